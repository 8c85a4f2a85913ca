//! Reflectors that are drawn against reflectors that are traced.

use catoptric_core::scene::{Projection, Scene, View};
use catoptric_engine::light::tracer::Tracer;
use catoptric_engine::optics::path::manifold::SpecularSurfaces;
use catoptric_projection::find::ray_map::{RayField, Specular, ViewField};
use catoptric_projection::parts::{PrimaryVisibility, VisibilityRow, polygon};
use catoptric_scenes::builtin;
use glam::{DVec3, Vec3, Vec3A};

/// Draws a view's reflectors and traces every ray too; returns the number of hits, `None` if nothing was drawn.
fn drawn_and_traced(name: &str, scene: &Scene, view: &View) -> Option<usize> {
    let tracer = Tracer::build(scene, |object| scene.role_of(object).is_specular());
    let surfaces = SpecularSurfaces::new(scene);
    let specular = Specular { scene, tracer: &tracer, surfaces: &surfaces, order: 1 };
    let field = ViewField::new(view, 4.0);
    let spacing_px = 2.0;
    let [columns, rows] = field.size_px().map(|size| (size / spacing_px).ceil() as u32);
    let seen = PrimaryVisibility::new(&specular, &field, spacing_px, [columns, rows])?;
    let (mut row, mut count) = (VisibilityRow::default(), 0);
    for number in 0..rows {
        seen.row(number, &mut row);
        let mut found = vec![None; columns as usize];
        for (column, _, meeting) in row.seen() {
            found[column as usize] = Some(*meeting);
        }
        for (column, found) in found.into_iter().enumerate() {
            let at = [column as f32, number as f32].map(|place| (place + 0.5) * spacing_px);
            let (ray, near) = field.ray(at[0], at[1]);
            let traced = tracer.first_meeting(scene, &ray, near);
            count += usize::from(traced.is_some());
            if found == traced {
                continue;
            }
            // Both triangles are right on an edge; the tracer's distances are in single precision.
            let (origin, direction) = (ray.origin.as_dvec3(), ray.direction.as_dvec3().normalize());
            let arrivals = [found, traced].map(|meeting| surfaces.arrival(origin, direction, &meeting?));
            let [Some(drawn), Some(traced)] = arrivals else { panic!("{name} {at:?}: {arrivals:?}") };
            let apart = drawn.position.distance(traced.position);
            assert!(apart < 1e-6 * f64::from(scene.bounds.diagonal()), "{name} {at:?}: {apart}, {arrivals:?}");
        }
    }
    Some(count)
}

#[test]
fn drawing_finds_what_tracing_finds() {
    let names = ["sphere_room?tess=24", "sphere_room?surface=analytic", "vase", "vase?surface=mesh&tess=24"];
    let more = ["teapot?tess=16", "planar_mirror?mirrors=4", "two_spheres?tess=24", "car?tess=12", "torus"];
    for name in names.into_iter().chain(more) {
        let scene = builtin::parse(name).unwrap().pose(&Default::default()).unwrap();
        let view = scene.default_view(160, 120);
        let met = drawn_and_traced(name, &scene, &view);
        assert!(met.is_some_and(|met| met > 200), "{name}: {met:?}");
        // The eye comes nearer and nearer, and is inside at last, with reflectors around and behind.
        let target = scene.objects[scene.specular_objects()[0] as usize].bounds.center();
        for share in [0.5, 0.8, 0.97, 1.05] {
            let mut near = view.clone();
            near.world_from_view.translation = Vec3A::from(view.eye().lerp(target, share));
            drawn_and_traced(name, &scene, &near);
            near.near = 0.3 * view.eye().distance(target);
            drawn_and_traced(name, &scene, &near);
        }
        let mut parallel = view.clone();
        parallel.projection = Projection::Orthographic { half_height: 0.3 * scene.bounds.diagonal() };
        let met = drawn_and_traced(name, &scene, &parallel);
        assert!(met.is_some_and(|met| met > 0), "{name}: {met:?}");
    }
}

#[test]
fn polygons_behind_the_eye_are_cut() {
    // A picture plane at distance 1 before an eye that looks along z.
    let place = |point: DVec3| (point.z > 0.0).then(|| [point.x / point.z, point.y / point.z]);
    let polygon = |corners: [Vec3; 3]| polygon(corners.map(|corner| place(corner.as_dvec3())), corners, &place);
    let (a, b, c) = (Vec3::new(0.0, 0.0, 1.0), Vec3::new(1.0, 0.0, 1.0), Vec3::new(1.0, 1.0, -1.0));
    assert_eq!(polygon([c, c - Vec3::X, c - Vec3::Y]), None);
    let both = polygon([a, b, c]).unwrap();
    assert_eq!(both[..2], [[0.0, 0.0], [1.0, 0.0]]);
    assert!(both[2][1] > 1e6 && both[3][1] > 1e6);
    let one = polygon([c - Vec3::X, a, c]).unwrap();
    assert!(one.iter().flatten().filter(|place| **place > 1e6).count() >= 3, "{one:?}");
}
