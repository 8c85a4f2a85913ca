//! Explosion maps: reflected rays of a reflector's vertices, by where they hit a near and a far sphere, give where
//! every point appears.
//!
//! See this folder's `README.md`.

pub(crate) mod cell_tree;
mod cells;
mod limits;
mod locator;
mod map;
pub(crate) mod profile;
mod settings;
mod subdivision;
mod vertices;

pub use settings::{ExplosionMapSettings, Preset, Variant, VirtualVertex};
pub use vertices::ReflectorMap;

use crate::draw::prepared::ProjectionMethod;
use crate::draw::work_limit::WorkLimit;
use crate::find::virtual_objects::{Options, Reflector, ReflectorMesh, map_size};
use crate::virtual_object_method::{Reflectors, VirtualObjectMethod};
use catoptric_core::scene::{Scene, View};
use catoptric_engine::method::{About, Family, MethodInfo, Settings};
use locator::Finder;

/// Description of the method.
pub static INFO: MethodInfo = MethodInfo {
    id: "explosion_map",
    family: Family::Projection,
    summary: "maps of where a reflector's rays hit a near and a far sphere say in which tangent \
        plane a vertex is mirrored",
    paper: "Ofek, Rappoport 1998, Interactive reflections on curved objects",
    assumptions: "reflectors are finely tessellated; the spheres about them hold nothing but them; \
        answers are approximate",
    about: About {
        readme: include_str!("README.md"),
        draws: "every object as a virtual mesh in each mirror or lens that shows it; what takes too much work by tiles",
        costs: "maps of each reflector and the virtual meshes for every view; reflectors in which rays cross often \
            are drawn by tiles, as the work of a frame ends before",
        cannot: "rims of caustics are ragged, parts of lenses beside rims and where rays cross are left to tiles, and \
            nothing may stand inside a lens",
        useful: &["preset", "variant", "spheres"],
    },
    cpu: true,
    gpu: true,
    bake: None,
    settings: ExplosionMapSettings::describe,
    effective: ExplosionMapSettings::effective,
    limits: &limits::LIMITS,
    create: |table| Ok(Box::new(ProjectionMethod(ExplosionMaps(ExplosionMapSettings::from_table(table)?)))),
};

/// The method with its settings.
#[derive(Clone)]
struct ExplosionMaps(ExplosionMapSettings);

impl VirtualObjectMethod for ExplosionMaps {
    type Locator = Finder;
    type Pictures = ();

    const INFO: &'static MethodInfo = &INFO;

    fn longest_edge(&self) -> f32 {
        self.0.longest_edge
    }

    fn pictures(&self, _: &[ReflectorMesh], _: u32, _: Option<&()>) {}

    fn locators<'a>(
        &'a self,
        scene: &'a Scene,
        reflectors: &'a Reflectors<Self>,
        _: &'a View,
    ) -> impl Fn(&Reflector<'_>) -> Option<Finder> + 'a {
        let map_size = map_size(self.0.map_size, reflectors.meshes.len());
        let settings = ExplosionMapSettings { map_size, ..self.0.clone() };
        move |reflector: &Reflector<'_>| Finder::new(reflector, &scene.bounds, &settings)
    }

    fn options(&self) -> Options {
        Options { polish: self.0.polish, recursion: self.0.recursion() }
    }

    fn work_limit(&self) -> WorkLimit {
        self.0.work_limit()
    }

    fn sizes_px(&self) -> [f32; 2] {
        [self.0.edge_error_px, self.0.piece_px]
    }
}
