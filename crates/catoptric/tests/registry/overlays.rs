//! Overlays of all methods: those that are offered are there, and show what the reference knows.

use catoptric::light::tracer::Tracer;
use catoptric::methods::overlay::{Overlay, OverlayKind};
use catoptric::methods::{self, Quality};
use catoptric::optics::step::LightStep;
use catoptric::progress::Silent;
use catoptric::scene::{Role, Scene, View};
use catoptric_testkit::drawing::scene;
use std::sync::Arc;

const ORDER: u32 = 2;

const VALID: &str = "the test's input is valid";

fn overlays(id: &str, settings: &str, scene: &Arc<Scene>, view: &View, samples: u32) -> Vec<Overlay> {
    let method = methods::create(id, &toml::from_str(settings).expect(VALID)).expect(VALID);
    let mut prepared = method.prepare(scene, Quality { samples, order: ORDER }, None, &Silent).expect(VALID);
    let frame = prepared.frame(view, &Silent).expect(VALID);
    let found = |kind: OverlayKind| {
        let overlay = frame.overlay(kind, &Silent).expect(VALID);
        assert_eq!(overlay.is_some(), method.overlays().contains(&kind), "{id}: {}", kind.name());
        overlay
    };
    OverlayKind::ALL.into_iter().filter_map(found).collect()
}

fn of_kind(overlays: &[Overlay], kind: OverlayKind) -> &Overlay {
    overlays.iter().find(|overlay| overlay.kind == kind).expect(VALID)
}

/// The names of the objects along the ray through each pixel's centre, mirrors and glass on the way with their letters,
/// as names of groups and of the last object (`None`: the environment): at glass the way through it. Traced.
fn traced(scene: &Scene, view: &View) -> Vec<(String, Option<u32>)> {
    traced_by(scene, view, &Tracer::build(scene, |_| true))
}

/// The same among some objects alone.
fn traced_by(scene: &Scene, view: &View, tracer: &Tracer) -> Vec<(String, Option<u32>)> {
    let pixel = |index: u32| {
        let mut ray = view.ray((index % view.width) as f32 + 0.5, (index / view.width) as f32 + 0.5);
        let mut path: Vec<String> = Vec::new();
        loop {
            let Some(hit) = tracer.first_hit(scene, &ray, 0.0) else { return (path.join(" > "), None) };
            let point = tracer.point(scene, &ray, &hit);
            let material = scene.material_of(point.object);
            if !material.role.is_specular() || path.len() as u32 == ORDER {
                return (path.join(" > "), Some(point.object));
            }
            let kind = match material.role {
                Role::Lens => catoptric::optics::path::bundle::BounceKind::Transmit,
                _ => catoptric::optics::path::bundle::BounceKind::Reflect,
            };
            path.push(format!("{} {}", kind.letter(), scene.objects[point.object as usize].name));
            let step = LightStep::at(scene, material, &point, ray.direction);
            let Some(direction) = step.outgoing(kind, ray.direction) else { return (path.join(" > "), None) };
            (ray.origin, ray.direction) = (tracer.departure(&point, direction), direction);
        }
    };
    (0..view.width * view.height).map(pixel).collect()
}

fn group_name(overlay: &Overlay, pixel: usize) -> &str {
    overlay.pixels[pixel].checked_sub(1).map_or("", |group| &overlay.groups[group as usize])
}

#[test]
fn offered_overlays_are_there_and_groups_are_the_references_paths() {
    for (id, spec, settings) in [
        ("auto", "planar_mirror?mirrors=2", ""),
        ("auto", "two_spheres?surface=mesh", ""),
        ("multiperspective", "two_spheres?surface=mesh", ""),
        ("multiperspective", "glass_sphere?surface=mesh", ""),
        ("planar_mirror", "planar_mirror?mirrors=2", ""),
        ("path_perturbation", "sphere_room?surface=mesh&tess=16", "work = 150"),
        ("sample_based_camera", "sphere_room?surface=mesh&tess=16", "work = 150"),
        ("explosion_map", "sphere_room?surface=mesh&tess=16", "work = 150"),
        ("reflector_search", "sphere_room?surface=mesh&tess=16", "work = 150"),
        ("reference", "planar_mirror?mirrors=2", ""),
        ("reference", "two_spheres", ""),
        ("reference", "glass_sphere", "paths = \"two_path\""),
        ("environment_map", "sphere_room?tess=16", "size = 16"),
        ("light_field", "sphere_room?tess=16", "st = 4\nuv = 8"),
    ] {
        let scene = Arc::new(scene(spec));
        let view = scene.default_view(120, 80);
        let found = overlays(id, settings, &scene, &view, 1);
        let paths = of_kind(&found, OverlayKind::Paths);
        let truth = traced(&scene, &view);
        assert_eq!((paths.size, paths.pixels.len()), ([120, 80], truth.len()));
        let specular = truth.iter().filter(|(path, _)| !path.is_empty()).count();
        let wrong = truth.iter().enumerate().filter(|(pixel, (path, _))| group_name(paths, *pixel) != path).count();
        assert!(specular > 500, "{spec}: {specular}");
        // Edges of meshes are off by parts of a pixel.
        assert!((wrong as f64) < 0.03 * specular as f64, "{id}, {spec}: {wrong} of {specular}: {:?}", paths.groups);
    }
}

