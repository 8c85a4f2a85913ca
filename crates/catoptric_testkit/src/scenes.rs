//! Small scenes whose pictures have a closed form.

use catoptric::math::random::Stream;
use catoptric::scene::model::{AnalyticAsset, LocalTransform, MeshAsset, Model, Node, Primitive};
use catoptric::scene::{Camera, Material, Object, PoseOptions, Sampler, Scene, Texture};
use catoptric::surface::{AnalyticSurface, PlacedSurface};
use glam::{Affine3A, DVec3, Mat4, Quat, Vec2, Vec3};
use std::sync::Arc;

/// Collects parts of a scene.
#[derive(Default)]
pub struct SceneBuilder {
    model: Model,
    camera: Option<Camera>,
}

impl SceneBuilder {
    /// An empty scene.
    pub fn new() -> Self {
        Self { model: Model { name: "test scene".into(), ..Model::default() }, camera: None }
    }

    /// Adds a material and returns its index.
    pub fn material(&mut self, material: Material) -> usize {
        self.model.materials.push(material);
        self.model.materials.len() - 1
    }

    /// An unlit material of one colour.
    pub fn flat(&mut self, name: &str, color: Vec3) -> usize {
        self.material(Material { unlit: true, ..Material::diffuse(name, color) })
    }

    /// An unlit checker of `cells` times `cells` squares over texture coordinates 0..1.
    pub fn checker(&mut self, name: &str, cells: u32, dark: [u8; 3], light: [u8; 3]) -> usize {
        let size = 256;
        let texel = |i: u32| {
            let (column, row) = (i % size * cells / size, i / size * cells / size);
            let [r, g, b] = if (column + row) % 2 == 0 { dark } else { light };
            [r, g, b, 255]
        };
        let texels: Vec<[u8; 4]> = (0..size * size).map(texel).collect();
        let texture = Texture::from_srgb8(name, size, size, &texels, Sampler::default());
        self.model.textures.push(Arc::new(texture));
        let binding = catoptric::scene::TextureBinding {
            texture: self.model.textures.len() as u32 - 1,
            uv_channel: 0,
            texture_from_uv: glam::Affine2::IDENTITY,
        };
        self.material(Material { unlit: true, base_texture: Some(binding), ..Material::diffuse(name, Vec3::ONE) })
    }

    /// A parallelogram from `corner` along `u` and `v`; its outer side is `u x v`.
    pub fn quad(&mut self, name: &str, corner: Vec3, u: Vec3, v: Vec3, material: usize) {
        let normal = u.cross(v).normalize();
        self.primitive(
            name,
            Primitive {
                positions: vec![corner, corner + u, corner + u + v, corner + v],
                normals: vec![normal; 4],
                uvs: [vec![Vec2::ZERO, Vec2::X, Vec2::ONE, Vec2::Y], Vec::new()],
                triangles: vec![[0, 1, 2], [0, 2, 3]],
                material,
                ..Primitive::default()
            },
        );
    }

    /// The six faces of a box, outwards, or inwards for a room.
    pub fn cuboid(&mut self, name: &str, min: Vec3, max: Vec3, inwards: bool, material: usize) {
        let size = max - min;
        let (x, y, z) = (Vec3::X * size.x, Vec3::Y * size.y, Vec3::Z * size.z);
        for (corner, u, v) in [(min, y, x), (min + z, x, y), (min, x, z), (min + y, z, x), (min, z, y), (min + x, y, z)]
        {
            let (u, v) = if inwards { (v, u) } else { (u, v) };
            self.quad(name, corner, u, v, material);
        }
    }

    /// Any triangles.
    pub fn primitive(&mut self, name: &str, primitive: Primitive) {
        self.model.meshes.push(MeshAsset { name: name.into(), primitives: vec![primitive], ..MeshAsset::default() });
        let mesh = Some(self.model.meshes.len() - 1);
        self.model.nodes.push(Node { name: name.into(), mesh, ..Node::default() });
    }

