//! Parameters of built-in scenes: the allowed and the checked values.

use catoptric_core::error::{SceneError, did_you_mean};
use catoptric_core::scene::{Attenuation, Blend};
use glam::Vec3;

/// A parameter of a built-in scene.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct ParameterInfo {
    /// The parameter's name.
    pub name: &'static str,
    /// The default value, as it is written in a specification.
    pub default: &'static str,
    /// The help text.
    pub help: &'static str,
    /// The values it takes.
    pub allowed: Allowed,
}

/// The values that a parameter takes.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Allowed {
    /// A whole number.
    Integer {
        /// The smallest.
        min: u64,
        /// The largest.
        max: u64,
    },
    /// A number.
    Number {
        /// The smallest.
        min: f32,
        /// The largest.
        max: f32,
    },
    /// One of these words.
    Choice(&'static [&'static str]),
}

impl std::fmt::Display for Allowed {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        match self {
            Self::Integer { min, max } => write!(f, "a whole number from {min} to {max}"),
            Self::Number { min, max } => write!(f, "a number from {min} to {max}"),
            Self::Choice(words) => write!(f, "{}", words.join(" or ")),
        }
    }
}

impl Allowed {
    fn accepts(&self, text: &str) -> bool {
        match *self {
            Self::Integer { min, max } => text.parse::<u64>().is_ok_and(|value| (min..=max).contains(&value)),
            Self::Number { min, max } => text.parse::<f32>().is_ok_and(|value| (min..=max).contains(&value)),
            Self::Choice(words) => words.contains(&text),
        }
    }
}

/// A parameter that takes whole numbers.
pub(super) const fn integer(
    name: &'static str,
    default: &'static str,
    help: &'static str,
    min: u64,
    max: u64,
) -> ParameterInfo {
    ParameterInfo { name, default, help, allowed: Allowed::Integer { min, max } }
}

/// A parameter that takes numbers.
pub(super) const fn number(
    name: &'static str,
    default: &'static str,
    help: &'static str,
    min: f32,
    max: f32,
) -> ParameterInfo {
    ParameterInfo { name, default, help, allowed: Allowed::Number { min, max } }
}

/// A parameter that takes one of several words; the first is the default.
pub(super) const fn choice(name: &'static str, help: &'static str, words: &'static [&'static str]) -> ParameterInfo {
    ParameterInfo { name, default: words[0], help, allowed: Allowed::Choice(words) }
}

/// The seed of a scene's random numbers.
pub(super) const SEED: ParameterInfo = integer("seed", "1", "another arrangement for every number", 0, u32::MAX as u64);

/// The choice of the exact surface (the default) or a mesh for a mirror.
pub(super) const EXACT_SURFACE: ParameterInfo =
    choice("surface", "the mirror is the exact surface of a formula, or a mesh", &["analytic", "mesh"]);

/// The choice of a mesh (the default) or the exact surface for a mirror.
pub(super) const SURFACE: ParameterInfo =
    choice("surface", "the mirror is a mesh, or the exact surface of a formula", &["mesh", "analytic"]);

/// The weights of the mirror's reflection against its own colour.
pub(super) const BLEND: ParameterInfo = choice(
    "blend",
    "the mirror's reflection over its own colour: all of it, weighed by angle, by distance, by both, or alike \
    everywhere",
    &["none", "fresnel", "attenuation", "both", "diffuse"],
);

/// The values of all parameters of a scene, checked.
pub(super) struct Values<'a> {
    infos: &'static [ParameterInfo],
    texts: Vec<&'a str>,
}

impl<'a> Values<'a> {
    /// The values given, and the defaults of the others.
    pub(super) fn new(
        scene: &str,
        infos: &'static [ParameterInfo],
        given: &[(&str, &'a str)],
    ) -> Result<Self, SceneError> {
        let invalid = |key: &str, problem: String| SceneError::invalid(format!("builtin:{scene}"), key, problem);
        let mut texts: Vec<Option<&'a str>> = vec![None; infos.len()];
        for (key, value) in given {
            let Some(index) = infos.iter().position(|info| info.name == *key) else {
                let known: Vec<String> = infos.iter().map(|info| format!("{} ({})", info.name, info.allowed)).collect();
                let hint = did_you_mean(key, infos.iter().map(|info| info.name));
                return Err(invalid(key, format!("no such parameter{hint}; there are: {}", known.join(", "))));
            };
            let allowed = infos[index].allowed;
            if !allowed.accepts(value) {
                return Err(invalid(key, format!("`{value}` is not allowed; it takes {allowed}")));
            }
            if texts[index].replace(value).is_some() {
                return Err(invalid(key, "given twice".into()));
            }
        }
        let texts = texts.iter().zip(infos).map(|(text, info)| text.unwrap_or(info.default)).collect();
        Ok(Self { infos, texts })
    }

    /// The scene's name with all parameters that differ from their defaults.
    pub(super) fn spec(&self, scene: &str) -> String {
        let mut spec = format!("builtin:{scene}");
        let changed = self.infos.iter().zip(&self.texts).filter(|(info, text)| info.default != **text);
        for (index, (info, text)) in changed.enumerate() {
            spec.push(if index == 0 { '?' } else { '&' });
            spec.push_str(&format!("{}={text}", info.name));
        }
        spec
    }

    /// The word given for a parameter of the scene.
    ///
    /// # Panics
    /// When the scene has no such parameter, which is a bug in the scene.
    pub(super) fn word(&self, name: &str) -> &'a str {
        match self.infos.iter().position(|info| info.name == name) {
            Some(index) => self.texts[index],
            None => panic!("the scene asks for a parameter `{name}` that it does not declare"),
        }
    }

    /// The whole number given for a parameter.
    pub(super) fn integer(&self, name: &str) -> u64 {
        match self.word(name).parse() {
            Ok(value) => value,
            Err(error) => panic!("the parameter `{name}` does not take whole numbers: {error}"),
        }
    }

    /// The number given for a parameter.
    pub(super) fn number(&self, name: &str) -> f32 {
        match self.word(name).parse() {
            Ok(value) => value,
            Err(error) => panic!("the parameter `{name}` does not take numbers: {error}"),
        }
    }

    /// The blend of mirrors, by [`BLEND`]; reflections fade within `distance` scene units.
    pub(super) fn blend(&self, distance: f32, diffuse: Vec3) -> Option<Blend> {
        let ramp = Some([0.2, 1.0]);
        let attenuation = Some(Attenuation { distance, specularity: [0.1, 1.0] });
        let (fresnel, attenuation) = match self.word(BLEND.name) {
            "fresnel" => (ramp, None),
            "attenuation" => (None, attenuation),
            "both" => (ramp, attenuation),
            "diffuse" => (Some([0.5, 0.5]), None),
            _ => return None,
        };
        Some(Blend { fresnel, attenuation, diffuse: Some(diffuse), ..Blend::default() })
    }

    /// The number of rings of curved surfaces.
    pub(super) fn tess(&self) -> u32 {
        self.integer("tess") as u32
    }

    /// Returns true if mirrors are exact surfaces.
    pub(super) fn analytic(&self) -> bool {
        self.word("surface") == "analytic"
    }
}
