//! Pictures of all sizes: the smallest and the odd ones sample by sample, the largest by spans.

use antumbra::glam::DVec3;
use antumbra::occlusion::OcclusionBuffer;
use antumbra::scene::Aabb;
use antumbra::view::{Camera, Projection};

use crate::exact::f32_step;
use crate::oracle::{Chance, Point, covers, side};
use crate::scatter::*;
use crate::tally::{Tally, keep_largest};
use crate::truth::{Facet, View};
use crate::world::{Thing, World};

/// Sizes at which tiles are cut every way.
const SIZES: [(u32, u32); 14] = [
    (1, 1),
    (1, 2),
    (2, 1),
    (1, 9),
    (9, 1),
    (3, 5),
    (7, 7),
    (8, 8),
    (9, 9),
    (15, 17),
    (16, 8),
    (1, 301),
    (301, 1),
    (301, 7),
];

/// Pictures from one pixel to a few hundred, of any proportions.
pub fn small_pictures(chance: &mut Chance) -> World {
    let (width, height) = one_of(chance, &SIZES);
    let size = size(width, height);
    let projection = if chance.one_in(3) {
        Projection::Orthographic {
            height: chance.real(1.0, 9.0),
            near: 0.1,
            far: None,
        }
    } else {
        Projection::Perspective {
            fov_y: chance.real(0.1, 2.0),
            near: 0.1,
            far: None,
        }
    };
    let camera = camera_at(chance, DVec3::ZERO, projection);
    let things = scattered(chance, &camera, size, |chance| chance.real(1.0, 12.0));
    World {
        camera,
        size,
        things,
    }
}

/// The first and last column of a row whose centres a triangle covers, found by halving from an edge to the next: `inside` is true
/// from some column on, or up to one.
fn first_where(from: i32, to: i32, inside: impl Fn(i32) -> bool) -> i32 {
    let (mut low, mut high) = (from, to);
    while low < high {
        let middle = low + (high - low) / 2;
        if inside(middle) {
            high = middle;
        } else {
            low = middle + 1;
        }
    }
    low
}

/// The columns that a triangle covers in a row of a picture.
fn span([a, b, c]: [Point; 3], y: i32, width: i32) -> std::ops::Range<i32> {
    let area = crate::truth::twice_area([a, b, c]).signum() as i32;
    let (mut first, mut end) = (0, width);
    for (p, q) in [(a, b), (b, c), (c, a)] {
        let inside = |x: i32| side(p, q, x, y) == area;
        match (inside(first), inside(end.max(first + 1) - 1)) {
            (true, true) => {}
            (false, false) => return 0..0,
            (false, true) => first = first_where(first, end, inside),
            (true, false) => end = first_where(first, end, |x| !inside(x)),
        }
        if first >= end {
            return 0..0;
        }
    }
    first..end
}

