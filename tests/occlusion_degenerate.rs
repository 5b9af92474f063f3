//! What is not finite, inverted, flat, enormous or too close never hides, never panics, and never changes an answer.

mod oracle;
mod worlds;

use antumbra::glam::{DAffine3, DMat3, DVec3};
use antumbra::occlusion::{Footprint, Occluder, OcclusionBuffer, OrientedBox, Screen, Sphere};
use antumbra::raster::{CullMode, Geometry, Positions};
use antumbra::scene::Aabb;
use antumbra::view::{Camera, PictureSize, Projection};
use antumbra_simd::Level;
use oracle::Chance;

const NOT_FINITE: [f64; 3] = [f64::NAN, f64::INFINITY, f64::NEG_INFINITY];

fn perspective(near: f64) -> Projection {
    Projection::Perspective {
        fov_y: 1.2,
        near,
        far: None,
    }
}

fn orthographic(near: f64) -> Projection {
    Projection::Orthographic {
        height: 9.0,
        near,
        far: None,
    }
}

/// Looks from the origin along −z.
fn camera(projection: Projection) -> Camera {
    Camera::look_at(DVec3::ZERO, DVec3::NEG_Z, DVec3::Y, projection).unwrap()
}

fn size() -> PictureSize {
    PictureSize::new(45, 33).unwrap()
}

fn draw(buffer: &mut OcclusionBuffer, positions: &[[f32; 3]], indices: &[u32], place: DAffine3) {
    buffer.draw(&Occluder {
        geometry: Geometry::new(Positions::packed(positions), indices).unwrap(),
        world_from_local: place,
        cull_mode: CullMode::None,
    });
}

const SQUARE: [[f32; 3]; 4] = [
    [-99.0, -99.0, 0.0],
    [99.0, -99.0, 0.0],
    [99.0, 99.0, 0.0],
    [-99.0, 99.0, 0.0],
];
const INDICES: [u32; 6] = [0, 1, 2, 0, 2, 3];

/// A buffer whose every pixel is covered at a distance of 1, before anything that is asked.
fn behind_a_wall(projection: Projection) -> OcclusionBuffer {
    let mut buffer = OcclusionBuffer::new(size(), camera(projection));
    draw(
        &mut buffer,
        &SQUARE,
        &INDICES,
        DAffine3::from_translation(DVec3::NEG_Z),
    );
    buffer.finish();
    assert!(
        buffer
            .tiles()
            .coverage()
            .iter()
            .enumerate()
            .all(|(i, &c)| c == buffer.tiles().picture_mask(i % 6, i / 6))
    );
    buffer
}

fn buffers() -> [OcclusionBuffer; 2] {
    [
        behind_a_wall(perspective(0.1)),
        behind_a_wall(orthographic(0.1)),
    ]
}

fn aabb(min: [f64; 3], max: [f64; 3]) -> Aabb {
    Aabb {
        min: DVec3::from_array(min),
        max: DVec3::from_array(max),
    }
}

#[test]
fn a_box_that_is_not_finite_or_inverted_is_visible() {
    for buffer in buffers() {
        let (min, max) = ([-1.0, -1.0, -4.0], [1.0, 1.0, -3.0]);
        assert!(buffer.test_aabb(&aabb(min, max)).is_hidden());
        for at in 0..3 {
            for bad in NOT_FINITE {
                let spoilt = |mut corner: [f64; 3]| {
                    corner[at] = bad;
                    corner
                };
                assert!(!buffer.test_aabb(&aabb(spoilt(min), max)).is_hidden());
                assert!(!buffer.test_aabb(&aabb(min, spoilt(max))).is_hidden());
                assert!(
                    !buffer
                        .test_aabb(&aabb(spoilt(min), spoilt(max)))
                        .is_hidden()
                );
            }
            let (mut low, mut high) = (min, max);
            (low[at], high[at]) = (max[at], min[at]);
            assert!(
                !buffer.test_aabb(&aabb(low, high)).is_hidden(),
                "inverted along {at}"
            );
        }
        assert!(!buffer.test_aabb(&Aabb::EMPTY).is_hidden());
        assert!(
            !buffer
                .test_aabb(&aabb([f64::MIN; 3], [f64::MAX; 3]))
                .is_hidden()
        );
        assert!(!buffer.test_aabb(&aabb([-1e30; 3], [1e30; 3])).is_hidden());
    }
}

