//! Methods: their declarations, settings and limits, and the states from settings to a picture.

pub mod bake;
mod life_cycle;
pub mod limits;
pub mod lookup_shader;
pub mod overlay;
pub mod path_lists;
pub mod path_query;
pub mod projector;
pub mod reflector_maps;
pub mod report;
mod settings;

pub use life_cycle::{About, Family, Frame, Method, MethodInfo, Prepared};
pub use report::{Choice, Job, Quality, Report};
pub use settings::{
    ChoiceSpec, Limits, SettingInfo, SettingKind, SettingSpec, SettingValue, Settings, setting_value, within,
};

pub use crate::{declare_choices, declare_settings};
