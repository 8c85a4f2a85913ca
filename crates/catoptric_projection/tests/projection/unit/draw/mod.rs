//! Bundles of rays, virtual meshes, motions of mirrors and steps of work.

mod bundles;
mod rigid_motion;
mod virtual_mesh;
mod work_limit;
