//! The overlap test against a plain scan of the rectangle's pixels, at odd sizes and with sparse holes.

mod oracle;

use antumbra::occlusion::{
    Accuracy, Approximation, Holes, OcclusionMap, SampleRect, Thresholds, is_behind, is_covered,
    is_covered_so_far,
};
use antumbra::raster::TileBuffer;
use antumbra::view::{MapScale, PictureSize};
use antumbra_simd::triangle::{CullMode, Triangle};
use oracle::{Chance, Point, vertex};

const SIZES: [(u32, u32); 12] = [
    (1, 1),
    (7, 9),
    (8, 8),
    (13, 1),
    (1, 13),
    (16, 16),
    (17, 33),
    (64, 64),
    (129, 65),
    (200, 3),
    (1_283, 771),
    (16_384, 1),
];

/// Covers the picture but for some pixels, each row of pixels by level strips between its holes.
fn with_holes(size: PictureSize, is_hole: impl Fn(i32, i32) -> bool) -> TileBuffer {
    let (w, h) = (size.width() as i32, size.height() as i32);
    let mut triangles = Vec::new();
    let mut strip = |x: [i32; 2], y: i32| {
        let corner = |x: i32, y: i32| -> Point { (256 * x, 256 * y) };
        let [a, b, c, d] = [
            corner(x[0], y),
            corner(x[1], y),
            corner(x[1], y + 1),
            corner(x[0], y + 1),
        ];
        for corners in [[a, b, c], [a, c, d]] {
            let set_up = Triangle::new(corners.map(|p| vertex(p, 0.5)), CullMode::None);
            triangles.extend(set_up.and_then(|t| t.within(w, h)));
        }
    };
    for y in 0..h {
        let mut start = 0;
        for x in 0..=w {
            if x == w || is_hole(x, y) {
                if start < x {
                    strip([start, x], y);
                }
                start = x + 1;
            }
        }
    }
    let mut tiles = TileBuffer::new(size);
    tiles.fill(&triangles);
    tiles
}

fn is_set(tiles: &TileBuffer, x: i32, y: i32) -> bool {
    let tile = (y / 8) as usize * tiles.size().tiles_across() + (x / 8) as usize;
    tiles.coverage()[tile] >> (y % 8 * 8 + x % 8) & 1 == 1
}

/// The uncovered pixels of a rectangle, one by one.
fn holes(tiles: &TileBuffer, rect: &SampleRect) -> Vec<(i32, i32)> {
    let rows = rect.y[0]..=rect.y[1];
    rows.flat_map(|y| (rect.x[0]..=rect.x[1]).map(move |x| (x, y)))
        .filter(|&(x, y)| !is_set(tiles, x, y))
        .collect()
}

fn any_rect(chance: &mut Chance, size: PictureSize) -> SampleRect {
    let mut span = |pixels: usize| {
        let last = pixels as i32 - 1;
        let first = chance.whole(0, last);
        match chance.whole(0, 3) {
            0 => [0, last],
            1 => [first, (first + chance.whole(0, 9)).min(last)],
            _ => {
                let other = chance.whole(0, last);
                [first.min(other), first.max(other)]
            }
        }
    };
    SampleRect {
        x: span(size.width()),
        y: span(size.height()),
        nearest_depth: 0.1,
    }
}

/// Calls `check` with buffers of every size whose holes are few, many, clustered or in the border.
fn for_patterns(seed: u64, mut check: impl FnMut(&mut Chance, &TileBuffer)) {
    let mut chance = Chance::seeded(seed);
    for (w, h) in SIZES {
        let size = PictureSize::new(w, h).unwrap();
        let is_large = w * h > 100_000;
        // A large picture's many holes would be most of the test's time.
        for pattern in (0..7).filter(|p| !is_large || ![3, 4].contains(p)) {
            let (seed, w, h) = (chance.bits(), w as i32, h as i32);
            let one = (chance.whole(0, w - 1), chance.whole(0, h - 1));
            let block = (
                chance.whole(0, w - 1) / 8 * 8,
                chance.whole(0, h - 1) / 8 * 8,
            );
            let at = move |x: i32, y: i32| Chance(seed ^ ((x as u64) << 32 | y as u64)).bits();
            let tiles = with_holes(size, |x, y| match pattern {
                0 => false,
                1 => (x, y) == one,
                2 => at(x, y).is_multiple_of(500),
                3 => at(x, y).is_multiple_of(13),
                4 => !at(x, y).is_multiple_of(9),
                5 => x >= block.0 && x < block.0 + 8 && y >= block.1 && y < block.1 + 8,
                _ => (x == w - 1 || y == h - 1) && at(x, y).is_multiple_of(20),
            });
            check(&mut chance, &tiles);
        }
    }
}

