//! Garbage in: however a file is damaged, loading it ends soon, in a scene or in an error.
//!
//! `ANTUMBRA_MUTATIONS` says how many mutations to try (2,000 without it).

mod scene_files;

use std::panic::{AssertUnwindSafe, catch_unwind};
use std::path::PathBuf;
use std::time::{Duration, Instant};

use antumbra::scene::Scene;
use scene_files::garbage::*;
use scene_files::*;

fn mutations() -> usize {
    std::env::var("ANTUMBRA_MUTATIONS")
        .ok()
        .and_then(|count| count.parse().ok())
        .unwrap_or(2_000)
}

/// Loads a file; if that panics or takes long, leaves the file behind and says where.
fn load_within(folder: &Folder, name: &str, bytes: &[u8], limit: Duration, attempt: usize) -> bool {
    let path = folder.write(name, bytes);
    let begun = Instant::now();
    let result = catch_unwind(AssertUnwindSafe(|| Scene::load(&path)));
    if result.is_err() || begun.elapsed() > limit {
        let kept = std::env::temp_dir().join(format!("antumbra-garbage-{attempt}-{name}"));
        std::fs::write(&kept, bytes).unwrap();
        panic!(
            "mutation {attempt}, kept as {}, took {:?}: {result:?}",
            kept.display(),
            begun.elapsed()
        );
    }
    let scene = result.unwrap();
    if let Ok(scene) = &scene {
        assert_eq!(scene.bvh().validate(scene.bounds()), Ok(()));
    }
    scene.is_ok()
}

#[test]
fn mutated_files_end_in_a_scene_or_an_error() {
    let folder = Folder::new();
    let gltf = rich();
    let data_uri = {
        use base64::Engine;
        format!(
            "data:;base64,{}",
            base64::engine::general_purpose::STANDARD.encode(&gltf.bin)
        )
    };
    let seeds = [
        Seed::glb(&Gltf::triangle()),
        Seed::glb(&gltf),
        Seed {
            name: "scene.gltf",
            json_or_text: gltf.text(&data_uri).into_bytes(),
            bin: None,
        },
        Seed {
            name: "scene.obj",
            json_or_text: OBJ.into(),
            bin: None,
        },
    ];
    folder.write("paint.mtl", MTL);
    let mut random = Random(0x9e37_79b9);
    let mut sound = 0;
    for seed in &seeds {
        assert!(
            load_within(&folder, seed.name, &seed.whole(), Duration::from_secs(2), 0),
            "{} is sound",
            seed.name
        );
    }
    for attempt in 0..mutations() {
        let seed = &seeds[attempt % seeds.len()];
        if seed.name == "scene.obj" {
            let mut library = MTL.as_bytes().to_vec();
            change_bytes(&mut library, &mut random);
            folder.write("paint.mtl", library);
        }
        let file = seed.mutated(&mut random);
        sound += usize::from(load_within(
            &folder,
            seed.name,
            &file,
            Duration::from_secs(2),
            attempt,
        ));
    }
    eprintln!("{sound} of {} mutations still load", mutations());
}

#[test]
fn a_mutated_real_scene_ends_in_a_scene_or_an_error() {
    let folder = std::env::var_os("ANTUMBRA_SCENES").map_or_else(
        || PathBuf::from(env!("CARGO_MANIFEST_DIR")).join("../shared/scenes"),
        PathBuf::from,
    );
    let Ok(whole) = std::fs::read(folder.join("delft.glb")) else {
        eprintln!("skipped: no delft.glb in {}", folder.display());
        return;
    };
    let (folder, mut random) = (Folder::new(), Random(11));
    for attempt in 0..mutations() / 100 {
        let mut file = whole.clone();
        change_bytes(&mut file, &mut random);
        load_within(&folder, "delft.glb", &file, Duration::from_secs(5), attempt);
    }
}
