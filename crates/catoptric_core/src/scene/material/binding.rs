//! Textures of materials.

use glam::Affine2;

/// The binding of a texture to a material.
#[derive(Clone, Debug, PartialEq)]
pub struct TextureBinding {
    /// Index into the scene's textures.
    pub texture: u32,
    /// The index of one of a vertex's two sets of texture coordinates.
    pub uv_channel: u8,
    /// Maps the vertex's texture coordinates to the texture's (KHR_texture_transform).
    pub texture_from_uv: Affine2,
}
