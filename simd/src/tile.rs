//! Merges a polygon into a tile: coverage, and two layers of conservative depth for each part.
//!
//! A part's depth is the farthest depth of the nearest occluder surfaces over its covered samples (HOM §6.4), or
//! farther. One value a part forgets too much: where a near and a far surface share a part, the far one's depth would
//! have to stand for both, and a third surface in front of the far one could not mend it. So a part keeps its covered
//! samples in two layers, each with a depth than which none of its samples is farther:
//!
//! ```text
//!   far layer    samples covered and not in `near_samples`    depth `far`     the part's depth
//!   near layer   samples in `near_samples`                    depth `near`    nearer than `far`
//! ```
//!
//! A polygon takes over the samples that it covers in layers farther than itself, and those not yet covered: the
//! surface there is now not farther than the polygon. Layers nearer than the polygon keep theirs. The polygon's
//! samples are a third layer; if none of the three is empty, the two that lie closest to each other along the view
//! become one, at the farther depth of the two. Depths are the larger the nearer.

use crate::coverage::PART_MASKS;
use crate::spans::SpanPolygon;
use crate::{PART_HEIGHT, PARTS_PER_TILE, TILE_SIZE};

/// The depth of a layer without samples: nearest possible, so that the depth test ignores a part without coverage
/// (HOM §6.4) and the overlap test decides.
pub const UNCOVERED: f32 = f32::INFINITY;

/// One tile's coverage and layers.
#[derive(Debug)]
pub struct TileMut<'a> {
    /// The covered samples.
    pub coverage: &'a mut u64,
    /// The depths of the parts: of their far layers.
    pub far: &'a mut [f32; PARTS_PER_TILE],
    /// The samples of the near layers.
    pub near_samples: &'a mut u64,
    /// The depths of the near layers.
    pub near: &'a mut [f32; PARTS_PER_TILE],
}

/// Merges the samples `mask` of a polygon, all in tile (`tile_x`, `tile_y`), into the tile. Returns how many samples it
/// took over.
#[inline]
pub fn merge(tile: TileMut<'_>, mask: u64, polygon: &SpanPolygon, tile_x: i32, tile_y: i32) -> u32 {
    let mut gain = 0;
    for (part, part_mask) in PART_MASKS.into_iter().enumerate() {
        let samples = mask & part_mask;
        if samples == 0 {
            continue;
        }
        let y = tile_y * TILE_SIZE + part as i32 * PART_HEIGHT;
        // No covered sample lies outside the polygon's own extent.
        let rows = [y.max(polygon.y[0]), (y + PART_HEIGHT - 1).min(polygon.y[1])];
        let depth = polygon.depth.over(tile_x, rows);
        let layer = |samples, depth| Layer { samples, depth };
        let near_samples = *tile.near_samples & part_mask;
        let far_samples = *tile.coverage & part_mask & !near_samples;
        let layers = [
            layer(far_samples, tile.far[part]),
            layer(near_samples, tile.near[part]),
        ];
        let new = new_of(layers, layer(samples, depth));
        if new.samples == 0 {
            continue;
        }
        gain += new.samples.count_ones();
        let [far, near] = merge_layer(layers, new);
        tile.far[part] = far.depth;
        tile.near[part] = near.depth;
        *tile.near_samples = *tile.near_samples & !part_mask | near.samples;
    }
    *tile.coverage |= mask;
    gain
}

/// Samples, and a depth than which none of them is farther.
#[derive(Clone, Copy, Debug, PartialEq)]
struct Layer {
    samples: u64,
    depth: f32,
}

const EMPTY: Layer = Layer {
    samples: 0,
    depth: UNCOVERED,
};

/// What is left of a third layer beside a part's two that are nearer, or as near.
#[inline]
fn new_of(layers: [Layer; 2], mut new: Layer) -> Layer {
    for layer in layers {
        if layer.depth >= new.depth {
            new.samples &= !layer.samples;
        }
    }
    new
}

