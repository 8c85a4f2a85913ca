//! Light that lit surfaces with microfacets, normal maps and occlusion send to their viewers: glTF's metallic-roughness
//! model (glTF 2.0, appendix B), for several points of one material at once.

use super::super::shadows::{ShadowStart, hide};
use super::super::{Environment, Light, Material, Microfacets, Scene};
use super::arriving_light::{ArrivingLight, add_suns, headlight};
use super::microfacets::{LEAST_COSINE, LEAST_ROUGHNESS, ReflectanceTable, grazing_share, lobe, widened_alpha};
use crate::math::lanes::{Lanes, Vec3Lanes};
use glam::{Vec2, Vec3};
use std::f32::consts::FRAC_1_PI;

/// The index of refraction of coats is 1.5.
pub(super) const COAT_REFLECTANCE: f32 = 0.04;

/// Points of one material, and all that their light depends on.
pub(super) struct LitPoints<const N: usize> {
    pub(super) position: Vec3Lanes<N>,
    /// Unit normals on the viewers' side, as the normal map turns them.
    pub(super) normal: Vec3Lanes<N>,
    /// The same without the map, or those of the coat.
    pub(super) smooth_normal: Vec3Lanes<N>,
    /// Unit vectors to the previous points of paths.
    pub(super) towards_viewer: Vec3Lanes<N>,
    pub(super) base: Vec3Lanes<N>,
    pub(super) metallic: Lanes<N>,
    /// Perceptual.
    pub(super) roughness: Lanes<N>,
    /// Mean square of the distances of unit normals, within what a point stands for, to their mean: of smooth ones
    /// until the map turns them.
    pub(super) variance: Lanes<N>,
    /// The same of smooth normals.
    pub(super) smooth_variance: Lanes<N>,
    /// The share of light from the environment that arrives.
    pub(super) occlusion: Vec3Lanes<N>,
    /// The irradiance by surfaces that emit light.
    pub(super) emitted: Vec3Lanes<N>,
    /// The share of the light that enters which is scattered: the rest passes the surface.
    pub(super) scattering: f32,
    /// The share of the environment's reflection that is added: the rest is followed by rays.
    pub(super) mirrored: f32,
    /// The same of the coat.
    pub(super) mirrored_by_coat: f32,
    /// Where light is sought from, if anything casts shadows.
    pub(super) shadow_starts: [ShadowStart; N],
}

impl<const N: usize> LitPoints<N> {
    pub(super) const ZERO: Self = Self {
        position: Vec3Lanes::ZERO,
        normal: Vec3Lanes::ZERO,
        smooth_normal: Vec3Lanes::ZERO,
        towards_viewer: Vec3Lanes::ZERO,
        base: Vec3Lanes::ZERO,
        metallic: Lanes::ZERO,
        roughness: Lanes::ZERO,
        variance: Lanes::ZERO,
        smooth_variance: Lanes::ZERO,
        occlusion: Vec3Lanes::ZERO,
        emitted: Vec3Lanes::ZERO,
        scattering: 1.0,
        mirrored: 1.0,
        mirrored_by_coat: 1.0,
        shadow_starts: [ShadowStart::NONE; N],
    };
}

/// The properties of points that are the same for all lights.
struct Facets<const N: usize> {
    /// Cosines between normals and viewers, as they are.
    n_v: Lanes<N>,
    alpha: Lanes<N>,
    coat_alpha: Lanes<N>,
    /// Reflectance at normal incidence.
    reflectance: Vec3Lanes<N>,
    /// The same at grazing angles.
    at_grazing: Lanes<N>,
    /// The share that is scattered of the light that enters.
    albedo: Vec3Lanes<N>,
}

/// A surface without facets, for normal maps on surfaces of Lambert's law.
const NO_FACETS: Microfacets = Microfacets {
    metallic: 0.0,
    roughness: 1.0,
    texture: None,
    specular: Vec3::ZERO,
    specular_at_grazing: 0.0,
    coat: 0.0,
    coat_roughness: 0.0,
};

