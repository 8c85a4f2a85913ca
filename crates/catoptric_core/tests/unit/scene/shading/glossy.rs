//! Microfacets under lights and environments.

use catoptric_core::math::random::Stream;
use catoptric_core::scene::shade::SurfacePoint;
use catoptric_core::scene::{Environment, Light, LightKind, Material, Microfacets, Object, Scene};
use glam::{DVec3, Vec3, Vec4};
use std::f64::consts::PI;
use std::sync::Arc;

fn scene(material: Material) -> Scene {
    let mut scene = Scene { materials: vec![material], ..Scene::default() };
    scene.objects.push(Object {
        name: String::new(),
        material: 0,
        triangles: 0..0,
        vertices: 0..0,
        surface: None,
        inside: false,
        bounds: Default::default(),
    });
    scene
}

fn point(normal: Vec3) -> SurfacePoint {
    SurfacePoint {
        geometric_normal: normal,
        normal,
        color: Vec4::ONE,
        triangle: u32::MAX,
        coordinate_size: 1.0,
        ..SurfacePoint::default()
    }
}

/// The reflection of appendix B of glTF 2.0, written from its formulas: half vectors of unit length, the distribution
/// by the cosine, base colours mixed as the appendix mixes whole lobes.
fn gltf(base: DVec3, metallic: f64, roughness: f64, normal: DVec3, viewer: DVec3, light: DVec3) -> DVec3 {
    let half = (light + viewer).normalize();
    let [n_l, n_v, n_h] = [light, viewer, half].map(|direction| normal.dot(direction).max(0.0));
    let v_h = viewer.dot(half);
    let alpha2 = roughness.powi(4);
    let distribution = alpha2 / (PI * (n_h * n_h * (alpha2 - 1.0) + 1.0).powi(2));
    let of = |cosine: f64| cosine + (alpha2 + (1.0 - alpha2) * cosine * cosine).sqrt();
    // Smith's function in its separable form would be 1 / (of(n_l) of(n_v)); height-correlated it is this.
    let shadowing = |a: f64, b: f64| a * (alpha2 + (1.0 - alpha2) * b * b).sqrt();
    let visibility = 0.5 / (shadowing(n_l, n_v) + shadowing(n_v, n_l));
    assert!(visibility >= 1.0 / (of(n_l) * of(n_v)) * 0.999, "correlated masking takes no more away");
    let specular = distribution * visibility;
    let schlick = (1.0 - v_h).powi(5);
    let metal = (base + (DVec3::ONE - base) * schlick) * specular;
    let share = 0.04 + 0.96 * schlick;
    let dielectric = base / PI * (1.0 - share) + DVec3::splat(specular * share);
    (dielectric * (1.0 - metallic) + metal * metallic) * n_l
}

#[test]
fn lights_reflect_as_the_formulas_of_gltf_say() {
    let mut random = Stream::new(71);
    let mut compared = 0;
    for _ in 0..2000 {
        let mut direction = || {
            let mut number = || random.next_between(-1.0, 1.0);
            Vec3::new(number(), number(), number()).normalize_or(Vec3::X)
        };
        let (normal, viewer, towards) = (direction(), direction(), direction());
        let mut number = || random.next_unit();
        let (base, metallic, roughness) = (Vec3::new(number(), number(), number()), number(), 0.1 + 0.9 * number());
        if normal.dot(viewer) < 0.01 || normal.dot(towards) < 0.01 {
            continue;
        }
        let microfacets = Microfacets { metallic, roughness, ..Microfacets::default() };
        let material = Material { base_color: base.extend(1.0), microfacets: Some(microfacets), ..Material::default() };
        let mut scene = scene(material);
        let intensity = Vec3::new(1.0, 2.0, 0.5);
        let kind = LightKind::Directional;
        scene.lights.push(Light { kind, intensity, position: Vec3::ZERO, direction: -towards });
        let found = scene.radiance(&point(normal), viewer);
        let [normal, viewer, towards] = [normal, viewer, towards].map(Vec3::as_dvec3);
        let (metallic, roughness) = (metallic.into(), roughness.into());
        let expected = gltf(base.as_dvec3(), metallic, roughness, normal, viewer, towards) * intensity.as_dvec3();
        let error = (found.as_dvec3() - expected).abs().max_element();
        assert!(error < 2e-3 * expected.max_element() + 1e-5, "{found} for {expected} ({roughness})");
        compared += 1;
    }
    assert!(compared > 300);
}

