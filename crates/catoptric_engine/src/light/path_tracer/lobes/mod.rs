//! Surfaces whose lobes are followed: what facets, coats and what passes a surface show, at each point of it (glTF 2.0,
//! appendix B).

mod emitters;
mod light;
mod lobe;
mod shared_rays;

use super::lobe_light::LobeLight;
use super::path_model::{LEAST_SHARE, MIN_THROUGHPUT, MOST_PASSAGES, RoughRays};
use super::rough::turn;
use super::segment::Segment;
use super::specular_paths::PathTracer;
use crate::light::radiance_field::RadianceField;
use crate::light::sides::Sides;
use crate::optics::step::{HIDDEN_LOBE, LightStep, lobe_width};
use catoptric_core::math::random;
use catoptric_core::scene::microfacets::disc_point;
use catoptric_core::scene::shade::SurfaceInteraction;
use catoptric_core::scene::{FilmReflectance, Lamps, Lobes, Material, Ray};
use glam::{Vec2, Vec3};
use lobe::{Lobe, SurfaceLobes};
pub use shared_rays::{SharedLight, SharedRays};
use std::sync::LazyLock;

/// The numbers that choose lobes, those that choose cones of a lobe, and those that choose facets differ.
const CHOICE: u64 = 0x5bd1_e995_9e37_79b9;
const COVERAGE: u64 = 0x1656_67b1_9e37_79f9;
const CONES: u64 = 0x2545_f491_4f6c_dd1d;

/// Cones that stand for a lobe together are wider by this factor than what there is to each of them: so they show no
/// gaps between them.
const OVERLAP: f32 = 1.8;

/// Cones that gather the light from infinity over a lobe, at all places of a pixel together, and at one of them at
/// least.
const MOST_CONES: u32 = 64;
const LEAST_CONES: u32 = 16;
/// The same of a ray that stands for a part of another lobe.
const LEAST_CONES_OF_RAY: u32 = 4;
/// Cones where rays of a lobe end are as narrow as if there were so many times more.
const COVERING_PARTS: u32 = 4;

/// The fewest rays of a lobe that stand for all of it by what they weigh together: fewer would favour where light
/// comes from.
const LEAST_RAYS_FOR_ALL: f32 = 4.0;

/// Rays that tell whether lamps at infinity are seen.
const RAYS_TO_LAMPS: f32 = 4.0;

/// The share of lamps' light that is looked at lamp by lamp, where cones of a lobe lie so densely, a solid angle: many
/// cones find lamps themselves, few may not (the power heuristic of Veach, Guibas 1995, with one look at each lamp).
fn share_by_lamps(density: f32) -> f32 {
    let ratio = density * Lamps::SOLID_ANGLE;
    1.0 / (1.0 + ratio * ratio)
}

/// A part of a lobe.
#[derive(Clone, Copy, Default)]
struct GatheredCone {
    /// The numbers of the facet in its middle.
    number: Vec2,
    weight: Vec3,
    /// The light from infinity that the lobe shows in it.
    light: Vec3,
    /// How many cones a ray in it stands for; 0: there is none.
    factor: f32,
}

/// Chooses cones for so many rays: half of them by their share of the lobe, half by that of its light. Both sums are
/// given.
fn choose(cones: &mut [GatheredCone], [shown, brightness]: [f32; 2], count: f32, start: f32) {
    // Cones in their order, each as long as it is likely, and as many marks at equal distances along them.
    let (mut passed, mut next) = (0.0, start);
    for cone in cones {
        let share = |part: Vec3, all: f32| if all > 0.0 { part.element_sum() / all } else { 0.0 };
        let [of_lobe, of_light] = [share(cone.weight, shown), share(cone.light, brightness)];
        let likely = if brightness > 0.0 { 0.5 * (of_lobe + of_light) } else { of_lobe };
        passed += likely * count;
        let marks = (passed - next).ceil().max(0.0);
        if marks > 0.0 && likely > 0.0 {
            next += marks;
            cone.factor = marks / (likely * count);
        }
    }
}

