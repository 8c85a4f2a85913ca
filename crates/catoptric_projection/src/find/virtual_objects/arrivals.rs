//! The rays that arrive at a reflector's vertices: from the eye, and from the reflector before.

use super::super::work;
use super::locator::{Locator, Reflector};
use super::mesh::ReflectorMesh;
use super::piece::{interpolated, weights_of};
use super::rays::{ArrivingRay, ReflectionPoint, ReflectionPoints, VertexRays};
use catoptric_core::parallel;
use catoptric_core::progress::{Cancelled, Stage};
use catoptric_core::scene::{Projection, View};
use catoptric_engine::optics::path::bundle::BounceKind;
use glam::Vec3;
use std::collections::{BTreeMap, HashMap, HashSet};

/// Rays are extrapolated over this many rings of triangles. Chosen, not measured.
const LED_ON: u32 = 2;

/// The interval of the vertices that are looked up to estimate the work of all of them. Chosen, not measured.
const PROBED: usize = 128;

/// Vertices that are looked up at once. A size for threads; chosen, not measured.
const VERTICES_AT_ONCE: usize = 1024;

/// Branch by which a ray leaves a reflector: rays that are neighbours where they arrive were neighbours there.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub(super) struct PathBranch {
    /// The smooth piece of the reflector.
    piece: u8,
    /// Focal points passed on the way.
    pub(super) focal_index: u32,
}

impl PathBranch {
    /// The branch from a reflection point over a distance.
    pub(super) fn from(reflector: &Reflector<'_>, reflection_point: &ReflectionPoint, distance: f32) -> Self {
        let focal_index = reflector.rays.focal_index(reflector.mesh, reflection_point.triangle, distance);
        Self { piece: reflector.mesh.pieces[reflection_point.triangle as usize], focal_index }
    }
}

/// A ray that arrives at a vertex.
pub(super) struct Arriving {
    vertex: u32,
    branch: PathBranch,
    beyond: bool,
    arrival: ArrivingRay,
}

/// Rays that arrive at all vertices of a reflector.
pub(super) struct Arrivals {
    /// The ray set of the level before that they come from, and by which branch; `None` from the eye.
    pub(super) from: Option<(u32, PathBranch)>,
    /// True if they run within the body.
    pub(super) inside: bool,
    pub(super) rays: Vec<ArrivingRay>,
}

impl Arrivals {
    pub(super) fn from_eye(rays: Vec<ArrivingRay>) -> Self {
        Self { from: None, inside: false, rays }
    }
}

/// Rays by branch.
pub(super) type BranchRays = BTreeMap<PathBranch, Vec<ArrivingRay>>;

/// Limits of a search for rays.
#[derive(Clone, Copy, Debug)]
pub(super) struct ArrivalLimits {
    /// Rays that are shorter do not count.
    pub(super) least: f32,
    /// Work that it may take.
    pub(super) work: u64,
}

/// The rays that arrive at a reflector's vertices from another (or the same), by branch, and the work of finding them;
/// `starting` are known. Returns `None` if it would take more work than the limit, by that of a few vertices.
pub(super) fn arriving_rays(
    reflector: &Reflector<'_>,
    locator: &impl Locator,
    mesh: &ReflectorMesh,
    limits: ArrivalLimits,
    starting: Vec<Arriving>,
    stage: &Stage<'_>,
) -> Result<Option<(BranchRays, u64)>, Cancelled> {
    let probes: Vec<Vec3> = mesh.positions.iter().step_by(PROBED).copied().collect();
    let before = work::done();
    locator.locate(reflector, &probes, &mut ReflectionPoints::default());
    let probed = work::since(before);
    let expected = probed * (mesh.positions.len() / probes.len().max(1)) as u64;
    if expected > limits.work {
        return Ok(None);
    }
    let chunks = mesh.positions.len().div_ceil(VERTICES_AT_ONCE);
    let found = parallel::map_within(stage, chunks, |chunk| {
        let range = chunk * VERTICES_AT_ONCE..((chunk + 1) * VERTICES_AT_ONCE).min(mesh.positions.len());
        let mut arriving = Vec::new();
        let mut located = ReflectionPoints::default();
        locator.locate(reflector, &mesh.positions[range.clone()], &mut located);
        for (number, vertex) in range.enumerate() {
            let position = mesh.positions[vertex];
            let first = arriving.len();
            for reflection_point in located.of(number) {
                let length = reflection_point.position.distance(position);
                let Some(direction) = (position - reflection_point.position).try_normalize() else { continue };
                if length <= limits.least {
                    continue;
                }
                let found = Arriving {
                    vertex: vertex as u32,
                    branch: PathBranch::from(reflector, reflection_point, length),
                    beyond: reflection_point.beyond,
                    arrival: ArrivingRay { origin: reflection_point.position, direction },
                };
                // Rays from within the reflector are better than those from beside it.
                match arriving[first..].iter_mut().find(|known: &&mut Arriving| known.branch == found.branch) {
                    Some(known) if known.beyond && !found.beyond => *known = found,
                    Some(_) => {}
                    None => arriving.push(found),
                }
            }
        }
        arriving
    })?;
    let mut branches = BranchRays::new();
    for found in starting.iter().chain(found.iter().flatten()) {
        let arriving = branches.entry(found.branch).or_insert_with(|| vec![ArrivingRay::NONE; mesh.positions.len()]);
        arriving[found.vertex as usize] = found.arrival;
    }
    Ok(Some((branches, expected + probed)))
}

