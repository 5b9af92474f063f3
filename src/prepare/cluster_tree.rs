//! A hierarchy over the clusters of a mesh: boxes of sixteen that stand next to each other, and of sixteen of those, up to one
//! block. Clusters are cut from the top down, so neighbours in their order lie near each other, and the order is the hierarchy.

use antumbra_simd::tree::{Block, Tree, WIDTH};

use super::clusters::Cluster;

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
