//! The closer question has the same answer on every level.

use antumbra_simd::Level;
use antumbra_simd::boxes::BoxView;
use antumbra_simd::closer::{LayeredTiles, is_box_hidden, is_outline_hidden, open_sample};
use antumbra_simd::covering::{BLOCK, RectangleBlock, covering};
use antumbra_simd::faces::{FacePlane, Faces};
use antumbra_simd::glance::{Rays, Slabs, is_seen, looks};
use antumbra_simd::outline::{Outline, OutlineEdge};
use antumbra_simd::projected::{CornerBox, OnScreen};
use antumbra_simd::query::Rectangle;
use antumbra_simd::tile::UNCOVERED;
use antumbra_simd::vertex::ScreenTransform;

struct Numbers(u64);

impl Numbers {
    fn below(&mut self, count: u64) -> u64 {
        self.0 = self
            .0
            .wrapping_mul(6_364_136_223_846_793_005)
            .wrapping_add(1_442_695_040_888_963_407);
        (self.0 >> 33) % count
    }

    fn one_of<T: Copy>(&mut self, of: &[T]) -> T {
        of[self.below(of.len() as u64) as usize]
    }

    fn range(&mut self, limit: i32) -> [i32; 2] {
        let (a, b) = (
            self.below(limit as u64) as i32,
            self.below(limit as u64) as i32,
        );
        [a.min(b), a.max(b)]
    }
}

#[derive(Default)]
struct Picture {
    coverage: Vec<u64>,
    far: Vec<[f32; 2]>,
    near_samples: Vec<u64>,
    near: Vec<[f32; 2]>,
    across: usize,
}

impl Picture {
    /// Most parts hide everything; some have holes, near layers of all shapes, depths that come close.
    fn any(numbers: &mut Numbers, across: usize, down: usize) -> Picture {
        let mut picture = Picture {
            across,
            ..Picture::default()
        };
        let rare = numbers.one_of(&[2, 8, 40, 200]);
        for _ in 0..across * down {
            let (mut far, mut near, mut near_samples) = ([2.0; 2], [UNCOVERED; 2], 0);
            for part in 0..2 {
                if numbers.below(rare) == 0 {
                    far[part] = numbers.one_of(&[0.125, 0.375, 0.5, 0.625]);
                    if numbers.below(2) == 0 {
                        near[part] = far[part] + 0.25 + numbers.below(3) as f32 * 0.25;
                        let samples = [0xff_u64 << 8, 0x0f0f_0f0f, 0xaaaa_aaaa, 0xff00_0000, 1];
                        near_samples |= numbers.one_of(&samples) << (32 * part);
                    }
                }
            }
            let hole = if numbers.below(8 * rare) == 0 {
                1 << numbers.below(64)
            } else {
                0
            };
            picture.coverage.push(!hole);
            picture.far.push(far);
            picture.near_samples.push(near_samples);
            picture.near.push(near);
        }
        picture
    }

    fn tiles(&self) -> LayeredTiles<'_> {
        LayeredTiles {
            coverage: &self.coverage,
            far: &self.far,
            near_samples: &self.near_samples,
            near: &self.near,
            across: self.across,
        }
    }
}

fn any_outline(numbers: &mut Numbers, width: i32, height: i32) -> Outline {
    let mut outline = Outline::of_rectangle(numbers.range(width), numbers.range(height));
    for _ in 0..numbers.below(7) {
        let slope = (numbers.below(65) as f64 - 32.0) * numbers.one_of(&[0.125, 1.0, 2048.0]);
        let x = numbers.below(width as u64) as f64 + numbers.one_of(&[0.0, 0.5, -0.25]);
        let offset = x - slope * numbers.below(height as u64) as f64;
        let edge = OutlineEdge { slope, offset };
        if (slope < 0.0) == (numbers.below(4) > 0) {
            outline.left.push(edge);
        } else {
            outline.right.push(edge);
        }
    }
    outline
}

