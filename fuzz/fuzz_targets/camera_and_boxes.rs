//! Any camera, any picture, any boxes: no panic, and footprints hold all that exact arithmetic says may be drawn of them. A box that is
//! hidden behind what was drawn owns no sample.
#![no_main]

#[path = "../drawn.rs"]
mod drawn;
#[path = "../../tests/numerics/exact.rs"]
mod exact;
#[path = "../numbers.rs"]
mod numbers;
#[path = "../../tests/oracle/coverage.rs"]
mod oracle;
#[path = "../../tests/numerics/truth.rs"]
mod truth;

use antumbra::glam::{DAffine3, DVec3};
use antumbra::occlusion::{Footprint, Occluder, OcclusionBuffer, OrientedBox, Screen};
use antumbra::raster::{CullMode, Geometry, Positions};
use antumbra::scene::Aabb;
use antumbra::view::{Containment, Frustum, Planes};
use antumbra_simd::Level;
use arbitrary::Arbitrary;
use drawn::{CUBE, FACES, Picture, cube_in, is_promised};
use exact::{Dyadic, Fraction};
use libfuzzer_sys::fuzz_target;
use numbers::{CameraWish, Matrix, Number, Size, Vector};
use truth::{Corner, View};

#[derive(Debug, Arbitrary)]
struct Case {
    camera: CameraWish,
    size: Size,
    /// In front of the eye: how far, how large.
    wall: Option<(Number, Number)>,
    boxes: Vec<(Vector, Vector)>,
    turned: Vec<(Vector, Matrix)>,
    balls: Vec<(Vector, Number)>,
    rectangles: Vec<([Number; 2], [Number; 2], Number)>,
}

/// The samples that something may cover whose corners are these, snapped as they may be: none if a corner is not behind the near
/// plane. And the nearest depth.
fn true_extent(view: &View, corners: &[Corner]) -> Option<([[i64; 2]; 2], Fraction)> {
    let before = |c: &Corner| c.w.sign() <= 0 || !view.is_behind_near(c);
    if corners.iter().any(before) {
        return None;
    }
    // First and last centre within half a sub-pixel: the snap alone.
    let samples = |at: &dyn Fn(&Corner) -> Fraction, pixels: i32| {
        let edge = |f: Fraction, out: f64| {
            let moved = &f.above + &(&f.below * &Dyadic::of(out));
            (moved, &f.below * &Dyadic::whole(256))
        };
        let index = |(above, below): (Dyadic, Dyadic)| {
            let index = above.floor_of_ratio(&below);
            i64::try_from(index).unwrap_or(if above.sign() < 0 { i64::MIN } else { i64::MAX })
        };
        let least = corners.iter().map(at).min().expect("a corner");
        let largest = corners.iter().map(at).max().expect("a corner");
        // ⌈v⌉ is ⌊v⌋ + 1 but for whole numbers, where this leaves one out: no harm.
        let first = index(edge(least, -128.5)).saturating_add(1).max(0);
        let last = index(edge(largest, -127.5)).min(i64::from(pixels) - 1);
        [first, last]
    };
    let x = samples(&|c| c.column(), view.width);
    let y = samples(&|c| c.row(), view.height);
    let nearest = corners
        .iter()
        .map(Corner::true_depth)
        .max()
        .expect("a corner");
    Some(([x, y], nearest))
}

fn check_footprint(
    view: &View,
    footprint: Footprint,
    corners: &[Corner],
    what: &dyn std::fmt::Debug,
) {
    let Some(([x, y], nearest)) = true_extent(view, corners) else {
        assert_eq!(footprint, Footprint::Unbounded, "{what:?}");
        return;
    };
    let somewhere = x[0] <= x[1] && y[0] <= y[1];
    match footprint {
        Footprint::Unbounded => {}
        Footprint::Nowhere => assert!(!somewhere, "{what:?}: {x:?}, {y:?}"),
        Footprint::Within(rect) => {
            let holds = |rect: [i32; 2], range: [i64; 2]| {
                i64::from(rect[0]) <= range[0] && range[1] <= i64::from(rect[1])
            };
            assert!(
                !somewhere || holds(rect.x, x) && holds(rect.y, y),
                "{what:?}: {rect:?} without {x:?}, {y:?}"
            );
            // What a sample writes is rounded to f32: a depth of less than half its least step is 0.
            let half_a_step = 2_f64.powi(-150);
            assert!(
                rect.nearest_depth == f32::INFINITY
                    || nearest.taken_from(rect.nearest_depth.into()) >= -half_a_step,
                "{what:?}: {rect:?}"
            );
        }
    }
}

fn is_sound(min: DVec3, max: DVec3) -> bool {
    min.is_finite() && max.is_finite() && min.cmple(max).all()
}

fn corners_of(min: DVec3, max: DVec3) -> [DVec3; 8] {
    std::array::from_fn(|i| {
        DVec3::from_array(std::array::from_fn(|a| {
            if i >> a & 1 == 0 { min[a] } else { max[a] }
        }))
    })
}

/// Larger pictures are not drawn.
const DRAWN: usize = 4096;

