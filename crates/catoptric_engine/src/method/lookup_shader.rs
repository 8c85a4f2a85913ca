//! Colours of diffuse surfaces, and of reflectors that look light up.

use crate::error::RenderError;
use crate::light::reflector_shader::ReflectorShader;
use crate::method::overlay::paths::Numbers;
use crate::method::overlay::{self, Overlay};
use crate::method::projector::SpecularPath;
use crate::method::{Job, Report};
use crate::optics::path::bundle::Bounce;
use crate::raster::{self, Fragment, FragmentShader, LayerSurface, LookShader, ShadingRequest};
use catoptric_core::clock::Stopwatch;
use catoptric_core::framebuffer::Framebuffer;
use catoptric_core::scene::shade::SurfaceInteraction;
use catoptric_core::scene::{Ray, RayDifferential, Scene, ViewRays};
use glam::{Vec2, Vec3};

/// Colours a view of the scene.
pub struct LookupShader<'a, L> {
    /// The scene.
    pub scene: &'a Scene,
    /// The view's rays.
    pub rays: ViewRays,
    /// Shading of reflectors and lenses.
    pub reflectors: &'a L,
    /// Radiance behind all that is drawn, in place of the environment.
    pub backdrop: Option<Vec3>,
}

impl<L: ReflectorShader> LookShader for LookupShader<'_, L> {
    fn scene(&self) -> &Scene {
        self.scene
    }

    #[inline]
    fn look(&self, fragment: &Fragment<'_>) -> ShadingRequest {
        let at = fragment.position;
        let Some(surface) = fragment.chain.first() else {
            if let Some(backdrop) = self.backdrop {
                return ShadingRequest::Color(backdrop);
            }
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
pub fn draw(
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
    let backdrop = job.scene.backdrop;
    let shader = LookupShader { scene: job.scene, rays: job.view.rays(), reflectors, backdrop };
    report.add_raster(&raster::draw(job.view, job.quality.samples, &[list], &shader, target, job.progress)?);
    Ok(report)
}

/// Gives fragments the number of the path that they show, plus 1, as a colour.
struct PathNumbers<'a, B> {
    scene: &'a Scene,
    rays: ViewRays,
    bounces: B,
    paths: Numbers<SpecularPath>,
}

impl<B> FragmentShader for PathNumbers<'_, B>
where
    B: Fn(&SurfaceInteraction, &Ray, &RayDifferential) -> Vec<Bounce> + Sync,
{
    fn shade(&self, fragment: &Fragment<'_>) -> Vec3 {
        let Some(surface) = fragment.chain.first() else { return Vec3::ZERO };
        if !self.scene.role_of(self.scene.triangle_objects[surface.source as usize]).is_specular() {
            return Vec3::ZERO;
        }
        let (ray, change) = self.rays.ray_with_differential(fragment.position.x, fragment.position.y);
        let encounter = self.scene.drawn_encounter(surface.source, &surface.barycentrics, &ray, &change);
        let path = SpecularPath { bounces: (self.bounces)(&encounter, &ray, &change) };
        Vec3::splat(self.paths.number(path) as f32 + 1.0)
    }

    fn is_present(&self, surface: &LayerSurface, _position: Vec2) -> bool {
        self.scene.is_surface_present(surface.source, &surface.barycentrics)
    }
}

/// The wanted objects' pixels by the path of light that reflectors and lenses show there: what `bounces` gives for a
/// ray that meets one, with its change a pixel.
///
/// # Errors
/// Errors of the rasteriser.
pub fn shown_paths(
    job: &Job<'_>,
    bounces: impl Fn(&SurfaceInteraction, &Ray, &RayDifferential) -> Vec<Bounce> + Sync,
    is_wanted: impl Fn(u32) -> bool,
) -> Result<Overlay, RenderError> {
    let Job { scene, view, progress, .. } = *job;
    let list = raster::scene_draw_list(scene, view, |object| is_wanted(object).then_some(0));
    let shader = PathNumbers { scene, rays: view.rays(), bounces, paths: Numbers::default() };
    let mut picture = Framebuffer::new(view.width, view.height);
    raster::draw(view, 1, &[list], &shader, &mut picture, progress)?;
    let (paths, places) = shader.paths.sorted(SpecularPath::cmp);
    let none = SpecularPath::default();
    let shown =
        |pixel: &[f32; 4]| (pixel[0] as usize).checked_sub(1).map_or(&none, |number| &paths[places[number] as usize]);
    let pixels: Vec<&SpecularPath> = picture.pixels.iter().map(shown).collect();
    Ok(overlay::paths::of_pixels(scene, [view.width, view.height], &pixels))
}
