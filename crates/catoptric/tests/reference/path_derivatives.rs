//! Path Jacobians and Hessians against central differences, and against the independent derivation by ray bundles.
//!
//! Paths are traced forwards from the eye, so they satisfy the specular constraint whatever the solvers do; perturbed
//! paths are found by aiming: the view ray is turned until the traced path passes through the moved point.

use catoptric::math::random::Stream;
use catoptric::optics::path::bundle::{BounceKind, Eye, OutgoingRays, RayBundle};
use catoptric::optics::path::path_derivatives::{PathBounce, PathDerivatives, PointDerivatives};
use catoptric::surface::patch::{SurfacePatch, tangent_frame};
use catoptric::surface::{
    AnalyticSurface, Ellipsoid, PlacedSurface, Quadric, Revolution, Superquadric, SurfaceMesh, Torus,
};
use glam::{Affine3A, DMat3, DVec2, DVec3, EulerRot, Quat};

/// Configurations nearer to a caustic than this (see `PathDerivatives::conditioning`) are left out, and those that
/// meet any surface under a cosine below 0.3 (0.25 after refraction), or whose derivatives exceed [`LARGEST_CHANGE`]:
/// there differences of any step are worth less than the bounds tested.
const MIN_CONDITIONING: f64 = 0.02;

/// See [`MIN_CONDITIONING`]; scene units a scene unit, and a scene unit squared.
const LARGEST_CHANGE: [f64; 2] = [5.0, 50.0];

struct Bounce {
    surface: PlacedSurface,
    kind: BounceKind,
    index: f64,
}

struct Ray {
    origin: DVec3,
    direction: DVec3,
}

/// A path from the eye: its surfaces, and its rays (the first one is the view ray).
struct Path {
    eye: Eye,
    bounces: Vec<Bounce>,
    rays: Vec<Ray>,
    point: DVec3,
}

/// A surface, and its tessellation: where it can be met.
type Shape = (AnalyticSurface, SurfaceMesh);

fn shapes() -> Vec<Shape> {
    // A one-sheeted hyperboloid: saddle-shaped everywhere. And the vase of Chen and Arvo 2000.
    let hyperboloid = [1.0, -0.5, 1.0, 0.0, 0.0, 0.2, 0.0, 0.1, 0.0, -0.8];
    let surfaces = vec![
        AnalyticSurface::Sphere { radius: 1.3 },
        AnalyticSurface::Plane { half_width: 2.0, half_height: 1.5 },
        AnalyticSurface::Ellipsoid(Ellipsoid::new([1.4, 0.9, 1.1]).expect("the path is regular")),
        AnalyticSurface::Quadric(
            Quadric::new(hyperboloid, [-2.0, -1.0, -2.0], [2.0, 1.0, 2.0]).expect("the path is regular"),
        ),
        AnalyticSurface::Torus(Torus::new(1.5, 0.6).expect("the path is regular")),
        AnalyticSurface::Superquadric(Superquadric::new([1.2, 1.0, 1.3], [0.8, 1.3]).expect("the path is regular")),
        AnalyticSurface::Revolution(Revolution::new(2.0, [5.80, -9.78, 3.90, 0.47]).expect("the path is regular")),
    ];
    surfaces.into_iter().map(|surface| (surface.clone(), surface.tessellate())).collect()
}

/// The ray's meeting with the surface near a distance, to double precision.
fn meet(surface: &PlacedSurface, ray: &Ray, near: f64) -> Option<DVec3> {
    let mut distance = near;
    for _ in 0..30 {
        let taylor = surface.taylor2(ray.origin + ray.direction * distance);
        let step = taylor.value / taylor.gradient.dot(ray.direction);
        distance -= step;
        if step.is_nan() || step.abs() <= 1e-16 * distance.abs() {
            break;
        }
    }
    let at = ray.origin + ray.direction * distance;
    (at.is_finite() && (distance - near).abs() < 0.1).then_some(at)
}

