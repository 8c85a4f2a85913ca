//! Light-field slabs against the reference, where they are exact, and as they get finer.

use catoptric::error::RenderError;
use catoptric::framebuffer::Framebuffer;
use catoptric::light::path_tracer::specular_mask;
use catoptric::light::tracer::Tracer;
use catoptric::math::Aabb;
use catoptric::methods::lookup::light_field::{Compression, Layout, LightFieldSettings, Slabs, views_manifest};
use catoptric::methods::{self, Quality};
use catoptric::metrics::{Comparison, PictureError};
use catoptric::picture;
use catoptric::progress::Silent;
use catoptric::scene::{Camera, Material, Projection, Scene, View};
use catoptric_testkit::baking::{Units, baked};
use catoptric_testkit::drawing::{self, reflector_error, refusal, scene, session};
use catoptric_testkit::scenes::SceneBuilder;
use catoptric_testkit::{Drawn, Session};
use glam::{Affine3A, Mat3, Vec3};
use std::path::Path;

const QUALITY: Quality = Quality { samples: 4, order: 1 };

fn picture(id: &str, settings: &str, scene: &Scene, view: &View) -> Framebuffer {
    drawing::picture(id, settings, scene, view, QUALITY)
}

/// The error over reflector pixels.
fn error(id: &str, settings: &str, scene: &Scene, view: &View) -> PictureError {
    drawing::error(id, settings, scene, view, QUALITY)
}

/// A flat mirror before a wall that is all that it shows.
fn mirror_before_a_wall() -> Scene {
    let mut builder = SceneBuilder::new();
    let wall = builder.checker("wall", 64, [60, 70, 120], [200, 205, 215]);
    builder.quad("behind", Vec3::new(-20.0, -20.0, -6.0), Vec3::new(40.0, 0.0, 0.0), Vec3::new(0.0, 40.0, 0.0), wall);
    builder.quad("wall", Vec3::new(20.0, -20.0, 4.0), Vec3::new(-40.0, 0.0, 0.0), Vec3::new(0.0, 40.0, 0.0), wall);
    let mirror = builder.material(Material::mirror("mirror", Vec3::ONE));
    builder.quad("mirror", Vec3::new(-0.5, -0.5, 0.0), Vec3::X, Vec3::Y, mirror);
    builder.camera(Vec3::new(0.4, 0.3, 2.0), Vec3::ZERO, 35.0);
    let mut scene = builder.build();
    scene.region = Some(Aabb { min: Vec3::new(-0.6, -0.6, -0.1), max: Vec3::new(0.6, 0.6, 0.1) });
    scene
}

#[test]
fn a_scene_on_the_focal_plane_needs_no_more_than_four_views() {
    let scene = mirror_before_a_wall();
    let view = scene.default_view(96, 96);
    // The plane of views lies at 0.1, the wall at 4.
    let with =
        |st: u32, disparity: &str| format!("st = {st}\nuv = 320\nfocal_distance = 3.9\ndisparity = '{disparity}'");
    let [few, many] = [2, 5].map(|st| picture("light_field", &with(st, "plane"), &scene, &view));
    let apart = Comparison::new(&few, &many).expect("pictures of one size").whole().expect("pixels");
    assert!(apart.rmse < 2e-3, "two views a side show what five show: {apart:?}");
    let at_infinity = error("light_field", &with(2, "none"), &scene, &view);
    let on_plane = error("light_field", &with(2, "plane"), &scene, &view);
    assert!(on_plane.rmse < 0.25 * at_infinity.rmse, "{on_plane:?}, {at_infinity:?}");
    let by_depth = error("light_field", &with(2, "depth"), &scene, &view);
    assert!(by_depth.rmse < 1.02 * on_plane.rmse, "depth finds the plane: {by_depth:?}, {on_plane:?}");
}

#[test]
fn finer_slabs_are_nearer_to_the_truth_and_beat_environment_maps() {
    let scene = scene("sphere_room");
    let view = scene.default_view(120, 90);
    let flip = |settings: &str| error("light_field", settings, &scene, &view).flip_mean;
    let by_uv = [12, 24, 48].map(|uv| flip(&format!("st = 16\nuv = {uv}")));
    // With these few views their number limits the last one.
    assert!(by_uv[0] > 1.2 * by_uv[1] && by_uv[1] > 1.05 * by_uv[2], "{by_uv:?}");
    let by_st = [3, 6, 12].map(|st| flip(&format!("st = {st}\nuv = 36\ndisparity = 'plane'")));
    assert!(by_st[0] > 1.1 * by_st[1] && by_st[1] > 1.1 * by_st[2], "{by_st:?}");
    let map = error("environment_map", "", &scene, &view).flip_mean;
    let corrected = error("environment_map", "parallax = 'box'", &scene, &view).flip_mean;
    assert!(by_uv[2] < 0.5 * map && by_uv[2] < corrected, "{by_uv:?}, {map}, {corrected}");
}

