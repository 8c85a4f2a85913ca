//! The scene that is on: its model, and its pose at the moment that is wished for.

use super::news::{ClipSummary, ObjectSummary, SceneSummary};
use super::order::{Changes, Opening, Source, Wish};
use catoptric::clock::Stopwatch;
use catoptric::error::{RenderError, SceneError};
use catoptric::framebuffer::Framebuffer;
use catoptric::light::bodies::remarks_on_bodies;
use catoptric::light::path_tracer::surface_mask;
use catoptric::light::tracer::Tracer;
use catoptric::light::visibility::{DIFFUSE_BOUNCES, cast_shadows, cast_shadows_as, shadow_sky, shadow_sky_as};
use catoptric::methods::{self, Quality};
use catoptric::progress::Silent;
use catoptric::scene::edits::Look;
use catoptric::scene::model::Animation;
use catoptric::scene::{Camera, Material, Model, PoseMemory, Role, Scene};
use catoptric::tone::{Display, automatic_exposure};
use catoptric_scenes::import::LoadOptions;
use catoptric_scenes::{Lighting, builtin, hint_on_missing, import, thin_glass};
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

/// The display that suits a scene from a camera, and the exposure in stops that makes it of middle brightness.
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
    // The user is told why a scene cannot be drawn once it is to be shown.
    if { draw }().is_err() {
        return (Display::default(), 0.0);
    }
    let mask = surface_mask(scene, &view);
    (Display::fitting(&picture, &mask), automatic_exposure(&picture, &mask))
}

/// A loaded scene.
pub(super) struct Stage {
    pub(super) number: u64,
    /// With the animations that play.
    pub(super) model: Model,
    /// All animations, while one plays alone; else the model has them.
    clips: Vec<Animation>,
    /// The one that plays alone.
    clip: Option<usize>,
    /// Bounces of light between surfaces; `None` without shadows.
    bounces: Option<u32>,
    memory: PoseMemory,
    /// The last pose with what it was made of.
    posed: Option<(f32, Changes, bool, Arc<Scene>)>,
    /// For picking, made when it is needed.
    tracer: Option<(Arc<Scene>, Arc<Tracer>)>,
}

impl Stage {
    /// Loads a scene and poses it for the first time.
    pub(super) fn load(number: u64, source: &Source, opening: &Opening) -> Result<(Self, SceneSummary), SceneError> {
        let watch = Stopwatch::new();
        let loading = LoadOptions { variant: opening.variant.as_deref(), allow_outside: opening.allow_outside };
        let mut model = match source {
            Source::Builtin(spec) => match loading.variant {
                None => builtin::parse(spec)?,
                Some(_) => {
                    let problem = "built-in scenes have no variants: leave it out";
                    return Err(SceneError::invalid(source.word(), "--variant", problem));
                }
            },
            Source::File(path) => import::load_with(path, loading).map_err(|error| match hint_on_missing(path) {
                Some(hint) => SceneError::invalid(source.word(), "path", format!("there is no such file; {hint}")),
                None => error,
            })?,
            Source::Bytes { name, bytes, beside } => import::load_bytes(name, bytes, beside)?,
        };
        let is_own = model.name.ends_with(".toml") || matches!(source, Source::Builtin(_));
        let (environment, edit) = (opening.environment.as_deref(), opening.environment_edit);
        let has_roles = !opening.roles.is_empty();
        Lighting { environment, edit, is_own, has_roles }.apply(&mut model)?;
        if opening.has_solid_glass {
            thin_glass(&mut model).for_each(|lobes| lobes.is_thin = false);
        }
        let bounces = if opening.lacks_bounces { 0 } else { DIFFUSE_BOUNCES };
        let (memory, bounces) = (PoseMemory::default(), (!opening.lacks_shadows).then_some(bounces));
        let (clips, clip, posed, tracer) = (Vec::new(), None, None, None);
        let mut stage = Self { number, model, clips, clip, bounces, memory, posed, tracer };
        let changes = Changes { roles: opening.roles.clone(), ..Changes::default() };
        let scene = stage.scene(0.0, &changes, true)?;
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
        match (&self.posed, self.bounces) {
            (_, None) => {}
            (Some((.., before)), Some(bounces)) => {
                cast_shadows_as(before, &mut scene);
                shadow_sky_as(before, &mut scene, bounces, &Silent).expect("nobody cancels it");
            }
            (None, Some(bounces)) => {
                cast_shadows(&mut scene);
                shadow_sky(&mut scene, bounces, &Silent).expect("nobody cancels it");
            }
        }
        let scene = Arc::new(scene);
        self.posed = Some((time, changes.clone(), ends_in_environment, scene.clone()));
        Ok(scene)
    }

    /// The scene of a wish.
    pub(super) fn scene_of(&mut self, wish: &Wish) -> Result<Arc<Scene>, SceneError> {
        self.play(wish.clip);
        self.scene(wish.time, &wish.changes, wish.has_automatic_order)
    }

