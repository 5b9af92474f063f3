//! Every loop gives the same bits on every level that this machine has: on random input, and on the odd cases that
//! vectors get wrong (narrow pictures, borders, edges that are level, vertices that are nowhere).

mod chance;

use antumbra_simd::assemble::{AssembleMemory, Cluster, Drawing, VERTEX_PADDING, assemble};
use antumbra_simd::blocks::{find_blocks, is_behind_blocks};
use antumbra_simd::boxes::{BOXES, BoxBlock, BoxView, RectBlock, project_boxes};
use antumbra_simd::closer::LayeredTiles;
use antumbra_simd::coverage::{PART_MASKS, coverage_of_tile};
use antumbra_simd::fill::{TileRows, fill};
use antumbra_simd::pyramid::{sum_2x2, uncovered};
use antumbra_simd::query::{Rectangle, Tiles, is_behind_all};
use antumbra_simd::spans::{SpanBlock, SpanBlocks, SpanPolygon};
use antumbra_simd::tile::UNCOVERED;
use antumbra_simd::triangle::{CullMode, Triangle};
use antumbra_simd::vertex::{ScreenTransform, ScreenVertex};
use antumbra_simd::{GUARD_BAND, Level};
use chance::Chance;

/// Coverage, depths, near samples, and the near depths of parts that have any.
type TileBits = (u64, [u32; 2], u64, [Option<u32>; 2]);

/// A picture's tiles.
#[derive(Clone, Debug)]
struct Picture {
    width: i32,
    height: i32,
    across: usize,
    coverage: Vec<u64>,
    far: Vec<[f32; 2]>,
    near_samples: Vec<u64>,
    near: Vec<[f32; 2]>,
    gains: [u32; OWNERS],
}

/// Whose polygons are counted.
const OWNERS: usize = 3;

impl Picture {
    fn new(width: i32, height: i32) -> Picture {
        let across = (width as usize).div_ceil(8);
        let tiles = across * (height as usize).div_ceil(8);
        Picture {
            width,
            height,
            across,
            coverage: vec![0; tiles],
            far: vec![[UNCOVERED; 2]; tiles],
            near_samples: vec![0; tiles],
            near: vec![[UNCOVERED; 2]; tiles],
            gains: [0; OWNERS],
        }
    }

    fn fill(&mut self, level: Level, blocks: &[SpanBlock]) {
        let mut rows = TileRows {
            coverage: &mut self.coverage,
            far: &mut self.far,
            near_samples: &mut self.near_samples,
            near: &mut self.near,
            first_row: 0,
            across: self.across,
            height: self.height,
            gains: &mut self.gains,
        };
        fill(level, std::iter::once(blocks), &mut rows);
    }

    fn tiles(&self) -> Tiles<'_> {
        Tiles {
            coverage: &self.coverage,
            depths: &self.far,
            across: self.across,
        }
    }

    fn layered(&self) -> LayeredTiles<'_> {
        LayeredTiles {
            coverage: &self.coverage,
            far: &self.far,
            near_samples: &self.near_samples,
            near: &self.near,
            across: self.across,
        }
    }

    /// The bits of all that means something.
    fn bits(&self) -> Vec<TileBits> {
        (0..self.coverage.len())
            .map(|t| {
                let near_samples = self.near_samples[t];
                let near = |part: usize| {
                    (near_samples & PART_MASKS[part] != 0).then(|| self.near[t][part].to_bits())
                };
                (
                    self.coverage[t],
                    self.far[t].map(f32::to_bits),
                    near_samples,
                    [near(0), near(1)],
                )
            })
            .collect()
    }
}

fn any_picture(chance: &mut Chance) -> Picture {
    let sizes = [
        (1, 1),
        (7, 9),
        (15, 40),
        (33, 8),
        (61, 70),
        (64, 64),
        (129, 50),
        (200, 131),
    ];
    let (width, height) = sizes[chance.whole(0, sizes.len() as i32 - 1) as usize];
    Picture::new(width, height)
}

