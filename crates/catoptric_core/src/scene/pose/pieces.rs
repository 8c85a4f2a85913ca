//! Primitives and exact surfaces at their places, as parts of a scene that may be used for the next pose, too.

use super::super::Scene;
use super::super::model::Primitive;
use super::fineness::SharedMeshes;
use super::morph::{PosedPrimitive, morphed};
use crate::math::Aabb;
use crate::surface::mesh::parts::append_parts;
use crate::surface::{PlacedSurface, SurfaceMesh};
use glam::{Affine3A, Mat3, Mat4, Vec2, Vec3, Vec4};
use std::collections::HashMap;
use std::ops::Range;
use std::sync::Arc;

/// The tangent of vertices without a normal map.
const NO_TANGENT: Vec4 = Vec4::new(1.0, 0.0, 0.0, 1.0);

/// Coordinates beyond this are taken for errors: squares of distances must stay finite.
const MAX_COORDINATE: f32 = 1e12;

/// The attributes that vertices of a scene have, beside those that all have.
#[derive(Clone, Copy, Debug)]
pub(super) struct Has {
    pub(super) tangents: bool,
    pub(super) colors: bool,
}

/// Where a primitive is, and what shape it has there.
#[derive(Clone, Debug, PartialEq)]
pub(super) struct Place {
    world: Affine3A,
    morph_weights: Vec<f32>,
    joints: Option<Vec<Mat4>>,
}

impl Place {
    pub(super) fn new(world: Affine3A, morph_weights: &[f32], joints: Option<&[Mat4]>) -> Self {
        Self { world, morph_weights: morph_weights.to_vec(), joints: joints.map(<[Mat4]>::to_vec) }
    }
}

/// The origin of a piece.
#[derive(Debug)]
enum Source {
    Primitive(Place),
    /// With its triangles about its own origin, and how fine these are.
    Surface(Box<PlacedSurface>, Arc<SurfaceMesh>, f64),
}

/// A piece of a scene: an object with vertices of its own, which are numbered from 0.
#[derive(Debug)]
pub(super) struct Piece {
    source: Source,
    positions: Vec<Vec3>,
    normals: Vec<Vec3>,
    uvs: Vec<[Vec2; 2]>,
    colors: Vec<[f32; 4]>,
    tangents: Vec<Vec4>,
    triangles: Vec<[u32; 3]>,
    /// As [`Scene::triangle_parts`].
    parts: Vec<u32>,
    bounds: Aabb,
}

impl Piece {
    fn new(source: Source) -> Self {
        Self {
            source,
            positions: Vec::new(),
            normals: Vec::new(),
            uvs: Vec::new(),
            colors: Vec::new(),
            tangents: Vec::new(),
            triangles: Vec::new(),
            parts: Vec::new(),
            bounds: Aabb::EMPTY,
        }
    }

    /// A primitive at a place.
    pub(super) fn of_primitive(primitive: &Primitive, place: Place, has: Has) -> Self {
        let shape = morphed(primitive, &place.morph_weights);
        let skinned = place.joints.as_ref().filter(|_| !primitive.joints.is_empty() && !primitive.weights.is_empty());
        let world = place.world;
        // Every vertex's own transform; without a skin it is the node's.
        let transform = |vertex: usize| match skinned {
            Some(joints) => skin_matrix(joints, primitive.joints[vertex], primitive.weights[vertex]),
            None => world,
        };
        let positions: Vec<Vec3> =
            (0..shape.positions.len()).map(|v| transform(v).transform_point3(shape.positions[v])).collect();
        let usable: Vec<bool> =
            positions.iter().map(|p| p.is_finite() && p.abs().max_element() < MAX_COORDINATE).collect();
        let mirrored = skinned.is_none() && world.matrix3.determinant() < 0.0;
        let triangles = primitive.triangles.iter();
        let triangles = triangles.filter(|triangle| triangle.iter().all(|&vertex| usable[vertex as usize]));
        // Where joints mirror a part of a mesh, that part alone turns over.
        let turns_over = |vertex: u32| match skinned {
            Some(_) => transform(vertex as usize).matrix3.determinant() < 0.0,
            None => mirrored,
        };
        let triangles: Vec<[u32; 3]> =
            triangles.map(|&[a, b, c]| if turns_over(a) { [a, c, b] } else { [a, b, c] }).collect();
        let mut piece = Self::new(Source::Primitive(Place::new(world, &[], None)));
        if shape.normals.is_empty() {
            piece.add_flat(primitive, &positions, &triangles, has);
        } else {
            let normal_of_all = normal_matrix(&world);
            piece.positions =
                positions.iter().zip(&usable).map(|(p, usable)| if *usable { *p } else { Vec3::ZERO }).collect();
            piece.triangles = triangles;
            piece.add_vertices(primitive, &shape, has, mirrored, |vertex| match skinned {
                Some(_) => (transform(vertex), normal_matrix(&transform(vertex))),
                None => (world, normal_of_all),
            });
            piece.mend_normals();
        }
        piece.source = Source::Primitive(place);
        piece.finished()
    }

