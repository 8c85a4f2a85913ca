//! The search: from the best of a few texels by Newton's method from cell to cell, and by climbing where that fails.

mod batch;
mod candidates;
mod cell;
mod law;
mod maximum;
mod origins;
pub(crate) mod starts;

use super::image::{ImagePlace, MeshSpot, ReflectorImage};
use super::settings::Search;
use crate::find::virtual_objects::{Locator, ReflectionPoint, ReflectionPoints, Reflector, weights_of};
use crate::find::work;
use candidates::{TexelCandidate, TexelCandidates};
use catoptric_core::scene::Projection;
use catoptric_engine::method::Report;
use catoptric_engine::optics::path::bundle::BounceKind;
use cell::{Ends, TexelCell};
use glam::{Vec2, Vec3};
use law::Law;
use origins::RayOrigins;
use starts::{Start, Starts};
use std::sync::Arc;
use std::sync::atomic::{AtomicU64, Ordering};

/// Candidates along a picture's longer side (the faces of a cube count as three, of two layers as four) where a point
/// appears once. Chosen, not measured.
const SINGLE: u32 = 10;

/// Like [`SINGLE`], where a point may appear several times. Chosen, not measured.
const SEVERAL: u32 = 40;

/// The maximum number of places that are found for one point. A bound on time; chosen, not measured.
const MAX_PLACES: usize = 8;

/// Newton's method gives up after this many cells. A bound on time; chosen, not measured.
const MAX_CELLS: u32 = 10;

/// Like [`MAX_CELLS`], from a start beside a better one: its zero is near. A bound on time; chosen, not measured.
const MAX_CELLS_NEAR: u32 = 4;

/// Climbing moves at most this many times with one stride. A bound on time; chosen, not measured.
const MAX_MOVES: u32 = 8;

/// A step that makes things worse is halved this many times. Chosen, not measured.
const MAX_HALVINGS: u32 = 3;

/// Like [`MAX_HALVINGS`], where a point appears once: steps beyond the reflector's end are halved until they end on it.
/// Chosen, not measured.
const MAX_HALVINGS_OF_ONE: u32 = 6;

/// A point lower than this (a sine) below the tangent plane of the best place is hidden by the reflector: climbing
/// would find nothing. Above the sine of twice [`TILT_AT_END`], by the greatest bend of a cell.
pub(super) const BEHIND: f32 = -0.5;

/// Zeros this far outside a cell still belong to it: rounding must not lose those between two cells. Chosen, not
/// measured.
pub(super) const OUTSIDE: f32 = 0.1;

/// The number of texels beyond the last cell up to which a result is extrapolated. Chosen, not measured.
const EXTRAPOLATED: f32 = 1.0;

/// Normals and half vectors further apart than this, in addition to the bend of the cell, do not belong together
/// (radians). Chosen, not measured.
pub(super) const TILT: f32 = 0.01;

/// Like [`TILT`], within a cell, whatever its bend, where other parts of the reflector may meet in it at an edge.
/// Chosen, not measured.
const MAX_TILT: f32 = 0.05;

/// Like [`TILT`], where the reflector ends: points a little beyond are drawn and cut. Chosen, not measured.
const TILT_AT_END: f32 = 0.15;

/// The surface is searched a little beyond where it turns away, as far as this cosine. Chosen, not measured.
const HORIZON: f32 = -0.1;

/// Two places nearer than this, in texels, are one. Chosen, not measured.
const SAME: f32 = 1.0;

/// Work of the law at the corners of a cell.
const WORK_A_CELL: u64 = 2;

/// The search in the picture of one reflector for one kind of rays.
pub struct ReflectorSearch {
    pub(super) image: Arc<ReflectorImage>,
    pub(super) law: Law,
    pub(super) source: RayOrigins,
    /// True for texels whose cell, to the right and below, shows one piece of surface that rays arrive at, on the side
    /// that is met or nearly.
    whole: Vec<bool>,
    candidates: TexelCandidates,
    /// Table of first guesses.
    pub(super) starts: Option<Starts>,
    /// True if no point appears more than once.
    single: bool,
    search: Search,
    /// Starts that were not followed since a point had [`MAX_PLACES`] already, summed over the points so far.
    not_followed: AtomicU64,
}

