//! The dense map of reflected rays that cameras are fitted to.

mod creases;
pub(super) mod extent;
pub(super) mod follow;
pub(super) mod grid;
pub(super) mod grid_ray;
pub(super) mod path_rays;
pub(super) mod pieces;
pub(crate) mod primary_visibility;
mod rows;
pub(super) mod sampler;
pub(super) mod visible_pieces;
