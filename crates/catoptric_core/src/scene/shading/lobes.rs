//! Lobes of surfaces that rays follow, at a point.

use super::super::{AlphaMode, LobeTexture, Lobes, Material, Microfacets, NormalMap, Scene};
use super::lit_point::LightOfFacets;
use super::microfacets::widened_alpha;
use super::shade::{SurfacePoint, finite};
use super::sheen::{self, SheenLobe};
use super::thin_film::FilmAt;
use crate::math::portable::PortableMath;
use glam::{Vec2, Vec3, Vec3Swizzles, Vec4Swizzles};

/// The lobes of a surface at a point, from factors, textures and vertex colours.
#[derive(Clone, Copy, Debug)]
pub struct LobesAt {
    /// The share of the surface that is there.
    pub coverage: f32,
    /// Linear.
    pub base: Vec3,
    /// 0 for dielectrics to 1 for metals.
    pub metallic: f32,
    /// Width of the facets' distribution (alpha of Trowbridge and Reitz), widened by what the normal map hides within a
    /// footprint.
    pub alpha: f32,
    /// The unit direction along which highlights are wider, at right angles to the normal, and the width there.
    pub stretch: Option<(Vec3, f32)>,
    /// The dielectric's reflectance at normal incidence.
    pub specular: Vec3,
    /// The same at grazing angles.
    pub specular_at_grazing: f32,
    /// A thin film over facets.
    pub film: Option<FilmAt>,
    /// The share of light that enters which passes the surface.
    pub transmission: f32,
    /// The share of scattered light that leaves on the other side, and its colour.
    pub diffuse_transmission: f32,
    /// Linear.
    pub diffuse_transmission_color: Vec3,
    /// Unit normal on the outer side, turned by the normal map.
    pub normal: Vec3,
    /// The share of the surface that the coat covers.
    pub coat: f32,
    /// Width of the coat's facets.
    pub coat_alpha: f32,
    /// Unit normal of the coat, on the outer side.
    pub coat_normal: Vec3,
    /// The colour of light that fibres scatter, and their perceptual roughness.
    pub sheen: Vec3,
    /// Perceptual roughness of the fibres.
    pub sheen_roughness: f32,
}

impl LobesAt {
    /// The same where nothing passes: what would is scattered.
    #[must_use]
    pub fn opaque(&self) -> Self {
        Self { transmission: 0.0, ..*self }
    }

    /// The share of light that fibres leave to what is beneath them, by the cosine towards the viewer.
    pub fn below_sheen(&self, cosine: f32) -> f32 {
        match self.sheen.max_element() {
            0.0 => 1.0,
            most => 1.0 - (most * sheen::albedo(self.sheen_roughness, cosine)).min(1.0),
        }
    }
}

impl Scene {
    /// The lobes of a material at a point of it.
    pub fn lobes_at(&self, material: &Material, lobes: &Lobes, point: &SurfacePoint) -> LobesAt {
        let base = self.base_color(material, point);
        let of_map = |map: &Option<NormalMap>| {
            let mut found = [(point.normal, 0.0)];
            if let Some(map) = map.as_ref().filter(|_| !self.tangents.is_empty()) {
                self.normals_of_map(map, std::slice::from_ref(point), &mut found);
            }
            found[0]
        };
        let ((normal, variance), (coat_normal, coat_variance)) =
            (of_map(&material.normal_map), of_map(&material.coat_normal_map));
        let texel = |texture| lobes.texture(texture).map(|binding| self.sample(binding, point));
        let color = |texture| texel(texture).map_or(Vec3::ONE, |texel| texel.xyz());
        let of_coat = texel(LobeTexture::CoatRoughness).map_or(1.0, |texel| texel.y);
        let mut at = LobesAt {
            coverage: if material.alpha_mode == AlphaMode::Blend { base.w.clamp(0.0, 1.0) } else { 1.0 },
            base: base.xyz(),
            metallic: 0.0,
            alpha: 1.0,
            specular: Vec3::ZERO,
            specular_at_grazing: 0.0,
            stretch: None,
            film: None,
            transmission: lobes.transmission * texel(LobeTexture::Transmission).map_or(1.0, |texel| texel.x),
            diffuse_transmission: 0.0,
            diffuse_transmission_color: Vec3::ZERO,
            normal,
            coat: self.coat(material, point),
            coat_alpha: 0.0,
            coat_normal,
            sheen: lobes.sheen * color(LobeTexture::SheenColor),
            sheen_roughness: lobes.sheen_roughness * texel(LobeTexture::SheenRoughness).map_or(1.0, |texel| texel.w),
        };
        if let Some(facets) = &material.microfacets {
            let texture = facets.texture.as_ref().map(|binding| self.sample(binding, point));
            let texture = texture.map_or([1.0; 2], |texel| [texel.y, texel.z]);
            at.metallic = facets.metallic * texture[1];
            at.alpha = widened_alpha((facets.roughness * texture[0]).powi(2), variance);
            at.coat_alpha = widened_alpha((facets.coat_roughness * of_coat).powi(2), coat_variance);
            let share = texel(LobeTexture::Specular).map_or(1.0, |texel| texel.w);
            at.specular = facets.specular * color(LobeTexture::SpecularColor) * share;
            at.specular_at_grazing = facets.specular_at_grazing * share;
        }
        if lobes.diffuse_transmission > 0.0 {
            let share = texel(LobeTexture::DiffuseTransmission).map_or(1.0, |texel| texel.w);
            at.diffuse_transmission = lobes.diffuse_transmission * share;
            at.diffuse_transmission_color =
                lobes.diffuse_transmission_color * color(LobeTexture::DiffuseTransmissionColor);
        }
        at.film = lobes.film.and_then(|film| {
            let share = film.share * texel(LobeTexture::FilmShare).map_or(1.0, |texel| texel.x);
            let [least, most] = film.thickness_nm;
            let thickness_nm = least + (most - least) * texel(LobeTexture::FilmThickness).map_or(1.0, |texel| texel.y);
            (share > 0.0).then_some(FilmAt { share, ior: film.ior, thickness_nm })
        });
        if lobes.anisotropy > 0.0 {
            at.stretch = stretch(&at, lobes, point, texel(LobeTexture::Anisotropy).map(|texel| texel.xyz()));
        }
        at
    }

