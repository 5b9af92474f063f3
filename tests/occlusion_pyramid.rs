//! The overlap test against a plain scan of the rectangle's pixels, at odd sizes and with sparse holes.

mod oracle;

use antumbra::occlusion::{
    Accuracy, OcclusionMap, SampleRect, is_behind, is_covered, is_covered_so_far,
};
use antumbra::raster::TileBuffer;
use antumbra::view::PictureSize;
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
            assert_eq!(
                is_covered(&map, tiles, &rect, Accuracy::Exact),
                truth,
                "{rect:?}"
            );
            assert_eq!(
                is_covered(&map, tiles, &rect, Accuracy::Approximate { hole: 3 }),
                truth,
                "{rect:?}"
            );
            assert_eq!(is_covered_so_far(tiles, &rect), truth, "{rect:?}");
            *(if truth { &mut covered } else { &mut not }) += 1;
        }
    });
    assert!(
        covered > 2_000 && not > 2_000,
        "{covered} covered, {not} not"
    );
}

/// What is ignored stays within the stated bound: a quarter of the hole in each tile, hence the hole in any window of
/// 8 × 8 pixels, wherever it stands. What an exact answer hides, an approximate one hides too.
#[test]
fn approximate_overlap_ignores_no_more_than_it_says() {
    let mut ignored_some = 0;
    for_patterns(62, |chance, tiles| {
        let map = OcclusionMap::new(tiles);
        let questions = if tiles.coverage().len() > 2_000 {
            20
        } else {
            60
        };
        for _ in 0..questions {
            let rect = any_rect(chance, tiles.size());
            let hole = [4, 8, 16, 64, 128, 255][chance.whole(0, 5) as usize];
            let holes = holes(tiles, &rect);
            let answer = is_covered(&map, tiles, &rect, Accuracy::Approximate { hole });
            if !answer {
                assert!(!holes.is_empty(), "{rect:?}");
                continue;
            }
            ignored_some += usize::from(!holes.is_empty());
            let mut of_tile = std::collections::BTreeMap::new();
            for &(x, y) in &holes {
                *of_tile.entry((x / 8, y / 8)).or_insert(0) += 1;
            }
            assert!(of_tile.values().all(|&n| n <= hole / 4), "{rect:?}");
            for &(x, y) in holes.iter().step_by(17) {
                let (left, top) = (x - chance.whole(0, 7), y - chance.whole(0, 7));
                let inside =
                    |&&(x, y): &&(i32, i32)| left <= x && x < left + 8 && top <= y && y < top + 8;
                assert!(
                    holes.iter().filter(inside).count() <= hole as usize,
                    "{rect:?}"
                );
            }
        }
    });
    assert!(ignored_some > 200, "{ignored_some}");
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
