//! Colours of diffuse surfaces, and of reflectors that look light up.

use crate::clock::Stopwatch;
use crate::error::RenderError;
use crate::framebuffer::Framebuffer;
use crate::light::reflector_shader::ReflectorShader;
use crate::methods::{Job, Report};
use crate::raster::{self, Fragment, LookShader, ShadingRequest};
use crate::scene::{Scene, ViewRays};
use glam::Vec3;

/// Colours a view of the scene.
pub(crate) struct LookupShader<'a, L> {
    pub(crate) scene: &'a Scene,
    pub(crate) rays: ViewRays,
    /// Shading of reflectors and lenses.
    pub(crate) reflectors: &'a L,
}

impl<L: ReflectorShader> LookShader for LookupShader<'_, L> {
    fn scene(&self) -> &Scene {
        self.scene
    }

    #[inline]
    fn look(&self, fragment: &Fragment<'_>) -> ShadingRequest {
        let at = fragment.position;
        let Some(surface) = fragment.chain.first() else {
            let (ray, change) = self.rays.ray_with_differential(at.x, at.y);
            return ShadingRequest::Color(self.reflectors.behind(self.scene, &ray, &change));
        };
        let object = self.scene.triangle_objects[surface.source as usize];
        let material = self.scene.material_of(object);
        if !material.role.is_specular() {
            let ray = self.rays.ray(at.x, at.y);
            return ShadingRequest::of_diffuse(self.scene, surface, &ray, Vec3::ONE, Vec3::ZERO);
        }
        let (ray, change) = self.rays.ray_with_differential(at.x, at.y);
        let encounter = self.scene.drawn_encounter(surface.source, &surface.barycentrics, &ray, &change);
        ShadingRequest::Color(self.reflectors.radiance(self.scene, &encounter, &ray, &change))
    }

    fn eye(&self) -> Option<&ViewRays> {
        Some(&self.rays)
    }
}

/// Draws the wanted objects of a scene whose reflectors and lenses look light up.
///
/// # Errors
/// Errors of the rasteriser.
pub(crate) fn draw(
    job: &Job<'_>,
    reflectors: &impl ReflectorShader,
    is_wanted: impl Fn(u32) -> bool,
    target: &mut Framebuffer,
) -> Result<Report, RenderError> {
    let mut report = Report::default();
    let mut watch = Stopwatch::new();
    let list = raster::scene_draw_list(job.scene, job.view, |object| is_wanted(object).then_some(0));
    report.stages_ms.push(("project", watch.lap_ms()));
    report.counts.insert("vertices_projected", list.vertices.len() as u64);
    let shader = LookupShader { scene: job.scene, rays: job.view.rays(), reflectors };
    report.add_raster(&raster::draw(job.view, job.quality.samples, &[list], &shader, target, job.progress)?);
    Ok(report)
}