/// Merges what is new of a third layer ([`new_of`]), not nothing, into a part's far and near ones; none that is not empty is
/// farther than the far one.
#[inline]
fn merge_layer([mut far, mut near]: [Layer; 2], new: Layer) -> [Layer; 2] {
    far.samples &= !new.samples;
    near.samples &= !new.samples;
    let layers = [far, near, new].map(|layer| if layer.samples == 0 { EMPTY } else { layer });
    // Farthest first, empty ones last.
    let mut depths = layers.map(|layer| layer.depth);
    depths.sort_unstable_by(f32::total_cmp);
    let [a, b, c] = depths;
    // Depth is near / distance: the gap between distances 1/a and 1/b is (b − a) / (a·b). Both sides are multiplied by
    // a·b·c. For depths that are −distance it is a guess; any choice is safe.
    let farther_two_are_closer = (b - a) * c.abs() <= (c - b) * a.abs();
    let last_of_far = if c < UNCOVERED && farther_two_are_closer {
        b
    } else {
        a
    };
    let [mut far, mut near] = [EMPTY; 2];
    for layer in layers {
        if layer.depth > last_of_far {
            near.samples |= layer.samples;
        } else {
            far.samples |= layer.samples;
        }
    }
    far.depth = a;
    near.depth = if b > last_of_far { b } else { c };
    [far, near]
}

#[cfg(test)]
mod tests {
    use super::*;

    fn layer(samples: u64, depth: f32) -> Layer {
        Layer { samples, depth }
    }

    fn merged(layers: [Layer; 2], third: Layer) -> [Layer; 2] {
        let new = new_of(layers, third);
        if new.samples == 0 {
            layers
        } else {
            merge_layer(layers, new)
        }
    }

    #[test]
    fn a_part_keeps_the_farthest_of_the_nearest_surfaces() {
        let (near, far) = (0.75, 0.25);
        let one = merged([EMPTY, EMPTY], layer(0b11, far));
        assert_eq!(one, [layer(0b11, far), EMPTY]);
        // A nearer surface in front of all of it moves the part nearer; in front of half of it, it does not.
        assert_eq!(merged(one, layer(0b11, near)), [layer(0b11, near), EMPTY]);
        let half = merged(one, layer(0b01, near));
        assert_eq!(half, [layer(0b10, far), layer(0b01, near)]);
        // Until the other half follows.
        assert_eq!(
            merged(half, layer(0b10, 0.5)),
            [layer(0b10, 0.5), layer(0b01, near)]
        );
        // A farther one behind it changes nothing; beside it, it moves the part away.
        let front = merged([EMPTY, EMPTY], layer(0b11, near));
        assert_eq!(merged(front, layer(0b01, far)), front);
        assert_eq!(
            merged(front, layer(0b110, far)),
            [layer(0b100, far), layer(0b11, near)]
        );
    }

    #[test]
    fn of_three_layers_the_two_closest_become_one_at_the_farther_depth() {
        // Distances 10, 2 and 1.
        let two = merged(merged([EMPTY, EMPTY], layer(0b1, 0.1)), layer(0b10, 0.5));
        assert_eq!(
            merged(two, layer(0b100, 1.0)),
            [layer(0b1, 0.1), layer(0b110, 0.5)]
        );
        // Distances 10, 9 and 1.
        let two = merged(
            merged([EMPTY, EMPTY], layer(0b1, 0.1)),
            layer(0b10, 1.0 / 9.0),
        );
        assert_eq!(
            merged(two, layer(0b100, 1.0)),
            [layer(0b11, 0.1), layer(0b100, 1.0)]
        );
    }

    #[test]
    fn no_order_of_merging_puts_a_part_nearer_than_a_sample() {
        // Every sequence of four surfaces over three samples, each at one of three depths.
        let surfaces: Vec<Layer> = (1..8)
            .flat_map(|samples| [0.25, 0.5, 0.75].map(|depth| layer(samples, depth)))
            .collect();
        let count = surfaces.len();
        for sequence in 0..count.pow(4) {
            let mut part = [EMPTY, EMPTY];
            let mut exact = [f32::NEG_INFINITY; 3];
            for step in 0..4 {
                let surface = surfaces[sequence / count.pow(step) % count];
                part = merged(part, surface);
                for (bit, depth) in exact.iter_mut().enumerate() {
                    if surface.samples >> bit & 1 == 1 {
                        *depth = depth.max(surface.depth);
                    }
                }
            }
            let [far, near] = part;
            assert_eq!(far.samples & near.samples, 0);
            assert!(near.samples == 0 || far.samples != 0 && far.depth < near.depth);
            for (bit, depth) in exact.into_iter().enumerate() {
                let of = |l: Layer| (l.samples >> bit & 1 == 1).then_some(l.depth);
                let bound = of(far).or(of(near));
                assert_eq!(bound.is_some(), depth > f32::NEG_INFINITY);
                assert!(bound.is_none_or(|b| b <= depth));
            }
        }
    }
}