/// The direction after a bounce; the normal on the side that the ray comes from.
fn scatter(direction: DVec3, normal: DVec3, kind: BounceKind, eta: f64) -> Option<DVec3> {
    let cosine = -direction.dot(normal);
    let direction = match kind {
        BounceKind::Reflect => direction + normal * (2.0 * cosine),
        BounceKind::Transmit => {
            let cos2 = 1.0 - eta * eta * (1.0 - cosine * cosine);
            direction * eta + normal * (eta * cosine - (cos2 > 0.0).then(|| cos2.sqrt())?)
        }
    };
    Some(direction.normalize())
}

impl Bounce {
    /// The ray after the bounce, and the least cosine of its two angles.
    fn leave(&self, ray: &Ray, near: f64) -> Option<(Ray, f64)> {
        let at = meet(&self.surface, ray, near)?;
        let outer = self.surface.taylor2(at).normal()?;
        let outside = ray.direction.dot(outer) < 0.0;
        let (normal, eta) = if outside { (outer, 1.0 / self.index) } else { (-outer, self.index) };
        let direction = scatter(ray.direction, normal, self.kind, eta)?;
        let cosine = ray.direction.dot(normal).abs().min(direction.dot(normal).abs());
        Some((Ray { origin: at, direction }, cosine))
    }
}

fn unit_vector(random: &mut Stream) -> DVec3 {
    loop {
        let [x, y, z] = [0; 3].map(|_| random.next_between(-1.0, 1.0) as f64);
        let vector = DVec3::new(x, y, z);
        if (0.1..1.0).contains(&vector.length()) {
            return vector.normalize();
        }
    }
}

/// A surface turned at random and put so that the ray meets one of its points at a distance.
fn put_in_the_way(shape: &Shape, ray: &Ray, distance: f64, random: &mut Stream) -> PlacedSurface {
    let (surface, mesh) = shape;
    let angle = |random: &mut Stream| random.next_between(-3.0, 3.0);
    let rotation = Quat::from_euler(EulerRot::XYZ, angle(random), angle(random), angle(random));
    let corners = mesh.triangles[(random.next_unit() * mesh.triangles.len() as f32) as usize];
    let (u, v) = (random.next_between(0.1, 0.45), random.next_between(0.1, 0.45));
    let [a, b, c] = corners.map(|corner| mesh.positions[corner as usize]);
    let local = a + (b - a) * u + (c - a) * v;
    let translation = (ray.origin + ray.direction * distance).as_vec3() - rotation * local;
    PlacedSurface {
        surface: surface.clone(),
        world_from_surface: Affine3A::from_rotation_translation(rotation, translation).as_daffine3(),
    }
}

/// A random path over given surfaces and kinds of bounces; returns `None` if the draw is degenerate.
fn draw(kinds: &[(&Shape, BounceKind)], at_infinity: bool, random: &mut Stream) -> Option<Path> {
    let start = unit_vector(random) * 2.0;
    let first = Ray { origin: start, direction: unit_vector(random) };
    let eye = if at_infinity { Eye::Direction(first.direction) } else { Eye::Point(start) };
    let mut rays = vec![first];
    let mut bounces = Vec::new();
    for (surface, kind) in kinds {
        let ray = rays.last().expect("the path is regular");
        let distance = random.next_between(0.6, 2.5) as f64;
        let surface = put_in_the_way(surface, ray, distance, random);
        let bounce = Bounce { surface, kind: *kind, index: random.next_between(1.2, 1.8) as f64 };
        let (next, cosine) = bounce.leave(ray, distance)?;
        if cosine < 0.3 {
            return None;
        }
        rays.push(next);
        bounces.push(bounce);
    }
    let last = rays.last().expect("the path is regular");
    let point = last.origin + last.direction * random.next_between(0.6, 2.5) as f64;
    Some(Path { eye, bounces, rays, point })
}

/// The limit of a central difference for small steps: Richardson's extrapolation over halved steps, stopped where its
/// own estimate of the error is least (Ridders 1982); returns `None` if no step works.
fn extrapolated(difference: &dyn Fn(f64) -> Option<DVec3>) -> Option<DVec3> {
    let mut previous: Vec<DVec3> = Vec::new();
    let mut best: Option<(f64, DVec3)> = None;
    for level in 0..8 {
        let Some(plain) = difference(2e-2 * 0.5f64.powi(level)) else {
            previous.clear();
            continue;
        };
        let mut row = vec![plain];
        for (k, coarser) in previous.iter().enumerate() {
            let finer = row[k];
            let next = finer + (finer - *coarser) / (4f64.powi(k as i32 + 1) - 1.0);
            let error = next.distance(finer).max(next.distance(*coarser));
            if best.is_none_or(|(least, _)| error < least) {
                best = Some((error, next));
            }
            row.push(next);
        }
        previous = row;
    }
    best.map(|(_, value)| value)
}