/// Pixels beside which all pixels show the same path.
fn are_within(paths: &[String], width: usize) -> Vec<bool> {
    let is_within = |pixel: usize| {
        let same = |row: isize, column: isize| {
            let other = pixel as isize + row * width as isize + column;
            paths.get(other as usize).is_some_and(|path| *path == paths[pixel])
        };
        (-1..=1).all(|row| (-1..=1).all(|column| same(row, column)))
    };
    (0..paths.len()).map(is_within).collect()
}

#[test]
fn the_reference_and_tiles_show_the_same_groups() {
    for spec in ["two_spheres", "colonnade?tess=16", "glass_sphere", "dish?tess=16", "planar_mirror?mirrors=3"] {
        let scene = Arc::new(scene(spec));
        let view = scene.default_view(150, 100);
        let names = |id: &str| -> Vec<String> {
            let found = overlays(id, "", &scene, &view, 1);
            let paths = of_kind(&found, OverlayKind::Paths);
            (0..paths.pixels.len()).map(|pixel| group_name(paths, pixel).to_owned()).collect()
        };
        let [reference, tiles] = ["reference", "multiperspective"].map(names);
        let within = are_within(&reference, 150);
        let inner: Vec<usize> =
            (0..reference.len()).filter(|pixel| within[*pixel] && !reference[*pixel].is_empty()).collect();
        let differs = |pixel: &&usize| reference[**pixel] != tiles[**pixel];
        let differ: Vec<_> = inner.iter().filter(differs).map(|pixel| (&reference[*pixel], &tiles[*pixel])).collect();
        // Tiles name the way through glass where it reflects totally, too: 7 of 2810 pixels of the colonnade's pot. All
        // others are the same.
        assert!(inner.len() > 1000 && differ.len() * 250 <= inner.len(), "{spec}: {differ:?} of {}", inner.len());
        assert!(differ.is_empty() || spec.starts_with("colonnade"), "{spec}: {differ:?}");
    }
}

#[test]
fn look_ups_show_the_groups_that_they_follow() {
    // Both balls are in one region only where the scene gives it.
    let one_region = |mut scene: Scene| {
        let specular = scene.specular_objects().into_iter().map(|object| scene.objects[object as usize].bounds);
        scene.region = specular.reduce(|all, one| all.union(one));
        scene
    };
    for (id, spec, settings, most) in [
        ("environment_map", "two_spheres", "size = 16", 1),
        ("environment_map", "glass_sphere", "size = 16", 1),
        ("light_field", "two_spheres", "st = 4\nuv = 8", 2),
        ("light_field", "two_spheres", "st = 4\nuv = 8\ntransfer = \"first\"", 1),
        ("light_field", "glass_sphere", "st = 4\nuv = 8\ntransfer = \"stored\"", 2),
        ("light_field", "glass_sphere", "st = 4\nuv = 8\nbackground = \"slabs\"", 2),
    ] {
        let scene = Arc::new(one_region(scene(spec)));
        let view = scene.default_view(120, 80);
        let found = overlays(id, settings, &scene, &view, 1);
        let paths = of_kind(&found, OverlayKind::Paths);
        let first = traced(&scene, &view);
        let among = Tracer::build(&scene, |object| scene.role_of(object).is_specular());
        // Beyond the first bounce reflectors and lenses alone are followed.
        let longer = traced_by(&scene, &view, &among);
        let (mut shown, mut wrong) = (0, 0);
        for pixel in 0..first.len() {
            let name = group_name(paths, pixel);
            let cut = |path: &str| path.split(" > ").take(most).collect::<Vec<_>>().join(" > ");
            let expected = if first[pixel].0.is_empty() { String::new() } else { cut(&longer[pixel].0) };
            shown += usize::from(!name.is_empty());
            wrong += usize::from(name != expected);
        }
        assert!(shown > 500 && wrong * 50 < shown, "{id}, {spec}, {settings}: {wrong} of {shown}: {:?}", paths.groups);
        assert!(paths.groups.iter().any(|name| name.split(" > ").count() == most), "{id}: {:?}", paths.groups);
    }
}