/// Sets the light that the first `count` points send to their viewers, without what they emit.
#[cfg_attr(not(debug_assertions), inline(always))]
pub(super) fn radiance<const N: usize>(
    scene: &Scene,
    microfacets: Option<&Microfacets>,
    points: &LitPoints<N>,
    count: usize,
    sum: &mut Vec3Lanes<N>,
) {
    if scene.has_headlight() {
        *sum = points.base * headlight(&points.normal, &points.towards_viewer);
        return;
    }
    *sum = Vec3Lanes::ZERO;
    let microfacets = microfacets.unwrap_or(&NO_FACETS);
    let facets = Facets::new(microfacets, points);
    let mut coat = Vec3Lanes::<N>::ZERO;
    let mut arriving = ArrivingLight::NONE;
    for light in &scene.lights {
        arriving.set(light, &points.position);
        if scene.light_visibility.is_some() {
            shadow(scene, light, points, count, &mut arriving);
        }
        add_light(&arriving, microfacets, &facets, points, sum);
        if microfacets.coat > 0.0 {
            add_light_of_coat(&arriving, &facets.coat_alpha, points, &mut coat);
        }
    }
    if let Some(environment) = &scene.environment {
        add_environment((scene, environment), microfacets, &facets, points, count, sum);
        if microfacets.coat > 0.0 && points.mirrored_by_coat > 0.0 {
            add_environment_of_coat(environment, &facets.coat_alpha, points, count, &mut coat);
        }
    }
    if scene.sky.as_ref().is_some_and(|sky| sky.has_light_of_surfaces()) {
        add_emitted(microfacets, &facets, points, count, sum);
    }
    if microfacets.coat > 0.0 {
        cover(microfacets.coat, points, &coat, sum);
    }
}

impl<const N: usize> Facets<N> {
    #[inline(always)]
    #[allow(clippy::needless_range_loop)] // lanes of several arrays, for the vectoriser
    fn new(microfacets: &Microfacets, points: &LitPoints<N>) -> Self {
        let mut facets = Self {
            n_v: points.normal.dot(&points.towards_viewer),
            alpha: Lanes::ZERO,
            coat_alpha: Lanes::ZERO,
            reflectance: Vec3Lanes::ZERO,
            at_grazing: Lanes::ZERO,
            albedo: Vec3Lanes::ZERO,
        };
        let coat_roughness = microfacets.coat_roughness.max(LEAST_ROUGHNESS);
        for i in 0..N {
            let roughness = points.roughness[i];
            let roughness = if roughness > LEAST_ROUGHNESS { roughness } else { LEAST_ROUGHNESS };
            facets.alpha[i] = widened_alpha(roughness * roughness, points.variance[i]);
            facets.coat_alpha[i] = widened_alpha(coat_roughness * coat_roughness, points.smooth_variance[i]);
        }
        for i in 0..N {
            let metallic = points.metallic[i];
            let grazing = microfacets.specular_at_grazing;
            facets.at_grazing[i] = grazing + (1.0 - grazing) * metallic;
            for channel in 0..3 {
                let (base, specular) = (points.base[channel][i], microfacets.specular[channel]);
                facets.reflectance[channel][i] = specular + (base - specular) * metallic;
                facets.albedo[channel][i] = base * (1.0 - metallic) * points.scattering;
            }
        }
        facets
    }
}

/// Takes the strength of a light away where something stands before it.
#[inline(never)] // rays cost much more than a call
fn shadow<const N: usize>(
    scene: &Scene,
    light: &Light,
    points: &LitPoints<N>,
    count: usize,
    arriving: &mut ArrivingLight<N>,
) {
    let strength = arriving.strength;
    let matters = |lane: &usize| {
        let towards = arriving.towards.vector(*lane);
        let faces = |normals: &Vec3Lanes<N>| normals.vector(*lane).dot(towards) > 0.0;
        strength[*lane] > 0.0 && (faces(&points.normal) || faces(&points.smooth_normal))
    };
    let starts = (0..count.min(N)).filter(matters).map(|lane| (lane, points.shadow_starts[lane]));
    hide(scene, light, starts, (&mut arriving.strength, &mut arriving.color));
}

