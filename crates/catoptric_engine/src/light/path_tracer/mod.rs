//! Specular paths, from the eye to the diffuse surfaces that they end on.

mod bounces;
mod lobe_light;
mod lobes;
mod near_plane;
mod path_model;
mod rough;
mod segment;
mod specular_paths;
mod waves;

pub use lobe_light::{LOBES, LobeLight};
pub use lobes::{SharedLight, SharedRays};
pub use near_plane::{NearPlane, specular_mask, surface_mask};
pub use path_model::{MIN_THROUGHPUT, PathModel};
pub use specular_paths::PathTracer;
pub use waves::{Cone, SeenSurface};
