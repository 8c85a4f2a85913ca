//! Reflections in a sequence of planes, in closed form.

use crate::draw::flat_mirrors::{MirrorPlane, Mirrors};
use catoptric_core::scene::Scene;
use catoptric_core::surface::AnalyticSurface;
use catoptric_engine::method::projector::{MAX_BOUNCES, SpecularPath};
use catoptric_engine::optics::path::bundle::{Bounce, BounceKind};
use glam::{DMat3, DVec3};

/// A sequence of mirrors, counted from the eye.
#[derive(Clone, Copy, Debug, Default)]
pub(super) struct Chain {
    planes: [u32; MAX_BOUNCES],
    pub(super) length: usize,
}

/// Start of the rays of a path.
#[derive(Clone, Copy, Debug)]
pub(super) enum ChainStart {
    /// Rays from a point.
    Point(DVec3),
    /// Rays along the direction, from a plane through the point.
    Parallel(DVec3, DVec3),
}

/// A path over all mirrors of a chain.
#[derive(Clone, Copy, Debug)]
pub(super) struct Unfolded {
    /// Start of the path.
    pub(super) eye: DVec3,
    /// The bounce points, from the eye.
    pub(super) bounces: [DVec3; MAX_BOUNCES],
    /// The image of the scene point behind all mirrors: in line with the eye and the first bounce.
    pub(super) image: DVec3,
}

impl ChainStart {
    /// The point from which a ray reaches `target`; returns `None` if the target lies behind the eye's plane.
    fn towards(self, target: DVec3) -> Option<DVec3> {
        match self {
            Self::Point(eye) => Some(eye),
            Self::Parallel(place, direction) => {
                let depth = (target - place).dot(direction);
                (depth > 0.0).then(|| target - direction * depth)
            }
        }
    }
}

impl Chain {
    /// The chain with one more mirror at its end; returns `None` if it is as long as paths get.
    pub(super) fn extended(&self, plane: u32) -> Option<Self> {
        let mut longer = *self;
        *longer.planes.get_mut(self.length)? = plane;
        longer.length += 1;
        Some(longer)
    }

    /// The mirrors, as indices.
    pub(super) fn planes(&self) -> &[u32] {
        &self.planes[..self.length]
    }

    /// The objects of the chain.
    pub(super) fn path(&self, mirrors: &Mirrors) -> SpecularPath {
        let bounce = |plane: &u32| Bounce { object: mirrors.planes[*plane as usize].object, kind: BounceKind::Reflect };
        SpecularPath { bounces: self.planes().iter().map(bounce).collect() }
    }

    /// Image change with the scene point.
    pub(super) fn image_change(&self, mirrors: &Mirrors) -> DMat3 {
        let reflection = |plane: &u32| mirrors.planes[*plane as usize].reflection().matrix3;
        self.planes().iter().map(reflection).fold(DMat3::IDENTITY, |product, next| product * next)
    }

    /// The path to `point`, as if the mirrors went on for ever. Returns `None` if a mirror does not lie between its
    /// neighbours on the path and their images, or turns its blind side to them.
    pub(super) fn unfold(&self, mirrors: &Mirrors, source: ChainStart, point: DVec3) -> Option<Unfolded> {
        let plane = |index: usize| &mirrors.planes[self.planes[index] as usize];
        // Images of the scene point: behind the mirrors from each on.
        let mut images = [DVec3::ZERO; MAX_BOUNCES];
        let mut image = point;
        for index in (0..self.length).rev() {
            image -= plane(index).normal * (2.0 * plane(index).height(image));
            images[index] = image;
        }
        let eye = source.towards(image)?;
        let mut path = Unfolded { eye, bounces: [DVec3::ZERO; MAX_BOUNCES], image };
        let mut from = eye;
        for (index, &image) in images[..self.length].iter().enumerate() {
            let mirror = plane(index);
            let (height, depth) = (mirror.height(from), mirror.height(image));
            let separates = height * depth < 0.0;
            if !separates || (mirror.inside && height > 0.0) {
                return None;
            }
            let share = height / (height - depth);
            from += (image - from) * share;
            // Exactly on the plane, whatever the rounding.
            from -= mirror.normal * mirror.height(from);
            path.bounces[index] = from;
        }
        from.is_finite().then_some(path)
    }
}

impl Mirrors {
    /// True if a point in a mirror's plane lies on the mirror, its border included.
    pub(super) fn contains(&self, scene: &Scene, plane: u32, point: DVec3) -> bool {
        let mirror = &self.planes[plane as usize];
        if let Some(placed) = &scene.objects[mirror.object as usize].surface
            && let AnalyticSurface::Plane { half_width, half_height } = placed.surface
        {
            let axes = placed.world_from_surface.matrix3;
            let relative = point - placed.world_from_surface.translation;
            let along = |axis: DVec3, half: f64| relative.dot(axis).abs() <= half;
            return along(axes.x_axis, half_width) && along(axes.z_axis, half_height);
        }
        mirror.triangles.iter().any(|&triangle| in_triangle(scene, mirror, triangle, point))
    }
}

/// True if a point in the plane of a triangle lies in the triangle, its edges included.
fn in_triangle(scene: &Scene, mirror: &MirrorPlane, triangle: u32, point: DVec3) -> bool {
    let corners = scene.triangles[triangle as usize].map(|vertex| scene.positions[vertex as usize].as_dvec3());
    // Both triangles of an edge see the same two corners and the same area, so no point falls between them.
    let area = |a: DVec3, b: DVec3| mirror.normal.dot((a - point).cross(b - point));
    let areas = [0, 1, 2].map(|k: usize| area(corners[k], corners[(k + 1) % 3]));
    areas.iter().all(|area| *area >= 0.0) || areas.iter().all(|area| *area <= 0.0)
}