impl<F: RadianceField> PathTracer<'_, F> {
    /// Goes on at a point of a surface with lobes: the light that ends the path here; children wait.
    pub(super) fn spread(
        &mut self,
        segment: &Segment,
        throughput: Vec3,
        sides: &Sides,
        encounter: &SurfaceInteraction,
        (material, lobes): (&Material, &Lobes),
    ) -> Vec3 {
        let (scene, direction, point) = (self.scene, segment.ray.direction, &encounter.point);
        let at = scene.lobes_at(material, lobes, point);
        let mut covered = at.coverage;
        if segment.is_cone && covered > 0.0 && covered < 1.0 {
            // A ray that stands for a part of a lobe meets what covers, or passes it: one of the two.
            let number = turn(self.rough.seed ^ COVERAGE, direction, point.position).x;
            covered = if number < covered { 1.0 } else { 0.0 };
        }
        if covered < 1.0 && segment.passages < MOST_PASSAGES {
            let passing = throughput * (1.0 - covered);
            if passing.max_element() >= MIN_THROUGHPUT {
                let ray = Ray { origin: self.tracer.departure(point, direction), direction };
                let (near, passages) = (0.0, segment.passages + 1);
                let passing = Segment {
                    ray,
                    near,
                    throughput: passing,
                    passages,
                    deferred: None,
                    counted: None,
                    density: 0.0,
                    ..*segment
                };
                self.waiting.push(passing);
            }
        }
        let known = std::mem::take(&mut self.known);
        let throughput = throughput * covered;
        if throughput == Vec3::ZERO {
            return Vec3::ZERO;
        }
        let last = segment.order >= self.max_order;
        if last || material.unlit {
            if !material.unlit {
                self.note_end(throughput);
            }
            // The path ends: the environment stands for all that rays would have found.
            return throughput * scene.radiance_beside_lobes(material, point, &at.opaque(), -direction, [1.0; 2]);
        }
        let films = at.film.map(|film| [at.specular, at.base].map(|base| FilmReflectance::new(&film, base)));
        let (color, eta_factor) = (segment.color, sides.eta_factor);
        let of_surface = SurfaceLobes { at: &at, material, lobes, films: films.as_ref(), color, eta_factor };
        let (mut found, mirrored) = of_surface.met(point, direction);
        let absorption = sides.absorption[0];
        let segment = Segment { absorption, deferred: None, counted: None, density: 0.0, ..*segment };
        if segment.is_cone {
            // The one facet that such a ray meets says how much it reflects and how much passes it.
            let number = self.number(0, 1, direction, point.position);
            for lobe in found.iter_mut().flatten().filter(|lobe| lobe.is_clear) {
                lobe.share = lobe.weight(-direction.dot(lobe.facet(direction, number)));
            }
        }
        // Where a path goes on by one lobe alone, faint ones cost nothing.
        let least = if segment.is_cone { 0.0 } else { LEAST_SHARE };
        let visible = |lobe: &Lobe| (throughput * lobe.share).max_element() > least;
        let total: f32 = found.iter().flatten().filter(|lobe| visible(lobe)).map(|lobe| lobe.share.max_element()).sum();
        // A ray that stands for a part of a lobe goes on by one lobe alone, chosen by its share.
        let numbers =
            if segment.is_cone { turn(self.rough.seed ^ CHOICE, direction, point.position) } else { Vec2::ZERO };
        let mut choice = segment.is_cone.then_some(numbers.x * total);
        let mut sum = Vec3::ZERO;
        for (lobe, known) in found.iter().zip(known) {
            let Some(lobe) = lobe.as_ref().filter(|lobe| visible(lobe)) else { continue };
            let share = lobe.share.max_element();
            let mut throughput = throughput;
            if let Some(rest) = &mut choice {
                *rest -= share;
                if *rest >= 0.0 {
                    continue;
                }
                throughput *= total / share;
            }
            let parts = of_surface.parts_by_color(lobe, segment.is_cone.then_some(numbers.y));
            for (lobe, color, factor) in parts.iter().flatten() {
                let segment = Segment { color: *color, ..segment };
                sum += self.push_lobe(&segment, throughput * *factor, encounter, (lobe, known), (material, sides));
            }
            if choice.is_some() {
                break;
            }
        }
        sum + throughput * scene.radiance_beside_lobes(material, point, &at, -direction, [mirrored, 0.0])
    }

    /// Adds the children of a path by a lobe; the light from infinity that it shows where nothing stands before it.
    fn push_lobe(
        &mut self,
        segment: &Segment,
        throughput: Vec3,
        encounter: &SurfaceInteraction,
        (lobe, known): (&Lobe, Option<LobeLight>),
        (material, sides): (&Material, &Sides),
    ) -> Vec3 {
        let (incoming, normal) = (segment.ray.direction, lobe.facing.normal);
        let segment = if lobe.is_thin { *segment } else { segment.after(lobe.kind, sides) };
        let segment = &segment;
        let step = lobe.light_step();
        let change_of = |step: &LightStep| {
            segment.change.as_ref().map(|change| step.outgoing_change(lobe.kind, incoming, change, encounter))
        };
        // A part of a lobe is wide itself, but its one ray must not stand for all facets.
        let across = match segment.is_cone {
            true => 0.0,
            false => change_of(&step).map_or(0.0, |change| change.solid_angle().sqrt()),
        };
        if lobe_width(lobe.alpha) <= (HIDDEN_LOBE * across).max(1e-4) {
            let Some(direction) = step.outgoing(lobe.kind, incoming) else { return Vec3::ZERO };
            let throughput = throughput * lobe.weight(-incoming.dot(normal));
            if throughput.max_element() >= MIN_THROUGHPUT {
                let ray = Ray { origin: self.tracer.departure(&encounter.point, direction), direction };
                let (change, near, order) = (change_of(&step), 0.0, segment.order + 1);
                self.waiting.push(Segment { ray, change, near, throughput, order, ..*segment });
            }
            return Vec3::ZERO;
        }
        let share = (throughput * lobe.share).max_element().min(1.0);
        let count = match segment.is_cone {
            true => 1,
            false => ((self.rough.count as f32 * share.sqrt()).ceil() as u32).clamp(1, self.rough.count),
        };
        // The one facet of a cone has chosen already whether such a ray is reflected.
        let is_chosen = segment.is_cone && lobe.is_clear;
        if !is_chosen && lobe.sees_sky(material) {
            return self.push_gathered(segment, throughput, encounter, (lobe, known), [share, count as f32]);
        }
        let width = step.cone_width(lobe.kind, incoming, lobe.alpha) / (self.rough.count as f32).sqrt();
        for index in 0..count {
            let facet = lobe.facet(incoming, self.number(index, count, incoming, encounter.point.position));
            let Some(direction) = lobe.outgoing(incoming, facet) else { continue };
            let weight = lobe.weight(-incoming.dot(facet)) * lobe.unshadowed_share(incoming, direction);
            let step = step.at_facet(facet);
            let change = change_of(&step).map(|change| change.widened(direction, width * self.rough.footprint_scale));
            let ray = Ray { origin: self.tracer.departure(&encounter.point, direction), direction };
            self.push_cone(segment, ray, change, throughput * weight, count);
        }
        Vec3::ZERO
    }

    /// The light from infinity over a lobe, as if nothing stood before it, and children of the path that tell what
    /// does: so there is no noise where nothing does.
    ///
    /// The lobe is divided into cones. Half of the children go to each of them alike, half where their light comes
    /// from: so none counts for more than twice its share of the lobe. Together they take away just what was counted
    /// where all of it is hidden, as in a room. Where it is known what does, there are no children.
    fn push_gathered(
        &mut self,
        segment: &Segment,
        throughput: Vec3,
        encounter: &SurfaceInteraction,
        (lobe, known): (&Lobe, Option<LobeLight>),
        [share, count]: [f32; 2],
    ) -> Vec3 {
        let (incoming, origin) = (segment.ray.direction, encounter.point.position);
        if let Some(light) = known.and_then(|known| known.of_lobe_like(lobe, incoming)) {
            return throughput * light;
        }
        let RoughRays { part, parts, seed, footprint_scale, .. } = self.rough;
        let start = turn(seed ^ CONES, incoming, origin);
        let wanted = (MOST_CONES as f32 * share.sqrt()) as u32 / parts;
        let wanted = if segment.is_cone { LEAST_CONES_OF_RAY } else { wanted.clamp(LEAST_CONES, MOST_CONES) };
        // A power of two.
        let cone_count = 1 << wanted.ilog2();
        // The few cones of a ray are so wide that they cover most of the lobe: a sun is never in one of them alone.
        let covering = cone_count * if segment.is_cone { COVERING_PARTS } else { parts };
        let mut cones = [GatheredCone::default(); MOST_CONES as usize];
        let cones = &mut cones[..cone_count as usize];
        let (mut light, mut brightness, mut shown) = (Vec3::ZERO, 0.0, Vec3::ZERO);
        let facets = lobe.facets(incoming);
        let lamps = if segment.is_cone { None } else { self.field.lamps(self.scene) };
        // The other cones of a pixel leave other places of the surface.
        let together = covering.min(MOST_CONES);
        let mut middles = cone_middles(cone_count, [part, parts]);
        // Many paths, each with cones of its own, meet in what a lobe shows.
        let numbers = segment.is_cone.then(|| turn(seed ^ CONES ^ 1, incoming, origin));
        for (index, cone) in (0..).zip(&mut *cones) {
            let (number, disc) = match numbers {
                Some(numbers) => middle(index, cone_count, numbers),
                None => middles.next().unwrap_or_default(),
            };
            cone.number = number;
            let facet = facets.facet(disc);
            let Some(direction) = lobe.outgoing(incoming, facet) else { continue };
            cone.weight = lobe.weight(-incoming.dot(facet)) * lobe.unshadowed_share(incoming, direction);
            let width = OVERLAP * lobe.width_of_part(incoming, facet, covering);
            let ray = Ray { origin, direction };
            // Lamps are looked at one by one where there are any.
            let together = lamps.map(|_| together);
            cone.light = cone.weight * self.sky_within((&ray, width), (incoming, lobe, facet), together);
            light += cone.light;
            brightness += cone.light.element_sum();
            shown += cone.weight;
        }
        let per_cone = 1.0 / cone_count as f32;
        light *= per_cone;
        let lamps = lamps.map(|lamps| {
            let visible = known.map(|known| known.visible_lamps);
            let (light, visible) = self.of_lamps(segment, encounter, lobe, lamps, (together, start.x), visible);
            light * visible
        });
        let lamps = lamps.unwrap_or(Vec3::ZERO);
        if let Some(known) = known {
            return throughput * (light * known.visible + shown * per_cone * known.found + lamps);
        }
        choose(cones, [shown.element_sum(), brightness], count, start.x);
        let seeks_emitters = self.emitters().is_some();
        // All children together take away all the light that was counted, if nothing of it arrives.
        let taken = cones.iter().map(|cone| cone.light * (cone.factor * per_cone)).sum::<Vec3>();
        let ratio = |all: Vec3, part: Vec3| (all / part.max(Vec3::splat(f32::MIN_POSITIVE))).min(Vec3::splat(f32::MAX));
        let taken = ratio(light, taken);
        // Several of them together stand for all of the lobe, too; a single one has the factor of its own cone.
        let chosen = cones.iter().map(|cone| cone.weight * cone.factor).sum::<Vec3>();
        let given = if count >= LEAST_RAYS_FOR_ALL { ratio(shown, chosen) } else { Vec3::ONE };
        for (index, cone) in (0..).zip(&*cones).filter(|(_, cone)| cone.factor > 0.0) {
            // Somewhere in the cone's part of the lobe.
            let within = if segment.is_cone { Vec2::splat(0.5) } else { turn(seed ^ index, incoming, origin) };
            let number = beside(cone.number, (within - 0.5) / (cone_count as f32).sqrt());
            let leaving = |number: Vec2| {
                let facet = facets.facet(disc_point(number));
                lobe.outgoing(incoming, facet).map(|direction| (facet, direction))
            };
            let Some((facet, direction)) = leaving(number).or_else(|| leaving(cone.number)) else { continue };
            let scale = throughput * (cone.factor * per_cone);
            let counted = Some(cone.light * taken * scale);
            let step = lobe.light_step().at_facet(facet);
            let width = lobe.width_of_part(incoming, facet, self.rough.count) * footprint_scale;
            let change = segment
                .change
                .as_ref()
                .map(|change| step.outgoing_change(lobe.kind, incoming, change, encounter).widened(direction, width));
            let ray = Ray { origin: self.tracer.departure(&encounter.point, direction), direction };
            let density = if seeks_emitters { count * lobe.density(incoming, facet) } else { 0.0 };
            // All rays of a cone weigh the same, as what is counted of it does.
            self.push_cone(&Segment { counted, density, ..*segment }, ray, change, cone.weight * scale * given, 1);
        }
        let emitted = self.of_emitters(segment, encounter, lobe, count);
        throughput * (light + lamps + emitted)
    }

    /// The light from infinity within an angle across about a ray by a facet; if the lobe has so many cones, without
    /// what is looked at lamp by lamp.
    fn sky_within(
        &self,
        (ray, across): (&Ray, f32),
        (incoming, lobe, facet): (Vec3, &Lobe, Vec3),
        cones: Option<u32>,
    ) -> Vec3 {
        match cones {
            Some(cones) => {
                let share_of_lamps = 1.0 - share_by_lamps(lobe.density(incoming, facet) * cones as f32);
                self.field.radiance_beside_lamps(self.scene, ray, across, share_of_lamps)
            }
            None => self.field.radiance_within(self.scene, ray, across),
        }
    }

    /// The light of lamps at infinity over a lobe that so many cones cover, as far as the cones leave it out, and the
    /// share of it that arrives: as a few rays tell, if that is not known.
    fn of_lamps(
        &self,
        segment: &Segment,
        encounter: &SurfaceInteraction,
        lobe: &Lobe,
        lamps: &Lamps,
        (cones, start): (u32, f32),
        visible: Option<f32>,
    ) -> (Vec3, f32) {
        let incoming = segment.ray.direction;
        let mut lights = [0.0; Lamps::MOST];
        let lights = &mut lights[..lamps.all().len()];
        lobe.densities(incoming, lamps.all(), lights);
        // How much of a lamp's light facets that reflect all would send.
        for (light, lamp) in lights.iter_mut().zip(lamps.all()) {
            *light *= share_by_lamps(*light * cones as f32) * lamp.brightness;
        }
        let least = lights.iter().sum::<f32>() * LEAST_SHARE / lights.len() as f32;
        let mut sum = Vec3::ZERO;
        for (light, lamp) in lights.iter_mut().zip(lamps.all()) {
            let facet = if *light > least { lobe.facet_towards(incoming, lamp.towards) } else { None };
            *light = facet.map_or(0.0, |facet| {
                let weight = lobe.weight(-incoming.dot(facet)) * lobe.unshadowed_share(incoming, lamp.towards);
                let of_lamp = weight * lamp.light * (*light / lamp.brightness);
                sum += of_lamp;
                of_lamp.element_sum()
            });
        }
        let all: f32 = lights.iter().sum();
        if let Some(visible) = visible {
            return (sum, visible);
        }
        if all * segment.throughput.max_element() < MIN_THROUGHPUT {
            return (sum, 1.0);
        }
        // At equal distances along the lamps' light, each as long as it is bright.
        let (mut passed, mut next, mut seen) = (0.0, start, 0.0);
        for (light, lamp) in lights.iter().zip(lamps.all()) {
            passed += light / all * RAYS_TO_LAMPS;
            let marks = (passed - next).ceil().max(0.0);
            if marks > 0.0 {
                next += marks;
                let origin = self.tracer.departure(&encounter.point, lamp.towards);
                seen += marks * self.passing(&Ray { origin, direction: lamp.towards });
            }
        }
        (sum, (seen / RAYS_TO_LAMPS).min(1.0))
    }

    /// The share of light from infinity that passes what casts shadows, of all colours together.
    fn passing(&self, ray: &Ray) -> f32 {
        match &self.scene.light_visibility {
            Some(visibility) => visibility.passing(self.scene, ray, f32::INFINITY).element_sum() / 3.0,
            None => f32::from(u8::from(!self.tracer.is_blocked(self.scene, ray, f32::INFINITY))),
        }
    }

    /// The numbers that choose a facet for one of so many rays.
    fn number(&self, index: u32, count: u32, incoming: Vec3, at: Vec3) -> Vec2 {
        (random::hammersley(index, count) + turn(self.rough.seed, incoming, at)).fract()
    }
}

