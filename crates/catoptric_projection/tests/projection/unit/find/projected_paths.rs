//! Projections as paths, against the closed form for flat mirrors.

use catoptric_core::math::random::Stream;
use catoptric_core::progress::Silent;
use catoptric_engine::method::Quality;
use catoptric_engine::method::path_query::{FoundPath, PathSearch};
use catoptric_projection::find::projected_paths::ProjectedPaths;
use catoptric_projection::planar_mirror;
use catoptric_scenes::builtin;
use glam::Vec3;
use std::sync::Arc;

#[test]
fn projections_of_flat_mirrors_become_the_paths_of_the_closed_form() {
    let scene = builtin::parse("planar_mirror?mirrors=3").unwrap().pose(&Default::default()).unwrap();
    let scene = Arc::new(scene);
    let view = scene.default_view(640, 480);
    let quality = Quality { samples: 1, order: 2 };
    let objects = scene.specular_objects();
    let method = (planar_mirror::INFO.create)(&Default::default()).unwrap();
    let mut prepared = method.prepare(&scene, quality, None, &Silent).unwrap();
    let frame = prepared.frame(&view, &Silent).unwrap();
    let exact = frame.path_search(view.eye().as_dvec3(), &objects).unwrap().unwrap();
    let projector = frame.projector().unwrap();
    let projected = ProjectedPaths::new(&scene, &view, projector, 2, &objects);
    let mut random = Stream::new(3);
    let (mut truth, mut found) = (Vec::new(), Vec::new());
    let mut compared = 0;
    for _ in 0..300 {
        let size = scene.bounds.max - scene.bounds.min;
        let share = Vec3::from([0; 3].map(|_| random.next_between(0.05, 0.95)));
        let point = (scene.bounds.min + size * share).as_dvec3();
        truth.clear();
        found.clear();
        exact.search(point, &mut truth);
        projected.search(point, &mut found);
        for path in &found {
            // Rays beyond a mirror's border do not meet it and are left out.
            let names = |search: &dyn PathSearch, path: &FoundPath| search.paths()[path.path as usize].clone();
            let same = truth.iter().find(|other| {
                names(exact.as_ref(), other) == names(&projected, path)
                    && other.bounce_points[0].distance(path.bounce_points[0]) < 1e-3
            });
            let Some(same) = same else { panic!("{path:?} is not among {truth:?}") };
            assert!((same.optical_length - path.optical_length).abs() < 1e-4 * same.optical_length);
            assert!(path.residual < 1e-4 && same.residual < 1e-12, "{path:?}");
            for column in 0..3 {
                let change = (same.jacobian.col(column) - path.jacobian.col(column)).length();
                assert!(change < 1e-3, "{} against {}", path.jacobian, same.jacobian);
            }
            compared += 1;
        }
    }
    assert!(compared > 100, "{compared}");
}
