//! What frames leave out because it does not pay: each step is seen to be skipped, and nothing is lost by it.

mod generated;

use std::sync::Arc;

use antumbra::cull::{Culler, Effort, Prices, Settings, Skip, VisibleSet};
use antumbra::glam::{DAffine3, DVec3};
use antumbra::measure::Reference;
use antumbra::occlusion::{Accuracy, Approximation};
use antumbra::scene::{Material, Mesh, Object, Scene, Surface};
use antumbra::view::{Camera, PictureSize, Projection};
use antumbra_fixtures::Kind;
use generated::generated;

fn settings(effort: Effort) -> Settings {
    Settings {
        threads: 1,
        effort,
        ..Settings::new(PictureSize::new(637, 411).expect("a size"))
    }
}

/// Nothing that owns a pixel is lost, and no pixel of the picture is wrong.
fn judge(culler: &Culler, camera: &Camera, found: &VisibleSet) {
    let reference = Reference::new(culler.scene(), camera, culler.settings().size);
    let lost = |object: &u32| found.visible.binary_search(object).is_err();
    assert_eq!(reference.visible_objects().find(lost), None);
    assert_eq!(
        reference.wrong_pixels(culler.scene(), camera, &found.visible),
        0
    );
}

/// A box from the origin to (1, 1, 1) and a square of side 1, placed.
fn placed(places: impl IntoIterator<Item = (usize, DVec3, DVec3)>) -> Arc<Scene> {
    let corner = |i: u32| [i & 1, i >> 1 & 1, i >> 2 & 1].map(|c| c as f32);
    let cube = [
        [0, 2, 3],
        [0, 3, 1],
        [4, 5, 7],
        [4, 7, 6],
        [0, 1, 5],
        [0, 5, 4],
        [2, 6, 7],
        [2, 7, 3],
        [0, 4, 6],
        [0, 6, 2],
        [1, 3, 7],
        [1, 7, 5],
    ];
    let mesh = |positions: Vec<[f32; 3]>, triangles: Vec<[u32; 3]>| Mesh {
        name: String::new(),
        surfaces: vec![Surface {
            triangles: 0..triangles.len(),
            material: Material::default(),
        }],
        positions: positions.into(),
        triangles: triangles.into(),
    };
    let square = vec![
        [0.0, 0.0, 0.0],
        [1.0, 0.0, 0.0],
        [1.0, 1.0, 0.0],
        [0.0, 1.0, 0.0],
    ];
    let meshes = vec![
        mesh((0..8).map(corner).collect(), cube.to_vec()),
        mesh(square, vec![[0, 1, 2], [0, 2, 3]]),
    ];
    let object = |(mesh, at, size): (usize, DVec3, DVec3)| Object {
        name: String::new(),
        mesh,
        world_from_local: DAffine3::from_translation(at) * DAffine3::from_scale(size),
        never_cull: false,
        never_occlude: false,
        occluder_proxy: None,
    };
    let objects = places.into_iter().map(object).collect();
    Arc::new(Scene::new(meshes, objects).expect("a sound scene"))
}

fn looking(eye: DVec3, target: DVec3) -> Camera {
    let projection = Projection::Perspective {
        fov_y: 1.0,
        near: 0.1,
        far: None,
    };
    Camera::look_at(eye, target, DVec3::Y, projection).expect("a camera")
}

