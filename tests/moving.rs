//! Scenes whose objects move: nothing is ever lost, and what has not changed is not found out again.

mod generated;

use antumbra::cull::{Culler, Effort, Settings, Skip, VisibleSet};
use antumbra::glam::{DAffine3, DVec3};
use antumbra::measure::{Animation, MeasureSettings, Moving, Reference, run};
use antumbra::prepare::Prepared;
use antumbra::scene::{Move, Scene};
use antumbra::view::{Camera, PictureSize};
use antumbra_fixtures::Kind;
use generated::generated;

fn settings(threads: usize) -> Settings {
    Settings {
        threads,
        ..Settings::new(PictureSize::new(637, 411).expect("a size"))
    }
}

fn shifted(scene: &Scene, object: u32, by: DVec3) -> Move {
    Move {
        object,
        world_from_local: DAffine3::from_translation(by)
            * scene.objects()[object as usize].world_from_local,
        swept: false,
    }
}

/// Whether the visible set holds all that owns a pixel where objects are now; how much it culls beside that.
fn judged(culler: &Culler, camera: &Camera, found: &VisibleSet) -> usize {
    let reference = Reference::new(culler.scene(), camera, culler.settings().size);
    for object in reference.visible_objects() {
        assert!(
            found.visible.binary_search(&object).is_ok(),
            "object {object} was lost ({})",
            found.statistics.skipped
        );
    }
    found.visible.len() - reference.visible_objects().count()
}

/// A moved scene is the scene that would have been made so; its hierarchy holds it, and is built again when it is worn.
#[test]
fn a_moved_scene_is_what_it_would_be_if_it_had_been_made_so() {
    let (scene, _) = generated(Kind::City, "moving-scene");
    let mut moved = Scene::clone(&scene);
    for frame in [0, 7, 300] {
        let mut moves = Vec::new();
        Animation::new(&scene, Moving::All, DVec3::Y, 5).moves(frame, &mut moves);
        moved.move_objects(&moves).expect("they stay in the world");
        let anew = Scene::new(moved.meshes().to_vec(), moved.objects().to_vec()).expect("sound");
        assert_eq!(moved.bvh().validate(moved.bounds()), Ok(()));
        for (index, object) in moved.objects().iter().enumerate() {
            let (here, there) = (moved.bounds()[index], anew.bounds()[index]);
            if moved.meshes()[object.mesh].positions.len() <= 1024 {
                assert_eq!(here, there);
                assert_eq!(moved.own_box(index), anew.own_box(index));
            } else {
                assert!(here.contains(there));
            }
        }
    }
    // Every other object goes far away: the hierarchy is as good as a new one afterwards.
    let objects = (0..scene.objects().len() as u32).step_by(2);
    let far =
        objects.map(|object| shifted(&scene, object, DVec3::new(9e3, 40.0, f64::from(object))));
    moved
        .move_objects(&far.collect::<Vec<_>>())
        .expect("far, but in the world");
    assert_eq!(moved.bvh().validate(moved.bounds()), Ok(()));
    let anew = Scene::new(moved.meshes().to_vec(), moved.objects().to_vec()).expect("sound");
    let area = |scene: &Scene| -> f64 {
        let sizes = scene.bvh().nodes.iter().map(|node| node.bounds().size());
        sizes.map(|s| s.x * s.y + s.y * s.z + s.z * s.x).sum()
    };
    assert!(area(&moved) < 1.1 * area(&anew));
}

/// What cannot be is said, and nothing has moved.
#[test]
fn moves_that_cannot_be_move_nothing() {
    let (scene, _) = generated(Kind::City, "moving-errors");
    let mut moved = Scene::clone(&scene);
    let good = shifted(&scene, 0, DVec3::X);
    let nowhere = Move {
        object: scene.objects().len() as u32,
        ..good
    };
    let not_finite = shifted(&scene, 1, DVec3::new(f64::NAN, 0.0, 0.0));
    let too_far = shifted(&scene, 1, DVec3::splat(1e31));
    for (bad, why) in [
        (nowhere, "there are"),
        (not_finite, "not finite"),
        (too_far, "beyond"),
    ] {
        let error = moved.move_objects(&[good, bad]).expect_err("it cannot be");
        assert!(error.to_string().contains(why), "{error}");
        assert_eq!(moved.bounds(), scene.bounds());
    }
}

