//! Barycentric coordinates, their derivatives, and where fragments are shaded.

use super::*;
use catoptric_core::math::random::Stream;
use catoptric_engine::raster::{SAMPLE_COUNTS, barycentrics};
use glam::DVec2;

/// Barycentric coordinates of the second and third corner on the ray through a picture position.
fn exact(view: &View, corners: &[Vec3; 3], x: f64, y: f64) -> DVec2 {
    let half = DVec2::new(view.width as f64, view.height as f64) * 0.5;
    let unit = match view.projection {
        Projection::Perspective { fov_y } => 2.0 * (fov_y as f64 * 0.5).tan() / view.height as f64,
        Projection::Orthographic { half_height } => 2.0 * half_height as f64 / view.height as f64,
    };
    let offset = DVec2::new(x - half.x, half.y - y) * unit;
    let [a, b, c] = corners.map(Vec3::as_dvec3);
    let volumes = match view.projection {
        Projection::Perspective { .. } => {
            let direction = offset.extend(-1.0);
            [direction.dot(b.cross(c)), direction.dot(c.cross(a)), direction.dot(a.cross(b))]
        }
        Projection::Orthographic { .. } => {
            let [a, b, c] = [a, b, c].map(|p| p.truncate() - offset);
            [b.perp_dot(c), c.perp_dot(a), a.perp_dot(b)]
        }
    };
    DVec2::new(volumes[1], volumes[2]) / volumes.iter().sum::<f64>()
}

#[test]
fn barycentrics_and_derivatives_match_rays_and_differences() {
    let mut random = Stream::new(11);
    let mut tested = 0;
    for perspective in [true, false] {
        let view = view(640, 480, perspective);
        let transform = view.picture_from_world();
        for _ in 0..3000 {
            let mut vector = |scale: f32| Vec3::from_array(std::array::from_fn(|_| random.next_between(-scale, scale)));
            // Some reach behind the eye: the coordinates come from the unclipped corners.
            let center = vector(1.0) - Vec3::Z * 2.5;
            let corners = [center + vector(2.0), center + vector(2.0), center + vector(2.0)];
            let weights = [random.next_unit(), random.next_unit()];
            let (b, c) = if weights[0] + weights[1] > 1.0 {
                (1.0 - weights[0], 1.0 - weights[1])
            } else {
                (weights[0], weights[1])
            };
            let inside = corners[0] * (1.0 - b - c) + corners[1] * b + corners[2] * c;
            let Some(position) = view.pixel_of(inside) else { continue };
            let normal = (corners[1] - corners[0]).cross(corners[2] - corners[0]).normalize_or_zero();
            let towards = if perspective { inside.normalize() } else { Vec3::NEG_Z };
            // Edge-on triangles amplify the rounding of the picture points themselves.
            if normal.dot(towards).abs() < 0.05 {
                continue;
            }
            tested += 1;
            let points = corners.map(|corner| transform.apply(corner));
            let found = barycentrics([&points[0], &points[1], &points[2]], position, 0.0);
            let (x, y) = (position.x as f64, position.y as f64);
            let expected = exact(&view, &corners, x, y).as_vec2();
            assert!((found.value - expected).length() < 1e-4, "{} against {expected}", found.value);
            assert!((found.value - Vec2::new(b, c)).length() < 1e-3);
            let step = 1e-3;
            let difference = |dx: f64, dy: f64| {
                let ends = exact(&view, &corners, x + dx, y + dy) - exact(&view, &corners, x - dx, y - dy);
                (ends / (2.0 * step)).as_vec2()
            };
            for (found, expected) in [(found.dx, difference(step, 0.0)), (found.dy, difference(0.0, step))] {
                assert!((found - expected).length() < 1e-6 + 1e-3 * expected.length(), "{found} against {expected}");
            }
        }
    }
    assert!(tested > 3000, "{tested}");
}

