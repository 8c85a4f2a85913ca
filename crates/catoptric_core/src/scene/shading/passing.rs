//! Light that goes straight on through surfaces, for shadows.

use super::super::{AlphaMode, LobeTexture, Material, Role, Scene, TextureBinding};
use super::microfacets::grazing_share;
use super::shade::SurfacePoint;
use glam::{Vec3, Vec4, Vec4Swizzles};

impl Material {
    /// True if some of the light that arrives may go on behind the surface, beside holes of textures.
    pub fn lets_light_pass(&self) -> bool {
        let passes = self.lobes().is_some_and(|lobes| lobes.transmission > 0.0);
        self.role == Role::Lens || passes || self.alpha_mode == AlphaMode::Blend
    }
}

impl Scene {
    /// The share of light of each colour that goes on behind a point of a surface, for shadows: what the surface leaves
    /// uncovered, and what enters it and passes it. That light is bent, and gathered by what is curved, is left out, as
    /// is what a body absorbs.
    pub fn passing(&self, point: &SurfacePoint, direction: Vec3) -> Vec3 {
        let material = self.material_of(point.object);
        let cosine = direction.dot(point.normal).abs();
        if material.role == Role::Lens {
            return self.base_color(material, point).xyz() * entering(cosine, material.ior);
        }
        let base = self.base_color(material, point);
        let coverage = if material.alpha_mode == AlphaMode::Blend { base.w.clamp(0.0, 1.0) } else { 1.0 };
        let lobes = material.lobes().filter(|lobes| lobes.transmission > 0.0 && coverage > 0.0);
        let Some(lobes) = lobes else { return Vec3::splat(1.0 - coverage) };
        let texel = |binding: Option<&TextureBinding>| binding.map_or(Vec4::ONE, |binding| self.sample(binding, point));
        let transmission = lobes.transmission * texel(lobes.texture(LobeTexture::Transmission)).x;
        let Some(facets) = &material.microfacets else { return base.xyz() * transmission };
        let metallic = if facets.metallic > 0.0 { facets.metallic * texel(facets.texture.as_ref()).z } else { 0.0 };
        let specular = facets.specular.max_element();
        let reflected = specular + (facets.specular_at_grazing - specular) * grazing_share(cosine);
        base.xyz() * (transmission * (1.0 - metallic) * (1.0 - reflected) * coverage) + (1.0 - coverage)
    }
}

/// The share of light that enters glass, as if the cosine were the same on both sides: by Fresnel's equations.
fn entering(cosine: f32, ior: f32) -> f32 {
    let within = (1.0 - (1.0 - cosine * cosine) / (ior * ior)).max(0.0).sqrt();
    let across = (cosine - ior * within) / (cosine + ior * within);
    let along = (within - ior * cosine) / (within + ior * cosine);
    let reflected = 0.5 * (across * across + along * along);
    if reflected.is_finite() { 1.0 - reflected } else { 0.0 }
}
