//! Damped steps: Newton's without damping, down the slope with much of it, and a solution where Newton's method stalls.

use super::*;
use glam::DVec3;

/// Two balls facing each other, with bounce points anywhere on the sides that do.
fn between_balls(random: &mut Stream, scene_surfaces: &SpecularSurfaces<'_>, eye: &Eye, point: DVec3) -> PathSites {
    let on = |random: &mut Stream, center: f64, towards: f64| {
        let direction = (vector(random) * 0.6 + DVec3::X * towards).normalize();
        ManifoldVertex::on_surface(DVec3::X * center + direction)
    };
    let first = (bounce(0, BounceKind::Reflect), on(random, 0.0, 1.0));
    let second = (bounce(1, BounceKind::Reflect), on(random, 4.0, -1.0));
    let path = PathSites::new(&[first, second]).expect("two bounces are allowed");
    assert!(residual(scene_surfaces, eye, point, &path).is_some());
    path
}

#[test]
fn damped_steps_lead_from_newtons_to_the_slope() {
    let scene = scene_of(&[sphere(Vec3::ZERO, 1.0, mirror()), sphere(Vec3::X * 4.0, 1.0, mirror())]);
    let surfaces = SpecularSurfaces::new(&scene);
    let mut random = Stream::new(31);
    let mut compared = 0;
    for _ in 0..200 {
        let eye = Eye::Point(DVec3::new(2.0, 3.0, 0.0) + vector(&mut random));
        let point = DVec3::new(2.0, -3.0, 0.0) + vector(&mut random);
        let path = between_balls(&mut random, &surfaces, &eye, point);
        let problem = Problem::<2>::new(&surfaces, &eye, point, &path).unwrap();
        let (Some(newton), Some(free)) = (problem.newton_step(), problem.damped_step(0.0)) else { continue };
        let (newton, free): ([DVec2; 2], [DVec2; 2]) = (newton, free);
        let size = newton[0].length() + newton[1].length();
        // Normal equations square the condition of the matrix.
        let off = newton[0].distance(free[0]) + newton[1].distance(free[1]);
        assert!(off < 1e-6 * size, "{newton:?} {free:?}");
        // A tiny step against the slope makes the sum of squares smaller.
        let step = problem.damped_step(1e6).unwrap();
        assert!(problem.square_after(&step).unwrap() < problem.square(), "{step:?}");
        compared += 1;
    }
    assert!(compared > 150, "{compared}");
}

#[test]
fn damped_descent_solves_what_newtons_method_does_not() {
    let scene = scene_of(&[sphere(Vec3::ZERO, 1.0, Material::glass("glass", 1.5))]);
    let surfaces = SpecularSurfaces::new(&scene);
    let mut random = Stream::new(32);
    let (mut by_newton, mut by_both) = (0, 0);
    for _ in 0..400 {
        // Points behind the ball, many of them near its caustic, and bounces anywhere on the two sides.
        let from = DVec3::Z * 3.5 + vector(&mut random) * 0.3;
        let point = DVec3::new(0.0, 0.0, -2.0) + vector(&mut random) * 0.8;
        let on = |random: &mut Stream, side: f64| {
            ManifoldVertex::on_surface((DVec3::Z * side + vector(random) * DVec3::new(1.2, 1.2, 0.0)).normalize())
        };
        let start = [on(&mut random, 1.0), on(&mut random, -1.0)].map(|site| (bounce(0, BounceKind::Transmit), site));
        let path = PathSites::new(&start).unwrap();
        let eye = Eye::Point(from);
        let Some(problem) = Problem::<2>::new(&surfaces, &eye, point, &path) else { continue };
        by_newton += u32::from(problem.is_solved_by_newton(40, 1e-12));
        let solution = solve(&surfaces, &eye, point, &path, 80, 1e-12);
        if let Some(solution) = solution.filter(|solution| solution.converged) {
            by_both += 1;
            // Snell's law, from the positions alone.
            let [front, back] = [0, 1].map(|k: usize| solution.sites.sites[k].position);
            let inside = (back - front).normalize();
            let at_front = (from - front).normalize() + inside * 1.5;
            let at_back = (point - back).normalize() - inside * 1.5;
            assert!(at_front.cross(front).length() < 1e-9 && at_back.cross(back).length() < 1e-9, "{front} {back}");
        }
    }
    assert!(by_newton > 100 && by_both > by_newton, "{by_newton} by Newton's method, {by_both} with descent");
}