/// A sky of a few soft lights of very different brightness.
fn sky() -> Environment {
    let (width, height) = (128u32, 64u32);
    let lights = [(Vec3::new(0.3, 0.8, 0.5), 40.0, 0.9), (Vec3::new(-0.8, 0.3, 0.2), 200.0, 0.98), (Vec3::Z, 8.0, 0.6)];
    let texel = |index: u32| {
        let (u, v) = ((index % width) as f32 + 0.5, (index / width) as f32 + 0.5);
        let direction = Environment::direction(u / width as f32, v / height as f32);
        let mut sum = Vec3::new(0.2, 0.3, 0.5) * (1.0 + direction.y);
        for (towards, brightness, size) in lights {
            let inside = ((towards.normalize().dot(direction) - size) / (1.0 - size)).max(0.0);
            sum += Vec3::new(1.0, 0.8, 0.6) * (brightness * inside);
        }
        sum.to_array()
    };
    Environment::new("lights", width, height, (0..width * height).map(texel).collect())
}

/// The integral over all light from the sky of the reflection of glTF's formulas.
fn integrated(sky: &Environment, base: DVec3, metallic: f64, roughness: f64, normal: DVec3, viewer: DVec3) -> DVec3 {
    let (columns, rows) = (512, 256);
    let mut sum = DVec3::ZERO;
    for row in 0..rows {
        let polar = |edge: f64| (edge / rows as f64 * PI).cos();
        let solid_angle = 2.0 * PI / columns as f64 * (polar(row as f64) - polar(row as f64 + 1.0));
        for column in 0..columns {
            let (u, v) = ((column as f32 + 0.5) / columns as f32, (row as f32 + 0.5) / rows as f32);
            let towards = Environment::direction(u, v);
            if normal.dot(towards.as_dvec3()) > 1e-4 {
                let reflected = gltf(base, metallic, roughness, normal, viewer, towards.as_dvec3());
                sum += sky.radiance(towards).as_dvec3() * reflected * solid_angle;
            }
        }
    }
    sum
}

#[test]
fn environments_reflect_as_the_integral_over_all_of_their_light() {
    let sky = sky();
    // Seen along the normal, maps are that integral; seen from aside, highlights are longer than they are wide, which
    // no map by roughness alone can have.
    // The lights are few, small and bright.
    let along = [(0.25f32, 0.0, 0.04), (0.5, 0.0, 0.03), (0.8, 0.0, 0.04)];
    let from_aside = [(0.25f32, 1.0, 0.08), (0.5, 1.0, 0.2), (0.8, 1.0, 0.14)];
    for (roughness, aside, bound) in along.into_iter().chain(from_aside) {
        for metallic in [0.0, 1.0] {
            let base = Vec3::new(0.9, 0.6, 0.3);
            let microfacets = Microfacets { metallic, roughness, ..Microfacets::default() };
            let material =
                Material { base_color: base.extend(1.0), microfacets: Some(microfacets), ..Material::default() };
            let mut scene = scene(material);
            scene.environment = Some(Arc::new(sky.clone()));
            let (mut error, mut sum) = (0.0, 0.0);
            let mut random = Stream::new(5);
            for _ in 0..24 {
                let mut number = || random.next_between(-1.0, 1.0);
                let normal = Vec3::new(number(), number(), number()).normalize_or(Vec3::Y);
                let across = normal.any_orthonormal_vector();
                let viewer = (normal + across * aside * (1.0 + number())).normalize();
                let found = scene.radiance(&point(normal), viewer).as_dvec3();
                let expected = integrated(
                    &sky,
                    base.as_dvec3(),
                    metallic.into(),
                    roughness.into(),
                    normal.as_dvec3(),
                    viewer.as_dvec3(),
                );
                error += (found - expected).abs().element_sum();
                sum += expected.element_sum();
            }
            assert!(error < bound * sum, "{roughness} {aside} {metallic}: off by {} of {sum}", error / sum);
        }
    }
}

#[test]
fn a_white_furnace_is_never_brighter_than_itself() {
    for roughness in [0.0, 0.2, 0.5, 1.0] {
        for metallic in [0.0, 0.5, 1.0] {
            for coat in [0.0, 0.4] {
                let microfacets =
                    Microfacets { metallic, roughness, coat, coat_roughness: 0.3, ..Microfacets::default() };
                let mut scene = scene(Material { microfacets: Some(microfacets), ..Material::default() });
                scene.environment = Some(Arc::new(Environment::new("white", 16, 8, vec![[1.0; 3]; 128])));
                for n_v in [0.05f32, 0.4, 1.0] {
                    let viewer = Vec3::new((1.0 - n_v * n_v).sqrt(), 0.0, n_v);
                    let found = scene.radiance(&point(Vec3::Z), viewer).x;
                    // Rough facets lose what they reflect to each other: single scattering.
                    assert!(found < 1.01, "{roughness} {metallic} {coat} {n_v}: {found}");
                    assert!(
                        found > 0.97 || roughness > 0.4 || n_v < 0.1,
                        "{roughness} {metallic} {coat} {n_v}: {found}"
                    );
                    assert!(found > 0.3, "{roughness} {metallic} {coat} {n_v}: {found}");
                }
            }
        }
    }
}