/// In an open field there is no occlusion pass, from the first frame on; in the city there is one in every frame.
#[test]
fn where_little_is_covered_nothing_is_drawn() {
    let (field, path) = generated(Kind::Sparse, "effort-field");
    let mut culler = Culler::new(field, settings(Effort::default())).expect("threads");
    for camera in path.cameras().iter().step_by(12) {
        let found = culler.cull(camera);
        assert!(found.statistics.skipped.has(Skip::OcclusionLittleCovers));
        assert_eq!(found.statistics.occluder_triangles, 0);
        assert_eq!(found.visible, culler.in_frustum(camera));
        assert!(
            culler
                .buffer()
                .expect("a frame")
                .tiles()
                .coverage()
                .iter()
                .all(|&c| c == 0)
        );
        judge(&culler, camera, &found);
    }
    // Nor is there anything to go on with when a stone moves.
    let camera = &path.cameras()[0];
    culler.cull(camera);
    let moved = antumbra::scene::Move {
        object: culler.in_frustum(camera)[0],
        world_from_local: DAffine3::from_translation(camera.eye() + camera.forward() * 9.0),
        swept: false,
    };
    culler
        .move_objects(&[moved])
        .expect("it stays in the world");
    let found = culler.cull(camera);
    assert!(!found.statistics.skipped.has(Skip::Elsewhere));
    judge(&culler, camera, &found);
    // The dearer drawing is, the more is worth trying.
    let dear = Effort {
        prices: Prices {
            object: 1e9,
            triangle: 0.0,
        },
        ..Effort::default()
    };
    culler.set_prices(dear.prices);
    let found = culler.cull(&path.cameras()[1]);
    assert!(!found.statistics.skipped.has(Skip::OcclusionLittleCovers));

    let (city, path) = generated(Kind::City, "effort-city");
    let mut culler = Culler::new(city, settings(Effort::default())).expect("threads");
    for camera in path.cameras().iter().step_by(12) {
        let skipped = culler.cull(camera).statistics.skipped;
        assert!(!skipped.has(Skip::OcclusionLittleCovers), "{skipped}");
        assert!(!skipped.has(Skip::OcclusionLittleHidden), "{skipped}");
    }
}

/// Boxes before a wall: the picture is covered, and nothing is hidden. What was in vain is tried again ever more seldom, and at once
/// when much more may be covered.
#[test]
fn what_was_in_vain_is_left_out_for_a_while() {
    let wall = (
        1,
        DVec3::new(-60.0, -40.0, -40.0),
        DVec3::new(120.0, 80.0, 1.0),
    );
    let row = |i: i32| {
        let at = DVec3::new(
            f64::from(i % 24) * 2.0 - 24.0,
            f64::from(i / 24) * 2.0 - 12.0,
            -36.0,
        );
        (0, at, DVec3::splat(0.5))
    };
    // Behind the eye at first: a wall with boxes behind it.
    let near_wall = (
        1,
        DVec3::new(-30.0, -20.0, 20.0),
        DVec3::new(60.0, 40.0, 1.0),
    );
    let behind = |i: i32| {
        let at = DVec3::new(f64::from(i % 24) - 12.0, f64::from(i / 24) - 6.0, 10.0);
        (0, at, DVec3::splat(0.5))
    };
    let front = std::iter::once(wall).chain((0..288).map(row));
    let back = std::iter::once(near_wall).chain((0..288).map(behind));
    let scene = placed(front.chain(back));
    let mut culler = Culler::new(scene, settings(Effort::default())).expect("threads");
    let pause = |culler: &mut Culler, frames: i32| {
        let skipped = (0..frames).map(|frame| {
            let eye = DVec3::new(f64::from(frame) * 1e-3, 0.0, 0.0);
            let camera = looking(eye, DVec3::NEG_Z * 40.0);
            let found = culler.cull(&camera);
            if frame % 10 < 2 {
                judge(culler, &camera, &found);
            }
            found.statistics.skipped.has(Skip::OcclusionLittleHidden)
        });
        skipped.collect::<Vec<bool>>()
    };
    let skipped = pause(&mut culler, 200);
    let tried: Vec<usize> = (0..200).filter(|&frame| !skipped[frame]).collect();
    let pauses: Vec<usize> = tried.windows(2).map(|w| w[1] - w[0] - 1).collect();
    assert_eq!(pauses, [0, 2, 4, 8, 16, 32, 64, 64]);

    // The eye turns round, to a wall that hides what is behind it.
    let camera = looking(DVec3::new(0.0, 0.0, 60.0), DVec3::ZERO);
    let hidden_by_wall = culler.cull(&camera);
    judge(&culler, &camera, &hidden_by_wall);
    let found = hidden_by_wall;
    assert!(!found.statistics.skipped.has(Skip::OcclusionLittleHidden));
    assert!(found.visible.len() < 400, "{}", found.visible.len());
}

