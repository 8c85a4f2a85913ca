//! The rough mirrors of a scene.

use catoptric_core::math::Aabb;
use catoptric_core::scene::{Ray, Scene};
use catoptric_engine::light::tracer::Tracer;

/// The rough mirrors of a scene, and lenses with bumps.
pub(crate) struct RoughMirrors {
    /// The tracer of rays to and from rough mirrors.
    pub(super) tracer: Tracer,
    /// True for each object that is a rough mirror, or may be one by its normal map.
    pub(super) is_rough: Vec<bool>,
    /// Boxes around them.
    boxes: Vec<Aabb>,
}

impl RoughMirrors {
    /// The rough mirrors of a scene, made from those of another moment of it if these are given; `None` if there are
    /// none.
    pub(crate) fn new(scene: &Scene, old: Option<&Self>) -> Option<Self> {
        let is_rough: Vec<bool> =
            (0..scene.objects.len() as u32).map(|object| scene.material_of(object).may_spread_light()).collect();
        let objects = scene.objects.iter().zip(&is_rough).filter(|(_, is_rough)| **is_rough);
        let boxes: Vec<Aabb> = objects.map(|(object, _)| object.bounds).collect();
        if boxes.is_empty() {
            return None;
        }
        let tracer = old.and_then(|old| old.tracer.refitted(scene)).unwrap_or_else(|| Tracer::build(scene, |_| true));
        Some(Self { tracer, is_rough, boxes })
    }

    /// The tracer of rays in the whole scene.
    pub(crate) fn tracer(&self) -> &Tracer {
        &self.tracer
    }

    /// Memory of the hierarchy.
    pub(crate) fn byte_count(&self) -> u64 {
        self.tracer.byte_count()
    }

    /// False if a ray meets none of them.
    pub(super) fn may_be_met_by(&self, ray: &Ray) -> bool {
        let inverse = ray.direction.recip();
        let is_met = |bounds: &Aabb| {
            let (low, high) = ((bounds.min - ray.origin) * inverse, (bounds.max - ray.origin) * inverse);
            let margin = 1e-5 * (low.abs() + high.abs());
            let enter = (low.min(high) - margin).max_element();
            let leave = (low.max(high) + margin).min_element();
            // Where a ray lies in a side's plane this is not a number, and counts as met.
            !(enter > leave || leave < 0.0)
        };
        self.boxes.iter().any(is_met)
    }
}
