//! What has been prepared comes back from its archive as it was, to the bit, and nothing else does.

mod archives;

use std::path::Path;
use std::sync::Arc;

use antumbra::cull::{Culler, Settings};
use antumbra::occluders::Selection;
use antumbra::prepare::{ArchiveError, Prepared};
use antumbra::scene::{Scene, SceneError};
use antumbra::view::{CameraPath, PictureSize};
use antumbra_fixtures::{Kind, Recipe, generate};
use archives::*;

/// All of a scene and its clusters, such that −0 and 0 are two.
fn all_of(prepared: &Prepared) -> String {
    let scene = prepared.scene();
    let own_boxes: Vec<_> = (0..scene.objects().len())
        .map(|o| scene.own_box(o))
        .collect();
    let grid = prepared.visibility_grid();
    format!(
        "{scene:?} {own_boxes:?} {:?} {grid:?}",
        prepared.occluders()
    )
}

#[test]
fn a_scene_and_its_clusters_come_back_as_they_were() {
    let folder = Folder::new("archive_round_trip");
    for (fineness, with_proxies) in [(1, false), (3, true), (20, true), (20, false)] {
        let before = prepared(fineness, with_proxies);
        let bytes = folder.saved(&before);
        let after = folder.load(&bytes).expect("sound");
        assert_eq!(all_of(&after), all_of(&before));
        assert_eq!(after.occluders(), before.occluders());
        assert_eq!(folder.saved(&after), bytes);
        cull_exactly(&after, "as it was");

        let meshes = after.scene().meshes();
        assert!(
            meshes
                .iter()
                .all(|m| m.positions.is_shared() && m.triangles.is_shared())
        );
        // What is written to a list goes to a copy.
        let mut mesh = meshes[0].clone();
        mesh.positions.to_mut()[0] = [9.0; 3];
        assert_ne!(mesh.positions[0], meshes[0].positions[0]);
    }
}

#[test]
fn what_a_file_could_not_say_is_kept() {
    let folder = Folder::new("archive_warnings");
    let text = "o a\nv 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 3\nl 1 2\n";
    let before = Prepared::load(&folder.write("a.obj", text.as_bytes())).expect("a scene");
    assert_eq!(before.scene().warnings().len(), 1);
    let after = folder.load(&folder.saved(&before)).expect("sound");
    assert_eq!(after.scene().warnings(), before.scene().warnings());
}

#[test]
fn frames_are_the_same_from_an_archive() {
    let folder = Folder::new("archive_frames");
    let recipe = Recipe {
        triangles: Some(40_000),
        ..Recipe::new(Kind::City)
    };
    let fixture = generate(&recipe).expect("enough triangles");
    let file = folder.file("city.glb");
    let out = std::fs::File::create(&file).expect("the file can be written");
    fixture.write_glb(out).expect("the file can be written");
    let scene = Arc::new(Scene::load(&file).expect("a scene"));
    let path = CameraPath::parse(&fixture.path_json(), &file).expect("a path");
    let archive = folder.saved(&Prepared::new(scene.clone()));
    let prepared = folder.load(&archive).expect("sound");
    for (occluders, threads) in [
        (Selection::Contribution, 1),
        (Selection::Contribution, 2),
        (Selection::Nearest, 1),
    ] {
        let settings = Settings {
            occluders,
            threads,
            ..Settings::new(PictureSize::new(320, 192).expect("a size"))
        };
        let mut from_scene = Culler::new(scene.clone(), settings).expect("threads");
        let mut from_archive = Culler::with_prepared(&prepared, settings).expect("threads");
        for camera in path.cameras().iter().step_by(7) {
            let (a, b) = (from_scene.cull(camera), from_archive.cull(camera));
            assert_eq!((a.visible, a.occluders), (b.visible, b.occluders));
            let hash = |culler: &Culler| culler.buffer().expect("a frame").tiles().hash();
            assert_eq!(hash(&from_scene), hash(&from_archive));
        }
    }
}

#[test]
fn the_layout_is_as_it_is_written_down() {
    let folder = Folder::new("archive_layout");
    let archive = folder.saved(&prepared(3, true));
    let sections = take_apart(&archive);
    assert_eq!(put_together(1, &sections), archive);
    let kinds: Vec<u32> = sections.iter().map(|s| s.kind).collect();
    assert_eq!(kinds, (1..=15).collect::<Vec<_>>());
    let sizes = [64, 32, 12, 12, 112, 1, 8, 4, 16, 4, 4, 4, 4, 1, 1];
    for (section, size) in sections.iter().zip(sizes) {
        assert_eq!(section.bytes.len() % size, 0, "{}", section.kind);
        assert_eq!(section.flags, u32::from(section.kind < 14));
    }
}

