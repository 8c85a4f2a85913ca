//! Roots of functions.

use catoptric_core::math::random::Stream;
use catoptric_core::math::roots::{bracketed_root, first_bernstein_root};

/// Bernstein coefficients of a product of linear factors `u - root`.
fn from_roots<const N: usize>(roots: &[f64]) -> [f64; N] {
    assert_eq!(roots.len() + 1, N);
    let binomial = |n: usize, k: usize| (0..k).fold(1.0, |b, i| b * (n - i) as f64 / (i + 1) as f64);
    let mut c = vec![1.0];
    for root in roots {
        let n = c.len() - 1;
        let mut product = vec![0.0; n + 2];
        for (k, value) in c.iter().enumerate() {
            // In scaled Bernstein form products are convolutions.
            product[k] += value * -root;
            product[k + 1] += value * (1.0 - root);
        }
        c = product;
    }
    std::array::from_fn(|k| c[k] / binomial(N - 1, k))
}

#[test]
fn the_first_of_known_roots_is_found() {
    let mut random = Stream::new(5);
    for _ in 0..2000 {
        let roots: [f64; 6] = std::array::from_fn(|_| random.next_between(-1.0, 2.0) as f64);
        let first = roots.iter().copied().filter(|r| (0.0..=1.0).contains(r)).min_by(f64::total_cmp);
        let found = first_bernstein_root(&from_roots::<7>(&roots));
        let apart = |r: f64| roots.iter().filter(|other| (**other - r).abs() < 1e-3).count() == 1;
        match (first, found) {
            (Some(a), Some(b)) => assert!(!apart(a) || (a - b).abs() < 1e-9, "{roots:?}: {b}"),
            (None, None) => {}
            (Some(a), None) => assert!(!apart(a), "{roots:?}: none"),
            (None, Some(b)) => panic!("{roots:?}: {b}"),
        }
    }
    assert_eq!(first_bernstein_root(&[0.0; 5]), Some(0.0));
    assert_eq!(first_bernstein_root(&[1.0, 1.0, 0.0]), Some(1.0));
    assert_eq!(first_bernstein_root(&[f64::NAN, -1.0, 1.0]).filter(|r| r.is_nan()), None);
}

#[test]
fn bracketed_roots_survive_flat_and_steep_functions() {
    for (root, power) in [(0.3, 1), (0.7, 3), (0.999, 9), (1e-5, 5)] {
        let function = |x: f64| ((x - root).powi(power), power as f64 * (x - root).powi(power - 1));
        let found = bracketed_root(function, 0.0, 1.0, -1.0, 0.5);
        assert!((found - root).abs() < 1e-12, "{root} {power}: {found}");
    }
    let found = bracketed_root(|x: f64| (x.cbrt(), 1.0 / (3.0 * x.cbrt().powi(2))), -1.0, 3.0, -1.0, 2.0);
    assert!(found.abs() < 1e-12);
}
