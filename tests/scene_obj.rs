//! What OBJ can say, and what becomes of it.

mod scene_files;

use antumbra::scene::{Alpha, Scene};
use scene_files::*;

const SQUARE: &str = "v 0 0 0\nv 1 0 0\nv 1 1 0\nv 0 1 0\n";

fn names(scene: &Scene) -> Vec<&str> {
    scene.objects().iter().map(|o| o.name.as_str()).collect()
}

#[track_caller]
fn loaded(text: &str) -> Scene {
    load("scene.obj", text).unwrap_or_else(|error| panic!("{error}"))
}

#[test]
fn polygons_are_cut_into_fans_with_two_sides() {
    let scene = loaded(&format!("{SQUARE}v -1 0.5 0\nf 1 2 3 4 5\n"));
    let [a, b, c, d, e] = [
        [0.0, 0.0, 0.0],
        [1.0, 0.0, 0.0],
        [1.0, 1.0, 0.0],
        [0.0, 1.0, 0.0],
        [-1.0, 0.5, 0.0],
    ];
    assert_eq!(corners(&scene, 0), [[a, b, c], [a, c, d], [a, d, e]]);
    let material = scene.meshes()[0].surfaces[0].material;
    assert_eq!(
        (material.alpha, material.double_sided),
        (Alpha::Opaque, true)
    );
    assert_eq!(names(&scene), ["object 0"]);
}

#[test]
fn objects_and_groups_are_objects_and_materials_only_surfaces() {
    let folder = Folder::new();
    folder.write(
        "paint.mtl",
        "newmtl red\nKd 1 0 0\nnewmtl glass\nKd 0 0 1\nd 0.3\n",
    );
    let text = format!(
        "mtllib paint.mtl\n{SQUARE}o house\nusemtl red\nf 1 2 3\nusemtl glass\nf 1 3 4\no house\nf 1 2 4\n\
         g front\nf 1 2 3\ng back\nf 1 2 3\no shed\nf 1 2 3\ng empty\n"
    );
    let scene = Scene::load(&folder.write("scene.obj", text)).unwrap();
    assert_eq!(
        names(&scene),
        ["house", "house/front", "house/back", "shed"]
    );
    let house = &scene.meshes()[0];
    assert_eq!(
        house
            .surfaces
            .iter()
            .map(|s| s.triangles.clone())
            .collect::<Vec<_>>(),
        [0..1, 1..3]
    );
    let [red, glass] = [0, 1].map(|i| house.surfaces[i].material);
    assert_eq!(
        (red.alpha, red.color),
        (Alpha::Opaque, [1.0, 0.0, 0.0, 1.0])
    );
    assert_eq!(
        (glass.alpha, glass.color),
        (Alpha::Blend, [0.0, 0.0, 1.0, 0.3])
    );
    assert_eq!(scene.warnings(), [""; 0]);
}

#[test]
fn every_way_to_name_a_vertex_means_the_same() {
    let expected = corners(&loaded(&format!("{SQUARE}f 1 2 3\n")), 0);
    for text in [
        format!("{SQUARE}vt 0 0\nvn 0 0 1\nf 1/1/1 2/1/1 3/1/1\n"),
        format!("{SQUARE}f 1//1 2//1 3//1\n"),
        format!("{SQUARE}f -4 -3 -2\n"),
        format!("{SQUARE}f 1 \\\n 2 \\\r\n 3\n"),
        format!("f 1 2 3\n{SQUARE}"),
        format!("{}\r\nf 1 2 3\r\n", SQUARE.replace('\n', " 1.0\r\n")),
        format!("{}\nf\t1\t2  3", SQUARE.replace('\n', " 0.5 0.5 0.5\n")),
        format!("\t {}\n  f 1 2 3  # three\n", SQUARE.replace('\n', "\n  ")),
    ] {
        assert_eq!(corners(&loaded(&text), 0), expected, "{text:?}");
    }
}

#[test]
fn a_fourth_number_divides_the_others() {
    assert_eq!(
        loaded("v 2 4 6 2\nv 0 0 0\nv 1 0 0\nf 1 2 3\n").meshes()[0].positions[0],
        [1.0, 2.0, 3.0]
    );
}

#[test]
fn names_in_other_encodings_are_read() {
    let mut text = b"o Stra\xdfe\n".to_vec();
    text.extend(format!("{SQUARE}f 1 2 3\n").as_bytes());
    assert_eq!(names(&load("scene.obj", text).unwrap()), ["Stra\u{fffd}e"]);
}