fn message(result: Result<Prepared, ArchiveError>) -> String {
    result.err().map(|e| e.to_string()).unwrap_or_default()
}

#[test]
fn sections_of_later_versions_are_passed_over_unless_they_matter() {
    let folder = Folder::new("archive_sections");
    let before = prepared(3, true);
    let mut sections = take_apart(&folder.saved(&before));
    for at in [0, 5, sections.len()] {
        let mut more = sections.clone();
        let new = Section {
            kind: 77,
            flags: 0,
            bytes: vec![1, 2, 3],
        };
        more.insert(at, new);
        let after = folder.load(&put_together(1, &more)).expect("sound");
        assert_eq!(all_of(&after), all_of(&before));
        more[at].flags = 1;
        let error = message(folder.load(&put_together(1, &more)));
        assert!(error.contains("section 77"), "{error}");
    }
    // In any order, and without what need not be there.
    sections.reverse();
    sections.retain(|s| s.flags == 1);
    let after = folder.load(&put_together(1, &sections)).expect("sound");
    assert_eq!(after.occluders(), before.occluders());
    assert!(after.visibility_grid().is_none());
    for kind in 1..=13 {
        let mut fewer = sections.clone();
        fewer.retain(|s| s.kind != kind);
        let error = message(folder.load(&put_together(1, &fewer)));
        assert!(error.contains("is missing"), "{error}");
        let mut more = sections.clone();
        more.extend(sections.iter().find(|s| s.kind == kind).cloned());
        let error = message(folder.load(&put_together(1, &more)));
        assert!(error.contains("is there twice"), "{error}");
    }
}

#[test]
fn errors_name_the_file_and_what_to_do() {
    let folder = Folder::new("archive_errors");
    let archive = folder.saved(&prepared(1, false));
    let later = message(folder.load(&put_together(2, &take_apart(&archive))));
    for part in [
        "loaded.antumbra",
        "version 2",
        "version 1",
        "antumbra prepare",
    ] {
        assert!(later.contains(part), "{later}");
    }
    let cut = message(folder.load(&archive[..archive.len() - 1]));
    for part in ["loaded.antumbra", "should have", "antumbra prepare"] {
        assert!(cut.contains(part), "{cut}");
    }
    for nothing in [&b""[..], b"ANTUMBRA", b"o a\nv 0 0 0\n"] {
        let error = message(folder.load(nothing));
        assert!(error.contains("loaded.antumbra: the header"), "{error}");
    }
    let missing = Prepared::load(&folder.file("nothing.antumbra"));
    assert!(matches!(missing, Err(ArchiveError::Read { .. })));
    std::fs::create_dir(folder.file("folder.antumbra")).expect("made");
    let no_file = Prepared::load(&folder.file("folder.antumbra"));
    assert!(matches!(no_file, Err(ArchiveError::Read { .. })));
    let as_scene = Scene::load(&folder.write("a.antumbra", &archive));
    assert!(matches!(as_scene, Err(SceneError::Archive { .. })));
}

#[test]
fn an_archive_is_known_by_its_first_bytes() {
    let folder = Folder::new("archive_names");
    let before = prepared(1, false);
    let archive = folder.saved(&before);
    for name in ["scene", "scene.glb", "scene.ANTUMBRA"] {
        let after = Prepared::load(&folder.write(name, &archive)).expect("sound");
        assert_eq!(all_of(&after), all_of(&before), "{name}");
    }
}

#[test]
fn what_cannot_be_written_loses_nothing() {
    let folder = Folder::new("archive_unwritten");
    let prepared = prepared(1, false);
    let nowhere = prepared.save(&folder.file("none/a.antumbra"));
    assert!(matches!(nowhere, Err(ArchiveError::Write { .. })));
    // A folder that is not empty cannot be replaced by a file.
    std::fs::create_dir(folder.file("taken")).expect("made");
    folder.write("taken/kept", b"kept");
    let taken = prepared.save(&folder.file("taken"));
    assert!(taken.is_err_and(|e| e.to_string().contains("taken: cannot be written")));
    assert_eq!(folder.names(), ["taken"]);
    assert!(Path::new(&folder.file("taken/kept")).exists());
}

#[cfg(unix)]
#[test]
fn whoever_has_loaded_an_archive_keeps_it_when_it_is_replaced() {
    let folder = Folder::new("archive_replaced");
    let file = folder.file("a.antumbra");
    let (first, second) = (prepared(5, false), prepared(1, true));
    first.save(&file).expect("saved");
    let loaded = Prepared::load(&file).expect("sound");
    second.save(&file).expect("saved");
    assert_eq!(all_of(&loaded), all_of(&first));
    let again = Prepared::load(&file).expect("sound");
    assert_eq!(all_of(&again), all_of(&second));
    assert_eq!(folder.names(), ["a.antumbra"]);
}
