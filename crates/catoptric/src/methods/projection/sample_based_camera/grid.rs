//! The dense ray map: every d-th view ray in both directions, followed through reflectors and lenses, and rays close to
//! where paths end.

use super::{creases, pieces};
use crate::math::Aabb;
use crate::methods::projection::ray_map::{RayField, Specular};
use crate::methods::projection::{MAX_BOUNCES, SpecularPath};
use crate::optics::bundle::{Bounce, BounceKind};
use crate::parallel;
use crate::scene::{Ray, Role};
use glam::DVec3;
use std::ops::Range;

/// Where paths end between neighbouring rays is found this near, in pixels.
pub(super) const BORDER_PX: f32 = 0.06;

/// Beyond the outermost rays of a path, places belong to it no further than this, in cells.
const FARTHEST_NEIGHBOUR: f32 = 0.75;

/// A cell that has more than one piece in it or beside it, or none.
const MIXED: u32 = u32::MAX;

/// A cell of the map that is meant by nobody.
pub(super) const NO_CELL: u32 = u32::MAX;

/// An outgoing ray, without the path that led to it.
#[derive(Clone, Copy, Debug)]
pub(super) struct GridRay {
    /// Where its view ray is, in cells: those of the regular map are at whole numbers.
    pub(super) place: [f32; 2],
    /// The first bounce point, and the unit normal there, on the side of the eye.
    pub(super) first: DVec3,
    pub(super) normal: DVec3,
    /// Its tail, the last bounce point, and unit direction.
    pub(super) tail: DVec3,
    pub(super) direction: DVec3,
    /// Optical length from the eye (its plane) to the tail.
    pub(super) length: f64,
    /// Index of refraction of what it runs through.
    pub(super) medium: f64,
}

/// All rays of one path.
#[derive(Clone, Debug, Default)]
pub(super) struct PathRays {
    pub(super) path: SpecularPath,
    /// In the order of the cells nearest to them, row by row; a cell's regular ray is its first.
    pub(super) rays: Vec<GridRay>,
    /// Where each of them is in the map, in cells: what is searched most.
    places: Vec<[f32; 2]>,
    /// The connected region that each ray belongs to.
    pub(super) piece_of_ray: Vec<u32>,
    pub(super) piece_count: u32,
    /// The rectangle of cells with rays.
    low: [u32; 2],
    size: [u32; 2],
    /// Where the rays of each of its cells start.
    starts: Vec<u32>,
    /// The piece of each of its cells, or [`MIXED`].
    piece_of_cell: Vec<u32>,
}

/// The rays of every path, on one grid of cells.
#[derive(Clone, Debug, Default)]
pub(super) struct RayGrid {
    /// Pixels between neighbouring rays; those of cell `(i, j)` are at `(i + 1/2, j + 1/2)` times this in the field.
    pub(super) spacing_px: f32,
    pub(super) groups: Vec<PathRays>,
    /// Rays traced, bounces included.
    pub(super) traced: u64,
}

/// A ray on its way into the grid.
#[derive(Clone, Copy, Debug)]
pub(super) struct Entry {
    group: u32,
    cell: u32,
    /// The cells between whose rays it was looked for; [`NO_CELL`] for regular rays.
    pub(super) between: [u32; 2],
    ray: GridRay,
}

/// What is found in one row.
#[derive(Default)]
struct RowEntries {
    /// The paths that occur; the entries' groups are indices of these.
    paths: Vec<Bounces>,
    entries: Vec<Entry>,
    room: Room,
}

impl RowEntries {
    fn group_of(&mut self, bounces: &Bounces) -> u32 {
        let known = self.paths.iter().position(|known| known == bounces);
        known.unwrap_or_else(|| {
            self.paths.push(*bounces);
            self.paths.len() - 1
        }) as u32
    }
}

/// Room for following a ray.
#[derive(Default)]
pub(super) struct Room {
    waiting: Vec<Waiting>,
    /// Rays traced so far.
    pub(super) traced: u64,
}

/// Traces the rays of a field.
pub(super) struct Sampler<'a> {
    specular: &'a Specular<'a>,
    field: &'a dyn RayField,
    pub(super) spacing_px: f32,
    /// How many regular rays there are across and down.
    size: [u32; 2],
    mapped: &'a [bool],
}

