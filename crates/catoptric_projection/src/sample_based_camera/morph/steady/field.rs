//! Appearances of the points of dense objects, interpolated.

use super::super::cache::AroundEye;
use super::super::sightings::Sightings;
use super::cubes::{Cube, CubeKey};
use crate::draw::virtual_mesh::SteadyField;
use crate::find::node_sightings::{MOST_NODES, NodeSightings};
use crate::find::work::SharedWork;
use catoptric_core::parallel;
use catoptric_core::progress::{Cancelled, Stage};
use glam::Vec3;
use rustc_hash::FxHashMap;
use std::sync::Arc;

/// Points are interpolated in cubes with so many of them or more: finding a cube takes about as long as two points, if
/// its neighbours are found, too. Chosen, not measured.
const LEAST_POINTS: u32 = 8;

/// Cubes where that is not accurate are cut into eight this often, as long as their parts have so many points. A bound
/// on time; chosen, not measured.
const MOST_CUTS: u32 = 4;

/// What the nodes around the eye see where an object's points lie densely.
pub(super) struct SightingField {
    nodes: [Vec3; MOST_NODES],
    /// The middle of the mirror.
    middle: Vec3,
    cubes: FxHashMap<CubeKey, Arc<Cube>>,
}

impl SightingField {
    /// On a path, by its number at the nodes, in a mirror of this size, by what `look` sees from the nodes at points;
    /// `None` where no points are dense, or there is too much work.
    ///
    /// # Errors
    /// [`Cancelled`].
    pub(super) fn new(
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

#[cfg(test)]
mod tests {
    use super::*;
    use crate::find::node_sightings::Sighting;
    use catoptric_core::progress::Silent;
    use glam::Mat3;
    use std::sync::atomic::{AtomicU64, Ordering};

    const NODES: [Vec3; MOST_NODES] =
        [Vec3::ZERO, Vec3::new(0.3, 0.0, 0.0), Vec3::new(0.3, 0.3, 0.0), Vec3::new(0.3, 0.3, 0.3)];

    /// What bends with the point's place, but beyond a plane, where nothing appears.
    fn look(point: Vec3) -> Arc<[Sightings]> {
        if point.x > 2.0 {
            return Arc::from([]);
        }
        let at = NODES.map(|node| {
            let first = 0.1 * point + 0.05 * node + Vec3::new(0.02 * point.y * point.y, 0.0, 0.001 * point.x.powi(3));
            let column = |x: f32, y: f32, z: f32| Vec3::new(x, y, z);
            Some(Sighting {
                first,
                change: Mat3::from_cols(
                    column(0.1, 0.0, 0.003 * point.x * point.x),
                    column(0.04 * point.y, 0.1, 0.0),
                    column(0.0, 0.0, 0.1),
                ),
                change_with_eye: Some(Mat3::IDENTITY * 0.05),
                normal: Vec3::Y,
                length: 1.5 * (first.distance(node) + first.distance(point)),
                last_segment: first.distance(point),
                error: 0.0,
            })
        });
        Arc::from([Sightings { focal_index: 2, at, is_rough: false }])
    }

    fn points(count: usize) -> Vec<Vec3> {
        let on = |axis: usize, number: usize| (number * [7, 11, 13][axis] % 101) as f32 / 101.0;
        (0..count).map(|k| Vec3::new(1.2 + on(0, k) * 1.2, 0.8 + on(1, k), on(2, k) * 0.3)).collect()
    }

    fn field(known: &AroundEye, points: &[Vec3], size: f32, asked: &AtomicU64) -> Option<SightingField> {
        let stage = Stage::begin(&Silent, "", 1).unwrap();
        let counted = |point| {
            asked.fetch_add(1, Ordering::Relaxed);
            look(point)
        };
        let work = SharedWork::new(u64::MAX);
        SightingField::new((known, 0), (NODES, Vec3::ZERO, size), points, counted, (&work, &stage)).unwrap()
    }

    #[test]
    fn dense_points_are_where_they_are_to_be() {
        let (known, asked) = (AroundEye::default(), AtomicU64::new(0));
        let points = points(4000);
        let dense = field(&known, &points, 1.0, &asked).expect("there are many points");
        let first_asked = asked.load(Ordering::Relaxed);
        assert!(first_asked < points.len() as u64 / 2, "{first_asked}");
        let mut told = 0;
        for &point in &points {
            let Some(found) = dense.sightings(point) else { continue };
            told += 1;
            let [expected] = &*look(point) else { panic!("{point} appears nowhere") };
            assert_eq!(found.focal_index, 2);
            for (found, expected) in found.at.iter().zip(expected.at.iter().flatten()) {
                assert!(found.first.distance(expected.first) < found.error + 1e-6, "{point}");
                assert!((found.length - expected.length).abs() < 1e-4, "{point}");
                let off =
                    (found.change - expected.change).to_cols_array().into_iter().fold(0.0, |a: f32, b| a.max(b.abs()));
                assert!(off < 2e-3, "{point}: {off}");
            }
        }
        let seen = points.iter().filter(|point| point.x <= 2.0).count();
        assert!(told > seen * 3 / 4 && told <= seen, "{told} of {seen}");
        // What is known is not looked for again.
        field(&known, &points, 1.0, &asked).expect("as before");
        assert_eq!(asked.load(Ordering::Relaxed), first_asked);
        // In a small mirror the same errors are too large: there smaller cubes are needed.
        let small = field(&AroundEye::default(), &points, 0.02, &asked).expect("there are many points");
        assert!(asked.load(Ordering::Relaxed) > 2 * first_asked && small.cubes.len() > dense.cubes.len());
    }

    #[test]
    fn few_points_are_no_field() {
        let asked = AtomicU64::new(0);
        assert!(field(&AroundEye::default(), &points(20), 1.0, &asked).is_none());
        let odd = [Vec3::ZERO, Vec3::NAN, Vec3::splat(f32::INFINITY), Vec3::splat(f32::MAX)];
        let odd: Vec<Vec3> = odd.into_iter().cycle().take(100).collect();
        assert!(field(&AroundEye::default(), &odd, 1.0, &asked).is_none());
        assert_eq!(asked.load(Ordering::Relaxed), 0);
    }
}
