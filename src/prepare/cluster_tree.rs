//! A hierarchy over the clusters of a mesh: boxes of sixteen that stand next to each other, and of sixteen of those, up to one
//! block. Clusters are cut from the top down, so neighbours in their order lie near each other, and the order is the hierarchy.

use std::ops::Range;

use antumbra_simd::tree::{Block, Tree, WIDTH};
use glam::DVec3;

use super::clusters::Cluster;
use crate::scene::Aabb;

/// The boxes above a mesh's clusters; none above a single one.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct ClusterTree {
    blocks: Vec<Block>,
    /// Where the blocks of each level begin, leaves first, and how many boxes are in them.
    levels: Vec<(u32, u32)>,
}

impl ClusterTree {
    /// That of some clusters.
    pub fn over(clusters: &[Cluster]) -> ClusterTree {
        let mut tree = ClusterTree::default();
        if clusters.len() < 2 {
            return tree;
        }
        tree.push_level(clusters.iter().map(|c| (c.min, c.max)));
        while let [.., (first, count)] = tree.levels[..]
            && count as usize > WIDTH
        {
            let below = &tree.blocks[first as usize..];
            let boxes: Vec<_> = below.iter().map(around).collect();
            tree.push_level(boxes.into_iter());
        }
        tree
    }

    fn push_level(&mut self, boxes: impl ExactSizeIterator<Item = ([f32; 3], [f32; 3])>) {
        let first = self.blocks.len();
        self.levels.push((first as u32, boxes.len() as u32));
        let count = boxes.len().div_ceil(WIDTH);
        self.blocks.resize(first + count, Block::EMPTY);
        for (place, (min, max)) in boxes.enumerate() {
            let block = &mut self.blocks[first + place / WIDTH];
            for axis in 0..3 {
                block.min[axis][place % WIDTH] = min[axis];
                block.max[axis][place % WIDTH] = max[axis];
            }
        }
    }

    /// The level and the number of the block that all others are below; none if there are no blocks.
    pub(crate) fn root(&self) -> Option<(usize, usize)> {
        self.levels.len().checked_sub(1).map(|top| (top, 0))
    }

    /// What is in a block: appends the boxes, local units, and gives their numbers, which are those of blocks of the level below, or
    /// of clusters on level 0.
    pub(crate) fn children(
        &self,
        level: usize,
        block: usize,
        boxes: &mut Vec<Aabb>,
    ) -> Range<usize> {
        let (first, count) = self.levels[level];
        let children = block * WIDTH..((block + 1) * WIDTH).min(count as usize);
        let block = &self.blocks[first as usize + block];
        let corner =
            |of: &[[f32; WIDTH]; 3], i: usize| DVec3::from_array(of.map(|axis| f64::from(axis[i])));
        boxes.extend((0..children.len()).map(|i| Aabb {
            min: corner(&block.min, i),
            max: corner(&block.max, i),
        }));
        children
    }

    /// What it takes, in bytes.
    pub fn memory_bytes(&self) -> usize {
        size_of_val(&self.blocks[..]) + size_of_val(&self.levels[..])
    }

    /// The same for the hot loops.
    pub(crate) fn for_loops(&self) -> Tree<'_> {
        Tree {
            blocks: &self.blocks,
            levels: &self.levels,
        }
    }
}

/// The box around the boxes of a block.
fn around(block: &Block) -> ([f32; 3], [f32; 3]) {
    let least = |axis: [f32; WIDTH]| axis.into_iter().fold(f32::INFINITY, f32::min);
    let largest = |axis: [f32; WIDTH]| axis.into_iter().fold(f32::NEG_INFINITY, f32::max);
    (block.min.map(least), block.max.map(largest))
}

#[cfg(test)]
mod tests {
    use super::*;

    fn cluster(x: f32) -> Cluster {
        Cluster {
            first_vertex: 0,
            first_quad: 0,
            vertex_count: 3,
            triangle_count: 1,
            quad_count: 1,
            double_sided: false,
            min: [x, -x, 0.0],
            max: [x + 1.0, 1.0, 2.0],
            cone: None,
        }
    }

    #[test]
    fn every_cluster_is_below_the_root_once_and_inside_all_above_it() {
        for count in [0, 1, 2, 15, 16, 17, 256, 257, 1000, 4097] {
            let clusters: Vec<Cluster> = (0..count).map(|i| cluster(i as f32)).collect();
            let tree = ClusterTree::over(&clusters);
            let everything = Aabb {
                min: DVec3::NEG_INFINITY,
                max: DVec3::INFINITY,
            };
            let mut pending: Vec<_> = tree.root().map(|r| (r, everything)).into_iter().collect();
            let mut found = Vec::new();
            while let Some(((level, block), above)) = pending.pop() {
                let mut boxes = Vec::new();
                for (child, inner) in tree.children(level, block, &mut boxes).zip(&boxes) {
                    assert!(above.contains(*inner));
                    if level > 0 {
                        pending.push(((level - 1, child), *inner));
                    } else {
                        assert_eq!(*inner, clusters[child].bounds());
                        found.push(child);
                    }
                }
            }
            found.sort_unstable();
            let all: Vec<usize> = if count < 2 {
                vec![]
            } else {
                (0..count).collect()
            };
            assert_eq!(found, all);
        }
    }
}
