//! The rectangle and depth that a shape is asked with enclose all that the shape can draw, and not much more: against
//! exact rational projections.

mod oracle;
mod worlds;

use antumbra::glam::{DAffine3, DMat3, DVec3};
use antumbra::occlusion::{Footprint, SampleRect, Screen};
use antumbra::raster::{ObjectAssembler, for_each_sample};
use antumbra::scene::{Aabb, Scene};
use antumbra::view::{Camera, PictureSize, Projection};
use antumbra_simd::vertex::{ScreenTransform, transform};
use num_bigint::BigInt;
use num_rational::BigRational;
use oracle::Chance;
use worlds::{DOUBLE_SIDED, SHAPES};

fn exact(v: f64) -> BigRational {
    BigRational::from_float(v).unwrap()
}

fn whole(v: i64) -> BigRational {
    BigRational::from_integer(v.into())
}

type ExactPoint = [BigRational; 3];

fn exact_point(p: DVec3) -> ExactPoint {
    p.to_array().map(exact)
}

/// A position relative to the eye, exactly: the placement, then the eye's distance.
fn from_eye(place: &DAffine3, position: [f32; 3], eye: DVec3) -> ExactPoint {
    let p = position.map(|v| exact(f64::from(v)));
    let columns = [
        place.matrix3.x_axis,
        place.matrix3.y_axis,
        place.matrix3.z_axis,
    ]
    .map(exact_point);
    let (origin, eye) = (exact_point(place.translation), exact_point(eye));
    std::array::from_fn(|i| {
        columns[0][i].clone() * &p[0]
            + columns[1][i].clone() * &p[1]
            + columns[2][i].clone() * &p[2]
            + &origin[i]
            - &eye[i]
    })
}

/// A row product. The rows of [`Camera::screen_from_eye`] are taken as given: they define the projection.
fn row(r: [f64; 4], p: &ExactPoint) -> BigRational {
    exact(r[0]) * &p[0] + exact(r[1]) * &p[1] + exact(r[2]) * &p[2] + exact(r[3])
}

/// X / W and Y / W in sub-pixels, and D / W; none at or behind the eye plane.
fn project(t: &ScreenTransform, p: &ExactPoint) -> Option<[BigRational; 3]> {
    let w = row(t.w, p);
    (w > whole(0)).then(|| [row(t.x, p) / &w, row(t.y, p) / &w, row(t.depth, p) / w])
}

fn least<'a>(all: impl Iterator<Item = &'a BigRational>) -> &'a BigRational {
    all.min().unwrap()
}

fn largest<'a>(all: impl Iterator<Item = &'a BigRational>) -> &'a BigRational {
    all.max().unwrap()
}

/// Whether all pixels of a picture `pixels` wide whose centre lies within `span`, half a sub-pixel more on both sides,
/// are in `rect`.
fn encloses(rect: [i32; 2], span: [&BigRational; 2], pixels: usize) -> bool {
    let (half, per_pixel) = (exact(0.5), whole(256));
    let first = ((span[0] - &half - whole(128)) / &per_pixel).ceil();
    let last = ((span[1] + &half - whole(128)) / &per_pixel).floor();
    let first = first.max(whole(0));
    let last = last.min(whole(pixels as i64 - 1));
    first > last || (whole(rect[0].into()) <= first && last <= whole(rect[1].into()))
}

