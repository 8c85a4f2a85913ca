//! Methods that look up the radiance of reflected rays.

pub mod environment_map;
