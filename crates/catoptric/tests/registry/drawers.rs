//! Counts of what has drawn the pixels of reflectors: the method, tiles or rays; and paths that no frame tries again.

use catoptric::light::path_tracer::specular_mask;
use catoptric::methods::overlay::OverlayKind;
use catoptric::methods::{self, Quality, Report};
use catoptric::progress::Silent;
use catoptric::scene::{Scene, View};
use catoptric_testkit::drawing::{draw, picture, scene, session};
use glam::Affine3A;
use std::sync::Arc;

const WITH_MESHES: [&str; 4] = ["path_perturbation", "sample_based_camera", "explosion_map", "reflector_search"];

/// All pixels of reflectors, and those drawn by the method, tiles and rays.
fn counted(report: &Report) -> [u64; 4] {
    ["", "_by_method", "_by_tiles", "_by_rays"].map(|by| report.counts[format!("reflector_pixels{by}").as_str()])
}

#[test]
fn every_pixel_of_a_reflector_is_drawn_by_one_of_three() {
    let mut by_both = 0;
    for name in ["vase", "glass_sphere", "two_spheres", "brushed"] {
        let scene = scene(&format!("{name}?tess=12"));
        let view = scene.default_view(80, 60);
        // By rays through the middles of pixels, where the only sample of one is.
        let seen = specular_mask(&scene, &view).into_iter().filter(|shows| *shows).count();
        for id in WITH_MESHES.iter().copied().chain(["auto", "multiperspective", "planar_mirror"]) {
            // Enough work for some paths of one scene: that is slow.
            let (work, samples_of_all) = if name == "two_spheres" { (4.0, &[1, 4][..]) } else { (0.5, &[1][..]) };
            for &samples in samples_of_all {
                let settings = if WITH_MESHES.contains(&id) { format!("work = {work:.1}") } else { String::new() };
                let report = draw(id, &settings, &scene, &view, Quality { samples, order: 2 }).report;
                let [all, method, tiles, rays] = counted(&report);
                let what = format!("{id} {name}, {samples} samples: {all} of {seen}, {method} {tiles} {rays}");
                assert_eq!(all, method + tiles + rays, "{what}");
                let off = all as f64 / seen as f64;
                assert!(if samples == 1 { (0.99..1.01).contains(&off) } else { (1.0..1.4).contains(&off) }, "{what}");
                let draws_all = !report.fallbacks.contains_key("paths_drawn_by_tiles") && WITH_MESHES.contains(&id);
                assert!(!draws_all || method == all, "{what}");
                by_both += u32::from(method > 0 && tiles > 0);
            }
        }
    }
    assert!(by_both >= 2, "{by_both} pictures are drawn by methods and tiles");
}

/// The overlay of tiles says of every pixel of a single sample how its first bounce is drawn.
#[test]
fn tiles_and_rays_are_counted_as_their_overlay_shows_them() {
    for (id, name) in [("multiperspective", "sphere_room?tess=16"), ("auto", "two_spheres?tess=16")] {
        let scene = Arc::new(scene(name));
        let (view, quality) = (scene.default_view(96, 72), Quality { samples: 1, order: 1 });
        let method = methods::create(id, &Default::default()).expect("default settings");
        let mut prepared = method.prepare(&scene, quality, None, &Silent).expect("a scene");
        let frame = prepared.frame(&view, &Silent).expect("a view");
        let overlay = frame.overlay(OverlayKind::Tiles, &Silent).expect("a view").expect("it has tiles");
        let traced = overlay.groups.iter().position(|group| group.contains("traced")).expect("a way") as u16 + 1;
        let shown = |is_traced: bool| {
            overlay.pixels.iter().filter(|group| **group != 0 && (**group == traced) == is_traced).count() as u64
        };
        let [_, method, tiles, rays] = counted(&draw(id, "", &scene, &view, quality).report);
        assert!(tiles > 100 && rays > 10, "{id}: {tiles} {rays}");
        assert_eq!([method, tiles, rays], [0, shown(false), shown(true)], "{id}");
    }
}