/// Numbers, and points of the unit disc, in the middles of parts of a lobe: every so many-th of a set, from one on.
/// Counts are powers of two, or as they are where samples of a pixel are none.
fn cone_middles(count: u32, [part, parts]: [u32; 2]) -> impl Iterator<Item = (Vec2, Vec2)> {
    const LARGEST: u32 = 12;
    static MIDDLES: LazyLock<Vec<Vec<(Vec2, Vec2)>>> = LazyLock::new(|| {
        let middles = |level: u32| (0..1 << level).map(move |index| middle(index, 1 << level, Vec2::ZERO)).collect();
        (0..=LARGEST).map(middles).collect()
    });
    let all = count * parts;
    let known = (all.is_power_of_two() && all.ilog2() <= LARGEST).then(|| &MIDDLES[all.ilog2() as usize]);
    (0..count).map(move |index| {
        let index = index * parts + part;
        known.map_or_else(|| middle(index, all, Vec2::ZERO), |known| known[index as usize])
    })
}

/// Two numbers that choose a facet, moved on by others: the second, an angle, goes around; the first, of which the
/// middle of the lobe is one end and its rim the other, turns back there.
fn beside(number: Vec2, step: Vec2) -> Vec2 {
    let Vec2 { x, y } = number + step;
    let x = x.abs();
    Vec2::new(if x > 1.0 { 2.0 - x } else { x }, y.rem_euclid(1.0))
}

/// The middle of one of so many parts, all of which are moved on by two numbers.
fn middle(index: u32, count: u32, moved: Vec2) -> (Vec2, Vec2) {
    let number = (random::hammersley(index, count) + moved).fract();
    (number, disc_point(number))
}
