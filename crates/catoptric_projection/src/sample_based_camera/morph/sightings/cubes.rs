//! Space about a mirror in cubes, and the nodes' sightings at the corners of these.
//!
//! Reflection points change smoothly with the scene point, the more slowly the farther that is from the mirror. Between
//! the corners of cubes whose sides are a share of that distance they are therefore interpolated: the mean of the
//! corners' linear predictions, each over half of the way. This is exact for quadratic changes, as it is between nodes.

use super::between::error_between;
use super::lookout::{Sightings, known_once};
use crate::find::node_sightings::{MOST_NODES, NodeSightings, Sighting};
use crate::find::work;
use glam::{Mat3, Vec3};
use rustc_hash::FxHashMap;
use std::hash::{Hash, Hasher};
use std::sync::{Arc, Mutex, MutexGuard, PoisonError};

/// Sides of cubes are at most this share of the distance from the middle of the mirror, and more than half of it.
/// Chosen, not measured.
const SIDE_OF_DISTANCE: f32 = 0.125;

/// The maximum number of cubes that are kept of a tetrahedron: of three kilobytes each. Chosen, not measured.
const MOST_CUBES: usize = 1 << 12;

const CORNERS: usize = 8;

/// Numbers of a vector at all nodes.
const AT_NODES: usize = 3 * MOST_NODES;

/// Vectors that are interpolated together: the reflection point, its derivatives with the scene point and with the eye
/// by columns, and the normal. The numbers of all nodes follow each other.
const FIRST: usize = 0;
const CHANGE: usize = 1;
const CHANGE_WITH_EYE: usize = 4;
const NORMAL: usize = 7;
const NUMBERS: usize = 8 * AT_NODES;

/// Numbers that are summed at once.
const LANES: usize = 8;

/// A cube: the side, a power of two, and its place in a lattice of such cubes.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub(super) struct CubeKey {
    side_bits: u32,
    index: [i32; 3],
}

impl Hash for CubeKey {
    /// Two words: every point asks for its cube.
    fn hash<H: Hasher>(&self, state: &mut H) {
        let [x, y, z] = self.index.map(|index| u64::from(index as u32));
        state.write_u64(u64::from(self.side_bits) << 32 | x);
        state.write_u64(y << 32 | z);
    }
}

impl CubeKey {
    /// The cube that a point lies in; `None` in the middle of the mirror and very far from it.
    pub(super) fn of(point: Vec3, middle: Vec3) -> Option<Self> {
        let most = point.distance(middle) * SIDE_OF_DISTANCE;
        // The next lower power of two: the number without its fraction.
        let side_bits = most.to_bits() & 0xFF80_0000;
        let side = f32::from_bits(side_bits);
        let index = (point / side).floor();
        // These limits make the corners exact.
        let is_exact = side.is_normal() && index.abs().max_element() < (1 << 18) as f32;
        is_exact.then(|| Self { side_bits, index: index.as_ivec3().to_array() })
    }

    /// The one of its eight parts that a point in it lies in.
    pub(super) fn part_with(&self, point: Vec3) -> Self {
        let half = self.side() * 0.5;
        let index = (point / half).floor().as_ivec3();
        Self { side_bits: half.to_bits(), index: index.to_array() }
    }

    fn side(&self) -> f32 {
        f32::from_bits(self.side_bits)
    }

    fn corner(&self, number: usize) -> Vec3 {
        let offset = |axis: usize| (self.index[axis] + (number >> axis & 1) as i32) as f32;
        Vec3::new(offset(0), offset(1), offset(2)) * self.side()
    }
}

/// The sightings of all nodes at a place, as numbers.
type Numbers = [f32; NUMBERS];

/// The sightings at the corners of a cube.
#[derive(Debug)]
struct CubeValues {
    focal_index: u32,
    /// Optical length of a unit.
    medium: f32,
    error: f32,
    corners: [Numbers; CORNERS],
}

/// A cube, and the work that it took.
#[derive(Debug)]
pub(super) struct Cube {
    key: CubeKey,
    /// `None` where points are looked for one by one.
    values: Option<CubeValues>,
    work: u64,
}

/// Something that nodes see at a place, in order.
fn numbers(at: &[Sighting; MOST_NODES]) -> Numbers {
    let mut all = [0.0; NUMBERS];
    for (node, Sighting { first, change, change_with_eye, normal, .. }) in at.iter().enumerate() {
        let with_eye = change_with_eye.unwrap_or_default();
        let columns = |matrix: &Mat3| [matrix.x_axis, matrix.y_axis, matrix.z_axis];
        let vectors = std::iter::once(*first).chain(columns(change)).chain(columns(&with_eye)).chain([*normal]);
        for (number, vector) in vectors.enumerate() {
            vector.write_to_slice(&mut all[number * AT_NODES + 3 * node..]);
        }
    }
    all
}

/// A vector as a node sees it.
#[inline]
fn vector(all: &Numbers, number: usize, node: usize) -> Vec3 {
    Vec3::from_slice(&all[number * AT_NODES + 3 * node..])
}

/// Three vectors from one on.
#[inline]
fn matrix(all: &Numbers, number: usize, node: usize) -> Mat3 {
    Mat3::from_cols(vector(all, number, node), vector(all, number + 1, node), vector(all, number + 2, node))
}

/// The sightings at a corner, if the point appears once, and exactly so at all nodes.
fn only_one(found: &[Sightings]) -> Option<NodeSightings> {
    known_once(found).filter(|seen| seen.at.iter().all(|at| at.change_with_eye.is_some()))
}