impl<'a> Sampler<'a> {
    /// Of a regular ray every `spacing_px`. Objects of `mapped` show environment maps: no path goes on at them.
    pub(super) fn new(
        specular: &'a Specular<'a>,
        field: &'a dyn RayField,
        spacing_px: f32,
        mapped: &'a [bool],
    ) -> Self {
        let size = field.size_px().map(|size| ((size / spacing_px).ceil() as u32).max(1));
        Self { specular, field, spacing_px, size, mapped }
    }

    /// The outgoing ray of a path at a place (in cells), if the path is seen there.
    pub(super) fn ray_on(&self, path: &SpecularPath, place: [f32; 2], room: &mut Room) -> Option<GridRay> {
        let [x, y] = place.map(|place| (place + 0.5) * self.spacing_px);
        let (ray, near) = self.field.ray(x, y);
        let wanted = |bounces: &Bounces| path.bounces.starts_with(&bounces.bounces[..bounces.count]);
        let mut on_path = None;
        follow(self.specular, self.mapped, &ray, near, room, &wanted, &mut |bounces, ray| {
            if bounces.count == path.bounces.len() {
                on_path = Some(GridRay { place, ..ray });
            }
        });
        on_path
    }

    /// Follows the ray at a place (in cells); a number that tells which paths it has taken, 0 for none.
    fn sample(&self, place: [f32; 2], cell: u32, between: [u32; 2], row: &mut RowEntries) -> u64 {
        let [x, y] = place.map(|place| (place + 0.5) * self.spacing_px);
        let (ray, near) = self.field.ray(x, y);
        let mut signature = 0u64;
        let mut room = std::mem::take(&mut row.room);
        follow(self.specular, self.mapped, &ray, near, &mut room, &|_| true, &mut |bounces, ray| {
            signature = signature.wrapping_add(bounces.signature());
            let group = row.group_of(&bounces);
            row.entries.push(Entry { group, cell, between, ray: GridRay { place, ..ray } });
        });
        row.room = room;
        signature
    }

    /// Closes in on where paths change between the rays of two cells with different signatures.
    fn close_in(&self, cells: [u32; 2], signature: u64, row: &mut RowEntries) {
        let [mut from, mut to] = cells.map(|cell| [cell % self.size[0], cell / self.size[0]].map(|index| index as f32));
        let mut apart_px = self.spacing_px;
        while apart_px > BORDER_PX {
            let middle = [0, 1].map(|axis: usize| 0.5 * (from[axis] + to[axis]));
            let cell = middle[1].round() as u32 * self.size[0] + middle[0].round() as u32;
            let same = self.sample(middle, cell, cells, row) == signature;
            *(if same { &mut from } else { &mut to }) = middle;
            apart_px *= 0.5;
        }
    }
}

impl RayGrid {
    /// Follows the rays of a field.
    pub(super) fn new(sampler: &Sampler<'_>) -> Self {
        let Sampler { specular, field, spacing_px, size: [columns, rows], .. } = *sampler;
        let spans = spans(specular, field, spacing_px, [columns, rows]);
        let regular = parallel::map_collect(rows as usize, |row| {
            let mut entries = RowEntries::default();
            let mut signatures = vec![0; columns as usize];
            for column in spans[row].clone() {
                let cell = row as u32 * columns + column;
                signatures[column as usize] =
                    sampler.sample([column as f32, row as f32], cell, [NO_CELL; 2], &mut entries);
            }
            (entries, signatures)
        });
        let signature = |column: u32, row: u32| regular[row as usize].1[column as usize];
        let borders = parallel::map_collect(rows as usize, |row| {
            let mut entries = RowEntries::default();
            let row = row as u32;
            let one_more = |count: u32, index: u32| (index + 1 < count).then_some(index + 1);
            for column in 0..columns {
                let own = signature(column, row);
                let right = one_more(columns, column).map(|column| (column, row));
                let below = one_more(rows, row).map(|row| (column, row));
                for (column_beside, row_beside) in [right, below].into_iter().flatten() {
                    if signature(column_beside, row_beside) != own {
                        let cells = [row * columns + column, row_beside * columns + column_beside];
                        sampler.close_in(cells, own, &mut entries);
                    }
                }
            }
            entries
        });
        let regular = regular.into_iter().map(|(entries, _)| entries);
        let found: Vec<RowEntries> = regular.chain(borders).collect();
        let traced: u64 = found.iter().map(|row| row.room.traced).sum();
        let mut groups = by_path(found);
        groups.sort_by(|a, b| a.0.cmp(&b.0));
        let reach = specular.scene.bounds.diagonal();
        let groups = parallel::map_collect(groups.len(), |index| {
            let (path, entries) = &groups[index];
            let mut group = PathRays::new(path.clone(), entries, columns, reach.into());
            let mut room = Room::default();
            let beside = creases::beside(&group, sampler, reach.into(), &mut room);
            group.add(beside);
            (group, room.traced)
        });
        let traced = traced + groups.iter().map(|(_, traced)| traced).sum::<u64>();
        Self { spacing_px, groups: groups.into_iter().map(|(group, _)| group).collect(), traced }
    }
}

