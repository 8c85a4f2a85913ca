//! Methods that find where scene points appear, and draw moved geometry there.

pub mod drawing;
pub mod finder;
pub mod path_perturbation;
pub mod planar_mirror;
pub mod projector;
pub mod ray_map;
pub mod virtual_mesh;

pub use projector::{MAX_BOUNCES, Projection, SpecularPath, VertexProjector};
