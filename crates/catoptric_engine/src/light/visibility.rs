//! Shadows of lights: which surfaces cast them, and rays that tell how much of a light arrives.

use super::tracer::Tracer;
use super::wide_hierarchy::Treelet;
use catoptric_core::progress::{Cancelled, Progress};
use catoptric_core::scene::hit::Hit;
use catoptric_core::scene::{
    AlphaMode, Light, LightStop, LightVisibility, Material, Ray, Role, Scene, StoppingSurface,
};
use glam::Vec3;
use std::any::Any;
use std::cell::RefCell;
use std::sync::Arc;

/// The objects between lights and surfaces, for rays of shadow.
#[derive(Debug)]
struct ShadowRays {
    /// A tracer of all objects that stop or weaken light.
    tracer: Tracer,
    /// Which objects let light pass; empty: none of them.
    clear: Vec<bool>,
    /// The others; empty: all.
    opaque: Vec<bool>,
}

impl ShadowRays {
    fn new(tracer: Tracer, clear: Vec<bool>) -> Self {
        let opaque = clear.iter().map(|is_clear| !is_clear).collect();
        Self { tracer, clear, opaque }
    }
}

/// A distance along a ray that ends before a surface, as a share of that to the surface.
const BEFORE: f32 = 1.0 - 1e-5;

impl LightVisibility for ShadowRays {
    fn passing(&self, scene: &Scene, ray: &Ray, distance: f32) -> Vec3 {
        self.tracer.passing(scene, ray, distance, &self.clear)
    }

    fn find_passing(&self, scene: &Scene, light: &Light, points: &[Vec3], passing: &mut [Vec3]) {
        thread_local! {
            /// Buffers of a thread.
            static TREELET: RefCell<Treelet> = RefCell::default();
        }
        TREELET.with_borrow_mut(|treelet| {
            self.tracer.find_passing(scene, (light, points), &self.clear, treelet, passing);
        });
    }

    fn first_stop(&self, scene: &Scene, ray: &Ray) -> Option<LightStop> {
        let objects = if self.opaque.is_empty() { None } else { Some(self.opaque.as_slice()) };
        let hit = self.tracer.first_stop(scene, ray, objects)?;
        let distance = hit.distance();
        let surface = match hit {
            Hit::Triangle { triangle, barycentrics, .. } => StoppingSurface::Triangle(triangle, barycentrics),
            Hit::Surface { object, hit } => StoppingSurface::Exact(object, hit),
        };
        let passing = match objects {
            Some(_) => self.tracer.passing(scene, ray, distance * BEFORE, &self.clear),
            None => Vec3::ONE,
        };
        Some(LightStop { distance, surface, passing })
    }

    fn hierarchy(&self) -> &dyn Any {
        &self.tracer
    }

    fn moved_to(&self, scene: &Scene) -> Option<Arc<dyn LightVisibility>> {
        Some(Arc::new(Self::new(self.tracer.refitted(scene)?, self.clear.clone())))
    }
}

/// Bounces of light between surfaces that scatter it, where nobody asks for others: as in Cycles.
pub const DIFFUSE_BOUNCES: u32 = 4;

/// Gives a scene with lights shadows: from then on every method asks rays whether a light is seen from a point that it
/// shades. Without lights nothing changes.
///
/// Shadows are hard. Mirrors and opaque surfaces cast them, with their holes where alpha is low. Glass and veils weaken
/// and tint what goes straight on through them: by what they cover and reflect, by their colour, and by what a body
/// absorbs. That glass bends light, and where it gathers, is not calculated. What is unlit casts none: skies and light
/// panels are made of it. The means belong to the scene: they are made anew for every pose.
pub fn cast_shadows(scene: &mut Scene) {
    scene.light_visibility = None;
    if !scene.lights.is_empty() {
        scene.light_visibility = Some(means(scene));
    }
}

fn means(scene: &Scene) -> Arc<dyn LightVisibility> {
    let tracer = Tracer::build(scene, |object| !scene.material_of(object).unlit);
    Arc::new(ShadowRays::new(tracer, clear(scene)))
}

