//! Steady parts of virtual meshes while the eye moves, beside those found from every eye, in closed form.

use super::closed_forms::{area, corners_agree, flat_object, grid, open_edges, pieces, view};
use catoptric_core::progress::{Cancelled, Silent, Stage};
use catoptric_core::scene::PreciseView;
use catoptric_engine::method::projector::{Projection, Projections, SpecularPath, VertexProjector};
use catoptric_projection::draw::virtual_mesh::{
    Allowance, MeshQuality, PictureScale, VirtualMesh, VirtualObject, WeldedObject,
};
use catoptric_projection::parts::work::{self, SharedWork};
use catoptric_projection::parts::{
    FormWeights, MOST_NODES, NodeSightings, PlaceAndLength, Sighting, Steadiness, SteadyField, SteadyMeshes,
    SteadyPath, SteadySource, TetrahedronForm, virtual_mesh,
};
use glam::{Vec2, Vec3};
use std::sync::Arc;
use std::sync::atomic::{AtomicU64, Ordering};

/// Pixels a unit of the object.
const SCALE: f32 = 100.0;

const LENGTH: f32 = 3.0;

/// A square that is seen bent, up to a border that moves with the eye: from x = 0.75 to 0.8.
struct Moving {
    /// The eye's distance from the first node, as a share of the way to the others.
    eye: f32,
    is_interpolated: bool,
    meshes: SteadyMeshes,
    sought: AtomicU64,
}

/// The appearance of a point in pixels, and its derivatives.
fn seen(p: Vec2, eye: f32) -> (Vec2, [Vec2; 2]) {
    let place = Vec2::new(p.x + 0.8 * p.x * p.x + eye * 0.1 * p.y, p.y + 0.5 * p.x * p.y + eye * 0.1);
    let change = [Vec2::new(1.0 + 1.6 * p.x, eye * 0.1), Vec2::new(0.5 * p.y, 1.0 + 0.5 * p.x)];
    (place * SCALE, change.map(|change| change * SCALE))
}

fn border(eye: f32) -> f32 {
    0.75 + 0.05 * eye
}

fn projection(point: Vec3, eye: f32) -> Projection {
    let (image_px, change) = seen(point.truncate(), eye);
    let image_change = change.map(|change| change.extend(0.0));
    Projection { image_px, image_change, path_length: LENGTH, ..Projection::default() }
}

impl Moving {
    fn new(eye: f32, is_interpolated: bool) -> Self {
        Self { eye, is_interpolated, meshes: SteadyMeshes::default(), sought: AtomicU64::new(0) }
    }
}

impl VertexProjector for Moving {
    fn paths(&self) -> &[SpecularPath] {
        &[]
    }

    fn project_on(&self, _: u32, points: &[Vec3], found: &mut Projections) {
        found.extend(points, |point, found| {
            if point.x < border(self.eye) {
                found.push(projection(point, self.eye));
            }
        });
    }
}

impl SteadySource for Moving {
    fn on_path(&self, path: u32) -> Option<SteadyPath<'_>> {
        Some(SteadyPath {
            path,
            meshes: &self.meshes,
            kept_path: path,
            middle: Vec3::ZERO,
            view_from_middle: PreciseView::new(&view()),
            scale_from_middle: PictureScale::new(&view()),
            weights: FormWeights::new([1.0 - self.eye, self.eye * 0.5, self.eye * 0.5, 0.0]),
            nodes: [Vec3::ZERO; MOST_NODES],
            mirror: (Vec3::ZERO, 1.0),
            view: PreciseView::new(&view()),
            scale: PictureScale::new(&view()),
        })
    }

    fn field(
        &self,
        _: &SteadyPath<'_>,
        _: &[Vec3],
        _: &SharedWork,
        _: &Stage<'_>,
    ) -> Result<Option<Box<dyn SteadyField>>, Cancelled> {
        Ok(self.is_interpolated.then(|| Box::new(Shifted) as Box<dyn SteadyField>))
    }

    fn steadiness(&self, _: &SteadyPath<'_>, point: Vec3) -> Steadiness {
        self.sought.fetch_add(1, Ordering::Relaxed);
        work::add(7);
        let from_middle = projection(point, 0.5);
        if point.x > 0.8 {
            return Steadiness::Nowhere;
        }
        if point.x > 0.7 {
            return Steadiness::Unsteady(if point.x < border(0.5) { vec![from_middle] } else { Vec::new() });
        }
        shown(point)
    }

    fn sightings(&self, _: &SteadyPath<'_>, point: Vec3) -> Option<NodeSightings> {
        (point.x <= 0.7).then(|| seen_at(point))
    }

    fn half_way(&self, _: &SteadyPath<'_>, [(a, _), (b, _)]: [(Vec3, &NodeSightings); 2]) -> Option<NodeSightings> {
        let middle = (a + b) * 0.5;
        (self.is_interpolated && middle.x < 0.7).then(|| seen_at(middle + SHIFT))
    }

    fn steadiness_of(&self, _: &SteadyPath<'_>, sightings: &NodeSightings) -> Steadiness {
        shown(sightings.at[0].first)
    }

    fn seen(&self, _: &SteadyPath<'_>, sightings: &NodeSightings) -> Option<Projection> {
        Some(projection(sightings.at[0].first, self.eye))
    }
}