#[test]
fn polylines_are_not_polygons() {
    let scene = loaded(&format!("{SQUARE}f 1 2 3\nl 1 2 3 4\np 1\nf 1 2\n"));
    assert_eq!(scene.triangle_count(), 1);
    assert!(
        scene.warnings()[0].contains("line 6 and 1 more: it draws points or lines"),
        "{:?}",
        scene.warnings()
    );
    assert!(
        scene.warnings()[1].contains("line 8: a face of fewer than three vertices"),
        "{:?}",
        scene.warnings()
    );
}

#[test]
fn a_missing_library_or_material_is_a_warning() {
    let scene = loaded(&format!(
        "mtllib nowhere.mtl\nmtllib /etc/hostname\n{SQUARE}usemtl red\nf 1 2 3\n"
    ));
    let warnings = scene.warnings().join("\n");
    for part in [
        "line 1, \"nowhere.mtl\"",
        "not relative to the scene",
        "material \"red\"",
    ] {
        assert!(warnings.contains(part), "{part} in {warnings}");
    }
}

#[test]
fn a_library_may_have_spaces_in_its_name_or_be_one_of_several() {
    for (statement, files) in [
        ("my paint.mtl", &["my paint.mtl"][..]),
        ("a.mtl b.mtl", &["a.mtl", "b.mtl"]),
    ] {
        let folder = Folder::new();
        for file in files {
            folder.write(file, format!("newmtl {file}\nmap_d x.png\n"));
        }
        let text = format!(
            "mtllib {statement}\n{SQUARE}usemtl {}\nf 1 2 3\n",
            files.last().unwrap()
        );
        let scene = Scene::load(&folder.write("scene.obj", text)).unwrap();
        assert_eq!(scene.meshes()[0].surfaces[0].material.alpha, Alpha::Mask);
    }
}

#[test]
fn damage_is_found_with_its_line_and_object() {
    for (text, parts) in [
        (
            "o wall\nf 1 2 9\n",
            &[
                "line 6, object \"wall\"",
                "index out of range: vertex 9, but the file has 4",
            ][..],
        ),
        (
            "o wall\nf 1 2 -5\n",
            &[
                "line 6, object \"wall\", a face",
                "index out of range: \"-5\"",
            ],
        ),
        (
            "o wall\nf 0 1 2\n",
            &["line 6, object \"wall\"", "there is no vertex 0"],
        ),
        ("f 1 2 x\n", &["line 5, a face", "\"x\" is no vertex"]),
        ("f 1 2 3/4/5/6\n", &["line 5", "is no vertex"]),
        ("f 1 2 3/a\n", &["line 5", "is no vertex"]),
        ("f 1 2 9223372036854775808\n", &["line 5", "is no vertex"]),
        (
            "f 1 2 -9223372036854775808\n",
            &["line 5", "index out of range"],
        ),
        (
            "f 1 2 9223372036854775807\n",
            &["line 5", "index out of range"],
        ),
        (
            "g roof\nv 1 2\n",
            &["line 6, object \"roof\", vertex 5: it has no z"],
        ),
        (
            "v 1 2 three\n",
            &["line 5, vertex 5: \"three\" is not a number"],
        ),
        (
            "v 1 nan 3\n",
            &["line 5, vertex 5: its position is not finite: nan"],
        ),
        (
            "v 1 1e39 3\n",
            &["line 5, vertex 5: its position is not finite: 1e39"],
        ),
        (
            "v 1 2 3 0\n",
            &["line 5, vertex 5: divided by its weight 0 it is not finite"],
        ),
        (
            "v 3e38 0 0\nv 0 3e38 0\nf 1 5 6\n",
            &["object 0 \"object 0\"", "beyond", "scale the scene down"],
        ),
        ("", &["the scene has no triangles"]),
        ("l 1 2\n", &["the scene has no triangles"]),
    ] {
        assert_refused("scene.obj", format!("{SQUARE}{text}"), parts);
    }
    assert_refused("scene.obj", "", &["the scene has no triangles"]);
    assert_refused("scene.obj", [0xff; 1000], &["the scene has no triangles"]);
}

#[test]
fn a_library_named_very_often_is_read_once() {
    let folder = Folder::new();
    folder.write("paint.mtl", "newmtl red\nKd 1 0 0\n".repeat(50_000));
    let text = format!(
        "{}{SQUARE}f 1 2 3\n",
        "mtllib paint.mtl\nmtllib ./paint.mtl\n".repeat(20_000)
    );
    let begun = std::time::Instant::now();
    assert_eq!(
        Scene::load(&folder.write("scene.obj", text))
            .unwrap()
            .warnings(),
        [""; 0]
    );
    assert!(begun.elapsed().as_secs() < 10, "{:?}", begun.elapsed());
}
