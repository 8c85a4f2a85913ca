//! Bounds of the second-order terms of an expansion, from its first order alone.

use super::sample::RaySample;
use catoptric_core::math::portable::PortableMath;
use catoptric_engine::optics::path::bundle::FirstOrder;
use glam::{DMat2, DVec3};

/// Norms of a sample's second derivatives with respect to the place in the picture: the second-order terms grow with
/// the square of the distance in pixels to which the first order leads.
#[derive(Clone, Copy, Debug)]
pub struct SecondOrderBound {
    /// Bound for the rays' origins: lateral, in scene units.
    origin: f64,
    /// Bound for their directions, at a distance of 1 along them.
    direction: f64,
    /// Bound for the place of the first reflection point, in pixels.
    surface: f64,
}

impl SecondOrderBound {
    /// The bound of a sample, from the changes of the place in the picture with its parameters and with its first
    /// reflection point.
    pub fn new(sample: &RaySample, picture_change: &DMat2, place_change: [DVec3; 2]) -> Self {
        let parameters = picture_change.inverse();
        let norm = |forms: [[f64; 3]; 2]| {
            let [x, y] = forms.map(|form| half_form_norm(form, &parameters));
            x.hypotenuse(y)
        };
        let [origin, direction] = sample.rays.bend_forms().map(norm);
        let surface = norm(place_change.map(|gradient| sample.first.second.map(|second| gradient.dot(second))));
        Self { origin, direction, surface }
    }

    /// The most that the second order moves an appearance in the picture, in pixels, from the change of the place in
    /// the picture with the sample's parameters.
    #[inline]
    pub fn px(&self, picture_change: &DMat2, first: &FirstOrder) -> f64 {
        let steep = (*picture_change * first.lateral_change()).to_cols_array();
        let steep = steep.iter().map(|entry| entry * entry).sum::<f64>().sqrt();
        let bent = steep * (self.origin + self.direction * first.distance.abs()) + self.surface;
        bent * (*picture_change * first.linear).length_squared()
    }
}

/// A bound of `xx a^2 / 2 + xy a b + yy b^2 / 2` for `(a, b)` that a matrix makes of a unit vector.
fn half_form_norm([xx, xy, yy]: [f64; 3], of: &DMat2) -> f64 {
    let form = of.transpose() * DMat2::from_cols_array(&[xx, xy, xy, yy]) * *of;
    let (mean, half) = (0.5 * (form.x_axis.x + form.y_axis.y), 0.5 * (form.x_axis.x - form.y_axis.y));
    // The larger of both eigenvalues.
    0.5 * (mean.abs() + half.hypotenuse(form.x_axis.y))
}
