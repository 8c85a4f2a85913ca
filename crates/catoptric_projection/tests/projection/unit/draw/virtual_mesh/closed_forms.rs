//! Virtual meshes of projections in closed form.

use catoptric_core::math::Aabb;
use catoptric_core::progress::{Silent, Stage};
use catoptric_core::scene::{Camera, View};
use catoptric_engine::method::projector::{Projection, Projections, SpecularPath, VertexProjector};
use catoptric_engine::raster::DrawTriangle;
use catoptric_projection::draw::virtual_mesh::{
    Allowance, MeshQuality, PictureScale, VirtualMesh, VirtualObject, WeldedObject,
};
use catoptric_projection::parts::{MAX_APPEARANCES, virtual_mesh};
use glam::{Vec2, Vec3};
use std::collections::{HashMap, HashSet};
use std::sync::Arc;

/// Pixels a unit of the flat object.
const SCALE: f32 = 100.0;

/// An appearance: place in units of [`SCALE`], its derivatives with respect to x and y, and focal index.
type Sheet = (Vec2, [Vec2; 2], u32);

/// Points of the plane z = 0, projected by a formula.
struct Formula<F>(F);

impl<F: Fn(Vec2) -> Vec<Sheet> + Sync> VertexProjector for Formula<F> {
    fn paths(&self) -> &[SpecularPath] {
        &[]
    }

    fn project_on(&self, path: u32, points: &[Vec3], found: &mut Projections) {
        let projection = |(place, change, focal_index): Sheet| Projection {
            path,
            focal_index,
            image_px: place * SCALE,
            image_change: [0, 1].map(|axis| Vec3::new(change[0][axis], change[1][axis], 0.0) * SCALE),
            path_length: 3.0,
            ..Projection::default()
        };
        found.extend(points, |point, found| found.extend((self.0)(point.truncate()).into_iter().map(projection)));
    }
}

/// A square of the plane z = 0, in `cells` by `cells` squares of two triangles.
pub(super) fn grid(min: Vec2, max: Vec2, cells: u32) -> WeldedObject {
    let place = |k: u32| k as f32 / cells as f32;
    let mut welded = WeldedObject::default();
    for row in 0..=cells {
        for column in 0..=cells {
            welded.points.push((min + (max - min) * Vec2::new(place(column), place(row))).extend(0.0));
        }
    }
    for row in 0..cells {
        for column in 0..cells {
            let a = row * (cells + 1) + column;
            let (b, c, d) = (a + 1, a + cells + 2, a + cells + 1);
            welded.triangles.extend([[a, b, c], [a, c, d]]);
        }
    }
    welded
}

/// The object is seen without perspective, far from its reflector: edges are divided by their pictures alone.
fn mesh_of<P: VertexProjector>(projector: &P, welded: &WeldedObject) -> VirtualMesh {
    let far = Aabb { min: Vec3::splat(100.0), max: Vec3::splat(101.0) };
    let object = VirtualObject {
        object: 0,
        welded: Arc::new(welded.clone()),
        first_triangle: 0,
        alpha_tested: false,
        path: 0,
        least_segment: 0.0,
        last_reflector: far,
        scene_size: 200.0,
    };
    uncancelled(projector, &object, &quality())
}

pub(super) fn flat_object(welded: &WeldedObject) -> VirtualObject {
    VirtualObject {
        object: 0,
        welded: Arc::new(welded.clone()),
        first_triangle: 0,
        alpha_tested: false,
        path: 0,
        least_segment: 0.0,
        last_reflector: Aabb { min: Vec3::splat(100.0), max: Vec3::splat(101.0) },
        scene_size: 2.0,
    }
}

fn uncancelled<P: VertexProjector>(projector: &P, object: &VirtualObject, quality: &MeshQuality) -> VirtualMesh {
    limited(projector, object, quality, PLENTY)
}

fn limited<P: VertexProjector>(
    projector: &P,
    object: &VirtualObject,
    quality: &MeshQuality,
    allowed: u64,
) -> VirtualMesh {
    virtual_mesh(
        (projector, None),
        object,
        quality,
        Allowance::for_all(allowed),
        &Stage::begin(&Silent, "", 1).expect("nothing is cancelled"),
    )
    .expect("nothing is cancelled")
}

const EDGE_ERROR_PX: f32 = 0.25;

/// Work that is never reached.
const PLENTY: u64 = u64::MAX / 1_000_000;

