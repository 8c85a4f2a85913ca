//! The sphere map: directions from a centre to places of a disc, and triangles of hits drawn there.

use crate::raster::id_map::IdMap;
use glam::{Vec2, Vec3};

/// Directions with an axial component below this are looked up about the opposite axis.
const TURN: f32 = -0.9;

/// Triangles that reach below this are drawn about the opposite axis, too.
const OVERLAP: f32 = -0.8;

/// Triangles that reach this near to the map's singular direction are not drawn in it.
const SINGULAR: f32 = -0.998;

/// Axes of the sphere map, right-handed; the third is the direction at the disc's centre, its opposite the singular one.
#[derive(Clone, Copy, Debug)]
pub(super) struct Axes {
    axes: [Vec3; 3],
}

/// A direction on the disc.
#[derive(Clone, Copy, Debug)]
pub(super) struct Place {
    /// Which of the two maps: about the axis or about its opposite.
    pub(super) chart: usize,
    /// -1 to 1.
    pub(super) uv: Vec2,
    /// The direction in the axes of that map.
    local: Vec3,
}

impl Axes {
    /// About an axis of any length; about z where it has none.
    pub(super) fn about(axis: Vec3) -> Self {
        let z = axis.try_normalize().unwrap_or(Vec3::Z);
        let (x, y) = z.any_orthonormal_pair();
        Self { axes: [x, y, z] }
    }

    pub(super) fn axis(&self) -> Vec3 {
        self.axes[2]
    }

    /// A unit direction along the axes of a map; those of the second are turned about the first axis by half a turn.
    #[inline]
    fn local(&self, direction: Vec3, chart: usize) -> Vec3 {
        let [x, y, z] = self.axes.map(|axis| axis.dot(direction));
        if chart == 0 { Vec3::new(x, y, z) } else { Vec3::new(x, -y, -z) }
    }

    /// Where a unit direction is looked up.
    #[inline]
    pub(super) fn place(&self, direction: Vec3) -> Place {
        let local = self.local(direction, 0);
        let chart = usize::from(local.z < TURN);
        let local = if chart == 0 { local } else { Vec3::new(local.x, -local.y, -local.z) };
        Place { chart, uv: mapped(local), local }
    }

    /// The changes of a place's two coordinates with the unit direction.
    pub(super) fn change(&self, place: &Place) -> [Vec3; 2] {
        let [x, y, z] = self.axes;
        let [y, z] = if place.chart == 0 { [y, z] } else { [-y, -z] };
        let scale = (2.0 + 2.0 * place.local.z).sqrt().recip();
        let fall = scale * scale * scale;
        [x * scale - z * (place.local.x * fall), y * scale - z * (place.local.y * fall)]
    }

    /// A triangle of unit directions in one of the maps; none where it is not drawn there.
    pub(super) fn triangle(&self, corners: [Vec3; 3], chart: usize) -> Option<[Vec2; 3]> {
        let local = corners.map(|corner| self.local(corner, chart));
        let lowest = local[0].z.min(local[1].z).min(local[2].z);
        let highest = local[0].z.max(local[1].z).max(local[2].z);
        let holds_singular = lowest < 0.0 && holds_opposite_axis(&local);
        let singular = lowest < SINGULAR || holds_singular;
        // In the second map only what the first one is not asked for.
        let wanted = chart == 0 || highest > -OVERLAP || holds_axis(&local);
        (!singular && wanted).then(|| local.map(mapped))
    }
}

/// The sphere map of a direction along its axes.
#[inline]
fn mapped(local: Vec3) -> Vec2 {
    local.truncate() * (2.0 + 2.0 * local.z).sqrt().recip()
}

fn holds_opposite_axis(local: &[Vec3; 3]) -> bool {
    holds_axis(&local.map(|corner| -corner))
}

/// Whether a spherical triangle holds the third axis.
fn holds_axis([a, b, c]: &[Vec3; 3]) -> bool {
    let side = |p: &Vec3, q: &Vec3| p.truncate().perp_dot(q.truncate());
    let sides = [side(a, b), side(b, c), side(c, a)];
    (a.z + b.z + c.z > 0.0) && (sides.iter().all(|side| *side >= 0.0) || sides.iter().all(|side| *side <= 0.0))
}

/// What is known about the surface at a place of the map, near one of its triangles: position and normal as linear
/// functions of the place.
#[derive(Clone, Copy, Debug)]
pub(super) struct Record {
    /// The place of the first corner.
    pub(super) uv: Vec2,
    /// Values there, and changes along both coordinates.
    pub(super) position: [Vec3; 3],
    pub(super) normal: [Vec3; 3],
    /// The triangle of the reflector's mesh.
    pub(super) triangle: u32,
    /// Whether it lies beyond where the reflector ends as it is seen.
    pub(super) beyond: bool,
}

/// What a record is made of: a corner of a cell.
#[derive(Clone, Copy, Debug)]
pub(super) struct CellCorner {
    pub(super) position: Vec3,
    pub(super) normal: Vec3,
}

/// One map: triangles by place.
#[derive(Clone, Debug, Default)]
pub(super) struct Chart {
    records: Vec<Record>,
    ids: IdMap,
    size: f32,
}

impl Chart {
    /// Draws cells, given by their triangles in the map, with `size` texels a side.
    pub(super) fn new(size: u32, cells: &[([Vec2; 3], [CellCorner; 3], u32, bool)]) -> Self {
        if cells.is_empty() {
            return Self::default();
        }
        let scale = 0.5 * size as f32;
        let texels = cells.iter().map(|(uv, ..)| uv.map(|uv| (uv + 1.0) * scale));
        let ids = IdMap::draw(size, size, texels);
        let records = cells.iter().map(|(uv, corners, triangle, beyond)| record(*uv, corners, *triangle, *beyond));
        Self { records: records.collect(), ids, size: size as f32 }
    }

    /// The cells at a place.
    #[inline]
    pub(super) fn at(&self, uv: Vec2) -> impl Iterator<Item = &Record> {
        let texel = (uv + 1.0) * (0.5 * self.size);
        self.ids.at(texel).iter().map(|id| &self.records[*id as usize])
    }

    /// The first cell at a place.
    #[inline]
    pub(super) fn first(&self, uv: Vec2) -> Option<&Record> {
        self.at(uv).next()
    }

    pub(super) fn byte_count(&self) -> u64 {
        self.ids.byte_count() + size_of_val(self.records.as_slice()) as u64
    }
}

fn record(uv: [Vec2; 3], corners: &[CellCorner; 3], triangle: u32, beyond: bool) -> Record {
    let [a, b, c] = uv;
    let (right, down) = (b - a, c - a);
    // Changes along both coordinates of what is linear in the triangle; cells without area are never looked up.
    let inverse = 1.0 / right.perp_dot(down);
    let along_u = Vec2::new(down.y, -right.y) * inverse;
    let along_v = Vec2::new(-down.x, right.x) * inverse;
    let [first, second, third] = corners;
    let vectors = |values: [Vec3; 3]| {
        let (to_second, to_third) = (values[1] - values[0], values[2] - values[0]);
        let change = |along: Vec2| to_second * along.x + to_third * along.y;
        [values[0], change(along_u), change(along_v)]
    };
    Record {
        uv: a,
        position: vectors([first.position, second.position, third.position]),
        normal: vectors([first.normal, second.normal, third.normal]),
        triangle,
        beyond,
    }
}
