//! Scene points to their appearances: candidates from the ray map, Taylor expansion, polish.

use super::settings::{Candidates, PathPerturbationSettings};
use crate::draw::virtual_mesh::Ends;
use crate::find::polish::{Effort, Polished, polished};
use crate::find::ray_map::{
    Approximation, Candidate, CandidateFilter, CandidateRule, CandidateScratch, Motion, Neighbour, PathRays, RayMap,
    RaySample,
};
use crate::find::work;
use catoptric_core::math::portable::PortableMath;
use catoptric_core::scene::PreciseView;
use catoptric_engine::method::projector::{Projection, Projections, SpecularPath, VertexProjector};
use catoptric_engine::optics::path::bundle::{Bounce, BounceKind, Eye, FirstOrder};
use catoptric_engine::optics::path::manifold::SpecularSurfaces;
use catoptric_engine::raster::BlockMask;
use glam::{DVec2, DVec3, Vec2, Vec3};
use std::cell::RefCell;

/// Two appearances on one sheet nearer than this, in pixels, are one: beside a fold the solver's answers scatter.
/// Chosen, not measured.
const SAME_PX: f32 = 0.3;

/// A sample's answer this near to a polished one on the same sheet, in pixels, is taken for the same. Chosen, not
/// measured.
const KNOWN_PX: f32 = 0.5;

/// The expansion's linear part is enough where the second order adds less than this, in pixels, by a bound. Chosen, not
/// measured.
const NEGLIGIBLE_PX: f64 = 0.02;

/// Answers of samples that reach further than this many times their neighbours are not trusted: the point's ray is
/// nearer to another sample, or none passes the point. Chosen, not measured.
const TRUSTED_REACH: f64 = 3.0;

/// The greatest distance of a solution from its sample, in distances of the sample's neighbours: beyond, other samples
/// are nearer. Chosen, not measured.
const SOLVED_REACH: f64 = 3.0;

/// A sample that leads less than this many distances of its neighbours away, with a second order below the square of
/// it, knows: if the solver finds nothing there, there is nothing. Chosen, not measured.
const SURE_REACH: f64 = 0.5;

/// Expansions that err by less than this, in pixels, are taken for solved in pictures.
const AS_GOOD_AS_SOLVED_PX: f64 = 0.1;

/// Expansions whose next order is larger than this share of the distance to their sample's neighbours mean nothing.
/// Chosen, not measured.
const LARGEST_REST: f64 = 0.75;

/// The distance from a sample, in distances of its neighbours, beyond which its expansion is believed only if no other
/// sample is nearer. Chosen, not measured.
const OWN_REACH: f64 = 1.0;

/// Points nearer to their last bounce than this share of the reflector's size lie on it. Chosen, not measured.
const TOUCHING: f64 = 2e-4;

/// Reflection points further from the sample of their cell than this many times its neighbours lie on another part of
/// the surface, behind the visible one. Chosen, not measured.
const SAME_PART_REACH: f64 = 2.5;

/// Last segments that an expansion puts below this share of the least length that counts are not looked at. Chosen, not
/// measured.
const SURELY_NEARER: f64 = 0.5;

/// Nearest rays that are grouped (section III-C.1 of the paper, which has as many).
const NEAREST_COUNT: usize = 5;

/// Nearest rays whose directions differ by more than this, in degrees, are different reflections. The paper leaves it
/// to the user; chosen, not measured.
const GROUP_ANGLE_DEG: f64 = 20.0;

/// Nearest rays whose reflection points lie further apart than this share of the reflector's size are, too. The paper
/// leaves it to the user; chosen, not measured.
const GROUP_DISTANCE: f64 = 0.25;

/// Work of an expansion.
const WORK_A_SAMPLE: u64 = 8;

/// Projects scene points by perturbing sample rays.
pub(super) struct Perturber<'a> {
    pub(super) map: &'a RayMap,
    /// Paths that are wrong in lenses.
    pub(super) left_out: &'a [SpecularPath],
    pub(super) surfaces: SpecularSurfaces<'a>,
    pub(super) paths: Vec<SpecularPath>,
    pub(super) eye: Eye,
    pub(super) view: PreciseView,
    pub(super) settings: &'a PathPerturbationSettings,
    /// Pixels that the ray map has around the picture.
    pub(super) margin_px: f64,
    /// The treatment of appearances where neighbouring rays disagree, for every path.
    pub(super) ends: Vec<Ends>,
    /// The blocks of the picture where appearances are not looked for, for every path.
    pub(super) holes: Vec<BlockMask>,
    /// The size of every object.
    pub(super) sizes: Vec<f64>,
}

