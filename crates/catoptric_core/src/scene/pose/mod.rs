//! Poses of a [`Model`] as a [`Scene`]: animation, skinning, morphing and placement at one moment.

mod coincident;
mod far;
mod fineness;
mod material_rules;
mod morph;
mod pieces;
mod plates;

use super::edits::{LookRule, MoveRule};
use super::model::{AnalyticAsset, Animation, LocalTransform, Model, Node, Primitive, Skin};
use super::roles::RoleRule;
use super::{Camera, Light, Object, Role, Scene};
use crate::error::SceneError;
use crate::math::Aabb;
use crate::surface::PlacedSurface;
use coincident::CoincidentFaces;
use fineness::{Fineness, SharedMeshes};
use glam::{Affine3A, DAffine3, DMat4, DQuat, DVec3, Mat4, Vec3};
use material_rules::{MaterialRules, Winners};
use pieces::{Has, Piece, Place};
use std::collections::{HashMap, HashSet};

/// The moment and the roles with which a model becomes a scene.
#[derive(Clone, Debug, Default)]
pub struct PoseOptions {
    /// Time in the animations, in seconds.
    pub time: f32,
    /// Roles by name, over those of the model; later ones win.
    pub roles: Vec<RoleRule>,
    /// Looks by name, over those of the model; later ones win.
    pub looks: Vec<LookRule>,
    /// Moves by name, beside those of the model.
    pub moves: Vec<MoveRule>,
}

/// More triangles than this are refused: they would not fit into the memory of most machines.
pub const MAX_TRIANGLES: usize = 100_000_000;

/// The parts of the last pose of a model: for the next one, in which little may have moved.
#[derive(Debug, Default)]
pub struct PoseMemory {
    /// One for each primitive at each place, in the order of the nodes.
    pieces: Vec<Piece>,
    /// The piece of each object.
    of_objects: Vec<usize>,
    coincident: Vec<CoincidentFaces>,
}

/// The animated state of one node.
#[derive(Clone)]
struct NodeState {
    local: DMat4,
    weights: Option<Vec<f32>>,
    /// The way by which rules move it, and it alone.
    moved: Vec3,
}

impl Model {
    /// The scene at one moment.
    ///
    /// # Errors
    /// [`SceneError`] when indices point nowhere, a node is its own ancestor, a role's pattern matches nothing, or
    /// there are more than [`MAX_TRIANGLES`] triangles. Triangles with coordinates that are not finite are left out.
    pub fn pose(&self, options: &PoseOptions) -> Result<Scene, SceneError> {
        self.pose_again(options, &mut PoseMemory::default())
    }

