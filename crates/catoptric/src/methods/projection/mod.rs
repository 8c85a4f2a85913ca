//! Methods that find where scene points appear, and draw moved geometry there.

pub mod drawing;
pub mod exact_search;
pub mod explosion_map;
pub mod finder;
pub mod path_perturbation;
pub mod planar_mirror;
mod polish;
pub mod projected;
pub mod projector;
pub mod ray_map;
pub mod reflector_search;
pub mod round_trip;
pub mod sample_based_camera;
pub mod virtual_mesh;
mod virtual_objects;
pub mod virtual_scene;
pub mod visibility;

pub use projected::ProjectedPaths;
pub use projector::{MAX_BOUNCES, Projection, SpecularPath, VertexProjector};
pub use round_trip::{RoundTrip, RoundTripError, RoundTripOptions, round_trip};
pub use visibility::PathVisibility;