/// The columns of each row in which reflectors and lenses may be seen first.
fn spans(specular: &Specular<'_>, field: &dyn RayField, spacing_px: f32, [columns, rows]: [u32; 2]) -> Vec<Range<u32>> {
    let mut spans = vec![0..0; rows as usize];
    for object in specular.scene.specular_objects() {
        let bounds = &specular.scene.objects[object as usize].bounds;
        let seen = extent(bounds, field).map(|[low, high]| {
            let cell = |px: f64| (px / f64::from(spacing_px) - 0.5).clamp(-1.0, 1e9);
            // One cell more on every side, for rounding.
            let [first, last] = [low, high].map(|corner| corner.map(cell));
            [first.map(|cell| (cell - 1.0).max(0.0) as u32), last.map(|cell| (cell + 2.0).max(0.0) as u32)]
        });
        let [low, high] = seen.unwrap_or([[0, 0], [columns, rows]]);
        for span in &mut spans[(low[1].min(rows)) as usize..(high[1] + 1).min(rows) as usize] {
            let (start, end) = (low[0].min(columns), (high[0] + 1).min(columns));
            *span = if span.start >= span.end { start..end } else { span.start.min(start)..span.end.max(end) };
        }
    }
    spans
}

/// The rectangle of the field that a box appears in; none where some of it is beside or behind the eye.
pub(super) fn extent(bounds: &Aabb, field: &dyn RayField) -> Option<[[f64; 2]; 2]> {
    let mut found = [[f64::INFINITY; 2], [f64::NEG_INFINITY; 2]];
    for corner in 0..8 {
        let axis = |axis: usize| f64::from(if corner >> axis & 1 == 0 { bounds.min[axis] } else { bounds.max[axis] });
        let place = field.place_of(DVec3::new(axis(0), axis(1), axis(2)))?;
        for (axis, place) in place.into_iter().enumerate() {
            found[0][axis] = found[0][axis].min(place);
            found[1][axis] = found[1][axis].max(place);
        }
    }
    Some(found)
}

/// The entries of all rows by their paths, in the order of the rows.
fn by_path(rows: Vec<RowEntries>) -> Vec<(SpecularPath, Vec<Entry>)> {
    let mut known: Vec<Bounces> = Vec::new();
    let mut groups: Vec<(SpecularPath, Vec<Entry>)> = Vec::new();
    for row in rows {
        let numbers: Vec<usize> = row
            .paths
            .iter()
            .map(|bounces| {
                known.iter().position(|other| other == bounces).unwrap_or_else(|| {
                    known.push(*bounces);
                    let path = SpecularPath { bounces: bounces.bounces[..bounces.count].to_vec() };
                    groups.push((path, Vec::new()));
                    known.len() - 1
                })
            })
            .collect();
        for entry in row.entries {
            groups[numbers[entry.group as usize]].1.push(entry);
        }
    }
    groups
}