#[test]
fn traced_transfer_shows_glass_and_mirrors_in_each_other() {
    let quality = Quality { samples: 4, order: 2 };
    let mut mirrors = scene("two_spheres");
    // Both objects are in one region.
    let bounds = mirrors.specular_objects().into_iter().map(|object| mirrors.objects[object as usize].bounds);
    mirrors.region = bounds.reduce(Aabb::union);
    // The other sphere is a small part of each reflection.
    for (name, scene, share) in [("glass_sphere", scene("glass_sphere"), 0.6), ("two_spheres", mirrors, 0.97)] {
        let view = scene.default_view(96, 72);
        let error = |transfer: &str| {
            let settings = format!("st = 12\nuv = 36\ntransfer = '{transfer}'");
            drawing::error("light_field", &settings, &scene, &view, quality).flip_mean
        };
        let (traced, first) = (error("traced"), error("first"));
        assert!(traced < 0.25 && traced < share * first, "{name}: {traced}, by the first bounce {first}");
    }
}

/// Kept rays lead through glass where one bounce does not, and away from mirrors nearly as the law has them; reflected
/// and scattered light keep their weights.
#[test]
#[ignore = "slow: cargo xtask check-all --only slow"]
fn stored_transfer_needs_no_tracing_and_gets_better_with_more_rays() {
    let quality = Quality { samples: 4, order: 2 };
    for (name, against, most) in [("glass_sphere", "first", 0.8), ("sphere_room?blend=both", "traced", 1.5)] {
        let scene = scene(name);
        let view = scene.default_view(160, 120);
        let error = |transfer: &str| {
            let settings = format!("st = 12\nuv = 40\n{transfer}");
            drawing::error("light_field", &settings, &scene, &view, quality).flip_mean
        };
        let stored = |st: u32, uv: u32| error(&format!("transfer = 'stored'\ntransfer_st = {st}\ntransfer_uv = {uv}"));
        let (few, many, other) = (stored(8, 24), stored(16, 64), error(&format!("transfer = '{against}'")));
        assert!(many < 0.9 * few, "{name}: more rays are nearer: {few}, {many}");
        assert!(many < most * other, "{name}: {many}, {against} {other}");
    }
}

#[test]
#[ignore = "slow: cargo xtask check-all --only slow"]
fn compressed_views_differ_little_and_a_bake_of_them_is_smaller() {
    let scene = scene("sphere_room");
    let view = scene.default_view(120, 90);
    let with = |compression: &str| format!("st = 8\nuv = 32\ncompression = '{compression}'");
    let plain = picture("light_field", &with("none"), &scene, &view);
    let bytes = |units: &Units| units.0.iter().map(Vec::len).sum::<usize>() as f64;
    let size = bytes(&baked("light_field", &with("none"), &scene, QUALITY));
    for (compression, most_flip, most_share) in [("bc1", 0.1, 0.17), ("bc6h", 0.04, 0.26), ("bc7", 0.05, 0.26)] {
        let captured = picture("light_field", &with(compression), &scene, &view);
        let apart = reflector_error(&captured, &plain, &scene, &view);
        assert!(apart.flip_mean > 0.0 && apart.flip_mean < most_flip, "{compression}: {apart:?}");
        let units = baked("light_field", &with(compression), &scene, QUALITY);
        assert!(bytes(&units) < most_share * size, "{compression}: {} of {size} bytes", bytes(&units));
        let mut session = from_bake(&with(compression), &scene, units).unwrap();
        assert!(session.draw(&view).unwrap().picture.pixels == captured.pixels, "{compression}");
    }
}

