//! A look at a box through one sample: most boxes that can be seen show themselves at once.
//!
//! The ray through a sample enters a box at some depth. If nothing is drawn at the sample, or nothing that is strictly
//! nearer, the box is not hidden there, and no closer question about its outline and faces ([`crate::outline`],
//! [`crate::faces`]) can find that it is: a sample whose ray meets the box is inside the outline, and the faces' bound is
//! not farther than the box itself. Both are grown by far more than what a ray is off by, which is a few 2⁻⁵⁰; so a look
//! saves the closer question without changing its answer. Should it err, the box is taken to be visible.

use fearless_simd::prelude::*;
use fearless_simd::{Simd, dispatch};

use crate::closer::LayeredTiles;
use crate::order::{greater, largest, least, lesser};
use crate::query::Rectangle;
use crate::vertex::ScreenTransform;
use crate::{Level, SUBPIXELS};

type Vector = [f64; 3];

/// The rays of a picture's samples, in the coordinates that a transform to the screen takes: all that is kept of them is
/// linear in the column and the row, at (0, 0), for one column more, for one row more.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Rays {
    /// None if it is where coordinates start, for every ray.
    origin: Option<[Vector; 3]>,
    direction: [Vector; 3],
    /// D and W (see [`ScreenTransform`]) at the origin, and what they grow by along the direction.
    depth: [Vector; 2],
    w: [Vector; 2],
}

/// A box of any orientation as three pairs of planes: points between `low` and `high` along each normal.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Slabs {
    /// Perpendicular to the planes, of any length; none for those of a box along the axes, of length 1.
    pub normals: Option<[Vector; 3]>,
    /// A point of the first plane times the normal.
    pub low: Vector,
    /// A point of the second.
    pub high: Vector,
}

#[inline]
fn dot(a: Vector, b: Vector) -> f64 {
    (a[0] * b[0] + a[1] * b[1]) + a[2] * b[2]
}

#[inline]
fn cross(a: Vector, b: Vector) -> Vector {
    [
        a[1] * b[2] - a[2] * b[1],
        a[2] * b[0] - a[0] * b[2],
        a[0] * b[1] - a[1] * b[0],
    ]
}

#[inline]
fn scaled(v: Vector, by: f64) -> Vector {
    v.map(|c| c * by)
}

#[inline]
fn sum(a: Vector, b: Vector) -> Vector {
    [a[0] + b[0], a[1] + b[1], a[2] + b[2]]
}

fn linear(row: &[f64; 4]) -> Vector {
    [row[0], row[1], row[2]]
}

impl Rays {
    /// The rays of the samples of a screen. W is 1 all over, or nothing has a constant: the eye is where coordinates
    /// start.
    pub fn new(t: &ScreenTransform) -> Rays {
        let (x, y, w) = (linear(&t.x), linear(&t.y), linear(&t.w));
        let per_sample = f64::from(SUBPIXELS);
        let half = per_sample * 0.5;
        // A point is on the ray of (X, Y) where x − X·w and y − Y·w are both 0: along the cross product of the two.
        let column = scaled(cross(w, y), -per_sample);
        let row = scaled(cross(x, w), -per_sample);
        let middle = sum(cross(x, y), scaled(sum(column, row), half / per_sample));
        let along = cross(x, y);
        let length_squared = dot(along, along);
        let across = scaled(cross(y, along), per_sample / length_squared);
        let down = scaled(cross(along, x), per_sample / length_squared);
        let to_samples = |constant: f64| (half - constant) / per_sample;
        let origin = (t.w[3] != 0.0).then(|| {
            let first = sum(
                scaled(across, to_samples(t.x[3])),
                scaled(down, to_samples(t.y[3])),
            );
            [first, across, down]
        });
        // Away from the eye: the way W grows or, where it does not, the depth falls.
        let ahead = dot(w, middle) - dot(linear(&t.depth), middle);
        let direction = [middle, column, row].map(|v| scaled(v, ahead.signum()));
        let along_rays = |row: &[f64; 4]| {
            let at_origin = origin.unwrap_or_default().map(|v| dot(linear(row), v));
            [
                sum(at_origin, [row[3], 0.0, 0.0]),
                direction.map(|v| dot(linear(row), v)),
            ]
        };
        Rays {
            origin,
            direction,
            depth: along_rays(&t.depth),
            w: along_rays(&t.w),
        }
    }
}