/// Pixels that a line passes through, with those beside it.
fn touched(overlay: &Overlay, wanted: impl Fn(&str) -> bool) -> Vec<bool> {
    let [width, height] = overlay.size.map(|length| length as i32);
    let mut touched = vec![false; (width * height) as usize];
    for segment in overlay.segments.iter().filter(|segment| wanted(&overlay.groups[segment.group as usize - 1])) {
        let [a, b] = segment.ends;
        let steps = (4.0 * a.distance(b)).ceil().max(1.0) as i32;
        for step in 0..=steps {
            let at = a.lerp(b, step as f32 / steps as f32).floor().as_ivec2();
            if at.x >= 0 && at.y >= 0 && at.x < width && at.y < height {
                touched[(at.y * width + at.x) as usize] = true;
            }
        }
    }
    touched
}

#[test]
fn edges_of_virtual_triangles_lie_where_the_reference_shows_reflections() {
    for (id, spec, settings) in [
        ("planar_mirror", "planar_mirror?mirrors=2", ""),
        ("auto", "planar_mirror?mirrors=2", ""),
        ("path_perturbation", "sphere_room?surface=mesh&tess=16", "work = 150"),
        ("reflector_search", "sphere_room?surface=mesh&tess=16", "work = 150"),
    ] {
        let scene = Arc::new(scene(spec));
        let view = scene.default_view(180, 120);
        let found = overlays(id, settings, &scene, &view, 1);
        let edges = of_kind(&found, OverlayKind::VirtualTriangles);
        assert!(edges.segments.len() > 100 && edges.segments_left_out == 0, "{id}: {}", edges.segments.len());
        let truth = traced(&scene, &view);
        for group in &edges.groups {
            let drawn = touched(edges, |name| name == group);
            let shows =
                |pixel: i32| truth.get(pixel as usize).is_some_and(|(path, end)| path == group && end.is_some());
            let is_near = |pixel: i32| {
                let width = 180;
                (-1..=1).any(|row| (-1..=1).any(|column| shows(pixel + row * width + column)))
            };
            let count = drawn.iter().filter(|drawn| **drawn).count();
            let beside = (0..drawn.len()).filter(|pixel| drawn[*pixel] && !is_near(*pixel as i32)).count();
            assert!(beside * 50 <= count, "{id}, {spec}, {group}: {beside} of {count} beside");
        }
        // Where two triangles meet in the reflection, one of them is drawn: pixels whose right neighbour shows another
        // object by the same path.
        let all = touched(edges, |_| true);
        let (mut borders, mut missed) = (0, 0);
        for pixel in (0..truth.len() - 1).filter(|pixel| pixel % 180 < 179) {
            let [(path, end), (other_path, other_end)] = [&truth[pixel], &truth[pixel + 1]];
            if !path.is_empty() && path == other_path && end.is_some() && other_end.is_some() && end != other_end {
                borders += 1;
                let is_drawn = (pixel.saturating_sub(1)..pixel + 3).any(|pixel| all.get(pixel) == Some(&true));
                missed += usize::from(!is_drawn);
            }
        }
        assert!(borders > 20 && missed * 20 <= borders, "{id}, {spec}: {missed} of {borders} missed");
    }
}

#[test]
fn tiles_divide_the_reflectors_pixels() {
    for (spec, samples) in [("sphere_room?tess=16", 4), ("two_spheres?surface=mesh", 1)] {
        let scene = Arc::new(scene(spec));
        let view = scene.default_view(150, 110);
        let found = overlays("multiperspective", "", &scene, &view, samples);
        let (tiles, paths) = (of_kind(&found, OverlayKind::Tiles), of_kind(&found, OverlayKind::Paths));
        let truth = traced(&scene, &view);
        // Every pixel whose centre shows a reflector is in a tile or traced, and no other but at silhouettes.
        let (mut reflector, mut without, mut beyond) = (0, 0, 0);
        for (pixel, (path, _)) in truth.iter().enumerate() {
            let is_reflector = !path.is_empty();
            reflector += usize::from(is_reflector);
            without += usize::from(tiles.pixels[pixel] == 0 && !group_name(paths, pixel).is_empty());
            let is_rim = group_name(tiles, pixel) == "traced sample by sample";
            beyond += usize::from(tiles.pixels[pixel] != 0 && !is_reflector && !is_rim);
        }
        assert!(reflector > 2000 && without == 0, "{spec}: {without} of {reflector}");
        assert!(beyond * 100 <= reflector, "{spec}: {beyond} of {reflector}");
        let bundles = (0..truth.len()).filter(|pixel| group_name(tiles, *pixel) == "one bundle of rays").count();
        assert!(bundles * 3 > reflector, "{spec}: {bundles} of {reflector}");
        // Squares lie on the grid of their sides, and none in another: their borders do not cross.
        assert!(tiles.segments.iter().all(|segment| {
            let [a, b] = segment.ends;
            (a.x == b.x) != (a.y == b.y) && a.x >= 0.0 && b.x <= 150.0 && a.y >= 0.0 && b.y <= 110.0
        }));
        // The same at any time, whatever thread was first.
        let again = overlays("multiperspective", "", &scene, &view, samples);
        assert!(again == found);
    }
}

