//! Objects that are far from a reflector, by a bound of the error of looking them up by direction alone (Chen, Arvo
//! 2000, conclusion: distant objects by a conventional environment map).
//!
//! An outgoing ray passes a reflector's centre at a distance `a`. The point that it meets at distance `d` from the
//! centre lies, seen from there, `asin(a / d)` radians beside the ray's direction. The picture shows that direction at
//! another place, which is off by that angle times the pixels a radian: the inverse of the change of reflected
//! directions from pixel to pixel, which every sample of the ray map holds. The error is the product, in pixels.

use crate::find::ray_map::{PathRays, RayMap, largest_stretch};
use catoptric_core::math::Aabb;
use catoptric_core::math::portable::PortableMath;
use catoptric_core::scene::Scene;
use catoptric_engine::light::cube_map::{direction_of, place_on_face};
use glam::{DVec3, Vec2};
use std::collections::BTreeMap;
use std::f64::consts::{FRAC_PI_2, PI};

/// Bins of directions along a side of a cube's face. Chosen, not measured.
const BINS: u32 = 32;

/// Comparisons of objects with bins of directions and with each other in one view: a tenth of a second of one core.
/// Chosen, not measured.
const MAX_COMPARISONS: usize = 20_000_000;

/// The bounds of an error.
pub(super) struct FarBounds {
    /// The largest error of a look-up, in pixels.
    pub(super) error_px: f64,
    /// The width of a map's texel, in radians: it may be seen as wide as a pixel.
    pub(super) texel: f64,
}

/// The far objects of a view.
#[derive(Default)]
pub(super) struct FarObjects {
    /// The far objects of each reflector, in ascending order.
    pub(super) of: Vec<Vec<u32>>,
    /// The number of far objects that are projected all the same, since they hide others that are.
    pub(super) kept: u64,
    /// Reflectors that were not looked at, for want of work.
    pub(super) reflectors_left: u64,
}

/// Data of all outgoing rays about in one direction that leave a reflector.
struct DirectionBin {
    axis: DVec3,
    /// The angle around the axis that it counts for, with the directions between samples.
    angle: f64,
    /// The largest distance of a ray from the reflector's centre.
    across: f64,
    /// The most pixels a radian, and that times the distance from the centre.
    px_per_radian: f64,
    error_at_unit_px: f64,
}

/// Directions and distances in which an object lies, and its box.
struct Cone {
    bounds: Aabb,
    axis: DVec3,
    half_angle: f64,
    nearest: f64,
    farthest: f64,
}

impl Cone {
    /// The cone around a box, all directions if that is wider than a half-space.
    fn around(bounds: &Aabb, center: DVec3) -> Self {
        if bounds.is_empty() {
            // An empty object is infinitely far away.
            return Self { bounds: *bounds, axis: DVec3::Z, half_angle: 0.0, nearest: f64::INFINITY, farthest: 0.0 };
        }
        let nearest = center.clamp(bounds.min.as_dvec3(), bounds.max.as_dvec3()).distance(center);
        let corners = bounds.corners().map(|corner| corner.as_dvec3() - center);
        let axis = (bounds.center().as_dvec3() - center).normalize_or(DVec3::Z);
        let half_angle = corners.iter().map(|corner| angle(axis, corner.normalize_or_zero())).fold(0.0, f64::max);
        let half_angle = if nearest > 0.0 && half_angle < FRAC_PI_2 { half_angle } else { PI };
        let farthest = corners.iter().map(|corner| corner.length()).fold(0.0, f64::max);
        Self { bounds: *bounds, axis, half_angle, nearest, farthest }
    }

    /// The greatest angle by which a step across the direction to the object turns it.
    fn parallax(&self, across: f64) -> f64 {
        parallax(across, self.nearest)
    }

    /// True if parts of `other` may be seen behind this object, from anywhere in a reflector's box; the cones are about
    /// that box's centre.
    fn may_hide(&self, other: &Self, reflector: &Aabb) -> bool {
        // If a plane across an axis separates the object from the reflector, the object hides only things beyond that
        // plane.
        let (own, others) = (&self.bounds, &other.bounds);
        let above = own.min.cmpge(reflector.max) & others.max.cmple(own.min);
        let below = own.max.cmple(reflector.min) & others.min.cmpge(own.max);
        if (above | below).any() {
            return false;
        }
        let radius = radius(reflector);
        let between = self.half_angle + other.half_angle + self.parallax(radius) + other.parallax(radius);
        other.farthest + 2.0 * radius > self.nearest && angle(self.axis, other.axis) <= between
    }
}

/// Half the diagonal of a box.
fn radius(bounds: &Aabb) -> f64 {
    0.5 * f64::from(bounds.diagonal())
}

/// The angle between the directions to a point at some distance from two places that are `across` apart, in radians.
fn parallax(across: f64, distance: f64) -> f64 {
    let sine = across / distance;
    if sine < 1.0 { sine.arc_sine() } else { PI }
}

/// The angle between two unit vectors; 90 degrees to one of no length.
fn angle(a: DVec3, b: DVec3) -> f64 {
    a.dot(b).clamp(-1.0, 1.0).arc_cosine()
}

