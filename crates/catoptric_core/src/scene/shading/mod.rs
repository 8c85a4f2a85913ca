//! The colours of surface points: textures and their filters, light, the environment.

mod arriving_light;
pub(super) mod batch;
pub(super) mod bumps;
mod drawn;
pub(super) mod environment;
pub(super) mod filter;
mod glossy;
mod lit_point;
pub(super) mod lobes;
pub mod microfacets;
mod passing;
pub(super) mod sample_patterns;
pub mod shade;
pub(super) mod sheen;
pub(super) mod sky;
pub(super) mod texture;
pub(super) mod thin_film;
