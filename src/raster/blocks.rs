//! Polygons that are ready to be filled, and which rows of tiles they lie in: who fills some rows need not look at the
//! polygons of the others.

use antumbra_simd::TILE_SIZE;
use antumbra_simd::spans::{BLOCK, SpanBlock, SpanBlocks};

/// Blocks that miss the rows are taken along where fewer than this lie between two that meet them: looking at a few more
/// polygons costs less than beginning anew.
const WORTH_SKIPPING: usize = 3;

/// Blocks of polygons in the order to fill them.
#[derive(Clone, Debug, Default)]
pub struct BlockList {
    /// The blocks.
    pub blocks: SpanBlocks,
    /// Those of the blocks, as far as they were found.
    rows: Vec<BlockRows>,
}

/// Where a block's polygons lie: kept apart from the block, which is large and may be in another thread's cache.
#[derive(Clone, Copy, Debug)]
pub(super) struct BlockRows {
    /// The first row of tiles.
    pub first: i32,
    /// The last row of tiles, below the first if there is no polygon.
    pub last: i32,
    /// How many polygons there are.
    pub polygons: u32,
}

impl BlockList {
    /// Forgets all blocks.
    pub fn clear(&mut self) {
        self.blocks.clear();
        self.rows.clear();
    }

    /// Finds the rows of all blocks. Until then they count as lying in any row.
    pub fn find_rows(&mut self) {
        let unknown = &self.blocks[self.rows.len()..];
        self.rows.extend(unknown.iter().map(rows_of_block));
    }

    /// The rows of the blocks, as far as they were found.
    pub(super) fn rows(&self) -> &[BlockRows] {
        &self.rows
    }

    /// The blocks that may lie in rows of tiles from `first` to `last`, in their order.
    pub fn in_rows(&self, first: i32, last: i32) -> impl Iterator<Item = &[SpanBlock]> {
        let meets = move |rows: &BlockRows| rows.first <= last && rows.last >= first;
        let mut at = 0;
        std::iter::from_fn(move || {
            let known = self.rows.len();
            at += self.rows[at.min(known)..]
                .iter()
                .take_while(|r| !meets(r))
                .count();
            let from = at;
            let mut end = at;
            while at < known && at - end < WORTH_SKIPPING {
                at += 1;
                if meets(&self.rows[at - 1]) {
                    end = at;
                }
            }
            if at == known && at < self.blocks.len() {
                at = self.blocks.len();
                end = at;
            }
            (from < end).then(|| &self.blocks[from..end])
        })
    }
}

fn rows_of_block(block: &SpanBlock) -> BlockRows {
    let (mut first, mut last) = (f32::INFINITY, f32::NEG_INFINITY);
    for i in 0..BLOCK {
        if block.present >> i & 1 == 1 {
            first = first.min(block.y[0][i]);
            last = last.max(block.y[1][i]);
        }
    }
    // Casts stop at the largest and the least number.
    BlockRows {
        first: first as i32 / TILE_SIZE,
        last: last as i32 / TILE_SIZE,
        polygons: block.present.count_ones(),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// A block whose polygons lie in rows of tiles from `first` to `last`.
    fn block(first: i32, last: i32) -> SpanBlock {
        let mut block = SpanBlock::EMPTY;
        block.present = 0b10;
        block.y[0][1] = (first * TILE_SIZE) as f32;
        block.y[1][1] = (last * TILE_SIZE + 7) as f32;
        block
    }

    fn found(rows: &[[i32; 2]], first: i32, last: i32) -> Vec<Vec<i32>> {
        let mut list = BlockList::default();
        rows.iter()
            .for_each(|r| list.blocks.push(block(r[0], r[1])));
        list.find_rows();
        let first_row = |b: &SpanBlock| b.y[0][1] as i32 / TILE_SIZE;
        list.in_rows(first, last)
            .map(|run| run.iter().map(first_row).collect())
            .collect()
    }

    #[test]
    fn blocks_beside_the_rows_are_left_out() {
        assert_eq!(found(&[[0, 1], [2, 3], [4, 5]], 2, 3), [[2]]);
        assert_eq!(found(&[[0, 9], [2, 3], [4, 5]], 6, 8), [[0]]);
        assert!(found(&[[0, 1], [4, 5]], 2, 3).is_empty());
        assert!(found(&[], 0, 9).is_empty());
    }

    #[test]
    fn a_few_are_taken_along_between_others() {
        let far = [9, 9];
        assert_eq!(
            found(&[far, [1, 1], far, far, [2, 2], far], 0, 3),
            [[1, 9, 9, 2]]
        );
        assert_eq!(
            found(&[[1, 1], far, far, far, [2, 2], [3, 3]], 0, 3),
            [vec![1], vec![2, 3]]
        );
    }

    #[test]
    fn blocks_whose_rows_are_not_known_are_everywhere() {
        let mut list = BlockList::default();
        list.blocks.push(block(0, 0));
        assert_eq!(list.in_rows(5, 6).map(<[_]>::len).sum::<usize>(), 1);
        list.find_rows();
        assert_eq!(list.in_rows(5, 6).count(), 0);
        list.blocks.push(block(0, 0));
        assert_eq!(list.in_rows(5, 6).map(<[_]>::len).sum::<usize>(), 1);
    }
}
