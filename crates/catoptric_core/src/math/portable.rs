//! Functions that give the same bits on every machine.
//!
//! Sines, powers and their like from the standard library are the system's, and systems differ in the last bits. What
//! is baked must not: two machines that make the same unit compare it bit for bit. So everything from which scenes are
//! built and radiance is computed takes these from the pure Rust crate `libm`. Square roots, sums and products are
//! exact to the last bit by IEEE 754 and come from the processor.

use glam::{DQuat, DVec3, Quat, Vec2, Vec3};

/// Elementary functions by `libm`: within about one unit in the last place.
pub trait PortableMath: Sized {
    /// The sine of an angle in radians.
    fn sine(self) -> Self;
    /// The cosine of an angle in radians.
    fn cosine(self) -> Self;
    /// Both, in this order.
    fn sine_cosine(self) -> (Self, Self);
    /// The tangent of an angle in radians.
    fn tangent(self) -> Self;
    /// The angle from -pi/2 to pi/2 with this sine; no number beyond -1 to 1.
    fn arc_sine(self) -> Self;
    /// The angle from 0 to pi with this cosine; no number beyond -1 to 1.
    fn arc_cosine(self) -> Self;
    /// The angle from -pi/2 to pi/2 with this tangent.
    fn arc_tangent(self) -> Self;
    /// The angle from -pi to pi of the point with this as its y and another as its x.
    fn arc_tangent2(self, x: Self) -> Self;
    /// e to this power.
    fn exponential(self) -> Self;
    /// The natural logarithm; no number below zero.
    fn logarithm(self) -> Self;
    /// The logarithm to the base 2; no number below zero.
    fn logarithm2(self) -> Self;
    /// This to a power.
    fn power(self, exponent: Self) -> Self;
    /// The cube root, also of what is negative.
    fn cube_root(self) -> Self;
    /// The root of the sum of this squared and another squared, without overflow.
    fn hypotenuse(self, other: Self) -> Self;
}

macro_rules! portable {
    ($number:ty: $sin:ident $cos:ident $sincos:ident $tan:ident $asin:ident $acos:ident $atan:ident $atan2:ident
        $exp:ident $log:ident $log2:ident $pow:ident $cbrt:ident $hypot:ident) => {
        impl PortableMath for $number {
            #[inline]
            fn sine(self) -> Self {
                libm::$sin(self)
            }
            #[inline]
            fn cosine(self) -> Self {
                libm::$cos(self)
            }
            #[inline]
            fn sine_cosine(self) -> (Self, Self) {
                libm::$sincos(self)
            }
            #[inline]
            fn tangent(self) -> Self {
                libm::$tan(self)
            }
            #[inline]
            fn arc_sine(self) -> Self {
                libm::$asin(self)
            }
            #[inline]
            fn arc_cosine(self) -> Self {
                libm::$acos(self)
            }
            #[inline]
            fn arc_tangent(self) -> Self {
                libm::$atan(self)
            }
            #[inline]
            fn arc_tangent2(self, x: Self) -> Self {
                libm::$atan2(self, x)
            }
            #[inline]
            fn exponential(self) -> Self {
                libm::$exp(self)
            }
            #[inline]
            fn logarithm(self) -> Self {
                libm::$log(self)
            }
            #[inline]
            fn logarithm2(self) -> Self {
                libm::$log2(self)
            }
            #[inline]
            fn power(self, exponent: Self) -> Self {
                libm::$pow(self, exponent)
            }
            #[inline]
            fn cube_root(self) -> Self {
                libm::$cbrt(self)
            }
            #[inline]
            fn hypotenuse(self, other: Self) -> Self {
                libm::$hypot(self, other)
            }
        }
    };
}

portable!(f32: sinf cosf sincosf tanf asinf acosf atanf atan2f expf logf log2f powf cbrtf hypotf);
portable!(f64: sin cos sincos tan asin acos atan atan2 exp log log2 pow cbrt hypot);

/// The turn by an angle in radians about a unit axis.
pub fn turn_about(axis: DVec3, angle: f64) -> DQuat {
    let (sine, cosine) = (0.5 * angle).sine_cosine();
    let along = axis * sine;
    DQuat::from_xyzw(along.x, along.y, along.z, cosine)
}

