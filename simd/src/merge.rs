//! Merges strips of a polygon into tiles, as many parts at once as a vector holds: [`crate::tile`]'s rule by selection.

use fearless_simd::prelude::*;
use fearless_simd::{Simd, f32x4};

use crate::PARTS_PER_TILE;
use crate::fill::TileRows;
use crate::strip_masks::{StripMasks, column_of};
use crate::tile::UNCOVERED;

/// Strips that are found before they are merged. What a strip is takes a long chain of operations, and so does merging:
/// taken in turns, each would wait for the other; in runs, several of a kind are under way at once.
pub(crate) const STRIPS: usize = 32;

/// A strip has so many tiles at most, a multiple of what any vector holds: its columns fit a byte.
pub(crate) const TILES_PER_STRIP: u32 = 24;

/// No vector has more lanes of 32 bits.
const MOST_LANES: usize = 16;

/// The depths of a polygon in a row of tiles: see [`crate::part_depth`].
#[derive(Clone, Copy)]
pub(crate) struct RowDepth {
    /// Over the halves of the polygon's first tile, twice.
    pub(crate) halves: [f32; 2 * PARTS_PER_TILE],
    /// What one column of tiles adds.
    pub(crate) per_tile: f32,
    pub(crate) farthest: f32,
    pub(crate) nearest: f32,
    /// The polygon's first column of tiles.
    pub(crate) first_tile: u32,
}

/// Eight rows of samples of a polygon, ready to be merged.
#[derive(Clone, Copy)]
pub(crate) struct Strip {
    pub(crate) depth: RowDepth,
    /// A byte for each row, the lowest for the first: the first covered column, counted from tile `from`.
    pub(crate) first: u64,
    /// The first column after it that is not covered.
    pub(crate) end: u64,
    /// Where the row of tiles begins.
    pub(crate) row: u32,
    /// The first tile, with a vector's tiles from it on in the row.
    pub(crate) from: u32,
    /// The last tile.
    pub(crate) last: u32,
    /// Whose it is: [`SpanBlock`](crate::spans::SpanBlock).
    pub(crate) owner: u32,
}

impl Strip {
    pub(crate) const EMPTY: Strip = Strip {
        depth: RowDepth {
            halves: [0.0; 2 * PARTS_PER_TILE],
            per_tile: 0.0,
            farthest: 0.0,
            nearest: 0.0,
            first_tile: 0,
        },
        first: 0,
        end: 0,
        row: 0,
        from: 0,
        last: 0,
        owner: 0,
    };
}

/// Strips that wait to be merged.
pub(crate) struct Waiting {
    pub(crate) strips: [Strip; STRIPS],
    pub(crate) count: usize,
}

/// The parts of [`TileRows`], whose slices have the same length, and the compiler can see it: one comparison is enough to know
/// that a range lies within each of them. And what their owners gain.
pub(crate) struct Parts<'a> {
    coverage: &'a mut [u32],
    far: &'a mut [f32],
    near_samples: &'a mut [u32],
    near: &'a mut [f32],
    gains: &'a mut [u32],
}

impl<'a> Parts<'a> {
    #[inline(always)]
    pub(crate) fn new(rows: &'a mut TileRows<'_>) -> Parts<'a> {
        Parts {
            coverage: bytemuck::cast_slice_mut(rows.coverage),
            far: rows.far.as_flattened_mut(),
            near_samples: bytemuck::cast_slice_mut(rows.near_samples),
            near: rows.near.as_flattened_mut(),
            gains: rows.gains,
        }
        .of_same_length()
    }

    #[inline(always)]
    fn of_same_length(self) -> Parts<'a> {
        let count = self.coverage.len();
        Parts {
            coverage: self.coverage,
            far: &mut self.far[..count],
            near_samples: &mut self.near_samples[..count],
            near: &mut self.near[..count],
            gains: self.gains,
        }
    }

    #[inline(always)]
    pub(crate) fn borrow(&mut self) -> Parts<'_> {
        Parts {
            coverage: &mut *self.coverage,
            far: &mut *self.far,
            near_samples: &mut *self.near_samples,
            near: &mut *self.near,
            gains: &mut *self.gains,
        }
    }

    /// Counts what an owner gains.
    #[inline(always)]
    pub(crate) fn count(&mut self, owner: u32, gain: u32) {
        if let Some(counted) = self.gains.get_mut(owner as usize) {
            *counted += gain;
        }
    }
}