impl ReflectorSearch {
    /// Makes ready to search in a picture of the reflector; returns `None` if it shows nothing of the side that is met.
    pub fn new(reflector: &Reflector<'_>, image: Arc<ReflectorImage>, search: Search) -> Option<Self> {
        let (mesh, rays) = (reflector.mesh, reflector.rays);
        let law = Law::new(rays);
        let eye = reflector
            .view
            .filter(|view| matches!(view.projection, Projection::Perspective { .. }))
            .map(catoptric_core::scene::View::eye);
        let origins = if eye.is_some() { Vec::new() } else { rays.origins.clone() };
        let leaves = |vertex: usize| match origins.get(vertex) {
            // Rays are extrapolated to vertices at which none arrives; arriving rays may be reflected totally.
            Some(origin) if !rays.origins[vertex].is_finite() => origin.is_finite(),
            _ => rays.outgoing[vertex].is_finite(),
        };
        let shows = |triangle: &[u32; 3]| {
            let some = triangle.iter().any(|vertex| rays.cosines[*vertex as usize] > HORIZON);
            some && triangle.iter().all(|vertex| leaves(*vertex as usize))
        };
        let shown: Vec<bool> = mesh.triangles.iter().map(shows).collect();
        let whole = image.whole_cells(&shown);
        let source = RayOrigins { eye, origins };
        // Rays from one point, or parallel ones, meet a surface that bulges.
        let single = reflector.view.is_some() && mesh.convex && rays.side > 0.0 && rays.kind == BounceKind::Reflect;
        let across = image.width.max(image.height)
            * match image.face_count {
                1 => 1,
                6 => 3,
                _ => 4,
            };
        let stride = across.div_ceil(if single { SINGLE } else { SEVERAL }).max(1);
        let candidates = TexelCandidates::select(&image, stride, &law, |face, x, y| {
            let index = image.index(face, x, y);
            if !whole[index] {
                return None;
            }
            let texel = &image.texels[index];
            let from = source.origin(mesh, &image.spots[index]) - texel.position;
            let nearness = from.length().recip();
            let (toward, normal) = (from * nearness, texel.normal * law.side);
            (toward.dot(normal) > 0.0).then_some(TexelCandidate { position: texel.position, normal, toward, nearness })
        });
        if candidates.is_empty() {
            return None;
        }
        let starts = match eye {
            Some(_) if single && search == Search::Cells => Starts::new(&image, &whole, law.side, mesh.center),
            _ => None,
        };
        let not_followed = AtomicU64::new(0);
        Some(Self { image, law, source, whole, candidates, starts, single, search, not_followed })
    }

    /// The origin of the ray that arrives at a texel.
    #[inline]
    fn origin(&self, reflector: &Reflector<'_>, index: usize) -> Vec3 {
        match self.source.eye {
            Some(eye) => eye,
            None => self.source.origin(reflector.mesh, &self.image.spots[index]),
        }
    }

    /// True if a place lies within the texels' centres.
    #[inline]
    fn holds(&self, place: &ImagePlace) -> bool {
        let (right, bottom) = ((self.image.width - 1) as f32, (self.image.height - 1) as f32);
        place.at.x >= 0.0 && place.at.y >= 0.0 && place.at.x < right && place.at.y < bottom
    }

    /// The squared distance between half vector and normal at a texel.
    #[inline]
    fn miss(&self, reflector: &Reflector<'_>, index: usize, point: Vec3) -> f32 {
        let texel = &self.image.texels[index];
        let toward = (self.origin(reflector, index) - texel.position).normalize();
        let half = self.law.half(texel.position, toward, point);
        half.unit.distance_squared(texel.normal * self.law.side)
    }

    /// The cell that holds a place, if it is whole.
    #[inline]
    fn cell(&self, reflector: &Reflector<'_>, place: &ImagePlace, point: Vec3) -> Option<TexelCell> {
        work::add(WORK_A_CELL);
        let (x, y) = self.image.cell_at(place);
        let low = self.image.index(place.face, x, y);
        if !self.whole[low] {
            return None;
        }
        let mut ends = Ends::default();
        for (lane, index) in self.image.corners(low).into_iter().enumerate() {
            ends.set(lane, &self.image.texels[index], self.law.side, self.origin(reflector, index));
        }
        TexelCell::new(place.face, Vec2::new(x as f32, y as f32), ends.corners(&self.law, point))
    }