#[test]
fn a_box_encloses_the_exact_projection_of_its_object_and_all_its_samples() {
    let mut chance = Chance::seeded(41);
    let size = PictureSize::new(71, 53).unwrap();
    let mut bounded = 0;
    for round in 0..500 {
        let home = worlds::home(&mut chance);
        let kind = SHAPES[chance.whole(0, SHAPES.len() as i32 - 1) as usize];
        let radius = [0.05, 1.0, 30.0][round % 3];
        let (mesh, place) = worlds::placed(&mut chance, kind, DOUBLE_SIDED, home, radius);
        let scene = Scene::new(vec![mesh], vec![worlds::object(0, place)]).unwrap();
        let distance = radius * chance.real(1.0, 60.0);
        let camera = worlds::camera(&mut chance, home, distance);
        let screen = Screen::new(camera, size);
        let Footprint::Within(rect) = screen.footprint_of_aabb(&scene.bounds()[0]) else {
            continue;
        };
        bounded += 1;
        // The exact projection of every vertex, and half a sub-pixel for its snap.
        let t = camera.screen_from_eye(size);
        let projected: Vec<[BigRational; 3]> = scene.meshes()[0]
            .positions
            .iter()
            .step_by(3)
            .map(|&p| {
                project(&t, &from_eye(&place, p, camera.eye())).expect("in front of the near plane")
            })
            .collect();
        for (axis, (range, pixels)) in [(rect.x, size.width()), (rect.y, size.height())]
            .into_iter()
            .enumerate()
        {
            let span = [
                least(projected.iter().map(|p| &p[axis])),
                largest(projected.iter().map(|p| &p[axis])),
            ];
            assert!(
                encloses(range, span, pixels),
                "round {round}, {kind:?}, axis {axis}: {range:?} is less than {span:?}"
            );
        }
        let nearest = largest(projected.iter().map(|p| &p[2]));
        assert!(
            *nearest <= exact(f64::from(rect.nearest_depth)),
            "round {round}, {kind:?}"
        );
        // All that is drawn.
        ObjectAssembler::new(camera, size).assemble(
            &scene.meshes()[0],
            &place,
            |_| true,
            |drawn| {
                for_each_sample(&drawn.triangle, 0..size.height() as i32, |x, y, depth| {
                    assert!(rect.x[0] <= x && x <= rect.x[1] && rect.y[0] <= y && y <= rect.y[1]);
                    assert!(depth <= rect.nearest_depth);
                });
            },
        );
    }
    assert!(bounded > 200, "{bounded} with a rectangle");
}

/// The bound that everything above rests on, for vertices as they are drawn: a snapped vertex lies within half a
/// sub-pixel, 2⁻¹⁰ more for the rounding of the snap and the division, and what a move by 2⁻⁴⁰ of the coordinates does,
/// from where it is exactly. (The sums are good to 2⁻⁵⁰ of their terms: γ₄ for the product with the instance's row, whose
/// own elements are as good.)
#[test]
fn a_snapped_vertex_is_within_the_bound_of_its_exact_projection() {
    let mut chance = Chance::seeded(42);
    let size = PictureSize::new(640, 480).unwrap();
    let mut worst = 0.0_f64;
    let mut seen = 0;
    for _ in 0..600 {
        let home = worlds::home(&mut chance);
        let (mesh, place) =
            worlds::placed(&mut chance, worlds::Shape::Cube, DOUBLE_SIDED, home, 1.0);
        let distance = chance.real(1.0, 60.0);
        let camera = worlds::camera(&mut chance, home, distance);
        let local = camera.screen_from_local(size, &place);
        let t = camera.screen_from_eye(size);
        let length = |r: [f64; 4]| DVec3::new(r[0], r[1], r[2]).length();
        for &position in &mesh.positions {
            let clip = transform(&local, position);
            if !clip.is_inside(&local) {
                continue;
            }
            seen += 1;
            let snapped = clip.snap();
            let [x, y, depth] = project(&t, &from_eye(&place, position, camera.eye())).unwrap();
            let m = place.matrix3;
            let p = position.map(|v| f64::from(v.abs()));
            let terms = m.x_axis.abs() * p[0]
                + m.y_axis.abs() * p[1]
                + m.z_axis.abs() * p[2]
                + place.translation.abs();
            let moved =
                (terms.max_element() + camera.eye().abs().max_element()) / (1_u64 << 40) as f64;
            for (snapped, exactly, norm) in
                [(snapped.x, x, length(t.x)), (snapped.y, y, length(t.y))]
            {
                let largest = f64::from(snapped.abs());
                let spare = moved * (norm + largest * length(t.w)) / (clip.w - moved * length(t.w));
                let off = whole(snapped.into()) - exactly;
                let off = if off < whole(0) { -off } else { off };
                assert!(off <= exact(0.5 + 1.0 / 1024.0 + spare));
                let spent = rounded(off - exact(0.5));
                worst = worst.max(spent / (1.0 / 1024.0 + spare));
            }
            let spare = moved * (length(t.depth) + snapped.depth.abs() * length(t.w)) / clip.w
                + snapped.depth.abs() / (1_u64 << 40) as f64;
            let off = exact(snapped.depth) - depth;
            let off = if off < whole(0) { -off } else { off };
            assert!(off <= exact(spare));
        }
    }
    assert!(seen > 2_000);
    // The bound is at least four times what is needed.
    assert!(worst < 0.25, "the bound is used to {worst}");
}

