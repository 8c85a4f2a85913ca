//! Rays that leave a place by a lobe, and what they tell of the light over lobes of places nearby.
//!
//! Neighbours on a surface look at nearly the same surroundings: what each one's rays have found is weighed again by
//! the lobes of all others (spatial reuse by multiple importance, as in Bekaert, Sbert, Halton 2002: Accelerating path
//! tracing by re-using paths), seen from their own places. Sums are normalised by those of the weights.

use super::super::lobe_light::{LOBES, LobeLight, ShownLight};
use super::super::path_model::LEAST_SHARE;
use super::super::segment::Segment;
use super::super::specular_paths::PathTracer;
use super::MOST_CONES;
use super::lobe::{Lobe, SurfaceLobes};
use crate::light::radiance_field::RadianceField;
use crate::optics::path::bundle::BounceKind;
use crate::optics::step::{HIDDEN_LOBE, lobe_width};
use catoptric_core::math::random;
use catoptric_core::scene::hit::Hit;
use catoptric_core::scene::microfacets::disc_point;
use catoptric_core::scene::shade::SurfaceInteraction;
use catoptric_core::scene::{Emitters, FilmReflectance, Ray, RayDifferential, Sky};
use glam::{Vec2, Vec3};
use std::f32::consts::PI;
use std::sync::LazyLock;

/// Rays of a lobe at a place, at most and at least. The ratio of two sums is not to be trusted with fewer.
const RAYS: usize = 16;
const LEAST_RAYS: usize = 4;

/// Rays to surfaces that emit light, from each place.
const EMITTER_RAYS: usize = 8;

const MOST_RAYS: usize = RAYS + EMITTER_RAYS;

/// Places whose rays have numbers of their own, in a square; and how often each of them may have rays.
const PLACES: u32 = 4;
const ROUNDS: u32 = 1 + MOST_MORE_ROUNDS;

/// The farthest that normals of places differ, in widths of the facets' distribution.
const LARGEST_TURN: f32 = 2.5;

/// Where fewer places around have lobes that are alike, or the rays of fewer serve, counted by how well, each pixel's
/// own tell more. Chosen between noise on flat surfaces and errors on narrowly bent ones and where things touch.
const LEAST_ALIKE: f32 = 8.0;
const LEAST_SHARED: f32 = 4.0;

/// The least reach of a place, times its lobe's width, in its sizes: below it, every pixel sees something else. Wide
/// lobes err less by what is a little too far away than by too few rays. Chosen on metal floors under five things.
const LEAST_REACH: f32 = 0.01;

/// The most rounds of rays that a place needs beside its first where its neighbours' rays do not serve.
const MOST_MORE_ROUNDS: u32 = LEAST_SHARED as u32 - 1;

/// The light over a lobe is smooth where the reach of all places around is so many sizes of one at least, so is
/// the nearest thing seen, the likeness
/// of its nearest neighbours and the rays that serve are no less, and the share of lamps' light that arrives differs by
/// no more. Chosen on floors of several roughnesses under five things: so their errors are those of the smallest cells.
const SMOOTH_REACH: f32 = 3.0;
const SMOOTH_NEAREST: f32 = 2.5;
const SMOOTH_LIKENESS: f32 = 0.9;
const SMOOTH_SHARED: f32 = 6.0;
const SMOOTH_LAMPS: f32 = 0.1;

/// Places of less than their size, where it is not known how much smaller they should be.
const SMALLER: f32 = 0.5;

/// How much nearer or farther what a ray has found may count as from another place, as a factor of areas.
const LARGEST_APPROACH: f32 = 4.0;

/// A lobe at its place, as far as it weighs rays.
#[derive(Clone, Copy)]
struct PlacedLobe {
    position: Vec3,
    /// Along facets of the first and the second width, and the normal.
    axes: [Vec3; 3],
    alpha: Vec2,
    /// Unit direction to the viewer, in the axes.
    viewer: Vec3,
    /// -1 for what passes: it is mirrored at the surface.
    side: f32,
    /// The share of light that facets reflect or pass at their normals' angle, and along them.
    reflectances: [f32; 2],
    /// No facet shadows another.
    is_clear: bool,
}

