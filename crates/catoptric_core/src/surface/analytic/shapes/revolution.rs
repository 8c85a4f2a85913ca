//! Surfaces of revolution.

use super::super::derivatives::{self, ImplicitFunction, outer};
use super::super::implicit_shape::ImplicitShape;
use super::super::parameters::{MAX_LENGTH, MIN_LENGTH, SurfaceError, checked_length};
use super::super::ray::{clip, roomy};
use super::super::tessellation::mesh::{ProfilePoint, SurfaceMesh, cells, revolved};
use crate::math::portable::PortableMath;
use crate::math::roots::first_bernstein_root;
use crate::math::scalar::Scalar;
use crate::surface::taylor::{Taylor2, Taylor3};
use glam::{DMat3, DVec3};

/// A surface of revolution about the y axis that stands on the origin, without lids: its radius at the height `y` is
/// `a s^3 + b s^2 + c s + d` with `s = y / h`; `g = sqrt(x^2 + z^2) - radius(y)` (Chen and Arvo 2000, section 7).
///
/// The function goes on beyond the ends of the surface.
#[derive(Clone, Debug, PartialEq)]
pub struct Revolution {
    height: f64,
    profile: [f64; 4],
    largest_radius: f64,
}

/// Distances from the axis are rounded up to this share of the largest radius: there is no gradient on the axis.
const SOFTENING: f64 = 1e-12;

impl Revolution {
    /// The surface of this height and profile `[a, b, c, d]`.
    ///
    /// The height must be from 1e-9 to 1e9, the radius nowhere negative and at its largest from 1e-9 to 1e9.
    pub fn new(height: f64, profile: [f64; 4]) -> Result<Self, SurfaceError> {
        checked_length("height", height)?;
        let wrong = |problem: String| Err(SurfaceError::new("profile", format!("{profile:?}; {problem}")));
        if profile.iter().any(|coefficient| coefficient.is_nan() || coefficient.abs() > MAX_LENGTH) {
            return wrong(format!("allowed are numbers up to {MAX_LENGTH:e}"));
        }
        let [a, b, c, _] = profile;
        let radius = |s: f64| value_and_slopes(&profile, s)[0];
        // The ends, and where the radius stands still in between: 3 a s^2 + 2 b s + c = 0.
        let mut places = vec![0.0, 1.0];
        let discriminant = b * b - 3.0 * a * c;
        if discriminant >= 0.0 {
            let q = -(b + discriminant.sqrt().copysign(b));
            places.extend([q / (3.0 * a), c / q].into_iter().filter(|s| (0.0..=1.0).contains(s)));
        }
        let radii = places.into_iter().map(radius);
        let (least, most) = radii.fold((f64::INFINITY, 0f64), |(least, most), r| (least.min(r), most.max(r)));
        if !(MIN_LENGTH..=MAX_LENGTH).contains(&most) {
            return wrong(format!("its largest radius, {most}, must be from {MIN_LENGTH:e} to {MAX_LENGTH:e}"));
        }
        // A tip may miss the axis by rounding.
        if least < -1e-9 * most {
            return wrong(format!("its radius must not be negative, but falls to {least}"));
        }
        Ok(Self { height, profile, largest_radius: most })
    }

    /// The height.
    pub fn height(&self) -> f64 {
        self.height
    }

    /// The coefficients `[a, b, c, d]` of the radius.
    pub fn profile(&self) -> [f64; 4] {
        self.profile
    }

    pub(in super::super) fn scaled(&self, scale: f64) -> Self {
        Self {
            height: self.height * scale,
            profile: self.profile.map(|coefficient| coefficient * scale),
            largest_radius: self.largest_radius * scale,
        }
    }

    fn soft2(&self) -> f64 {
        (SOFTENING * self.largest_radius).powi(2)
    }

    /// The radius as a polar form: of three heights (as shares), symmetric and linear in each.
    fn blossom(&self, s: f64, t: f64, u: f64) -> f64 {
        let [a, b, c, d] = self.profile;
        a * s * t * u + b * (s * t + t * u + u * s) / 3.0 + c * (s + t + u) / 3.0 + d
    }

    /// The shares of the height at which the tessellation has rings.
    fn rings(&self, fineness: f64) -> Vec<f64> {
        // Steps of an arc of length l with curvature k are off by k l^2 / 8: their number in all is the integral of
        // sqrt(k / (8 error)) along the profile. Between its samples the density is taken as constant.
        const SAMPLES: usize = 512;
        let error = 2.5e-5 * (self.height.max(2.0 * self.largest_radius));
        let density = |s: f64| {
            let [_, slope, bend] = value_and_slopes(&self.profile, s);
            // In terms of s: |(h, r')| ds is the arc, |h r''| / |(h, r')|^3 the curvature.
            let speed = self.height.hypotenuse(slope);
            ((self.height * bend).abs() / speed.powi(3) / (8.0 * error)).sqrt() * speed
        };
        let mut sums = vec![0.0];
        for sample in 0..SAMPLES {
            let last = sums[sample];
            sums.push(last + density((sample as f64 + 0.5) / SAMPLES as f64).max(8.0) / SAMPLES as f64);
        }
        let total = sums[SAMPLES];
        let steps = cells((total * 1.05).ceil().clamp(8.0, 4096.0) as u32, fineness) as usize;
        let mut rings = Vec::with_capacity(steps + 1);
        let mut sample = 0;
        for step in 0..steps {
            let wanted = total * step as f64 / steps as f64;
            while sums[sample + 1] < wanted {
                sample += 1;
            }
            let within = (wanted - sums[sample]) / (sums[sample + 1] - sums[sample]);
            rings.push((sample as f64 + within) / SAMPLES as f64);
        }
        rings.push(1.0);
        rings
    }
}

