//! Compares what the library draws and answers with the truth, to the bit where it must be equal and with the proven bound where
//! it may differ:
//!
//! * A vertex is drawn within half a sub-pixel, 2⁻¹⁰ and 2⁻⁴⁰ of its terms from its exact projection (`src/occlusion/footprint.rs`).
//! * Between vertices as they are drawn, exactly the samples of the top-left rule are covered.
//! * A sample's depth is off by half a step of f32, 2⁻²³ of the vertices' range and 2⁻⁵⁰ (`simd/src/triangle.rs`); a sliver's is
//!   not nearer.
//! * What a tile keeps is nowhere nearer than the nearest true surface, but for that half step.
//! * What owns a sample, at the true depths of the true surfaces, or shares one, is not hidden.
#![allow(dead_code)] // Each program uses its own share.

use std::sync::Arc;

use antumbra::cull::{Culler, Settings};
use antumbra::glam::DVec3;
use antumbra::occlusion::OcclusionBuffer;
use antumbra::raster::{TileBuffer, for_each_sample};
use antumbra::scene::Scene;
use antumbra_simd::{Level, PART_HEIGHT};

use crate::exact::{Dyadic, Fraction, f32_step};
use crate::oracle::Point;
use crate::tally::{Tally, keep_largest};
use crate::truth::{Corner, Facet, View, twice_area};
use crate::world::{Drawn, Thing, World};
use crate::worlds;

/// The share of its terms by which a position may be off.
const POSITION_ERROR: f64 = 1.0 / (1_u64 << 40) as f64;

/// A facet that is drawn, as the library has it, and how far the depth of its corners may be off.
struct Surface {
    facet: Facet,
    drawn: Drawn,
    slack: f64,
}

fn length(row: [f64; 4]) -> f64 {
    DVec3::new(row[0], row[1], row[2]).length()
}

/// Where a corner may be drawn: within so many sub-pixels across and down, and so much depth.
struct Tolerance {
    x: f64,
    y: f64,
    depth: f64,
}

fn tolerance(view: &View, corner: &Corner, position: f64) -> Tolerance {
    let t = &view.rows;
    let [x, y, depth, w] = corner.as_drawn();
    let far_off_w = position * length(t.w) + corner.blur[3];
    let least_w = w - far_off_w;
    let of = |at: f64, row: [f64; 4], blur: f64| {
        let at = (at / w).abs();
        if least_w > 0.0 {
            (position * length(row) + blur + at * far_off_w) / least_w + at * POSITION_ERROR
        } else {
            f64::INFINITY
        }
    };
    let snap = 0.5 + 1.0 / 1024.0;
    Tolerance {
        x: snap + of(x, t.x, corner.blur[0]),
        y: snap + of(y, t.y, corner.blur[1]),
        depth: of(depth, t.depth, corner.blur[2]),
    }
}

/// Whether a matrix turns left hands into right ones, exactly.
fn is_mirrored(thing: &Thing) -> bool {
    let m = thing.place.matrix3;
    let [a, b, c] = [m.x_axis, m.y_axis, m.z_axis].map(|v| v.to_array().map(Dyadic::of));
    let minor = |i: usize, j: usize| &(&b[i] * &c[j]) - &(&b[j] * &c[i]);
    let sum = &(&a[0] * &minor(1, 2)) + &(&a[1] * &minor(2, 0));
    (&sum + &(&a[2] * &minor(0, 1))).sign() < 0
}

/// A drawn point beside a true corner: how far it is off in sub-pixels, if that is within the bound.
fn off(corner: &Corner, tolerance: &Tolerance, (x, y): Point) -> Option<f64> {
    let off_x = corner.column().taken_from(x.into()).abs();
    let off_y = corner.row().taken_from(y.into()).abs();
    (off_x <= tolerance.x && off_y <= tolerance.y).then(|| off_x.max(off_y))
}

