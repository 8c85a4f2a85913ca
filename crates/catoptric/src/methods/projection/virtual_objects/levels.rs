//! One level a bounce: the rays that leave a reflector after a path's bounces so far, and what finds points by them.

use super::eye_image::EyeImage;
use super::mesh::ReflectorMesh;
use super::piece::{interpolated, weights_of};
use super::rays::{Arrival, Foot, VertexRays};
use crate::methods::projection::SpecularPath;
use crate::optics::bundle::{Bounce, BounceKind};
use crate::parallel;
use crate::scene::{Projection, Role, Scene, View};
use glam::{Mat3, Vec2, Vec3};
use std::collections::{BTreeMap, HashMap, HashSet};
use std::sync::Arc;

/// No more paths than this are built: short ones first.
const MOST_PATHS: usize = 256;

/// Meshes are refined so many times where ways meet, unless they get more triangles than this.
const MOST_REFINEMENTS: u32 = 4;
const MOST_TRIANGLES: usize = 300_000;

/// Rays are led on over so many rings of triangles.
const LED_ON: u32 = 2;

/// Vertices that are looked up at once.
const VERTICES_AT_ONCE: usize = 1024;

/// A reflector with rays at its vertices.
#[derive(Clone, Copy)]
pub(in super::super) struct Reflector<'a> {
    /// Which of the scene's specular objects it is; none where the mesh is a finer one made for its rays.
    pub(in super::super) index: Option<u32>,
    pub(in super::super) mesh: &'a ReflectorMesh,
    pub(in super::super) rays: &'a VertexRays,
    /// The view, where the rays come straight from the eye.
    pub(in super::super) view: Option<&'a View>,
}

/// Finds where points appear in a reflector.
pub(in super::super) trait Locator: Send + Sync {
    /// Calls `take` for all places, about, where a point appears.
    fn locate(&self, reflector: &Reflector<'_>, point: Vec3, take: &mut dyn FnMut(&Foot));

    /// Bytes held.
    fn byte_count(&self) -> u64;
}

/// Rays of one kind at a level.
pub(in super::super) struct Family<L> {
    pub(in super::super) rays: VertexRays,
    pub(in super::super) locator: L,
    /// The family of the level before that they come from, and by which way.
    parent: Option<(u32, Way)>,
}

/// How a ray leaves a reflector: rays that are neighbours where they arrive were neighbours there.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
struct Way {
    /// The smooth piece of the reflector.
    piece: u8,
    /// Focal points passed on the way.
    focal_index: u32,
}

impl Way {
    /// From a foot over a distance.
    fn from(reflector: &Reflector<'_>, foot: &Foot, distance: f32) -> Self {
        let focal_index = reflector.rays.focal_index(reflector.mesh, foot.triangle, distance);
        Self { piece: reflector.mesh.pieces[foot.triangle as usize], focal_index }
    }
}

/// A ray that arrives at a vertex.
struct Arriving {
    vertex: u32,
    way: Way,
    beyond: bool,
    arrival: Arrival,
}

/// All that ends with a path's last bounce.
pub(in super::super) struct Level<L> {
    /// The path without its last bounce, a level.
    parent: Option<u32>,
    pub(in super::super) bounce: Bounce,
    /// Index of the reflector.
    pub(in super::super) mesh: u32,
    /// A finer mesh of it, where rays of several ways meet.
    finer: Option<Arc<ReflectorMesh>>,
    pub(in super::super) families: Vec<Family<L>>,
}

/// All paths of a view up to an order.
pub(in super::super) struct Levels<L> {
    pub(in super::super) paths: Vec<SpecularPath>,
    /// One for each path.
    pub(in super::super) levels: Vec<Level<L>>,
    view: View,
    /// What of each reflector is seen first; none where it hides nothing of itself.
    images: Vec<Option<EyeImage>>,
    /// Whether there were more paths than are built.
    pub(in super::super) cut_short: bool,
}

/// What of a bounce is an object for the bounce before.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(in super::super) enum Recursion {
    /// The virtual point in the tangent plane at the foot (Ofek, Rappoport 1998).
    VirtualPoints,
    /// The foot itself, made to obey the law of the bounce: it appears where the virtual point would.
    Feet,
}

/// One place on a path where a point appears.
#[derive(Clone, Copy)]
pub(in super::super) struct Step {
    pub(in super::super) foot: Foot,
    pub(in super::super) outside: bool,
    /// The index of refraction of what the ray goes on in.
    pub(in super::super) index_after: f32,
    pub(in super::super) bounce: Bounce,
    pub(in super::super) mesh: u32,
    /// Index of the level.
    pub(super) level: u32,
}

