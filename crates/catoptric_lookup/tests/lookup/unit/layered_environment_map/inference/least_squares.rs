//! Solutions of equations.

use catoptric_core::math::random::Stream;
use catoptric_lookup::parts::{Equations, Stop, solve};
use glam::Vec4;

/// Random equations of a few texels each.
fn system(rows: usize, columns: usize, seed: u64, value: impl Fn(&[(u32, f32)]) -> Vec4) -> Equations {
    let mut random = Stream::new(seed);
    let mut equations = Equations::default();
    for _ in 0..rows {
        let terms: Vec<(u32, f32)> = (0..5)
            .map(|_| {
                let texel = (random.next_between(0.0, columns as f32) as u32).min(columns as u32 - 1);
                (texel, random.next_between(0.1, 1.0))
            })
            .collect();
        equations.push(1.0, value(&terms), |tap| terms.iter().for_each(|(texel, weight)| tap(*texel, *weight)));
    }
    equations
}

const STOP: Stop = Stop { most_steps: 500, gradient: 1e-6 };

#[test]
fn what_made_the_equations_comes_back() {
    let mut random = Stream::new(4);
    let texels: Vec<Vec4> =
        (0..200).map(|_| Vec4::new(random.next_between(0.0, 1.0), 0.5, random.next_between(0.0, 4.0), 0.0)).collect();
    let equations =
        system(2000, 200, 1, |terms| terms.iter().map(|(texel, weight)| texels[*texel as usize] * *weight).sum());
    let (found, residual) = solve(&equations, &[Vec4::splat(0.7); 200], 1e-7, STOP);
    for (found, texel) in found.iter().zip(&texels) {
        assert!((*found - *texel).abs().max_element() < 1e-3, "{found} for {texel}");
    }
    assert!(residual.after < 1e-3 * residual.before, "{residual:?}");
}

#[test]
fn contradictions_are_settled_as_the_normal_equations_say() {
    let mut random = Stream::new(11);
    let noise: Vec<f32> = (0..300).map(|_| random.next_between(-1.0, 1.0)).collect();
    let columns = 20;
    let equations = system(300, columns, 2, |terms| Vec4::splat(noise[(terms[0].1 * 290.0) as usize]));
    let (trust, expected) = (0.25, vec![Vec4::splat(0.3); columns]);
    let (found, _) = solve(&equations, &expected, trust, STOP);
    // The gradient of the sum of squares, summed up in double precision.
    let mut gradient: Vec<f64> =
        found.iter().map(|value| f64::from(trust) * (f64::from(value.x) - f64::from(expected[0].x))).collect();
    let mut largest = 0.0f64;
    for row in 0..equations.values.len() {
        let range = equations.range(row);
        let terms = || equations.texels[range.clone()].iter().zip(&equations.weights[range.clone()]);
        let sum: f64 = terms().map(|(texel, weight)| f64::from(found[*texel as usize].x) * f64::from(*weight)).sum();
        let off = sum - f64::from(equations.values[row].x);
        for (texel, weight) in terms() {
            gradient[*texel as usize] += off * f64::from(*weight);
            largest = largest.max((off * f64::from(*weight)).abs());
        }
    }
    assert!(gradient.iter().all(|value| value.abs() < 1e-4 * largest), "{gradient:?}");
}

#[test]
fn confidence_decides_between_contradictions_and_untouched_texels_keep_their_value() {
    let mut equations = Equations::default();
    equations.push(1.0, Vec4::splat(2.0), |tap| tap(0, 1.0));
    equations.push(0.5, Vec4::splat(4.0), |tap| tap(0, 1.0));
    let (found, _) = solve(&equations, &[Vec4::ZERO, Vec4::splat(9.0)], 1e-9, STOP);
    // (2 + 4 / 4) / (1 + 1 / 4)
    assert!((found[0] - 2.4).abs().max_element() < 1e-4, "{found:?}");
    assert_eq!(found[1], Vec4::splat(9.0));
    let none = solve(&Equations::default(), &[Vec4::ONE], 1e-3, STOP);
    assert_eq!(none.0, [Vec4::ONE]);
}
