//! Building blocks of built-in scenes: shapes, textures and the kit.

pub(super) mod kit;
pub(super) mod lizard;
pub(crate) mod shapes;
pub(crate) mod textures;
