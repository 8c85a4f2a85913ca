//! Virtual geometry: the triangles of an object where they appear after a specular path.
//!
//! Vertices are projected; triangles whose edges would be drawn too straight, or of which only a part appears, are
//! divided. Whether an edge is divided depends on its two ends alone, so neighbours agree and no crack opens. The
//! appearances at the ends of an edge belong together when they have the same focal index and each predicts the
//! other by its path Jacobian; so concave reflectors, which show a point several times, need no other book-keeping.

mod edge;
mod fold;
mod weld;

pub use weld::WeldedObject;

use super::{Projection, VertexProjector};
use crate::math::Aabb;
use crate::parallel;
use crate::raster::DrawTriangle;
use crate::scene::{PicturePoint, View};
use edge::EdgeRule;
use glam::{Vec2, Vec3};

/// How finely virtual geometry is made.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct MeshQuality {
    /// Edges are divided until their middles are this near to where they belong, in pixels.
    pub edge_error_px: f32,
    /// Edges of which one end does not appear are divided down to this size, in pixels.
    pub piece_px: f32,
    /// The picture: what appears outside it is not divided.
    pub picture: PictureScale,
    /// No more pieces than this are made of one object on one path.
    pub max_pieces: usize,
}

/// How places in a picture and path lengths make picture points.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct PictureScale {
    size_px: Vec2,
    /// Pixels per unit of the tangent of the angle to the view axis; none in orthographic views.
    focal_px: Option<f32>,
}

impl PictureScale {
    /// The scale of a view's picture.
    pub fn new(view: &View) -> Self {
        let size_px = Vec2::new(view.width as f32, view.height as f32);
        let focal_px = match view.projection {
            crate::scene::Projection::Perspective { fov_y } => Some(size_px.y * 0.5 / (fov_y * 0.5).tan()),
            crate::scene::Projection::Orthographic { .. } => None,
        };
        Self { size_px, focal_px }
    }

    /// The depth of the place that lies the path's length away on the view ray.
    #[inline]
    fn depth(&self, one: &Projection) -> f32 {
        match self.focal_px {
            Some(focal_px) => {
                let from_axis = (one.image_px - self.size_px * 0.5) / focal_px;
                one.path_length / (1.0 + from_axis.length_squared()).sqrt()
            }
            None => one.path_length,
        }
    }

    /// What depths are divided by: the homogeneous coordinate.
    #[inline]
    fn w(&self, one: &Projection) -> f32 {
        if self.focal_px.is_some() { self.depth(one) } else { 1.0 }
    }

    fn point(&self, one: &Projection) -> PicturePoint {
        let (w, depth) = (self.w(one), self.depth(one));
        PicturePoint { xy: one.image_px * w, w, depth }
    }
}

/// Pieces of an object's triangles where they appear.
#[derive(Clone, Debug, Default)]
pub struct VirtualMesh {
    /// Three corners a piece.
    pub vertices: Vec<PicturePoint>,
    /// The pieces; their groups are left at 0.
    pub triangles: Vec<DrawTriangle>,
    /// Weights of the source's second and third vertex at the corners.
    pub corners: Vec<[Vec2; 3]>,
    /// Points projected to make it.
    pub points_projected: u64,
    /// Source triangles that were left undivided because there were too many pieces.
    pub unfinished: u64,
}

impl VirtualMesh {
    /// Appends the pieces to those of other meshes.
    pub fn append_to(
        &self,
        vertices: &mut Vec<PicturePoint>,
        triangles: &mut Vec<DrawTriangle>,
        corners: &mut Vec<[Vec2; 3]>,
    ) {
        let first = vertices.len() as u32;
        vertices.extend_from_slice(&self.vertices);
        triangles.extend(
            self.triangles
                .iter()
                .map(|triangle| DrawTriangle { vertices: triangle.vertices.map(|v| v + first), ..*triangle }),
        );
        corners.extend_from_slice(&self.corners);
    }

    fn append(&mut self, other: &Self) {
        other.append_to(&mut self.vertices, &mut self.triangles, &mut self.corners);
        self.points_projected += other.points_projected;
        self.unfinished += other.unfinished;
    }
}