/// To within 2⁻⁴⁰.
fn rounded(v: BigRational) -> f64 {
    let scaled = (v * whole(1 << 40)).to_integer();
    scaled.to_string().parse::<f64>().unwrap() / (1_u64 << 40) as f64
}

/// In ordinary worlds nothing but the snap is added: at most 1/100 of a sub-pixel more.
#[test]
fn the_rectangle_of_a_box_is_tight() {
    let mut chance = Chance::seeded(43);
    let size = PictureSize::new(320, 200).unwrap();
    let mut bounded = 0;
    for _ in 0..2_000 {
        let home = DVec3::splat([0.0, 2_000.0][chance.whole(0, 1) as usize]);
        let half = DVec3::new(
            chance.real(0.1, 2.0),
            chance.real(0.0, 2.0),
            chance.real(0.1, 2.0),
        );
        let bounds = Aabb {
            min: home - half,
            max: home + half,
        };
        let distance = chance.real(3.0, 60.0);
        let camera = worlds::camera(&mut chance, home, distance);
        let Footprint::Within(rect) = Screen::new(camera, size).footprint_of_aabb(&bounds) else {
            continue;
        };
        bounded += 1;
        let t = camera.screen_from_eye(size);
        let eye = exact_point(camera.eye());
        let projected: Vec<[BigRational; 3]> = bounds
            .corners()
            .map(|c| {
                let [x, y, z] = exact_point(c);
                project(&t, &[x - &eye[0], y - &eye[1], z - &eye[2]]).unwrap()
            })
            .to_vec();
        let more = exact(0.51);
        for (axis, range) in [rect.x, rect.y].into_iter().enumerate() {
            let [first, last] = range.map(|i| whole(256 * i64::from(i) + 128));
            assert!(first >= least(projected.iter().map(|p| &p[axis])) - &more);
            assert!(last <= largest(projected.iter().map(|p| &p[axis])) + &more);
        }
        let nearest = largest(projected.iter().map(|p| &p[2]));
        let excess = exact(f64::from(rect.nearest_depth)) / nearest;
        // The corner with the largest D need not be the one with the least W, but both are the same for either view.
        assert!(rounded(excess - whole(1)).abs() < 2e-7);
    }
    assert!(bounded > 1_000, "{bounded} with a rectangle");
}

fn rect(footprint: Footprint) -> Option<SampleRect> {
    match footprint {
        Footprint::Within(rect) => Some(rect),
        _ => None,
    }
}