fn buffer_with_wall(case: &Case, screen: &Screen, picture: &mut Picture) -> OcclusionBuffer {
    let (camera, size) = (*screen.camera(), screen.size());
    let mut buffer = OcclusionBuffer::new(size, camera);
    if let Some((away, large)) = case.wall {
        let place = DAffine3 {
            matrix3: antumbra::glam::DMat3::from_cols(
                camera.right() * large.0,
                camera.up() * large.0,
                camera.forward(),
            ),
            translation: camera.eye() + camera.forward() * (away.0 + 1.0),
        };
        let indices = [0, 1, 3, 0, 3, 2];
        buffer.draw(&Occluder {
            geometry: Geometry::new(Positions::packed(&CUBE), &indices).expect("sound"),
            world_from_local: place,
            cull_mode: CullMode::None,
        });
        picture.draw(&camera, &CUBE, &indices, &place, CullMode::None);
    }
    buffer.finish();
    picture.check(buffer.tiles());
    buffer
}

fuzz_target!(|case: Case| {
    let Some(camera) = case.camera.get() else {
        return;
    };
    let size = case.size.any();
    let (screen, view) = (Screen::new(camera, size), View::new(&camera, size));
    let frustum = Frustum::new(&camera, size);
    let is_small = size.width() * size.height() <= DRAWN;
    let drawn = is_small.then(|| {
        let mut picture = Picture::new(size);
        let buffer = buffer_with_wall(&case, &screen, &mut picture);
        (buffer, picture)
    });
    let check_hidden = |hidden: bool, place: &DAffine3| {
        if let Some((_, picture)) = &drawn
            && hidden
            && is_promised(place)
        {
            assert!(!picture.shows(&camera, &CUBE, &FACES, place), "{place:?}");
        }
    };

    let mut aligned = Vec::new();
    for &(center, half) in case.boxes.iter().take(6) {
        // As two corners, or as a centre and half a diagonal: both are asked for.
        let (center, half) = (center.get(), half.get());
        aligned.push((center, half));
        aligned.push((center - half.abs(), center + half.abs()));
    }
    let as_box = |&(min, max): &(DVec3, DVec3)| Aabb { min, max };
    for &(min, max) in &aligned {
        let bounds = Aabb { min, max };
        let footprint = screen.footprint_of_aabb(&bounds);
        if is_sound(min, max) {
            let corners = corners_of(min, max).map(|c| view.corner_of_world(c));
            check_footprint(&view, footprint, &corners, &bounds);
        } else {
            assert_eq!(footprint, Footprint::Unbounded, "{bounds:?}");
        }
        // As a scene's boxes are, it is larger by a little than what it holds.
        let reach = min.abs().max(max.abs()).max_element();
        let grown = bounds.grown(reach * 2_f64.powi(-40));
        let outside = frustum.contains(&grown, Planes::ALL) == Containment::Outside;
        if let Some((buffer, picture)) = &drawn {
            let place = cube_in(min, max);
            check_hidden(buffer.test_aabb(&bounds).is_hidden(), &place);
            // What lies outside the frustum has no pixel at all.
            if outside && is_sound(min, max) && is_promised(&place) {
                let empty = Picture::new(picture.size);
                assert!(!empty.shows(&camera, &CUBE, &FACES, &place), "{bounds:?}");
            }
        }
    }
    // Several at once are what they are one by one, or no less.
    let mut several: Vec<Vec<Footprint>> = Vec::new();
    for &level in Level::available() {
        let mut footprints = Vec::new();
        screen.footprints_of_aabbs(level, aligned.iter().map(as_box), &mut footprints);
        assert_eq!(footprints.len(), aligned.len());
        several.push(footprints);
    }
    assert!(several.iter().all(|s| *s == several[0]), "{several:?}");
    for (&(min, max), &footprint) in aligned.iter().zip(&several[0]) {
        if is_sound(min, max) {
            let corners = corners_of(min, max).map(|c| view.corner_of_world(c));
            check_footprint(&view, footprint, &corners, &(min, max));
        }
    }

    for &(center, axes) in case.turned.iter().take(4) {
        let (center, axes) = (center.get(), axes.get());
        let half_axes = [axes.x_axis, axes.y_axis, axes.z_axis];
        let footprint = screen.footprint_of_oriented_box(center, half_axes);
        let place = DAffine3 {
            matrix3: axes,
            translation: center,
        };
        if place.is_finite() {
            let corners = CUBE.map(|c| view.corner(&place, c));
            check_footprint(&view, footprint, &corners, &place);
        } else {
            assert_eq!(footprint, Footprint::Unbounded, "{place:?}");
        }
        if let Some((buffer, _)) = &drawn {
            let oriented = OrientedBox { center, half_axes };
            check_hidden(buffer.test_oriented_box(&oriented).is_hidden(), &place);
        }
    }

    for &(center, radius) in case.balls.iter().take(4) {
        let (center, radius) = (center.get(), radius.0);
        let footprint = screen.footprint_of_sphere(center, radius);
        if !(center.is_finite() && radius.is_finite() && radius >= 0.0) {
            assert_eq!(footprint, Footprint::Unbounded, "{center:?} {radius}");
            continue;
        }
        // Six points of it, a little inside however they are rounded.
        let axes = [DVec3::X, DVec3::Y, DVec3::Z];
        let inside = radius * (1.0 - 1e-15);
        let points = axes
            .iter()
            .flat_map(|&a| [center + a * inside, center - a * inside]);
        let corners: Vec<Corner> = points
            .filter(|p| p.is_finite())
            .map(|p| view.corner_of_world(p))
            .collect();
        if !corners.is_empty() {
            check_footprint(&view, footprint, &corners, &(center, radius));
        }
    }

    for &(x, y, distance) in case.rectangles.iter().take(4) {
        let (x, y) = (x.map(|n| n.0), y.map(|n| n.0));
        let _: Footprint = screen.footprint_of_rectangle(x, y, distance.0);
    }
});
