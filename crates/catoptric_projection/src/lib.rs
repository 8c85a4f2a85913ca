//! Methods that find where scene points appear, and draw moved geometry there.

pub mod auto;
pub mod draw;
pub mod explosion_map;
pub mod find;
pub mod measure;
pub mod multiperspective;
pub mod path_perturbation;
pub mod planar_mirror;
pub mod reflector_search;
pub mod sample_based_camera;
