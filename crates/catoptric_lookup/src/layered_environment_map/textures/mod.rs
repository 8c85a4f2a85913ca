//! Textures of layers on cube-map texels: radiance with transparency, depth intervals, and their look-up.

mod bounds;
pub(super) mod capture;
pub(super) mod depths;
pub(super) mod distances;
pub(super) mod maps;
pub(super) mod tables;
pub(super) mod texels;
pub(super) mod texture;
