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