impl PlacedLobe {
    fn new(lobe: &Lobe<'_>, position: Vec3, incoming: Vec3) -> Self {
        let [x, y, normal] = lobe.axes();
        let viewer = -Vec3::new(incoming.dot(x), incoming.dot(y), incoming.dot(normal));
        let side = if lobe.kind == BounceKind::Transmit { -1.0 } else { 1.0 };
        // A lobe that reflects nothing has weights, too.
        let reflectances = [1.0, 0.0].map(|cosine| lobe.weight(cosine).element_sum().max(1e-6));
        let alpha = lobe.widths().max(Vec2::splat(1e-3));
        Self { position, axes: [x, y, normal], alpha, viewer, side, reflectances, is_clear: lobe.is_clear }
    }

    /// Length of a direction in the axes whose part along the surface is as long as facets are steep (Heitz 2014,
    /// equation 86).
    #[inline(always)]
    fn slope(&self, to: Vec3) -> f32 {
        let Vec2 { x, y } = self.alpha * to.truncate();
        (x * x + y * y + to.z * to.z).sqrt()
    }

    /// The density of the lobe's rays in a direction, a solid angle, and that of the light that it shows from there
    /// (Heitz 2018, equations 3 and 17).
    #[inline(always)]
    fn densities(&self, towards: Vec3) -> [f32; 2] {
        let [x, y, z] = self.axes;
        let dot = |a: Vec3| a.x * towards.x + a.y * towards.y + a.z * towards.z;
        let light = Vec3::new(dot(x), dot(y), dot(z) * self.side);
        let half = light + self.viewer;
        let half2 = half.x * half.x + half.y * half.y + half.z * half.z;
        let [stretched_x, stretched_y] = [half.x / self.alpha.x, half.y / self.alpha.y];
        let spread = stretched_x * stretched_x + stretched_y * stretched_y + half.z * half.z;
        let facets = half2 * half2 / (PI * self.alpha.x * self.alpha.y * spread * spread);
        let [of_light, of_viewer] = [self.slope(light), self.slope(self.viewer)];
        let rays = facets / (2.0 * (self.viewer.z + of_viewer));
        let shadowed = light.z * (self.viewer.z + of_viewer) / (light.z * of_viewer + self.viewer.z * of_light);
        let unshadowed = if self.is_clear { 1.0 } else { shadowed };
        // The cosine between a facet's normal and the viewer is half of the sum of the two directions.
        let leaning = 1.0 - 0.5 * half2.sqrt();
        let leaning2 = leaning * leaning;
        let [at_normal, at_grazing] = self.reflectances;
        let shown = rays * unshadowed * (at_normal + (at_grazing - at_normal) * leaning2 * leaning2 * leaning);
        // Not a number along the surface: nothing is known there.
        if (light.z > 0.0) & (rays < f32::INFINITY) & (shown < f32::INFINITY) { [rays, shown] } else { [0.0; 2] }
    }
}

/// Rays that leave a place by one of its lobes.
pub struct SharedRays {
    lobe: PlacedLobe,
    /// Half of what it sees lies nearer than that share of the lobe's width: neighbours farther away see something
    /// else.
    reach: f32,
    /// The same of the nearest thing that it sees, at most that thing's distance.
    nearest: f32,
    /// How many places of the arrays are used.
    count: usize,
    /// Where rays end; directions of those that meet nothing, which have a last part of 0.
    ends: [[f32; MOST_RAYS]; 4],
    /// The density of the lobe's rays a solid angle; infinite where there is no ray.
    density: [f32; MOST_RAYS],
    /// The same of rays to emitters, for each of the lobe's.
    density_to_emitters: [f32; MOST_RAYS],
    /// The inverse of the square of each one's length; 1 where it meets nothing.
    nearness2: [f32; MOST_RAYS],
    /// Light from infinity, as if nothing hid it, beside lamps.
    sky: [[f32; MOST_RAYS]; 3],
    /// Light of what hides it.
    found: [[f32; MOST_RAYS]; 3],
    /// The light of lamps, as if nothing hid it, and the share that arrives.
    lamps: [f32; 2],
}

/// Sums over rays.
#[derive(Default)]
struct Sums {
    weight: f32,
    sky: Vec3,
    visible: Vec3,
    found: Vec3,
    lamps: [f32; 2],
}

