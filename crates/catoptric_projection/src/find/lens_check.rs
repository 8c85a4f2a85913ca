//! A check of appearances by lenses: rays are followed from the eye through them, as few as a coarse picture has, and
//! the method is asked for points on these rays.
//!
//! Light that passes a lens turns quickly beside its rim, near the angle of total reflection and where rays cross on
//! its far side. A method that knows a lens by its vertices or by few rays can miss appearances there, or make up
//! others, and no error bound of its own tells. The part of the lens that shows such places is found here, so that
//! something else draws it.

use super::ray_map::{Approximation, RayField, RaySample, Specular, ViewField, eye_of, follow};
use catoptric_core::math::portable::PortableMath;
use catoptric_core::parallel;
use catoptric_core::progress::{Cancelled, Progress};
use catoptric_core::scene::{Role, Scene, View};
use catoptric_engine::method::projector::{Projections, SpecularPath, VertexProjector};
use catoptric_engine::optics::path::bundle::{Bounce, BounceKind};
use catoptric_engine::raster::{BLOCK, BlockMask};
use glam::{DVec3, Vec2, Vec3};
use std::collections::BTreeMap;

/// Rays are followed from about this many places of a picture. Chosen between time and the narrowest ring that is
/// noticed.
const PLACES: f32 = 8000.0;

/// The least distance between these rays, in pixels. Chosen, not measured.
const LEAST_SPACING_PX: f32 = 2.0;

/// The factor by which rays are closer to each other where a lens begins or ends: rims are narrow. Chosen, not
/// measured.
const FINER_AT_RIMS: usize = 4;

/// A lens appears in itself only where the ray between is longer than this share of its size: at their rims lenses are
/// thin. Chosen, not measured.
pub(crate) const OWN_TRANSMITTED: f32 = 0.002;

/// Points of the scene whose appearances are all checked. Chosen, not measured.
const POINTS: u32 = 600;

/// Steps of a sequence that fills a square evenly (Roberts 2018): one over the plastic number, and its square.
const EVEN_STEPS: [f64; 2] = [0.754_877_666_246_692_7, 0.569_840_290_998_053_2];

/// Points are asked for this far on the way to where the scene ends. Chosen, not measured.
const WAY: f32 = 0.98;

/// A path through a lens behind another mirror is left out if more than this share of its rays is wrong. Chosen, not
/// measured.
const WRONG_SHARE: f32 = 0.01;

/// A lens of which more than this share is wrong is left out as a whole: little would be left. Chosen, not measured.
const MOSTLY: f32 = 0.5;

/// Appearances through lenses may be off by this much, in pixels, or something else draws them. Chosen, not measured.
pub(crate) const TOLERANCE_PX: f32 = 1.0;

/// Like [`TOLERANCE_PX`], for settings with which appearances are many pixels off everywhere: only missing ones are
/// found, and those that are a lens away. Chosen, not measured.
pub(crate) const COARSE_TOLERANCE_PX: f32 = 40.0;

/// Places and paths at which appearances in lenses are wrong.
#[derive(Debug, Default)]
pub(crate) struct WrongInLenses {
    /// Blocks of the picture where lenses that are seen directly are wrong.
    pub(crate) blocks: BlockMask,
    /// Paths that are wrong in too many places, from the eye to the first lens on them: both events there.
    pub(crate) paths: Vec<SpecularPath>,
}

/// The result of the check at one place of the picture.
struct Checked {
    /// The path of the ray to the first lens on it.
    beginning: SpecularPath,
    is_right: bool,
    /// Other places where appearances are made up.
    made_up: Vec<Vec2>,
}

/// True if a scene has a lens.
pub(crate) fn has_lens(scene: &Scene) -> bool {
    scene.specular_objects().into_iter().any(|object| scene.role_of(object) == Role::Lens)
}