    /// The same, but what has not moved since the last pose with this memory is copied from it: two to ten times as
    /// fast where little moves, more with exact surfaces. In between nothing of the model may have changed but where
    /// its nodes are.
    ///
    /// # Errors
    /// As [`Self::pose`].
    pub fn pose_again(&self, options: &PoseOptions, memory: &mut PoseMemory) -> Result<Scene, SceneError> {
        let invalid = |field: String, problem: &str| SceneError::invalid(&self.name, field, problem);
        let mut states = self.animated(options.time)?;
        let idle = self.apply_moves(options, &mut states);
        let worlds = self.world_transforms(&states)?;
        let mut builder = SceneBuilder::new(self, options, memory);
        let placed = |world: &DAffine3| placed_about(self.origin, world);
        for (index, node) in self.nodes.iter().enumerate() {
            let exact_world = worlds[index];
            let world = placed(&exact_world);
            if let Some(light) = &node.light {
                let direction = world.transform_vector3(Vec3::NEG_Z).try_normalize().unwrap_or(Vec3::NEG_Z);
                let position = world.transform_point3(Vec3::ZERO);
                if position.is_finite() && light.intensity.is_finite() {
                    let intensity = light.intensity.max(Vec3::ZERO);
                    builder.scene.lights.push(Light { kind: light.kind, intensity, position, direction });
                }
            }
            if let Some(analytic) = &node.analytic {
                let translation = exact_world.translation - self.origin;
                builder.add_analytic(node, analytic, &DAffine3 { translation, ..exact_world }, index)?;
            }
            let Some(mesh_index) = node.mesh else { continue };
            let mesh =
                self.meshes.get(mesh_index).ok_or_else(|| invalid(format!("nodes[{index}].mesh"), "no such mesh"))?;
            let weights = states[index].weights.as_deref().unwrap_or(&mesh.morph_weights);
            let joints = match node.skin {
                Some(skin) => {
                    let skin =
                        self.skins.get(skin).ok_or_else(|| invalid(format!("nodes[{index}].skin"), "no such skin"))?;
                    let moved = states[index].moved;
                    Some(
                        joint_matrices(skin, (&worlds, self.origin), moved)
                            .ok_or_else(|| invalid("skins".into(), "a joint is no node"))?,
                    )
                }
                None => None,
            };
            let name = if node.name.is_empty() { &mesh.name } else { &node.name };
            for (part, primitive) in mesh.primitives.iter().enumerate() {
                let field = || format!("meshes[{mesh_index}].primitives[{part}]");
                primitive.check(self).map_err(|problem| invalid(field(), &problem))?;
                let weights = if primitive.morph_targets.is_empty() { &[] } else { weights };
                let place = |world: Affine3A| Place::new(world, weights, joints.as_deref());
                if node.instances.is_empty() {
                    builder.add_primitive(name, primitive, place(world))?;
                }
                for instance in &node.instances {
                    builder.add_primitive(name, primitive, place(placed(&(exact_world * exact(instance)))))?;
                }
            }
        }
        builder.rules.check(&builder.scene)?;
        if let Some((name, field)) = idle {
            builder.rules.unknown("node", &name, &field, &builder.scene)?;
        }
        let mut scene = builder.finish(memory);
        self.add_cameras(&worlds, &mut scene.cameras)?;
        Ok(scene)
    }

    fn region_about_origin(&self) -> Option<Aabb> {
        let about = |corner: Vec3| (corner.as_dvec3() - self.origin).as_vec3();
        self.region.map(|region| Aabb { min: about(region.min), max: about(region.max) })
    }

    fn add_cameras(&self, worlds: &[DAffine3], cameras: &mut Vec<Camera>) -> Result<(), SceneError> {
        for camera in &self.cameras {
            let parent = match camera.node {
                Some(node) => {
                    *worlds.get(node).ok_or_else(|| SceneError::invalid(&self.name, "cameras", "no such node"))?
                }
                None => DAffine3::IDENTITY,
            };
            let world = rigid(&placed_about(self.origin, &(parent * exact(&camera.placement))));
            if world.is_finite() {
                let camera = Camera {
                    name: camera.name.clone(),
                    other_name: camera.other_name.clone(),
                    world_from_camera: world,
                    projection: camera.projection,
                };
                cameras.push(camera);
            }
        }
        Ok(())
    }

    /// The last time of any animation key, in seconds; 0 without animations.
    pub fn duration(&self) -> f32 {
        self.animations.iter().map(Animation::duration).fold(0.0, f32::max)
    }

    /// The indices of the animations that play: all but those with a target of one before.
    pub fn playing(&self) -> Vec<usize> {
        let mut driven = HashSet::new();
        let plays = |(index, animation): (usize, &Animation)| {
            let targets = || animation.channels.iter().map(|channel| (channel.node, channel.values.property()));
            let is_free = !targets().any(|target| driven.contains(&target));
            if is_free {
                driven.extend(targets());
            }
            is_free.then_some(index)
        };
        self.animations.iter().enumerate().filter_map(plays).collect()
    }

    fn animated(&self, time: f32) -> Result<Vec<NodeState>, SceneError> {
        let mut parts: Vec<LocalTransform> = self.nodes.iter().map(|node| node.local).collect();
        let mut weights: Vec<Option<Vec<f32>>> = self
            .nodes
            .iter()
            .map(|node| (!node.morph_weights.is_empty()).then(|| node.morph_weights.clone()))
            .collect();
        for index in self.playing() {
            for channel in &self.animations[index].channels {
                let Some(local) = parts.get_mut(channel.node) else {
                    let field = format!("animations[{index}].channels");
                    return Err(SceneError::invalid(&self.name, field, "a target is no node"));
                };
                channel.apply(time, local, &mut weights[channel.node]);
            }
        }
        let states = parts.iter().zip(weights).map(|(local, weights)| NodeState {
            local: local.exact_matrix(),
            weights,
            moved: Vec3::ZERO,
        });
        Ok(states.collect())
    }

