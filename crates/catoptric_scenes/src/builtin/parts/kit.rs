//! A builder of models: materials, nodes, rooms and cameras.

use super::super::parameters::Values;
use super::shapes::{self, Shape};
use super::textures;
use crate::tangents;
use catoptric_core::math::portable::turn_about_f32;
use catoptric_core::scene::model::{
    AnalyticAsset, CameraAsset, LightAsset, LocalTransform, MeshAsset, Model, Node, Primitive,
};
use catoptric_core::scene::{Camera, LightKind, Material, Microfacets, NormalMap, Texture, TextureBinding};
use catoptric_core::surface::{AnalyticSurface, SurfaceError};
use glam::{Affine2, Affine3A, Quat, Vec2, Vec3};
use std::sync::Arc;

/// A model under construction.
pub(in super::super) struct Kit {
    model: Model,
    lit: bool,
}

/// A rigid pose: a rotation and a translation.
#[derive(Clone, Copy, Debug)]
pub(in super::super) struct Place {
    pub(in super::super) translation: Vec3,
    pub(in super::super) rotation: Quat,
}

/// At a point, not turned.
pub(in super::super) fn at(x: f32, y: f32, z: f32) -> Place {
    Place { translation: Vec3::new(x, y, z), rotation: Quat::IDENTITY }
}

impl Place {
    /// Turned about y, counter-clockwise from above.
    pub(in super::super) fn turned(self, degrees: f32) -> Self {
        Self { rotation: self.rotation * turn_about_f32(Vec3::Y, degrees.to_radians()), ..self }
    }

    /// Turned about its own x, y and z axes, y first.
    pub(in super::super) fn turned_yxz(self, y_deg: f32, x_deg: f32, z_deg: f32) -> Self {
        let about = |axis: Vec3, degrees: f32| turn_about_f32(axis, degrees.to_radians());
        let turn = about(Vec3::Y, y_deg) * about(Vec3::X, x_deg) * about(Vec3::Z, z_deg);
        Self { rotation: self.rotation * turn, ..self }
    }
}

/// The length of the cells that flat surfaces of a room are cut into, in scene units.
const ROOM_CELL: f32 = 0.5;

impl Kit {
    /// A scene of unlit materials.
    pub(in super::super) fn unlit(spec: &str) -> Self {
        Self { model: Model { name: spec.into(), ..Model::default() }, lit: false }
    }

    /// A scene of materials that lights shine on.
    pub(in super::super) fn lit(spec: &str) -> Self {
        Self { lit: true, ..Self::unlit(spec) }
    }

    /// The finished model.
    pub(in super::super) fn finish(self) -> Model {
        self.model
    }

    /// The model under construction, for parts without a function of the kit.
    pub(in super::super) fn model(&mut self) -> &mut Model {
        &mut self.model
    }

    /// Adds a material and returns its index.
    pub(in super::super) fn material(&mut self, material: Material) -> usize {
        self.model.materials.push(material);
        self.model.materials.len() - 1
    }

    /// Adds a diffuse material of one sRGB colour.
    pub(in super::super) fn plain(&mut self, name: &str, color: Vec3) -> usize {
        let unlit = !self.lit;
        self.material(Material { unlit, ..Material::diffuse(name, textures::linear(color)) })
    }

    /// Adds a texture; returns its use as it is.
    fn bound(&mut self, texture: Texture) -> TextureBinding {
        self.model.textures.push(Arc::new(texture));
        let texture = self.model.textures.len() as u32 - 1;
        TextureBinding { texture, uv_channel: 0, texture_from_uv: Affine2::IDENTITY }
    }

    /// Adds a diffuse material of the texture's name.
    pub(in super::super) fn painted(&mut self, texture: Texture) -> usize {
        let name = texture.name.clone();
        let binding = self.bound(texture);
        let unlit = !self.lit;
        self.material(Material { unlit, base_texture: Some(binding), ..Material::diffuse(&name, Vec3::ONE) })
    }

