//! Divides triangles where what arrives between their corners is not what arrives at these.

use super::super::super::Scene;
use super::super::shade::Barycentrics;
use super::corners::{CornerSamples, Corners, is_lit};
use super::gather::{GROUPS, Gathered, Gatherer, Sample, near};
use super::shares::{Arriving, Node, SurfaceShares};
use crate::parallel;
use crate::progress::Cancelled;
use glam::{UVec2, Vec2, Vec3};
use std::collections::HashMap;

/// Points between corners at which light is gathered, at most.
const MOST_POINTS: usize = 24_000;

/// Points that are left undone rather than sought alone.
const LEAST_POINTS: usize = 64;

/// Triangles are divided by halving their sides so often at most.
const LEVELS: u32 = 12;

/// A share between two points differs from their mean by no more than this, or the triangle is divided; light of
/// emitters by no more than this part of itself and of all light there.
const TOLERANCE: f32 = 0.03;

/// The light of emitters that is known to be none, in parts of the brightest that arrives anywhere.
const FAINT: f32 = 0.02;

/// A triangle is divided where its longest side is longer than this part of the scene's size, and never where it is
/// shorter than the other of its object's.
const LONGEST: f32 = 1.0 / 16.0;
const SHORTEST: f32 = 1.0 / 512.0;

/// The same beside a smaller object, in parts of that one's size.
const LONGEST_BESIDE: f32 = 1.0 / 4.0;
const SHORTEST_BESIDE: f32 = 1.0 / 64.0;

/// Pairs of a triangle and an object that are looked at, at most.
const MOST_PAIRS: usize = 20_000_000;

/// The light of a corner is gathered within this part of sides about it, so that it is right for what lies between
/// corners (as a fit to all of it would make it: Kavan, Bargteil, Sloan 2011), and nearer where that is divided.
const ABOUT: f32 = 0.25;

/// The same of points within triangles, of the sides of the node between whose corners they lie.
const ABOUT_POINT: f32 = 1.0 / 16.0;

/// Differences between the ends of a side of which the light in its middle is off by so much, where it is not known.
const BEND: f32 = 0.25;

/// The same at least, in tolerances, as what is small may stand before the middle of a triangle; more for large ones.
const LEAST_BEND: f32 = 0.25;
const LEAST_BEND_OF_LARGE: f32 = 2.0;

/// Nodes are divided together whose errors are no smaller than this part of the worst.
const NEARLY_AS_WRONG: f32 = 1.0 / 8.0;

/// A node that may be divided.
#[derive(Clone, Copy)]
struct Candidate {
    node: u32,
    triangle: u32,
    /// Weights of the triangle's second and third corner at the node's corners, in units of 2^-[`LEVELS`].
    corners: [UVec2; 3],
    /// Longer than any may be.
    is_large: bool,
    /// How much light is wrong as long as it is not divided, about: an area times tolerances.
    error: f32,
}

const WHOLE: u32 = 1 << LEVELS;

/// Where light is gathered: at the corners of triangles, and at others.
pub(super) struct Places<'a> {
    corners: &'a Corners,
    pub(super) others: Vec<Place>,
}

impl<'a> Places<'a> {
    pub(super) fn new(corners: &'a Corners) -> Self {
        Self { corners, others: Vec::new() }
    }

    pub(super) fn corner_count(&self) -> usize {
        self.corners.count()
    }

    /// The samples of corners.
    pub(super) fn corner_samples(&self, scene: &Scene) -> CornerSamples<'a> {
        self.corners.samples((ABOUT * LONGEST * scene.bounds.diagonal(), ABOUT))
    }

    /// The position and normal of a place, corners first, in the order of what arrives.
    pub(super) fn middle(&self, scene: &Scene, place: usize) -> (Vec3, Vec3) {
        if place < self.corners.count() {
            return self.corners.place(place);
        }
        let Some(other) = place.checked_sub(self.corners.count() + 1) else { return (Vec3::ZERO, Vec3::Y) };
        match self.others[other] {
            Place::Corner(corner) => self.corners.place(corner as usize),
            Place::Point { triangle, at, .. } => {
                let value = at.as_vec2() / WHOLE as f32;
                let point = scene.surface_point(triangle, &Barycentrics { value, ..Barycentrics::default() });
                (point.position, point.normal)
            }
        }
    }

    /// A sample of another place.
    pub(super) fn sample(&self, scene: &Scene, place: usize, number: usize) -> Sample {
        let within = (ABOUT * SHORTEST * scene.bounds.diagonal(), ABOUT);
        let (triangle, at) = match self.others[place] {
            Place::Corner(corner) => self.corners.sample(scene, corner as usize, number, within),
            Place::Point { triangle, at, part } => {
                let (at, number) = (at.as_vec2() / WHOLE as f32, place * 7 % 4096 + number);
                (triangle, near(at, number as u32, Vec2::splat(part)))
            }
        };
        Sample { triangle, at, group: number as u8 }
    }
}