    /// Writes what rules move into the nodes' states. Returns the name of a rule that has moved nothing, with its field
    /// in the file, which is empty for rules beyond it.
    fn apply_moves(&self, options: &PoseOptions, states: &mut [NodeState]) -> Option<(String, String)> {
        let mut idle = None;
        for (index, rule) in self.moves.iter().chain(&options.moves).enumerate() {
            let mut has_moved = false;
            for (node, state) in self.nodes.iter().zip(&mut *states) {
                let of_mesh = node.mesh.and_then(|mesh| self.meshes.get(mesh)).map_or("", |mesh| &mesh.name);
                let name = if node.name.is_empty() { of_mesh } else { &node.name };
                if !name.is_empty() && rule.pattern.matches(name, "") {
                    state.moved += rule.by;
                    has_moved = true;
                }
            }
            if !has_moved {
                let name = rule.pattern();
                let field = if index < self.moves.len() { format!("move.{name}") } else { String::new() };
                idle.get_or_insert((name.to_owned(), field));
            }
        }
        idle
    }

    fn world_transforms(&self, states: &[NodeState]) -> Result<Vec<DAffine3>, SceneError> {
        let mut worlds: Vec<Option<DMat4>> = vec![None; self.nodes.len()];
        let mut chain = Vec::new();
        for start in 0..self.nodes.len() {
            let mut node = start;
            chain.clear();
            // Up to an ancestor with a computed place, then down again.
            let mut world = loop {
                if let Some(world) = worlds[node] {
                    break world;
                }
                chain.push(node);
                if chain.len() > self.nodes.len() {
                    let field = format!("nodes[{start}]");
                    return Err(SceneError::invalid(&self.name, field, "the node is its own ancestor"));
                }
                match self.nodes[node].parent {
                    Some(parent) if parent < self.nodes.len() => node = parent,
                    Some(parent) => {
                        let field = format!("nodes[{node}]");
                        return Err(SceneError::invalid(&self.name, field, format!("its parent {parent} is no node")));
                    }
                    None => break DMat4::IDENTITY,
                }
            };
            for &node in chain.iter().rev() {
                let NodeState { local, moved, .. } = &states[node];
                world *= *local;
                world.w_axis += moved.as_dvec3().extend(0.0);
                worlds[node] = Some(world);
            }
        }
        Ok(worlds.into_iter().map(|world| DAffine3::from_mat4(world.unwrap_or_default())).collect())
    }
}

fn exact(transform: &Affine3A) -> DAffine3 {
    let [x, y, z] = [transform.matrix3.x_axis, transform.matrix3.y_axis, transform.matrix3.z_axis];
    DAffine3::from_cols(x.as_dvec3(), y.as_dvec3(), z.as_dvec3(), transform.translation.as_dvec3())
}

/// A place about an origin, rounded.
fn placed_about(origin: DVec3, world: &DAffine3) -> Affine3A {
    let [x, y, z] = [world.matrix3.x_axis, world.matrix3.y_axis, world.matrix3.z_axis].map(|axis| axis.as_vec3());
    Affine3A::from_cols(x.into(), y.into(), z.into(), (world.translation - origin).as_vec3().into())
}

/// The rotation and translation of a transform; scale and shear are taken off.
fn rigid(transform: &Affine3A) -> Affine3A {
    let (_, rotation, translation) = transform.to_scale_rotation_translation();
    Affine3A::from_rotation_translation(rotation, translation)
}

impl LocalTransform {
    /// The matrix in double precision: of single-precision rotations, that of the nearest unit quaternion.
    fn exact_matrix(&self) -> DMat4 {
        match *self {
            Self::Matrix(matrix) => matrix.as_dmat4(),
            Self::Parts { translation, rotation, scale } => {
                let rotation = rotation.as_dquat();
                let length2 = rotation.length_squared();
                let rotation =
                    if length2.is_finite() && length2 > 1e-20 { rotation.normalize() } else { DQuat::IDENTITY };
                DMat4::from_scale_rotation_translation(scale.as_dvec3(), rotation, translation.as_dvec3())
            }
            Self::Rigid { translation, rotation } => DMat4::from_rotation_translation(rotation, translation),
        }
    }
}

