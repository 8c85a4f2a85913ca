//! Appearances of dense points, interpolated in cubes.

use catoptric_core::progress::{Silent, Stage};
use catoptric_projection::parts::work::SharedWork;
use catoptric_projection::parts::{AroundEye, MOST_NODES, Sighting, SightingField, Sightings, SteadyField};
use glam::{Mat3, Vec3};
use std::sync::Arc;
use std::sync::atomic::{AtomicU64, Ordering};

const NODES: [Vec3; MOST_NODES] =
    [Vec3::ZERO, Vec3::new(0.3, 0.0, 0.0), Vec3::new(0.3, 0.3, 0.0), Vec3::new(0.3, 0.3, 0.3)];

/// Sightings that depend on the point's place by terms of higher order, but beyond a plane, where nothing appears.
fn look(point: Vec3) -> Arc<[Sightings]> {
    if point.x > 2.0 {
        return Arc::from([]);
    }
    let at = NODES.map(|node| {
        let first = 0.1 * point + 0.05 * node + Vec3::new(0.02 * point.y * point.y, 0.0, 0.001 * point.x.powi(3));
        let column = |x: f32, y: f32, z: f32| Vec3::new(x, y, z);
        Some(Sighting {
            first,
            change: Mat3::from_cols(
                column(0.1, 0.0, 0.003 * point.x * point.x),
                column(0.04 * point.y, 0.1, 0.0),
                column(0.0, 0.0, 0.1),
            ),
            change_with_eye: Some(Mat3::IDENTITY * 0.05),
            normal: Vec3::Y,
            length: 1.5 * (first.distance(node) + first.distance(point)),
            last_segment: first.distance(point),
            error: 0.0,
        })
    });
    Arc::from([Sightings { focal_index: 2, at, is_rough: false }])
}

fn points(count: usize) -> Vec<Vec3> {
    let on = |axis: usize, number: usize| (number * [7, 11, 13][axis] % 101) as f32 / 101.0;
    (0..count).map(|k| Vec3::new(1.2 + on(0, k) * 1.2, 0.8 + on(1, k), on(2, k) * 0.3)).collect()
}

fn field(known: &AroundEye, points: &[Vec3], size: f32, asked: &AtomicU64) -> Option<SightingField> {
    let stage = Stage::begin(&Silent, "", 1).expect("nothing is cancelled");
    let counted = |point| {
        asked.fetch_add(1, Ordering::Relaxed);
        look(point)
    };
    let work = SharedWork::new(u64::MAX);
    SightingField::new((known, 0), (NODES, Vec3::ZERO, size), points, counted, (&work, &stage))
        .expect("nothing is cancelled")
}

#[test]
fn dense_points_are_where_they_are_to_be() {
    let (known, asked) = (AroundEye::default(), AtomicU64::new(0));
    let points = points(4000);
    let dense = field(&known, &points, 1.0, &asked).expect("there are many points");
    let first_asked = asked.load(Ordering::Relaxed);
    assert!(first_asked < points.len() as u64 / 2, "{first_asked}");
    let mut told = 0;
    for &point in &points {
        let Some(found) = dense.sightings(point) else { continue };
        told += 1;
        let [expected] = &*look(point) else { panic!("{point} appears nowhere") };
        assert_eq!(found.focal_index, 2);
        for (found, expected) in found.at.iter().zip(expected.at.iter().flatten()) {
            assert!(found.first.distance(expected.first) < found.error + 1e-6, "{point}");
            assert!((found.length - expected.length).abs() < 1e-4, "{point}");
            let off =
                (found.change - expected.change).to_cols_array().into_iter().fold(0.0, |a: f32, b| a.max(b.abs()));
            assert!(off < 2e-3, "{point}: {off}");
        }
    }
    let seen = points.iter().filter(|point| point.x <= 2.0).count();
    assert!(told > seen * 3 / 4 && told <= seen, "{told} of {seen}");
    // Known cubes are not searched again.
    field(&known, &points, 1.0, &asked).expect("as before");
    assert_eq!(asked.load(Ordering::Relaxed), first_asked);
    // The same errors are too large in a small mirror: smaller cubes are needed there.
    let small = field(&AroundEye::default(), &points, 0.02, &asked).expect("there are many points");
    assert!(asked.load(Ordering::Relaxed) > 2 * first_asked && small.cube_count() > dense.cube_count());
}

#[test]
fn few_points_are_no_field() {
    let asked = AtomicU64::new(0);
    assert!(field(&AroundEye::default(), &points(20), 1.0, &asked).is_none());
    let odd = [Vec3::ZERO, Vec3::NAN, Vec3::splat(f32::INFINITY), Vec3::splat(f32::MAX)];
    let odd: Vec<Vec3> = odd.into_iter().cycle().take(100).collect();
    assert!(field(&AroundEye::default(), &odd, 1.0, &asked).is_none());
    assert_eq!(asked.load(Ordering::Relaxed), 0);
}
