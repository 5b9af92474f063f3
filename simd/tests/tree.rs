//! A ray goes down a tree of boxes to what it may meet.

mod chance;

use antumbra_simd::Level;
use antumbra_simd::glance::{Ray, Rays};
use antumbra_simd::tree::{Block, Tree, WIDTH, descend};
use antumbra_simd::vertex::ScreenTransform;
use chance::Chance;

type Boxes = Vec<([f32; 3], [f32; 3])>;

/// A tree over boxes in their order, and its levels.
fn tree_over(boxes: &Boxes) -> (Vec<Block>, Vec<(u32, u32)>) {
    let (mut blocks, mut levels) = (Vec::<Block>::new(), Vec::new());
    let mut level = boxes.clone();
    loop {
        levels.push((blocks.len() as u32, level.len() as u32));
        let mut above = Boxes::new();
        for chunk in level.chunks(WIDTH) {
            let mut block = Block::EMPTY;
            let mut around = ([f32::INFINITY; 3], [f32::NEG_INFINITY; 3]);
            for (i, (min, max)) in chunk.iter().enumerate() {
                for axis in 0..3 {
                    block.min[axis][i] = min[axis];
                    block.max[axis][i] = max[axis];
                    around.0[axis] = around.0[axis].min(min[axis]);
                    around.1[axis] = around.1[axis].max(max[axis]);
                }
            }
            blocks.push(block);
            above.push(around);
        }
        if above.len() == 1 {
            return (blocks, levels);
        }
        level = above;
    }
}

const PERSPECTIVE: ScreenTransform = ScreenTransform {
    x: [256.0 * 64.0, 0.0, 256.0 * 32.0, 0.0],
    y: [0.0, 256.0 * 64.0, 256.0 * 32.0, 0.0],
    depth: [0.0, 0.0, 0.0, 1.0],
    w: [0.0, 0.0, 1.0, 0.0],
    near_depth: 1.0,
    far_depth: f64::NEG_INFINITY,
};

const ORTHOGRAPHIC: ScreenTransform = ScreenTransform {
    x: [256.0 * 8.0, 0.0, 0.0, 256.0 * 32.0],
    y: [0.0, 256.0 * 8.0, 0.0, 256.0 * 32.0],
    depth: [0.0, 0.0, -0.1, 1.0],
    w: [0.0, 0.0, 0.0, 1.0],
    near_depth: 1.0,
    far_depth: 0.0,
};

/// The same on every level; all that box by box in double precision finds, but for roundings; in ascending order.
#[test]
fn a_ray_finds_what_it_may_meet() {
    let mut chance = Chance(11);
    let (mut pending, mut found, mut again) = (Vec::new(), Vec::new(), Vec::new());
    let (mut alike, mut different, mut met) = (0, 0, 0);
    for round in 0..120 {
        let count = [1, 5, 16, 17, 200, 300, 1000][round % 7];
        // Along a line, so that neighbours are near each other; some are flat.
        let boxes: Boxes = (0..count)
            .map(|i| {
                let along = 8.0 * f64::from(i) / f64::from(count) - 4.0;
                let min = [along, chance.real(-4.0, 4.0), chance.real(1.5, 9.0)];
                let size = [0, 1, 2].map(|_| chance.real(0.0, 3.0).max(0.3) - 0.3);
                let max: [f64; 3] = std::array::from_fn(|axis| min[axis] + size[axis]);
                (min.map(|v| v as f32), max.map(|v| v as f32))
            })
            .collect();
        let (blocks, levels) = tree_over(&boxes);
        let tree = Tree {
            blocks: &blocks,
            levels: &levels,
        };
        let screen = [PERSPECTIVE, ORTHOGRAPHIC][round % 2];
        let rays = Rays::new(&screen);
        for _ in 0..60 {
            let sample = [0, 1].map(|_| chance.whole(0, 63));
            let ray = Ray::through(&rays, [0.0; 3], sample);
            let depth = chance.real(0.05, 0.9);
            found.clear();
            descend(Level::Scalar, tree, &ray, depth, &mut pending, &mut found);
            assert!(found.is_sorted());
            for &level in Level::available() {
                again.clear();
                descend(level, tree, &ray, depth, &mut pending, &mut again);
                assert_eq!(again, found, "{level}");
            }
            for (i, (min, max)) in (0..).zip(&boxes) {
                let wide = |corner: &[f32; 3]| corner.map(f64::from);
                let may_be = ray.may_be_before(wide(min), wide(max), depth);
                let is_found = found.binary_search(&i).is_ok();
                *(if may_be == is_found {
                    &mut alike
                } else {
                    &mut different
                }) += 1;
                met += usize::from(is_found);
            }
        }
    }
    assert!(
        met > 5_000 && different * 10_000 < alike,
        "{met} {alike} {different}"
    );
}