#[test]
fn reflectors_outside_the_region_show_environment_maps_and_are_counted() {
    let mut scene = scene("two_spheres");
    let [first, second] = [0, 1].map(|k: usize| scene.specular_objects()[k]);
    scene.region = Some(scene.objects[first as usize].bounds);
    let view = scene.default_view(120, 90);
    let shown = drawing::draw("light_field", "st = 3\nuv = 8", &scene, &view, QUALITY);
    let (report, shown) = (shown.setup, shown.picture);
    assert_eq!(report.fallbacks["reflectors_with_environment_maps"], 1);
    assert_eq!(report.counts["regions"], 1);
    assert_eq!(report.counts["captured_rays"], 6 * 9 * 64);
    // The second sphere looks as its environment map does.
    let mapped = picture("environment_map", "", &scene, &view);
    let place = view.pixel_of(scene.objects[second as usize].bounds.center()).expect("it is seen");
    let index = place.y as usize * 120 + place.x as usize;
    assert!((shown.pixels[index][0] - mapped.pixels[index][0]).abs() < 0.05);
}

#[test]
fn settings_and_regions_that_mean_nothing_are_refused() {
    let scene = scene("sphere_room");
    let region = scene.objects[scene.specular_objects()[0] as usize].bounds;
    let small = LightFieldSettings { st: 2, uv: 4, ..LightFieldSettings::default() };
    let flat = Aabb { max: region.min, ..region };
    for (settings, region, named) in [
        (LightFieldSettings { st: 0, ..small.clone() }, region, "st = 0"),
        (LightFieldSettings { uv: 0, ..small.clone() }, region, "uv = 0"),
        (small, flat, "has no size"),
    ] {
        let error = Slabs::capture(&settings, &scene, region, 0, &Silent).expect_err("it is refused").to_string();
        assert!(error.contains(named), "{error}");
    }
}

fn from_bake(settings: &str, scene: &Scene, units: Units) -> Result<Session, RenderError> {
    Session::with_bake("light_field", settings, scene, QUALITY, units)
}

#[test]
fn what_no_machine_could_hold_is_refused_before_it_is_begun() {
    let scene = mirror_before_a_wall();
    let quality = Quality { samples: 1, order: 1 };
    const LARGE_TRANSFER: &str = "transfer = 'stored'\ntransfer_st = 64\ntransfer_uv = 256";
    for settings in ["st = 256\nuv = 1024", &format!("st = 2\nuv = 4\n{LARGE_TRANSFER}")] {
        let refused = refusal(Session::new("light_field", settings, &scene, quality));
        assert!(refused.contains("GiB of memory") && refused.contains("smaller"), "{refused}");
    }
    // Order 0 keeps nothing in memory.
    let quality = Quality { order: 0, ..quality };
    session("light_field", &format!("st = 256\nuv = 1024\n{LARGE_TRANSFER}"), &scene, quality);
}

#[test]
fn baked_slabs_draw_what_captured_ones_do() {
    const SETTINGS: &str = "st = 4\nuv = 12";
    let scene = scene("two_spheres");
    let view = scene.default_view(80, 60);
    let captured = picture("light_field", SETTINGS, &scene, &view);
    let units = baked("light_field", SETTINGS, &scene, QUALITY);
    let mut session = from_bake(SETTINGS, &scene, units).unwrap();
    let report = session.setup();
    assert!(!report.counts.contains_key("captured_rays") && report.warnings.is_empty(), "{report:?}");
    assert!(session.draw(&view).unwrap().picture.pixels == captured.pixels);
}

/// Boxes and columns that cross the planes of slabs, about as many bytes.
#[test]
fn views_on_the_box_show_near_things_that_cross_the_planes_of_slabs() {
    for (name, most) in [("sphere_room", 0.75), ("two_spheres", 0.9)] {
        let scene = scene(name);
        let view = scene.default_view(120, 90);
        let off = |settings: &str| error("light_field", settings, &scene, &view);
        let (slabs, sides) = (off("st = 12\nuv = 36"), off("layout = 'box'\nst = 6\nuv = 72"));
        let [of_slabs, of_sides] = [&slabs, &sides].map(|error| error.over_0_1);
        assert!(of_sides < most * of_slabs, "{name}: {sides:?}, slabs {slabs:?}");
        assert!(sides.flip_mean < slabs.flip_mean, "{name}: {sides:?}, slabs {slabs:?}");
    }
}

