//! Explosion maps: reflected rays of a reflector's vertices, by where they hit a near and a far sphere, tell where
//! every point appears.
//!
//! See this folder's `README.md`.

mod cell_tree;
mod cells;
mod chart;
mod finder;
mod map;
mod mirror;
mod profile;
mod settings;
mod subdivision;
mod vertices;

pub use settings::{ExplosionMapSettings, Preset, Variant, VirtualVertex};
pub use vertices::ReflectorMap;

use super::virtual_objects::{Kept, Options, Recursion, Reflector};
use crate::clock::Stopwatch;
use crate::error::RenderError;
use crate::framebuffer::Framebuffer;
use crate::methods::projection::VertexProjector;
use crate::methods::{Family, Job, MethodInfo, Quality, ReflectionMethod, Report, Settings};
use crate::progress::Progress;
use crate::scene::Scene;
use finder::Finder;

/// What explosion maps are.
pub static INFO: MethodInfo = MethodInfo {
    id: "explosion_map",
    family: Family::Projection,
    summary: "maps of where a reflector's rays hit a near and a far sphere say in which tangent plane a vertex is mirrored",
    paper: "Ofek, Rappoport 1998, Interactive reflections on curved objects",
    assumptions: "reflectors are finely tessellated; the spheres about them hold nothing but them; answers are approximate",
    cpu: true,
    gpu: false,
    bake: None,
    settings: ExplosionMapSettings::describe,
    in_force: ExplosionMapSettings::in_force,
    create: |table| Ok(Box::new(ExplosionMapMethod::new(ExplosionMapSettings::from_table(table)?))),
};

/// The method with what it keeps from frame to frame.
struct ExplosionMapMethod {
    settings: ExplosionMapSettings,
    kept: Kept<Finder>,
}

impl ExplosionMapMethod {
    fn new(settings: ExplosionMapSettings) -> Self {
        Self { settings, kept: Kept::new(INFO.id) }
    }

    /// Builds the maps where the kept ones do not fit the view.
    fn build(&mut self, job: &Job<'_>) -> Result<(), RenderError> {
        if !self.kept.fits(job)? {
            let settings = &self.settings;
            let make = |reflector: &Reflector<'_>| Finder::new(reflector, &job.scene.bounds, settings);
            self.kept.build(job, make);
        }
        Ok(())
    }

    fn options(&self) -> Options {
        let recursion = match self.settings.virtual_vertex {
            // The solver starts at feet that obey the law as well as the mesh knows.
            VirtualVertex::Mirrored if self.settings.polish == 0 => Recursion::VirtualPoints,
            _ => Recursion::Feet,
        };
        Options { polish: self.settings.polish, recursion }
    }
}

impl ReflectionMethod for ExplosionMapMethod {
    fn info(&self) -> &'static MethodInfo {
        &INFO
    }

    fn prepare(&mut self, scene: &Scene, _quality: Quality, _progress: &dyn Progress) -> Result<Report, RenderError> {
        Ok(self.kept.prepare(scene, self.settings.longest_edge).0)
    }

    fn render(&mut self, job: &Job<'_>, target: &mut Framebuffer) -> Result<Report, RenderError> {
        let mut watch = Stopwatch::new();
        let mut report = Report::default();
        self.build(job)?;
        report.stages_ms.push(("build", watch.lap_ms()));
        let sizes = [self.settings.edge_error_px, self.settings.piece_px];
        self.kept.draw(job, self.options(), sizes, &mut report, target)?;
        Ok(report)
    }

    fn projector<'a>(&'a mut self, job: &Job<'a>) -> Result<Option<Box<dyn VertexProjector + 'a>>, RenderError> {
        self.build(job)?;
        Ok(Some(Box::new(self.kept.projector(job, self.options())?)))
    }
}
