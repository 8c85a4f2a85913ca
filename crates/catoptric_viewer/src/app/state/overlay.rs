//! Overlays on the screen: one texture each, as large as the picture.

use crate::studio::news::Overlaid;
use crate::studio::order::Wish;
use catoptric::methods::overlay::{Overlay, OverlayKind, OverlaySegment};
use eframe::egui::ecolor::Hsva;
use eframe::egui::{Color32, ColorImage, Context, TextureHandle, TextureOptions};
use std::sync::Arc;

/// How much of the picture the colours of pixels hide.
const PIXEL_OPACITY: f32 = 0.45;

/// The same of lines.
const LINE_OPACITY: f32 = 0.85;

/// The steps in which lines fade across pixels: opacities are made once, not for each pixel, which the window would
/// wait for.
const STEPS: usize = 32;

/// An overlay on the screen.
pub(in crate::app) struct ShownOverlay {
    pub(in crate::app) wish: Arc<Wish>,
    pub(in crate::app) overlay: Overlay,
    /// `None` where there is nothing to be shown.
    pub(in crate::app) texture: Option<TextureHandle>,
}

impl ShownOverlay {
    pub(in crate::app) fn new(ctx: &Context, Overlaid { wish, overlay, .. }: Overlaid) -> Self {
        let is_empty = overlay.pixels.is_empty() && overlay.segments.is_empty();
        let texture =
            (!is_empty).then(|| ctx.load_texture(overlay.kind.name(), image(&overlay), TextureOptions::NEAREST));
        Self { wish, overlay, texture }
    }
}

/// The colour of a group (its number less 1) of an overlay.
pub(in crate::app) fn color_of(kind: OverlayKind, group: usize) -> Color32 {
    // From green for what is drawn fast to red for what is not, and the lines between.
    const BY_SPEED: [[u8; 3]; 4] = [[60, 220, 110], [250, 205, 50], [240, 70, 60], [235, 235, 235]];
    if matches!(kind, OverlayKind::Tiles | OverlayKind::Leaves) {
        let [red, green, blue] = BY_SPEED[group.min(3)];
        return Color32::from_rgb(red, green, blue);
    }
    // Hues of numbers side by side are far apart.
    let hue = (0.58 + 0.618_034 * group as f32).fract();
    Hsva::new(hue, if group.is_multiple_of(2) { 0.85 } else { 0.6 }, 1.0, 1.0).into()
}

/// The overlay as a picture of the same size.
fn image(overlay: &Overlay) -> ColorImage {
    let size = overlay.size.map(|length| length as usize);
    let colors = || (0..overlay.groups.len()).map(|group| color_of(overlay.kind, group));
    // Group 0 is none.
    let of_pixels: Vec<Color32> = std::iter::once(Color32::TRANSPARENT)
        .chain(colors().map(|color| color.linear_multiply(PIXEL_OPACITY)))
        .collect();
    let of_lines: Vec<[Color32; STEPS + 1]> = colors()
        .map(|color| std::array::from_fn(|step| color.linear_multiply(LINE_OPACITY * step as f32 / STEPS as f32)))
        .collect();
    let mut image = ColorImage::filled(size, Color32::TRANSPARENT);
    for (pixel, &group) in image.pixels.iter_mut().zip(&overlay.pixels) {
        *pixel = of_pixels.get(usize::from(group)).copied().unwrap_or_default();
    }
    // Grids lie below what divides them.
    for segment in overlay.segments.iter().rev() {
        if let Some(colors) = usize::from(segment.group).checked_sub(1).and_then(|group| of_lines.get(group)) {
            draw_line(&mut image, segment, colors);
        }
    }
    image
}

/// Draws a line about a pixel wide: in each column (or row, if it is steep) over the two pixels that it lies between.
fn draw_line(
    image: &mut ColorImage,
    OverlaySegment { ends: [a, b], .. }: &OverlaySegment,
    fading: &[Color32; STEPS + 1],
) {
    let [width, height] = image.size.map(|length| length as i32);
    let change = *b - *a;
    let is_steep = change.y.abs() > change.x.abs();
    let [from, to] = if is_steep { [a.y, b.y] } else { [a.x, b.x] };
    let (low, high) = (from.min(to), from.max(to));
    let last = if is_steep { height } else { width } - 1;
    let first = (low.floor() as i32).clamp(0, last.max(0));
    for at in first..=((high.ceil() as i32 - 1).clamp(first, last.max(0))) {
        let middle = (at as f32 + 0.5).clamp(low, high);
        let share = if to == from { 0.0 } else { (middle - from) / (to - from) };
        let across = if is_steep { a.x + share * change.x } else { a.y + share * change.y } - 0.5;
        let beside = across.floor();
        for (place, weight) in [(beside, 1.0 - (across - beside)), (beside + 1.0, across - beside)] {
            let [x, y] = if is_steep { [place as i32, at] } else { [at, place as i32] };
            if weight > 0.0 && (0..width).contains(&x) && (0..height).contains(&y) {
                let pixel = &mut image.pixels[(y * width + x) as usize];
                *pixel = pixel.blend(fading[((weight * STEPS as f32).round() as usize).min(STEPS)]);
            }
        }
    }
}