    /// Adds triangles without normals: every one has its own three vertices.
    fn add_flat(&mut self, primitive: &Primitive, positions: &[Vec3], triangles: &[[u32; 3]], has: Has) {
        for triangle in triangles {
            let corners = triangle.map(|vertex| positions[vertex as usize]);
            let normal = face_normal(corners).unwrap_or(Vec3::Y);
            let base = self.positions.len() as u32;
            self.triangles.push([base, base + 1, base + 2]);
            for vertex in triangle.map(|vertex| vertex as usize) {
                self.positions.push(positions[vertex]);
                self.normals.push(normal);
                self.uvs.push(uv(primitive, vertex));
                if has.tangents {
                    self.tangents.push(NO_TANGENT);
                }
                if has.colors {
                    self.colors.push(color(primitive, vertex));
                }
            }
        }
    }

    /// Adds what vertices have beside their positions; `transforms` are those of a vertex and of its normal.
    fn add_vertices(
        &mut self,
        primitive: &Primitive,
        shape: &PosedPrimitive<'_>,
        has: Has,
        mirrored: bool,
        transforms: impl Fn(usize) -> (Affine3A, Mat3),
    ) {
        for vertex in 0..self.positions.len() {
            let (transform, of_normal) = transforms(vertex);
            self.normals.push((of_normal * shape.normals[vertex]).try_normalize().unwrap_or(Vec3::ZERO));
            self.uvs.push(uv(primitive, vertex));
            if has.tangents {
                let tangent = shape.tangents.get(vertex).copied().unwrap_or(NO_TANGENT);
                let placed = transform.transform_vector3(tangent.truncate()).normalize_or(Vec3::X);
                let turned = if mirrored { -tangent.w } else { tangent.w };
                self.tangents.push(placed.extend(if turned < 0.0 { -1.0 } else { 1.0 }));
            }
            if has.colors {
                self.colors.push(color(primitive, vertex));
            }
        }
    }

    /// An exact surface at a place, with a mesh of some fineness; an earlier piece of it is used as far as it holds.
    pub(super) fn of_surface(
        placed: PlacedSurface,
        (fineness, meshes): (f64, &mut SharedMeshes),
        earlier: Option<Self>,
        has: Has,
    ) -> Self {
        let earlier = earlier.and_then(|piece| match &piece.source {
            Source::Surface(before, mesh, fine) if before.surface == placed.surface && *fine == fineness => {
                let (is_at_rest, mesh) = (before.world_from_surface == placed.world_from_surface, mesh.clone());
                Some((piece, is_at_rest, mesh))
            }
            _ => None,
        });
        let (mut piece, mesh) = match earlier {
            Some((piece, true, _)) => return piece,
            Some((piece, false, mesh)) => (piece, mesh),
            None => {
                let mesh = meshes.get(&placed.surface, fineness);
                let mut piece = Self::new(Source::Surface(Box::new(placed.clone()), mesh.clone(), fineness));
                piece.uvs = mesh.uvs.iter().map(|uv| [*uv; 2]).collect();
                let count = mesh.positions.len();
                piece.tangents = if has.tangents { vec![NO_TANGENT; count] } else { Vec::new() };
                piece.colors = if has.colors { vec![[1.0; 4]; count] } else { Vec::new() };
                piece.triangles.clone_from(&mesh.triangles);
                (piece, mesh)
            }
        };
        let place = placed.world_from_surface;
        piece.positions = mesh.positions.iter().map(|p| place.transform_point3(p.as_dvec3()).as_vec3()).collect();
        piece.normals = mesh.normals.iter().map(|n| place.transform_vector3(n.as_dvec3()).as_vec3()).collect();
        piece.source = Source::Surface(Box::new(placed), mesh, fineness);
        piece.finished()
    }

    /// True if it is a primitive at this place.
    pub(super) fn is_at(&self, place: &Place) -> bool {
        matches!(&self.source, Source::Primitive(own) if own == place)
    }

    /// The exact surface of the piece, if it has one.
    pub(super) fn surface(&self) -> Option<&PlacedSurface> {
        match &self.source {
            Source::Surface(placed, ..) => Some(placed),
            Source::Primitive(_) => None,
        }
    }

