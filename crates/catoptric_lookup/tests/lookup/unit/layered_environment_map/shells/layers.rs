//! Layers from meetings of rays.

use catoptric_lookup::layered_environment_map::{Clustering, Shells};
use catoptric_lookup::parts::{LayerHit, clusters, strata};
use glam::Vec3;

#[test]
fn distances_fall_into_their_clusters() {
    let distances: Vec<f32> = (0..300).map(|k| [1.0, 5.0, 5.2, 20.0][k % 4] + 0.01 * (k % 7) as f32).collect();
    let found = clusters(&distances, 3);
    assert_eq!(found.len(), 3);
    for (found, expected) in found.iter().zip([1.03, 5.13, 20.03]) {
        assert!((found - expected).abs() < 0.01, "{found}");
    }
    assert_eq!(clusters(&[2.0; 10], 3), [2.0], "there are no more clusters than distances");
    assert!(clusters(&[], 3).is_empty());
}

#[test]
fn things_stay_whole_and_only_the_first_meeting_of_a_ray_counts() {
    // A wall from 4 to 12 away, mostly at 10; a thing at 1; another one behind the first, met by the same rays.
    let mut meetings = Vec::new();
    for ray in 0..100u32 {
        let aside = ray as f32 / 100.0;
        let mut meet = |object, x: f32| meetings.push(LayerHit { ray, object, position: Vec3::new(x, aside, 0.0) });
        meet(7, 1.0);
        meet(8, 1.5);
        meet(3, if ray < 30 { 4.0 } else { 10.0 });
    }
    let found = strata(&meetings, &[(9, 11.0), (5, 0.0)], 2, Shells::Sphere, Clustering::Distance);
    assert_eq!(found.len(), 2);
    assert_eq!((&found[0].objects[..], &found[1].objects[..]), (&[7, 8, 5][..], &[3, 9][..]));
    let radius = found[0].shell.distance(Vec3::ZERO, Vec3::X);
    let mean: f32 = (0..100).map(|ray| Vec3::new(1.0, ray as f32 / 100.0, 0.0).length()).sum::<f32>() / 100.0;
    assert!((radius - mean).abs() < 1e-4, "{radius}: of the first things alone, not {mean}");
}
