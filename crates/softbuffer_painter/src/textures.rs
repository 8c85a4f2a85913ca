//! The pictures that egui's meshes show, its letters among them.

use crate::color::{alpha, between, packed};
use egui::{ImageData, TextureFilter, TextureId, TextureOptions, TextureWrapMode, TexturesDelta};
use std::collections::HashMap;

/// A picture.
#[derive(Debug)]
pub(crate) struct Texture {
    pub(crate) size: [usize; 2],
    /// Row by row.
    texels: Vec<u32>,
    pub(crate) options: TextureOptions,
    /// Each texel hides what lies beneath.
    pub(crate) is_opaque: bool,
}

impl Texture {
    /// A row of texels.
    pub(crate) fn row(&self, row: usize) -> &[u32] {
        let start = row * self.size[0];
        self.texels.get(start..start + self.size[0]).unwrap_or_default()
    }

    /// The texel of a place that may lie beside the picture.
    pub(crate) fn texel(&self, column: i64, row: i64) -> u32 {
        let [column, row] = [(column, self.size[0]), (row, self.size[1])]
            .map(|(at, length)| wrapped(at, length, self.options.wrap_mode));
        self.texels.get(row * self.size[0] + column).copied().unwrap_or_default()
    }

    /// The colour at a place, in texels from the corner.
    pub(crate) fn sample(&self, [x, y]: [f64; 2], filter: TextureFilter) -> u32 {
        if filter == TextureFilter::Nearest {
            return self.texel(x.floor() as i64, y.floor() as i64);
        }
        let ([left, top], [x_share, y_share]) = ([x, y].map(|at| before(at).0), [x, y].map(|at| before(at).1));
        let line = |row: i64| between(self.texel(left, row), self.texel(left + 1, row), x_share);
        between(line(top), line(top + 1), y_share)
    }
}

/// Farther than this from a texture all places look the same.
pub(crate) const FAR: f64 = 1e9;

/// The texel whose middle lies before a place, and the share of the next one, of 256.
pub(crate) fn before(at: f64) -> (i64, u32) {
    // Places that meshes name may have any size.
    let at = at.clamp(-FAR, FAR);
    let first = (at - 0.5).floor();
    (first as i64, ((at - 0.5 - first) * 256.0).round() as u32)
}

fn wrapped(at: i64, length: usize, mode: TextureWrapMode) -> usize {
    let length = (length as i64).max(1);
    let inside = match mode {
        TextureWrapMode::ClampToEdge => at.clamp(0, length - 1),
        TextureWrapMode::Repeat => at.rem_euclid(length),
        TextureWrapMode::MirroredRepeat => {
            let phase = at.rem_euclid(2 * length);
            phase.min(2 * length - 1 - phase)
        }
    };
    inside as usize
}

/// All pictures of a window.
#[derive(Debug, Default)]
pub(crate) struct Textures {
    all: HashMap<TextureId, Texture>,
}

impl Textures {
    pub(crate) fn get(&self, id: TextureId) -> Option<&Texture> {
        self.all.get(&id)
    }

    /// Takes new pictures, whole ones and parts.
    pub(crate) fn update(&mut self, delta: &TexturesDelta) {
        for (id, images) in &delta.set {
            for image in images {
                let ImageData::Color(pixels) = &image.image;
                let texels = pixels.pixels.iter().map(|color| packed(*color));
                match image.pos {
                    None => {
                        let mut kept = self.all.remove(id).map(|texture| texture.texels).unwrap_or_default();
                        kept.clear();
                        kept.extend(texels);
                        let is_opaque = kept.iter().all(|texel| alpha(*texel) == 255);
                        let texture = Texture { size: pixels.size, texels: kept, options: image.options, is_opaque };
                        self.all.insert(*id, texture);
                    }
                    Some(place) => {
                        if let Some(texture) = self.all.get_mut(id) {
                            texture.options = image.options;
                            put(texture, place, pixels.size, &texels.collect::<Vec<_>>());
                        }
                    }
                }
            }
        }
    }

    /// Forgets pictures that are not needed any more.
    pub(crate) fn free(&mut self, delta: &TexturesDelta) {
        for id in &delta.free {
            self.all.remove(id);
        }
    }
}

/// Puts a part into a picture, as far as it lies in it.
fn put(texture: &mut Texture, [left, top]: [usize; 2], [width, height]: [usize; 2], texels: &[u32]) {
    let length = width.min(texture.size[0].saturating_sub(left));
    if length == 0 {
        return;
    }
    for (line, row) in texels.chunks_exact(width).zip(top..texture.size[1].min(top + height)) {
        let start = row * texture.size[0] + left;
        if let Some(target) = texture.texels.get_mut(start..start + length) {
            target.copy_from_slice(&line[..length]);
            texture.is_opaque &= target.iter().all(|texel| alpha(*texel) == 255);
        }
    }
}
