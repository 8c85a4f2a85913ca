//! Errors of the normals of facets.

use catoptric_projection::parts::{ReflectorMesh, interpolated, normal_errors};
use glam::Vec2;

fn mesh(name: &str) -> ReflectorMesh {
    let scene =
        catoptric_scenes::builtin::parse(name).expect("a built-in scene").pose(&Default::default()).expect("a scene");
    ReflectorMesh::new(&scene, scene.specular_objects()[0], 0.125)
}

#[test]
fn planes_and_spheres_have_none_and_others_less_the_finer_they_are() {
    for name in ["planar_mirror", "sphere_room?tess=40"] {
        let errors = normal_errors(mesh(name).shape());
        assert!(errors.iter().all(|error| *error < 2e-3), "{name}: {errors:?}");
    }
    let worst = |name: &str| normal_errors(mesh(name).shape()).into_iter().fold(0.0, f32::max);
    let (coarse, fine) = (worst("vase?surface=mesh&tess=20"), worst("vase?surface=mesh&tess=80"));
    assert!(coarse > 4.0 * fine && fine > 0.0, "{coarse}, {fine}");
}

#[test]
fn normals_of_an_ellipsoid_are_off_by_no_more() {
    let scene = catoptric_scenes::builtin::parse("ellipsoid").unwrap().pose(&Default::default()).unwrap();
    let index = scene.specular_objects()[0];
    let mesh = ReflectorMesh::new(&scene, index, 0.125);
    let surface = scene.objects[index as usize].surface.as_ref().expect("a formula");
    let (mut within, mut count) = (0, 0);
    for (triangle, error) in mesh.triangles.iter().zip(normal_errors(mesh.shape())) {
        for weights in [Vec2::splat(1.0 / 3.0), Vec2::new(0.5, 0.0), Vec2::new(0.0, 0.5)] {
            let place = interpolated(&mesh.positions, *triangle, weights);
            let normal = interpolated(&mesh.normals, *triangle, weights).normalize();
            let gradient = surface.taylor2(place.as_dvec3()).gradient.as_vec3().normalize();
            let off = normal.distance(gradient).min(normal.distance(-gradient));
            assert!(off <= 2.0 * error + 1e-4, "{off} radians, told {error}");
            within += u32::from(off <= error + 1e-5);
            count += 1;
        }
    }
    assert!(within * 100 >= count * 95, "{within} of {count}");
}