#[test]
fn a_flat_box_or_a_point_is_answered_like_any_other() {
    for buffer in buffers() {
        for half in [
            [0.0, 0.0, 0.0],
            [1.0, 0.0, 0.0],
            [0.0, 1.0, 1.0],
            [1.0, 1.0, 0.0],
        ] {
            let half = DVec3::from_array(half);
            let at = |z: f64| Aabb {
                min: DVec3::new(0.0, 0.0, z) - half,
                max: DVec3::new(0.0, 0.0, z) + half,
            };
            assert!(buffer.test_aabb(&at(-3.0)).is_hidden());
            // In front, if it holds a centre at all: the picture's middle is one.
            assert!(!buffer.test_aabb(&at(-0.9)).is_hidden());
            let axes = [DVec3::X * half.x, DVec3::Y * half.y, DVec3::Z * half.z];
            let oriented = |z: f64| OrientedBox {
                center: DVec3::new(0.0, 0.0, z),
                half_axes: axes,
            };
            assert!(buffer.test_oriented_box(&oriented(-3.0)).is_hidden());
            assert!(!buffer.test_oriented_box(&oriented(-0.9)).is_hidden());
        }
    }
}

#[test]
fn what_reaches_the_near_plane_is_visible() {
    for projection in [perspective(0.5), orthographic(0.5)] {
        // Not behind anything nearer than the near plane, so the wall stands at the least distance there is.
        let buffer = behind_a_wall(projection);
        let from_to = |near: f64, far: f64| aabb([-0.1, -0.1, -far], [0.1, 0.1, -near]);
        let sphere = |distance: f64, radius: f64| Sphere {
            center: DVec3::NEG_Z * distance,
            radius,
        };
        assert!(buffer.test_aabb(&from_to(2.0, 9.0)).is_hidden());
        assert!(buffer.test_sphere(&sphere(5.0, 3.0)).is_hidden());
        for near in [0.5, 0.499, 0.0, -1.0, -1e9] {
            assert!(
                !buffer.test_aabb(&from_to(near, 9.0)).is_hidden(),
                "near end at {near}"
            );
            let ball = sphere(5.0, 5.0 - near);
            assert!(!buffer.test_sphere(&ball).is_hidden(), "near end at {near}");
            assert!(
                !buffer
                    .test_rectangle([0.0, 9.0], [0.0, 9.0], near)
                    .is_hidden()
            );
        }
        // Behind the eye, and around it.
        assert!(!buffer.test_aabb(&from_to(-9.0, -3.0)).is_hidden());
        assert!(!buffer.test_sphere(&sphere(-5.0, 1.0)).is_hidden());
        assert!(!buffer.test_aabb(&from_to(0.0, 0.0)).is_hidden());
        assert!(!buffer.test_sphere(&sphere(0.0, 0.0)).is_hidden());
    }
}

#[test]
fn a_ball_without_a_proper_radius_is_visible() {
    for buffer in buffers() {
        let center = DVec3::new(0.3, 0.2, -7.0);
        let hidden =
            |center: DVec3, radius: f64| buffer.test_sphere(&Sphere { center, radius }).is_hidden();
        assert!(
            hidden(center, 0.0)
                && hidden(center, 1e-300)
                && hidden(center, 1.0)
                && hidden(center, 5.9)
        );
        for radius in [
            -1.0,
            -1e-3,
            -1e-12,
            -1e-15,
            -1e-300,
            f64::NAN,
            f64::INFINITY,
            f64::NEG_INFINITY,
            f64::MAX,
            1e200,
        ] {
            assert!(!hidden(center, radius), "radius {radius:e}");
        }
        for at in 0..3 {
            for bad in NOT_FINITE {
                let mut spoilt = center.to_array();
                spoilt[at] = bad;
                assert!(!hidden(DVec3::from_array(spoilt), 1.0), "centre {spoilt:?}");
                assert!(!hidden(DVec3::from_array(spoilt), bad), "centre {spoilt:?}");
            }
        }
    }
}

#[test]
fn an_oriented_box_that_is_not_finite_is_visible() {
    for buffer in buffers() {
        let whole = OrientedBox {
            center: DVec3::NEG_Z * 7.0,
            half_axes: [DVec3::X, DVec3::Y, DVec3::Z],
        };
        assert!(buffer.test_oriented_box(&whole).is_hidden());
        for at in 0..12 {
            for bad in [f64::NAN, f64::INFINITY, f64::NEG_INFINITY, f64::MAX] {
                let mut numbers: Vec<f64> = std::iter::once(whole.center)
                    .chain(whole.half_axes)
                    .flat_map(|v| v.to_array())
                    .collect();
                numbers[at] = bad;
                let v = |i: usize| DVec3::from_slice(&numbers[3 * i..]);
                let spoilt = OrientedBox {
                    center: v(0),
                    half_axes: [v(1), v(2), v(3)],
                };
                assert!(
                    !buffer.test_oriented_box(&spoilt).is_hidden(),
                    "number {at} is {bad}"
                );
            }
        }
    }
}