/// Compares the appearances of points with rays that show them: those through lenses, whose places may be off by
/// `tolerance_px`.
///
/// # Errors
/// [`Cancelled`].
pub(crate) fn wrong_in_lenses(
    projector: &dyn VertexProjector,
    specular: &Specular<'_>,
    view: &View,
    tolerance_px: f32,
    progress: &dyn Progress,
) -> Result<WrongInLenses, Cancelled> {
    if !has_lens(specular.scene) || specular.order == 0 {
        return Ok(WrongInLenses::default());
    }
    let area = view.width as f32 * view.height as f32;
    let spacing_px = (area / PLACES).sqrt().max(LEAST_SPACING_PX);
    let size = [view.width, view.height].map(|side| ((side as f32 / spacing_px).ceil() as usize).max(1));
    let order = specular.order as usize;
    let specular = &Specular { order: specular.order + 1, ..*specular };
    let check = Check { projector, specular, view, field: ViewField::new(view, 0.0), tolerance_px, order };
    let corner = |index: usize| Vec2::new((index % size[0]) as f32, (index / size[0]) as f32);
    let middle = parallel::map_stage(progress, "checking lenses", size[0] * size[1], |index| {
        check.at((corner(index) + 0.5) * spacing_px)
    })?;
    let at_rim = |index: usize| {
        let (column, row) = (index % size[0], index / size[0]);
        let is_lens = |index: usize| middle[index].is_some();
        let differs = |other: usize| is_lens(other) != is_lens(index);
        (column > 0 && differs(index - 1))
            || (column + 1 < size[0] && differs(index + 1))
            || (row > 0 && differs(index - size[0]))
            || (row + 1 < size[1] && differs(index + size[0]))
    };
    let rims: Vec<usize> = (0..middle.len()).filter(|index| at_rim(*index)).collect();
    let finer = FINER_AT_RIMS * FINER_AT_RIMS;
    let of_rims = parallel::map_stage(progress, "checking rims of lenses", finer * rims.len(), |number| {
        let (index, part) = (rims[number / finer], number % finer);
        let part = Vec2::new((part % FINER_AT_RIMS) as f32, (part / FINER_AT_RIMS) as f32);
        let checked = check.at((corner(index) + (part + 0.5) / FINER_AT_RIMS as f32) * spacing_px);
        checked.map(|checked| (index, checked))
    })?;
    let middle = middle.into_iter().enumerate();
    let checked: Vec<(usize, Checked)> =
        middle.filter_map(|(index, checked)| Some((index, checked?))).chain(of_rims.into_iter().flatten()).collect();
    let mut counts: BTreeMap<&SpecularPath, [u32; 2]> = BTreeMap::new();
    for (_, checked) in &checked {
        let [wrong, all] = counts.entry(&checked.beginning).or_default();
        *wrong += u32::from(!checked.is_right);
        *all += 1;
    }
    let left = |(path, [wrong, all]): (&&SpecularPath, &[u32; 2])| {
        let share = if path.bounces.len() == 1 { MOSTLY } else { WRONG_SHARE };
        (*wrong as f32 > share * *all as f32).then(|| (*path).clone())
    };
    let paths: Vec<SpecularPath> = counts.iter().filter_map(left).collect();
    let mut blocks = BlockMask::new([view.width, view.height].map(|side| side as usize));
    // The box includes the places beside this one.
    let mut add = |place: Vec2| blocks.add_box(place - 1.5 * spacing_px, place + 1.5 * spacing_px);
    for (index, checked) in checked.iter().filter(|(_, checked)| checked.beginning.bounces.len() == 1) {
        if !checked.is_right {
            add((corner(*index) + 0.5) * spacing_px);
        }
        checked.made_up.iter().copied().for_each(&mut add);
    }
    let points = points_of(specular.scene);
    let made_up =
        parallel::map_stage(progress, "checking appearances", points.len(), |index| check.made_up_of(points[index]))?;
    made_up.iter().flatten().copied().for_each(add);
    Ok(WrongInLenses { blocks, paths })
}

/// The inputs of the check.
struct Check<'a> {
    projector: &'a dyn VertexProjector,
    specular: &'a Specular<'a>,
    view: &'a View,
    field: ViewField,
    tolerance_px: f32,
    /// The maximum number of bounces of paths that the picture shows.
    order: usize,
}

