//! The tree of paths, a level a bounce: the rays that leave a reflector after a path's bounces, with their locators.

use super::arrivals::{
    ArrivalLimits, Arrivals, PathBranch, arriving_rays, edges_between_branches, extrapolate_rays, eye_rays,
    starting_rays,
};
use super::eye_image::EyeImage;
use super::locator::{Locator, Reflector};
use super::mesh::ReflectorMesh;
use super::rays::VertexRays;
use catoptric_core::parallel;
use catoptric_core::progress::{Cancelled, Progress, Stage};
use catoptric_core::scene::{Role, Scene, View};
use catoptric_engine::method::projector::{MAX_BOUNCES, PathBeginnings, SpecularPath};
use catoptric_engine::optics::path::bundle::{Bounce, BounceKind};
use catoptric_engine::optics::step::relative_index;
use catoptric_engine::raster::BlockMask;
use std::sync::Arc;

/// The maximum number of paths that are built: short ones first. A bound on time; chosen, not measured.
const MAX_PATHS: usize = 256;

/// Meshes are refined this many times where branches meet, unless they get more triangles than this.
const MAX_REFINEMENTS: u32 = 4;
const MAX_TRIANGLES: usize = 300_000;

/// The maximum number of reflectors with maps of full size; more have smaller ones, with as many texels together. A
/// bound on time and memory; chosen, not measured.
const MAX_FULL_MAPS: usize = 24;

/// Smaller maps show next to nothing. Chosen, not measured.
const MIN_MAP_SIZE: u32 = 16;

/// The texels a side of the maps of so many reflectors, where one alone would have `wanted`.
pub(crate) fn map_size(wanted: u32, reflectors: usize) -> u32 {
    let share = (MAX_FULL_MAPS as f32 / reflectors.max(1) as f32).sqrt();
    if share < 1.0 { ((wanted as f32 * share) as u32).max(MIN_MAP_SIZE.min(wanted)) } else { wanted }
}

/// Rays do not come back to their own reflector within this share of its radius. Chosen, not measured.
const MIN_WAY: f32 = 1e-4;

/// The rays that arrive at a reflector, with a finer mesh of it if it needs one.
type LevelArrivals = (Option<Arc<ReflectorMesh>>, Vec<Arrivals>);

/// Rays of one kind at a level.
pub struct RaySet<L> {
    pub rays: VertexRays,
    pub locator: L,
    /// The ray set of the level before that they come from, and by which branch.
    pub(super) parent: Option<(u32, PathBranch)>,
}

/// The last bounce of a path, with its rays.
pub struct PathLevel<L> {
    /// The path without its last bounce, a level.
    pub(super) parent: Option<u32>,
    pub(crate) bounce: Bounce,
    /// Index of the reflector.
    pub mesh: u32,
    /// A finer mesh of it, where rays of several branches meet.
    finer: Option<Arc<ReflectorMesh>>,
    pub ray_sets: Vec<RaySet<L>>,
}

/// Limits of the paths of a view.
#[derive(Clone, Copy, Debug)]
pub struct PathLimits<'a> {
    /// The highest number of bounces; paths have at most [`MAX_BOUNCES`].
    pub order: u32,
    /// About the most work for building them.
    pub work: u64,
    /// Paths that are not built, as if they took too much work.
    pub without: &'a PathBeginnings,
}

/// The paths of a view up to an order.
pub struct PathTree<L> {
    /// The paths.
    pub paths: Vec<SpecularPath>,
    /// The level of each path.
    pub levels: Vec<PathLevel<L>>,
    view: View,
    /// The surface of each reflector nearest to the eye; `None` if it hides nothing of itself.
    images: Vec<Option<EyeImage>>,
    /// Paths that are not built, because there were too many or too much to do for them, without longer ones that would
    /// start with them. Where both paths of a lens are not built, it is the one that reflects.
    pub(crate) left_out: Vec<SpecularPath>,
    /// Blocks of the picture where appearances in lenses that are seen directly are wrong.
    pub(crate) wrong_in_lenses: BlockMask,
    /// Work that is left for building paths.
    remaining: u64,
    /// Paths that are not to be built.
    without: PathBeginnings,
}

impl<L> PathLevel<L> {
    /// True if some of the rays may meet a reflector: those within a body stay there, and those that leave a convex one
    /// do not come back.
    fn may_reach(&self, ray_set: &RaySet<L>, index: u32, mesh: &ReflectorMesh) -> bool {
        let (inside, own) = (ray_set.rays.inside_after, self.mesh == index);
        let possible = if inside { own } else { !(own && mesh.convex && ray_set.rays.side > 0.0) };
        let leaves = own && !inside && self.bounce.kind == BounceKind::Transmit && mesh.convex;
        possible && !leaves
    }

    /// The mesh that the rays belong to.
    pub(super) fn reflector_mesh<'a>(&'a self, meshes: &'a [ReflectorMesh]) -> &'a ReflectorMesh {
        self.finer.as_deref().unwrap_or(&meshes[self.mesh as usize])
    }
}

