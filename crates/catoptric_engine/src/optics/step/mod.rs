//! The light step: directions, weights and media of light at one point of a reflector or lens. All walkers along
//! specular paths take them from here.
//!
//! Records are plain and bodies scalar, so that a shader can mirror them line by line; [`LightStep::at`] alone reads a
//! scene. [`Facing`] turns the normals to the side of arrival, [`LightStep`] divides light among reflection, refraction
//! and the surface's own scattering, [`crossed_medium`] and [`medium_after`] keep account of the medium along a path.

use super::path::bundle::BounceKind;
use catoptric_core::math::portable::PortableMath;
use catoptric_core::scene::microfacets::ReflectanceTable;
use catoptric_core::scene::shade::{SurfaceInteraction, SurfacePoint};
use catoptric_core::scene::{Attenuation, Material, RayDifferential, Role, Scene};
use glam::{Vec3, Vec4Swizzles};
use std::f32::consts::SQRT_2;

/// Sine of the least angle between a new direction and the flat surface.
const MIN_SINE: f32 = 1e-3;

/// The mirror direction of `incoming` about `normal` (both unit length; the sign of the normal does not matter).
#[inline(always)] // for the instructions of its caller
pub fn reflect(incoming: Vec3, normal: Vec3) -> Vec3 {
    incoming - normal * (2.0 * incoming.dot(normal))
}

/// The refracted direction by Snell's law; returns `None` on total internal reflection.
///
/// `incoming` and `normal` are unit vectors, the normal on the side the ray comes from (`incoming . normal < 0`);
/// `eta` is the index of refraction of the side the ray comes from over that of the side it goes to.
#[inline]
pub fn refract(incoming: Vec3, normal: Vec3, eta: f32) -> Option<Vec3> {
    refract_unscaled(incoming, normal, eta).map(Vec3::normalize)
}

/// [`refract`] of unit length but for rounding.
#[inline]
pub fn refract_unscaled(incoming: Vec3, normal: Vec3, eta: f32) -> Option<Vec3> {
    let cos_in = -incoming.dot(normal);
    let sin2_out = eta * eta * (1.0 - cos_in * cos_in).max(0.0);
    if sin2_out >= 1.0 {
        return None;
    }
    let cos_out = (1.0 - sin2_out).sqrt();
    Some(incoming * eta + normal * (eta * cos_in - cos_out))
}

/// The change of the mirror direction (Igehy 1999, equation 14).
///
/// `incoming` and `normal` are unit vectors, the changes are per pixel; the sign of the normal does not matter if its
/// change has the same.
#[inline]
pub fn reflected_change(incoming: Vec3, incoming_change: Vec3, normal: Vec3, normal_change: Vec3) -> Vec3 {
    let cosine_change = incoming_change.dot(normal) + incoming.dot(normal_change);
    incoming_change - (normal_change * incoming.dot(normal) + normal * cosine_change) * 2.0
}

/// The change of the refracted direction (Igehy 1999, equations 15 to 18).
///
/// The normal is on the side the ray comes from, `eta` as in [`refract`].
#[inline]
pub fn refracted_change(incoming: Vec3, incoming_change: Vec3, normal: Vec3, normal_change: Vec3, eta: f32) -> Vec3 {
    let cos_in = -incoming.dot(normal);
    // Near the critical angle the change grows without bound; footprints that large blur to the mean all the same.
    let cos_out = (1.0 - eta * eta * (1.0 - cos_in * cos_in)).max(1e-4).sqrt();
    let cos_change = -(incoming_change.dot(normal) + incoming.dot(normal_change));
    let along_change = (eta - eta * eta * cos_in / cos_out) * cos_change;
    incoming_change * eta + normal_change * (eta * cos_in - cos_out) + normal * along_change
}

/// Index of refraction of the side of arrival over that of the other, at a surface whose inner side has index `ior`.
#[inline]
pub fn relative_index(ior: f32, outside: bool) -> f32 {
    if outside { 1.0 / ior } else { ior }
}

