//! The hierarchy of beams against all samples, one by one, in double precision.

use super::samples::{balls, traced};
use catoptric_core::math::random::Stream;
use catoptric_core::scene::Material;
use catoptric_engine::optics::path::bundle::BounceKind;
use catoptric_projection::find::ray_map::{RayBeams, RaySample, Reaching};
use catoptric_testkit::scenes::random_vector as vector;
use glam::{DMat2, DVec2, DVec3, Vec3};

/// Rays along a side of a map.
const SIDE: usize = 40;

/// A map of rays after a mirror ball, with the derivatives of their pictures with respect to their parameters
/// (stretched and sheared at random), the distances to which each is used, and their places.
fn map(random: &mut Stream, width: f64) -> (Vec<RaySample>, Vec<DMat2>, Vec<f32>, Vec<[f32; 2]>) {
    let scene = balls(&[(Vec3::ZERO, 1.0, Material::mirror("mirror", Vec3::ONE))]);
    let towards = vector(random).normalize();
    let eye = (towards * 3.0).as_vec3().as_dvec3();
    let side = towards.any_orthonormal_vector();
    let up = towards.cross(side);
    let (mut samples, mut pictures, mut reach, mut places) = (Vec::new(), Vec::new(), Vec::new(), Vec::new());
    for place in 0..SIDE * SIDE {
        let [x, y] = [place % SIDE, place / SIDE].map(|k| (k as f64 / (SIDE - 1) as f64 * 2.0 - 1.0) * width);
        let Some(sample) = traced(&scene, eye, side * x + up * y, &[(0, BounceKind::Reflect)]) else { continue };
        samples.push(sample);
        let mut entry = || f64::from(random.next_between(-0.4, 0.4));
        pictures.push(DMat2::IDENTITY + DMat2::from_cols_array(&[entry(), entry(), entry(), entry()]));
        reach.push(random.next_between(0.01, 0.3));
        places.push([(place % SIDE * 8) as f32, (place / SIDE * 8) as f32]);
    }
    (samples, pictures, reach, places)
}

/// A sample's place agrees with its expansion in double precision.
fn leads_there(one: &Reaching, samples: &[RaySample], pictures: &[DMat2], places: &[[f32; 2]], point: Vec3) {
    let index = one.sample as usize;
    let rays = &samples[index].rays;
    let perturbed = rays.perturbed(point.as_dvec3()).expect("what is reached is not at a focus");
    let way = pictures[index] * perturbed.linear;
    let close = |a: f32, b: f64| (f64::from(a) - b).abs() < 1e-4 * (1.0 + b.abs());
    let own = DVec2::new(places[index][0].into(), places[index][1].into());
    let place = one.place.as_dvec2();
    assert!(place.distance(own + way) < 1e-3 && close(one.distance2, way.length_squared()), "{one:?}: {way}");
    let [[a, b], [c, d]] = rays.spread(perturbed.distance);
    let mirrored = (a * d - b * c) * pictures[index].determinant() < 0.0;
    assert_eq!(one.mirrored, mirrored, "{one:?}");
}

#[test]
fn every_sample_that_reaches_a_point_is_found_and_few_others_are() {
    let mut random = Stream::new(99);
    // The widths give all of the ball's disc, silhouette included, and a small part of it.
    for width in [1.1, 0.1] {
        let (samples, pictures, reach, places) = map(&mut random, width);
        let beams = RayBeams::new(&samples, &pictures, &reach, &places, 3.0);
        let (mut expected, mut beyond, mut most) = (0, 0, 0);
        for case in 0..300 {
            // Anywhere, near the ball, and far away in front of a ray.
            let point = match case % 3 {
                0 => vector(&mut random) * 8.0,
                1 => vector(&mut random).normalize() * f64::from(random.next_between(1.0, 1.1)),
                _ => {
                    let sample = &samples[(random.next_unit() * samples.len() as f32) as usize];
                    let distance = f64::from(random.next_between(0.0, 100.0));
                    sample.rays.origin + sample.rays.direction * distance + vector(&mut random) * 0.02
                }
            };
            let point = point.as_vec3();
            let mut reaching = Vec::new();
            beams.reaching(point, &mut reaching);
            for one in &reaching {
                leads_there(one, &samples, &pictures, &places, point);
            }
            let mut found: Vec<u32> = reaching.iter().map(|one| one.sample).collect();
            let count = found.len();
            found.sort_unstable();
            found.dedup();
            assert_eq!(found.len(), count, "a sample is found twice");
            let reaches = |index: usize, leeway: f64| {
                let perturbed = samples[index].rays.perturbed(point.as_dvec3());
                perturbed.is_some_and(|perturbed| {
                    perturbed.distance > 0.0
                        && (pictures[index] * perturbed.linear).length() <= f64::from(reach[index]) * leeway
                })
            };
            for index in 0..samples.len() {
                let is_found = found.binary_search(&(index as u32)).is_ok();
                // Single precision may add a few at the border.
                assert!(is_found || !reaches(index, 0.999), "{point}: sample {index} of {found:?}");
                beyond += u32::from(is_found && !reaches(index, 1.01));
                expected += u32::from(reaches(index, 1.0));
            }
            most = most.max(count);
        }
        assert!(expected > 1000 && most > 10 && beyond * 50 < expected, "{expected} expected, {beyond} beyond");
    }
}

#[test]
fn no_samples_and_no_points_give_nothing() {
    let mut found = Vec::new();
    RayBeams::new(&[], &[], &[], &[], 1.0).reaching(Vec3::ONE, &mut found);
    let (samples, pictures, reach, places) = map(&mut Stream::new(3), 0.5);
    let beams = RayBeams::new(&samples, &pictures, &reach, &places, 3.0);
    for point in [Vec3::NAN, Vec3::INFINITY, Vec3::new(0.0, f32::NAN, 1.0)] {
        beams.reaching(point, &mut found);
    }
    assert!(found.is_empty() && beams.byte_count() > samples.len() * 80);
    // A single sample reaches points on its own ray.
    let one = RayBeams::new(&samples[..1], &pictures[..1], &reach[..1], &places[..1], 3.0);
    let at = |distance: f64| -> DVec3 { samples[0].rays.origin + samples[0].rays.direction * distance };
    one.reaching(at(5.0).as_vec3(), &mut found);
    assert!(found.len() == 1 && found[0].sample == 0 && found[0].distance2 < 1e-6, "{found:?}");
    one.reaching(at(-5.0).as_vec3(), &mut found);
    assert!(found.len() == 1 && found[0].sample == 0 && found[0].distance2 < 1e-6, "{found:?}");
}
