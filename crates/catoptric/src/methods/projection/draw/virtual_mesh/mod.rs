//! Virtual geometry: the triangles of an object where they appear after a specular path.
//!
//! Vertices are projected; triangles whose edges would be drawn too straight, or of which only a part appears, are
//! divided. Whether an edge is divided depends on its two ends alone, so neighbours agree and no crack opens. The
//! appearances at the ends of an edge belong together when they have the same focal index and each predicts the
//! other by its path Jacobian; so concave reflectors, which show a point several times, need no other book-keeping.

mod divider;
mod edge;
mod weld;

pub use weld::WeldedObject;

use crate::math::Aabb;
use crate::methods::projector::{Projection, Projections, VertexProjector};
use crate::parallel;
use crate::progress::{Cancelled, Stage};
use crate::raster::DrawTriangle;
use crate::scene::{PicturePoint, View};
use divider::{Divider, ForcedEdges, MissedBoundary};
use edge::EdgeRule;
use glam::{Vec2, Vec3};
use std::collections::HashSet;
use std::ops::Range;

/// Fineness of virtual geometry.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct MeshQuality {
    /// Edges are divided until their middles are this near to where they belong, in pixels.
    pub edge_error_px: f32,
    /// Edges shorter than this are not divided, in pixels; those on which an appearance ends, than 32 times this.
    pub piece_px: f32,
    /// The picture: what appears outside it is not divided.
    pub picture: PictureScale,
    /// About so many pieces are made of one object on one path at the most, or 6,000 of one triangle; those
    /// that need it least are left.
    pub max_pieces: usize,
}

/// No more pieces than this are made of one object on one path, as a rule. A bound on memory; chosen, not measured.
const MAX_PIECES: usize = 200_000;

impl MeshQuality {
    /// For a view's picture, by the finest edges' error and the smallest pieces, both in pixels.
    pub fn new(view: &View, edge_error_px: f32, piece_px: f32) -> Self {
        Self { edge_error_px, piece_px, picture: PictureScale::new(view), max_pieces: MAX_PIECES }
    }
}

/// Picture points from places in a picture and path lengths.
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

    /// Divisor of depths: the homogeneous coordinate.
    #[inline]
    fn w(&self, one: &Projection) -> f32 {
        if self.focal_px.is_some() { self.depth(one) } else { 1.0 }
    }

    /// True if places all lie beyond one side of the picture.
    fn is_beside<const COUNT: usize>(&self, places: [Vec2; COUNT]) -> bool {
        let beyond = |is: &dyn Fn(Vec2) -> bool| places.into_iter().all(is);
        beyond(&|place| place.x < 0.0)
            || beyond(&|place| place.y < 0.0)
            || beyond(&|place| place.x > self.size_px.x)
            || beyond(&|place| place.y > self.size_px.y)
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
        self.append_some_to(0..self.triangles.len(), vertices, triangles, corners);
    }

    fn append_some_to(
        &self,
        pieces: Range<usize>,
        vertices: &mut Vec<PicturePoint>,
        triangles: &mut Vec<DrawTriangle>,
        corners: &mut Vec<[Vec2; 3]>,
    ) {
        // Three vertices a piece, in their order.
        let (first, from) = (vertices.len() as u32, 3 * pieces.start as u32);
        vertices.extend_from_slice(&self.vertices[3 * pieces.start..3 * pieces.end]);
        let moved = |triangle: &DrawTriangle| {
            let vertices = triangle.vertices.map(|vertex| vertex - from + first);
            DrawTriangle { vertices, ..*triangle }
        };
        triangles.extend(self.triangles[pieces.clone()].iter().map(moved));
        corners.extend_from_slice(&self.corners[pieces]);
    }
}

/// A path and the objects projected on it.
#[derive(Clone, Copy)]
pub struct VirtualObject<'a> {
    /// The object's points and triangles.
    pub welded: &'a WeldedObject,
    /// The number of its first triangle in the scene.
    pub first_triangle: u32,
    /// True if its triangles have holes.
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
    /// Appends points with all their appearances.
    fn project<P: VertexProjector + ?Sized>(&self, projector: &P, points: &[Vec3], found: &mut Projections) {
        let first = found.point_count();
        projector.project_on(self.path, points, found);
        self.retain_distant(first, found);
    }

    /// Appends a point with the appearance that continues `one`, and perhaps others.
    fn follow<P: VertexProjector + ?Sized>(
        &self,
        projector: &P,
        one: &Projection,
        point: Vec3,
        found: &mut Projections,
    ) {
        let first = found.point_count();
        projector.follow(one, point, found);
        self.retain_distant(first, found);
    }

    fn retain_distant(&self, first: usize, found: &mut Projections) {
        if self.least_segment > 0.0 {
            found.retain_from(first, |one| one.last_segment >= self.least_segment);
        }
    }
}

