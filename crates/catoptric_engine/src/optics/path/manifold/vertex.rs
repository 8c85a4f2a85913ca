//! Points of the manifold, and the surfaces about them to first order.

use glam::DVec3;

/// The triangle index of sites without a triangle: those of analytic surfaces.
pub const NO_TRIANGLE: u32 = u32::MAX;

/// A point of a specular object.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct ManifoldVertex {
    /// The point, world.
    pub position: DVec3,
    /// Index of the scene's triangle that it lies on, [`NO_TRIANGLE`] on analytic surfaces.
    pub triangle: u32,
    /// Weights of the triangle's second and third vertex; outside 0 to 1 where a site continues beyond a border.
    pub barycentrics: [f64; 2],
}

impl Default for ManifoldVertex {
    fn default() -> Self {
        Self::on_surface(DVec3::ZERO)
    }
}

impl ManifoldVertex {
    /// A point of an analytic surface.
    pub fn on_surface(position: DVec3) -> Self {
        Self { position, triangle: NO_TRIANGLE, barycentrics: [0.0; 2] }
    }
}

/// A surface at a site, to first order, for Newton's method.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct ManifoldFrame {
    /// The site's position, world.
    pub position: DVec3,
    /// The unit (shading) normal on the outer side.
    pub normal: DVec3,
    /// Two orthonormal directions of motion, right-handed about the outer side: tangents of the surface, on meshes
    /// those of the flat triangle (which are not perpendicular to an interpolated normal).
    pub tangents: [DVec3; 2],
    /// Change of the unit normal a unit of motion along each tangent.
    pub normal_change: [DVec3; 2],
}

impl ManifoldFrame {
    /// The unit normal of the flat triangle (of the surface itself on analytic ones), on the outer side.
    #[inline]
    pub fn geometric_normal(&self) -> DVec3 {
        self.tangents[0].cross(self.tangents[1])
    }
}