/// The same, worked out in double precision and rounded.
pub fn turn_about_f32(axis: Vec3, angle: f32) -> Quat {
    turn_about(axis.as_dvec3(), f64::from(angle)).as_quat()
}

/// A part of the way between two unit turns, at an even pace: the shorter way (Shoemake 1985, spherical linear
/// interpolation).
pub fn between_turns(from: Quat, to: Quat, part: f32) -> Quat {
    let (from, mut to, part) = (from.as_dquat(), to.as_dquat(), f64::from(part));
    let mut cosine = from.dot(to);
    if cosine < 0.0 {
        (to, cosine) = (-to, -cosine);
    }
    // The angle by its tangent: a cosine near one does not tell small angles.
    let angle = (to - from * cosine).length().arc_tangent2(cosine);
    let sine = angle.sine();
    let (first, second) = match sine > f64::EPSILON {
        true => ((angle * (1.0 - part)).sine() / sine, (angle * part).sine() / sine),
        false => (1.0 - part, part),
    };
    (from * first + to * second).as_quat()
}

/// The unit vector at an angle in radians from the x axis towards the y axis.
pub fn at_angle(angle: f32) -> Vec2 {
    let (sine, cosine) = angle.sine_cosine();
    Vec2::new(cosine, sine)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::math::random::Stream;

    /// Against the system's functions, which are right to a unit or two in the last place.
    #[test]
    fn functions_are_those_of_the_system_but_for_the_last_places() {
        let mut random = Stream::new(11);
        let near = |found: f64, expected: f64, what: &str, x: f64| {
            let error = (found - expected).abs();
            assert!(error <= 4.0 * f64::EPSILON * expected.abs().max(1e-300), "{what}({x}): {found}, {expected}");
        };
        for _ in 0..20_000 {
            let x = f64::from(random.next_between(-20.0, 20.0));
            let (unit, positive) = (f64::from(random.next_between(-1.0, 1.0)), x.abs() + 1e-9);
            let (sine, cosine) = x.sine_cosine();
            assert_eq!([sine, cosine], [x.sine(), x.cosine()]);
            near(sine, x.sin(), "sin", x);
            near(cosine, x.cos(), "cos", x);
            near(x.tangent(), x.tan(), "tan", x);
            near(unit.arc_sine(), unit.asin(), "asin", unit);
            near(unit.arc_cosine(), unit.acos(), "acos", unit);
            near(x.arc_tangent(), x.atan(), "atan", x);
            near(unit.arc_tangent2(x), unit.atan2(x), "atan2", x);
            near(x.exponential(), x.exp(), "exp", x);
            near(positive.logarithm(), positive.ln(), "ln", positive);
            near(positive.logarithm2(), positive.log2(), "log2", positive);
            near(positive.power(unit), positive.powf(unit), "pow", positive);
            near(x.cube_root(), x.cbrt(), "cbrt", x);
            near(x.hypotenuse(unit), x.hypot(unit), "hypot", x);
            let single = x as f32;
            assert!((single.sine() - single.sin()).abs() <= 2.0 * f32::EPSILON);
            assert!((single.exponential() / single.exp() - 1.0).abs() <= 4.0 * f32::EPSILON);
        }
    }

    #[test]
    fn turns_are_rotations() {
        let mut random = Stream::new(3);
        let mut number = || random.next_between(-1.0, 1.0);
        for _ in 0..500 {
            let axis = Vec3::new(number(), number(), number()).normalize_or(Vec3::X);
            let (angle, part) = (3.0 * number(), 0.5 + 0.5 * number());
            let turn = turn_about_f32(axis, angle);
            assert!(turn.abs_diff_eq(Quat::from_axis_angle(axis, angle), 1e-6));
            let other = turn_about_f32(Vec3::new(number(), number(), number()).normalize_or(Vec3::Y), 3.0 * number());
            let found = between_turns(turn, other, part);
            // `q` and `-q` are one turn.
            let expected = turn.slerp(other, part);
            assert!(found.dot(expected).abs() > 1.0 - 1e-5, "{found} {expected}");
            assert!(between_turns(turn, turn, part).abs_diff_eq(turn, 1e-6));
            assert!(at_angle(angle).abs_diff_eq(Vec2::from_angle(angle), 1e-6));
        }
    }
}
