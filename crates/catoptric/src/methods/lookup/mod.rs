//! Methods that look up the radiance of reflected rays.

pub mod environment_map;
pub mod light_field;
pub(super) mod reflector;
mod shader;
