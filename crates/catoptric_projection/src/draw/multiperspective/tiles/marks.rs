//! Counts of the pixels of a tile that are drawn by tiles, and by single rays: every pixel counts once.

use super::super::bundles::coverage::ROOT;
use super::super::counts::Counts;

/// Pixels of a root tile, as bits of its rows.
pub(in super::super) type Rows = [u16; ROOT];

/// The pixels of a root tile, by the way in which parts of their paths were drawn so far.
#[derive(Clone, Copy, Default)]
struct RootMarks {
    tiles: Rows,
    /// Pixels of which no tile has drawn any part.
    rays: Rows,
}

/// The pixels of a tile.
#[derive(Default)]
pub(in super::super) struct PixelMarks {
    /// The marks of each root tile, by its place in the tile.
    roots: Vec<RootMarks>,
}

impl PixelMarks {
    /// Forgets all: another tile begins.
    pub(in super::super) fn clear(&mut self) {
        self.roots.clear();
    }

    /// Marks and counts pixels of a root tile, the first pixel of which has this column and row in a tile so wide.
    pub(in super::super) fn add(
        &mut self,
        ([column, row], width): ([usize; 2], usize),
        (tiles, rays): (&Rows, &Rows),
        counts: &Counts,
    ) {
        let root = row / ROOT * width.div_ceil(ROOT) + column / ROOT;
        if self.roots.len() <= root {
            self.roots.resize(root + 1, RootMarks::default());
        }
        let known = &mut self.roots[root];
        let [mut by_tiles, mut by_rays, mut no_longer] = [0; 3];
        for row in 0..ROOT {
            let new_tiles = tiles[row] & !known.tiles[row];
            let were_rays = new_tiles & known.rays[row];
            known.tiles[row] |= new_tiles;
            known.rays[row] &= !were_rays;
            let new_rays = rays[row] & !(known.tiles[row] | known.rays[row]);
            known.rays[row] |= new_rays;
            by_tiles += new_tiles.count_ones();
            by_rays += new_rays.count_ones();
            no_longer += were_rays.count_ones();
        }
        if by_tiles + by_rays > 0 {
            counts.add_pixels(by_tiles, by_rays, no_longer);
        }
    }
}