/// The share of unpolarised light that a smooth dielectric interface reflects (Fresnel's equations, exact).
///
/// `cos_in` is the cosine of the angle of incidence (0 to 1), `eta` as in [`refract`]. Total internal reflection gives
/// 1.
#[inline]
pub fn fresnel_dielectric(cos_in: f32, eta: f32) -> f32 {
    let cos_in = cos_in.clamp(0.0, 1.0);
    let sin2_out = eta * eta * (1.0 - cos_in * cos_in);
    if sin2_out >= 1.0 {
        return 1.0;
    }
    let cos_out = (1.0 - sin2_out).sqrt();
    let parallel = (cos_in - eta * cos_out) / (cos_in + eta * cos_out);
    let perpendicular = (eta * cos_in - cos_out) / (eta * cos_in + cos_out);
    if !(parallel.is_finite() && perpendicular.is_finite()) {
        return 1.0; // grazing incidence between equal media: the limit of the formula
    }
    (0.5 * (parallel * parallel + perpendicular * perpendicular)).clamp(0.0, 1.0)
}

/// Schlick's approximation of a conductor's reflectance from its colour at normal incidence (Schlick 1994).
#[inline]
pub fn fresnel_schlick(normal_reflectance: Vec3, cos_in: f32) -> Vec3 {
    let m = (1.0 - cos_in).clamp(0.0, 1.0);
    let m2 = m * m;
    normal_reflectance + (Vec3::ONE - normal_reflectance) * (m2 * m2 * m)
}

/// Beer-Lambert: the share of light that is left after `distance` in a medium of this absorption a unit of length.
#[inline]
pub fn transmittance(absorption: Vec3, distance: f32) -> Vec3 {
    if absorption == Vec3::ZERO {
        return Vec3::ONE;
    }
    let exponent = absorption * -distance.max(0.0);
    Vec3::new(exponent.x.exponential(), exponent.y.exponential(), exponent.z.exponential())
}

/// The medium that a ray has crossed on arrival at a surface: `own`, that inside the surface's lens, or `carried`, that
/// of the path so far. A medium is given by its absorption or by its index of refraction.
///
/// A ray that meets a lens from inside has crossed that lens, also if it started there or left another within.
#[inline]
pub fn crossed_medium<M>(is_lens: bool, outside: bool, own: M, carried: M) -> M {
    if is_lens && !outside { own } else { carried }
}

/// The medium that a ray runs through after an event at a surface; `own` and `crossed` as in [`crossed_medium`].
#[inline]
pub fn medium_after<M>(kind: BounceKind, outside: bool, own: M, crossed: M, vacuum: M) -> M {
    match kind {
        BounceKind::Reflect => crossed,
        BounceKind::Transmit if outside => own,
        BounceKind::Transmit => vacuum,
    }
}

/// A lobe that covers less than this share of a cone across is not seen beside it.
pub const HIDDEN_LOBE: f32 = 0.3;

/// The angle across a lobe of mirrored directions where it is half as bright as in its middle: the distribution falls
/// to a half at a tangent of 0.64 alpha, and mirrored directions turn twice as far.
pub fn lobe_width(alpha: f32) -> f32 {
    2.57 * alpha
}

/// The angle across a cone that stands for a lobe of mirrored directions: facets' slopes are about as wide as alpha to
/// each side, and mirrored directions turn twice as far.
#[inline]
pub fn cone_width(alpha: f32) -> f32 {
    2.0 * SQRT_2 * alpha
}

/// The light that a rough mirror reflects towards one side, as a cone.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct RoughLobe {
    /// The unit mean direction that light arrives from.
    pub direction: Vec3,
    /// The share of light that facets neither mask nor shadow.
    pub share: f32,
    /// The angle across the cone.
    pub width: f32,
}

impl RoughLobe {
    /// The cone of light that a mirror of such facets ([`Material::facets_alpha`]) reflects against a ray's
    /// direction; `None` for mirrors that reflect sharply.
    #[inline]
    pub fn of(alpha: f32, facing: &Facing, incoming: Vec3) -> Option<Self> {
        (alpha > 0.0).then(|| Self::of_rough(alpha, facing, incoming))
    }

    #[inline(never)] // rarely needed
    fn of_rough(alpha: f32, facing: &Facing, incoming: Vec3) -> Self {
        let lobe = ReflectanceTable::get().reflected(alpha.sqrt(), -incoming.dot(facing.normal));
        let mirrored = reflect(incoming, facing.normal);
        let direction = facing.normal.lerp(mirrored, lobe.tilt).try_normalize().unwrap_or(mirrored);
        let width = cone_width(alpha) * lobe.spread;
        Self { direction, share: lobe.at_normal + lobe.at_grazing, width }
    }
}

