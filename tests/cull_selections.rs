//! The selections of the papers, and the two hazards of temporal coherence (HOM figure 7.4).

use std::sync::Arc;

use antumbra::cull::{Culler, Settings};
use antumbra::glam::{DAffine3, DVec3};
use antumbra::occluders::{
    Budget, FramesBack, Selection, Weighing, distance_keys, object_of, solid_angle_keys,
    sort_nearest, weight_keys, z_plane_keys,
};
use antumbra::prepare::StaticCriteria;
use antumbra::scene::{Material, Mesh, Object, Scene, Surface};
use antumbra::view::{Camera, PictureSize, Projection};

/// A box of such a size at a place.
fn block(place: [f64; 3], size: [f64; 3]) -> Object {
    let scale = antumbra::glam::DMat3::from_diagonal(DVec3::from(size));
    Object {
        name: String::new(),
        mesh: 0,
        world_from_local: DAffine3 {
            matrix3: scale,
            translation: DVec3::from(place),
        },
        never_cull: false,
        never_occlude: false,
        occluder_proxy: None,
    }
}

fn scene(objects: Vec<Object>) -> Arc<Scene> {
    let corner = |i: u32| [0, 1, 2].map(|axis| if i >> axis & 1 == 1 { 0.5 } else { -0.5 });
    let faces = [
        [0, 2, 3, 1],
        [4, 5, 7, 6],
        [0, 1, 5, 4],
        [2, 6, 7, 3],
        [0, 4, 6, 2],
        [1, 3, 7, 5],
    ];
    let triangles: Vec<[u32; 3]> = faces
        .iter()
        .flat_map(|&[a, b, c, d]| [[a, b, c], [a, c, d]])
        .collect();
    let cube = Mesh {
        name: "cube".to_owned(),
        positions: (0..8).map(corner).collect(),
        surfaces: vec![Surface {
            triangles: 0..triangles.len(),
            material: Material {
                double_sided: true,
                ..Material::default()
            },
        }],
        triangles: triangles.into(),
    };
    Arc::new(Scene::new(vec![cube], objects).expect("a sound scene"))
}

fn culler(scene: &Arc<Scene>, occluders: Selection) -> Culler {
    let settings = Settings {
        occluders,
        budget: Budget::All,
        threads: 1,
        ..Settings::new(PictureSize::new(320, 200).expect("a size"))
    };
    Culler::new(scene.clone(), settings).expect("threads")
}

fn looking(eye: [f64; 3], at: [f64; 3]) -> Camera {
    let projection = Projection::Perspective {
        fov_y: 0.6,
        near: 0.1,
        far: None,
    };
    let [eye, at] = [eye, at].map(DVec3::from);
    Camera::look_at(eye, at, DVec3::Y, projection).expect("a camera")
}

const A: u32 = 0;

/// A turn brings a wall A and three boxes behind it into the frustum. Nobody saw A before, but it has just entered: equation
/// 7.1 takes it, and what was visible alone does not.
#[test]
fn a_turn_loses_nothing_where_what_enters_the_frustum_may_occlude() {
    let scene = scene(vec![
        block([20.0, 0.0, -4.0], [0.2, 12.0, 12.0]),
        block([25.0, 0.0, -3.0], [1.0; 3]),
        block([26.0, 0.0, -4.0], [1.0; 3]),
        block([27.0, 0.0, -5.0], [1.0; 3]),
        block([0.0, 0.0, -20.0], [2.0; 3]),
    ]);
    let cameras = [
        looking([0.0, 0.0, -4.0], [0.0, 0.0, -20.0]),
        looking([0.0, 0.0, -4.0], [20.0, 0.0, -4.0]),
        looking([0.0, 0.0, -4.0], [20.0, 0.0, -4.1]),
    ];
    let visible = |selection| {
        let mut culler = culler(&scene, selection);
        cameras.map(|camera| culler.cull(&camera).visible)
    };
    assert_eq!(visible(Selection::Coherent)[1..], [[A], [A]]);
    let previous = visible(Selection::PreviousVisible);
    assert_eq!(previous[1], [A, 1, 2, 3]);
    assert_eq!(previous[2], [A]);
    assert_eq!(visible(Selection::Nearest)[1..], [[A], [A]]);
}

