//! Random paths through spheres and planes: found again by the solver, and followed by a tracer of the tests' own.

use super::*;

/// A ray in double precision, its meetings with spheres and planes, and the laws of optics: independent of the library.
#[derive(Clone, Copy)]
struct Traced {
    origin: DVec3,
    direction: DVec3,
}

#[derive(Clone, Copy)]
enum Shape {
    Ball { center: DVec3, radius: f64 },
    Sheet { point: DVec3, normal: DVec3 },
}

impl Shape {
    fn meet(&self, ray: &Traced) -> Option<(f64, DVec3)> {
        match *self {
            Self::Ball { center, radius } => {
                let relative = ray.origin - center;
                let b = relative.dot(ray.direction);
                let root = (b * b - relative.length_squared() + radius * radius).sqrt();
                let distance = [-b - root, -b + root].into_iter().find(|d| *d > 1e-7)?;
                Some((distance, (relative + ray.direction * distance) / radius))
            }
            Self::Sheet { point, normal } => {
                let distance = (point - ray.origin).dot(normal) / ray.direction.dot(normal);
                (distance > 1e-7).then_some((distance, normal))
            }
        }
    }
}

/// Snell's law in vector form (Glassner 1989), with the normal towards where the ray comes from.
fn bent(direction: DVec3, normal: DVec3, eta: f64) -> Option<DVec3> {
    let cosine = -direction.dot(normal);
    let square = 1.0 - eta * eta * (1.0 - cosine * cosine);
    (square > 0.0).then(|| direction * eta + normal * (eta * cosine - square.sqrt()))
}

fn scattered(ray: &Traced, shape: &Shape, kind: BounceKind, index: f64) -> Option<(Traced, DVec3)> {
    let (distance, outer) = shape.meet(ray)?;
    let origin = ray.origin + ray.direction * distance;
    let (normal, eta) = if ray.direction.dot(outer) < 0.0 { (outer, 1.0 / index) } else { (-outer, index) };
    let direction = match kind {
        BounceKind::Reflect => ray.direction - normal * (2.0 * ray.direction.dot(normal)),
        BounceKind::Transmit => bent(ray.direction, normal, eta)?,
    };
    Some((Traced { origin, direction: direction.normalize() }, outer))
}

const INDEX: f32 = 1.5;

/// Two mirror balls, a glass ball, a glass slab of two planes and a tilted mirror.
fn world() -> (Scene, Vec<Shape>) {
    let glass = Material::glass("glass", INDEX);
    let mut parts = Vec::new();
    let mut shapes = Vec::new();
    for (center, radius, material) in [
        (Vec3::new(-2.0, 0.0, 0.0), 1.0, mirror()),
        (Vec3::new(2.0, 0.5, 0.25), 1.25, mirror()),
        (Vec3::new(0.0, 0.0, -1.5), 0.75, glass.clone()),
    ] {
        parts.push(sphere(center, radius, material));
        shapes.push(Shape::Ball { center: center.as_dvec3(), radius: radius as f64 });
    }
    let turn = Quat::from_rotation_x(std::f32::consts::FRAC_PI_2);
    let over = Quat::from_rotation_x(-std::f32::consts::FRAC_PI_2);
    for (turn, place, material) in [
        (turn, Vec3::new(0.0, 0.0, 2.5), glass.clone()),
        (over, Vec3::new(0.0, 0.0, 2.0), glass),
        (Quat::from_rotation_z(0.3), Vec3::new(0.0, -3.0, 0.0), mirror()),
    ] {
        let place = Affine3A::from_rotation_translation(turn, place);
        parts.push((AnalyticSurface::Plane { half_width: 9.0, half_height: 9.0 }, place, material));
        // The plane that the single precision numbers stand for.
        let normal = Vec3::from(place.matrix3.y_axis).as_dvec3();
        let point = Vec3::from(place.translation).as_dvec3();
        shapes.push(Shape::Sheet { point, normal: normal.normalize() });
    }
    (scene_of(&parts), shapes)
}

