//! What is around a group of reflectors and lenses: rays that leave it, and what they meet, layer by layer.

use super::groups::LensGroup;
use super::layers::{Meeting, Stratum};
use crate::methods::reference::{PathModel, PathTracer};
use crate::scene::shade::Encounter;
use crate::scene::{Ray, RayDifferential, Scene};
use crate::surface::tracer::{Hit, Tracer};
use glam::{Vec3, Vec4};

/// Surfaces that a ray passes by looking for another; behind so many nothing is looked for.
const MOST_SURFACES: usize = 64;

/// How much further than a surface that was met the next one is looked for, as a share of its distance.
const FURTHER: f32 = 1e-5;

/// The surfaces along a ray, one behind the other.
fn hits<'a>(scene: &'a Scene, tracer: &'a Tracer, ray: Ray) -> impl Iterator<Item = (Encounter, Hit)> + 'a {
    let mut near = 0.0;
    std::iter::from_fn(move || {
        let hit = tracer.first_hit(scene, &ray, near)?;
        near = hit.distance() * (1.0 + FURTHER);
        Some((tracer.encounter(scene, &ray, &hit, None), hit))
    })
    .take(MOST_SURFACES)
}

fn faces(encounter: &Encounter, ray: &Ray) -> bool {
    ray.direction.dot(encounter.point.geometric_normal) < 0.0
}

/// All that is not in the group.
pub(super) struct Surroundings<'a> {
    scene: &'a Scene,
    /// From the centre of its layers.
    center: Vec3,
    /// Without the group.
    tracer: Tracer,
}

impl<'a> Surroundings<'a> {
    pub(super) fn new(scene: &'a Scene, group: &LensGroup) -> Self {
        let tracer = Tracer::build(scene, |object| !group.objects.contains(&object));
        Self { scene, center: group.center(), tracer }
    }

    /// Appends what a ray that leaves the group meets: what it is stopped by, and whatever faces it behind that.
    pub(super) fn meet(&self, number: u32, ray: &Ray, meetings: &mut Vec<Meeting>) {
        for (order, (encounter, _)) in hits(self.scene, &self.tracer, *ray).enumerate() {
            if order == 0 || faces(&encounter, ray) {
                let position = encounter.point.position - self.center;
                meetings.push(Meeting { ray: number, object: encounter.point.object, position });
            }
        }
    }
}

/// Things of layers, apart.
pub(super) struct Strata<'a> {
    scene: &'a Scene,
    /// Of everything, for what is seen in the reflectors among them.
    everything: &'a Tracer,
    surroundings: &'a Surroundings<'a>,
    layers: Vec<Tracer>,
    /// Events on the paths from them.
    order: u32,
    /// Whether they are seen through the things of other layers.
    continued: bool,
}

impl<'a> Strata<'a> {
    pub(super) fn new(
        surroundings: &'a Surroundings<'a>,
        everything: &'a Tracer,
        strata: &[Stratum],
        order: u32,
        continued: bool,
    ) -> Self {
        let scene = surroundings.scene;
        let layers = strata.iter().map(|stratum| Tracer::build(scene, |object| stratum.objects.contains(&object)));
        Self { scene, everything, surroundings, layers: layers.collect(), order, continued }
    }

    /// How many layers there are.
    pub(super) fn layer_count(&self) -> usize {
        self.layers.len()
    }

    /// What a ray that leaves the group sees of a layer: radiance with 1, or nothing where it meets none of the layer's things
    /// from the front (or from behind, as the first of all things).
    pub(super) fn seen(&self, layer: usize, ray: &Ray, change: Option<&RayDifferential>) -> Vec4 {
        let scene = self.scene;
        let stops = |hit: &Hit| {
            let first = self.surroundings.tracer.first_hit(scene, ray, 0.0);
            first.is_some_and(|first| first.distance() == hit.distance())
        };
        let mut hits = hits(scene, &self.layers[layer], *ray);
        let found = hits.find(|(encounter, hit)| (self.continued && faces(encounter, ray)) || stops(hit));
        let Some((_, hit)) = found else { return Vec4::ZERO };
        let encounter = self.layers[layer].encounter(scene, ray, &hit, change);
        let mut paths = PathTracer::new(scene, self.everything, PathModel::Tree, self.order);
        paths.radiance_from(*ray, change.copied(), &encounter).extend(1.0)
    }
}
