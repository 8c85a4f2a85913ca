//! Shells, textures and meshes of layers, what is inferred for them, and bakes.

mod bake;
mod inference;
mod mesh;
mod shell;
mod shells;
mod texels;
mod textures;