/// Doors and everything, on the path of the city: no false cull, no wrong pixel.
#[test]
fn nothing_is_lost_while_objects_move() {
    let (scene, path) = generated(Kind::City, "moving-path");
    let prepared = Prepared::new(scene);
    for (moving, threads) in [(Moving::Doors, 1), (Moving::All, 2)] {
        let settings = MeasureSettings {
            cull: settings(threads),
            cold: false,
            every: 6,
            animate: Some((moving, 3)),
            simulate_threads: false,
        };
        let report = run(&prepared, &path, &settings, |_, _| {}).expect("threads");
        assert!(report.frames.iter().all(|frame| frame.moved > 0));
        assert_eq!(report.totals.false_culls, 0, "{moving}");
        assert_eq!(report.totals.wrong_pixels, 0, "{moving}");
        let culled = report.totals.culled_of_hidden;
        assert!(
            culled > 0.9 * report.totals.ideal_box_culled_of_hidden,
            "{moving}: {culled}"
        );
    }
}

/// A frame like the last one is the last one's answer, buffer and all; anything that changes ends that.
#[test]
fn a_frame_like_the_last_one_is_not_found_again() {
    let (scene, path) = generated(Kind::City, "moving-reuse");
    let mut culler = Culler::new(scene.clone(), settings(1)).expect("threads");
    let hash = |culler: &Culler| culler.buffer().expect("a frame").tiles().hash();
    let again = |culler: &mut Culler, camera| {
        let found = culler.cull(camera);
        (
            found.statistics.skipped.has(Skip::Everything),
            found.visible,
        )
    };
    for cameras in path.cameras().windows(2).step_by(9) {
        let first = culler.cull(&cameras[0]);
        assert!(!first.statistics.skipped.has(Skip::Everything));
        let drawn = hash(&culler);
        assert_eq!(again(&mut culler, &cameras[0]), (true, first.visible));
        assert_eq!(hash(&culler), drawn);
        assert!(!again(&mut culler, &cameras[1]).0);
    }
    let camera = &path.cameras()[0];
    culler.cull(camera);
    assert!(again(&mut culler, camera).0);
    culler.set_salience(0, 0.5);
    assert!(!again(&mut culler, camera).0);
    culler.forget();
    assert!(!again(&mut culler, camera).0);
    culler.resize(PictureSize::new(320, 200).expect("a size"));
    assert!(!again(&mut culler, camera).0);
    let mut never = Culler::new(
        scene,
        Settings {
            effort: Effort::FULL,
            ..settings(1)
        },
    )
    .expect("threads");
    never.cull(camera);
    assert!(!again(&mut never, camera).0);
}

/// While the camera stands still and one object moves, only what it touches is found again; the picture is right, and as much is
/// culled as if everything were.
#[test]
fn what_a_moved_object_touches_is_found_again() {
    let (scene, path) = generated(Kind::City, "moving-part");
    let (mut parts, mut unchanged) = (0, 0);
    let (mut kept, mut kept_by_all) = (0, 0);
    for (number, camera) in path.cameras().iter().step_by(16).enumerate() {
        let mut culler = Culler::new(scene.clone(), settings(1 + number % 2)).expect("threads");
        let mut whole = Culler::new(
            scene.clone(),
            Settings {
                effort: Effort::FULL,
                ..settings(1)
            },
        )
        .expect("threads");
        let seen = culler.cull(camera).visible;
        whole.cull(camera);
        let in_frustum = culler.in_frustum(camera);
        for step in 0..24 {
            // What is seen, and what is not, each there and back, and sideways into view.
            let among = if step % 4 < 2 { &seen } else { &in_frustum };
            let object = among[(step / 2 * 7 + number * 13) % among.len()];
            let way = scene.bounds()[object as usize].size().max_element() * 0.7;
            let by = [DVec3::X, DVec3::Y, DVec3::Z][step / 2 % 3] * way;
            let sign = if step % 2 == 0 { 1.0 } else { -1.0 };
            let moves = [shifted(culler.scene(), object, by * sign)];
            culler.move_objects(&moves).expect("it stays in the world");
            whole.move_objects(&moves).expect("it stays in the world");
            let found = culler.cull(camera);
            kept += judged(&culler, camera, &found);
            whole.forget();
            let all = whole.cull(camera);
            kept_by_all += judged(&whole, camera, &all);
            parts += usize::from(found.statistics.skipped.has(Skip::Elsewhere));
            let tiles = culler.buffer().expect("a frame").tiles().coverage().len();
            unchanged += usize::from(found.statistics.occluder_triangles == 0 && tiles > 0);
        }
    }
    assert!(parts > 60, "{parts} of the frames were parts");
    assert!(unchanged < parts, "{unchanged} drew nothing");
    assert!(
        kept <= kept_by_all + kept_by_all / 10,
        "{kept} hidden objects were kept, and {kept_by_all} by whole frames"
    );
}

