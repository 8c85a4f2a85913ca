//! Light that arrives at many points.

use super::super::super::{Light, LightKind, Scene};
use crate::math::lanes::{Lanes, Vec3Lanes};

/// Sets the arriving irradiance at the first `count` points, over pi. Normals are of unit length and towards the
/// viewers, whose directions are of any length.
#[inline(always)]
#[allow(clippy::needless_range_loop)] // lanes of several arrays, for the vectoriser
pub(super) fn irradiance_over_pi<const N: usize>(
    scene: &Scene,
    positions: &Vec3Lanes<N>,
    normals: &Vec3Lanes<N>,
    viewers: &Vec3Lanes<N>,
    count: usize,
    sum: &mut Vec3Lanes<N>,
) {
    if scene.lights.is_empty() && scene.environment.is_none() {
        for i in 0..N {
            let [x, y, z] = viewers.components(i);
            let length2 = x * x + y * y + z * z;
            let cosine = (normals[0][i] * x + normals[1][i] * y + normals[2][i] * z) / length2.sqrt();
            let cosine = if cosine > 0.0 { cosine } else { 0.0 };
            (sum[0][i], sum[1][i], sum[2][i]) = (cosine, cosine, cosine);
        }
        return;
    }
    for channel in 0..3 {
        sum[channel] = Lanes::ZERO;
    }
    for light in &scene.lights {
        add(light, positions, normals, sum);
    }
    if let Some(environment) = &scene.environment {
        for i in 0..count.min(N) {
            let irradiance = environment.irradiance(normals.vector(i));
            for channel in 0..3 {
                sum[channel][i] += irradiance[channel];
            }
        }
    }
    sum.iter_mut().for_each(|channel| *channel *= std::f32::consts::FRAC_1_PI);
}

/// Adds what a light gives to surfaces: [`Light::arriving`] times the cosine.
#[inline(always)]
#[allow(clippy::needless_range_loop)]
fn add<const N: usize>(light: &Light, positions: &Vec3Lanes<N>, normals: &Vec3Lanes<N>, sum: &mut Vec3Lanes<N>) {
    let [red, green, blue] = light.intensity.to_array();
    let (range, inner_cos, outer_cos) = match light.kind {
        LightKind::Directional => {
            let towards = -light.direction;
            for i in 0..N {
                let cosine = normals[0][i] * towards.x + normals[1][i] * towards.y + normals[2][i] * towards.z;
                let cosine = if cosine > 0.0 { cosine } else { 0.0 };
                sum[0][i] += cosine * red;
                sum[1][i] += cosine * green;
                sum[2][i] += cosine * blue;
            }
            return;
        }
        // A point light is a spot that has not begun to fade behind itself.
        LightKind::Point { range } => (range, -3.0, -4.0),
        LightKind::Spot { range, inner_cos, outer_cos } => (range, inner_cos, outer_cos),
    };
    let inverse_range2 = if range.is_finite() { 1.0 / (range * range) } else { 0.0 };
    let inverse_fade = 1.0 / (inner_cos - outer_cos).max(1e-4);
    let (at, shines) = (light.position, light.direction);
    for i in 0..N {
        let [x, y, z] = [at.x - positions[0][i], at.y - positions[1][i], at.z - positions[2][i]];
        let distance2 = x * x + y * y + z * z;
        let distance2 = if distance2 > 1e-12 { distance2 } else { 1e-12 };
        let inverse = 1.0 / distance2.sqrt();
        let cosine = (normals[0][i] * x + normals[1][i] * y + normals[2][i] * z) * inverse;
        let cosine = if cosine > 0.0 { cosine } else { 0.0 };
        let ratio2 = distance2 * inverse_range2;
        let window = 1.0 - ratio2 * ratio2;
        let window = if window > 0.0 { window } else { 0.0 };
        let fade = (-(shines.x * x + shines.y * y + shines.z * z) * inverse - outer_cos) * inverse_fade;
        let fade = if fade > 0.0 { fade } else { 0.0 };
        let fade = if fade < 1.0 { fade } else { 1.0 };
        let strength = cosine * window * (fade * fade) / distance2;
        sum[0][i] += strength * red;
        sum[1][i] += strength * green;
        sum[2][i] += strength * blue;
    }
}