#[test]
fn random_paths_are_found_again_and_obey_the_laws() {
    let (scene, shapes) = world();
    let surfaces = SpecularSurfaces::new(&scene);
    let mut random = Stream::new(0x1a);
    let (mut paths, mut found_by_count, mut kept_by_count, mut mixed) = (0, [0; 5], [0; 5], 0);
    while paths < 6000 {
        let eye = vector(&mut random) * 3.0;
        let mut ray = Traced { origin: eye, direction: vector(&mut random).normalize() };
        let first = ray;
        let wanted = 1 + (random.next_unit() * 4.0) as usize;
        let mut bounces = Vec::new();
        let mut least_cosine: f64 = 1.0;
        // Objects in the way count: the nearest is met.
        while bounces.len() < wanted {
            let met = shapes.iter().enumerate().filter_map(|(k, shape)| Some((shape.meet(&ray)?.0, k)));
            let Some((_, object)) = met.min_by(|a, b| a.0.total_cmp(&b.0)) else { break };
            let kind = if surfaces.is_lens(object as u32) && random.next_unit() < 0.7 {
                BounceKind::Transmit
            } else {
                BounceKind::Reflect
            };
            let Some((next, normal)) = scattered(&ray, &shapes[object], kind, surfaces.index_of(object as u32)) else {
                break;
            };
            least_cosine = least_cosine.min(ray.direction.dot(normal).abs()).min(next.direction.dot(normal).abs());
            bounces.push((bounce(object as u32, kind), ManifoldVertex::on_surface(next.origin)));
            ray = next;
        }
        if bounces.len() < wanted || least_cosine < 0.1 || ray.origin.length() > 30.0 {
            continue;
        }
        paths += 1;
        let point = ray.origin + ray.direction * random.next_between(0.3, 2.0) as f64;
        let path = PathSites::new(&bounces).unwrap();
        // Numbers in single precision place the planes: 1e-7, not 1e-12.
        assert!(residual(&surfaces, &Eye::Point(eye), point, &path).unwrap() < 1e-5);
        kept_by_count[wanted] += 1;
        // Bounces are off by a hundredth, and so is the point: a neighbouring path is looked for.
        let mut start = path;
        for site in &mut start.sites[..wanted] {
            site.position += vector(&mut random) * 1e-3;
        }
        let moved = point + vector(&mut random) * 1e-3;
        let Some(found) = solve(&surfaces, &Eye::Point(eye), moved, &start, 30, 1e-13) else { continue };
        if !found.converged {
            continue;
        }
        found_by_count[wanted] += 1;
        mixed += u32::from(bounces.iter().any(|b| b.0.kind != bounces[0].0.kind));
        // From the eye through the first bounce: the laws lead to the point.
        let aim = found.sites.sites[0].position - eye;
        let mut ray = Traced { origin: eye, direction: aim.normalize() };
        assert!(first.direction.dot(ray.direction) > 0.9);
        let mut spread: f64 = 1.0;
        for (bounce, site) in found.sites.bounces.iter().zip(&found.sites.sites).take(wanted) {
            let frame = surfaces.frame(bounce.object, site).unwrap();
            // The laws at the bounces themselves: angles (of sines times indices) agree, in one plane.
            let distance = (site.position - ray.origin).dot(ray.direction);
            let off = (site.position - ray.origin - ray.direction * distance).length();
            assert!(off < 1e-9 * spread, "{off} beside the bounce");
            let next = scattered(
                &Traced { origin: site.position - ray.direction, direction: ray.direction },
                &Shape::Sheet { point: site.position, normal: frame.normal },
                bounce.kind,
                surfaces.index_of(bounce.object),
            );
            ray = Traced { origin: site.position, direction: next.unwrap().0.direction };
            spread *= 1.0 + 4.0 / frame.normal_change[0].length().recip().min(1e3);
        }
        let off = (moved - ray.origin - ray.direction * (moved - ray.origin).dot(ray.direction)).length();
        assert!(off < 1e-9, "{off} beside the point after {wanted} bounces");
    }
    for count in 1..=4 {
        let share = found_by_count[count] as f64 / kept_by_count[count] as f64;
        assert!(share > 0.97, "{count} bounces: {found_by_count:?} of {kept_by_count:?}");
    }
    assert!(mixed > 300, "{mixed} mixed paths");
}
