//! All roots: reflections and refractions of spheres and planes in closed form, and by dense scans.

mod dense;

use catoptric_core::math::random::Stream;
use catoptric_core::surface::{AnalyticSurface, PlacedSurface};
use catoptric_engine::optics::path::all_roots::{RootCount, RootFinder};
use catoptric_engine::optics::path::bundle::{BounceKind, Eye};
use glam::{Affine3A, DVec2, DVec3, Quat};

const RADIUS: f64 = 1.25;

fn center() -> DVec3 {
    DVec3::new(0.5, -0.25, 1.0)
}

fn sphere() -> PlacedSurface {
    let place = Affine3A::from_rotation_translation(Quat::from_rotation_x(0.4), center().as_vec3());
    PlacedSurface { surface: AnalyticSurface::Sphere { radius: RADIUS }, world_from_surface: place.as_daffine3() }
}

fn unit_vector(random: &mut Stream) -> DVec3 {
    loop {
        let vector = DVec3::from([0; 3].map(|_| random.next_between(-1.0, 1.0) as f64));
        if (0.1..1.0).contains(&vector.length()) {
            return vector.normalize();
        }
    }
}

/// A point anywhere from the sphere's centre to four radii, at least a thousandth of a radius off its surface.
fn near_sphere(inside: bool, random: &mut Stream) -> DVec3 {
    let (low, high) = if inside { (0.0, 0.999) } else { (1.001, 4.0) };
    center() + unit_vector(random) * (RADIUS * random.next_between(low, high) as f64)
}

/// The roots on a sphere, by angle in the plane of eye, centre and point.
struct InPlane {
    axes: [DVec3; 2],
    ends: [DVec2; 2],
}

impl InPlane {
    /// Returns `None` if eye, centre and point (nearly) form a line.
    fn new(eye: DVec3, point: DVec3) -> Option<Self> {
        let [a, b] = [eye, point].map(|end| end - center());
        let x = a.try_normalize()?;
        let side = b - x * b.dot(x);
        (side.length() > 1e-3 * b.length()).then_some(())?;
        let axes = [x, side.normalize()];
        Some(Self { axes, ends: [a, b].map(|end| DVec2::new(axes[0].dot(end), axes[1].dot(end))) })
    }

    fn at(&self, angle: f64) -> DVec3 {
        center() + (self.axes[0] * angle.cos() + self.axes[1] * angle.sin()) * RADIUS
    }

    /// Heights of the ends over the tangent at an angle, and the tangential parts of the unit vectors to them.
    fn heights_and_tangents(&self, angle: f64) -> [(f64, f64); 2] {
        let (normal, tangent) = (DVec2::from_angle(angle), DVec2::from_angle(angle).perp());
        self.ends.map(|end| {
            let towards = end - normal * RADIUS;
            (towards.dot(normal), towards.dot(tangent) / towards.length())
        })
    }

    /// Alhazen's problem: equal angles make `(t.p)(n.q - R) + (t.q)(n.p - R)` vanish, a trigonometric polynomial of
    /// degree 2 in the angle; so a quartic in `z = exp(i angle)`, whose roots on the unit circle count. Returns `None`
    /// if a root is nearly double, or an end nearly in its tangent plane.
    fn alhazen(&self) -> Option<Vec<DVec3>> {
        let [p, q] = self.ends;
        let (sin2, cos2) = (p.y * q.y - p.x * q.x, p.y * q.x + p.x * q.y);
        let (sin1, cos1) = (RADIUS * (p.x + q.x), -RADIUS * (p.y + q.y));
        let coefficient = |cos: f64, sin: f64| DVec2::new(0.5 * cos, -0.5 * sin);
        let conjugate = |z: DVec2| DVec2::new(z.x, -z.y);
        let (high, low) = (coefficient(cos2, sin2), coefficient(cos1, sin1));
        let roots = quartic_roots([high, low, DVec2::ZERO, conjugate(low), conjugate(high)]);
        let mut found = Vec::new();
        for (i, root) in roots.iter().enumerate() {
            let mut others = (0..4).filter(|j| *j != i);
            if others.any(|j| roots[j].distance(*root) < 1e-4) {
                return None;
            }
            if (root.length() - 1.0).abs() < 1e-9 {
                let [(a, _), (b, _)] = self.heights_and_tangents(root.to_angle());
                (a.abs().min(b.abs()) > 1e-6).then_some(())?;
                if a * b > 0.0 {
                    found.push(self.at(root.to_angle()));
                }
            }
        }
        Some(found)
    }

