//! The lobes of a point of a surface, and facets of one of them.

use crate::optics::path::bundle::BounceKind;
use crate::optics::step::{Facing, LightStep, fresnel_dielectric, reflect, refract, relative_index};
use catoptric_core::scene::microfacets::{
    ReflectanceTable, VisibleFacets, disc_point, extent_of_sample, extent_of_stretched_sample, unshadowed_share,
    unshadowed_share_stretched,
};
use catoptric_core::scene::shade::SurfacePoint;
use catoptric_core::scene::{FilmReflectance, Lamp, Lobes, LobesAt, Material};
use glam::{Vec2, Vec3};
use std::f32::consts::{FRAC_1_SQRT_2, PI};

/// The index of refraction of coats (KHR_materials_clearcoat).
const COAT_IOR: f32 = 1.5;

/// Reflections of dielectrics from the first perceptual roughness on become those of the environment alone, which all
/// of them are from the second one on: lobes as wide as half of the sky that carry a twentieth of the light.
const WIDE_ROUGHNESS: [f32; 2] = [0.5, 0.75];

/// One lobe of a surface, in the direction of a path.
#[derive(Clone)]
pub(super) struct Lobe<'f> {
    pub(super) kind: BounceKind,
    /// The side of arrival, with the lobe's own normal.
    pub(super) facing: Facing,
    /// Width of the facets' distribution, the greater one where two differ.
    pub(super) alpha: f32,
    pub(super) stretch: Option<Stretch>,
    pub(super) eta: f32,
    /// A refracted ray goes straight on, as through a wall without thickness; the medium stays the same.
    pub(super) is_thin: bool,
    /// The surface lets light pass: a ray that meets several facets leaves it on one side or the other, and no light is
    /// lost.
    pub(super) is_clear: bool,
    pub(super) reflectance: Reflectance<'f>,
    /// The factor on what the reflectance leaves, of refracted light, or on it, of reflected light.
    pub(super) factor: Vec3,
    /// The share of light that goes this way, at the normal's angle.
    pub(super) share: Vec3,
}

/// Facets whose slopes differ along two directions.
#[derive(Clone, Copy)]
pub(super) struct Stretch {
    /// Unit directions at right angles to each other and to the normal.
    axes: [Vec3; 2],
    alpha: Vec2,
}

/// Reflectance by the angle: of a dielectric, of metal, or of a mixture.
#[derive(Clone, Copy)]
pub(super) struct Reflectance<'f> {
    /// The dielectric's at normal incidence, and at grazing angles.
    specular: Vec3,
    grazing: f32,
    /// The base colour, and how much of the surface is metal.
    base: Vec3,
    metallic: f32,
    eta: f32,
    /// Two such surfaces reflect.
    is_plate: bool,
    /// Under a thin film: of the dielectric, and of the metal.
    films: Option<&'f [FilmReflectance; 2]>,
}

impl Reflectance<'_> {
    /// The dielectric's share, by the cosine of the angle of incidence.
    #[inline]
    fn of_dielectric(&self, cosine: f32) -> Vec3 {
        let at_normal = fresnel_dielectric(1.0, self.eta);
        // Fresnel's own curve, between the two ends that the material names.
        let rise = (fresnel_dielectric(cosine, self.eta) - at_normal) / (1.0 - at_normal).max(1e-6);
        let bare = self.specular + (Vec3::splat(self.grazing) - self.specular) * rise;
        if self.is_plate {
            return 2.0 * bare / (Vec3::ONE + bare);
        }
        self.films.map_or(bare, |[film, _]| film.over(bare, cosine))
    }

    /// The share of light that enters the dielectric.
    #[inline]
    fn entering(&self, cosine: f32) -> Vec3 {
        let reflected = self.of_dielectric(cosine);
        // Light of one colour that a film sends back is not made up for by another colour.
        let reflected = if self.films.is_some() { Vec3::splat(reflected.max_element()) } else { reflected };
        Vec3::ONE - reflected
    }

    #[inline]
    fn of_all(&self, cosine: f32) -> Vec3 {
        let dielectric = self.of_dielectric(cosine);
        if self.metallic == 0.0 {
            return dielectric;
        }
        let rise = (1.0 - cosine.clamp(0.0, 1.0)).powi(5);
        let bare = self.base + (Vec3::ONE - self.base) * rise;
        dielectric.lerp(self.films.map_or(bare, |[_, film]| film.over(bare, cosine)), self.metallic)
    }
}

