//! Garbage in: however a scene file is damaged, `render` ends soon, in a picture or in an error, and takes little memory.
//!
//! Each file is drawn by a process of its own, which has to end with exit code 0 or 1 within [`TIME_LIMIT`], must not
//! panic, and with `--check` must not find that culling changes the picture. `ANTUMBRA_MUTATIONS` says how many files
//! to try ([`DEFAULT_MUTATIONS`] without it), half of them OBJ, half GLB.
//!
//! Peak memory is what GNU time reports of the process (`ru_maxrss`), exact even for processes of a few milliseconds.
//! Where there is no GNU time, a shell limits the address space to the same number of bytes: that counts more than
//! is resident, so it claims more, but it measures nothing.

mod scene_files;

use std::path::{Path, PathBuf};
use std::process::{Command, Output, Stdio};
use std::sync::mpsc;
use std::time::Duration;

use antumbra_fixtures::{Kind, Recipe, generate};
use scene_files::garbage::*;
use scene_files::*;

const DEFAULT_MUTATIONS: usize = 150;
const TIME_LIMIT: Duration = Duration::from_secs(10);

/// How a process's memory is watched.
#[derive(Clone, Copy, Debug, PartialEq)]
enum Watch {
    /// GNU time measures it.
    Measured,
    /// A shell limits the address space.
    Limited,
    /// Neither is there.
    Not,
}

impl Watch {
    fn best() -> Watch {
        let works = |command: &mut Command| {
            let output = command.stdin(Stdio::null()).output();
            output.is_ok_and(|o| o.status.success())
        };
        if works(Command::new("/usr/bin/time").args(["-q", "-f", "%M", "true"])) {
            Watch::Measured
        } else if works(Command::new("sh").args(["-c", "ulimit -v 1000000"])) {
            Watch::Limited
        } else {
            Watch::Not
        }
    }
}

/// What `render` did with a file.
struct Run {
    /// None if it had not ended in time.
    output: Option<Output>,
    peak_bytes: Option<u64>,
}

/// One thread, and small pictures: the memory is the file's, not the machine's.
const RENDER: [&str; 7] = [
    "--size",
    "64x48",
    "--threads",
    "1",
    "--check",
    "--out",
    "out",
];

/// Renders a file of a folder.
fn render(folder: &Folder, name: &str, more: &[&str], watch: Watch, limit_bytes: u64) -> Run {
    let exe = env!("CARGO_BIN_EXE_antumbra");
    let peak_file = folder.path().join("peak");
    let mut command = match watch {
        Watch::Measured => {
            let mut time = Command::new("/usr/bin/time");
            time.args(["-q", "-f", "%M", "-o"]).arg(&peak_file).arg(exe);
            time
        }
        Watch::Limited => {
            let mut shell = Command::new("sh");
            shell.args(["-c", r#"ulimit -v "$0" && exec "$@""#]);
            shell.arg((limit_bytes >> 10).to_string()).arg(exe);
            shell
        }
        Watch::Not => Command::new(exe),
    };
    command.args(["render", name]).args(RENDER).args(more);
    command.current_dir(folder.path());
    command
        .stdin(Stdio::null())
        .stdout(Stdio::null())
        .stderr(Stdio::piped());
    let output = output_within(command, TIME_LIMIT);
    let peak = std::fs::read_to_string(&peak_file).ok();
    let peak_bytes = peak
        .and_then(|kib| kib.trim().parse::<u64>().ok())
        .map(|kib| kib << 10);
    let _ = std::fs::remove_file(&peak_file);
    Run { output, peak_bytes }
}

/// What a command printed, or none if it was not done in time, which ends it and what it started.
fn output_within(mut command: Command, limit: Duration) -> Option<Output> {
    #[cfg(unix)]
    std::os::unix::process::CommandExt::process_group(&mut command, 0);
    let child = command.spawn().expect("the command starts");
    let group = child.id();
    let (done, wait) = mpsc::channel();
    let waiter = std::thread::spawn(move || done.send(child.wait_with_output()));
    let output = wait.recv_timeout(limit).ok();
    if output.is_none() {
        let all = format!("-{group}");
        let _ = Command::new("kill").args(["-KILL", "--", &all]).status();
    }
    let _ = waiter.join();
    output.map(|output| output.expect("the command can be waited for"))
}

/// A landscape with houses as text: two hundred vertices, some groups, polygons, indices from the end.
fn village() -> String {
    use std::fmt::Write;
    let mut text = String::from("mtllib paint.mtl\no ground\nusemtl red\n");
    for i in 0..100 {
        let (x, z) = (i % 10, i / 10);
        let _ = writeln!(
            text,
            "v {x}.5 {} -{z}.25",
            f64::from((x * 7 + z * 3) % 5) * 0.1
        );
    }
    for i in (1..90).filter(|i| i % 10 != 0) {
        let _ = writeln!(text, "f {i} {} {} {}", i + 1, i + 11, i + 10);
    }
    for house in 0..12 {
        let _ = writeln!(
            text,
            "g house {house}\nusemtl {}",
            ["red", "glass"][usize::from(house % 5 == 4)]
        );
        for corner in 0..8 {
            let at = |bit: u32| f64::from(corner >> bit & 1);
            let (x, z) = (
                f64::from(house % 4) * 2.5 + 1.0,
                f64::from(house / 4) * -3.0 - 1.0,
            );
            let _ = writeln!(text, "v {} {} {}", x + at(0), at(1) * 1.5, z + at(2));
        }
        text += "f -8 -6 -5 -7\nf -4 -3 -1 -2\nf -8 -7 -3 -4\nf -6 -2 -1 -5\nf -8 -4 -2 -6\nf -7 -5 -1 -3\n";
    }
    text
}

/// Cameras inside the scenes, beside them, and in the origin, where many a number ends up.
const PATH: &str = r#"{"fov_y_degrees": 70, "near": 0.1, "frames": [
    {"eye": [0, 0, 0], "target": [1, 0.2, -3]},
    {"eye": [4.5, 0.8, 3], "target": [4, 0.5, -8]},
    {"eye": [-3, 4, 5], "target": [0.5, 0.5, 0]}]}"#;
