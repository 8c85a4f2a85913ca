//! The surfaces that a tile's samples show, from its pixels: paths, squares with one bundle each, single rays.

mod cover;
pub(super) mod exact;
pub(super) mod follow;
pub(super) mod found;
pub(super) mod marks;
pub(super) mod own;
pub(super) mod paths;
pub(super) mod reflections;
pub(super) mod square;
