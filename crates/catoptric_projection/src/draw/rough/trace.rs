//! The tracing of a grid: the rough mirrors that its rays meet, and their light as if they were smooth.

use super::grid::{Bumps, Found, Layout, MARGIN, Part, Place, ReflectedGrid, dilated};
use super::lobe::{DiscPoints, Lobe};
use super::mirrors::RoughMirrors;
use super::passage::Passage;
use catoptric_core::math::random;
use catoptric_core::parallel;
use catoptric_core::scene::hit::Hit;
use catoptric_core::scene::shade::SurfaceInteraction;
use catoptric_core::scene::{Ray, RayDifferential, Role, TurnedEncounter};
use catoptric_engine::error::RenderError;
use catoptric_engine::light::bumps::BumpyMeeting;
use catoptric_engine::light::path_tracer::{Cone, NearPlane, PathModel, PathTracer};
use catoptric_engine::light::wide_hierarchy::Treelet;
use catoptric_engine::method::Job;
use catoptric_engine::optics::path::bundle::BounceKind;
use catoptric_engine::optics::step::{LightStep, crossed_medium, medium_after};
use glam::{Vec2, Vec3};
use std::ops::Range;

/// Rays from rough mirrors that are seen in rough mirrors: blurred once more, their noise hardly shows.
const RAYS: u32 = 4;

/// Rays from each place of a rough mirror with bumps, and of a smooth one whose bumps are smaller than the place.
/// Chosen between noise and time.
const BUMP_RAYS: usize = 16;
const SMALL_BUMP_RAYS: u32 = 8;

/// Cells of a block along each side: they are traced together.
const BLOCK: usize = 16;

/// The greatest distance of reflected things, in diagonals of the scene: beyond, parallax cannot be seen.
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

/// A place whose light rays tell.
struct Leaving<'a> {
    /// The number of the cell's result.
    number: usize,
    met: &'a Met,
    /// The surface where the ray meets it, before a map turns the normal.
    encounter: SurfaceInteraction,
    /// The change of its sharp ray from cell to cell.
    change: RayDifferential,
    /// The factors of light by each event.
    weights: [Vec3; 2],
}

