//! Every way to draw reflections, behind one interface, in one table: [`all`].

pub mod budget;
pub mod reference;

pub use catoptric_engine::method::{
    About, Choice, ChoiceSpec, Family, Frame, Job, Limits, Method, MethodInfo, Prepared, Quality, Report, SettingInfo,
    SettingKind, SettingSpec, Settings, bake, limits, overlay, path_lists, path_query, projector, setting_value,
};
pub use {catoptric_lookup as lookup, catoptric_projection as projection};

use catoptric_engine::error::{RenderError, did_you_mean};

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
        hint: did_you_mean(id, all().iter().map(|info| info.id)),
        known: all().iter().map(|info| info.id).collect::<Vec<_>>().join(", "),
    })
}