#[cfg_attr(not(debug_assertions), inline(always))]
#[allow(clippy::needless_range_loop)]
fn add_light<const N: usize>(
    arriving: &ArrivingLight<N>,
    microfacets: &Microfacets,
    facets: &Facets<N>,
    points: &LitPoints<N>,
    sum: &mut Vec3Lanes<N>,
) {
    let ArrivingLight { towards, strength, color } = arriving;
    let (at_normal, at_grazing) = (microfacets.specular.max_element(), microfacets.specular_at_grazing);
    let (mut scattered, mut reflected, mut grazing) = (Lanes::<N>::ZERO, Lanes::<N>::ZERO, Lanes::<N>::ZERO);
    for i in 0..N {
        let [lx, ly, lz] = [towards[0][i], towards[1][i], towards[2][i]];
        let [nx, ny, nz] = [points.normal[0][i], points.normal[1][i], points.normal[2][i]];
        let viewer = &points.towards_viewer;
        let [hx, hy, hz] = [lx + viewer[0][i], ly + viewer[1][i], lz + viewer[2][i]];
        let n_l = nx * lx + ny * ly + nz * lz;
        let n_h = n_l + facets.n_v[i];
        let h2 = hx * hx + hy * hy + hz * hz;
        let h2 = if h2 > 1e-12 { h2 } else { 1e-12 };
        let [cx, cy, cz] = [ny * hz - nz * hy, nz * hx - nx * hz, nx * hy - ny * hx];
        let inverse = 1.0 / h2;
        let (cosine2, sine2) = (n_h * n_h * inverse, (cx * cx + cy * cy + cz * cz) * inverse);
        let n_v = if facets.n_v[i] > LEAST_COSINE { facets.n_v[i] } else { LEAST_COSINE };
        let irradiance = if n_l > 0.0 { n_l * strength[i] } else { 0.0 };
        // The half vector's length is twice its cosine to the light.
        grazing[i] = grazing_share(0.5 * h2.sqrt());
        scattered[i] = irradiance * FRAC_1_PI * (1.0 - at_normal - (at_grazing - at_normal) * grazing[i]);
        reflected[i] = irradiance * lobe(facets.alpha[i], cosine2, sine2, n_l, n_v);
    }
    for channel in 0..3 {
        let (reflectance, albedo) = (&facets.reflectance[channel], &facets.albedo[channel]);
        for i in 0..N {
            let fresnel = reflectance[i] + (facets.at_grazing[i] - reflectance[i]) * grazing[i];
            sum[channel][i] += color[channel][i] * (albedo[i] * scattered[i] + fresnel * reflected[i]);
        }
    }
}

/// Adds a light's highlight on the coat, before Fresnel's share.
#[inline(never)] // coats are rare
fn add_light_of_coat<const N: usize>(
    arriving: &ArrivingLight<N>,
    alpha: &Lanes<N>,
    points: &LitPoints<N>,
    sum: &mut Vec3Lanes<N>,
) {
    for i in 0..N {
        let [normal, towards, viewer] =
            [&points.smooth_normal, &arriving.towards, &points.towards_viewer].map(|vectors| vectors.vector(i));
        let (n_l, half) = (normal.dot(towards), towards + viewer);
        if n_l <= 0.0 || arriving.strength[i] <= 0.0 {
            continue;
        }
        let inverse = 1.0 / half.length_squared().max(1e-12);
        let (cosine2, sine2) = (normal.dot(half).powi(2) * inverse, normal.cross(half).length_squared() * inverse);
        let n_v = normal.dot(viewer).max(LEAST_COSINE);
        let reflected =
            arriving.color.vector(i) * (n_l * arriving.strength[i] * lobe(alpha[i], cosine2, sine2, n_l, n_v));
        sum.set(i, sum.vector(i) + reflected);
    }
}

#[cfg_attr(not(debug_assertions), inline(always))]
#[allow(clippy::needless_range_loop)] // lanes of several arrays, for the vectoriser
fn add_environment<const N: usize>(
    (scene, environment): (&Scene, &Environment),
    microfacets: &Microfacets,
    facets: &Facets<N>,
    points: &LitPoints<N>,
    count: usize,
    sum: &mut Vec3Lanes<N>,
) {
    let table = ReflectanceTable::get();
    let (at_normal, at_grazing) = (microfacets.specular.max_element(), microfacets.specular_at_grazing);
    let mut shares = [Lanes::<N>::ZERO; 2];
    let (mut tilts, mut alphas) = (Lanes::<N>::ZERO, Lanes::<N>::ZERO);
    for i in 0..count.min(N) {
        let n_v = if facets.n_v[i] > LEAST_COSINE { facets.n_v[i] } else { LEAST_COSINE };
        let surroundings = table.reflected(facets.alpha[i].sqrt(), n_v);
        (shares[0][i], shares[1][i]) = (surroundings.at_normal, surroundings.at_grazing);
        tilts[i] = surroundings.tilt;
        alphas[i] = surroundings.alpha(facets.alpha[i]);
    }
    // The middles of highlights: see `ReflectedSurroundings::middle`.
    let mut middles = Vec3Lanes::<N>::ZERO;
    for i in 0..N {
        let [nx, ny, nz] = [points.normal[0][i], points.normal[1][i], points.normal[2][i]];
        let (twice, tilt) = (2.0 * facets.n_v[i], tilts[i]);
        let viewer = &points.towards_viewer;
        let x = nx + (nx * twice - viewer[0][i] - nx) * tilt;
        let y = ny + (ny * twice - viewer[1][i] - ny) * tilt;
        let z = nz + (nz * twice - viewer[2][i] - nz) * tilt;
        let length2 = x * x + y * y + z * z;
        let inverse = 1.0 / if length2 > 1e-12 { length2 } else { 1e-12 }.sqrt();
        (middles[0][i], middles[1][i], middles[2][i]) = (x * inverse, y * inverse, z * inverse);
    }
    let [of_normals, of_middles] = [environment.places(&points.normal), environment.places(&middles)];
    let mut suns = Vec3Lanes::<N>::ZERO;
    if let Some(sky) = &scene.sky {
        add_suns(scene, sky, &points.normal, &points.shadow_starts, count, &mut suns);
    }
    for i in 0..count.min(N) {
        let [of_normal, of_grazing] = [shares[0][i], shares[1][i]];
        let entering = 1.0 - (at_normal * of_normal + at_grazing * of_grazing);
        let of_normal_in_picture = Vec2::new(of_normals[0][i], of_normals[1][i]);
        let irradiance = match &scene.sky {
            Some(sky) => sky.irradiance_at(of_normal_in_picture),
            None => environment.irradiance_at(of_normal_in_picture),
        };
        let scattered = irradiance * (FRAC_1_PI * entering);
        let reflected = match points.mirrored {
            0.0 => Vec3::ZERO,
            share => environment.glossy_at(Vec2::new(of_middles[0][i], of_middles[1][i]), alphas[i]) * share,
        };
        for channel in 0..3 {
            let reflectance = facets.reflectance[channel][i] * of_normal + facets.at_grazing[i] * of_grazing;
            sum[channel][i] += points.occlusion[channel][i]
                * (facets.albedo[channel][i] * scattered[channel] + reflectance * reflected[channel]);
            // Their shadows are known, and no texture's matter.
            sum[channel][i] += facets.albedo[channel][i] * suns[channel][i] * (FRAC_1_PI * entering);
        }
    }
}