impl PathRays {
    /// `reach` is how far rays are expected to go.
    fn new(path: SpecularPath, entries: &[Entry], columns: u32, reach: f64) -> Self {
        let place = |cell: u32| [cell % columns, cell / columns];
        let (mut low, mut high) = ([u32::MAX; 2], [0; 2]);
        for entry in entries {
            for (axis, index) in place(entry.cell).into_iter().enumerate() {
                low[axis] = low[axis].min(index);
                high[axis] = high[axis].max(index);
            }
        }
        let size = [0, 1].map(|axis: usize| high[axis] + 1 - low[axis].min(high[axis]));
        let mut group = Self { path, low, size, ..Self::default() };
        let bin = |cell: u32| {
            let [column, row] = place(cell);
            ((row - low[1]) * size[0] + column - low[0]) as usize
        };
        let mut starts = vec![0u32; (size[0] * size[1]) as usize + 1];
        for entry in entries {
            starts[bin(entry.cell) + 1] += 1;
        }
        for index in 1..starts.len() {
            starts[index] += starts[index - 1];
        }
        let mut next = starts.clone();
        let mut order = vec![0u32; entries.len()];
        // Regular rays come first among the entries, so they do in their cells.
        for (index, entry) in entries.iter().enumerate() {
            let next = &mut next[bin(entry.cell)];
            order[*next as usize] = index as u32;
            *next += 1;
        }
        group.starts = starts;
        group.rays = order.iter().map(|&index| entries[index as usize].ray).collect();
        group.places = group.rays.iter().map(|ray| ray.place).collect();
        let between: Vec<[u32; 2]> = order.iter().map(|&index| entries[index as usize].between).collect();
        (group.piece_of_ray, group.piece_count) = pieces::of(&group, &between, columns, reach);
        group.piece_of_cell = group.pieces_of_cells();
        group
    }

    /// Adds rays of known pieces near to others. What becomes of the numbers of rays: the old ones by the new ones, those
    /// that are added after the others.
    pub(super) fn add(&mut self, added: Vec<(GridRay, u32)>) -> Vec<u32> {
        let before = self.rays.len();
        if added.is_empty() {
            return (0..before as u32).collect();
        }
        // What lies beyond the outermost cells belongs to these.
        let bin = |ray: &GridRay| {
            let inside = |axis: usize| {
                let (low, size) = (i64::from(self.low[axis]), i64::from(self.size[axis]));
                (ray.place[axis].round() as i64 - low).clamp(0, size - 1) as usize
            };
            inside(1) * self.size[0] as usize + inside(0)
        };
        let bins = (0..self.starts.len() - 1)
            .flat_map(|bin| (self.starts[bin]..self.starts[bin + 1]).map(move |_| bin))
            .chain(added.iter().map(|(ray, _)| bin(ray)));
        let mut order: Vec<(usize, u32)> = bins.zip(0..).collect();
        // Regular rays stay the first of their cells.
        order.sort_unstable();
        let mut starts = vec![0u32; self.starts.len()];
        for (bin, _) in &order {
            starts[bin + 1] += 1;
        }
        for index in 1..starts.len() {
            starts[index] += starts[index - 1];
        }
        let order: Vec<u32> = order.into_iter().map(|(_, ray)| ray).collect();
        let (rays, pieces): (Vec<GridRay>, Vec<u32>) = order
            .iter()
            .map(|&ray| match (ray as usize).checked_sub(before) {
                Some(index) => added[index],
                None => (self.rays[ray as usize], self.piece_of_ray[ray as usize]),
            })
            .unzip();
        (self.rays, self.piece_of_ray, self.starts) = (rays, pieces, starts);
        self.places = self.rays.iter().map(|ray| ray.place).collect();
        order
    }

    /// The numbers of the rays of a cell.
    #[inline]
    pub(super) fn in_cell(&self, column: i64, row: i64) -> Range<usize> {
        let Some(bin) = self.bin(column, row) else { return 0..0 };
        self.starts[bin] as usize..self.starts[bin + 1] as usize
    }

    /// The numbers of the rays of some cells of a row, from the first column to the second.
    #[inline]
    fn in_cells(&self, columns: [i64; 2], row: i64) -> Range<usize> {
        let last = i64::from(self.size[0]) - 1;
        let [first, end] = columns.map(|column| column - i64::from(self.low[0]));
        let row = row - i64::from(self.low[1]);
        if end < 0 || first > last || row < 0 || row >= i64::from(self.size[1]) {
            return 0..0;
        }
        let bin = |column: i64| (row * (last + 1) + column) as usize;
        self.starts[bin(first.max(0))] as usize..self.starts[bin(end.min(last)) + 1] as usize
    }

    /// The regular ray of a cell.
    #[inline]
    pub(super) fn regular(&self, column: i64, row: i64) -> Option<usize> {
        let first = self.in_cell(column, row).next()?;
        (self.places[first] == [column as f32, row as f32]).then_some(first)
    }

