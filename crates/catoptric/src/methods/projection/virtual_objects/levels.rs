//! One level a bounce: the rays that leave a reflector after a path's bounces so far, and what finds points by them.

use super::arrivals::{Arrivals, Way, arriving_rays, edges_between_ways, eye_rays, lead_on, starting_rays};
use super::eye_image::EyeImage;
use super::mesh::ReflectorMesh;
use super::rays::{Foot, VertexRays};
use crate::methods::projection::SpecularPath;
use crate::optics::bundle::{Bounce, BounceKind};
use crate::parallel;
use crate::scene::{Role, Scene, View};
use glam::{Mat3, Vec2, Vec3};
use std::sync::Arc;

/// No more paths than this are built: short ones first.
const MOST_PATHS: usize = 256;

/// Meshes are refined so many times where ways meet, unless they get more triangles than this.
const MOST_REFINEMENTS: u32 = 4;
const MOST_TRIANGLES: usize = 300_000;

/// Rays do not come back to their own reflector within this share of its radius.
const LEAST_WAY: f32 = 1e-4;

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
    /// How far `seen` may be off because reflectors are made of triangles, in scene units.
    pub(in super::super) error: f32,
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
    /// How far `point` may be off because reflectors are made of triangles.
    error: f32,
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
            let starting = if own && inside { starting_rays(&reflector, mesh) } else { Vec::new() };
            let least = if own { LEAST_WAY * mesh.radius } else { 0.0 };
            for (way, rays) in arriving_rays(&reflector, &family.locator, mesh, least, starting) {
                all.push(Arrivals { from: Some((number as u32, way)), inside, rays });
            }
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
            error: 0.0,
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
                let foot = match recursion {
                    Recursion::VirtualPoints => *foot,
                    Recursion::Feet => match foot.corrected(reflector.mesh, &family.rays, from.point) {
                        Some(corrected) => corrected,
                        // What is not seen goes on beside the silhouette.
                        None if foot.beyond => *foot,
                        // The ray of the place that was found leads past the point, far from it: it is none.
                        None => return,
                    },
                };
                let distance = foot.position.distance(from.point);
                let (point, moves, behind) = match recursion {
                    Recursion::Feet if foot.beyond => {
                        let (point, moves) = foot.beside(from.point);
                        (point, moves, 0.0)
                    }
                    Recursion::Feet => (foot.position, foot.position_change, 0.0),
                    Recursion::VirtualPoints => {
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
                let missed = distance * family.rays.bend(reflector.mesh.normal_errors[foot.triangle as usize]);
                let next = Descent {
                    steps: &steps[..=count],
                    wanted: family.parent,
                    point,
                    change: moves * from.change,
                    error: spread(&moves) * (from.error + missed),
                    length: from.length + (distance - from.behind) * index_after,
                    behind,
                    focal_index: from.focal_index + way.focal_index,
                };
                match level.parent {
                    Some(parent) => self.descend(meshes, parent, &next, recursion, take),
                    None => take(&Appearance {
                        seen: point,
                        change: next.change,
                        error: next.error,
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

/// How many times longer a small step becomes by a change, about.
fn spread(change: &Mat3) -> f32 {
    change.x_axis.length_squared().max(change.y_axis.length_squared()).max(change.z_axis.length_squared()).sqrt()
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