/// Finds the light at all places of a scene's triangles: those are divided first of which most light is wrong. Adds
/// the places that are no corners.
pub(super) fn refined(gatherer: &Gatherer<'_>, places: &mut Places<'_>) -> Result<SurfaceShares, Cancelled> {
    let (scene, corners) = (gatherer.scene, places.corners);
    let samples = places.corner_samples(scene);
    let found =
        gatherer.gathered((samples.count(), samples.each), |corner, number| samples.sample(scene, corner, number))?;
    let mut arriving: Vec<Arriving> = samples.shared(scene, found).iter().map(Gathered::arriving).collect();
    // For vertices that nothing needs.
    let open = arriving.len() as u32;
    arriving.push(Arriving::OPEN);
    let corner = |vertex: u32| corners.of_vertex(vertex).min(open);
    let nodes = scene.triangles.iter().map(|vertices| Node { corners: vertices.map(corner), parts: 0 }).collect();
    let differs = Difference::new(&arriving, gatherer.sources.sky_irradiance());
    let shares = SurfaceShares { arriving, nodes };
    let neighbours = Neighbours::new(scene);
    // Where neighbours share their light, a corner of its own would stand out.
    let first = |corner: u32| if corners.are_apart() { u32::MAX } else { corner };
    let near_corners = (0..corners.count() as u32).map(first).collect();
    let mut refinement =
        Refinement { gatherer, places, differs, neighbours, shares, near_corners, known: HashMap::new() };
    let whole = [UVec2::ZERO, UVec2::new(WHOLE, 0), UVec2::new(0, WHOLE)];
    let wholes = parallel::map_collect(scene.triangles.len(), |triangle| {
        let is_lit = is_lit(scene.material_of(scene.triangle_objects[triangle]));
        is_lit.then(|| refinement.candidate(triangle as u32, triangle as u32, whole, 0.0)).flatten()
    });
    let mut candidates: Vec<Candidate> = wholes.into_iter().flatten().collect();
    let mut left = MOST_POINTS;
    while left >= LEAST_POINTS && !candidates.is_empty() {
        // The others wait, as parts of these may be worse than they are.
        let worst = candidates.iter().map(|candidate| candidate.error).fold(0.0, f32::max);
        let mut rest: Vec<Candidate> =
            candidates.extract_if(.., |candidate| candidate.error < NEARLY_AS_WRONG * worst).collect();
        // Each asks for six points at most; half of what is left is for what they show.
        let most = left.div_ceil(12);
        if candidates.len() > most {
            let worst_first =
                |one: &Candidate, other: &Candidate| other.error.total_cmp(&one.error).then(one.node.cmp(&other.node));
            candidates.select_nth_unstable_by(most, worst_first);
            rest.extend(candidates.drain(most..));
        }
        let asked = refinement.shares.arriving.len();
        let divided = refinement.find_divided(&candidates)?;
        let corners = refinement.corners_of_parts(&divided)?;
        candidates = rest;
        for ((parent, middles, bend), corners) in divided.iter().zip(corners) {
            refinement.divide(parent, corners, *middles, *bend, &mut candidates);
        }
        left = left.saturating_sub(refinement.shares.arriving.len() - asked);
    }
    Ok(refinement.shares)
}

/// Triangles that are being divided.
struct Refinement<'a, 'c> {
    gatherer: &'a Gatherer<'a>,
    places: &'a mut Places<'c>,
    differs: Difference,
    neighbours: Neighbours,
    shares: SurfaceShares,
    /// Indices of the light right at corners, for divided triangles; `u32::MAX`: not known.
    near_corners: Vec<u32>,
    /// Indices of the light about points of triangles, for nodes of a length of sides.
    known: HashMap<(u32, UVec2, u32), u32>,
}

/// A node that is to be divided, what arrives at the middles of its sides, and by how much that bends, in tolerances.
type ToDivide = (Candidate, [u32; 3], f32);

/// Where light is gathered.
#[derive(Clone, Copy)]
pub(super) enum Place {
    /// Right at a corner of triangles.
    Corner(u32),
    /// About a point of a triangle, within a part of its sides.
    Point { triangle: u32, at: UVec2, part: f32 },
}

/// The length of a node's sides in the units of its corners: 1 where it cannot be divided.
fn side([a, b, c]: [UVec2; 3]) -> u32 {
    (a.max(b).max(c) - a.min(b).min(c)).max_element()
}

