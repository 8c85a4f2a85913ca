//! Textures: linear 16-bit texels with mip levels, and glTF samplers.

use crate::framebuffer::linear_from_srgb;
use glam::{Vec2, Vec3};

/// The wrapping of a texture beyond its edges.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Wrap {
    /// The edge texel goes on.
    ClampToEdge,
    /// Every second copy is mirrored.
    MirroredRepeat,
    /// Copies side by side.
    Repeat,
}

/// The filter between texels and mip levels.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum MipFilter {
    /// The finest level always.
    None,
    /// The nearest level.
    Nearest,
    /// The two nearest levels, blended.
    Linear,
}

/// The filtering and wrapping of a texture; the fields are those of glTF's samplers.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Sampler {
    /// Beyond the left and right edges.
    pub wrap_u: Wrap,
    /// Beyond the top and bottom edges.
    pub wrap_v: Wrap,
    /// Blend texels where the texture is magnified.
    pub magnify_linear: bool,
    /// Blend texels where it is minified.
    pub minify_linear: bool,
    /// The use of mip levels under minification.
    pub mip_filter: MipFilter,
}

impl Default for Sampler {
    fn default() -> Self {
        Self {
            wrap_u: Wrap::Repeat,
            wrap_v: Wrap::Repeat,
            magnify_linear: true,
            minify_linear: true,
            mip_filter: MipFilter::Linear,
        }
    }
}

/// The change of texture coordinates from a pixel to its right and lower neighbour.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct UvFootprint {
    /// Change with the pixel's column.
    pub dx: Vec2,
    /// Change with the pixel's row.
    pub dy: Vec2,
    /// One look-up stands for this many samples of the pixel: see
    /// [`Barycentrics::samples`](super::shade::Barycentrics).
    pub samples: u32,
}

/// The place of a mip level among the texels.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct MipLevel {
    /// Width and height in texels.
    pub size: [f32; 2],
    /// The index of the level's first texel.
    pub first: u32,
    /// Texels from row to row. Each row is followed by one more texel: see [`Texture::texels`].
    pub stride: u32,
}

/// An image on its way to a mip level.
struct Image {
    width: u32,
    height: u32,
    texels: Vec<[u16; 4]>,
}

/// An image with its mip levels and sampler. Values are linear, alpha is not premultiplied.
#[derive(Clone, Debug, PartialEq)]
pub struct Texture {
    /// The image's name or file, for messages.
    pub name: String,
    pub(in super::super) sampler: Sampler,
    pub(in super::super) levels: Vec<MipLevel>,
    /// See [`Self::texels`].
    pub(in super::super) texels: Vec<[u16; 4]>,
    least_alpha: f32,
}

impl Texture {
    /// A texture of 8-bit sRGB colour with linear alpha, rows from the top; all mip levels are made here.
    ///
    /// `rgba` must hold `width * height` texels, both at least 1; missing texels are white.
    pub fn from_srgb8(name: &str, width: u32, height: u32, rgba: &[[u8; 4]], sampler: Sampler) -> Self {
        let decode: Vec<u16> =
            (0..256).map(|value| (linear_from_srgb(value as f32 / 255.0) * 65535.0 + 0.5) as u16).collect();
        let texels = rgba
            .iter()
            .map(|t| [decode[t[0] as usize], decode[t[1] as usize], decode[t[2] as usize], t[3] as u16 * 257])
            .collect();
        Self::from_linear16(name, width, height, texels, sampler)
    }

    /// A texture of 8-bit numbers that are no colours, rows from the top; else as [`Self::from_srgb8`].
    pub fn from_linear8(name: &str, width: u32, height: u32, rgba: &[[u8; 4]], sampler: Sampler) -> Self {
        let texels = rgba.iter().map(|texel| texel.map(|value| u16::from(value) * 257)).collect();
        Self::from_linear16(name, width, height, texels, sampler)
    }

    /// A texture of normals, rows from the top: from 0 for -1 to 255 for 1 in x (right), y (up) and z (outwards), as in
    /// glTF. They are given unit length; mip levels hold means, whose length tells how much normals differ.
    pub fn from_normals8(name: &str, width: u32, height: u32, rgba: &[[u8; 4]], sampler: Sampler) -> Self {
        let normal = |texel: &[u8; 4]| {
            Vec3::from([texel[0], texel[1], texel[2]].map(|value| f32::from(value) * (2.0 / 255.0) - 1.0))
        };
        Self::from_normals(name, width, height, rgba.iter().map(normal), sampler)
    }