#[test]
fn a_rectangle_that_is_not_one_is_visible() {
    for buffer in buffers() {
        let hidden = |x, y, d| buffer.test_rectangle(x, y, d).is_hidden();
        assert!(hidden([3.0, 9.0], [2.0, 4.0], 7.0));
        assert!(hidden(
            [-1e300, 1e300],
            [f64::NEG_INFINITY, f64::INFINITY],
            7.0
        ));
        for bad in [f64::NAN, f64::NEG_INFINITY, -1.0, 0.0] {
            assert!(
                !hidden([3.0, 9.0], [2.0, 4.0], bad),
                "at a distance of {bad}"
            );
        }
        assert!(
            !hidden([f64::NAN, 9.0], [2.0, 4.0], 7.0) && !hidden([3.0, f64::NAN], [2.0, 4.0], 7.0)
        );
        assert!(
            !hidden([3.0, 9.0], [f64::NAN, 4.0], 7.0) && !hidden([3.0, 9.0], [2.0, f64::NAN], 7.0)
        );
        assert!(!hidden([9.0, 3.0], [2.0, 4.0], 7.0) && !hidden([3.0, 9.0], [4.0, 2.0], 7.0));
    }
}

/// A ball that all but touches the eye plane, with the nearest near plane there is: its outline goes to infinity, and
/// it stays around the middle of the picture, which it hides from no direction.
#[test]
fn a_ball_at_the_eye_plane_is_never_nowhere() {
    let mut chance = Chance::seeded(51);
    for round in 0..60_000 {
        let distance = [1.0, 3.7, 1e3, 6.4e6, 1e9][round % 5] * chance.real(0.5, 2.0);
        // From the plane itself out to a millionth of the distance.
        let gap = distance * 2_f64.powi(-chance.whole(20, 53)) * chance.real(0.0, 2.0);
        let axis = if round % 2 == 0 {
            DVec3::NEG_Z
        } else {
            worlds::direction(&mut chance)
        };
        let camera = Camera::look_at(
            DVec3::ZERO,
            axis,
            DVec3::new(0.3, 1.0, 0.1),
            perspective(1e-30),
        )
        .unwrap();
        let center = camera.forward() * distance;
        let footprint = Screen::new(camera, size()).footprint_of_sphere(center, distance - gap);
        match footprint {
            Footprint::Unbounded => {}
            Footprint::Nowhere => panic!("a ball at {distance} with {gap:e} before it is nowhere"),
            Footprint::Within(rect) => {
                // Seen from that close it is half the world.
                assert_eq!(
                    (rect.x, rect.y),
                    ([0, 44], [0, 32]),
                    "a ball at {distance} with {gap:e} before it"
                );
            }
        }
    }
}

/// Finite numbers whose products with the view are not: asked one by one and several at once.
#[test]
fn a_box_whose_projection_overflows_is_visible() {
    let mut unbounded = 0;
    for projection in [perspective(0.1), orthographic(0.1)] {
        let forward = DVec3::new(0.3, 0.2, -1.0);
        let camera = Camera::look_at(DVec3::ZERO, forward, DVec3::Y, projection).unwrap();
        let screen = Screen::new(camera, size());
        for large in [1e306, f64::MAX] {
            // From the eye, or from far away, to where no product fits an f64.
            for near in [[-1.0, -21.5, -9.0], [0.3, large * 0.5, -large * 0.5]] {
                for signs in 0..7 {
                    let far = [0, 1, 2].map(|i| if signs >> i & 1 == 0 { large } else { near[i] });
                    let (near, far) = (DVec3::from_array(near), DVec3::from_array(far));
                    let bounds = Aabb {
                        min: near.min(far),
                        max: near.max(far),
                    };
                    let mut several = Vec::new();
                    for &level in Level::available() {
                        screen.footprints_of_aabbs(level, [bounds; 3].iter(), &mut several);
                    }
                    several.push(screen.footprint_of_aabb(&bounds));
                    for footprint in several {
                        assert_eq!(footprint, Footprint::Unbounded, "{bounds:?}");
                        unbounded += 1;
                    }
                }
            }
        }
    }
    assert!(unbounded > 200);
}