impl Refinement<'_, '_> {
    /// A node as a candidate, unless it is too small or divided too often; `bend`: by how much light is known to bend
    /// within it, about.
    fn candidate(&self, node: u32, triangle: u32, corners: [UVec2; 3], bend: f32) -> Option<Candidate> {
        let (length, area, [most, least]) = self.neighbours.limits(self.gatherer.scene, triangle, corners);
        let is_large = length > most;
        let ends = self.shares.nodes[node as usize].corners.map(|index| &self.shares.arriving[index as usize]);
        let least_bend = if is_large { LEAST_BEND_OF_LARGE } else { LEAST_BEND };
        let bend = (BEND * self.differs.of_ends(ends)).max(bend).max(least_bend);
        // Few places that are very wrong are seen rather than many that are a little wrong.
        let may_be = length > least && side(corners) > 1;
        may_be.then_some(Candidate { node, triangle, corners, is_large, error: area * bend * bend })
    }

    /// Gathers light at places, after what is known.
    fn gather(&mut self, wanted: Vec<Place>) -> Result<(), Cancelled> {
        let (scene, count, first) = (self.gatherer.scene, wanted.len(), self.places.others.len());
        self.places.others.extend(wanted);
        let places = &*self.places;
        let sample = |place: usize, number: usize| places.sample(scene, first + place, number);
        let gathered = self.gatherer.gathered((count, GROUPS), sample)?;
        self.shares.arriving.extend(gathered.iter().map(Gathered::arriving));
        Ok(())
    }

    /// The index of what arrives at a point for a node, which is among the places to gather if it is not known.
    fn point(&mut self, node: &Candidate, at: UVec2, places: &mut Vec<Place>) -> u32 {
        let side = side(node.corners);
        let next = (self.shares.arriving.len() + places.len()) as u32;
        *self.known.entry((node.triangle, at, side)).or_insert_with(|| {
            places.push(Place::Point { triangle: node.triangle, at, part: ABOUT_POINT * side as f32 / WHOLE as f32 });
            next
        })
    }

    /// Gathers light in the middles of the sides of candidates; returns which are to be divided.
    fn find_divided(&mut self, candidates: &[Candidate]) -> Result<Vec<ToDivide>, Cancelled> {
        let mut places = Vec::new();
        let mut middles = Vec::with_capacity(candidates.len());
        for candidate in candidates {
            let [a, b, c] = candidate.corners;
            middles.push([(a, b), (b, c), (c, a)].map(|(a, b)| self.point(candidate, (a + b) / 2, &mut places)));
        }
        self.gather(places)?;
        let arriving = &self.shares.arriving;
        let divided = candidates.iter().zip(middles).filter_map(|(candidate, middles)| {
            let corners = self.shares.nodes[candidate.node as usize].corners;
            let bend = (0..3).map(|side| {
                let ends = [corners[side], corners[(side + 1) % 3], middles[side]];
                self.differs.of_middle(ends.map(|index| &arriving[index as usize]))
            });
            let bend = bend.fold(0.0, f32::max);
            (bend > 1.0 || candidate.is_large).then_some((*candidate, middles, bend))
        });
        Ok(divided.collect())
    }

    /// The corners of nodes as their parts have them: what arrives nearer to these than is right for the whole.
    fn corners_of_parts(&mut self, divided: &[ToDivide]) -> Result<Vec<[u32; 3]>, Cancelled> {
        let mut places = Vec::new();
        let mut corners = Vec::with_capacity(divided.len());
        for (node, ..) in divided {
            let whole = self.shares.nodes[node.node as usize].corners;
            let mut of_parts = whole;
            for ((of_parts, whole), at) in of_parts.iter_mut().zip(whole).zip(node.corners) {
                // All triangles at a vertex have the same.
                let is_vertex = at == UVec2::ZERO || at.max_element() == WHOLE;
                if !is_vertex {
                    *of_parts = self.point(node, at, &mut places);
                } else if node.node == node.triangle {
                    let known = &mut self.near_corners[whole as usize];
                    if *known == u32::MAX {
                        *known = (self.shares.arriving.len() + places.len()) as u32;
                        places.push(Place::Corner(whole));
                    }
                    *of_parts = *known;
                }
            }
            corners.push(of_parts);
        }
        self.gather(places)?;
        Ok(corners)
    }

