//! An overlay that shows the layer that each pixel is looked up in.

use super::lookup::{LensShader, Waiting};
use super::textures::maps;
use catoptric_core::framebuffer::Framebuffer;
use catoptric_engine::method::overlay::{Overlay, OverlayKind};
use catoptric_engine::raster::{Fragment, FragmentShader, LayerSurface};
use glam::{Vec2, Vec3};

/// Gives fragments of reflectors and lenses the number of the layer that shows there as a colour: 1 is the nearest one,
/// and fragments that show none have one more than all layers.
pub(super) struct LayerNumbers<'a, 's>(pub(super) &'a LensShader<'s>);

/// Stands for the background.
const BEHIND_ALL: f32 = 4096.0;

impl FragmentShader for LayerNumbers<'_, '_> {
    fn shade(&self, fragment: &Fragment<'_>) -> Vec3 {
        let mut waiting = Waiting::default();
        self.0.look(fragment, 0, &mut waiting);
        let lookups = waiting.iter().flat_map(|path| path.list.iter().zip(&path.rays));
        let brightest = lookups.max_by(|(a, _), (b, _)| a.share.max_element().total_cmp(&b.share.max_element()));
        let Some((lookup, (ray, _))) = brightest else { return Vec3::ZERO };
        let layer = maps::shown_layer(&self.0.maps[lookup.group], ray);
        Vec3::splat(layer.map_or(BEHIND_ALL, |number| number as f32 + 1.0))
    }

    fn is_present(&self, surface: &LayerSurface, position: Vec2) -> bool {
        self.0.is_present(surface, position)
    }
}

impl LayerNumbers<'_, '_> {
    /// The overlay of a picture that was drawn by it.
    pub(super) fn overlay(picture: &Framebuffer) -> Overlay {
        let mut overlay = Overlay::new(OverlayKind::Layers, [picture.width, picture.height]);
        let numbers = || picture.pixels.iter().map(|pixel| pixel[0]);
        let last = numbers().filter(|number| *number < BEHIND_ALL).fold(0.0, f32::max) as u16;
        for number in 1..=last {
            overlay.group(format!("layer {number}"));
        }
        let behind = overlay.group("behind all layers");
        overlay.pixels = numbers().map(|number| if number < BEHIND_ALL { number as u16 } else { behind }).collect();
        overlay
    }
}
