//! Normals that a map turns, and mirrors and lenses with such maps.

use super::microfacets::{variance_of_mean, variance_over_pixel, widened_alpha};
use super::sample_patterns::SAMPLE_PATTERNS;
use super::shade::{SurfaceInteraction, SurfacePoint};
use crate::math::lanes::LANES;
use crate::math::portable::PortableMath;
use crate::scene::{Material, NormalMap, Role, Scene, UvFootprint};
use glam::{Vec2, Vec3, Vec4};
use std::borrow::Cow;

/// The step over which the change of a normal is found, in pixels.
const STEP_PX: f32 = 0.5;

/// Bumps smaller than a pixel whose variance is below this share of the facets' own do not spread highlights.
const HARDLY_SPREAD: f32 = 0.1;

/// A point of a surface with its normal turned by a map.
#[derive(Clone, Debug)]
pub struct TurnedEncounter<'a> {
    /// The encounter with the mean normal over the point's footprint, and its change with the pixel's column and row.
    pub encounter: Cow<'a, SurfaceInteraction>,
    /// How much normals differ within the footprint, as for
    /// [`widened_alpha`](super::microfacets::widened_alpha): what the mean does not show.
    pub variance: f32,
}

impl Material {
    /// The width of the facets' distribution (alpha of Trowbridge and Reitz) with which a mirror, coat or lens shows
    /// surfaces: that of its roughness, widened by what its normal map hides within a footprint, as
    /// [`TurnedEncounter::variance`] says.
    #[inline]
    pub fn facets_alpha(&self, variance: f32) -> f32 {
        match self.role {
            Role::Diffuse => 0.0,
            Role::Reflector | Role::Coated | Role::Lens => widened_alpha(self.reflection_roughness().powi(2), variance),
        }
    }
}

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

impl SurfacePoint {
    /// The same with a part of its footprints in textures: so many pixels beside the middle, of a side in pixels, and
    /// for one sample.
    #[must_use]
    fn with_part_of_textures(&self, offset_px: Vec2, side_px: f32) -> Self {
        let mut point = *self;
        for (uv, footprint) in point.uvs.iter_mut().zip(&mut point.footprints) {
            *uv += footprint.dx * offset_px.x + footprint.dy * offset_px.y;
            *footprint = UvFootprint { dx: footprint.dx * side_px, dy: footprint.dy * side_px, samples: 1 };
        }
        point
    }
}

impl SurfaceInteraction {
    /// A part of what a ray meets, to first order: so many pixels beside the middle, and of a side in pixels.
    #[must_use]
    pub fn part(&self, offset_px: Vec2, side_px: f32) -> Self {
        let moved = |[dx, dy]: [Vec3; 2]| dx * offset_px.x + dy * offset_px.y;
        let mut point = self.point.with_part_of_textures(offset_px, side_px);
        point.position += moved(self.position_change);
        point.normal = (point.normal + moved(self.normal_change)).normalize_or(point.normal);
        point.normal_change2 *= side_px * side_px;
        Self {
            point,
            position_change: self.position_change.map(|change| change * side_px),
            normal_change: self.normal_change.map(|change| change * side_px),
        }
    }
}

impl Scene {
    /// A point's unit normal on the outer side, turned by the material's normal map where there is one: its mean over
    /// the point's footprint.
    #[inline(always)]
    pub fn turned_normal(&self, material: &Material, point: &SurfacePoint) -> Vec3 {
        self.turned_normal_and_variance(material, point).0
    }

    /// The same, and how much normals differ within the footprint ([`TurnedEncounter::variance`]).
    #[inline(always)]
    pub fn turned_normal_and_variance(&self, material: &Material, point: &SurfacePoint) -> (Vec3, f32) {
        match material.turning_map() {
            Some(map) => self.normal_of_map(map, point),
            None => (point.normal, 0.0),
        }
    }

