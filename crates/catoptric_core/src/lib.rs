//! Geometry, scenes and pictures that the methods of `catoptric` and the scenes of `catoptric_scenes` share.
//!
//! The crate `catoptric` re-exports these modules under the same names.

pub mod clock;
pub mod error;
#[cfg(feature = "openexr")]
pub mod exr_blocks;
pub mod framebuffer;
pub mod input;
pub mod math;
#[cfg(feature = "outputs")]
pub mod output;
pub mod parallel;
#[cfg(feature = "files")]
pub mod picture;
pub mod progress;
pub mod scene;
pub mod surface;
pub mod tone;
