//! Layered environment maps against the reference, and against their own parts.

use catoptric::framebuffer::Framebuffer;
use catoptric::methods::{Quality, Report};
use catoptric::scene::{Camera, Scene, View};
use catoptric_testkit::Session;
use catoptric_testkit::baking::{Units, baked};
use catoptric_testkit::drawing::{draw, error, reflector_error, refusal, scene, session};
use glam::{Quat, Vec3};

const ID: &str = "layered_environment_map";
const QUALITY: Quality = Quality { samples: 4, order: 4 };
const SMALL: &str = "size = 64\npicture_size = 128\ncapture_samples = 4\nviewpoint_count = 12";

/// A picture with the method's reports.
fn picture(id: &str, settings: &str, scene: &Scene, view: &View) -> (Framebuffer, Report) {
    let drawn = draw(id, settings, scene, view, QUALITY);
    (drawn.picture, drawn.report)
}

/// FLIP over reflectors and lenses, against the same model fully traced.
fn flip(settings: &str, scene: &Scene, view: &View) -> f64 {
    let (truth, _) = picture("reference", "paths = 'two_path'", scene, view);
    reflector_error(&picture(ID, settings, scene, view).0, &truth, scene, view).flip_mean
}

#[test]
fn an_adaptive_mesh_shows_what_tracing_every_fragment_does_with_a_tenth_of_the_rays() {
    let scene = scene("colonnade?tess=24");
    let view = scene.default_view(320, 240);
    let (exact, every) = picture(ID, &format!("{SMALL}\ntransfer = 'exact'"), &scene, &view);
    let off = |settings: &str| {
        let (found, report) = picture(ID, &format!("{SMALL}\n{settings}"), &scene, &view);
        (reflector_error(&found, &exact, &scene, &view).flip_mean, report.counts["rays_traced"])
    };
    // Fragments that are traced on the spot would hide how coarse a mesh is.
    let [(fine, more), (coarse, fewer)] = [1, 6].map(|tau| off(&format!("tau = {tau}\nedges = 'nearest'")));
    assert!(fine < coarse && fewer < more, "{fine} with {more} rays, {coarse} with {fewer}");
    // Footprints are blurred by one and not by the other.
    assert!(fine < 0.08, "{fine}");
    // The more is traced where paths of neighbours take different ways, the better.
    let [(each, most), (once, some), (none, least)] =
        ["traced", "once", "nearest"].map(|edges| off(&format!("tau = 6\nedges = '{edges}'")));
    assert!(least < some && some < most, "{least}, {some}, {most} rays");
    assert!(each < none && once < none, "{each}, {once}, {none}");
    let (_, truth) = picture("reference", "paths = 'two_path'", &scene, &view);
    let (all, rays) = (truth.counts["rays_traced"], off("tau = 5").1);
    assert!(10 * rays < all && rays < every.counts["rays_traced"], "{rays} of {all}");
}

#[test]
fn inferred_textures_beat_projected_ones_and_layers_beat_one_layer() {
    let scene = scene("sphere_room");
    let view = scene.default_view(160, 120);
    // Without depths everything is on its shell, as in the paper.
    const SIZES: &str = "depth = false\nsize = 128\npicture_size = 192\nviewpoint_count = 12";
    let with = |settings: &str| flip(&format!("{SIZES}\n{settings}"), &scene, &view);
    let projected = with("");
    let inferred = with("textures = 'inferred'\nneighbours = 0");
    let single = with("textures = 'inferred'\nneighbours = 0\nlayers = 1");
    assert!(inferred < 0.8 * projected, "{inferred}, {projected}");
    assert!(inferred < single, "{inferred}, {single}");
    let mapped = error("environment_map", "", &scene, &view, QUALITY).flip_mean;
    assert!(projected < 0.6 * mapped, "{projected}, {mapped}");
}

#[test]
fn texels_with_distances_show_things_at_their_places() {
    // A pot and a cup between near things, from a viewpoint and from above.
    let scene = scene("colonnade?tess=24");
    let camera = scene.default_view(4, 3);
    let lens = scene.specular_objects().into_iter().map(|object| scene.objects[object as usize].bounds.center());
    let center = lens.reduce(|a, b| 0.5 * (a + b)).unwrap();
    for eye in [camera.eye(), camera.eye() + 0.8 * Vec3::Y] {
        let view = scene.view(&Camera::look_at("", eye, center, Vec3::Y, 30.0), 160, 120);
        let [deep, flat] = [true, false].map(|depth| flip(&format!("size = 128\ndepth = {depth}"), &scene, &view));
        assert!(deep < 0.8 * flat, "{eye}: {deep}, {flat}");
    }
}