/// The matrices of the joints that bend a mesh, which is moved by so much whatever its joints do.
fn joint_matrices(skin: &Skin, (worlds, origin): (&[DAffine3], DVec3), moved: Vec3) -> Option<Vec<Mat4>> {
    let bind = |joint: usize| skin.inverse_bind.get(joint).copied().unwrap_or(Mat4::IDENTITY).as_dmat4();
    let joints = skin.joints.iter().enumerate();
    let moved = DMat4::from_translation(moved.as_dvec3() - origin);
    joints.map(|(joint, node)| Some((moved * DMat4::from(*worlds.get(*node)?) * bind(joint)).as_mat4())).collect()
}

impl Primitive {
    fn check(&self, model: &Model) -> Result<(), String> {
        let count = self.positions.len();
        let lengths = [
            ("normals", self.normals.len()),
            ("first texture coordinates", self.uvs[0].len()),
            ("second texture coordinates", self.uvs[1].len()),
            ("tangents", self.tangents.len()),
            ("colors", self.colors.len()),
            ("joints", self.joints.len()),
            ("weights", self.weights.len()),
        ];
        for (name, length) in lengths {
            if length != 0 && length != count {
                return Err(format!("{length} {name} for {count} positions"));
            }
        }
        for target in &self.morph_targets {
            for length in [target.positions.len(), target.normals.len(), target.tangents.len()] {
                if length != 0 && length != count {
                    return Err(format!("a morph target has {length} values for {count} positions"));
                }
            }
        }
        if let Some(index) = self.triangles.iter().flatten().find(|index| **index as usize >= count) {
            return Err(format!("index {index} is beyond the {count} vertices"));
        }
        if self.material >= model.materials.len() {
            return Err(format!("there is no material {}", self.material));
        }
        Ok(())
    }
}

struct SceneBuilder<'a> {
    model: &'a Model,
    rules: MaterialRules<'a>,
    /// Materials made by rules: by original material and the rules that won.
    overridden: HashMap<(usize, Winners), u32>,
    /// The overridden materials that a role makes glass.
    glass_by_role: HashSet<u32>,
    has: Has,
    fineness: Fineness,
    /// Meshes of exact surfaces that were made for this pose.
    meshes: SharedMeshes,
    /// The pieces of the last pose that have not had their turn, and those of this one.
    earlier: std::vec::IntoIter<Piece>,
    pieces: Vec<Piece>,
    /// The piece of each object, and whether it was made for this pose.
    of_objects: Vec<usize>,
    is_new: Vec<bool>,
    scene: Scene,
}

impl<'a> SceneBuilder<'a> {
    /// A scene without objects.
    fn new(model: &'a Model, options: &'a PoseOptions, memory: &mut PoseMemory) -> Self {
        let primitives = || model.meshes.iter().flat_map(|mesh| &mesh.primitives);
        Self {
            model,
            rules: MaterialRules::new(model, &options.roles, &options.looks),
            overridden: HashMap::new(),
            glass_by_role: HashSet::new(),
            has: Has {
                tangents: primitives().any(|primitive| !primitive.tangents.is_empty()),
                colors: primitives().any(|primitive| !primitive.colors.is_empty()),
            },
            fineness: Fineness::of(model.nodes.iter().filter_map(|node| Some(&node.analytic.as_ref()?.surface))),
            meshes: SharedMeshes::default(),
            earlier: std::mem::take(&mut memory.pieces).into_iter(),
            pieces: Vec::new(),
            of_objects: Vec::new(),
            is_new: Vec::new(),
            scene: Scene {
                name: model.name.clone(),
                materials: model.materials.clone(),
                textures: model.textures.clone(),
                environment: model.environment.clone(),
                origin: model.origin,
                region: model.region_about_origin(),
                ends_in_environment: model.ends_in_environment,
                backdrop: model.backdrop,
                bounds: Aabb::EMPTY,
                ..Scene::default()
            },
        }
    }

