//! Surfaces given by formulas.

mod expression;
mod superquadric;

use catoptric_core::math::random::Stream;
use catoptric_core::surface::{
    AnalyticSurface, Ellipsoid, Expression, Implicit, PlacedSurface, Quadric, Revolution, Superquadric, SurfaceError,
    SurfaceMesh, Taylor2, Torus,
};
use glam::{Affine3A, DAffine3, DMat3, DVec3, Quat, Vec3};
use std::collections::HashMap;
use std::sync::OnceLock;

/// Surfaces of every kind, and of the forms that a kind takes.
fn surfaces() -> Vec<(&'static str, AnalyticSurface)> {
    let quadric = |coefficients: [f64; 10], bound: [f64; 3]| {
        AnalyticSurface::Quadric(Quadric::new(coefficients, bound.map(|b| -b), bound).unwrap())
    };
    let implicit =
        |text: &str, bound: [f64; 3]| AnalyticSurface::Implicit(Implicit::new(text, bound.map(|b| -b), bound).unwrap());
    let superquadric = |radii, exponents| AnalyticSurface::Superquadric(Superquadric::new(radii, exponents).unwrap());
    let revolution = |height, profile| AnalyticSurface::Revolution(Revolution::new(height, profile).unwrap());
    vec![
        ("sphere", AnalyticSurface::Sphere { radius: 0.8 }),
        ("plane", AnalyticSurface::Plane { half_width: 1.0, half_height: 0.6 }),
        ("ellipsoid", AnalyticSurface::Ellipsoid(Ellipsoid::new([1.2, 0.7, 0.4]).unwrap())),
        ("torus", AnalyticSurface::Torus(Torus::new(0.8, 0.3).unwrap())),
        ("thin torus", AnalyticSurface::Torus(Torus::new(1.0, 0.02).unwrap())),
        ("vase", revolution(2.0, [5.80, -9.78, 3.90, 0.47])),
        ("cone", revolution(1.0, [0.0, 0.0, -0.5, 0.5])),
        ("cylinder", revolution(0.5, [0.0, 0.0, 0.0, 0.4])),
        ("saddle", quadric([1.0, 0.0, -1.0, 0.3, 0.0, 0.0, 0.0, -1.0, 0.1, 0.05], [1.0, 0.8, 1.0])),
        ("paraboloid", quadric([1.0, 0.0, 1.0, 0.0, 0.0, 0.0, 0.0, -1.0, 0.0, 0.0], [0.9, 0.8, 0.9])),
        ("hyperboloid", quadric([1.0, -0.7, 1.0, 0.0, 0.0, 0.2, 0.0, 0.0, 0.0, -0.2], [1.0, 1.0, 1.0])),
        ("rounded box", superquadric([1.0, 0.6, 0.8], [0.4, 0.6])),
        ("lemon", superquadric([0.5, 0.6, 1.0], [1.7, 1.2])),
        ("superquadric sphere", superquadric([0.7, 0.7, 0.7], [1.0, 1.0])),
        ("cushion", superquadric([0.9, 1.0, 0.6], [1.3, 2.6])),
        ("gyroid", implicit("sin(4*x)*cos(4*y) + sin(4*y)*cos(4*z) + sin(4*z)*cos(4*x) - 0.2", [0.7, 0.6, 0.8])),
        ("tangle", implicit("x^4 + y^4 + z^4 - x^2 - y^2 - z^2 + 0.4", [1.1, 1.1, 1.1])),
        ("waves", implicit("y - 0.1*exp(-(x^2 + z^2))*sin(6*sqrt(x^2 + z^2 + 0.01))", [1.0, 0.3, 1.0])),
        ("tent", implicit("abs(x) + 2*abs(y)^1.5 + z - 0.5", [0.6, 0.5, 0.6])),
        ("half a ball", implicit("x - sqrt(0.25 - y^2 - z^2)", [0.6, 0.6, 0.6])),
    ]
}

