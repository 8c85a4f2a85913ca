//! Formats of the pictures that pipelines draw.

use wgpu::TextureFormat;

/// Triangles' numbers, in two halves: 32 bits in one number cannot be antialiased.
pub(crate) const ID_FORMAT: TextureFormat = TextureFormat::Rg16Uint;
/// Linear colours.
pub(crate) const COLOR_FORMAT: TextureFormat = TextureFormat::Rgba32Float;
pub(crate) const DEPTH_FORMAT: TextureFormat = TextureFormat::Depth32Float;
/// Hits in two halves, and the number of the path that they are on.
pub(crate) const CONFINED_FORMAT: TextureFormat = TextureFormat::Rgba16Uint;