    /// The box around its triangles.
    pub(super) fn bounds(&self) -> Aabb {
        self.bounds
    }

    fn finished(mut self) -> Self {
        let corners = self.triangles.iter().flatten();
        self.bounds = Aabb::around(corners.map(|vertex| self.positions[*vertex as usize]));
        if self.parts.len() != self.triangles.len() {
            self.parts.clear();
            append_parts(&self.triangles, 0..self.positions.len() as u32, &mut self.parts);
        }
        self
    }

    /// Appends it to a scene as an object of that number, and returns its vertices and triangles there; `None` if it
    /// has no triangles.
    pub(super) fn append_to(&self, scene: &mut Scene, object: u32) -> Option<(Range<u32>, Range<u32>)> {
        if self.triangles.is_empty() {
            return None;
        }
        let (vertex, triangle) = (scene.positions.len() as u32, scene.triangles.len() as u32);
        scene.positions.extend_from_slice(&self.positions);
        scene.normals.extend_from_slice(&self.normals);
        scene.uvs.extend_from_slice(&self.uvs);
        scene.colors.extend_from_slice(&self.colors);
        scene.tangents.extend_from_slice(&self.tangents);
        scene.triangles.extend(self.triangles.iter().map(|corners| corners.map(|corner| corner + vertex)));
        scene.triangle_parts.extend(self.parts.iter().map(|part| part + vertex));
        scene.triangle_objects.resize(scene.triangles.len(), object);
        Some((vertex..scene.positions.len() as u32, triangle..scene.triangles.len() as u32))
    }

    /// Gives vertices without a usable normal the mean normal of their triangles.
    fn mend_normals(&mut self) {
        let Self { positions, normals, triangles, .. } = self;
        let broken = |normal: Vec3| normal == Vec3::ZERO || !normal.is_finite();
        let mut mended: HashMap<u32, Vec3> = HashMap::new();
        for triangle in triangles {
            if triangle.iter().any(|&vertex| broken(normals[vertex as usize])) {
                let corners = triangle.map(|vertex| positions[vertex as usize]);
                let normal = face_normal(corners).unwrap_or(Vec3::ZERO);
                for &mut vertex in triangle {
                    *mended.entry(vertex).or_insert(Vec3::ZERO) += normal;
                }
            }
        }
        for (vertex, sum) in mended {
            let normal = &mut normals[vertex as usize];
            if broken(*normal) {
                *normal = sum.try_normalize().unwrap_or(Vec3::Y);
            }
        }
        // Vertices that no triangle uses.
        for normal in normals {
            if broken(*normal) {
                *normal = Vec3::Y;
            }
        }
    }
}

fn uv(primitive: &Primitive, vertex: usize) -> [Vec2; 2] {
    let get = |set: &[Vec2]| set.get(vertex).copied().filter(|uv| uv.is_finite()).unwrap_or(Vec2::ZERO);
    [get(&primitive.uvs[0]), get(&primitive.uvs[1])]
}

fn color(primitive: &Primitive, vertex: usize) -> [f32; 4] {
    let color = primitive.colors.get(vertex).copied().unwrap_or([1.0; 4]);
    color.map(|c| if c.is_finite() { c.max(0.0) } else { 1.0 })
}

fn skin_matrix(joints: &[Mat4], indices: [u16; 4], weights: [f32; 4]) -> Affine3A {
    let mut sum = Mat4::ZERO;
    let mut total = 0.0;
    for (index, weight) in indices.into_iter().zip(weights) {
        if let Some(joint) = joints.get(index as usize).filter(|_| weight.is_finite() && weight > 0.0) {
            sum += *joint * weight;
            total += weight;
        }
    }
    if total > 1e-6 { Affine3A::from_mat4(sum * (1.0 / total)) } else { Affine3A::IDENTITY }
}

/// Maps normals as the transform maps surfaces; also for singular transforms, where that has a meaning.
fn normal_matrix(transform: &Affine3A) -> Mat3 {
    // The cofactor matrix: the inverse transpose times the determinant, without a division.
    let m = Mat3::from(transform.matrix3);
    let sign = if m.determinant() < 0.0 { -1.0 } else { 1.0 };
    Mat3::from_cols(m.y_axis.cross(m.z_axis), m.z_axis.cross(m.x_axis), m.x_axis.cross(m.y_axis)) * sign
}

fn face_normal([a, b, c]: [Vec3; 3]) -> Option<Vec3> {
    (b - a).cross(c - a).try_normalize()
}
