//! Writes a corpus to begin with, all of it generated: `cargo run --release --example seeds`.

#[path = "../tests/archives/mod.rs"]
mod archives;
mod scene_bytes;
#[path = "../tests/scene_files/mod.rs"]
mod scene_files;

use std::path::Path;
use std::sync::Arc;

use antumbra::prepare::Prepared;
use antumbra::scene::Scene;
use antumbra_fixtures::{Kind, Recipe, generate};
use scene_files::garbage::{MTL, OBJ, Seed, rich};
use scene_files::{Folder, Gltf};

fn input(kind: u8, parts: &[&[u8]]) -> Vec<u8> {
    let mut input = vec![kind];
    input.extend(parts.join(&0));
    input
}

fn scene_files_corpus() -> Vec<Vec<u8>> {
    let (triangle, rich) = (Gltf::triangle(), rich());
    let embedded = {
        use base64::Engine;
        let base64 = base64::engine::general_purpose::STANDARD.encode(&rich.bin);
        rich.text(&format!("data:;base64,{base64}"))
    };
    let mut corpus = vec![
        input(0, &[&triangle.glb()]),
        input(0, &[&rich.glb()]),
        input(1, &[embedded.as_bytes()]),
        input(2, &[OBJ.as_bytes(), MTL.as_bytes()]),
    ];
    for gltf in [&triangle, &rich] {
        let seed = Seed::glb(gltf);
        let bin = seed.bin.as_deref().unwrap_or_default();
        corpus.push(input(5, &[&seed.json_or_text, bin]));
    }
    let folder = Folder::new();
    let archive_of = |prepared: &Prepared| {
        let path = folder.path().join("seed.antumbra");
        prepared.save(&path).expect("saved");
        let archive = std::fs::read(&path).expect("read");
        let sections = archives::take_apart(&archive);
        [
            scene_bytes::input_of_sections(&sections),
            input(4, &[&archive]),
        ]
    };
    for (fineness, proxies) in [(1, false), (2, true), (9, false)] {
        corpus.extend(archive_of(&archives::prepared(fineness, proxies)));
    }
    for triangles in [1_000, 2_000] {
        let mut recipe = Recipe::new(Kind::MachineRoom);
        recipe.triangles = Some(triangles);
        let fixture = generate(&recipe).expect("generated");
        let mut file = Vec::new();
        fixture.write_glb(&mut file).expect("written to memory");
        let path = folder.write("seed.glb", &file);
        let scene = Scene::load(&path).expect("sound");
        corpus.extend(archive_of(&Prepared::new(Arc::new(scene))));
        corpus.push(input(0, &[&file]));
    }
    corpus
}

fn write(target: &str, corpus: &[Vec<u8>]) {
    let folder = Path::new(env!("CARGO_MANIFEST_DIR"))
        .join("corpus")
        .join(target);
    std::fs::create_dir_all(&folder).expect("the corpus can be written");
    for (i, input) in corpus.iter().enumerate() {
        std::fs::write(folder.join(format!("seed-{i}")), input).expect("written");
    }
    println!("{target}: {} seeds", corpus.len());
}

fn main() {
    write("scene_files", &scene_files_corpus());
}
