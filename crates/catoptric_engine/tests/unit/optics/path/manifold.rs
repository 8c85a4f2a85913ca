//! Surfaces of specular paths: frames against differences, steps over meshes, patches of a sphere and a torus.

use catoptric_core::math::random::Stream;
use catoptric_core::scene::{Material, Object, Ray, Scene};
use catoptric_core::surface::{AnalyticSurface, PlacedSurface, SurfaceMesh, sphere_mesh};
use catoptric_engine::light::tracer::Tracer;
use catoptric_engine::optics::path::manifold::{ManifoldVertex, NO_TRIANGLE, SpecularSurfaces};
use glam::{Affine3A, DVec2, DVec3, Quat, Vec3};

/// A scene of one mesh.
pub(crate) fn mesh_scene(mesh: &SurfaceMesh, material: Material) -> Scene {
    let mut scene = Scene {
        positions: mesh.positions.clone(),
        normals: mesh.normals.clone(),
        uvs: vec![Default::default(); mesh.positions.len()],
        triangles: mesh.triangles.clone(),
        triangle_objects: vec![0; mesh.triangles.len()],
        materials: vec![material],
        ..Scene::default()
    };
    let bounds = catoptric_core::math::Aabb { min: Vec3::splat(-9.0), max: Vec3::splat(9.0) };
    scene.objects.push(Object {
        name: String::new(),
        material: 0,
        triangles: 0..mesh.triangles.len() as u32,
        vertices: 0..mesh.positions.len() as u32,
        surface: None,
        inside: false,
        bounds,
    });
    scene.bounds = bounds;
    scene
}

/// A grid of `cells` x `cells` quads over the unit square, laid out by a map of its points.
pub(crate) fn grid(cells: u32, place: impl Fn(f32, f32) -> (Vec3, Vec3)) -> SurfaceMesh {
    let mut mesh = SurfaceMesh::default();
    for row in 0..=cells {
        for column in 0..=cells {
            let (position, normal) = place(column as f32 / cells as f32, row as f32 / cells as f32);
            mesh.positions.push(position);
            mesh.normals.push(normal);
        }
    }
    let index = |row: u32, column: u32| row * (cells + 1) + column;
    for row in 0..cells {
        for column in 0..cells {
            let [a, b, c, d] =
                [index(row, column), index(row, column + 1), index(row + 1, column + 1), index(row + 1, column)];
            mesh.triangles.extend([[a, c, b], [a, d, c]]);
        }
    }
    mesh
}

/// A plane at y = 0 of sides 2 about the origin, with its outer side up.
pub(crate) fn flat_grid(cells: u32) -> SurfaceMesh {
    grid(cells, |u, v| (Vec3::new(2.0 * u - 1.0, 0.0, 2.0 * v - 1.0), Vec3::Y))
}

pub(crate) fn mirror() -> Material {
    Material::mirror("mirror", Vec3::ONE)
}

fn centroid_site(scene: &Scene, triangle: u32) -> ManifoldVertex {
    let sum: DVec3 = scene.triangles[triangle as usize].iter().map(|&v| scene.positions[v as usize].as_dvec3()).sum();
    ManifoldVertex { position: sum / 3.0, triangle, barycentrics: [1.0 / 3.0; 2] }
}

fn ball(place: Affine3A, radius: f32) -> Scene {
    let mut scene = mesh_scene(&SurfaceMesh::default(), mirror());
    let placed = PlacedSurface {
        surface: AnalyticSurface::Sphere { radius: radius.into() },
        world_from_surface: place.as_daffine3(),
    };
    scene.objects[0].surface = Some(placed);
    scene
}