fn quality() -> MeshQuality {
    MeshQuality::new(&view(), EDGE_ERROR_PX, 0.75)
}

/// A view without perspective, one pixel a unit, in whose picture places have their own coordinates.
pub(super) fn view() -> View {
    let camera = Camera::look_at("", Vec3::new(200.0, -200.0, 1.0), Vec3::new(200.0, -200.0, 0.0), Vec3::Y, 40.0);
    let projection = catoptric_core::scene::Projection::Orthographic { half_height: 200.0 };
    View { projection, ..View::new(&camera, 400, 400, 0.01) }
}

/// A point of a source triangle by the weights of its second and third vertex.
fn source_point(welded: &WeldedObject, source: u32, weights: Vec2) -> Vec2 {
    let [a, b, c] = welded.triangles[source as usize].map(|point| welded.points[point as usize].truncate());
    a + (b - a) * weights.x + (c - a) * weights.y
}

/// A piece: its corners in the plane, and where they are drawn.
pub(super) struct DrawnPiece {
    pub(super) source: [Vec2; 3],
    pub(super) drawn: [Vec2; 3],
}

pub(super) fn pieces(mesh: &VirtualMesh, welded: &WeldedObject) -> Vec<DrawnPiece> {
    let piece = |(triangle, corners): (&DrawTriangle, &[Vec2; 3])| {
        let vertices = triangle.vertices.map(|vertex| mesh.vertices[vertex as usize]);
        DrawnPiece {
            source: corners.map(|weights| source_point(welded, triangle.source, weights)),
            drawn: vertices.map(|point| point.xy / point.w),
        }
    };
    mesh.triangles.iter().zip(&mesh.corners).map(piece).collect()
}

pub(super) fn area([a, b, c]: [Vec2; 3]) -> f32 {
    0.5 * (b - a).perp_dot(c - a)
}

fn drawn_area(pieces: &[DrawnPiece]) -> f32 {
    pieces.iter().map(|piece| area(piece.drawn).abs()).sum()
}

/// The largest distance in pixels between where points of the pieces are drawn and where they belong.
fn largest_error(pieces: &[DrawnPiece], truth: impl Fn(Vec2, Vec2) -> f32) -> f32 {
    let mut worst = 0.0f32;
    for piece in pieces {
        for i in 0..=6 {
            for j in 0..=6 - i {
                let weights = Vec3::new(i as f32, j as f32, (6 - i - j) as f32) / 6.0;
                let mix = |p: [Vec2; 3]| p[0] * weights.x + p[1] * weights.y + p[2] * weights.z;
                worst = worst.max(truth(mix(piece.source), mix(piece.drawn)));
            }
        }
    }
    worst
}

fn key(point: Vec2) -> [i32; 2] {
    point.to_array().map(|value| (value * 1e5).round() as i32)
}

/// Edges of pieces that have no piece on their other side, by their ends in the plane.
pub(super) fn open_edges(pieces: &[DrawnPiece]) -> Vec<[Vec2; 2]> {
    let mut edges: HashMap<[[i32; 2]; 2], (u32, [Vec2; 2])> = HashMap::new();
    for piece in pieces {
        for k in 0..3 {
            let ends = [piece.source[k], piece.source[(k + 1) % 3]];
            let mut name = ends.map(key);
            name.sort_unstable();
            if name[0] != name[1] {
                edges.entry(name).or_insert((0, ends)).0 += 1;
            }
        }
    }
    assert!(edges.values().all(|(count, _)| *count <= 2), "pieces overlap");
    edges.into_values().filter(|(count, _)| *count == 1).map(|(_, ends)| ends).collect()
}

/// True if the same source point is drawn in the same place by all pieces.
pub(super) fn corners_agree(pieces: &[DrawnPiece]) -> bool {
    let mut places: HashMap<[i32; 2], Vec2> = HashMap::new();
    let corners = pieces.iter().flat_map(|piece| piece.source.into_iter().zip(piece.drawn));
    corners.into_iter().all(|(source, drawn)| places.entry(key(source)).or_insert(drawn).distance(drawn) < 0.01)
}

/// x + a x^2, and y sheared by x y.
fn bent(p: Vec2) -> Vec<Sheet> {
    let place = Vec2::new(p.x + 0.8 * p.x * p.x, p.y + 0.5 * p.x * p.y);
    vec![(place, [Vec2::new(1.0 + 1.6 * p.x, 0.5 * p.y), Vec2::new(0.0, 1.0 + 0.5 * p.x)], 0)]
}

