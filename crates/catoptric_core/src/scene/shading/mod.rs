//! The colours of surface points: textures and their filters, light, the environment.

pub(super) mod batch;
mod drawn;
pub(super) mod environment;
mod filter;
pub(super) mod sample_patterns;
pub mod shade;
pub(super) mod texture;