/// An appearance: a point in the direction in which the eye sees it, and how it was found.
pub(in super::super) struct Appearance<'a> {
    /// The virtual point after all bounces, or the first bounce.
    pub(in super::super) seen: Vec3,
    /// Its change with the scene point.
    pub(in super::super) change: Mat3,
    /// Optical length of the path from the first bounce to the scene point.
    pub(in super::super) length: f32,
    /// Focal points passed, summed over the path.
    pub(in super::super) focal_index: u32,
    /// The bounces from the last one back to the eye.
    pub(in super::super) steps: &'a [Step],
}

/// The way from a scene point back to the eye.
#[derive(Clone, Copy)]
struct Descent<'a> {
    steps: &'a [Step],
    /// The family that the next bounce must belong to, and the way from there.
    wanted: Option<(u32, Way)>,
    point: Vec3,
    change: Mat3,
    /// Optical, from the last foot to the scene point; how much of the way to `point` lies behind that foot.
    length: f32,
    behind: f32,
    focal_index: u32,
}

impl<L> Level<L> {
    fn reflector_mesh<'a>(&'a self, meshes: &'a [ReflectorMesh]) -> &'a ReflectorMesh {
        self.finer.as_deref().unwrap_or(&meshes[self.mesh as usize])
    }
}

/// Rays that arrive at all vertices of a reflector.
struct Arrivals {
    /// The family of the level before that they come from, and by which way; none from the eye.
    from: Option<(u32, Way)>,
    /// Whether they run within the body.
    inside: bool,
    rays: Vec<Arrival>,
}

impl Arrivals {
    fn from_eye(rays: Vec<Arrival>) -> Self {
        Self { from: None, inside: false, rays }
    }
}

