//! Environment maps: what engines use today.
//!
//! See this folder's `README.md`.

mod cube_map;
mod maps;
mod parallax;
mod settings;

pub use settings::{EnvironmentMapSettings, Parallax, Source};

use crate::clock::Stopwatch;
use crate::error::RenderError;
use crate::framebuffer::Framebuffer;
use crate::methods::lookup::shader::draw;
use crate::methods::{Family, Job, MethodInfo, Quality, ReflectionMethod, Report, Settings};
use crate::progress::Progress;
use crate::scene::Scene;
pub(in crate::methods) use maps::ReflectorMaps;

/// What environment maps are.
pub static INFO: MethodInfo = MethodInfo {
    id: "environment_map",
    family: Family::Lookup,
    summary: "a cube map captured at each reflector's centre; at infinity, or corrected for a box or sphere",
    paper: "Blinn, Newell 1976, Texture and reflection in computer generated images; Greene 1986; \
            parallax correction: Lagarde, Zanuttini 2012",
    assumptions: "the surround is infinitely far, or lies on a box or sphere; one reflection, one refraction",
    cpu: true,
    gpu: false,
    bake: None,
    settings: EnvironmentMapSettings::describe,
    in_force: EnvironmentMapSettings::in_force,
    create: |table| {
        let settings = EnvironmentMapSettings::from_table(table)?;
        Ok(Box::new(EnvironmentMap { settings, maps: ReflectorMaps::default() }))
    },
};

struct EnvironmentMap {
    settings: EnvironmentMapSettings,
    /// Of all reflectors and lenses; with order 0 of none.
    maps: ReflectorMaps,
}

impl ReflectionMethod for EnvironmentMap {
    fn info(&self) -> &'static MethodInfo {
        &INFO
    }

    fn prepare(&mut self, scene: &Scene, quality: Quality, progress: &dyn Progress) -> Result<Report, RenderError> {
        let mut watch = Stopwatch::new();
        let reflectors = scene.specular_objects();
        self.maps = ReflectorMaps::capture(&self.settings, scene, &reflectors, quality.order, progress)?;
        let mut report = Report::default();
        report.counts.insert("captured_faces", self.maps.captured_faces());
        let bytes = self.maps.byte_count();
        report.stages_ms = vec![("capture", watch.lap_ms())];
        report.bytes.insert("environment_maps", bytes);
        Ok(report)
    }

    fn render(&mut self, job: &Job<'_>, target: &mut Framebuffer) -> Result<Report, RenderError> {
        if !self.maps.fit(job.scene) {
            let problem = "it has not been prepared for the scene".into();
            return Err(RenderError::Limit { method: INFO.id, problem });
        }
        draw(job, &self.maps, |_| true, target)
    }
}
