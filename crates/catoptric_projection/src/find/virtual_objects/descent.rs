//! Descent of a path tree: from scene points back to the eye, bounce by bounce.

use super::arrivals::PathBranch;
use super::locator::{Locator, Reflector};
use super::mesh::ReflectorMesh;
use super::path_tree::{PathLevel, PathTree, RaySet};
use super::rays::{ReflectionPoint, ReflectionPoints};
use crate::find::work;
use catoptric_engine::method::projector::MAX_BOUNCES;
use catoptric_engine::optics::path::bundle::Bounce;
use glam::{Mat3, Vec3};

/// The point of a bounce that is an object for the bounce before.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Recursion {
    /// The virtual point in the tangent plane at the reflection point (Ofek, Rappoport 1998).
    VirtualPoints,
    /// The reflection point itself, made to obey the law of the bounce: it appears where the virtual point would.
    ReflectionPoints,
}

/// One place on a path where a point appears.
#[derive(Clone, Copy)]
pub(crate) struct PathStep {
    pub(crate) reflection_point: ReflectionPoint,
    pub(crate) outside: bool,
    /// The index of refraction of the medium in which the ray goes on.
    pub(crate) index_after: f32,
    pub(crate) bounce: Bounce,
    pub(crate) mesh: u32,
    /// Index of the level.
    pub(super) level: u32,
}

/// An appearance: a point in its direction from the eye, and the bounces to it.
pub(crate) struct Appearance<'a> {
    /// The virtual point after all bounces, or the first bounce.
    pub(crate) seen: Vec3,
    /// The derivative of `seen` with respect to the scene point.
    pub(crate) change: Mat3,
    /// Optical length of the path from the first bounce to the scene point.
    pub(crate) length: f32,
    /// Error bound of `seen` from the reflectors' triangles, in scene units.
    pub(crate) error: f32,
    /// Focal points passed, summed over the path.
    pub(crate) focal_index: u32,
    /// The bounces from the last one back to the eye.
    pub(crate) steps: &'a [PathStep],
}

/// A path from a scene point back towards the eye, up to one of its bounces.
#[derive(Clone, Copy)]
struct PartialPath<'a> {
    steps: &'a [PathStep],
    /// The ray set that the next bounce must belong to, and the branch from there.
    wanted: Option<(u32, PathBranch)>,
    point: Vec3,
    change: Mat3,
    /// Error bound of `point` from the reflectors' triangles, in scene units.
    error: f32,
    /// Optical length from the last reflection point to the scene point, and the part of the way to `point` that lies
    /// behind that reflection point, in scene units.
    length: f32,
    behind: f32,
    focal_index: u32,
}

/// Scratch space of a descent.
#[derive(Default)]
pub(super) struct DescentScratch {
    /// Reflection points of a batch, for each ray set of a path's last bounce.
    located: Vec<LocatedBatch>,
    /// Reflection points of one point at each bounce before the last.
    inner: [ReflectionPoints; MAX_BOUNCES],
}

/// Reflection points of a batch of scene points by one ray set.
#[derive(Default)]
struct LocatedBatch {
    /// The points that can appear by the ray set.
    points: Vec<Vec3>,
    /// The place of each point of the batch in `points`; [`LEFT_OUT`] if it is not located.
    rows: Vec<usize>,
    found: ReflectionPoints,
}

/// Work of a bounce at a reflection point.
const WORK_A_BOUNCE: u64 = 4;

/// The row of points that are not located: beyond all rows.
const LEFT_OUT: usize = usize::MAX;

/// Descends a path tree.
pub(super) struct Descent<'a, L> {
    pub(super) tree: &'a PathTree<L>,
    pub(super) meshes: &'a [ReflectorMesh],
    pub(super) recursion: Recursion,
}

impl<L> PathTree<L> {
    /// The mesh that a step's reflection point is on.
    pub(super) fn mesh_of<'a>(&'a self, meshes: &'a [ReflectorMesh], step: &PathStep) -> &'a ReflectorMesh {
        self.levels[step.level as usize].reflector_mesh(meshes)
    }
}

/// A ray set of a level, with its reflector.
struct LevelRays<'a, L> {
    /// Index of the level.
    index: u32,
    level: &'a PathLevel<L>,
    ray_set: &'a RaySet<L>,
    reflector: Reflector<'a>,
}

impl<L> Clone for LevelRays<'_, L> {
    fn clone(&self) -> Self {
        *self
    }
}

impl<L> Copy for LevelRays<'_, L> {}

