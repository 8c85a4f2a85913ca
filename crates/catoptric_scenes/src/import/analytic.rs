//! The keys that describe an analytic surface, the same in `.toml` scenes and in glTF extras.

use super::blend::BlendKeys;
use super::key_error::{KeyError, positive, wrong};
use catoptric_core::error::did_you_mean;
use catoptric_core::scene::Material;
use catoptric_core::surface::{AnalyticSurface, Ellipsoid, Implicit, Quadric, Revolution, Superquadric, Torus};
use glam::Vec3;

/// The kinds of surfaces.
const KINDS: [Kind; 8] = [
    Kind { name: "plane", parameters: &[numbers("size", 2)] },
    Kind { name: "sphere", parameters: &[numbers("radius", 1)] },
    Kind { name: "ellipsoid", parameters: &[numbers("radii", 3)] },
    Kind {
        name: "quadric",
        parameters: &[numbers("coefficients", 10), numbers("bounds_min", 3), numbers("bounds_max", 3)],
    },
    Kind { name: "torus", parameters: &[numbers("major_radius", 1), numbers("minor_radius", 1)] },
    Kind { name: "superquadric", parameters: &[numbers("radii", 3), numbers("exponents", 2)] },
    Kind { name: "revolution", parameters: &[numbers("height", 1), numbers("profile", 4)] },
    Kind {
        name: "implicit",
        parameters: &[
            Parameter { key: "expression", form: Form::Text },
            numbers("bounds_min", 3),
            numbers("bounds_max", 3),
        ],
    },
];

/// A kind of surface and its own keys; all of them must be given.
#[derive(Debug)]
pub(super) struct Kind {
    pub(super) name: &'static str,
    pub(super) parameters: &'static [Parameter],
}

/// A key of a kind.
#[derive(Debug)]
pub(super) struct Parameter {
    pub(super) key: &'static str,
    pub(super) form: Form,
}

/// The type of a key's value.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) enum Form {
    /// A count of finite numbers: in brackets, unless it is one.
    Numbers(usize),
    /// A text.
    Text,
}

/// The value of a key.
#[derive(Clone, Debug)]
pub(super) enum Value {
    /// The numbers, as many as its form takes.
    Numbers(Vec<f64>),
    /// A text.
    Text(String),
}

const fn numbers(key: &'static str, count: usize) -> Parameter {
    Parameter { key, form: Form::Numbers(count) }
}

/// The kind of this name, to be looked up before its keys.
pub(super) fn kind_named(name: &str) -> Result<&'static Kind, KeyError> {
    match KINDS.iter().find(|kind| kind.name == name) {
        Some(kind) => Ok(kind),
        None => Err(unknown_kind(name, kind_names())),
    }
}

/// The names of all kinds.
pub(super) fn kind_names() -> impl Iterator<Item = &'static str> + Clone {
    KINDS.iter().map(|kind| kind.name)
}

/// The error about a kind that is none of those known.
pub(super) fn unknown_kind(name: &str, known: impl Iterator<Item = &'static str> + Clone) -> KeyError {
    let listed: Vec<String> = known.clone().map(|kind| format!("`{kind}`")).collect();
    let hint = did_you_mean(name, known);
    KeyError {
        key: "surface",
        problem: format!("there is no kind `{name}`{hint}; supported are {}", listed.join(", ")),
    }
}

/// The keys of a surface as they were given; the place is not among them.
#[derive(Clone, Debug)]
pub(super) struct SurfaceKeys {
    pub(super) kind: &'static Kind,
    /// The values of the kind's parameters, in their order; `None` for those not given.
    pub(super) values: Vec<Option<Value>>,
}

/// The keys of a mirror's or lens's material as they were given.
#[derive(Clone, Debug)]
pub(super) struct MaterialKeys {
    pub(super) tint: Option<[f64; 3]>,
    pub(super) ior: Option<f64>,
    pub(super) roughness: Option<f64>,
    pub(super) inside: bool,
    pub(super) blend: BlendKeys,
}

