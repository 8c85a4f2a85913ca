//! Triangles that are parts of one surface.

use super::*;
use catoptric_core::progress::Silent;
use catoptric_engine::raster::RasterReport;
use std::sync::Mutex;

fn with_patch(mut list: DrawList, patch: impl Fn(u32) -> u32) -> DrawList {
    for triangle in &mut list.triangles {
        triangle.patch = patch(triangle.source);
    }
    list
}

/// The report of a call, and the picture of coverage.
fn drawn(list: DrawList, samples: u32) -> (RasterReport, Framebuffer) {
    let view = view(64, 64, true);
    let mut target = Framebuffer::new(view.width, view.height);
    let report = draw(&view, samples, &[list], &Paint(coverage), &mut target, &Silent).expect("the count is supported");
    (report, target)
}

/// Strips a third of a pixel wide that cover the whole picture, on a slanted plane.
fn strips() -> DrawList {
    let depth = |x: f32| 1.0 / (0.2 + 0.002 * x);
    let corner = |x: f32, y: f32| at(x, y, depth(x));
    list((0..192).flat_map(|strip| {
        let (left, right) = (strip as f32 / 3.0, (strip + 1) as f32 / 3.0);
        let [a, b, c, d] = [corner(left, 0.0), corner(right, 0.0), corner(right, 64.0), corner(left, 64.0)];
        [[a, b, c], [a, c, d]]
    }))
}

#[test]
fn parts_of_a_surface_are_shaded_once_a_pixel() {
    for samples in [4, 16] {
        let (alone, plain) = drawn(with_patch(strips(), |_| 0), samples);
        let (together, merged) = drawn(with_patch(strips(), |_| 7), samples);
        assert!(alone.fragments > 2 * 64 * 64, "{} fragments", alone.fragments);
        assert_eq!(together.fragments, 64 * 64);
        let same = plain.pixels.iter().zip(&merged.pixels).all(|(a, b)| (a[0] - b[0]).abs() < 1e-6);
        assert!(same, "{samples} samples: coverage differs");
    }
}

#[test]
fn surfaces_at_different_depths_and_other_patches_stay_apart() {
    // Two rectangles side by side that meet in the middle of a column of pixels.
    let halves = |right: f32| {
        let low = rectangle(Vec2::ZERO, Vec2::new(32.5, 64.0), 2.0);
        list(low.into_iter().chain(rectangle(Vec2::new(32.5, 0.0), Vec2::splat(64.0), right)))
    };
    let fragments = |list: DrawList| drawn(list, 16).0.fragments;
    assert_eq!(fragments(with_patch(halves(2.0), |_| 3)), 64 * 64);
    assert_eq!(fragments(with_patch(halves(2.1), |_| 3)), 65 * 64);
    assert_eq!(fragments(with_patch(halves(2.0), |source| 1 + source / 2)), 65 * 64);
}

#[test]
fn the_part_in_the_middle_is_shaded() {
    // The left part covers a quarter of the pixels of a column, the right one the rest.
    let low = rectangle(Vec2::ZERO, Vec2::new(32.25, 64.0), 2.0);
    let list = list(low.into_iter().chain(rectangle(Vec2::new(32.25, 0.0), Vec2::splat(64.0), 2.0)));
    let sources = Mutex::new(Vec::new());
    picture(&view(64, 64, true), 16, &[with_patch(list, |_| 1)], |fragment| {
        if fragment.position.x == 32.5 {
            sources.lock().unwrap().push(fragment.chain[0].source);
        }
        Vec3::ONE
    });
    let sources = sources.into_inner().unwrap();
    assert!(sources.len() == 64 && sources.iter().all(|source| *source >= 2), "{sources:?}");
}