impl<'a, L: Locator> Descent<'a, L> {
    /// The ray sets of a path's last bounce; none for a path that the tree does not hold.
    fn ray_sets(&self, path: u32) -> impl Iterator<Item = LevelRays<'a, L>> {
        let Self { tree, meshes, .. } = *self;
        tree.levels.get(path as usize).into_iter().flat_map(move |level| {
            level.ray_sets.iter().map(move |ray_set| {
                let reflector = tree.reflector(meshes, level, ray_set);
                LevelRays { index: path, level, ray_set, reflector }
            })
        })
    }

    /// Finds the reflection points of a batch of scene points at a path's last bounce.
    pub(super) fn locate(&self, path: u32, points: &[Vec3], scratch: &mut DescentScratch) {
        for (count, LevelRays { ray_set, reflector, .. }) in self.ray_sets(path).enumerate() {
            if count == scratch.located.len() {
                scratch.located.push(LocatedBatch::default());
            }
            let batch = &mut scratch.located[count];
            batch.points.clear();
            batch.rows.clear();
            batch.found.clear();
            for point in points {
                // Rays within a body end at its surface: points beyond never appear by them.
                let can_appear = point.is_finite() && (!ray_set.rays.inside_after || reflector.mesh.may_hold(*point));
                batch.rows.push(if can_appear { batch.points.len() } else { LEFT_OUT });
                if can_appear {
                    batch.points.push(*point);
                }
            }
            ray_set.locator.locate(&reflector, &batch.points, &mut batch.found);
        }
    }

    /// Calls `take` for all appearances on a path of the scene point with this number in the batch that was located
    /// last.
    pub(super) fn appearances(
        &self,
        path: u32,
        (number, point): (usize, Vec3),
        scratch: &mut DescentScratch,
        take: &mut dyn FnMut(&Appearance<'_>),
    ) {
        let start = PartialPath {
            steps: &[],
            wanted: None,
            point,
            change: Mat3::IDENTITY,
            error: 0.0,
            length: 0.0,
            behind: 0.0,
            focal_index: 0,
        };
        let DescentScratch { located, inner } = scratch;
        for (rays, batch) in self.ray_sets(path).zip(located) {
            for found in batch.found.of(batch.rows[number]) {
                self.bounce(&rays, &start, found, inner, take);
            }
        }
    }

    /// Goes on at the bounce before, by all its reflection points of the path's end.
    fn descend(
        &self,
        index: u32,
        from: &PartialPath<'_>,
        scratch: &mut [ReflectionPoints],
        take: &mut dyn FnMut(&Appearance<'_>),
    ) {
        let Some((found, inner)) = scratch.split_first_mut() else { return };
        for (number, rays) in self.ray_sets(index).enumerate() {
            if from.wanted.is_some_and(|(wanted, _)| wanted != number as u32) {
                continue;
            }
            found.clear();
            rays.ray_set.locator.locate(&rays.reflector, &[from.point], found);
            for found in found.of(0) {
                self.bounce(&rays, from, found, inner, take);
            }
        }
    }

    /// Adds a bounce at one reflection point, and goes on from there.
    fn bounce(
        &self,
        rays: &LevelRays<'_, L>,
        from: &PartialPath<'_>,
        found: &ReflectionPoint,
        scratch: &mut [ReflectionPoints],
        take: &mut dyn FnMut(&Appearance<'_>),
    ) {
        work::add(WORK_A_BOUNCE);
        let LevelRays { index, level, ray_set, ref reflector } = *rays;
        let distance = found.position.distance(from.point);
        let branch = PathBranch::from(reflector, found, distance);
        if from.wanted.is_some_and(|(_, wanted)| wanted != branch) {
            return;
        }
        let reflection_point = match self.recursion {
            Recursion::VirtualPoints => *found,
            Recursion::ReflectionPoints => match found.corrected(reflector.mesh, &ray_set.rays, from.point) {
                Some(corrected) => corrected,
                // Hidden points appear beside the silhouette.
                None if found.beyond => *found,
                // The ray at this place leads past the point, far from it: no reflection.
                None => return,
            },
        };
        let distance = reflection_point.position.distance(from.point);
        let (point, moves, behind) = match self.recursion {
            Recursion::ReflectionPoints if reflection_point.beyond => {
                let (point, moves) = reflection_point.beside(from.point);
                (point, moves, 0.0)
            }
            Recursion::ReflectionPoints => (reflection_point.position, reflection_point.position_change, 0.0),
            Recursion::VirtualPoints => {
                let Some((seen, moves)) = reflection_point.virtual_point(&ray_set.rays, from.point) else { return };
                (seen, moves, distance)
            }
        };
        let (outside, index_after) = (ray_set.rays.side > 0.0, ray_set.rays.index_after);
        let step =
            PathStep { reflection_point, outside, index_after, bounce: level.bounce, mesh: level.mesh, level: index };
        let mut steps = [step; MAX_BOUNCES];
        let count = from.steps.len();
        if count >= steps.len() {
            return;
        }
        steps[..count].copy_from_slice(from.steps);
        let normal_error = reflector.mesh.normal_errors[reflection_point.triangle as usize];
        let missed = distance * ray_set.rays.bend(normal_error);
        let next = PartialPath {
            steps: &steps[..=count],
            wanted: ray_set.parent,
            point,
            change: moves * from.change,
            error: spread(&moves) * (from.error + missed),
            length: from.length + (distance - from.behind) * index_after,
            behind,
            focal_index: from.focal_index + branch.focal_index,
        };
        match level.parent {
            Some(parent) => self.descend(parent, &next, scratch, take),
            None => take(&Appearance {
                seen: point,
                change: next.change,
                error: next.error,
                length: next.length,
                focal_index: next.focal_index,
                steps: next.steps,
            }),
        }
    }
}

/// Factor by which a change lengthens a small step, about.
fn spread(change: &Mat3) -> f32 {
    change.x_axis.length_squared().max(change.y_axis.length_squared()).max(change.z_axis.length_squared()).sqrt()
}
