//! Bundles of rays, the triangles that they see, and what samples see of these.

pub(crate) mod beam;
pub(crate) mod bundle;
pub(crate) mod coverage;
pub(crate) mod edges;
pub(crate) mod least_squares;
pub(crate) mod model;