/// The side of a surface on which a ray arrives, and the normals on that side.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Facing {
    /// The ray arrives on the outer side.
    pub outside: bool,
    /// The flat surface's unit normal on the side of arrival.
    pub geometric: Vec3,
    /// The unit shading normal on the side of arrival, bent so that the ray at least grazes it.
    pub normal: Vec3,
}

impl Facing {
    /// The side of a surface with these outer unit normals on which a ray of this unit direction arrives.
    #[inline(always)] // for the instructions of its caller
    pub fn new(direction: Vec3, geometric_normal: Vec3, shading_normal: Vec3) -> Self {
        let outside = direction.dot(geometric_normal) <= 0.0;
        let sign = if outside { 1.0 } else { -1.0 };
        let (geometric, mut normal) = (geometric_normal * sign, shading_normal * sign);
        // A shading normal that turns away from the ray is bent back until the ray just grazes it.
        let cosine = direction.dot(normal);
        if cosine > -MIN_SINE {
            normal = (normal - direction * (cosine + MIN_SINE)).try_normalize().unwrap_or(geometric);
        }
        Self { outside, geometric, normal }
    }

    /// The same side with another unit normal on it.
    #[must_use]
    pub fn with_normal(&self, normal: Vec3) -> Self {
        Self { normal, ..*self }
    }

    /// The factor that turns outer normals to the side of arrival: 1 or -1.
    #[inline]
    pub fn sign(&self) -> f32 {
        if self.outside { 1.0 } else { -1.0 }
    }

    /// The unit direction after an event, on the side where it belongs; returns `None` on total internal reflection.
    ///
    /// `eta` as in [`refract`]; reflection does not use it.
    #[inline(always)] // for the instructions of its caller
    pub fn outgoing(&self, kind: BounceKind, incoming: Vec3, eta: f32) -> Option<Vec3> {
        match kind {
            BounceKind::Reflect => Some(keep_on_side(reflect(incoming, self.normal), self.geometric)),
            BounceKind::Transmit => Some(keep_on_side(refract(incoming, self.normal, eta)?, -self.geometric)),
        }
    }
}

/// The direction, or one along the flat surface in place of one that a shading normal bent to the other side of it.
#[inline(always)] // for the instructions of its caller
fn keep_on_side(direction: Vec3, normal: Vec3) -> Vec3 {
    let sine = direction.dot(normal);
    if sine >= MIN_SINE {
        return direction;
    }
    (direction + normal * (MIN_SINE - sine)).try_normalize().unwrap_or(normal)
}

/// Light at a point of a surface: where it goes, and how much.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct LightStep {
    /// The side of arrival.
    pub facing: Facing,
    /// Index of refraction of the side of arrival over that of the other; 1 if nothing is refracted.
    pub eta: f32,
    /// The share of light that is reflected, before any tint and any attenuation.
    pub reflectance: f32,
    /// The factor of reflected light, before any attenuation.
    pub reflected: Vec3,
    /// The factor of refracted light.
    pub transmitted: Vec3,
    /// The factor of the surface's own scattered light; with an attenuation, that where nothing is reflected.
    pub scattered: f32,
    /// The fading of the reflection with distance: [`Deferred`] light is then settled at the next surface.
    pub attenuation: Option<Attenuation>,
}

/// Light of a mirror whose share depends on the distance of the next surface along the reflected ray.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Deferred {
    own: Vec3,
    reflectance: f32,
    attenuation: Attenuation,
}

impl Deferred {
    /// The part of one of several rays that leave a mirror.
    #[must_use]
    pub fn shared_by(&self, count: u32) -> Self {
        Self { own: self.own / count as f32, ..*self }
    }

    /// The mirror's own light and the factor of light from the next surface, at this distance from the mirror (infinite
    /// if there is none).
    #[inline]
    pub fn settled(&self, distance: f32) -> (Vec3, f32) {
        let weight = self.attenuation.weight(distance);
        (self.own * (1.0 - self.reflectance * weight), weight)
    }
}

impl LightStep {
    /// The same at a facet of the surface, which has a normal of its own.
    #[inline(always)]
    #[must_use]
    pub fn at_facet(&self, normal: Vec3) -> Self {
        Self { facing: self.facing.with_normal(normal), ..*self }
    }