#[test]
fn baked_views_on_the_box_draw_what_captured_ones_do() {
    let scene = scene("two_spheres");
    let view = scene.default_view(80, 60);
    for compression in ["none", "bc1"] {
        let settings = format!("layout = 'box'\nst = 4\nuv = 12\ncompression = '{compression}'");
        let captured = picture("light_field", &settings, &scene, &view);
        let units = baked("light_field", &settings, &scene, QUALITY);
        // Sizes may be those of slabs: which they are stands in the file.
        let work = (methods::find("light_field").unwrap().bake.unwrap())(&settings.parse().unwrap(), &scene, QUALITY);
        assert_eq!(work.unwrap().settings()["layout"].as_str(), Some("box"));
        let mut session = from_bake(&settings, &scene, units).unwrap();
        assert!(session.draw(&view).unwrap().picture.pixels == captured.pixels, "{compression}");
    }
}

/// Compressed views are not decompressed: 738 MB of 32 x 32 views of 128 x 128 pixels are less than 120.
#[test]
fn compressed_views_stay_so_in_memory() {
    let scene = scene("sphere_room?tess=12");
    let region = scene.objects[scene.specular_objects()[0] as usize].bounds;
    for layout in [Layout::Slabs, Layout::Box] {
        let bytes = |compression: Compression| {
            let settings = LightFieldSettings { layout, st: 2, uv: 128, compression, ..LightFieldSettings::default() };
            Slabs::capture(&settings, &scene, region, 0, &Silent).unwrap().byte_count() * 16 * 16
        };
        let [none, bc1] = [Compression::None, Compression::Bc1].map(bytes);
        assert!(none > 730_000_000 && bc1 <= 120_000_000, "{layout:?}: {none}, {bc1}");
    }
}

#[test]
fn views_made_elsewhere_are_those_of_slabs() {
    let scene = mirror_before_a_wall();
    let settings = LightFieldSettings { layout: Layout::Box, st: 3, uv: 8, ..LightFieldSettings::default() };
    let refused = views_manifest(&settings, &scene).expect_err("it is refused").to_string();
    assert!(refused.contains("layout=slabs"), "{refused}");
    let refused =
        refusal(Session::new("light_field", "layout = 'box'\nst = 3\nuv = 8\nviews = 'v.toml'", &scene, QUALITY));
    assert!(refused.contains("layout=slabs"), "{refused}");
}

#[test]
fn a_bake_of_other_sizes_is_refused() {
    let scene = scene("sphere_room?tess=12");
    let units = baked("light_field", "st = 3\nuv = 8", &scene, QUALITY);
    for (settings, units) in [
        ("st = 4\nuv = 8", Units(units.0.clone())),
        ("st = 3\nuv = 9", Units(units.0.clone())),
        ("st = 3\nuv = 8", Units(units.0[1..].to_vec())),
    ] {
        let error = refusal(from_bake(settings, &scene, units));
        assert!(error.contains("units"), "{settings}: {error}");
    }
    assert!(Session::with_bake("reference", "", &scene, QUALITY, units).is_err());
}

/// A copy of the scene with its ball elsewhere.
fn moved(scene: &Scene, by: Vec3) -> Scene {
    let mut moved = scene.clone();
    let object = &mut moved.objects[scene.specular_objects()[0] as usize];
    object.bounds = Aabb { min: object.bounds.min + by, max: object.bounds.max + by };
    for vertex in object.vertices.clone() {
        moved.positions[vertex as usize] += by;
    }
    moved
}

#[test]
fn reflectors_move_within_their_region_without_a_new_capture() {
    let mut scene = scene("sphere_room");
    let ball = scene.objects[scene.specular_objects()[0] as usize].bounds;
    let by = Vec3::new(0.3, 0.05, -0.2) * ball.size();
    scene.region = Some(Aabb { min: ball.min - by.abs(), max: ball.max + by.abs() });
    let elsewhere = moved(&scene, by);
    let view = scene.default_view(160, 120);
    let settings = "st = 16\nuv = 48";
    let mut kept = session("light_field", settings, &scene, QUALITY);
    assert!(kept.setup().counts["captured_rays"] > 0);
    kept.update(&elsewhere).unwrap();
    assert!(!kept.setup().counts.contains_key("captured_rays"));
    let truth = picture("reference", "", &elsewhere, &view);
    let [kept, anew] = [kept, session("light_field", settings, &elsewhere, QUALITY)]
        .map(|mut session| reflector_error(&session.draw(&view).unwrap().picture, &truth, &elsewhere, &view).flip_mean);
    assert_eq!(kept, anew, "the slabs are the same");
    // Reflectors near the region's border, too, are better than an environment map that is taken anew.
    let map = error("environment_map", "", &elsewhere, &view).flip_mean;
    assert!(kept < 0.6 * map, "{kept}, environment map {map}");

    // A bake of a scene without a region is of one moment.
    let still = Scene { region: None, ..scene.clone() };
    let small = "st = 3\nuv = 8";
    let moved = moved(&still, by);
    let mut session = from_bake(small, &still, baked("light_field", small, &still, QUALITY)).unwrap();
    let error = session.update(&moved).expect_err("it is refused").to_string();
    assert!(error.contains("one moment"), "{error}");
}

