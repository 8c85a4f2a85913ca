//! Expressions of implicit surfaces.

use catoptric_core::math::interval::{Interval, IntervalDual};
use catoptric_core::math::scalar::Scalar;
use catoptric_core::surface::Expression;
use num_dual::Dual64;
use proptest::prelude::*;

fn value(text: &str, point: [f64; 3]) -> f64 {
    Expression::parse(text).unwrap().evaluate(point)
}

#[test]
fn precedence_is_that_of_mathematics() {
    let at = [2.0, 3.0, 5.0];
    for (text, expected) in [
        ("-x^2", -4.0),
        ("(-x)^2", 4.0),
        ("x^y^2", 512.0),
        ("x^-y", 0.125),
        ("2*-x", -4.0),
        ("z-y-x", 0.0),
        ("z/x/2", 1.25),
        ("x+y*z^2", 77.0),
        ("1e-3*x + .5 - 2.5E1*y+0*z", -74.498),
        ("sqrt(x*2) + abs(-y) + sin(0*x)", 5.0),
        ("exp(cos(x-2) - 1)+x*0", 1.0),
        ("--x", 2.0),
        ("-+-x", 2.0),
        ("y^0.5*y^0.5", 3.0),
        ("x^2^0.5", 2f64.powf(2f64.sqrt())),
        ("((((x))))", 2.0),
    ] {
        assert!((value(text, at) - expected).abs() < 1e-12, "{text}: {}", value(text, at));
    }
}

#[test]
fn errors_name_the_character() {
    for (text, needle) in [
        ("", "character 1: expected a number"),
        ("x +", "character 4: expected a number"),
        ("x + * y", "character 5: expected a number"),
        ("(x", "character 1: `(` without `)`"),
        ("x)", "character 2: `)` without `(`"),
        ("x y", "character 3: expected an operator"),
        ("2x", "character 2: expected an operator"),
        ("x + foo(y)", "character 5: unknown name `foo`"),
        ("sin x", "character 5: expected `(` after `sin`"),
        ("x + 1.2.3", "character 5: `1.2.3` is no number"),
        ("x # y", "character 3: expected an operator"),
        ("x + \u{e4}", "character 5: expected a number"),
        ("1 + 2", "must depend on x, y or z"),
        ("x + 1/0", "the constant before it is inf"),
        ("()", "character 2: expected a number"),
    ] {
        let error = Expression::parse(text).unwrap_err();
        assert!(error.problem.contains(needle), "{text}: {}", error.problem);
    }
    assert!(Expression::parse(&"(".repeat(100_000)).unwrap_err().problem.contains("too long"));
    assert!(Expression::parse(&format!("{}x", "-".repeat(1_900))).unwrap_err().problem.contains("too many"));
    let deep = format!("{}x{}", "x+(".repeat(100), ")".repeat(100));
    assert!(Expression::parse(&deep).unwrap_err().problem.contains("too deep"));
    assert!(Expression::parse(&format!("{}x{}", "(".repeat(900), ")".repeat(900))).is_ok());
}

/// Expressions that are well formed.
fn expressions() -> impl Strategy<Value = String> {
    let leaf = prop_oneof![
        Just("x".to_owned()),
        Just("y".to_owned()),
        Just("z".to_owned()),
        (0.1..3.0f64).prop_map(|number| format!("{number:.3}")),
    ];
    leaf.prop_recursive(4, 24, 2, |inner| {
        let pair = (inner.clone(), prop_oneof!["\\+", "-", "\\*", "/"], inner.clone());
        prop_oneof![
            pair.prop_map(|(a, operator, b)| format!("({a}) {operator} ({b})")),
            inner.clone().prop_map(|a| format!("-({a})")),
            (inner.clone(), -3..4i32).prop_map(|(a, power)| format!("({a})^({power})")),
            (inner.clone(), 0.2..2.5f64).prop_map(|(a, power)| format!("abs({a})^{power:.2}")),
            (prop_oneof!["sqrt", "exp", "sin", "cos", "abs"], inner).prop_map(|(f, a)| format!("{f}({a})")),
        ]
    })
}

proptest! {
    #![proptest_config(ProptestConfig { cases: 400, failure_persistence: None, ..ProptestConfig::default() })]

    #[test]
    fn any_text_is_read_or_refused(text in "[xyz0-9+*/^(). a-eincospqrtb-]{0,60}") {
        if let Ok(expression) = Expression::parse(&text) {
            let _ = expression.evaluate([0.3, -0.7, 1.1]);
        }
    }

    #[test]
    fn intervals_hold_the_values_and_slopes(
        text in expressions(),
        origin in [-1.5..1.5f64, -1.5..1.5, -1.5..1.5],
        direction in [-1.0..1.0f64, -1.0..1.0, -1.0..1.0],
        width in 1e-6..1.0f64,
        share in 0.0..1.0f64,
    ) {
        let Ok(expression) = Expression::parse(&format!("{text} + 0*x")) else { return Ok(()) };
        let t = share * width;
        let number: [Dual64; 3] = std::array::from_fn(|axis| {
            Dual64::new(origin[axis] + t * direction[axis], direction[axis])
        });
        let exact = expression.evaluate(number);
        // Numbers and dual numbers round differently: they agree where rounding does not matter.
        let room = 1e-9 * exact.re.abs().max(1.0);
        let [plain, before, after] =
            [1.0, 1.0 - 1e-12, 1.0 + 1e-12].map(|factor| expression.evaluate(number.map(|n| n.re * factor)));
        if exact.re.is_finite() && (plain - before).abs().max((plain - after).abs()) < 0.1 * room {
            prop_assert!((exact.re - plain).abs() <= room, "{text}: {exact:?} and {plain}");
        }
        let bounds = expression.evaluate(std::array::from_fn(|axis| {
            let slope = Interval::constant(direction[axis]);
            IntervalDual { value: Interval::constant(origin[axis]) + Interval::new(0.0, width) * slope, slope }
        }));
        if exact.re.is_finite() {
            let room = 1e-12 * exact.re.abs();
            prop_assert!(!bounds.value.is_empty(), "{text}: {exact:?} in {bounds:?}");
            prop_assert!(bounds.value.low <= exact.re + room && bounds.value.high >= exact.re - room);
        }
        if exact.re.is_finite() && exact.eps.is_finite() && bounds.slope.is_bounded() {
            let room = 1e-9 * exact.eps.abs().max(1e-9);
            prop_assert!(
                bounds.slope.low <= exact.eps + room && bounds.slope.high >= exact.eps - room,
                "{text}: {exact:?} in {bounds:?}"
            );
        }
    }
}