/// The true surfaces of a thing, each beside what is drawn of it.
fn surfaces(world: &World, view: &View, thing: &Thing, tally: &mut Tally) -> Vec<Surface> {
    let mirrored = is_mirrored(thing);
    let drawn = world.drawn(thing, mirrored);
    let seen: Vec<Corner> = thing
        .positions
        .iter()
        .map(|&p| view.corner(&thing.place, p))
        .collect();
    let is_culled = |points: [Point; 3]| {
        // Counter-clockwise is the front, and negative where y points down.
        let front = (twice_area(points) < 0) != mirrored;
        twice_area(points) == 0 || !thing.double_sided && !front
    };
    let mut surfaces = Vec::new();
    let mut rest = drawn.as_slice();
    for (index, triangle) in thing.triangles.iter().enumerate() {
        let own = rest.iter().take_while(|d| d.index == index).count();
        let (own, others) = rest.split_at(own);
        rest = others;
        let corners = triangle.map(|i| seen[i as usize].clone());
        let terms = triangle.map(|i| thing.terms(thing.positions[i as usize]));
        let terms = terms.into_iter().fold(0.0, f64::max);
        let position = (terms + view.eye_reach) * POSITION_ERROR;
        let polygon = view.clipped(&corners, position);
        let tolerances: Vec<Tolerance> = polygon
            .iter()
            .map(|c| tolerance(view, c, position))
            .collect();
        let mut found = vec![false; polygon.len()];
        for &drawn in own {
            let [first, p, q] = drawn.points;
            let at = |i: usize, point| off(&polygon[i], &tolerances[i], point);
            // A triangle of the fan around the first corner, which may have been turned over: the one that fits best.
            let fan = (1..polygon.len().max(1) - 1).filter(|&i| !found[i]);
            let fits = fan.flat_map(|i| [(i, [0, i, i + 1]), (i, [0, i + 1, i])]);
            let fits = fits.filter_map(|(i, [_, j, k])| {
                let all = [at(0, first)?, at(j, p)?, at(k, q)?];
                Some((i, [0, j, k], all.into_iter().fold(0.0, f64::max)))
            });
            let part = fits.min_by(|a, b| a.2.total_cmp(&b.2));
            let Some((i, order, error)) = part else {
                panic!(
                    "triangle {index} is drawn as {:?}, but is {:?}",
                    drawn.points,
                    polygon
                        .iter()
                        .map(|c| [c.column(), c.row()].map(|f| f.approximately()))
                        .collect::<Vec<_>>()
                );
            };
            found[i] = true;
            let is_whole =
                polygon.len() == 3 && polygon.iter().all(|c| c.scale == Dyadic::whole(1));
            let worst = if is_whole {
                &mut tally.position
            } else {
                &mut tally.cut
            };
            keep_largest(worst, error / 256.0);
            let in_order = if order[1] < order[2] {
                [first, p, q]
            } else {
                [first, q, p]
            };
            assert!(!is_culled(in_order), "triangle {index} looks away");
            let slack = order.map(|i| tolerances[i].depth);
            let facet = Facet::new(drawn.points, order.map(|i| &polygon[i]));
            surfaces.push(Surface {
                facet: facet.expect("it has an area"),
                drawn,
                slack: slack.into_iter().fold(0.0, f64::max),
            });
        }
        // What is not drawn covers nothing, unless it hangs on how a corner is rounded.
        for i in (1..polygon.len().max(1) - 1).filter(|&i| !found[i]) {
            let fan = [0, i, i + 1];
            let points = fan.map(|i| polygon[i].snapped().expect("within the guard band"));
            let sure = fan.iter().all(|&i| {
                let nearest = |f: Fraction, tolerance: f64| {
                    let at = f.approximately();
                    ((at + 0.5) - (at + 0.5).floor() - 0.5).abs() < 1.0 - tolerance
                };
                nearest(polygon[i].column(), tolerances[i].x)
                    && nearest(polygon[i].row(), tolerances[i].y)
            });
            if sure && !is_culled(points) {
                let facet = Facet::new(points, fan.map(|i| &polygon[i])).expect("it has an area");
                let missed = facet.samples(view.width, view.height).next();
                assert_eq!(missed, None, "triangle {index}, {points:?}, is not drawn");
            }
        }
    }
    assert!(rest.is_empty(), "what is drawn last is of no triangle");
    surfaces
}

/// The depth that a surface writes at each of its samples, beside the true one.
fn check_samples(surface: &Surface, view: &View, tally: &mut Tally) {
    let mut written = Vec::new();
    for_each_sample(&surface.drawn.triangle, 0..view.height, |x, y, depth| {
        written.push((y, x, depth));
    });
    written.sort_unstable_by_key(|&(y, x, _)| (y, x));
    let covered: Vec<(i32, i32)> = surface.facet.samples(view.width, view.height).collect();
    let where_written: Vec<(i32, i32)> = written.iter().map(|&(y, x, _)| (x, y)).collect();
    assert_eq!(where_written, covered, "{:?}", surface.facet.points);
    let [a, b, c] = surface.facet.depths;
    let (least, largest) = (a.min(b).min(c), a.max(b).max(c));
    let magnitude = least.abs().max(largest.abs());
    let is_sliver = surface.facet.is_sliver();
    let slack = surface.slack + magnitude * 2_f64.powi(-50);
    let slope = (largest - least) * 2_f64.powi(-23);
    tally.triangles += 1;
    tally.slivers += u64::from(is_sliver);
    tally.samples += written.len() as u64;
    for (y, x, depth) in written {
        let truth = surface.facet.depth_at(x, y);
        let (nearer, step) = (
            truth.taken_from(depth.into()),
            f32_step(truth.approximately()),
        );
        keep_largest(&mut tally.nearer, nearer / step);
        if is_sliver {
            assert!(
                nearer <= step * 0.5 + slack,
                "a sliver is nearer by {nearer:e}"
            );
        } else {
            keep_largest(&mut tally.farther, -nearer / step);
            assert!(
                nearer.abs() <= step * 0.5 + slack + slope,
                "({x}, {y}): {depth:e} is nearer by {nearer:e}, {} steps",
                nearer / step
            );
        }
    }
}