impl<L: Locator> Levels<L> {
    /// Builds all levels; `make` is asked once for each family and says none where nothing can appear by it.
    pub(in super::super) fn build(
        scene: &Scene,
        meshes: &[ReflectorMesh],
        view: &View,
        order: u32,
        image_size: u32,
        make: impl Fn(&Reflector<'_>) -> Option<L>,
    ) -> Self {
        let drawn = |mesh: &ReflectorMesh| (!mesh.convex).then(|| EyeImage::draw(mesh, view, image_size)).flatten();
        let images = parallel::map_collect(meshes.len(), |index| drawn(&meshes[index]));
        let mut all = Self { paths: Vec::new(), levels: Vec::new(), view: view.clone(), images, cut_short: false };
        let mut parents = 0..0;
        for length in 1..=order {
            let first = all.levels.len();
            if length == 1 {
                for (index, mesh) in meshes.iter().enumerate() {
                    if is_in_picture(mesh, view) {
                        all.grow(scene, meshes, None, index as u32, &make);
                    }
                }
            } else {
                for parent in parents {
                    for index in 0..meshes.len() as u32 {
                        all.grow(scene, meshes, Some(parent as u32), index, &make);
                    }
                }
            }
            parents = first..all.levels.len();
        }
        all
    }

    /// Adds the levels of one more bounce on a reflector.
    fn grow(
        &mut self,
        scene: &Scene,
        meshes: &[ReflectorMesh],
        parent: Option<u32>,
        index: u32,
        make: &impl Fn(&Reflector<'_>) -> Option<L>,
    ) {
        if !meshes[index as usize].has_shape() {
            return;
        }
        let mut finer: Option<Arc<ReflectorMesh>> = None;
        let mut arrivals = match parent {
            None => vec![Arrivals::from_eye(eye_rays(&meshes[index as usize], &self.view))],
            Some(parent) => self.level_rays(meshes, parent, index, &meshes[index as usize]),
        };
        if let Some(parent) = parent {
            for _ in 0..MOST_REFINEMENTS {
                let mesh = finer.as_deref().unwrap_or(&meshes[index as usize]);
                let edges = edges_between_ways(mesh, &arrivals);
                if edges.is_empty() || mesh.triangles.len() + 3 * edges.len() > MOST_TRIANGLES {
                    break;
                }
                let mesh = Arc::new(mesh.with_halved(&edges));
                arrivals = self.level_rays(meshes, parent, index, &mesh);
                finer = Some(mesh);
            }
        }
        let mesh = finer.as_deref().unwrap_or(&meshes[index as usize]);
        for arrivals in &mut arrivals {
            lead_on(mesh, &mut arrivals.rays);
        }
        let material = scene.material_of(mesh.object);
        let lens = material.role == Role::Lens;
        let kinds: &[BounceKind] =
            if lens { &[BounceKind::Reflect, BounceKind::Transmit] } else { &[BounceKind::Reflect] };
        for &kind in kinds {
            let mut families = Vec::new();
            for Arrivals { from, inside, rays: arriving } in &arrivals {
                for side in [1.0, -1.0] {
                    // Within a body its inner side is met, from without the outer one; open sheets have both.
                    let possible = match (mesh.inside_only, mesh.closed, *inside) {
                        (true, ..) => side < 0.0,
                        (_, true, false) => side > 0.0,
                        (_, true, true) => side < 0.0,
                        (_, false, inside) => !lens || (side < 0.0) == inside,
                    };
                    if !possible {
                        continue;
                    }
                    let transmits = kind == BounceKind::Transmit;
                    let within = (*inside != transmits).then_some(material.ior);
                    let eta = match (transmits, side > 0.0) {
                        (false, _) => 1.0,
                        (true, true) => 1.0 / material.ior,
                        (true, false) => material.ior,
                    };
                    let rays = VertexRays::new(mesh, kind, side, eta, within, arriving);
                    if !mesh.triangles.iter().any(|triangle| rays.shows(*triangle)) {
                        continue;
                    }
                    let view = parent.is_none().then_some(&self.view);
                    if let Some(locator) =
                        make(&Reflector { index: finer.is_none().then_some(index), mesh, rays: &rays, view })
                    {
                        families.push(Family { rays, locator, parent: *from });
                    }
                }
            }
            if families.is_empty() {
                continue;
            }
            if self.levels.len() >= MOST_PATHS {
                self.cut_short = true;
                return;
            }
            let bounce = Bounce { object: mesh.object, kind };
            let mut path = parent.map(|parent| self.paths[parent as usize].clone()).unwrap_or_default();
            path.bounces.push(bounce);
            self.paths.push(path);
            self.levels.push(Level { parent, bounce, mesh: index, finer: finer.clone(), families });
        }
    }

    /// The rays that arrive at a reflector's vertices after a level, by family and way.
    fn level_rays(&self, meshes: &[ReflectorMesh], parent: u32, index: u32, mesh: &ReflectorMesh) -> Vec<Arrivals> {
        let level = &self.levels[parent as usize];
        let mut all = Vec::new();
        for (number, family) in level.families.iter().enumerate() {
            let inside = family.rays.inside_after;
            let own = level.mesh == index;
            // Rays within a body stay there, and those that leave a convex one do not come back.
            let possible = if inside { own } else { !(own && mesh.convex && family.rays.side > 0.0) };
            let leaves = own && !inside && level.bounce.kind == BounceKind::Transmit && mesh.convex;
            if !possible || leaves {
                continue;
            }
            let reflector = self.reflector(meshes, level, family);
            let chunks = mesh.positions.len().div_ceil(VERTICES_AT_ONCE);
            let least = if own { 1e-4 * mesh.radius } else { 0.0 };
            let found = parallel::map_collect(chunks, |chunk| {
                let range = chunk * VERTICES_AT_ONCE..((chunk + 1) * VERTICES_AT_ONCE).min(mesh.positions.len());
                let mut arriving = Vec::new();
                for vertex in range {
                    let position = mesh.positions[vertex];
                    let first = arriving.len();
                    family.locator.locate(&reflector, position, &mut |foot| {
                        let length = foot.position.distance(position);
                        let Some(direction) = (position - foot.position).try_normalize() else { return };
                        if length <= least {
                            return;
                        }
                        let found = Arriving {
                            vertex: vertex as u32,
                            way: Way::from(&reflector, foot, length),
                            beyond: foot.beyond,
                            arrival: Arrival { origin: foot.position, direction },
                        };
                        // What is seen in the reflector is better than what is seen beside it.
                        match arriving[first..].iter_mut().find(|known: &&mut Arriving| known.way == found.way) {
                            Some(known) if known.beyond && !found.beyond => *known = found,
                            Some(_) => {}
                            None => arriving.push(found),
                        }
                    });
                }
                arriving
            });
            let mut ways: BTreeMap<Way, Vec<Arrival>> = BTreeMap::new();
            let starting = if own && inside { starting_rays(&reflector, mesh) } else { Vec::new() };
            for found in starting.iter().chain(found.iter().flatten()) {
                let arriving = ways.entry(found.way).or_insert_with(|| vec![Arrival::NONE; mesh.positions.len()]);
                arriving[found.vertex as usize] = found.arrival;
            }
            all.extend(ways.into_iter().map(|(way, rays)| Arrivals { from: Some((number as u32, way)), inside, rays }));
        }
        all
    }

    fn reflector<'a>(
        &'a self,
        meshes: &'a [ReflectorMesh],
        level: &'a Level<L>,
        family: &'a Family<L>,
    ) -> Reflector<'a> {
        let view = level.parent.is_none().then_some(&self.view);
        let index = level.finer.is_none().then_some(level.mesh);
        Reflector { index, mesh: level.reflector_mesh(meshes), rays: &family.rays, view }
    }

