//! Distributions of facets.

use catoptric_core::math::random::Stream;
use catoptric_core::scene::microfacets::{
    LEAST_ROUGHNESS, ReflectanceTable, grazing_share, lobe, unshadowed_share, variance_of_mean, visible_facet,
    widened_alpha,
};
use glam::{Vec2, Vec3};
use std::f32::consts::TAU;

/// The reflectance of facets that reflect all light, or, by `weight` of the cosine between light and half vector, a
/// share: an integral over all directions of light, by a grid that is fine where the mirror direction is.
fn reflectance(alpha: f32, n_v: f32, weight: impl Fn(f32) -> f32) -> f64 {
    let viewer = Vec3::new((1.0 - n_v * n_v).sqrt(), 0.0, n_v);
    let (rings, spokes) = (2000, 256);
    let mut sum = 0.0f64;
    for ring in 0..rings {
        // Half vectors by the tangent of their angle to the normal: most are within alpha.
        let share = (ring as f64 + 0.5) / rings as f64;
        let tangent = f64::from(alpha) * share / (1.0 - share);
        let slope_step = f64::from(alpha) / ((1.0 - share) * (1.0 - share)) / rings as f64;
        let cosine = 1.0 / (1.0 + tangent * tangent).sqrt();
        // Solid angle: sine times the step of the angle, which is the tangent's times the squared cosine.
        let solid_angle = tangent * cosine * cosine * cosine * slope_step * std::f64::consts::TAU / spokes as f64;
        for spoke in 0..spokes {
            let azimuth = (spoke as f64 + 0.5) / spokes as f64 * std::f64::consts::TAU;
            let sine = tangent * cosine;
            let half = Vec3::new((sine * azimuth.cos()) as f32, (sine * azimuth.sin()) as f32, cosine as f32);
            let v_h = viewer.dot(half);
            let light = half * (2.0 * v_h) - viewer;
            if v_h <= 0.0 || light.z <= 0.0 {
                continue;
            }
            let value = lobe(alpha, (cosine * cosine) as f32, (sine * sine) as f32, light.z, n_v) * light.z;
            // Directions of light are spread four times their cosine wider than half vectors.
            sum += f64::from(value * weight(v_h) * 4.0 * v_h) * solid_angle;
        }
    }
    sum
}

#[test]
fn the_table_is_the_integral_over_all_light_and_no_more_than_all_of_it() {
    let table = ReflectanceTable::get();
    for roughness in [0.1f32, 0.25, 0.4, 0.55, 0.7, 0.85, 1.0] {
        for n_v in [0.08, 0.2, 0.45, 0.7, 0.95, 1.0] {
            let alpha = roughness * roughness;
            let found = table.reflected(roughness, n_v);
            let found = Vec2::new(found.at_normal, found.at_grazing);
            let at_normal = reflectance(alpha, n_v, |cosine| 1.0 - grazing_share(cosine));
            let at_grazing = reflectance(alpha, n_v, grazing_share);
            let errors = [f64::from(found.x) - at_normal, f64::from(found.y) - at_grazing];
            assert!(
                errors.iter().all(|error| error.abs() < 0.006),
                "{roughness} {n_v}: {found} {at_normal} {at_grazing}"
            );
            assert!(at_normal + at_grazing < 1.002 && found.x + found.y < 1.002, "{roughness} {n_v}: {found}");
        }
    }
    // Smooth facets reflect all light, and by Schlick's formula.
    for n_v in [0.25, 0.5, 1.0] {
        let found = table.reflected(LEAST_ROUGHNESS, n_v);
        let found = Vec2::new(found.at_normal, found.at_grazing);
        assert!((found.x + found.y - 1.0).abs() < 2e-3 && (found.y - grazing_share(n_v)).abs() < 5e-3, "{found}");
    }
}

#[test]
fn light_and_viewer_can_change_places() {
    let mut random = Stream::new(3);
    for _ in 0..500 {
        let mut direction = || {
            let z = random.next_between(0.01, 1.0);
            let azimuth = random.next_between(0.0, TAU);
            let sine = (1.0 - z * z).sqrt();
            Vec3::new(sine * azimuth.cos(), sine * azimuth.sin(), z)
        };
        let (a, b) = (direction(), direction());
        let half = (a + b).normalize();
        let (cosine2, sine2) = (half.z * half.z, half.x * half.x + half.y * half.y);
        for alpha in [0.01, 0.3, 1.0] {
            let (there, back) = (lobe(alpha, cosine2, sine2, a.z, b.z), lobe(alpha, cosine2, sine2, b.z, a.z));
            assert!((there - back).abs() <= 1e-5 * there, "{there} {back}");
        }
    }
}