#[test]
fn frames_are_the_derivatives_of_motion() {
    let exact = ball(Affine3A::from_rotation_translation(Quat::from_rotation_y(0.5), Vec3::new(1.0, 2.0, 3.0)), 1.5);
    let mesh = mesh_scene(&sphere_mesh(1.5, 12, 24), mirror());
    let mut random = Stream::new(3);
    for scene in [&exact, &mesh] {
        let surfaces = SpecularSurfaces::new(scene);
        for _ in 0..200 {
            let site = if scene.triangles.is_empty() {
                let mut next = || random.next_between(-1.0, 1.0) as f64;
                let direction = DVec3::new(next(), next(), next());
                ManifoldVertex::on_surface(DVec3::new(1.0, 2.0, 3.0) + direction.normalize() * 1.5)
            } else {
                centroid_site(scene, (random.next_unit() * scene.triangles.len() as f32) as u32)
            };
            let frame = surfaces.frame(0, &site).unwrap();
            let [t0, t1] = frame.tangents;
            assert!(t0.dot(t1).abs() < 1e-14 && (t0.length() - 1.0).abs() < 1e-14);
            assert!(frame.geometric_normal().dot(frame.normal) > 0.9);
            let step = 1e-5;
            for (axis, turn) in [DVec2::X, DVec2::Y].into_iter().zip(frame.normal_change) {
                let at = |sign: f64| {
                    let moved = surfaces.moved(0, &site, axis * (sign * step)).unwrap();
                    surfaces.frame(0, &moved).unwrap()
                };
                let (ahead, behind) = (at(1.0), at(-1.0));
                let moved = (ahead.position - behind.position) / (2.0 * step);
                let turned = (ahead.normal - behind.normal) / (2.0 * step);
                assert!((moved - (t0 * axis.x + t1 * axis.y)).length() < 1e-8);
                assert!((turned - turn).length() < 1e-8, "{turned} against {turn}");
            }
        }
    }
}

#[test]
fn steps_stay_on_a_sphere_and_far_ones_are_refused() {
    let scene = ball(Affine3A::from_translation(Vec3::X), 2.0);
    let surfaces = SpecularSurfaces::new(&scene);
    let site = ManifoldVertex::on_surface(DVec3::new(1.0, 2.0, 0.0));
    for length in [1e-9, 1e-4, 0.1, 0.9, 1.9] {
        let moved = surfaces.moved(0, &site, DVec2::new(length, 0.3 * length)).unwrap();
        assert!(((moved.position - DVec3::X).length() - 2.0).abs() < 1e-14);
        let arc = 2.0 * (site.position - DVec3::X).angle_between(moved.position - DVec3::X);
        let wanted = length * 1.09f64.sqrt();
        assert!((arc - wanted).abs() <= 0.2 * wanted.powi(3) + 1e-7, "{arc} for {wanted}");
        assert!(surfaces.is_within(0, &moved));
    }
    assert!(surfaces.moved(0, &site, DVec2::splat(1e6)).is_none());
    assert!(surfaces.moved(0, &site, DVec2::splat(f64::NAN)).is_none());
    assert!(surfaces.frame(0, &ManifoldVertex::on_surface(DVec3::X)).is_none(), "the centre has no normal");
}

#[test]
fn hits_become_sites_in_double_precision() {
    let place = Affine3A::from_translation(Vec3::new(0.1, 0.2, 0.3));
    let mesh = mesh_scene(&sphere_mesh(1.0, 20, 40), mirror());
    let tracer = Tracer::build(&mesh, |_| true);
    let exact = ball(place, 1.0);
    let exact_tracer = Tracer::build(&exact, |_| true);
    let mut random = Stream::new(11);
    for (scene, tracer) in [(&mesh, &tracer), (&exact, &exact_tracer)] {
        let surfaces = SpecularSurfaces::new(scene);
        let mut met = 0;
        for _ in 0..500 {
            let mut next = || random.next_between(-0.9, 0.9);
            let origin = Vec3::new(next(), next(), 4.0);
            let ray = Ray { origin, direction: (Vec3::new(next(), next(), 0.0) - origin).normalize() };
            let Some(hit) = tracer.first_hit(scene, &ray, 0.0) else { continue };
            let (object, site) = surfaces.site_of(&ray, &hit).unwrap();
            let frame = surfaces.frame(object, &site).unwrap();
            let direction = ray.direction.as_dvec3().normalize();
            if frame.geometric_normal().dot(direction) > -0.05 {
                continue;
            }
            met += 1;
            let relative = site.position - origin.as_dvec3();
            assert!((relative - direction * relative.dot(direction)).length() < 1e-13, "beside the ray");
            assert!((relative.length() - hit.distance() as f64).abs() < 1e-5);
            assert!(surfaces.is_within(object, &site));
            if scene.triangles.is_empty() {
                let center = Vec3::from(place.translation).as_dvec3();
                assert!((site.position.distance(center) - 1.0).abs() < 1e-14, "beside the surface");
            } else {
                let [a, b, c] = scene.triangles[site.triangle as usize].map(|v| scene.positions[v as usize].as_dvec3());
                assert!((site.position - a).dot((b - a).cross(c - a).normalize()).abs() < 1e-14, "beside the triangle");
            }
        }
        assert!(met > 300, "{met}");
    }
}

