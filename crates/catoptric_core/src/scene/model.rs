//! A scene file's content: a tree of nodes with meshes, skins, animations, cameras and lights.
//!
//! [`Model::pose`] evaluates it at a time and flattens it into a [`Scene`](super::Scene), the methods' input.

use super::{Environment, LightKind, Material, Projection, Texture};
use crate::error::SceneError;
use crate::math::Aabb;
use crate::surface::AnalyticSurface;
use glam::{Affine3A, DQuat, DVec3, Mat4, Quat, Vec2, Vec3, Vec4};
use std::collections::BTreeMap;
use std::sync::Arc;

/// The content of a scene file.
///
/// Indices between the parts are checked by [`Model::pose`], which reports one that points nowhere.
#[derive(Clone, Debug, Default)]
pub struct Model {
    /// The file or built-in scene it came from, for messages.
    pub name: String,
    /// Where the origin of its scenes lies in the file's coordinates: [`Scene::origin`](super::Scene::origin).
    pub origin: DVec3,
    /// All nodes; a parent may stand before or after its children.
    pub nodes: Vec<Node>,
    /// Meshes that nodes place.
    pub meshes: Vec<MeshAsset>,
    /// Skins that bend meshes.
    pub skins: Vec<Skin>,
    /// Animations. All play from time 0, but one with the target of an earlier one is left out; at their ends they
    /// hold.
    pub animations: Vec<Animation>,
    /// The names of the file's variants: sets of materials of which one can be chosen when it is read.
    pub variants: Vec<String>,
    /// The variant whose materials the primitives have; without one they have the file's default materials.
    pub variant: Option<String>,
    /// Materials that primitives name.
    pub materials: Vec<Material>,
    /// Textures that materials name.
    pub textures: Vec<Arc<Texture>>,
    /// Light from infinity.
    pub environment: Option<Arc<Environment>>,
    /// The value of [`Scene::ends_in_environment`](super::Scene::ends_in_environment).
    pub ends_in_environment: bool,
    /// The value of [`Scene::backdrop`](super::Scene::backdrop).
    pub backdrop: Option<Vec3>,
    /// Cameras; the first is the default.
    pub cameras: Vec<CameraAsset>,
    /// The region in which reflectors or views may move (for baking).
    pub region: Option<Aabb>,
    /// Settings of methods that the file brings along, by method id.
    pub method_settings: BTreeMap<String, toml::Table>,
    /// Roles that the file gives by name, over its materials.
    pub roles: Vec<super::roles::RoleRule>,
    /// The file's blends of mirrors by name, over their materials; later ones win.
    pub blends: Vec<super::roles::BlendRule>,
    /// Rules that move nodes by name, whatever animations do; ways add up.
    pub moves: Vec<super::edits::MoveRule>,
    /// Looks by name, over all materials; later ones win.
    pub looks: Vec<super::edits::LookRule>,
    /// Lines of the file by fields that are checked later than they are read: `role.NAME`, `blend.NAME`, `move.NAME`,
    /// `material.NAME`, `method.ID` and `method.ID.KEY`.
    pub lines: BTreeMap<String, usize>,
    /// The parts left out or mended while reading, for the user.
    pub warnings: Vec<String>,
}

impl Model {
    /// A wrong field of the file, with its line where that is known.
    pub fn invalid(&self, field: &str, problem: impl Into<String>) -> SceneError {
        let place = self.lines.get(field).map_or_else(|| field.into(), |line| format!("line {line}: {field}"));
        SceneError::invalid(&self.name, place, problem)
    }
}

/// A named place in the tree, with its mesh, light or surface.
#[derive(Clone, Debug, Default)]
pub struct Node {
    /// The name in the file; may be empty.
    pub name: String,
    /// Index of the parent node.
    pub parent: Option<usize>,
    /// The pose of the node in its parent's frame.
    pub local: LocalTransform,
    /// Index of the mesh that stands here.
    pub mesh: Option<usize>,
    /// Index of the skin that bends the mesh.
    pub skin: Option<usize>,
    /// Weights of the mesh's morph targets; empty: the mesh's own.
    pub morph_weights: Vec<f32>,
    /// A light that stands here and shines along -z.
    pub light: Option<LightAsset>,
    /// Placements of the mesh in the node's own frame (EXT_mesh_gpu_instancing); empty: one, at the node.
    pub instances: Vec<Affine3A>,
    /// An analytic surface in the node's own frame, instead of triangles.
    pub analytic: Option<AnalyticAsset>,
}

/// A node's place in its parent.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum LocalTransform {
    /// A matrix; not animated.
    Matrix(Mat4),
    /// Scale, then rotate, then translate; each may be animated.
    Parts {
        /// The translation.
        translation: Vec3,
        /// The rotation; normalised when used.
        rotation: Quat,
        /// The scale along each axis.
        scale: Vec3,
    },
    /// Rotate, then translate, in double precision, for analytic surfaces; not animated.
    Rigid {
        /// The translation.
        translation: DVec3,
        /// The rotation, of unit length.
        rotation: DQuat,
    },
}

