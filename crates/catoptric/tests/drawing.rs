//! Drawing of virtual geometry against the reference, with geometry that is exact.

use catoptric::framebuffer::Framebuffer;
use catoptric::methods::projection::SpecularPath;
use catoptric::methods::projection::drawing::{PathGeometry, draw_paths};
use catoptric::methods::{self, Job, Quality};
use catoptric::metrics::{Comparison, PictureError};
use catoptric::optics::bundle::{Bounce, BounceKind};
use catoptric::progress::Silent;
use catoptric::raster::DrawTriangle;
use catoptric::scene::{Environment, Material, Role, Scene, View};
use catoptric_testkit::scenes::SceneBuilder;
use glam::{DAffine3, DMat3, DVec3, Vec2, Vec3};
use std::sync::Arc;

fn drawn(scene: &Scene, view: &View, quality: Quality, paths: Vec<PathGeometry>) -> Framebuffer {
    let mut target = Framebuffer::new(view.width, view.height);
    let job = Job { scene, view, quality, progress: &Silent };
    draw_paths(&job, paths, &mut target).expect("the picture can be drawn");
    assert!(target.pixels.iter().flatten().all(|value| value.is_finite()));
    target
}

fn truth(scene: &Scene, view: &View, quality: Quality) -> Framebuffer {
    let mut target = Framebuffer::new(view.width, view.height);
    let mut method = methods::create("reference", &toml::Table::new()).expect("it exists");
    method.prepare(scene, quality, &Silent).expect("the scene is sound");
    method.render(&Job { scene, view, quality, progress: &Silent }, &mut target).expect("the picture can be drawn");
    target
}

fn error(drawn: &Framebuffer, truth: &Framebuffer) -> PictureError {
    Comparison::new(drawn, truth).expect("sizes are equal").whole().expect("there are pixels")
}

/// A sky of smooth colours.
fn sky() -> Arc<Environment> {
    let (width, height) = (256, 128);
    let texel = |i: u32| {
        let d = Environment::direction((i % width) as f32 / width as f32, (i / width) as f32 / height as f32);
        ((d + 1.0) * 0.5).to_array()
    };
    Arc::new(Environment::new("sky", width, height, (0..width * height).map(texel).collect()))
}

fn object(scene: &Scene, name: &str) -> u32 {
    scene.objects.iter().position(|object| object.name == name).expect("the object exists") as u32
}

/// A flat mirror: its object and its plane, the normal on the side that is seen.
struct Mirror {
    object: u32,
    normal: DVec3,
    offset: f64,
}

impl Mirror {
    fn new(scene: &Scene, name: &str) -> Self {
        let object = object(scene, name);
        let vertex = scene.objects[object as usize].vertices.start as usize;
        let normal = scene.normals[vertex].as_dvec3();
        Self { object, normal, offset: normal.dot(scene.positions[vertex].as_dvec3()) }
    }

    fn reflection(&self) -> DAffine3 {
        let n = self.normal;
        let matrix = DMat3::IDENTITY - 2.0 * DMat3::from_cols(n * n.x, n * n.y, n * n.z);
        DAffine3 { matrix3: matrix, translation: n * (2.0 * self.offset) }
    }
}

/// The triangles of the scene that `wanted` lets pass, each cut into four pieces: positions and corners of pieces.
fn pieces(scene: &Scene, wanted: impl Fn(u32) -> bool) -> (Vec<Vec3>, Vec<DrawTriangle>, Vec<[Vec2; 3]>) {
    let (mut positions, mut triangles, mut corners) = (Vec::new(), Vec::new(), Vec::new());
    let places = [Vec2::ZERO, Vec2::X, Vec2::Y, Vec2::new(0.5, 0.0), Vec2::new(0.5, 0.5), Vec2::new(0.0, 0.5)];
    for source in (0..scene.triangles.len() as u32).filter(|triangle| wanted(*triangle)) {
        let first = positions.len() as u32;
        positions.extend(places.map(|place| scene.position_on(source, place)));
        for piece in [[0, 3, 5], [3, 1, 4], [5, 4, 2], [3, 4, 5]] {
            let vertices = piece.map(|corner| first + corner);
            triangles.push(DrawTriangle { vertices, source, ..DrawTriangle::default() });
            corners.push(piece.map(|corner| places[corner as usize]));
        }
    }
    (positions, triangles, corners)
}