    /// Adds a material whose base colour is multiplied by a texture.
    pub(in super::super) fn textured(&mut self, material: Material, texture: Texture) -> usize {
        let base_texture = Some(self.bound(texture));
        self.material(Material { base_texture, ..material })
    }

    /// Gives a material with facets a texture of their roughness and metal.
    pub(in super::super) fn set_facet_map(&mut self, material: usize, texture: Texture) {
        let texture = Some(self.bound(texture));
        let facets = self.model.materials[material].microfacets.take().unwrap_or_default();
        self.model.materials[material].microfacets = Some(Microfacets { texture, ..facets });
    }

    /// Gives a material a normal map, whose slopes are scaled.
    pub(in super::super) fn set_normal_map(&mut self, material: usize, texture: Texture, scale: f32) {
        let binding = self.bound(texture);
        self.model.materials[material].normal_map = Some(NormalMap { binding, scale });
    }

    /// Adds the perfect mirror of most scenes, a little darker than the world.
    pub(in super::super) fn mirror(&mut self) -> usize {
        self.material(Material::mirror("mirror", Vec3::splat(0.95)))
    }

    /// Adds that mirror, blended with a colour (sRGB) by the scene's parameter `blend`.
    pub(in super::super) fn blended_mirror(&mut self, distance: f32, color: Vec3, values: &Values<'_>) -> usize {
        let mirror = self.mirror();
        self.model.materials[mirror].blend = values.blend(distance, textures::linear(color));
        mirror
    }

    fn node(&mut self, name: &str, place: Place) -> &mut Node {
        let local =
            LocalTransform::Parts { translation: place.translation, rotation: place.rotation, scale: Vec3::ONE };
        self.model.nodes.push(Node { name: name.into(), local, ..Node::default() });
        let last = self.model.nodes.len() - 1;
        &mut self.model.nodes[last]
    }

    /// Adds a node with a mesh and returns its index.
    ///
    /// In unlit scenes faces get the brightness of their direction, as if a broad light came from above.
    pub(in super::super) fn add(&mut self, name: &str, material: usize, shape: Shape, place: Place) -> usize {
        let unlit = self.model.materials[material].unlit;
        let colors =
            if unlit { shape.normals.iter().map(|n| shade(place.rotation * *n)).collect() } else { Vec::new() };
        let mut primitive = Primitive {
            positions: shape.positions,
            normals: shape.normals,
            uvs: [shape.uvs, Vec::new()],
            colors,
            triangles: shape.triangles,
            material,
            ..Primitive::default()
        };
        if self.model.materials[material].normal_map.is_some() {
            tangents::complete(&mut primitive, 0);
        }
        self.model.meshes.push(MeshAsset { name: name.into(), primitives: vec![primitive], ..MeshAsset::default() });
        let mesh = self.model.meshes.len() - 1;
        self.node(name, place).mesh = Some(mesh);
        self.model.nodes.len() - 1
    }

    /// Adds a node with an exact surface.
    pub(in super::super) fn add_analytic(
        &mut self,
        name: &str,
        material: usize,
        surface: AnalyticSurface,
        place: Place,
    ) {
        self.node(name, place).analytic = Some(AnalyticAsset { surface, material, inside: false });
    }

    /// Adds an empty node as a parent of others; returns its index.
    pub(in super::super) fn pivot(&mut self, name: &str, place: Place) -> usize {
        self.node(name, place);
        self.model.nodes.len() - 1
    }

    /// Makes a node the child of another one, whose frame its place is then in.
    pub(in super::super) fn set_parent(&mut self, child: usize, parent: usize) {
        self.model.nodes[child].parent = Some(parent);
    }

    /// Adds a mirror: the exact surface or a mesh, by the scene's parameter `surface`.
    pub(in super::super) fn add_mirror(
        &mut self,
        name: &str,
        material: usize,
        exact: Result<AnalyticSurface, SurfaceError>,
        mesh: impl FnOnce() -> Shape,
        place: Place,
        values: &Values<'_>,
    ) {
        match exact {
            Ok(surface) if values.analytic() => self.add_analytic(name, material, surface, place),
            Ok(_) => {
                self.add(name, material, mesh(), place);
            }
            Err(error) => panic!("the built-in surface `{name}` does not exist: {error}"),
        }
    }