    /// The step at a point of a scene that a ray of this unit direction meets; the material is the point's. Normal maps
    /// turn nothing.
    #[inline(always)]
    pub fn at(scene: &Scene, material: &Material, point: &SurfacePoint, direction: Vec3) -> Self {
        Self::with_normal(scene, material, point, point.normal, direction)
    }

    /// The same with another unit normal on the outer side than the point's.
    #[inline(always)]
    pub fn with_normal(
        scene: &Scene,
        material: &Material,
        point: &SurfacePoint,
        normal: Vec3,
        direction: Vec3,
    ) -> Self {
        let facing = Facing::new(direction, point.geometric_normal, normal);
        let is_blind = facing.outside && scene.objects[point.object as usize].inside;
        let tint = match material.role {
            Role::Reflector | Role::Lens => scene.base_color(material, point).xyz(),
            Role::Coated => Vec3::splat(scene.coat(material, point)),
            Role::Diffuse => Vec3::ZERO,
        };
        Self::new(material, tint, is_blind, facing, direction)
    }

    /// The step at a surface of this material and tint (of coats: the share that they cover); a mirror `is_blind` on
    /// the back of its one side.
    #[inline(always)]
    pub fn new(material: &Material, tint: Vec3, is_blind: bool, facing: Facing, direction: Vec3) -> Self {
        let cosine = -direction.dot(facing.normal);
        let mut step = Self {
            facing,
            eta: 1.0,
            reflectance: 0.0,
            reflected: Vec3::ZERO,
            transmitted: Vec3::ZERO,
            scattered: 0.0,
            attenuation: None,
        };
        match material.role {
            Role::Diffuse => step.scattered = 1.0,
            Role::Reflector if is_blind => {}
            Role::Reflector => {
                // A ramp of weights by the angle takes the place of Schlick's.
                let ramp = material.blend.is_some_and(|blend| blend.fresnel.is_some());
                step.reflected = if material.schlick && !ramp { fresnel_schlick(tint, cosine) } else { tint };
                step.reflectance = 1.0;
                if let Some(blend) = &material.blend {
                    step.reflectance = blend.weight_at(cosine);
                    step.reflected *= step.reflectance;
                    step.attenuation = blend.attenuation;
                    let faintest = blend.attenuation.map_or(1.0, |attenuation| attenuation.weight(f32::INFINITY));
                    step.scattered = 1.0 - step.reflectance * faintest;
                }
            }
            Role::Coated => {
                step.reflectance = tint.x * fresnel_dielectric(cosine, 1.0 / material.ior);
                step.reflected = Vec3::splat(step.reflectance);
                step.scattered = 1.0 - step.reflectance;
            }
            Role::Lens => {
                step.eta = relative_index(material.ior, facing.outside);
                step.reflectance = fresnel_dielectric(cosine, step.eta);
                step.reflected = Vec3::splat(step.reflectance);
                if step.reflectance < 1.0 {
                    step.transmitted = tint * (1.0 - step.reflectance);
                }
            }
        }
        step
    }

    /// The same step at a lens about which there is another medium than vacuum: so many times its index of the side of
    /// arrival over that of the other.
    #[inline(always)]
    #[must_use]
    pub(crate) fn within(
        self,
        eta_factor: f32,
        material: &Material,
        tint: impl FnOnce() -> Vec3,
        direction: Vec3,
    ) -> Self {
        if eta_factor == 1.0 || material.role != Role::Lens {
            return self;
        }
        let eta = self.eta * eta_factor;
        let reflectance = fresnel_dielectric(-direction.dot(self.facing.normal), eta);
        let transmitted = if reflectance < 1.0 { tint() * (1.0 - reflectance) } else { Vec3::ZERO };
        Self { eta, reflectance, reflected: Vec3::splat(reflectance), transmitted, ..self }
    }

    /// True if a path that does not branch goes on by reflection: by the larger Fresnel coefficient (Hakura, Snyder
    /// 2001, section 3), or because nothing is refracted.
    #[inline]
    pub fn prefers_reflection(&self) -> bool {
        self.reflectance > 0.5 || self.transmitted == Vec3::ZERO
    }

    /// The factor of light that goes on by an event, before any attenuation.
    #[inline]
    pub fn weight(&self, kind: BounceKind) -> Vec3 {
        match kind {
            BounceKind::Reflect => self.reflected,
            BounceKind::Transmit => self.transmitted,
        }
    }