#[test]
fn overlays_of_paths_name_those_that_tiles_draw() {
    let scene = Arc::new(scene("two_spheres?tess=12"));
    let view = scene.default_view(80, 60);
    let groups = |settings: &str| {
        let table = toml::from_str(settings).expect("lines of TOML");
        let method = methods::create("explosion_map", &table).expect("settings");
        let mut prepared = method.prepare(&scene, QUALITY, None, &Silent).expect("a scene");
        let frame = prepared.frame(&view, &Silent).expect("a view");
        frame.overlay(OverlayKind::Paths, &Silent).expect("a view").expect("all have it").groups
    };
    let (own, tiles) = (groups(""), groups("work = 0.0"));
    assert!(own.len() == 2 && own.iter().all(|name| !name.contains("tiles")), "{own:?}");
    assert_eq!(tiles, own.iter().map(|name| format!("{name}, by tiles")).collect::<Vec<_>>());
}

/// A pot whose paths take too much work, and its view, turned by an angle about it.
fn pot() -> (Scene, impl Fn(f32) -> View) {
    let scene = scene("teapot?tess=8");
    let specular = scene.specular_objects().into_iter().map(|object| scene.objects[object as usize].bounds);
    let middle = specular.reduce(|all, one| all.union(one)).expect("there is a pot").center();
    let view = scene.default_view(48, 36);
    let turned = move |degrees: f32| {
        let turn = Affine3A::from_rotation_y(degrees.to_radians());
        let about = Affine3A::from_translation(middle) * turn * Affine3A::from_translation(-middle);
        View { world_from_view: about * view.world_from_view, ..view.clone() }
    };
    (scene, turned)
}

const QUALITY: Quality = Quality { samples: 1, order: 1 };

/// Work, points, and paths that are not tried.
fn tried(report: &Report) -> [u64; 3] {
    ["work", "vertices_projected", "paths_not_tried_again"].map(|name| report.counts[name])
}

#[test]
fn paths_that_take_too_much_work_are_not_tried_in_every_frame() {
    let (scene, view) = pot();
    for id in WITH_MESHES {
        let mut session = session(id, "work = 0.005", &scene, QUALITY);
        let first = session.draw(&view(0.0)).expect("a view").report;
        let [all, method, tiles, rays] = counted(&first);
        assert!(all > 100 && method == 0 && tiles + rays == all && first.counts["paths"] == 0, "{id}: {first:?}");
        // Cameras know before meshes are begun.
        assert!(tried(&first)[0] > 0 || id == "sample_based_camera", "{id}: {first:?}");
        // The same view once more costs nothing, and is the same.
        let again = session.draw(&view(0.0)).expect("a view").report;
        assert_eq!((again.counts["work"], tried(&again)[1]), (first.counts["work"], 0), "{id}");
        // Paths that were not tried yet, as others took all work, come next.
        (1..3).for_each(|frame| drop(session.draw(&view(frame as f32)).expect("a view")));
        for frame in 3..8 {
            let drawn = session.draw(&view(frame as f32)).expect("a view");
            let left = drawn.report.fallbacks["paths_drawn_by_tiles"];
            assert_eq!(tried(&drawn.report), [0, 0, left], "{id}, frame {frame}");
            if frame == 3 {
                let tiles = picture("multiperspective", "", &scene, &view(3.0), QUALITY);
                assert!(drawn.picture.pixels == tiles.pixels, "{id}");
            }
        }
        // Something has moved: that alone is no reason before it is time.
        session.update(&scene).expect("the same scene");
        assert_eq!(tried(&session.draw(&view(7.0)).expect("a view").report)[0], 0, "{id}");
    }
}

/// Frames in which paths are tried, of so many, from views that turn by an angle from one to the next.
fn frames_with_tries(count: u32, degrees: f32) -> Vec<u32> {
    let (scene, view) = pot();
    let mut session = session("reflector_search", "work = 0.5", &scene, QUALITY);
    let mut is_tried = |frame: &u32| {
        let drawn = session.draw(&view(*frame as f32 * degrees)).expect("a view");
        tried(&drawn.report)[0] > 0
    };
    (0..count).filter(|frame| is_tried(frame)).collect()
}

#[test]
fn paths_are_tried_again_from_elsewhere_but_less_and_less_often() {
    // A quarter of the way around: far enough each time.
    let far = frames_with_tries(30, 90.0);
    let later: Vec<u32> = far.iter().copied().filter(|frame| *frame > 3).collect();
    assert!(!later.is_empty() && later.len() <= 6, "{far:?}");
    assert!(later.iter().all(|frame| *frame >= 9), "{far:?}");
    // Views that are alike give no reason.
    let near = frames_with_tries(30, 0.1);
    assert!(near.iter().all(|frame| *frame <= 3), "{near:?}");
    assert_eq!(far, frames_with_tries(30, 90.0), "the same frames, the same tries");
}