#[test]
fn bent_pictures_are_within_the_edge_error_and_without_cracks() {
    let welded = grid(Vec2::ZERO, Vec2::ONE, 2);
    let mesh = mesh_of(&Formula(bent), &welded);
    let pieces = pieces(&mesh, &welded);
    // The error of a quadratic map in a triangle is four thirds of its error on the edges.
    let error = largest_error(&pieces, |source, drawn| bent(source)[0].0.distance(drawn / SCALE) * SCALE);
    assert!(error <= EDGE_ERROR_PX * 4.0 / 3.0 && error > 0.02, "{error}");
    assert!(mesh.unfinished == 0 && pieces.len() < 1000, "{} pieces", pieces.len());
    let covered: f32 = pieces.iter().map(|piece| area(piece.source)).sum();
    assert!((covered - 1.0).abs() < 1e-4, "{covered}");
    let on_outline = |p: &Vec2, q: &Vec2| (0..2).any(|k| p[k] == q[k] && (p[k] == 0.0 || p[k] == 1.0));
    for [p, q] in open_edges(&pieces) {
        assert!(on_outline(&p, &q), "crack from {p} to {q}");
    }
    assert!(corners_agree(&pieces));
}

#[test]
fn nothing_is_divided_where_pictures_are_straight() {
    let welded = grid(Vec2::ZERO, Vec2::ONE, 2);
    let mesh = mesh_of(&Formula(|p| vec![(p, [Vec2::X, Vec2::Y], 0)]), &welded);
    assert_eq!((mesh.triangles.len(), mesh.points_projected), (8, 9));
}

/// An eye at the origin that looks along -z.
struct Pinhole {
    view: View,
}

impl VertexProjector for Pinhole {
    fn paths(&self) -> &[SpecularPath] {
        &[]
    }

    fn project_on(&self, path: u32, points: &[Vec3], found: &mut Projections) {
        found.extend(points, |point, found| {
            if let Some((image_px, image_change)) = self.view.picture_from_world().pixel_with_change(point) {
                let path_length = point.length();
                found.push(Projection { path, image_px, image_change, path_length, ..Projection::default() });
            }
        });
    }
}

#[test]
fn straight_edges_in_perspective_are_drawn_as_they_are() {
    let camera = Camera::look_at("", Vec3::ZERO, Vec3::NEG_Z, Vec3::Y, 60.0);
    let view = View::new(&camera, 400, 400, 0.01);
    // A floor that leads away.
    let mut welded = grid(Vec2::new(-1.0, -8.0), Vec2::new(1.0, -2.0), 1);
    for point in &mut welded.points {
        *point = Vec3::new(point.x, -0.8, point.y);
    }
    let object = VirtualObject {
        object: 0,
        welded: Arc::new(welded.clone()),
        first_triangle: 7,
        alpha_tested: true,
        path: 0,
        least_segment: 0.0,
        last_reflector: Aabb { min: Vec3::splat(100.0), max: Vec3::splat(101.0) },
        scene_size: 200.0,
    };
    let quality = MeshQuality { picture: PictureScale::new(&view), ..quality() };
    let mesh = uncancelled(&Pinhole { view: view.clone() }, &object, &quality);
    assert_eq!(mesh.triangles.len(), 2);
    for (triangle, corners) in mesh.triangles.iter().zip(&mesh.corners) {
        assert!(triangle.alpha_tested && (7..9).contains(&triangle.source));
        for (vertex, weights) in triangle.vertices.into_iter().zip(corners) {
            let p = source_points(&welded, triangle.source - 7, *weights);
            let (drawn, exact) = (mesh.vertices[vertex as usize], view.picture_from_world().apply(p));
            assert!((drawn.w - exact.w).abs() < 1e-4 && (drawn.depth + p.z).abs() < 1e-4, "{drawn:?} for {exact:?}");
            assert!(drawn.xy.distance(exact.xy) < 0.05, "{drawn:?} for {exact:?}");
        }
    }
}

fn source_points(welded: &WeldedObject, source: u32, weights: Vec2) -> Vec3 {
    let [a, b, c] = welded.triangles[source as usize].map(|point| welded.points[point as usize]);
    a + (b - a) * weights.x + (c - a) * weights.y
}