    /// The unit direction after an event; returns `None` on total internal reflection.
    #[inline(always)] // for the instructions of its caller
    pub fn outgoing(&self, kind: BounceKind, incoming: Vec3) -> Option<Vec3> {
        self.facing.outgoing(kind, incoming, self.eta)
    }

    /// The light from infinity by all events, as if nothing stood before it, against a ray's direction: by facets of
    /// this width.
    pub fn background(&self, scene: &Scene, incoming: Vec3, alpha: f32) -> Vec3 {
        let Some(environment) = &scene.environment else { return Vec3::ZERO };
        let by = |kind: BounceKind| match self.weight(kind) {
            Vec3::ZERO => Vec3::ZERO,
            weight => self.outgoing(kind, incoming).map_or(Vec3::ZERO, |to| weight * environment.glossy(to, alpha)),
        };
        by(BounceKind::Reflect) + by(BounceKind::Transmit)
    }

    /// The angle across a cone of light after an event, from bumps or facets whose slopes are so wide to each side, as
    /// [`cone_width`]; refracted directions turn less far than mirrored ones.
    pub fn cone_width(&self, kind: BounceKind, incoming: Vec3, alpha: f32) -> f32 {
        let turning = match kind {
            BounceKind::Reflect => 1.0,
            BounceKind::Transmit => {
                let cos_in = -incoming.dot(self.facing.normal);
                let cos_out = (1.0 - self.eta * self.eta * (1.0 - cos_in * cos_in)).max(0.0).sqrt();
                // The change of the angle of refraction with the normal's, from Snell's law; beyond, near the critical
                // angle, it grows without bound.
                (0.5 * (self.eta * cos_in / cos_out.max(1e-3) - 1.0).abs()).min(1.0)
            }
        };
        cone_width(alpha) * turning
    }

    /// The change a pixel of the ray after an event, from that of the ray that arrives in a unit direction.
    #[inline]
    pub fn outgoing_change(
        &self,
        kind: BounceKind,
        incoming: Vec3,
        change: &RayDifferential,
        at: &SurfaceInteraction,
    ) -> RayDifferential {
        let [origin_dx, origin_dy] = at.position_change;
        let [normal_dx, normal_dy] = at.normal_change;
        RayDifferential {
            origin_dx,
            origin_dy,
            direction_dx: self.direction_change(kind, incoming, change.direction_dx, normal_dx),
            direction_dy: self.direction_change(kind, incoming, change.direction_dy, normal_dy),
        }
    }

    #[inline]
    fn direction_change(&self, kind: BounceKind, incoming: Vec3, change: Vec3, outer_normal_change: Vec3) -> Vec3 {
        let normal_change = outer_normal_change * self.facing.sign();
        match kind {
            BounceKind::Reflect => reflected_change(incoming, change, self.facing.normal, normal_change),
            BounceKind::Transmit => refracted_change(incoming, change, self.facing.normal, normal_change, self.eta),
        }
    }

    /// The same by facets of a rough mirror with this unit normal on the side of arrival: the share of light that they
    /// reflect.
    pub fn reflected_by_facet(
        material: &Material,
        reflected: Vec3,
        normal: Vec3,
        facet: Vec3,
        direction: Vec3,
    ) -> Vec3 {
        let [at_normal, at_facet] = [normal, facet].map(|normal| -direction.dot(normal));
        match material.role {
            Role::Coated => {
                let of = |cosine: f32| fresnel_dielectric(cosine, 1.0 / material.ior);
                reflected * (of(at_facet) / of(at_normal).max(1e-6))
            }
            Role::Reflector if material.schlick => {
                // From what Schlick's formula gives at the mean normal back to normal incidence, and to the facet.
                let [mean, own] = [at_normal, at_facet].map(|cosine| fresnel_schlick(Vec3::ZERO, cosine).x);
                let at_incidence = (reflected - mean) / (1.0 - mean).max(1e-3);
                (at_incidence + (Vec3::ONE - at_incidence) * own).clamp(Vec3::ZERO, Vec3::ONE)
            }
            _ => reflected,
        }
    }

    /// The light that waits for the next surface, from the light that the surface scatters itself (before its share is
    /// taken); returns `None` without an attenuation.
    #[inline]
    pub fn deferred(&self, own: Vec3) -> Option<Deferred> {
        let attenuation = self.attenuation?;
        Some(Deferred { own, reflectance: self.reflectance, attenuation })
    }
}
