//! The light of points that are worked out alone, and what textures say of points of glossy surfaces.

use super::super::shadows::ShadowStart;
use super::super::{Material, Microfacets, Role, Scene, Texture, TextureBinding};
use super::arriving_light::{ArrivingLight, SeenSky, add_environment, add_scattered, headlight};
use super::filter::{self, TextureLookUps};
use super::glossy::{self, COAT_REFLECTANCE, LitPoints};
use super::microfacets::{LEAST_COSINE, LEAST_ROUGHNESS, grazing_share, lobe, variance_of_mean, variance_over_pixel};
use super::shade::{SurfacePoint, look_ups};
use crate::math::lanes::{Lanes, Vec3Lanes};
use glam::{Vec3, Vec4};
use std::f32::consts::FRAC_1_PI;

/// Highlights of a lower radiance are not seen: a tenth of a step of eight bits where those are smallest.
const FAINTEST_HIGHLIGHT: f32 = 3e-5;

/// The places where textures are looked up for some points of one material.
pub(super) trait LookUps<const N: usize> {
    /// The places of a texture.
    fn of(&self, binding: &TextureBinding) -> TextureLookUps<N>;
}

impl LookUps<1> for SurfacePoint {
    fn of(&self, binding: &TextureBinding) -> TextureLookUps<1> {
        look_ups(binding, std::slice::from_ref(self))
    }
}

/// Which light of a surface's facets is counted, where rays find the rest.
pub(super) struct LightOfFacets {
    /// The share of the light that enters which is scattered: the rest passes the surface.
    pub(super) scattering: f32,
    /// The share of the environment's reflection that is added.
    pub(super) mirrored: f32,
    /// The same of the coat.
    pub(super) mirrored_by_coat: f32,
    /// The coat's unit normal on the outer side, whose roughness has in it what the coat's map hides; else the coat is
    /// as smooth as the surface.
    pub(super) coat_normal: Option<Vec3>,
}

impl LightOfFacets {
    const ALL: Self = Self { scattering: 1.0, mirrored: 1.0, mirrored_by_coat: 1.0, coat_normal: None };
}

impl Scene {
    fn texture_of(&self, binding: &TextureBinding) -> Option<&Texture> {
        Some(self.textures.get(binding.texture as usize)?)
    }

    /// The light that a point scatters and reflects to its viewer, without what it emits.
    #[inline(always)]
    pub(super) fn lit(&self, material: &Material, base: Vec3, point: &SurfacePoint, towards_viewer: Vec3) -> Vec3 {
        let side = if point.geometric_normal.dot(towards_viewer) < 0.0 { -1.0 } else { 1.0 };
        if material.is_glossy(self) {
            let facets = material.microfacets.as_ref();
            return self.lit_glossy((material, facets), base, point, towards_viewer, &LightOfFacets::ALL);
        }
        let (normals, viewers) = (Vec3Lanes::one(point.normal * side), Vec3Lanes::one(towards_viewer));
        if self.has_headlight() {
            return base * headlight(&normals, &viewers)[0];
        }
        let (mut sum, mut arriving) = (Vec3Lanes::ZERO, ArrivingLight::NONE);
        let start = self.light_visibility.as_ref().map(|_| self.shadow_start(point, side));
        for light in &self.lights {
            arriving.set(light, &Vec3Lanes::one(point.position));
            if normals.dot(&arriving.towards)[0] > 0.0 && arriving.strength[0] > 0.0 {
                let passing = start.map_or(Vec3::ONE, |start| start.passing(self, light));
                arriving.color = Vec3Lanes::one(light.intensity * passing);
                add_scattered(&arriving, &normals, &mut sum);
            }
        }
        if let Some(environment) = &self.environment {
            let shares = Vec3Lanes::one(self.sky_share(point, side));
            let starts = start.map(|start| [start]);
            let seen = starts.as_ref().map(|starts| SeenSky { shares: &shares, starts });
            add_environment(environment, &normals, 1, (self, seen), &mut sum);
        }
        base * (sum.vector(0) + self.by_surfaces_onto(point, side)) * FRAC_1_PI
    }

    /// The irradiance of a point by surfaces that emit light or scatter it.
    pub(super) fn by_surfaces_onto(&self, point: &SurfacePoint, side: f32) -> Vec3 {
        match &self.sky {
            Some(sky) if point.triangle != u32::MAX => sky.by_surfaces(point.triangle, point.barycentrics, side),
            _ => Vec3::ZERO,
        }
    }

