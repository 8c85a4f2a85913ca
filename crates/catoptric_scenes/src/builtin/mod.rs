//! Built-in scenes: made by formulas, without files, the same on every machine.
//!
//! Every scene has a default camera, named objects and a parameter `tess` that scales the tessellation of its
//! curved meshes. Unless described otherwise, surfaces are unlit: their textures are radiance as they stand, with
//! a mild brightness a face so that boxes read as solid.

mod cars;
mod colonnade;
mod glass;
mod halls;
mod info;
mod parameters;
pub(crate) mod parts;
mod pots;
mod rooms;
mod shells;
mod spheres;
mod surfaces;

pub use info::BuiltinInfo;
pub use parameters::{Allowed, ParameterInfo};

use catoptric_core::error::SceneError;
use catoptric_core::scene::Model;
use parameters::Values;

/// All built-in scenes.
pub fn all() -> &'static [BuiltinInfo] {
    &[
        spheres::SPHERE_ROOM,
        spheres::TWO_SPHERES,
        pots::VASE,
        pots::TEAPOT,
        glass::GLASS_SPHERE,
        glass::GLASS_SLAB,
        glass::LENS,
        shells::DISH,
        rooms::PLANAR_MIRROR,
        shells::ELLIPSOID,
        shells::TORUS,
        cars::CAR,
        halls::LARGE_ROOM,
        colonnade::COLONNADE,
        surfaces::HIGHLIGHTS,
        surfaces::BRUSHED,
        surfaces::RIPPLED,
        surfaces::WORKSHOP,
    ]
}

/// The built-in scene of this name; parameters that are not given have their defaults.
///
/// # Errors
/// [`SceneError::Unknown`] for an unknown name, [`SceneError::Invalid`] for a parameter that is unknown, given
/// twice or outside its range; the message lists the allowed values.
pub fn load(name: &str, parameters: &[(&str, &str)]) -> Result<Model, SceneError> {
    let Some(info) = all().iter().find(|info| info.name == name) else {
        let known: Vec<&str> = all().iter().map(|info| info.name).collect();
        let listed = known.join(", ");
        return Err(SceneError::unknown("built-in scene", name, known, listed));
    };
    let values = Values::new(name, info.parameters, parameters)?;
    Ok((info.build)(&values.spec(name), &values))
}

/// The built-in scene of a specification `NAME` or `NAME?key=value&key=value`.
///
/// # Errors
/// As [`load`]; also when a parameter has no `=`.
pub fn parse(spec: &str) -> Result<Model, SceneError> {
    let (name, query) = spec.split_once('?').unwrap_or((spec, ""));
    let parameters: Result<Vec<(&str, &str)>, SceneError> = query
        .split('&')
        .filter(|pair| !pair.is_empty())
        .map(|pair| {
            pair.split_once('=').ok_or_else(|| {
                let problem = "a parameter is written key=value, and several are joined by &";
                SceneError::invalid(format!("builtin:{spec}"), pair, problem)
            })
        })
        .collect();
    load(name, &parameters?)
}
