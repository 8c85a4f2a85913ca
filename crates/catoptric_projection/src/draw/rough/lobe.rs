//! The directions that a rough place reflects light from.

use catoptric_core::math::lanes::Lanes;
use catoptric_core::math::portable::PortableMath;
use catoptric_core::math::random;
use catoptric_core::scene::microfacets::{
    ReflectanceTable, VisibleFacets, disc_point, extent_of_sample, unshadowed_share,
};
use catoptric_engine::optics::step::{Facing, lobe_width};
use glam::{Vec2, Vec3};

/// A place's lobe, from its microfacets and the direction of view.
#[derive(Clone, Copy, Debug)]
pub(super) struct Lobe {
    alpha: f32,
    /// Unit normals on the viewer's side: of shading, and of the flat surface.
    normal: Vec3,
    geometric: Vec3,
    towards_viewer: Vec3,
    /// The share of light that facets neither mask nor shadow.
    pub(super) share: f32,
    /// The width of its bright part, in radians.
    pub(super) width: f32,
}

/// The exponent by which points of the disc are denser towards its rim, where few facets lean far: bright light there
/// counts.
const TAIL: f32 = 1.5;

/// Points of the unit disc, one a direction, and the parts of it that they stand for, in units of their mean.
pub(super) struct DiscPoints<const N: usize> {
    x: Lanes<N>,
    y: Lanes<N>,
    part: Lanes<N>,
}

impl<const N: usize> DiscPoints<N> {
    /// The points that numbers between 0 and 1 shift.
    pub(super) fn new(shift: Vec2) -> Self {
        let mut points = Self { x: Lanes::ZERO, y: Lanes::ZERO, part: Lanes::ZERO };
        for lane in 0..N {
            let number = (random::hammersley(lane as u32, N as u32) + shift).fract();
            let rest = 1.0 - number.x;
            let point = disc_point(Vec2::new(1.0 - rest.power(TAIL), number.y));
            points.part[lane] = TAIL * rest.power(TAIL - 1.0);
            (points.x[lane], points.y[lane]) = (point.x, point.y);
        }
        points
    }
}

/// Directions that light comes from.
pub(super) struct Directions<const N: usize> {
    pub(super) x: Lanes<N>,
    pub(super) y: Lanes<N>,
    pub(super) z: Lanes<N>,
    /// The share of a direction's light in the sum of all.
    pub(super) share: Lanes<N>,
    /// The solid angle that it stands for.
    pub(super) extent: Lanes<N>,
    /// The share of light from above the flat surface: light from below is lost.
    pub(super) kept: f32,
}

impl<const N: usize> Directions<N> {
    #[inline(always)] // for the instructions of its callers
    pub(super) fn of(&self, lane: usize) -> Vec3 {
        Vec3::new(self.x[lane], self.y[lane], self.z[lane])
    }
}

impl Lobe {
    /// The lobe of a surface's facets, whose distribution is so wide, seen from a direction.
    pub(super) fn new(alpha: f32, facing: &Facing, towards_viewer: Vec3) -> Self {
        let reflected = ReflectanceTable::get().reflected(alpha.sqrt(), towards_viewer.dot(facing.normal).max(1e-3));
        Self {
            alpha,
            normal: facing.normal,
            geometric: facing.geometric,
            towards_viewer,
            share: reflected.at_normal + reflected.at_grazing,
            width: lobe_width(alpha),
        }
    }

    /// The directions that light comes from, one a point.
    #[inline(always)] // for the instructions of its caller
    pub(super) fn directions<const N: usize>(&self, points: &DiscPoints<N>) -> Directions<N> {
        let Self { alpha, normal, geometric, towards_viewer, .. } = *self;
        let (across, along) = normal.any_orthonormal_pair();
        let n_v = towards_viewer.dot(normal).max(1e-3);
        let local = Vec3::new(towards_viewer.dot(across), towards_viewer.dot(along), n_v);
        let facets = VisibleFacets::new(alpha, local);
        let mut directions = Directions {
            x: Lanes::ZERO,
            y: Lanes::ZERO,
            z: Lanes::ZERO,
            share: Lanes::ZERO,
            extent: Lanes::ZERO,
            kept: 0.0,
        };
        let mut shares = Lanes::<N>::ZERO;
        for lane in 0..N {
            let facet = facets.facet(Vec2::new(points.x[lane], points.y[lane]));
            let light = facet * (2.0 * local.dot(facet)) - local;
            let towards = across * light.x + along * light.y + normal * light.z;
            (directions.x[lane], directions.y[lane], directions.z[lane]) = (towards.x, towards.y, towards.z);
            let share = unshadowed_share(alpha, light.z, n_v) * points.part[lane];
            shares[lane] = share;
            directions.share[lane] = if towards.dot(geometric) > 0.0 { share } else { 0.0 };
            directions.extent[lane] = extent_of_sample(alpha, facet.z, n_v, N as u32) * points.part[lane];
        }
        let all: f32 = shares.iter().sum();
        directions.kept = directions.share.iter().sum::<f32>() / all.max(f32::MIN_POSITIVE);
        directions
    }
}