#[test]
#[ignore = "slow: cargo xtask check-all --only slow"]
fn what_pictures_do_not_show_is_there_for_the_views_beside_them() {
    // The eye is between two viewpoints, each of which was inferred alone.
    let scene = scene("sphere_room");
    let camera = scene.default_view(4, 3);
    let turn = Quat::from_rotation_y((0.5f32 * 30.0).to_radians());
    let center = scene.objects[scene.specular_objects()[0] as usize].bounds.center();
    let eye = center + turn * (camera.eye() - center);
    let view = scene.view(&Camera::look_at("", eye, center, Vec3::Y, 40.0), 120, 90);
    let with = |settings: &str| flip(&format!("{SMALL}\ntextures = 'inferred'\n{settings}"), &scene, &view);
    let complete = with("");
    let bare = with("continued = false\nneighbours = 0\ndirect = \"none\"");
    assert!(complete < bare, "{complete}, {bare}");
    let flat = with("depth = false");
    let bare = with("depth = false\ncontinued = false\nneighbours = 0\ndirect = \"none\"");
    assert!(flat < bare, "{flat}, {bare}");
}

#[test]
fn direct_images_show_what_a_lens_does_not_and_change_nothing_that_it_shows() {
    // A glass ball, from a viewpoint and from beside it, with pictures from the viewpoint alone.
    let scene = scene("glass_sphere?tess=24");
    let camera = scene.default_view(4, 3);
    let center = scene.objects[scene.specular_objects()[0] as usize].bounds.center();
    let errors = |direct: &str| {
        [0.0f32, 15.0].map(|degrees| {
            let eye = center + Quat::from_rotation_y(degrees.to_radians()) * (camera.eye() - center);
            let view = scene.view(&Camera::look_at("", eye, center, Vec3::Y, 40.0), 80, 60);
            let rest = "textures = 'inferred'\ndepth = false\ncontinued = false\nneighbours = 0";
            flip(&format!("{SMALL}\n{rest}\ndirect = '{direct}'"), &scene, &view)
        })
    };
    let [bare, from_viewpoint, from_both] = ["none", "viewpoint", "both"].map(errors);
    assert!(from_viewpoint[1] < 0.9 * bare[1], "{from_viewpoint:?}, {bare:?}");
    assert!(from_both[1] < 0.9 * bare[1], "{from_both:?}, {bare:?}");
    assert!(from_viewpoint[0] < 1.02 * bare[0], "{from_viewpoint:?}, {bare:?}");
}

#[test]
#[ignore = "slow: cargo xtask check-all --only slow"]
fn groups_that_share_their_farthest_layer_show_about_what_they_show_without() {
    let scene = scene("two_spheres");
    let view = scene.default_view(160, 120);
    for textures in ["projected", "inferred"] {
        let [apart, shared] = [false, true].map(|shared| {
            let settings = format!("{SMALL}\nlayers = 2\ntextures = '{textures}'\nshare_far = {shared}");
            let report = session(ID, &settings, &scene, QUALITY).setup().clone();
            (report, flip(&settings, &scene, &view))
        });
        assert_eq!((apart.0.counts["lens_groups"], shared.0.counts["shared_layers"]), (2, 1));
        assert!(shared.0.counts["layers"] < apart.0.counts["layers"], "{:?}, {:?}", apart.0, shared.0);
        assert!(shared.0.bytes["layers"] < apart.0.bytes["layers"], "{:?}, {:?}", apart.0, shared.0);
        // The places of shells depend on the viewpoints: with 8 to 45 of these the difference is 0.009 to 0.014.
        assert!(shared.1 < apart.1 + 0.015, "{textures}: {}, {}", shared.1, apart.1);
    }
}

#[test]
fn baked_layers_draw_what_made_ones_do() {
    for more in ["", "\nshare_far = true", "\ndirect = 'both'", "\ndepth = false"] {
        baked_layers_draw_the_same(&format!("textures = 'inferred'{more}"));
    }
    for more in ["", "\nshare_far = true", "\ndepth = false", "\nlayers = 6\nclustering = 'distance'"] {
        baked_layers_draw_the_same(&format!("textures = 'projected'{more}"));
    }
}