/// Cones that make up the light of a place by an event: of which place, by which event, which cones, and the factor of
/// their sum.
type TracedLobe = (usize, BounceKind, Range<usize>, f32);

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

    /// Finds the places that were met, and the light of their sharp rays.
    fn follow(&self, paths: &mut PathTracer<'_>, met: &[Met], found: &mut Vec<Found>) {
        let (scene, tracer) = (self.job.scene, &self.mirrors.tracer);
        let greatest = FAR_DIAGONALS * scene.bounds.diagonal().max(f32::MIN_POSITIVE);
        let (mut leaving, mut places) = (Vec::with_capacity(met.len()), Vec::with_capacity(met.len()));
        for met in met {
            let encounter = tracer.encounter(scene, &met.ray, &met.hit, Some(&met.change));
            let object = encounter.point.object;
            let material = scene.material_of(object);
            let TurnedEncounter { encounter: turned, variance } = scene.turned_encounter(material, &encounter);
            let incoming = met.ray.direction;
            let step = LightStep::at(scene, material, &turned.point, incoming);
            let direction = step.outgoing(BounceKind::Reflect, incoming).filter(|_| step.reflected != Vec3::ZERO);
            let Some(direction) = direction else { continue };
            let change = step.outgoing_change(BounceKind::Reflect, incoming, &met.change, &turned);
            let ray = Ray { origin: tracer.departure(&turned.point, direction), direction };
            // The bumps' changes from cell to cell say nothing of how lobes cover cells.
            let smooth_change = match variance > 0.0 {
                true => step.outgoing_change(BounceKind::Reflect, incoming, &met.change, &encounter),
                false => change,
            };
            let mut lobe = Lobe::new(material.facets_alpha(variance), &step.facing, -incoming);
            let bumps = match (material.turning_map().is_some(), material.reflection_roughness() > 0.0) {
                (false, _) => Bumps::None,
                (true, true) => Bumps::OfRough,
                // Far from what it shows, where lobes cover most.
                (true, false) if self.layout.is_hidden(lobe.width, smooth_change.solid_angle()) => Bumps::Resolved,
                (true, false) => Bumps::OfSmooth,
            };
            if matches!(bumps, Bumps::OfSmooth | Bumps::Resolved) {
                // Bumps are known one by one: no facets are hidden.
                lobe.share = 1.0;
            }
            let (column, row) = (met.column as u32, met.row as u32);
            let place = Place { column, row, lobe, distance: f32::INFINITY, is_seen: met.is_seen, bumps };
            let passage = Passage::new(object, &ray, &smooth_change, f32::INFINITY, greatest);
            if bumps != Bumps::Resolved {
                leaving.push((ray, change));
                let (number, weights) = (found.len(), BounceKind::BOTH.map(|kind| step.weight(kind)));
                places.push(Leaving { number, met, encounter, change, weights });
            }
            found.push(Found { place, passage, sharp: Vec3::ZERO, traced: None, refracted: Vec3::ZERO });
        }
        let (mut sharp, mut distances) = (vec![Vec3::ZERO; leaving.len()], vec![0.0; leaving.len()]);
        paths.radiances_and_distances(&leaving, &mut sharp, &mut distances);
        for (index, Leaving { number, .. }) in places.iter().enumerate() {
            let found = &mut found[*number];
            (found.place.distance, found.sharp) = (distances[index], sharp[index]);
            found.passage.distance = distances[index].min(greatest);
        }
        if self.layout.cell_px == self.layout.finest_px {
            self.trace_lobes(paths, &places, found);
        }
    }

    /// The means over the lobes of places with bumps by rays, each of a cone.
    fn trace_lobes(&self, paths: &mut PathTracer<'_>, places: &[Leaving<'_>], found: &mut [Found]) {
        let (scene, tracer) = (self.job.scene, &self.mirrors.tracer);
        let (mut cones, mut shares, mut parts) = (Vec::new(), Vec::new(), Vec::new());
        let mut lobes: Vec<TracedLobe> = Vec::new();
        for Leaving { number, met, encounter, change, weights } in places {
            let Found { place, passage, .. } = &found[*number];
            let is_hidden = place.bumps == Bumps::OfSmooth
                && self.layout.is_hidden(place.lobe.width, passage.cell_extent(passage.distance));
            if place.bumps == Bumps::None || !place.is_seen || is_hidden {
                continue;
            }
            // Each cell has other directions: errors are noise, not a pattern.
            let shifts = [[0, 1], [2, 3]]
                .map(|axes| Vec2::from(axes.map(|axis| random::unit(axis, place.column.into(), place.row.into()))));
            let material = scene.material_of(encounter.point.object);
            if place.bumps == Bumps::OfSmooth {
                let meeting = BumpyMeeting { scene, tracer, ray: &met.ray, change: &met.change, encounter };
                parts.clear();
                meeting.for_each_part(material, SMALL_BUMP_RAYS, shifts, |part| parts.push(part));
                for (kind, weight) in BounceKind::BOTH.into_iter().zip(weights) {
                    let (first, mean) = (cones.len(), weight.element_sum());
                    if mean <= 0.0 {
                        continue;
                    }
                    for (part, leaving) in parts.iter().filter_map(|part| Some((part, part.leaving(kind)?))) {
                        let (outside, own) = (part.step.facing.outside, material.absorption);
                        let crossed = crossed_medium(material.role == Role::Lens, outside, own, Vec3::ZERO);
                        let absorption = medium_after(kind, outside, own, crossed, Vec3::ZERO);
                        cones.push(Cone { ray: leaving.ray, change: leaving.change, absorption });
                        shares.push(leaving.weight.element_sum());
                    }
                    // The share of light that takes this event differs from part to part, not only its direction.
                    lobes.push((*number, kind, first..cones.len(), 1.0 / (SMALL_BUMP_RAYS as f32 * mean)));
                }
                continue;
            }
            let first = cones.len();
            let directions = place.lobe.directions(&DiscPoints::<BUMP_RAYS>::new(shifts[0]));
            for lane in 0..BUMP_RAYS {
                let (direction, share) = (directions.of(lane), directions.share[lane]);
                if share > 0.0 {
                    let change = change.widened(direction, directions.extent[lane].sqrt());
                    let ray = Ray { origin: tracer.departure(&encounter.point, direction), direction };
                    cones.push(Cone { ray, change, absorption: Vec3::ZERO });
                    shares.push(share);
                }
            }
            let all: f32 = shares[first..].iter().sum();
            if all > 0.0 {
                lobes.push((*number, BounceKind::Reflect, first..cones.len(), directions.kept / all));
            }
        }
        let mut light = vec![Vec3::ZERO; cones.len()];
        paths.radiances_of_cones(&cones, &mut light);
        for (number, kind, of_lobe, factor) in lobes {
            let (light, shares) = (&light[of_lobe.clone()], &shares[of_lobe]);
            let mean = light.iter().zip(shares).map(|(light, share)| *light * *share).sum::<Vec3>() * factor;
            match kind {
                BounceKind::Reflect => found[number].traced = Some(mean),
                BounceKind::Transmit => found[number].refracted = mean,
            }
        }
    }
}
