//! Reflections and refractions of *near* objects in curved mirrors and glass, without tracing the scene a ray a pixel.
//!
//! A scene point's reflection can be *found* (the projection family: moved geometry is drawn) or a reflected ray
//! can be *looked up* (the lookup family: radiance is fetched). Every method is measured against the same
//! ray-traced [`methods::reference`].
//!

mod clock;
pub mod error;
pub mod framebuffer;
pub mod math;
pub mod methods;
pub mod metrics;
pub mod optics;
pub mod parallel;
#[cfg(feature = "files")]
pub mod picture;
pub mod progress;
pub mod raster;
pub mod scene;
pub mod surface;
