//! Bundles of rays, the triangles that they see, and what samples see of these.

pub(super) mod beam;
pub(super) mod bundle;
pub(super) mod coverage;
pub(super) mod edges;
pub(super) mod least_squares;
pub(super) mod model;
#[cfg(test)]
mod tests;