fn any_faces(numbers: &mut Numbers, width: i32, height: i32) -> Faces {
    let mut faces = Faces::new(0.25 + numbers.below(4) as f32 * 0.25);
    for _ in 0..numbers.below(4) {
        let mut slope = || {
            let steep = numbers.one_of(&[1.0 / 1024.0, 1.0 / 65536.0, 1e9]);
            (numbers.below(129) as f64 - 64.0) * steep
        };
        let (slope_x, slope_y) = (slope(), slope());
        let (x, y) = (
            numbers.below(width as u64) as f64,
            numbers.below(height as u64) as f64,
        );
        faces.push(FacePlane {
            slope_x,
            slope_y,
            depth: numbers.below(5) as f64 * 0.25 - slope_x * x - slope_y * y,
        });
    }
    faces
}

#[test]
fn every_level_gives_the_same_answer() {
    let mut numbers = Numbers(3);
    let mut count = [0; 2];
    for _ in 0..400 {
        let across = numbers.one_of(&[1, 2, 3, 4, 5, 7, 8, 9, 16, 21, 40]);
        let down = 1 + numbers.below(12) as usize;
        let picture = Picture::any(&mut numbers, across, down);
        let size = |tiles: usize, numbers: &mut Numbers| 8 * tiles as i32 - numbers.below(8) as i32;
        let (width, height) = (size(across, &mut numbers), size(down, &mut numbers));
        for _ in 0..100 {
            let outline = any_outline(&mut numbers, width, height);
            let faces = any_faces(&mut numbers, width, height);
            let tiles = picture.tiles();
            let expected = is_outline_hidden(Level::Scalar, tiles, &outline, &faces);
            for &level in Level::available() {
                let answer = is_outline_hidden(level, tiles, &outline, &faces);
                assert_eq!(answer, expected, "{level}: {outline:?} {faces:?}");
            }
            count[usize::from(expected)] += 1;
        }
    }
    assert!(count[0] > 4_000 && count[1] > 4_000, "{count:?}");
}

/// The rectangle around a part's samples is found in the bits of its mask.
#[test]
fn every_level_finds_the_rectangle_of_a_layer() {
    let mut numbers = Numbers(5);
    let mut count = [0; 2];
    for _ in 0..20_000 {
        let near_samples = (0..3).fold(u64::MAX, |m, _| {
            m & (numbers.below(1 << 31) | numbers.below(1 << 31) << 31 | numbers.below(4) << 62)
        });
        let picture = Picture {
            coverage: vec![u64::MAX; 8],
            far: vec![[0.0; 2]; 8],
            near_samples: vec![near_samples; 8],
            near: vec![[0.5; 2]; 8],
            across: 8,
        };
        // All that is not in the near layer is behind as well, if the plane is lowered enough.
        let mut faces = Faces::new(1.0);
        let mut slope = || (numbers.below(17) as f64 - 8.0) / 64.0;
        let (slope_x, slope_y) = (slope(), slope());
        let depth = (numbers.below(256) as f64 - 224.0) / 64.0;
        faces.push(FacePlane {
            slope_x,
            slope_y,
            depth,
        });
        let mut outline = Outline::of_rectangle(numbers.range(64), numbers.range(8));
        outline.left.push(OutlineEdge {
            slope: 0.0,
            offset: numbers.below(60) as f64,
        });
        let tiles = picture.tiles();
        let expected = is_outline_hidden(Level::Scalar, tiles, &outline, &faces);
        for &level in Level::available() {
            let answer = is_outline_hidden(level, tiles, &outline, &faces);
            assert_eq!(answer, expected, "{level}: {outline:?} {faces:?}");
        }
        count[usize::from(expected)] += 1;
    }
    assert!(count[0] > 4_000 && count[1] > 4_000, "{count:?}");
}

