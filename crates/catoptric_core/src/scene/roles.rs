//! Settings of objects by name, over the materials of the file: roles, and blends of mirrors.

use super::edits::LookRule;
use super::{AlphaMode, Blend, Material, Model, PoseOptions, Role, Scene};
use crate::error::SceneError;
use globset::{Glob, GlobMatcher};

/// Names that a message lists, at most.
const MAX_LISTED: usize = 40;

/// A name of nodes or materials, or a glob with `*`, `?`, `[...]`, `{a,b}`.
#[derive(Clone, Debug)]
pub(super) struct NamePattern {
    text: String,
    matcher: GlobMatcher,
}

impl NamePattern {
    /// A pattern as the part `kind` of a scene names it.
    pub(super) fn read(kind: &str, text: &str) -> Result<Self, SceneError> {
        let invalid = |error| SceneError::invalid(kind, text, format!("is neither a name nor a glob: {error}"));
        Self::new(text).map_err(invalid)
    }

    /// The pattern as it was given.
    pub(super) fn text(&self) -> &str {
        &self.text
    }

    fn new(text: &str) -> Result<Self, globset::Error> {
        // A name that is no valid glob is still matched literally.
        let glob = Glob::new(text).or_else(|_| Glob::new(&globset::escape(text)))?;
        Ok(Self { text: text.into(), matcher: glob.compile_matcher() })
    }

    pub(super) fn matches(&self, node: &str, material: &str) -> bool {
        // What has no name at all is still among everything.
        let has_name = !(node.is_empty() && material.is_empty());
        let is_match = |name: &str| !(has_name && name.is_empty()) && self.matcher.is_match(name);
        node == self.text || material == self.text || is_match(node) || is_match(material)
    }
}

/// Blends every mirror whose node or material name matches.
#[derive(Clone, Debug)]
pub struct BlendRule {
    pattern: NamePattern,
    blend: Blend,
}

impl BlendRule {
    /// A rule for `pattern`: a name or a glob, as of roles.
    ///
    /// # Errors
    /// [`SceneError::Invalid`] when the pattern is too large.
    pub fn new(pattern: &str, blend: Blend) -> Result<Self, SceneError> {
        Ok(Self { pattern: NamePattern::read("blend", pattern)?, blend })
    }

    /// The pattern as it was given.
    pub fn pattern(&self) -> &str {
        &self.pattern.text
    }

    /// Returns true if the rule is for a node or material of these names.
    pub fn matches(&self, node: &str, material: &str) -> bool {
        self.pattern.matches(node, material)
    }
}

/// Gives a role to every object whose node or material name matches.
#[derive(Clone, Debug)]
pub struct RoleRule {
    pattern: NamePattern,
    role: Role,
    ior: Option<f32>,
}

impl RoleRule {
    /// A rule for `pattern` (a name, or a glob with `*`, `?`, `[...]`, `{a,b}`); the index of refraction is for lenses.
    pub fn new(pattern: &str, role: Role, ior: Option<f32>) -> Result<Self, SceneError> {
        let invalid = |problem: String| SceneError::invalid("role", pattern, problem);
        let names = NamePattern::read("role", pattern)?;
        if let Some(ior) = ior.filter(|ior| !(0.1..=10.0).contains(ior)) {
            return Err(invalid(format!("the index of refraction {ior} is outside 0.1 to 10")));
        }
        Ok(Self { pattern: names, role, ior })
    }

    /// Reads `GLOB` or `GLOB:IOR`.
    pub fn parse_lens(text: &str) -> Result<Self, SceneError> {
        match text.rsplit_once(':').and_then(|(pattern, ior)| Some((pattern, ior.trim().parse().ok()?))) {
            Some((pattern, ior)) => Self::new(pattern, Role::Lens, Some(ior)),
            None => Self::new(text, Role::Lens, None),
        }
    }

    /// The pattern as it was given.
    pub fn pattern(&self) -> &str {
        &self.pattern.text
    }

    /// The role that it gives.
    pub fn role(&self) -> Role {
        self.role
    }

    /// The index of refraction that it gives, if any.
    pub fn ior(&self) -> Option<f32> {
        self.ior
    }

    /// Returns true if the rule is for a node or material of these names.
    pub fn matches(&self, node: &str, material: &str) -> bool {
        self.pattern.matches(node, material)
    }

    /// The material with the rule's role.
    pub fn apply(&self, material: &Material) -> Material {
        Material {
            role: self.role,
            ior: self.ior.unwrap_or(material.ior),
            schlick: false,
            blend: material.blend.filter(|_| self.role == Role::Reflector),
            coat: if self.role == Role::Coated { material.coat } else { 0.0 },
            // A role takes the place of lobes, and of veils.
            lobes: None,
            alpha_mode: match material.alpha_mode {
                AlphaMode::Blend => AlphaMode::Mask(0.5),
                other => other,
            },
            mirror_roughness: if self.role == material.role { material.mirror_roughness } else { 0.0 },
            ..material.clone()
        }
    }
}

/// The matches so far of a rule that blends mirrors.
#[derive(Clone, Debug, PartialEq)]
enum BlendUse {
    /// Nothing.
    None,
    /// Only surfaces that are no mirrors; this, for instance.
    Other(String),
    /// A mirror, or a surface that is none by the user's roles.
    Mirror,
}