#[test]
fn exact_overlap_equals_a_scan_of_every_pixel() {
    let (mut covered, mut not) = (0, 0);
    for_patterns(61, |chance, tiles| {
        let map = OcclusionMap::new(tiles);
        let questions = if tiles.coverage().len() > 2_000 {
            40
        } else {
            200
        };
        for _ in 0..questions {
            let rect = any_rect(chance, tiles.size());
            let truth = holes(tiles, &rect).is_empty();
            let promise = Accuracy::Approximate(Approximation::promise(3));
            for accuracy in [Accuracy::Exact, promise] {
                let thresholds = Thresholds::new(&accuracy, MapScale::Full, map.level_count());
                let answer = is_covered(&map, tiles, &rect, &thresholds);
                assert_eq!(answer, truth, "{rect:?}");
            }
            assert_eq!(is_covered_so_far(tiles, &rect), truth, "{rect:?}");
            *(if truth { &mut covered } else { &mut not }) += 1;
        }
    });
    assert!(
        covered > 2_000 && not > 2_000,
        "{covered} covered, {not} not"
    );
}

/// Holes of any size, on any level, however favourably they are taken to be distributed.
fn any_approximation(chance: &mut Chance) -> Approximation {
    Approximation {
        hole: [0, 3, 4, 8, 16, 63, 64, 128, 255][chance.whole(0, 8) as usize],
        base_level: chance.whole(0, 2) as u8,
        distribution: [1.0, 1.0, 2.0, 2.5, 4.0][chance.whole(0, 4) as usize],
        coarsest_level: [2, 4, u8::MAX][chance.whole(0, 2) as usize],
        ..Approximation::default()
    }
}

fn covered(tiles: &TileBuffer, rect: &SampleRect) -> bool {
    holes(tiles, rect).is_empty()
}

/// Covering the holes that may be ignored, once, gives the answers of HOM's overlap test: where the distribution is the worst, the
/// same; otherwise the test may begin at too fine a level to see that a coarser one lets the hole pass.
#[test]
fn covering_holes_gives_the_answers_of_the_overlap_test() {
    let (mut passed, mut failed) = (0, 0);
    for_patterns(62, |chance, tiles| {
        let map = OcclusionMap::new(tiles);
        let is_large = tiles.coverage().len() > 2_000;
        for _ in 0..if is_large { 2 } else { 8 } {
            let approximation = any_approximation(chance);
            let accuracy = Accuracy::Approximate(approximation);
            let thresholds = Thresholds::new(&accuracy, MapScale::Full, map.level_count());
            let mut closed = tiles.clone();
            Holes::new(tiles, &accuracy, MapScale::Full).close(&mut closed);
            for _ in 0..if is_large { 10 } else { 25 } {
                let rect = any_rect(chance, tiles.size());
                let answer = is_covered(&map, tiles, &rect, &thresholds);
                let is_closed = covered(&closed, &rect);
                assert!(is_closed || !answer, "{rect:?}, {approximation:?}");
                if approximation.distribution == 1.0 && approximation.base_level == 0 {
                    assert_eq!(answer, is_closed, "{rect:?}, {approximation:?}");
                }
                let gained = answer && !covered(tiles, &rect);
                *(if gained { &mut passed } else { &mut failed }) += 1;
            }
        }
    });
    assert!(
        passed > 500 && failed > 2_000,
        "{passed} passed, {failed} not"
    );
}

/// The L-k-hole constraint (HOM §5.3.3.1): of what is ignored, no window of the base cells' size holds more than L pixels, wherever it
/// stands, whatever is drawn after holes were covered, and at any scale of the map.
#[test]
fn no_window_holds_more_ignored_pixels_than_the_hole_has() {
    let (mut windows, mut most_full) = (0, 0.0_f64);
    for_patterns(65, |chance, tiles| {
        let is_large = tiles.coverage().len() > 2_000;
        for _ in 0..if is_large { 1 } else { 6 } {
            let approximation = Approximation {
                distribution: 1.0,
                ..any_approximation(chance)
            };
            let scale = MapScale::ALL[chance.whole(0, 2) as usize];
            let mut holes = Holes::new(tiles, &Accuracy::Approximate(approximation), scale);
            let mut closed = tiles.clone();
            for _ in 0..3 {
                holes.close(&mut closed);
                let [w, h] = [tiles.size().width() as i32, tiles.size().height() as i32];
                let mut corner =
                    || vertex((chance.whole(0, 256 * w), chance.whole(0, 256 * h)), 0.7);
                let drawn = Triangle::new([corner(), corner(), corner()], CullMode::None);
                let drawn = drawn.and_then(|t| t.within(w, h));
                closed.fill(&drawn.into_iter().collect::<Vec<_>>());
            }
            holes.close(&mut closed);
            let pixels = scale.pixels() as i32;
            let across = tiles.size().tiles_across();
            let mut ignored = Vec::new();
            for (tile, &mask) in holes.ignored().iter().enumerate() {
                for bit in (0..64).filter(|bit| mask >> bit & 1 == 1) {
                    let x = (tile % across * 8) as i32 + bit % 8;
                    let y = (tile / across * 8) as i32 + bit / 8;
                    assert!(!is_set(tiles, x, y), "{x}, {y} was covered");
                    let block = (0..pixels).flat_map(|j| (0..pixels).map(move |i| (i, j)));
                    ignored.extend(block.map(|(i, j)| (x * pixels + i, y * pixels + j)));
                }
            }
            assert_eq!(
                holes.samples() as usize * (pixels * pixels) as usize,
                ignored.len()
            );
            let edge = 8 << approximation.base_level;
            for &(x, y) in ignored.iter().step_by(1 + ignored.len() / 60) {
                let (left, top) = (x - chance.whole(0, edge - 1), y - chance.whole(0, edge - 1));
                let inside = |&&(x, y): &&(i32, i32)| {
                    left <= x && x < left + edge && top <= y && y < top + edge
                };
                let count = ignored.iter().filter(inside).count();
                assert!(
                    count <= approximation.hole as usize,
                    "{approximation:?}, {scale}"
                );
                most_full = most_full.max(count as f64 / f64::from(approximation.hole));
                windows += 1;
            }
        }
    });
    // A quarter is always there to be had; more where holes meet at a corner.
    assert!(
        windows > 1_000 && most_full >= 0.5,
        "{windows} windows, {most_full}"
    );
}