/// What stays the same from strip to strip. A vector holds the parts of `S::f64s::LEN` tiles.
pub(crate) struct Merger<S: Simd> {
    simd: S,
    /// The last tile of a row from which on there is a vector's.
    pub(crate) last_from: u32,
    masks: StripMasks<S>,
    /// The tiles of the parts, counted from the first.
    part_tile: S::f32s,
}

impl<S: Simd> Merger<S> {
    const TILES: u32 = S::f64s::LEN as u32;

    #[inline(always)]
    pub(crate) fn new(simd: S, last_from: u32) -> Self {
        Merger {
            simd,
            last_from,
            masks: StripMasks::new(simd),
            part_tile: S::f32s::from_fn(simd, |i| (i / PARTS_PER_TILE) as f32),
        }
    }

    /// Merges a strip. Returns how many samples it took over.
    #[inline(always)]
    pub(crate) fn merge_strip(&self, parts: &mut Parts<'_>, strip: &Strip) -> u32 {
        let depths = Depths::new(self.simd, &strip.depth);
        let mut first = self.masks.ends(strip.first);
        let end = self.masks.ends(strip.end);
        let mut start = strip.from;
        let mut columns = self.masks.columns_from(0);
        let mut number = self.numbers(&strip.depth, start);
        let mut gain = 0;
        loop {
            let mask = self.masks.between(first, end, columns);
            gain += self.merge(parts, mask, depths.of(number), strip.row + start);
            if start + Self::TILES > strip.last {
                return gain;
            }
            if start + Self::TILES <= self.last_from {
                start += Self::TILES;
                columns += column_of(Self::TILES);
                number += Self::TILES as f32;
            } else {
                // At the end of the row, some tiles of the vector have had theirs.
                first = self
                    .masks
                    .not_before(first, start + Self::TILES - strip.from);
                let step = self.last_from - start;
                start += step;
                columns += column_of(step);
                number += step as f32;
            }
        }
    }

    /// The tiles of the parts of a vector, counted from the polygon's first.
    #[inline(always)]
    fn numbers(&self, depth: &RowDepth, start: u32) -> S::f32s {
        self.part_tile + (start as i32 - depth.first_tile as i32) as f32
    }

    /// Skips vectors of a strip's tiles that are covered and nowhere farther than the polygon's nearest corner. Returns the
    /// first tile that is left, and whether its vector is covered.
    #[inline(always)]
    pub(crate) fn skip_behind_nearest(
        &self,
        parts: &Parts<'_>,
        nearest: f32,
        row: u32,
        [mut tile, last]: [u32; 2],
    ) -> (u32, bool) {
        let nearest = S::f32s::splat(self.simd, nearest);
        while tile <= last {
            let at = row + tile.min(self.last_from);
            if !self.is_covered(parts, at) {
                return (tile, false);
            }
            if !self.is_behind(parts, nearest, at) {
                return (tile, true);
            }
            tile += Self::TILES;
        }
        (tile, false)
    }

    /// Skips vectors of tiles that are covered and nowhere farther than the polygon is there. Returns the first tile that is
    /// left.
    #[inline(always)]
    pub(crate) fn skip_behind(
        &self,
        parts: &Parts<'_>,
        depth: &RowDepth,
        row: u32,
        [mut tile, last]: [u32; 2],
    ) -> u32 {
        let depths = Depths::new(self.simd, depth);
        while tile <= last {
            let start = tile.min(self.last_from);
            let depth = depths.of(self.numbers(depth, start));
            if !self.is_covered(parts, row + start) || !self.is_behind(parts, depth, row + start) {
                break;
            }
            tile += Self::TILES;
        }
        tile
    }