/// The length of all lines of an overlay.
fn length_of_lines(overlay: &Overlay) -> f32 {
    overlay.segments.iter().map(|segment| segment.ends[0].distance(segment.ends[1])).sum()
}

#[test]
fn every_pixel_of_a_reflector_has_a_leaf() {
    for (spec, settings) in [
        ("sphere_room?surface=mesh&tess=16", "work = 150"),
        ("sphere_room?surface=mesh&tess=16", "work = 150\ncamera = \"pinhole\"\naccuracy_px = 4.0"),
        ("sphere_room?surface=mesh&tess=16", "work = 0.01"),
        ("two_spheres?tess=16", "beyond_work = \"coarse\""),
    ] {
        let scene = Arc::new(scene(spec));
        let view = scene.default_view(150, 100);
        let found = overlays("sample_based_camera", settings, &scene, &view, 1);
        let leaves = of_kind(&found, OverlayKind::Leaves);
        let paths: Vec<String> = traced(&scene, &view).into_iter().map(|(path, _)| path).collect();
        let within = are_within(&paths, 150);
        let (mut reflector, mut wrong, mut by_tiles) = (0, 0, 0);
        for pixel in (0..paths.len()).filter(|pixel| within[*pixel]) {
            let is_reflector = !paths[pixel].is_empty();
            reflector += usize::from(is_reflector);
            wrong += usize::from((leaves.pixels[pixel] != 0) != is_reflector);
            by_tiles += usize::from(group_name(leaves, pixel) == "no leaf: drawn by tiles");
        }
        assert!(reflector > 1000 && wrong == 0, "{spec}, {settings}: {wrong} of {reflector}");
        // Without work there are no cameras, and with enough of it nothing else.
        let expected = if settings == "work = 0.01" { reflector } else { 0 };
        assert_eq!(by_tiles, expected, "{spec}, {settings}: {reflector}");
        assert_eq!(leaves.segments.is_empty(), by_tiles > 0, "{spec}, {settings}");
    }
}

#[test]
fn leaves_are_as_many_as_the_accuracy_takes() {
    let leaves = |spec: &str, settings: &str| {
        let scene = Arc::new(scene(spec));
        let view = scene.default_view(150, 100);
        of_kind(&overlays("sample_based_camera", settings, &scene, &view, 1), OverlayKind::Leaves).clone()
    };
    // A flat mirror shows what one pinhole behind it sees, whatever the accuracy.
    for settings in ["accuracy_px = 0.1", "accuracy_px = 0.1\ncamera = \"pinhole\""] {
        let flat = leaves("planar_mirror?mirrors=1", settings);
        let cameras = flat.pixels.iter().filter(|group| **group == 1).count();
        assert!(cameras > 1000 && flat.pixels.iter().all(|group| *group <= 1), "{settings}: {cameras}");
        assert_eq!(flat.segments, [], "{settings}");
    }
    let [fine, coarse] = ["0.05", "5.0"].map(|accuracy| {
        let settings = format!("beyond_work = \"coarse\"\naccuracy_px = {accuracy}");
        length_of_lines(&leaves("sphere_room?surface=analytic&tess=16", &settings))
    });
    assert!(fine > 2.0 * coarse && fine > 300.0, "{fine} against {coarse}");
}

#[test]
fn layers_are_those_that_the_rays_meet() {
    // A ball between a block and the walls: the nearest layer shows the block alone.
    let scene = Arc::new(scene("sphere_room?tess=16"));
    let view = scene.default_view(90, 60);
    let found = overlays("layered_environment_map", "size = 64", &scene, &view, 1);
    let layers = of_kind(&found, OverlayKind::Layers);
    let truth = traced(&scene, &view);
    let wrong = truth.iter().enumerate().filter(|(pixel, (path, _))| (layers.pixels[*pixel] != 0) == path.is_empty());
    assert!(wrong.count() * 50 <= truth.len());
    assert!(layers.groups.len() >= 2, "{:?}", layers.groups);
    // An object's pixels are in one layer for the most part.
    let mut votes: std::collections::BTreeMap<u32, std::collections::BTreeMap<u16, usize>> = Default::default();
    for (pixel, (path, end)) in truth.iter().enumerate() {
        if let (false, Some(object)) = (path.is_empty(), end) {
            *votes.entry(*object).or_default().entry(layers.pixels[pixel]).or_default() += 1;
        }
    }
    let (most, all) = votes
        .values()
        .fold((0, 0), |(most, all), votes| (most + votes.values().max().unwrap(), all + votes.values().sum::<usize>()));
    assert!(most * 10 >= all * 8, "{most} of {all}: {votes:?}");
}