    /// The ray nearest to a place, in cells; none where none is within three quarters of a cell.
    pub(super) fn nearest(&self, place: [f64; 2]) -> Option<usize> {
        let mut nearest = (f32::INFINITY, 0);
        let [x, y] = place.map(|place| place as f32);
        let mut look = |columns: [i64; 2], rows: [i64; 2]| {
            for row in rows[0]..=rows[1] {
                let rays = self.in_cells(columns, row);
                for (place, ray) in self.places[rays.clone()].iter().zip(rays) {
                    let (right, down) = (place[0] - x, place[1] - y);
                    let distance2 = right * right + down * down;
                    if distance2 < nearest.0 {
                        nearest = (distance2, ray);
                    }
                }
            }
            nearest
        };
        // Rays of other cells than the four around the place are more than half a cell away.
        let [left, above] = place.map(|place| place.floor() as i64);
        let mut nearest = look([left, left + 1], [above, above + 1]);
        if nearest.0 > 0.25 {
            let [column, row] = place.map(|place| place.round() as i64);
            nearest = look([column - 1, column + 1], [row - 1, row + 1]);
        }
        (nearest.0 <= FARTHEST_NEIGHBOUR * FARTHEST_NEIGHBOUR).then_some(nearest.1)
    }

    /// The piece that a place belongs to.
    #[inline]
    pub(super) fn piece_at(&self, place: [f64; 2]) -> Option<u32> {
        let [column, row] = place.map(|place| place.round() as i64);
        match self.bin(column, row).map(|bin| self.piece_of_cell[bin]) {
            Some(piece) if piece != MIXED => Some(piece),
            _ => self.nearest(place).map(|ray| self.piece_of_ray[ray]),
        }
    }

    #[inline]
    fn bin(&self, column: i64, row: i64) -> Option<usize> {
        let (column, row) = (column - i64::from(self.low[0]), row - i64::from(self.low[1]));
        let inside = column >= 0 && row >= 0 && column < i64::from(self.size[0]) && row < i64::from(self.size[1]);
        inside.then(|| row as usize * self.size[0] as usize + column as usize)
    }

    /// The piece of each cell that has, like all cells around it, a regular ray of one and the same piece.
    fn pieces_of_cells(&self) -> Vec<u32> {
        let piece = |column: i64, row: i64| self.regular(column, row).map(|ray| self.piece_of_ray[ray]);
        let cells =
            (0..i64::from(self.size[1])).flat_map(|row| (0..i64::from(self.size[0])).map(move |column| (column, row)));
        cells
            .map(|(column, row)| {
                let (column, row) = (column + i64::from(self.low[0]), row + i64::from(self.low[1]));
                let Some(own) = piece(column, row) else { return MIXED };
                let mut around = (-1..=1).flat_map(|down| (-1..=1).map(move |right| (column + right, row + down)));
                if around.all(|(column, row)| piece(column, row) == Some(own)) { own } else { MIXED }
            })
            .collect()
    }

    /// The rays of a piece in the square whose corners are four regular rays, the first at `cell`.
    pub(super) fn in_unit(&self, cell: [u32; 2], piece: u32) -> impl Iterator<Item = usize> {
        let low = cell.map(i64::from);
        let corners = [(0, 0), (1, 0), (0, 1), (1, 1)];
        let rays = corners.into_iter().flat_map(move |(right, down)| self.in_cell(low[0] + right, low[1] + down));
        rays.filter(move |&ray| {
            let inside = |axis: usize| (0.0..=1.0).contains(&(self.rays[ray].place[axis] - cell[axis] as f32));
            self.piece_of_ray[ray] == piece && inside(0) && inside(1)
        })
    }

    /// The cell that a ray is nearest to.
    pub(super) fn cell_of(&self, ray: usize) -> [i64; 2] {
        self.rays[ray].place.map(|place| place.round() as i64)
    }
}

/// A path so far.
#[derive(Clone, Copy, Debug, PartialEq)]
struct Bounces {
    count: usize,
    bounces: [Bounce; MAX_BOUNCES],
}

impl Bounces {
    /// A number by which sets of paths are told apart as sums.
    fn signature(&self) -> u64 {
        self.bounces[..self.count].iter().fold(0x9e37_79b9_7f4a_7c15, |number: u64, bounce| {
            let letter = u64::from(bounce.object) << 1 | u64::from(bounce.kind == BounceKind::Reflect);
            let mixed = (number ^ letter.wrapping_add(0x632b_e59b_d9b4_e019)).wrapping_mul(0xff51_afd7_ed55_8ccd);
            mixed ^ mixed >> 32
        })
    }
}

