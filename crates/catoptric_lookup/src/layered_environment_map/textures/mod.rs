//! Textures of layers on cube-map texels: radiance with transparency, depth intervals, and their look-up.

pub(crate) mod bounds;
pub(crate) mod depths;
pub(crate) mod distances;
pub(crate) mod maps;
pub(super) mod tables;
pub(crate) mod texture;