/// What any occluder may be, and what it must leave as it was.
#[test]
fn an_occluder_that_is_not_finite_or_has_no_area_changes_nothing() {
    for projection in [perspective(0.1), orthographic(0.1)] {
        let mut buffer = OcclusionBuffer::new(size(), camera(projection));
        let triangle = [[-2.0, -1.0, -5.0], [2.0, -1.5, -6.0], [0.0, 2.0, -4.0]];
        draw(&mut buffer, &triangle, &[0, 1, 2], DAffine3::IDENTITY);
        let before = buffer.tiles().clone();
        assert!(before.coverage().iter().any(|&c| c != 0));
        let mut still_the_same = |positions: &[[f32; 3]], place: DAffine3| {
            draw(&mut buffer, positions, &[0, 1, 2], place);
            assert_eq!(*buffer.tiles(), before, "{positions:?} {place:?}");
        };
        let near = [[-2.0, -1.0, -3.0], [2.0, -1.5, -3.0], [0.0, 2.0, -3.0_f32]];
        for bad in NOT_FINITE {
            for at in 0..9 {
                let mut spoilt = near;
                spoilt[at / 3][at % 3] = bad as f32;
                still_the_same(&spoilt, DAffine3::IDENTITY);
            }
            for at in 0..12 {
                let mut columns = DAffine3::IDENTITY.to_cols_array();
                columns[at] = bad;
                still_the_same(&near, DAffine3::from_cols_array(&columns));
            }
        }
        // No area: a point, a line, a scale of 0, an edge-on plane, less than the grid can tell.
        still_the_same(&[near[0]; 3], DAffine3::IDENTITY);
        still_the_same(&[near[0], near[1], near[0]], DAffine3::IDENTITY);
        still_the_same(
            &[[0.0, 0.0, -3.0], [1.0, 1.0, -3.0], [-2.0, -2.0, -3.0]],
            DAffine3::IDENTITY,
        );
        still_the_same(
            &[[0.0, 0.0, -3.0], [0.0, 0.0, -4.0], [0.0, 0.0, -2.0]],
            DAffine3::IDENTITY,
        );
        still_the_same(
            &near,
            DAffine3 {
                matrix3: DMat3::ZERO,
                translation: DVec3::NEG_Z * 3.0,
            },
        );
        let tiny = DMat3::from_diagonal(DVec3::splat(1e-300));
        still_the_same(
            &near,
            DAffine3 {
                matrix3: tiny,
                translation: DVec3::NEG_Z * 3.0,
            },
        );
        // Behind the eye, and before the near plane.
        still_the_same(&near, DAffine3::from_translation(DVec3::Z * 9.0));
        still_the_same(&near, DAffine3::from_scale(DVec3::splat(1e-3)));
    }
}

/// Enormous numbers may cover anything, but at no nearer depth than their vertices', and without a panic.
#[test]
fn enormous_occluders_do_not_panic() {
    let mut chance = Chance::seeded(52);
    for round in 0..40_000 {
        let near = [1e-30, 0.1, 1e20, 1e30][round % 4];
        let projection = if round % 3 == 0 {
            Projection::Orthographic {
                height: [1e-20, 5.0, 1e25][round / 3 % 3],
                near: -near,
                far: None,
            }
        } else {
            Projection::Perspective {
                fov_y: [2e-6, 1.0, 3.1][round / 3 % 3],
                near,
                far: None,
            }
        };
        let eye = DVec3::splat([0.0, 1e9, 1e28][round / 5 % 3]);
        let Ok(camera) = Camera::look_at(
            eye,
            eye + DVec3::new(0.3, -0.2, -1.0) * 1e20,
            DVec3::Y,
            projection,
        ) else {
            continue;
        };
        let mut buffer = OcclusionBuffer::new(size(), camera);
        let mut number = || {
            let sign = if chance.one_in(2) { 1.0 } else { -1.0_f32 };
            let large =
                [0.0, 1e-40, 1.0, 3e4, 1e9, 1e20, 1e30, f32::MAX][chance.whole(0, 7) as usize];
            sign * large * chance.real(0.5, 1.0) as f32
        };
        let positions: Vec<[f32; 3]> = (0..9).map(|_| [number(), number(), number()]).collect();
        let scale = [1e-300, 1e-9, 1.0, 1e30, 1e150, 1e300][chance.whole(0, 5) as usize];
        let place = DAffine3::from_scale(DVec3::new(scale, -scale, scale * chance.real(0.1, 1.0)));
        draw(&mut buffer, &positions, &[0, 1, 2, 3, 4, 5, 6, 7, 8], place);
        buffer.finish();
        for depths in buffer.tiles().depths() {
            assert!(depths.iter().all(|d| !d.is_nan()));
        }
        let corner = |p: &[f32; 3]| place.transform_point3(DVec3::from_array(p.map(f64::from)));
        let bounds = Aabb::around(positions.iter().map(corner));
        if buffer.tiles().coverage().iter().any(|&c| c != 0) {
            assert!(!buffer.test_aabb(&bounds).is_hidden(), "round {round}");
        }
    }
}