    /// Whether the tiles from `tile` are all covered.
    #[inline(always)]
    fn is_covered(&self, parts: &Parts<'_>, tile: u32) -> bool {
        let at = tile as usize * PARTS_PER_TILE;
        let coverage = S::u32s::from_slice(self.simd, &parts.coverage[at..at + S::u32s::LEN]);
        (!coverage).simd_eq(S::u32s::splat(self.simd, 0)).all_true()
    }

    /// Whether no part of the tiles from `tile` is farther than these depths.
    #[inline(always)]
    fn is_behind(&self, parts: &Parts<'_>, depth: S::f32s, tile: u32) -> bool {
        let at = tile as usize * PARTS_PER_TILE;
        S::f32s::from_slice(self.simd, &parts.far[at..at + S::u32s::LEN])
            .simd_ge(depth)
            .all_true()
    }

    /// Merges the samples `mask`, in parts at these depths, into the tiles from `tile`. Returns how many samples it took over.
    #[inline(always)]
    fn merge(&self, parts: &mut Parts<'_>, mask: S::u32s, depth: S::f32s, tile: u32) -> u32 {
        let simd = self.simd;
        let at = tile as usize * PARTS_PER_TILE;
        let range = at..at + S::u32s::LEN;
        let none = S::u32s::splat(simd, 0);
        let coverage = S::u32s::from_slice(simd, &parts.coverage[range.clone()]);
        if coverage.simd_eq(none).all_true() {
            // Nothing but this polygon, or nothing at all.
            mask.store_slice(&mut parts.coverage[range.clone()]);
            let uncovered = S::f32s::splat(simd, UNCOVERED);
            let depth = mask.simd_eq(none).select(uncovered, depth);
            depth.store_slice(&mut parts.far[range]);
            return Self::count(mask);
        }
        let far = S::f32s::from_slice(simd, &parts.far[range.clone()]);
        let near_samples = S::u32s::from_slice(simd, &parts.near_samples[range.clone()]);
        let near = S::f32s::from_slice(simd, &parts.near[range.clone()]);
        let far_samples = coverage & !near_samples;
        // Samples that a layer shows nearer, or as near.
        let hidden = of_parts::<S>(far.simd_ge(depth), far_samples)
            | of_parts::<S>(near.simd_ge(depth), near_samples);
        let new = mask & !hidden;
        let is_none = new.simd_eq(none);
        if is_none.all_true() {
            return 0;
        }
        let far_samples = far_samples & !new;
        let near_samples = near_samples & !new;
        (coverage | mask).store_slice(&mut parts.coverage[range.clone()]);
        if (far_samples | near_samples).simd_eq(none).all_true() {
            // Nothing but this polygon is left, or nothing at all.
            none.store_slice(&mut parts.near_samples[range.clone()]);
            let depth = is_none.select(far, depth);
            depth.store_slice(&mut parts.far[range]);
            return Self::count(new);
        }
        let layers = [
            Layer::new(far_samples, far),
            Layer::new(near_samples, near),
            Layer::new(new, depth),
        ];
        let (far, near) = Layer::<S>::two_of_three(layers);
        near.samples
            .store_slice(&mut parts.near_samples[range.clone()]);
        far.store_slice(&mut parts.far[range.clone()]);
        near.depth.store_slice(&mut parts.near[range]);
        Self::count(new)
    }

    /// How many samples there are.
    #[inline(always)]
    fn count(samples: S::u32s) -> u32 {
        let mut parts = [0_u64; MOST_LANES / 2];
        samples.store_slice(&mut bytemuck::cast_slice_mut(&mut parts)[..S::u32s::LEN]);
        let mut count = 0;
        for part in &parts[..S::u32s::LEN / 2] {
            count += part.count_ones();
        }
        count
    }
}

