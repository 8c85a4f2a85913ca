//! Groups of reflectors and lenses whose paths are traced together, alone.

use crate::shared::regions::Regions;
use catoptric_core::math::Aabb;
use catoptric_core::scene::Scene;
use catoptric_engine::light::tracer::Tracer;
use glam::Vec3;

/// Reflectors and lenses that are traced without the rest of the scene.
pub struct LensGroup {
    /// Ascending.
    pub(crate) objects: Vec<u32>,
    /// Around them.
    pub(crate) bounds: Aabb,
    /// Hierarchy of the group's objects alone.
    pub(crate) tracer: Tracer,
}

impl LensGroup {
    /// The groups of a scene: reflectors and lenses in its region are one, and so are others whose boxes overlap.
    pub fn all(scene: &Scene) -> Vec<Self> {
        let regions = Regions::of(scene, 0.0);
        let specular = scene.specular_objects();
        let mut members = vec![Vec::new(); regions.boxes.len()];
        for &object in &specular {
            match regions.region_of[object as usize] {
                Some(region) => members[region as usize].push(object),
                None => members.push(vec![object]),
            }
        }
        let members = members.into_iter().filter(|objects| !objects.is_empty());
        members.map(|objects| Self::new(scene, objects)).collect()
    }

    /// True if a scene has any.
    pub(crate) fn any(scene: &Scene) -> bool {
        !scene.specular_objects().is_empty()
    }

    fn new(scene: &Scene, mut objects: Vec<u32>) -> Self {
        objects.sort_unstable();
        let bounds = objects.iter().map(|object| scene.objects[*object as usize].bounds);
        let bounds = bounds.fold(Aabb::EMPTY, Aabb::union);
        let tracer = Tracer::build(scene, |object| objects.binary_search(&object).is_ok());
        Self { objects, bounds, tracer }
    }

    /// Returns true for objects of the group.
    #[inline]
    pub(crate) fn holds(&self, object: u32) -> bool {
        self.objects.binary_search(&object).is_ok()
    }

    /// Has it count the triangles and surfaces that rays are tested against.
    pub(crate) fn counting_tests(self) -> Self {
        Self { tracer: self.tracer.counting_tests(), ..self }
    }

    /// The middle of the shells about it.
    pub(crate) fn center(&self) -> Vec3 {
        self.bounds.center()
    }
}