/// A ray on its way.
#[derive(Clone, Copy, Debug)]
struct Waiting {
    ray: Ray,
    near: f32,
    from: DVec3,
    direction: DVec3,
    first: Option<(DVec3, DVec3)>,
    length: f64,
    medium: f64,
    bounces: Bounces,
}

/// Calls `found` for the outgoing ray of every `wanted` path that a view ray begins; paths that begin with unwanted
/// ones are not followed. Its place is left at the origin.
fn follow(
    specular: &Specular<'_>,
    mapped: &[bool],
    ray: &Ray,
    near: f32,
    room: &mut Room,
    wanted: &impl Fn(&Bounces) -> bool,
    found: &mut impl FnMut(Bounces, GridRay),
) {
    let Room { waiting, traced } = room;
    let most = (specular.order as usize).min(MAX_BOUNCES);
    if most == 0 {
        return;
    }
    let none = Bounces { count: 0, bounces: [Bounce { object: 0, kind: BounceKind::Reflect }; MAX_BOUNCES] };
    waiting.clear();
    waiting.push(Waiting {
        ray: *ray,
        near,
        from: ray.origin.as_dvec3(),
        direction: ray.direction.as_dvec3().normalize_or_zero(),
        first: None,
        length: 0.0,
        medium: 1.0,
        bounces: none,
    });
    while let Some(before) = waiting.pop() {
        *traced += 1;
        let Some(hit) = specular.tracer.first_hit(specular.scene, &before.ray, before.near) else { continue };
        let Some((object, site)) = specular.surfaces.site_of(&before.ray, &hit) else { continue };
        if mapped.get(object as usize) == Some(&true) {
            continue;
        }
        let Some(frame) = specular.surfaces.frame(object, &site) else { continue };
        let lens = specular.scene.role_of(object) == Role::Lens;
        let cosine = before.direction.dot(frame.normal);
        let outside = cosine <= 0.0;
        if outside && specular.scene.objects[object as usize].inside {
            continue; // the blind side
        }
        let index = specular.surfaces.index_of(object);
        // Whoever meets a lens from inside was inside it.
        let medium = if lens && !outside { index } else { before.medium };
        let length = before.length + medium * before.from.distance(frame.position);
        for kind in [BounceKind::Transmit, BounceKind::Reflect] {
            let (direction, medium) = match kind {
                BounceKind::Reflect => (before.direction - frame.normal * (2.0 * cosine), medium),
                BounceKind::Transmit if lens => {
                    let ratio = if outside { 1.0 / index } else { index };
                    let Some(direction) = refracted(before.direction, frame.normal, cosine, ratio) else { continue };
                    (direction, if outside { index } else { 1.0 })
                }
                BounceKind::Transmit => continue,
            };
            // With shading normals light may seem to come from behind the flat triangle.
            let geometric = frame.geometric_normal();
            if (direction.dot(geometric) > 0.0) != (outside == (kind == BounceKind::Reflect)) {
                continue;
            }
            let mut bounces = before.bounces;
            bounces.bounces[bounces.count] = Bounce { object, kind };
            bounces.count += 1;
            if !wanted(&bounces) {
                continue;
            }
            let first = before.first.unwrap_or((frame.position, if outside { frame.normal } else { -frame.normal }));
            let tail = frame.position;
            let ray = GridRay { place: [0.0; 2], first: first.0, normal: first.1, tail, direction, length, medium };
            found(bounces, ray);
            if bounces.count < most {
                let offset = 16.0 * f64::from(f32::EPSILON) * tail.abs().max_element();
                let origin = (tail + geometric * offset.copysign(direction.dot(geometric))).as_vec3();
                let ray = Ray { origin, direction: direction.as_vec3().normalize() };
                let first = Some(first);
                waiting.push(Waiting { ray, near: 0.0, from: tail, direction, first, length, medium, bounces });
            }
        }
    }
}

/// Snell's law; none where there is total reflection. `ratio`: the index before over that behind.
fn refracted(direction: DVec3, normal: DVec3, cosine: f64, ratio: f64) -> Option<DVec3> {
    let behind = 1.0 - ratio * ratio * (1.0 - cosine * cosine);
    (behind >= 0.0).then(|| direction * ratio + normal * (behind.sqrt().copysign(cosine) - ratio * cosine))
}
