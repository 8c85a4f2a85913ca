//! The scene that is on: its model, and its pose at the moment that is wished for.

use super::news::{ObjectSummary, SceneSummary};
use super::order::{Changes, Source, Wish};
use catoptric::clock::Stopwatch;
use catoptric::error::{RenderError, SceneError};
use catoptric::framebuffer::Framebuffer;
use catoptric::light::bodies::remarks_on_bodies;
use catoptric::light::path_tracer::surface_mask;
use catoptric::light::tracer::Tracer;
use catoptric::light::visibility::{cast_shadows, cast_shadows_as, shadow_sky, shadow_sky_as};
use catoptric::methods::{self, Quality};
use catoptric::progress::Silent;
use catoptric::scene::edits::Look;
use catoptric::scene::{Camera, Material, Model, PoseMemory, Role, Scene};
use catoptric::tone::{Display, automatic_exposure};
use catoptric_scenes::{builtin, import, light_if_dark};
use std::sync::Arc;

/// The roughness that a [`Look`] of this material changes.
fn roughness_of(material: &Material) -> Option<f32> {
    match material.role {
        Role::Reflector | Role::Coated => Some(material.mirror_roughness),
        Role::Diffuse => material.microfacets.as_ref().map(|microfacets| microfacets.roughness),
        Role::Lens => None,
    }
}

/// The size of the small picture by which the display is chosen.
const SMALL_PICTURE: [u32; 2] = [64, 48];

/// What shows a scene well from a camera, and the exposure in stops that makes it of middle brightness.
fn fitting_display(scene: &Arc<Scene>, camera: &Camera) -> (Display, f32) {
    let [width, height] = SMALL_PICTURE;
    let view = scene.view(camera, width, height);
    let quality = Quality { samples: 1, order: scene.order_needed() };
    let mut picture = Framebuffer::new(width, height);
    let draw = || -> Result<(), RenderError> {
        let mut prepared = methods::create("reference", &toml::Table::new())?.prepare(scene, quality, None, &Silent)?;
        prepared.frame(&view, &Silent)?.draw(&mut picture, &Silent)?;
        Ok(())
    };
    // What cannot be drawn is told once it is to be shown.
    if { draw }().is_err() {
        return (Display::default(), 0.0);
    }
    let mask = surface_mask(scene, &view);
    let seen = || picture.pixels.iter().zip(&mask).filter(|(_, is_seen)| **is_seen).map(|(pixel, _)| *pixel);
    (Display::fitting(seen()), automatic_exposure(seen()))
}

/// A loaded scene.
pub(super) struct Stage {
    pub(super) number: u64,
    pub(super) model: Model,
    memory: PoseMemory,
    /// The last pose with what it was made of.
    posed: Option<(f32, Changes, bool, Arc<Scene>)>,
    /// For picking, made when it is needed.
    tracer: Option<(Arc<Scene>, Arc<Tracer>)>,
}

impl Stage {
    /// Loads a scene and poses it for the first time.
    pub(super) fn load(number: u64, source: &Source) -> Result<(Self, SceneSummary), SceneError> {
        let watch = Stopwatch::new();
        let mut model = match source {
            Source::Builtin(spec) => builtin::parse(spec)?,
            Source::File(path) => import::load(path)?,
            Source::Bytes { name, bytes, beside } => import::load_bytes(name, bytes, beside)?,
        };
        let is_own = model.name.ends_with(".toml") || matches!(source, Source::Builtin(_));
        if !is_own {
            light_if_dark(&mut model, false);
        }
        let mut stage = Self { number, model, memory: PoseMemory::default(), posed: None, tracer: None };
        let scene = stage.scene(0.0, &Changes::default(), true)?;
        let summary = stage.summary(&scene, watch.elapsed_ms());
        Ok((stage, summary))
    }

    /// The scene at a moment, with changes, and with light from infinity where paths end or not; what holds of the last
    /// one is used again.
    ///
    /// # Errors
    /// As [`Model::pose`].
    pub(super) fn scene(
        &mut self,
        time: f32,
        changes: &Changes,
        ends_in_environment: bool,
    ) -> Result<Arc<Scene>, SceneError> {
        if let Some((at, with, ends, scene)) = &self.posed
            && (*at, *ends) == (time, ends_in_environment)
            && with == changes
        {
            return Ok(scene.clone());
        }
        let options = changes.pose_at(time)?;
        self.model.ends_in_environment = ends_in_environment;
        let mut scene = self.model.pose_again(&options, &mut self.memory)?;
        match &self.posed {
            Some((.., before)) => {
                cast_shadows_as(before, &mut scene);
                shadow_sky_as(before, &mut scene, &Silent).expect("nobody cancels it");
            }
            None => {
                cast_shadows(&mut scene);
                shadow_sky(&mut scene, &Silent).expect("nobody cancels it");
            }
        }
        let scene = Arc::new(scene);
        self.posed = Some((time, changes.clone(), ends_in_environment, scene.clone()));
        Ok(scene)
    }

    /// The scene of a wish.
    pub(super) fn scene_of(&mut self, wish: &Wish) -> Result<Arc<Scene>, SceneError> {
        self.scene(wish.time, &wish.changes, wish.has_automatic_order)
    }

    /// A hierarchy over all of a scene, for single rays.
    pub(super) fn tracer(&mut self, scene: &Arc<Scene>) -> Arc<Tracer> {
        if let Some((of, tracer)) = &self.tracer
            && Arc::ptr_eq(of, scene)
        {
            return tracer.clone();
        }
        let tracer = Arc::new(Tracer::build(scene, |_| true));
        self.tracer = Some((scene.clone(), tracer.clone()));
        tracer
    }

    fn summary(&self, scene: &Arc<Scene>, load_ms: f64) -> SceneSummary {
        let object = |index: usize| {
            let object = &scene.objects[index];
            let material = &scene.materials[object.material as usize];
            ObjectSummary {
                name: object.name.clone(),
                material: material.name.clone(),
                role: material.role,
                look: Look {
                    color: Some(material.base_color.truncate()),
                    roughness: roughness_of(material),
                    ior: matches!(material.role, Role::Lens | Role::Coated).then_some(material.ior),
                    priority: None,
                },
                ior: material.ior,
                triangles: object.triangles.len() as u32,
                bounds: object.bounds,
            }
        };
        let mut cameras = scene.cameras.clone();
        if cameras.is_empty() {
            cameras.push(scene.framing(4.0 / 3.0));
        }
        let (display, automatic_stops) = fitting_display(scene, &cameras[0]);
        SceneSummary {
            number: self.number,
            name: self.model.name.clone(),
            cameras,
            objects: (0..scene.objects.len()).map(object).collect(),
            triangles: scene.triangles.len(),
            duration: self.model.duration(),
            bounds: scene.bounds,
            settings: self.model.method_settings.clone(),
            warnings: self.model.warnings.iter().cloned().chain(remarks_on_bodies(scene)).collect(),
            origin: scene.origin,
            order_needed: scene.order_needed(),
            display,
            automatic_stops,
            load_ms,
        }
    }
}
