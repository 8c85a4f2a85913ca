//! The exact search on round trips: points that view rays show in one reflector appear where the rays came from.

use catoptric::light::tracer::Tracer;
use catoptric::math::random::Stream;
use catoptric::methods::path_query::PathSearch;
use catoptric::methods::projection::find::exact_search::{ExactSearch, SearchSettings};
use catoptric::optics::path::manifold::{ManifoldVertex, SpecularSurfaces};
use catoptric::progress::Silent;
use catoptric::scene::model::{AnalyticAsset, LocalTransform, MeshAsset, Model, Node, Primitive};
use catoptric::scene::{Material, Ray, Scene};
use catoptric::surface::{AnalyticSurface, Ellipsoid, Implicit, Revolution, Torus};
use glam::{DVec3, Quat, Vec3};

/// The region from which eyes are drawn.
#[derive(Clone, Copy)]
enum Eyes {
    /// Up to three sizes of the reflector's box from its middle, in all directions.
    Around,
    /// The inner half of the box.
    Inside,
}

fn node(name: &str) -> Node {
    let rotation = Quat::from_euler(glam::EulerRot::XYZ, 0.4, -0.9, 1.3).as_dquat();
    Node {
        name: name.into(),
        local: LocalTransform::Rigid { translation: DVec3::new(0.3, -0.2, 0.5), rotation },
        ..Node::default()
    }
}

fn posed(model: &Model) -> Scene {
    model.pose(&Default::default()).expect("the test's input is valid")
}

fn of_formula(surface: AnalyticSurface, inside: bool) -> Scene {
    let mut model = Model { materials: vec![Material::mirror("chrome", Vec3::ONE)], ..Model::default() };
    model.nodes.push(Node { analytic: Some(AnalyticAsset { surface, material: 0, inside }), ..node("formula") });
    posed(&model)
}

fn of_mesh(surface: &AnalyticSurface) -> Scene {
    let mesh = surface.tessellate();
    let mut model = Model { materials: vec![Material::mirror("chrome", Vec3::ONE)], ..Model::default() };
    let (positions, normals, triangles) = (mesh.positions, mesh.normals, mesh.triangles);
    let primitive = Primitive { positions, normals, triangles, ..Primitive::default() };
    model.meshes.push(MeshAsset { primitives: vec![primitive], ..MeshAsset::default() });
    model.nodes.push(Node { mesh: Some(0), ..node("mesh") });
    posed(&model)
}

fn implicit(text: &str, half: [f64; 3]) -> AnalyticSurface {
    AnalyticSurface::Implicit(Implicit::new(text, half.map(|h| -h), half).expect("the test's input is valid"))
}

/// The reflectors, and where their eyes are.
fn reflectors() -> Vec<(&'static str, Scene, Eyes)> {
    let vase = AnalyticSurface::Revolution(
        Revolution::new(2.0, [5.80, -9.78, 3.90, 0.47]).expect("the test's input is valid"),
    );
    let ellipsoid = AnalyticSurface::Ellipsoid(Ellipsoid::new([1.2, 0.7, 0.4]).expect("the test's input is valid"));
    let torus = AnalyticSurface::Torus(Torus::new(0.8, 0.3).expect("the test's input is valid"));
    let blob = implicit("x^4 + y^4 + z^4 - x^2 - y^2 - z^2 + 0.4", [1.1; 3]);
    let gyroid = implicit("sin(4*x)*cos(4*y) + sin(4*y)*cos(4*z) + sin(4*z)*cos(4*x) - 0.2", [0.7, 0.6, 0.8]);
    vec![
        ("mesh", of_mesh(&torus), Eyes::Around),
        ("vase", of_formula(vase, false), Eyes::Around),
        ("blob", of_formula(blob, false), Eyes::Around),
        ("gyroid", of_formula(gyroid, false), Eyes::Around),
        ("ellipsoid", of_formula(ellipsoid, true), Eyes::Inside),
        ("torus", of_formula(torus, false), Eyes::Around),
    ]
}

fn vector(random: &mut Stream) -> DVec3 {
    DVec3::from_array(std::array::from_fn(|_| f64::from(random.next_between(-1.0, 1.0))))
}

/// The counts of round trips.
#[derive(Clone, Copy, Debug, Default)]
struct Trips {
    asked: usize,
    missed: usize,
    cut_short: usize,
}

