//! Methods that look up the radiance of reflected rays.

pub mod environment_map;
pub mod layered_environment_map;
pub mod light_field;
mod shared;