impl SharedRays {
    /// How well another place's rays serve this one, from 0 to 1, by the likeness of the lobes alone.
    fn likeness(&self, other: &Self) -> f32 {
        let [own, others] = [&self.lobe, &other.lobe];
        let alpha = own.alpha.min_element();
        let turn = 2.0 * (1.0 - own.axes[2].dot(others.axes[2])) / (LARGEST_TURN * alpha).powi(2);
        let width = (others.alpha.min_element() - alpha) / alpha;
        (1.0 - turn - 2.0 * width * width).max(0.0)
    }

    /// The light over the lobe, by its own rays, those of more rounds from its place, and those of others, each with a
    /// factor; how long places may be so that it is known between them, too. `side` is that of what the place stands
    /// for.
    pub fn light(&self, side: f32, more: &[&Self], others: &[(&Self, f32)]) -> (SharedLight, f32) {
        // Where one of them sees something near, all may soon.
        let reach = others.iter().fold(self.reach, |reach, (other, _)| reach.min(other.reach));
        let nearest = others.iter().fold(self.nearest, |nearest, (other, _)| nearest.min(other.nearest));
        let mut smooth_side = (reach / SMOOTH_REACH).min(nearest / SMOOTH_NEAREST);
        let mut sums = Sums::default();
        for own in [self].iter().chain(more) {
            self.add(own, 1.0, &mut sums);
        }
        let (mut alike, mut shared) = (1.0, 1.0 + more.len() as f32);
        for (other, factor) in others {
            let likeness = self.likeness(other);
            if *factor >= 1.0 {
                // Normals turn as far as places lie apart.
                smooth_side = smooth_side.min(side * ((1.0 - SMOOTH_LIKENESS) / (1.0 - likeness)).sqrt());
            }
            if !self.lamps_alike(other) {
                smooth_side = smooth_side.min(SMALLER * side);
            }
            let likeness = factor * likeness;
            let apart = self.lobe.position.distance_squared(other.lobe.position) / (reach * reach);
            alike += likeness;
            // Not a number where nothing has an extent: it serves not.
            if likeness > 0.0 && apart < 1.0 {
                let weight = likeness * (1.0 - apart);
                shared += weight;
                self.add(other, weight, &mut sums);
            }
        }
        if alike < LEAST_ALIKE {
            return (SharedLight::Unknown, smooth_side.min(SMALLER * side));
        }
        if shared < LEAST_SHARED {
            let is_far = reach * lobe_width(self.lobe.alpha.min_element()) > LEAST_REACH * side;
            let rounds = (LEAST_SHARED - shared).ceil() as u32;
            let light = if is_far { SharedLight::Lacks { rounds } } else { SharedLight::Unknown };
            return (light, smooth_side.min(SMALLER * side));
        }
        if shared < SMOOTH_SHARED || !more.is_empty() {
            smooth_side = smooth_side.min(SMALLER * side);
        }
        let Sums { weight, sky, visible, found, lamps: [of_lamps, arriving] } = sums;
        let share = |part: f32, all: f32| if all > 0.0 { (part / all).clamp(0.0, 1.0) } else { 1.0 };
        let light = LobeLight {
            visible: Vec3::new(share(visible.x, sky.x), share(visible.y, sky.y), share(visible.z, sky.z)),
            found: if weight > 0.0 { (found / weight).max(Vec3::ZERO) } else { Vec3::ZERO },
            visible_lamps: share(arriving, of_lamps),
            shown: ShownLight::default(),
        };
        (SharedLight::Known(light), smooth_side)
    }

    /// True if as much of the lamps' light arrives at another place.
    fn lamps_alike(&self, other: &Self) -> bool {
        let [[light, share], [_, others]] = [self.lamps, other.lamps];
        light <= 0.0 || (share - others).abs() <= SMOOTH_LAMPS
    }

