//! Shadows: how much of a light arrives where it shines on.

use super::{Light, Scene};
use crate::math::lanes::{Lanes, Vec3Lanes};
use glam::{Vec2, Vec3};

/// Where light is sought from.
#[derive(Clone, Copy, Debug, Default)]
pub(super) struct ShadowStart {
    /// A point above the surface, on the viewers' side.
    pub(super) origin: Vec3,
}

/// Rays start so far from the surface, in units of rounding of the coordinates.
const OFFSET: f32 = 32.0 * f32::EPSILON;

impl ShadowStart {
    pub(super) const NONE: Self = Self { origin: Vec3::ZERO };

    /// The start at a place of a triangle; `side` is -1 for views of its back, else 1.
    ///
    /// Corners' normals bend the triangle: where that makes it bulge, light is sought from the bulge (Hanika 2021,
    /// Hacking the shadow terminator). From the flat triangle, neighbours would cast shadows that show their edges.
    #[inline]
    pub(super) fn on_triangle(scene: &Scene, triangle: u32, at: Vec2, side: f32) -> Self {
        let corners = scene.triangles[triangle as usize];
        let [a, b, c] = corners.map(|vertex| scene.positions[vertex as usize]);
        let [na, nb, nc] = corners.map(|vertex| scene.normals[vertex as usize]);
        // At the rim of what a pixel shows its middle may lie beside the triangle, where the plane may be inside.
        let at = at.max(Vec2::ZERO);
        let at = at / (at.x + at.y).max(1.0);
        let weights = [1.0 - at.x - at.y, at.x, at.y];
        let (ab, ac) = (b - a, c - a);
        let position = a + ab * at.x + ac * at.y;
        let face = ab.cross(ac);
        let face = if face.dot(na + nb + nc) < 0.0 { -face } else { face };
        let face = face.normalize_or(na) * side;
        let mut bulge = Vec3::ZERO;
        for (weight, (corner, normal)) in weights.into_iter().zip([(a, na), (b, nb), (c, nc)]) {
            let normal = normal * side;
            let below = (position - corner).dot(normal);
            // A corner of another direction than the face would tear the point off.
            if below < 0.0 && normal.dot(face) > 0.5 {
                bulge -= normal * (weight * below);
            }
        }
        let size = a.abs().max(b.abs()).max(c.abs()).max_element();
        Self { origin: position + bulge + face * (OFFSET * size.max(f32::MIN_POSITIVE)) }
    }

    /// The start at a point of an exact surface, with its unit normal towards the viewer.
    #[inline]
    pub(super) fn on_surface(position: Vec3, normal: Vec3, coordinate_size: f32) -> Self {
        Self { origin: position + normal * (OFFSET * coordinate_size.max(f32::MIN_POSITIVE)) }
    }

    /// The share of a light that arrives here; without means to tell, all of it.
    #[inline]
    pub(super) fn passing(&self, scene: &Scene, light: &Light) -> Vec3 {
        let Some(visibility) = &scene.light_visibility else { return Vec3::ONE };
        let way = light.way_from(self.origin);
        way.map_or(Vec3::ONE, |(ray, distance)| visibility.passing(scene, &ray, distance))
    }
}

/// Takes light away at points that it does not reach, or not all of it: `starts` by lane, of those lanes that matter.
#[inline(always)]
pub(super) fn hide<const N: usize>(
    scene: &Scene,
    light: &Light,
    starts: impl Iterator<Item = (usize, ShadowStart)>,
    (strength, color): (&mut Lanes<N>, &mut Vec3Lanes<N>),
) {
    let Some(visibility) = &scene.light_visibility else { return };
    let (mut lanes, mut points, mut count) = ([0usize; N], [Vec3::ZERO; N], 0);
    for (lane, start) in starts.take(N) {
        (lanes[count], points[count]) = (lane, start.origin);
        count += 1;
    }
    let mut passing = [Vec3::ONE; N];
    visibility.find_passing(scene, light, &points[..count], &mut passing[..count]);
    for (lane, passing) in lanes[..count].iter().zip(passing) {
        if passing == Vec3::ZERO {
            strength[*lane] = 0.0;
        } else if passing != Vec3::ONE {
            color.set(*lane, color.vector(*lane) * passing);
        }
    }
}
