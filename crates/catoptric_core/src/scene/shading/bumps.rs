//! Mirrors and lenses with normal maps.

use super::shade::{SurfaceInteraction, SurfacePoint};
use crate::scene::{Material, Scene};
use glam::{Vec2, Vec3};

/// The step over which the change of a normal is found, in pixels.
const STEP_PX: f32 = 0.5;

impl Scene {
    /// A point's unit normal on the outer side, turned by the material's normal map where there is one: its mean over
    /// the point's footprint.
    #[inline(always)]
    pub fn turned_normal(&self, material: &Material, point: &SurfacePoint) -> Vec3 {
        match material.normal_map {
            Some(_) => self.normal_of_map(material, point, point.normal, Vec2::ZERO),
            None => point.normal,
        }
    }

    /// [`Self::turned_normal`] and its change with the pixel's column and row.
    #[inline(always)]
    pub fn turned_normal_and_change(&self, material: &Material, encounter: &SurfaceInteraction) -> (Vec3, [Vec3; 2]) {
        match material.normal_map {
            Some(_) => self.normal_of_map_and_change(material, encounter),
            None => (encounter.point.normal, encounter.normal_change),
        }
    }

    #[inline(never)] // rarely needed
    fn normal_of_map_and_change(&self, material: &Material, encounter: &SurfaceInteraction) -> (Vec3, [Vec3; 2]) {
        let point = &encounter.point;
        let normal = self.normal_of_map(material, point, point.normal, Vec2::ZERO);
        let change = |axis: usize, pixels: Vec2| {
            let smooth = (point.normal + encounter.normal_change[axis] * STEP_PX).normalize_or(point.normal);
            (self.normal_of_map(material, point, smooth, pixels * STEP_PX) - normal) / STEP_PX
        };
        (normal, [change(0, Vec2::X), change(1, Vec2::Y)])
    }

    /// The normal so many pixels beside a point, where the smooth one is given.
    #[inline(never)] // rarely needed
    fn normal_of_map(&self, material: &Material, point: &SurfacePoint, smooth: Vec3, pixels: Vec2) -> Vec3 {
        let Some(map) = &material.normal_map else { return smooth };
        // Without a direction on the surface (exact surfaces have none) a map says nothing.
        let Some(tangent) = point.tangent.truncate().reject_from_normalized(smooth).try_normalize() else {
            return smooth;
        };
        let channel = map.binding.uv_channel as usize & 1;
        let mut beside = *point;
        let footprint = &point.footprints[channel];
        beside.uvs[channel] += footprint.dx * pixels.x + footprint.dy * pixels.y;
        let mean = self.sample(&map.binding, &beside).truncate() * 2.0 - 1.0;
        let bitangent = smooth.cross(tangent) * point.tangent.w;
        let turned = tangent * (mean.x * map.scale) + bitangent * (mean.y * map.scale) + smooth * mean.z;
        turned.try_normalize().unwrap_or(smooth)
    }
}
