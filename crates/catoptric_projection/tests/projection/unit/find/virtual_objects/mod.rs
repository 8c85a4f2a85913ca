//! Reflectors' meshes, their rays, facets and pieces.

mod facets;
mod mesh;
mod piece;
mod rays;