#[test]
fn walks_over_a_flat_mesh_are_straight_and_go_on_beyond_its_border() {
    let scene = mesh_scene(&flat_grid(16), mirror());
    let surfaces = SpecularSurfaces::new(&scene);
    let mut random = Stream::new(21);
    let mut site = centroid_site(&scene, 100);
    let (mut inside, mut beyond, mut back) = (0, 0, 0);
    for _ in 0..3000 {
        let frame = surfaces.frame(0, &site).unwrap();
        assert!(frame.normal == DVec3::Y && frame.normal_change == [DVec3::ZERO; 2]);
        // Pulled to the middle, so that it does not wander away for good.
        let pull = DVec2::new(-frame.tangents[0].dot(site.position), -frame.tangents[1].dot(site.position));
        let step =
            DVec2::new(random.next_between(-1.5, 1.5) as f64, random.next_between(-1.5, 1.5) as f64) + pull * 0.3;
        let wanted = site.position + frame.tangents[0] * step.x + frame.tangents[1] * step.y;
        let was_within = surfaces.is_within(0, &site);
        site = surfaces.moved(0, &site, step).unwrap();
        assert!(site.position.distance(wanted) < 1e-13, "{} for {wanted}", site.position);
        let is_on_grid = wanted.x.abs() < 1.0 && wanted.z.abs() < 1.0;
        assert_eq!(surfaces.is_within(0, &site), is_on_grid, "at {wanted}");
        inside += u32::from(is_on_grid);
        beyond += u32::from(!is_on_grid);
        back += u32::from(is_on_grid && !was_within);
    }
    assert!(inside > 800 && beyond > 500 && back > 200, "{inside} {beyond} {back}");
}

#[test]
fn a_step_over_a_rounded_edge_is_a_straight_line_on_the_unfolded_sheet() {
    // Two half planes that meet at 120 degrees; one normal at the edge, so light is reflected as by a smooth surface.
    let fold = |u: f32, v: f32| {
        let (x, z) = (2.0 * u - 1.0, 2.0 * v - 1.0);
        let down = x.max(0.0);
        let position = Vec3::new(x.min(0.0) + 0.5 * down, -0.75f32.sqrt() * down, z);
        let normal = if x < -1e-3 {
            Vec3::Y
        } else if x > 1e-3 {
            Vec3::new(0.75f32.sqrt(), 0.5, 0.0)
        } else {
            Vec3::new(0.5, 0.75f32.sqrt(), 0.0)
        };
        (position, normal)
    };
    let scene = mesh_scene(&grid(8, fold), mirror());
    let surfaces = SpecularSurfaces::new(&scene);
    let start = centroid_site(&scene, 2 * (8 * 3 + 2));
    let frame = surfaces.frame(0, &start).unwrap();
    for (dx, dz) in [(1.0, 0.0), (0.9, 0.5), (0.7, -0.4), (0.3, 0.3)] {
        let step = DVec3::new(dx, 0.0, dz);
        let moved = surfaces.moved(0, &start, DVec2::new(frame.tangents[0].dot(step), frame.tangents[1].dot(step)));
        let (moved, flat) = (moved.unwrap().position, start.position + step);
        let down = flat.x.max(0.0);
        let wanted = DVec3::new(flat.x.min(0.0) + 0.5 * down, -0.75f64.sqrt() * down, flat.z);
        assert!(moved.distance(wanted) < 1e-6, "{moved} for {wanted}");
    }
}

