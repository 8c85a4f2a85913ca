//! Textures as tables for shaders.

use crate::error::GpuError;
use crate::layout::{Level, MAX_LEVELS, TextureRecord};
use catoptric::scene::{MipFilter, Scene, Texture, Wrap};

/// All textures.
#[derive(Clone, Debug, Default)]
pub struct TextureTables {
    /// One a texture.
    pub records: Vec<TextureRecord>,
    /// The texels of all of them.
    pub texels: Vec<[u16; 4]>,
}

/// The textures of a scene.
///
/// # Errors
/// [`GpuError::Limit`] for a texture of more than [`MAX_LEVELS`] mip levels, and for more than 2^32 texels.
pub fn texture_tables(scene: &Scene) -> Result<TextureTables, GpuError> {
    let mut tables = TextureTables::default();
    for texture in &scene.textures {
        let first = tables.texels.len();
        if texture.levels().len() > MAX_LEVELS || first + texture.texels().len() > u32::MAX as usize {
            let (width, height) = texture.size();
            return Err(GpuError::Limit {
                what: format!("the texture `{}`", texture.name),
                needed: format!("{width} x {height} texels"),
                allowed: "32,768 a side, and 4,294,967,295 texels in all".into(),
                remedy: "make it smaller, or use the CPU backend",
            });
        }
        tables.records.push(record(texture, first as u32));
        tables.texels.extend_from_slice(texture.texels());
    }
    Ok(tables)
}

fn record(texture: &Texture, first: u32) -> TextureRecord {
    let sampler = texture.sampler();
    let half = |linear: bool| if linear { 0.5 } else { 0.0 };
    let wrap = |wrap: Wrap| match wrap {
        Wrap::ClampToEdge => 0.0,
        Wrap::Repeat => 1.0,
        Wrap::MirroredRepeat => 0.5,
    };
    let uses_levels = sampler.mip_filter != MipFilter::None;
    let mut levels = [Level::default(); MAX_LEVELS];
    for (record, level) in levels.iter_mut().zip(texture.levels()) {
        *record = Level { size: level.size, first: first + level.first, stride: level.stride };
    }
    TextureRecord {
        size: texture.levels()[0].size,
        last_level: if uses_levels { (texture.levels().len() - 1) as f32 } else { -1.0 },
        nearest_level: if sampler.mip_filter == MipFilter::Nearest { 1.0 } else { 0.0 },
        magnified_half: half(sampler.magnify_linear),
        minified_half: half(sampler.minify_linear),
        wrap: [wrap(sampler.wrap_u), wrap(sampler.wrap_v)],
        levels,
    }
}