#[test]
fn highlights_are_brightest_in_the_mirror_direction_and_as_wide_as_the_distribution_says() {
    for alpha in [0.01f32, 0.1, 0.4] {
        // Seen and lit along the normal, masking plays no part: the value is half of the peak's where the tangent of
        // the half vector's angle is alpha times the root of the root of two less one.
        let at = |tangent: f32| {
            let cosine2 = 1.0 / (1.0 + tangent * tangent);
            lobe(alpha, cosine2, tangent * tangent * cosine2, 1.0, 1.0)
        };
        let peak = at(0.0);
        assert!((peak * 4.0 * std::f32::consts::PI * alpha * alpha - 1.0).abs() < 1e-4, "{peak}");
        // The distribution falls with the fourth power of the cosine, too.
        let tangent = alpha * (2.0f32.sqrt() - 1.0).sqrt();
        let expected = 0.5 * peak * (1.0 + tangent * tangent).powi(2);
        assert!((at(tangent) / expected - 1.0).abs() < 1e-3, "{alpha}: {} {expected}", at(tangent));
    }
}

#[test]
fn chosen_facets_are_seen_and_light_of_all_of_them_is_white() {
    for (alpha, n_v) in [(0.05, 0.9), (0.3, 0.3), (0.7, 0.6), (1.0, 0.1)] {
        let viewer = Vec3::new(0.0, (1.0f32 - n_v * n_v).sqrt(), n_v);
        let mut sum = 0.0f64;
        let side = 256;
        for place in 0..side * side {
            let number = Vec2::new((place % side) as f32 + 0.5, (place / side) as f32 + 0.5) / side as f32;
            let facet = visible_facet(alpha, viewer, number);
            assert!(facet.is_normalized() && facet.z > 0.0 && facet.dot(viewer) > -1e-4, "{facet}");
            let light = facet * (2.0 * viewer.dot(facet)) - viewer;
            sum += f64::from(unshadowed_share(alpha, light.z, n_v));
        }
        let mean = sum / (side * side) as f64;
        let expected = reflectance(alpha, n_v, |_| 1.0);
        assert!((mean - expected).abs() < 4e-3, "{alpha} {n_v}: {mean} {expected}");
    }
}

#[test]
fn normals_that_vary_widen_highlights_as_their_mean_does() {
    // Slopes of normal distribution, averaged: the mean normal's length gives their variance back.
    let deviation = 0.12f32;
    let mut random = Stream::new(12);
    let (mut mean, mut lit, mut single) = (Vec3::ZERO, [0.0f32; 3], [0.0f32; 3]);
    let alpha = 0.08f32;
    let half_tangents = [0.0f32, 0.1, 0.25];
    let count = 100_000;
    for _ in 0..count {
        let (radius, angle) = ((-2.0 * (1.0 - random.next_unit()).ln()).sqrt(), random.next_between(0.0, TAU));
        let slope = Vec2::from_angle(angle) * (radius * deviation);
        let normal = Vec3::new(-slope.x, -slope.y, 1.0).normalize();
        mean += normal / count as f32;
        for (lit, tangent) in lit.iter_mut().zip(half_tangents) {
            let half = Vec3::new(tangent, 0.0, 1.0).normalize();
            let cosine2 = normal.dot(half).powi(2);
            *lit += lobe(alpha, cosine2, 1.0 - cosine2, 1.0, 1.0) / count as f32;
        }
    }
    let variance = variance_of_mean(mean.length());
    assert!((variance / (2.0 * deviation * deviation) - 1.0).abs() < 0.1, "{variance}");
    let widened = widened_alpha(alpha, variance);
    for (single, tangent) in single.iter_mut().zip(half_tangents) {
        let cosine2 = 1.0 / (1.0 + tangent * tangent);
        *single = lobe(widened, cosine2, tangent * tangent * cosine2, 1.0, 1.0);
    }
    // Sharp highlights on every bump, against one wide one: a mean of lobes has another shape than a lobe.
    for (lit, single) in lit.iter().zip(single) {
        assert!((single / lit - 1.0).abs() < 0.3, "{single} for {lit}");
    }
    // Without the variance, the highlight is many times too bright in its middle.
    assert!(lobe(alpha, 1.0, 0.0, 1.0, 1.0) > 4.0 * lit[0]);
    assert_eq!(variance_of_mean(1.0 - 1e-5), 0.0, "rounding is no variance");
}