    /// A sphere, given by its formula.
    pub fn sphere(&mut self, name: &str, center: Vec3, radius: f32, material: usize) {
        let surface = AnalyticSurface::Sphere { radius: radius.into() };
        self.analytic(name, Affine3A::from_translation(center), surface, material, false);
    }

    /// Any analytic surface.
    pub fn analytic(&mut self, name: &str, place: Affine3A, surface: AnalyticSurface, material: usize, inside: bool) {
        let (_, rotation, translation) = place.to_scale_rotation_translation();
        let local = LocalTransform::Parts { translation, rotation, scale: Vec3::ONE };
        let analytic = Some(AnalyticAsset { surface, material, inside });
        self.model.nodes.push(Node { name: name.into(), local, analytic, ..Node::default() });
    }

    /// A sphere of triangles with exact normals.
    pub fn sphere_mesh(&mut self, name: &str, center: Vec3, radius: f32, rings: u32, material: usize) {
        let segments = rings * 2;
        let mut primitive = Primitive { material, ..Primitive::default() };
        for ring in 0..=rings {
            for segment in 0..=segments {
                let polar = ring as f32 / rings as f32 * std::f32::consts::PI;
                let azimuth = (segment % segments) as f32 / segments as f32 * std::f32::consts::TAU;
                let normal = Quat::from_rotation_y(-azimuth) * Vec3::new(polar.sin(), polar.cos(), 0.0);
                primitive.positions.push(center + normal * radius);
                primitive.normals.push(normal);
            }
        }
        for ring in 0..rings {
            for segment in 0..segments {
                let a = ring * (segments + 1) + segment;
                let (b, c, d) = (a + 1, a + segments + 2, a + segments + 1);
                primitive.triangles.extend([[a, b, c], [a, c, d]]);
            }
        }
        self.primitive(name, primitive);
    }

    /// The model as it is.
    pub fn model_mut(&mut self) -> &mut Model {
        &mut self.model
    }

    /// A camera.
    pub fn camera(&mut self, eye: Vec3, target: Vec3, fov_deg: f32) {
        self.camera = Some(Camera::look_at("camera", eye, target, Vec3::Y, fov_deg));
    }

    /// The finished scene.
    pub fn build(self) -> Scene {
        let mut scene = self.model.pose(&PoseOptions::default()).expect("test scenes are valid");
        scene.cameras.extend(self.camera);
        scene
    }
}

/// A node's place a step further, in its parent's space.
pub fn moved(local: &LocalTransform, step: Vec3) -> LocalTransform {
    match *local {
        LocalTransform::Matrix(matrix) => LocalTransform::Matrix(Mat4::from_translation(step) * matrix),
        LocalTransform::Parts { translation, rotation, scale } => {
            LocalTransform::Parts { translation: translation + step, rotation, scale }
        }
        LocalTransform::Rigid { translation, rotation } => {
            LocalTransform::Rigid { translation: translation + step.as_dvec3(), rotation }
        }
    }
}

/// A mirror sphere (analytic, or of triangles) in a checkered room with boxes near it.
pub fn sphere_in_room(analytic: bool) -> Scene {
    let mut builder = SceneBuilder::new();
    let walls = builder.checker("walls", 8, [60, 70, 120], [200, 205, 215]);
    builder.cuboid("room", Vec3::new(-3.0, 0.0, -3.0), Vec3::new(3.0, 3.0, 3.0), true, walls);
    let red = builder.checker("red", 4, [200, 30, 20], [240, 190, 60]);
    builder.cuboid("box", Vec3::new(0.9, 0.0, 0.3), Vec3::new(1.4, 0.8, 0.8), false, red);
    let green = builder.checker("green", 4, [20, 140, 40], [230, 240, 230]);
    builder.cuboid("column", Vec3::new(-1.5, 0.0, 0.2), Vec3::new(-1.2, 2.0, 0.5), false, green);
    let mirror = builder.material(Material::mirror("mirror", Vec3::splat(0.95)));
    let center = Vec3::new(0.0, 1.0, -0.5);
    if analytic {
        builder.sphere("ball", center, 0.7, mirror);
    } else {
        builder.sphere_mesh("ball", center, 0.7, 64, mirror);
    }
    builder.camera(Vec3::new(0.3, 1.4, 2.6), Vec3::new(0.0, 1.0, -0.5), 50.0);
    builder.build()
}