/// Adds what is scattered of the light of emitters: what surfaces mirror of it is not there.
#[inline(never)] // rarely needed
fn add_emitted<const N: usize>(
    microfacets: &Microfacets,
    facets: &Facets<N>,
    points: &LitPoints<N>,
    count: usize,
    sum: &mut Vec3Lanes<N>,
) {
    let table = ReflectanceTable::get();
    let (at_normal, at_grazing) = (microfacets.specular.max_element(), microfacets.specular_at_grazing);
    for i in 0..count.min(N) {
        let surroundings = table.reflected(facets.alpha[i].sqrt(), facets.n_v[i].max(LEAST_COSINE));
        let entering = 1.0 - (at_normal * surroundings.at_normal + at_grazing * surroundings.at_grazing);
        for channel in 0..3 {
            let scattered = facets.albedo[channel][i] * points.emitted[channel][i];
            sum[channel][i] += scattered * (FRAC_1_PI * entering);
        }
    }
}

/// Adds the environment in the coat, before Fresnel's share.
#[inline(never)]
fn add_environment_of_coat<const N: usize>(
    environment: &Environment,
    alpha: &Lanes<N>,
    points: &LitPoints<N>,
    count: usize,
    sum: &mut Vec3Lanes<N>,
) {
    for i in 0..count.min(N) {
        let (normal, viewer) = (points.smooth_normal.vector(i), points.towards_viewer.vector(i));
        let n_v = normal.dot(viewer);
        let surroundings = ReflectanceTable::get().reflected(alpha[i].sqrt(), n_v.max(LEAST_COSINE));
        let middle = surroundings.middle(normal, normal * (2.0 * n_v) - viewer);
        let reflected = environment.glossy(middle, surroundings.alpha(alpha[i]));
        sum.set(i, sum.vector(i) + reflected * points.occlusion.vector(i) * points.mirrored_by_coat);
    }
}

/// Puts a coat over what lies beneath it (KHR_materials_clearcoat).
#[inline(never)]
fn cover<const N: usize>(share: f32, points: &LitPoints<N>, coat: &Vec3Lanes<N>, sum: &mut Vec3Lanes<N>) {
    for i in 0..N {
        let n_v = points.smooth_normal.vector(i).dot(points.towards_viewer.vector(i)).max(0.0);
        let fresnel = share * (COAT_REFLECTANCE + (1.0 - COAT_REFLECTANCE) * grazing_share(n_v));
        sum.set(i, sum.vector(i) * (1.0 - fresnel) + coat.vector(i) * fresnel);
    }
}

impl Material {
    /// Returns true if Lambert's law, one colour texture and vertex colours do not say all about its light.
    #[inline(always)]
    pub(super) fn is_glossy(&self, scene: &Scene) -> bool {
        !self.unlit
            && (self.normal_map.is_some()
                || self.lobes.is_some()
                || (self.microfacets.is_some() || self.occlusion_map.is_some()) && !scene.has_headlight())
    }
}
