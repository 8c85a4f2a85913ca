//! Light that arrives at many points.

use super::super::shadows::{ShadowStart, hide};
use super::super::{Environment, Light, LightKind, Scene, Sky};
use crate::math::lanes::{Lanes, Vec3Lanes};
use glam::Vec2;

/// A light as several points see it.
pub(super) struct ArrivingLight<const N: usize> {
    /// Unit directions to it.
    pub(super) towards: Vec3Lanes<N>,
    /// The factor on its colour that gives the irradiance of surfaces that face it.
    pub(super) strength: Lanes<N>,
    /// The light's intensity, as far as it passes what stands before it.
    pub(super) color: Vec3Lanes<N>,
}

impl<const N: usize> ArrivingLight<N> {
    pub(super) const NONE: Self = Self { towards: Vec3Lanes::ZERO, strength: Lanes::ZERO, color: Vec3Lanes::ZERO };

    /// Sets [`Light::arriving`] of all points.
    #[inline(always)]
    #[allow(clippy::needless_range_loop)] // lanes of several arrays, for the vectoriser
    pub(super) fn set(&mut self, light: &Light, positions: &Vec3Lanes<N>) {
        self.color = Vec3Lanes::splat(light.intensity);
        let (range, inner_cos, outer_cos) = match light.kind {
            LightKind::Directional => {
                (self.towards, self.strength) = (Vec3Lanes::splat(-light.direction), Lanes::splat(1.0));
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
            let ratio2 = distance2 * inverse_range2;
            let window = 1.0 - ratio2 * ratio2;
            let window = if window > 0.0 { window } else { 0.0 };
            let fade = (-(shines.x * x + shines.y * y + shines.z * z) * inverse - outer_cos) * inverse_fade;
            let fade = if fade > 0.0 { fade } else { 0.0 };
            let fade = if fade < 1.0 { fade } else { 1.0 };
            self.strength[i] = window * (fade * fade) / distance2;
            (self.towards[0][i], self.towards[1][i], self.towards[2][i]) = (x * inverse, y * inverse, z * inverse);
        }
    }
}

/// The cosines of a headlight at each point: viewers' directions are of any length.
#[inline(always)]
#[allow(clippy::needless_range_loop)]
pub(super) fn headlight<const N: usize>(normals: &Vec3Lanes<N>, viewers: &Vec3Lanes<N>) -> Lanes<N> {
    let mut cosines = Lanes::ZERO;
    for i in 0..N {
        let [x, y, z] = viewers.components(i);
        let length2 = x * x + y * y + z * z;
        let cosine = (normals[0][i] * x + normals[1][i] * y + normals[2][i] * z) / length2.sqrt();
        cosines[i] = if cosine > 0.0 { cosine } else { 0.0 };
    }
    cosines
}

/// Adds what a light gives to surfaces, times pi: its irradiance times the cosine.
#[inline(always)]
#[allow(clippy::needless_range_loop)]
pub(super) fn add_scattered<const N: usize>(
    arriving: &ArrivingLight<N>,
    normals: &Vec3Lanes<N>,
    sum: &mut Vec3Lanes<N>,
) {
    let ArrivingLight { towards, strength, color } = arriving;
    for i in 0..N {
        let cosine = normals[0][i] * towards[0][i] + normals[1][i] * towards[1][i] + normals[2][i] * towards[2][i];
        let strength = if cosine > 0.0 { cosine * strength[i] } else { 0.0 };
        sum[0][i] += strength * color[0][i];
        sum[1][i] += strength * color[1][i];
        sum[2][i] += strength * color[2][i];
    }
}

/// The sky as points see it: the share of its light that arrives, for each colour, and where its suns are sought from.
pub(super) struct SeenSky<'a, const N: usize> {
    pub(super) shares: &'a Vec3Lanes<N>,
    pub(super) starts: &'a [ShadowStart; N],
}

/// Adds the environment's irradiance at the first `count` points: of what they see, if that is known.
#[inline(always)]
pub(super) fn add_environment<const N: usize>(
    environment: &Environment,
    normals: &Vec3Lanes<N>,
    count: usize,
    (scene, seen): (&Scene, Option<SeenSky<'_, N>>),
    sum: &mut Vec3Lanes<N>,
) {
    let positions = environment.places(normals);
    if let (Some(sky), Some(seen)) = (&scene.sky, seen) {
        for i in 0..count.min(N) {
            let irradiance = sky.irradiance_at(Vec2::new(positions[0][i], positions[1][i])) * seen.shares.vector(i);
            for channel in 0..3 {
                sum[channel][i] += irradiance[channel];
            }
        }
        add_suns(scene, sky, normals, seen.starts, count, sum);
        return;
    }
    for i in 0..count.min(N) {
        let irradiance = environment.irradiance_at(Vec2::new(positions[0][i], positions[1][i]));
        for channel in 0..3 {
            sum[channel][i] += irradiance[channel];
        }
    }
}

/// Adds the irradiance of a sky's suns where they are seen.
#[inline(never)] // rays cost much more than a call
pub(super) fn add_suns<const N: usize>(
    scene: &Scene,
    sky: &Sky,
    normals: &Vec3Lanes<N>,
    starts: &[ShadowStart; N],
    count: usize,
    sum: &mut Vec3Lanes<N>,
) {
    for sun in sky.suns() {
        let mut arriving = ArrivingLight::NONE;
        arriving.set(sun, &Vec3Lanes::ZERO);
        let cosines = normals.dot(&arriving.towards);
        let facing = (0..count.min(N)).filter(|lane| cosines[*lane] > 0.0).map(|lane| (lane, starts[lane]));
        hide(scene, sun, facing, (&mut arriving.strength, &mut arriving.color));
        add_scattered(&arriving, normals, sum);
    }
}

impl Scene {
    /// Returns true if a headlight shines, as there is no other light.
    #[inline(always)]
    pub(super) fn has_headlight(&self) -> bool {
        self.lights.is_empty() && self.environment.is_none()
    }
}