/// An eye in the region sees the whole picture in slabs: nothing of the scene is drawn but the reflector.
#[test]
fn an_eye_in_the_region_needs_no_scene() {
    let mut scene = mirror_before_a_wall();
    // Pixels as large as those of the slabs' views.
    let view = scene.default_view(48, 48);
    scene.region = Some(Aabb { min: Vec3::new(-0.6, -0.6, -0.1), max: Vec3::new(0.6, 0.6, 2.1) });
    let settings = "st = 8\nuv = 128";
    let mut session = session("light_field", &format!("{settings}\nbackground = 'slabs'"), &scene, QUALITY);
    let Drawn { report, picture: shown, .. } = session.draw(&view).unwrap();
    let reflector = scene.objects[scene.specular_objects()[0] as usize].triangles.len() as u64;
    assert!(report.counts["triangles_drawn"] <= reflector, "{report:?}");
    assert!(report.fallbacks.is_empty(), "{report:?}");
    let truth = picture("reference", "", &scene, &view);
    let behind: Vec<bool> = specular_mask(&scene, &view).iter().map(|on_mirror| !on_mirror).collect();
    let off = Comparison::new(&shown, &truth).unwrap().masked(&behind).unwrap().unwrap();
    assert!(off.flip_mean < 0.1 && off.rmse < 0.1, "{off:?}");

    // An eye elsewhere sees the drawn scene, and that is counted.
    let mut away = view;
    away.world_from_view.translation += glam::Vec3A::Z;
    let report = session.draw(&away).unwrap().report;
    assert_eq!(report.fallbacks["frames_with_a_drawn_background"], 1);
}

fn vector(value: &toml::Value) -> Vec3 {
    let numbers = value.as_array().expect("a list").iter();
    Vec3::from_slice(&numbers.map(|number| number.as_float().expect("a number") as f32).collect::<Vec<f32>>())
}

/// Makes the pictures of a manifest, as another renderer would.
fn make_views(manifest: &toml::Table, empty: &Scene, folder: &Path, fov_deg: f32) {
    let side = manifest["uv"].as_integer().unwrap() as u32;
    let tracer = Tracer::build(empty, |_| true);
    let quality = Quality { samples: 1, order: 0 };
    let mut reference = session("reference", "", empty, quality);
    for one in manifest["view"].as_array().unwrap() {
        let [eye, right, down, forward] = ["eye", "right", "down", "forward"].map(|key| vector(&one[key]));
        let axes = Mat3::from_cols(right, -down, -forward);
        assert!((axes.determinant() - 1.0).abs() < 1e-5, "a camera that is no mirror image");
        let camera = Camera {
            world_from_camera: Affine3A::from_mat3_translation(axes, eye),
            projection: Projection::Perspective { fov_y: fov_deg.to_radians() },
            ..empty.framing(1.0)
        };
        let view = empty.view(&camera, side, side);
        let shown = reference.draw(&view).unwrap().picture;
        let mut distances = shown.clone();
        for (index, pixel) in distances.pixels.iter_mut().enumerate() {
            let (x, y) = (index as u32 % side, index as u32 / side);
            let ray = view.rays().ray(x as f32 + 0.5, y as f32 + 0.5);
            let hit = tracer.first_hit(empty, &ray, 0.0);
            let distance = hit.map_or(f32::INFINITY, |hit| hit.distance() * ray.direction.dot(forward));
            *pixel = [distance, 0.0, 0.0, 1.0];
        }
        for (key, picture) in [("radiance", &shown), ("distance", &distances)] {
            let name = manifest[key].as_str().unwrap().replace("{slab}", one["slab"].as_str().unwrap());
            let name = ["s", "t"].iter().fold(name, |name, part| {
                name.replace(&format!("{{{part}}}"), &one[*part].as_integer().unwrap().to_string())
            });
            picture::write(&folder.join(name), picture).unwrap();
        }
    }
}

