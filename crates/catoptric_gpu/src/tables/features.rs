//! The features that a scene has: the code that draws it leaves the others out.

use crate::layout::{BINDINGS, BindingPlace, EXPRESSION, NONE, Surface, surface_flags as flags};
use catoptric::scene::{Role, Scene};

/// The number of yes-or-no features.
const COUNT: usize = 22;

/// The shaders' names of the features.
const NAMES: [&str; COUNT] = [
    "HAS_ENVIRONMENT",
    "HAS_LIGHTS",
    "HAS_SHADOWS",
    "HAS_MICROFACETS",
    "HAS_NORMAL_MAPS",
    "HAS_HIGHLIGHTS",
    "HAS_COATS",
    "HAS_LENSES",
    "HAS_ATTENUATION",
    "HAS_EXACT",
    HOLES,
    "HAS_COLORS",
    "HAS_SECOND_UVS",
    "HAS_HIGHER_DEGREES",
    "HAS_EXPRESSIONS",
    TURNS,
    ROUGH,
    LISTS,
    "ENDS_IN_ENVIRONMENT",
    LOBES,
    "HAS_SKY",
    "HAS_SUNS",
];

/// Surfaces have holes where their alpha is low.
const HOLES: &str = "HAS_HOLES";
/// Something refracts.
const LENSES: &str = "HAS_LENSES";
/// The geometry of paths is drawn.
const LISTS: &str = "HAS_LISTS";
/// Normal maps turn what mirrors, glass or coats reflect and refract.
const TURNS: &str = "HAS_TURNS";
/// Some mirrors or coats are rough.
const ROUGH: &str = "HAS_ROUGH";
/// Rays follow lobes of some surfaces.
const LOBES: &str = "HAS_LOBES";
/// The features that decide where rays go, and those that do so too where normal maps turn rays.
const OF_RAYS: [&str; 9] =
    [LENSES, "HAS_EXACT", HOLES, "HAS_HIGHER_DEGREES", "HAS_EXPRESSIONS", TURNS, ROUGH, LISTS, LOBES];
const OF_TURNED_RAYS: [&str; 2] = ["HAS_NORMAL_MAPS", "HAS_SECOND_UVS"];

/// The features that a scene has: each is a constant of the shaders.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub struct SceneFeatures {
    has: [bool; COUNT],
    /// The first textures of surfaces that any of them has.
    bindings_used: u32,
}

impl SceneFeatures {
    /// The features of a scene with these records of its objects.
    pub fn of(scene: &Scene, surfaces: &[Surface]) -> Self {
        let any = |flag: u32| surfaces.iter().any(|surface| surface.flags & flag != 0);
        let has_role =
            |role: Role| scene.objects.iter().any(|object| scene.materials[object.material as usize].role == role);
        let uses = |place: usize| surfaces.iter().any(|surface| surface.bindings[place].texture != NONE);
        let places = 0..BINDINGS;
        let has_suns = scene.sky.as_ref().is_some_and(|sky| !sky.suns().is_empty());
        Self {
            has: [
                scene.environment.is_some(),
                !scene.lights.is_empty(),
                scene.light_visibility.is_some() && (!scene.lights.is_empty() || has_suns),
                any(flags::MICROFACETS),
                uses(BindingPlace::Normals as usize) || uses(BindingPlace::CoatNormals as usize),
                surfaces.iter().any(|surface| surface.highlight_roughness >= 0.0),
                has_role(Role::Coated),
                has_role(Role::Lens),
                any(flags::ATTENUATION),
                any(flags::EXACT),
                any(flags::ALPHA_TESTED),
                !scene.colors.is_empty(),
                surfaces.iter().flat_map(|surface| &surface.bindings).any(|binding| binding.channel == 1),
                surfaces.iter().any(|surface| surface.exact.kind != 0),
                surfaces.iter().any(|surface| surface.exact.kind == EXPRESSION),
                surfaces.iter().any(|surface| surface.turning_map != NONE),
                surfaces.iter().any(|surface| surface.mirror_roughness > 0.0),
                false,
                scene.ends_in_environment && scene.environment.is_some(),
                surfaces.iter().any(|surface| surface.lobes != NONE),
                scene.sky.is_some(),
                has_suns,
            ],
            bindings_used: places.rev().find(|place| uses(*place)).map_or(0, |place| place as u32 + 1),
        }
    }

    /// True if something refracts.
    pub fn has_lenses(&self) -> bool {
        self.has_any(&[LENSES])
    }

    /// True if surfaces spread what they reflect or refract.
    pub fn spreads_light(&self) -> bool {
        self.has_any(&[TURNS, ROUGH, LOBES])
    }

    /// True if some mirrors or coats are rough.
    pub fn has_rough(&self) -> bool {
        self.has_any(&[ROUGH])
    }

    /// True if rays follow lobes of some surfaces.
    pub fn has_lobes(&self) -> bool {
        self.has_any(&[LOBES])
    }

    /// True if some surfaces have holes.
    pub fn has_holes(&self) -> bool {
        self.has_any(&[HOLES])
    }

    fn has_any(&self, names: &[&str]) -> bool {
        NAMES.iter().zip(self.has).any(|(name, has)| has && names.contains(name))
    }

    /// The same where the geometry of paths is drawn.
    pub fn with_lists(self) -> Self {
        Self { has: std::array::from_fn(|index| self.has[index] || NAMES[index] == LISTS), ..self }
    }

    /// The same without refraction, where all mirrors are smooth.
    pub fn of_smooth_mirrors(self) -> Self {
        Self { has: self.those(|name| ![LENSES, TURNS, ROUGH].contains(&name)), ..self }
    }

    /// The features alone that decide where rays go.
    pub fn of_rays(&self) -> Self {
        let turns = self.has_any(&[TURNS]);
        let decides = |name: &str| OF_RAYS.contains(&name) || turns && OF_TURNED_RAYS.contains(&name);
        Self { has: self.those(decides), bindings_used: 0 }
    }

    /// The features that the scene has among those that are named.
    fn those(&self, is_named: impl Fn(&str) -> bool) -> [bool; COUNT] {
        std::array::from_fn(|index| self.has[index] && is_named(NAMES[index]))
    }

    /// The values of the shaders' constants, by their names.
    pub fn constants(&self) -> Vec<(&'static str, f64)> {
        let number = |has: bool| if has { 1.0 } else { 0.0 };
        let features = NAMES.iter().zip(self.has).map(|(name, has)| (*name, number(has)));
        features.chain([("BINDINGS_USED", f64::from(self.bindings_used))]).collect()
    }
}