thread_local! {
    static SCRATCH: RefCell<CandidateScratch> = RefCell::default();
}

impl VertexProjector for Perturber<'_> {
    fn paths(&self) -> &[SpecularPath] {
        &self.paths
    }

    fn project_on(&self, path: u32, points: &[Vec3], found: &mut Projections) {
        self.project_beyond(path, 0.0, points, found);
    }

    fn project_beyond(&self, path: u32, least_segment: f32, points: &[Vec3], found: &mut Projections) {
        let least = SURELY_NEARER * f64::from(least_segment);
        found.extend(points, |point, found| self.project_point(path, point, least, found));
    }

    fn may_show(&self, path: u32, center: Vec3, radius: f32) -> bool {
        let group = &self.map.groups[path as usize];
        self.ends[path as usize] == Ends::Followed || group.may_be_even(center, radius)
    }

    fn holes(&self, path: u32) -> Option<&BlockMask> {
        self.holes.get(path as usize).filter(|holes| !holes.is_empty())
    }

    fn left_out(&self) -> &[SpecularPath] {
        self.left_out
    }

    fn follow(&self, one: &Projection, point: Vec3, found: &mut Projections) {
        found.extend(&[point], |point, found| found.extend(self.followed(one, point.as_dvec3())));
    }
}

impl Perturber<'_> {
    /// Appends the appearances of a point, but for those that expansions put nearer than `least` to their last bounce.
    fn project_point(&self, path: u32, point: Vec3, least: f64, found: &mut Vec<Projection>) {
        let Some(group) = self.map.groups.get(path as usize) else { return };
        if !point.is_finite() {
            return;
        }
        let start = found.len();
        let exact = point.as_dvec3();
        let mut representatives: [u32; 8] = [0; 8];
        let mut representative_count = 0;
        let mut attempts: CandidateFilter = CandidateFilter::default();
        let leaves_out = self.ends[path as usize] == Ends::LeftOut;
        let mut take = |candidate: Candidate| {
            let ray = candidate.ray;
            if leaves_out && candidate.reaching.is_some_and(|one| !self.map.is_beside_even(group, one.place)) {
                return;
            }
            if self.settings.candidates == Candidates::Nearest {
                let known = &representatives[..representative_count];
                if known.iter().any(|&other| self.same_reflection(group, ray, other)) {
                    return;
                }
                if representative_count < representatives.len() {
                    representatives[representative_count] = ray;
                    representative_count += 1;
                }
            }
            let Some(attempt) = attempts.begin(&candidate) else { return };
            let outcome = self.perturb(path, group, ray, (exact, least), &found[start..]);
            attempts.end(attempt, !matches!(outcome, PointOutcome::Unsolved));
            let PointOutcome::Seen(projection) = outcome else { return };
            let same = |other: &Projection| {
                other.focal_index == projection.focal_index && other.image_px.distance(projection.image_px) < SAME_PX
            };
            if !found[start..].iter().any(same) {
                found.push(projection);
            }
        };
        SCRATCH.with_borrow_mut(|scratch| match leaves_out {
            true => group.even_candidates(point, scratch, &mut take),
            false => group.candidates(point, scratch, &mut take),
        });
    }

    /// The paper's grouping (section III-C.1): near directions and near reflection points are one reflection.
    fn same_reflection(&self, group: &PathRays, a: u32, b: u32) -> bool {
        let (a, b) = (&group.samples[a as usize], &group.samples[b as usize]);
        let angle = a.rays.direction.dot(b.rays.direction).clamp(-1.0, 1.0).arc_cosine();
        let last = |sample: &RaySample| sample.sites.sites[sample.sites.count - 1].position;
        let size = group.path.bounces.last().map_or(0.0, |bounce| self.sizes[bounce.object as usize]);
        angle <= GROUP_ANGLE_DEG.to_radians() && last(a).distance(last(b)) <= GROUP_DISTANCE * size
    }

    /// The appearance that a sample ray leads to; unsolved where its expansion does not reach or the solver finds none.
    fn perturb(
        &self,
        path: u32,
        group: &PathRays,
        ray: u32,
        (point, least): (DVec3, f64),
        known: &[Projection],
    ) -> PointOutcome {
        work::add(WORK_A_SAMPLE);
        let sample = &group.samples[ray as usize];
        let Some(first) = sample.rays.first_order(point) else { return PointOutcome::Unsolved };
        if !(first.distance > 0.0 && (self.settings.draws_any_reach() || group.is_trusted(ray, first.linear))) {
            return PointOutcome::Unsolved;
        }
        let neighbour = match self.settings.expansion.forced() {
            None if group.second_order_px(ray, &first) < NEGLIGIBLE_PX => {
                sample.neighbour_at(&first, DVec2::ZERO, Approximation::Linear)
            }
            forced => {
                let order = forced.unwrap_or(Approximation::Quadratic);
                sample.neighbour_at(&first, sample.rays.second_order(&first), order)
            }
        };
        let Some(neighbour) = neighbour else { return PointOutcome::Unsolved };
        if least > 0.0 && sample.rays.origin_near(neighbour.parameters).distance(point) < least {
            return PointOutcome::Settled;
        }
        let spacing = f64::from(group.reach[ray as usize]);
        let found = if self.settings.polish > 0 {
            if self.is_known(sample, &neighbour, known) {
                return PointOutcome::Settled;
            }
            if let Some(found) = self.expanded_nearby(path, group, ray, &first, point) {
                return self.seen(path, group, sample, &found, point).map_or(PointOutcome::Settled, PointOutcome::Seen);
            }
            let parameters = neighbour.parameters.clamp_length_max(TRUSTED_REACH * spacing);
            self.polished(sample, parameters, point, SOLVED_REACH * spacing)
        } else {
            self.expanded(group, ray, &neighbour, point)
        };
        let Some(found) = found else {
            let px = |parameters: DVec2| group.picture_distance(ray, parameters);
            let sure = px(neighbour.linear) < SURE_REACH && px(neighbour.remainder) < SURE_REACH * SURE_REACH;
            return if sure { PointOutcome::Settled } else { PointOutcome::Unsolved };
        };
        self.seen(path, group, sample, &found, point).map_or(PointOutcome::Settled, PointOutcome::Seen)
    }

    /// The appearance by an expansion alone; returns `None` if the expansion gives none.
    fn expanded(&self, group: &PathRays, ray: u32, neighbour: &Neighbour, point: DVec3) -> Option<PointPath> {
        let sample = &group.samples[ray as usize];
        let forced = self.settings.expansion.forced();
        let left_out = left_out(neighbour, forced);
        // An expansion whose next order is as large as its reach means nothing; the paper draws it, distorted.
        let limit = if forced == Some(Approximation::Nearest) { TRUSTED_REACH } else { LARGEST_REST };
        if !self.settings.draws_any_reach() && group.picture_distance(ray, left_out) > limit {
            return None;
        }
        if self.settings.draws_any_reach() && self.is_behind(group, sample, point) {
            return None;
        }
        let parameters = sample.parameters_of(neighbour.reflection_point);
        if self.settings.candidates == Candidates::InReach
            && group.picture_distance(ray, parameters) > OWN_REACH
            && self.sample_seen_at(group, neighbour.reflection_point).is_some_and(|nearer| nearer != ray)
        {
            return None;
        }
        PointPath::expanded(sample, neighbour, (parameters, left_out), point)
    }

    /// The appearance by the second-order expansion of a sample, if that is as good as solved: its neighbours agree
    /// with it, and the point's ray is much nearer than they are.
    fn expanded_nearby(
        &self,
        path: u32,
        group: &PathRays,
        ray: u32,
        first: &FirstOrder,
        point: DVec3,
    ) -> Option<PointPath> {
        if self.ends[path as usize] == Ends::Followed || self.settings.expansion.forced().is_some() {
            return None;
        }
        if group.is_rough(ray) || group.picture_distance(ray, first.linear) > 1.0 {
            return None;
        }
        let sample = &group.samples[ray as usize];
        let neighbour = sample.neighbour_at(first, sample.rays.second_order(first), Approximation::Quadratic)?;
        let parameters = sample.parameters_of(neighbour.reflection_point);
        // Expansions err by at most the accuracy at the neighbours, and errors go by the third power of the distance.
        let distance = group.picture_distance(ray, parameters);
        let error_px = f64::from(self.settings.accuracy_px) * distance.powi(3);
        if error_px > AS_GOOD_AS_SOLVED_PX {
            return None;
        }
        PointPath::expanded(sample, &neighbour, (parameters, DVec2::ZERO), point)
    }

    /// True if a point lies behind the last mirror of a sample's path, by the tangent plane there.
    fn is_behind(&self, group: &PathRays, sample: &RaySample, point: DVec3) -> bool {
        let [.., Bounce { kind: BounceKind::Reflect, .. }] = group.path.bounces[..] else { return false };
        let sites = &sample.sites.sites[..sample.sites.count];
        let (last, arriving) = match (sites, self.eye) {
            ([.., before, last], _) => (last, last.position - before.position),
            ([last], Eye::Point(eye)) => (last, last.position - eye),
            ([last], Eye::Direction(direction)) => (last, direction),
            ([], _) => return false,
        };
        let normal = sample.rays.direction - arriving.normalize();
        normal.dot(point - last.position) <= 0.0
    }

    /// A path as an appearance; returns `None` if it is not seen.
    fn seen(
        &self,
        path: u32,
        group: &PathRays,
        sample: &RaySample,
        found: &PointPath,
        point: DVec3,
    ) -> Option<Projection> {
        let object = group.path.bounces.last()?.object;
        if found.last.distance(point) < TOUCHING * self.sizes[object as usize] {
            return None;
        }
        let place = self.view.place_of(found.reflection_point)?;
        if self.is_hidden(group, found.reflection_point, place) {
            return None;
        }
        self.finish(path, sample, found, place, point)
    }

    /// The appearance that one of a point near by continues into, from where that one is: by the solver, or by the
    /// sample whose cell it is seen in.
    fn followed(&self, one: &Projection, point: DVec3) -> Option<Projection> {
        let group = self.map.groups.get(one.path as usize)?;
        let place = [one.image_px.x, one.image_px.y].map(|pixel| f64::from(pixel) + self.margin_px);
        let ray = self.map.sample_at(group, place)?;
        if self.settings.polish == 0 {
            return match self.perturb(one.path, group, ray, (point, 0.0), &[]) {
                PointOutcome::Seen(projection) => Some(projection),
                PointOutcome::Settled | PointOutcome::Unsolved => None,
            };
        }
        let sample = &group.samples[ray as usize];
        let parameters = sample.parameters_of(one.reflection_point.as_dvec3());
        let found = self.polished(sample, parameters, point, f64::INFINITY)?;
        self.seen(one.path, group, sample, &found, point)
    }

    /// True if a sample's answer is one that another sample has led to: near it, and on the same sheet.
    fn is_known(&self, sample: &RaySample, neighbour: &Neighbour, known: &[Projection]) -> bool {
        if known.is_empty() {
            return false;
        }
        let Some([x, y]) = self.view.place_of(neighbour.reflection_point) else { return true };
        let place = Vec2::new(x as f32, y as f32);
        let near = |one: &&Projection| one.image_px.distance(place) < KNOWN_PX;
        let Some(one) = known.iter().find(near) else { return false };
        // Beside a fold two appearances are near each other, on different sheets.
        let motion = sample.motion(neighbour.distance, sample.parameters_of(neighbour.reflection_point));
        motion.is_some_and(|motion| motion.focal_index == one.focal_index)
    }

    /// The exact path near a sample's, whose first bounce is at most `reach` away from where `parameters` have it; none
    /// where the solver finds none, or one that meets surfaces from other sides.
    fn polished(&self, sample: &RaySample, parameters: DVec2, point: DVec3, reach: f64) -> Option<PointPath> {
        let start = sample.sites_at(&self.surfaces, parameters)?;
        let effort = Effort { steps: self.settings.polish, reach, must_converge: true };
        let found = polished(&self.surfaces, &self.eye, &start, &sample.outside, point, effort)?;
        let Polished { sites, last, motion, .. } = found;
        let reflection_point = sites.sites[0].position;
        let optical_length = sample.optical_length_along(&self.eye, &sites, point);
        Some(PointPath { reflection_point, last, motion, optical_length, left_out: DVec2::ZERO })
    }

    /// The sample in whose cell a first reflection point is seen.
    fn sample_seen_at(&self, group: &PathRays, reflection_point: DVec3) -> Option<u32> {
        let [x, y] = self.view.place_of(reflection_point)?;
        self.map.sample_at(group, [x + self.margin_px, y + self.margin_px])
    }

    /// True if the ray map saw another part of the path's surfaces where a reflection point should be.
    fn is_hidden(&self, group: &PathRays, reflection_point: DVec3, [x, y]: [f64; 2]) -> bool {
        if self.settings.draws_any_reach() {
            return false;
        }
        match self.map.sample_at(group, [x + self.margin_px, y + self.margin_px]) {
            Some(seen) => {
                let reach = f64::from(group.reach[seen as usize]).max(1e-9);
                group.samples[seen as usize].first.value.distance(reflection_point) > SAME_PART_REACH * reach
            }
            None => false,
        }
    }

    fn finish(
        &self,
        path: u32,
        sample: &RaySample,
        found: &PointPath,
        [x, y]: [f64; 2],
        point: DVec3,
    ) -> Option<Projection> {
        let gradients = self.view.place_change(found.reflection_point);
        let [gx, gy] = gradients;
        let tangents = &sample.first.first;
        let left_out = tangents[0] * found.left_out.x + tangents[1] * found.left_out.y;
        let projection = Projection {
            path,
            focal_index: found.motion.focal_index,
            image_px: Vec2::new(x as f32, y as f32),
            image_change: found.motion.image_change(gradients),
            path_length: found.optical_length as f32,
            reflection_point: found.reflection_point.as_vec3(),
            last_segment: found.last.distance(point) as f32,
            error_px: gx.dot(left_out).hypotenuse(gy.dot(left_out)) as f32,
        };
        projection.if_meaningful()
    }
}

