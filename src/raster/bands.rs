//! The picture's rows of tiles in bands that take about the same time to fill.
//!
//! What there is to draw often lies in a few rows: bands of equal heights would leave all threads waiting for one of them.
//! So rows are weighed by the polygons of the blocks that touch them. The bits do not depend on it.

use super::BlockList;

/// So many bands for each thread: the weights are a guess, and one who has guessed too low should not hold up the others.
const BANDS_PER_THREAD: usize = 2;

/// Bands of rows, from the top; kept from fill to fill.
#[derive(Clone, Debug, Default)]
pub struct Bands {
    /// The row after the last of each band.
    ends: Vec<usize>,
    /// How much more there is to do in a row than in the one above.
    steps: Vec<i64>,
}

impl Bands {
    /// Cuts `rows` rows into bands for so many threads, of equal weights as far as rows allow.
    pub fn weigh<'a>(
        &mut self,
        rows: usize,
        threads: usize,
        lists: impl Iterator<Item = &'a BlockList>,
    ) {
        let Bands { ends, steps } = self;
        ends.clear();
        if threads == 1 {
            return ends.push(rows);
        }
        steps.clear();
        steps.resize(rows + 1, 0);
        // Looking at a row takes time, too.
        steps[0] = 1;
        for block in lists.flat_map(BlockList::rows) {
            if block.first <= block.last {
                steps[block.first as usize] += i64::from(block.polygons);
                steps[block.last as usize + 1] -= i64::from(block.polygons);
            }
        }
        let weights = || {
            steps[..rows].iter().scan(0, |row, step| {
                *row += step;
                Some(*row)
            })
        };
        let all: i64 = weights().sum();
        let bands = (BANDS_PER_THREAD * threads) as i64;
        let mut above = 0;
        for (row, weight) in weights().enumerate() {
            above += weight;
            let is_share = above * bands >= all * (ends.len() as i64 + 1);
            if is_share || row + 1 == rows {
                ends.push(row + 1);
            }
        }
    }

    /// How many there are.
    pub fn count(&self) -> usize {
        self.ends.len()
    }

    /// How many rows `count` bands have from the one that begins at row `first`.
    pub fn rows_from(&self, first: usize, count: usize) -> usize {
        let band = self.ends.partition_point(|&end| end <= first);
        self.ends[band + count - 1] - first
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use antumbra_simd::TILE_SIZE;
    use antumbra_simd::spans::SpanBlock;

    fn bands(rows: usize, threads: usize, triangles: &[[i32; 2]]) -> Vec<usize> {
        let mut list = BlockList::default();
        for [first, last] in triangles {
            let mut block = SpanBlock::EMPTY;
            block.present = 1;
            block.y = [first, last].map(|row| [(row * TILE_SIZE) as f32; 8]);
            list.blocks.push(block);
        }
        list.find_rows();
        let mut bands = Bands::default();
        bands.weigh(rows, threads, std::iter::once(&list));
        let mut heights = Vec::new();
        let mut first = 0;
        for _ in 0..bands.count() {
            let height = bands.rows_from(first, 1);
            heights.push(height);
            first += height;
        }
        assert_eq!(first, rows);
        assert_eq!(bands.rows_from(0, bands.count()), rows);
        heights
    }

    #[test]
    fn one_thread_takes_all_rows() {
        assert_eq!(bands(96, 1, &[[3, 4]]), [96]);
    }

    #[test]
    fn rows_with_much_in_them_are_shared_out() {
        let busy = vec![[40, 47]; 1000];
        let heights = bands(96, 2, &busy);
        // As many bands as for any rows, and the eight busy ones by twos, more or less.
        assert_eq!(heights.len(), 4);
        let ends = heights.iter().scan(0, |end, height| {
            *end += height;
            Some(*end)
        });
        let mut first = 0;
        for end in ends {
            let busy = (40..48).filter(|row| (first..end).contains(row)).count();
            assert!((1..=3).contains(&busy), "{heights:?}");
            first = end;
        }
    }

    #[test]
    fn without_anything_to_draw_bands_are_alike() {
        let heights = bands(96, 2, &[]);
        assert!(heights.iter().all(|&h| h <= 25), "{heights:?}");
    }
}