    /// Adds a sphere: a mesh or the exact surface, by the scene's parameter `surface`.
    pub(in super::super) fn add_sphere(
        &mut self,
        name: &str,
        material: usize,
        radius: f32,
        place: Place,
        values: &Values<'_>,
    ) {
        if values.analytic() {
            self.add_analytic(name, material, AnalyticSurface::Sphere { radius: radius as f64 }, place);
        } else {
            self.add(name, material, shapes::sphere(radius, values.tess()), place);
        }
    }

    /// Adds a box with the middle of its base at a place.
    pub(in super::super) fn add_box(&mut self, name: &str, material: usize, size: [f32; 3], place: Place) -> usize {
        let half = Vec3::from(size) * 0.5;
        let lifted = Place { translation: place.translation + Vec3::Y * half.y, ..place };
        self.add(name, material, shapes::cuboid(half, 4), lifted)
    }

    /// Adds the six inner faces of a room between two corners: floor and ceiling, each of a material and the length
    /// of its texture in scene units, and the walls at the back, front, left and right, which share that length.
    pub(in super::super) fn add_room(
        &mut self,
        [min, max]: [Vec3; 2],
        [floor, ceiling]: [(usize, f32); 2],
        ([back, front, left, right], wall_tile): ([usize; 4], f32),
    ) {
        let size = max - min;
        let (x, y, z) = (Vec3::X * size.x, Vec3::Y * size.y, Vec3::Z * size.z);
        let corner = |right: bool, top: bool, near: bool| {
            Vec3::new(
                if right { max.x } else { min.x },
                if top { max.y } else { min.y },
                if near { max.z } else { min.z },
            )
        };
        for (name, (material, tile), corner, right, up) in [
            ("floor", floor, corner(false, false, true), x, -z),
            ("ceiling", ceiling, corner(false, true, false), x, z),
            ("wall_back", (back, wall_tile), corner(false, false, false), x, y),
            ("wall_front", (front, wall_tile), corner(true, false, true), -x, y),
            ("wall_left", (left, wall_tile), corner(false, false, true), -z, y),
            ("wall_right", (right, wall_tile), corner(true, false, false), z, y),
        ] {
            let cells = [right, up].map(|edge| ((edge.length() / ROOM_CELL).ceil() as u32).clamp(1, 64));
            let shape = shapes::rectangle(corner, right, up, cells, Vec2::splat(tile));
            self.add(name, material, shape, at(0.0, 0.0, 0.0));
        }
    }

    /// Adds a light; directional ones shine along `towards`.
    pub(in super::super) fn add_light(
        &mut self,
        name: &str,
        kind: LightKind,
        intensity: Vec3,
        position: Vec3,
        towards: Vec3,
    ) {
        let rotation = Quat::from_rotation_arc(Vec3::NEG_Z, towards.normalize_or(Vec3::NEG_Y));
        self.node(name, Place { translation: position, rotation }).light = Some(LightAsset { kind, intensity });
    }

    /// Adds a camera; the first is the default. The field of view is vertical.
    pub(in super::super) fn add_camera(&mut self, name: &str, eye: Vec3, target: Vec3, fov_deg: f32) {
        let camera = Camera::look_at(name, eye, target, Vec3::Y, fov_deg);
        let placement: Affine3A = camera.world_from_camera;
        let camera = CameraAsset {
            name: name.into(),
            other_name: String::new(),
            node: None,
            placement,
            projection: camera.projection,
        };
        self.model.cameras.push(camera);
    }
}

/// The brightness of an unlit face: full from above and the front right, a third less from below and behind.
fn shade(normal: Vec3) -> [f32; 4] {
    let towards_light = Vec3::new(0.42, 0.8, 0.43);
    let brightness = 0.8 + 0.2 * normal.dot(towards_light);
    [brightness, brightness, brightness, 1.0]
}