/// The bins of all rays that leave a reflector at the end of some paths.
fn direction_bins<'a>(groups: impl Iterator<Item = &'a PathRays>, center: DVec3) -> Vec<DirectionBin> {
    let mut bins: BTreeMap<(u32, [u32; 2]), DirectionBin> = BTreeMap::new();
    for group in groups {
        for (ray, sample) in group.samples.iter().enumerate() {
            let direction = sample.rays.direction;
            let (face, place) = place_on_face(direction.as_vec3().to_array());
            let column = place.map(|share| (((share + 1.0) * 0.5 * BINS as f32) as u32).min(BINS - 1));
            let bin = bins.entry((face, column)).or_insert_with(|| {
                let middle = column.map(|column| (column as f32 + 0.5) / BINS as f32 * 2.0 - 1.0);
                let axis = direction_of(face as usize, Vec2::from(middle)).as_dvec3().normalize();
                DirectionBin { axis, angle: 0.0, across: 0.0, px_per_radian: 0.0, error_at_unit_px: 0.0 }
            });
            let finite = |value: f64| if value.is_nan() { f64::INFINITY } else { value };
            let offset = sample.rays.origin - center;
            let across = finite(offset.cross(direction).length());
            let px_per_radian = finite(largest_stretch(group.place_change_with_direction(ray as u32)));
            let around = angle(bin.axis, direction) + finite(group.turn(ray as u32));
            bin.angle = bin.angle.max(around.min(PI));
            bin.across = bin.across.max(across);
            bin.px_per_radian = bin.px_per_radian.max(px_per_radian);
            bin.error_at_unit_px = bin.error_at_unit_px.max(finite(across * px_per_radian));
        }
    }
    bins.into_values().collect()
}

impl FarBounds {
    /// True if rays show an object and a look-up by direction shows it in its place, within the bounds.
    fn hold(&self, object: &Cone, bins: &[DirectionBin]) -> bool {
        let mut is_seen = false;
        for bin in bins {
            let turned = object.parallax(bin.across);
            if angle(bin.axis, object.axis) > object.half_angle + bin.angle + turned {
                continue;
            }
            is_seen = true;
            // The arc sine is by this much more than its argument, at the most.
            let arc = if bin.across > 0.0 { turned * object.nearest / bin.across } else { 1.0 };
            let error_px = bin.error_at_unit_px / object.nearest * arc;
            if !(error_px <= self.error_px && self.texel * bin.px_per_radian <= 1.0) {
                return false;
            }
        }
        is_seen
    }

    /// The objects that are far from the reflectors and lenses at the ends of a ray map's paths. Specular objects are
    /// not far, nor is any object from mirrors that fade with distance, which a map cannot show.
    pub(super) fn far_objects(&self, scene: &Scene, map: &RayMap) -> FarObjects {
        let mut found = FarObjects { of: vec![Vec::new(); scene.objects.len()], ..FarObjects::default() };
        let mut left = MAX_COMPARISONS;
        let last = |group: &PathRays| group.path.bounces.last().map(|bounce| bounce.object);
        for reflector in scene.specular_objects() {
            let blend = scene.material_of(reflector).blend;
            let groups = || map.groups.iter().filter(|group| last(group) == Some(reflector));
            if groups().next().is_none() || blend.is_some_and(|blend| blend.attenuation.is_some()) {
                continue;
            }
            let bounds = &scene.objects[reflector as usize].bounds;
            let center = bounds.center().as_dvec3();
            let bins = direction_bins(groups(), center);
            let count = scene.objects.len();
            // Each object is compared with all bins, and each that is projected with those that are far.
            let Some(rest) = left.checked_sub(count.saturating_mul(bins.len())) else {
                found.reflectors_left += 1;
                continue;
            };
            let cones: Vec<Cone> = scene.objects.iter().map(|object| Cone::around(&object.bounds, center)).collect();
            let is_far =
                |object: &u32| !scene.role_of(*object).is_specular() && self.hold(&cones[*object as usize], &bins);
            let candidates: Vec<u32> = (0..count as u32).filter(is_far).collect();
            let Some(rest) = rest.checked_sub(candidates.len().saturating_mul(count)) else {
                found.reflectors_left += 1;
                continue;
            };
            left = rest;
            let far = hiding_no_other(&candidates, &cones, bounds);
            found.kept += (candidates.len() - far.len()) as u64;
            found.of[reflector as usize] = far;
        }
        found
    }
}

/// The candidates that hide no objects but each other: a map is seen behind everything that is projected.
fn hiding_no_other(candidates: &[u32], cones: &[Cone], reflector: &Aabb) -> Vec<u32> {
    let mut far = candidates.to_vec();
    let mut projected: Vec<u32> =
        (0..cones.len() as u32).filter(|object| candidates.binary_search(object).is_err()).collect();
    // An object that is projected after all may be hidden by others, in turn.
    while let Some(other) = projected.pop() {
        let other = &cones[other as usize];
        far.retain(|&object| {
            let hides = cones[object as usize].may_hide(other, reflector);
            if hides {
                projected.push(object);
            }
            !hides
        });
    }
    far
}