/// The edges, by their vertices in order, of triangles at which rays within a body arrive by one branch at some corners
/// only. There the branches meet at a caustic on the surface, next to which rays move with the root of the distance
/// from it: the ring of triangles between them is as wide in the picture as the root of their size.
pub(super) fn edges_between_branches(mesh: &ReflectorMesh, arrivals: &[Arrivals]) -> HashSet<[u32; 2]> {
    let mut edges = HashSet::new();
    for Arrivals { rays, .. } in arrivals.iter().filter(|arrivals| arrivals.inside) {
        for triangle in &mesh.triangles {
            let known = triangle.iter().filter(|vertex| rays[**vertex as usize].origin.is_finite()).count();
            if known == 1 || known == 2 {
                let [a, b, c] = *triangle;
                edges.extend([[a, b], [b, c], [c, a]].map(|[p, q]| [p.min(q), p.max(q)]));
            }
        }
    }
    edges
}

/// Extrapolates rays to vertices without any that lie across an edge from a triangle with rays.
///
/// Rays of one branch end where those of another begin, at caustics on the surface and at creases, mostly amid
/// triangles: without this a ring of triangles would be missing there. The reflector before decides whether a point
/// appears by such a ray.
pub(super) fn extrapolate_rays(mesh: &ReflectorMesh, arriving: &mut [ArrivingRay]) {
    let mut sums: HashMap<u32, (Vec3, f32)> = HashMap::new();
    for _ in 0..LED_ON {
        let origins: Vec<Vec3> = arriving.iter().map(|arrival| arrival.origin).collect();
        let is_known = |vertex: &u32| origins[*vertex as usize].is_finite();
        for (triangle, neighbours) in mesh.triangles.iter().zip(&mesh.neighbours) {
            let Some(corner) = (0..3).find(|corner| !is_known(&triangle[*corner])) else { continue };
            let Some(beside) = mesh.triangles.get(neighbours[corner] as usize) else { continue };
            if !beside.iter().all(is_known) {
                continue;
            }
            let corners = beside.map(|vertex| mesh.positions[vertex as usize]);
            let place = mesh.positions[triangle[corner] as usize];
            let (sum, count) = sums.entry(triangle[corner]).or_default();
            *sum += interpolated(&origins, *beside, weights_of(corners, place));
            *count += 1.0;
        }
        for (vertex, (sum, count)) in sums.drain() {
            let origin = sum / count;
            if let Some(direction) = (mesh.positions[vertex as usize] - origin).try_normalize() {
                arriving[vertex as usize] = ArrivingRay { origin, direction };
            }
        }
    }
}

/// The rays that start within a body at vertices of its far side: where that meets the near side at a crease, as along
/// the rim of a lens, the way between them has no length, but a direction.
pub(super) fn starting_rays(near: &Reflector<'_>, far: &ReflectorMesh) -> Vec<Arriving> {
    let mut starts: HashMap<[u32; 3], (PathBranch, Vec3)> = HashMap::new();
    let place = |mesh: &ReflectorMesh, vertex: u32| mesh.positions[vertex as usize].to_array().map(f32::to_bits);
    let (mesh, rays) = (near.mesh, near.rays);
    for (triangle, piece) in mesh.triangles.iter().zip(&mesh.pieces).filter(|(triangle, _)| rays.shows(**triangle)) {
        for vertex in triangle.iter().filter(|vertex| rays.cosines[**vertex as usize] > 0.0) {
            let branch = PathBranch { piece: *piece, focal_index: 0 };
            starts.entry(place(mesh, *vertex)).or_insert((branch, rays.outgoing[*vertex as usize]));
        }
    }
    let starting = |vertex: u32| {
        let &(branch, direction) = starts.get(&place(far, vertex))?;
        let faces = direction.dot(far.normals[vertex as usize]) > 0.0;
        let arrival = ArrivingRay { origin: far.positions[vertex as usize], direction };
        faces.then_some(Arriving { vertex, branch, beyond: true, arrival })
    };
    (0..far.positions.len() as u32).filter_map(starting).collect()
}

/// The rays that arrive at a reflector's vertices from the eye.
pub(super) fn eye_rays(mesh: &ReflectorMesh, view: &View) -> Vec<ArrivingRay> {
    let eye = view.eye();
    let parallel = match view.projection {
        Projection::Perspective { .. } => None,
        Projection::Orthographic { .. } => Some(view.ray(0.0, 0.0).direction),
    };
    let arriving = |position: &Vec3| match parallel {
        None => match (*position - eye).try_normalize() {
            Some(direction) => ArrivingRay { origin: eye, direction },
            None => ArrivingRay::NONE,
        },
        // Parallel rays start in the eye's plane.
        Some(direction) => ArrivingRay { origin: *position - direction * (*position - eye).dot(direction), direction },
    };
    mesh.positions.iter().map(arriving).collect()
}

impl VertexRays {
    /// The reflections of view rays on the outer side of a reflector.
    pub(crate) fn of_view(mesh: &ReflectorMesh, view: &View) -> Self {
        let side = if mesh.inside_only { -1.0 } else { 1.0 };
        Self::new(mesh, BounceKind::Reflect, side, 1.0, None, &eye_rays(mesh, view))
    }
}
