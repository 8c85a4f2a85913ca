//! The triangles that rays can meet of the object that they just left.

use super::super::shapes::{ObjectShape, SceneShapes};
use catoptric_core::scene::Scene;
use catoptric_engine::optics::path::bundle::BounceKind;

/// Faces of an object that is not closed count from behind only at this distance from where a ray left it, as a share
/// of its size. Chosen, not measured.
const AROUND: f32 = 0.05;

/// Within a lens its surface is met before things that touch it from without: those beyond by up to this share of
/// their distance. A rounding.
pub(in super::super) const TOUCHING: f32 = 1e-4;

/// The triangles of the last object of a path that its rays can meet.
///
/// Rays of interpolated normals, or of an exact surface, start in the midst of the object's triangles: without this
/// they would meet the triangles that they come from, and leave them through their backs.
#[derive(Clone, Copy, Debug)]
pub(in super::super) struct OwnRule {
    pub(in super::super) object: u32,
    /// True if the rays can meet no triangle of it.
    none: bool,
    /// The rays are on its outer side.
    outside: bool,
    /// Distance from which on faces seen from behind count.
    from_behind: f32,
}

impl OwnRule {
    /// The rule for rays that leave the outer side of an object, or its inner side.
    pub(in super::super) fn new(object: u32, shape: ObjectShape, kind: BounceKind, outside: bool) -> Self {
        let none = shape.is_convex && outside && kind == BounceKind::Reflect;
        let from_behind = if shape.is_closed { f32::INFINITY } else { AROUND * shape.size };
        Self { object, none, outside, from_behind }
    }

    /// True if the object has an inside: the side by which a triangle is met tells whether rays have left it.
    #[inline(always)]
    pub(in super::super) fn is_closed(&self) -> bool {
        self.from_behind == f32::INFINITY
    }

    /// True for the object if rays run within it.
    #[inline(always)]
    pub(in super::super) fn is_around(&self, object: u32) -> bool {
        !self.outside && object == self.object
    }

    /// The distances from which on a triangle counts: met along its winding's normal, and against it. Infinite: never.
    #[inline(always)]
    pub(in super::super) fn distances(&self, scene: &Scene, shapes: &SceneShapes, triangle: u32) -> [f32; 2] {
        let object = scene.triangle_objects[triangle as usize];
        if object != self.object {
            return match (scene.is_one_sided(object), shapes.is_turned(triangle)) {
                (false, _) => [0.0; 2],
                (true, false) => [f32::INFINITY, 0.0],
                (true, true) => [0.0, f32::INFINITY],
            };
        }
        if self.none {
            return [f32::INFINITY; 2];
        }
        // Along the normal of its winding a ray meets a triangle from within, unless that is turned.
        match self.outside == shapes.is_turned(triangle) {
            true => [0.0, self.from_behind],
            false => [self.from_behind, 0.0],
        }
    }
}