/// Which objects let light pass; empty: none of them.
fn clear(scene: &Scene) -> Vec<bool> {
    let is_clear = |object: u32| scene.material_of(object).lets_light_pass();
    let clear: Vec<bool> = (0..scene.objects.len() as u32).map(is_clear).collect();
    if clear.contains(&true) { clear } else { Vec::new() }
}

/// Shadows a scene's environment: from then on surfaces scatter what they see of it, not all of it, and the light of
/// surfaces that emit it or, after so many bounces, scatter it. Without light nothing changes.
///
/// The same surfaces cast shadows as of lights. It is made for one pose.
///
/// # Errors
/// [`Cancelled`]; nothing is shadowed then.
pub fn shadow_sky(scene: &mut Scene, bounces: u32, progress: &dyn Progress) -> Result<(), Cancelled> {
    scene.sky = None;
    let is_lit = bounces > 0 && !scene.lights.is_empty();
    if scene.environment.is_none() && !has_emitters(scene) && !is_lit {
        return Ok(());
    }
    let means = scene.light_visibility.clone().unwrap_or_else(|| means(scene));
    scene.see_sky(means, bounces, progress)
}

fn has_emitters(scene: &Scene) -> bool {
    (0..scene.objects.len() as u32).any(|object| scene.material_of(object).emits_light())
}

/// The same for another moment of a scene that has them, `before`: where the same triangles are elsewhere and the same
/// objects cast shadows, the means move with them, which takes a part of the time.
pub fn cast_shadows_as(before: &Scene, scene: &mut Scene) {
    scene.light_visibility = None;
    if !scene.lights.is_empty() {
        scene.light_visibility = Some(means_as(before, scene));
    }
}

/// [`shadow_sky`] for another moment of a scene whose sky is shadowed, `before`: where the same triangles are
/// elsewhere, shares of the sky and the light of surfaces stay with them, as finding them takes longer than a frame.
/// Shadows of suns are those of the moment.
///
/// # Errors
/// [`Cancelled`]; nothing is shadowed then.
pub fn shadow_sky_as(
    before: &Scene,
    scene: &mut Scene,
    bounces: u32,
    progress: &dyn Progress,
) -> Result<(), Cancelled> {
    let has_same_sky = match (&before.environment, &scene.environment) {
        (Some(before), Some(now)) => Arc::ptr_eq(before, now),
        (before, now) => before.is_none() && now.is_none(),
    };
    // Lamps may move, too, but not shine otherwise.
    let shining = |scene: &Scene| scene.lights.iter().map(|light| light.intensity).collect::<Vec<_>>();
    let has_same_light = has_same_sky && (bounces == 0 || shining(before) == shining(scene));
    match before.sky.as_ref().filter(|_| has_same_light && casts_as(before, scene)) {
        Some(sky) => {
            scene.sky = Some(sky.clone());
            let means = scene.light_visibility.take().unwrap_or_else(|| means_as(before, scene));
            scene.light_visibility = Some(means);
            Ok(())
        }
        None => shadow_sky(scene, bounces, progress),
    }
}

/// Returns true if the same triangles cast shadows at two moments of a scene.
fn casts_as(before: &Scene, scene: &Scene) -> bool {
    let casting = |scene: &Scene| -> Vec<[bool; 2]> {
        let materials = (0..scene.objects.len() as u32).map(|object| scene.material_of(object));
        materials.map(|material| [material.unlit, material.lets_light_pass()]).collect()
    };
    before.triangles == scene.triangles
        && before.triangle_objects == scene.triangle_objects
        && casting(before) == casting(scene)
}

fn means_as(before: &Scene, scene: &Scene) -> Arc<dyn LightVisibility> {
    let known = before.light_visibility.as_ref().filter(|_| casts_as(before, scene));
    known.and_then(|known| known.moved_to(scene)).unwrap_or_else(|| means(scene))
}

/// Returns true for the materials of objects that cast shadows where nothing but opaque things and glass is known, as
/// on devices: what lets half of the light pass or more, lets all of it pass there.
pub fn casts_shadows(material: &Material) -> bool {
    let blends = material.alpha_mode == AlphaMode::Blend && material.base_color.w <= 0.5;
    let passes = blends || material.lobes().is_some_and(|lobes| lobes.transmission >= 0.5);
    material.role != Role::Lens && !material.unlit && !passes
}