/// [`sphere_in_room`], and eyes within the sphere, on it and just before it, with what they look at.
pub fn eyes_within_and_on_a_sphere() -> (Scene, [(Vec3, Vec3); 4]) {
    let center = Vec3::new(0.0, 1.0, -0.5);
    let eyes = [
        (center, Vec3::Z * 3.0),
        (center + Vec3::Z * 0.5, center),
        (center + Vec3::Z * 0.7, Vec3::Z * 3.0),
        (center + Vec3::Z * 0.700_01, center),
    ];
    (sphere_in_room(true), eyes)
}

/// A room with a ball and a speck of a mirror, among points and lines, some of them mirrors, too; and eyes with what
/// they look at.
pub fn things_without_size() -> (Scene, [(Vec3, Vec3); 2]) {
    let mut builder = SceneBuilder::new();
    let grey = builder.flat("grey", Vec3::splat(0.5));
    builder.cuboid("room", Vec3::splat(-3.0), Vec3::splat(3.0), true, grey);
    builder.quad("point", Vec3::new(0.5, 0.5, 0.5), Vec3::ZERO, Vec3::ZERO, grey);
    builder.quad("line", Vec3::new(-0.5, 0.5, 0.5), Vec3::X, Vec3::ZERO, grey);
    let mirror = builder.material(Material::mirror("mirror", Vec3::ONE));
    builder.sphere("ball", Vec3::ZERO, 0.3, mirror);
    builder.sphere("speck", Vec3::new(0.7, 0.0, 0.0), 1e-6, mirror);
    builder.sphere("crumb", Vec3::new(-0.5, 0.0, 0.3), 0.02, mirror);
    builder.quad("mirror point", Vec3::new(0.0, 0.8, 0.0), Vec3::ZERO, Vec3::ZERO, mirror);
    builder.quad("mirror line", Vec3::new(0.0, -0.8, 0.0), Vec3::X, Vec3::X, mirror);
    let eye = Vec3::new(0.0, 0.5, 2.0);
    (builder.build(), [(eye, Vec3::ZERO), (eye, Vec3::new(0.7, 0.0, 0.0))])
}

impl SceneBuilder {
    /// An unlit parallelogram whose colour encodes the position: (share along `u`, share along `v`, 1).
    pub fn ruler(&mut self, name: &str, corner: Vec3, u: Vec3, v: Vec3) {
        let material = self.flat(name, Vec3::ONE);
        self.primitive(
            name,
            Primitive {
                positions: vec![corner, corner + u, corner + u + v, corner + v],
                normals: vec![u.cross(v).normalize(); 4],
                colors: vec![[0.0, 0.0, 1.0, 1.0], [1.0, 0.0, 1.0, 1.0], [1.0, 1.0, 1.0, 1.0], [0.0, 1.0, 1.0, 1.0]],
                triangles: vec![[0, 1, 2], [0, 2, 3]],
                material,
                ..Primitive::default()
            },
        );
    }
}

/// A scene of analytic surfaces with their materials.
pub fn scene_of(surfaces: &[(AnalyticSurface, Affine3A, Material)]) -> Scene {
    let mut scene = Scene::default();
    for (surface, place, material) in surfaces {
        let placed = PlacedSurface { surface: surface.clone(), world_from_surface: place.as_daffine3() };
        scene.objects.push(Object {
            name: String::new(),
            material: scene.materials.len() as u32,
            triangles: 0..0,
            vertices: 0..0,
            bounds: placed.bounds(),
            surface: Some(placed),
            inside: false,
        });
        scene.materials.push(material.clone());
    }
    scene
}

/// A vector at random within the unit ball, not near its middle.
pub fn random_vector(random: &mut Stream) -> DVec3 {
    loop {
        let mut next = || random.next_between(-1.0, 1.0) as f64;
        let vector = DVec3::new(next(), next(), next());
        if (0.01..1.0).contains(&vector.length_squared()) {
            return vector;
        }
    }
}
