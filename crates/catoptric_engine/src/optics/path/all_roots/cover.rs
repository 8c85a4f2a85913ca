//! A surface covered by cells: a hierarchy of balls and cones of normals over a tessellation, and triangular cells
//! that are halved without end.

use catoptric_core::math::portable::PortableMath;
use catoptric_core::surface::{PlacedSurface, Taylor2};
use glam::DVec3;

/// The ratio of a cell's ball to the ball of its corners: neighbouring cells that are halved unevenly leave slivers
/// between them, as curved borders do, and both are of second order in the cell's size.
const CELL_MARGIN: f64 = 1.15;

/// Bulge of the surface over a tessellation's triangles, in lengths of their longest edge. An edge that turns by half
/// a radian bulges by a sixteenth.
const BULGE: f64 = 0.1;

/// Triangles in a leaf of the hierarchy.
const LEAF_TRIANGLES: usize = 4;

/// A piece of surface, bounded: it lies within a ball, its normals lie within a cone.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct BoundingCone {
    pub(super) center: DVec3,
    pub(super) radius: f64,
    /// The cone's unit axis.
    pub(super) axis: DVec3,
    /// Half its opening angle.
    pub(super) angle: f64,
}

#[derive(Clone, Copy, Debug)]
pub(super) enum CoverContent {
    /// Two nodes: this one and the next.
    Inner(u32),
    /// Triangles from the first to before the second.
    Leaf(u32, u32),
}

#[derive(Clone, Copy, Debug)]
pub(super) struct CoverNode {
    pub(super) bounds: BoundingCone,
    pub(super) content: CoverContent,
}

/// A tessellated surface and the hierarchy over it, in the world.
#[derive(Clone, Debug)]
pub(super) struct Cover {
    pub(super) nodes: Vec<CoverNode>,
    triangles: Vec<[u32; 3]>,
    positions: Vec<DVec3>,
    normals: Vec<DVec3>,
    /// The diagonal of the surface's box.
    pub(super) size: f64,
}

/// The angle between two unit vectors, exact for small ones.
pub(super) fn angle_between(a: DVec3, b: DVec3) -> f64 {
    a.cross(b).length().arc_tangent2(a.dot(b))
}

/// The point of the surface near a point, by Newton's steps along the gradient, and the Taylor coefficients there.
pub(super) fn onto_surface(surface: &PlacedSurface, near: DVec3) -> Option<(DVec3, Taylor2)> {
    let mut at = near;
    let mut taylor = surface.taylor2(at);
    for _ in 0..20 {
        let step = taylor.gradient * (taylor.value / taylor.gradient.length_squared());
        if !step.is_finite() {
            return None;
        }
        if step.length_squared() <= 1e-32 * at.length_squared() {
            break;
        }
        at -= step;
        taylor = surface.taylor2(at);
    }
    Some((at, taylor))
}

/// A triangular cell with corners on the surface.
#[derive(Clone, Copy, Debug)]
pub(super) struct SurfaceCell {
    corners: [DVec3; 3],
    pub(super) normals: [DVec3; 3],
    /// Ball and cone; the ball's centre lies on the surface, the cone's axis is the normal there.
    pub(super) bounds: BoundingCone,
}

impl SurfaceCell {
    /// The cell of three points on the surface; returns `None` if the surface has no normal.
    fn new(surface: &PlacedSurface, corners: [DVec3; 3], normals: [DVec3; 3]) -> Option<Self> {
        let (center, taylor) = onto_surface(surface, (corners[0] + corners[1] + corners[2]) / 3.0)?;
        let axis = taylor.normal()?;
        let radius = CELL_MARGIN * corners.map(|corner| corner.distance(center)).into_iter().fold(0.0, f64::max);
        // Normals at the corners miss a bend between them; the curvature at the centre does not.
        let columns = [taylor.hessian.x_axis, taylor.hessian.y_axis, taylor.hessian.z_axis];
        let bend = columns.map(|column| column.length_squared()).iter().sum::<f64>().sqrt();
        let turn = bend / taylor.gradient.length() * radius;
        let spread = normals.map(|normal| angle_between(normal, axis)).into_iter().fold(0.0, f64::max);
        let angle = CELL_MARGIN * spread.max(turn);
        let bounds = BoundingCone { center, radius, axis, angle };
        (center.is_finite() && radius.is_finite() && angle.is_finite()).then_some(Self { corners, normals, bounds })
    }

    pub(super) fn corners(&self) -> &[DVec3; 3] {
        &self.corners
    }

    /// The cell's halves, split across its longest edge.
    pub(super) fn halves(&self, surface: &PlacedSurface) -> [Option<Self>; 2] {
        let length2 = |i: usize| self.corners[i].distance_squared(self.corners[(i + 1) % 3]);
        let longest = (0..3).max_by(|i, j| length2(*i).total_cmp(&length2(*j))).unwrap_or(0);
        let [i, j, k] = [longest, (longest + 1) % 3, (longest + 2) % 3];
        let middle = onto_surface(surface, (self.corners[i] + self.corners[j]) * 0.5)
            .and_then(|(at, taylor)| Some((at, taylor.normal()?)));
        let Some((at, normal)) = middle else { return [None; 2] };
        [[Some(i), None, Some(k)], [None, Some(j), Some(k)]].map(|picked| {
            let corners = picked.map(|corner| corner.map_or(at, |corner| self.corners[corner]));
            let normals = picked.map(|corner| corner.map_or(normal, |corner| self.normals[corner]));
            Self::new(surface, corners, normals)
        })
    }
}