/// Merges the strips that wait. A function of its own, since it is called from two places.
#[inline(always)]
pub(crate) fn merge_strips<S: Simd>(
    simd: S,
    mut parts: Parts<'_>,
    last_from: u32,
    waiting: &mut Waiting,
) {
    simd.vectorize(
        #[inline(always)]
        || {
            let mut parts = parts.borrow().of_same_length();
            let merger = Merger::new(simd, last_from);
            for strip in &waiting.strips[..waiting.count] {
                let gain = merger.merge_strip(&mut parts, strip);
                parts.count(strip.owner, gain);
            }
            waiting.count = 0;
        },
    );
}

/// [`RowDepth`] in vectors.
struct Depths<S: Simd> {
    halves: S::f32s,
    per_tile: f32,
    farthest: S::f32s,
    nearest: S::f32s,
}

impl<S: Simd> Depths<S> {
    #[inline(always)]
    fn new(simd: S, depth: &RowDepth) -> Self {
        Depths {
            halves: S::f32s::block_splat(f32x4::load_array(simd, depth.halves)),
            per_tile: depth.per_tile,
            farthest: S::f32s::splat(simd, depth.farthest),
            nearest: S::f32s::splat(simd, depth.nearest),
        }
    }

    /// The depths over parts of these tiles, counted from the polygon's first.
    #[inline(always)]
    fn of(&self, number: S::f32s) -> S::f32s {
        (self.halves + number * self.per_tile)
            .max(self.farthest)
            .min(self.nearest)
    }
}

/// The samples of the parts that a mask names. (As floats: an AND, where integers take two instructions.)
#[inline(always)]
fn of_parts<S: Simd>(parts: S::mask32s, samples: S::u32s) -> S::u32s {
    let none = S::f32s::splat(samples.token(), 0.0);
    parts.select(samples.bitcast::<S::f32s>(), none).bitcast()
}

/// A layer of several parts: see [`crate::tile`].
#[derive(Clone, Copy)]
struct Layer<S: Simd> {
    samples: S::u32s,
    depth: S::f32s,
}

impl<S: Simd> Layer<S> {
    #[inline(always)]
    fn new(samples: S::u32s, depth: S::f32s) -> Layer<S> {
        let simd = samples.token();
        let uncovered = S::f32s::splat(simd, UNCOVERED);
        let none = S::u32s::splat(simd, 0);
        Layer {
            samples,
            depth: samples.simd_eq(none).select(uncovered, depth),
        }
    }

    /// The samples where the layer is nearer than this.
    #[inline(always)]
    fn nearer_than(&self, depth: S::f32s) -> S::u32s {
        of_parts::<S>(self.depth.simd_gt(depth), self.samples)
    }

    /// What three layers become: the depth of the far one, and the near one. [`crate::tile`]'s rule, by selection.
    #[inline(always)]
    fn two_of_three([far, near, new]: [Layer<S>; 3]) -> (S::f32s, Layer<S>) {
        let (farther, nearer) = (far.depth.min(near.depth), far.depth.max(near.depth));
        let a = farther.min(new.depth);
        let b = farther.max(nearer.min(new.depth));
        let c = nearer.max(new.depth);
        let farther_two_are_closer = ((b - a) * c.abs()).simd_le((c - b) * a.abs());
        let are_three = c.simd_lt(S::f32s::splat(c.token(), UNCOVERED));
        let last_of_far = (are_three & farther_two_are_closer).select(b, a);
        let near = Layer {
            samples: far.nearer_than(last_of_far)
                | near.nearer_than(last_of_far)
                | new.nearer_than(last_of_far),
            depth: b.simd_gt(last_of_far).select(b, c),
        };
        (a, near)
    }
}
