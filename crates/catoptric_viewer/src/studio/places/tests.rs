//! Places against closed forms and against each other.

use super::*;
use crate::studio::order::Changes;
use crate::studio::pick::follow;
use catoptric::math::random::Stream;
use catoptric::progress::Silent;
use catoptric_scenes::builtin;

struct Room {
    scene: Arc<Scene>,
    tracer: Tracer,
    wish: Arc<Wish>,
    view: View,
    ready: std::cell::RefCell<ReadyMethods>,
}

fn room(spec: &str) -> Room {
    let scene = Arc::new(builtin::parse(spec).unwrap().pose(&Default::default()).unwrap());
    let tracer = Tracer::build(&scene, |_| true);
    let view = scene.default_view(640, 480);
    let quality = Quality { samples: 4, order: 2 };
    let wish = Wish {
        scene: 1,
        time: 0.0,
        clip: None,
        changes: Changes::default(),
        camera: scene.camera(None, 1.0).unwrap(),
        size: [640, 480],
        sides: vec![Drawn { method: "auto".into(), settings: toml::Table::new(), quality }],
        has_automatic_order: false,
        display: Default::default(),
        compares: false,
        overlays: Vec::new(),
    };
    Room { scene, tracer, wish: Arc::new(wish), view, ready: Default::default() }
}

impl Room {
    /// The path through a pixel and where its end appears; `None` where nothing is mirrored.
    fn places(&self, at: [f32; 2]) -> Option<(Vec<Bounce>, Places)> {
        let path = follow(&self.scene, &self.tracer, &self.view, at, 2);
        let mut search = PlaceSearch::new(1, &self.wish, at, &path, &BTreeMap::new())?;
        let searched = SearchedScene { scene: &self.scene, tracer: &self.tracer };
        let mut last = None;
        while !search.is_over() {
            last = search.step(&searched, &mut self.ready.borrow_mut(), &Mailbox::default());
        }
        Some((path, last?))
    }
}

fn offset(places: &Places, method: &str) -> Option<f32> {
    places.list.iter().find(|place| place.method == method).map(|place| place.offset_px)
}

/// The place on a ball whose mirrored ray has a direction, by halving in the plane of the eye and the direction.
fn place_on_ball(center: DVec3, radius: f64, eye: DVec3, direction: DVec3) -> DVec3 {
    let towards = (eye - center).normalize();
    let across = (direction - towards * direction.dot(towards)).normalize();
    let on_ball = |angle: f64| towards * angle.cos() + across * angle.sin();
    // The mirrored ray turns on with the place; the angle from the eye's axis grows.
    let (mut low, mut high) = (0.0, towards.angle_between(direction));
    for _ in 0..200 {
        let middle = 0.5 * (low + high);
        let normal = on_ball(middle);
        let ray = (center + normal * radius - eye).normalize();
        let mirrored = ray - normal * (2.0 * normal.dot(ray));
        let turned = mirrored.dot(across).atan2(mirrored.dot(towards));
        if turned < towards.angle_between(direction) { low = middle } else { high = middle }
    }
    center + on_ball(0.5 * (low + high)) * radius
}