/// The same in parallel projection.
const PARALLEL: &str = r#"{"height": 8, "near": -2, "far": 1000, "frames": [
    {"eye": [0, 0, 0], "target": [1, 0.2, -3]},
    {"eye": [-3, 4, 5], "target": [0.5, 0.5, 0]}]}"#;
/// What each file is drawn with, in turn.
const VIEWS: [&[&str]; 4] = [
    &[],
    &["--path", "inside.json"],
    &["--overlay"],
    &["--path", "parallel.json"],
];

fn seeds() -> (Vec<Seed>, Vec<Seed>) {
    let obj = |text: &str| Seed {
        name: "scene.obj",
        json_or_text: text.into(),
        bin: None,
    };
    let obj_seeds = vec![obj(OBJ), obj(&village())];
    let recipe = Recipe {
        kind: Kind::City,
        triangles: Some(20_000),
        seed: 1,
    };
    let mut city = Vec::new();
    generate(&recipe)
        .expect("enough triangles")
        .write_glb(&mut city)
        .expect("in memory");
    let mut glb_seeds = vec![
        Seed::glb(&Gltf::triangle()),
        Seed::glb(&rich()),
        Seed::of_glb("scene.glb", &city),
    ];
    let scenes = std::env::var_os("ANTUMBRA_SCENES").map_or_else(
        || Path::new(env!("CARGO_MANIFEST_DIR")).join("../shared/scenes"),
        PathBuf::from,
    );
    for name in ["delft.glb", "cistern.glb"] {
        match std::fs::read(scenes.join(name)) {
            Ok(file) => glb_seeds.push(Seed::of_glb("scene.glb", &file)),
            Err(_) => eprintln!("left out: no {name} in {}", scenes.display()),
        }
    }
    (obj_seeds, glb_seeds)
}

/// What went wrong with a run, if anything did.
fn fault_of(run: &Run, limit_bytes: u64) -> Option<String> {
    let Some(output) = &run.output else {
        return Some(format!("it had not ended after {TIME_LIMIT:?}"));
    };
    let stderr = String::from_utf8_lossy(&output.stderr);
    if !matches!(output.status.code(), Some(0 | 1)) || stderr.contains("panicked") {
        return Some(format!("{}: {stderr}", output.status));
    }
    if stderr.contains("culling changes") {
        return Some(stderr.into_owned());
    }
    if output.status.code() == Some(1) && !stderr.contains("scene.") {
        return Some(format!("the error does not name the file: {stderr}"));
    }
    let peak = run.peak_bytes?;
    (peak >= limit_bytes).then(|| format!("it took {peak} bytes of {limit_bytes}"))
}