    /// Has one animation play alone, or all again.
    fn play(&mut self, clip: Option<usize>) {
        if clip == self.clip {
            return;
        }
        if self.clip.is_none() {
            self.clips = std::mem::take(&mut self.model.animations);
        }
        self.model.animations = match clip {
            Some(index) => self.clips.get(index).cloned().into_iter().collect(),
            None => std::mem::take(&mut self.clips),
        };
        (self.clip, self.posed) = (clip, None);
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
        let clip = |animation: &Animation| ClipSummary { name: animation.name.clone(), duration: animation.duration() };
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
            clips: self.model.animations.iter().map(clip).collect(),
            bounds: scene.bounds,
            settings: self.model.method_settings.clone(),
            warnings: self.model.warnings.iter().cloned().chain(remarks_on_bodies(scene)).collect(),
            origin: scene.origin,
            has_environment: scene.environment.is_some(),
            order_needed: scene.order_needed(),
            display,
            automatic_stops,
            load_ms,
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::studio::order::{Beside, RoleChange};
    use catoptric_scenes::import::EnvironmentEdit;
    use glam::Vec3;

    /// A triangle that `Survey` moves by x = 1 within a second and `Walk` by y = 2 within three.
    fn walker() -> Source {
        let floats: [f32; 25] = [
            0.0, 0.0, 0.0, 1.0, 0.0, 0.0, 0.0, 1.0, 0.0, // positions
            0.0, 1.0, 0.0, 3.0, // times
            0.0, 0.0, 0.0, 1.0, 0.0, 0.0, // to x = 1
            0.0, 0.0, 0.0, 0.0, 2.0, 0.0, // to y = 2
        ];
        let bytes: Vec<u8> = floats.iter().flat_map(|float| float.to_le_bytes()).collect();
        let accessor = |offset: u32, count: u32, kind: &str, more: &str| {
            format!(
                r#"{{"bufferView":0,"byteOffset":{offset},"componentType":5126,"count":{count},"type":"{kind}"{more}}}"#
            )
        };
        let clip = |name: &str, times: u32| {
            let values = times + 2;
            format!(
                r#"{{"name":"{name}","samplers":[{{"input":{times},"output":{values}}}],
                "channels":[{{"sampler":0,"target":{{"node":0,"path":"translation"}}}}]}}"#
            )
        };
        let accessors = [
            accessor(0, 3, "VEC3", r#","min":[0,0,0],"max":[1,1,0]"#),
            accessor(36, 2, "SCALAR", r#","min":[0],"max":[1]"#),
            accessor(44, 2, "SCALAR", r#","min":[0],"max":[3]"#),
            accessor(52, 2, "VEC3", ""),
            accessor(76, 2, "VEC3", ""),
        ];
        let text = format!(
            r#"{{"asset":{{"version":"2.0"}},"scene":0,"scenes":[{{"nodes":[0]}}],
            "nodes":[{{"name":"Ball","mesh":0}}],"meshes":[{{"primitives":[{{"attributes":{{"POSITION":0}}}}]}}],
            "buffers":[{{"uri":"a.bin","byteLength":100}}],"bufferViews":[{{"buffer":0,"byteLength":100}}],
            "accessors":[{}],"animations":[{},{}]}}"#,
            accessors.join(","),
            clip("Survey", 1),
            clip("Walk", 2)
        );
        let beside = Beside(Arc::new([("a.bin".to_owned(), bytes)].into()));
        Source::Bytes { name: "walker.gltf".into(), bytes: text.into_bytes().into(), beside }
    }

    #[test]
    fn one_animation_plays_alone_and_all_again() {
        let (mut stage, summary) = Stage::load(1, &walker(), &Opening::default()).unwrap();
        let clips: Vec<(&str, f32)> = summary.clips.iter().map(|clip| (clip.name.as_str(), clip.duration)).collect();
        assert_eq!(clips, [("Survey", 1.0), ("Walk", 3.0)]);
        assert_eq!([None, Some(0), Some(1)].map(|clip| summary.duration(clip)), [3.0, 1.0, 3.0]);
        let mut corner = |clip, time| {
            stage.play(clip);
            stage.scene(time, &Changes::default(), false).unwrap().bounds.min
        };
        // Both move the same: the first one plays.
        assert_eq!(corner(None, 3.0), Vec3::X);
        assert_eq!((corner(Some(1), 1.5), corner(Some(1), 3.0)), (Vec3::Y, 2.0 * Vec3::Y));
        assert_eq!((corner(Some(0), 0.5), corner(None, 1.0)), (0.5 * Vec3::X, Vec3::X));
    }

    #[test]
    fn scenes_are_opened_as_is_wanted() {
        let mirror = RoleChange { name: "B*".into(), role: Role::Reflector, ior: None };
        let turned = EnvironmentEdit { rotation_deg: Some(90.0), strength: None };
        let sky = Opening {
            environment: Some("sky".into()),
            environment_edit: turned,
            roles: vec![mirror],
            ..Opening::default()
        };
        let (mut stage, summary) = Stage::load(1, &walker(), &sky).unwrap();
        assert_eq!((summary.objects[0].role, summary.has_environment), (Role::Reflector, true));
        let scene = stage.scene(0.0, &Changes::default(), false).unwrap();
        let (lit, sky) = (scene.environment.as_ref().unwrap(), catoptric_scenes::named_environment("sky").unwrap());
        assert_eq!((&lit.name, lit.turn()), (&sky.name, 0.25));
        // Something without mirrors has no light of its own that could be turned.
        let problem = |opening: &Opening| Stage::load(1, &walker(), opening).err().unwrap().to_string();
        let dark = problem(&Opening { environment_edit: turned, ..Opening::default() });
        assert!(dark.contains("--environment-rotation") && dark.contains("give one by --environment"), "{dark}");
        let nobody = RoleChange { name: "Balll".into(), role: Role::Reflector, ior: None };
        let unknown = problem(&Opening { roles: vec![nobody], ..Opening::default() });
        assert!(unknown.contains("Balll") && unknown.contains("did you mean `Ball`"), "{unknown}");
    }
}
