//! The colours of surface points: textures and their filters, light, the environment.

mod drawn;
pub(super) mod environment;
mod filter;
pub(super) mod sample_patterns;
pub mod shade;
pub(super) mod shade_batch;
pub(super) mod texture;
