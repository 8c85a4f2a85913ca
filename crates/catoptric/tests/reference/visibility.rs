//! Rasteriser and ray tracer show the same surfaces.

use catoptric::framebuffer::Framebuffer;
use catoptric::methods::Quality;
use catoptric::metrics::Comparison;
use catoptric::progress::Silent;
use catoptric::raster::{SceneShader, draw, scene_draw_list};
use catoptric::scene::{Role, Scene, View};
use catoptric_scenes::builtin;
use catoptric_testkit::drawing::{picture, scene};
use catoptric_testkit::scenes::sphere_in_room;

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