impl Lobe<'_> {
    /// The factor of light by a facet that is met at this cosine.
    #[inline]
    pub(super) fn weight(&self, cosine: f32) -> Vec3 {
        self.factor
            * match self.kind {
                BounceKind::Reflect => self.reflectance.of_all(cosine),
                BounceKind::Transmit => self.reflectance.entering(cosine),
            }
    }

    /// Returns true if all that it shows follows from its normal, its width, and its reflectance at one angle.
    pub(super) fn is_plain(&self) -> bool {
        self.kind == BounceKind::Reflect && self.stretch.is_none() && self.reflectance.films.is_none()
    }

    /// The facet that two numbers choose, of those that a ray meets.
    #[inline]
    pub(super) fn facet(&self, incoming: Vec3, number: Vec2) -> Vec3 {
        self.facets(incoming).facet(disc_point(number))
    }

    /// The facets that a ray meets.
    pub(super) fn facets(&self, incoming: Vec3) -> MetFacets {
        let axes = self.axes();
        let towards_viewer = -Vec3::from(axes.map(|axis| incoming.dot(axis)));
        MetFacets { axes, visible: VisibleFacets::stretched(self.widths(), towards_viewer) }
    }

    /// Unit directions along the two widths of facets, and the normal.
    pub(super) fn axes(&self) -> [Vec3; 3] {
        let normal = self.facing.normal;
        let (x, y) = self.stretch.map_or_else(|| normal.any_orthonormal_pair(), |Stretch { axes: [x, y], .. }| (x, y));
        [x, y, normal]
    }

    /// Returns true if light from infinity arrives over the lobe: none does within a body.
    pub(super) fn sees_sky(&self, material: &Material) -> bool {
        let is_within = material.has_inside() && !self.facing.outside;
        !is_within && (self.kind == BounceKind::Reflect || self.is_thin)
    }

    /// The widths of facets along the first two of the [`Self::axes`].
    pub(super) fn widths(&self) -> Vec2 {
        self.stretch.map_or(Vec2::splat(self.alpha), |stretch| stretch.alpha)
    }

    /// The step of light whose directions are those of the lobe's middle, and whose light the lobe tells.
    pub(super) fn light_step(&self) -> LightStep {
        let is_straight = self.is_thin && self.kind == BounceKind::Transmit;
        LightStep {
            facing: self.facing,
            eta: if is_straight { 1.0 } else { self.eta },
            reflectance: 0.0,
            reflected: Vec3::ZERO,
            transmitted: Vec3::ZERO,
            scattered: 0.0,
            attenuation: None,
        }
    }

    /// The angle across the part of a reflected lobe that one of so many facets stands for.
    #[inline]
    pub(super) fn width_of_part(&self, incoming: Vec3, facet: Vec3, count: u32) -> f32 {
        let (normal, cosine) = (self.facing.normal, -incoming.dot(self.facing.normal));
        let extent = match &self.stretch {
            Some(Stretch { axes: [x, y], alpha }) => {
                let facet = Vec3::new(facet.dot(*x), facet.dot(*y), facet.dot(normal));
                extent_of_stretched_sample(*alpha, facet, cosine, count)
            }
            None => extent_of_sample(self.alpha, facet.dot(normal), cosine, count),
        };
        extent.sqrt()
    }

    /// The density of the directions that the facets a ray meets send it to, about one of them, a solid angle.
    #[inline]
    pub(super) fn density(&self, incoming: Vec3, facet: Vec3) -> f32 {
        let density = self.unmasked_share(incoming) / self.width_of_part(incoming, facet, 1).powi(2);
        // Along the surface nothing is known.
        if density.is_finite() { density } else { 0.0 }
    }

    /// The share of facets that are not masked for a ray (Smith's), which the extent of a part leaves out.
    #[inline]
    fn unmasked_share(&self, incoming: Vec3) -> f32 {
        let normal = self.facing.normal;
        let slope = match &self.stretch {
            Some(Stretch { axes: [x, y], alpha }) => {
                Vec3::new(alpha.x * incoming.dot(*x), alpha.y * incoming.dot(*y), incoming.dot(normal)).length()
            }
            None => {
                let (cosine2, alpha2) = (incoming.dot(normal).powi(2), self.alpha * self.alpha);
                (alpha2 + (1.0 - alpha2) * cosine2).sqrt()
            }
        };
        let cosine = -incoming.dot(normal);
        2.0 * cosine / (cosine + slope)
    }

    /// Sets [`Self::density`] about the directions to lamps; 0 where no facet sends a ray there.
    pub(super) fn densities(&self, incoming: Vec3, lamps: &[Lamp], densities: &mut [f32]) {
        if self.stretch.is_some() {
            for (density, lamp) in densities.iter_mut().zip(lamps) {
                let facet = self.facet_towards(incoming, lamp.towards);
                *density = facet.map_or(0.0, |facet| self.density(incoming, facet));
            }
            return;
        }
        // By cosines alone, for the vectoriser: a facet's is that of half way between viewer and light.
        let side = if self.kind == BounceKind::Transmit { -1.0 } else { 1.0 };
        let (normal, cosine) = (self.facing.normal, -incoming.dot(self.facing.normal));
        // Seen from the side of arrival.
        let from = if side < 0.0 { incoming + normal * (2.0 * cosine) } else { incoming };
        let unmasked = self.unmasked_share(incoming);
        for (density, lamp) in densities.iter_mut().zip(lamps) {
            let towards = lamp.towards;
            let height = (normal.x * towards.x + normal.y * towards.y + normal.z * towards.z) * side;
            let along = from.x * towards.x + from.y * towards.y + from.z * towards.z;
            let half2 = 2.0 * (1.0 - along);
            let n_h2 = (height + cosine) * (height + cosine) / if half2 > 1e-12 { half2 } else { 1e-12 };
            let spread = 1.0 - n_h2 * (1.0 - self.alpha * self.alpha);
            let of_facets = self.alpha * self.alpha / (PI * spread * spread) / (4.0 * cosine);
            let found = unmasked * of_facets;
            *density = if (height > 0.0) & (found < f32::INFINITY) { found } else { 0.0 };
        }
    }

    /// The facet that sends light from a direction to where a ray comes from, if any does.
    pub(super) fn facet_towards(&self, incoming: Vec3, towards: Vec3) -> Option<Vec3> {
        let Facing { geometric, normal, .. } = self.facing;
        let side = if self.kind == BounceKind::Transmit { -1.0 } else { 1.0 };
        let [height, depth] = [normal, geometric].map(|normal| towards.dot(normal) * side);
        if height <= 0.0 || depth <= 0.0 {
            return None;
        }
        let mirrored = if side < 0.0 { towards - normal * (2.0 * towards.dot(normal)) } else { towards };
        (mirrored - incoming).try_normalize()
    }

    /// The share of a facet's light that is not shadowed by others.
    #[inline]
    pub(super) fn unshadowed_share(&self, incoming: Vec3, direction: Vec3) -> f32 {
        if self.is_clear {
            return 1.0;
        }
        let normal = self.facing.normal;
        if let Some(Stretch { axes: [x, y], alpha }) = &self.stretch {
            let [light, viewer] = [direction, -incoming].map(|to| Vec3::new(to.dot(*x), to.dot(*y), to.dot(normal)));
            return unshadowed_share_stretched(*alpha, light, viewer);
        }
        unshadowed_share(self.alpha, direction.dot(normal), -incoming.dot(normal))
    }

    /// The direction after an event at a facet, on the side where it belongs.
    #[inline]
    pub(super) fn outgoing(&self, incoming: Vec3, facet: Vec3) -> Option<Vec3> {
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

/// The facets of a lobe that a ray meets.
pub(super) struct MetFacets {
    axes: [Vec3; 3],
    visible: VisibleFacets,
}

impl MetFacets {
    /// The one that belongs to a point of the unit disc.
    #[inline(always)]
    pub(super) fn facet(&self, disc: Vec2) -> Vec3 {
        let [x, y, normal] = self.axes;
        let facet = self.visible.facet(disc);
        x * facet.x + y * facet.y + normal * facet.z
    }
}

/// A material at a point, with all that its lobes depend on.
pub(super) struct SurfaceLobes<'s> {
    pub(super) at: &'s LobesAt,
    pub(super) material: &'s Material,
    pub(super) lobes: &'s Lobes,
    pub(super) films: Option<&'s [FilmReflectance; 2]>,
    /// The primary colour of the path's light, if it has only one.
    pub(super) color: Option<u8>,
    /// Index of refraction before the surface over that behind it, over what that would be in vacuum.
    pub(super) eta_factor: f32,
}