    /// The mesh that a step's foot is on.
    pub(super) fn mesh_of<'a>(&'a self, meshes: &'a [ReflectorMesh], step: &Step) -> &'a ReflectorMesh {
        self.levels[step.level as usize].reflector_mesh(meshes)
    }

    /// Calls `take` for all appearances of a point on a path.
    pub(in super::super) fn appearances(
        &self,
        meshes: &[ReflectorMesh],
        path: u32,
        point: Vec3,
        recursion: Recursion,
        take: &mut dyn FnMut(&Appearance<'_>),
    ) {
        let start = Descent {
            steps: &[],
            wanted: None,
            point,
            change: Mat3::IDENTITY,
            length: 0.0,
            behind: 0.0,
            focal_index: 0,
        };
        self.descend(meshes, path, &start, recursion, take);
    }

    fn descend(
        &self,
        meshes: &[ReflectorMesh],
        index: u32,
        from: &Descent<'_>,
        recursion: Recursion,
        take: &mut dyn FnMut(&Appearance<'_>),
    ) {
        let Some(level) = self.levels.get(index as usize) else { return };
        for (number, family) in level.families.iter().enumerate() {
            if from.wanted.is_some_and(|(wanted, _)| wanted != number as u32) {
                continue;
            }
            let reflector = self.reflector(meshes, level, family);
            // Rays within a body end at its surface: scene points beyond are never seen by them.
            if family.rays.inside_after && from.steps.is_empty() && !reflector.mesh.may_hold(from.point) {
                continue;
            }
            family.locator.locate(&reflector, from.point, &mut |foot| {
                let distance = foot.position.distance(from.point);
                let way = Way::from(&reflector, foot, distance);
                if from.wanted.is_some_and(|(_, wanted)| wanted != way) {
                    return;
                }
                let corrected = match recursion {
                    Recursion::VirtualPoints => None,
                    Recursion::Feet => foot.corrected(reflector.mesh, &family.rays, from.point),
                };
                let foot = corrected.unwrap_or(*foot);
                let distance = foot.position.distance(from.point);
                let (point, moves, behind) = match recursion {
                    Recursion::Feet if foot.beyond => {
                        let (point, moves) = foot.beside(from.point);
                        (point, moves, 0.0)
                    }
                    Recursion::Feet if corrected.is_some() => (foot.position, foot.position_change, 0.0),
                    _ => {
                        let Some((seen, moves)) = foot.virtual_point(&family.rays, from.point) else { return };
                        (seen, moves, distance)
                    }
                };
                let (outside, index_after) = (family.rays.side > 0.0, family.rays.index_after);
                let step = Step { foot, outside, index_after, bounce: level.bounce, mesh: level.mesh, level: index };
                let mut steps = [step; crate::methods::projection::MAX_BOUNCES];
                let count = from.steps.len();
                if count >= steps.len() {
                    return;
                }
                steps[..count].copy_from_slice(from.steps);
                let next = Descent {
                    steps: &steps[..=count],
                    wanted: family.parent,
                    point,
                    change: moves * from.change,
                    length: from.length + (distance - from.behind) * index_after,
                    behind,
                    focal_index: from.focal_index + way.focal_index,
                };
                match level.parent {
                    Some(parent) => self.descend(meshes, parent, &next, recursion, take),
                    None => take(&Appearance {
                        seen: point,
                        change: next.change,
                        length: next.length,
                        focal_index: next.focal_index,
                        steps: next.steps,
                    }),
                }
            });
        }
    }

    /// What of a reflector is seen first; none where it hides nothing of itself.
    pub(in super::super) fn image_of(&self, mesh: u32) -> Option<&EyeImage> {
        self.images.get(mesh as usize)?.as_ref()
    }

    /// Bytes held.
    pub(in super::super) fn byte_count(&self) -> u64 {
        let families = self.levels.iter().flat_map(|level| &level.families);
        families.map(|family| family.locator.byte_count() + 40 * family.rays.origins.len() as u64).sum()
    }
}

/// The edges, by their vertices in order, of triangles at which rays within a body arrive by one way at some corners only.
/// There the ways meet at a caustic on the surface, next to which rays move with the root of the distance from it: the ring of
/// triangles between them is as wide in the picture as the root of their size.
fn edges_between_ways(mesh: &ReflectorMesh, arrivals: &[Arrivals]) -> HashSet<[u32; 2]> {
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

/// Leads rays on to vertices without any that lie across an edge from a triangle with rays.
///
/// Rays of one way end where those of another begin, at caustics on the surface and at creases, mostly amid triangles:
/// without this a ring of triangles would be missing there. That a point appears by such a ray is told by the reflector before.
fn lead_on(mesh: &ReflectorMesh, arriving: &mut [Arrival]) {
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
                arriving[vertex as usize] = Arrival { origin, direction };
            }
        }
    }
}