fn any_vertex(chance: &mut Chance, picture: &Picture) -> ScreenVertex {
    let (w, h) = (256 * picture.width, 256 * picture.height);
    let [x, y] = match chance.whole(0, 9) {
        0 => [
            chance.whole(-GUARD_BAND, GUARD_BAND),
            chance.whole(-GUARD_BAND, GUARD_BAND),
        ],
        // On pixel centres and corners: edges through samples, level and upright ones.
        1..4 => [
            128 * chance.whole(-3, 2 * w / 256 + 3),
            128 * chance.whole(-3, 2 * h / 256 + 3),
        ],
        _ => [
            chance.whole(-w / 4, w + w / 4),
            chance.whole(-h / 4, h + h / 4),
        ],
    };
    let depth = match chance.whole(0, 4) {
        0 => 0.5,
        1 => -chance.real(0.0, 1e6),
        _ => chance.real(1e-3, 1.0),
    };
    ScreenVertex { x, y, depth }
}

fn any_triangle(chance: &mut Chance, picture: &Picture) -> Option<Triangle> {
    let a = any_vertex(chance, picture);
    let corners = if chance.whole(0, 1) == 0 {
        [a, any_vertex(chance, picture), any_vertex(chance, picture)]
    } else {
        let mut near = || ScreenVertex {
            x: (a.x + chance.whole(-3_000, 3_000)).clamp(-GUARD_BAND, GUARD_BAND),
            y: (a.y + chance.whole(-3_000, 3_000)).clamp(-GUARD_BAND, GUARD_BAND),
            depth: a.depth * chance.real(0.9, 1.1),
        };
        [a, near(), near()]
    };
    Triangle::new(corners, CullMode::None).and_then(|t| t.within(picture.width, picture.height))
}

fn packed(triangles: &[Triangle]) -> SpanBlocks {
    let mut blocks = SpanBlocks::default();
    blocks.pack(triangles.iter().map(|t| SpanPolygon::of_triangle(t, 0)));
    blocks
}

fn vector_levels() -> impl Iterator<Item = Level> {
    Level::available()
        .iter()
        .copied()
        .filter(|&level| level != Level::Scalar)
}

/// Whoever runs these tests for the sake of one level says so: it must not go untried.
#[test]
fn the_level_asked_for_is_among_them() {
    if let Ok(name) = std::env::var("ANTUMBRA_LEVEL") {
        let level: Level = name.parse().expect("the name of a level");
        assert_eq!(level.require(), Ok(level));
    }
}

#[test]
fn spans_cover_what_integers_cover() {
    let mut chance = Chance(1);
    let mut covered = 0;
    for _ in 0..3_000 {
        let picture = any_picture(&mut chance);
        let Some(triangle) = any_triangle(&mut chance, &picture) else {
            continue;
        };
        let spans = SpanPolygon::of_triangle(&triangle, 0);
        for tile_y in triangle.y[0] / 8..=triangle.y[1] / 8 {
            for tile_x in triangle.x[0] / 8..=triangle.x[1] / 8 {
                let exact = coverage_of_tile(&triangle, tile_x, tile_y);
                assert_eq!(
                    spans.coverage_of_tile(tile_x, tile_y),
                    exact,
                    "{triangle:?}"
                );
                covered += exact.count_ones();
            }
        }
    }
    assert!(covered > 100_000, "{covered}");
}

#[test]
fn fill_gives_the_same_bits_on_every_level() {
    let mut chance = Chance(2);
    let mut gained = 0;
    for round in 0..300 {
        let mut plain = any_picture(&mut chance);
        let count = [3, 30, 300][round % 3];
        let triangles: Vec<Triangle> = (0..count)
            .filter_map(|_| any_triangle(&mut chance, &plain))
            .collect();
        let mut blocks = packed(&triangles);
        // The last is nobody's whom anybody counts.
        for block in 0..blocks.len() {
            blocks.set_owner(block, (block % (OWNERS + 1)) as u32);
        }
        let empty = plain.clone();
        plain.fill(Level::Scalar, &blocks);
        for level in vector_levels() {
            let mut picture = empty.clone();
            // In one go, or in two.
            let (first, second) = blocks.split_at(blocks.len() / 2);
            picture.fill(level, first);
            picture.fill(level, second);
            assert_eq!(picture.bits(), plain.bits(), "{level}, round {round}");
            assert_eq!(picture.gains, plain.gains, "{level}, round {round}");
        }
        gained += plain.gains.iter().sum::<u32>();
    }
    assert!(gained > 100_000, "{gained}");
}