    /// The cell nearest to where the normal is the half vector, from a first guess.
    #[inline]
    fn refined(&self, reflector: &Reflector<'_>, start: TexelCell, point: Vec3, most_cells: u32) -> Option<TexelCell> {
        if self.single && lies_behind(&start, point) {
            return None;
        }
        if self.search == Search::Maximum {
            return self.at_maximum(reflector, &start, point);
        }
        let mut now = start;
        for _ in 0..most_cells {
            if is_inside(&now) {
                return Some(now);
            }
            match self.stepped(reflector, &now, point) {
                Some(next) => now = next,
                None => break,
            }
        }
        if is_inside(&now) {
            return Some(now);
        }
        // The reflector ends here, or steps lead astray: the search climbs texel by texel. If there are several places
        // others start nearer, and searches that end nowhere are many.
        match self.single {
            true if lies_behind(&now, point) => None,
            true => self.climbed(reflector, now, point),
            false => ends_near(&now).then_some(now),
        }
    }

    /// The cell where this one has its zero, or one on the way there that is better.
    #[inline]
    fn stepped(&self, reflector: &Reflector<'_>, now: &TexelCell, point: Vec3) -> Option<TexelCell> {
        let step = (now.zero - 0.5).clamp_length_max(1.5 * self.candidates.stride as f32);
        if let Some(better) = self.moved(reflector, now, step, point) {
            return Some(better);
        }
        if !self.single || lies_behind(now, point) {
            return None;
        }
        // Steps beyond the reflector's end go along it, the longer way first.
        let along = [Vec2::new(step.x, 0.0), Vec2::new(0.0, step.y)];
        let along = if step.x.abs() >= step.y.abs() { along } else { [along[1], along[0]] };
        along.into_iter().find_map(|step| self.moved(reflector, now, step, point))
    }

    /// A better cell at the end of a step, or of that step halved.
    #[inline]
    fn moved(&self, reflector: &Reflector<'_>, now: &TexelCell, mut step: Vec2, point: Vec3) -> Option<TexelCell> {
        let (own, mut asked) = (ImagePlace { face: now.face, at: now.low }, 0);
        for _ in 0..if self.single { MAX_HALVINGS_OF_ONE } else { MAX_HALVINGS } {
            let place = self.image.settled(ImagePlace { face: now.face, at: now.low + 0.5 + step });
            if place.face == own.face && place.at.floor() == own.at {
                return None;
            }
            if self.whole_at(&place).is_some() {
                let cell = self.cell(reflector, &place, point)?;
                if cell.miss < now.miss {
                    return Some(cell);
                }
                asked += 1;
                if asked == MAX_HALVINGS {
                    return None;
                }
            }
            step *= 0.5;
        }
        None
    }

    /// Climbs to the texel that misses least, with smaller and smaller strides, and from there to its cell.
    #[cold]
    fn climbed(&self, reflector: &Reflector<'_>, from: TexelCell, point: Vec3) -> Option<TexelCell> {
        let miss =
            |place: &ImagePlace| self.whole_at(place).map_or(f32::MAX, |index| self.miss(reflector, index, point));
        // The middles of texels' cells.
        let start = ImagePlace { face: from.face, at: from.low + 0.5 };
        let (mut place, mut least) = (start, from.corners[0].miss.length_squared());
        let mut stride = (self.candidates.stride / 4).next_power_of_two();
        while stride > 0 {
            // Each move makes the miss smaller, so this ends; a bound all the same.
            for _ in 0..MAX_MOVES {
                let around = [Vec2::X, Vec2::NEG_X, Vec2::Y, Vec2::NEG_Y].map(|way| {
                    let moved = self.image.settled(ImagePlace { face: place.face, at: place.at + way * stride as f32 });
                    (miss(&moved), moved)
                });
                let best =
                    around.into_iter().fold((least, place), |best, other| if other.0 < best.0 { other } else { best });
                if best.1 == place {
                    break;
                }
                (least, place) = best;
            }
            stride /= 2;
        }
        if place == start { Some(from) } else { self.cell(reflector, &place, point) }
    }

    /// The reflection point of a point on a reflector that shows no point twice.
    #[inline]
    fn only_reflection_point(&self, reflector: &Reflector<'_>, point: Vec3) -> Option<ReflectionPoint> {
        self.only_cell(reflector, point).and_then(|cell| self.reflection_point(reflector, &cell, point))
    }

