//! Drawing of virtual geometry against the reference, with geometry that is exact.

use catoptric::framebuffer::Framebuffer;
use catoptric::methods::projection::draw::{PathGeometry, draw_paths};
use catoptric::methods::projector::SpecularPath;
use catoptric::methods::{Job, Quality};
use catoptric::metrics::{Comparison, PictureError};
use catoptric::optics::path::bundle::{Bounce, BounceKind};
use catoptric::progress::Silent;
use catoptric::raster::DrawTriangle;
use catoptric::scene::model::Primitive;
use catoptric::scene::{Environment, Material, Role, Scene, View};
use catoptric_testkit::drawing::picture;
use catoptric_testkit::scenes::SceneBuilder;
use glam::{DAffine3, DMat3, DVec3, Vec2, Vec3, Vec4};
use std::sync::Arc;

fn drawn(scene: &Scene, view: &View, quality: Quality, paths: Vec<PathGeometry>) -> Framebuffer {
    let mut target = Framebuffer::new(view.width, view.height);
    let job = Job { scene, view, quality, progress: &Silent };
    draw_paths(&job, paths, &mut target).expect("the picture can be drawn");
    assert!(target.pixels.iter().flatten().all(|value| value.is_finite()));
    target
}

fn truth(scene: &Scene, view: &View, quality: Quality) -> Framebuffer {
    picture("reference", "", scene, view, quality)
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

/// A flat mirror: its object and its plane, the normal on the visible side.
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

/// The triangles of the scene that `wanted` lets pass, each cut into `cuts` times `cuts` pieces: the pieces' positions
/// and places in their sources.
fn pieces(scene: &Scene, cuts: u32, wanted: impl Fn(u32) -> bool) -> (Vec<Vec3>, Vec<DrawTriangle>, Vec<[Vec2; 3]>) {
    let (mut positions, mut triangles, mut corners) = (Vec::new(), Vec::new(), Vec::new());
    for source in (0..scene.triangles.len() as u32).filter(|triangle| wanted(*triangle)) {
        let mut add = |places: [[u32; 2]; 3]| {
            let places = places.map(|[b, c]| Vec2::new(b as f32, c as f32) / cuts as f32);
            let first = positions.len() as u32;
            positions.extend(places.map(|place| scene.position_on(source, place)));
            let vertices = [first, first + 1, first + 2];
            triangles.push(DrawTriangle { vertices, source, ..DrawTriangle::default() });
            corners.push(places);
        };
        for b in 0..cuts {
            for c in 0..cuts - b {
                add([[b, c], [b + 1, c], [b, c + 1]]);
                if b + c + 1 < cuts {
                    add([[b + 1, c + 1], [b, c + 1], [b + 1, c]]);
                }
            }
        }
    }
    (positions, triangles, corners)
}

/// The pictures in flat mirrors up to the order: the scene moved to where it appears, cut at the last mirror.
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
                    pieces(scene, 2, |triangle| scene.triangle_objects[triangle as usize] != mirror.object);
                let height = |position: &Vec3| (mirror.normal.dot(position.as_dvec3()) - mirror.offset) as f32;
                all.push(PathGeometry {
                    path: path.clone(),
                    clip_distances: positions.iter().map(height).collect(),
                    vertices: positions.iter().map(|position| picture.apply(*position)).collect(),
                    triangles,
                    corners,
                    ..PathGeometry::default()
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

/// The place of light that goes through the glass slab of [`glass_scene`], met from the front.
#[derive(Clone, Copy, PartialEq)]
enum Side {
    Front,
    Inside,
    Behind,
}

/// A path among the slab's two faces (at `z = 0` and `z = -SLAB`) and the floor (at `y = 0`), all perpendicular or
/// parallel: the floor mirrors, the slab displaces, in any order.
#[derive(Clone)]
struct SlabPath {
    path: SpecularPath,
    side: Side,
    /// 1 towards positive z, -1 towards negative z.
    heading: f64,
    /// The last z at which the slab was met, or the eye's.
    z: f64,
    in_air: f64,
    in_glass: f64,
    on_floor: bool,
}

const SLAB: f64 = 0.6;
const SLAB_INDEX: f64 = 1.5;

impl SlabPath {
    fn longer(&self, object: u32, kind: BounceKind) -> Self {
        let mut longer = self.clone();
        longer.path.bounces.push(Bounce { object, kind });
        longer
    }

    /// The face of the slab that is met next, if any.
    fn face(&self) -> Option<f64> {
        match (self.side, self.heading < 0.0) {
            (Side::Front, true) | (Side::Inside, false) => Some(0.0),
            (Side::Inside, true) => Some(-SLAB),
            _ => None,
        }
    }

    fn children(&self, slab: u32, floor: u32) -> Vec<Self> {
        let mut all = Vec::new();
        if self.side != Side::Inside && !self.on_floor {
            all.push(Self { on_floor: true, ..self.longer(floor, BounceKind::Reflect) });
        }
        let Some(face) = self.face() else { return all };
        let (air, glass) = match self.side {
            Side::Inside => (0.0, SLAB),
            _ => ((face - self.z).abs(), 0.0),
        };
        let at_face = Self { z: face, in_air: self.in_air + air, in_glass: self.in_glass + glass, ..self.clone() };
        all.push(Self { heading: -at_face.heading, ..at_face.longer(slab, BounceKind::Reflect) });
        let side = match (self.side, self.heading < 0.0) {
            (Side::Inside, true) => Side::Behind,
            (Side::Inside, false) => Side::Front,
            _ => Side::Inside,
        };
        all.push(Self { side, ..at_face.longer(slab, BounceKind::Transmit) });
        all
    }

    /// The place at which a scene point appears: the point on the view ray at the path's length.
    fn virtual_point(&self, eye: DVec3, point: DVec3) -> Option<DVec3> {
        let ahead = (point.z - self.z) * self.heading;
        if ahead < 0.0 {
            return None;
        }
        let (mut air, mut glass) = (self.in_air, self.in_glass);
        match self.side {
            Side::Inside => glass += ahead,
            _ => air += ahead,
        }
        let mirrored = if self.on_floor { -point.y } else { point.y };
        let lateral = DVec3::new(point.x - eye.x, mirrored - eye.y, 0.0);
        // Snell's law between parallel faces: bisection for the sine outside.
        let (mut low, mut high) = (0.0f64, 1.0f64);
        let inner = |sine: f64| sine / SLAB_INDEX;
        let tangent = |sine: f64| sine / (1.0 - sine * sine).sqrt();
        for _ in 0..40 {
            let middle = 0.5 * (low + high);
            let reached = air * tangent(middle) + glass * tangent(inner(middle));
            if reached < lateral.length() { low = middle } else { high = middle }
        }
        let cosine = (1.0 - low * low).sqrt();
        let length = air / cosine + glass / (1.0 - inner(low).powi(2)).sqrt();
        let direction = lateral.normalize_or_zero() * low + DVec3::NEG_Z * cosine;
        Some(eye + direction * length)
    }
}

/// The pictures in the slab and the floor of [`glass_scene`] up to the order.
fn through_slab(scene: &Scene, view: &View, order: u32) -> Vec<PathGeometry> {
    let (slab, floor) = (object(scene, "slab"), object(scene, "floor"));
    let eye = view.eye().as_dvec3();
    let start = SlabPath {
        path: SpecularPath::default(),
        side: Side::Front,
        heading: -1.0,
        z: eye.z,
        in_air: 0.0,
        in_glass: 0.0,
        on_floor: false,
    };
    let picture = view.picture_from_world();
    let mut all = Vec::new();
    let mut paths = vec![start];
    for _ in 0..order {
        paths = paths.iter().flat_map(|path| path.children(slab, floor)).collect();
        for path in &paths {
            let wanted = |triangle: u32| {
                let object = scene.triangle_objects[triangle as usize];
                let z = scene.position_on(triangle, Vec2::splat(0.25)).z as f64;
                if object == slab {
                    return path.face().is_some_and(|face| (z - face).abs() < 1e-6);
                }
                let beside = match path.side {
                    Side::Front => z > 0.0,
                    Side::Inside => false,
                    Side::Behind => z < -SLAB,
                };
                beside && (object != floor || !path.on_floor)
            };
            let (positions, mut triangles, corners) = pieces(scene, 12, wanted);
            let places: Vec<_> = positions.iter().map(|p| path.virtual_point(eye, p.as_dvec3())).collect();
            // Points behind the eye have no place on this path: such pieces point nowhere.
            for triangle in &mut triangles {
                if triangle.vertices.iter().any(|&vertex| places[vertex as usize].is_none()) {
                    triangle.vertices = [u32::MAX; 3];
                }
            }
            let height = |position: &Vec3| if path.on_floor { position.y } else { 1.0 };
            all.push(PathGeometry {
                path: path.path.clone(),
                clip_distances: positions.iter().map(height).collect(),
                vertices: places.iter().map(|place| picture.apply(place.unwrap_or(eye).as_vec3())).collect(),
                triangles,
                corners,
                ..PathGeometry::default()
            });
        }
    }
    all
}

/// A slab of tinted, absorbing glass over a coated floor, from both sides.
fn glass_scene() -> Scene {
    let mut builder = SceneBuilder::new();
    let checker = builder.checker("checker", 6, [40, 60, 90], [230, 220, 200]);
    let plain = builder.material(Material::diffuse("plain", Vec3::new(0.7, 0.6, 0.5)));
    let coated =
        builder.material(Material { role: Role::Coated, coat: 1.0, ..Material::diffuse("coated", Vec3::splat(0.4)) });
    let glass = builder.material(Material {
        absorption: Vec3::new(0.9, 0.2, 0.4),
        base_color: Vec4::new(0.95, 0.98, 0.97, 1.0),
        ..Material::glass("glass", SLAB_INDEX as f32)
    });
    let (mut positions, mut normals) = (Vec::new(), Vec::new());
    for (z, normal) in [(0.0, Vec3::Z), (-SLAB as f32, Vec3::NEG_Z)] {
        positions.extend([(-9.0, -6.0), (9.0, -6.0), (9.0, 6.0), (-9.0, 6.0)].map(|(x, y)| Vec3::new(x, y, z)));
        normals.extend([normal; 4]);
    }
    let triangles = vec![[0, 1, 2], [0, 2, 3], [4, 6, 5], [4, 7, 6]];
    builder.primitive("slab", Primitive { positions, normals, triangles, material: glass, ..Primitive::default() });
    let floor = [(0.01f32, 6.0f32), (-5.0, -SLAB as f32 - 0.01)];
    let corners = floor.map(|(far, near)| [(-3.0, near), (3.0, near), (3.0, far), (-3.0, far)]);
    let positions = corners.concat().into_iter().map(|(x, z)| Vec3::new(x, 0.0, z)).collect();
    builder.primitive(
        "floor",
        Primitive {
            positions,
            normals: vec![Vec3::Y; 8],
            triangles: vec![[0, 1, 2], [0, 2, 3], [4, 5, 6], [4, 6, 7]],
            material: coated,
            ..Primitive::default()
        },
    );
    builder.quad("back", Vec3::new(-3.0, 0.0, -4.0), Vec3::X * 5.0, Vec3::Y * 1.8, checker);
    builder.quad("rear", Vec3::new(3.0, 0.0, 6.0), Vec3::NEG_X * 6.0, Vec3::Y * 2.5, checker);
    builder.cuboid("block", Vec3::new(0.2, 0.1, -2.0), Vec3::new(1.0, 1.0, -1.3), false, plain);
    builder.cuboid("near block", Vec3::new(-1.5, 0.1, 0.8), Vec3::new(-0.9, 0.9, 1.4), false, checker);
    builder.camera(Vec3::new(0.3, 1.1, 3.5), Vec3::new(-0.1, 0.6, 0.0), 50.0);
    builder.build()
}

#[test]
fn glass_shows_what_it_reflects_and_what_it_refracts() {
    let mut scene = glass_scene();
    for lit_by_sky in [true, false] {
        scene.environment = lit_by_sky.then(sky);
        let view = scene.default_view(150, 100);
        for (order, samples) in [(1, 4), (2, 8), (2, 16), (3, 1), (4, 1)] {
            let quality = Quality { samples, order };
            let paths = through_slab(&scene, &view, order);
            let error = error(&drawn(&scene, &view, quality, paths), &truth(&scene, &view, quality));
            // Straight pieces stand for bent ones. Sixteen samples are shaded at once at edges, seams among them.
            let (share_allowed, flip_allowed) = if samples == 16 { (2e-3, 2e-2) } else { (1e-3, 6e-3) };
            assert!(error.over_0_1 <= share_allowed, "order {order}, {samples} samples: {error:?}");
            assert!(error.flip_mean < flip_allowed, "order {order}, {samples} samples: {error:?}");
        }
    }
}

#[test]
fn where_nothing_is_drawn_the_environment_is_seen() {
    // Convex bodies in the sky: a coarse mesh, whose shading normals turn away from the view at its outline, and a
    // sphere by its formula.
    for material in [
        Material::mirror("mirror", Vec3::new(0.9, 0.8, 0.7)),
        Material { schlick: true, ..Material::mirror("metal", Vec3::new(0.9, 0.5, 0.2)) },
        Material { role: Role::Coated, coat: 0.8, ..Material::diffuse("coated", Vec3::splat(0.5)) },
    ] {
        for mesh in [true, false] {
            let mut builder = SceneBuilder::new();
            let material = builder.material(material.clone());
            match mesh {
                true => builder.sphere_mesh("ball", Vec3::ZERO, 1.0, 6, material),
                false => builder.sphere("ball", Vec3::ZERO, 1.0, material),
            }
            builder.camera(Vec3::new(0.0, 1.0, 4.0), Vec3::ZERO, 40.0);
            let mut scene = builder.build();
            scene.environment = Some(sky());
            let view = scene.default_view(120, 80);
            let quality = Quality { samples: 1, order: 1 };
            let (drawn, truth) = (drawn(&scene, &view, quality, Vec::new()), truth(&scene, &view, quality));
            let error = error(&drawn, &truth);
            // The outline of the sphere is that of its triangles.
            assert!(error.over_0_1 <= if mesh { 0.0 } else { 2e-3 }, "{error:?}");
            assert!(error.flip_mean < 2e-3, "{error:?}");
        }
    }
}

#[test]
fn both_branches_at_a_surface_before_empty_space() {
    // A sheet of glass in the sky, viewed straight on, has the weights of Fresnel's equations alone.
    let mut builder = SceneBuilder::new();
    let glass = builder.material(Material::glass("glass", 1.5));
    builder.quad("sheet", Vec3::new(-9.0, -9.0, 0.0), Vec3::X * 18.0, Vec3::Y * 18.0, glass);
    builder.camera(Vec3::new(0.0, 0.0, 4.0), Vec3::ZERO, 2.0);
    let mut scene = builder.build();
    scene.environment = Some(sky());
    let view = scene.default_view(3, 3);
    let pixel = drawn(&scene, &view, Quality { samples: 4, order: 2 }, Vec::new()).pixel(1, 1);
    let expected = scene.background(Vec3::Z) * 0.04 + scene.background(Vec3::NEG_Z) * 0.96;
    assert!((Vec4::from(pixel).truncate() - expected).length() < 1e-3, "{pixel:?} against {expected}");
}

#[test]
fn paths_that_light_cannot_take_are_not_drawn() {
    let scene = hall().build();
    let view = scene.default_view(60, 40);
    let quality = Quality { samples: 1, order: 2 };
    let sound = mirrored(&scene, &view, &mirrors(&scene), 2);
    let expected = drawn(&scene, &view, quality, sound.clone());
    let (block, left) = (object(&scene, "block"), object(&scene, "left"));
    let reflect = |object| Bounce { object, kind: BounceKind::Reflect };
    let mut paths = sound.clone();
    let wrong = [
        vec![],
        vec![reflect(block)],
        vec![reflect(u32::MAX)],
        vec![Bounce { object: left, kind: BounceKind::Transmit }],
        vec![reflect(left), reflect(left), reflect(left)],
    ];
    for bounces in wrong {
        paths.push(PathGeometry { path: SpecularPath { bounces }, ..sound[0].clone() });
    }
    // Triangles of no scene, and vertices that are not there, in a part of a path of its own.
    let mut broken = sound[1].clone();
    for (index, triangle) in broken.triangles.iter_mut().enumerate() {
        match index % 2 {
            0 => triangle.source = u32::MAX - 1,
            _ => triangle.vertices[1] = 1 << 30,
        }
    }
    paths.push(broken);
    paths.rotate_left(3);
    assert_eq!(drawn(&scene, &view, quality, paths).pixels, expected.pixels);
}

#[test]
fn pictures_without_glass_are_drawn_once() {
    let scene = hall().build();
    let view = scene.default_view(60, 40);
    let quality = Quality { samples: 1, order: 3 };
    let mut target = Framebuffer::new(60, 40);
    let job = Job { scene: &scene, view: &view, quality, progress: &Silent };
    let report = draw_paths(&job, mirrored(&scene, &view, &mirrors(&scene), 3), &mut target).expect("it can be drawn");
    assert_eq!(report.fragments, 60 * 40);
}