#[test]
fn blocks_of_tiles_hide_what_their_tiles_hide() {
    let mut chance = Chance(6);
    let mut hidden = [0; 2];
    for round in 0..400 {
        let mut picture = any_picture(&mut chance);
        let triangles: Vec<Triangle> = (0..[3, 300][round % 2])
            .filter_map(|_| any_triangle(&mut chance, &picture))
            .collect();
        picture.fill(Level::Scalar, &packed(&triangles));
        if round % 4 == 0 {
            picture.coverage.fill(u64::MAX);
        }
        let mut plain = Vec::new();
        find_blocks(Level::Scalar, picture.tiles(), &mut plain);
        for level in vector_levels() {
            let mut depths = Vec::new();
            find_blocks(level, picture.tiles(), &mut depths);
            assert_eq!(depths, plain, "{level}");
        }
        for _ in 0..50 {
            let mut range = |size: i32| {
                let first = chance.whole(0, size - 1);
                [first, chance.whole(first, size - 1)]
            };
            let rectangle = Rectangle {
                x: range(picture.width),
                y: range(picture.height),
                nearest: chance.real(-0.2, 0.3) as f32,
            };
            let tiles = is_behind_all(Level::Scalar, picture.tiles(), rectangle);
            let blocks = is_behind_blocks(&plain, picture.across, rectangle);
            assert!(tiles || !blocks, "{rectangle:?}");
            hidden[0] += u32::from(tiles);
            hidden[1] += u32::from(blocks);
        }
    }
    assert!(hidden[0] > hidden[1] && hidden[1] > 100, "{hidden:?}");
}

/// Four vertices, three of them all the same now and then, or the last two.
fn any_quad(chance: &mut Chance, last: i32) -> [u8; 4] {
    let [a, b, c, d] = std::array::from_fn(|_| chance.whole(0, last) as u8);
    match chance.whole(0, 9) {
        0 => [a, b, b, b],
        1..5 => [a, b, c, c],
        _ => [a, b, c, d],
    }
}

#[test]
fn assemble_gives_the_same_polygons_on_every_level() {
    let mut chance = Chance(3);
    let mut set_up = 0;
    let mut clipped = 0;
    for round in 0..2_000 {
        let picture = any_picture(&mut chance);
        let count = chance.whole(3, 128) as usize;
        let mut positions: Vec<[f32; 3]> = (0..count)
            .map(|_| {
                let reach = [3.0, 40.0, 1e5][chance.whole(0, 2) as usize];
                [
                    chance.real(-reach, reach) as f32,
                    chance.real(-reach, reach) as f32,
                    chance.real(if round % 2 == 0 { 1.5 } else { -9.0 }, 60.0) as f32,
                ]
            })
            .collect();
        if round % 50 == 0 {
            positions[count / 2][round / 50 % 3] = [f32::NAN, f32::INFINITY, 0.0][round % 3];
        }
        positions.resize(count.next_multiple_of(VERTEX_PADDING), positions[count - 1]);
        let axis = |i: usize| positions.iter().map(|p| p[i]).collect::<Vec<f32>>();
        let (x, y, z) = (axis(0), axis(1), axis(2));
        let last = count as i32 - 1;
        let quads: Vec<[u8; 4]> = (0..chance.whole(1, 64))
            .map(|_| any_quad(&mut chance, last))
            .collect();
        let scale = 256.0 * f64::from(picture.width);
        let screen = ScreenTransform {
            x: [scale, 0.0, scale * 0.5, chance.real(-9.0, 9.0)],
            y: [1.0, scale, scale * 0.5, 0.0],
            depth: [0.0, 0.0, 0.0, 1.0],
            w: [0.0, chance.real(-0.1, 0.1), 1.0, 0.0],
            near_depth: 1.0,
            far_depth: [f64::NEG_INFINITY, 0.02][chance.whole(0, 1) as usize],
        };
        let drawing = Drawing {
            screen: &screen,
            cull: [CullMode::None, CullMode::Back, CullMode::Front][round % 3],
            width: picture.width,
            height: picture.height,
            inset: [0, 0, 66, 98][chance.whole(0, 3) as usize],
            drawn: picture.layered(),
        };
        let cluster = Cluster {
            x: &x,
            y: &y,
            z: &z,
            vertices: count,
            quads: &quads,
        };
        let assembled = |level: Level| {
            let (mut blocks, mut to_clip) = (SpanBlocks::default(), Vec::new());
            let mut memory = AssembleMemory::default();
            assemble(
                level,
                cluster,
                drawing,
                &mut memory,
                &mut blocks,
                &mut to_clip,
            );
            let polygons: Vec<SpanPolygon> = blocks.iter().flat_map(SpanBlock::iter).collect();
            (polygons, to_clip)
        };
        let plain = assembled(Level::Scalar);
        set_up += plain.0.len();
        clipped += plain.1.len();
        for level in vector_levels() {
            assert_eq!(assembled(level), plain, "{level}, round {round}");
        }
    }
    assert!(set_up > 3_000 && clipped > 3_000, "{set_up} {clipped}");
}

