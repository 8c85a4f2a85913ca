//! Paths over triangle meshes: the hit point on the flat triangle, the direction from the interpolated normal.

use super::*;
use crate::optics::path::manifold::{flat_grid, grid, mesh_scene};
use catoptric_core::surface::sphere_mesh;

/// The point of a triangle and the normal interpolated there, by their definitions.
fn truth(scene: &Scene, site: &ManifoldVertex) -> (DVec3, DVec3) {
    let vertices = scene.triangles[site.triangle as usize];
    let weights = [1.0 - site.barycentrics[0] - site.barycentrics[1], site.barycentrics[0], site.barycentrics[1]];
    let blend = |of: &[Vec3]| {
        let parts = vertices.iter().zip(weights).map(|(&v, weight)| of[v as usize].as_dvec3() * weight);
        parts.sum::<DVec3>()
    };
    (blend(&scene.positions), blend(&scene.normals).normalize())
}

fn random_site(scene: &Scene, random: &mut Stream) -> ManifoldVertex {
    let triangle = (random.next_unit() * scene.triangles.len() as f32) as u32;
    let (a, b) = (random.next_between(0.02, 0.98) as f64, random.next_between(0.02, 0.98) as f64);
    let barycentrics = if a + b < 0.98 { [a, b] } else { [0.98 - a.min(0.97), (0.98 - b).max(0.01)] };
    ManifoldVertex { position: DVec3::ZERO, triangle, barycentrics }
}

fn distance_of_ray(origin: DVec3, direction: DVec3, point: DVec3) -> f64 {
    let relative = point - origin;
    (relative - direction * relative.dot(direction)).length()
}

#[test]
fn reflections_in_a_sphere_of_triangles_are_exact() {
    let scene = mesh_scene(&sphere_mesh(1.0, 24, 48), mirror());
    let surfaces = SpecularSurfaces::new(&scene);
    let mut random = Stream::new(77);
    let (mut tried, mut same) = (0, 0);
    while tried < 2000 {
        let site = random_site(&scene, &mut random);
        let (at, normal) = truth(&scene, &site);
        let eye = vector(&mut random).normalize() * random.next_between(1.3, 5.0) as f64;
        let out = (at - eye).normalize() - normal * (2.0 * (at - eye).normalize().dot(normal));
        if (eye - at).normalize().dot(normal) < 0.2 {
            continue;
        }
        tried += 1;
        let point = at + out * random.next_between(0.3, 4.0) as f64;
        // Several triangles away: each is 0.13 wide at the most.
        let step = DVec2::new(random.next_between(-0.3, 0.3) as f64, random.next_between(-0.3, 0.3) as f64);
        let start = surfaces.moved(0, &site, step).unwrap();
        assert_ne!((start.triangle, step.length() > 0.2), (site.triangle, true));
        let start = PathSites::new(&[(bounce(0, BounceKind::Reflect), start)]).unwrap();
        let Some(found) = solve(&surfaces, &Eye::Point(eye), point, &start, 40, 1e-12) else { continue };
        if !found.converged {
            continue;
        }
        let (found_at, normal) = truth(&scene, &found.sites.sites[0]);
        assert!(surfaces.is_within(0, &found.sites.sites[0]));
        assert!(found_at.distance(found.sites.sites[0].position) < 1e-14);
        let incoming = (found_at - eye).normalize();
        let off = distance_of_ray(found_at, incoming - normal * (2.0 * incoming.dot(normal)), point);
        assert!(off < 1e-9, "{off}");
        same += u32::from(found_at.distance(at) < 1e-8);
    }
    assert!(same as f64 > 0.985 * tried as f64, "{same} of {tried}");
}

