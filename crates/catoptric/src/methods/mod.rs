//! Every way to draw reflections, behind one interface, in one table: [`all`].

pub mod bake;
pub mod budget;
pub mod limits;
pub mod lookup;
mod lookup_shader;
mod method;
pub mod overlay;
pub mod path_lists;
pub mod path_query;
pub mod projection;
pub mod projector;
pub mod reference;
mod reflector_maps;
mod report;
mod settings;

pub use method::{Family, Frame, Method, MethodInfo, Prepared};
pub use report::{Choice, Job, Quality, Report};
pub use settings::{ChoiceSpec, Limits, SettingInfo, SettingKind, SettingSpec, Settings, setting_value};
pub(crate) use settings::{SettingValue, declare_choices, declare_settings, within};

use crate::error::RenderError;

/// All methods, the reference first.
pub fn all() -> &'static [&'static MethodInfo] {
    static ALL: &[&MethodInfo] = &[
        &reference::INFO,
        &projection::auto::INFO,
        &lookup::environment_map::INFO,
        &lookup::light_field::INFO,
        &lookup::layered_environment_map::INFO,
        &projection::planar_mirror::INFO,
        &projection::multiperspective::INFO,
        &projection::path_perturbation::INFO,
        &projection::sample_based_camera::INFO,
        &projection::explosion_map::INFO,
        &projection::reflector_search::INFO,
    ];
    ALL
}

/// The method with this id and these settings.
pub fn create(id: &str, settings: &toml::Table) -> Result<Box<dyn Method>, RenderError> {
    (find(id)?.create)(settings)
}

/// The entry of the method with this id.
pub fn find(id: &str) -> Result<&'static MethodInfo, RenderError> {
    all().iter().copied().find(|info| info.id == id).ok_or_else(|| RenderError::UnknownMethod {
        id: id.into(),
        known: all().iter().map(|info| info.id).collect::<Vec<_>>().join(", "),
    })
}