    /// The material that an object gets, after the rules.
    fn material(&mut self, name: &str, material: usize) -> u32 {
        let original = &self.model.materials[material];
        let winners = self.rules.winners(name, original);
        if winners == Winners::default() {
            return material as u32;
        }
        *self.overridden.entry((material, winners)).or_insert_with(|| {
            self.scene.materials.push(self.rules.apply(winners, original));
            let number = self.scene.materials.len() as u32 - 1;
            if self.rules.role_of(winners) == Some(Role::Lens) {
                self.glass_by_role.insert(number);
            }
            number
        })
    }

    fn add_primitive(&mut self, name: &str, primitive: &Primitive, place: Place) -> Result<(), SceneError> {
        let material = self.material(name, primitive.material);
        self.check_count(primitive.triangles.len())?;
        let (piece, is_new) = match self.earlier.next() {
            Some(earlier) if earlier.is_at(&place) => (earlier, false),
            _ => (Piece::of_primitive(primitive, place, self.has), true),
        };
        self.add(name, material, (piece, is_new), false)
    }

    fn add_analytic(
        &mut self,
        node: &Node,
        analytic: &AnalyticAsset,
        world: &DAffine3,
        index: usize,
    ) -> Result<(), SceneError> {
        let invalid = |problem: &str| SceneError::invalid(&self.model.name, format!("nodes[{index}]"), problem);
        if analytic.material >= self.model.materials.len() {
            return Err(invalid("its analytic surface has no material"));
        }
        let scales = [world.matrix3.x_axis, world.matrix3.y_axis, world.matrix3.z_axis].map(|column| column.length());
        let scale = scales[0];
        if !world.is_finite() || scale <= 0.0 || scales.iter().any(|s| (s - scale).abs() > 1e-3 * scale) {
            return Err(invalid("an analytic surface can be turned, moved and scaled alike in all directions only"));
        }
        let surface = analytic.surface.scaled(scale);
        let (_, rotation, translation) = world.to_scale_rotation_translation();
        let place = DAffine3::from_rotation_translation(rotation, translation);
        let placed = PlacedSurface { surface, world_from_surface: place };
        let material = self.material(&node.name, analytic.material);
        let earlier = self.earlier.next();
        let is_new = earlier.as_ref().and_then(Piece::surface) != Some(&placed);
        let fineness = self.fineness.of_surface(&analytic.surface);
        let piece = Piece::of_surface(placed, (fineness, &mut self.meshes), earlier, self.has);
        self.add(&node.name, material, (piece, is_new), analytic.inside)
    }

    /// The scene with all its objects, which is remembered for the next pose.
    fn finish(self, memory: &mut PoseMemory) -> Scene {
        let Self { pieces, of_objects, is_new, mut scene, glass_by_role, .. } = self;
        plates::make_plates(&mut scene, |material| glass_by_role.contains(&material));
        let are_known = memory.of_objects == of_objects;
        coincident::separate(&mut scene, |object| !are_known || is_new[*object as usize], &mut memory.coincident);
        (memory.pieces, memory.of_objects) = (pieces, of_objects);
        scene
    }

    /// Refuses more triangles than there may be.
    fn check_count(&self, more: usize) -> Result<(), SceneError> {
        let vertices = self.scene.positions.len();
        if vertices > u32::MAX as usize / 2 || self.scene.triangles.len() + more > MAX_TRIANGLES {
            let problem = format!("more than {MAX_TRIANGLES} triangles once all instances are placed");
            return Err(SceneError::invalid(&self.model.name, "nodes", problem));
        }
        Ok(())
    }

    /// Adds a piece as an object, unless it has no triangles.
    fn add(
        &mut self,
        name: &str,
        material: u32,
        (piece, is_new): (Piece, bool),
        inside: bool,
    ) -> Result<(), SceneError> {
        let number = self.scene.objects.len() as u32;
        if let Some((vertices, triangles)) = piece.append_to(&mut self.scene, number) {
            let (bounds, surface) = (piece.bounds(), piece.surface().cloned());
            self.scene.bounds = self.scene.bounds.union(bounds);
            let name = name.into();
            self.scene.objects.push(Object { name, material, triangles, vertices, surface, inside, bounds });
            self.of_objects.push(self.pieces.len());
            self.is_new.push(is_new);
        }
        self.pieces.push(piece);
        self.check_count(0)
    }
}
