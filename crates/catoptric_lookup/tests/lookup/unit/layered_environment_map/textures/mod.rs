//! Textures on shells: depths, distances and texels.

mod bounds;
mod depths;
mod distances;
mod texture;