#[test]
fn sizes_do_not_matter() {
    // The picture's shape is the same whatever the unit of length; products must not leave the range of numbers.
    let corners = [at(3.0, 4.0, 1.0), at(40.0, 9.0, 2.0), at(11.0, 50.0, 3.0)];
    let position = Vec2::new(13.0, 14.0);
    let expected = barycentrics([&corners[0], &corners[1], &corners[2]], position, 0.0);
    for scale in [1e-30f32, 1e-10, 1e10, 1e30] {
        let scaled = corners.map(|p| PicturePoint { xy: p.xy * scale, w: p.w * scale, depth: p.depth * scale });
        let found = barycentrics([&scaled[0], &scaled[1], &scaled[2]], position, 0.0);
        assert!((found.value - expected.value).length() < 1e-5, "{scale}");
        assert!((found.dx - expected.dx).length() < 1e-6, "{scale}");
    }
}

#[test]
fn fragments_lie_in_their_triangles() {
    // Slivers, tiny and large triangles: coordinates must never leave the triangle, nor fragments their pixel.
    let mut random = Stream::new(12);
    let view = view(61, 47, true);
    for samples in SAMPLE_COUNTS {
        let triangles = (0..300).map(|index| {
            let size = [0.7, 4.0, 40.0][index % 3];
            let (x, y) = (random.next_between(0.0, 61.0), random.next_between(0.0, 47.0));
            std::array::from_fn(|_| {
                let (dx, dy) = (random.next_between(-size, size), random.next_between(-size, size));
                at(x + dx, y + dy * 0.1, random.next_between(1.0, 50.0))
            })
        });
        let list = list(triangles);
        let drawn = picture(&view, samples, std::slice::from_ref(&list), |fragment| {
            let Some(surface) = fragment.chain.first() else { return Vec3::ZERO };
            let at = surface.barycentrics.value;
            assert!(at.min_element() >= 0.0 && at.x + at.y <= 1.0 + 1e-6, "{at}");
            // The point with these coordinates projects to the fragment's position, to the snapping of corners.
            let [a, b, c] = list.triangles[surface.source as usize].vertices.map(|v| list.vertices[v as usize]);
            let mix = |a: f32, b: f32, c: f32| a * (1.0 - at.x - at.y) + b * at.x + c * at.y;
            let w = mix(a.w, b.w, c.w);
            let shown = Vec2::new(mix(a.xy.x, b.xy.x, c.xy.x), mix(a.xy.y, b.xy.y, c.xy.y)) / w;
            let distance = shown - fragment.position;
            // Samples lie in the snapped triangle; back into the given one they may move along a sliver's length.
            let corners = [a, b, c].map(|p| p.xy / p.w);
            let edges = [corners[1] - corners[0], corners[2] - corners[1], corners[0] - corners[2]];
            let longest = edges.iter().map(|edge| edge.length()).fold(0.0, f32::max);
            let height = edges[0].perp_dot(edges[2]).abs() / longest;
            assert!(distance.length() < 0.01 * (1.0 + longest / height), "{distance} in {corners:?}");
            Vec3::ONE
        });
        assert!(drawn.pixels.iter().all(|pixel| pixel.iter().all(|v| (0.0..=1.0).contains(v))));
    }
}

#[test]
fn whole_pixels_are_shaded_at_their_centre_and_parts_at_their_centroid() {
    let half = list(rectangle(Vec2::new(2.5, 0.0), Vec2::new(8.0, 8.0), 1.0));
    let drawn = picture(&view(8, 8, true), 16, &[half], |fragment| {
        if fragment.chain.is_empty() { Vec3::ZERO } else { fragment.position.extend(1.0) }
    });
    assert_eq!(drawn.pixel(5, 3), [5.5, 3.5, 1.0, 1.0]);
    let part = drawn.pixel(2, 3);
    let centroid = Vec2::new(part[0], part[1]) / part[2];
    assert_eq!(part[2], 0.5);
    assert!(centroid.x > 2.5 && centroid.x < 3.0 && (centroid.y - 3.5).abs() < 0.1, "{centroid}");
}
