//! What is around a group of reflectors and lenses: what rays that leave it meet, layer by layer.

use super::groups::LensGroup;
use super::layers::{Meeting, Stratum};
use crate::methods::reference::{PathModel, PathTracer};
use crate::scene::shade::Encounter;
use crate::scene::{Ray, RayDifferential, Scene};
use crate::surface::tracer::{Hit, Tracer};
use glam::Vec4;

/// Surfaces that a ray passes by looking for another; behind so many nothing is looked for.
const MOST_SURFACES: usize = 64;

/// How much further than a surface that was met the next one is looked for, as a share of its distance.
const FURTHER: f32 = 1e-5;

/// All that is not in a group.
#[derive(Clone, Copy)]
pub(super) struct Surroundings<'a> {
    pub(super) scene: &'a Scene,
    /// Of everything, the group too.
    pub(super) everything: &'a Tracer,
    pub(super) group: &'a LensGroup,
}

impl<'a> Surroundings<'a> {
    /// The surfaces along a ray, one behind the other: what it is stopped by, and whatever faces it behind that.
    fn hits(self, ray: Ray) -> impl Iterator<Item = (Encounter, Hit)> + use<'a> {
        let mut near = 0.0;
        let all = std::iter::from_fn(move || {
            let hit = self.everything.first_hit(self.scene, &ray, near)?;
            near = hit.distance() * (1.0 + FURTHER);
            Some(hit)
        });
        let others = all.take(MOST_SURFACES).filter(move |hit| !self.group.holds(hit.object(self.scene)));
        let others = others.map(move |hit| (self.everything.encounter(self.scene, &ray, &hit, None), hit));
        let faces = move |encounter: &Encounter| ray.direction.dot(encounter.point.geometric_normal) < 0.0;
        others.enumerate().filter(move |(order, (encounter, _))| *order == 0 || faces(encounter)).map(|(_, hit)| hit)
    }

    /// Appends what a ray that leaves the group meets.
    pub(super) fn meet(self, number: u32, ray: &Ray, meetings: &mut Vec<Meeting>) {
        meetings.extend(self.hits(*ray).map(|(encounter, _)| {
            let position = encounter.point.position - self.group.center();
            Meeting { ray: number, object: encounter.point.object, position }
        }));
    }
}

/// Things of layers, apart.
pub(super) struct Strata<'a> {
    pub(super) around: Surroundings<'a>,
    /// Of every object the number of its layer.
    layer_of: Vec<Option<u32>>,
    /// How many layers there are.
    pub(super) count: usize,
    /// Events on the paths from them.
    order: u32,
    /// Whether they are seen through the things of other layers.
    continued: bool,
}

impl<'a> Strata<'a> {
    pub(super) fn new(around: Surroundings<'a>, strata: &[Stratum], order: u32, continued: bool) -> Self {
        let mut layer_of = vec![None; around.scene.objects.len()];
        for (number, stratum) in strata.iter().enumerate() {
            stratum.objects.iter().for_each(|object| layer_of[*object as usize] = Some(number as u32));
        }
        Self { around, layer_of, count: strata.len(), order, continued }
    }

    /// What a ray meets, each with its layer's number.
    fn hits(&self, ray: &Ray) -> impl Iterator<Item = (usize, Hit)> {
        let most = if self.continued { usize::MAX } else { 1 };
        let hits = self.around.hits(*ray).take(most);
        hits.filter_map(|(encounter, hit)| Some((self.layer_of[encounter.point.object as usize]? as usize, hit)))
    }

    /// What is seen by a ray where it hits something: radiance with 1.
    fn look(&self, ray: &Ray, change: Option<&RayDifferential>, hit: &Hit) -> Vec4 {
        let Surroundings { scene, everything, .. } = self.around;
        let encounter = everything.encounter(scene, ray, hit, change);
        let mut paths = PathTracer::new(scene, everything, PathModel::Tree, self.order);
        paths.radiance_from(*ray, change.copied(), &encounter).extend(1.0)
    }

    /// All layers, as bits.
    pub(super) fn all(&self) -> u32 {
        (1 << self.count) - 1
    }

    /// Calls, for the wanted layers (as bits), with what a ray that leaves the group meets first of each: from the front (or from behind, as
    /// the first of all things).
    pub(super) fn each_first(&self, ray: &Ray, wanted: u32, mut met: impl FnMut(usize, &Hit)) {
        let mut waiting = wanted;
        if waiting == 0 {
            return;
        }
        for (layer, hit) in self.hits(ray) {
            if waiting >> layer & 1 != 0 {
                met(layer, &hit);
                waiting &= !(1 << layer);
            }
            if waiting == 0 {
                return;
            }
        }
    }

    /// Adds, for the wanted layers (as bits), what a ray that leaves the group sees of each: radiance with 1, or nothing where it meets none
    /// of the layer's things.
    pub(super) fn add_seen(&self, ray: &Ray, change: Option<&RayDifferential>, wanted: u32, seen: &mut [Vec4]) {
        self.each_first(ray, wanted, |layer, hit| seen[layer] += self.look(ray, change, hit));
    }
}
