//! What the command-line tests share: the command, a folder of their own, and a small scene.
#![allow(dead_code, reason = "each test file uses some")]

use std::path::{Path, PathBuf};
use std::process::{Command, Output};

pub const EXE: &str = env!("CARGO_BIN_EXE_antumbra");

/// Runs the command to its end.
pub fn antumbra(arguments: &[&str]) -> Output {
    Command::new(EXE)
        .args(arguments)
        .output()
        .expect("the command starts")
}

/// Runs the command, which has to succeed.
pub fn succeed(arguments: &[&str]) -> Output {
    let output = antumbra(arguments);
    assert!(
        output.status.success(),
        "{arguments:?}: {}\n{}",
        output.status,
        stderr(&output)
    );
    output
}

pub fn stdout(output: &Output) -> String {
    String::from_utf8_lossy(&output.stdout).into_owned()
}

pub fn stderr(output: &Output) -> String {
    String::from_utf8_lossy(&output.stderr).into_owned()
}

/// An empty folder that is removed at the end.
pub struct Folder(PathBuf);

impl Folder {
    pub fn new(name: &str) -> Folder {
        let folder = Path::new(env!("CARGO_TARGET_TMPDIR")).join(name);
        let _ = std::fs::remove_dir_all(&folder);
        std::fs::create_dir_all(&folder).expect("a folder can be made");
        Folder(folder)
    }

    /// The name of a file in the folder.
    pub fn file(&self, name: &str) -> String {
        self.0.join(name).to_str().expect("a name in UTF-8").into()
    }

    /// The names of all files in the folder, sorted.
    pub fn names(&self) -> Vec<String> {
        let entries = std::fs::read_dir(&self.0).expect("the folder is there");
        let mut names: Vec<String> = entries
            .map(|e| {
                e.expect("an entry")
                    .file_name()
                    .to_string_lossy()
                    .into_owned()
            })
            .collect();
        names.sort();
        names
    }

    /// Writes a small scene and a path through it: a wall before one box, and a box beside the wall.
    pub fn with_scene(self) -> Folder {
        std::fs::write(self.file("yard.obj"), yard()).expect("written");
        std::fs::write(self.file("yard.path.json"), PATH).expect("written");
        self
    }
}

impl Drop for Folder {
    fn drop(&mut self) {
        let _ = std::fs::remove_dir_all(&self.0);
    }
}

/// Three frames: the wall hides a box in the first two; the third looks away.
const PATH: &str = r#"{
    "fov_y_degrees": 60, "near": 0.1,
    "frames": [
        {"eye": [0, 1, 10], "target": [0, 1, 0], "up": [0, 1, 0]},
        {"eye": [1, 1, 10], "target": [0, 1, 0], "up": [0, 1, 0]},
        {"eye": [0, 1, 10], "target": [0, 1, 20], "up": [0, 1, 0]}
    ]
}"#;

fn yard() -> String {
    let mut text = String::new();
    let mut first = 1;
    let mut block = |name: &str, min: [f32; 3], max: [f32; 3]| {
        text += &format!("o {name}\n");
        for i in 0..8 {
            let pick = |axis: usize| {
                if i >> axis & 1 == 0 {
                    min[axis]
                } else {
                    max[axis]
                }
            };
            text += &format!("v {} {} {}\n", pick(0), pick(1), pick(2));
        }
        // Counter-clockwise from outside.
        for face in [
            [0, 2, 3, 1],
            [4, 5, 7, 6],
            [0, 1, 5, 4],
            [2, 6, 7, 3],
            [0, 4, 6, 2],
            [1, 3, 7, 5],
        ] {
            let [a, b, c, d] = face.map(|i| i + first);
            text += &format!("f {a} {b} {c} {d}\n");
        }
        first += 8;
    };
    block("wall", [-3.0, 0.0, 0.0], [3.0, 4.0, 0.2]);
    block("hidden", [-1.0, 0.5, -4.0], [1.0, 2.0, -3.0]);
    block("beside", [4.0, 0.0, -1.0], [5.0, 1.0, 0.0]);
    text
}