#[test]
fn creases_are_borders() {
    // The same fold with a normal for each half: two vertices at each point of the edge.
    let mut mesh = grid(1, |u, v| (Vec3::new(u - 1.0, 0.0, v), Vec3::Y));
    let other = grid(1, |u, v| (Vec3::new(0.0, -u, v), Vec3::X));
    let shift = mesh.positions.len() as u32;
    mesh.positions.extend(other.positions);
    mesh.normals.extend(other.normals);
    mesh.triangles.extend(other.triangles.iter().map(|t| t.map(|v| v + shift)));
    let scene = mesh_scene(&mesh, mirror());
    let surfaces = SpecularSurfaces::new(&scene);
    let start = centroid_site(&scene, 0);
    let frame = surfaces.frame(0, &start).unwrap();
    let step = DVec3::X * 3.0;
    let moved =
        surfaces.moved(0, &start, DVec2::new(frame.tangents[0].dot(step), frame.tangents[1].dot(step))).unwrap();
    assert!(moved.position.distance(start.position + step) < 1e-14 && !surfaces.is_within(0, &moved));
}

#[test]
fn curved_borders_go_on_a_little() {
    // A quarter of a cylinder; beyond its end normals are extrapolated, but not for ever.
    let curved = |u: f32, v: f32| {
        let normal = Vec3::new((u * 1.5).sin(), (u * 1.5).cos(), 0.0);
        (normal + Vec3::Z * v, normal)
    };
    let scene = mesh_scene(&grid(12, curved), mirror());
    let surfaces = SpecularSurfaces::new(&scene);
    let start = centroid_site(&scene, 2 * (12 * 6 + 11));
    let frame = surfaces.frame(0, &start).unwrap();
    let end = DVec3::new(1.5f64.sin(), 1.5f64.cos(), 0.0);
    let step = (end - start.position * DVec3::new(1.0, 1.0, 0.0)).normalize();
    let along = |length: f64| {
        let step = step * length;
        surfaces.moved(0, &start, DVec2::new(frame.tangents[0].dot(step), frame.tangents[1].dot(step)))
    };
    let beyond = along(0.2).unwrap();
    assert!(!surfaces.is_within(0, &beyond) && beyond.position.y < end.y);
    let angle = |site: &ManifoldVertex| {
        let normal = surfaces.frame(0, site).unwrap().normal;
        normal.x.atan2(normal.y)
    };
    assert!(angle(&beyond) > 1.52 && angle(&along(0.25).unwrap()) > angle(&beyond));
    assert!(along(2.0).is_none());
}

/// A torus about the y axis with tube radius 1; its exact normals.
fn torus(cells: u32, ring: f32) -> SurfaceMesh {
    grid(cells, |u, v| {
        let ((sin, cos), (up, out)) = ((u * std::f32::consts::TAU).sin_cos(), (v * std::f32::consts::TAU).sin_cos());
        let normal = Vec3::new(out * cos, up, out * sin);
        (Vec3::new(cos, 0.0, sin) * ring + normal, normal)
    })
}

/// The largest errors of a torus mesh's patches: of the curvatures, and of normals at a distance of a tenth.
fn torus_errors(cells: u32) -> [f64; 2] {
    let ring = 3.0;
    let scene = mesh_scene(&torus(cells, ring), mirror());
    let surfaces = SpecularSurfaces::new(&scene);
    let mut errors = [0f64; 2];
    for triangle in (0..scene.triangles.len() as u32).step_by(scene.triangles.len() / 300) {
        // At the meeting of the grid's borders rounding leaves the mesh open: one-sided fits are less accurate.
        let (row, column) = (triangle / 2 / cells, triangle / 2 % cells);
        if !(1..cells - 1).contains(&row) || !(1..cells - 1).contains(&column) {
            continue;
        }
        let site = centroid_site(&scene, triangle);
        let patch = surfaces.patch(0, &site).expect("the surface has a patch");
        let core = |p: DVec3| DVec3::new(p.x, 0.0, p.z).normalize() * ring as f64;
        let normal_at = |p: DVec3| (p - core(p)).normalize();
        let radial = DVec3::new(site.position.x, 0.0, site.position.z).normalize();
        let around = DVec3::Y.cross(radial);
        let normal = normal_at(site.position);
        let curvatures = [1.0, normal.dot(radial) / (ring as f64 + normal.dot(radial))];
        let directions = [normal.cross(around), around];
        for (direction, curvature) in directions.into_iter().zip(curvatures) {
            let [x, y] = patch.tangents.map(|tangent| tangent.dot(direction));
            let turn = patch.normal_change[0] * x + patch.normal_change[1] * y;
            errors[0] = errors[0].max((turn - direction * curvature).length());
        }
        for [x, y] in [[0.1, 0.0], [0.0, 0.1], [-0.07, 0.07], [-0.07, -0.07]] {
            let at = patch.position_at([x, y]);
            let [uu, uv, vv] = patch.normal_bend;
            let bent = uu * (0.5 * x * x) + uv * (x * y) + vv * (0.5 * y * y);
            let found = patch.normal + patch.normal_change[0] * x + patch.normal_change[1] * y + bent;
            errors[1] = errors[1].max(found.distance(normal_at(at)));
        }
    }
    errors
}