/// The surfaces with their tessellations, made once for all tests.
fn cases() -> &'static [(&'static str, AnalyticSurface, SurfaceMesh)] {
    static CASES: OnceLock<Vec<(&'static str, AnalyticSurface, SurfaceMesh)>> = OnceLock::new();
    CASES.get_or_init(|| {
        let with_mesh = |(name, surface): (&'static str, AnalyticSurface)| {
            let mesh = surface.tessellate();
            (name, surface, mesh)
        };
        surfaces().into_iter().map(with_mesh).collect()
    })
}

fn placed(surface: &AnalyticSurface) -> PlacedSurface {
    let turn = Quat::from_euler(glam::EulerRot::XYZ, 0.4, -0.9, 1.3);
    PlacedSurface {
        surface: surface.clone(),
        world_from_surface: Affine3A::from_rotation_translation(turn, Vec3::new(0.3, -0.2, 0.5)).as_daffine3(),
    }
}

fn random_vector(random: &mut Stream) -> DVec3 {
    DVec3::from_array(std::array::from_fn(|_| random.next_between(-1.0, 1.0) as f64))
}

/// Points near a placed surface, within `distance` of it.
fn points_near(
    placed: &PlacedSurface,
    mesh: &SurfaceMesh,
    count: usize,
    distance: f64,
    random: &mut Stream,
) -> Vec<DVec3> {
    let vertex = |random: &mut Stream| {
        let index = (random.next_unit() * mesh.positions.len() as f32) as usize % mesh.positions.len();
        placed.world_from_surface.transform_point3(mesh.positions[index].as_dvec3())
    };
    (0..count).map(|_| vertex(random) + random_vector(random) * distance).collect()
}

fn largest(matrix: &DMat3) -> f64 {
    matrix.to_cols_array().iter().fold(0.0, |largest, x| largest.max(x.abs()))
}

#[test]
fn derivatives_agree_with_central_differences() {
    let mut random = Stream::new(1);
    for (name, surface, mesh) in cases() {
        let placed = placed(surface);
        let [min, max] = placed.surface.corners();
        let feature = (max - min).to_array().into_iter().filter(|x| *x > 0.0).fold(1.0, f64::min);
        for point in points_near(&placed, mesh, 60, 0.05 * feature, &mut random) {
            let at = placed.taylor3(point);
            let lower = placed.taylor2(point);
            assert_eq!(at.lower.value.signum(), lower.value.signum());
            // Powers near the coordinate planes change fast: steps there must be small, and differences are not exact.
            let local = placed.world_from_surface.inverse().transform_point3(point);
            let flat = matches!(placed.surface, AnalyticSurface::Superquadric(_)) || *name == "tent";
            if flat && local.abs().min_element() < 0.05 {
                continue;
            }
            let size = 1.0 + largest(&lower.hessian) + at.third.iter().map(largest).fold(0.0, f64::max);
            // Derivatives that grow this fast, as at the end of a root's domain, make differences useless.
            if size * feature * feature > 1e3 {
                continue;
            }
            assert!((at.lower.value - lower.value).abs() < 1e-13 * size, "{name}");
            assert!((at.lower.gradient - lower.gradient).length() < 1e-11 * size, "{name}");
            assert!(largest(&(at.lower.hessian - lower.hessian)) < 1e-10 * size, "{name}");
            for axis in 0..3 {
                // Five points: the error of the difference is of fourth order.
                let step = 4e-4 * feature;
                let shifted = |steps: f64| {
                    let mut shifted = point;
                    shifted[axis] += steps * step;
                    placed.taylor2(shifted)
                };
                let [a, b, c, d] = [-2.0, -1.0, 1.0, 2.0].map(shifted);
                if [&a, &b, &c, &d].iter().any(|taylor| taylor.gradient == DVec3::ZERO) {
                    continue; // outside the domain of an expression
                }
                let slope = (a.value - 8.0 * b.value + 8.0 * c.value - d.value) / (12.0 * step);
                assert!((slope - lower.gradient[axis]).abs() < 1e-6 * size, "{name}: {slope} {}", lower.gradient);
                let bend = (a.gradient - 8.0 * b.gradient + 8.0 * c.gradient - d.gradient) / (12.0 * step);
                assert!((bend - lower.hessian.col(axis)).length() < 1e-6 * size, "{name}: {bend} {}", lower.hessian);
                let third = (a.hessian - b.hessian * 8.0 + c.hessian * 8.0 - d.hessian) * (1.0 / (12.0 * step));
                let difference = largest(&(third - at.third[axis]));
                assert!(difference < 1e-6 * size, "{name}: {third} {} of {size}", at.third[axis]);
            }
        }
    }
}

#[test]
fn derivatives_are_finite_everywhere() {
    for (name, surface, _) in cases() {
        let placed = PlacedSurface { surface: surface.clone(), world_from_surface: DAffine3::IDENTITY };
        for point in [
            DVec3::ZERO,
            DVec3::X * 0.5,
            DVec3::Y,
            DVec3::NEG_Z * 0.8,
            DVec3::new(0.5, 0.5, 0.0),
            DVec3::new(0.8, 0.0, 0.0),
            DVec3::splat(1e-200),
            DVec3::splat(1e9),
        ] {
            let taylor = placed.taylor3(point);
            let finite = |taylor: &Taylor2| {
                taylor.value.is_finite() && taylor.gradient.is_finite() && taylor.hessian.is_finite()
            };
            assert!(finite(&taylor.lower) && finite(&placed.taylor2(point)), "{name} at {point}: {taylor:?}");
            assert!(taylor.third.iter().all(|third| third.is_finite()), "{name} at {point}: {taylor:?}");
            assert!(placed.shape_operator(point).is_finite(), "{name} at {point}");
        }
    }
}

/// The part of a ray up to `far` that lies in a box, or none.
fn clip(origin: DVec3, direction: DVec3, [min, max]: [DVec3; 2], far: f64) -> Option<(f64, f64)> {
    let (mut enter, mut leave) = (0.0f64, far);
    for axis in 0..3 {
        let (o, d) = (origin[axis], direction[axis]);
        if d == 0.0 {
            if o < min[axis] || o > max[axis] {
                return None;
            }
            continue;
        }
        let (a, b) = ((min[axis] - o) / d, (max[axis] - o) / d);
        (enter, leave) = (enter.max(a.min(b)), leave.min(a.max(b)));
    }
    (enter <= leave).then_some((enter, leave))
}

/// The distances at which `g` changes its sign along a ray, within the surface's bounds, by dense sampling.
fn sign_changes(placed: &PlacedSurface, origin: DVec3, direction: DVec3, far: f64) -> Vec<f64> {
    const STEPS: usize = 4000;
    let inverse = placed.world_from_surface.matrix3.transpose();
    let center = placed.world_from_surface.translation;
    let (o, d) = (inverse * (origin - center), inverse * direction);
    let [min, max] = placed.surface.corners();
    // Rays may graze the box of bounds that do not cut the surface: room around it.
    let room = 1e-6 * (max - min).length();
    let margin = match placed.surface {
        AnalyticSurface::Plane { .. } => DVec3::new(0.0, room, 0.0),
        AnalyticSurface::Quadric(_) | AnalyticSurface::Implicit(_) => DVec3::ZERO,
        AnalyticSurface::Revolution(_) => DVec3::new(room, 0.0, room),
        _ => DVec3::splat(room),
    };
    let Some((enter, leave)) = clip(o, d, [min - margin, max + margin], far) else { return Vec::new() };
    let expression = match &placed.surface {
        AnalyticSurface::Implicit(surface) => Some(Expression::parse(surface.expression()).unwrap()),
        _ => None,
    };
    let value = |t: f64| match (&expression, &placed.surface) {
        (Some(expression), _) => expression.evaluate((o + d * t).to_array()),
        (_, AnalyticSurface::Superquadric(surface)) => surface.value((o + d * t).to_array()),
        _ => placed.taylor2(origin + direction * t).value,
    };
    let mut found = Vec::new();
    let mut last = (enter, value(enter));
    for step in 1..=STEPS {
        let t = enter + (leave - enter) * step as f64 / STEPS as f64;
        let next = (t, value(t));
        if last.1 * next.1 <= 0.0 && next.1 != 0.0 {
            found.push(last.0 + (t - last.0) * (last.1 / (last.1 - next.1)));
        }
        last = next;
    }
    found
}

#[test]
fn no_first_hit_is_missed_and_none_is_invented() {
    let mut random = Stream::new(2);
    for (name, surface, mesh) in cases() {
        let placed = placed(surface);
        let bounds = placed.bounds();
        let (mut met, mut missed) = (0, 0);
        for case in 0..300 {
            let spread = bounds.diagonal() as f64;
            // Half of them at the surface itself, or it may be too thin to be met often.
            let vertex = mesh.positions[(random.next_unit() * mesh.positions.len() as f32) as usize];
            let target = match case % 2 {
                0 => bounds.center().as_dvec3() + random_vector(&mut random) * spread * 0.3,
                _ => placed.world_from_surface.transform_point3(vertex.as_dvec3()),
            };
            // From outside and from inside.
            let reach = if case % 4 == 0 { 0.3 } else { 2.0 };
            let origin = (bounds.center().as_dvec3() + random_vector(&mut random) * spread * reach).as_vec3();
            let direction = (target.as_vec3() - origin).normalize();
            let expected = sign_changes(&placed, origin.as_dvec3(), direction.as_dvec3(), 1e9);
            let hit = placed.intersect(origin, direction, 0.0, f32::INFINITY);
            let describe = || format!("{name}, case {case}: {hit:?}, expected {expected:?}");
            match (&hit, expected.first()) {
                (None, None) => missed += 1,
                (None, Some(_)) => panic!("{}", describe()),
                (Some(hit), first) => {
                    met += 1;
                    // On the surface, on the outside's side, within the bounds.
                    let exact = origin.as_dvec3() + direction.as_dvec3() * hit.distance as f64;
                    let taylor = placed.taylor2(hit.position.as_dvec3());
                    let off = taylor.value.abs() / taylor.gradient.length();
                    assert!(off < 2e-6 && placed.is_within_bounds(exact), "off by {off}: {}", describe());
                    // The rounding of the point turns the normal where the surface bends sharply.
                    let room = 1e-6 * (1.0 + largest(&taylor.hessian) / taylor.gradient.length());
                    let turned = (taylor.gradient.normalize() - hit.normal.as_dvec3()).length();
                    assert!(turned < room, "turned by {turned}: {}", describe());
                    // Nearer than the samples show, it can only lie at two crossings between two samples.
                    let step = spread * 4.0 / 4000.0;
                    match first {
                        Some(first) if (hit.distance as f64 - first).abs() < step => {}
                        Some(first) => assert!((hit.distance as f64) < *first, "{}", describe()),
                        None => {}
                    }
                }
            }
        }
        assert!(met > 40 && missed > 20, "{name}: {met} met, {missed} missed");
    }
}

#[test]
fn degenerate_rays_give_no_nonsense() {
    for (name, surface, mesh) in cases() {
        let placed = PlacedSurface { surface: surface.clone(), world_from_surface: DAffine3::IDENTITY };
        let on_surface = mesh.positions[mesh.positions.len() / 3];
        let size = placed.bounds().diagonal();
        let origins = [Vec3::ZERO, on_surface, Vec3::X * 5.0, Vec3::new(0.0, -7.0, 0.0), Vec3::splat(1e8)];
        let directions = [
            Vec3::X,
            Vec3::NEG_X,
            Vec3::Y,
            Vec3::NEG_Y,
            Vec3::Z,
            Vec3::NEG_Z,
            Vec3::splat(-1.0).normalize(),
            Vec3::ZERO,
            Vec3::splat(f32::NAN),
        ];
        for origin in origins {
            for direction in directions {
                for (near, far) in [(0.0, f32::INFINITY), (1e-4, 3.0), (2.0, 1.0)] {
                    if let Some(hit) = placed.intersect(origin, direction, near, far) {
                        assert!(hit.position.is_finite() && (hit.normal.length() - 1.0).abs() < 1e-5, "{name}");
                        assert!(hit.distance >= near && hit.distance <= far, "{name}: {hit:?}");
                        let taylor = placed.taylor2(hit.position.as_dvec3());
                        assert!(taylor.value.abs() < 1e-5 * taylor.gradient.length(), "{name}: {origin} {direction}");
                    }
                    if let Some(hit) = placed.refine(origin, direction, near) {
                        assert!(hit.position.is_finite() && hit.distance.abs() < near + size, "{name}: {hit:?}");
                    }
                }
            }
        }
    }
}

#[test]
fn tessellations_lie_on_the_surface_and_face_outwards() {
    for (name, surface, mesh) in cases() {
        let placed = PlacedSurface { surface: surface.clone(), world_from_surface: DAffine3::IDENTITY };
        let bounds = placed.bounds();
        let size = bounds.diagonal() as f64;
        let distance = |point: DVec3| {
            let taylor = placed.taylor2(point);
            // Rounding, and the middles of triangles, can lie beyond the end of a root's domain.
            if *name == "half a ball" && taylor.gradient == DVec3::ZERO {
                return 0.0;
            }
            taylor.value.abs() / taylor.gradient.length().max(1e-9)
        };
        for (position, normal) in mesh.positions.iter().zip(&mesh.normals) {
            assert!(distance(position.as_dvec3()) < 2e-7 * size, "{name}: {position} off");
            assert!((normal.length() - 1.0).abs() < 1e-5, "{name}: {normal}");
            let [low, high] = [bounds.min, bounds.max].map(|corner| corner.as_dvec3());
            let room = DVec3::splat(1e-7 * size);
            assert!(position.as_dvec3().cmpge(low - room).all() && position.as_dvec3().cmple(high + room).all());
        }
        let mut worst = 0f64;
        let mut backwards = 0.0;
        for triangle in &mesh.triangles {
            let [a, b, c] = triangle.map(|vertex| mesh.positions[vertex as usize].as_dvec3());
            let face = (b - a).cross(c - a);
            let normals: Vec3 = triangle.iter().map(|vertex| mesh.normals[*vertex as usize]).sum();
            // Triangles thinner than the rounding of their points have no side.
            let thickness = face.length() / (b - a).length().max((c - a).length());
            // At the ridge of the tent normals are those of one side.
            let at_ridge = *name == "tent" && [a, b, c].iter().any(|corner| corner.x.abs() < 0.02);
            if thickness > 1e-6 * size && !at_ridge && face.dot(normals.as_dvec3()) <= 0.0 {
                backwards += face.length();
            }
            for weights in [[1.0, 1.0, 1.0], [1.0, 1.0, 0.0], [0.0, 1.0, 1.0], [1.0, 0.0, 1.0]] {
                let sum: f64 = weights.iter().sum();
                worst = worst.max(distance((a * weights[0] + b * weights[1] + c * weights[2]) / sum));
            }
        }
        let longest = (bounds.max - bounds.min).max_element() as f64;
        let cell = longest / 96.0;
        let limit = match placed.surface {
            // Edges, and the end of a root's domain, are cut off within a cell.
            _ if *name == "tent" || *name == "half a ball" => cell,
            AnalyticSurface::Quadric(_) | AnalyticSurface::Implicit(_) => {
                let bend = |position: &Vec3| largest(&placed.shape_operator(position.as_dvec3()));
                0.5 * mesh.positions.iter().map(bend).fold(0.0, f64::max) * cell * cell
            }
            _ => 5e-5 * size,
        };
        assert!(worst < limit, "{name}: {worst} of {limit}");
        assert!(backwards <= 0.0, "{name}: an area of {backwards} backwards");
    }
}

#[test]
fn seams_are_closed() {
    // Every inner edge has two triangles: edges of one triangle lie at the ends of the sheet.
    for (name, surface, mesh) in cases() {
        let bits = |vertex: u32| mesh.positions[vertex as usize].to_array().map(|x| (x + 0.0).to_bits());
        let mut edges = HashMap::new();
        for [a, b, c] in &mesh.triangles {
            for (from, to) in [(a, b), (b, c), (c, a)] {
                *edges.entry((bits(*from), bits(*to))).or_insert(0) += 1;
            }
        }
        let open = edges.keys().filter(|(from, to)| !edges.contains_key(&(*to, *from)));
        let [min, max] = surface.corners().map(|corner| corner.as_vec3());
        for (from, to) in open {
            if *name == "half a ball" {
                continue; // it ends where its root does
            }
            for end in [from, to] {
                let point = Vec3::from_array(end.map(f32::from_bits));
                let at_end = match &surface {
                    AnalyticSurface::Plane { .. } => true,
                    AnalyticSurface::Revolution(_) => point.y == min.y || point.y == max.y,
                    AnalyticSurface::Quadric(_) | AnalyticSurface::Implicit(_) => {
                        point.cmpeq(min).any() || point.cmpeq(max).any()
                    }
                    _ => false,
                };
                assert!(at_end, "{name}: an open edge at {point}");
            }
        }
    }
}

#[test]
fn refinement_finds_what_the_ray_meets() {
    let mut random = Stream::new(3);
    for (name, surface, mesh) in cases() {
        let placed = placed(surface);
        let bounds = placed.bounds();
        let size = bounds.diagonal();
        let (mut found, mut lost) = (0, 0);
        for _ in 0..400 {
            let direction = random_vector(&mut random).as_vec3().normalize();
            let vertex = mesh.positions[(random.next_unit() * mesh.positions.len() as f32) as usize];
            let target = placed.world_from_surface.transform_point3(vertex.as_dvec3()).as_vec3();
            let origin = target - direction * size * 2.0;
            let Some(hit) = placed.intersect(origin, direction, 0.0, f32::INFINITY) else { continue };
            let guess = hit.distance + random.next_between(-1e-4, 1e-4) * size;
            match placed.refine(origin, direction, guess) {
                Some(refined) if (refined.distance - hit.distance).abs() < 1e-5 * size => {
                    found += 1;
                    let taylor = placed.taylor2(refined.position.as_dvec3());
                    assert!(taylor.value.abs() < 2e-6 * taylor.gradient.length(), "{name}");
                }
                _ => lost += 1, // at a silhouette or beside an end the guess may be nearer to something else
            }
        }
        assert!(found > 50 && lost * 50 < found, "{name}: {found} found, {lost} lost");
    }
    // Beside the silhouette there is nothing.
    let sphere =
        PlacedSurface { surface: AnalyticSurface::Sphere { radius: 1.0 }, world_from_surface: DAffine3::IDENTITY };
    assert!(sphere.refine(Vec3::new(1.0001, 0.0, 5.0), Vec3::NEG_Z, 5.0).is_none());
    assert!(sphere.refine(Vec3::new(0.9999, 0.0, 5.0), Vec3::NEG_Z, 4.999).is_some());
}

#[test]
fn impossible_surfaces_are_refused() {
    let parameter = |result: Result<(), SurfaceError>| result.unwrap_err().parameter;
    assert_eq!(parameter(Ellipsoid::new([1.0, 0.0, 1.0]).map(|_| ())), "radii");
    assert_eq!(parameter(Ellipsoid::new([1.0, f64::NAN, 1.0]).map(|_| ())), "radii");
    assert_eq!(parameter(Torus::new(1.0, 1.0).map(|_| ())), "minor_radius");
    assert_eq!(parameter(Torus::new(-1.0, 0.5).map(|_| ())), "major_radius");
    assert_eq!(parameter(Superquadric::new([1.0; 3], [0.0, 1.0]).map(|_| ())), "exponents");
    assert_eq!(parameter(Superquadric::new([1.0; 3], [1.0, f64::INFINITY]).map(|_| ())), "exponents");
    assert_eq!(parameter(Revolution::new(0.0, [0.0, 0.0, 0.0, 1.0]).map(|_| ())), "height");
    assert_eq!(parameter(Revolution::new(1.0, [0.0; 4]).map(|_| ())), "profile");
    // Negative in the middle alone.
    assert_eq!(parameter(Revolution::new(1.0, [0.0, 4.0, -4.0, 0.9]).map(|_| ())), "profile");
    assert!(Revolution::new(1.0, [0.0, 4.0, -4.0, 1.1]).is_ok());
    let bounds = ([-1.0; 3], [1.0; 3]);
    assert_eq!(parameter(Quadric::new([0.0; 10], bounds.0, bounds.1).map(|_| ())), "coefficients");
    assert_eq!(parameter(Quadric::new([f64::NAN; 10], bounds.0, bounds.1).map(|_| ())), "coefficients");
    assert_eq!(parameter(Quadric::new([1.0; 10], bounds.1, bounds.0).map(|_| ())), "bounds_max");
}
