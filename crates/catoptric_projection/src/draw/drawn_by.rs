//! Counts, for reports, of the pixels of reflectors and lenses by what has drawn them.
//!
//! A pixel is a reflector's if any of its samples shows a reflector or lens. It counts once, as drawn by
//!
//! * tiles, if any part of any path that it shows is drawn by these, be it from the second bounce on;
//! * else single rays, if any part is: of samples that are traced one by one, or of a rough mirror's grid;
//! * else the method's own geometry: virtual meshes, mirrored copies, or environment maps in place of them.

use catoptric_core::scene::Scene;
use catoptric_engine::method::Report;
use catoptric_engine::raster::{Fragment, FragmentBatch};
use glam::Vec2;
use std::sync::atomic::{AtomicU64, Ordering};

/// The pixels of reflectors and lenses that are not drawn by lists of geometry.
#[derive(Clone, Copy, Debug, Default)]
pub(crate) struct PixelsByOthers {
    pub(crate) tiles: u64,
    pub(crate) rays: u64,
}

/// The number of pixels that show reflectors and lenses, as shaders come upon them.
#[derive(Debug, Default)]
pub(super) struct ReflectorPixels {
    all: AtomicU64,
    /// Pixels whose shader traces their rays.
    followed: AtomicU64,
}

impl ReflectorPixels {
    /// Counts those of a batch: a part of a picture, of which every pixel comes once by first branches alone.
    /// `is_followed`: the shader follows a ray of the fragment, which is all that its pixel shows.
    pub(super) fn add(&self, scene: &Scene, batch: &FragmentBatch<'_>, is_followed: impl Fn(&Fragment<'_>) -> bool) {
        let (mut count, mut followed, mut last_pixel) = (0, 0, Vec2::NAN);
        // Neighbours mostly show the same.
        let mut last = (u32::MAX, false);
        for fragment in batch.iter() {
            if fragment.second_branches != 0 {
                return;
            }
            let Some(surface) = fragment.chain.first() else { continue };
            let object = scene.triangle_objects[surface.source as usize];
            if object != last.0 {
                last = (object, scene.role_of(object).is_specular());
            }
            if last.1 {
                // Fragments of a pixel follow each other.
                let pixel = fragment.position.floor();
                count += u64::from(pixel != last_pixel);
                last_pixel = pixel;
                followed += u64::from(is_followed(&fragment));
            }
        }
        self.all.fetch_add(count, Ordering::Relaxed);
        self.followed.fetch_add(followed, Ordering::Relaxed);
    }

    /// Adds the number to a report, divided by what has drawn them.
    pub(super) fn describe(&self, by: PixelsByOthers, report: &mut Report) {
        let [all, followed] = [&self.all, &self.followed].map(|count| count.load(Ordering::Relaxed));
        let rays = by.rays + followed;
        let by_method = all.saturating_sub(by.tiles + rays);
        report.counts.extend([
            ("reflector_pixels", all),
            ("reflector_pixels_by_method", by_method),
            ("reflector_pixels_by_tiles", by.tiles),
            ("reflector_pixels_by_rays", rays),
        ]);
    }
}