    /// The radiance that a point of a surface with lobes scatters and emits towards its viewer, and the highlights of
    /// lights on it, beside what its lobes show: `mirrored` are the shares of the environment's reflection, and of that
    /// in the coat, that are added, as they are not followed.
    pub fn radiance_beside_lobes(
        &self,
        material: &Material,
        point: &SurfacePoint,
        at: &LobesAt,
        towards_viewer: Vec3,
        [mirrored, mirrored_by_coat]: [f32; 2],
    ) -> Vec3 {
        if material.unlit {
            return finite(at.base);
        }
        // A headlight shows what scatters it.
        let headlit = if self.has_headlight() { (1.0 - at.metallic) * (1.0 - at.transmission) } else { 1.0 };
        let side = if point.geometric_normal.dot(towards_viewer) < 0.0 { -1.0 } else { 1.0 };
        let scattering = (1.0 - at.transmission) * (1.0 - at.diffuse_transmission);
        let light = LightOfFacets { scattering, mirrored, mirrored_by_coat, coat_normal: Some(at.coat_normal) };
        let facets = material.microfacets.as_ref().map(|facets| {
            let cosine = at.normal.dot(towards_viewer).abs();
            let specular = match &at.film {
                Some(film) => at.specular.lerp(film.reflectance(cosine, at.specular), film.share),
                None => at.specular,
            };
            // Coats are outside.
            let coat = if side < 0.0 { 0.0 } else { at.coat };
            let (specular_at_grazing, coat_roughness) = (at.specular_at_grazing, at.coat_alpha.sqrt());
            Microfacets { specular, specular_at_grazing, coat, coat_roughness, ..facets.clone() }
        });
        let mut lit = self.lit_glossy((material, facets.as_ref()), at.base * headlit, point, towards_viewer, &light);
        if at.diffuse_transmission > 0.0 {
            lit += self.lit_behind(material, at, point, towards_viewer);
        }
        if at.sheen == Vec3::ZERO || self.has_headlight() {
            return finite(lit + self.emitted(material, point));
        }
        let cosine = (at.normal * side).dot(towards_viewer).clamp(0.02, 1.0);
        let below = at.below_sheen(cosine);
        finite(lit * below + self.sheen(material, point, at, towards_viewer, side) + self.emitted(material, point))
    }

    /// The light that arrives at the other side, and is scattered through the surface.
    fn lit_behind(&self, material: &Material, at: &LobesAt, point: &SurfacePoint, towards_viewer: Vec3) -> Vec3 {
        // Light that enters there, leaves here.
        let passing = at.diffuse_transmission * (1.0 - at.transmission) * (1.0 - at.specular.max_element());
        let normal = point.geometric_normal;
        let from_behind = towards_viewer - normal * (2.0 * towards_viewer.dot(normal));
        let color = at.diffuse_transmission_color * passing;
        let light = LightOfFacets { scattering: 1.0, mirrored: 0.0, mirrored_by_coat: 0.0, coat_normal: None };
        self.lit_glossy((material, None), color, point, from_behind, &light)
    }

    /// The light that fibres scatter towards the viewer, of lights and of the environment.
    fn sheen(&self, material: &Material, point: &SurfacePoint, at: &LobesAt, towards_viewer: Vec3, side: f32) -> Vec3 {
        let lobe = SheenLobe::new(at.sheen_roughness, at.normal * side, towards_viewer);
        let mut sum = Vec3::ZERO;
        for light in &self.lights {
            let (towards, irradiance) = light.arriving(point.position);
            let share = lobe.of(towards);
            if share > 0.0 {
                sum += irradiance * share * self.shadow_start(point, side).passing(self, light);
            }
        }
        if let Some(environment) = &self.environment {
            let occlusion = material
                .occlusion_map
                .as_ref()
                .map_or(1.0, |map| 1.0 + (self.sample(&map.binding, point).x - 1.0) * map.strength);
            let occlusion = self.sky_share(point, side).min(Vec3::splat(occlusion));
            sum += occlusion * lobe.gather(|direction, across| environment.radiance_within(direction, across));
        }
        at.sheen * sum
    }
}

/// The direction along which highlights are wider, and the width there: by the direction and strength of the texture
/// (KHR_materials_anisotropy).
fn stretch(at: &LobesAt, lobes: &Lobes, point: &SurfacePoint, texel: Option<Vec3>) -> Option<(Vec3, f32)> {
    let tangent = point.tangent.truncate().reject_from_normalized(at.normal).try_normalize()?;
    let bitangent = at.normal.cross(tangent) * if point.tangent.w < 0.0 { -1.0 } else { 1.0 };
    let (direction, strength) = match texel {
        Some(texel) => ((texel.xy() * 2.0 - 1.0).normalize_or(Vec2::X), texel.z),
        None => (Vec2::X, 1.0),
    };
    let (sine, cosine) = lobes.anisotropy_rotation.sine_cosine();
    let direction = Vec2::new(cosine, sine).rotate(direction);
    let strength = (lobes.anisotropy * strength).clamp(0.0, 1.0);
    let along = tangent * direction.x + bitangent * direction.y;
    (strength > 0.0).then_some((along, at.alpha + (1.0 - at.alpha) * strength * strength))
}
