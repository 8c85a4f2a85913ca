//! Rasteriser and ray tracer show the same surfaces.

use catoptric::framebuffer::Framebuffer;
use catoptric::light::path_tracer::specular_mask;
use catoptric::methods::Quality;
use catoptric::metrics::Comparison;
use catoptric::progress::Silent;
use catoptric::raster::{DrawList, SceneShader, draw, scene_draw_list};
use catoptric::scene::{Environment, Role, Scene, View};
use catoptric::tone::Display;
use catoptric_scenes::builtin;
use catoptric_testkit::drawing::{picture, scene};
use catoptric_testkit::scenes::{SceneBuilder, sphere_in_room};
use glam::Vec3;
use std::sync::Arc;

/// The share of pixels (sRGB channel off by more than 0.1) where the two disagree, everything being diffuse.
fn disagreement(mut scene: Scene, view: &View, samples: u32) -> f64 {
    for material in &mut scene.materials {
        material.role = Role::Diffuse;
    }
    let mut drawn = Framebuffer::new(view.width, view.height);
    let list = scene_draw_list(&scene, view, |_| Some(0));
    draw(view, samples, &[list], &SceneShader::new(&scene, view), &mut drawn, &Silent)
        .expect("the test's input is valid");
    let traced = picture("reference", "", &scene, view, Quality { samples, order: 0 });
    Comparison::new(&drawn, &traced)
        .expect("the test's input is valid")
        .whole()
        .expect("the test's input is valid")
        .over_0_1
}

#[test]
fn built_in_scenes_look_alike_drawn_and_traced() {
    for info in builtin::all() {
        let scene = scene(info.name);
        let view = scene.default_view(480, 320);
        let share = disagreement(scene, &view, 1);
        assert!(share <= 5e-4, "{}: {share}", info.name);
    }
}

#[test]
fn antialiased_edges_and_exact_surfaces_look_alike_too() {
    for analytic in [false, true] {
        let scene = sphere_in_room(analytic);
        let view = scene.default_view(300, 200);
        // Up to eight samples, pixels at edges are shaded sample by sample; sixteen are shaded together and differ
        // more.
        for samples in [2, 4, 8] {
            let share = disagreement(scene.clone(), &view, samples);
            assert!(share <= 5e-4, "{analytic} {samples}: {share}");
        }
    }
}

/// A screen shows no more than white: samples are limited before they are averaged, by the rasteriser and by the
/// tracer, whatever the number of samples.
#[test]
fn edges_before_a_bright_sky_are_smooth_on_a_screen() {
    let mut builder = SceneBuilder::new();
    let black = builder.flat("black", Vec3::ZERO);
    builder.quad("leaf", Vec3::ZERO, Vec3::new(2.0, 0.3, 0.1), Vec3::new(0.4, 1.8, -0.2), black);
    builder.camera(Vec3::new(1.2, 1.0, 4.0), Vec3::new(1.2, 1.0, 0.0), 40.0);
    let mut scene = builder.build();
    scene.environment = Some(Arc::new(Environment::new("sky", 4, 2, vec![[100.0; 3]; 8])));
    let view = scene.default_view(120, 120);
    let smooth = |method: &str, samples: u32| {
        let drawn = picture(method, "", &scene, &view, Quality { samples, order: 1 });
        let shown = Display::default().of(&drawn);
        let is_between = |pixel: &&[f32; 4]| pixel[0] > 0.05 && pixel[0] < 0.95;
        (shown.pixels.iter().filter(is_between).count(), shown)
    };
    for (method, samples) in [("auto", 4), ("reference", 4), ("reference", 64)] {
        let (count, shown) = smooth(method, samples);
        assert!(count > 100, "{method}: {count} pixels of edges are smooth");
        // The tracer's pattern of four samples is the rasteriser's.
        if samples == 4 && method == "reference" {
            let drawn = smooth("auto", samples).1;
            let differ = |(a, b): &(&[f32; 4], &[f32; 4])| (a[0] - b[0]).abs() > 1e-3;
            let count = shown.pixels.iter().zip(&drawn.pixels).filter(differ).count();
            // Samples next to an edge may lie on either side of it, as above.
            assert!(count as f64 <= 5e-4 * drawn.pixels.len() as f64, "{count} pixels differ");
        }
    }
}

#[test]
fn smooth_meshes_of_scenes_are_shaded_once_a_pixel_and_look_as_they_are() {
    let scene = scene("colonnade?tess=24");
    let view = scene.view(&scene.camera(None, 1.0).expect("the test's input is valid"), 240, 135);
    let list = scene_draw_list(&scene, &view, |_| Some(0));
    let shown = |list: DrawList| {
        let mut target = Framebuffer::new(view.width, view.height);
        let report = draw(&view, 8, &[list], &SceneShader::new(&scene, &view), &mut target, &Silent)
            .expect("the test's input is valid");
        (report.fragments, target)
    };
    let mut in_parts = list.clone();
    in_parts.triangles.iter_mut().for_each(|triangle| triangle.patch = 0);
    let (alone, plain) = shown(in_parts);
    let (together, merged) = shown(list);
    let pixels = u64::from(view.width * view.height);
    assert!(together < alone - pixels / 10, "{together} fragments, {alone} without parts");
    let quality = Quality { samples: 8, order: 1 };
    let truth = picture("reference", "", &scene, &view, quality);
    let is_specular = specular_mask(&scene, &view);
    // The root of the mean square over all that neither reflects nor refracts.
    let error = |picture: &Framebuffer| {
        let pairs =
            picture.pixels.iter().zip(&truth.pixels).zip(&is_specular).filter(|(_, is_specular)| !**is_specular);
        let squares =
            pairs.map(|((a, b), _)| (0..3).map(|channel| f64::from(a[channel] - b[channel]).powi(2)).sum::<f64>());
        (squares.sum::<f64>() / pixels as f64).sqrt()
    };
    let (plain, merged) = (error(&plain), error(&merged));
    assert!(merged < plain + 1e-3, "{merged} against {plain} without parts");
}
