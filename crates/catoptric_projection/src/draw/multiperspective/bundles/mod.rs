//! Bundles of rays, the triangles that they meet, and the coverage of samples by these.

pub(crate) mod beam;
pub(crate) mod bundle;
pub(crate) mod coverage;
pub(crate) mod edges;
pub(crate) mod least_squares;
pub(crate) mod model;