#[test]
fn two_refractions_through_a_glass_ball_of_triangles_are_exact() {
    let scene = mesh_scene(&sphere_mesh(1.0, 24, 48), Material::glass("glass", 1.5));
    let surfaces = SpecularSurfaces::new(&scene);
    let mut random = Stream::new(78);
    let bent = |direction: DVec3, normal: DVec3, eta: f64| {
        let cosine = -direction.dot(normal);
        direction * eta + normal * (eta * cosine - (1.0 - eta * eta * (1.0 - cosine * cosine)).sqrt())
    };
    let leave = |from: DVec3, direction: DVec3| {
        (0..scene.triangles.len() as u32).find_map(|triangle| {
            let [a, b, c] = scene.triangles[triangle as usize].map(|v| scene.positions[v as usize].as_dvec3());
            let matrix = glam::DMat3::from_cols(b - a, c - a, -direction);
            let [u, v, distance] = (matrix.inverse() * (from - a)).to_array();
            let inside = u > 0.0 && v > 0.0 && u + v < 1.0 && distance > 1e-6;
            inside.then_some(ManifoldVertex { position: DVec3::ZERO, triangle, barycentrics: [u, v] })
        })
    };
    let (mut tried, mut exact, mut same) = (0, 0, 0);
    while tried < 150 {
        let entry = random_site(&scene, &mut random);
        let (at, normal) = truth(&scene, &entry);
        let eye = (normal * 2.0 + vector(&mut random)).normalize() * random.next_between(1.5, 5.0) as f64;
        let incoming = (at - eye).normalize();
        if incoming.dot(normal) > -0.5 {
            continue;
        }
        let inner = bent(incoming, normal, 1.0 / 1.5);
        let Some(exit) = leave(at, inner) else { continue };
        let (out_at, out_normal) = truth(&scene, &exit);
        let outgoing = bent(inner, -out_normal, 1.5);
        let point = out_at + outgoing * random.next_between(0.05, 0.4) as f64;
        tried += 1;
        let mut near = |site: &ManifoldVertex| {
            let step = DVec2::new(random.next_between(-0.1, 0.1) as f64, random.next_between(-0.1, 0.1) as f64);
            (bounce(0, BounceKind::Transmit), surfaces.moved(0, site, step).unwrap())
        };
        let start = PathSites::new(&[near(&entry), near(&exit)]).unwrap();
        let Some(found) = solve(&surfaces, &Eye::Point(eye), point, &start, 40, 1e-12) else { continue };
        if !found.converged {
            continue;
        }
        let [first, second, ..] = found.sites.sites.map(|site| if site.triangle == u32::MAX { entry } else { site });
        let ((at_one, normal_one), (at_two, normal_two)) = (truth(&scene, &first), truth(&scene, &second));
        let inner = bent((at_one - eye).normalize(), normal_one, 1.0 / 1.5);
        assert!(distance_of_ray(at_one, inner, at_two) < 1e-9);
        assert!(distance_of_ray(at_two, bent(inner, -normal_two, 1.5), point) < 1e-9);
        exact += 1;
        same += u32::from(at_one.distance(at) < 1e-7);
    }
    // Near the ball's caustic a point has several paths, all of them true.
    assert!(exact as f64 > 0.98 * tried as f64 && same as f64 > 0.9 * tried as f64, "{same}, {exact} of {tried}");
}

#[test]
fn a_flat_mesh_is_an_exact_plane_mirror() {
    let scene = mesh_scene(&flat_grid(10), mirror());
    let surfaces = SpecularSurfaces::new(&scene);
    let mut random = Stream::new(79);
    let mut beyond = 0;
    for _ in 0..500 {
        let [mut eye, mut point] = [0, 1].map(|_| vector(&mut random) * 3.0);
        (eye.y, point.y) = (eye.y.abs() + 0.1, point.y.abs() + 0.1);
        let image = point * DVec3::new(1.0, -1.0, 1.0);
        let wanted = eye + (image - eye) * (eye.y / (eye.y - image.y));
        let start = PathSites::new(&[(bounce(0, BounceKind::Reflect), random_site(&scene, &mut random))]).unwrap();
        let found = solve(&surfaces, &Eye::Point(eye), point, &start, 40, 1e-13).unwrap();
        assert!(found.converged && found.sites.sites[0].position.distance(wanted) < 1e-11, "{found:?} {wanted}");
        let is_on_grid = wanted.x.abs() < 1.0 && wanted.z.abs() < 1.0;
        assert_eq!(surfaces.is_within(0, &found.sites.sites[0]), is_on_grid);
        beyond += u32::from(!is_on_grid);
    }
    assert!((50..450).contains(&beyond), "{beyond}");
}

#[test]
fn reflections_go_on_beyond_the_rim_of_a_bowl() {
    // The lower half of a sphere, seen from above; points whose reflection lies a little above the rim.
    let bowl = |u: f32, v: f32| {
        let direction = Vec3::new((u - 0.5) * 1.6, -1.0, (v - 0.5) * 1.6).normalize();
        (direction, direction)
    };
    let scene = mesh_scene(&grid(20, bowl), mirror());
    let surfaces = SpecularSurfaces::new(&scene);
    let mut beyond = 0;
    for step in 0..36 {
        // The rim is at 0.8, and a cell is 0.08 wide: sites go on for two of them.
        let slope = 0.6 + 0.01 * step as f64;
        let at = DVec3::new(slope, -1.0, 0.05).normalize();
        let eye = DVec3::new(0.1, 0.2, 0.0);
        let incoming = (at - eye).normalize();
        let point = at + (incoming - at * (2.0 * incoming.dot(at))) * 0.4;
        let middle = ManifoldVertex { position: DVec3::ZERO, triangle: 2 * (20 * 10 + 15), barycentrics: [0.3, 0.3] };
        let start = PathSites::new(&[(bounce(0, BounceKind::Reflect), middle)]).unwrap();
        let found = solve(&surfaces, &Eye::Point(eye), point, &start, 40, 1e-12).unwrap();
        assert!(found.converged, "{slope}: {found:?}");
        let (position, _) = truth(&scene, &found.sites.sites[0]);
        assert!(position.distance(at) < 0.02, "{slope}: {position} for {at}");
        let is_within = surfaces.is_within(0, &found.sites.sites[0]);
        assert!(is_within == (slope < 0.8) || (slope - 0.8).abs() < 0.015, "{slope}");
        beyond += u32::from(!is_within);
    }
    assert!(beyond > 12, "{beyond}");
}
