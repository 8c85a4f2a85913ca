//! Taylor coefficients of implicit functions, in world axes.

use glam::{DMat3, DVec3};

/// An implicit function `g` at a point, to second order. The surface is where `g` is 0; its outside where `g > 0`.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Taylor2 {
    /// The function's value.
    pub value: f64,
    /// The function's gradient; it points to the outer side.
    pub gradient: DVec3,
    /// The function's (symmetric) Hessian.
    pub hessian: DMat3,
}

/// An implicit function at a point, to third order.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Taylor3 {
    /// Value, gradient and Hessian.
    pub lower: Taylor2,
    /// The derivative of the Hessian by x, by y and by z.
    pub third: [DMat3; 3],
}

impl Taylor3 {
    /// The third derivative along three directions.
    #[inline]
    pub fn third_along(&self, a: DVec3, b: DVec3, c: DVec3) -> f64 {
        let along = |matrix: &DMat3| a.dot(*matrix * b);
        along(&self.third[0]) * c.x + along(&self.third[1]) * c.y + along(&self.third[2]) * c.z
    }
}

impl Taylor2 {
    /// The unit normal on the outer side, or `None` if the gradient vanishes or is not finite.
    #[inline]
    pub fn normal(&self) -> Option<DVec3> {
        self.gradient.try_normalize()
    }
}
