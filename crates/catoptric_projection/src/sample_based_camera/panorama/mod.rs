//! Cameras for all directions about a point: cube ray maps (Popescu, Sacks, Mei 2006, section VI).

mod cameras;
pub(crate) mod cube;
mod project;
mod stored;

pub use cameras::{PanoramaSettings, PanoramicCameras, PanoramicMirrors};
pub use project::{PanoramicProjection, PanoramicProjector};