    fn only_cell(&self, reflector: &Reflector<'_>, point: Vec3) -> Option<TexelCell> {
        let start = match (&self.starts, self.source.eye) {
            (Some(starts), Some(eye)) => self.begun(&starts.start(eye, point)),
            _ => self.candidates.nearest(&self.law, point)?,
        };
        self.refined(reflector, self.cell(reflector, &start, point)?, point, MAX_CELLS)
    }

    /// A place of a start that lies in a whole cell.
    #[inline]
    pub(super) fn begun(&self, start: &Start) -> ImagePlace {
        let near = self.image.settled(start.near);
        if self.whole_at(&near).is_some() { near } else { start.sure }
    }

    /// The low texel of the cell that holds a place, if it is whole.
    #[inline]
    pub(super) fn whole_at(&self, place: &ImagePlace) -> Option<usize> {
        if !self.holds(place) {
            return None;
        }
        let (x, y) = self.image.cell_at(place);
        let low = self.image.index(place.face, x, y);
        self.whole[low].then_some(low)
    }

    /// The reflection point in a cell; returns `None` if its normal does not belong to the point.
    fn reflection_point(&self, reflector: &Reflector<'_>, cell: &TexelCell, point: Vec3) -> Option<ReflectionPoint> {
        let (mesh, rays) = (reflector.mesh, reflector.rays);
        let ends = !is_inside(cell);
        let at = cell.zero.clamp(Vec2::splat(-EXTRAPOLATED), Vec2::splat(1.0 + EXTRAPOLATED));
        // The triangle of the nearest texel.
        let nearest = (cell.low + at.clamp(Vec2::ZERO, Vec2::ONE)).round();
        let triangle = self.image.spots[self.image.index(cell.face, nearest.x as u32, nearest.y as u32)].triangle;
        let corners = mesh.triangles[triangle as usize].map(|vertex| mesh.positions[vertex as usize]);
        let spot_at = |position: Vec3| MeshSpot { triangle, weights: weights_of(corners, position) };
        let toward = |position: Vec3| {
            let from = match self.source.eye {
                Some(eye) => eye,
                None => self.source.origin(mesh, &spot_at(position)),
            };
            (from - position).normalize()
        };
        let spot = cell.spot(at, &self.law, point, toward);
        // Within a cell the bilinear form is wrong by the second order of its bend; more is a crease that it smooths,
        // or no answer. A convex reflector is continued beyond its end, which drawing cuts. Others end at their visible
        // end: their continuation lies hidden, and jumps from one end to another.
        let bend = cell.bend();
        let allowed = match (ends, self.single) {
            // At the end of the picture the greatest product may still miss the half vector.
            _ if self.search == Search::Maximum => TILT_AT_END + bend,
            (false, true) => TILT + bend * bend,
            (false, false) => (TILT + bend * bend).min(MAX_TILT),
            (true, false) => TILT + bend,
            (true, true) => TILT_AT_END + bend,
        };
        // Values that are not numbers are rejected, too.
        if !(spot.tilt <= allowed && spot.position_change.is_finite()) {
            return None;
        }
        // The law of the half vector holds on the wrong side of a refraction, too.
        if self.law.transmits && spot.normal.dot(point - spot.position) > 0.0 {
            return None;
        }
        let lies = spot_at(spot.position);
        let reflection_point = ReflectionPoint {
            position: spot.position,
            normal: spot.normal,
            position_change: spot.position_change,
            normal_change: spot.normal_change,
            origin: self.source.origin(mesh, &lies),
            triangle,
            weights: lies.weights,
            beyond: ends,
            blended_image: None,
        };
        if reflection_point.normal.dot(reflection_point.origin - reflection_point.position) >= 0.0 {
            return Some(reflection_point);
        }
        // The derivatives of its weights, which move it in its triangle.
        let (right, down) = (corners[1] - corners[0], corners[2] - corners[0]);
        let (g11, g12, g22) = (right.length_squared(), right.dot(down), down.length_squared());
        let scale = 1.0 / (g11 * g22 - g12 * g12);
        let turned = reflection_point.position_change.transpose();
        let change = [(right * g22 - down * g12) * scale, (down * g11 - right * g12) * scale].map(|row| turned * row);
        let held = reflection_point.held_at_horizon(mesh, rays, change);
        held.position_change.is_finite().then_some(held)
    }
}

