//! Reflections and refractions of *near* objects in curved mirrors and glass, without tracing the scene a ray a pixel.
//!
//! A scene point's reflection can be *found* (the projection family: moved geometry is drawn) or a reflected ray
//! can be *looked up* (the lookup family: radiance is fetched). Every method is measured against the same
//! ray-traced [`methods::reference`].
//!
//! ```
//! use catoptric::framebuffer::Framebuffer;
//! use catoptric::methods::{self, Quality};
//! use catoptric::progress::Silent;
//! use catoptric::scene::PoseOptions;
//! use catoptric_scenes::builtin;
//! use std::sync::Arc;
//!
//! let model = builtin::load("sphere_room", &[("tess", "16")]).unwrap();
//! let scene = Arc::new(model.pose(&PoseOptions::default()).unwrap());
//! let view = scene.default_view(64, 48);
//! let method = methods::create("reference", &Default::default()).unwrap();
//! let quality = Quality { samples: 1, order: 2 };
//! let mut prepared = method.prepare(&scene, quality, None, &Silent).unwrap();
//! let frame = prepared.frame(&view, &Silent).unwrap();
//! let mut picture = Framebuffer::new(64, 48);
//! frame.draw(&mut picture, &Silent).unwrap();
//! assert!(picture.pixels.iter().all(|pixel| pixel[0].is_finite()));
//! ```

pub mod methods;

#[cfg(feature = "outputs")]
pub use catoptric_core::output;
#[cfg(feature = "files")]
pub use catoptric_core::picture;
pub use catoptric_core::{clock, framebuffer, input, math, parallel, progress, scene, surface, tone};
pub use catoptric_engine::{error, light, metrics, optics, raster};