    /// The same from normals of any length.
    pub fn from_normals(
        name: &str,
        width: u32,
        height: u32,
        normals: impl Iterator<Item = Vec3>,
        sampler: Sampler,
    ) -> Self {
        let coded = |normal: Vec3| {
            let coded = (normal.try_normalize().unwrap_or(Vec3::Z) * 0.5 + 0.5) * 65535.0 + 0.5;
            [coded.x as u16, coded.y as u16, coded.z as u16, u16::MAX]
        };
        Self::from_linear16(name, width, height, normals.map(coded).collect(), sampler)
    }

    /// A texture of linear 16-bit texels, rows from the top; all mip levels are made here.
    pub fn from_linear16(name: &str, width: u32, height: u32, mut texels: Vec<[u16; 4]>, sampler: Sampler) -> Self {
        let (width, height) = (width.max(1), height.max(1));
        texels.resize(width as usize * height as usize, [u16::MAX; 4]);
        let least_alpha = texels.iter().map(|texel| texel[3]).min().map_or(1.0, |least| f32::from(least) / 65535.0);
        let mut texture = Self { name: name.into(), sampler, levels: Vec::new(), texels: Vec::new(), least_alpha };
        let mut image = Some(Image { width, height, texels });
        while let Some(level) = image {
            texture.push(&level);
            image = if sampler.mip_filter != MipFilter::None { level.halved() } else { None };
        }
        texture
    }

    fn push(&mut self, image: &Image) {
        let Image { width, height, .. } = *image;
        let (size, first) = ([width as f32, height as f32], self.texels.len() as u32);
        self.levels.push(MipLevel { size, first, stride: width + 1 });
        self.texels.reserve((width as usize + 1) * height as usize);
        for row in image.texels.chunks_exact(width as usize) {
            let next = if self.sampler.wrap_u == Wrap::Repeat { row.first() } else { row.last() };
            self.texels.extend_from_slice(row);
            self.texels.extend(next);
        }
    }

    /// Width and height of the finest level, in texels.
    pub fn size(&self) -> (u32, u32) {
        let [width, height] = self.levels[0].size;
        (width as u32, height as u32)
    }

    /// The filter and the wrapping.
    pub fn sampler(&self) -> &Sampler {
        &self.sampler
    }

    /// The mip levels, the finest first; at least one.
    pub fn levels(&self) -> &[MipLevel] {
        &self.levels
    }

    /// The texels of all levels, linear RGBA, 65535 for 1. At the end of each row stands its right neighbour (its
    /// first texel where the image repeats, else its last), so that two neighbours are always read at once.
    pub fn texels(&self) -> &[[u16; 4]] {
        &self.texels
    }

    /// The least alpha of all texels.
    pub fn least_alpha(&self) -> f32 {
        self.least_alpha
    }

    /// The memory that the texels take.
    pub fn byte_count(&self) -> usize {
        self.texels.len() * 8
    }
}

impl Image {
    fn halved(&self) -> Option<Self> {
        if self.width == 1 && self.height == 1 {
            return None;
        }
        let (width, height) = ((self.width / 2).max(1), (self.height / 2).max(1));
        let mut texels = Vec::with_capacity(width as usize * height as usize);
        for y in 0..height {
            let (top, bottom) = span(y, height, self.height);
            for x in 0..width {
                let (left, right) = span(x, width, self.width);
                let (mut sum, mut count) = ([0u64; 4], 0u64);
                for row in top..bottom {
                    for column in left..right {
                        let texel = self.texels[row as usize * self.width as usize + column as usize];
                        for channel in 0..4 {
                            sum[channel] += texel[channel] as u64;
                        }
                        count += 1;
                    }
                }
                texels.push(sum.map(|value| ((value + count / 2) / count) as u16));
            }
        }
        Some(Self { width, height, texels })
    }
}

/// The texels of a level of `from` texels that texel `index` of the next level (`to` texels) averages.
fn span(index: u32, to: u32, from: u32) -> (u32, u32) {
    let begin = (index as u64 * from as u64 / to as u64) as u32;
    let end = ((index as u64 + 1) * from as u64).div_ceil(to as u64) as u32;
    (begin, end.min(from).max(begin + 1))
}
