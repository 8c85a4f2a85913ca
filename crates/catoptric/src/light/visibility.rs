//! Shadows of lights: which surfaces cast them, and rays that tell whether a light is seen.

use super::tracer::Tracer;
use crate::scene::{AlphaMode, LightVisibility, Material, Role, Scene};
use std::sync::Arc;

/// Gives a scene with lights shadows: from then on every method asks rays whether a light is seen from a point that it
/// shades. Without lights nothing changes.
///
/// Shadows are hard. Mirrors and opaque surfaces cast them, with their holes where alpha is low. Glass does not, as its
/// light goes on (where it gathers is not calculated), and what is unlit does not: skies and light panels are made of
/// it. The means belong to the scene: they are made anew for every pose.
pub fn cast_shadows(scene: &mut Scene) {
    scene.light_visibility = None;
    if !scene.lights.is_empty() {
        scene.light_visibility = Some(means(scene));
    }
}

fn means(scene: &Scene) -> Arc<dyn LightVisibility> {
    let casts = |object: u32| casts_shadows(scene.material_of(object));
    Arc::new(Tracer::build(scene, casts))
}

/// Shadows a scene's environment: from then on surfaces scatter what they see of it, not all of it, and the light of
/// surfaces that emit it. Without either nothing changes.
///
/// The same surfaces cast shadows as of lights. It is made for one pose.
pub fn shadow_sky(scene: &mut Scene) {
    scene.sky = None;
    if scene.environment.is_none() && !has_emitters(scene) {
        return;
    }
    let means = scene.light_visibility.clone().unwrap_or_else(|| means(scene));
    scene.sky = scene.seen_sky(&*means).map(Arc::new);
    scene.light_visibility = Some(means);
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
/// elsewhere, shares of the sky stay with them, as finding them takes longer than a frame. Shadows of suns are those
/// of the moment.
pub fn shadow_sky_as(before: &Scene, scene: &mut Scene) {
    let has_same_light = match (&before.environment, &scene.environment) {
        (Some(before), Some(now)) => Arc::ptr_eq(before, now),
        (before, now) => before.is_none() && now.is_none(),
    };
    match before.sky.as_ref().filter(|_| has_same_light && casts_as(before, scene)) {
        Some(sky) => {
            scene.sky = Some(sky.clone());
            let means = scene.light_visibility.take().unwrap_or_else(|| means_as(before, scene));
            scene.light_visibility = Some(means);
        }
        None => shadow_sky(scene),
    }
}

/// Returns true if the same triangles cast shadows at two moments of a scene.
fn casts_as(before: &Scene, scene: &Scene) -> bool {
    let casting = |scene: &Scene| -> Vec<bool> {
        (0..scene.objects.len() as u32).map(|object| casts_shadows(scene.material_of(object))).collect()
    };
    before.triangles == scene.triangles
        && before.triangle_objects == scene.triangle_objects
        && casting(before) == casting(scene)
}

fn means_as(before: &Scene, scene: &Scene) -> Arc<dyn LightVisibility> {
    let known = before.light_visibility.as_ref().filter(|_| casts_as(before, scene));
    known.and_then(|known| known.moved_to(scene)).unwrap_or_else(|| means(scene))
}

/// Returns true for the materials of objects that cast shadows.
pub fn casts_shadows(material: &Material) -> bool {
    // A surface that lets half of the light pass or more lets all of it pass here.
    let blends = material.alpha_mode == AlphaMode::Blend && material.base_color.w <= 0.5;
    let passes = blends || material.lobes().is_some_and(|lobes| lobes.transmission >= 0.5);
    material.role != Role::Lens && !material.unlit && !passes
}
