//! Lobes that rays follow at surfaces.

use super::Binding;
use bytemuck::{Pod, Zeroable};
use catoptric::scene::LobeTexture;

/// Bits of [`LobesRecord::flags`].
pub mod lobe_flags {
    flags! {
        /// A wall without thickness: what passes goes straight on.
        THIN = 0;
        /// Both sides of such a wall reflect.
        PLATE = 1;
        /// There is a medium behind the surface.
        HAS_INSIDE = 2;
        /// Light goes straight on where the base colour's alpha is below 1.
        BLENDS = 3;
    }
}

/// The lobes of a surface. These records lie behind those of objects.
#[derive(Clone, Copy, Debug, Default, PartialEq, Pod, Zeroable)]
#[repr(C)]
pub struct LobesRecord {
    /// The share of the light that enters which passes.
    pub transmission: f32,
    /// See [`lobe_flags`].
    pub flags: u32,
    /// The factor on the slopes of the coat's normal map.
    pub coat_normal_scale: f32,
    /// Padding.
    pub unused: f32,
    /// Textures: see [`LobeTexture`].
    pub bindings: [Binding; LobeTexture::COUNT],
}
