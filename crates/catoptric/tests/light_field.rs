//! Light-field slabs against the reference, where they are exact, and as they get finer.

use catoptric::framebuffer::Framebuffer;
use catoptric::math::Aabb;
use catoptric::methods::bake::Baked;
use catoptric::methods::lookup::light_field::{LightFieldSettings, Slabs};
use catoptric::methods::reference::specular_mask;
use catoptric::methods::{self, Quality, ReflectionMethod};
use catoptric::metrics::{Comparison, PictureError};
use catoptric::progress::Silent;
use catoptric::scene::{Material, Scene, View};
use catoptric_testkit::drawing::{drawn, prepared, scene, survives_with};
use catoptric_testkit::scenes::{SceneBuilder, eyes_within_and_on_a_sphere, things_without_size};
use glam::Vec3;
use std::sync::Arc;

const QUALITY: Quality = Quality { samples: 4, order: 1 };

fn picture(id: &str, settings: &str, scene: &Scene, view: &View) -> Framebuffer {
    drawn(&mut *prepared(id, settings, scene, QUALITY), scene, view, QUALITY)
}

/// The error over reflector pixels.
fn error(id: &str, settings: &str, scene: &Scene, view: &View) -> PictureError {
    let truth = picture("reference", "", scene, view);
    let comparison = Comparison::new(&picture(id, settings, scene, view), &truth).expect("pictures of one size");
    comparison.masked(&specular_mask(scene, view)).expect("a mask of their size").expect("the reflector is seen")
}

/// A flat mirror before a wall that is all that it shows.
fn mirror_before_a_wall() -> Scene {
    let mut builder = SceneBuilder::new();
    let wall = builder.checker("wall", 64, [60, 70, 120], [200, 205, 215]);
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
    let view = scene.default_view(160, 160);
    // The plane of views lies at 0.1, the wall at 4.
    let with =
        |st: u32, disparity: &str| format!("st = {st}\nuv = 512\nfocal_distance = 3.9\ndisparity = '{disparity}'");
    let [few, many] = [2, 9].map(|st| picture("light_field", &with(st, "plane"), &scene, &view));
    let apart = Comparison::new(&few, &many).expect("pictures of one size").whole().expect("pixels");
    assert!(apart.rmse < 2e-3, "two views a side show what nine show: {apart:?}");
    let at_infinity = error("light_field", &with(2, "none"), &scene, &view);
    let on_plane = error("light_field", &with(2, "plane"), &scene, &view);
    assert!(on_plane.rmse < 0.25 * at_infinity.rmse, "{on_plane:?}, {at_infinity:?}");
    let by_depth = error("light_field", &with(2, "depth"), &scene, &view);
    assert!(by_depth.rmse < 1.02 * on_plane.rmse, "depth finds the plane: {by_depth:?}, {on_plane:?}");
}

#[test]
fn finer_slabs_are_nearer_to_the_truth_and_beat_environment_maps() {
    let scene = scene("sphere_room");
    let view = scene.default_view(200, 150);
    let flip = |settings: &str| error("light_field", settings, &scene, &view).flip_mean;
    let by_uv = [16, 32, 64].map(|uv| flip(&format!("st = 16\nuv = {uv}")));
    // With these few views it is they that limit the last.
    assert!(by_uv[0] > 1.2 * by_uv[1] && by_uv[1] > 1.05 * by_uv[2], "{by_uv:?}");
    let by_st = [4, 8, 16].map(|st| flip(&format!("st = {st}\nuv = 48\ndisparity = 'plane'")));
    assert!(by_st[0] > 1.1 * by_st[1] && by_st[1] > 1.1 * by_st[2], "{by_st:?}");
    let map = error("environment_map", "", &scene, &view).flip_mean;
    let corrected = error("environment_map", "parallax = 'box'", &scene, &view).flip_mean;
    assert!(by_uv[2] < 0.5 * map && by_uv[2] < corrected, "{by_uv:?}, {map}, {corrected}");
}

#[test]
fn traced_transfer_shows_glass_and_mirrors_in_each_other() {
    let quality = Quality { samples: 4, order: 2 };
    let mut mirrors = scene("two_spheres");
    // Both in one region.
    let bounds = mirrors.specular_objects().into_iter().map(|object| mirrors.objects[object as usize].bounds);
    mirrors.region = bounds.reduce(Aabb::union);
    // The other sphere is a small part of what each shows.
    for (name, scene, share) in [("glass_sphere", scene("glass_sphere"), 0.6), ("two_spheres", mirrors, 0.97)] {
        let view = scene.default_view(160, 120);
        let shown =
            |id: &str, settings: &str| drawn(&mut *prepared(id, settings, &scene, quality), &scene, &view, quality);
        let (truth, mask) = (shown("reference", ""), specular_mask(&scene, &view));
        let error = |transfer: &str| {
            let picture = shown("light_field", &format!("st = 16\nuv = 48\ntransfer = '{transfer}'"));
            let comparison = Comparison::new(&picture, &truth).expect("pictures of one size");
            comparison.masked(&mask).expect("a mask of their size").expect("reflectors are seen").flip_mean
        };
        let (traced, first) = (error("traced"), error("first"));
        assert!(traced < 0.25 && traced < share * first, "{name}: {traced}, by the first bounce {first}");
    }
}

#[test]
fn eyes_anywhere_and_things_without_size_are_survived() {
    let (scene, eyes) = eyes_within_and_on_a_sphere();
    survives_with("light_field", "st = 3\nuv = 8", &scene, &eyes, 2);
    let (scene, eyes) = things_without_size();
    survives_with("light_field", "st = 3\nuv = 8", &scene, &eyes, 2);
}