/// Where an object costs less to draw than to ask about, nobody asks; groups of them are culled all the same.
#[test]
fn nobody_asks_about_what_is_cheap_to_draw() {
    let (city, path) = generated(Kind::City, "effort-cheap");
    let cheap = Effort {
        reuse: false,
        prices: Prices {
            object: 0.0,
            triangle: 0.5,
        },
        ..Effort::default()
    };
    let mut cullers = [cheap, Effort::FULL]
        .map(|effort| Culler::new(city.clone(), settings(effort)).expect("threads"));
    let mut taken = 0;
    for camera in path.cameras().iter().step_by(10) {
        let [asks_less, asks] = [0, 1].map(|i| cullers[i].cull(camera));
        judge(&cullers[0], camera, &asks_less);
        let skipped = asks_less.statistics.skipped;
        taken += usize::from(skipped.has(Skip::QuestionsDearerThanDrawing));
        assert!(asks_less.visible.len() >= asks.visible.len());
        assert_eq!(asks_less.statistics.objects_in_question, 0);
        assert!(
            !asks
                .statistics
                .skipped
                .has(Skip::QuestionsDearerThanDrawing)
        );
    }
    assert!(taken > 3, "{taken}");
}

/// The pyramid is built where holes may be ignored, and nowhere else.
#[test]
fn exact_frames_have_no_pyramid() {
    let (city, path) = generated(Kind::City, "effort-pyramid");
    let approximate = Accuracy::Approximate(Approximation::of_hole(64));
    for (accuracy, has_none) in [(Accuracy::Exact, true), (approximate, false)] {
        let settings = Settings {
            accuracy,
            ..settings(Effort::default())
        };
        let mut culler = Culler::new(city.clone(), settings).expect("threads");
        let camera = &path.cameras()[0];
        let found = culler.cull(camera);
        assert_eq!(found.statistics.skipped.has(Skip::Pyramid), has_none);
        if has_none {
            judge(&culler, camera, &found);
        }
    }
}

/// Each view of a scene finds what a culler of its own would, whatever the threads, and objects that move do so in all of them.
#[test]
fn views_share_a_scene_and_nothing_else() {
    use antumbra::scene::Move;
    let (city, path) = generated(Kind::City, "effort-views");
    let sizes = [[637, 411], [256, 256], [320, 90]];
    let of_view = |view: usize| Settings {
        size: PictureSize::new(sizes[view][0], sizes[view][1]).expect("a size"),
        ..settings(Effort::default())
    };
    for threads in [1, 2, 5] {
        let shared = Settings {
            threads,
            ..of_view(0)
        };
        let mut culler = Culler::new(city.clone(), shared).expect("threads");
        assert_eq!(
            [culler.add_view(of_view(1)), culler.add_view(of_view(2))],
            [1, 2]
        );
        let mut alone =
            [0, 1, 2].map(|view| Culler::new(city.clone(), of_view(view)).expect("threads"));
        let mut found: [VisibleSet; 3] = Default::default();
        for frame in 0..6 {
            let object = (frame * 31) as u32;
            let moves = [Move {
                object,
                world_from_local: DAffine3::from_translation(DVec3::X)
                    * culler.scene().objects()[object as usize].world_from_local,
                swept: false,
            }];
            culler.move_objects(&moves).expect("it stays in the world");
            let cameras = [0, 1, 2].map(|view| path.cameras()[frame * 5 + view * 60]);
            culler.cull_views(&cameras, &mut found);
            for view in 0..3 {
                alone[view]
                    .move_objects(&moves)
                    .expect("it stays in the world");
                let by_itself = alone[view].cull(&cameras[view]);
                assert_eq!(
                    found[view].visible, by_itself.visible,
                    "view {view}, {threads} threads"
                );
                let hash = |buffer: Option<&antumbra::occlusion::OcclusionBuffer>| {
                    buffer.expect("a frame").tiles().hash()
                };
                assert_eq!(hash(culler.buffer_of(view)), hash(alone[view].buffer()));
            }
        }
        culler.cull_view(1, &path.cameras()[7], &mut found[1]);
        assert_eq!(found[1].visible, alone[1].cull(&path.cameras()[7]).visible);
    }
}