    /// The highlights of lights on a mirror or coat: the radiance that it reflects to its viewer, beside what it shows.
    /// Without lights there are none: the headlight makes none, the environment is what is shown.
    #[inline]
    pub fn highlights(&self, point: &SurfacePoint, towards_viewer: Vec3) -> Vec3 {
        let material = self.material_of(point.object);
        match material.highlight_roughness() {
            Some(roughness) if !self.lights.is_empty() => {
                self.highlights_of(material, roughness, point, towards_viewer)
            }
            _ => Vec3::ZERO,
        }
    }

    #[inline(never)] // few surfaces have them
    fn highlights_of(&self, material: &Material, roughness: f32, point: &SurfacePoint, towards_viewer: Vec3) -> Vec3 {
        let side = if point.geometric_normal.dot(towards_viewer) < 0.0 { -1.0 } else { 1.0 };
        let is_blind = side > 0.0 && self.objects[point.object as usize].inside;
        if is_blind {
            return Vec3::ZERO;
        }
        let mut start = None;
        let tint = self.base_color(material, point).truncate();
        let coat = self.coat(material, point);
        let reflectance = |grazing: f32| match material.role {
            Role::Coated => Vec3::splat(coat * (COAT_REFLECTANCE + (1.0 - COAT_REFLECTANCE) * grazing)),
            _ if material.schlick => tint + (Vec3::ONE - tint) * grazing,
            _ => tint,
        };
        let (normals, count) = self.normals_of_highlights(material, point, roughness.max(LEAST_ROUGHNESS).powi(2));
        let mut sum = Vec3::ZERO;
        for light in &self.lights {
            let (towards, irradiance) = light.arriving(point.position);
            let half = towards + towards_viewer;
            let length2 = half.length_squared();
            if irradiance == Vec3::ZERO || length2 < 1e-12 {
                continue;
            }
            let mut reflected = 0.0;
            for (normal, alpha) in &normals[..count] {
                let normal = *normal * side;
                let (n_l, n_v) = (normal.dot(towards), normal.dot(towards_viewer).max(LEAST_COSINE));
                if n_l > 0.0 {
                    let (cosine2, sine2) =
                        (normal.dot(half).powi(2) / length2, normal.cross(half).length_squared() / length2);
                    reflected += n_l * lobe(*alpha, cosine2, sine2, n_l, n_v);
                }
            }
            let light_reflected =
                irradiance * reflectance(grazing_share(0.5 * length2.sqrt())) * (reflected / count as f32);
            // Lobes end nowhere: far from a highlight a ray would cost more than it shows.
            if light_reflected.max_element() > FAINTEST_HIGHLIGHT {
                let start = start.get_or_insert_with(|| self.shadow_start(point, side));
                sum += light_reflected * start.passing(self, light);
            }
        }
        if sum.is_finite() { sum } else { Vec3::ZERO }
    }

    /// The share of the sky's light that arrives at a point, for each colour: 1 where nothing is known of it.
    pub(super) fn sky_share(&self, point: &SurfacePoint, side: f32) -> Vec3 {
        match &self.sky {
            Some(sky) if point.triangle != u32::MAX => sky.share(point.triangle, point.barycentrics, side),
            _ => Vec3::ONE,
        }
    }

    /// Returns true if rays tell which lights or suns a point sees.
    #[inline]
    pub(super) fn seeks_light(&self) -> bool {
        let has_suns = || self.sky.as_ref().is_some_and(|sky| !sky.suns().is_empty());
        self.light_visibility.is_some() && (!self.lights.is_empty() || has_suns())
    }

    /// Where light that shines on a point is sought from.
    pub(super) fn shadow_start(&self, point: &SurfacePoint, side: f32) -> ShadowStart {
        match point.triangle {
            u32::MAX => ShadowStart::on_surface(point.position, point.geometric_normal * side, point.coordinate_size),
            triangle => ShadowStart::on_triangle(self, triangle, point.barycentrics, side),
        }
    }