/// What is projected on which path.
#[derive(Clone, Copy)]
pub struct VirtualObject<'a> {
    /// The object's points and triangles.
    pub welded: &'a WeldedObject,
    /// The number of its first triangle in the scene.
    pub first_triangle: u32,
    /// Whether its triangles have holes.
    pub alpha_tested: bool,
    /// The path, an index of the projector's.
    pub path: u32,
    /// The box around the path's last reflector.
    pub last_reflector: Aabb,
    /// The size of the scene.
    pub scene_size: f32,
}

/// Points that are projected at once.
const POINTS_AT_ONCE: usize = 512;
/// Triangles that are worked on at once.
const TRIANGLES_AT_ONCE: usize = 64;

/// Makes the virtual mesh of an object on one path.
pub fn virtual_mesh<P: VertexProjector + ?Sized>(
    projector: &P,
    object: &VirtualObject<'_>,
    quality: &MeshQuality,
) -> VirtualMesh {
    let welded = object.welded;
    let chunks = welded.points.len().div_ceil(POINTS_AT_ONCE);
    let projected = parallel::map_collect(chunks, |chunk| {
        let range = chunk * POINTS_AT_ONCE..((chunk + 1) * POINTS_AT_ONCE).min(welded.points.len());
        let mut found = Vec::new();
        let mut ends = Vec::with_capacity(range.len());
        for &point in &welded.points[range] {
            projector.project_on(object.path, point, &mut found);
            ends.push(found.len() as u32);
        }
        (found, ends)
    });
    let mut found: Vec<Projection> = Vec::new();
    let mut ends = Vec::with_capacity(welded.points.len());
    for (chunk, chunk_ends) in projected {
        let first = found.len() as u32;
        found.extend(chunk);
        ends.extend(chunk_ends.into_iter().map(|end| end + first));
    }
    let chunks = welded.triangles.len().div_ceil(TRIANGLES_AT_ONCE);
    let most = (quality.max_pieces / chunks.max(1)).max(2000);
    let pieces = parallel::map_collect(chunks, |chunk| {
        let range = chunk * TRIANGLES_AT_ONCE..((chunk + 1) * TRIANGLES_AT_ONCE).min(welded.triangles.len());
        let mut divider = Divider {
            projector,
            object,
            rule: EdgeRule::new(quality, &object.last_reflector, object.scene_size),
            source: 0,
            most,
            scratch: Vec::new(),
            mesh: VirtualMesh::default(),
        };
        for triangle in range {
            divider.source = object.first_triangle + triangle as u32;
            let corners = welded.triangles[triangle].map(|point| {
                let start = if point == 0 { 0 } else { ends[point as usize - 1] as usize };
                let appearances = &found[start..ends[point as usize] as usize];
                (welded.points[point as usize], appearances)
            });
            let weights = [Vec2::ZERO, Vec2::X, Vec2::Y];
            let corner =
                |k: usize| Corner { position: corners[k].0, weights: weights[k], appearances: corners[k].1.into() };
            divider.divide(&[corner(0), corner(1), corner(2)], 0);
        }
        divider.mesh
    });
    let mut mesh = VirtualMesh { points_projected: welded.points.len() as u64, ..VirtualMesh::default() };
    for piece in &pieces {
        mesh.append(piece);
    }
    mesh
}

/// Appearances of a point: mostly one.
#[derive(Clone, Debug)]
enum Appearances {
    Few([Projection; 2], u8),
    Many(Box<[Projection]>),
}

impl From<&[Projection]> for Appearances {
    fn from(list: &[Projection]) -> Self {
        match list {
            [] => Self::Few([Projection::default(); 2], 0),
            [one] => Self::Few([*one; 2], 1),
            [one, other] => Self::Few([*one, *other], 2),
            many => Self::Many(many.into()),
        }
    }
}

/// A corner of a piece.
#[derive(Clone, Debug)]
struct Corner {
    position: Vec3,
    /// Weights of the source's second and third vertex.
    weights: Vec2,
    appearances: Appearances,
}

impl Corner {
    fn appearances(&self) -> &[Projection] {
        match &self.appearances {
            Appearances::Few(list, count) => &list[..*count as usize],
            Appearances::Many(list) => list,
        }
    }
}

/// Pieces are divided this many times at the most.
const MAX_DEPTH: u32 = 40;

