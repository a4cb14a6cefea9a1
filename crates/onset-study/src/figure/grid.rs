//! Decomposition of a grid of classes into few rectangles.

/// Block of cells of one class; its ends are exclusive.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) struct Block {
    pub(super) class: u8,
    pub(super) columns: (usize, usize),
    pub(super) rows: (usize, usize),
}

/// Decomposes the grid into disjoint blocks: runs along a row, joined with equal runs in the rows above. Missing cells have no block.
pub(super) fn blocks(columns: usize, classes: &[u8]) -> Vec<Block> {
    let mut blocks: Vec<Block> = Vec::new();
    if columns == 0 {
        return blocks;
    }
    // Blocks that end in the preceding row, by their first column.
    let mut open: Vec<Option<usize>> = vec![None; columns.min(classes.len())];
    for (row, cells) in classes.chunks(columns).enumerate() {
        let mut start = 0;
        for run in cells.chunk_by(|a, b| a == b) {
            let end = start + run.len();
            let above = open[start].map(|above| &mut blocks[above]).filter(|block| {
                block.class == run[0] && block.columns == (start, end) && block.rows.1 == row
            });
            if let Some(block) = above {
                block.rows.1 = row + 1;
            } else {
                open[start] = Some(blocks.len());
                blocks.push(Block {
                    class: run[0],
                    columns: (start, end),
                    rows: (row, row + 1),
                });
            }
            start = end;
        }
    }
    blocks
}

#[cfg(test)]
mod tests {
    use super::*;

    fn is_lossless(columns: usize, classes: &[u8]) -> usize {
        let merged = blocks(columns, classes);
        let mut painted = vec![None; classes.len()];
        for block in &merged {
            for row in block.rows.0..block.rows.1 {
                for column in block.columns.0..block.columns.1 {
                    let cell = painted[row * columns + column].replace(block.class);
                    assert_eq!(cell, None, "cell ({column}, {row}) is covered twice");
                }
            }
        }
        let painted: Vec<u8> = painted
            .into_iter()
            .map(|cell| cell.expect("covered"))
            .collect();
        assert_eq!(painted, classes);
        merged.len()
    }

    #[test]
    fn blocks_cover_every_cell_once_with_its_class() {
        let mut state = 1u32;
        for columns in 1..12 {
            for cells in [0, 1, columns, 3 * columns, 11 * columns - 1] {
                let classes: Vec<u8> = (0..cells)
                    .map(|_| {
                        state = state.wrapping_mul(1_664_525).wrapping_add(1_013_904_223);
                        (state >> 28) as u8 % 3
                    })
                    .collect();
                is_lossless(columns, &classes);
            }
        }
    }

    #[test]
    fn equal_neighbors_become_one_block() {
        assert_eq!(is_lossless(50, &[4; 2500]), 1);
        let halves: Vec<u8> = (0..2500).map(|i| u8::from(i % 50 >= 20)).collect();
        assert_eq!(is_lossless(50, &halves), 2);
        let disc: Vec<u8> = (0..10_000i32)
            .map(|i| u8::from((i % 100 - 50).pow(2) + (i / 100 - 50).pow(2) < 1600))
            .collect();
        assert!(is_lossless(100, &disc) < 300);
    }

    #[test]
    fn a_grid_without_columns_is_empty() {
        assert_eq!(blocks(0, &[]), []);
        assert_eq!(blocks(0, &[1, 2]), []);
    }
}
