//! Layouts of the views of light fields.

mod hemi_octahedron;
mod region_box;
mod slabs;