/// What is seen in flat mirrors up to the order: the scene moved to where it appears, cut at the last mirror.
fn mirrored(scene: &Scene, view: &View, mirrors: &[Mirror], order: u32) -> Vec<PathGeometry> {
    let mut all = Vec::new();
    let mut paths = vec![(SpecularPath::default(), DAffine3::IDENTITY)];
    for _ in 0..order {
        let mut longer = Vec::new();
        for (path, world_from_scene) in &paths {
            for mirror in mirrors.iter() {
                if path.bounces.last().is_some_and(|last| last.object == mirror.object) {
                    continue;
                }
                let mut path = path.clone();
                path.bounces.push(Bounce { object: mirror.object, kind: BounceKind::Reflect });
                let world_from_scene = *world_from_scene * mirror.reflection();
                let picture = view.picture_from_moved(&world_from_scene);
                let (positions, triangles, corners) =
                    pieces(scene, |triangle| scene.triangle_objects[triangle as usize] != mirror.object);
                let height = |position: &Vec3| (mirror.normal.dot(position.as_dvec3()) - mirror.offset) as f32;
                all.push(PathGeometry {
                    path: path.clone(),
                    clip_distances: positions.iter().map(height).collect(),
                    vertices: positions.iter().map(|position| picture.apply(*position)).collect(),
                    triangles,
                    corners,
                });
                longer.push((path, world_from_scene));
            }
        }
        paths = longer;
    }
    all
}

/// Two mirrors that face each other over a coated floor, with a ball and a block between, open to the sky.
fn hall() -> SceneBuilder {
    let mut builder = SceneBuilder::new();
    let checker = builder.checker("checker", 5, [40, 60, 90], [230, 220, 200]);
    let floor = builder.material(Material {
        role: Role::Coated,
        coat: 1.0,
        unlit: false,
        ..Material::diffuse("floor", Vec3::new(0.5, 0.3, 0.2))
    });
    let silver = builder.material(Material::mirror("silver", Vec3::new(0.9, 0.95, 0.9)));
    let metal = builder.material(Material { schlick: true, ..Material::mirror("metal", Vec3::new(0.9, 0.6, 0.3)) });
    let plain = builder.material(Material::diffuse("plain", Vec3::new(0.7, 0.6, 0.5)));
    builder.quad("floor", Vec3::new(-2.0, 0.0, 2.0), Vec3::X * 4.0, Vec3::NEG_Z * 5.0, floor);
    builder.quad("left", Vec3::new(-1.9, 0.1, 1.0), Vec3::NEG_Z * 3.5, Vec3::Y * 2.0, silver);
    builder.quad("right", Vec3::new(1.9, 0.1, -2.0), Vec3::new(0.3, 0.0, 3.0), Vec3::Y * 2.0, metal);
    builder.quad("back", Vec3::new(-2.0, 0.0, -3.0), Vec3::X * 4.0, Vec3::Y * 1.5, checker);
    builder.cuboid("block", Vec3::new(0.2, 0.0, -1.5), Vec3::new(0.9, 0.8, -0.8), false, checker);
    builder.sphere_mesh("ball", Vec3::new(-0.7, 0.6, -0.6), 0.5, 16, plain);
    builder.camera(Vec3::new(0.4, 1.3, 3.2), Vec3::new(0.0, 0.6, -1.0), 50.0);
    builder
}

fn mirrors(scene: &Scene) -> Vec<Mirror> {
    ["floor", "left", "right"].map(|name| Mirror::new(scene, name)).into()
}

#[test]
fn flat_mirrors_are_those_of_the_reference() {
    let mut scene = hall().build();
    // Without a light a headlight travels along the true path, not along the view ray.
    for lit_by_sky in [false, true] {
        scene.environment = lit_by_sky.then(sky);
        let view = scene.default_view(240, 160);
        for (order, samples) in [(0, 1), (1, 1), (2, 4), (3, 1), (2, 16)] {
            let quality = Quality { samples, order };
            let paths = mirrored(&scene, &view, &mirrors(&scene), order);
            let error = error(&drawn(&scene, &view, quality, paths), &truth(&scene, &view, quality));
            // Sixteen samples of a surface are shaded at once at edges; that shows a little without mirrors, too.
            let flip_allowed = if samples == 16 { 1e-2 } else { 1e-3 };
            assert!(error.over_0_1 <= 1e-3, "order {order}, {samples} samples: {error:?}");
            assert!(error.flip_mean < flip_allowed, "order {order}, {samples} samples: {error:?}");
        }
    }
}
