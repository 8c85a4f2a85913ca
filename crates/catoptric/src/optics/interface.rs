//! What happens to light at a point of a reflector or lens: the one place where it is decided, for the reference and
//! for every method that follows its paths.

use super::{fresnel_dielectric, fresnel_schlick, reflect, refract};
use crate::scene::shade::SurfacePoint;
use crate::scene::{Attenuation, Material, Role, Scene};
use glam::{Vec3, Vec4Swizzles};

/// How a new direction is kept on the side of the flat surface where it belongs: the sine of the least angle to it.
const LEAST_SINE: f32 = 1e-3;

/// Which side of a surface is seen, and its normals on that side.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Facing {
    /// The outer side is seen.
    pub outside: bool,
    /// The flat surface's unit normal on the side that is seen.
    pub geometric: Vec3,
    /// The unit shading normal on the side that is seen; the view at least grazes it.
    pub normal: Vec3,
}

impl Facing {
    /// How a point is seen by a ray of this unit direction.
    #[inline]
    pub fn of(direction: Vec3, point: &SurfacePoint) -> Self {
        let outside = direction.dot(point.geometric_normal) <= 0.0;
        let sign = if outside { 1.0 } else { -1.0 };
        let (geometric, mut normal) = (point.geometric_normal * sign, point.normal * sign);
        // A shading normal that turns away from the viewer is bent back until the view just grazes it.
        let cosine = direction.dot(normal);
        if cosine > -LEAST_SINE {
            normal = (normal - direction * (cosine + LEAST_SINE)).try_normalize().unwrap_or(geometric);
        }
        Self { outside, geometric, normal }
    }

    /// What turns outer normals to the side that is seen.
    #[inline]
    pub fn sign(&self) -> f32 {
        if self.outside { 1.0 } else { -1.0 }
    }

    /// The direction of the reflected ray; it points to the side that is seen.
    #[inline]
    pub fn reflected(&self, direction: Vec3) -> Vec3 {
        keep_on_side(reflect(direction, self.normal), self.geometric)
    }

    /// The direction of the refracted ray, which points to the other side, or none on total internal reflection.
    ///
    /// `eta` is the index of refraction of the side that is seen over that of the other.
    #[inline]
    pub fn refracted(&self, direction: Vec3, eta: f32) -> Option<Vec3> {
        Some(keep_on_side(refract(direction, self.normal, eta)?, -self.geometric))
    }
}

/// A direction that points to the side of `normal`: one that shading normals bent below the flat surface is laid along it.
#[inline]
fn keep_on_side(direction: Vec3, normal: Vec3) -> Vec3 {
    let sine = direction.dot(normal);
    if sine >= LEAST_SINE {
        return direction;
    }
    (direction + normal * (LEAST_SINE - sine)).try_normalize().unwrap_or(normal)
}

/// Where light goes at a point of a surface, and how much.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Interface {
    /// Which side is seen.
    pub facing: Facing,
    /// Index of refraction of the side that is seen over that of the other; 1 where nothing is refracted.
    pub eta: f32,
    /// The share of light that is reflected, before any tint and any attenuation.
    pub reflectance: f32,
    /// What reflected light is multiplied with, before any attenuation.
    pub reflected: Vec3,
    /// What refracted light is multiplied with.
    pub transmitted: Vec3,
    /// What the surface's own scattered light is multiplied with; with an attenuation, where nothing is reflected.
    pub scattered: f32,
    /// How the reflection fades with distance: then [`Deferred`] light is settled at the next surface.
    pub attenuation: Option<Attenuation>,
}

/// Light of a mirror whose share depends on how far away what it reflects is, which is known only when that is met.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Deferred {
    own: Vec3,
    reflectance: f32,
    attenuation: Attenuation,
}

impl Deferred {
    /// When the next surface is met at this distance from the mirror (infinite: none is): the mirror's own light, and
    /// what light from there is multiplied with.
    #[inline]
    pub fn settled(&self, distance: f32) -> (Vec3, f32) {
        let weight = self.attenuation.weight(distance);
        (self.own * (1.0 - self.reflectance * weight), weight)
    }
}

impl Interface {
    /// What happens at a point that is met in this unit direction.
    #[inline(always)]
    pub fn of(scene: &Scene, material: &Material, point: &SurfacePoint, direction: Vec3) -> Self {
        let facing = Facing::of(direction, point);
        let cosine = -direction.dot(facing.normal);
        let mut found = Self {
            facing,
            eta: 1.0,
            reflectance: 0.0,
            reflected: Vec3::ZERO,
            transmitted: Vec3::ZERO,
            scattered: 0.0,
            attenuation: None,
        };
        match material.role {
            Role::Diffuse => found.scattered = 1.0,
            Role::Reflector => {
                let blind = facing.outside && scene.objects[point.object as usize].inside;
                if !blind {
                    let base = scene.base_color(material, point).xyz();
                    found.reflected = mirror_tint(material, base, cosine);
                    found.reflectance = 1.0;
                    if let Some(blend) = &material.blend {
                        found.reflectance = blend.weight_at(cosine);
                        found.reflected *= found.reflectance;
                        found.attenuation = blend.attenuation;
                        let faintest = blend.attenuation.map_or(1.0, |attenuation| attenuation.weight(f32::INFINITY));
                        found.scattered = 1.0 - found.reflectance * faintest;
                    }
                }
            }
            Role::Coated => {
                found.reflectance = material.coat * fresnel_dielectric(cosine, 1.0 / material.ior);
                found.reflected = Vec3::splat(found.reflectance);
                found.scattered = 1.0 - found.reflectance;
            }
            Role::Lens => {
                found.eta = if facing.outside { 1.0 / material.ior } else { material.ior };
                found.reflectance = fresnel_dielectric(cosine, found.eta);
                found.reflected = Vec3::splat(found.reflectance);
                if found.reflectance < 1.0 {
                    found.transmitted = scene.base_color(material, point).xyz() * (1.0 - found.reflectance);
                }
            }
        }
        found
    }

    /// Whether a path that does not branch goes on by reflection: by the larger Fresnel coefficient (Hakura, Snyder 2001, section 3),
    /// or because nothing is refracted.
    #[inline]
    pub fn prefers_reflection(&self) -> bool {
        self.reflectance > 0.5 || self.transmitted == Vec3::ZERO
    }

    /// What waits for the next surface, given the light that the surface scatters itself (before its share is taken).
    #[inline]
    pub fn deferred(&self, own: Vec3) -> Option<Deferred> {
        let attenuation = self.attenuation?;
        Some(Deferred { own, reflectance: self.reflectance, attenuation })
    }
}

/// What colours a mirror's reflection: a ramp of weights by the angle takes the place of Schlick's.
#[inline(always)]
pub(crate) fn mirror_tint(material: &Material, base: Vec3, cosine: f32) -> Vec3 {
    let ramp = material.blend.is_some_and(|blend| blend.fresnel.is_some());
    if material.schlick && !ramp { fresnel_schlick(base, cosine) } else { base }
}