/// The ray through a sample, ready to be asked about many boxes along the axes. The answers are not exact: the ray or a depth may
/// miss by a few roundings.
#[derive(Clone, Copy, Debug)]
pub struct Ray {
    /// A point of it: the eye, if it has one.
    pub(crate) origin: Vector,
    /// Where it begins, in multiples of the direction: at the eye, or without end.
    pub(crate) start: f64,
    /// One over the direction.
    pub(crate) time: Vector,
    /// D and W at the origin, and along the direction.
    pub(crate) depth: [f64; 2],
    pub(crate) w: [f64; 2],
}

impl Ray {
    /// That of a sample; `eye` is where coordinates start for rays that all begin there.
    pub fn through(rays: &Rays, eye: Vector, [column, row]: [i32; 2]) -> Ray {
        let (column, row) = (f64::from(column), f64::from(row));
        let at = |[first, across, down]: [f64; 3]| first + (across * column + down * row);
        let [a, b, c] = rays.direction;
        let (origin, start) = match rays.origin {
            None => (eye, 0.0),
            Some([first, across, down]) => {
                let origin =
                    std::array::from_fn(|axis| at([first[axis], across[axis], down[axis]]));
                (sum(eye, origin), f64::NEG_INFINITY)
            }
        };
        Ray {
            origin,
            start,
            // Along a face of a box it passes through it nowhere, or from minus to plus infinity; NaN is neither.
            time: std::array::from_fn(|axis| 1.0 / at([a[axis], b[axis], c[axis]])),
            depth: rays.depth.map(at),
            w: rays.w.map(at),
        }
    }

    /// Whether it may meet something between two corners of a box that is nearer than a depth.
    #[inline]
    pub fn may_be_before(&self, low: Vector, high: Vector, depth: f64) -> bool {
        let (mut entry, mut exit) = (self.start, f64::INFINITY);
        for axis in 0..3 {
            let low = (low[axis] - self.origin[axis]) * self.time[axis];
            let high = (high[axis] - self.origin[axis]) * self.time[axis];
            let (first, last) = if low < high { (low, high) } else { (high, low) };
            entry = greater(first, entry);
            exit = lesser(last, exit);
        }
        let [d, w] = [self.depth, self.w].map(|[start, along]| start + along * entry);
        entry <= exit && (entry == self.start || d >= depth * w)
    }
}

/// The rays as a box's planes see them.
struct Crossings<'a> {
    rays: &'a Rays,
    slabs: &'a Slabs,
    /// The rays' origins times each normal; none if all are 0.
    start: Option<&'a [Vector; 3]>,
    /// Their directions times each normal.
    speed: &'a [Vector; 3],
}

impl Crossings<'_> {
    /// The depth at which the ray through a sample meets the planes that it enters the box by; none if it misses the box,
    /// or runs along one of its faces.
    #[inline]
    fn entry_depth(&self, column: f64, row: f64) -> Option<f64> {
        let at = |first: f64, across: f64, down: f64| first + (across * column + down * row);
        let (mut entry, mut exit) = (f64::NEG_INFINITY, f64::INFINITY);
        for axis in 0..3 {
            let of = |v: &[Vector; 3]| at(v[0][axis], v[1][axis], v[2][axis]);
            let (start, speed) = (self.start.map_or(0.0, of), of(self.speed));
            if speed == 0.0 {
                return None;
            }
            let time = 1.0 / speed;
            let low = (self.slabs.low[axis] - start) * time;
            let high = (self.slabs.high[axis] - start) * time;
            let (first, last) = if low < high { (low, high) } else { (high, low) };
            entry = greater(entry, first);
            exit = lesser(exit, last);
        }
        // False for a NaN.
        let meets = entry <= exit;
        if !meets {
            return None;
        }
        let at_entry = |of: &[Vector; 2]| {
            let [origin, direction] = of.map(|[first, across, down]| at(first, across, down));
            origin + direction * entry
        };
        Some(at_entry(&self.rays.depth) / at_entry(&self.rays.w))
    }

    /// [`Crossings::entry_depth`] of several samples; lanes of no meaning where the mask says so.
    #[inline(always)]
    fn entry_depths<S: Simd>(
        &self,
        simd: S,
        column: S::f64s,
        row: S::f64s,
    ) -> (S::f64s, S::mask64s) {
        let zero = S::f64s::splat(simd, 0.0);
        let mut entry = S::f64s::splat(simd, f64::NEG_INFINITY);
        let mut exit = S::f64s::splat(simd, f64::INFINITY);
        let mut is_parallel = zero.simd_lt(zero);
        for axis in 0..3 {
            let [first, across, down] = self.speed;
            let speed = column * across[axis] + row * down[axis] + first[axis];
            is_parallel |= speed.simd_eq(zero);
            let time = S::f64s::splat(simd, 1.0) / speed;
            let mut low = S::f64s::splat(simd, self.slabs.low[axis]);
            let mut high = S::f64s::splat(simd, self.slabs.high[axis]);
            if let Some([first, across, down]) = self.start {
                let start = column * across[axis] + row * down[axis] + first[axis];
                low -= start;
                high -= start;
            }
            let (low, high) = (low * time, high * time);
            let is_upwards = low.simd_lt(high);
            let (first, last) = (is_upwards.select(low, high), is_upwards.select(high, low));
            entry = largest::<S>(entry, first);
            exit = least::<S>(exit, last);
        }
        let meets = entry.simd_le(exit) & !is_parallel;
        let depth = at_entry::<S>(&self.rays.depth, column, row, entry);
        let w = at_entry::<S>(&self.rays.w, column, row, entry);
        (depth / w, meets)
    }
}

