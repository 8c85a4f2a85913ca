//! Input that is huge, degenerate or not a number; odd pictures; threads.

use super::*;
use catoptric_core::math::random::Stream;
use catoptric_core::progress::Silent;
use catoptric_engine::error::RenderError;
use catoptric_engine::raster::{Branch, SAMPLE_COUNTS, Stencil};

#[test]
fn broken_triangles_are_skipped_without_harm() {
    let good = rectangle(Vec2::ZERO, Vec2::splat(40.0), 5.0);
    let broken = [f32::NAN, f32::INFINITY, f32::NEG_INFINITY].into_iter().flat_map(|bad| {
        let [a, b, c] = good[0];
        [
            [PicturePoint { w: bad, ..a }, b, c],
            [a, PicturePoint { depth: bad, ..b }, c],
            [a, b, PicturePoint { xy: Vec2::new(bad, 1.0), ..c }],
        ]
    });
    let [a, b, _] = good[0];
    let degenerate = [[a, a, a], [a, b, a], [a, b, at(20.0, 0.0, 5.0)], [PicturePoint::default(); 3]];
    let mut lists = list(broken.chain(degenerate));
    let count = lists.triangles.len() as u32;
    lists.triangles.push(DrawTriangle { vertices: [0, 1, u32::MAX], ..DrawTriangle::default() });
    for samples in SAMPLE_COUNTS {
        let drawn = picture(&view(40, 40, true), samples, &[lists.clone(), list(good)], |fragment| {
            assert!(fragment.chain.iter().all(|surface| surface.barycentrics.value.is_finite()));
            Vec3::splat(fragment.chain.first().map_or(9.0, |surface| surface.list as f32))
        });
        assert!(drawn.pixels.iter().all(|pixel| pixel[0] == 1.0), "{count} broken triangles left a trace");
    }
}

#[test]
fn random_bits_do_no_harm() {
    let mut random = Stream::new(21);
    for round in 0..40 {
        let mut number = || {
            let bits = (random.next_unit() * 65536.0) as u32;
            let value = f32::from_bits(bits << 16 | bits);
            if bits.is_multiple_of(3) { value } else { (bits % 100) as f32 - 20.0 }
        };
        let triangles: Vec<[PicturePoint; 3]> = (0..200)
            .map(|_| {
                std::array::from_fn(|_| PicturePoint {
                    xy: Vec2::new(number(), number()),
                    w: number(),
                    depth: number(),
                })
            })
            .collect();
        let view = View { near: number(), ..view(37, 35, round % 2 == 0) };
        let samples = SAMPLE_COUNTS[round % 5];
        let drawn = picture(&view, samples, &[list(triangles)], |fragment| {
            for surface in fragment.chain {
                let at = surface.barycentrics;
                assert!(at.value.is_finite() && at.dx.is_finite() && at.dy.is_finite());
                assert!(at.value.min_element() >= 0.0 && at.value.x + at.value.y <= 1.0 + 1e-6);
            }
            coverage(fragment)
        });
        assert!(drawn.pixels.iter().all(|pixel| (0.0..=1.0).contains(&pixel[0]) && pixel[3] == 1.0));
    }
}

#[test]
fn huge_triangles_cover_the_picture() {
    for size in [1e3f32, 1e5, 1e8, 1e15, 1e30] {
        let (a, b, c) = (at(-size, -size, 2.0), at(3.0 * size, -size, 2.0), at(-size, 3.0 * size, 2.0));
        for (width, height) in [(1, 1), (7, 100), (129, 65)] {
            let drawn = picture(&view(width, height, true), 4, &[list([[a, b, c]])], coverage);
            assert!(drawn.pixels.iter().all(|pixel| pixel[0] == 1.0), "{size}, {width} x {height}");
        }
    }
    // A floor from behind the eye to the horizon: all below the middle row, nothing above.
    let view = view(64, 64, true);
    let transform = view.picture_from_world();
    let [a, b, c, d] =
        [(-1e6, 1e6), (1e6, 1e6), (1e6, -1e6), (-1e6, -1e6)].map(|(x, z)| transform.apply(Vec3::new(x, -1.0, z)));
    let drawn = picture(&view, 1, &[list([[a, b, c], [a, c, d]])], coverage);
    for (index, pixel) in drawn.pixels.iter().enumerate() {
        // The lowest rows show the floor at the distance 1.7, beyond the near plane.
        assert_eq!(pixel[0], f32::from(index >= 32 * 64), "pixel {index}");
    }
}