    /// The light of a point by facets.
    #[inline(never)] // as much as all else together
    pub(super) fn lit_glossy(
        &self,
        (material, facets): (&Material, Option<&Microfacets>),
        base: Vec3,
        point: &SurfacePoint,
        towards_viewer: Vec3,
        light: &LightOfFacets,
    ) -> Vec3 {
        let side = if point.geometric_normal.dot(towards_viewer) < 0.0 { -1.0 } else { 1.0 };
        let mut points = LitPoints::<1>::ZERO;
        (points.scattering, points.mirrored, points.mirrored_by_coat) =
            (light.scattering, light.mirrored, light.mirrored_by_coat);
        points.position = Vec3Lanes::one(point.position);
        points.smooth_normal = Vec3Lanes::one(point.normal * side);
        points.towards_viewer = Vec3Lanes::one(towards_viewer);
        points.base = Vec3Lanes::one(base);
        points.variance = Lanes::splat(variance_over_pixel(point.normal_change2));
        points.set_surface(self, material, 1, point);
        points.turn_normals(self, material, 1, point, [point.tangent], &Lanes::splat(side));
        if let Some(normal) = light.coat_normal {
            (points.smooth_normal, points.smooth_variance) = (Vec3Lanes::one(normal * side), Lanes::ZERO);
        }
        if self.seeks_light() {
            points.shadow_starts = [self.shadow_start(point, side)];
        }
        points.occlusion = Vec3Lanes::one(points.occlusion.vector(0).min(self.sky_share(point, side)));
        points.emitted = Vec3Lanes::one(self.by_surfaces_onto(point, side));
        let mut sum = Vec3Lanes::ZERO;
        glossy::radiance(self, facets, &points, 1, &mut sum);
        sum.vector(0)
    }
}

impl<const N: usize> LitPoints<N> {
    /// Sets metalness, roughness and occlusion at the first `count` points.
    #[cfg_attr(not(debug_assertions), inline(always))]
    pub(super) fn set_surface(&mut self, scene: &Scene, material: &Material, count: usize, look_ups: &impl LookUps<N>) {
        let microfacets = material.microfacets.as_ref();
        self.metallic = Lanes::splat(microfacets.map_or(0.0, |microfacets| microfacets.metallic));
        self.roughness = Lanes::splat(microfacets.map_or(1.0, |microfacets| microfacets.roughness));
        self.occlusion = Vec3Lanes::splat(Vec3::ONE);
        let mut texels = [Vec4::ONE; N];
        let of_facets = microfacets.and_then(|microfacets| microfacets.texture.as_ref());
        if let Some((binding, texture)) = of_facets.and_then(|binding| Some((binding, scene.texture_of(binding)?))) {
            filter::sample(texture, &look_ups.of(binding), count, &mut texels);
            for (i, texel) in texels.iter().enumerate() {
                self.roughness[i] *= texel.y;
                self.metallic[i] *= texel.z;
            }
        }
        let Some(map) = &material.occlusion_map else { return };
        if of_facets != Some(&map.binding) {
            let Some(texture) = scene.texture_of(&map.binding) else { return };
            filter::sample(texture, &look_ups.of(&map.binding), count, &mut texels);
        }
        for (i, texel) in texels.iter().enumerate() {
            self.occlusion.set(i, Vec3::splat(1.0 + (texel.x - 1.0) * map.strength));
        }
    }

    /// Sets normals: the smooth ones, turned by the map at the first `count` points, and adds to the variance.
    /// `tangents` are along the map's u, of any length, `sides` is -1 where the normal is turned over.
    #[cfg_attr(not(debug_assertions), inline(always))]
    pub(super) fn turn_normals(
        &mut self,
        scene: &Scene,
        material: &Material,
        count: usize,
        look_ups: &impl LookUps<N>,
        tangents: [Vec4; N],
        sides: &Lanes<N>,
    ) {
        self.normal = self.smooth_normal;
        self.smooth_variance = self.variance;
        let Some(map) = material.normal_map.as_ref().filter(|_| !scene.tangents.is_empty()) else { return };
        let Some(texture) = scene.texture_of(&map.binding) else { return };
        let mut texels = [Vec4::ONE; N];
        filter::sample(texture, &look_ups.of(&map.binding), count, &mut texels);
        for (i, texel) in texels.iter().enumerate().take(count) {
            let mean = texel.truncate() * 2.0 - 1.0;
            let length = mean.length();
            self.variance[i] += variance_of_mean(length) * (map.scale * map.scale);
            let smooth = self.smooth_normal.vector(i);
            self.normal.set(i, map.turned(smooth, tangents[i], sides[i], mean));
        }
    }
}
