//! The parts that all methods of [`catoptric`](https://docs.rs/catoptric) stand on: paths of light, the radiance along
//! rays, rasterisation, error metrics, and the traits of a method.
//!
//! Programs use the crate `catoptric`, which gives all of this again; it alone promises that names stay as they are.

pub mod error;
pub mod light;
pub mod method;
pub mod metrics;
pub mod optics;
pub mod raster;
