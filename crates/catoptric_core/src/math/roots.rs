//! Guaranteed roots of functions of one variable: of polynomials in Bernstein form, and by interval bounds.

use super::interval::{Interval, IntervalDual};

/// The smallest root in 0..=1 of the polynomial with these Bernstein coefficients (its degree is `N - 1`).
///
/// The number of sign changes of the coefficients bounds the number of roots (Descartes' rule in Bernstein form; Lane
/// and Riesenfeld 1981, Bounds on a polynomial): none is no root, one is exactly one root, and otherwise the interval
/// is halved. Roots of even multiplicity, where the polynomial touches zero, are found or not as rounding falls.
#[inline]
pub fn first_bernstein_root<const N: usize>(coefficients: &[f64; N]) -> Option<f64> {
    if coefficients.iter().all(|c| *c > 0.0) || coefficients.iter().all(|c| *c < 0.0) {
        return None; // most rays: not worth a call
    }
    search(coefficients, 0.0, 1.0, 0)
}

/// Halvings after which roots are as far apart as numbers are.
const MAX_DEPTH: u32 = 50;

fn search<const N: usize>(c: &[f64; N], low: f64, high: f64, depth: u32) -> Option<f64> {
    if c[0] == 0.0 {
        return Some(low);
    }
    let mut changes = 0;
    let mut last = c[0];
    for &coefficient in &c[1..] {
        if coefficient != 0.0 {
            changes += u32::from((coefficient < 0.0) != (last < 0.0));
            last = coefficient;
        }
    }
    let end = c[N - 1];
    if changes == 0 {
        return (end == 0.0 && high == 1.0).then_some(high);
    }
    if changes == 1 && end != 0.0 {
        // The secant is a good start where the polynomial is nearly straight.
        let start = c[0] / (c[0] - end);
        let root = bracketed_root(|u| bernstein_value(c, u), 0.0, 1.0, c[0], start);
        return Some(low + (high - low) * root);
    }
    if depth == MAX_DEPTH || c.iter().any(|c| !c.is_finite()) {
        return ((c[0] < 0.0) != (end < 0.0)).then_some(low);
    }
    let (left, right) = halves(c);
    let middle = 0.5 * (low + high);
    search(&left, low, middle, depth + 1).or_else(|| search(&right, middle, high, depth + 1))
}

/// The polynomial over both halves of its interval (de Casteljau).
fn halves<const N: usize>(c: &[f64; N]) -> ([f64; N], [f64; N]) {
    let mut right = *c;
    let left = std::array::from_fn(|level| {
        if level > 0 {
            for k in 0..N - level {
                right[k] = 0.5 * (right[k] + right[k + 1]);
            }
        }
        right[0]
    });
    (left, right)
}

/// Value and derivative of a polynomial in Bernstein form.
#[inline]
fn bernstein_value<const N: usize>(c: &[f64; N], u: f64) -> (f64, f64) {
    let mut points = *c;
    for level in 1..N.saturating_sub(1) {
        for k in 0..N - level {
            points[k] += u * (points[k + 1] - points[k]);
        }
    }
    let change = points[1] - points[0];
    (points[0] + u * change, change * (N - 1) as f64)
}

/// The root of a function between `low` and `high`, where its signs differ: Newton's steps where they stay inside and
/// shrink the bracket, halving elsewhere. Accurate to the rounding of the function and of its argument.
///
/// `function` gives value and derivative, `value_at_low` is the value (or its sign) at `low`, `start` the first guess.
#[inline]
pub fn bracketed_root(function: impl Fn(f64) -> (f64, f64), low: f64, high: f64, value_at_low: f64, start: f64) -> f64 {
    let (mut low, mut high) = (low, high);
    let mut at = if start > low && start < high { start } else { 0.5 * (low + high) };
    let mut width = high - low;
    for step in 0..300 {
        let (value, slope) = function(at);
        if value == 0.0 {
            return at;
        }
        if (value < 0.0) == (value_at_low < 0.0) {
            low = at;
        } else {
            high = at;
        }
        let mut next = at - value / slope;
        // Every third step checks that the bracket halves at least; Newton's alone can creep along one side.
        let creeps = step % 3 == 2 && high - low > 0.5 * width;
        if step % 3 == 2 {
            width = high - low;
        }
        let settled = (next - at).abs() <= 2.0 * f64::EPSILON * at.abs().max(f64::MIN_POSITIVE);
        if settled {
            return next.clamp(low, high);
        }
        if !(next > low && next < high) || creeps {
            next = 0.5 * (low + high);
        }
        if next <= low || next >= high {
            return next;
        }
        at = next;
    }
    at
}

/// The smallest root between `low` and `high` of a function given by bounds over intervals (value and derivative) and
/// by its value and derivative at a number.
///
/// Intervals whose bounds leave out zero have no root, intervals where the derivative keeps its sign have one at
/// most; all others are halved. Nothing is missed but roots where the function touches zero without passing it. Sign
/// changes where the function or its derivative has no bounds (poles) are no roots. A function that is zero, or nearly
/// so, over stretches is given up after `MAX_INTERVALS` intervals: no root is reported then.
pub fn first_interval_root(
    bounds: impl Fn(Interval) -> IntervalDual,
    function: impl Fn(f64) -> (f64, f64),
    low: f64,
    high: f64,
) -> Option<f64> {
    let least_width = 4.0 * f64::EPSILON * low.abs().max(high.abs()).max(f64::MIN_POSITIVE);
    let mut waiting = [(0.0, 0.0); 64];
    waiting[0] = (low, high);
    let mut count = 1;
    for _ in 0..MAX_INTERVALS {
        if count == 0 {
            return None;
        }
        count -= 1;
        let (from, to) = waiting[count];
        let over = bounds(Interval::new(from, to));
        if over.value.is_empty() || !over.value.contains_zero() {
            continue;
        }
        let middle = 0.5 * (from + to);
        let small = to - from <= least_width || middle <= from || middle >= to || count + 2 > waiting.len();
        let is_monotone = over.slope.is_bounded() && !over.slope.contains_zero();
        if is_monotone || small {
            let (first, last) = (function(from).0, function(to).0);
            if first == 0.0 {
                return Some(from);
            }
            let passes = first.is_finite() && last.is_finite() && (last == 0.0 || (first < 0.0) != (last < 0.0));
            if passes && over.value.is_bounded() {
                let start = from + (to - from) * (first / (first - last));
                return Some(if small || last == 0.0 { to } else { bracketed_root(&function, from, to, first, start) });
            }
            if is_monotone && first.is_finite() && last.is_finite() || small {
                continue;
            }
        }
        // The mean value form is narrower than the bounds where the interval is small.
        if over.slope.is_bounded() {
            let at_middle = bounds(Interval::new(middle, middle)).value;
            let half = 0.5 * (to - from) * (1.0 + 4.0 * f64::EPSILON);
            let mean = at_middle + over.slope * Interval::new(-half, half);
            if !mean.is_empty() && !mean.contains_zero() {
                continue;
            }
        }
        waiting[count] = (middle, to);
        waiting[count + 1] = (from, middle);
        count += 2;
    }
    None
}

/// Intervals after which a search for a root is given up.
const MAX_INTERVALS: usize = 20_000;
