//! Colours of diffuse surfaces, and of reflectors that look light up.

use super::reflector::ReflectorLook;
use crate::clock::Stopwatch;
use crate::error::RenderError;
use crate::framebuffer::Framebuffer;
use crate::methods::{Job, Report};
use crate::raster::{self, Fragment, Look, LookShader};
use crate::scene::{Scene, ViewRays};
use glam::Vec3;

/// Colours a view of the scene.
pub(super) struct LookupShader<'a, L> {
    pub(super) scene: &'a Scene,
    pub(super) rays: ViewRays,
    /// What reflectors and lenses look like.
    pub(super) reflectors: &'a L,
}

impl<L: ReflectorLook> LookShader for LookupShader<'_, L> {
    fn scene(&self) -> &Scene {
        self.scene
    }

    #[inline]
    fn look(&self, fragment: &Fragment<'_>) -> Look {
        let at = fragment.position;
        let Some(surface) = fragment.chain.first() else {
            let (ray, change) = self.rays.ray_with_differential(at.x, at.y);
            return Look::Color(self.reflectors.behind(self.scene, &ray, &change));
        };
        let object = self.scene.triangle_objects[surface.source as usize];
        let material = self.scene.material_of(object);
        if !material.role.is_specular() {
            let ray = self.rays.ray(at.x, at.y);
            return Look::of_diffuse(self.scene, surface, &ray, Vec3::ONE, Vec3::ZERO);
        }
        let (ray, change) = self.rays.ray_with_differential(at.x, at.y);
        let encounter = self.scene.drawn_encounter(surface, &ray, &change);
        Look::Color(self.reflectors.radiance(self.scene, &encounter, &ray, &change))
    }
}

/// Draws the wanted objects of a scene whose reflectors and lenses look light up.
///
/// # Errors
/// Those of the rasteriser.
pub(super) fn draw(
    job: &Job<'_>,
    reflectors: &impl ReflectorLook,
    is_wanted: impl Fn(u32) -> bool,
    target: &mut Framebuffer,
) -> Result<Report, RenderError> {
    let mut report = Report::default();
    let mut watch = Stopwatch::new();
    let list = raster::scene_draw_list(job.scene, job.view, |object| is_wanted(object).then_some(0));
    report.stages_ms.push(("project", watch.lap_ms()));
    report.counts.insert("vertices_projected", list.vertices.len() as u64);
    let shader = LookupShader { scene: job.scene, rays: job.view.rays(), reflectors };
    report.add_raster(&raster::draw(job.view, job.quality.samples, &[list], &shader, target)?);
    Ok(report)
}