/// A ray that leaves the reflector after a view ray's bounce: its bounce, and a point that it shows.
fn shown(
    scene: &Scene,
    tracer: &Tracer,
    surfaces: &SpecularSurfaces<'_>,
    ray: &Ray,
    random: &mut Stream,
) -> Option<(ManifoldVertex, DVec3)> {
    let hit = tracer.first_hit(scene, ray, 0.0)?;
    let (object, site) = surfaces.site_of(ray, &hit)?;
    let frame = surfaces.frame(object, &site)?;
    let incoming = (site.position - ray.origin.as_dvec3()).normalize();
    let outgoing = incoming - frame.normal * (2.0 * incoming.dot(frame.normal));
    let (before, after) = (-incoming.dot(frame.geometric_normal()), outgoing.dot(frame.geometric_normal()));
    if before * after <= 0.0 || (scene.objects[object as usize].inside && before > 0.0) {
        return None;
    }
    let size = f64::from(scene.bounds.diagonal());
    let departure = site.position + frame.geometric_normal() * (4e-6 * size).copysign(after);
    let next = Ray { origin: departure.as_vec3(), direction: outgoing.as_vec3() };
    let free = tracer.first_hit(scene, &next, 0.0).map_or(f64::INFINITY, |hit| f64::from(hit.distance()));
    let distance = free.min(1.5 * size) * f64::from(random.next_between(0.02, 0.98));
    (free > 1e-3 * size).then_some((site, site.position + outgoing * distance))
}

fn round_trips(
    name: &str,
    scene: &Scene,
    eyes: Eyes,
    [eye_count, ray_count]: [usize; 2],
    settings: &SearchSettings,
) -> Trips {
    let object = scene.specular_objects()[0];
    let bounds = scene.objects[object as usize].bounds;
    let (center, half) = (bounds.center().as_dvec3(), (bounds.max - bounds.min).as_dvec3() * 0.5);
    let (tracer, surfaces) = (Tracer::build(scene, |_| true), SpecularSurfaces::new(scene));
    let same = 1e-6 * f64::from(scene.bounds.diagonal());
    let mut random = Stream::new(23);
    let mut trips = Trips::default();
    let mut found = Vec::new();
    for _ in 0..eye_count {
        let eye = match eyes {
            Eyes::Around => center + vector(&mut random) * half.length() * 3.0,
            Eyes::Inside => center + vector(&mut random) * half * 0.5,
        };
        let eye = eye.as_vec3();
        let search = ExactSearch::new(scene, eye.as_dvec3(), 1, &[object], settings, &Silent)
            .expect("the test's input is valid");
        for _ in 0..ray_count {
            let target = center + vector(&mut random) * half;
            let direction = match eyes {
                Eyes::Around => target - eye.as_dvec3(),
                Eyes::Inside => vector(&mut random),
            };
            let ray = Ray { origin: eye, direction: direction.normalize().as_vec3() };
            let Some((site, point)) = shown(scene, &tracer, &surfaces, &ray, &mut random) else { continue };
            found.clear();
            let outcome = search.search(point, &mut found);
            trips.asked += 1;
            if !found.iter().any(|path| path.bounce_points[0].distance(site.position) < same) {
                trips.missed += 1;
                trips.cut_short += usize::from(outcome.cut_short);
                eprintln!("{name}: missed {} of {point} from {eye}: {outcome:?}", site.position);
            }
        }
    }
    trips
}

/// Checks that at most two in a thousand appearances are missed on each surface.
fn check(counts: [usize; 2]) {
    for (name, scene, eyes) in reflectors() {
        let started = std::time::Instant::now();
        let trips = round_trips(name, &scene, eyes, counts, &SearchSettings::default());
        eprintln!("{name}: {trips:?} in {:.1?}", started.elapsed());
        assert!(trips.asked * 4 > counts[0] * counts[1], "{name}: {trips:?}");
        assert!(trips.missed * 1000 <= 2 * trips.asked, "{name}: {trips:?}");
    }
}

#[test]
fn what_view_rays_show_is_found() {
    check([1, 250]);
}

#[test]
#[ignore = "thousands of rays to each surface: run it with --release"]
fn what_view_rays_show_is_found_for_many_eyes() {
    check([8, 1000]);
}
