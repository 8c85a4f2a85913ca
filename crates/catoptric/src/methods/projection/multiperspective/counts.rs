//! Counts of what was done, by all threads.

use crate::methods::Report;
use std::sync::atomic::{AtomicU64, Ordering};

/// What was done, in all tiles.
#[derive(Debug, Default)]
pub(super) struct Counts {
    /// Rays that bundles were fitted to.
    pub(super) rays: AtomicU64,
    /// Tiles whose bundle was accurate.
    pub(super) tiles: AtomicU64,
    /// Tiles that were divided.
    pub(super) divided: AtomicU64,
    /// Pairs of a tile and a triangle that it may show.
    pub(super) pairs: AtomicU64,
    /// Pixels that were worked out sample by sample because they lie at the rim of a path.
    pub(super) rim_pixels: AtomicU64,
    /// And because no bundle was accurate.
    pub(super) left_pixels: AtomicU64,
    /// Samples whose rays were traced.
    pub(super) traced: AtomicU64,
}

impl Counts {
    pub(super) fn add(counter: &AtomicU64, more: usize) {
        counter.fetch_add(more as u64, Ordering::Relaxed);
    }

    /// Adds them to a report.
    pub(super) fn describe(&self, report: &mut Report) {
        let counts = [
            ("rays", &self.rays),
            ("tiles", &self.tiles),
            ("tiles_divided", &self.divided),
            ("tile_triangles", &self.pairs),
            ("rim_pixels", &self.rim_pixels),
            ("rays_traced", &self.traced),
        ];
        for (name, count) in counts {
            report.counts.insert(name, count.load(Ordering::Relaxed));
        }
        report.add_fallback("traced_pixels", self.left_pixels.load(Ordering::Relaxed));
    }
}