/// Something that is interpolated is off by this, and appears where another point is.
const SHIFT: Vec3 = Vec3::new(0.0, 0.0005, 0.0);

/// A field that knows some points.
struct Shifted;

impl SteadyField for Shifted {
    fn sightings(&self, point: Vec3) -> Option<NodeSightings> {
        (point.x < 0.6 && point.y > 0.4).then(|| seen_at(point + SHIFT))
    }
}

/// Sightings of a point that appears, from all nodes, at this place.
fn seen_at(point: Vec3) -> NodeSightings {
    NodeSightings { focal_index: 0, at: [Sighting { first: point, ..Sighting::default() }; MOST_NODES] }
}

/// The steady appearance of this point.
fn shown(point: Vec3) -> Steadiness {
    let corner = |eye: f32| {
        let Vec2 { x, y } = seen(point.truncate(), eye).0;
        PlaceAndLength { place: Vec3::new(x, -y, 0.0), length: LENGTH }
    };
    let straight = |_, _| PlaceAndLength::default();
    let form = TetrahedronForm::new([corner(0.0), corner(1.0), corner(1.0), corner(1.0)], straight);
    Steadiness::Shown(form, projection(point, 0.5))
}

fn square(welded: &Arc<WeldedObject>) -> VirtualObject {
    VirtualObject { welded: welded.clone(), ..flat_object(welded) }
}

fn drawn(moving: &Moving, welded: &Arc<WeldedObject>, work: u64) -> VirtualMesh {
    let quality = MeshQuality::new(&view(), 0.25, 0.75);
    let stage = Stage::begin(&Silent, "", 1).expect("nothing is cancelled");
    virtual_mesh((moving, Some(moving)), &square(welded), &quality, Allowance::for_whole(work), &stage)
        .expect("nothing is cancelled")
}

const PLENTY: u64 = 1_000_000;

#[test]
fn what_is_steady_joins_what_is_not_without_cracks() {
    for (cells, is_interpolated) in [1, 3, 16].into_iter().flat_map(|cells| [(cells, false), (cells, true)]) {
        let welded = Arc::new(grid(Vec2::ZERO, Vec2::ONE, cells));
        let mut moving = Moving::new(0.0, is_interpolated);
        let mut sought = 0;
        for (number, eye) in [0.3, 0.07, 0.45, 0.9, 0.97].into_iter().enumerate() {
            moving.eye = eye;
            let mesh = drawn(&moving, &welded, PLENTY);
            assert!(mesh.is_whole() && mesh.steady_points > 10, "{cells} {eye}: {} points", mesh.steady_points);
            let pieces = pieces(&mesh, &welded);
            assert!(corners_agree(&pieces), "{cells} {eye}");
            for piece in &pieces {
                for (source, drawn) in piece.source.into_iter().zip(piece.drawn) {
                    let expected = seen(source, eye).0;
                    let allowed = if is_interpolated { 0.1 + SHIFT.length() * 2.0 * SCALE } else { 0.1 };
                    assert!(expected.distance(drawn) < allowed, "{source} at {drawn}, not at {expected}");
                }
            }
            let covered: f32 = pieces.iter().map(|piece| area(piece.source).abs()).sum();
            assert!((covered - border(eye)).abs() < 2e-3, "{cells} {eye}: {covered}");
            for [p, q] in open_edges(&pieces) {
                let on_outline = (0..2).any(|k| p[k] == q[k] && (p[k] == 0.0 || p[k] == 1.0));
                let at_border = [p, q].into_iter().all(|end| (end.x - border(eye)).abs() < 2e-3);
                assert!(on_outline || at_border, "{cells} {eye}: crack from {p} to {q}");
            }
            let all = moving.sought.load(Ordering::Relaxed);
            assert!(if number == 0 { all > 0 } else { all == sought }, "{cells} {eye}: {all} after {sought}");
            sought = all;
        }
    }
}

/// The drawn mesh and its counted work do not depend on what was drawn before; nor does giving up.
#[test]
fn known_meshes_are_as_new_ones() {
    let welded = Arc::new(grid(Vec2::ZERO, Vec2::ONE, 8));
    let new = || Moving::new(0.6, true);
    let needed = drawn(&new(), &welded, PLENTY).needed.expect("nothing stopped it");
    let known = new();
    for work in [needed / 3, PLENTY, needed / 3, needed, needed - 1, needed / 10] {
        let (first, again) = (drawn(&new(), &welded, work), drawn(&known, &welded, work));
        assert!(first.vertices == again.vertices && first.corners == again.corners, "{work}");
        assert_eq!((first.work, first.is_whole()), (again.work, again.is_whole()), "{work}");
        assert!(first.is_whole() || work < needed, "{work} of {needed}");
    }
    assert!(!drawn(&known, &welded, needed / 10).is_whole());
    // Another mesh of the same object is not taken for it.
    let moved = Arc::new(grid(Vec2::ZERO, Vec2::splat(0.5), 8));
    let covered = |mesh: &VirtualMesh| pieces(mesh, &moved).iter().map(|piece| area(piece.source).abs()).sum::<f32>();
    assert!((covered(&drawn(&known, &moved, PLENTY)) - 0.25).abs() < 1e-4);
}