/// One triangle over a large picture, and a corner of another: every row is compared with exact spans, and depths at some samples.
pub fn judge_large(chance: &mut Chance, width: u32, height: u32, tally: &mut Tally) {
    let size = size(width, height);
    let projection = Projection::Perspective {
        fov_y: 1.0,
        near: 0.1,
        far: None,
    };
    let camera = Camera::look_at(DVec3::ZERO, DVec3::NEG_Z, DVec3::Y, projection);
    let camera = camera.expect("a camera");
    let mut points = Vec::new();
    for _ in 0..2 {
        let reach = one_of(chance, &[0.9, 3.0]);
        for _ in 0..3 {
            let away = chance.real(4.0, 40.0);
            let (_, half) = in_view(chance, &camera, size, away);
            let mut aside = || chance.real(-reach, reach) * half;
            let (x, y) = (aside() * size.aspect(), aside());
            points.push(DVec3::new(x, y, -away));
        }
    }
    let thing = of_world(&points, vec![[0, 1, 2], [3, 4, 5]], true);
    let world = World {
        camera,
        size,
        things: vec![thing],
    };
    let thing: &Thing = &world.things[0];
    let view = View::new(&camera, size);
    tally.cases += 1;
    let drawn = world.drawn(thing, false);
    let indices: Vec<usize> = drawn.iter().map(|d| d.index).collect();
    let facets: Vec<Facet> = drawn
        .iter()
        .map(|drawn| {
            let corners = thing.triangles[drawn.index];
            let corners = corners.map(|i| view.corner(&thing.place, thing.positions[i as usize]));
            // Of this thing nothing is clipped; whether a corner comes second or third hangs on which way it runs.
            let snapped = |p: Point| {
                let near = |c: &&crate::truth::Corner| {
                    let off_x = c.column().taken_from(p.0.into()).abs();
                    let off_y = c.row().taken_from(p.1.into()).abs();
                    off_x.max(off_y) < 0.51
                };
                let corner = corners
                    .iter()
                    .find(near)
                    .expect("a corner is drawn where it is");
                let off_x = corner.column().taken_from(p.0.into()).abs();
                let off_y = corner.row().taken_from(p.1.into()).abs();
                (corner, off_x.max(off_y) / 256.0)
            };
            let found = drawn.points.map(snapped);
            for (_, off) in &found {
                keep_largest(&mut tally.position, *off);
            }
            tally.triangles += 1;
            Facet::new(drawn.points, found.map(|(c, _)| c)).expect("it has an area")
        })
        .collect();
    if facets.is_empty() {
        return; // It lies between the centres of a picture that is one pixel wide.
    }
    let mut buffer = OcclusionBuffer::new(size, camera);
    world.draw(&mut buffer, thing);
    buffer.finish();
    let (tiles, across) = (buffer.tiles(), size.tiles_across());
    for y in 0..height as i32 {
        let spans: Vec<_> = facets
            .iter()
            .map(|f| span(f.points, y, width as i32))
            .collect();
        for tile in 0..across as i32 {
            let mut expected = 0_u8;
            for span in &spans {
                let from = (span.start - 8 * tile).clamp(0, 8);
                let to = (span.end - 8 * tile).clamp(0, 8);
                if from < to {
                    expected |= ((1_u16 << to) - (1 << from)) as u8;
                }
            }
            let word = tiles.coverage()[y as usize / 8 * across + tile as usize];
            let row = (word >> (y % 8 * 8)) as u8;
            assert_eq!(row, expected, "row {y}, tile {tile}");
        }
        let covered = spans.iter().map(|s| s.len() as u64).sum::<u64>();
        tally.samples += covered;
    }
    // What is kept at some samples, the ends of rows among them, and who owns those.
    let mut owns = vec![false; facets.len()];
    for _ in 0..3_000 {
        let chosen = chance.whole(0, facets.len() as i32 - 1) as usize;
        let y = chance.whole(0, height as i32 - 1);
        let span = span(facets[chosen].points, y, width as i32);
        if span.is_empty() {
            continue;
        }
        let middle = span.start + (span.end - span.start) / 2;
        let x = one_of(chance, &[span.start, span.end - 1, middle]);
        let Some(stored) = buffer.pixel(x as usize, y as usize) else {
            panic!("({x}, {y}) is not covered");
        };
        let covering = facets.iter().filter(|f| covers(f.points, x, y));
        let nearest = covering.map(|f| f.depth_at(x, y)).max().expect("covered");
        owns[chosen] |= facets[chosen].depth_at(x, y) == nearest;
        let step = f32_step(nearest.approximately());
        keep_largest(
            &mut tally.stored_nearer,
            nearest.taken_from(stored.into()) / step,
        );
    }
    // A box around each triangle, and small ones far behind it.
    for (&index, owns) in indices.iter().zip(owns) {
        let corners = &points[3 * index..3 * index + 3];
        let grown = Aabb::around(corners.iter().copied()).grown(1e-3);
        let hidden = buffer.test_aabb(&grown).is_hidden();
        tally.answer(owns, hidden, || format!("triangle {index}, {corners:?}"));
        let behind = (corners[0] + corners[1] + corners[2]) * (2.0 / 3.0);
        let half = DVec3::splat(0.01);
        let (min, max) = (behind - half, behind + half);
        let hidden = buffer.test_aabb(&Aabb { min, max }).is_hidden();
        tally.answer(false, hidden, String::new);
    }
}
