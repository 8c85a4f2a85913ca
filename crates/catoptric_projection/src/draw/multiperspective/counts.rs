//! Counts of the work done by all threads.

use super::super::PixelsByOthers;
use catoptric_engine::method::Report;
use std::sync::atomic::{AtomicU32, AtomicU64, Ordering};

/// Counts of the work in all tiles.
#[derive(Debug, Default)]
pub(super) struct Counts {
    /// Rays that bundles were fitted to.
    pub(super) rays: AtomicU64,
    /// Tiles whose bundle was accurate.
    pub(super) tiles: AtomicU64,
    /// Tiles whose pixels have their own rays.
    pub(super) tiles_by_rays: AtomicU64,
    /// Tiles that were divided.
    pub(super) divided: AtomicU64,
    /// Pairs of a tile and a triangle that it may show.
    pub(super) pairs: AtomicU64,
    /// Pixels that were worked out sample by sample because they lie at the rim of a path.
    pub(super) rim_pixels: AtomicU64,
    /// Pixels that were worked out sample by sample because no bundle was accurate.
    pub(super) left_pixels: AtomicU64,
    /// Samples whose rays were traced.
    pub(super) traced: AtomicU64,
    /// Pixels by what draws their paths, the innermost counting.
    by_tiles: AtomicU64,
    by_rays: AtomicU64,
    /// Bits of the largest error of a bundle that was accepted, in pixels: those of positive numbers are in order.
    worst_px: AtomicU32,
}

impl Counts {
    pub(super) fn add(counter: &AtomicU64, more: usize) {
        counter.fetch_add(more as u64, Ordering::Relaxed);
    }

    /// Counts pixels that are drawn by tiles or by rays, and those of them that had counted as drawn by rays before.
    pub(super) fn add_pixels(&self, tiles: u32, rays: u32, no_longer_by_rays: u32) {
        Self::add(&self.by_tiles, tiles as usize);
        Self::add(&self.by_rays, rays as usize);
        self.by_rays.fetch_sub(no_longer_by_rays.into(), Ordering::Relaxed);
    }

    /// The pixels that no list alone draws.
    pub(super) fn pixels_by_others(&self) -> PixelsByOthers {
        let [tiles, rays] = [&self.by_tiles, &self.by_rays].map(|count| count.load(Ordering::Relaxed));
        PixelsByOthers { tiles, rays }
    }

    /// Counts a bundle that was accepted with an error.
    pub(super) fn accept(&self, error_px: f32) {
        Self::add(&self.tiles, 1);
        self.worst_px.fetch_max(error_px.max(0.0).to_bits(), Ordering::Relaxed);
    }

    /// Adds them to a report.
    pub(super) fn describe(&self, report: &mut Report) {
        let counts = [
            ("rays", &self.rays),
            ("tiles", &self.tiles),
            ("tiles_by_rays", &self.tiles_by_rays),
            ("tiles_divided", &self.divided),
            ("tile_triangles", &self.pairs),
            ("rim_pixels", &self.rim_pixels),
            ("rays_traced", &self.traced),
        ];
        for (name, count) in counts {
            report.counts.insert(name, count.load(Ordering::Relaxed));
        }
        report.error_px = Some(f32::from_bits(self.worst_px.load(Ordering::Relaxed)).into());
        report.add_fallback("traced_pixels", self.left_pixels.load(Ordering::Relaxed));
    }
}