/// The same turn, with what was visible two frames back: a wall that comes into view is drawn a frame later than with one.
#[test]
fn two_frames_back_draws_what_was_visible_then() {
    let scene = scene(vec![
        block([20.0, 0.0, -4.0], [0.2, 12.0, 12.0]),
        block([25.0, 0.0, -3.0], [1.0; 3]),
    ]);
    let away = looking([0.0, 0.0, -4.0], [0.0, 0.0, -20.0]);
    let there = looking([0.0, 0.0, -4.0], [20.0, 0.0, -4.0]);
    let visible = |frames_back| {
        let settings = Settings {
            frames_back,
            ..*culler(&scene, Selection::PreviousVisible).settings()
        };
        let mut culler = Culler::new(scene.clone(), settings).expect("threads");
        [away, there, there, there, there].map(|camera| {
            let found = culler.cull(&camera);
            assert!(found.visible.is_empty() || found.visible.contains(&A));
            found.visible.len()
        })
    };
    assert_eq!(visible(FramesBack::One), [0, 2, 1, 1, 1]);
    assert_eq!(visible(FramesBack::Two), [0, 2, 2, 1, 1]);
}

/// A step aside exposes a wall A and what is behind it, all of which was hidden. None of it is a candidate then: culling is lost
/// for a frame, and nothing else.
#[test]
fn a_step_aside_loses_culling_and_nothing_else() {
    let scene = scene(vec![
        block([0.0, 0.0, -20.0], [6.0, 6.0, 0.2]),
        block([-1.0, 0.0, -30.0], [1.0; 3]),
        block([0.0, 0.0, -30.0], [1.0; 3]),
        block([1.0, 0.0, -30.0], [1.0; 3]),
        // What hides them all at first.
        block([0.0, 0.0, -5.0], [3.0, 3.0, 0.2]),
    ]);
    let cameras = [0.0, 5.0, 5.1].map(|x| looking([x, 0.0, 0.0], [x * 0.5, 0.0, -20.0]));
    let mut culler = culler(&scene, Selection::Coherent);
    // Once to know what is visible.
    culler.cull(&cameras[0]);
    let visible = cameras.map(|camera| culler.cull(&camera).visible);
    assert_eq!(visible[0], [4]);
    assert_eq!(visible[1], [A, 1, 2, 3]);
    assert_eq!(visible[2], [A]);
}

/// Which of three objects each order begins with.
#[test]
fn each_order_begins_with_what_it_says() {
    let scene = scene(vec![
        // Near, and small.
        block([0.6, 0.0, -1.95], [0.2, 0.2, 0.2]),
        // Nearer along the view, but aside.
        block([-3.0, 0.7, -1.5], [0.9, 0.9, 0.01]),
        // Far, and large.
        block([0.0, 0.0, -12.0], [8.0, 8.0, 0.5]),
    ]);
    let camera = looking([0.0, 0.0, 0.0], [0.0, 0.0, -1.0]);
    let eye = camera.eye();
    let first = |find: &dyn Fn(&mut Vec<u64>)| {
        let mut keys = Vec::new();
        find(&mut keys);
        sort_nearest(&mut keys, 3);
        object_of(keys[0])
    };
    assert_eq!(first(&|keys| distance_keys(&scene, eye, 0..3, keys)), 0);
    assert_eq!(first(&|keys| z_plane_keys(&scene, &camera, 0..3, keys)), 1);
    assert_eq!(first(&|keys| solid_angle_keys(&scene, eye, 0..3, keys)), 2);
    let facing = |_| DVec3::Z;
    assert_eq!(
        first(&|keys| weight_keys(&scene, &camera, facing, 0..3, keys)),
        2
    );
    // From its edge the large one weighs next to nothing.
    let turned = |object| if object == 2 { DVec3::X } else { DVec3::Z };
    assert_eq!(
        first(&|keys| weight_keys(&scene, &camera, turned, 0..3, keys)),
        0
    );
}

/// A budget is spent in the order of the selection.
#[test]
fn a_budget_goes_to_what_comes_first() {
    let scene = scene(vec![
        block([0.6, 0.0, -1.95], [0.2, 0.2, 0.2]),
        block([0.0, 0.0, -12.0], [8.0, 8.0, 0.5]),
    ]);
    let camera = looking([0.0, 0.0, 0.0], [0.0, 0.0, -1.0]);
    let drawn = |occluders| {
        let settings = Settings {
            budget: Budget::Triangles(12),
            ..*culler(&scene, occluders).settings()
        };
        let mut culler = Culler::new(scene.clone(), settings).expect("threads");
        let found = culler.cull(&camera);
        let objects = found.occluders.iter().map(|drawn| drawn.id.object);
        objects.collect::<Vec<u32>>()
    };
    assert_eq!(drawn(Selection::Nearest), [0]);
    assert_eq!(drawn(Selection::Coherent), [0]);
    assert!(drawn(Selection::PreviousVisible).is_empty());
    assert_eq!(drawn(Selection::SolidAngle), [1]);
    assert_eq!(drawn(Selection::Weight), [1]);
}