impl<'s> SurfaceLobes<'s> {
    /// The index of refraction for a primary colour, or for all (KHR_materials_dispersion).
    fn ior(&self, color: Option<u8>) -> f32 {
        let ior = self.material.ior;
        let half_spread = (ior - 1.0) * 0.025 * self.lobes.dispersion;
        match color {
            Some(0) => (ior - half_spread).max(1.0),
            Some(2) => ior + half_spread,
            _ => ior,
        }
    }

    /// The index of what is in front of the surface over that of what is behind it.
    fn eta(&self, outside: bool, color: Option<u8>) -> f32 {
        let ior = self.ior(color);
        if self.material.has_inside() { relative_index(ior, outside) * self.eta_factor } else { 1.0 / ior }
    }

    /// The dielectric's reflectance at normal incidence by what lies about it, from that in vacuum.
    fn specular_within(&self, specular: Vec3, grazing: f32, outside: bool) -> Vec3 {
        if self.eta_factor == 1.0 {
            return specular;
        }
        let in_vacuum = fresnel_dielectric(1.0, relative_index(self.material.ior, outside));
        let factor = fresnel_dielectric(1.0, self.eta(outside, None)) / in_vacuum.max(1e-6);
        (specular * factor).min(Vec3::splat(grazing))
    }

