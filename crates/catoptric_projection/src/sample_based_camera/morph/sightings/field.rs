//! Appearances of the points of dense objects, interpolated.

use super::around_eye::AroundEye;
use super::cubes::{Cube, CubeKey};
use super::lookout::Sightings;
use crate::draw::virtual_mesh::SteadyField;
use crate::find::node_sightings::{MOST_NODES, NodeSightings};
use crate::find::work::SharedWork;
use catoptric_core::parallel;
use catoptric_core::progress::{Cancelled, Stage};
use glam::Vec3;
use rustc_hash::FxHashMap;
use std::sync::Arc;

/// Points are interpolated in cubes with this many of them or more: finding a cube takes about as long as two points,
/// if its neighbours are found, too. Chosen, not measured.
const LEAST_POINTS: u32 = 8;

/// Cubes where that is not accurate are cut into eight this often, as long as their parts have this many points. A
/// bound on time; chosen, not measured.
const MOST_CUTS: u32 = 4;

/// Interpolated sightings of the nodes around the eye where an object's points lie densely.
pub struct SightingField {
    nodes: [Vec3; MOST_NODES],
    /// The middle of the mirror.
    middle: Vec3,
    cubes: FxHashMap<CubeKey, Arc<Cube>>,
}

impl SightingField {
    /// The field of a path, given by its number at the nodes, in a mirror of this size; `look` finds the sightings of
    /// points. `None` where no points are dense, or there is too much work.
    ///
    /// # Errors
    /// [`Cancelled`].
    pub fn new(
        (known, path): (&AroundEye, u32),
        (nodes, middle, size): ([Vec3; MOST_NODES], Vec3, f32),
        points: &[Vec3],
        look: impl Fn(Vec3) -> Arc<[Sightings]> + Sync,
        (work, stage): (&SharedWork, &Stage<'_>),
    ) -> Result<Option<Self>, Cancelled> {
        let mut field = Self { nodes, middle, cubes: FxHashMap::default() };
        for _ in 0..=MOST_CUTS {
            let dense = field.dense_cubes(points);
            if dense.is_empty() {
                break;
            }
            let found = parallel::map_within(stage, dense.len(), |number| {
                let mut share = work.share();
                let wanted = (path, dense[number]);
                (!share.is_too_much()).then(|| known.cubes.get(wanted, (&nodes, size), &look))
            })?;
            if work.is_too_much() {
                return Ok(None);
            }
            field.cubes.extend(dense.into_iter().zip(found.into_iter().flatten()));
        }
        Ok((!field.cubes.is_empty()).then_some(field))
    }

    /// The number of cubes.
    pub fn cube_count(&self) -> usize {
        self.cubes.len()
    }

    /// The cubes with many points that were not looked at, in their order: parts of those where points are to be looked
    /// for.
    fn dense_cubes(&self, points: &[Vec3]) -> Vec<CubeKey> {
        let mut counts: FxHashMap<CubeKey, u32> = FxHashMap::default();
        for point in points {
            let Some(mut key) = CubeKey::of(*point, self.middle) else { continue };
            loop {
                match self.cubes.get(&key) {
                    Some(cube) if cube.is_known() => break,
                    Some(_) => key = key.part_with(*point),
                    None => {
                        *counts.entry(key).or_default() += 1;
                        break;
                    }
                }
            }
        }
        let is_dense = |(key, count): (CubeKey, u32)| (count >= LEAST_POINTS).then_some(key);
        let mut dense: Vec<CubeKey> = counts.into_iter().filter_map(is_dense).collect();
        dense.sort_unstable();
        dense
    }
}

impl SteadyField for SightingField {
    fn sightings(&self, point: Vec3) -> Option<NodeSightings> {
        let mut key = CubeKey::of(point, self.middle)?;
        loop {
            let cube = self.cubes.get(&key)?;
            if cube.is_known() {
                return cube.sightings(&self.nodes, point);
            }
            key = key.part_with(point);
        }
    }
}