/// The nearest true depth at a sample.
struct Nearest {
    depth: Fraction,
    rounded: f64,
    /// What any of the surfaces there may be off by.
    slack: f64,
}

/// Which is nearer, by rounded numbers where they will do.
fn is_before(a: &Fraction, rounded: f64, b: &Nearest) -> std::cmp::Ordering {
    let difference = rounded - b.rounded;
    if difference.abs() > 1e-12 * rounded.abs().max(b.rounded.abs()) {
        return difference.total_cmp(&0.0);
    }
    a.cmp(&b.depth)
}

/// A picture of the nearest true depths.
struct Picture {
    nearest: Vec<Option<Nearest>>,
    width: usize,
}

impl Picture {
    fn new(view: &View) -> Picture {
        let pixels = (view.width * view.height) as usize;
        Picture {
            nearest: (0..pixels).map(|_| None).collect(),
            width: view.width as usize,
        }
    }

    fn at(&self, x: i32, y: i32) -> &Option<Nearest> {
        &self.nearest[y as usize * self.width + x as usize]
    }

    fn draw(&mut self, surface: &Surface, view: &View) {
        for (x, y) in surface.facet.samples(view.width, view.height) {
            let depth = surface.facet.depth_at(x, y);
            let rounded = depth.approximately();
            let pixel = &mut self.nearest[y as usize * self.width + x as usize];
            let slack = pixel.as_ref().map_or(0.0, |p| p.slack).max(surface.slack);
            match pixel {
                Some(before) if is_before(&depth, rounded, before).is_le() => before.slack = slack,
                _ => {
                    *pixel = Some(Nearest {
                        depth,
                        rounded,
                        slack,
                    });
                }
            }
        }
    }

    /// Whether a surface is as near as anything at one of its samples, or alone there.
    fn shows(&self, surface: &Surface, view: &View) -> bool {
        let mut samples = surface.facet.samples(view.width, view.height);
        samples.any(|(x, y)| {
            self.at(x, y).as_ref().is_none_or(|nearest| {
                let depth = surface.facet.depth_at(x, y);
                is_before(&depth, depth.approximately(), nearest).is_ge()
            })
        })
    }

    /// Coverage is that of the picture, all of it or no more of it, and nothing that tiles keep is nearer than the picture.
    fn check_tiles(&self, tiles: &TileBuffer, all: bool, tally: &mut Tally) {
        let size = tiles.size();
        for (i, nearest) in self.nearest.iter().enumerate() {
            let (x, y) = (i % self.width, i / self.width);
            let (tile, bit) = (y / 8 * size.tiles_across() + x / 8, y % 8 * 8 + x % 8);
            let covered = tiles.coverage()[tile] >> bit & 1 == 1;
            if !covered {
                assert!(!all || nearest.is_none(), "({x}, {y}) is not covered");
                continue;
            }
            let nearest = nearest.as_ref();
            let nearest = nearest.unwrap_or_else(|| panic!("({x}, {y}) is covered by nothing"));
            let part = y % 8 / PART_HEIGHT as usize;
            let stored = if tiles.near_samples()[tile] >> bit & 1 == 1 {
                tiles.near_depths()[tile][part]
            } else {
                tiles.depths()[tile][part]
            };
            let step = f32_step(nearest.rounded);
            let nearer = nearest.depth.taken_from(stored.into());
            keep_largest(&mut tally.stored_nearer, nearer / step);
            assert!(
                nearer <= step * 0.5 + nearest.slack,
                "({x}, {y}): {stored:e} is stored, nearer by {nearer:e}, {} steps",
                nearer / step
            );
        }
    }
}