#[inline(always)]
fn at_entry<S: Simd>(
    [origin, direction]: &[Vector; 2],
    column: S::f64s,
    row: S::f64s,
    entry: S::f64s,
) -> S::f64s {
    let origin = column * origin[1] + row * origin[2] + origin[0];
    let direction = column * direction[1] + row * direction[2] + direction[0];
    direction * entry + origin
}

/// Asks something about rays as a box's planes see them.
#[inline(always)]
fn with_crossings<R>(rays: &Rays, slabs: &Slabs, ask: impl Fn(&Crossings<'_>) -> R) -> R {
    let ask = |start: Option<&[Vector; 3]>, speed: &[Vector; 3]| {
        ask(&Crossings {
            rays,
            slabs,
            start,
            speed,
        })
    };
    let (origin, direction) = (rays.origin.as_ref(), &rays.direction);
    match &slabs.normals {
        None => ask(origin, direction),
        Some(normals) => {
            let along = |v: &[Vector; 3]| v.map(|v| normals.map(|normal| dot(normal, v)));
            ask(origin.map(along).as_ref(), &along(direction))
        }
    }
}

/// Where a box is looked at, in eighths of its rectangle from left to right, and from top to bottom; as many as the
/// longest vector has lanes.
const LOOKS: [[f64; 8]; 2] = [
    [4.0, 2.0, 6.0, 2.0, 6.0, 4.0, 1.0, 7.0],
    [4.0, 2.0, 6.0, 6.0, 2.0, 1.0, 4.0, 4.0],
];

/// Whether a box shows itself at one of a few samples of its rectangle, which lies within the picture.
pub fn is_seen(
    level: Level,
    rays: &Rays,
    slabs: &Slabs,
    tiles: LayeredTiles<'_>,
    rectangle: Rectangle,
) -> bool {
    with_crossings(rays, slabs, |crossings| {
        is_seen_by(level, crossings, tiles, rectangle)
    })
}

fn is_seen_by(
    level: Level,
    crossings: &Crossings<'_>,
    tiles: LayeredTiles<'_>,
    Rectangle { x, y, .. }: Rectangle,
) -> bool {
    match level.token() {
        None => (0..LOOKS[0].len()).any(|look| {
            let (column, row) = (looked_at(x, LOOKS[0][look]), looked_at(y, LOOKS[1][look]));
            crossings
                .entry_depth(column, row)
                .is_some_and(|depth| !tiles.is_nearer(column as i32, row as i32, depth as f32))
        }),
        Some(token) => {
            dispatch!(token, simd => is_seen_by_vector(simd, crossings, tiles, x, y))
        }
    }
}

/// The samples at which a box is looked at: its rectangle's, in places that are always the same.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Looks {
    /// Bit `i` is set if the box is seen at sample `i`.
    pub seen: u8,
    /// The samples' columns.
    pub columns: [f64; 8],
    /// The samples' rows.
    pub rows: [f64; 8],
    /// The depths at which their rays enter the box; of no meaning where it is not seen.
    pub depths: [f64; 8],
}