/// An estimate of an expansion's remainder, in the sample's parameters: its next order.
fn left_out(neighbour: &Neighbour, forced: Option<Approximation>) -> DVec2 {
    let Neighbour { linear, remainder, .. } = *neighbour;
    match forced {
        Some(Approximation::Nearest) => linear + remainder,
        Some(Approximation::Linear) => remainder,
        // Orders fall off alike.
        Some(Approximation::Quadratic) | None => {
            let ratio = remainder.length() / linear.length();
            if ratio.is_finite() { remainder * ratio.min(1.0) } else { DVec2::ZERO }
        }
    }
}

/// Result of a sample.
enum PointOutcome {
    Seen(Projection),
    /// A path that is not seen, or one that is known.
    Settled,
    /// Undecided: another sample may lead to a path.
    Unsolved,
}

/// An appearance before it is put into the picture.
struct PointPath {
    reflection_point: DVec3,
    /// The last bounce point.
    last: DVec3,
    motion: Motion,
    optical_length: f64,
    /// The part of the expansion that was estimated but not used or not followed, in the sample's parameters.
    left_out: DVec2,
}

impl PointPath {
    /// The appearance that an expansion leads to, whose first reflection point has these parameters, and the
    /// expansion's remainder.
    fn expanded(
        sample: &RaySample,
        neighbour: &Neighbour,
        (parameters, left_out): (DVec2, DVec2),
        point: DVec3,
    ) -> Option<Self> {
        Some(Self {
            reflection_point: neighbour.reflection_point,
            last: sample.rays.origin_near(neighbour.parameters),
            motion: sample.motion(neighbour.distance, parameters)?,
            optical_length: sample.optical_length_to(point),
            left_out,
        })
    }
}

/// Selection of candidates.
pub(super) fn rule(settings: &PathPerturbationSettings) -> CandidateRule {
    match settings.candidates {
        Candidates::InReach => CandidateRule::InReach(TRUSTED_REACH as f32),
        Candidates::Nearest => CandidateRule::Nearest(NEAREST_COUNT),
    }
}