impl SurfaceKeys {
    /// The numbers of one of the kind's parameters.
    fn parameter<const N: usize>(&self, key: &'static str) -> Result<[f64; N], KeyError> {
        let numbers = match self.value(key) {
            Some(Value::Numbers(numbers)) => <[f64; N]>::try_from(numbers.as_slice()).ok(),
            _ => None,
        };
        numbers.ok_or_else(|| {
            self.missing(key, &if N == 1 { "a number".into() } else { format!("{N} numbers in brackets") })
        })
    }

    fn value(&self, key: &str) -> Option<&Value> {
        let index = self.kind.parameters.iter().position(|parameter| parameter.key == key)?;
        self.values.get(index)?.as_ref()
    }

    fn missing(&self, key: &'static str, form: &str) -> KeyError {
        let problem = format!("missing; a surface of the kind `{}` needs `{key}`, {form}", self.kind.name);
        KeyError { key, problem }
    }

    /// The surface in its own frame.
    pub(super) fn surface(&self) -> Result<AnalyticSurface, KeyError> {
        let surface = match self.kind.name {
            "plane" => {
                let [width, height] = self.parameter("size")?;
                let half = |length| Ok::<f64, KeyError>(positive("size", length)? * 0.5);
                AnalyticSurface::Plane { half_width: half(width)?, half_height: half(height)? }
            }
            "sphere" => {
                let [radius] = self.parameter("radius")?;
                AnalyticSurface::Sphere { radius: positive("radius", radius)? }
            }
            "ellipsoid" => AnalyticSurface::Ellipsoid(Ellipsoid::new(self.parameter("radii")?)?),
            "quadric" => AnalyticSurface::Quadric(Quadric::new(
                self.parameter("coefficients")?,
                self.parameter("bounds_min")?,
                self.parameter("bounds_max")?,
            )?),
            "torus" => {
                let ([major], [minor]) = (self.parameter("major_radius")?, self.parameter("minor_radius")?);
                AnalyticSurface::Torus(Torus::new(major, minor)?)
            }
            "superquadric" => AnalyticSurface::Superquadric(Superquadric::new(
                self.parameter("radii")?,
                self.parameter("exponents")?,
            )?),
            "revolution" => {
                let [height] = self.parameter("height")?;
                AnalyticSurface::Revolution(Revolution::new(height, self.parameter("profile")?)?)
            }
            _ => {
                let Some(Value::Text(expression)) = self.value("expression") else {
                    return Err(self.missing("expression", "a text such as \"x^2 + y^2 + z^2 - 1\""));
                };
                let bounds = (self.parameter("bounds_min")?, self.parameter("bounds_max")?);
                AnalyticSurface::Implicit(Implicit::new(expression, bounds.0, bounds.1)?)
            }
        };
        Ok(surface)
    }
}

impl MaterialKeys {
    /// The material: glass where there is an index of refraction, else a mirror.
    pub(super) fn material(&self, name: &str) -> Result<Material, KeyError> {
        let mut tint = Vec3::ONE;
        if let Some(numbers) = self.tint {
            if numbers.iter().any(|number| !(0.0..=1.0).contains(number)) {
                return wrong("tint", format!("{numbers:?}; every number must be from 0 to 1"));
            }
            tint = Vec3::from(numbers.map(|number| number as f32));
        }
        let blend = self.blend.blend()?;
        let roughness = self.roughness.unwrap_or(0.0);
        if !(0.0..=0.5).contains(&roughness) {
            return wrong("roughness", format!("{roughness}; allowed is 0 to 0.5"));
        }
        let Some(ior) = self.ior else {
            let mirror_roughness = roughness as f32;
            return Ok(Material { blend, mirror_roughness, ..Material::mirror(name, tint) });
        };
        if self.roughness.is_some() {
            return wrong("roughness", "is for mirrors, not for lenses: leave out `roughness` or `ior`");
        }
        if !(0.1..=10.0).contains(&ior) {
            return wrong("ior", format!("{ior}; allowed is 0.1 to 10"));
        }
        if self.inside {
            return wrong("inside", "is for mirrors, not for lenses: leave out `inside` or `ior`");
        }
        if let Some(key) = self.blend.any() {
            return wrong(key, format!("is for mirrors, not for lenses: leave out `{key}` or `ior`"));
        }
        Ok(Material { base_color: tint.extend(1.0), ..Material::glass(name, ior as f32) })
    }
}