/// A ball's outline on a column λ of the screen is where A·λ² − 2B·λ + C ≤ 0: the plane X = λ·W is at most a radius away
/// from the centre. No column outside the rectangle may be such a one; one that is farther out by a pixel must not be in.
#[test]
fn a_ball_is_enclosed_and_tightly() {
    let mut chance = Chance::seeded(44);
    let size = PictureSize::new(97, 83).unwrap();
    let mut bounded = 0;
    for round in 0..6_000 {
        let home = worlds::home(&mut chance);
        let radius = chance.real(0.0, 1.0) * [0.001, 1.0, 100.0][round % 3];
        // From far away, and from just before the surface.
        let distance = radius
            + [
                radius * 1e-4 + 1e-6,
                0.1 * radius + 1e-3,
                5.0 * radius,
                50.0,
            ][round / 3 % 4];
        let camera = worlds::camera(&mut chance, home, distance);
        let aside = worlds::direction(&mut chance) * chance.real(0.0, distance);
        let centre = if chance.one_in(2) { home } else { home + aside };
        let Some(rect) = rect(Screen::new(camera, size).footprint_of_sphere(centre, radius)) else {
            continue;
        };
        bounded += 1;
        let t = camera.screen_from_eye(size);
        let relative: ExactPoint =
            std::array::from_fn(|i| exact(centre[i]) - exact(camera.eye()[i]));
        let r2 = exact(radius) * exact(radius);
        let dot = |a: [f64; 4], b: [f64; 4]| {
            (0..3).fold(whole(0), |sum, i| sum + exact(a[i]) * exact(b[i]))
        };
        let w = row(t.w, &relative);
        for (across, range, pixels) in [(t.x, rect.x, size.width()), (t.y, rect.y, size.height())] {
            let x = row(across, &relative);
            // |n − λ·w|·r is the most that the plane's value changes within the ball, so a column is outside it where
            // (x − λ·w)² is more than the square of that. All denominators are powers of two: one does for all.
            let coefficients = [
                &x * &x - dot(across, across) * &r2,
                &x * &w - dot(across, t.w) * &r2,
                &w * &w - dot(t.w, t.w) * &r2,
            ];
            let denominator = coefficients
                .iter()
                .map(|c| c.denom().clone())
                .max()
                .unwrap();
            let [c0, c1, c2] = coefficients.map(|c| c.numer() * (&denominator / c.denom()));
            let outside = |sub_pixels: i64| {
                &c0 - 2 * sub_pixels * &c1 + sub_pixels * sub_pixels * &c2 > BigInt::ZERO
            };
            for i in 0..pixels as i32 {
                let inside_rect = range[0] <= i && i <= range[1];
                if !inside_rect {
                    assert!(
                        outside(256 * i64::from(i) + 128),
                        "round {round}: column or row {i} of {range:?}"
                    );
                }
            }
            // Tight: a pixel in from each end that the picture does not cut, the ball is met. (A ball smaller than a
            // pixel may be missed on both sides.)
            // (Where neither the eye plane nor what the position may be off by is close.)
            let (plain_w, plain_norm) = (
                rounded(w.clone()),
                DVec3::new(across[0], across[1], across[2]).length(),
            );
            let moved = (centre.abs().max_element() + camera.eye().abs().max_element())
                / (1_u64 << 40) as f64;
            let clear = plain_w > radius * 1.01 && moved * plain_norm < 16.0 * (plain_w - radius);
            if range[1] - range[0] > 3 && clear {
                if range[0] > 0 {
                    assert!(
                        !outside(256 * i64::from(range[0] + 1) + 128),
                        "round {round}: {range:?}"
                    );
                }
                if range[1] + 1 < pixels as i32 {
                    assert!(
                        !outside(256 * i64::from(range[1] - 1) + 128),
                        "round {round}: {range:?}"
                    );
                }
            }
        }
        // The nearest point.
        let forward = camera.forward();
        let front = centre - forward * radius;
        let depth = project(
            &t,
            &std::array::from_fn(|i| exact(front[i]) - exact(camera.eye()[i])),
        )
        .unwrap();
        let tolerance = whole(1) / whole(1 << 45);
        let magnitude = if depth[2] < whole(0) {
            -depth[2].clone()
        } else {
            depth[2].clone()
        };
        let reach = exact(centre.abs().max_element() + camera.eye().abs().max_element());
        assert!(
            depth[2].clone() - (magnitude + reach) * tolerance
                <= exact(f64::from(rect.nearest_depth))
        );
    }
    assert!(bounded > 2_000, "{bounded} with a rectangle");
}

