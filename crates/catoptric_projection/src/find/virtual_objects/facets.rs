//! Error of a reflector's triangles against its surface.

use super::mesh::ReflectorMesh;
use super::piece::{interpolated, weights_of};
use catoptric_core::parallel;

/// The interpolated normals of a triangle are off by about this share of what they are off where they are led on to the
/// corner of a neighbour: an eighth for parabolas, and as much again for their slopes at the triangle's border.
const SHARE: f32 = 0.25;

/// For every triangle, the largest angle by which the normals that are interpolated in it may be from those of the
/// surface, in radians.
///
/// Told by how far its normals, led on, miss those of its neighbours: the second difference. Spheres, whose normals are
/// linear in the place, have none.
pub(super) fn normal_errors(mesh: &ReflectorMesh) -> Vec<f32> {
    parallel::map_collect(mesh.triangles.len(), |index| {
        let triangle = mesh.triangles[index];
        let corners = triangle.map(|vertex| mesh.positions[vertex as usize]);
        let missed = |neighbour: &u32| {
            let beside = mesh.triangles.get(*neighbour as usize)?;
            let apart = *beside.iter().find(|vertex| !triangle.contains(vertex))? as usize;
            let led_on = interpolated(&mesh.normals, triangle, weights_of(corners, mesh.positions[apart]));
            Some(led_on.try_normalize()?.distance(mesh.normals[apart]))
        };
        // Without slopes, as at the end of a strip of triangles without an area, nothing is known to be off.
        SHARE * mesh.neighbours[index].iter().filter_map(missed).fold(0.0, f32::max)
    })
}

#[cfg(test)]
mod tests {
    use super::*;
    use glam::Vec2;

    fn mesh(name: &str) -> ReflectorMesh {
        let scene = catoptric_scenes::builtin::parse(name).unwrap().pose(&Default::default()).unwrap();
        ReflectorMesh::new(&scene, scene.specular_objects()[0], 0.125)
    }

    #[test]
    fn planes_and_spheres_have_none_and_others_less_the_finer_they_are() {
        for name in ["planar_mirror", "sphere_room?tess=40"] {
            let errors = normal_errors(&mesh(name));
            assert!(errors.iter().all(|error| *error < 2e-3), "{name}: {errors:?}");
        }
        let worst = |name: &str| normal_errors(&mesh(name)).into_iter().fold(0.0, f32::max);
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
        for (triangle, error) in mesh.triangles.iter().zip(normal_errors(&mesh)) {
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
}
