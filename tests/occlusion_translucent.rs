//! Translucent occluders: panes of glass that together hide what one of them does not.

use antumbra::cull::{Culler, Settings};
use antumbra::glam::{DAffine3, DVec3};
use antumbra::occlusion::{Accuracy, Approximation, Occluder, OcclusionBuffer};
use antumbra::raster::{CullMode, Geometry, Positions};
use antumbra::scene::{Aabb, Alpha, Material, Mesh, Object, Scene, Surface};
use antumbra::view::{Camera, MapScale, PictureSize, Projection};

const WALL: [[f32; 3]; 4] = [
    [-50.0, -50.0, 0.0],
    [50.0, -50.0, 0.0],
    [50.0, 50.0, 0.0],
    [-50.0, 50.0, 0.0],
];

/// A buffer with panes at these distances, all of one opacity.
fn behind_panes(
    accuracy: Accuracy,
    scale: MapScale,
    distances: &[f64],
    opacity: f32,
) -> OcclusionBuffer {
    let projection = Projection::Perspective {
        fov_y: 1.0,
        near: 0.1,
        far: None,
    };
    let camera =
        Camera::look_at(DVec3::ZERO, DVec3::NEG_Z, DVec3::Y, projection).expect("a camera");
    let size = PictureSize::new(203, 157).expect("a size");
    let mut buffer = OcclusionBuffer::with_map_scale(size, camera, scale);
    buffer.set_accuracy(accuracy);
    for &distance in distances {
        let pane = Occluder {
            geometry: Geometry::new(Positions::packed(&WALL), &[0, 1, 2, 0, 2, 3]).expect("a quad"),
            world_from_local: DAffine3::from_translation(DVec3::new(0.0, 0.0, -distance)),
            cull_mode: CullMode::None,
        };
        buffer.draw_translucent(&pane, opacity);
    }
    buffer.finish();
    buffer
}

fn hides_cube_at(buffer: &OcclusionBuffer, distance: f64) -> bool {
    let middle = DVec3::new(0.0, 0.0, -distance);
    let half = DVec3::splat(0.4);
    let cube = Aabb {
        min: middle - half,
        max: middle + half,
    };
    buffer.test_aabb(&cube).is_hidden()
}

/// A tile is opaque if no more than a quarter of its pixels are uncovered here; what panes let through counts as so many.
#[test]
fn panes_hide_together_what_they_do_not_hide_alone() {
    let accuracy = Accuracy::Approximate(Approximation::promise(64));
    for scale in [MapScale::Full, MapScale::Half] {
        for (opacity, least) in [(1.0, 1), (0.8, 1), (0.6, 2), (0.45, 3), (0.3, 4), (0.1, 14)] {
            for count in 1..=20 {
                let distances: Vec<f64> = (0..count).map(|i| 5.0 + 0.1 * f64::from(i)).collect();
                let buffer = behind_panes(accuracy, scale, &distances, opacity);
                let hides = hides_cube_at(&buffer, 20.0);
                if scale == MapScale::Full {
                    assert_eq!(hides, count >= least, "{count} panes of {opacity}");
                } else {
                    // Its cells have fewer samples, and what is ignored in them is rounded down.
                    assert!(!hides || count >= least, "{count} panes of {opacity}");
                }
                assert!(!hides_cube_at(&buffer, 3.0), "nothing is before it");
            }
        }
    }
}

#[test]
fn what_stands_between_panes_is_not_hidden() {
    let accuracy = Accuracy::Approximate(Approximation::default());
    let buffer = behind_panes(accuracy, MapScale::Full, &[5.0, 15.0], 0.9);
    assert!(hides_cube_at(&buffer, 20.0));
    assert!(!hides_cube_at(&buffer, 10.0));
}

/// The next frame begins without them.
#[test]
fn panes_are_forgotten_with_the_rest() {
    let accuracy = Accuracy::Approximate(Approximation::default());
    let mut buffer = behind_panes(accuracy, MapScale::Full, &[5.0], 0.9);
    assert!(hides_cube_at(&buffer, 20.0));
    let camera = *buffer.screen().camera();
    buffer.clear(&camera);
    buffer.finish();
    assert!(!hides_cube_at(&buffer, 20.0));
}

#[test]
fn where_nothing_is_lost_glass_hides_nothing() {
    let nothing = Accuracy::Approximate(Approximation::of_hole(0));
    for accuracy in [Accuracy::Exact, nothing] {
        let buffer = behind_panes(accuracy, MapScale::Full, &[5.0, 6.0, 7.0], 1.0);
        assert!(!hides_cube_at(&buffer, 20.0));
        assert_eq!(buffer.ignored_pixels(), 0);
    }
}

/// A frame draws the glass of its scene if it is asked to and may lose something.
#[test]
fn frames_see_through_glass_unless_they_are_told_otherwise() {
    let mesh = |alpha, opacity| Mesh {
        name: String::new(),
        positions: WALL.to_vec().into(),
        triangles: vec![[0, 1, 2], [0, 2, 3]].into(),
        surfaces: vec![Surface {
            triangles: 0..2,
            material: Material {
                alpha,
                double_sided: true,
                color: [1.0, 1.0, 1.0, opacity],
            },
        }],
    };
    let placed = |mesh, distance: f64| Object {
        name: String::new(),
        mesh,
        world_from_local: DAffine3::from_translation(DVec3::new(0.0, 0.0, -distance)),
        never_cull: false,
        // What is drawn itself leaves no hole to be covered.
        never_occlude: mesh == 1,
        occluder_proxy: None,
    };
    let meshes = vec![mesh(Alpha::Blend, 0.6), mesh(Alpha::Opaque, 1.0)];
    let behind_the_first = placed(1, 7.0);
    let behind_all = placed(1, 40.0);
    let panes = [5.0, 10.0, 15.0].map(|distance| placed(0, distance));
    for (wall, expected) in [(behind_all, false), (behind_the_first, true)] {
        let mut objects = panes.to_vec();
        objects.push(wall);
        let scene = std::sync::Arc::new(Scene::new(meshes.clone(), objects).expect("a scene"));
        let projection = Projection::Perspective {
            fov_y: 1.0,
            near: 0.1,
            far: None,
        };
        let camera =
            Camera::look_at(DVec3::ZERO, DVec3::NEG_Z, DVec3::Y, projection).expect("a camera");
        let sees_wall = |accuracy, translucent| {
            let settings = Settings {
                accuracy,
                translucent,
                threads: 2,
                ..Settings::new(PictureSize::new(203, 157).expect("a size"))
            };
            let mut culler = Culler::new(scene.clone(), settings).expect("threads");
            let frames = [culler.cull(&camera), culler.cull(&camera)];
            let [first, second] = frames.map(|found| found.visible.contains(&3));
            assert_eq!(first, second);
            first
        };
        let approximate = Accuracy::Approximate(Approximation::promise(64));
        assert!(sees_wall(Accuracy::Exact, true));
        assert!(sees_wall(approximate, false));
        // One pane lets 0.4 through, three 0.064.
        assert_eq!(sees_wall(approximate, true), expected);
    }
}