/// What is left out because it is hidden is the same on every level, and to fill it would change nothing.
#[test]
fn assembling_behind_what_is_drawn_leaves_out_only_what_changes_nothing() {
    let mut chance = Chance(4);
    let screen = ScreenTransform {
        x: [256.0 * 64.0, 0.0, 256.0 * 32.0, 0.0],
        y: [0.0, 256.0 * 64.0, 256.0 * 32.0, 0.0],
        depth: [0.0, 0.0, 0.0, 1.0],
        w: [0.0, 0.0, 1.0, 0.0],
        near_depth: 1.0,
        far_depth: f64::NEG_INFINITY,
    };
    let empty = Picture::new(64, 64);
    let mut left_out = 0;
    for round in 0..300 {
        let mut picture = empty.clone();
        let before: Vec<Triangle> = (0..[3, 60][round % 2])
            .filter_map(|_| any_triangle(&mut chance, &picture))
            .collect();
        picture.fill(Level::Scalar, &packed(&before));
        let reach = [1.0, 0.1][round / 2 % 2];
        let mut axis = |from, to| {
            (0..48)
                .map(|_| chance.real(from, to) as f32)
                .collect::<Vec<_>>()
        };
        let (x, y, z) = (axis(-reach, reach), axis(-reach, reach), axis(1.5, 9.0));
        let quads: Vec<[u8; 4]> = (0..45).map(|i| [i, i + 1, i + 2, i + 2 + i % 2]).collect();
        let cluster = Cluster {
            x: &x,
            y: &y,
            z: &z,
            vertices: 48,
            quads: &quads,
        };
        let assembled = |level: Level, drawn: &Picture| {
            let (mut blocks, mut to_clip) = (SpanBlocks::default(), Vec::new());
            let drawing = Drawing {
                screen: &screen,
                cull: CullMode::None,
                width: 64,
                height: 64,
                inset: 0,
                drawn: drawn.layered(),
            };
            let mut memory = AssembleMemory::default();
            assemble(
                level,
                cluster,
                drawing,
                &mut memory,
                &mut blocks,
                &mut to_clip,
            );
            let polygons: Vec<SpanPolygon> = blocks.iter().flat_map(SpanBlock::iter).collect();
            polygons
        };
        let kept = assembled(Level::Scalar, &picture);
        for level in vector_levels() {
            assert_eq!(assembled(level, &picture), kept, "{level}, round {round}");
        }
        let mut next = kept.iter().peekable();
        for polygon in assembled(Level::Scalar, &empty) {
            if next.next_if_eq(&&polygon).is_none() {
                left_out += 1;
                let mut blocks = SpanBlocks::default();
                blocks.pack(std::iter::once(polygon));
                let mut filled = picture.clone();
                filled.fill(Level::Scalar, &blocks);
                assert_eq!(filled.bits(), picture.bits(), "round {round}");
            }
        }
        assert_eq!(next.next(), None, "round {round}");
    }
    assert!(left_out > 100, "{left_out}");
}

