//! Virtual geometry: the triangles of an object where they appear after a specular path.
//!
//! Vertices are projected; triangles whose edges would be drawn too straight, or of which only a part appears, are
//! divided. Whether an edge is divided depends on its two ends alone, so neighbours agree and no crack opens. The
//! appearances at the ends of an edge belong together when they have the same focal index and each predicts the
//! other by its path Jacobian; so concave reflectors, which show a point several times, need no other book-keeping.

mod edge;
mod weld;

pub use weld::WeldedObject;

use super::{Projection, VertexProjector};
use crate::math::Aabb;
use crate::parallel;
use crate::raster::DrawTriangle;
use crate::scene::{PicturePoint, View};
use edge::{EdgeRule, nearest};
use glam::{Vec2, Vec3};

/// How finely virtual geometry is made.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct MeshQuality {
    /// Edges are divided until their middles are this near to where they belong, in pixels.
    pub edge_error_px: f32,
    /// Edges shorter than this are not divided, in pixels; those of which one end does not appear, than eight times this.
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
    /// Pieces that were left undivided because there were too many pieces.
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
    /// Appearances with shorter last segments than this are left out: 0, but for the path's last reflector itself.
    ///
    /// The points of a tessellation lie a little off its surface, and would appear where they touch it.
    pub least_segment: f32,
    /// The box around the path's last reflector.
    pub last_reflector: Aabb,
    /// The size of the scene.
    pub scene_size: f32,
}

impl VirtualObject<'_> {
    fn project<P: VertexProjector + ?Sized>(&self, projector: &P, point: Vec3, found: &mut Vec<Projection>) {
        let start = found.len();
        projector.project_on(self.path, point, found);
        if self.least_segment > 0.0 {
            let mut kept = start;
            for index in start..found.len() {
                if found[index].last_segment >= self.least_segment {
                    found[kept] = found[index];
                    kept += 1;
                }
            }
            found.truncate(kept);
        }
    }
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
            object.project(projector, point, &mut found);
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

/// The end of an appearance on an edge is found to this power of a half of the edge.
const END_STEPS: u32 = 8;

/// Projected points that count as a piece, where the number of pieces is limited.
const POINTS_A_PIECE: usize = 4;

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
        let spent = self.mesh.triangles.len().max(self.mesh.points_projected as usize / POINTS_A_PIECE);
        if depth >= MAX_DEPTH || spent > self.most {
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
        self.object.project(self.projector, position, &mut self.scratch);
        self.mesh.points_projected += 1;
        let appearances = self.scratch.as_slice().into();
        Corner { position, weights: (a.weights + b.weights) * 0.5, appearances }
    }

    /// Where an appearance of `a` ends on the way to `b`, with the weights there.
    ///
    /// In a fold both of its appearances end at the same place: half-way between them.
    fn end_of(&mut self, one: Projection, a: &Corner, b: &Corner) -> (Projection, Vec2) {
        let way = b.position - a.position;
        let mut merging = self.rule.merging(&one, a.appearances(), b.appearances(), way).copied();
        let (mut near, mut far) = (0.0f32, 1.0f32);
        let mut last = one;
        for _ in 0..END_STEPS {
            let share = (near + far) * 0.5;
            self.scratch.clear();
            self.object.project(self.projector, a.position.lerp(b.position, share), &mut self.scratch);
            self.mesh.points_projected += 1;
            match self.rule.continued(&last, &self.scratch, way * (share - near)) {
                Some(found) => {
                    last = *found;
                    near = share;
                    if merging.is_some() {
                        let other_sheet = |other: &&Projection| other.focal_index.abs_diff(last.focal_index) == 1;
                        merging = nearest(&last, self.scratch.iter().filter(other_sheet)).copied().or(merging);
                    }
                }
                None => far = share,
            }
        }
        if let Some(other) = merging {
            last.image_px = (last.image_px + other.image_px) * 0.5;
            last.path_length = (last.path_length + other.path_length) * 0.5;
        }
        (last, a.weights.lerp(b.weights, near))
    }

    /// Draws every appearance of the corners: whole where all three share it, cut where it ends where some do.
    fn emit(&mut self, corners: &[Corner; 3]) {
        for from in 0..3 {
            for index in 0..corners[from].appearances().len() {
                self.emit_appearance(corners, from, index);
            }
        }
    }

    /// Draws an appearance, unless an earlier corner has it too.
    fn emit_appearance(&mut self, corners: &[Corner; 3], from: usize, index: usize) {
        let own = &corners[from];
        let one = &own.appearances()[index];
        let mut shared: [Option<&Projection>; 3] = [None; 3];
        shared[from] = Some(one);
        for (k, other) in corners.iter().enumerate().filter(|(k, _)| *k != from) {
            let step = other.position - own.position;
            let partner = self.rule.partner(one, own.appearances(), other.appearances(), step);
            if partner.is_some() && k < from {
                return; // drawn from there
            }
            shared[k] = partner;
        }
        if let [Some(a), Some(b), Some(c)] = shared {
            let all = [a, b, c];
            let (second, third) = ((from + 1) % 3, (from + 2) % 3);
            let [here, there] = [&corners[second], &corners[third]];
            let step = there.position - here.position;
            let partner = self.rule.partner(all[second], here.appearances(), there.appearances(), step);
            if partner.is_some_and(|partner| std::ptr::eq(partner, all[third])) {
                self.push([(a, corners[0].weights), (b, corners[1].weights), (c, corners[2].weights)]);
            }
            return;
        }
        // The border of what appears, around the triangle.
        let mut border: [(Projection, Vec2); 4] = [(*one, own.weights); 4];
        let mut count = 0;
        for k in 0..3 {
            let next = (k + 1) % 3;
            if let Some(here) = shared[k] {
                border[count] = (*here, corners[k].weights);
                count += 1;
                if shared[next].is_none() {
                    border[count] = self.end_of(*here, &corners[k], &corners[next]);
                    count += 1;
                }
            } else if let Some(there) = shared[next] {
                border[count] = self.end_of(*there, &corners[next], &corners[k]);
                count += 1;
            }
        }
        for second in 1..count.saturating_sub(1) {
            let [a, b, c] = [&border[0], &border[second], &border[second + 1]];
            self.push([(&a.0, a.1), (&b.0, b.1), (&c.0, c.1)]);
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

#[cfg(test)]
mod tests;