/// A rectangle on screen around a thing and its least distance, as a user finds them; none if it reaches the near plane.
fn rectangle_around(
    world: &World,
    view: &View,
    thing: &Thing,
) -> Option<([f64; 2], [f64; 2], f64)> {
    let mut all = (
        [f64::INFINITY, f64::NEG_INFINITY],
        [f64::INFINITY, f64::NEG_INFINITY],
    );
    let mut distance = f64::INFINITY;
    let perspective = matches!(
        world.camera.projection(),
        antumbra::view::Projection::Perspective { .. }
    );
    for &position in &thing.positions {
        let corner = view.corner(&thing.place, position);
        if corner.w.sign() <= 0 || !view.is_behind_near(&corner) {
            return None;
        }
        let widen = |range: &mut [f64; 2], at: f64| {
            let spare = at.abs() * 1e-14;
            *range = [range[0].min(at - spare), range[1].max(at + spare)];
        };
        widen(&mut all.0, corner.column().approximately() / 256.0);
        widen(&mut all.1, corner.row().approximately() / 256.0);
        let away = if perspective {
            corner.w.approximately()
        } else {
            -corner.depth.approximately()
        };
        let moved = (thing.terms(position) + view.eye_reach) * POSITION_ERROR;
        distance = distance.min(away - away.abs() * 1e-14 - moved);
    }
    Some((all.0, all.1, distance))
}

/// Asks about things in every way there is.
fn ask(
    world: &World,
    view: &View,
    scene: Option<&Scene>,
    buffer: &OcclusionBuffer,
    owns: &[bool],
    tally: &mut Tally,
    said: &str,
) {
    for (i, thing) in world.things.iter().enumerate() {
        let mut answer = |hidden: bool, how: &str| {
            tally.answer(owns[i], hidden, || format!("{said}, thing {i} by {how}"));
        };
        if let Some(scene) = scene {
            answer(buffer.test_aabb(&scene.bounds()[i]).is_hidden(), "box");
        }
        let (oriented, ball) = worlds::around(&thing.mesh(), &thing.place);
        answer(
            buffer.test_oriented_box(&oriented).is_hidden(),
            "oriented box",
        );
        answer(buffer.test_sphere(&ball).is_hidden(), "ball");
        if let Some((x, y, distance)) = rectangle_around(world, view, thing) {
            answer(
                buffer.test_rectangle(x, y, distance).is_hidden(),
                "rectangle",
            );
        }
    }
}

/// Draws a world, and judges all that comes of it. `culls`: also by a [`Culler`], which takes longer.
pub fn judge(world: &World, level: Level, culls: bool, tally: &mut Tally, said: &str) {
    tally.cases += 1;
    let view = View::new(&world.camera, world.size);
    let all: Vec<Vec<Surface>> = world
        .things
        .iter()
        .map(|thing| surfaces(world, &view, thing, tally))
        .collect();
    let mut picture = Picture::new(&view);
    for (thing, surfaces) in world.things.iter().zip(&all) {
        for surface in surfaces {
            check_samples(surface, &view, tally);
            if thing.drawn {
                picture.draw(surface, &view);
            }
        }
    }
    let owns: Vec<bool> = all
        .iter()
        .map(|surfaces| surfaces.iter().any(|s| picture.shows(s, &view)))
        .collect();
    let scene = world.scene().ok();

    let mut buffer = OcclusionBuffer::new(world.size, world.camera);
    buffer.set_level(level);
    for (i, thing) in world.things.iter().enumerate().filter(|(_, t)| t.drawn) {
        world.draw(&mut buffer, thing);
        if i == world.things.len() / 2 {
            // What is hidden already stays so.
            ask(world, &view, scene.as_ref(), &buffer, &owns, tally, said);
        }
    }
    buffer.finish();
    picture.check_tiles(buffer.tiles(), true, tally);
    ask(world, &view, scene.as_ref(), &buffer, &owns, tally, said);

    let Some(scene) = scene.filter(|_| culls) else {
        return;
    };
    let settings = Settings {
        threads: 1,
        level,
        ..Settings::new(world.size)
    };
    let mut culler = Culler::new(Arc::new(scene), settings).expect("one thread needs no pool");
    let in_frustum = culler.in_frustum(&world.camera);
    for frame in 0..2 {
        let visible = culler.cull(&world.camera).visible;
        for (i, &owns) in owns.iter().enumerate() {
            let hidden = !visible.contains(&(i as u32));
            assert!(
                !owns || in_frustum.contains(&(i as u32)),
                "{said}, thing {i}"
            );
            tally.answer(owns, hidden, || format!("{said}, thing {i}, frame {frame}"));
        }
        if let Some(buffer) = culler.buffer() {
            picture.check_tiles(buffer.tiles(), false, tally);
        }
    }
}