/// The radius and its first and second derivative by `s`.
#[inline]
fn value_and_slopes([a, b, c, d]: &[f64; 4], s: f64) -> [f64; 3] {
    [((a * s + b) * s + c) * s + d, (3.0 * a * s + 2.0 * b) * s + c, 6.0 * a * s + 2.0 * b]
}

impl ImplicitFunction for Revolution {
    fn value<S: Scalar>(&self, [x, y, z]: [S; 3]) -> S {
        let [a, b, c, d] = self.profile.map(S::constant);
        let s = y * S::constant(1.0 / self.height);
        (x * x + z * z + S::constant(self.soft2())).sqrt() - (((a * s + b) * s + c) * s + d)
    }
}

impl ImplicitShape for Revolution {
    fn corners(&self) -> [DVec3; 2] {
        let wide = self.largest_radius;
        [DVec3::new(-wide, 0.0, -wide), DVec3::new(wide, self.height, wide)]
    }

    #[inline]
    fn taylor2(&self, point: DVec3) -> Taylor2 {
        let inverse_height = 1.0 / self.height;
        let [radius, slope, bend] = value_and_slopes(&self.profile, point.y * inverse_height);
        let axis_distance = (point.x * point.x + point.z * point.z + self.soft2()).sqrt();
        let outwards = DVec3::new(point.x, 0.0, point.z) / axis_distance;
        let mut hessian =
            (DMat3::from_diagonal(DVec3::new(1.0, 0.0, 1.0)) - outer(outwards, outwards)) * (1.0 / axis_distance);
        hessian.y_axis.y = -bend * inverse_height * inverse_height;
        Taylor2 {
            value: axis_distance - radius,
            gradient: DVec3::new(outwards.x, -slope * inverse_height, outwards.z),
            hessian,
        }
    }

    fn taylor3(&self, point: DVec3) -> Taylor3 {
        derivatives::taylor3(self, point)
    }

    #[inline]
    fn outwards(&self, point: DVec3) -> DVec3 {
        let [_, slope, _] = value_and_slopes(&self.profile, point.y / self.height);
        let axis_distance = (point.x * point.x + point.z * point.z + self.soft2()).sqrt();
        DVec3::new(point.x / axis_distance, -slope / self.height, point.z / axis_distance)
    }

    #[inline]
    fn first_hit(&self, origin: DVec3, direction: DVec3, near: f64, far: f64) -> Option<f64> {
        // Room beside the surface alone: above and below it ends.
        let [mut low, mut high] = roomy(self.corners());
        (low.y, high.y) = (0.0, self.height);
        let (enter, leave) = clip(origin, direction, [low, high], near, far)?;
        let (p, q) = (origin + direction * enter, origin + direction * leave);
        let (s, t) = (p.y / self.height, q.y / self.height);
        // radius^2 - (x^2 + z^2), of degree 6, in Bernstein form between the two points.
        let r = [self.blossom(s, s, s), self.blossom(s, s, t), self.blossom(s, t, t), self.blossom(t, t, t)];
        let axial = [p.x * p.x + p.z * p.z, p.x * q.x + p.z * q.z, q.x * q.x + q.z * q.z];
        let coefficients = [
            r[0] * r[0] - axial[0],
            r[0] * r[1] - (2.0 * axial[0] + axial[1]) / 3.0,
            (2.0 * r[0] * r[2] + 3.0 * r[1] * r[1]) / 5.0 - (6.0 * axial[0] + 8.0 * axial[1] + axial[2]) / 15.0,
            (r[0] * r[3] + 9.0 * r[1] * r[2]) / 10.0 - (axial[0] + 3.0 * axial[1] + axial[2]) / 5.0,
            (2.0 * r[1] * r[3] + 3.0 * r[2] * r[2]) / 5.0 - (axial[0] + 8.0 * axial[1] + 6.0 * axial[2]) / 15.0,
            r[2] * r[3] - (axial[1] + 2.0 * axial[2]) / 3.0,
            r[3] * r[3] - axial[2],
        ];
        // The radius is not negative between the ends: squaring has added no roots.
        let share = first_bernstein_root(&coefficients)?;
        Some(enter + share * (leave - enter))
    }

    fn tessellate(&self, fineness: f64) -> SurfaceMesh {
        let point = |s: f64| {
            let [radius, slope, _] = value_and_slopes(&self.profile, s);
            ProfilePoint { radius: radius.max(0.0), height: s * self.height, direction: [slope, self.height] }
        };
        revolved(&self.rings(fineness).into_iter().map(point).collect::<Vec<_>>(), cells(320, fineness))
    }
}
