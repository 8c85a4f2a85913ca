//! Elementary functions that are the same everywhere.

use catoptric_core::math::portable::{PortableMath, at_angle, between_turns, turn_about_f32};
use catoptric_core::math::random::Stream;
use glam::{Quat, Vec2, Vec3};

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
