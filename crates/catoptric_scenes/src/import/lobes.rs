//! Roles and lobes of materials by their properties, the same for all kinds of files.

use catoptric_core::math::portable::PortableMath;
use catoptric_core::scene::{AlphaMode, Lobes, Material, Role};
use glam::Vec3;

/// Perceptual roughness up to which metal is a plain mirror, and glass is clear.
const MAX_SHARP_ROUGHNESS: f32 = 0.02;
/// Opaque dielectrics that are rougher all over reflect the environment alone, as wide as half of the sky.
const MAX_FOLLOWED_ROUGHNESS: f32 = 0.75;

/// Properties of a file's material beside its factors.
#[derive(Clone, Copy, Default)]
pub(super) struct Details {
    /// A texture of roughness or metalness.
    pub(super) has_facet_texture: bool,
    /// A texture of transmission.
    pub(super) has_transmission_texture: bool,
    /// A reflectance of dielectrics that is not that of the index of refraction.
    pub(super) has_specular: bool,
}

/// The absorption of a volume along a unit of length, from the colour that white light has after a distance.
pub(super) fn absorption(color: Vec3, distance: f32) -> Vec3 {
    if !(distance.is_finite() && distance > 0.0 && color.is_finite()) {
        return Vec3::ZERO;
    }
    // Black would absorb infinitely much; colours beyond reason would poison the picture.
    let absorption = -color.clamp(Vec3::splat(1e-6), Vec3::ONE).map(f32::logarithm) / distance;
    absorption.clamp(Vec3::ZERO, Vec3::splat(1e6))
}

/// Plain mirrors and plain glass get roles; what else reflects or lets light pass gets lobes. The material has its
/// facets, coat and use of alpha already; without facets nothing is done.
pub(super) fn give_role_or_lobes(material: &mut Material, lobes: Lobes, details: Details) {
    let Some(facets) = &material.microfacets else { return };
    let blends = material.alpha_mode == AlphaMode::Blend;
    let has_sheen = lobes.sheen != Vec3::ZERO;
    let is_modified = lobes.film.is_some() || lobes.dispersion > 0.0 || lobes.diffuse_transmission > 0.0;
    let is_bare = !(details.has_facet_texture || blends || has_sheen || is_modified) && facets.coat == 0.0;
    let is_plain = is_bare && lobes.anisotropy == 0.0 && facets.roughness <= MAX_SHARP_ROUGHNESS;
    if is_plain && facets.metallic == 1.0 {
        material.role = Role::Reflector;
        material.mirror_roughness = facets.roughness;
        material.schlick = true;
        return;
    }
    let lets_all_pass = lobes.transmission == 1.0 && !details.has_transmission_texture && !lobes.is_thin;
    if is_plain && lets_all_pass && !details.has_specular && facets.metallic == 0.0 {
        material.role = Role::Lens;
        return;
    }
    let reflects = facets.metallic > 0.0 || details.has_facet_texture || facets.roughness < MAX_FOLLOWED_ROUGHNESS;
    if reflects || lobes.transmission > 0.0 || !is_bare {
        material.lobes = Some(Box::new(lobes));
    }
}