impl Path {
    /// The view ray, moved or turned by two small numbers.
    fn view_ray(&self, turn: DVec2) -> Ray {
        let Ray { origin, direction } = self.rays[0];
        let [a, b] = tangent_frame(direction);
        let change = a * turn.x + b * turn.y;
        match self.eye {
            Eye::Point(_) => Ray { origin, direction: (direction + change).normalize() },
            Eye::Direction(_) => Ray { origin: origin + change, direction },
        }
    }

    /// The last bounce point, and by how much the traced path misses a point to the side.
    fn traced(&self, turn: DVec2, point: DVec3) -> Option<(Vec<DVec3>, DVec2)> {
        let mut ray = self.view_ray(turn);
        let mut points = Vec::new();
        for (bounce, known) in self.bounces.iter().zip(&self.rays[1..]) {
            let near = (known.origin - ray.origin).dot(ray.direction);
            ray = bounce.leave(&ray, near)?.0;
            points.push(ray.origin);
        }
        let [a, b] = tangent_frame(self.rays.last()?.direction);
        let relative = point - ray.origin;
        let miss = relative - ray.direction * relative.dot(ray.direction);
        Some((points, DVec2::new(a.dot(miss), b.dot(miss))))
    }

    /// The bounce points of the path to a point near this path's, from the eye on.
    fn aimed(&self, point: DVec3) -> Option<Vec<DVec3>> {
        let step = 1e-5;
        let column = |axis: DVec2| {
            let (_, ahead) = self.traced(axis * step, self.point)?;
            let (_, behind) = self.traced(axis * -step, self.point)?;
            Some((ahead - behind) / (2.0 * step))
        };
        let inverse = glam::DMat2::from_cols(column(DVec2::X)?, column(DVec2::Y)?).inverse();
        let mut turn = DVec2::ZERO;
        let mut best = self.traced(turn, point)?;
        for _ in 0..60 {
            turn -= inverse * best.1;
            let next = self.traced(turn, point)?;
            let done = next.1.length() >= 0.5 * best.1.length() && next.1.length() < 1e-13;
            best = next;
            if done {
                break;
            }
        }
        // Errors of rounding: the extrapolation of differences estimates them and keeps its steps large enough.
        (best.1.length() < 2e-13).then_some(best.0)
    }

    /// The path's bounces as path derivatives want them: from the scene point on.
    fn bounces_from_the_point(&self) -> Vec<PathBounce> {
        let bounce = |i: usize| {
            let Bounce { surface, kind, index } = &self.bounces[i];
            let position = self.rays[i + 1].origin;
            let taylor = surface.taylor3(position);
            let outside = |direction: DVec3| direction.dot(taylor.lower.gradient) > 0.0;
            let media = |direction: DVec3| match kind {
                BounceKind::Reflect => 1.0,
                BounceKind::Transmit if outside(direction) => 1.0,
                BounceKind::Transmit => *index,
            };
            let weights = [media(self.rays[i + 1].direction), media(-self.rays[i].direction)];
            PathBounce { position, taylor, weights }
        };
        (0..self.bounces.len()).rev().map(bounce).collect()
    }

    fn derivatives(&self) -> Option<PathDerivatives> {
        PathDerivatives::of_path(self.point, &self.bounces_from_the_point(), &self.eye)
    }

    /// The path as far as its first bounces, and from there to the next bounce point.
    fn beginning(&self, bounces: usize) -> Path {
        let point = self.rays.get(bounces + 1).map_or(self.point, |ray| ray.origin);
        let kept = |bounce: &Bounce| Bounce { surface: bounce.surface.clone(), ..*bounce };
        Path {
            eye: self.eye,
            bounces: self.bounces[..bounces].iter().map(kept).collect(),
            rays: self.rays[..=bounces].iter().map(|ray| Ray { ..*ray }).collect(),
            point,
        }
    }