impl Cover {
    /// The cover of a surface by its tessellation, whose points are moved onto the surface in double precision.
    pub(super) fn new(surface: &PlacedSurface) -> Self {
        let mesh = surface.surface.tessellate();
        let place = &surface.world_from_surface;
        let points: Vec<_> = (mesh.positions.iter().zip(&mesh.normals))
            .map(|(position, normal)| {
                let near = place.transform_point3(position.as_dvec3());
                let rough = place.transform_vector3(normal.as_dvec3()).normalize_or_zero();
                let exact = onto_surface(surface, near);
                exact.and_then(|(at, taylor)| Some((at, taylor.normal()?))).unwrap_or((near, rough))
            })
            .collect();
        let (positions, normals): (Vec<_>, Vec<_>) = points.into_iter().unzip();
        let low = positions.iter().copied().fold(DVec3::INFINITY, DVec3::min);
        let high = positions.iter().copied().fold(DVec3::NEG_INFINITY, DVec3::max);
        let mut cover = Self { nodes: Vec::new(), triangles: mesh.triangles, positions, normals, size: 0.0 };
        if !cover.triangles.is_empty() {
            cover.size = high.distance(low);
            cover
                .nodes
                .push(CoverNode { bounds: cover.bounds(0, cover.triangles.len()), content: CoverContent::Leaf(0, 0) });
            cover.build();
        }
        cover
    }

    fn build(&mut self) {
        let mut open = vec![(0usize, 0usize, self.triangles.len())];
        while let Some((node, begin, end)) = open.pop() {
            if end - begin <= LEAF_TRIANGLES {
                self.nodes[node].content = CoverContent::Leaf(begin as u32, end as u32);
                continue;
            }
            let positions = &self.positions;
            let middle = |triangle: &[u32; 3]| triangle.map(|corner| positions[corner as usize]).iter().sum::<DVec3>();
            let part = &mut self.triangles[begin..end];
            let low = part.iter().map(middle).fold(DVec3::INFINITY, DVec3::min);
            let high = part.iter().map(middle).fold(DVec3::NEG_INFINITY, DVec3::max);
            let axis = (high - low).max_position();
            let half = part.len() / 2;
            part.select_nth_unstable_by(half, |a, b| middle(a)[axis].total_cmp(&middle(b)[axis]));
            let first = self.nodes.len();
            self.nodes[node].content = CoverContent::Inner(first as u32);
            for (begin, end) in [(begin, begin + half), (begin + half, end)] {
                let bounds = self.bounds(begin, end);
                self.nodes.push(CoverNode { bounds, content: CoverContent::Leaf(0, 0) });
                open.push((self.nodes.len() - 1, begin, end));
            }
        }
    }

    /// Ball and cone of a range of triangles.
    fn bounds(&self, begin: usize, end: usize) -> BoundingCone {
        let triangles = &self.triangles[begin..end];
        let corners = || triangles.iter().flatten().map(|corner| *corner as usize);
        let low = corners().map(|corner| self.positions[corner]).fold(DVec3::INFINITY, DVec3::min);
        let high = corners().map(|corner| self.positions[corner]).fold(DVec3::NEG_INFINITY, DVec3::max);
        let center = (low + high) * 0.5;
        let axis = corners().map(|corner| self.normals[corner]).sum::<DVec3>().normalize_or(DVec3::Z);
        let mut edge = 0f64;
        let mut turn = 0f64;
        for triangle in triangles {
            for i in 0..3 {
                let [a, b] = [triangle[i], triangle[(i + 1) % 3]].map(|corner| corner as usize);
                edge = edge.max(self.positions[a].distance(self.positions[b]));
                turn = turn.max(angle_between(self.normals[a], self.normals[b]));
            }
        }
        let radius = corners().map(|corner| self.positions[corner].distance(center)).fold(0.0, f64::max);
        let angle = corners().map(|corner| angle_between(self.normals[corner], axis)).fold(0.0, f64::max);
        BoundingCone { center, radius: radius + BULGE * edge, axis, angle: angle + 0.5 * turn }
    }

    /// The cells of a leaf's triangles; `None` for those without normals.
    pub(super) fn cells(
        &self,
        surface: &PlacedSurface,
        begin: u32,
        end: u32,
    ) -> impl Iterator<Item = Option<SurfaceCell>> {
        self.triangles[begin as usize..end as usize].iter().map(|triangle| {
            let corners = triangle.map(|corner| self.positions[corner as usize]);
            SurfaceCell::new(surface, corners, triangle.map(|corner| self.normals[corner as usize]))
        })
    }
}