#[test]
fn appearances_end_where_a_half_plane_ends() {
    let side = Vec2::new(1.0, 0.3);
    let limit = 0.55;
    let welded = grid(Vec2::ZERO, Vec2::ONE, 3);
    let projector = Formula(|p: Vec2| {
        let seen = p.dot(side) < limit;
        seen.then_some((p, [Vec2::X, Vec2::Y], 0)).into_iter().collect()
    });
    let mesh = mesh_of(&projector, &welded);
    let pieces = pieces(&mesh, &welded);
    let corners = || pieces.iter().flat_map(|piece| piece.source);
    assert!(corners().all(|p| p.dot(side) < limit + 1e-5));
    // The border is found to 2^-8 of an edge, and is at most 1.1 units long.
    let truth = (limit / side.x + (limit - side.y) / side.x) * 0.5 * SCALE * SCALE;
    let drawn = drawn_area(&pieces);
    let longest = SCALE * 2f32.sqrt() / 3.0;
    assert!((drawn - truth).abs() < 1.1 * SCALE * longest / 256.0 + 0.1, "{drawn} for {truth}");
    // Pieces end at the outline or at the border, nowhere else.
    let outline = |p: &Vec2, q: &Vec2| (0..2).any(|k| (p[k] - q[k]).abs() < 1e-5 && (p[k] < 1e-5 || p[k] > 1.0 - 1e-5));
    let border = |p: &Vec2| p.dot(side) > limit - 1.1 * longest / SCALE / 256.0 - 1e-5;
    for [p, q] in open_edges(&pieces) {
        assert!(outline(&p, &q) || (border(&p) && border(&q)), "open from {p} to {q}");
    }
    assert!(corners_agree(&pieces));
    assert!(mesh.unfinished == 0 && pieces.len() < 2000, "{} pieces", pieces.len());
}

#[test]
fn borders_that_bulge_over_an_edge_are_drawn_on_its_other_side_too() {
    // Two triangles with an edge along y = 0; the appearance is a disc around (0.5, 0.45) that reaches a little below
    // it. None of the corners and no middle of the outline shows any of that.
    let welded = WeldedObject {
        points: vec![
            Vec3::new(-1.0, 0.0, 0.0),
            Vec3::new(2.0, 0.0, 0.0),
            Vec3::new(0.5, 0.5, 0.0),
            Vec3::new(0.5, -3.0, 0.0),
        ],
        triangles: vec![[0, 1, 2], [0, 3, 1]],
    };
    let (center, radius) = (Vec2::new(0.5, 0.45), 0.5f32);
    let disc = |p: Vec2| {
        let seen = p.distance(center) < radius;
        // Small enough that no edge is divided for its length in the picture.
        seen.then_some((p * 0.1, [Vec2::X * 0.1, Vec2::Y * 0.1], 0)).into_iter().collect()
    };
    let mesh = mesh_of(&Formula(disc), &welded);
    let pieces = pieces(&mesh, &welded);
    let below: f32 = pieces
        .iter()
        .filter(|piece| piece.source.iter().any(|p| p.y < 0.0))
        .map(|piece| area(piece.source).abs())
        .sum();
    // The segment of the disc below y = 0.
    let angle = 2.0 * (0.45f32 / radius).acos();
    let truth = 0.5 * radius * radius * (angle - angle.sin());
    // A border as small as this is drawn straight between its ends and its middle: three quarters of a segment, less
    // the error of the ends.
    assert!(below > 0.65 * truth && below <= truth, "{below} of {truth}");
}

/// Two appearances where y > 0, which meet at y = 0.
fn folded(p: Vec2) -> Vec<Sheet> {
    if p.y <= 0.0 {
        return Vec::new();
    }
    let root = p.y.sqrt();
    let sheet = |sign: f32, focal_index| {
        (Vec2::new(p.x, 1.0 + sign * root), [Vec2::X, Vec2::Y * (sign * 0.5 / root)], focal_index)
    };
    vec![sheet(1.0, 0), sheet(-1.0, 1)]
}