#[test]
fn points_of_a_ball_fall_into_its_rectangle() {
    let mut chance = Chance::seeded(45);
    let size = PictureSize::new(97, 83).unwrap();
    for round in 0..300 {
        let home = worlds::home(&mut chance);
        let radius = [0.01, 1.0, 50.0][round % 3];
        let distance = radius * chance.real(1.01, 9.0);
        let camera = worlds::camera(&mut chance, home, distance);
        let Some(rect) = rect(Screen::new(camera, size).footprint_of_sphere(home, radius)) else {
            continue;
        };
        let t = camera.screen_from_local(
            size,
            &DAffine3 {
                matrix3: DMat3::IDENTITY,
                translation: home,
            },
        );
        for _ in 0..300 {
            let p = worlds::direction(&mut chance) * radius;
            let at = |r: [f64; 4]| r[0] * p.x + r[1] * p.y + r[2] * p.z + r[3];
            let [x, y] = [at(t.x) / at(t.w), at(t.y) / at(t.w)];
            for (v, range, pixels) in [(x, rect.x, size.width()), (y, rect.y, size.height())] {
                // The samples on both sides of a point of the ball are within half a pixel of it or not asked.
                if v < 0.0 || v >= 256.0 * pixels as f64 {
                    continue;
                }
                let [first, last] = range.map(|i| 256.0 * f64::from(i) + 128.0);
                assert!(first - 256.0 <= v && v <= last + 256.0);
            }
            assert!((at(t.depth) / at(t.w)) <= f64::from(rect.nearest_depth));
        }
    }
}

/// An axis-aligned box asked as an oriented one gives the same samples and depth.
#[test]
fn an_oriented_box_without_a_turn_equals_the_axis_aligned_one() {
    let mut chance = Chance::seeded(46);
    let size = PictureSize::new(131, 77).unwrap();
    let mut bounded = 0;
    for _ in 0..3_000 {
        // Dyadic numbers: centre and half axes are exact.
        let mut dyadic = |reach: i32| f64::from(chance.whole(-reach, reach)) / 64.0;
        let center = DVec3::new(dyadic(9_000), dyadic(9_000), dyadic(9_000));
        let half = DVec3::new(dyadic(99).abs(), dyadic(99).abs(), dyadic(99).abs());
        let distance = chance.real(1.0, 20.0);
        let camera = worlds::camera(&mut chance, center, distance);
        let screen = Screen::new(camera, size);
        let axes = [DVec3::X * half.x, DVec3::Y * -half.y, DVec3::Z * half.z];
        let oriented = screen.footprint_of_oriented_box(center, [axes[1], axes[2], axes[0]]);
        let aligned = screen.footprint_of_aabb(&Aabb {
            min: center - half,
            max: center + half,
        });
        match (oriented, aligned) {
            (Footprint::Within(a), Footprint::Within(b)) => {
                bounded += 1;
                assert_eq!((a.x, a.y), (b.x, b.y));
                assert!(
                    (a.nearest_depth - b.nearest_depth).abs()
                        <= 2.0 * f32::EPSILON * b.nearest_depth.abs()
                );
            }
            (a, b) => assert_eq!(a, b),
        }
    }
    assert!(bounded > 1_000);
}

/// A rectangle on screen is what the caller says, in pixels, but for the snap.
#[test]
fn a_rectangle_holds_the_centres_inside_it() {
    let size = PictureSize::new(30, 20).unwrap();
    let projection = Projection::Perspective {
        fov_y: 1.0,
        near: 0.5,
        far: None,
    };
    let camera = Camera::look_at(DVec3::ZERO, DVec3::X, DVec3::Y, projection).unwrap();
    let screen = Screen::new(camera, size);
    let of =
        |x: [f64; 2], y: [f64; 2], distance: f64| screen.footprint_of_rectangle(x, y, distance);
    let within = |x, y, nearest_depth| {
        Footprint::Within(SampleRect {
            x,
            y,
            nearest_depth,
        })
    };
    // The depth is rounded towards the eye: the f32 after 0.25.
    assert_eq!(
        of([3.0, 7.0], [0.6, 1.6], 2.0),
        within([3, 6], [1, 1], 0.25_f32.next_up())
    );
    assert_eq!(
        of([3.5, 7.5], [-5.0, 99.0], 2.0),
        within([3, 7], [0, 19], 0.25_f32.next_up())
    );
    assert_eq!(of([3.6, 4.4], [0.0, 9.0], 2.0), Footprint::Nowhere);
    assert_eq!(of([-9.0, -1.0], [0.0, 9.0], 2.0), Footprint::Nowhere);
    assert_eq!(of([0.0, 1.0], [0.0, 9.0], 0.5), Footprint::Unbounded);
}
