//! Changes of a model by name, after its file was read: what is moved, and what looks otherwise.

use super::name_pattern::NamePattern;
use super::{Material, Microfacets, Role};
use crate::error::SceneError;
use glam::{Vec3, Vec4};

/// The largest distance that anything is moved.
const MAX_MOVE: f32 = 1e9;

/// Moves every node of a matching name, with everything beneath it.
#[derive(Clone, Debug)]
pub struct MoveRule {
    pub(super) pattern: NamePattern,
    pub(super) by: Vec3,
}

impl MoveRule {
    /// A rule for a name or a glob, as of roles: nodes, and meshes whose nodes have no name, go by so much in the
    /// world, whatever their animations do.
    ///
    /// # Errors
    /// [`SceneError::Invalid`] when the pattern is too large, or the way too long or not finite.
    pub fn new(pattern: &str, by: Vec3) -> Result<Self, SceneError> {
        if !(by.is_finite() && by.abs().max_element() <= MAX_MOVE) {
            let problem = format!("{by}; allowed is up to {MAX_MOVE:e} in each direction");
            return Err(SceneError::invalid("move", pattern, problem));
        }
        Ok(Self { pattern: NamePattern::read("move", pattern)?, by })
    }

    /// The pattern as it was given.
    pub fn pattern(&self) -> &str {
        self.pattern.text()
    }
}

/// A change of a material's look; what is `None` stays.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Look {
    /// Linear base colour: albedo, or the tint of a mirror or of glass. Multiplies the material's texture.
    pub color: Option<Vec3>,
    /// Perceptual roughness: of mirrors and coats to 0.5.
    pub roughness: Option<f32>,
    /// Index of refraction of glass and coats.
    pub ior: Option<f32>,
    /// See [`Material::priority`].
    pub priority: Option<i32>,
}

impl Look {
    /// The material with this look.
    pub fn apply(&self, material: &mut Material) {
        if let Some(color) = self.color {
            material.base_color = Vec4::from((color, material.base_color.w));
        }
        if let Some(roughness) = self.roughness {
            match material.role {
                Role::Reflector | Role::Coated => material.mirror_roughness = roughness.min(MAX_MIRROR_ROUGHNESS),
                Role::Diffuse => material.microfacets.get_or_insert_with(Microfacets::default).roughness = roughness,
                Role::Lens => {}
            }
        }
        material.ior = self.ior.unwrap_or(material.ior);
        material.priority = self.priority.unwrap_or(material.priority);
    }
}

/// Rougher mirrors are lit surfaces.
const MAX_MIRROR_ROUGHNESS: f32 = 0.5;

/// Changes the look of every material whose name, or whose node's name, matches.
#[derive(Clone, Debug)]
pub struct LookRule {
    pub(super) pattern: NamePattern,
    pub(super) look: Look,
}

impl LookRule {
    /// A rule for a name or a glob, as of roles.
    ///
    /// # Errors
    /// [`SceneError::Invalid`] when the pattern is too large or a number is outside its range.
    pub fn new(pattern: &str, look: Look) -> Result<Self, SceneError> {
        let invalid = |problem: String| Err(SceneError::invalid("material", pattern, problem));
        let Look { color, roughness, ior, .. } = look;
        if let Some(color) = color.filter(|color| !(color.min_element() >= 0.0 && color.max_element() <= 1.0)) {
            return invalid(format!("the colour {color} is outside 0 to 1"));
        }
        if let Some(roughness) = roughness.filter(|roughness| !(0.0..=1.0).contains(roughness)) {
            return invalid(format!("the roughness {roughness} is outside 0 to 1"));
        }
        if let Some(ior) = ior.filter(|ior| !(0.1..=10.0).contains(ior)) {
            return invalid(format!("the index of refraction {ior} is outside 0.1 to 10"));
        }
        Ok(Self { pattern: NamePattern::read("material", pattern)?, look })
    }

    /// The pattern as it was given.
    pub fn pattern(&self) -> &str {
        self.pattern.text()
    }
}
