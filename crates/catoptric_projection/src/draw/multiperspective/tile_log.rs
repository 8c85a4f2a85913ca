//! A log of how the first bounce's pixels were divided into tiles, for an overlay.

use super::bundles::coverage::ROOT;
use catoptric_engine::method::overlay::{Overlay, OverlayKind, OverlaySegment};
use glam::IVec2;
use std::collections::BTreeSet;
use std::sync::{Mutex, PoisonError};

/// The way in which pixels were drawn.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub(super) enum TileWay {
    /// One bundle for the whole square.
    Bundle,
    /// A ray for each pixel.
    Rays,
    /// Rays of samples, one by one.
    Traced,
}

impl TileWay {
    const ALL: [Self; 3] = [Self::Bundle, Self::Rays, Self::Traced];

    /// The way of a square whose bundle is accurate or not.
    pub(super) fn of_square(is_accurate: bool) -> Self {
        if is_accurate { Self::Bundle } else { Self::Rays }
    }

    fn name(self) -> &'static str {
        match self {
            Self::Bundle => "one bundle of rays",
            Self::Rays => "a ray for each pixel",
            Self::Traced => "traced sample by sample",
        }
    }
}

/// A square of pixels that was drawn together.
#[derive(Clone, Copy)]
struct TileRecord {
    /// The first pixels of its root tile and of itself in the picture.
    root: IVec2,
    corner: IVec2,
    side: usize,
    way: TileWay,
    /// The pixels that are drawn, as bits of the root tile's rows.
    rows: [u16; ROOT],
}

/// The squares of a picture's first bounce.
#[derive(Default)]
pub(super) struct TileLog {
    records: Mutex<Vec<TileRecord>>,
}

impl TileLog {
    /// Adds pixels (bits of the root tile's rows) of a square that are drawn in a way.
    pub(super) fn add(&self, root: IVec2, corner: IVec2, side: usize, way: TileWay, rows: &[u16; ROOT]) {
        let record = TileRecord { root, corner, side, way, rows: *rows };
        self.records.lock().unwrap_or_else(PoisonError::into_inner).push(record);
    }

    /// The overlay of a picture of this size: pixels by the way in which they were drawn (where there are several
    /// paths, the slowest), the borders of squares, and those of root tiles.
    pub(super) fn overlay(self, size: [u32; 2]) -> Overlay {
        let records = self.records.into_inner().unwrap_or_else(PoisonError::into_inner);
        let [width, height] = size.map(|length| length as i32);
        let mut overlay = Overlay::new(OverlayKind::Tiles, size);
        let of_way = TileWay::ALL.map(|way| overlay.group(way.name()));
        let of_root = overlay.group("squares of 16 x 16 pixels");
        overlay.pixels = vec![0; width as usize * height as usize];
        // Neighbours share borders, and threads come in any order.
        let mut borders: BTreeSet<(u16, [i32; 4])> = BTreeSet::new();
        let mut add_border = |group: u16, corner: IVec2, side: usize| {
            let (low, high) = (corner, (corner + side as i32).min(IVec2::new(width, height)));
            for line in [
                [low.x, low.y, high.x, low.y],
                [low.x, high.y, high.x, high.y],
                [low.x, low.y, low.x, high.y],
                [high.x, low.y, high.x, high.y],
            ] {
                borders.insert((group, line));
            }
        };
        for TileRecord { root, corner, side, way, rows } in records {
            let group = of_way[way as usize];
            for (row, bits) in (0..).zip(rows) {
                for column in (0..ROOT as i32).filter(|column| bits >> column & 1 != 0) {
                    let at = root + IVec2::new(column, row);
                    if at.x < width && at.y < height {
                        let pixel = &mut overlay.pixels[(at.y * width + at.x) as usize];
                        *pixel = group.max(*pixel);
                    }
                }
            }
            // Traced pixels are no tile.
            if way != TileWay::Traced && rows.iter().any(|bits| *bits != 0) {
                add_border(group, corner, side);
            }
            add_border(of_root, root, ROOT);
        }
        for (group, line) in borders {
            let [x0, y0, x1, y1] = line.map(|place| place as f32);
            overlay.add_segment(OverlaySegment { ends: [[x0, y0].into(), [x1, y1].into()], group });
        }
        overlay
    }
}