#[test]
fn views_made_elsewhere_show_what_captured_ones_do() {
    let scene = mirror_before_a_wall();
    let view = scene.default_view(100, 100);
    let settings = LightFieldSettings { st: 6, uv: 24, ..LightFieldSettings::default() };
    let text = views_manifest(&settings, &scene).unwrap();
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("views.toml");
    std::fs::write(&path, &text).unwrap();
    let manifest: toml::Table = toml::from_str(&text).unwrap();
    let fov_deg = text.split("fov_deg = ").nth(1).unwrap().split(' ').next().unwrap().parse().unwrap();
    let with = |more: &str| format!("st = 6\nuv = 24\nviews = '{}'\n{more}", path.display());
    let fails = |settings: &str| refusal(Session::new("light_field", settings, &scene, QUALITY));
    let missing = fails(&with(""));
    assert!(missing.contains("radiance-px-0-0.exr"), "{missing}");
    // The mirror is not in the pictures.
    make_views(&manifest, &moved(&scene, Vec3::X * 1e4), folder.path(), fov_deg);
    let imported = picture("light_field", &with(""), &scene, &view);
    let captured = picture("light_field", "st = 6\nuv = 24", &scene, &view);
    let apart = reflector_error(&imported, &captured, &scene, &view);
    assert!(apart.flip_mean < 0.03, "{apart:?}");
    let (truth, map) = (picture("reference", "", &scene, &view), picture("environment_map", "", &scene, &view));
    let error = |shown: &Framebuffer| reflector_error(shown, &truth, &scene, &view).flip_mean;
    let [imported_error, captured_error, map_error] = [&imported, &captured, &map].map(error);
    assert!(imported_error < 1.05 * captured_error, "{imported_error}, captured {captured_error}");
    assert!(imported_error < 0.85 * map_error, "{imported_error}, environment map {map_error}");

    // Baked, they are the same; the file names the pictures that they are of.
    let units = baked("light_field", &with(""), &scene, QUALITY);
    assert!(from_bake(&with(""), &scene, units).unwrap().draw(&view).unwrap().picture.pixels == imported.pixels);

    // The hash is one that other programs can compute, too: of lengths and bytes, view after view.
    let mut hash = blake3::Hasher::new();
    for slab in ["px", "nx", "py", "ny", "pz", "nz"] {
        for (t, s) in (0..6).flat_map(|t| (0..6).map(move |s| (t, s))) {
            for kind in ["radiance", "distance"] {
                let bytes = std::fs::read(folder.path().join(format!("{kind}-{slab}-{s}-{t}.exr"))).unwrap();
                hash.update(&(bytes.len() as u64).to_le_bytes()).update(&bytes);
            }
        }
    }
    let plan = methods::find("light_field").unwrap().bake.unwrap();
    let work = plan(&with("").parse().unwrap(), &scene, QUALITY).unwrap();
    let expected = format!("pictures:{}", &hash.finalize().to_hex()[..32]);
    assert_eq!(work.settings()["views"].as_str(), Some(&*expected));

    // Pictures that do not fit are refused by name.
    let manifest_without = |line: &str| {
        let kept: Vec<&str> = text.lines().filter(|it| !it.starts_with(line)).collect();
        std::fs::write(&path, kept.join("\n")).unwrap();
        fails(&with(""))
    };
    assert!(manifest_without("distance").contains("focal_distance"));
    assert!(manifest_without("uv").contains("uv"));
    std::fs::write(&path, text.replace("-{t}", "")).unwrap();
    assert!(fails(&with("")).contains("{t}"));
    std::fs::write(&path, &text).unwrap();
    assert!(fails(&with("").replace("st = 6", "st = 7")).contains("set st=6"));
    let elsewhere = Scene { region: Some(scene.bounds), ..scene.clone() };
    let error = refusal(Session::new("light_field", &with(""), &elsewhere, QUALITY));
    assert!(error.contains("region"), "{error}");
    std::fs::copy(folder.path().join("distance-px-0-0.exr"), folder.path().join("radiance-nz-5-5.exr")).unwrap();
    std::fs::write(folder.path().join("distance-pz-1-1.exr"), "no picture").unwrap();
    assert!(fails(&with("")).contains("distance-pz-1-1.exr"));
}
