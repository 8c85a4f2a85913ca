//! Methods that look up the radiance of reflected rays.

mod cube;
pub mod environment_map;
mod greedy;
mod lanes;
pub mod layered_environment_map;
pub mod light_field;
mod memory;
pub(super) mod reflector;
mod regions;
mod shader;
mod surround;
