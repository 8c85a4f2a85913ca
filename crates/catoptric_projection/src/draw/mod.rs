//! Drawing and shading of projected geometry, shared by all methods that find where scene points appear.
//!
//! Each specular path is a list of triangles in the layer of its number of bounces, confined by a stencil to where the
//! path without its last bounce shows the object of that bounce. A shader then walks along the surfaces that a pixel
//! shows, with the same optics and the same shading as the reference.
//!
//! At a lens light divides: reflection is the rasteriser's first [`Branch`](catoptric_engine::raster::Branch),
//! transmission its second. Every path belongs to exactly one sequence of branches (which of its bounces transmit), so
//! nothing is counted twice; a tile draws only the sequences that it shows, and one where there are no lenses.
//!
//! A path that entered a lens meets that lens's exit surface next, from inside. Nothing marks which of a lens's
//! triangles are exits: at the end of a path that entered, the nearest is one, and hides those beyond it.

mod drawing;
mod drawn_by;
pub(super) mod far_maps;
pub(super) mod flat_mirrors;
mod followed;
mod lists;
mod lobe_lights;
mod mesh_neighbours;
pub(super) mod multiperspective;
pub(super) mod overlays;
mod path_shader;
pub(super) mod prepared;
mod rough;
pub(super) mod stages;
pub mod virtual_mesh;
pub mod virtual_scene;
pub(super) mod work_limit;

pub use drawing::draw_paths;
pub(crate) use drawn_by::PixelsByOthers;
pub(crate) use far_maps::MapsInView;
pub use lists::PathGeometry;
pub(crate) use path_shader::PathShader;
