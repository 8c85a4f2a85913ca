//! Normals that a map turns, and mirrors and lenses with such maps.

use super::shade::{SurfaceInteraction, SurfacePoint};
use crate::scene::{Material, NormalMap, Scene};
use glam::{Vec2, Vec3, Vec4};
use std::borrow::Cow;

/// The step over which the change of a normal is found, in pixels.
const STEP_PX: f32 = 0.5;

impl NormalMap {
    /// A unit normal, turned by a mean of the map's normals. The tangent along the map's u may have any length; `side`
    /// is -1 where the normal is turned over: the map's frame then turns over as a whole. Without a direction on the
    /// surface (exact surfaces have none) a map says nothing.
    #[inline(always)] // for the instructions of its caller
    pub(super) fn turned(&self, smooth: Vec3, tangent: Vec4, side: f32, mean: Vec3) -> Vec3 {
        let Some(along) = tangent.truncate().reject_from_normalized(smooth).try_normalize() else { return smooth };
        let bitangent = smooth.cross(along) * (tangent.w * side);
        let [x, y] = [mean.x * self.scale * side, mean.y * self.scale * side];
        (along * x + bitangent * y + smooth * mean.z).try_normalize().unwrap_or(smooth)
    }
}

impl Scene {
    /// A point's unit normal on the outer side, turned by the material's normal map where there is one: its mean over
    /// the point's footprint.
    #[inline(always)]
    pub fn turned_normal(&self, material: &Material, point: &SurfacePoint) -> Vec3 {
        match &material.normal_map {
            Some(map) => self.normal_of_map(map, point, point.normal, Vec2::ZERO),
            None => point.normal,
        }
    }

    /// An encounter with the normal of [`Self::turned_normal`], and its change with the pixel's column and row. Light
    /// of the surface's own is that of the encounter which is given: there the map is still to turn the normal.
    #[inline(always)]
    pub fn turned_encounter<'a>(
        &self,
        material: &Material,
        encounter: &'a SurfaceInteraction,
    ) -> Cow<'a, SurfaceInteraction> {
        match &material.normal_map {
            Some(map) => Cow::Owned(self.encounter_of_map(map, encounter)),
            None => Cow::Borrowed(encounter),
        }
    }

    #[inline(never)] // rarely needed
    fn encounter_of_map(&self, map: &NormalMap, encounter: &SurfaceInteraction) -> SurfaceInteraction {
        let point = &encounter.point;
        let normal = self.normal_of_map(map, point, point.normal, Vec2::ZERO);
        let change = |axis: usize, pixels: Vec2| {
            let smooth = (point.normal + encounter.normal_change[axis] * STEP_PX).normalize_or(point.normal);
            (self.normal_of_map(map, point, smooth, pixels * STEP_PX) - normal) / STEP_PX
        };
        let normal_change = [change(0, Vec2::X), change(1, Vec2::Y)];
        SurfaceInteraction { point: SurfacePoint { normal, ..*point }, normal_change, ..*encounter }
    }

    /// The normal so many pixels beside a point, where the smooth one is given.
    #[inline(never)] // rarely needed
    fn normal_of_map(&self, map: &NormalMap, point: &SurfacePoint, smooth: Vec3, pixels: Vec2) -> Vec3 {
        let channel = map.binding.uv_channel as usize & 1;
        let mut beside = *point;
        let footprint = &point.footprints[channel];
        beside.uvs[channel] += footprint.dx * pixels.x + footprint.dy * pixels.y;
        let mean = self.sample(&map.binding, &beside).truncate() * 2.0 - 1.0;
        map.turned(smooth, point.tangent, 1.0, mean)
    }
}
