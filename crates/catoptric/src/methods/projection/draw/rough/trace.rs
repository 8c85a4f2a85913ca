//! The tracing of a grid: which rough mirrors its rays meet, and what those would show if they were smooth.

use super::RoughMirrors;
use super::grid::{Layout, MARGIN, Part, Place, ReflectedGrid, dilated};
use super::lobe::{DiscPoints, Lobe};
use super::passage::Passage;
use crate::error::RenderError;
use crate::light::path_tracer::{NearPlane, PathModel, PathTracer};
use crate::light::wide_hierarchy::Treelet;
use crate::math::random;
use crate::methods::Job;
use crate::optics::path::bundle::BounceKind;
use crate::optics::step::LightStep;
use crate::parallel;
use crate::scene::hit::Hit;
use crate::scene::shade::SurfacePoint;
use crate::scene::{Ray, RayDifferential};
use glam::{Vec2, Vec3};

/// Rays from rough mirrors that are seen in rough mirrors: blurred once more, their noise hardly shows.
const RAYS: u32 = 4;

/// Rays from each place of a rough mirror with bumps. Chosen between noise and time.
const BUMP_RAYS: usize = 16;

/// Cells of a block along each side: they are traced together.
const BLOCK: usize = 16;

/// Beyond this many diagonals of the scene, nothing moves in what a place sees.
const FAR_DIAGONALS: f32 = 100.0;

/// A rough mirror that a cell's ray meets.
struct Met {
    column: usize,
    row: usize,
    ray: Ray,
    change: RayDifferential,
    hit: Hit,
    is_seen: bool,
}

/// What is found in a cell.
pub(super) struct Found {
    pub(super) place: Place,
    pub(super) passage: Passage,
    pub(super) sharp: Vec3,
    /// The mean over the lobe, where rays tell it.
    pub(super) traced: Option<Vec3>,
}

/// A grid that is to be traced.
pub(super) struct Cells<'a, 'b> {
    pub(super) job: &'a Job<'b>,
    pub(super) mirrors: &'a RoughMirrors,
    pub(super) layout: Layout,
    pub(super) part: Part,
}

impl Cells<'_, '_> {
    /// The grid, without blurred light.
    pub(super) fn trace(&self) -> Result<ReflectedGrid, RenderError> {
        let Self { job, mirrors, layout, .. } = self;
        let blocks = layout.width.div_ceil(BLOCK) * layout.height.div_ceil(BLOCK);
        let seen =
            parallel::map_init_stage(job.progress, "rough mirrors", blocks, Treelet::default, |treelet, block| {
                self.seen_in(block, treelet)
            })?;
        let near = match self.part {
            Part::Whole => Some(self.near(&seen)),
            Part::Narrow { .. } => None,
        };
        let init = || {
            // The rough mirror's own event is one of the path's.
            PathTracer::new(job.scene, &mirrors.tracer, PathModel::Tree, job.quality.order - 1)
                .with_rough_rays(RAYS, 0, 1.0)
        };
        let blocks = parallel::map_init_stage(job.progress, "rough mirrors", blocks, init, |paths, block| {
            let hidden = self.hidden_in(block, &seen[block], near.as_deref());
            let mut found = Vec::with_capacity(seen[block].len() + hidden.len());
            for met in [&seen[block], &hidden] {
                self.follow(paths, met, &mut found);
            }
            found
        })?;
        Ok(ReflectedGrid::new(*layout, blocks))
    }

    /// Cells near enough to those that are seen for their lobes to reach them.
    fn near(&self, seen: &[Vec<Met>]) -> Vec<bool> {
        let mut is_seen = vec![false; self.layout.cell_count()];
        for met in seen.iter().flatten() {
            is_seen[met.row * self.layout.width + met.column] = true;
        }
        dilated(&is_seen, self.layout.width, MARGIN as usize)
    }

    /// The cells of a block that are covered, by their columns and rows.
    fn cells_of(&self, block: usize) -> impl Iterator<Item = (usize, usize)> {
        let Layout { width, height, .. } = self.layout;
        let blocks = width.div_ceil(BLOCK);
        let (left, top) = (block % blocks * BLOCK, block / blocks * BLOCK);
        let cells = (top..(top + BLOCK).min(height))
            .flat_map(move |row| (left..(left + BLOCK).min(width)).map(move |column| (column, row)));
        cells.filter(|(column, row)| self.part.is_reached(*column, *row))
    }

    /// Rough mirrors that are seen in a block.
    fn seen_in(&self, block: usize, treelet: &mut Treelet) -> Vec<Met> {
        let (scene, view, rays) = (self.job.scene, self.job.view, self.job.view.rays());
        let RoughMirrors { tracer, is_rough, .. } = self.mirrors;
        let near = NearPlane::new(view);
        let is_inside = |at: Vec2| at.cmpge(Vec2::ZERO).all() && at.x < view.width as f32 && at.y < view.height as f32;
        let mut wanted = Vec::new();
        let (mut low, mut high) = (Vec2::INFINITY, Vec2::NEG_INFINITY);
        for (column, row) in self.cells_of(block).filter(|(column, row)| self.part.is_wanted(*column, *row)) {
            let at = self.layout.middle_px(column, row);
            let ray = rays.ray(at.x, at.y);
            if is_inside(at) && self.mirrors.may_be_met_by(&ray) {
                wanted.push((column, row, at, ray));
                (low, high) = (low.min(at), high.max(at));
            }
        }
        let mut seen = Vec::new();
        if wanted.is_empty() {
            return seen;
        }
        tracer.gather(&rays, low, high, treelet);
        for (column, row, at, ray) in wanted {
            let hit = tracer.first_hit_among(scene, &ray, near.distance(&ray), treelet);
            if let Some(hit) = hit.filter(|hit| is_rough[hit.object(scene) as usize]) {
                let (ray, change) = rays.ray_with_differential(at.x, at.y);
                let change = change.scaled(self.layout.cell_px as f32);
                seen.push(Met { column, row, ray, change, hit, is_seen: true });
            }
        }
        seen
    }