#[test]
fn boxes_are_projected_to_the_same_bits_on_every_level() {
    let mut chance = Chance(5);
    let mut bounded = 0;
    for _ in 0..3_000 {
        let mut number = |reach: f64| chance.real(-reach, reach);
        let mut row = |reach| [number(reach), number(reach), number(reach), number(0.1)];
        let view = BoxView {
            screen: ScreenTransform {
                x: row(300_000.0),
                y: row(300_000.0),
                depth: [0.0, 0.0, 0.0, 0.1],
                w: row(1.0),
                near_depth: 1.0,
                far_depth: f64::NEG_INFINITY,
            },
            norms: [3e5, 3e5, 0.0, 1.0],
            snap_error: 0.501,
            relative_error: 1e-12,
            slope_error: antumbra_simd::triangle::DepthPlane::SLOPE_ERROR,
            size: [1283.0, 771.0],
        };
        let mut boxes = BoxBlock::EMPTY;
        for i in 0..BOXES {
            for axis in 0..3 {
                let at = number(20.0);
                boxes.min[axis][i] = at;
                boxes.max[axis][i] = at + number(1.0).abs() * 3.0;
            }
            boxes.error[i] = number(1e-6).abs();
        }
        if number(1.0) > 0.9 {
            boxes.min[1][3] = f64::NAN;
            boxes.max[0][5] = f64::INFINITY;
        }
        let projected = |level: Level| {
            let mut rects = RectBlock::EMPTY;
            project_boxes(level, &view, &boxes, &mut rects);
            let of = |i: usize| {
                let numbers = [
                    rects.x[0],
                    rects.x[1],
                    rects.y[0],
                    rects.y[1],
                    rects.nearest,
                ];
                numbers.map(|n| n[i] + 0.0)
            };
            (0..BOXES)
                .map(|i| (rects.bounded >> i & 1 == 1).then(|| of(i)))
                .collect::<Vec<_>>()
        };
        let plain = projected(Level::Scalar);
        bounded += plain.iter().flatten().count();
        let text = format!("{plain:?}");
        for level in vector_levels() {
            // As text, in which a NaN equals another.
            assert_eq!(format!("{:?}", projected(level)), text, "{level}");
        }
    }
    assert!(bounded > 3_000, "{bounded}");
}

#[test]
fn rectangles_get_the_same_answers_on_every_level() {
    let mut chance = Chance(6);
    let mut answers = [0; 2];
    for _ in 0..150 {
        let mut picture = any_picture(&mut chance);
        let triangles: Vec<Triangle> = (0..40)
            .filter_map(|_| any_triangle(&mut chance, &picture))
            .collect();
        picture.fill(Level::Scalar, &packed(&triangles));
        for _ in 0..60 {
            let mut span = |pixels: i32| {
                let first = chance.whole(0, pixels - 1);
                [first, (first + chance.whole(0, 40)).min(pixels - 1)]
            };
            let (x, y) = (span(picture.width), span(picture.height));
            let depths = picture.far.as_flattened();
            let at = depths[chance.whole(0, depths.len() as i32 - 1) as usize];
            let nearest = match chance.whole(0, 3) {
                0 if at.is_finite() => at,
                1 if at.is_finite() => at.next_down(),
                2 => -2e6,
                _ => chance.real(0.0, 0.5) as f32,
            };
            let rectangle = Rectangle { x, y, nearest };
            let plain = is_behind_all(Level::Scalar, picture.tiles(), rectangle);
            answers[usize::from(plain)] += 1;
            for level in vector_levels() {
                let answer = is_behind_all(level, picture.tiles(), rectangle);
                assert_eq!(answer, plain, "{level}: {rectangle:?}");
            }
        }
    }
    assert!(answers.iter().all(|&n| n > 500), "{answers:?}");
}

#[test]
fn pyramids_are_the_same_on_every_level() {
    let mut chance = Chance(7);
    for width in 1..40 {
        for height in [1, 2, 5, 8] {
            let words = |chance: &mut Chance| -> Vec<u64> {
                (0..width * height).map(|_| chance.next()).collect()
            };
            let (coverage, picture) = (words(&mut chance), words(&mut chance));
            let levels = |level: Level| {
                let mut counts = vec![0; width * height];
                uncovered(level, &coverage, &picture, &mut counts);
                let mut coarse = vec![0; width.div_ceil(2) * height.div_ceil(2)];
                sum_2x2(level, &counts, width, &mut coarse);
                (counts, coarse)
            };
            for level in vector_levels() {
                assert_eq!(levels(level), levels(Level::Scalar), "{level}");
            }
        }
    }
}