/// True if a cell is the last one before a zero a little beyond.
fn ends_near(cell: &TexelCell) -> bool {
    (cell.zero - 0.5).abs().max_element() <= 0.5 + EXTRAPOLATED
}

/// True if a point lies far below the tangent plane at a cell.
fn lies_behind(cell: &TexelCell, point: Vec3) -> bool {
    let corner = &cell.corners[0];
    let from = point - corner.position;
    corner.normal.dot(from) < BEHIND * from.length()
}

/// A place that is found.
#[derive(Clone, Copy)]
struct LocatedPlace {
    face: u32,
    at: Vec2,
    position: Vec3,
    /// True if the half vector turns the other way round about it, which separates two places that a fold unites.
    turns: bool,
}

/// True if a cell holds its zero.
#[inline]
fn is_inside(cell: &TexelCell) -> bool {
    (cell.zero - 0.5).abs().max_element() <= 0.5 + OUTSIDE
}

impl ReflectorSearch {
    /// Appends the reflection points of one scene point.
    fn locate_point(&self, reflector: &Reflector<'_>, point: Vec3, found_points: &mut Vec<ReflectionPoint>) {
        if !point.is_finite() {
            return;
        }
        if self.single {
            found_points.extend(self.only_reflection_point(reflector, point));
            return;
        }
        let mut found =
            [LocatedPlace { face: u32::MAX, at: Vec2::ZERO, position: Vec3::NAN, turns: false }; MAX_PLACES];
        let mut count = 0;
        let stride = self.candidates.stride as f32;
        self.candidates.best(&self.law, point, |start, best| {
            if count == MAX_PLACES {
                self.not_followed.fetch_add(1, Ordering::Relaxed);
                return;
            }
            if !best && self.search == Search::Maximum {
                return;
            }
            let Some(cell) = self.cell(reflector, &start, point) else { return };
            // Two places lie side by side near a fold: neighbours of the best candidate may lead to the other one.
            let reach = if best { 0.0 } else { 1.5 * stride };
            let known = |cell: &TexelCell, at: Vec2, reach: f32| {
                let same = |one: &LocatedPlace| {
                    one.face == cell.face && one.turns == cell.turns && one.at.distance(at) < reach
                };
                found[..count].iter().any(same)
            };
            let ahead = cell.low + 0.5 + (cell.zero - 0.5).clamp_length_max(stride);
            if !best && (known(&cell, start.at, reach) || known(&cell, ahead, reach)) {
                return;
            }
            // A step that leads far away leads elsewhere.
            if !best && (cell.zero - 0.5).abs().max_element() > stride {
                return;
            }
            let most_cells = if best { MAX_CELLS } else { MAX_CELLS_NEAR };
            let Some(cell) = self.refined(reflector, cell, point, most_cells) else { return };
            let at = cell.low + cell.zero.clamp(Vec2::splat(-EXTRAPOLATED), Vec2::splat(1.0 + EXTRAPOLATED));
            let ImagePlace { face, at } = self.image.settled(ImagePlace { face: cell.face, at });
            let Some(reflection_point) = self.reflection_point(reflector, &cell, point) else { return };
            let size = cell.corners[0].position.distance(cell.corners[3].position);
            // Both layers of cube maps may show the same place.
            let known = |one: &LocatedPlace| {
                let here = one.face == face && one.at.distance(at) < SAME;
                one.turns == cell.turns && (here || one.position.distance(reflection_point.position) < size)
            };
            if !found[..count].iter().any(known) {
                found[count] = LocatedPlace { face, at, position: reflection_point.position, turns: cell.turns };
                count += 1;
                found_points.push(reflection_point);
            }
        });
    }
}

impl Locator for ReflectorSearch {
    fn locate(&self, reflector: &Reflector<'_>, points: &[Vec3], found: &mut ReflectionPoints) {
        found.extend(points, |point, found| self.locate_point(reflector, point, found));
    }

    fn add_fallbacks(&self, report: &mut Report) {
        report.add_fallback("texels_not_searched", self.candidates.left_out);
        report.add_fallback("starts_not_followed", self.not_followed.load(Ordering::Relaxed));
    }

    fn byte_count(&self) -> u64 {
        // The picture may be shared with other paths: it is counted for each.
        self.candidates.byte_count()
            + self.image.byte_count()
            + self.starts.as_ref().map_or(0, Starts::byte_count)
            + size_of_val(self.whole.as_slice()) as u64
    }
}