    /// Rough mirrors of a block that are not seen, in cells that are near those which are, if such are given: something
    /// hides them, or they lie beyond the picture.
    fn hidden_in(&self, block: usize, seen: &[Met], near_seen: Option<&[bool]>) -> Vec<Met> {
        let (scene, view, rays) = (self.job.scene, self.job.view, self.job.view.rays());
        let RoughMirrors { tracer, is_rough, .. } = self.mirrors;
        let near = NearPlane::new(view);
        let mut is_seen = [false; BLOCK * BLOCK];
        for met in seen {
            is_seen[met.row % BLOCK * BLOCK + met.column % BLOCK] = true;
        }
        let mut hidden = Vec::new();
        for (column, row) in self.cells_of(block) {
            let is_near = near_seen.is_none_or(|near| near[row * self.layout.width + column]);
            if is_seen[row % BLOCK * BLOCK + column % BLOCK] || !is_near {
                continue;
            }
            let at = self.layout.middle_px(column, row);
            if !self.mirrors.may_be_met_by(&rays.ray(at.x, at.y)) {
                continue;
            }
            let (ray, change) = rays.ray_with_differential(at.x, at.y);
            if let Some(hit) = tracer.first_hit_of(scene, &ray, near.distance(&ray), is_rough) {
                let change = change.scaled(self.layout.cell_px as f32);
                hidden.push(Met { column, row, ray, change, hit, is_seen: false });
            }
        }
        hidden
    }

    /// The places that were met, and what their sharp rays show.
    fn follow(&self, paths: &mut PathTracer<'_>, met: &[Met], found: &mut Vec<Found>) {
        let (scene, tracer) = (self.job.scene, &self.mirrors.tracer);
        let greatest = FAR_DIAGONALS * scene.bounds.diagonal().max(f32::MIN_POSITIVE);
        let mut leaving = Vec::with_capacity(met.len());
        let mut places = Vec::with_capacity(met.len());
        for met in met {
            let encounter = tracer.encounter(scene, &met.ray, &met.hit, Some(&met.change));
            let object = encounter.point.object;
            let material = scene.material_of(object);
            let encounter = scene.turned_encounter(material, &encounter);
            let incoming = met.ray.direction;
            let step = LightStep::at(scene, material, &encounter.point, incoming);
            let direction = step.outgoing(BounceKind::Reflect, incoming).filter(|_| step.reflected != Vec3::ZERO);
            let Some(direction) = direction else { continue };
            let change = step.outgoing_change(BounceKind::Reflect, incoming, &met.change, &encounter);
            let ray = Ray { origin: tracer.departure(&encounter.point, direction), direction };
            leaving.push((ray, change));
            let lobe = Lobe::new(material.reflection_roughness(), &step.facing, -incoming);
            let (column, row) = (met.column as u32, met.row as u32);
            let is_bumpy = material.normal_map.is_some();
            let place = Place { column, row, lobe, distance: 0.0, is_seen: met.is_seen, is_bumpy };
            places.push((object, place, encounter.point));
        }
        let (mut sharp, mut distances) = (vec![Vec3::ZERO; leaving.len()], vec![0.0; leaving.len()]);
        paths.radiances_and_distances(&leaving, &mut sharp, &mut distances);
        for (index, (object, place, point)) in places.into_iter().enumerate() {
            let (ray, change) = &leaving[index];
            let distance = distances[index];
            let passage = Passage::new(object, ray, change, distance, greatest);
            let is_asked = place.is_bumpy && place.is_seen && self.layout.cell_px == self.layout.finest_px;
            let traced = is_asked.then(|| self.mean_by_rays(paths, &place, &point, change)).flatten();
            found.push(Found { place: Place { distance, ..place }, passage, sharp: sharp[index], traced });
        }
    }

    /// The mean over the lobe of a point by rays, each of a cone; `None` if none leaves the surface.
    fn mean_by_rays(
        &self,
        paths: &mut PathTracer<'_>,
        place: &Place,
        point: &SurfacePoint,
        change: &RayDifferential,
    ) -> Option<Vec3> {
        // Others in every cell: what they miss is noise, not a pattern.
        let shift = [0, 1].map(|axis| random::unit(axis, place.column.into(), place.row.into()));
        let directions = place.lobe.directions(&DiscPoints::<BUMP_RAYS>::new(shift.into()));
        let (mut rays, mut shares) = (Vec::with_capacity(BUMP_RAYS), Vec::with_capacity(BUMP_RAYS));
        for lane in 0..BUMP_RAYS {
            let (direction, share) = (directions.of(lane), directions.share[lane]);
            if share > 0.0 {
                let change = change.widened(direction, directions.extent[lane].sqrt());
                rays.push((Ray { origin: self.mirrors.tracer.departure(point, direction), direction }, change));
                shares.push(share);
            }
        }
        let (mut light, mut distances) = (vec![Vec3::ZERO; rays.len()], vec![0.0; rays.len()]);
        paths.radiances_and_distances(&rays, &mut light, &mut distances);
        let sum: Vec3 = light.iter().zip(&shares).map(|(light, share)| *light * *share).sum();
        let shares: f32 = shares.iter().sum();
        (shares > 0.0).then(|| sum * (directions.kept / shares))
    }
}