/// What covers little may be taken for nothing: that rejects more, and never passes what was not passed.
#[test]
fn transparency_thresholds_only_reject() {
    let mut rejected = 0;
    for_patterns(66, |chance, tiles| {
        let map = OcclusionMap::new(tiles);
        for _ in 0..10 {
            let rect = any_rect(chance, tiles.size());
            let answer = |transparency| {
                let approximation = Approximation {
                    transparency,
                    ..Approximation::default()
                };
                let accuracy = Accuracy::Approximate(approximation);
                let thresholds = Thresholds::new(&accuracy, MapScale::Full, map.level_count());
                is_covered(&map, tiles, &rect, &thresholds)
            };
            let (all, some) = (answer(0.0), answer(0.4));
            assert!(all || !some, "{rect:?}");
            rejected += usize::from(all && !some);
        }
    });
    assert!(rejected > 0);
}

#[test]
fn every_cell_counts_the_uncovered_pixels_of_the_picture_below_it() {
    for_patterns(63, |_, tiles| {
        let map = OcclusionMap::new(tiles);
        let size = tiles.size();
        for level in 0..map.level_count() {
            let width = map.width_of_level(level);
            let cells = map.uncovered_of_level(level);
            let mut all = 0;
            for (i, &count) in cells.iter().enumerate() {
                let [columns, rows] = map.pixels_of_cell(level, i % width, i / width);
                assert!(columns[1] < size.width() as i32 && rows[1] < size.height() as i32);
                let rect = SampleRect {
                    x: columns,
                    y: rows,
                    nearest_depth: 0.0,
                };
                if level < 2 || cells.len() < 4 {
                    assert_eq!(count as usize, holes(tiles, &rect).len());
                }
                all += count;
            }
            assert_eq!(all, map.uncovered_of_level(map.level_count() - 1)[0]);
        }
        assert_eq!(map.uncovered_of_level(map.level_count() - 1).len(), 1);
    });
}

/// Strictly farther than every part that holds one of the rectangle's pixels, and those alone.
#[test]
fn the_depth_test_equals_a_scan_of_the_parts() {
    let mut chance = Chance::seeded(64);
    for (w, h) in SIZES {
        let size = PictureSize::new(w, h).unwrap();
        for _ in 0..if w * h > 100_000 { 2 } else { 12 } {
            let mut triangles = Vec::new();
            for _ in 0..30 {
                let mut corner = || {
                    let at = (
                        chance.whole(-999, 256 * w as i32 + 999),
                        chance.whole(-999, 256 * h as i32 + 999),
                    );
                    vertex(at, chance.real(0.2, 1.0))
                };
                let corners = [corner(), corner(), corner()];
                let set_up = Triangle::new(corners, CullMode::None);
                triangles.extend(set_up.and_then(|t| t.within(w as i32, h as i32)));
            }
            let mut tiles = TileBuffer::new(size);
            tiles.fill(&triangles);
            for _ in 0..60 {
                let rect = any_rect(&mut chance, size);
                let any_part = chance.whole(0, tiles.depths().len() as i32 - 1) as usize;
                let at = tiles.depths()[any_part][chance.whole(0, 1) as usize];
                // At, just before and just behind a depth that occurs, and anywhere.
                let depth = match chance.whole(0, 3) {
                    0 if at.is_finite() => at,
                    1 if at.is_finite() => at.next_down(),
                    2 if at.is_finite() => at.next_up(),
                    _ => chance.real(0.1, 1.0) as f32,
                };
                let rect = SampleRect {
                    nearest_depth: depth,
                    ..rect
                };
                let truth = (rect.y[0]..=rect.y[1])
                    .flat_map(|y| (rect.x[0]..=rect.x[1]).map(move |x| (x, y)))
                    .all(|(x, y)| {
                        let tile = (y / 8) as usize * size.tiles_across() + (x / 8) as usize;
                        let part = (y % 8 / 4) as usize;
                        depth < tiles.depths()[tile][part]
                    });
                assert_eq!(is_behind(&tiles, &rect), truth, "{rect:?}");
            }
        }
    }
}