    /// Divides a node by the middles of its sides.
    fn divide(
        &mut self,
        parent: &Candidate,
        [a, b, c]: [u32; 3],
        [ab, bc, ca]: [u32; 3],
        bend: f32,
        candidates: &mut Vec<Candidate>,
    ) {
        let first = self.shares.nodes.len() as u32;
        self.shares.nodes[parent.node as usize].parts = first;
        let parts = [[a, ab, ca], [ab, b, bc], [ca, bc, c], [bc, ca, ab]];
        self.shares.nodes.extend(parts.map(|corners| Node { corners, parts: 0 }));
        let [a, b, c] = parent.corners;
        let [ab, bc, ca] = [(a, b), (b, c), (c, a)].map(|(one, other)| (one + other) / 2);
        for (part, corners) in [[a, ab, ca], [ab, b, bc], [ca, bc, c], [bc, ca, ab]].into_iter().enumerate() {
            candidates.extend(self.candidate(first + part as u32, parent.triangle, corners, BEND * bend));
        }
    }
}

/// Differences of what arrives, in tolerances.
struct Difference {
    /// Light that is always there.
    steady: f32,
}

impl Difference {
    fn new(corners: &[Arriving], sky_irradiance: f32) -> Self {
        let brightest = corners.iter().flat_map(|corner| corner.by_surfaces).map(Vec3::element_sum).fold(0.0, f32::max);
        Self { steady: FAINT * (brightest + sky_irradiance) }
    }

    /// Between the middle of a side and the mean of its two ends.
    fn of_middle(&self, [one, other, middle]: [&Arriving; 3]) -> f32 {
        let none = Arriving { sky: [Vec3::ZERO; 2], by_surfaces: [Vec3::ZERO; 2] };
        self.between(&none.plus(one, 0.5).plus(other, 0.5), middle)
    }

    /// Between the ends of sides, the largest.
    fn of_ends(&self, [a, b, c]: [&Arriving; 3]) -> f32 {
        self.between(a, b).max(self.between(b, c)).max(self.between(c, a))
    }

    fn between(&self, one: &Arriving, other: &Arriving) -> f32 {
        let on_side = |side: usize| {
            let emitted = [one, other].map(|arriving| arriving.by_surfaces[side].element_sum());
            let all = emitted[0].max(emitted[1]) + self.steady;
            let of_emitters = if all > 0.0 { (emitted[0] - emitted[1]).abs() / all } else { 0.0 };
            of_emitters.max((one.sky[side] - other.sky[side]).abs().max_element())
        };
        on_side(0).max(on_side(1)) / TOLERANCE
    }
}

/// Objects near triangles, for how finely these are to be divided.
struct Neighbours {
    scene_size: f32,
    /// The sizes of objects, small ones first, with their numbers; none where there are too many to ask for.
    sizes: Vec<(f32, u32)>,
}

impl Neighbours {
    fn new(scene: &Scene) -> Self {
        let mut sizes: Vec<(f32, u32)> =
            (0..).zip(&scene.objects).map(|(index, object)| (object.bounds.diagonal(), index)).collect();
        sizes.sort_by(|one, other| one.0.total_cmp(&other.0));
        if sizes.len() * scene.triangles.len() > MOST_PAIRS {
            sizes.clear();
        }
        Self { scene_size: scene.bounds.diagonal(), sizes }
    }

    /// The longest side of a part of a triangle, its area, and the lengths beyond and below which it is always and
    /// never divided.
    fn limits(&self, scene: &Scene, triangle: u32, corners: [UVec2; 3]) -> (f32, f32, [f32; 2]) {
        let whole = scene.triangles[triangle as usize].map(|vertex| scene.positions[vertex as usize]);
        let [a, b, c] = corners.map(|at| {
            let at = at.as_vec2() / WHOLE as f32;
            whole[0] + (whole[1] - whole[0]) * at.x + (whole[2] - whole[0]) * at.y
        });
        let length = a.distance(b).max(b.distance(c)).max(c.distance(a));
        let own = scene.triangle_objects[triangle as usize];
        let size = scene.objects[own as usize].bounds.diagonal();
        let mut limits = [self.scene_size * LONGEST, size.min(self.scene_size) * SHORTEST];
        let (low, high) = (a.min(b).min(c) - length, a.max(b).max(c) + length);
        // Larger objects do not ask for smaller parts than these.
        for (size, index) in self.sizes.iter().take_while(|(size, _)| size * SHORTEST_BESIDE < length) {
            let bounds = &scene.objects[*index as usize].bounds;
            if *index != own && bounds.min.cmple(high).all() && bounds.max.cmpge(low).all() {
                limits = [limits[0].min(size * LONGEST_BESIDE), limits[1].min(size * SHORTEST_BESIDE)];
            }
        }
        (length, 0.5 * (b - a).cross(c - a).length(), limits)
    }
}
