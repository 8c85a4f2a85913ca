//! Surfaces whose lobes are followed: what facets, coats and what passes a surface show, at each point of it (glTF 2.0,
//! appendix B).

use super::rough::RoughRays;
use super::{MIN_THROUGHPUT, PathTracer, Segment};
use crate::light::radiance_field::RadianceField;
use crate::math::random;
use crate::optics::path::bundle::BounceKind;
use crate::optics::step::{
    Facing, HIDDEN_LOBE, LightStep, fresnel_dielectric, lobe_width, medium_after, reflect, refract,
    relative_index,
};
use crate::scene::microfacets::{ReflectanceTable, extent_of_sample, unshadowed_share, visible_facet};
use crate::scene::shade::SurfaceInteraction;
use crate::scene::{Lobes, LobesAt, Material, Ray, RayDifferential};
use glam::{Vec2, Vec3};

/// A lobe that can add no more than this share of the light before it is not followed: half a step of eight bits at
/// half of the brightest.
const LEAST_SHARE: f32 = 1.0 / 1024.0;

/// The index of refraction of coats (KHR_materials_clearcoat).
const COAT_IOR: f32 = 1.5;

/// Reflections of dielectrics from the first perceptual roughness on become those of the environment alone, which all
/// of them are from the second one on: lobes as wide as half of the sky that carry a twentieth of the light.
const WIDE_ROUGHNESS: [f32; 2] = [0.5, 0.75];

/// The numbers that choose lobes are others than those that choose facets.
const CHOICE: u64 = 0x5bd1_e995_9e37_79b9;

/// Cones that stand for a lobe together are wider by this factor than what there is to each of them: so they show no gaps
/// between them.
const OVERLAP: f32 = 1.8;

/// Cones that gather the light from infinity over a lobe, at all places of a pixel together, and at one of them at least.
const MOST_CONES: u32 = 64;
const LEAST_CONES: u32 = 16;
/// Where rays of a lobe end, each has one of so many parts of those cones.
const PARTS: u32 = 8;

/// Surfaces that a path passes straight on, at most.
const MOST_PASSAGES: u8 = 64;

/// One lobe of a surface, in the direction of a path.
struct Lobe {
    kind: BounceKind,
    /// The side of arrival, with the lobe's own normal.
    facing: Facing,
    /// Width of the facets' distribution.
    alpha: f32,
    eta: f32,
    /// A refracted ray goes straight on, as through a wall without thickness; the medium stays the same.
    is_thin: bool,
    /// The surface lets light pass: a ray that meets several facets leaves it on one side or the other, and no light is
    /// lost.
    is_clear: bool,
    reflectance: Reflectance,
    /// The factor on what the reflectance leaves, of refracted light, or on it, of reflected light.
    factor: Vec3,
    /// The share of light that goes this way, at the normal's angle.
    share: Vec3,
}

/// A part of a lobe.
#[derive(Clone, Copy, Default)]
struct GatheredCone {
    /// The numbers of the facet in its middle.
    number: Vec2,
    weight: Vec3,
    /// The light from infinity that the lobe shows in it.
    light: Vec3,
}

/// Reflectance by the angle: of a dielectric, of metal, or of a mixture.
#[derive(Clone, Copy)]
struct Reflectance {
    /// The dielectric's at normal incidence, and at grazing angles.
    specular: Vec3,
    grazing: f32,
    /// The base colour, and how much of the surface is metal.
    base: Vec3,
    metallic: f32,
    eta: f32,
}

impl Reflectance {
    /// The dielectric's share, by the cosine of the angle of incidence.
    fn of_dielectric(&self, cosine: f32) -> Vec3 {
        let at_normal = fresnel_dielectric(1.0, self.eta);
        // Fresnel's own curve, between the two ends that the material names.
        let rise = (fresnel_dielectric(cosine, self.eta) - at_normal) / (1.0 - at_normal).max(1e-6);
        self.specular + (Vec3::splat(self.grazing) - self.specular) * rise
    }

