//! Building blocks of built-in scenes: shapes, textures and the kit.

pub(super) mod kit;
pub(super) mod lizard;
pub(super) mod shapes;
pub(super) mod textures;
