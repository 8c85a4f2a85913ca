//! The keys of the shapes of optics.

use super::super::super::key_error::{KeyError, positive};
use super::super::keys::{Keys, Located, Text};
use super::super::places::exact_point;
use super::profile::Profile;
use super::sheet::Window;
use catoptric_core::error::SceneError;
use glam::DVec3;

/// The kinds.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(in super::super) enum Kind {
    /// With the conic constant if the name says it, else those that are allowed.
    Conic(Option<f64>, [f64; 2]),
    Asphere,
    Cylinder,
    Cone,
    Disk,
    Lens,
}

const MAX_CONIC: f64 = 1e6;

const KINDS: [(&str, Kind); 10] = [
    ("conic", Kind::Conic(None, [-MAX_CONIC, MAX_CONIC])),
    ("paraboloid", Kind::Conic(Some(-1.0), [-1.0, -1.0])),
    ("hyperboloid", Kind::Conic(None, [-MAX_CONIC, -1.0])),
    ("ellipsoid of revolution", Kind::Conic(None, [-1.0, MAX_CONIC])),
    ("asphere", Kind::Asphere),
    ("cylinder", Kind::Cylinder),
    ("cone", Kind::Cone),
    ("axicon", Kind::Cone),
    ("disk", Kind::Disk),
    ("lens", Kind::Lens),
];

/// The names of all kinds.
pub(in super::super) fn kind_names() -> impl Iterator<Item = &'static str> + Clone {
    KINDS.iter().map(|(name, _)| *name)
}

/// The kind of a name.
pub(in super::super) fn kind_named(name: &str) -> Option<Kind> {
    KINDS.iter().find(|(known, _)| *known == name).map(|(_, kind)| *kind)
}

/// The error about a key, at its place.
pub(super) fn explain(table: &Keys<'_, '_>, error: KeyError) -> SceneError {
    table.blame(error.key, error.problem)
}

/// A length that must be given.
pub(super) fn read_length(table: &mut Keys<'_, '_>, key: &'static str) -> Result<f64, SceneError> {
    let given = table.number(key)?;
    let given = given.ok_or_else(|| table.missing(key, format!("missing; needed is `{key}`, a length")))?;
    positive(key, given.value).map_err(|error| explain(table, error))
}

/// A profile's own keys: all are optional but the radius of conics, their constant, and the terms of aspheres.
pub(super) fn read_profile(table: &mut Keys<'_, '_>, kind: Kind) -> Result<Profile, SceneError> {
    let curvature = match (table.number("radius")?, kind) {
        (Some(radius), _) => {
            positive("radius", radius.value.abs()).map_err(|error| explain(table, error))?;
            1.0 / radius.value
        }
        (None, Kind::Conic(..)) => {
            let problem = "missing; needed is the radius of curvature at the vertex, negative for a mirror that bulges";
            return Err(table.missing("radius", problem));
        }
        (None, _) => 0.0,
    };
    let (constant, [least, most]) = match kind {
        Kind::Conic(constant, allowed) => (constant, allowed),
        _ => (Some(0.0), [-MAX_CONIC, MAX_CONIC]),
    };
    let conic = match (if least < most { table.number("conic_constant")? } else { None }, constant) {
        (Some(Located { begin, value }), _) if !(least..=most).contains(&value) => {
            let problem = format!("{value}; allowed is {least} to {most}");
            return Err(table.wrong("conic_constant", begin, problem));
        }
        (Some(given), _) => given.value,
        (None, Some(constant)) => constant,
        (None, None) => {
            let problem = "missing; it is 0 for spheres, -1 for paraboloids, below that for hyperboloids";
            return Err(table.missing("conic_constant", problem));
        }
    };
    let mut terms = [0.0; 4];
    if !matches!(kind, Kind::Conic(..)) {
        match table.one_or_more("coefficients", 4)? {
            Some(given) => terms.iter_mut().zip(&given.value).for_each(|(term, given)| *term = *given),
            None if kind == Kind::Asphere => {
                let problem = "missing; needed are the factors of r^4, r^6, r^8 and r^10, or the first of them";
                return Err(table.missing("coefficients", problem));
            }
            None => {}
        }
    }
    Ok(Profile { curvature, conic, terms })
}

/// Exactly one of `aperture_radius` and `aperture_size`, and where it is.
pub(super) fn read_window(text: Text<'_>, table: &mut Keys<'_, '_>) -> Result<Window, SceneError> {
    let (radius, size) = (table.number("aperture_radius")?, table.numbers::<2>("aperture_size")?);
    let center = match table.numbers::<2>("aperture_center")? {
        // To the right and up, as a plane mirror is seen.
        Some(Located { begin, value: [right, up] }) => {
            exact_point(text, &table.field("aperture_center"), Located { begin, value: [right, 0.0, -up] })?
        }
        None => DVec3::ZERO,
    };
    let length = |key, length| positive(key, length).map_err(|error| explain(table, error));
    match (radius, size) {
        (Some(radius), None) => Ok(Window::Round { radius: length("aperture_radius", radius.value)?, center }),
        (None, Some(Located { value: [width, height], .. })) => {
            let [width, height] = [length("aperture_size", width)?, length("aperture_size", height)?];
            Ok(Window::Rectangle { half: DVec3::new(width * 0.5, 0.0, height * 0.5), center })
        }
        (Some(_), Some(size)) => {
            Err(table.wrong("aperture_size", size.begin, "is for rectangles: leave out `aperture_radius` or this"))
        }
        (None, None) => {
            Err(table.missing("aperture_radius", "missing; needed is `aperture_radius`, or `aperture_size = [w, h]`"))
        }
    }
}