    /// Coat, reflection, and what passes, for a ray's direction; and the share of the reflection that is not among
    /// them.
    pub(super) fn met(&self, point: &SurfacePoint, direction: Vec3) -> ([Option<Lobe<'s>>; 3], f32) {
        let at = self.at;
        let facing = Facing::new(direction, point.geometric_normal, at.normal);
        let eta = self.eta(facing.outside, self.color);
        let LobesAt { base, metallic, specular, specular_at_grazing: grazing, .. } = *at;
        let specular = self.specular_within(specular, grazing, facing.outside);
        let is_plate = self.lobes.is_plate;
        let reflectance = Reflectance { specular, grazing, base, metallic, eta, is_plate, films: self.films };
        let cosine = -direction.dot(facing.normal);
        let mut below = at.below_sheen(cosine.max(0.0));
        let coat = (at.coat > 0.0 && facing.outside).then(|| coat(at, point, direction));
        if let Some(coat) = &coat {
            below *= 1.0 - coat.share.x;
        }
        let (alpha, stretch) = widths(at, facing.normal);
        // Light that facets send to each other leaves the surface in the end (Turquin 2019): as much as of facets that
        // are as steep in the mean square.
        let roughness = stretch.map_or(alpha, |stretch| stretch.alpha.length() * FRAC_1_SQRT_2).sqrt();
        let surroundings = ReflectanceTable::get().reflected(roughness, cosine);
        let kept = (surroundings.at_normal + surroundings.at_grazing).clamp(0.05, 1.0);
        let [narrow, wide] = WIDE_ROUGHNESS;
        let of_dielectric = ((roughness - narrow) / (wide - narrow)).clamp(0.0, 1.0);
        let is_dielectric = (1.0 - 10.0 * metallic).max(0.0) * (1.0 - at.transmission);
        let mirrored = of_dielectric * is_dielectric;
        let is_clear = at.transmission > 0.0;
        let missing = if is_clear { 0.0 } else { 1.0 / kept - 1.0 };
        let compensation = Vec3::ONE + specular.lerp(base, metallic) * missing;
        let factor = compensation * (below * (1.0 - mirrored));
        // Facets that lean away from the normal may reflect all where others let all pass, and the other way round.
        let leaning = if is_clear { 0.5 * alpha } else { 0.0 };
        let share = reflectance.of_all(cosine).max(Vec3::splat(leaning)) * factor;
        let (kind, is_thin) = (BounceKind::Reflect, true);
        let reflected = Lobe { kind, facing, alpha, stretch, eta, is_thin, is_clear, reflectance, factor, share };
        let passes = (1.0 - metallic) * at.transmission * below;
        let passing = (passes > 0.0).then(|| {
            let factor = base * passes;
            let share = factor * reflectance.entering(cosine).max(Vec3::splat(leaning));
            let (kind, is_thin) = (BounceKind::Transmit, self.lobes.is_thin);
            Lobe { kind, is_thin, factor, share, ..reflected.clone() }
        });
        ([coat, Some(reflected), passing], mirrored)
    }

    /// A lobe as it is, or, where light of all colours enters a body that bends them differently, one for each of the
    /// three primaries; where a path goes on by one of them alone, by `number` between 0 and 1. With each the path's
    /// colour, and the factor on its light.
    pub(super) fn parts_by_color(
        &self,
        lobe: &Lobe<'s>,
        number: Option<f32>,
    ) -> [Option<(Lobe<'s>, Option<u8>, Vec3)>; 3] {
        let disperses = self.lobes.dispersion > 0.0 && lobe.kind == BounceKind::Transmit && !lobe.is_thin;
        if !disperses || self.color.is_some() {
            return [Some((lobe.clone(), self.color, Vec3::ONE)), None, None];
        }
        let chosen = number.map(|number| ((number * 3.0) as u8).min(2));
        std::array::from_fn(|index| {
            let color = index as u8;
            if chosen.is_some_and(|chosen| chosen != color) {
                return None;
            }
            let eta = self.eta(lobe.facing.outside, Some(color));
            let reflectance = Reflectance { eta, ..lobe.reflectance };
            let factor = Vec3::AXES[index] * if chosen.is_some() { 3.0 } else { 1.0 };
            Some((Lobe { eta, reflectance, ..lobe.clone() }, Some(color), factor))
        })
    }
}

/// The lobe of a coat, for a ray that meets it from outside.
fn coat<'s>(at: &LobesAt, point: &SurfacePoint, direction: Vec3) -> Lobe<'s> {
    let facing = Facing::new(direction, point.geometric_normal, at.coat_normal);
    let (eta, at_normal) = (1.0 / COAT_IOR, fresnel_dielectric(1.0, 1.0 / COAT_IOR));
    let specular = Vec3::splat(at_normal);
    let (base, metallic) = (Vec3::ZERO, 0.0);
    let reflectance = Reflectance { specular, grazing: 1.0, base, metallic, eta, is_plate: false, films: None };
    let share = at.coat * reflectance.of_dielectric(-direction.dot(facing.normal));
    let factor = Vec3::splat(at.coat);
    let (kind, alpha) = (BounceKind::Reflect, at.coat_alpha);
    Lobe { kind, facing, alpha, stretch: None, eta, is_thin: true, is_clear: false, reflectance, factor, share }
}

/// The greater width of facets, and both where they differ.
fn widths(at: &LobesAt, normal: Vec3) -> (f32, Option<Stretch>) {
    let stretch = at.stretch.and_then(|(along, wide)| {
        let along = along.reject_from_normalized(normal).try_normalize()?;
        Some(Stretch { axes: [along, normal.cross(along)], alpha: Vec2::new(wide, at.alpha.max(1e-3)) })
    });
    (stretch.map_or(at.alpha, |stretch| stretch.alpha.max_element()), stretch)
}
