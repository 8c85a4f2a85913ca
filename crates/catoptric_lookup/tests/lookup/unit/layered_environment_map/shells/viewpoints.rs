//! Viewpoints about a group.

use catoptric_lookup::layered_environment_map::{LayeredEnvironmentMapSettings, Viewpoints};
use catoptric_lookup::parts::{LensGroup, Viewspace};
use catoptric_scenes::builtin;
use glam::Vec3;

fn viewspace(viewpoints: Viewpoints) -> Viewspace {
    let scene = builtin::parse("sphere_room").unwrap().pose(&Default::default()).unwrap();
    let settings = LayeredEnvironmentMapSettings { viewpoints, viewpoint_count: 12, ..Default::default() };
    Viewspace::new(&settings, &scene, &LensGroup::all(&scene)[0])
}

#[test]
fn an_eye_at_a_viewpoint_is_that_one_and_between_two_it_is_both() {
    for kind in [Viewpoints::Circle, Viewpoints::Line, Viewpoints::Grid] {
        let viewspace = viewspace(kind);
        for number in 0..viewspace.count() {
            let shares = viewspace.around(viewspace.eye(number, 0.0));
            let most = shares.iter().max_by(|a, b| a.1.total_cmp(&b.1)).unwrap();
            assert!(most.0 == number && most.1 > 0.999, "{kind:?} {number}: {shares:?}");
            if (number + 1) % viewspace.columns != 0 {
                let shares = viewspace.around(viewspace.eye(number, 0.25));
                let share = |number: u32| shares.iter().filter(|(n, _)| *n == number).map(|(_, s)| s).sum::<f32>();
                assert!((share(number) - 0.75).abs() < 0.01, "{kind:?} {number}: {shares:?}");
                assert!((share(number + 1) - 0.25).abs() < 0.01, "{kind:?} {number}: {shares:?}");
            }
        }
        let sum: f32 = viewspace.around(Vec3::new(3.0, 80.0, -7.0)).iter().map(|(_, share)| share).sum();
        assert!((sum - 1.0).abs() < 1e-5);
    }
}

#[test]
fn the_scenes_camera_is_on_the_circle() {
    let scene = builtin::parse("sphere_room").unwrap().pose(&Default::default()).unwrap();
    let eye = scene.default_view(4, 3).eye();
    assert!(viewspace(Viewpoints::Circle).eye(0, 0.0).distance(eye) < 1e-4);
    let grid = viewspace(Viewpoints::Grid);
    assert_eq!(grid.count(), 36);
    assert!((0..36).any(|number| grid.eye(number, 0.0).distance(eye) < 1e-3));
}