impl Cube {
    /// A cube from the sightings at its corners in a mirror of this size.
    fn new(key: CubeKey, nodes: &[Vec3; MOST_NODES], size: f32, look: impl Fn(Vec3) -> Arc<[Sightings]>) -> Self {
        let before = work::done();
        let values = CubeValues::new(&key, nodes, size, &look);
        Self { key, values, work: work::since(before) }
    }

    /// True if the sightings in it are known.
    pub(super) fn is_known(&self) -> bool {
        self.values.is_some()
    }

    /// The sightings of a point in the cube from the nodes at these places; `None` where they have to be searched.
    pub(super) fn sightings(&self, nodes: &[Vec3; MOST_NODES], point: Vec3) -> Option<NodeSightings> {
        let CubeValues { focal_index, medium, error, corners } = self.values.as_ref()?;
        let at = interpolated(corners, self.key.side(), (point - self.key.corner(0)) / self.key.side());
        let mut seen = [Sighting::default(); MOST_NODES];
        for (node, seen) in seen.iter_mut().enumerate() {
            let first = vector(&at, FIRST, node);
            let last_segment = first.distance(point);
            *seen = Sighting {
                first,
                change: matrix(&at, CHANGE, node),
                change_with_eye: Some(matrix(&at, CHANGE_WITH_EYE, node)),
                normal: vector(&at, NORMAL, node),
                // The true path is the shortest of those near it, so that an error of the point hardly changes the
                // length.
                length: medium * (first.distance(nodes[node]) + last_segment),
                last_segment,
                error: *error,
            };
        }
        Some(NodeSightings { focal_index: *focal_index, at: seen })
    }
}

impl CubeValues {
    fn new(
        key: &CubeKey,
        nodes: &[Vec3; MOST_NODES],
        size: f32,
        look: impl Fn(Vec3) -> Arc<[Sightings]>,
    ) -> Option<Self> {
        let places: [Vec3; CORNERS] = std::array::from_fn(|number| key.corner(number));
        let first = only_one(&look(places[0]))?;
        let mut seen = [first; CORNERS];
        for (seen, place) in seen.iter_mut().zip(places).skip(1) {
            let found = only_one(&look(place))?;
            (found.focal_index == first.focal_index).then(|| *seen = found)?;
        }
        let mut error = 0.0f32;
        for (number, (one, from)) in seen.iter().zip(places).enumerate() {
            for (other, to) in seen.iter().zip(places).skip(number + 1) {
                error = error.max(error_between(&one.at, &other.at, to - from, size)?);
            }
        }
        let corners = seen.map(|seen| numbers(&seen.at));
        let [at_first_node, ..] = &first.at;
        let medium = at_first_node.length / (at_first_node.first.distance(nodes[0]) + at_first_node.last_segment);
        Some(Self { focal_index: first.focal_index, medium, error, corners })
    }
}

/// The interpolated sightings at a place, given in sides from the first corner.
#[multiversion::multiversion(targets("x86_64+avx2+bmi1+bmi2+popcnt+lzcnt"))]
fn interpolated(corners: &[Numbers; CORNERS], side: f32, place: Vec3) -> Numbers {
    let mut weights = [0.0; CORNERS];
    // Times half of the way from the corner.
    let mut half_ways = [[0.0; 3]; CORNERS];
    for number in 0..CORNERS {
        let mut weight = 1.0;
        let mut ways = [0.0; 3];
        for axis in 0..3 {
            let is_far = number >> axis & 1 == 1;
            weight *= if is_far { place[axis] } else { 1.0 - place[axis] };
            ways[axis] = if is_far { place[axis] - 1.0 } else { place[axis] };
        }
        weights[number] = weight;
        for axis in 0..3 {
            half_ways[number][axis] = 0.5 * side * weight * ways[axis];
        }
    }
    let mut at = [0.0; NUMBERS];
    // Each group has as many sums as registers hold.
    for (group, sums) in at.chunks_exact_mut(LANES).enumerate() {
        let mut all = [0.0f32; LANES];
        for (corner, weight) in corners.iter().zip(weights) {
            for (lane, sum) in all.iter_mut().enumerate() {
                *sum += corner[group * LANES + lane] * weight;
            }
        }
        sums.copy_from_slice(&all);
    }
    let mut ahead = [0.0; AT_NODES];
    for (corner, half_way) in corners.iter().zip(half_ways) {
        for (axis, times) in half_way.into_iter().enumerate() {
            for (number, sum) in ahead.iter_mut().enumerate() {
                *sum += corner[(CHANGE + axis) * AT_NODES + number] * times;
            }
        }
    }
    for (first, ahead) in at[FIRST * AT_NODES..].iter_mut().zip(ahead) {
        *first += ahead;
    }
    at
}

type KnownCubes = FxHashMap<(u32, CubeKey), Arc<Cube>>;

/// The cubes of a tetrahedron's paths that are known.
#[derive(Default)]
pub(in super::super) struct CubeCache(Mutex<KnownCubes>);

impl CubeCache {
    fn locked(&self) -> MutexGuard<'_, KnownCubes> {
        self.0.lock().unwrap_or_else(PoisonError::into_inner)
    }

    /// A cube of a path, from the sightings of points that `look` finds. Known and new cubes count as the same work.
    pub(super) fn get(
        &self,
        (path, key): (u32, CubeKey),
        (nodes, size): (&[Vec3; MOST_NODES], f32),
        look: impl Fn(Vec3) -> Arc<[Sightings]>,
    ) -> Arc<Cube> {
        let known = self.locked().get(&(path, key)).cloned();
        if let Some(known) = known {
            work::add(known.work);
            return known;
        }
        let cube = Arc::new(Cube::new(key, nodes, size, look));
        let mut known = self.locked();
        if known.len() >= MOST_CUBES {
            known.clear();
        }
        known.insert((path, key), cube.clone());
        cube
    }
}
