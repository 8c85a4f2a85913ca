//! The sorting of triangles into the tiles that they may show in.

use super::kernel::{TILE, TilePlace, touches_tile};
use super::lists::DrawList;
use super::report::RasterReport;
use super::setup::{PictureSetup, SetupOutcome, SetupTriangle, set_up};
use std::ops::Range;

/// A piece of a list that is set up at once.
#[derive(Clone, Debug)]
pub(super) struct ListPart {
    pub(super) list: u32,
    pub(super) triangles: Range<u32>,
    /// The id of the list's first triangle.
    pub(super) first_id: u32,
}

/// The triangles of a piece, and their numbers sorted by tile.
#[derive(Debug)]
pub(super) struct Bins {
    pub(super) list: u32,
    pub(super) setup: Vec<SetupTriangle>,
    /// The start of each tile's numbers in `indices`; one more at the end. Empty: no triangle is in the picture.
    starts: Vec<u32>,
    indices: Vec<u32>,
    pub(super) report: RasterReport,
}

impl Bins {
    /// The numbers of those triangles that may show in a tile, in the order of the list.
    #[inline]
    pub(super) fn of_tile(&self, tile: usize) -> &[u32] {
        match self.starts.get(tile..tile + 2) {
            Some(range) => &self.indices[range[0] as usize..range[1] as usize],
            None => &[],
        }
    }
}

/// The tiles of a picture.
#[derive(Clone, Copy, Debug)]
pub(super) struct TileGrid {
    pub(super) columns: usize,
    pub(super) rows: usize,
}

impl TileGrid {
    pub(super) fn new(frame: &PictureSetup) -> Self {
        let tiles = |size: u32| (size as usize).div_ceil(TILE);
        Self { columns: tiles(frame.width), rows: tiles(frame.height) }
    }

    pub(super) fn place(&self, frame: &PictureSetup, tile: usize) -> TilePlace {
        let pixel = [(tile % self.columns * TILE) as i32, (tile / self.columns * TILE) as i32];
        let [cx, cy] = frame.center();
        TilePlace { pixel, from_center: [pixel[0] - cx, pixel[1] - cy] }
    }
}

/// Sets up a piece of a list and sorts its triangles into tiles.
pub(super) fn bin(frame: &PictureSetup, grid: &TileGrid, list: &DrawList, piece: &ListPart) -> Bins {
    let mut report = RasterReport::default();
    let mut setup: Vec<SetupTriangle> = Vec::with_capacity(piece.triangles.len());
    let mut pairs: Vec<(u32, u32)> = Vec::with_capacity(piece.triangles.len() * 3 / 2);
    for index in piece.triangles.clone() {
        let triangle = &list.triangles[index as usize];
        report.triangles += 1;
        let [a, b, c] = triangle.vertices.map(|vertex| list.vertices.get(vertex as usize));
        let (Some(a), Some(b), Some(c)) = (a, b, c) else { continue };
        let clip = |vertex: u32| list.clip_distances.get(vertex as usize).copied().unwrap_or(0.0);
        let [va, vb, vc] = triangle.vertices;
        let clip_distances = [clip(va), clip(vb), clip(vc)];
        let id = piece.first_id + index;
        let outcome = set_up(frame, [a, b, c], clip_distances, id, triangle.alpha_tested, |triangle| {
            let number = setup.len() as u32;
            if for_each_tile(frame, grid, &triangle, |tile| pairs.push((tile, number))) {
                setup.push(triangle);
            }
        });
        report.clipped += u64::from(outcome == SetupOutcome::Clipped);
    }
    report.binned = pairs.len() as u64;
    if pairs.is_empty() {
        return Bins { list: piece.list, setup, starts: Vec::new(), indices: Vec::new(), report };
    }
    // A counting sort: it keeps the order within a tile.
    let mut starts = vec![0u32; grid.columns * grid.rows + 1];
    for &(tile, _) in &pairs {
        starts[tile as usize + 1] += 1;
    }
    for tile in 1..starts.len() {
        starts[tile] += starts[tile - 1];
    }
    let mut next = starts.clone();
    let mut indices = vec![0u32; pairs.len()];
    for (tile, number) in pairs {
        let place = &mut next[tile as usize];
        indices[*place as usize] = number;
        *place += 1;
    }
    Bins { list: piece.list, setup, starts, indices, report }
}

/// Calls `found` for every tile that a triangle may show in, and returns whether there was one.
#[inline]
fn for_each_tile(frame: &PictureSetup, grid: &TileGrid, triangle: &SetupTriangle, mut found: impl FnMut(u32)) -> bool {
    let [first_column, last_column] = triangle.columns.map(|pixel| pixel as usize / TILE);
    let [first_row, last_row] = triangle.rows.map(|pixel| pixel as usize / TILE);
    // Few tiles: the kernel finds out faster than a test here.
    let test = (last_column - first_column + 1) * (last_row - first_row + 1) > 4;
    let mut any = false;
    for row in first_row..=last_row {
        for column in first_column..=last_column {
            let tile = row * grid.columns + column;
            if !test || touches_tile(triangle, &grid.place(frame, tile)) {
                found(tile as u32);
                any = true;
            }
        }
    }
    any
}