#[test]
fn damaged_files_end_in_a_picture_or_an_error() {
    let mutations = std::env::var("ANTUMBRA_MUTATIONS")
        .ok()
        .and_then(|count| count.parse().ok());
    let (folder, watch) = (Folder::new(), Watch::best());
    folder.write("inside.json", PATH);
    folder.write("parallel.json", PARALLEL);
    let (obj_seeds, glb_seeds) = seeds();
    let mut random = Random(0x2545_f491);
    let (mut rendered, mut worst, mut largest_share) = ([0; 2], String::new(), 0.0);
    let mut faults = Vec::new();
    let count = mutations.unwrap_or(DEFAULT_MUTATIONS);
    for attempt in 0..count {
        // OBJ and GLB by turns; each seed and each view meet.
        let is_glb = attempt % 2;
        let seeds = [&obj_seeds, &glb_seeds][is_glb];
        let seed = &seeds[attempt / 2 % seeds.len()];
        let view = VIEWS[attempt / 2 / seeds.len() % VIEWS.len()];
        let mut library = MTL.as_bytes().to_vec();
        if random.below(4) == 0 {
            change_bytes(&mut library, &mut random);
        }
        folder.write("paint.mtl", &library);
        let bytes = seed.mutated(&mut random);
        folder.write(seed.name, &bytes);
        let limit = 10 * bytes.len() as u64 + (64 << 20);
        // An overlay is a picture far larger than these files.
        let watch = if view.contains(&"--overlay") {
            Watch::Not
        } else {
            watch
        };
        let run = render(&folder, seed.name, view, watch, limit);
        rendered[is_glb] += usize::from(run.output.as_ref().is_some_and(|o| o.status.success()));
        if let Some(peak) = run.peak_bytes {
            let share = peak as f64 / limit as f64;
            if share > largest_share {
                largest_share = share;
                worst = format!(
                    "{:.1} MiB for a {} of {:.3} MiB, {:.0} % of the limit",
                    peak as f64 / f64::from(1 << 20),
                    seed.name,
                    bytes.len() as f64 / f64::from(1 << 20),
                    share * 100.0
                );
            }
        }
        if let Some(fault) = fault_of(&run, limit) {
            let kept = Path::new(env!("CARGO_TARGET_TMPDIR"))
                .join(format!("garbage-{attempt}-{}", seed.name));
            std::fs::write(&kept, &bytes).expect("the file can be written");
            std::fs::write(kept.with_extension("mtl"), &library).expect("the file can be written");
            faults.push(format!("{} {view:?}: {fault}", kept.display()));
        }
    }
    eprintln!(
        "{count} files: {} of {} OBJ and {} of {} GLB still rendered; peak memory ({watch:?}): {worst}",
        rendered[0],
        count.div_ceil(2),
        rendered[1],
        count / 2
    );
    assert!(
        faults.is_empty(),
        "{} of {count} files:\n{}",
        faults.len(),
        faults.join("\n")
    );
}

#[test]
fn the_files_render_before_they_are_damaged() {
    let (folder, watch) = (Folder::new(), Watch::best());
    folder.write("inside.json", PATH);
    folder.write("parallel.json", PARALLEL);
    folder.write("paint.mtl", MTL);
    let (obj_seeds, glb_seeds) = seeds();
    for seed in obj_seeds.iter().chain(&glb_seeds) {
        let file = seed.whole();
        folder.write(seed.name, &file);
        for view in VIEWS {
            let limit = 10 * file.len() as u64 + (64 << 20);
            let watch = if view.contains(&"--overlay") {
                Watch::Not
            } else {
                watch
            };
            let run = render(&folder, seed.name, view, watch, limit);
            assert_eq!(fault_of(&run, limit), None);
            let output = run.output.expect("it has ended");
            assert!(
                output.status.success(),
                "{}",
                String::from_utf8_lossy(&output.stderr)
            );
        }
    }
}
