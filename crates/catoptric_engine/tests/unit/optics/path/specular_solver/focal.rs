//! Focal points along solved paths against Coddington's equations.

use super::*;
use catoptric_engine::optics::path::bundle::OutgoingRays;

#[test]
fn focal_points_off_the_axis_obey_coddington() {
    let (radius, center) = (2.0, Vec3::new(0.5, -1.0, 0.25));
    let scene = scene_of(&[sphere(center, radius as f32, mirror())]);
    let surfaces = SpecularSurfaces::new(&scene);
    let mut random = Stream::new(91);
    let (mut concave, mut counts) = (0, [0; 3]);
    for case in 0..1500 {
        let normal = vector(&mut random).normalize();
        let at = center.as_dvec3() + normal * radius;
        // From inside and from outside.
        let side = if case % 3 == 0 { 1.0 } else { -1.0 };
        let eye = at + (normal * side + vector(&mut random)).normalize() * random.next_between(0.2, 3.0) as f64;
        let (incoming, distance) = ((at - eye).normalize(), eye.distance(at));
        let cosine = -incoming.dot(normal) * side;
        if cosine < 0.1 {
            continue;
        }
        let outgoing = incoming - normal * (2.0 * incoming.dot(normal));
        let point = at + outgoing * random.next_between(0.2, 4.0) as f64;
        let start = center.as_dvec3() + (normal + vector(&mut random) * 1e-4).normalize() * radius;
        let start = PathSites::new(&[(bounce(0, BounceKind::Reflect), ManifoldVertex::on_surface(start))]).unwrap();
        let found = solve(&surfaces, &Eye::Point(eye), point, &start, 30, 1e-13);
        let Some(found) = found.filter(|found| found.sites.sites[0].position.distance(at) < 1e-9) else { continue };
        let bundle = bundle_of(&surfaces, &Eye::Point(eye), &found.sites).unwrap();
        let focal = OutgoingRays::new(&bundle).unwrap().focal_distances();
        // 1/s + 1/s' = 2 / (R cos i) in the plane of incidence and 2 cos i / R across it; R < 0 from outside.
        let signed = -side * radius;
        let mut expected: Vec<f64> = [2.0 / (signed * cosine), 2.0 * cosine / signed]
            .iter()
            .map(|power| 1.0 / (power - 1.0 / distance))
            .filter(|distance| *distance > 0.0)
            .collect();
        expected.sort_by(f64::total_cmp);
        let focal: Vec<f64> = focal.into_iter().flatten().collect();
        assert_eq!(focal.len(), expected.len(), "case {case}: {focal:?} for {expected:?}");
        for (found, expected) in focal.iter().zip(&expected) {
            assert!((found / expected - 1.0).abs() < 1e-6 * expected.max(1.0), "case {case}: {found} for {expected}");
        }
        concave += u32::from(side < 0.0);
        counts[focal.len()] += 1;
    }
    assert!(concave > 500 && counts.iter().all(|count| *count > 50), "{concave} {counts:?}");
}