    fn of_all(&self, cosine: f32) -> Vec3 {
        let dielectric = self.of_dielectric(cosine);
        if self.metallic == 0.0 {
            return dielectric;
        }
        let rise = (1.0 - cosine.clamp(0.0, 1.0)).powi(5);
        dielectric.lerp(self.base + (Vec3::ONE - self.base) * rise, self.metallic)
    }
}

impl Lobe {
    /// The factor of light by a facet that is met at this cosine.
    fn weight(&self, cosine: f32) -> Vec3 {
        self.factor
            * match self.kind {
                BounceKind::Reflect => self.reflectance.of_all(cosine),
                BounceKind::Transmit => Vec3::ONE - self.reflectance.of_dielectric(cosine),
            }
    }

    /// The facet that two numbers choose, of those that a ray meets.
    fn facet(&self, incoming: Vec3, number: Vec2) -> Vec3 {
        let normal = self.facing.normal;
        let (x, y) = normal.any_orthonormal_pair();
        let towards_viewer = -Vec3::new(incoming.dot(x), incoming.dot(y), incoming.dot(normal));
        let facet = visible_facet(self.alpha, towards_viewer, number);
        x * facet.x + y * facet.y + normal * facet.z
    }

    /// The share of a facet's light that is not shadowed by others.
    fn unshadowed_share(&self, incoming: Vec3, direction: Vec3) -> f32 {
        if self.is_clear {
            return 1.0;
        }
        let normal = self.facing.normal;
        unshadowed_share(self.alpha, direction.dot(normal), -incoming.dot(normal))
    }

    /// The direction after an event at a facet, on the side where it belongs.
    fn outgoing(&self, incoming: Vec3, facet: Vec3) -> Option<Vec3> {
        let Facing { geometric, normal, .. } = self.facing;
        let (direction, side) = match self.kind {
            BounceKind::Reflect => (reflect(incoming, facet), 1.0),
            BounceKind::Transmit if self.is_thin => {
                let mirrored = reflect(incoming, facet);
                (mirrored - normal * (2.0 * mirrored.dot(normal)), -1.0)
            }
            BounceKind::Transmit => (refract(incoming, facet, self.eta)?, -1.0),
        };
        let height = direction.dot(normal) * side;
        let direction = match height <= 0.0 {
            true if self.is_clear => direction - normal * (2.0 * height * side),
            // Light that meets another facet: the compensation gives it back.
            true => return None,
            false => direction,
        };
        // On the other side of the flat surface alone: it stays on its side.
        let side = geometric * side;
        let depth = direction.dot(side);
        Some(if depth < 0.0 { direction - side * (2.0 * depth) } else { direction })
    }
}

