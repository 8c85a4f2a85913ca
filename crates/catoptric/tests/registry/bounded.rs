//! Frames and preparations end, whatever is asked of them: their work is limited, and what is left out is counted.

use catoptric::framebuffer::Framebuffer;
use catoptric::methods::{self, Quality};
use catoptric::scene::{Material, Scene};
use catoptric_testkit::Drawn;
use catoptric_testkit::drawing::{draw, picture, reflector_error, scene};
use catoptric_testkit::scenes::SceneBuilder;
use glam::Vec3;

/// More than the limit of a frame of a small picture that the scene fills: the last piece of work may pass it.
const WORK_OF_A_FRAME: u64 = 20_000_000;

/// The default settings at the program's default order, on a pot that shows itself and whose spout shows the pot.
fn pot(id: &str, threads: usize) -> Drawn {
    let scene = scene("teapot?tess=8");
    let view = scene.default_view(48, 36);
    let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build().expect("there are threads");
    pool.install(|| draw(id, "", &scene, &view, Quality { samples: 1, order: 2 }))
}

#[test]
fn frames_of_projection_methods_stop_at_their_limit_of_work() {
    let mut limited = 0;
    for id in ["path_perturbation", "sample_based_camera", "explosion_map", "reflector_search"] {
        let report = pot(id, 2).report;
        assert!(report.counts["work"] < WORK_OF_A_FRAME, "{id}: {report:?}");
        limited += u32::from(report.fallbacks.contains_key("paths_drawn_by_tiles"));
    }
    assert!(limited >= 2, "the scene does not show what happens at the limit");
}

/// Without any work methods draw what `multiperspective` does, to the bit; with some of it the paths that they end, and
/// tiles the others: mirrors in mirrors, and glass, at which both paths have to go on in the same way.
#[test]
fn what_is_not_done_within_the_limit_is_drawn_by_tiles() {
    let quality = Quality { samples: 4, order: 2 };
    let mut mixed = 0;
    for name in ["teapot", "glass_sphere", "two_spheres"] {
        let scene = scene(&format!("{name}?tess=16"));
        let view = scene.default_view(96, 72);
        let truth = picture("reference", "", &scene, &view, quality);
        let error = |picture: &Framebuffer| reflector_error(picture, &truth, &scene, &view).over_0_1;
        let tiles = picture("multiperspective", "", &scene, &view, quality);
        for id in ["path_perturbation", "sample_based_camera", "explosion_map", "reflector_search"] {
            let info = methods::all().iter().find(|info| info.id == id).expect("it is a method");
            let limits = info.limits.scenes.iter().find(|limits| limits.scene == name).expect("all scenes have limits");
            // A method has its own errors on the paths that it draws itself.
            let allowed = error(&tiles).max(limits.orders[1].over_0_1) + 0.005;
            for work in [0, 4, 12] {
                let Drawn { picture, report, .. } = draw(id, &format!("work = {work}.0"), &scene, &view, quality);
                let by_tiles = report.fallbacks.get("paths_drawn_by_tiles").copied().unwrap_or(0);
                let what = format!("{id} {name}, work {work}: {by_tiles} paths by tiles, {}", error(&picture));
                if work == 0 {
                    assert!(by_tiles > 0 && picture.pixels == tiles.pixels, "{what}");
                }
                mixed += u32::from(by_tiles > 0 && report.counts["paths"] > 0);
                assert!(error(&picture) < allowed, "{what}, tiles alone {}", error(&tiles));
            }
        }
    }
    assert!(mixed > 4, "{mixed} pictures show paths of both kinds");
}

#[test]
fn what_is_left_out_does_not_depend_on_the_number_of_threads() {
    let [one, two] = [1, 2].map(|threads| pot("sample_based_camera", threads));
    assert_eq!(one.report.counts, two.report.counts);
    assert_eq!(one.report.fallbacks, two.report.fallbacks);
    assert_eq!(one.picture.pixels, two.picture.pixels);
}

/// Forty mirror balls in a room.
fn balls() -> Scene {
    let mut builder = SceneBuilder::new();
    let chrome = builder.material(Material::mirror("chrome", Vec3::ONE));
    let white = builder.flat("white", Vec3::ONE);
    builder.cuboid("room", Vec3::splat(-6.0), Vec3::splat(6.0), true, white);
    for ball in 0..40u8 {
        let center = Vec3::new(f32::from(ball % 8) - 3.5, f32::from(ball / 8) - 2.0, 0.0);
        builder.sphere_mesh(&format!("ball {ball}"), center, 0.3, 6, chrome);
    }
    builder.camera(Vec3::new(0.0, 0.0, 5.5), Vec3::ZERO, 60.0);
    builder.build()
}

#[test]
fn captures_about_many_reflectors_are_smaller_or_shared() {
    let scene = balls();
    let view = scene.default_view(48, 36);
    let setup = |id: &str, settings: &str| draw(id, settings, &scene, &view, Quality { samples: 1, order: 1 }).setup;
    let maps = setup("environment_map", "");
    assert_eq!(maps.fallbacks["smaller_environment_maps"], 40, "{maps:?}");
    // 16 bytes a texel at the finest level; levels above add a third.
    let whole_maps = maps.bytes["environment_maps"] / (6 * 512 * 512 * 16);
    assert!(whole_maps < 20, "{maps:?}");
    let few = setup("environment_map", "size = 64\ncapture_samples = 1");
    assert!(few.fallbacks.is_empty(), "{few:?}");
    let slabs = setup("light_field", "st = 4\nuv = 16");
    assert!(slabs.counts["regions"] <= 4 && slabs.fallbacks["joined_regions"] >= 36, "{slabs:?}");
    let layers = setup("layered_environment_map", "size = 32");
    assert!(layers.counts["lens_groups"] <= 4 && layers.fallbacks["joined_groups"] >= 36, "{layers:?}");
}