/// A box of any shape, turned and sheared, perhaps flat.
fn any_box(numbers: &mut Numbers) -> CornerBox {
    let mut real = |least: f64, range: f64| least + range * numbers.below(1 << 20) as f64 / 1e6;
    let center = [real(-2.0, 4.0), real(-2.0, 4.0), real(1.5, 7.0)];
    let mut axes = [[0.0; 3]; 3];
    for (i, axis) in axes.iter_mut().enumerate() {
        *axis = [real(-0.2, 0.4), real(-0.2, 0.4), real(-0.2, 0.4)];
        axis[i] = real(-0.1, 1.0);
    }
    if let Some(flat) = axes.get_mut(numbers.below(9) as usize) {
        *flat = [0.0; 3];
    }
    let corner = |i: usize, c: usize| {
        (0..3).fold(center[c], |sum, axis| {
            let side = if i >> axis & 1 == 0 { -1.0 } else { 1.0 };
            sum + side * axes[axis][c]
        })
    };
    CornerBox {
        corners: std::array::from_fn(|c| std::array::from_fn(|i| corner(i, c))),
        error: numbers.one_of(&[0.0, 1e-9, 1e-3]),
        mirrored: numbers.below(2) == 0,
    }
}

#[test]
fn every_level_gives_the_same_answer_about_a_box() {
    let mut numbers = Numbers(7);
    let mut count = [0; 2];
    let mut opened = 0;
    for _ in 0..300 {
        let across = numbers.one_of(&[1, 3, 4, 5, 8, 9, 16, 21]);
        let down = 1 + numbers.below(12) as usize;
        let picture = Picture::any(&mut numbers, across, down);
        let (width, height) = (8 * across as i32, 8 * down as i32);
        let [half_width, half_height] = [width, height].map(|v| 128.0 * f64::from(v));
        let view = BoxView {
            screen: ScreenTransform {
                x: [half_height, 0.0, half_width, 0.0],
                y: [0.0, -half_height, half_height, 0.0],
                depth: [0.0, 0.0, 0.0, 1.0],
                w: [0.0, 0.0, 1.0, 0.0],
                near_depth: 1.0,
                far_depth: f64::NEG_INFINITY,
            },
            norms: [half_height + half_width, 1.5 * half_height, 0.0, 1.0],
            snap_error: 0.5,
            relative_error: 1e-12,
            slope_error: antumbra_simd::triangle::DepthPlane::SLOPE_ERROR,
            size: [f64::from(width), f64::from(height)],
        };
        for _ in 0..100 {
            let b = any_box(&mut numbers);
            let rectangle = Rectangle {
                x: numbers.range(width),
                y: numbers.range(height),
                nearest: numbers.one_of(&[0.3, 0.5, 1.0]),
            };
            let tiles = picture.tiles();
            let expected = is_box_hidden(Level::Scalar, &view, tiles, &b, rectangle);
            for &level in Level::available() {
                let answer = is_box_hidden(level, &view, tiles, &b, rectangle);
                assert_eq!(answer, expected, "{level}: {b:?} {rectangle:?}");
            }
            // What is not hidden has a sample to show for it, within its rectangle and not covered by anything nearer than what
            // the box has there; only a box that cannot be projected has none.
            let open = open_sample(&view, tiles, &b, rectangle);
            let is_projected = OnScreen::new(&view, &b).is_some();
            assert_eq!(open.is_some(), !expected && is_projected, "{b:?}");
            if let Some(([x, y], depth)) = open {
                let holds = |[first, last]: [i32; 2], v: i32| first <= v && v <= last;
                assert!(holds(rectangle.x, x) && holds(rectangle.y, y));
                assert!(!tiles.is_nearer(x, y, depth), "{b:?} {rectangle:?}");
            }
            opened += usize::from(open.is_some());
            count[usize::from(expected)] += 1;
        }
    }
    assert!(count[0] > 1_000 && count[1] > 1_000, "{count:?}");
    assert!(opened > 500, "{opened} of {count:?}");
}

