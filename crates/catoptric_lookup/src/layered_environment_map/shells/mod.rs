//! Groups of lenses, the distant geometry around them, and the shells that its layers lie on.

mod capture;
pub(super) mod distant_geometry;
pub(crate) mod group_layers;
pub(crate) mod groups;
pub(crate) mod layer_geometry;
pub(crate) mod layers;
pub(crate) mod merging;
pub(super) mod shared_layer;
pub(crate) mod viewpoints;