    /// Adds what the rays of a place say.
    #[inline(always)]
    fn add(&self, other: &Self, factor: f32, sums: &mut Sums) {
        let own = &self.lobe;
        let [x, y, z, meets] = &other.ends;
        let mut weights = [0.0; MOST_RAYS];
        let count = other.count.min(MOST_RAYS);
        for index in 0..count {
            let step = Vec3::new(
                x[index] - own.position.x * meets[index],
                y[index] - own.position.y * meets[index],
                z[index] - own.position.z * meets[index],
            );
            let length2 = step.x * step.x + step.y * step.y + step.z * step.z;
            let towards = step * (1.0 / length2.sqrt());
            let approach = length2 * other.nearness2[index];
            let approach = if approach > 1.0 / LARGEST_APPROACH { approach } else { 1.0 / LARGEST_APPROACH };
            let approach = if approach < LARGEST_APPROACH { approach } else { LARGEST_APPROACH };
            let [rays, shown] = own.densities(towards);
            let to_emitters = 2.0 * other.density_to_emitters[index];
            weights[index] = factor * 2.0 * shown / (rays + (other.density[index] + to_emitters) * approach);
        }
        for index in 0..count {
            // Not a number where neither has a ray.
            let weight = if weights[index] > 0.0 { weights[index] } else { 0.0 };
            let [sky, found] = [&other.sky, &other.found]
                .map(|light| Vec3::new(light[0][index], light[1][index], light[2][index]) * weight);
            sums.weight += weight;
            sums.sky += sky;
            sums.visible += sky * (1.0 - meets[index]);
            sums.found += found;
        }
        sums.lamps[0] += other.lamps[0] * factor;
        sums.lamps[1] += other.lamps[0] * other.lamps[1] * factor;
    }
}

/// The light over a lobe, as far as rays tell it.
pub enum SharedLight {
    /// The light, as told by rays nearby.
    Known(LobeLight),
    /// The place itself needs more rounds of rays: things are too near for others to see the same.
    Lacks {
        /// Rounds of rays that are missing.
        rounds: u32,
    },
    /// The surface is so bent, or things are so near, that pixels see something else each: their own rays tell more.
    Unknown,
}

/// Numbers and points of the unit disc for the rays of so many places: those of each are spread evenly, and so are
/// those of all, round by round (the first two numbers of the sequence of Sobol 1967).
static NUMBERS: LazyLock<Vec<(Vec2, Vec2)>> = LazyLock::new(|| {
    let all = ROUNDS * PLACES * PLACES * RAYS as u32;
    let middle = |index| random::sobol(index) + 0.5 / all as f32;
    (0..all).map(middle).map(|number| (number, disc_point(number))).collect()
});

/// The number of a place among those whose rays differ: neighbours in pairs first.
fn place_number(column: u32, row: u32) -> u32 {
    (column & 1) | (row & 1) << 1 | (column & 2) << 1 | (row & 2) << 2
}

