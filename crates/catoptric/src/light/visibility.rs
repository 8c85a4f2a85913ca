//! Shadows of lights: which surfaces cast them, and rays that tell whether a light is seen.

use super::tracer::Tracer;
use super::wide_hierarchy::Treelet;
use crate::scene::{Light, LightVisibility, Material, Ray, Role, Scene};
use glam::Vec3;
use std::cell::RefCell;
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
        let casts = |object: u32| casts_shadows(scene.material_of(object));
        scene.light_visibility = Some(Arc::new(Shadows { tracer: Tracer::build(scene, casts) }));
    }
}

/// The same for another moment of a scene that has them, `before`: where the same triangles are elsewhere and the same
/// objects cast shadows, the means move with them, which takes a part of the time.
pub fn cast_shadows_as(before: &Scene, scene: &mut Scene) {
    let casting = |scene: &Scene| -> Vec<bool> {
        (0..scene.objects.len() as u32).map(|object| casts_shadows(scene.material_of(object))).collect()
    };
    let is_same = !scene.lights.is_empty()
        && before.triangles == scene.triangles
        && before.triangle_objects == scene.triangle_objects
        && casting(before) == casting(scene);
    let means = before.light_visibility.as_ref().filter(|_| is_same);
    match means.and_then(|means| means.moved_to(scene)) {
        Some(moved) => scene.light_visibility = Some(moved),
        None => cast_shadows(scene),
    }
}

/// Returns true for the materials of objects that cast shadows.
pub fn casts_shadows(material: &Material) -> bool {
    material.role != Role::Lens && !material.unlit
}

/// The hierarchy over all that casts shadows.
#[derive(Debug)]
struct Shadows {
    tracer: Tracer,
}

impl LightVisibility for Shadows {
    fn is_blocked(&self, scene: &Scene, ray: &Ray, distance: f32) -> bool {
        self.tracer.is_blocked(scene, ray, distance)
    }

    fn find_hidden(&self, scene: &Scene, light: &Light, points: &[Vec3], hidden: &mut [bool]) {
        thread_local! {
            /// Buffers of a thread.
            static TREELET: RefCell<Treelet> = RefCell::default();
        }
        TREELET.with_borrow_mut(|treelet| self.tracer.find_blocked(scene, light, points, treelet, hidden));
    }

    fn moved_to(&self, scene: &Scene) -> Option<Arc<dyn LightVisibility>> {
        Some(Arc::new(Self { tracer: self.tracer.refitted(scene)? }))
    }
}
