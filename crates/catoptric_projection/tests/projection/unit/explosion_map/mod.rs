//! Cells of a reflector's rays, and profiles of extrusions.

mod cell_tree;
mod profile;
