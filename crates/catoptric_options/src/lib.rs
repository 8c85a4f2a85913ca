//! The options of scenes, roles of their parts, views and exposure: one definition for all programs that take them.

mod display;
pub mod parse;
mod roles;
mod scene;
mod view;

pub use display::{DisplayArgs, Tone};
pub use roles::{RoleWord, role_words, rules};
pub use scene::{ChoiceArgs, EnvironmentArgs, GlassArgs, PoseArgs, SceneArgs, Shadows, ThinGlass};
pub use view::{DEFAULT_FOV_DEG, ViewArgs};
