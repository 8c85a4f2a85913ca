//! Groups of lenses, the distant geometry around them, and the shells that its layers lie on.

pub(super) mod distant_geometry;
pub(super) mod group_layers;
pub(super) mod groups;
pub(super) mod layer_geometry;
pub(super) mod layers;
mod merging;
pub(super) mod shared_layer;
pub(super) mod shell;
pub(super) mod viewpoints;
