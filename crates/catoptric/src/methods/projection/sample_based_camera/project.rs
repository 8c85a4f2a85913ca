//! Scene points to their appearances through the leaves of sample-based cameras.

use super::grid::{NO_RAY, RayGrid};
use super::leaf::Answer;
use super::tree::{Block, Tree};
use crate::methods::projection::{Projection, SpecularPath, VertexProjector};
use crate::optics::bundle::Eye;
use crate::scene::PreciseView;
use glam::{DVec2, Vec2, Vec3};

/// Points nearer to their last bounce than this share of the reflector's size lie on it.
const TOUCHING: f64 = 2e-4;

/// Beyond the outermost rays of a path its leaves are believed so far, in cells.
const BEYOND_BORDER: f64 = 1.5;

/// Two answers of leaves that share a border are one when they are nearer than this many times the accuracy.
const SAME: f32 = 3.0;

/// Starts of Newton's method in a leaf that folds over, after its middle.
const OTHER_STARTS: [(f64, f64); 4] = [(-0.7, -0.7), (0.7, -0.7), (-0.7, 0.7), (0.7, 0.7)];

/// Projects scene points by the cameras of one view.
pub(super) struct CameraProjector<'a> {
    pub(super) grid: &'a RayGrid,
    pub(super) trees: &'a [Tree],
    pub(super) paths: Vec<SpecularPath>,
    pub(super) eye: Eye,
    pub(super) view: PreciseView,
    pub(super) margin_px: f64,
    pub(super) accuracy_px: f32,
    /// The size of every object.
    pub(super) sizes: Vec<f64>,
}

impl VertexProjector for CameraProjector<'_> {
    fn paths(&self) -> &[SpecularPath] {
        &self.paths
    }

    fn project_on(&self, path: u32, point: Vec3, found: &mut Vec<Projection>) {
        let Some(tree) = self.trees.get(path as usize) else { return };
        if !point.is_finite() {
            return;
        }
        let start = found.len();
        let exact = point.as_dvec3();
        tree.leaves_at(exact, |leaf, block| {
            let slice = leaf.slice(exact);
            let mut take = |from: DVec2| {
                let Some(answer) = leaf.seen(&slice, from) else { return };
                let Some(projection) = self.projection(path, block, &answer) else { return };
                let same = |other: &Projection| {
                    other.focal_index == projection.focal_index
                        && other.image_px.distance(projection.image_px) < SAME * self.accuracy_px
                };
                if !found[start..].iter().any(same) {
                    found.push(projection);
                }
            };
            take(DVec2::ZERO);
            if slice.folds() {
                OTHER_STARTS.into_iter().for_each(|(x, y)| take(DVec2::new(x, y)));
            }
        });
    }

    fn follow(&self, one: &Projection, point: Vec3, found: &mut Vec<Projection>) {
        let Some(tree) = self.trees.get(one.path as usize) else { return };
        let mut place = self.cell_of([one.image_px.x.into(), one.image_px.y.into()]);
        let mut first = one.reflection_point.as_dvec3();
        // In the leaf where the appearance is, and if it has moved out of it in that one.
        for _ in 0..2 {
            let Some((leaf, block)) = tree.leaf_at(self.grid, place) else { break };
            let Some(answer) = leaf.seen(&leaf.slice(point.as_dvec3()), leaf.parameters(first)) else { break };
            if let Some(projection) = self.projection(one.path, block, &answer) {
                found.push(projection);
                return;
            }
            let Some(seen) = self.view.place_of(answer.first) else { break };
            (place, first) = (self.cell_of(seen), answer.first);
        }
        self.project_on(one.path, point, found);
    }
}

impl CameraProjector<'_> {
    /// A place of the picture in cells of the ray map, whose rays are at whole numbers.
    fn cell_of(&self, pixel: [f64; 2]) -> [f64; 2] {
        pixel.map(|pixel| (pixel + self.margin_px) / f64::from(self.grid.spacing_px) - 0.5)
    }

    /// A leaf's answer as an appearance; none outside the leaf's block of rays, but where no rays are.
    fn projection(&self, path: u32, block: &Block, answer: &Answer) -> Option<Projection> {
        let object = self.paths[path as usize].bounces.last()?.object;
        if answer.last_segment < TOUCHING * self.sizes[object as usize] {
            return None;
        }
        // Polynomials go on beyond the silhouette, to the side that is not seen.
        if self.eye.direction_to(answer.first)?.dot(answer.normal) >= 0.0 {
            return None;
        }
        let [x, y] = self.view.place_of(answer.first)?;
        let spacing = f64::from(self.grid.spacing_px);
        let place = self.cell_of([x, y]);
        let leeway = f64::from(self.accuracy_px) / spacing;
        let is_near = || block.holds(place, BEYOND_BORDER) && self.is_at_border(path, place);
        if !(block.holds(place, leeway) || is_near()) {
            return None;
        }
        let gradients = self.view.place_change(answer.first);
        let image_change = gradients.map(|gradient| {
            let [right, up] = answer.moves.map(|moves| gradient.dot(moves));
            (answer.lateral[0] * right + answer.lateral[1] * up).as_vec3()
        });
        let projection = Projection {
            path,
            focal_index: answer.focal_index,
            image_px: Vec2::new(x as f32, y as f32),
            image_change,
            path_length: answer.length as f32,
            reflection_point: answer.first.as_vec3(),
            last_segment: answer.last_segment as f32,
            error_px: self.accuracy_px,
        };
        projection.if_meaningful()
    }

    /// Whether one of the four rays around a place, in cells, is not on the path.
    fn is_at_border(&self, path: u32, [x, y]: [f64; 2]) -> bool {
        let group = &self.grid.groups[path as usize];
        let has_ray = |column: f64, row: f64| {
            let inside =
                column >= 0.0 && row >= 0.0 && column < f64::from(self.grid.columns) && row < f64::from(self.grid.rows);
            inside && group.ray_of_cell[row as usize * self.grid.columns as usize + column as usize] != NO_RAY
        };
        let (column, row) = (x.floor(), y.floor());
        let corners = [(column, row), (column + 1.0, row), (column, row + 1.0), (column + 1.0, row + 1.0)];
        !corners.into_iter().all(|(column, row)| has_ray(column, row))
    }
}
