//! Maps of triangle numbers.

use catoptric_core::math::random::Stream;
use catoptric_engine::raster::id_map::IdMap;
use glam::Vec2;

#[test]
fn every_centre_of_a_triangulated_square_has_a_triangle_that_holds_it() {
    let mut random = Stream::new(5);
    let (width, height) = (37, 23);
    // A fan about a point within: its triangles cover the map, inner edges twice.
    let centre = Vec2::new(13.3, 9.1);
    let size = Vec2::new(width as f32, height as f32);
    let rim: Vec<Vec2> = (0..40)
        .map(|k| Vec2::from_angle(std::f32::consts::TAU * (k as f32 + random.next_unit() * 0.5) / 40.0) * 60.0 + centre)
        .collect();
    let triangles: Vec<[Vec2; 3]> = (0..rim.len()).map(|k| [centre, rim[k], rim[(k + 1) % rim.len()]]).collect();
    let mut map = IdMap::new(width, height);
    for (id, corners) in triangles.iter().enumerate() {
        assert!(map.draw(id as u32, *corners));
    }
    for y in 0..height {
        for x in 0..width {
            let place = Vec2::new(x as f32 + 0.5, y as f32 + 0.5);
            // The distance of the place within a triangle's edges, in texels.
            let within = |id: u32| {
                let [a, b, c] = triangles[id as usize];
                let from_edge = |p: Vec2, q: Vec2| (q - p).normalize().perp_dot(place - p);
                from_edge(a, b).min(from_edge(b, c)).min(from_edge(c, a))
            };
            let found: Vec<u32> = map.at(place).collect();
            assert_eq!(found.first().copied(), Some(map.first_in((y * width + x) as usize)), "{place}");
            assert!(found.iter().all(|id| within(*id) > -1e-3 && *id >= found[0]), "{place}: {found:?}");
            let wanted: Vec<u32> = (0..triangles.len() as u32).filter(|id| within(*id) > 0.0).collect();
            assert!(wanted.iter().all(|id| found.contains(id)), "{place}: {found:?}, not {wanted:?}");
        }
    }
    for outside in [-Vec2::X, -Vec2::Y, Vec2::X * 1e9, size, Vec2::NAN, Vec2::splat(f32::NEG_INFINITY)] {
        assert!(map.at(outside).next().is_none());
    }
}

#[test]
fn triangles_without_area_and_broken_ones_cover_nothing() {
    let broken = [
        [Vec2::ONE; 3],
        [Vec2::ZERO, Vec2::X * 4.0, Vec2::X * 8.0],
        [Vec2::NAN, Vec2::X, Vec2::Y],
        [Vec2::splat(f32::INFINITY), Vec2::X, Vec2::Y],
        [Vec2::splat(-9.0), Vec2::splat(-3.0), Vec2::new(-9.0, -3.0)],
    ];
    let mut map = IdMap::new(8, 8);
    for corners in broken {
        assert!(!map.draw(0, corners));
    }
    for texel in 0..64 {
        assert_eq!(map.first_in(texel), u32::MAX);
        let centre = Vec2::new((texel % 8) as f32 + 0.5, (texel / 8) as f32 + 0.5);
        assert!(map.at(centre).next().is_none(), "{centre}");
    }
    assert_eq!(map.byte_count(), IdMap::new(8, 8).byte_count());
}