    /// Roots of refraction by a dense scan of the circle. Returns `None` if a turn of the residual towards zero could
    /// hide two roots between two steps, or an end lies nearly in a root's tangent plane.
    fn scanned(&self, index: f64) -> Option<Vec<DVec3>> {
        let steps = 2000;
        let mut found = Vec::new();
        for weights in [[1.0, index], [index, 1.0]] {
            let residual = |angle: f64| {
                let [(_, a), (_, b)] = self.heights_and_tangents(angle);
                weights[0] * a + weights[1] * b
            };
            let angle = |step: i32| step as f64 / steps as f64 * std::f64::consts::TAU;
            for step in 0..steps {
                let [before, mut low, mut high, after] = [step - 1, step, step + 1, step + 2].map(angle);
                let (at_low, at_high) = (residual(low), residual(high));
                if at_low * at_high > 0.0 {
                    let least = at_low.abs().min(at_high.abs());
                    let turn = (residual(before) - at_low).abs().max((at_high - residual(after)).abs());
                    let turns = (at_low - residual(before)) * (residual(after) - at_high) < 0.0;
                    (!(turns && least < turn)).then_some(())?;
                    continue;
                }
                for _ in 0..60 {
                    let middle = 0.5 * (low + high);
                    if residual(middle) * at_low > 0.0 { low = middle } else { high = middle }
                }
                let [(a, _), (b, _)] = self.heights_and_tangents(low);
                (a.abs().min(b.abs()) > 1e-6).then_some(())?;
                let sided = if weights[0] == 1.0 { a > 0.0 && b < 0.0 } else { a < 0.0 && b > 0.0 };
                if sided {
                    found.push(self.at(low));
                }
            }
        }
        Some(found)
    }
}

/// All roots of a quartic with complex coefficients, the highest first (Durand and Kerner's iteration).
fn quartic_roots(coefficients: [DVec2; 5]) -> [DVec2; 4] {
    let times = |a: DVec2, b: DVec2| DVec2::new(a.x * b.x - a.y * b.y, a.x * b.y + a.y * b.x);
    let over = |a: DVec2, b: DVec2| times(a, DVec2::new(b.x, -b.y)) / b.length_squared();
    let monic = coefficients.map(|coefficient| over(coefficient, coefficients[0]));
    let value = |z: DVec2| monic.iter().fold(DVec2::ZERO, |sum, coefficient| times(sum, z) + *coefficient);
    let mut roots = [0.3, 1.9, 3.3, 4.8].map(|angle: f64| DVec2::from_angle(angle) * 0.9);
    for _ in 0..500 {
        let mut moved = 0f64;
        for i in 0..4 {
            let others = (0..4).filter(|j| *j != i);
            let product = others.fold(DVec2::X, |product, j| times(product, roots[i] - roots[j]));
            let step = over(value(roots[i]), product);
            roots[i] -= step;
            moved = moved.max(step.length());
        }
        if moved < 1e-15 {
            break;
        }
    }
    roots
}

/// Asserts that two lists hold the same points.
fn assert_same(found: &[DVec3], expected: &[DVec3], what: &dyn std::fmt::Debug) {
    assert_eq!(found.len(), expected.len(), "{what:?}: {found:?} against {expected:?}");
    for root in expected {
        let error = found.iter().map(|other| other.distance(*root)).fold(f64::INFINITY, f64::min);
        assert!(error < 1e-7, "{what:?}: {root} is missing ({error:e}) in {found:?}");
    }
}

/// Compares sphere roots in random configurations, a quarter each with eye and point inside or outside; returns how
/// many were compared, and how many had each number of roots.
fn compare_with_alhazen(cases: usize, seed: u64) -> (usize, [usize; 5]) {
    let finder = RootFinder::new(&sphere());
    let mut random = Stream::new(seed);
    let mut counts = [0; 5];
    let mut compared = 0;
    for case in 0..cases {
        let [eye, point] = [case & 1 == 0, case & 2 == 0].map(|inside| near_sphere(inside, &mut random));
        let Some(expected) = InPlane::new(eye, point).and_then(|plane| plane.alhazen()) else { continue };
        let mut found = Vec::new();
        let outcome = finder.roots(&Eye::Point(eye), point, BounceKind::Reflect, 1.0, &mut found);
        assert_eq!(outcome, RootCount::Finite, "{eye} {point}");
        assert_same(&found, &expected, &(eye, point));
        counts[expected.len()] += 1;
        compared += 1;
    }
    (compared, counts)
}

#[test]
fn reflections_in_a_sphere_are_alhazens() {
    let cases = 1000;
    let (compared, counts) = compare_with_alhazen(cases, 1021);
    assert!(compared * 100 > cases * 98, "{compared} of {cases} were compared");
    assert!(counts[1] > 250 && counts[2] > 250 && counts[3] > 25 && counts[4] > 10, "{counts:?}");
}

#[test]
#[ignore = "40,000 cases: run it with --release"]
fn reflections_in_a_sphere_are_alhazens_in_many_cases() {
    let started = std::time::Instant::now();
    let (compared, counts) = compare_with_alhazen(40_000, 965);
    eprintln!("{compared} of 40000 compared, roots {counts:?}, {:?}", started.elapsed());
    assert!(compared > 39_200);
}