#[test]
fn every_level_sees_a_box_alike() {
    let mut numbers = Numbers(9);
    let mut count = [0; 2];
    for _ in 0..300 {
        let across = numbers.one_of(&[1, 3, 4, 5, 8, 9, 16, 21]);
        let down = 1 + numbers.below(12) as usize;
        let mut picture = Picture::any(&mut numbers, across, down);
        for far in picture.far.iter_mut().filter(|_| numbers.below(4) > 0) {
            *far = [0.25, 0.375];
        }
        let (width, height) = (8 * across as i32, 8 * down as i32);
        let [half_width, half_height] = [width, height].map(|v| 128.0 * f64::from(v));
        let perspective = ScreenTransform {
            x: [half_height, 0.0, half_width, 0.0],
            y: [0.0, -half_height, half_height, 0.0],
            depth: [0.0, 0.0, 0.0, 1.0],
            w: [0.0, 0.0, 1.0, 0.0],
            near_depth: 1.0,
            far_depth: f64::NEG_INFINITY,
        };
        let orthographic = ScreenTransform {
            x: [half_height / 2.0, 0.0, 0.0, half_width],
            y: [0.0, -half_height / 2.0, 0.0, half_height],
            depth: [0.0, 0.0, -0.125, 1.0],
            w: [0.0, 0.0, 0.0, 1.0],
            ..perspective
        };
        let rays = Rays::new(&numbers.one_of(&[perspective, orthographic]));
        for _ in 0..100 {
            let mut real =
                |least: f64, range: f64| least + range * numbers.below(1 << 20) as f64 / 1e6;
            let center = [real(-2.0, 4.0), real(-2.0, 4.0), real(1.5, 7.0)];
            let half = [real(0.0, 1.0), real(0.0, 1.0), real(0.0, 1.0)];
            let turned = std::array::from_fn(|i| {
                let mut normal = [real(-0.2, 0.4), real(-0.2, 0.4), real(-0.2, 0.4)];
                normal[i] = real(-0.1, 1.0);
                normal
            });
            let normals = (numbers.below(2) == 0).then_some(turned);
            let slabs = Slabs {
                normals,
                low: std::array::from_fn(|i| center[i] - half[i]),
                high: std::array::from_fn(|i| center[i] + half[i]),
            };
            let rectangle = Rectangle {
                x: numbers.range(width),
                y: numbers.range(height),
                nearest: 1.0,
            };
            let tiles = picture.tiles();
            let expected = is_seen(Level::Scalar, &rays, &slabs, tiles, rectangle);
            for &level in Level::available() {
                let all = looks(level, &rays, &slabs, tiles, rectangle);
                assert_eq!(all.seen != 0, expected, "{level}");
                let plain = looks(Level::Scalar, &rays, &slabs, tiles, rectangle);
                for i in (0..8).filter(|i| plain.seen >> i & 1 == 1) {
                    assert_eq!(all.depths[i].to_bits(), plain.depths[i].to_bits());
                }
                assert_eq!(
                    (all.seen, all.columns, all.rows),
                    (plain.seen, plain.columns, plain.rows)
                );
                let answer = is_seen(level, &rays, &slabs, tiles, rectangle);
                assert_eq!(answer, expected, "{level}: {slabs:?} {rectangle:?}");
            }
            count[usize::from(expected)] += 1;
        }
    }
    assert!(count[0] > 500 && count[1] > 500, "{count:?}");
}

#[test]
fn every_level_finds_the_rectangles_over_a_sample() {
    let mut numbers = Numbers(11);
    let mut found = 0;
    for _ in 0..2_000 {
        let mut block = RectangleBlock::EMPTY;
        for i in 0..BLOCK {
            for ends in [&mut block.x, &mut block.y] {
                let first = numbers.below(41) as i32;
                ends[0][i] = first;
                ends[1][i] = first + numbers.below(33) as i32 - 2;
            }
            block.nearest[i] = numbers.one_of(&[f32::NEG_INFINITY, 0.25, 0.5, f32::INFINITY]);
        }
        let blocks = [block, RectangleBlock::EMPTY, block];
        let sample = [0, 1].map(|_| numbers.below(41) as i32);
        let mut plain = Vec::new();
        covering(Level::Scalar, &blocks, sample, 0.25, &mut plain);
        assert_eq!((plain[0], plain[1]), (plain[2], 0));
        found += plain[0].count_ones();
        for &level in Level::available() {
            let mut masks = Vec::new();
            covering(level, &blocks, sample, 0.25, &mut masks);
            assert_eq!(masks, plain, "{level}");
        }
    }
    assert!(found > 1_000, "{found}");
}