/// Points that are projected at once. A size for threads; chosen, not measured.
const POINTS_AT_ONCE: usize = 512;
/// Triangles that are worked on at once. A size for threads; chosen, not measured.
const TRIANGLES_AT_ONCE: usize = 8;

/// A triangle may become so many pieces however many triangles its object has. Chosen, not measured.
const MIN_BUDGET: usize = 6000;

/// Triangles are looked at again, because of what was found in their neighbours, at most this often. A bound on time;
/// chosen, not measured.
const MAX_ROUNDS: usize = 4;

/// Makes the virtual mesh of an object on one path, as a part of a step of a stage.
///
/// # Errors
/// [`Cancelled`].
pub fn virtual_mesh<P: VertexProjector + ?Sized>(
    projector: &P,
    object: &VirtualObject<'_>,
    quality: &MeshQuality,
    stage: &Stage<'_>,
) -> Result<VirtualMesh, Cancelled> {
    let welded = object.welded;
    let chunks: Vec<&[Vec3]> = welded.points.chunks(POINTS_AT_ONCE).collect();
    let projected = parallel::map_within(stage, chunks.len(), |chunk| {
        let mut found = Projections::default();
        object.project(projector, chunks[chunk], &mut found);
        found
    })?;
    let appearances_of = |point: u32| {
        let point = point as usize;
        projected[point / POINTS_AT_ONCE].of(point % POINTS_AT_ONCE)
    };
    let most = (quality.max_pieces / welded.triangles.len().max(1)).max(MIN_BUDGET);
    let mut forced = ForcedEdges::default();
    let mut wanted: Vec<u32> = (0..welded.triangles.len() as u32).collect();
    let mut meshes: Vec<VirtualMesh> = Vec::new();
    // Of every triangle, in which mesh its pieces are, and where.
    let mut pieces_of: Vec<(u32, Range<usize>)> = vec![(0, 0..0); welded.triangles.len()];
    let mut mesh = VirtualMesh { points_projected: welded.points.len() as u64, ..VirtualMesh::default() };
    for _ in 0..MAX_ROUNDS {
        let chunks: Vec<&[u32]> = wanted.chunks(TRIANGLES_AT_ONCE).collect();
        let divided = parallel::map_within(stage, chunks.len(), |chunk| {
            let rule = EdgeRule::new(quality, &object.last_reflector, object.scene_size);
            let mut divider = Divider::new(projector, object, rule, most, &forced);
            let mut ends = Vec::with_capacity(chunks[chunk].len());
            for &triangle in chunks[chunk] {
                let points = welded.triangles[triangle as usize];
                let corners = points.map(|point| (welded.points[point as usize], appearances_of(point)));
                ends.push(divider.triangle(triangle, corners));
            }
            (divider.finish(), ends)
        })?;
        let mut dips = Vec::new();
        for (((pieces, found), ends), triangles) in divided.into_iter().zip(&chunks) {
            let starts = std::iter::once(&0).chain(&ends);
            for ((&triangle, &start), &end) in triangles.iter().zip(starts).zip(&ends) {
                pieces_of[triangle as usize] = (meshes.len() as u32, start..end);
            }
            mesh.points_projected += pieces.points_projected;
            mesh.unfinished += pieces.unfinished;
            meshes.push(pieces);
            dips.extend(found);
        }
        dips.retain(|dip| forced.add(dip));
        wanted = welded.beside(&dips);
        if wanted.is_empty() {
            break;
        }
    }
    let VirtualMesh { vertices, triangles, corners, .. } = &mut mesh;
    for (number, range) in pieces_of {
        if !range.is_empty() {
            meshes[number as usize].append_some_to(range, vertices, triangles, corners);
        }
    }
    Ok(mesh)
}

impl WeldedObject {
    /// The triangles on both sides of dips, sorted.
    fn beside(&self, dips: &[MissedBoundary]) -> Vec<u32> {
        let mut found: Vec<u32> = dips.iter().map(|dip| dip.triangle).collect();
        let side_of = |dip: &MissedBoundary| {
            let points = self.triangles[dip.triangle as usize];
            dip.side.map(|side| sorted([points[(side + 1) % 3], points[(side + 2) % 3]]))
        };
        let sides: HashSet<[u32; 2]> = dips.iter().filter_map(side_of).collect();
        if !sides.is_empty() {
            for (triangle, [a, b, c]) in self.triangles.iter().enumerate() {
                if [[*a, *b], [*b, *c], [*c, *a]].into_iter().any(|side| sides.contains(&sorted(side))) {
                    found.push(triangle as u32);
                }
            }
        }
        found.sort_unstable();
        found.dedup();
        found
    }
}

fn sorted([a, b]: [u32; 2]) -> [u32; 2] {
    [a.min(b), a.max(b)]
}

#[cfg(test)]
mod tests;
