//! Geometry around a group of reflectors and lenses, and its hits by rays that leave the group, layer by layer.

use super::layers::{LayerHit, LayerSpec};
use crate::layered_environment_map::textures::maps::MAX_LAYERS;
use catoptric_core::scene::hit::Hit;
use catoptric_core::scene::shade::SurfaceInteraction;
use catoptric_core::scene::{Ray, RayDifferential, Scene};
use catoptric_engine::light::path_tracer::{PathModel, PathTracer};
use catoptric_engine::light::tracer::Tracer;
use glam::{Vec3, Vec4};

/// Surfaces that a ray passes by looking for another; behind this many nothing is looked for. A bound on time; chosen,
/// not measured.
const MAX_SURFACES: usize = 64;

/// The distance beyond a surface hit from which on the next surface is searched, as a share of the hit's distance.
/// Chosen well above rounding, not measured.
const FURTHER: f32 = 1e-5;

/// Like [`FURTHER`], as a share of the scene's diagonal, for surfaces that rays start from: the middle of a flat mirror
/// lies on it. Chosen well above rounding, not measured.
const FURTHER_OF_SCENE: f32 = 1e-6;

/// A surface on the way of a ray.
struct ShellCrossing {
    encounter: SurfaceInteraction,
    hit: Hit,
    /// True for hits on the front.
    is_faced: bool,
}

/// The surroundings of a group, or of the groups that share a layer: all objects that are in none of these.
#[derive(Clone, Copy)]
pub(crate) struct DistantGeometry<'a> {
    pub(crate) scene: &'a Scene,
    /// Hierarchy of all objects, those of the group included.
    pub(crate) everything: &'a Tracer,
    /// The objects of the groups, ascending.
    pub(crate) within: &'a [u32],
    /// The centre of the group.
    pub(crate) center: Vec3,
}

/// The surfaces of a tracer along a ray, one behind the other, from either side; no more than [`MAX_SURFACES`].
pub(crate) fn further_hits<'a>(scene: &'a Scene, tracer: &'a Tracer, ray: Ray) -> impl Iterator<Item = Hit> + use<'a> {
    let (mut near, least) = (0.0, FURTHER_OF_SCENE * scene.bounds.diagonal());
    let all = std::iter::from_fn(move || {
        let hit = tracer.first_hit(scene, &ray, near)?;
        near = hit.distance() * (1.0 + FURTHER) + least;
        Some(hit)
    });
    all.take(MAX_SURFACES)
}

impl<'a> DistantGeometry<'a> {
    /// The surfaces along a ray, one behind the other: the first hit, and the surfaces behind it that face the ray.
    fn hits(self, ray: Ray) -> impl Iterator<Item = (SurfaceInteraction, Hit)> + use<'a> {
        let all = self.all_hits(ray).enumerate();
        all.filter(|(order, met)| *order == 0 || met.is_faced).map(|(_, met)| (met.encounter, met.hit))
    }

    /// The surfaces along a ray, one behind the other, from either side.
    fn all_hits(self, ray: Ray) -> impl Iterator<Item = ShellCrossing> + use<'a> {
        let all = further_hits(self.scene, self.everything, ray);
        let others = all.filter(move |hit| !self.holds(hit.object(self.scene)));
        others.map(move |hit| {
            let encounter = self.everything.encounter(self.scene, &ray, &hit, None);
            ShellCrossing { is_faced: ray.direction.dot(encounter.point.geometric_normal) < 0.0, encounter, hit }
        })
    }

    /// Returns true for objects of the group.
    #[inline]
    fn holds(&self, object: u32) -> bool {
        self.within.binary_search(&object).is_ok()
    }

    /// Appends the hits of a ray that leaves the group.
    pub(crate) fn meet(self, number: u32, ray: &Ray, meetings: &mut Vec<LayerHit>) {
        meetings.extend(self.hits(*ray).map(|(encounter, _)| {
            let position = encounter.point.position - self.center;
            LayerHit { ray: number, object: encounter.point.object, position }
        }));
    }
}