impl<F: RadianceField> PathTracer<'_, F> {
    /// Traces rays that leave a surface by its lobes, where a path meets it first. None for lobes that are too narrow
    /// for it, or too weak, or that go on within a body; tells whether there are any that are narrow or go on within.
    /// `place` is a column, a row, and a round, which choose the rays.
    pub fn shared_rays(
        &mut self,
        ray: &Ray,
        change: &RayDifferential,
        encounter: &SurfaceInteraction,
        [column, row, round]: [u32; 3],
    ) -> ([Option<SharedRays>; LOBES], bool) {
        let (scene, point, direction) = (self.scene, &encounter.point, ray.direction);
        let material = scene.material_of(point.object);
        let none = ([const { None }; LOBES], false);
        let Some(lobes) = material.lobes().filter(|_| !material.unlit && self.max_order > 0) else { return none };
        let at = scene.lobes_at(material, lobes, point);
        if at.coverage <= 0.0 {
            return none;
        }
        let films = at.film.map(|film| [at.specular, at.base].map(|base| FilmReflectance::new(&film, base)));
        let of_surface = SurfaceLobes { at: &at, material, lobes, films: films.as_ref(), color: None, eta_factor: 1.0 };
        let (found, _) = of_surface.met(point, direction);
        let place = round * PLACES * PLACES + place_number(column, row);
        let segment = Segment::first(*ray, Some(*change), 0.0);
        let mut has_others = at.coverage < 1.0;
        let rays = found.map(|lobe| {
            let lobe = lobe.filter(|lobe| lobe.share.max_element() > LEAST_SHARE)?;
            let step = lobe.light_step();
            let across = step.outgoing_change(lobe.kind, direction, change, encounter).solid_angle().sqrt();
            if !lobe.sees_sky(material) || lobe_width(lobe.alpha) <= (HIDDEN_LOBE * across).max(1e-4) {
                has_others = true;
                return None;
            }
            Some(self.rays_of_lobe(&segment, encounter, &lobe, place))
        });
        (rays, has_others)
    }

    /// Adds all the light that lobes show to what is known of it, where a path meets a surface first.
    pub fn add_shown_light(
        &mut self,
        ray: &Ray,
        change: &RayDifferential,
        encounter: &SurfaceInteraction,
        lights: &mut [Option<LobeLight>; LOBES],
    ) {
        let (scene, point, direction) = (self.scene, &encounter.point, ray.direction);
        let material = scene.material_of(point.object);
        let Some(lobes) = material.lobes() else { return };
        let at = scene.lobes_at(material, lobes, point);
        let of_surface = SurfaceLobes { at: &at, material, lobes, films: None, color: None, eta_factor: 1.0 };
        let (found, _) = of_surface.met(point, direction);
        let segment = Segment::first(*ray, Some(*change), 0.0);
        for (lobe, light) in found.iter().zip(lights).filter(|_| at.film.is_none()) {
            let (Some(lobe), Some(light)) = (lobe.as_ref().filter(|lobe| lobe.is_plain()), light) else { continue };
            let share = lobe.share.max_element().min(1.0);
            let radiance = self.push_gathered(&segment, Vec3::ONE, encounter, (lobe, Some(*light)), [share, 1.0]);
            let normal = lobe.facing.normal;
            let weight = lobe.weight(-direction.dot(normal));
            light.shown = ShownLight { share: 1.0, normal, alpha: lobe.alpha, weight, radiance };
        }
    }

    /// The rays of one lobe.
    fn rays_of_lobe(
        &mut self,
        segment: &Segment,
        encounter: &SurfaceInteraction,
        lobe: &Lobe<'_>,
        place: u32,
    ) -> SharedRays {
        let incoming = segment.ray.direction;
        let share = lobe.share.max_element().min(1.0);
        let wanted = ((RAYS as f32 * share.sqrt()) as usize).clamp(LEAST_RAYS, RAYS);
        let count = 1 << wanted.ilog2();
        let mut shared = SharedRays {
            lobe: PlacedLobe::new(lobe, encounter.point.position, incoming),
            reach: f32::INFINITY,
            nearest: f32::INFINITY,
            count,
            ends: [[0.0; MOST_RAYS]; 4],
            density: [f32::INFINITY; MOST_RAYS],
            density_to_emitters: [0.0; MOST_RAYS],
            nearness2: [1.0; MOST_RAYS],
            sky: [[0.0; MOST_RAYS]; 3],
            found: [[0.0; MOST_RAYS]; 3],
            lamps: [0.0; 2],
        };
        let facets = lobe.facets(incoming);
        let numbers = &NUMBERS[place as usize * count..][..count];
        let mut waiting = WaitingRays { rays: Vec::with_capacity(MOST_RAYS), starts: Vec::with_capacity(MOST_RAYS) };
        for (_, disc) in numbers {
            let facet = facets.facet(*disc);
            if let Some(direction) = lobe.outgoing(incoming, facet) {
                let width = lobe.width_of_part(incoming, facet, count as u32);
                self.add_ray((segment, encounter, lobe), (direction, facet, width), &mut shared, &mut waiting);
            }
        }
        let emitters = self.scene.sky.as_deref().and_then(Sky::emitters);
        let of_lobe = waiting.rays.len();
        if let Some(emitters) = emitters {
            for (number, _) in &NUMBERS[place as usize * EMITTER_RAYS..][..EMITTER_RAYS] {
                let towards = self.scene.point_of(emitters, *number) - encounter.point.position;
                let Some(direction) = towards.try_normalize() else { continue };
                if let Some(facet) = lobe.facet_towards(incoming, direction) {
                    self.add_ray((segment, encounter, lobe), (direction, facet, 0.0), &mut shared, &mut waiting);
                }
            }
        }
        self.trace_shared(waiting, of_lobe, emitters, &mut shared);
        // The harmonic mean of lengths: near things change most.
        let nearness = |ray: usize| shared.ends[3][ray] * shared.nearness2[ray].sqrt();
        let width = lobe_width(shared.lobe.alpha.min_element());
        let nearest = (0..shared.count).filter(|ray| shared.density[*ray] < f32::INFINITY).map(nearness);
        shared.nearest = width.min(1.0) / nearest.fold(0.0, f32::max);
        shared.reach = width * of_lobe as f32 / (0..of_lobe).map(nearness).sum::<f32>();
        if let Some(lamps) = self.field.lamps(self.scene) {
            let number = NUMBERS[place as usize].0.x;
            let (light, share) = self.of_lamps(segment, encounter, lobe, lamps, (MOST_CONES, number), None);
            shared.lamps = [light.element_sum(), share];
        }
        shared
    }

    /// Adds a ray by a facet, as wide as an angle across, with the light from infinity that it would bring.
    fn add_ray(
        &self,
        (segment, encounter, lobe): (&Segment, &SurfaceInteraction, &Lobe<'_>),
        (direction, facet, width): (Vec3, Vec3, f32),
        shared: &mut SharedRays,
        waiting: &mut WaitingRays,
    ) {
        let (incoming, index) = (segment.ray.direction, waiting.rays.len());
        let ray = Ray { origin: self.tracer.departure(&encounter.point, direction), direction };
        let cones = self.field.lamps(self.scene).map(|_| MOST_CONES);
        let sky = self.sky_within((&ray, width), (incoming, lobe, facet), cones);
        for (axis, sky) in sky.to_array().into_iter().enumerate() {
            shared.sky[axis][index] = sky;
        }
        let [density, _] = shared.lobe.densities(direction);
        shared.density[index] = if density > 0.0 { density } else { f32::INFINITY };
        let step = lobe.light_step().at_facet(facet);
        let change = segment
            .change
            .as_ref()
            .map(|change| step.outgoing_change(lobe.kind, incoming, change, encounter).widened(direction, width));
        // Light from infinity is known: such a ray tells what hides it.
        let order = segment.order + 1;
        waiting.rays.push(direction);
        waiting.starts.push(Segment { ray, change, order, is_cone: true, counted: Some(Vec3::ZERO), ..*segment });
    }

    /// Traces rays; those behind the first, which go to emitters, count where they meet one.
    fn trace_shared(
        &mut self,
        waiting: WaitingRays,
        of_lobe: usize,
        emitters: Option<&Emitters>,
        shared: &mut SharedRays,
    ) {
        let (scene, position) = (self.scene, shared.lobe.position);
        let WaitingRays { rays, starts } = waiting;
        let (mut found, mut hits) = ([Vec3::ZERO; MOST_RAYS], [None; MOST_RAYS]);
        self.radiances_from(starts.into_iter(), &mut found[..rays.len()], |ray, hit| hits[ray] = hit.copied());
        // Some of the lobe's own rays have no direction; they count in the density all the same.
        let per_ray = EMITTER_RAYS as f32 / shared.count as f32;
        shared.count = rays.len();
        for (index, direction) in rays.into_iter().enumerate() {
            let Some(hit) = hits[index] else {
                for (axis, value) in direction.to_array().into_iter().enumerate() {
                    shared.ends[axis][index] = value;
                }
                if index >= of_lobe {
                    shared.density[index] = f32::INFINITY;
                }
                continue;
            };
            let distance = hit.distance();
            let end = (position + direction * distance).extend(1.0);
            for (axis, value) in end.to_array().into_iter().enumerate() {
                shared.ends[axis][index] = value;
            }
            shared.nearness2[index] = 1.0 / (distance * distance).max(f32::MIN_POSITIVE);
            for (axis, value) in found[index].to_array().into_iter().enumerate() {
                shared.found[axis][index] = value;
            }
            let Some(emitters) = emitters else { continue };
            let to_emitters = match hit {
                Hit::Triangle { triangle, .. } => scene.density_of(emitters, triangle, direction) * distance * distance,
                _ => 0.0,
            };
            shared.density_to_emitters[index] = per_ray * to_emitters;
            if index >= of_lobe && to_emitters <= 0.0 {
                shared.density[index] = f32::INFINITY;
            }
        }
    }
}

/// Rays that wait to be traced: their directions, and the first segments of their paths.
struct WaitingRays {
    rays: Vec<Vec3>,
    starts: Vec<Segment>,
}