impl Default for LocalTransform {
    fn default() -> Self {
        Self::Parts { translation: Vec3::ZERO, rotation: Quat::IDENTITY, scale: Vec3::ONE }
    }
}

impl LocalTransform {
    /// A pure translation.
    pub fn at(translation: Vec3) -> Self {
        Self::Parts { translation, rotation: Quat::IDENTITY, scale: Vec3::ONE }
    }
}

/// A mesh: primitives that are placed together.
#[derive(Clone, Debug, Default)]
pub struct MeshAsset {
    /// The name in the file; may be empty.
    pub name: String,
    /// The mesh's parts, one a material.
    pub primitives: Vec<Primitive>,
    /// Default weights of the morph targets.
    pub morph_weights: Vec<f32>,
}

/// Triangles of one material. All per-vertex arrays are as long as `positions` or empty.
#[derive(Clone, Debug, Default)]
pub struct Primitive {
    /// Vertex positions.
    pub positions: Vec<Vec3>,
    /// Unit shading normals; empty: every triangle is flat.
    pub normals: Vec<Vec3>,
    /// Two sets of texture coordinates, those that the material's textures use.
    pub uvs: [Vec<Vec2>; 2],
    /// Tangents of the normal map, as in a [`Scene`](super::Scene).
    pub tangents: Vec<Vec4>,
    /// Linear vertex colours with alpha; empty: white.
    pub colors: Vec<[f32; 4]>,
    /// Four joints a vertex, indices into the skin's joints.
    pub joints: Vec<[u16; 4]>,
    /// The joints' weights.
    pub weights: Vec<[f32; 4]>,
    /// Vertex indices of each triangle, counter-clockwise seen from outside.
    pub triangles: Vec<[u32; 3]>,
    /// Shapes that the weights blend in.
    pub morph_targets: Vec<MorphTarget>,
    /// Index of the material.
    pub material: usize,
}

/// The offsets of a morph target at weight 1; arrays as long as the primitive's positions, or empty.
#[derive(Clone, Debug, Default)]
pub struct MorphTarget {
    /// Added to positions.
    pub positions: Vec<Vec3>,
    /// Added to normals.
    pub normals: Vec<Vec3>,
    /// Added to tangents.
    pub tangents: Vec<Vec3>,
}

/// Joints that bend a mesh.
#[derive(Clone, Debug, Default)]
pub struct Skin {
    /// Node indices of the joints.
    pub joints: Vec<usize>,
    /// Maps the mesh's rest pose to each joint's frame; empty: identities.
    pub inverse_bind: Vec<Mat4>,
}

/// A set of channels that move nodes.
#[derive(Clone, Debug, Default)]
pub struct Animation {
    /// The name in the file; may be empty.
    pub name: String,
    /// The values it moves.
    pub channels: Vec<Channel>,
}

/// The motion of one property of one node.
#[derive(Clone, Debug)]
pub struct Channel {
    /// Index of the node.
    pub node: usize,
    /// Times of the keys in seconds, rising.
    pub times: Vec<f32>,
    /// The interpolation between keys.
    pub interpolation: Interpolation,
    /// The values.
    pub values: ChannelValues,
}

/// Interpolation between keys, as in glTF.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Interpolation {
    /// The last key's value.
    Step,
    /// Linear; spherical for rotations.
    Linear,
    /// Hermite splines; three values a key: in-tangent, value, out-tangent.
    CubicSpline,
}

/// The values of a channel: one a key, or three for splines.
#[derive(Clone, Debug)]
pub enum ChannelValues {
    /// Translations.
    Translation(Vec<Vec3>),
    /// Rotations.
    Rotation(Vec<Quat>),
    /// Scales.
    Scale(Vec<Vec3>),
    /// Weights of morph targets: `targets` numbers a value, all in one row.
    Weights {
        /// Numbers a value.
        targets: usize,
        /// The numbers.
        numbers: Vec<f32>,
    },
}

/// A camera and where it stands.
#[derive(Clone, Debug)]
pub struct CameraAsset {
    /// The camera's name; may be empty.
    pub name: String,
    /// A second name to find it by; may be empty.
    pub other_name: String,
    /// The node it is fixed to; `None`: `placement` is in the world.
    pub node: Option<usize>,
    /// The place in the node or in the world; the camera looks along -z.
    pub placement: Affine3A,
    /// The projection onto the picture.
    pub projection: Projection,
}

/// A light as it stands in a file; the node places it.
#[derive(Clone, Copy, Debug)]
pub struct LightAsset {
    /// The kind and its parameters.
    pub kind: LightKind,
    /// Linear colour times intensity.
    pub intensity: Vec3,
}

/// An analytic surface as it stands in a file; the node places it by rotation and translation alone.
#[derive(Clone, Debug)]
pub struct AnalyticAsset {
    /// The shape in the node's frame.
    pub surface: AnalyticSurface,
    /// Index of the material.
    pub material: usize,
    /// The inner side is the mirror and the outer side is opaque and black.
    pub inside: bool,
}
