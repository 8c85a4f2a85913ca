//! Reflections in a sphere against Alhazen's quartic, solved in its plane without any of the library.

use super::*;
use std::f64::consts::{PI, TAU};

/// The real roots of a polynomial (ascending coefficients) in an interval: those of its derivative part them.
fn roots_between(polynomial: &[f64], low: f64, high: f64) -> Vec<f64> {
    let value = |t: f64| polynomial.iter().rev().fold(0.0, |sum, c| sum * t + c);
    if polynomial.len() < 2 {
        return Vec::new();
    }
    let derivative: Vec<f64> = polynomial.iter().enumerate().skip(1).map(|(k, c)| c * k as f64).collect();
    let mut borders = vec![low];
    borders.extend(roots_between(&derivative, low, high));
    borders.push(high);
    let mut found = Vec::new();
    for pair in borders.windows(2) {
        let (mut a, mut b) = (pair[0], pair[1]);
        if value(a) * value(b) > 0.0 {
            continue;
        }
        let rising = value(b) > value(a);
        for _ in 0..80 {
            let middle = 0.5 * (a + b);
            if (value(middle) > 0.0) == rising { b = middle } else { a = middle }
        }
        found.push(0.5 * (a + b));
    }
    found
}

/// Angles of the points of a circle of radius 1 about the origin where light from `b` can be reflected to `a`, and of
/// all points that solve the quartic: `(a - z)(b - z) / z^2` is real, for a reflection positive.
fn reflections(a: [f64; 2], b: [f64; 2]) -> (Vec<f64>, Vec<f64>) {
    let product = [a[0] * b[0] - a[1] * b[1], a[0] * b[1] + a[1] * b[0]];
    let sum = [a[0] + b[0], a[1] + b[1]];
    let mut all = Vec::new();
    // Two charts t = tan(angle / 2), turned by half a circle: z = s (1 + i t)^2 / (1 + t^2).
    for turn in [1.0, -1.0] {
        // Im(product conj(z)^2 - sum conj(z)), with c = (1 - t^2) s and k = 2 t s over 1 + t^2.
        let (p, q) = (product, [sum[0] * turn, sum[1] * turn]);
        // p.y (c^2 - k^2) - 2 p.x c k - (q.y c - q.x k)(1 + t^2)
        let polynomial = [p[1] - q[1], -4.0 * p[0] + 2.0 * q[0], -6.0 * p[1], 4.0 * p[0] + 2.0 * q[0], p[1] + q[1]];
        all.extend(roots_between(&polynomial, -1.0, 1.0).iter().map(|t| {
            let angle = 2.0 * t.atan() + if turn < 0.0 { PI } else { 0.0 };
            angle.rem_euclid(TAU)
        }));
    }
    let is_reflection = |angle: &f64| {
        let z = [angle.cos(), angle.sin()];
        let over = |c: [f64; 2]| {
            let d = [c[0] - z[0], c[1] - z[1]];
            [d[0] * z[0] + d[1] * z[1], d[1] * z[0] - d[0] * z[1]]
        };
        let (u, v) = (over(a), over(b));
        u[0] * v[0] - u[1] * v[1] > 0.0 && u[0] * v[0] > 0.0
    };
    (all.iter().copied().filter(is_reflection).collect(), all)
}

#[test]
fn newton_reaches_every_root_of_alhazens_quartic() {
    let mut random = Stream::new(0xa1);
    let (mut reached, mut skipped, mut counts) = (0, 0, [0; 5]);
    for case in 0..4000 {
        let radius = random.next_between(0.5, 3.0);
        let center = vector(&mut random).as_vec3() * 4.0;
        let scene = scene_of(&[sphere(center, radius, mirror())]);
        let surfaces = SpecularSurfaces::new(&scene);
        let (center, radius) = (center.as_dvec3(), radius as f64);
        // Both inside, both outside, or one each.
        let place = |random: &mut Stream, outside: bool| {
            let size = if outside { random.next_between(1.05, 5.0) } else { random.next_between(0.05, 0.97) };
            vector(random).normalize() * size as f64
        };
        let (a, b) = (place(&mut random, case % 4 < 2), place(&mut random, case % 4 == 0 || case % 4 == 3));
        // The plane of eye, centre and point.
        let x = a.normalize();
        let y = (b - x * b.dot(x)).normalize();
        let (valid, all) = reflections([a.length(), 0.0], [b.dot(x), b.dot(y)]);
        let (eye, point) = (Eye::Point(center + a * radius), center + b * radius);
        counts[valid.len()] += 1;
        for &angle in &valid {
            let at = |angle: f64| x * angle.cos() + y * angle.sin();
            let apart = |other: &f64| (other - angle + PI).rem_euclid(TAU) - PI;
            let separation = all.iter().map(apart).map(f64::abs).filter(|&d| d > 0.0).fold(0.3, f64::min);
            if separation < 1e-3 {
                skipped += 1; // a double root, all but
                continue;
            }
            let shift = vector(&mut random) * (0.05 * separation);
            let start = center + (at(angle) + shift).normalize() * radius;
            let start = PathSites::new(&[(bounce(0, BounceKind::Reflect), ManifoldVertex::on_surface(start))]).unwrap();
            let found = solve(&surfaces, &eye, point, &start, 30, 1e-12);
            let found = found.unwrap_or_else(|| panic!("case {case}: root {angle} of {all:?} is lost"));
            assert!(found.converged && found.residual < 1e-12, "case {case}: {found:?}");
            let off = found.sites.sites[0].position.distance(center + at(angle) * radius) / radius;
            assert!(off < 1e-7, "case {case}: {off} beside root {angle} of {all:?}, valid {valid:?}");
            reached += 1;
        }
    }
    assert!(reached > 5000 && skipped * 500 < reached, "{reached} reached, {skipped} skipped");
    assert!(counts[1] > 500 && counts[2] > 500 && counts[4] > 20, "numbers of reflections: {counts:?}");
}
