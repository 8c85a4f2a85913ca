//! The scene that is on: its model, and its pose at the moment that is wished for.

use super::news::{ObjectSummary, SceneSummary};
use super::order::{Changes, Source, Wish};
use catoptric::clock::Stopwatch;
use catoptric::error::SceneError;
use catoptric::light::tracer::Tracer;
use catoptric::light::visibility::{cast_shadows, cast_shadows_as, shadow_sky, shadow_sky_as};
use catoptric::scene::edits::Look;
use catoptric::scene::{Material, Model, PoseMemory, Role, Scene};
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

/// A loaded scene.
pub(super) struct Stage {
    pub(super) number: u64,
    pub(super) model: Model,
    memory: PoseMemory,
    /// The last pose with what it was made of.
    posed: Option<(f32, Changes, Arc<Scene>)>,
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
        let scene = stage.scene(0.0, &Changes::default())?;
        let summary = stage.summary(&scene, watch.elapsed_ms());
        Ok((stage, summary))
    }

    /// The scene at a moment, with changes; what holds of the last one is used again.
    ///
    /// # Errors
    /// As [`Model::pose`].
    pub(super) fn scene(&mut self, time: f32, changes: &Changes) -> Result<Arc<Scene>, SceneError> {
        if let Some((at, with, scene)) = &self.posed
            && *at == time
            && with == changes
        {
            return Ok(scene.clone());
        }
        let options = changes.pose_at(time)?;
        let mut scene = self.model.pose_again(&options, &mut self.memory)?;
        match &self.posed {
            Some((.., before)) => {
                cast_shadows_as(before, &mut scene);
                shadow_sky_as(before, &mut scene);
            }
            None => {
                cast_shadows(&mut scene);
                shadow_sky(&mut scene);
            }
        }
        let scene = Arc::new(scene);
        self.posed = Some((time, changes.clone(), scene.clone()));
        Ok(scene)
    }

    /// The scene of a wish.
    pub(super) fn scene_of(&mut self, wish: &Wish) -> Result<Arc<Scene>, SceneError> {
        self.scene(wish.time, &wish.changes)
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

    fn summary(&self, scene: &Scene, load_ms: f64) -> SceneSummary {
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
        SceneSummary {
            number: self.number,
            name: self.model.name.clone(),
            cameras,
            objects: (0..scene.objects.len()).map(object).collect(),
            triangles: scene.triangles.len(),
            duration: self.model.duration(),
            bounds: scene.bounds,
            settings: self.model.method_settings.clone(),
            warnings: self.model.warnings.clone(),
            load_ms,
        }
    }
}
