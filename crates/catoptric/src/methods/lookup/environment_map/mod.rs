//! Environment maps.
mod cube_map;
mod parallax;
mod settings;