/// What reaches the near plane has no rectangle. It stays visible when something moves where nobody looks.
#[test]
fn what_moves_out_of_the_picture_takes_nothing_with_it() {
    let (scene, path) = generated(Kind::City, "moving-outside");
    let mut culler = Culler::new(scene.clone(), settings(1)).expect("threads");
    let eye = path.cameras()[0].eye();
    let reaches = |object: &u32| {
        let bounds = scene.bounds()[*object as usize].grown(0.5);
        bounds.min.cmple(eye).all() && bounds.max.cmpge(eye).all()
    };
    let objects = 0..scene.objects().len() as u32;
    // Something large is moved so that the eye is inside of it, and something else is moved behind.
    let large = { objects.clone() }
        .max_by(|&a, &b| {
            let size = |object: u32| scene.bounds()[object as usize].size().min_element();
            size(a).total_cmp(&size(b))
        })
        .expect("an object");
    let center = scene.bounds()[large as usize].center();
    let moves = [shifted(&scene, large, eye - center)];
    culler.move_objects(&moves).expect("it stays in the world");
    let camera = &path.cameras()[0];
    let before = culler.cull(camera);
    assert!(before.visible.contains(&large));
    let other = { objects }
        .find(|object| *object != large && !reaches(object) && !before.visible.contains(object))
        .expect("a hidden object");
    let behind = eye - camera.forward() * 500.0;
    for step in [0.0, 1.0] {
        let at = culler.scene().bounds()[other as usize].center();
        let to = behind + DVec3::Y * step - at;
        let moves = [shifted(culler.scene(), other, to)];
        culler.move_objects(&moves).expect("it stays in the world");
        let found = culler.cull(camera);
        assert!(
            found.visible.contains(&large),
            "{}",
            found.statistics.skipped
        );
        judged(&culler, camera, &found);
        if step == 1.0 {
            assert!(found.statistics.skipped.has(Skip::Elsewhere));
            assert_eq!(found.visible, before.visible);
        }
    }
}

/// Teleports, cuts, resizes and other fields of view are right on the first frame.
#[test]
fn sudden_changes_are_right_at_once() {
    let (scene, path) = generated(Kind::City, "moving-cuts");
    let mut culler = Culler::new(scene.clone(), settings(2)).expect("threads");
    let cameras = path.cameras();
    let sizes = [[637, 411], [200, 300], [1000, 90]];
    for frame in 0..12 {
        let camera = &cameras[frame * 37 % cameras.len()];
        let [width, height] = sizes[frame / 2 % 3];
        culler.resize(PictureSize::new(width, height).expect("a size"));
        // A large object, which may hide much, goes where the camera looks.
        let object = (frame * 101 % scene.objects().len()) as u32;
        let there = camera.eye() + camera.forward() * 12.0;
        let center = culler.scene().bounds()[object as usize].center();
        let moves = [shifted(culler.scene(), object, there - center)];
        culler.move_objects(&moves).expect("it stays in the world");
        let found = culler.cull(camera);
        judged(&culler, camera, &found);
    }
}

/// A swept object's box holds where it was and where it is, and it hides nothing until it moves again.
#[test]
fn a_swept_object_hides_nothing_and_is_seen_on_its_way() {
    let (scene, path) = generated(Kind::City, "moving-swept");
    let mut culler = Culler::new(scene.clone(), settings(1)).expect("threads");
    let camera = &path.cameras()[0];
    let found = culler.cull(camera);
    let occluder = found.occluders[0].id.object;
    let still = Move {
        swept: true,
        ..shifted(&scene, occluder, DVec3::X * 3.0)
    };
    culler
        .move_objects(&[still])
        .expect("it stays in the world");
    let swept = culler.scene().bounds()[occluder as usize];
    assert!(swept.contains(scene.bounds()[occluder as usize]));
    let found = culler.cull(camera);
    assert!(
        found
            .occluders
            .iter()
            .all(|drawn| drawn.id.object != occluder)
    );
    judged(&culler, camera, &found);
    let back = Move {
        swept: false,
        ..shifted(&scene, occluder, DVec3::ZERO)
    };
    culler.move_objects(&[back]).expect("it stays in the world");
    assert_eq!(culler.scene().bounds(), scene.bounds());
    let found = culler.cull(camera);
    judged(&culler, camera, &found);
    assert!(!culler.scene().objects()[occluder as usize].never_occlude);
}
