//! The making of what is steady of an object.

use super::from_middle::{NOWHERE, SteadyCorner, SteadyDivider, SteadyPiece, SteadyPieces, SteadyPoints};
use super::meshes::{KnownMesh, LeftPieces, MadeOf, SteadyMesh};
use super::search::SteadySearch;
use super::source::{SteadyPath, SteadySource};
use crate::draw::virtual_mesh::edge::EdgeRule;
use crate::draw::virtual_mesh::object::VirtualObject;
use crate::draw::virtual_mesh::portions::triangles_at_once;
use crate::find::tetrahedron_form::{FormBlock, LANES, TetrahedronForm};
use crate::find::work::SharedWork;
use catoptric_core::parallel;
use catoptric_core::progress::{Cancelled, Stage};
use catoptric_engine::method::projector::Projection;
use glam::Vec3;
use std::collections::HashMap;
use std::ops::Range;
use std::sync::Arc;

/// Points that a thread takes at once. A size for threads; chosen, not measured.
const POINTS_AT_ONCE: usize = 256;

/// The steady part of an object's mesh, with the work of making it, if that is no more than is allowed.
///
/// # Errors
/// [`Cancelled`].
pub(super) fn steady_mesh(
    source: (&dyn SteadySource, &SteadyPath<'_>),
    object: &VirtualObject,
    rule: EdgeRule,
    allowed: u64,
    stage: &Stage<'_>,
) -> Result<Option<(Arc<SteadyMesh>, u64)>, Cancelled> {
    let made_of = MadeOf { welded: object.welded.clone(), rule };
    let (meshes, key) = (source.1.meshes, (source.1.kept_path, object.object));
    let known = meshes.locked().get(&key).filter(|known| known.made_of.is_same(&made_of)).cloned();
    let KnownMesh { mesh, work, .. } = match known.filter(|known| known.tells(allowed)) {
        Some(known) => known,
        None => {
            let made = made(source, made_of, allowed, stage)?;
            meshes.locked().insert(key, made.clone());
            made
        }
    };
    Ok(mesh.filter(|_| work <= allowed).map(|mesh| (mesh, work)))
}

/// An object's points with how they appear.
struct FoundPoints {
    chunks: Vec<FoundChunk>,
    /// The number of polynomials before each chunk.
    forms_before: Vec<u32>,
    /// The number of all polynomials.
    form_count: u32,
}

struct FoundChunk {
    points: SteadyPoints,
    /// The row of each point, and the range of its appearances from the middle.
    places: Vec<(u32, Range<u32>)>,
}

impl FoundPoints {
    /// Looks for points until there is too much work.
    fn new(
        search: &SteadySearch<'_>,
        points: &[Vec3],
        work: &SharedWork,
        stage: &Stage<'_>,
    ) -> Result<Self, Cancelled> {
        let parts: Vec<&[Vec3]> = points.chunks(POINTS_AT_ONCE).collect();
        let chunks = parallel::map_within(stage, parts.len(), |part| {
            let (mut points, mut share) = (SteadyPoints::default(), work.share());
            let wanted = parts[part].iter().take_while(|_| !share.is_too_much());
            let places = wanted.map(|point| points.add(search.steadiness(*point))).collect();
            FoundChunk { points, places }
        })?;
        let (mut forms_before, mut form_count) = (Vec::with_capacity(chunks.len()), 0);
        for chunk in &chunks {
            forms_before.push(form_count);
            form_count += chunk.points.forms.len() as u32;
        }
        Ok(Self { chunks, forms_before, form_count })
    }

    /// The row of a point, and its appearances from the middle.
    fn of(&self, point: u32) -> (u32, &[Projection]) {
        let (chunk, number) = (point as usize / POINTS_AT_ONCE, point as usize % POINTS_AT_ONCE);
        let FoundChunk { points, places } = &self.chunks[chunk];
        let (row, range) = &places[number];
        let row = if *row < NOWHERE { self.forms_before[chunk] + row } else { *row };
        (row, &points.appearances[range.start as usize..range.end as usize])
    }

    fn into_forms(self) -> Vec<TetrahedronForm> {
        self.chunks.into_iter().flat_map(|chunk| chunk.points.forms).collect()
    }
}

/// Makes the mesh of an object on a path, if no more work is needed for that than is allowed.
fn made(
    (source, at): (&dyn SteadySource, &SteadyPath<'_>),
    made_of: MadeOf,
    allowed: u64,
    stage: &Stage<'_>,
) -> Result<KnownMesh, Cancelled> {
    let MadeOf { welded, rule } = &made_of;
    let work = SharedWork::new(allowed);
    let field = source.field(at, &welded.points, &work, stage)?;
    let search = SteadySearch { source, at, field: field.as_deref() };
    let points = FoundPoints::new(&search, &welded.points, &work, stage)?;
    let mut mesh = None;
    if !work.is_too_much() {
        let corner = |point: u32| {
            let (row, appearances) = points.of(point);
            (welded.points[point as usize], row, appearances)
        };
        let numbers: Vec<u32> = (0..welded.triangles.len() as u32).collect();
        let parts: Vec<&[u32]> = numbers.chunks(triangles_at_once(numbers.len())).collect();
        let pieces = parallel::map_within(stage, parts.len(), |part| {
            let mut divider = SteadyDivider::new(search, rule, work.share(), points.form_count);
            for &triangle in parts[part].iter().take_while(|_| !work.is_too_much()) {
                divider.triangle(triangle, welded.triangles[triangle as usize].map(corner));
            }
            divider.finish()
        })?;
        mesh = (!work.is_too_much()).then(|| Arc::new(SteadyMesh::new(points, pieces)));
    }
    let work = if mesh.is_some() { work.done() } else { allowed };
    Ok(KnownMesh { made_of: Arc::new(made_of), mesh, work })
}

impl SteadyMesh {
    fn new(points: FoundPoints, pieces: Vec<SteadyPieces>) -> Self {
        let (mut mesh, mut numbers) = (Self::default(), HashMap::new());
        let first = points.form_count;
        let mut forms = points.into_forms();
        pieces.into_iter().for_each(|pieces| mesh.add(pieces, (&mut forms, first), &mut numbers));
        mesh.count = forms.len();
        mesh.blocks = forms.chunks(LANES).map(FormBlock::new).collect();
        mesh
    }

    /// Adds pieces; the rows of their own polynomials begin with `first`, and `numbers` are those of the points that
    /// pieces that are left have so far.
    fn add(
        &mut self,
        SteadyPieces { forms: mut own, drawn, left, known }: SteadyPieces,
        (forms, first): (&mut Vec<TetrahedronForm>, u32),
        numbers: &mut HashMap<[u32; 3], u32>,
    ) {
        let moved = forms.len() as u32 - first;
        forms.append(&mut own);
        for SteadyPiece { triangle, corners } in drawn {
            self.sources.push(triangle);
            self.rows.push(corners.map(|corner| if corner.row < first { corner.row } else { corner.row + moved }));
            self.weights.push(corners.map(|corner| corner.weights));
        }
        self.left.known.extend(known);
        for SteadyPiece { triangle, corners } in left {
            let LeftPieces { welded, sources, is_fixed, .. } = &mut self.left;
            sources.push((triangle, corners.map(|corner| corner.weights)));
            let is_steady = |corner: &SteadyCorner| corner.row <= NOWHERE;
            is_fixed.push([0, 1, 2].map(|k| is_steady(&corners[(k + 1) % 3]) && is_steady(&corners[(k + 2) % 3])));
            welded.triangles.push(corners.map(|corner| {
                *numbers.entry(corner.position.to_array().map(f32::to_bits)).or_insert_with(|| {
                    welded.points.push(corner.position);
                    welded.points.len() as u32 - 1
                })
            }));
        }
    }
}
