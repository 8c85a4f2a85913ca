//! Methods that find where scene points appear, and draw moved geometry there.

pub mod drawing;
pub mod finder;
pub mod planar_mirror;
pub mod projector;

pub use projector::{MAX_BOUNCES, Projection, SpecularPath, VertexProjector};
