//! Steady parts of a virtual mesh, which can be kept while the eye moves a little (Popescu, Sacks, Mei 2006, section
//! VI: the projections of static vertices are reused with varying weights): the appearances of points as polynomials,
//! and the pieces that are drawn between these.
//!
//! Edges are divided as they are seen from one place in the middle of where the eye may be. Pieces some of whose
//! corners may come and go are left: they are divided further as the eye sees them, like triangles of their own; but
//! for edges between steady corners, so that both of their sides agree.

mod from_middle;
mod making;
mod meshes;
mod search;
mod source;

pub use meshes::SteadyMeshes;
pub use source::{Steadiness, SteadyField, SteadyPath, SteadySource};

use super::divider::{MissedBoundary, WORK_A_PIECE};
use super::edge::EdgeRule;
use super::mesh::VirtualMesh;
use super::object::VirtualObject;
use super::quality::{Ends, MeshQuality};
use super::weld::WeldedObject;
use catoptric_core::clock::Stopwatch;
use catoptric_core::progress::{Cancelled, Stage};
use catoptric_core::scene::PicturePoint;
use catoptric_engine::raster::DrawTriangle;
use making::steady_mesh;
use meshes::SteadyMesh;
use search::KnownPointsProjector;
use std::sync::Arc;

/// The steady part of an object's mesh in a view.
pub(super) struct SteadyFrame<'a> {
    mesh: Arc<SteadyMesh>,
    source: &'a dyn SteadySource,
    at: SteadyPath<'a>,
    places: Vec<PicturePoint>,
    /// Work for making the mesh.
    work: u64,
    /// Time for finding the places.
    blend_ms: f64,
}

/// The result of looking for the steady part of an object's mesh.
pub(super) enum SteadyPart<'a> {
    None,
    /// Finding it takes more than it may.
    TooMuch,
    Found(Box<SteadyFrame<'a>>),
}

impl<'a> SteadyPart<'a> {
    /// The steady part of an object's mesh, found with at most the allowed work.
    pub(super) fn of(
        source: Option<&'a dyn SteadySource>,
        object: &VirtualObject,
        quality: &MeshQuality,
        allowed: u64,
        stage: &Stage<'_>,
    ) -> Result<Self, Cancelled> {
        if object.least_segment > 0.0 {
            return Ok(Self::None);
        }
        let Some((source, at)) = source.and_then(|source| Some((source, source.on_path(object.path)?))) else {
            return Ok(Self::None);
        };
        // Pieces on which appearances end are not steady.
        let quality = MeshQuality { picture: at.scale_from_middle, ends: Ends::Followed, ..*quality };
        let rule = EdgeRule::new(&quality, &object.last_reflector, object.scene_size);
        let found = steady_mesh((source, &at), object, rule, allowed, stage)?;
        let Some((mesh, work)) = found else { return Ok(Self::TooMuch) };
        let watch = Stopwatch::new();
        let places = mesh.places(&at.weights, (&at.view, &at.scale), stage)?;
        let blend_ms = watch.elapsed_ms();
        // If the mirror reaches behind the picture's plane, some places may lie behind it.
        let all_before = places.iter().all(|place| place.w > 0.0);
        Ok(if all_before {
            Self::Found(Box::new(SteadyFrame { mesh, source, at, places, work, blend_ms }))
        } else {
            Self::None
        })
    }
}

impl SteadyFrame<'_> {
    /// A projector that answers for the steady points of the pieces that are left, and passes on all others.
    pub(super) fn projector<'s, P: ?Sized>(&'s self, inner: &'s P) -> KnownPointsProjector<'s, P> {
        KnownPointsProjector::new(inner, (self.source, &self.at), &self.mesh.left.known)
    }

    /// Work that it counts as, whether it was known or not; its pieces are drawn, too.
    pub(super) fn work(&self) -> u64 {
        self.work + WORK_A_PIECE * self.mesh.rows.len() as u64
    }

    /// The pieces that are looked at.
    pub(super) fn left(&self) -> &WeldedObject {
        &self.mesh.left.welded
    }

    /// The split priorities of the edges of such a piece, as far as they are known; else not a number.
    pub(super) fn priorities(&self, piece: u32) -> [f32; 3] {
        self.mesh.left.is_fixed[piece as usize].map(|is_fixed| if is_fixed { 0.0 } else { f32::NAN })
    }

    /// True unless a boundary is said to be missed on an edge that is not divided from the other side either.
    pub(super) fn may_be_missed(&self, boundary: &MissedBoundary) -> bool {
        boundary.side.is_none_or(|side| !self.mesh.left.is_fixed[boundary.triangle as usize][side])
    }

    /// Turns the mesh of the pieces that were left into the mesh of the whole object.
    pub(super) fn complete(&self, mesh: &mut VirtualMesh, object: &VirtualObject) {
        for (triangle, corners) in mesh.triangles.iter_mut().zip(&mut mesh.corners) {
            let (source, [a, b, c]) = self.mesh.left.sources[(triangle.source - object.first_triangle) as usize];
            triangle.source = object.first_triangle + source;
            *corners = corners.map(|weights| a + (b - a) * weights.x + (c - a) * weights.y);
        }
        let first = mesh.vertices.len() as u32;
        mesh.vertices.extend_from_slice(&self.places);
        mesh.triangles.extend(self.mesh.sources.iter().zip(&self.mesh.rows).map(|(source, rows)| DrawTriangle {
            vertices: rows.map(|row| first + row),
            source: object.first_triangle + source,
            group: 0,
            patch: 0,
            alpha_tested: object.alpha_tested,
        }));
        mesh.corners.extend_from_slice(&self.mesh.weights);
        mesh.steady_points = self.places.len() as u64;
        mesh.blend_ms = self.blend_ms;
    }
}
