//! State of every projection method with virtual meshes: mirrors made ready, welded objects, meshes of earlier
//! frames.

mod drawing;
mod failed_paths;
mod geometry;
mod in_shares;
mod kept_meshes;
mod maker;
mod mirror_state;
pub(crate) mod rigid_motion;
mod scene;
mod whole_paths;

pub(crate) use geometry::{MeshesOfView, VirtualGeometry};
pub(crate) use mirror_state::MirrorState;
pub use scene::VirtualScene;
