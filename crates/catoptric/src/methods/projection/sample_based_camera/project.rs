//! Scene points to their appearances through the leaves of sample-based cameras.

use super::answer::Answer;
use super::bundle::{ask, ask_near};
use super::bundles::BundleTree;
use super::grid::RayGrid;
use super::layout::BundleLeaf;
use crate::methods::projection::{Projection, SpecularPath, VertexProjector};
use crate::optics::bundle::Eye;
use crate::scene::PreciseView;
use glam::{DVec3, Vec2, Vec3};

/// Points nearer to their last bounce than this share of the reflector's size lie on it.
const TOUCHING: f64 = 2e-4;

/// A leaf is believed so far, in cells, beyond the cells of its rays.
const BEYOND_BLOCK: f64 = 0.75;

/// Two answers of leaves that share a border are one when they are nearer than this many times the accuracy.
const SAME: f32 = 3.0;

/// Projects scene points by the cameras of one view.
pub(super) struct CameraProjector<'a> {
    pub(super) grid: &'a RayGrid,
    pub(super) trees: &'a [BundleTree],
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
        let mut answers = Vec::new();
        tree.leaves_at(point, |leaf| {
            let leaf = &tree.leaves[leaf as usize];
            ask(leaf, point, &mut answers);
            for answer in answers.drain(..) {
                self.take(path, leaf, &answer, start, found);
            }
        });
    }

    fn follow(&self, one: &Projection, point: Vec3, found: &mut Vec<Projection>) {
        let (Some(tree), Some(group)) = (self.trees.get(one.path as usize), self.grid.groups.get(one.path as usize))
        else {
            return;
        };
        let mut place = self.cell_of([one.image_px.x.into(), one.image_px.y.into()]);
        let mut first = one.reflection_point.as_dvec3();
        // In the leaf where the appearance is, and if it has moved out of it in that one.
        for _ in 0..2 {
            let Some(leaf) = group.nearest(place).and_then(|ray| tree.leaf_of(ray)) else { break };
            let Some(answer) = ask_near(leaf, point, first) else { break };
            if let Some(projection) = self.projection(one.path, leaf, &answer) {
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

    /// Appends a leaf's answer unless it is none, or one that another leaf has given.
    fn take(&self, path: u32, leaf: &BundleLeaf, answer: &Answer, start: usize, found: &mut Vec<Projection>) {
        let Some(projection) = self.projection(path, leaf, answer) else { return };
        let same = |other: &Projection| {
            other.focal_index == projection.focal_index
                && other.image_px.distance(projection.image_px) < SAME * self.accuracy_px
        };
        if !found[start..].iter().any(same) {
            found.push(projection);
        }
    }

    /// A leaf's answer as an appearance; none outside the leaf's block of rays.
    fn projection(&self, path: u32, leaf: &BundleLeaf, answer: &Answer) -> Option<Projection> {
        let object = self.paths[path as usize].bounces.last()?.object;
        if f64::from(answer.last_segment) < TOUCHING * self.sizes[object as usize] {
            return None;
        }
        // Polynomials go on beyond the silhouette, to the side that is not seen.
        let towards: DVec3 = self.eye.direction_to(answer.first)?;
        if towards.dot(answer.normal.as_dvec3()) >= 0.0 {
            return None;
        }
        let [x, y] = self.view.place_of(answer.first)?;
        let place = self.cell_of([x, y]);
        if !self.is_within(path, leaf, place) {
            return None;
        }
        let gradients = self.view.place_change(answer.first).map(DVec3::as_vec3);
        // Changes of the place with a lateral step.
        let [across, down] = gradients.map(|gradient| answer.moves.map(|moves| gradient.dot(moves)));
        let image_change = [across, down].map(|[right, up]| answer.lateral[0] * right + answer.lateral[1] * up);
        let largest = [across, down].as_flattened().iter().map(|change| change * change).sum::<f32>().sqrt();
        let projection = Projection {
            path,
            focal_index: answer.focal_index,
            image_px: Vec2::new(x as f32, y as f32),
            image_change,
            path_length: answer.length,
            reflection_point: answer.first.as_vec3(),
            last_segment: answer.last_segment,
            error_px: answer.lateral_error * largest,
        };
        projection.if_meaningful()
    }

    /// Whether a place, in cells, is among the rays of a leaf, or beside them where its piece ends.
    fn is_within(&self, path: u32, leaf: &BundleLeaf, place: [f64; 2]) -> bool {
        let group = &self.grid.groups[path as usize];
        let leeway = f64::from(self.accuracy_px / self.grid.spacing_px);
        for axis in 0..2 {
            let (low, high) = (f64::from(leaf.low_cell[axis]), f64::from(leaf.high_cell[axis]));
            let (beyond, next) =
                if place[axis] > high { (place[axis] - high, high + 1.0) } else { (low - place[axis], low - 1.0) };
            if beyond <= leeway {
                continue;
            }
            let mut cell = place.map(|place| place.round() as i64);
            cell[axis] = next as i64;
            let goes_on = group.regular(cell[0], cell[1]).is_some_and(|ray| group.piece_of_ray[ray] == leaf.piece);
            if beyond > BEYOND_BLOCK || goes_on {
                return false;
            }
        }
        group.piece_at(place) == Some(leaf.piece)
    }
}
