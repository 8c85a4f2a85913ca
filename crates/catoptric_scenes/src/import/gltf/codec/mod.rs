//! Compressed geometry and textures.

pub(super) mod draco;
pub(super) mod ktx2;
pub(super) mod meshopt;