/// At which of a few samples of its rectangle, which lies within the picture, a box shows itself.
pub fn looks(
    level: Level,
    rays: &Rays,
    slabs: &Slabs,
    tiles: LayeredTiles<'_>,
    rectangle: Rectangle,
) -> Looks {
    with_crossings(rays, slabs, |crossings| {
        looks_by(level, crossings, tiles, rectangle)
    })
}

fn looks_by(
    level: Level,
    crossings: &Crossings<'_>,
    tiles: LayeredTiles<'_>,
    Rectangle { x, y, .. }: Rectangle,
) -> Looks {
    let mut looks = Looks {
        seen: 0,
        columns: LOOKS[0].map(|look| looked_at(x, look)),
        rows: LOOKS[1].map(|look| looked_at(y, look)),
        depths: [0.0; 8],
    };
    let meets = match level.token() {
        None => (0..LOOKS[0].len()).fold(0, |meets, look| {
            let depth = crossings.entry_depth(looks.columns[look], looks.rows[look]);
            looks.depths[look] = depth.unwrap_or(0.0);
            meets | u8::from(depth.is_some()) << look
        }),
        Some(token) => dispatch!(token, simd => entries(simd, crossings, &mut looks)),
    };
    let mut left = meets;
    while left != 0 {
        let i = left.trailing_zeros() as usize;
        left &= left - 1;
        let (column, row) = (whole(looks.columns[i]), whole(looks.rows[i]));
        if !tiles.is_nearer(column, row, looks.depths[i] as f32) {
            looks.seen |= 1 << i;
        }
    }
    looks
}

/// The samples whose rays meet the box: a bit each.
#[inline(always)]
fn entries<S: Simd>(simd: S, crossings: &Crossings<'_>, looks: &mut Looks) -> u8 {
    let lanes = S::f64s::LEN;
    let mut all = 0;
    for first in (0..LOOKS[0].len()).step_by(lanes) {
        let column = S::f64s::from_slice(simd, &looks.columns[first..first + lanes]);
        let row = S::f64s::from_slice(simd, &looks.rows[first..first + lanes]);
        let (depth, meets) = crossings.entry_depths::<S>(simd, column, row);
        depth.store_slice(&mut looks.depths[first..first + lanes]);
        all |= meets.to_bitmask() << first;
    }
    all as u8
}

/// The column or row so many eighths into a range.
#[inline(always)]
fn looked_at(range: [i32; 2], eighths: f64) -> f64 {
    (f64::from(range[1] - range[0]) * (eighths * 0.125)).floor() + f64::from(range[0])
}

/// A whole number from 0 to 2³¹, which a cast would first have to find within bounds: in the lowest bits of its sum with
/// 2⁵².
#[inline(always)]
fn whole(value: f64) -> i32 {
    (value + (1_u64 << 52) as f64).to_bits() as i32
}

/// The looks side by side in the lanes of a vector.
#[inline(always)]
fn is_seen_by_vector<S: Simd>(
    simd: S,
    crossings: &Crossings<'_>,
    tiles: LayeredTiles<'_>,
    x: [i32; 2],
    y: [i32; 2],
) -> bool {
    let lanes = S::f64s::LEN;
    let (mut columns, mut rows, mut depths) = ([0.0; 8], [0.0; 8], [0.0; 8]);
    for first in (0..LOOKS[0].len()).step_by(lanes) {
        let across = S::f64s::from_slice(simd, &LOOKS[0][first..first + lanes]);
        let down = S::f64s::from_slice(simd, &LOOKS[1][first..first + lanes]);
        let column = (across * 0.125 * f64::from(x[1] - x[0])).floor() + f64::from(x[0]);
        let row = (down * 0.125 * f64::from(y[1] - y[0])).floor() + f64::from(y[0]);
        let (depth, meets) = crossings.entry_depths::<S>(simd, column, row);
        column.store_slice(&mut columns[..lanes]);
        row.store_slice(&mut rows[..lanes]);
        depth.store_slice(&mut depths[..lanes]);
        let mut left = meets.to_bitmask();
        while left != 0 {
            let i = left.trailing_zeros() as usize % lanes;
            left &= left - 1;
            let (column, row) = (whole(columns[i]), whole(rows[i]));
            if !tiles.is_nearer(column, row, depths[i] as f32) {
                return true;
            }
        }
    }
    false
}