    /// Derivatives of one bounce point (counted from the eye) by the end point: central differences,
    /// extrapolated.
    fn differences(&self, bounce: usize) -> Option<PointDerivatives> {
        let at = |step: DVec3| Some(self.aimed(self.point + step)?[bounce]);
        let axes = [DVec3::X, DVec3::Y, DVec3::Z];
        let first = |k: usize| {
            let difference = |h: f64| Some((at(axes[k] * h)? - at(-axes[k] * h)?) / (2.0 * h));
            extrapolated(&difference)
        };
        let second = |j: usize, k: usize| {
            let difference = |h: f64| {
                let (a, b) = (axes[j] * h, axes[k] * h);
                Some((at(a + b)? - at(a - b)? - at(b - a)? + at(-a - b)?) / (4.0 * h * h))
            };
            extrapolated(&difference)
        };
        let jacobian = DMat3::from_cols(first(0)?, first(1)?, first(2)?);
        let mut hessian = [DMat3::ZERO; 3];
        for (j, k) in [(0, 0), (0, 1), (0, 2), (1, 1), (1, 2), (2, 2)] {
            let value = second(j, k)?;
            for (i, matrix) in hessian.iter_mut().enumerate() {
                matrix.col_mut(k)[j] = value[i];
                matrix.col_mut(j)[k] = value[i];
            }
        }
        Some(PointDerivatives { jacobian, hessian })
    }
}

fn jacobian_norm(matrix: &DMat3) -> f64 {
    matrix.to_cols_array().iter().map(|entry| entry * entry).sum::<f64>().sqrt()
}

fn hessian_norm(hessian: &[DMat3; 3]) -> f64 {
    hessian.iter().map(|matrix| jacobian_norm(matrix).powi(2)).sum::<f64>().sqrt()
}

/// The errors of the Jacobian and of the Hessian relative to their own size (Frobenius norms), which counts as at
/// least 1e-3 of the scene's size, 1: a derivative that vanishes (planes) has no relative error.
fn relative_errors(found: &PointDerivatives, expected: &PointDerivatives) -> [f64; 2] {
    let bends: [DMat3; 3] = std::array::from_fn(|i| found.hessian[i] - expected.hessian[i]);
    [
        jacobian_norm(&(found.jacobian - expected.jacobian)) / jacobian_norm(&expected.jacobian).max(1e-3),
        hessian_norm(&bends) / hessian_norm(&expected.hessian).max(1e-3),
    ]
}

/// All sequences of kinds of bounces up to three, each with surfaces drawn from all there are.
fn for_each_sequence(draws: usize, mut test: impl FnMut(&str, &Path, &PathDerivatives)) {
    let shapes = shapes();
    let mut random = Stream::new(2000);
    let mut tested = vec![0; shapes.len()];
    for bounces in 1..=3usize {
        for code in 0..1usize << bounces {
            let mut accepted = 0;
            for attempt in 0..400 * draws {
                // Every surface takes its turn as the first one of a path.
                let kinds: Vec<_> = (0..bounces)
                    .map(|i| {
                        let any = (random.next_unit() * shapes.len() as f32) as usize;
                        let which = if i == 0 { accepted % shapes.len() } else { any };
                        let transmits = code >> i & 1 == 1;
                        (which, if transmits { BounceKind::Transmit } else { BounceKind::Reflect })
                    })
                    .collect();
                let drawn: Vec<_> = kinds.iter().map(|(which, kind)| (&shapes[*which], *kind)).collect();
                let Some(path) = draw(&drawn, attempt % 4 == 3, &mut random) else { continue };
                let Some(derivatives) = path.derivatives() else { continue };
                let largest = |part: &PointDerivatives| {
                    jacobian_norm(&part.jacobian) > LARGEST_CHANGE[0] || hessian_norm(&part.hessian) > LARGEST_CHANGE[1]
                };
                if derivatives.conditioning < MIN_CONDITIONING
                    || derivatives.bounces.iter().any(largest)
                    || largest(&derivatives.total())
                {
                    continue;
                }
                let name = drawn
                    .iter()
                    .map(|((surface, _), kind)| format!("{}:{}", surface.kind(), kind.letter()))
                    .collect::<Vec<_>>()
                    .join(">");
                kinds.iter().for_each(|(which, _)| tested[*which] += 1);
                test(&name, &path, &derivatives);
                accepted += 1;
                if accepted == draws {
                    break;
                }
            }
            assert_eq!(accepted, draws, "{bounces} bounces, kinds {code:b}: too few configurations were drawn");
        }
    }
    assert!(tested.iter().all(|count| *count >= draws), "surfaces tested: {tested:?}");
}