#[test]
fn environment_maps_show_points_where_a_ball_reflects_their_directions() {
    let room = room("sphere_room?surface=analytic");
    let bounds = room.scene.bounds;
    let mut random = Stream::new(5);
    let (mut seen, mut on_walls, mut largest) = (0, 0, 0.0f32);
    for _ in 0..60 {
        let at = [random.next_between(180.0, 460.0), random.next_between(120.0, 400.0)];
        let Some((path, places)) = room.places(at) else { continue };
        let [first, end] = &path[..] else { continue };
        assert!(places.is_done && places.is_solved, "{at:?}");
        let truth = Vec2::from(places.truth_px);
        assert!(truth.distance(Vec2::from(at)) < 0.05, "{at:?}: {truth}");
        let object = &room.scene.objects[first.object as usize];
        let (center, radius) = (object.bounds.center().as_dvec3(), f64::from(object.bounds.size().x) * 0.5);
        let direction = (end.position.as_dvec3() - center).normalize();
        let on_ball = place_on_ball(center, radius, room.view.eye().as_dvec3(), direction);
        let expected = room.view.pixel_of_exact(on_ball).unwrap().as_vec2();
        let found = places.list.iter().find(|place| place.method == "environment_map").unwrap();
        assert!(Vec2::from(found.position_px).distance(expected) < 0.02, "{at:?}: {found:?}, {expected}");
        assert!((found.offset_px - expected.distance(truth)).abs() < 0.02);
        largest = largest.max(found.offset_px);
        // Walls lie on the box that the map is corrected for: there it is exact.
        let beside = (end.position - bounds.min).min(bounds.max - end.position).min_element();
        if beside < 1e-4 * bounds.diagonal() {
            let boxed = offset(&places, "environment_map (box)").unwrap();
            assert!(boxed < 0.05, "{at:?}: {boxed}");
            on_walls += 1;
        }
        seen += 1;
    }
    assert!(seen > 20 && on_walls > 5 && largest > 5.0, "{seen} {on_walls} {largest}");
}

#[test]
#[expect(clippy::print_stdout, reason = "what was measured is printed")]
fn methods_that_solve_for_points_are_near_the_truth() {
    for spec in ["sphere_room?tess=32", "vase", "planar_mirror?mirrors=1"] {
        let room = room(spec);
        let mut random = Stream::new(7);
        let mut listed: BTreeMap<String, Vec<f32>> = BTreeMap::new();
        let (mut picks, mut waits_ms) = (0, Vec::new());
        for _ in 0..40 {
            let at = [random.next_between(60.0, 580.0), random.next_between(60.0, 420.0)];
            let watch = Stopwatch::new();
            let Some((path, places)) = room.places(at) else { continue };
            if path.len() != 2 {
                continue;
            }
            waits_ms.push(watch.elapsed_ms());
            picks += 1;
            for place in places.list {
                listed.entry(place.method).or_default().push(place.offset_px);
            }
            if picks == 8 {
                break;
            }
        }
        listed.values_mut().for_each(|offsets| offsets.sort_by(f32::total_cmp));
        let later = waits_ms.iter().skip(1).fold(0.0, |most: f64, ms| most.max(*ms));
        println!("{spec}: the first click {:.0} ms, later ones at most {later:.1} ms", waits_ms[0]);
        let middle = |method: &str| listed.get(method).map(|offsets| offsets[offsets.len() / 2]);
        assert!(picks >= 4, "{spec}: {picks}");
        // Each within what its pictures are good for.
        assert!(middle("path_perturbation").is_some_and(|px| px < 0.5), "{spec}");
        assert!(middle("reflector_search").is_some_and(|px| px < 3.0), "{spec}");
        if spec.starts_with("planar") {
            assert!(middle("planar_mirror").is_some_and(|px| px < 0.01), "{spec}");
        }
    }
}

#[test]
fn all_methods_that_project_points_are_asked() {
    let room = room("sphere_room?tess=8");
    let view = room.scene.default_view(64, 48);
    let projects = |id: &str| {
        let method = methods::create(id, &toml::Table::new()).unwrap();
        let quality = Quality { samples: 1, order: 1 };
        let mut prepared = method.prepare(&room.scene, quality, None, &Silent).unwrap();
        prepared.frame(&view, &Silent).unwrap().projector().is_some()
    };
    let family = methods::all().iter().filter(|info| info.family == methods::Family::Projection);
    let projecting: Vec<&str> = family.map(|info| info.id).filter(|id| projects(id)).collect();
    let (mut asked, mut all) = (PROJECTING.to_vec(), projecting);
    asked.sort_unstable();
    all.sort_unstable();
    assert_eq!(asked, all);
}
