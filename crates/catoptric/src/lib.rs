//! Reflections and refractions of *near* objects in curved mirrors and glass, without tracing the scene a ray a pixel.
//!
//! A scene point's reflection can be *found* (the projection family: moved geometry is drawn) or a reflected ray
//! can be *looked up* (the lookup family: radiance is fetched). Every method is measured against the same
//! ray-traced [`methods::reference`].
//!
//!
//! ```
//! use catoptric::framebuffer::Framebuffer;
//! use catoptric::methods::{self, Job, Quality};
//! use catoptric::progress::Silent;
//! use catoptric::scene::{PoseOptions, builtin};
//!
//! let model = builtin::load("sphere_room", &[("tess", "16")]).unwrap();
//! let scene = model.pose(&PoseOptions::default()).unwrap();
//! let view = scene.default_view(64, 48);
//! let mut method = methods::create("reference", &Default::default()).unwrap();
//! let quality = Quality { samples: 1, order: 2 };
//! method.prepare(&scene, quality, &Silent).unwrap();
//! let mut picture = Framebuffer::new(64, 48);
//! method.render(&Job { scene: &scene, view: &view, quality, progress: &Silent }, &mut picture).unwrap();
//! assert!(picture.pixels.iter().all(|pixel| pixel[0].is_finite()));
//! ```

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
