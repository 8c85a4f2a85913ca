//! Motions that are found from moved points.

use catoptric_projection::parts::rigid_motion;
use glam::{DAffine3, DQuat, DVec3, Vec3};

#[test]
fn motions_are_found_again() {
    let points: Vec<Vec3> = (0..50).map(|n| catoptric_core::math::random::spread(n).extend((n % 7) as f32)).collect();
    let turn = DQuat::from_axis_angle(DVec3::new(1.0, 2.0, -0.5).normalize(), 2.1);
    let motion = DAffine3::from_rotation_translation(turn, DVec3::new(3.0, -1.0, 20.0));
    let moved = |motion: &DAffine3| -> Vec<Vec3> {
        points.iter().map(|point| motion.transform_point3(point.as_dvec3()).as_vec3()).collect()
    };
    let found = rigid_motion(&points, &moved(&motion)).unwrap();
    assert!(found.abs_diff_eq(motion, 1e-5), "{found} for {motion}");
    // Scaled, mirrored, and with one point elsewhere.
    assert!(rigid_motion(&points, &moved(&DAffine3::from_scale(DVec3::splat(1.001)))).is_none());
    assert!(rigid_motion(&points, &moved(&DAffine3::from_scale(DVec3::new(1.0, -1.0, 1.0)))).is_none());
    let mut bent = moved(&motion);
    bent[31].x += 1e-3;
    assert!(rigid_motion(&points, &bent).is_none());
    // A line may turn about itself.
    let line: Vec<Vec3> = (0..9).map(|n| Vec3::X * n as f32).collect();
    assert!(rigid_motion(&line, &line).is_none() && rigid_motion(&[], &[]).is_none());
    assert!(rigid_motion(&points, &points[..40]).is_none());
}