impl Check<'_> {
    /// Follows the ray of a place; returns `None` if it meets no lens.
    fn at(&self, place: Vec2) -> Option<Checked> {
        let samples = self.samples(place);
        let mut checked: Option<Checked> = None;
        for (path, sample) in &samples {
            let is_lens = |bounce: &Bounce| self.specular.scene.role_of(bounce.object) == Role::Lens;
            let Some(first) = path.bounces.iter().position(is_lens) else { continue };
            if !shows_much(path, sample, &samples) {
                continue;
            }
            // Both events at the lens are counted together.
            let mut beginning = SpecularPath { bounces: path.bounces[..=first].to_vec() };
            beginning.bounces[first].kind = BounceKind::Reflect;
            let checked = checked.get_or_insert(Checked { beginning, is_right: true, made_up: Vec::new() });
            // Compares where the ray meets the lens from within, and the surface beyond.
            let last = path.bounces.len() - 1;
            if last > first {
                let met = SpecularPath { bounces: path.bounces[..last].to_vec() };
                let object = path.bounces[last].object;
                let is_own = path.bounces[last - 1].object == object;
                let size = self.specular.scene.objects[object as usize].bounds.diagonal();
                let least = if is_own { OWN_TRANSMITTED * size } else { 0.0 };
                self.compare(&met, (sample.sites.sites[last].position.as_vec3(), least), place, checked);
            }
            // Rays are followed by one bounce more than pictures have.
            if path.bounces.len() <= self.order
                && !self.ends_within(sample)
                && let Some(point) = self.seen_by(sample)
            {
                self.compare(path, (point, 0.0), place, checked);
            }
        }
        checked
    }

    fn samples(&self, place: Vec2) -> Vec<(SpecularPath, RaySample)> {
        let (ray, near) = self.field.ray(place.x, place.y);
        let mut samples = Vec::new();
        let mut found = |path, sample| samples.push((path, sample));
        follow(self.specular, &eye_of(self.view), &ray, near, &mut found);
        samples
    }

    /// True if a ray goes on within a lens.
    fn ends_within(&self, sample: &RaySample) -> bool {
        let last = sample.sites.count - 1;
        let Bounce { object, kind } = sample.sites.bounces[last];
        let is_lens = self.specular.scene.role_of(object) == Role::Lens;
        is_lens && sample.outside[last] == (kind == BounceKind::Transmit)
    }

    /// A point that a ray shows, where the scene ends; `None` if it leaves the scene at once.
    fn seen_by(&self, sample: &RaySample) -> Option<Vec3> {
        let bounds = &self.specular.scene.bounds;
        let (from, direction) = (sample.rays.origin.as_vec3(), sample.rays.direction.as_vec3());
        let inverse = direction.recip();
        let (low, high) = ((bounds.min - from) * inverse, (bounds.max - from) * inverse);
        let leave = low.max(high).min_element();
        (leave.is_finite() && leave > 0.0).then(|| from + direction * (leave * WAY))
    }

    /// Asks for the appearances of a point that a ray of a place shows on a path, by a segment of at least some length.
    fn compare(&self, path: &SpecularPath, (point, least): (Vec3, f32), place: Vec2, checked: &mut Checked) {
        if is_left_out(self.projector.left_out(), path) {
            return;
        }
        let number = self.projector.paths().iter().position(|other| other == path);
        if let Some(number) = number
            && let Some(holes) = self.projector.holes(number as u32)
        {
            let block = (place / BLOCK as f32).floor().max(Vec2::ZERO);
            if holes.has(block.x as usize, block.y as usize) {
                // Places in holes are not drawn.
                return;
            }
        }
        let mut found = Projections::default();
        if let Some(number) = number {
            self.projector.project_on(number as u32, &[point], &mut found);
        }
        let is_here = |image_px: Vec2| image_px.distance(place) <= self.tolerance_px;
        checked.is_right &= found.all().iter().any(|one| is_here(one.image_px) && one.last_segment >= least);
        for one in found.all().iter().filter(|one| !is_here(one.image_px)) {
            if self.is_made_up(path, point.as_dvec3(), one.image_px) {
                checked.made_up.push(one.image_px);
            }
        }
    }

    /// The places where a point of the scene appears in lenses that are seen directly, though it does not.
    fn made_up_of(&self, point: Vec3) -> Vec<Vec2> {
        let mut places = Vec::new();
        let mut found = Projections::default();
        for (number, path) in (0..).zip(self.projector.paths()) {
            let is_lens = |bounce: &Bounce| self.specular.scene.role_of(bounce.object) == Role::Lens;
            if path.bounces.first().is_some_and(is_lens) && !is_left_out(self.projector.left_out(), path) {
                found.clear();
                self.projector.project_on(number, &[point], &mut found);
                let is_made_up = |place: &Vec2| self.is_made_up(path, point.as_dvec3(), *place);
                places.extend(found.all().iter().map(|one| one.image_px).filter(is_made_up));
            }
        }
        places
    }

    /// True if a ray of a place takes a path, but leads past a point that is said to appear there.
    fn is_made_up(&self, path: &SpecularPath, point: DVec3, place: Vec2) -> bool {
        if !place.is_finite() {
            return false;
        }
        let samples = self.samples(place);
        let Some((_, sample)) = samples.iter().find(|(other, _)| other == path) else { return false };
        let shown = sample.neighbour(point, Approximation::Quadratic);
        let shown = shown.and_then(|neighbour| self.field.place_of(neighbour.reflection_point));
        let allowed = f64::from(self.tolerance_px);
        !shown.is_some_and(|[x, y]| (x - f64::from(place.x)).hypotenuse(y - f64::from(place.y)) <= allowed)
    }
}