#[test]
fn pictures_of_any_size_are_drawn() {
    for (width, height) in [(0, 0), (0, 5), (1, 1), (1, 70), (33, 31), (64, 32), (65, 97)] {
        for samples in SAMPLE_COUNTS {
            let view = view(width, height, false);
            let half = rectangle(Vec2::new(-9.0, -9.0), Vec2::new(width as f32, height as f32 * 0.5), 1.0)
                .map(|triangle| triangle.map(|p| PicturePoint { w: 1.0, xy: p.xy / p.w, depth: 3.0 }));
            let drawn = picture(&view, samples, &[list(half)], coverage);
            let sum: f32 = drawn.pixels.iter().map(|pixel| pixel[0]).sum();
            if samples == 4 || height % 2 == 0 {
                assert_eq!(sum, width as f32 * height as f32 * 0.5, "{width} x {height}, {samples} samples");
            }
        }
    }
}

#[test]
fn limits_are_errors() {
    let draw_into = |view: &View, samples: u32, mut target: Framebuffer| {
        draw(view, samples, &[], &Paint(coverage), &mut target, &Silent).map(|_| ())
    };
    let small = view(4, 4, true);
    assert!(draw_into(&small, 1, Framebuffer::new(4, 4)).is_ok());
    assert!(matches!(draw_into(&small, 3, Framebuffer::new(4, 4)), Err(RenderError::Samples { samples: 3 })));
    assert!(matches!(draw_into(&small, 1, Framebuffer::new(4, 5)), Err(RenderError::Limit { .. })));
    let wide = view(16_385, 1, true);
    assert!(matches!(draw_into(&wide, 1, Framebuffer::new(16_385, 1)), Err(RenderError::Limit { .. })));
    let widest = view(16_384, 2, true);
    let all = list(rectangle(Vec2::ZERO, Vec2::new(16_384.0, 2.0), 2.0));
    let drawn = picture(&widest, 2, &[all], coverage);
    assert!(drawn.pixels.iter().all(|pixel| pixel[0] == 1.0));
}

#[cfg(feature = "parallel")]
#[test]
fn threads_do_not_change_the_picture() {
    let mut random = Stream::new(22);
    let mut triangles = || -> Vec<[PicturePoint; 3]> {
        let corner = |random: &mut Stream| {
            at(random.next_between(-50.0, 250.0), random.next_between(-50.0, 200.0), random.next_between(0.3, 3.0))
        };
        (0..3000).map(|_| [corner(&mut random), corner(&mut random), corner(&mut random)]).collect()
    };
    // Every second triangle is drawn twice: ties.
    let mut first = list(triangles().into_iter().flat_map(|t| [t, t]));
    for (index, triangle) in first.triangles.iter_mut().enumerate() {
        triangle.group = index as u32 % 3;
        triangle.alpha_tested = index % 7 == 0;
    }
    let stencil = Stencil { list: 0, group: 1, ..Stencil::default() };
    let second = DrawList { layer: 1, stencil: Some(stencil), ..list(triangles()) };
    let third =
        DrawList { layer: 1, stencil: Some(Stencil { branch: Branch::Second, ..stencil }), ..list(triangles()) };
    let lists = [first, second, third];
    let view = view(200, 150, true);
    let with = |threads: usize| {
        let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build().unwrap();
        pool.install(|| {
            picture(&view, 8, &lists, |fragment| {
                let sum =
                    |f: &dyn Fn(&catoptric_engine::raster::LayerSurface) -> f32| fragment.chain.iter().map(f).sum();
                Vec3::new(sum(&|s| s.source as f32), sum(&|s| s.barycentrics.value.x), sum(&|s| s.barycentrics.dx.y))
            })
        })
    };
    let expected = with(1);
    for threads in [2, 5] {
        let same =
            with(threads).pixels.iter().zip(&expected.pixels).all(|(a, b)| a.map(f32::to_bits) == b.map(f32::to_bits));
        assert!(same, "{threads} threads");
    }
}
