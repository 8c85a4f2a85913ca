//! The grid of nodes around a reflector, and the tetrahedron of it that an eye is in (Popescu, Sacks, Mei 2006, section
//! VI).

use crate::sample_based_camera::settings::node_counts;
use catoptric_core::math::Aabb;
use glam::{UVec3, Vec3};

/// Nodes at the corners of cubes.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct NodeGrid {
    low: Vec3,
    /// The side of a cube.
    pub spacing: f32,
    counts: UVec3,
}

/// The four nodes around an eye with their barycentric weights, whose sum is 1; those without weight are left out.
pub type Tetrahedron = Vec<(UVec3, f32)>;

impl NodeGrid {
    /// The grid around a reflector's box: along the longer of its horizontal axes it reaches so many diagonals of the
    /// box beyond it.
    pub fn around(bounds: &Aabb, counts: UVec3, reach: f32) -> Self {
        let diagonal = bounds.diagonal();
        let spacing = diagonal * (1.0 + 2.0 * reach) / (counts.x.max(counts.z) - 1) as f32;
        let size = (counts - UVec3::ONE).as_vec3() * spacing;
        Self { low: bounds.center() - size * 0.5, spacing, counts }
    }

    /// The place of a node.
    pub fn place(&self, node: UVec3) -> Vec3 {
        self.low + node.as_vec3() * self.spacing
    }

    /// The tetrahedron that a place lies in; `None` beyond the grid.
    ///
    /// Each cube is cut into six tetrahedra about its diagonal, by the order of the place's coordinates in it. So
    /// neighbours share whole faces, and weights are continuous.
    pub fn tetrahedron(&self, place: Vec3) -> Option<Tetrahedron> {
        let cells = (place - self.low) / self.spacing;
        let last = (self.counts - UVec3::ONE).as_vec3();
        if !(cells.cmpge(Vec3::ZERO).all() && cells.cmple(last).all()) {
            return None;
        }
        let cell = cells.as_uvec3().min(self.counts - UVec3::splat(2));
        let within = (cells - cell.as_vec3()).to_array();
        let mut axes = [0, 1, 2];
        axes.sort_by(|&a, &b| within[b].total_cmp(&within[a]));
        let (mut corner, mut before, mut corners) = (cell, 1.0, Vec::with_capacity(4));
        for axis in axes {
            corners.push((corner, before - within[axis]));
            before = within[axis];
            corner[axis] += 1;
        }
        corners.push((corner, before));
        corners.retain(|(_, weight)| *weight > 0.0);
        Some(corners)
    }
}

/// The nodes of a reflector's grid around an eye: their places with their barycentric weights, whose sum is 1, four of
/// them at the most; `None` beyond the grid. `grid` and `grid_reach` are the settings of these names, `bounds` is the
/// reflector's box.
///
/// # Errors
/// Says what is wrong with `grid`.
///
/// ```
/// use catoptric::math::Aabb;
/// use catoptric::methods::projection::sample_based_camera::nodes_around;
/// use glam::Vec3;
///
/// let bounds = Aabb { min: Vec3::ZERO, max: Vec3::ONE };
/// let eye = Vec3::new(1.9, 0.4, -1.2);
/// let nodes = nodes_around(&bounds, "17x17x8", 2.0, eye).unwrap().unwrap();
/// let mean: Vec3 = nodes.iter().map(|(place, weight)| *place * *weight).sum();
/// assert!(nodes.len() == 4 && mean.distance(eye) < 1e-5);
/// ```
pub fn nodes_around(bounds: &Aabb, grid: &str, grid_reach: f32, eye: Vec3) -> Result<Option<Vec<(Vec3, f32)>>, String> {
    let grid = NodeGrid::around(bounds, node_counts(grid)?, grid_reach);
    let corners = grid.tetrahedron(eye);
    Ok(corners.map(|corners| corners.into_iter().map(|(node, weight)| (grid.place(node), weight)).collect()))
}
