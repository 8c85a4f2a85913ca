//! Shells, textures and meshes of layers, inference, and bakes.

mod bake;
mod inference;
mod mesh;
mod shell;
mod shells;
mod texels;
mod textures;