#[test]
fn reflectors_outside_the_region_show_environment_maps_and_are_counted() {
    let mut scene = scene("two_spheres");
    let [first, second] = [0, 1].map(|k: usize| scene.specular_objects()[k]);
    scene.region = Some(scene.objects[first as usize].bounds);
    let mut method = methods::create("light_field", &toml::from_str("st = 3\nuv = 8").unwrap()).unwrap();
    let report = method.prepare(&scene, QUALITY, &Silent).unwrap();
    assert_eq!(report.fallbacks["reflectors_with_environment_maps"], 1);
    assert_eq!(report.counts["regions"], 1);
    assert_eq!(report.counts["captured_rays"], 6 * 9 * 64);
    // The second sphere looks as its environment map does.
    let view = scene.default_view(120, 90);
    let shown = drawn(&mut *method, &scene, &view, QUALITY);
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

/// Units in memory.
struct Units(Vec<Vec<u8>>);

impl Baked for Units {
    fn unit_count(&self) -> usize {
        self.0.len()
    }

    fn unit(&self, number: usize) -> &[u8] {
        self.0.get(number).map(Vec::as_slice).unwrap_or_default()
    }
}

fn light_field(settings: &str) -> Box<dyn ReflectionMethod> {
    methods::create("light_field", &toml::from_str(settings).unwrap()).unwrap()
}

/// All units, the last one first.
fn baked(settings: &str, scene: &Scene) -> Units {
    let bake = methods::find("light_field").unwrap().bake.expect("it can be baked");
    let work = bake(&toml::from_str(settings).unwrap(), scene, QUALITY).unwrap();
    let (units, maker) = (work.units(), work.maker());
    let mut made: Vec<Vec<u8>> = (0..units.len()).rev().map(|number| maker.make(number)).collect();
    made.reverse();
    for (unit, bytes) in units.iter().zip(&made) {
        assert_eq!(unit.bytes, bytes.len() as u64, "{}", unit.name);
    }
    assert!(maker.make(units.len()).is_empty());
    assert!(maker.estimate_core_secs() > 0.0);
    Units(made)
}

#[test]
fn baked_slabs_draw_what_captured_ones_do() {
    const SETTINGS: &str = "st = 4\nuv = 12";
    let scene = scene("two_spheres");
    let view = scene.default_view(80, 60);
    let captured = picture("light_field", SETTINGS, &scene, &view);
    let mut method = light_field(SETTINGS);
    method.take_bake(Arc::new(baked(SETTINGS, &scene))).unwrap();
    let report = method.prepare(&scene, QUALITY, &Silent).unwrap();
    assert!(!report.counts.contains_key("captured_rays") && report.warnings.is_empty(), "{report:?}");
    assert!(drawn(&mut *method, &scene, &view, QUALITY).pixels == captured.pixels);
}

#[test]
fn a_bake_of_other_sizes_is_refused() {
    let scene = scene("sphere_room?tess=12");
    let units = baked("st = 3\nuv = 8", &scene);
    for (settings, units) in [
        ("st = 4\nuv = 8", Units(units.0.clone())),
        ("st = 3\nuv = 9", Units(units.0.clone())),
        ("st = 3\nuv = 8", Units(units.0[1..].to_vec())),
    ] {
        let mut method = light_field(settings);
        method.take_bake(Arc::new(units)).unwrap();
        let error = method.prepare(&scene, QUALITY, &Silent).expect_err("it is refused").to_string();
        assert!(error.contains("units"), "{settings}: {error}");
    }
    assert!(methods::create("reference", &toml::Table::new()).unwrap().take_bake(Arc::new(units)).is_err());
}

/// The same scene with its ball elsewhere.
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
    let mut method = light_field(settings);
    assert!(method.prepare(&scene, QUALITY, &Silent).unwrap().counts["captured_rays"] > 0);
    let shown = |method: &mut dyn ReflectionMethod, scene: &Scene| {
        let truth = picture("reference", "", scene, &view);
        let mask = specular_mask(scene, &view);
        let comparison = Comparison::new(&drawn(method, scene, &view, QUALITY), &truth).unwrap();
        comparison.masked(&mask).unwrap().unwrap().flip_mean
    };
    let before = shown(&mut *method, &scene);
    assert!(!method.prepare(&elsewhere, QUALITY, &Silent).unwrap().counts.contains_key("captured_rays"));
    let mut anew = light_field(settings);
    anew.prepare(&elsewhere, QUALITY, &Silent).unwrap();
    let (kept, anew) = (shown(&mut *method, &elsewhere), shown(&mut *anew, &elsewhere));
    assert_eq!(kept, anew, "the slabs are the same");
    // As good as in the middle of the region, and better than an environment map that is taken anew.
    let map = error("environment_map", "", &elsewhere, &view).flip_mean;
    assert!(kept < 1.2 * before && kept < 0.7 * map, "{kept}, before it moved {before}, environment map {map}");

    // A bake of a scene without a region is of one moment.
    let still = Scene { region: None, ..scene.clone() };
    let small = "st = 3\nuv = 8";
    let mut method = light_field(small);
    method.take_bake(Arc::new(baked(small, &still))).unwrap();
    method.prepare(&still, QUALITY, &Silent).unwrap();
    let error = method.prepare(&moved(&still, by), QUALITY, &Silent).expect_err("it is refused").to_string();
    assert!(error.contains("one moment"), "{error}");
}
