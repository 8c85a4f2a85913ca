//! Rotations and translations, found from where points were and are.

use glam::{DAffine3, DMat3, DVec3, Vec3};

/// Points may be off by this share of the size of all, as they are rounded.
const ROUNDED: f64 = 1e-5;

/// The further error of points by rounding, in units in the last place of their largest coordinate.
const LAST_PLACES: f64 = 4.0;

/// The rotation and translation that takes points to others, one by one; `None` where there is none, and of points on a
/// line.
pub fn rigid_motion(from: &[Vec3], to: &[Vec3]) -> Option<DAffine3> {
    let first = from.first()?.as_dvec3();
    let farthest = |distance: &dyn Fn(DVec3) -> f64| {
        let distances = from.iter().map(|point| distance(point.as_dvec3()));
        distances.enumerate().max_by(|a, b| a.1.total_cmp(&b.1))
    };
    let (second, size) = farthest(&|point| point.distance(first))?;
    let along = (from[second].as_dvec3() - first).normalize_or_zero();
    let (third, _) = farthest(&|point| (point - first).cross(along).length())?;
    let rotation = axes(to, second, third)? * axes(from, second, third)?.transpose();
    let motion = DAffine3::from_mat3_translation(rotation, to.first()?.as_dvec3() - rotation * first);
    let largest = from.iter().chain(to).map(|point| point.abs().max_element()).fold(0.0, f32::max);
    let tolerance = ROUNDED * size + LAST_PLACES * f64::from(f32::EPSILON * largest);
    let is_there =
        |(from, to): (&Vec3, &Vec3)| motion.transform_point3(from.as_dvec3()).distance(to.as_dvec3()) <= tolerance;
    (from.len() == to.len() && from.iter().zip(to).all(is_there)).then_some(motion)
}

/// Orthonormal axes through the first of some points and two others; `None` for points on a line.
fn axes(points: &[Vec3], second: usize, third: usize) -> Option<DMat3> {
    let [first, second, third] = [0, second, third].map(|point| points.get(point).map(|point| point.as_dvec3()));
    let (first, second, third) = (first?, second?, third?);
    let x = (second - first).try_normalize()?;
    let z = x.cross(third - first).try_normalize()?;
    Some(DMat3::from_cols(x, z.cross(x), z))
}