/// Things of layers, apart.
pub(crate) struct LayerSpecs<'a> {
    pub(crate) around: DistantGeometry<'a>,
    /// Number of the layer of every object.
    layer_of: Vec<Option<u32>>,
    /// The number of layers.
    pub(crate) count: usize,
    /// Events on the paths from them.
    order: u32,
    /// True if rays pass through objects of other layers.
    continued: bool,
}

impl<'a> LayerSpecs<'a> {
    /// The objects of layers, the nearest layer first.
    pub(crate) fn new<'b>(
        around: DistantGeometry<'a>,
        strata: impl IntoIterator<Item = &'b LayerSpec>,
        order: u32,
        continued: bool,
    ) -> Self {
        let (mut layer_of, mut count) = (vec![None; around.scene.objects.len()], 0);
        for stratum in strata {
            stratum.objects.iter().for_each(|object| layer_of[*object as usize] = Some(count));
            count += 1;
        }
        Self { around, layer_of, count: count as usize, order, continued }
    }

    /// Hits of a ray, each with its layer's number.
    fn hits(&self, ray: &Ray) -> impl Iterator<Item = (usize, Hit)> {
        let most = if self.continued { usize::MAX } else { 1 };
        let hits = self.around.hits(*ray).take(most);
        hits.filter_map(|(encounter, hit)| Some((self.layer_of[encounter.point.object as usize]? as usize, hit)))
    }

    /// The radiance along a ray from a hit, with opacity 1.
    fn look(&self, ray: &Ray, change: Option<&RayDifferential>, hit: &Hit) -> Vec4 {
        let DistantGeometry { scene, everything, .. } = self.around;
        let encounter = everything.encounter(scene, ray, hit, change);
        let mut paths = PathTracer::new(scene, everything, PathModel::Tree, self.order);
        paths.radiance_from(*ray, change.copied(), &encounter).extend(1.0)
    }

    /// A bit for each layer.
    pub(crate) fn all(&self) -> u32 {
        (1 << self.count) - 1
    }

    /// Calls `met` with the first hit, on each of the wanted layers (as bits), of a ray that leaves the group: from the
    /// front (or from behind, as the first of all surfaces).
    pub(crate) fn each_first(&self, ray: &Ray, wanted: u32, mut met: impl FnMut(usize, &Hit)) {
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

    /// Calls `met`, for each of the wanted layers (as bits), with the distance of a ray's first hit, twice; and once
    /// more with the distance at which the ray leaves that object again, where it is a solid.
    pub(crate) fn each_depth(&self, ray: &Ray, wanted: u32, mut met: impl FnMut(usize, [f32; 2])) {
        let (mut waiting, mut within) = (wanted, [None; MAX_LAYERS]);
        if waiting == 0 {
            return;
        }
        for (order, ShellCrossing { encounter, hit, is_faced }) in self.around.all_hits(*ray).enumerate() {
            let Some(layer) = self.layer_of[encounter.point.object as usize].map(|layer| layer as usize) else {
                continue;
            };
            if waiting >> layer & 1 == 0 {
                continue;
            }
            match within[layer] {
                None if order == 0 || (is_faced && self.continued) => {
                    within[layer] = Some((encounter.point.object, hit.distance()));
                    met(layer, [hit.distance(); 2]);
                    // A surface hit from behind has no other side.
                    waiting &= if is_faced { u32::MAX } else { !(1 << layer) };
                }
                Some((object, front)) if object == encounter.point.object => {
                    if !is_faced {
                        met(layer, [front, hit.distance()]);
                    }
                    waiting &= !(1 << layer);
                }
                _ => {}
            }
            if waiting == 0 {
                return;
            }
        }
    }

    /// Adds, for each of the wanted layers (as bits), the radiance along a ray that leaves the group, with opacity 1;
    /// nothing where it meets none of the layer's objects.
    pub(crate) fn add_seen(&self, ray: &Ray, change: Option<&RayDifferential>, wanted: u32, seen: &mut [Vec4]) {
        self.each_first(ray, wanted, |layer, hit| seen[layer] += self.look(ray, change, hit));
    }
}