struct Divider<'a, P: VertexProjector + ?Sized> {
    projector: &'a P,
    object: &'a VirtualObject<'a>,
    rule: EdgeRule,
    /// The triangle of the scene.
    source: u32,
    most: usize,
    scratch: Vec<Projection>,
    mesh: VirtualMesh,
}

impl<P: VertexProjector + ?Sized> Divider<'_, P> {
    fn divide(&mut self, corners: &[Corner; 3], depth: u32) {
        let [a, b, c] = corners;
        if depth >= MAX_DEPTH || self.mesh.triangles.len() > self.most {
            self.mesh.unfinished += 1;
            return self.emit(corners);
        }
        let split = |one: &Corner, other: &Corner| {
            self.rule.divides(one.position, one.appearances(), other.position, other.appearances())
        };
        // Edge k is opposite to corner k.
        let flags = [split(b, c), split(c, a), split(a, b)];
        match flags {
            [false, false, false] => self.emit(corners),
            [true, true, true] => {
                let (bc, ca, ab) = (self.middle(b, c), self.middle(c, a), self.middle(a, b));
                self.divide(&[a.clone(), ab.clone(), ca.clone()], depth + 1);
                self.divide(&[ab.clone(), b.clone(), bc.clone()], depth + 1);
                self.divide(&[ca.clone(), bc.clone(), c.clone()], depth + 1);
                self.divide(&[bc, ca, ab], depth + 1);
            }
            _ => {
                // Turned so that edge 0 is divided, and edge 1 is not unless edge 2 is too.
                let turn = match flags {
                    [true, false, _] => 0,
                    [false, _, true] => 2,
                    _ => 1,
                };
                let [a, b, c] = [0, 1, 2].map(|k| &corners[(k + turn) % 3]);
                let bc = self.middle(b, c);
                if flags[(turn + 2) % 3] {
                    let ab = self.middle(a, b);
                    self.divide(&[ab.clone(), b.clone(), bc.clone()], depth + 1);
                    self.divide(&[a.clone(), ab, bc.clone()], depth + 1);
                    self.divide(&[a.clone(), bc, c.clone()], depth + 1);
                } else {
                    self.divide(&[a.clone(), b.clone(), bc.clone()], depth + 1);
                    self.divide(&[a.clone(), bc, c.clone()], depth + 1);
                }
            }
        }
    }

    fn middle(&mut self, a: &Corner, b: &Corner) -> Corner {
        // Sums do not depend on the order: neighbours find the same point.
        let position = (a.position + b.position) * 0.5;
        self.scratch.clear();
        self.projector.project_on(self.object.path, position, &mut self.scratch);
        self.mesh.points_projected += 1;
        let appearances = self.scratch.as_slice().into();
        Corner { position, weights: (a.weights + b.weights) * 0.5, appearances }
    }

    /// Draws every appearance that all three corners share, and closes folds.
    fn emit(&mut self, corners: &[Corner; 3]) {
        let [a, b, c] = corners;
        let ends = |one: &Corner, other: &Corner| other.position - one.position;
        for first in a.appearances() {
            let Some(second) = self.rule.partner(first, a.appearances(), b.appearances(), ends(a, b)) else { continue };
            let Some(third) = self.rule.partner(first, a.appearances(), c.appearances(), ends(a, c)) else { continue };
            let other = self.rule.partner(second, b.appearances(), c.appearances(), ends(b, c));
            if other.is_some_and(|other| std::ptr::eq(other, third)) {
                self.push([(first, a.weights), (second, b.weights), (third, c.weights)]);
            }
        }
        for k in 0..3 {
            let [one, other, missing] = [0, 1, 2].map(|step| &corners[(k + step) % 3]);
            for [p, q, r, s] in fold::gaps(&self.rule, one, other, missing) {
                self.push([p, q, r]);
                self.push([p, r, s]);
            }
        }
    }

    fn push(&mut self, corners: [(&Projection, Vec2); 3]) {
        let mesh = &mut self.mesh;
        let first = mesh.vertices.len() as u32;
        mesh.vertices.extend(corners.map(|(projection, _)| self.rule.picture().point(projection)));
        let vertices = [first, first + 1, first + 2];
        let alpha_tested = self.object.alpha_tested;
        mesh.triangles.push(DrawTriangle { vertices, source: self.source, group: 0, alpha_tested });
        mesh.corners.push(corners.map(|(_, weights)| weights));
    }
}