/// All rules for the materials of a model, and which of them have matched.
pub(super) struct MaterialRules<'a> {
    model: &'a Model,
    roles: Vec<&'a RoleRule>,
    role_used: Vec<bool>,
    blend_uses: Vec<BlendUse>,
    looks: Vec<&'a LookRule>,
    look_used: Vec<bool>,
}

/// The numbers of the rules that win for a node's material, of each kind the last one that matches.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Hash)]
pub(super) struct Winners {
    role: Option<usize>,
    blend: Option<usize>,
    look: Option<usize>,
}

impl<'a> MaterialRules<'a> {
    /// The rules of a model, then further ones.
    pub(super) fn new(model: &'a Model, options: &'a PoseOptions) -> Self {
        let roles: Vec<&RoleRule> = model.roles.iter().chain(&options.roles).collect();
        let looks: Vec<&LookRule> = model.looks.iter().chain(&options.looks).collect();
        let (role_used, blend_uses) = (vec![false; roles.len()], vec![BlendUse::None; model.blends.len()]);
        let look_used = vec![false; looks.len()];
        Self { model, roles, role_used, blend_uses, looks, look_used }
    }

    /// The rules that win for a node's material.
    pub(super) fn winners(&mut self, node: &str, material: &Material) -> Winners {
        let mut role = None;
        for (index, rule) in self.roles.iter().enumerate() {
            if rule.matches(node, &material.name) {
                self.role_used[index] = true;
                role = Some(index);
            }
        }
        let is_mirror = role.map_or(material.role, |rule| self.roles[rule].role) == Role::Reflector;
        let mut blend = None;
        for (index, rule) in self.model.blends.iter().enumerate() {
            if !rule.matches(node, &material.name) {
                continue;
            }
            // Roles beyond the model's own apply to this pose alone: its blends may then be left without use.
            let overruled = role.is_some_and(|rule| rule >= self.model.roles.len());
            if is_mirror || overruled {
                self.blend_uses[index] = BlendUse::Mirror;
                blend = is_mirror.then_some(index);
            } else if self.blend_uses[index] == BlendUse::None {
                let name = if node.is_empty() { &material.name } else { node };
                self.blend_uses[index] = BlendUse::Other(name.into());
            }
        }
        let mut look = None;
        for (index, rule) in self.looks.iter().enumerate() {
            if rule.pattern.matches(node, &material.name) {
                self.look_used[index] = true;
                look = Some(index);
            }
        }
        Winners { role, blend, look }
    }

    /// The role that the winners give.
    pub(super) fn role_of(&self, winners: Winners) -> Option<Role> {
        winners.role.map(|rule| self.roles[rule].role)
    }

    /// The material as the winners make it.
    pub(super) fn apply(&self, Winners { role, blend, look }: Winners, material: &Material) -> Material {
        let mut changed = role.map_or_else(|| material.clone(), |rule| self.roles[rule].apply(material));
        if let Some(rule) = blend {
            changed.blend = Some(self.model.blends[rule].blend);
        }
        if let Some(rule) = look {
            self.looks[rule].look.apply(&mut changed);
        }
        changed
    }

    /// Returns true if every rule has matched something.
    pub(super) fn check(&self, scene: &Scene) -> Result<(), SceneError> {
        for (rule, found) in self.model.blends.iter().zip(&self.blend_uses) {
            if let BlendUse::Other(name) = found {
                let problem = format!("`{name}` is not a mirror: give it the role \"reflector\", or leave this out");
                return Err(self.model.invalid(&format!("blend.{}", rule.pattern()), problem));
            }
        }
        let role = self.role_used.iter().position(|used| !used);
        let blend = self.blend_uses.iter().position(|found| *found == BlendUse::None);
        // The field of the file, empty for roles that the user gives beyond it.
        let (name, field) = match (role, blend) {
            (Some(unused), _) if unused >= self.model.roles.len() => (self.roles[unused].pattern(), String::new()),
            (Some(unused), _) => (self.roles[unused].pattern(), format!("role.{}", self.roles[unused].pattern())),
            (None, Some(unused)) => {
                let name = self.model.blends[unused].pattern();
                (name, format!("blend.{name}"))
            }
            (None, None) => {
                let Some(unused) = self.look_used.iter().position(|used| !used) else { return Ok(()) };
                let name = self.looks[unused].pattern();
                (name, if unused < self.model.looks.len() { format!("material.{name}") } else { String::new() })
            }
        };
        self.unknown("node or material", name, &field, scene)
    }

    /// The error about a name that nothing has; the field of the file is empty for names that the user gives beyond it.
    pub(super) fn unknown(&self, kind: &'static str, name: &str, field: &str, scene: &Scene) -> Result<(), SceneError> {
        let names = self.names(kind, scene);
        let listed = match names.len() {
            0 => "none with a name; `*` is all of them".into(),
            1..=MAX_LISTED => names.join(", "),
            _ => names[..MAX_LISTED].join(", ") + ", ...",
        };
        let unknown = SceneError::unknown(kind, name, names, listed);
        if field.is_empty() { Err(unknown) } else { Err(self.model.invalid(field, unknown.to_string())) }
    }

    /// The names of a kind that rules can match, for messages.
    fn names<'s>(&'s self, kind: &str, scene: &'s Scene) -> Vec<&'s str> {
        let mut names: Vec<&str> = scene.objects.iter().map(|object| object.name.as_str()).collect();
        if kind != "node" {
            names.extend(self.model.materials.iter().map(|material| material.name.as_str()));
        }
        names.retain(|name| !name.is_empty());
        names.sort_unstable();
        names.dedup();
        names
    }
}