#[test]
fn patches_of_a_torus_mesh_approach_the_torus() {
    let (coarse, fine) = (torus_errors(64), torus_errors(128));
    assert!(fine[0] < 2e-3 && fine[1] < 1.5e-3, "{coarse:?} {fine:?}");
    // Accurate to second order in the size of the triangles.
    assert!(coarse[0] / fine[0] > 3.0 && coarse[1] / fine[1] > 3.0, "{coarse:?} {fine:?}");
}

#[test]
fn patches_of_a_sphere_mesh_approach_the_sphere() {
    let radius = 2.0;
    let scene = mesh_scene(&sphere_mesh(radius as f32, 40, 80), mirror());
    let surfaces = SpecularSurfaces::new(&scene);
    let mut errors = [0f64; 2];
    for triangle in 0..scene.triangles.len() as u32 {
        let patch = surfaces.patch(0, &centroid_site(&scene, triangle)).unwrap();
        for (turn, tangent) in patch.normal_change.iter().zip(patch.tangents) {
            errors[0] = errors[0].max((*turn - tangent / radius).length());
        }
        for (bend, place_bend) in patch.normal_bend.iter().zip(patch.bend) {
            errors[1] = errors[1].max((*bend - place_bend / radius).length());
        }
    }
    assert!(errors[0] < 2e-3 && errors[1] < 0.04 / (radius * radius), "{errors:?}");
}

#[test]
fn broken_meshes_give_values_or_nothing() {
    let mut mesh = sphere_mesh(1.0, 6, 12);
    mesh.triangles.extend([[0, 0, 0], [20, 20, 21], [30, 31, 30]]);
    let at = mesh.positions.len() as u32;
    mesh.positions.extend([Vec3::X * 1e-30, Vec3::Y * 1e-30, Vec3::Z * 1e-30, Vec3::ZERO, Vec3::X, Vec3::Y]);
    mesh.normals.extend([Vec3::X, Vec3::X, Vec3::X, Vec3::ZERO, Vec3::ZERO, Vec3::ZERO]);
    mesh.triangles.extend([[at, at + 1, at + 2], [at + 3, at + 4, at + 5], [at + 3, at + 3, at + 5]]);
    for k in 0..mesh.normals.len() / 5 {
        mesh.normals[5 * k] = [Vec3::ZERO, -mesh.normals[5 * k], Vec3::Y][k % 3];
    }
    let scene = mesh_scene(&mesh, mirror());
    let surfaces = SpecularSurfaces::new(&scene);
    let (mut frames, mut moves) = (0, 0);
    for triangle in (0..mesh.triangles.len() as u32).chain([12345, NO_TRIANGLE]) {
        for barycentrics in [[0.3, 0.3], [0.0, 1.0], [-5.0, 3.0], [f64::NAN, 0.0], [f64::INFINITY, 0.0], [1e200, 1e200]]
        {
            let site = ManifoldVertex { position: DVec3::X, triangle, barycentrics };
            if let Some(frame) = surfaces.frame(0, &site) {
                frames += 1;
                assert!(
                    frame.normal.is_finite() && frame.tangents[1].is_finite() && frame.normal_change[0].is_finite()
                );
            }
            assert!(surfaces.patch(0, &site).is_none_or(|patch| patch.is_finite()));
            for step in [DVec2::ZERO, DVec2::new(0.3, -2.0), DVec2::splat(1e9), DVec2::NAN, DVec2::INFINITY] {
                if let Some(moved) = surfaces.moved(0, &site, step) {
                    moves += 1;
                    assert!(moved.position.is_finite(), "{site:?} {step}");
                }
            }
            surfaces.is_within(0, &site);
        }
    }
    assert!(frames > 300 && moves > 300, "{frames} {moves}");
}