impl<F: RadianceField> PathTracer<'_, F> {
    /// Goes on at a point of a surface with lobes, which a path reaches through a medium of this absorption: the light
    /// that ends the path here; children wait.
    pub(super) fn spread(
        &mut self,
        segment: &Segment,
        throughput: Vec3,
        absorption: Vec3,
        encounter: &SurfaceInteraction,
        (material, lobes): (&Material, &Lobes),
    ) -> Vec3 {
        let (scene, direction, point) = (self.scene, segment.ray.direction, &encounter.point);
        let at = scene.lobes_at(material, lobes, point);
        if at.coverage < 1.0 && segment.passages < MOST_PASSAGES {
            let passing = throughput * (1.0 - at.coverage);
            if passing.max_element() >= MIN_THROUGHPUT {
                let ray = Ray { origin: self.tracer.departure(point, direction), direction };
                let (near, passages) = (0.0, segment.passages + 1);
                let passing = Segment { ray, near, throughput: passing, passages, deferred: None, counted: None, ..*segment };
                self.waiting.push(passing);
            }
        }
        let throughput = throughput * at.coverage;
        if throughput == Vec3::ZERO {
            return Vec3::ZERO;
        }
        let last = segment.order >= self.max_order;
        if last || material.unlit {
            // The path ends: the environment stands for all that rays would have found.
            return throughput * scene.radiance_beside_lobes(material, point, &at.opaque(), -direction, 1.0);
        }
        let (mut lobes, mirrored) = self.lobes_of(&at, material, lobes, encounter, direction);
        let segment = Segment { absorption, deferred: None, counted: None, ..*segment };
        if segment.is_cone {
            // The one facet that such a ray meets says how much it reflects and how much passes it.
            let number = self.number(0, 1, direction, point.position);
            for lobe in lobes.iter_mut().flatten().filter(|lobe| lobe.is_clear) {
                lobe.share = lobe.weight(-direction.dot(lobe.facet(direction, number)));
            }
        }
        // Where a path goes on by one lobe alone, faint ones cost nothing.
        let least = if segment.is_cone { 0.0 } else { LEAST_SHARE };
        let visible = |lobe: &Lobe| (throughput * lobe.share).max_element() > least;
        let total: f32 = lobes.iter().flatten().filter(|lobe| visible(lobe)).map(|lobe| lobe.share.max_element()).sum();
        // A ray that stands for a part of a lobe goes on by one lobe alone, chosen by its share.
        let number = || super::rough::turn(self.rough.seed ^ CHOICE, direction, point.position).x;
        let mut choice = segment.is_cone.then(|| number() * total);
        let mut sum = Vec3::ZERO;
        for lobe in lobes.iter().flatten().filter(|lobe| visible(lobe)) {
            let share = lobe.share.max_element();
            let mut throughput = throughput;
            if let Some(rest) = &mut choice {
                *rest -= share;
                if *rest >= 0.0 {
                    continue;
                }
                throughput *= total / share;
            }
            sum += self.push_lobe(&segment, throughput, encounter, lobe, material);
            if choice.is_some() {
                break;
            }
        }
        sum + throughput * scene.radiance_beside_lobes(material, point, &at, -direction, mirrored)
    }

    /// The lobes of a point: coat, reflection, what passes; and the share of its reflection that is not among them.
    fn lobes_of(
        &self,
        at: &LobesAt,
        material: &Material,
        lobes: &Lobes,
        encounter: &SurfaceInteraction,
        direction: Vec3,
    ) -> ([Option<Lobe>; 3], f32) {
        let point = &encounter.point;
        let facing = Facing::new(direction, point.geometric_normal, at.normal);
        let eta = match material.has_inside() {
            true => relative_index(material.ior, facing.outside),
            false => 1.0 / material.ior,
        };
        let LobesAt { base, metallic, specular, specular_at_grazing: grazing, .. } = *at;
        let reflectance = Reflectance { specular, grazing, base, metallic, eta };
        let cosine = -direction.dot(facing.normal);
        let mut found = [None, None, None];
        let mut below = at.below_sheen(cosine.max(0.0));
        if at.coat > 0.0 && facing.outside {
            let facing = Facing::new(direction, point.geometric_normal, at.coat_normal);
            let (eta, at_normal) = (1.0 / COAT_IOR, fresnel_dielectric(1.0, 1.0 / COAT_IOR));
            let of_coat =
                Reflectance { specular: Vec3::splat(at_normal), grazing: 1.0, base: Vec3::ZERO, metallic: 0.0, eta };
            let share = at.coat * of_coat.of_dielectric(-direction.dot(facing.normal));
            below *= 1.0 - share.x;
            let factor = Vec3::splat(at.coat);
            let (kind, alpha, reflectance, is_clear) = (BounceKind::Reflect, at.coat_alpha, of_coat, false);
            found[0] = Some(Lobe { kind, facing, alpha, eta, is_thin: true, is_clear, reflectance, factor, share });
        }
        // Light that facets send to each other leaves the surface in the end (Turquin 2019).
        let roughness = at.alpha.sqrt();
        let surroundings = ReflectanceTable::get().reflected(roughness, cosine);
        let kept = (surroundings.at_normal + surroundings.at_grazing).clamp(0.05, 1.0);
        let missing = 1.0 / kept - 1.0;
        let [narrow, wide] = WIDE_ROUGHNESS;
        let of_dielectric = ((roughness - narrow) / (wide - narrow)).clamp(0.0, 1.0);
        let is_dielectric = (1.0 - 10.0 * metallic).max(0.0) * (1.0 - at.transmission);
        let mirrored = of_dielectric * is_dielectric;
        let reflected = reflectance.of_all(cosine);
        let is_clear = at.transmission > 0.0;
        let missing = if is_clear { 0.0 } else { missing };
        let compensation = Vec3::ONE + specular.lerp(base, metallic) * missing;
        let factor = compensation * (below * (1.0 - mirrored));
        let (kind, alpha, is_thin) = (BounceKind::Reflect, at.alpha, true);
        // Facets that lean away from the normal may reflect all where others let all pass, and the other way round.
        let leaning = if is_clear { 0.5 * alpha } else { 0.0 };
        let share = reflected.max(Vec3::splat(leaning)) * factor;
        found[1] = Some(Lobe { kind, facing, alpha, eta, is_thin, is_clear, reflectance, factor, share });
        let passes = (1.0 - metallic) * at.transmission * below;
        if passes > 0.0 {
            let factor = base * passes;
            let share = factor * (Vec3::ONE - reflectance.of_dielectric(cosine)).max(Vec3::splat(leaning));
            let (kind, is_thin) = (BounceKind::Transmit, lobes.is_thin);
            found[2] = Some(Lobe { kind, facing, alpha, eta, is_thin, is_clear, reflectance, factor, share });
        }
        (found, mirrored)
    }

    /// Adds the children of a path by a lobe; the light from infinity that it shows where nothing stands before it.
    fn push_lobe(
        &mut self,
        segment: &Segment,
        throughput: Vec3,
        encounter: &SurfaceInteraction,
        lobe: &Lobe,
        material: &Material,
    ) -> Vec3 {
        let incoming = segment.ray.direction;
        let Facing { outside, normal, .. } = lobe.facing;
        let absorption = match lobe.is_thin {
            true => segment.absorption,
            false => medium_after(lobe.kind, outside, material.absorption, segment.absorption, Vec3::ZERO),
        };
        let segment = &Segment { absorption, ..*segment };
        let is_straight = lobe.is_thin && lobe.kind == BounceKind::Transmit;
        let step = LightStep {
            facing: lobe.facing,
            eta: if is_straight { 1.0 } else { lobe.eta },
            reflectance: 0.0,
            reflected: Vec3::ZERO,
            transmitted: Vec3::ZERO,
            scattered: 0.0,
            attenuation: None,
        };
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
        // Its one facet has chosen already whether such a ray is reflected.
        let is_chosen = segment.is_cone && lobe.is_clear;
        if !is_chosen && (lobe.kind == BounceKind::Reflect || lobe.is_thin) {
            return self.push_gathered(segment, throughput, encounter, lobe, &step, [share, count as f32]);
        }
        let width = step.cone_width(lobe.kind, incoming, lobe.alpha) / (self.rough.count as f32).sqrt();
        for index in 0..count {
            let facet = lobe.facet(incoming, self.number(index, count, incoming, encounter.point.position));
            let Some(direction) = lobe.outgoing(incoming, facet) else { continue };
            let weight = lobe.weight(-incoming.dot(facet)) * lobe.unshadowed_share(incoming, direction);
            let step = LightStep { facing: step.facing.with_normal(facet), ..step };
            let change = change_of(&step).map(|change| change.widened(direction, width * self.rough.footprint_scale));
            let ray = Ray { origin: self.tracer.departure(&encounter.point, direction), direction };
            self.push_cone(segment, ray, change, throughput * weight, count);
        }
        Vec3::ZERO
    }

    /// The light from infinity over a lobe, as if nothing stood before it, and children of the path that tell what does:
    /// so there is no noise where nothing does.
    ///
    /// The lobe is divided into cones. Half of the children go to each of them alike, half where their light comes from:
    /// so none counts for more than twice its share of the lobe, nor of its light.
    fn push_gathered(
        &mut self,
        segment: &Segment,
        throughput: Vec3,
        encounter: &SurfaceInteraction,
        lobe: &Lobe,
        step: &LightStep,
        [share, count]: [f32; 2],
    ) -> Vec3 {
        let (incoming, normal, origin) = (segment.ray.direction, lobe.facing.normal, encounter.point.position);
        let RoughRays { part, parts, seed, footprint_scale, .. } = self.rough;
        let turn = super::rough::turn(seed ^ CHOICE, incoming, origin);
        // Many paths, each with its part of the cones, meet in what a lobe shows.
        let (part, parts) = if segment.is_cone { ((turn.y * PARTS as f32) as u32, PARTS) } else { (part, parts) };
        let least = if segment.is_cone { LEAST_CONES / 2 } else { LEAST_CONES };
        let cone_count = ((MOST_CONES as f32 * share.sqrt()) as u32 / parts).max(least).min(MOST_CONES);
        let cosine = -incoming.dot(normal);
        let width_of = |facet: Vec3, count: u32| extent_of_sample(lobe.alpha, facet.dot(normal), cosine, count).sqrt();
        let mut cones = [GatheredCone::default(); MOST_CONES as usize];
        let cones = &mut cones[..cone_count as usize];
        let (mut light, mut brightness, mut shown) = (Vec3::ZERO, 0.0, 0.0f32);
        for (index, cone) in (0..).zip(&mut *cones) {
            cone.number = random::hammersley(index * parts + part, cone_count * parts);
            let facet = lobe.facet(incoming, cone.number);
            let Some(direction) = lobe.outgoing(incoming, facet) else { continue };
            cone.weight = lobe.weight(-incoming.dot(facet)) * lobe.unshadowed_share(incoming, direction);
            let width = OVERLAP * width_of(facet, cone_count * parts);
            let change = RayDifferential::default().widened(direction, width);
            let ray = Ray { origin, direction };
            cone.light = cone.weight * self.field.radiance_of_cone(self.scene, &ray, &change);
            light += cone.light;
            brightness += cone.light.element_sum();
            shown += cone.weight.element_sum();
        }
        // Cones in their order, each as long as it is likely, and as many marks at equal distances along them.
        let (mut passed, mut next) = (0.0, turn.x);
        let per_cone = 1.0 / cone_count as f32;
        for (index, cone) in (0..).zip(&*cones) {
            let [of_lobe, of_light] = [(cone.weight, shown), (cone.light, brightness)]
                .map(|(part, all)| if all > 0.0 { part.element_sum() / all } else { 0.0 });
            let likely = if brightness > 0.0 { 0.5 * (of_lobe + of_light) } else { of_lobe };
            passed += likely * count;
            let marks = (passed - next).ceil().max(0.0);
            if marks == 0.0 || likely == 0.0 {
                continue;
            }
            next += marks;
            // Somewhere in the cone's part of the lobe.
            let within = super::rough::turn(seed ^ index, incoming, origin);
            let number = (cone.number + (within - 0.5) / (cone_count as f32).sqrt()).rem_euclid(Vec2::ONE);
            let leaving = |number: Vec2| {
                let facet = lobe.facet(incoming, number);
                lobe.outgoing(incoming, facet).map(|direction| (facet, direction))
            };
            let Some((facet, direction)) = leaving(number).or_else(|| leaving(cone.number)) else { continue };
            let scale = throughput * (marks * per_cone / (likely * count));
            let counted = Some(cone.light * scale);
            let weight = lobe.weight(-incoming.dot(facet)) * lobe.unshadowed_share(incoming, direction);
            let step = LightStep { facing: step.facing.with_normal(facet), ..*step };
            let width = width_of(facet, self.rough.count) * footprint_scale;
            let change = segment.change.as_ref().map(|change| {
                step.outgoing_change(lobe.kind, incoming, change, encounter).widened(direction, width)
            });
            let ray = Ray { origin: self.tracer.departure(&encounter.point, direction), direction };
            self.push_cone(&Segment { counted, ..*segment }, ray, change, weight * scale, 1);
        }
        throughput * light * per_cone
    }

    /// The numbers that choose a facet for one of so many rays.
    fn number(&self, index: u32, count: u32, incoming: Vec3, at: Vec3) -> Vec2 {
        (random::hammersley(index, count) + super::rough::turn(self.rough.seed, incoming, at)).fract()
    }
}
