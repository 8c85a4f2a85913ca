//! The colours of surface points.

mod batch;
mod environment;
mod filter;
mod glossy;
mod microfacets;
mod sheen;
mod texture;
mod thin_film;