#[test]
fn derivatives_agree_with_central_differences() {
    let mut left_out = 0;
    let mut count = 0;
    for_each_sequence(14, |name, path, derivatives| {
        // x_N by the scene point, and the bounce nearest to the end by the end, for all beginnings of the path.
        let bounces = path.bounces.len();
        let parts = (1..=bounces).map(|k| (path.beginning(k), k - 1, derivatives.bounces[bounces - k]));
        for (path, bounce, found) in parts.chain([(path.beginning(bounces), 0, derivatives.total())]) {
            count += 1;
            let Some(expected) = path.differences(bounce) else {
                left_out += 1;
                continue;
            };
            for (order, error) in relative_errors(&found, &expected).into_iter().enumerate() {
                assert!(error < 1e-6, "{name}, {:?}, bounce {bounce}, order {}: {error:e}", path.eye, order + 1);
            }
        }
    });
    assert!(left_out * 50 < count, "{left_out} of {count} could not be differenced");
}

#[test]
fn derivatives_agree_with_ray_bundles() {
    for_each_sequence(40, |name, path, derivatives| {
        let patch = |i: usize| {
            let at = path.rays[i + 1].origin;
            SurfacePatch::of_implicit(at, &path.bounces[i].surface.taylor3(at)).expect("the path is regular")
        };
        let first = patch(0);
        let mut bundle = RayBundle::arriving(&path.eye, &first).expect("the path is regular");
        bundle = bundle
            .scattered(&first, &RayBundle::own_parameters(), path.bounces[0].kind, path.bounces[0].index)
            .expect("the path is regular");
        for (i, bounce) in path.bounces.iter().enumerate().skip(1) {
            let patch = patch(i);
            let (arrived, u) = bundle.advanced(&patch).expect("the path is regular");
            bundle = arrived.scattered(&patch, &u, bounce.kind, bounce.index).expect("the path is regular");
        }
        let rays = OutgoingRays::new(&bundle).expect("the path is regular");
        let expected = by_bundle(&rays, &first, path.point);
        let found = derivatives.total();
        for (order, error) in relative_errors(&found, &expected).into_iter().enumerate() {
            assert!(error < 1e-9, "{name}, {:?}, order {}: {error:e}", path.eye, order + 1);
        }
    });
}

/// The first bounce point's derivatives by a point on the central ray, from a bundle's outgoing rays.
fn by_bundle(rays: &OutgoingRays, first: &SurfacePatch, point: DVec3) -> PointDerivatives {
    let [d, a, b] = [rays.direction, rays.across[0], rays.across[1]];
    let on_surface = |z: DVec2| first.tangents[0] * z.x + first.tangents[1] * z.y;
    // To the side the expansion is the Taylor polynomial: a linear part and a quadratic form.
    let linear = |step: DVec3| on_surface(rays.perturbed(point + step).expect("the path is regular").linear);
    let square = |step: DVec3| {
        let moved = rays.perturbed(point + step).expect("the path is regular");
        let z = moved.linear;
        let bend = first.bend[0] * (z.x * z.x) + first.bend[1] * (2.0 * z.x * z.y) + first.bend[2] * (z.y * z.y);
        on_surface(moved.quadratic) * 2.0 + bend
    };
    // Along the ray nothing changes, but the inverse of the spread does: -S^-1 S' S^-1.
    let distance = (point - rays.origin).dot(d);
    let columns = |[[a, b], [c, d]]: [[f64; 2]; 2]| glam::DMat2::from_cols(DVec2::new(a, c), DVec2::new(b, d));
    let inverse = columns(rays.spread(distance)).inverse();
    let slope = columns(rays.spread(distance + 1.0)) - columns(rays.spread(distance));
    let mixed = |side: DVec2| on_surface(inverse * (slope * (inverse * side)) * -1.0);
    // Components in the ray's frame: d, a, b.
    let (ha, hb) = (square(a), square(b));
    let hab = (square(a + b) - ha - hb) * 0.5;
    let (ma, mb) = (mixed(DVec2::X), mixed(DVec2::Y));
    let frame = DMat3::from_cols(d, a, b);
    let hessian = std::array::from_fn(|i| {
        let in_frame = DMat3::from_cols(
            DVec3::new(0.0, ma[i], mb[i]),
            DVec3::new(ma[i], ha[i], hab[i]),
            DVec3::new(mb[i], hab[i], hb[i]),
        );
        frame * in_frame * frame.transpose()
    });
    PointDerivatives { jacobian: DMat3::from_cols(DVec3::ZERO, linear(a), linear(b)) * frame.transpose(), hessian }
}

