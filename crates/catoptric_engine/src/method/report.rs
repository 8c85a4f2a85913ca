//! The quality and the arguments with which pictures are asked for, and reports of making them.

use crate::raster::RasterReport;
use catoptric_core::progress::Progress;
use catoptric_core::scene::{Material, Role, Scene, View};
use std::collections::BTreeMap;

/// The quality of a picture.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Quality {
    /// Antialiasing samples a pixel, at least 1.
    pub samples: u32,
    /// Highest number of specular events on a path; what lies beyond is black.
    pub order: u32,
}

/// One picture to be drawn: the arguments that drawing has everywhere.
#[derive(Clone, Copy)]
pub struct Job<'a> {
    /// The scene.
    pub scene: &'a Scene,
    /// The view of it.
    pub view: &'a View,
    /// Samples and order.
    pub quality: Quality,
    /// Receives the progress, and may cancel.
    pub progress: &'a dyn Progress,
}

/// Times, counts and warnings of a step of a method's work.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Report {
    /// Time of each stage in milliseconds, in order.
    pub stages_ms: Vec<(&'static str, f64)>,
    /// Counted things: rays, triangles, vertices...
    pub counts: BTreeMap<&'static str, u64>,
    /// Counts of things that could not be drawn exactly, by the reason or by what was drawn instead.
    pub fallbacks: BTreeMap<&'static str, u64>,
    /// Memory of the method's own tables.
    pub bytes: BTreeMap<&'static str, u64>,
    /// Warnings for the user.
    pub warnings: Vec<String>,
    /// The choices of a method that chooses a way for each reflector.
    pub choices: Vec<Choice>,
    /// The largest error of approximations that were accepted, in pixels, measured where they were made; `None` for
    /// methods that do not measure it.
    pub error_px: Option<f64>,
    /// The standard error of a pixel by sampling, root mean square over the picture and its colours, from how far two
    /// halves of the samples are apart: of linear radiance up to 1. `None` for methods that do not estimate it.
    pub noise: Option<f64>,
}

/// The way to draw a reflector or lens that a method has chosen.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Choice {
    /// The object's name.
    pub object: String,
    /// The id of the method that draws it.
    pub method: &'static str,
    /// Why.
    pub reason: String,
}

impl Report {
    /// The empty report: of steps that do nothing.
    pub fn none() -> &'static Self {
        static NONE: Report = Report {
            stages_ms: Vec::new(),
            counts: BTreeMap::new(),
            fallbacks: BTreeMap::new(),
            bytes: BTreeMap::new(),
            warnings: Vec::new(),
            choices: Vec::new(),
            error_px: None,
            noise: None,
        };
        &NONE
    }

    /// Adds the report of a later step: its stages behind these, its numbers in place of these.
    pub fn add(&mut self, later: Self) {
        self.stages_ms.extend(later.stages_ms);
        self.counts.extend(later.counts);
        self.fallbacks.extend(later.fallbacks);
        self.bytes.extend(later.bytes);
        self.warnings.extend(later.warnings);
        self.choices.extend(later.choices);
        self.error_px = later.error_px.or(self.error_px);
        self.noise = later.noise.or(self.noise);
    }

    /// Adds to the count of a fall-back, if there were any.
    pub fn add_fallback(&mut self, name: &'static str, count: u64) {
        if count > 0 {
            *self.fallbacks.entry(name).or_insert(0) += count;
        }
    }

    /// Adds the rasteriser's times and counts.
    pub fn add_raster(&mut self, raster: &RasterReport) {
        let RasterReport { raster_ms, shade_ms, resolve_ms, .. } = *raster;
        self.stages_ms.extend([("raster", raster_ms), ("shade", shade_ms), ("resolve", resolve_ms)]);
        self.counts.insert("triangles_drawn", raster.triangles);
        self.counts.insert("triangles_clipped", raster.clipped);
        self.counts.insert("fragments", raster.fragments);
    }
}

/// The warning that rough mirrors are drawn as smooth ones; `None` if the scene has none.
pub fn rough_mirrors(scene: &Scene) -> Option<String> {
    let names = named(scene, |material| material.reflection_roughness() > 0.0)?;
    Some(format!("rough mirrors are drawn as smooth ones: {names} (`multiperspective` blurs what they reflect)"))
}

/// The warning that normal maps of mirrors and lenses are not drawn; `None` if the scene has none.
pub fn bumpy_surfaces(scene: &Scene) -> Option<String> {
    let names = named(scene, |material| material.turning_map().is_some())?;
    Some(format!("bumpy surfaces reflect and refract as smooth ones: {names} (`multiperspective` draws normal maps)"))
}

/// The names of mirrors and lenses whose materials are such.
fn named(scene: &Scene, is_such: impl Fn(&Material) -> bool) -> Option<String> {
    /// More are counted, not named.
    const NAMED: usize = 3;
    let such = (0..scene.objects.len() as u32).filter(|&object| {
        let material = scene.material_of(object);
        material.role != Role::Diffuse && is_such(material)
    });
    let mut names: Vec<&str> = such.map(|object| scene.objects[object as usize].name.as_str()).collect();
    names.dedup();
    let more = names.len().saturating_sub(NAMED);
    names.truncate(NAMED);
    let all = names.join(", ");
    match (names.is_empty(), more) {
        (true, _) => None,
        (_, 0) => Some(all),
        _ => Some(format!("{all} and {more} more")),
    }
}