impl<L: Locator> PathTree<L> {
    /// Builds all levels within limits; `make` is called once for each ray set and returns `None` if nothing can appear
    /// by it.
    pub fn build(
        scene: &Scene,
        meshes: &[ReflectorMesh],
        view: &View,
        PathLimits { order, work, without }: PathLimits<'_>,
        image_size: u32,
        make: impl Fn(&Reflector<'_>) -> Option<L>,
        progress: &dyn Progress,
    ) -> Result<Self, Cancelled> {
        let drawn = |mesh: &ReflectorMesh| (!mesh.convex).then(|| EyeImage::draw(mesh, view, image_size)).flatten();
        let images = parallel::map_collect(meshes.len(), |index| drawn(&meshes[index]));
        let mut all = Self {
            paths: Vec::new(),
            levels: Vec::new(),
            view: view.clone(),
            images,
            left_out: Vec::new(),
            wrong_in_lenses: BlockMask::default(),
            remaining: work,
            without: without.clone(),
        };
        // The number of paths is not known yet.
        let stage = Stage::begin(progress, "building maps", 0)?;
        let mut parents = 0..0;
        for length in 1..=order.min(MAX_BOUNCES as u32) {
            let first = all.levels.len();
            if length == 1 {
                for (index, mesh) in meshes.iter().enumerate() {
                    if view.may_show(mesh.positions.iter().copied()) {
                        all.grow(scene, meshes, None, index as u32, &make, &stage)?;
                    }
                }
            } else {
                for parent in parents {
                    for index in 0..meshes.len() as u32 {
                        all.grow(scene, meshes, Some(parent as u32), index, &make, &stage)?;
                    }
                }
            }
            parents = first..all.levels.len();
        }
        Ok(all)
    }

    /// Adds the levels of one more bounce on a reflector.
    fn grow(
        &mut self,
        scene: &Scene,
        meshes: &[ReflectorMesh],
        parent: Option<u32>,
        index: u32,
        make: &impl Fn(&Reflector<'_>) -> Option<L>,
        stage: &Stage<'_>,
    ) -> Result<(), Cancelled> {
        stage.advance(1)?;
        if !meshes[index as usize].has_shape() {
            return Ok(());
        }
        let mesh = &meshes[index as usize];
        if let Some(level) = parent.map(|parent| &self.levels[parent as usize])
            && !level.ray_sets.iter().any(|ray_set| level.may_reach(ray_set, index, mesh))
        {
            return Ok(());
        }
        let work = L::work_a_triangle() * mesh.triangles.len() as u64;
        // Without first paths there would be nothing of the method.
        let is_affordable = parent.is_none() || self.remaining > work;
        let reflecting = self.going_on(parent, Bounce { object: mesh.object, kind: BounceKind::Reflect });
        let is_wanted = is_affordable && !self.without.hold(&reflecting);
        let found = if is_wanted { self.arrivals(meshes, parent, index, stage)? } else { None };
        let Some((finer, mut arrivals)) = found else {
            self.left_out.push(reflecting);
            return Ok(());
        };
        let mesh = finer.as_deref().unwrap_or(&meshes[index as usize]);
        for arrivals in &mut arrivals {
            extrapolate_rays(mesh, &mut arrivals.rays);
        }
        let material = scene.material_of(mesh.object);
        let lens = material.role == Role::Lens;
        let from_within = self.view.may_start_within(&scene.objects[mesh.object as usize].bounds);
        let kinds: &[BounceKind] =
            if lens { &[BounceKind::Reflect, BounceKind::Transmit] } else { &[BounceKind::Reflect] };
        for &kind in kinds {
            let mut ray_sets = Vec::new();
            for Arrivals { from, inside, rays: arriving } in &arrivals {
                for side in [1.0, -1.0] {
                    // Within a body its inner side is met, from without the outer one; open sheets have both, and so
                    // do mirrors around the eye.
                    let possible = match (mesh.inside_only, mesh.closed, *inside) {
                        (true, ..) => side < 0.0,
                        (_, true, false) => (side > 0.0) != mesh.inside_out || (from_within && !lens),
                        (_, true, true) => side < 0.0,
                        (_, false, inside) => !lens || (side < 0.0) == inside,
                    };
                    if !possible {
                        continue;
                    }
                    let transmits = kind == BounceKind::Transmit;
                    let within = (*inside != transmits).then_some(material.ior);
                    let eta = if transmits { relative_index(material.ior, side > 0.0) } else { 1.0 };
                    let rays = VertexRays::new(mesh, kind, side, eta, within, arriving);
                    if !mesh.triangles.iter().any(|triangle| rays.shows(*triangle)) {
                        continue;
                    }
                    stage.advance(0)?;
                    let view = parent.is_none().then_some(&self.view);
                    if let Some(locator) =
                        make(&Reflector { index: finer.is_none().then_some(index), mesh, rays: &rays, view })
                    {
                        self.remaining = self.remaining.saturating_sub(locator.build_work());
                        ray_sets.push(RaySet { rays, locator, parent: *from });
                    }
                }
            }
            if ray_sets.is_empty() {
                continue;
            }
            let bounce = Bounce { object: mesh.object, kind };
            let path = self.going_on(parent, bounce);
            if self.levels.len() >= MAX_PATHS {
                self.left_out.push(path);
                continue;
            }
            self.paths.push(path);
            self.levels.push(PathLevel { parent, bounce, mesh: index, finer: finer.clone(), ray_sets });
        }
        Ok(())
    }

    /// The path of a level (of no bounce for `None`) with one more bounce.
    fn going_on(&self, parent: Option<u32>, bounce: Bounce) -> SpecularPath {
        let mut path = parent.map(|parent| self.paths[parent as usize].clone()).unwrap_or_default();
        path.bounces.push(bounce);
        path
    }

    /// The rays that arrive at a reflector's vertices, and a finer mesh of it where several branches meet. Returns
    /// `None` if that takes more work than is left.
    fn arrivals(
        &mut self,
        meshes: &[ReflectorMesh],
        parent: Option<u32>,
        index: u32,
        stage: &Stage<'_>,
    ) -> Result<Option<LevelArrivals>, Cancelled> {
        let own = &meshes[index as usize];
        let Some(parent) = parent else {
            return Ok(Some((None, vec![Arrivals::from_eye(eye_rays(own, &self.view))])));
        };
        let mut finer: Option<Arc<ReflectorMesh>> = None;
        let Some(mut arrivals) = self.level_rays(meshes, parent, index, own, stage)? else { return Ok(None) };
        for _ in 0..MAX_REFINEMENTS {
            let mesh = finer.as_deref().unwrap_or(own);
            let edges = edges_between_branches(mesh, &arrivals);
            if edges.is_empty() || mesh.triangles.len() + 3 * edges.len() > MAX_TRIANGLES {
                break;
            }
            let mesh = Arc::new(mesh.with_halved(&edges));
            let Some(finer_arrivals) = self.level_rays(meshes, parent, index, &mesh, stage)? else { break };
            arrivals = finer_arrivals;
            finer = Some(mesh);
        }
        Ok(Some((finer, arrivals)))
    }

    /// The rays that arrive at a reflector's vertices after a level, by ray set and branch. Returns `None` if that
    /// takes more than a half of the work that is left.
    fn level_rays(
        &mut self,
        meshes: &[ReflectorMesh],
        parent: u32,
        index: u32,
        mesh: &ReflectorMesh,
        stage: &Stage<'_>,
    ) -> Result<Option<Vec<Arrivals>>, Cancelled> {
        let level = &self.levels[parent as usize];
        let mut all = Vec::new();
        let (mut done, allowed) = (0, self.remaining / 2);
        for (number, ray_set) in level.ray_sets.iter().enumerate() {
            if !level.may_reach(ray_set, index, mesh) {
                continue;
            }
            let (inside, own) = (ray_set.rays.inside_after, level.mesh == index);
            let reflector = self.reflector(meshes, level, ray_set);
            let starting = if own && inside { starting_rays(&reflector, mesh) } else { Vec::new() };
            let least = if own { MIN_WAY * mesh.radius } else { 0.0 };
            let limits = ArrivalLimits { least, work: allowed - done };
            let found = arriving_rays(&reflector, &ray_set.locator, mesh, limits, starting, stage)?;
            let Some((branches, work)) = found else { return Ok(None) };
            done = (done + work).min(allowed);
            for (branch, rays) in branches {
                all.push(Arrivals { from: Some((number as u32, branch)), inside, rays });
            }
        }
        self.remaining -= done;
        Ok(Some(all))
    }

    pub(super) fn reflector<'a>(
        &'a self,
        meshes: &'a [ReflectorMesh],
        level: &'a PathLevel<L>,
        ray_set: &'a RaySet<L>,
    ) -> Reflector<'a> {
        let view = level.parent.is_none().then_some(&self.view);
        let index = level.finer.is_none().then_some(level.mesh);
        Reflector { index, mesh: level.reflector_mesh(meshes), rays: &ray_set.rays, view }
    }

    /// The surface of a reflector nearest to the eye; returns `None` if it hides nothing of itself.
    pub(crate) fn image_of(&self, mesh: u32) -> Option<&EyeImage> {
        self.images.get(mesh as usize)?.as_ref()
    }

    /// The number of reflectors, if there are so many that their maps are smaller than wanted.
    pub(crate) fn coarser_maps(&self) -> u64 {
        if self.images.len() > MAX_FULL_MAPS { self.images.len() as u64 } else { 0 }
    }

    /// Bytes held.
    pub(crate) fn byte_count(&self) -> u64 {
        let ray_sets = self.levels.iter().flat_map(|level| &level.ray_sets);
        ray_sets.map(|ray_set| ray_set.locator.byte_count() + 40 * ray_set.rays.origins.len() as u64).sum()
    }
}