#[test]
fn both_sheets_of_a_fold_are_drawn_up_to_the_fold() {
    let welded = grid(Vec2::new(0.0, -0.37), Vec2::new(1.0, 1.0), 3);
    let mesh = mesh_of(&Formula(folded), &welded);
    let pieces = pieces(&mesh, &welded);
    for sign in [1.0, -1.0f32] {
        let sheet: Vec<&DrawnPiece> =
            pieces.iter().filter(|piece| piece.drawn.iter().map(|p| p.y - SCALE).sum::<f32>() * sign > 0.0).collect();
        let drawn: f32 = sheet.iter().map(|piece| area(piece.drawn).abs()).sum();
        // The end of an edge is found to 2^-12 of it: at most sqrt(0.65 / 4096) short of the fold.
        let short = (0.65f32 / 256.0).sqrt() * SCALE * SCALE;
        assert!((drawn - SCALE * SCALE).abs() < short, "{drawn} of {}", SCALE * SCALE);
    }
    let error = |away: f32| {
        largest_error(&pieces, |source, drawn| {
            let sign = (drawn.y - SCALE).signum();
            let truth = Vec2::new(source.x, 1.0 + sign * source.y.max(0.0).sqrt()) * SCALE;
            if (truth.y - SCALE).abs() >= away { truth.distance(drawn) } else { 0.0 }
        })
    };
    // Far from the fold as everywhere (third orders count a little); near it a root is drawn straight over the six
    // pixels that its last pieces may measure, which is off by a quarter of them.
    let (all, far) = (error(0.0), error(20.0));
    assert!(far <= EDGE_ERROR_PX * 2.0, "{far}");
    assert!(all <= 6.0 / 4.0 * 4.0 / 3.0, "{all}");
    assert!(corners_agree_on_sheets(&pieces));
    assert!(mesh.unfinished == 0 && pieces.len() < 4000, "{} pieces", pieces.len());
}

/// Two sheets that merge in a fold at x = 0, and beyond it one that has nothing to do with them and the focal index of
/// one of them, where that seems to move to.
fn folded_beside_another(p: Vec2) -> Vec<Sheet> {
    if p.x <= 0.0 {
        return vec![(Vec2::new(0.7 + 0.01 * p.x, p.y), [Vec2::new(0.01, 0.0), Vec2::Y], 0)];
    }
    let root = p.x.sqrt();
    let sheet = |side: f32, focal_index| {
        (Vec2::new(2.0 + side * root, p.y), [Vec2::new(0.5 * side / root, 0.0), Vec2::Y], focal_index)
    };
    vec![sheet(1.0, 0), sheet(-1.0, 1)]
}

#[test]
fn what_ends_in_a_fold_is_not_torn_to_what_begins_beyond() {
    let welded = grid(Vec2::new(-0.75, 0.5), Vec2::new(0.75, 2.0), 3);
    let mesh = mesh_of(&Formula(folded_beside_another), &welded);
    let pieces = pieces(&mesh, &welded);
    let (mut folded, mut beside) = (0.0, 0.0);
    for piece in &pieces {
        let [low, high] =
            [f32::min, f32::max].map(|of| piece.drawn.iter().map(|place| place.x).fold(piece.drawn[0].x, of));
        // The sheets reach from 113 to 287 pixels, the other one lies about 70.
        assert!(low > 100.0 || high < 80.0, "torn: {:?}", piece.drawn);
        *if low > 100.0 { &mut folded } else { &mut beside } += area(piece.drawn).abs();
    }
    let expected = 2.0 * 0.75f32.sqrt() * 1.5 * SCALE * SCALE;
    assert!((folded / expected - 1.0).abs() < 0.02, "{folded} of {expected} pixels are drawn");
    assert!(beside > 0.0);
}

fn corners_agree_on_sheets(all: &[DrawnPiece]) -> bool {
    let mut places: HashMap<([i32; 2], bool), Vec2> = HashMap::new();
    let corners = all.iter().flat_map(|piece| piece.source.into_iter().zip(piece.drawn));
    corners
        .into_iter()
        .all(|(p, drawn)| places.entry((key(p), drawn.y > SCALE)).or_insert(drawn).distance(drawn) < 0.01)
}

#[test]
fn neither_threads_nor_the_order_of_triangles_matter() {
    let welded = grid(Vec2::new(0.0, -0.37), Vec2::new(1.0, 1.0), 12);
    let drawn = |welded: &WeldedObject| mesh_of(&Formula(folded), welded);
    let in_pool = |threads: usize| {
        let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build().unwrap();
        pool.install(|| drawn(&welded))
    };
    let (one, four) = (in_pool(1), in_pool(4));
    assert!(one.vertices == four.vertices && one.triangles == four.triangles && one.corners == four.corners);
    let mut turned = welded.clone();
    turned.triangles.reverse();
    let places = |mesh: &VirtualMesh| -> HashSet<[u32; 2]> {
        mesh.vertices.iter().map(|point| point.xy.to_array().map(f32::to_bits)).collect()
    };
    let other = drawn(&turned);
    assert!(other.triangles.len() == one.triangles.len() && places(&other) == places(&one));
}