/// Points of a scene's surfaces, evenly spread over all that is neither mirror nor glass.
fn points_of(scene: &Scene) -> Vec<Vec3> {
    let is_plain = |triangle: &usize| !scene.role_of(scene.triangle_objects[*triangle]).is_specular();
    let corners = |triangle: usize| scene.triangles[triangle].map(|vertex| scene.positions[vertex as usize]);
    let mut sum = 0.0;
    let areas = (0..scene.triangles.len()).filter(is_plain).map(|triangle| {
        let [a, b, c] = corners(triangle);
        sum += f64::from((b - a).cross(c - a).length());
        (sum, triangle)
    });
    let areas: Vec<(f64, usize)> = areas.collect();
    let point = |index: u32| {
        let wanted = sum * (f64::from(index) + 0.5) / f64::from(POINTS);
        let (_, triangle) = *areas.get(areas.partition_point(|(sum, _)| *sum < wanted))?;
        let [a, b, c] = corners(triangle);
        // A sequence that fills the square evenly, folded into the triangle.
        let [u, v] = EVEN_STEPS.map(|step| (f64::from(index) * step).fract() as f32);
        let [u, v] = if u + v > 1.0 { [1.0 - u, 1.0 - v] } else { [u, v] };
        Some(a + (b - a) * u + (c - a) * v)
    };
    (0..POINTS).filter_map(point).filter(|point| point.is_finite()).collect()
}

/// False for paths whose light is reflected within lenses more than once where most of it leaves.
fn shows_much(path: &SpecularPath, sample: &RaySample, samples: &[(SpecularPath, RaySample)]) -> bool {
    let is_weak = |index: &usize| {
        let (before, bounce) = (&path.bounces[..*index], path.bounces[*index]);
        let leaves = |other: &SpecularPath| {
            other.bounces.len() == index + 1
                && other.bounces[..*index] == *before
                && other.bounces[*index] == Bounce { kind: BounceKind::Transmit, ..bounce }
        };
        bounce.kind == BounceKind::Reflect && !sample.outside[*index] && samples.iter().any(|(other, _)| leaves(other))
    };
    (0..path.bounces.len()).filter(is_weak).count() <= 1
}

/// True if something else draws a path: both events of a lens, and all paths that go on from it.
fn is_left_out(left_out: &[SpecularPath], path: &SpecularPath) -> bool {
    left_out.iter().any(|left| {
        let Some((last, before)) = left.bounces.split_last() else { return false };
        path.bounces.starts_with(before)
            && path.bounces.get(before.len()).is_some_and(|next| next.object == last.object)
    })
}