#[test]
fn perturbed_paths_err_by_one_order_more_than_they_keep() {
    let mut rates: [Vec<f64>; 2] = Default::default();
    for_each_sequence(3, |_, path, derivatives| {
        let direction = DVec3::new(0.5, -0.6, 0.4);
        let error = |scale: f64, second_order: bool| {
            let truth = path.aimed(path.point + direction * scale)?;
            let changes = derivatives.perturbed(direction * scale, second_order);
            let worst = truth.iter().rev().zip(path.rays[1..].iter().rev()).zip(changes);
            Some(worst.map(|((truth, ray), change)| truth.distance(ray.origin + change)).fold(0f64, f64::max))
        };
        for (order, rates) in rates.iter_mut().enumerate() {
            if let (Some(coarse), Some(fine)) = (error(4e-3, order == 1), error(1e-3, order == 1))
                && fine > 1e-12
            {
                rates.push((coarse / fine).log2() / 2.0);
            }
        }
    });
    for (order, rates) in rates.iter_mut().enumerate() {
        rates.sort_by(f64::total_cmp);
        let median = rates[rates.len() / 2];
        assert!(rates.len() >= 20, "order {}: {} paths had an error to speak of", order + 1, rates.len());
        assert!((median - (order as f64 + 2.0)).abs() < 0.1, "order {}: rate {median}", order + 1);
    }
}

#[test]
fn degenerate_paths_have_no_derivatives() {
    let sphere = PlacedSurface {
        surface: AnalyticSurface::Sphere { radius: 1.0 },
        world_from_surface: Affine3A::IDENTITY.as_daffine3(),
    };
    let at = |position: DVec3| PathBounce { position, taylor: sphere.taylor3(position), weights: [1.0; 2] };
    let eye = Eye::Point(DVec3::Z * 3.0);
    let top = at(DVec3::Z);
    assert!(PathDerivatives::of_path(DVec3::Z * 2.0, &[top], &eye).is_some());
    assert_eq!(PathDerivatives::of_path(DVec3::Z * 2.0, &[], &eye), None);
    assert_eq!(PathDerivatives::of_path(DVec3::Z * 2.0, &[top; 5], &eye), None);
    assert_eq!(PathDerivatives::of_path(DVec3::Z, &[top], &eye), None, "the point on the surface");
    assert_eq!(PathDerivatives::of_path(DVec3::Z * 2.0, &[top], &Eye::Point(DVec3::Z)), None, "the eye on the surface");
    assert_eq!(PathDerivatives::of_path(DVec3::Z * 2.0, &[at(DVec3::ZERO)], &eye), None, "no normal");
    assert_eq!(PathDerivatives::of_path(DVec3::NAN, &[top], &eye), None);
    assert_eq!(PathDerivatives::of_path(DVec3::Z * 2.0, &[top], &Eye::Direction(DVec3::NAN)), None);
    // Within the sphere both at the centre: every point of it reflects, so this is a caustic.
    assert_eq!(PathDerivatives::of_path(DVec3::ZERO, &[top], &Eye::Point(DVec3::ZERO)), None);
}
