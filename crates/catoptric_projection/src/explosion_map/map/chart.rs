//! The sphere map: directions from a centre to places of a disc, and triangles of hits drawn there.

use crate::explosion_map::cells::{MapCells, RayCorner};
use catoptric_engine::raster::id_map::IdMap;
use glam::{Vec2, Vec3, Vec3A, Vec4};

/// Directions with an axial component below this are looked up about the opposite axis. Chosen, not measured.
pub(super) const TURN: f32 = -0.9;

/// Triangles that reach below this are drawn about the opposite axis, too. Chosen, not measured.
const OVERLAP: f32 = -0.8;

/// Triangles that reach this near to the map's singular direction are not drawn in it. Chosen, not measured.
const SINGULAR: f32 = -0.998;

/// Axes of the sphere map, right-handed; the third is the direction at the disc's centre, its opposite the singular
/// one.
#[derive(Clone, Copy, Debug)]
pub(super) struct Axes {
    axes: [Vec3; 3],
}

/// A direction on the disc.
#[derive(Clone, Copy, Debug)]
pub(super) struct ChartPlace {
    /// Index of one of the two maps: about the axis or about its opposite.
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

    pub(super) fn all(&self) -> [Vec3; 3] {
        self.axes
    }

    /// A unit direction along the axes of the first map.
    #[inline]
    pub(super) fn local(&self, direction: Vec3A) -> Vec3 {
        let [x, y, z] = self.axes.map(|axis| Vec3A::from(axis).dot(direction));
        Vec3::new(x, y, z)
    }

    /// The place at which a unit direction is looked up.
    #[inline]
    pub(super) fn place(&self, direction: Vec3) -> ChartPlace {
        let local = self.local(direction.into());
        let chart = usize::from(local.z < TURN);
        let local = turned(local, chart);
        ChartPlace { chart, uv: mapped(local), local }
    }

    /// The changes of a place's two coordinates with the unit direction.
    pub(super) fn change(&self, place: &ChartPlace) -> [Vec3; 2] {
        let [x, y, z] = self.axes;
        let [y, z] = if place.chart == 0 { [y, z] } else { [-y, -z] };
        let scale = (2.0 + 2.0 * place.local.z).sqrt().recip();
        let fall = scale * scale * scale;
        [x * scale - z * (place.local.x * fall), y * scale - z * (place.local.y * fall)]
    }
}

/// A direction along the axes of the first map in those of another; those of the second are turned about the first axis
/// by half a turn.
#[inline]
pub(super) fn turned(local: Vec3, chart: usize) -> Vec3 {
    if chart == 0 { local } else { Vec3::new(local.x, -local.y, -local.z) }
}

/// True if a triangle of unit directions along the axes of a map is drawn there.
#[inline]
fn is_drawn(local: &[Vec3; 3], chart: usize) -> bool {
    let lowest = local[0].z.min(local[1].z).min(local[2].z);
    let highest = local[0].z.max(local[1].z).max(local[2].z);
    let holds_singular = lowest < 0.0 && holds_opposite_axis(local);
    let singular = lowest < SINGULAR || holds_singular;
    // The second map holds only directions that the first one is not asked for.
    let wanted = chart == 0 || highest > -OVERLAP || holds_axis(local);
    !singular && wanted
}

/// The sphere map of a direction along its axes.
#[inline]
pub(super) fn mapped(local: Vec3) -> Vec2 {
    local.truncate() * (2.0 + 2.0 * local.z).sqrt().recip()
}

fn holds_opposite_axis(local: &[Vec3; 3]) -> bool {
    holds_axis(&local.map(|corner| -corner))
}

/// True if a spherical triangle holds the third axis.
fn holds_axis([a, b, c]: &[Vec3; 3]) -> bool {
    let side = |p: &Vec3, q: &Vec3| p.truncate().perp_dot(q.truncate());
    let sides = [side(a, b), side(b, c), side(c, a)];
    (a.z + b.z + c.z > 0.0) && (sides.iter().all(|side| *side >= 0.0) || sides.iter().all(|side| *side <= 0.0))
}

/// Expansion of the surface at a place of the map, near one of its triangles: position and normal as linear
/// functions of the place.
#[derive(Clone, Copy, Debug)]
pub(super) struct Record {
    /// The position at the first corner, and its changes along both coordinates of the place. The first fourth
    /// component is that corner's first coordinate.
    position: [Vec4; 3],
    /// The normal at the first corner, and its changes; the first fourth component is that corner's second coordinate.
    normal: [Vec4; 3],
}