fn compare_refractions(cases: usize, seed: u64) -> usize {
    let finder = RootFinder::new(&sphere());
    let mut random = Stream::new(seed);
    let mut compared = 0;
    for case in 0..cases {
        let [eye, point] = [case & 1 == 0, case & 2 == 0].map(|inside| near_sphere(inside, &mut random));
        let index = random.next_between(1.1, 2.0) as f64;
        let Some(expected) = InPlane::new(eye, point).and_then(|plane| plane.scanned(index)) else { continue };
        let mut found = Vec::new();
        let outcome = finder.roots(&Eye::Point(eye), point, BounceKind::Transmit, index, &mut found);
        assert_eq!(outcome, RootCount::Finite, "{eye} {point}");
        assert_same(&found, &expected, &(eye, point, index));
        compared += 1;
    }
    compared
}

#[test]
fn refractions_at_a_sphere_are_those_of_a_dense_scan() {
    assert!(compare_refractions(400, 3) > 380);
}

#[test]
#[ignore = "10,000 cases: run it with --release"]
fn refractions_at_a_sphere_are_those_of_a_dense_scan_in_many_cases() {
    let compared = compare_refractions(10_000, 4);
    eprintln!("{compared} of 10000 compared");
    assert!(compared > 9_800);
}

#[test]
fn eye_centre_and_point_in_a_line_have_infinitely_many_reflections() {
    let finder = RootFinder::new(&sphere());
    let mut found = Vec::new();
    let axis = DVec3::new(0.3, 0.8, -0.5).normalize();
    let at = |along: f64| center() + axis * (along * RADIUS);
    // Both ends inside, on different sides of the centre and equally far: the circle between them reflects.
    let count = finder.roots(&Eye::Point(at(0.5)), at(-0.5), BounceKind::Reflect, 1.0, &mut found);
    assert_eq!((count, found.len()), (RootCount::Infinite, 0));
    // Both at the centre: everything does.
    let count = finder.roots(&Eye::Point(center()), center(), BounceKind::Reflect, 1.0, &mut found);
    assert_eq!((count, found.len()), (RootCount::Infinite, 0));
    // Both outside on one side: the near point and (from its back) the far one.
    let count = finder.roots(&Eye::Point(at(2.0)), at(3.0), BounceKind::Reflect, 1.0, &mut found);
    assert_eq!(count, RootCount::Finite);
    assert_same(&found, &[at(1.0), at(-1.0)], &"on the axis");
}

#[test]
fn a_plane_mirrors_once_within_its_border() {
    let surface = AnalyticSurface::Plane { half_width: 2.0, half_height: 1.0 };
    let plane = PlacedSurface { surface, world_from_surface: Affine3A::IDENTITY.as_daffine3() };
    let finder = RootFinder::new(&plane);
    let mut random = Stream::new(7);
    let mut inside = 0;
    for _ in 0..500 {
        let [eye, point] = [0; 2].map(|_| {
            DVec3::from([(-3.0, 3.0), (0.1, 3.0), (-2.0, 2.0)].map(|(a, b)| random.next_between(a, b) as f64))
        });
        let expected = eye.lerp(DVec3::new(point.x, -point.y, point.z), eye.y / (eye.y + point.y));
        let mut found = Vec::new();
        let count = finder.roots(&Eye::Point(eye), point, BounceKind::Reflect, 1.0, &mut found);
        assert_eq!(count, RootCount::Finite);
        let is_inside = expected.x.abs() <= 2.0 && expected.z.abs() <= 1.0;
        assert_same(&found, if is_inside { std::slice::from_ref(&expected) } else { &[] }, &(eye, point));
        inside += usize::from(is_inside);
    }
    assert!((100..400).contains(&inside));
}

#[test]
fn parallel_view_rays_and_degenerate_input_are_answered() {
    let finder = RootFinder::new(&sphere());
    let mut found = Vec::new();
    // A point on the axis of parallel rays: the near point, and the far one from behind.
    let eye = Eye::Direction(DVec3::NEG_Z);
    finder.roots(&eye, center() + DVec3::Z * 5.0, BounceKind::Reflect, 1.0, &mut found);
    assert_same(&found, &[center() + DVec3::Z * RADIUS, center() - DVec3::Z * RADIUS], &"parallel rays");
    found.clear();
    let on_the_surface = center() + DVec3::X * RADIUS;
    let outside = DVec3::new(4.0, 3.0, 2.0);
    for (eye, point) in [
        (Eye::Point(DVec3::NAN), outside),
        (Eye::Point(outside), DVec3::INFINITY),
        (Eye::Direction(DVec3::ZERO), outside),
    ] {
        assert_eq!(finder.roots(&eye, point, BounceKind::Reflect, 1.0, &mut found), RootCount::Finite);
        assert!(found.is_empty());
    }
    for (eye, point) in [(outside, on_the_surface), (on_the_surface, outside), (outside, outside), (center(), outside)]
    {
        for kind in [BounceKind::Reflect, BounceKind::Transmit] {
            finder.roots(&Eye::Point(eye), point, kind, 1.5, &mut found);
            assert!(found.iter().all(|root| (root.distance(center()) - RADIUS).abs() < 1e-12));
        }
    }
    assert!(!found.is_empty());
}