#[test]
fn pieces_are_bounded_where_pictures_are_wild() {
    // Noise: no edge is ever straight, and appearances come and go.
    let noise = |p: Vec2| (p * Vec2::new(7919.0, 104_729.0)).to_array().map(|v| (v.sin() * 43_758.547).fract().abs());
    let projector = Formula(move |p: Vec2| {
        let [x, y] = noise(p);
        if y > 0.7 {
            Vec::new()
        } else {
            vec![(Vec2::new(x, y) * 4.0, [Vec2::X * 40.0 * x, Vec2::Y * 40.0 * y], (x * 3.0) as u32)]
        }
    });
    let welded = grid(Vec2::splat(0.13), Vec2::splat(0.93), 5);
    let object = flat_object(&welded);
    let allowed = 4000;
    let mesh = limited(&projector, &object, &quality(), allowed);
    // Pieces that were begun are finished: a few pieces more at every level of division.
    assert!(mesh.work < 4 * allowed && mesh.triangles.len() as u64 * 20 < 2 * allowed, "{}", mesh.work);
    assert!(mesh.unfinished > 0 && mesh.needed.is_none(), "{} unfinished, {:?}", mesh.unfinished, mesh.needed);
    assert!(mesh.vertices.iter().all(|point| point.xy.is_finite() && point.w.is_finite()));
    assert_eq!(mesh.vertices.len(), 3 * mesh.corners.len());
    // Without work only known pieces are drawn.
    assert!(limited(&projector, &object, &quality(), 0).work < 1000);
}

#[test]
fn meshes_are_the_same_with_as_much_work_as_they_need() {
    let welded = grid(Vec2::ZERO, Vec2::ONE, 2);
    let (object, projector) = (flat_object(&welded), Formula(bent));
    let plenty = limited(&projector, &object, &quality(), PLENTY);
    let needed = plenty.needed.unwrap();
    let same = |other: &VirtualMesh| {
        other.vertices == plenty.vertices && other.triangles == plenty.triangles && other.corners == plenty.corners
    };
    let enough = limited(&projector, &object, &quality(), needed);
    assert!(same(&enough) && enough.unfinished == 0 && enough.needed == Some(needed) && plenty.holds_with(needed));
    // Far less is not enough, and says so.
    let less = limited(&projector, &object, &quality(), needed / 20);
    let state = (less.unfinished, less.extrapolated, less.needed, needed);
    assert!(!same(&less) && less.needed.is_none() && less.unfinished + less.extrapolated > 0, "{state:?}");
    assert!(!less.holds_with(needed) && less.holds_with(needed / 20));
}

#[test]
fn points_beyond_the_work_are_led_on_from_others() {
    let welded = grid(Vec2::ZERO, Vec2::ONE, 20);
    let mesh = limited(&Formula(bent), &flat_object(&welded), &quality(), 100);
    assert!(mesh.extrapolated > 300 && mesh.points_projected < 140, "{} led on", mesh.extrapolated);
    let pieces = pieces(&mesh, &welded);
    // Every triangle is drawn; points are extrapolated over a third of the square at most, and off by the second order.
    assert!(pieces.len() >= welded.triangles.len());
    let error = largest_error(&pieces, |source, drawn| bent(source)[0].0.distance(drawn / SCALE) * SCALE);
    assert!(error < (0.8 + 0.5) * SCALE / 9.0, "{error}");
}

#[test]
fn of_very_many_appearances_the_largest_are_drawn() {
    let many = |p: Vec2| -> Vec<Sheet> {
        (0..40).map(|k| (p * 0.1 * k as f32, [Vec2::X * 0.1 * k as f32, Vec2::Y * 0.1 * k as f32], k)).collect()
    };
    let welded = grid(Vec2::ZERO, Vec2::ONE, 1);
    let mesh = limited(&Formula(many), &flat_object(&welded), &quality(), PLENTY);
    assert_eq!(mesh.left_out, 4 * (40 - MAX_APPEARANCES as u64));
    // The smallest of those that are drawn has its far corner here.
    let smallest = 0.1 * (40 - MAX_APPEARANCES) as f32 * SCALE;
    let farthest = |piece: &DrawnPiece| piece.drawn.iter().map(|place| place.x.max(place.y)).fold(0.0, f32::max);
    assert!(pieces(&mesh, &welded).iter().all(|piece| farthest(piece) > smallest - 0.1));
}