fn baked_layers_draw_the_same(more: &str) {
    const SIZES: &str = "size = 16\npicture_size = 32\ncapture_samples = 1\nviewpoint_count = 3";
    let settings = format!("{SIZES}\n{more}");
    let scene = scene("two_spheres?tess=12");
    let view = scene.default_view(80, 60);
    let (made_now, report) = picture(ID, &settings, &scene, &view);
    let inferred = report.counts.get("viewpoints_inferred").copied();
    assert!(if more.contains("inferred") { inferred >= Some(2) } else { inferred.is_none() }, "{report:?}");
    let Units(made) = baked(ID, &settings, &scene, QUALITY);
    let session =
        |settings: &str, made: &[Vec<u8>]| Session::with_bake(ID, settings, &scene, QUALITY, Units(made.to_vec()));
    let mut baked = session(&settings, &made).unwrap();
    assert!(baked.draw(&view).unwrap().picture.pixels == made_now.pixels, "{more}");
    assert!(!baked.setup().stages_ms.iter().any(|(stage, _)| *stage == "capture"), "nothing is captured");
    for (settings, made) in [(settings.replace("size = 16", "size = 32"), &made[..]), (settings.clone(), &made[1..])] {
        let refused = refusal(session(&settings, made));
        assert!(refused.contains("units"), "{refused}");
    }
}

/// Bytes of all kinds, but for the first `kept` of each unit: half floats that are infinite, numbers that are none,
/// negative opacities.
fn scrambled(units: &mut [Vec<u8>], kept: usize) {
    let mut state = 7u32;
    for byte in units.iter_mut().flat_map(|unit| unit.iter_mut().skip(kept)) {
        state = state.wrapping_mul(1_664_525).wrapping_add(1_013_904_223);
        *byte = (state >> 24) as u8;
    }
}

#[test]
fn bakes_of_any_bytes_give_pictures_of_numbers() {
    const SETTINGS: &str = "size = 16\npicture_size = 32\ncapture_samples = 1\nviewpoint_count = 3";
    let scene = scene("two_spheres?tess=12");
    let view = scene.default_view(80, 60);
    for textures in ["inferred", "projected"] {
        let settings = format!("{SETTINGS}\ntextures = '{textures}'");
        let Units(good) = baked(ID, &settings, &scene, QUALITY);
        let session = |units: &[Vec<u8>]| Session::with_bake(ID, &settings, &scene, QUALITY, Units(units.to_vec()));
        // Depths of all kinds, and textures; all values of pictures are finite.
        let mut units = good.clone();
        scrambled(&mut units[1..], 12);
        session(&units).unwrap().draw(&view).unwrap();
        // The base of the depths is broken, too, and then the shells.
        scrambled(&mut units[1..], 0);
        assert!(refusal(session(&units)).contains("no depths"), "{textures}");
        units[1..].clone_from_slice(&good[1..]);
        scrambled(&mut units[..1], 0);
        assert!(refusal(session(&units)).contains("no shells"), "{textures}");
    }
}

/// Larger pictures read larger textures, a view the same whatever was drawn before, and a given size is as given.
#[test]
fn textures_are_as_large_as_a_view_reads_them() {
    let scene = scene("sphere_room?tess=16");
    let quality = Quality { samples: 1, order: 1 };
    let fine = "capture_samples = 1";
    let [small, large] = [[32, 24], [256, 192]].map(|[width, height]| scene.default_view(width, height));
    let mut chosen = session(ID, fine, &scene, quality);
    let [first, second, again] = [&small, &large, &small].map(|view| chosen.draw(view).expect("it is drawn"));
    let texels = [&first, &second, &again].map(|drawn| drawn.report.counts["layer_texels"]);
    assert!(texels[0] < texels[1] && texels[0] == texels[2], "{texels:?}");
    assert!(first.picture.pixels == again.picture.pixels, "a picture depends on what was drawn before");
    let captures = [&first, &second, &again].map(|drawn| drawn.report.stages_ms.iter().any(|one| one.0 == "capture"));
    assert_eq!(captures, [true, true, false]);
    // The chosen size gives the same picture as that size in the settings, and a better one than the next smaller
    // sizes.
    let given = |size: u64| draw(ID, &format!("{fine}\nsize = {size}"), &scene, &large, quality).picture;
    assert!(given(texels[1]).pixels == second.picture.pixels, "{texels:?}");
    let truth = draw("reference", "paths = 'two_path'", &scene, &large, quality).picture;
    let error = |found: &Framebuffer| reflector_error(found, &truth, &scene, &large).flip_mean;
    assert!(error(&second.picture) < 0.95 * error(&given(64)), "{texels:?}");
}
