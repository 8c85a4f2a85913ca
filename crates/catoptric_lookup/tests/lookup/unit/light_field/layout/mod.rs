//! Where the views of light fields are.

mod hemi_octahedron;
mod region_box;
mod slabs;
