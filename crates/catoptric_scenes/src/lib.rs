//! Scenes for `catoptric`: built-in ones, made by formulas, and readers of glTF, OBJ, TOML, HDR and EXR files.
//!
//! ```
//! use catoptric_core::scene::PoseOptions;
//!
//! let model = catoptric_scenes::builtin::parse("sphere_room?tess=16").unwrap();
//! let scene = model.pose(&PoseOptions::default()).unwrap();
//! assert_eq!(scene.specular_objects().len(), 1);
//! ```

pub mod builtin;
#[cfg(feature = "files")]
pub mod import;
#[cfg(feature = "files")]
mod opening;
mod sky;
mod studio;
mod tangents;

#[cfg(feature = "files")]
pub use opening::{Lighting, hint_on_missing, thin_glass};
pub use sky::sky;
pub use studio::{ENVIRONMENT_NAMES, light_if_dark, named_environment, studio};