/// The rays that start within a body at vertices of its far side: where that meets the near side at a crease, as along the
/// rim of a lens, the way between them has no length, but a direction.
fn starting_rays(near: &Reflector<'_>, far: &ReflectorMesh) -> Vec<Arriving> {
    let mut starts: HashMap<[u32; 3], (Way, Vec3)> = HashMap::new();
    let place = |mesh: &ReflectorMesh, vertex: u32| mesh.positions[vertex as usize].to_array().map(f32::to_bits);
    let (mesh, rays) = (near.mesh, near.rays);
    for (triangle, piece) in mesh.triangles.iter().zip(&mesh.pieces).filter(|(triangle, _)| rays.shows(**triangle)) {
        for vertex in triangle.iter().filter(|vertex| rays.cosines[**vertex as usize] > 0.0) {
            let way = Way { piece: *piece, focal_index: 0 };
            starts.entry(place(mesh, *vertex)).or_insert((way, rays.outgoing[*vertex as usize]));
        }
    }
    let starting = |vertex: u32| {
        let &(way, direction) = starts.get(&place(far, vertex))?;
        let faces = direction.dot(far.normals[vertex as usize]) > 0.0;
        let arrival = Arrival { origin: far.positions[vertex as usize], direction };
        faces.then_some(Arriving { vertex, way, beyond: true, arrival })
    };
    (0..far.positions.len() as u32).filter_map(starting).collect()
}

/// The rays that arrive at a reflector's vertices from the eye.
fn eye_rays(mesh: &ReflectorMesh, view: &View) -> Vec<Arrival> {
    let eye = view.eye();
    let parallel = match view.projection {
        Projection::Perspective { .. } => None,
        Projection::Orthographic { .. } => Some(view.ray(0.0, 0.0).direction),
    };
    let arriving = |position: &Vec3| match parallel {
        None => match (*position - eye).try_normalize() {
            Some(direction) => Arrival { origin: eye, direction },
            None => Arrival::NONE,
        },
        // From the eye's plane.
        Some(direction) => Arrival { origin: *position - direction * (*position - eye).dot(direction), direction },
    };
    mesh.positions.iter().map(arriving).collect()
}

impl VertexRays {
    /// The reflections of view rays on the outer side of a reflector.
    pub(in super::super) fn of_view(mesh: &ReflectorMesh, view: &View) -> Self {
        let side = if mesh.inside_only { -1.0 } else { 1.0 };
        Self::new(mesh, BounceKind::Reflect, side, 1.0, None, &eye_rays(mesh, view))
    }
}

/// Whether any of a reflector may appear in the picture.
fn is_in_picture(mesh: &ReflectorMesh, view: &View) -> bool {
    let transform = view.picture_from_world();
    let (size_px, mut beside) = (Vec2::new(view.width as f32, view.height as f32), [true; 5]);
    for position in &mesh.positions {
        let point = transform.apply(*position);
        let sides = [
            point.depth < view.near,
            point.xy.x < 0.0,
            point.xy.y < 0.0,
            point.xy.x > size_px.x * point.w,
            point.xy.y > size_px.y * point.w,
        ];
        for (beside, side) in beside.iter_mut().zip(sides) {
            *beside &= side;
        }
    }
    !beside.contains(&true)
}