impl Record {
    #[inline]
    fn new(uv: [Vec2; 3], corners: [&RayCorner; 3]) -> Self {
        let [a, b, c] = uv;
        let (right, down) = (b - a, c - a);
        // The derivatives of a function that is linear in the triangle along both coordinates; cells without area are
        // never looked up.
        let inverse = 1.0 / right.perp_dot(down);
        let along_u = Vec2::new(down.y, -right.y) * inverse;
        let along_v = Vec2::new(-down.x, right.x) * inverse;
        let vectors = |[first, second, third]: [Vec3A; 3], coordinate: f32| {
            let (to_second, to_third) = (second - first, third - first);
            let change = |along: Vec2| (to_second * along.x + to_third * along.y).extend(0.0);
            [first.extend(coordinate), change(along_u), change(along_v)]
        };
        Self {
            position: vectors(corners.map(|corner| corner.position), a.x),
            normal: vectors(corners.map(|corner| corner.normal), a.y),
        }
    }

    /// Position and normal (not of unit length) at a place.
    #[inline]
    pub(super) fn at(&self, uv: Vec2) -> [Vec3A; 2] {
        let (u, v) = (uv.x - self.position[0].w, uv.y - self.normal[0].w);
        let at = |values: &[Vec4; 3]| Vec3A::from_vec4(values[0] + values[1] * u + values[2] * v);
        [at(&self.position), at(&self.normal)]
    }

    /// Changes of the position along both coordinates.
    pub(super) fn position_changes(&self) -> [Vec3; 2] {
        [self.position[1].truncate(), self.position[2].truncate()]
    }

    /// Changes of the normal along both coordinates.
    pub(super) fn normal_changes(&self) -> [Vec3; 2] {
        [self.normal[1].truncate(), self.normal[2].truncate()]
    }
}

/// The origin of a record.
#[derive(Clone, Copy, Debug)]
pub(super) struct Tag {
    /// The triangle of the reflector's mesh.
    pub(super) triangle: u32,
    /// True if it lies beyond where the reflector ends as it is seen.
    pub(super) beyond: bool,
}

/// One of the two maps of a sphere: triangles by place.
#[derive(Clone, Debug, Default)]
pub(super) struct SphereChart {
    records: Vec<Record>,
    tags: Vec<Tag>,
    ids: IdMap,
    size: f32,
}

impl SphereChart {
    /// Draws cells, given by the directions of their corners along the axes of this map, with `size` texels a side.
    pub(super) fn new(size: u32, chart: usize, cells: &MapCells, local: &[Vec3]) -> Self {
        let mut drawn = Self { size: size as f32, ..Self::default() };
        draw(&mut drawn, chart, cells, local);
        drawn
    }

    /// The cells at a place.
    #[inline]
    pub(super) fn at(&self, uv: Vec2) -> impl Iterator<Item = (&Record, &Tag)> {
        let texel = (uv + 1.0) * (0.5 * self.size);
        self.ids.at(texel).map(|id| (&self.records[id as usize], &self.tags[id as usize]))
    }

    /// The first cell at a texel.
    #[inline]
    pub(super) fn first_in(&self, texel: usize) -> Option<&Record> {
        self.records.get(self.ids.first_in(texel) as usize)
    }

    pub(super) fn byte_count(&self) -> u64 {
        let parts = size_of_val(self.records.as_slice()) + size_of_val(self.tags.as_slice());
        self.ids.byte_count() + parts as u64
    }
}

#[multiversion::multiversion(targets("x86_64+avx2+bmi1+bmi2+popcnt+lzcnt"))]
fn draw(drawn: &mut SphereChart, chart: usize, cells: &MapCells, local: &[Vec3]) {
    let scale = 0.5 * drawn.size;
    // The second map holds little, if anything.
    let mut places = Vec::new();
    for cell in &cells.cells {
        let directions = cell.corners.map(|corner| turned(local[corner as usize], chart));
        if !is_drawn(&directions, chart) {
            continue;
        }
        if places.is_empty() {
            places = local.iter().map(|local| mapped(turned(*local, chart))).collect();
            drawn.ids = IdMap::new(drawn.size as u32, drawn.size as u32);
            drawn.records.reserve(if chart == 0 { cells.cells.len() } else { 0 });
            drawn.tags.reserve(drawn.records.capacity());
        }
        let uv = cell.corners.map(|corner| places[corner as usize]);
        // Cells smaller than a texel may never be looked up.
        if drawn.ids.draw(drawn.records.len() as u32, uv.map(|uv| (uv + 1.0) * scale)) {
            drawn.records.push(Record::new(uv, cell.corners.map(|corner| &cells.corners[corner as usize])));
            drawn.tags.push(Tag { triangle: cell.triangle, beyond: cell.beyond });
        }
    }
}