/// The objects that a culler with changed settings draws.
fn drawn_with(scene: &Arc<Scene>, camera: &Camera, settings: Settings) -> Vec<u32> {
    let mut culler = Culler::new(scene.clone(), settings).expect("threads");
    let found = culler.cull(camera);
    let mut objects: Vec<u32> = found
        .occluders
        .iter()
        .map(|drawn| drawn.id.object)
        .collect();
    objects.sort_unstable();
    objects.dedup();
    objects
}

/// Three boxes side by side, and a cross of two bars in one mesh, which is nearest and largest but fills little of its box.
#[test]
fn by_weight_only_compact_objects_are_candidates_and_some_are_active() {
    let boxes = [-2.0, 0.0, 2.0].map(|x| block([x, 0.0, -10.0 - x], [1.0; 3]));
    let cube = scene(boxes.to_vec());
    let mut meshes = cube.meshes().to_vec();
    let bars = [[2.0, 0.1, 0.1], [0.1, 2.0, 0.1]];
    let bar = |size: [f32; 3]| {
        let positions = meshes[0].positions.iter();
        positions.map(move |p| [p[0] * size[0], p[1] * size[1], p[2] * size[2]])
    };
    let mut cross = meshes[0].clone();
    cross.positions = bars.into_iter().flat_map(bar).collect();
    let others = cross
        .triangles
        .clone()
        .into_iter()
        .map(|t| t.map(|i| i + 8));
    cross.triangles.to_mut().extend(others);
    cross.surfaces[0].triangles = 0..cross.triangles.len();
    meshes.push(cross);
    let mut objects = cube.objects().to_vec();
    objects.push(Object {
        mesh: 1,
        ..block([0.0, 1.5, -6.0], [1.0; 3])
    });
    let scene = Arc::new(Scene::new(meshes, objects).expect("a sound scene"));
    let camera = looking([0.0, 0.0, 0.0], [0.0, 0.0, -1.0]);
    let drawn = |weighing| {
        let settings = Settings {
            weighing,
            ..*culler(&scene, Selection::Weight).settings()
        };
        drawn_with(&scene, &camera, settings)
    };
    let all = Weighing {
        least_compactness: 0.0,
        most_active: None,
    };
    assert_eq!(drawn(all), [0, 1, 2, 3]);
    let compact = Weighing {
        least_compactness: 0.55,
        ..all
    };
    assert_eq!(drawn(compact), [0, 1, 2]);
    // The first box is nearest to the eye along the view.
    let one = Weighing {
        most_active: Some(1),
        ..compact
    };
    assert_eq!(drawn(one), [0]);
    let none = Weighing {
        most_active: Some(0),
        ..compact
    };
    assert!(drawn(none).is_empty());
    // Other selections know nothing of it.
    let nearest = Settings {
        weighing: none,
        ..*culler(&scene, Selection::Nearest).settings()
    };
    assert_eq!(drawn_with(&scene, &camera, nearest), [0, 1, 2, 3]);
}

/// A bolt before a wall, and a box.
#[test]
fn unfit_objects_are_not_drawn_by_the_papers_selections() {
    let scene = scene(vec![
        block([0.0, 0.0, -20.0], [8.0, 6.0, 0.2]),
        block([0.5, 0.3, -6.0], [0.05; 3]),
        block([-1.0, 0.0, -10.0], [1.0; 3]),
    ]);
    let camera = looking([0.0, 0.0, 0.0], [0.0, 0.0, -1.0]);
    for selection in Selection::ALL {
        let drawn = |static_criteria| {
            let settings = Settings {
                static_criteria,
                ..*culler(&scene, selection).settings()
            };
            drawn_with(&scene, &camera, settings)
        };
        let size = StaticCriteria {
            size: true,
            ..StaticCriteria::NONE
        };
        let (all, fit) = match selection {
            // Nothing was visible before the first frame.
            Selection::PreviousVisible => (vec![], vec![]),
            Selection::Contribution => (vec![0, 1, 2], vec![0, 1, 2]),
            _ => (vec![0, 1, 2], vec![0, 2]),
        };
        assert_eq!(drawn(StaticCriteria::NONE), all, "{selection}");
        assert_eq!(drawn(size), fit, "{selection}");
    }
}