    /// An encounter with the normal of [`Self::turned_normal`]. Light of the surface's own is that of the encounter
    /// which is given: there the map is still to turn the normal.
    #[inline(always)]
    pub fn turned_encounter<'a>(&self, material: &Material, encounter: &'a SurfaceInteraction) -> TurnedEncounter<'a> {
        match material.turning_map() {
            Some(map) => self.encounter_of_map(map, encounter),
            None => TurnedEncounter { encounter: Cow::Borrowed(encounter), variance: 0.0 },
        }
    }

    /// [`Self::turned_normal_and_variance`] of points of a surface with this normal map: sets as many of `found` as
    /// there are points. Several are looked up at a time.
    pub fn normals_of_map(&self, map: &NormalMap, points: &[SurfacePoint], found: &mut [(Vec3, f32)]) {
        for (points, found) in points.chunks(LANES).zip(found.chunks_mut(LANES)) {
            let mut means = [Vec4::ZERO; LANES];
            self.sample_at(&map.binding, points, &mut means);
            for ((point, mean), found) in points.iter().zip(&means).zip(found) {
                *found = self.normal_by_mean(map, point, *mean);
            }
        }
    }

    #[inline(never)] // rarely needed
    fn encounter_of_map(&self, map: &NormalMap, encounter: &SurfaceInteraction) -> TurnedEncounter<'static> {
        let point = &encounter.point;
        let beside = |axis: usize, pixels: Vec2| {
            let smooth = (point.normal + encounter.normal_change[axis] * STEP_PX).normalize_or(point.normal);
            let moved = point.with_part_of_textures(pixels * STEP_PX, 1.0);
            SurfacePoint { normal: smooth, footprints: point.footprints, ..moved }
        };
        let mut normals = [(Vec3::ZERO, 0.0); 3];
        self.normals_of_map(map, &[*point, beside(0, Vec2::X), beside(1, Vec2::Y)], &mut normals);
        let [(normal, variance), (right, _), (below, _)] = normals;
        let normal_change = [right, below].map(|beside| (beside - normal) / STEP_PX);
        let point = SurfacePoint { normal, ..*point };
        let encounter = Cow::Owned(SurfaceInteraction { point, normal_change, ..*encounter });
        TurnedEncounter { encounter, variance }
    }

    /// The normal of a point, and how much it differs from others in the footprint.
    #[inline(never)] // rarely needed
    fn normal_of_map(&self, map: &NormalMap, point: &SurfacePoint) -> (Vec3, f32) {
        self.normal_by_mean(map, point, self.sample(&map.binding, point))
    }

    /// The same of a point by what the map's texture says there.
    fn normal_by_mean(&self, map: &NormalMap, point: &SurfacePoint, texture: Vec4) -> (Vec3, f32) {
        let mean = texture.truncate() * 2.0 - 1.0;
        // Within a texel normals are blended, which makes them shorter, but each is that of a place.
        let hidden = self.texels_across(&map.binding, point).logarithm2().clamp(0.0, 1.0);
        let variance = variance_of_mean(mean.length()) * (map.scale * map.scale) * hidden;
        match point.tangent.truncate() == Vec3::ZERO {
            true => (point.normal, 0.0),
            false => (map.turned(point.normal, point.tangent, 1.0, mean), variance),
        }
    }

    /// The normals that mirror lights within a point's footprint on a surface of such facets, each with the width of
    /// the facets' distribution about it; how many there are comes second. Where bumps spread highlights, and the point
    /// stands for several samples of a pixel, they are those at the places of four of them.
    pub(super) fn normals_of_highlights(
        &self,
        material: &Material,
        point: &SurfacePoint,
        alpha: f32,
    ) -> ([(Vec3, f32); 4], usize) {
        let smooth_variance = variance_over_pixel(point.normal_change2);
        let Some(map) = material.turning_map() else {
            return ([(point.normal, widened_alpha(alpha, smooth_variance)); 4], 1);
        };
        let facets = |(normal, variance): (Vec3, f32)| (normal, widened_alpha(alpha, variance + smooth_variance));
        let whole = self.normal_of_map(map, point);
        if point.footprints[0].samples <= 1 || whole.1 <= HARDLY_SPREAD * alpha * alpha {
            return ([facets(whole); 4], 1);
        }
        let part = |place: usize| {
            let offset = SAMPLE_PATTERNS[2][place].map(|sixteenths| f32::from(sixteenths) / 16.0 - 0.5);
            point.with_part_of_textures(offset.into(), 0.5)
        };
        let mut parts = [(Vec3::ZERO, 0.0); 4];
        self.normals_of_map(map, &[part(0), part(1), part(2), part(3)], &mut parts);
        (parts.map(facets), 4)
    }
}
