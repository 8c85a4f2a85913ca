//! The rules about materials in a pose: which of them win for an object, and which have matched nothing.

use super::super::edits::LookRule;
use super::super::roles::RoleRule;
use super::super::{Material, Model, Role, Scene};
use crate::error::SceneError;

/// Names that a message lists, at most.
const MAX_LISTED: usize = 40;

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
    pub(super) fn new(model: &'a Model, roles: &'a [RoleRule], looks: &'a [LookRule]) -> Self {
        let roles: Vec<&RoleRule> = model.roles.iter().chain(roles).collect();
        let looks: Vec<&LookRule> = model.looks.iter().chain(looks).collect();
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
        let is_mirror = role.map_or(material.role, |rule| self.roles[rule].role()) == Role::Reflector;
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
        winners.role.map(|rule| self.roles[rule].role())
    }

    /// The material as the winners make it.
    pub(super) fn apply(&self, Winners { role, blend, look }: Winners, material: &Material) -> Material {
        let mut changed = role.map_or_else(|| material.clone(), |rule| self.roles[rule].apply(material));
        if let Some(rule) = blend {
            changed.blend = Some(self.model.blends[rule].blend());
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
