//! The search in pictures of reflectors: a point appears where a reflector's normal is the half vector of the
//! directions to the eye and to the point.
//!
//! See this folder's `README.md`.

pub(crate) mod image;
mod limits;
pub(crate) mod locator;
mod pictures;
mod settings;

pub use pictures::ReflectorPictures;
pub use settings::{Images, Preset, Refine, ReflectorSearchSettings, Search};

use crate::draw::prepared::ProjectionMethod;
use crate::draw::work_limit::WorkLimit;
use crate::find::virtual_objects::{Options, Recursion, Reflector, ReflectorMesh, map_size};
use crate::virtual_object_method::{Reflectors, VirtualObjectMethod};
use catoptric_core::parallel;
use catoptric_core::scene::{Scene, View};
use catoptric_engine::method::{About, Family, MethodInfo, Settings};
use image::ReflectorImage;
use locator::ReflectorSearch;
use std::sync::Arc;

/// Description of the method.
pub static INFO: MethodInfo = MethodInfo {
    id: "reflector_search",
    family: Family::Projection,
    summary: "a picture of the reflector's positions and normals is searched for the half vector of every vertex",
    paper: "Estalella, Martin, Drettakis, Tost 2006, A GPU-driven algorithm for accurate \
        interactive reflections on curved objects",
    assumptions: "reflectors are finely tessellated and smooth between creases; answers are approximate",
    about: About {
        readme: include_str!("README.md"),
        draws: "every object as a virtual mesh in each mirror or lens that shows it; what takes too much work by tiles",
        costs: "a picture of each reflector for every view (images=cube: once), and a search in it for every vertex",
        cannot: "silhouettes of reflectors that are not convex are ragged by up to piece_px, and of appearances close \
            to each other one can be missed",
        useful: &["images", "map_size", "refine", "polish"],
    },
    cpu: true,
    gpu: true,
    bake: None,
    settings: ReflectorSearchSettings::describe,
    effective: ReflectorSearchSettings::effective,
    limits: &limits::LIMITS,
    create: |table| Ok(Box::new(ProjectionMethod(ReflectorSearchMethod(ReflectorSearchSettings::from_table(table)?)))),
};

/// The method with its settings.
#[derive(Clone)]
struct ReflectorSearchMethod(ReflectorSearchSettings);

impl ReflectorSearchMethod {
    /// Texels a side of the cube maps of so many reflectors: as many texels around as there are in two pictures of half
    /// of it.
    fn cube_size(&self, reflectors: usize) -> u32 {
        map_size(self.0.map_size, reflectors).div_ceil(2)
    }
}

impl VirtualObjectMethod for ReflectorSearchMethod {
    type Locator = ReflectorSearch;
    /// Cube maps, one for each reflector where any path needs them.
    type Pictures = Vec<Arc<ReflectorImage>>;

    const INFO: &'static MethodInfo = &INFO;

    fn pictures(
        &self,
        meshes: &[ReflectorMesh],
        order: u32,
        old: Option<&Vec<Arc<ReflectorImage>>>,
    ) -> Vec<Arc<ReflectorImage>> {
        match old {
            Some(cubes) if cubes.len() == meshes.len() => cubes.clone(),
            _ if order <= 1 && self.0.images == Images::Eye => Vec::new(),
            _ => {
                let size = self.cube_size(meshes.len());
                meshes.iter().map(|mesh| Arc::new(ReflectorImage::around(mesh, size))).collect()
            }
        }
    }

    fn locators<'a>(
        &'a self,
        _: &'a Scene,
        reflectors: &'a Reflectors<Self>,
        view: &'a View,
    ) -> impl Fn(&Reflector<'_>) -> Option<ReflectorSearch> + 'a {
        let Reflectors { meshes, pictures: cubes, .. } = reflectors;
        let images = self.0.images;
        let size = map_size(self.0.map_size, meshes.len());
        let from_eye = |index: usize| ReflectorImage::from_eye(&meshes[index], view, size).map(Arc::new);
        let seen = match images {
            Images::Eye => parallel::map_collect(meshes.len(), from_eye),
            Images::Cube => Vec::new(),
        };
        move |reflector: &Reflector<'_>| {
            let image = match (reflector.index, reflector.view, images) {
                (Some(index), Some(_), Images::Eye) => seen.get(index as usize)?.clone()?,
                (Some(index), ..) => cubes.get(index as usize)?.clone(),
                (None, ..) => Arc::new(ReflectorImage::around(reflector.mesh, self.cube_size(meshes.len()))),
            };
            ReflectorSearch::new(reflector, image, self.0.search)
        }
    }

    fn options(&self) -> Options {
        let recursion = match self.0.refine {
            Refine::Corrected => Recursion::ReflectionPoints,
            Refine::Texel => Recursion::VirtualPoints,
        };
        Options { polish: self.0.polish, recursion }
    }

    fn work_limit(&self) -> WorkLimit {
        self.0.work_limit()
    }

    fn sizes_px(&self) -> [f32; 2] {
        [self.0.edge_error_px, self.0.piece_px]
    }
}
