//! Ray maps: a sparse sampling of view rays, followed through reflectors and lenses, that can be asked near which of
//! its outgoing rays a scene point lies.

mod cells;
mod lines;
mod sample;
mod tree;
mod tubes;

pub use cells::{Sampling, ViewField, eye_of};
pub use lines::{Lines, Offset};
pub use sample::{Approximation, Motion, Neighbour, RaySample, Specular, follow};
pub use tree::RayTree;
pub use tubes::RayTubes;

use crate::math::Aabb;
use crate::methods::projection::SpecularPath;
use crate::optics::bundle::Eye;
use crate::parallel;
use crate::scene::Ray;
use cells::{CellIndex, Cells};
use glam::{DMat2, DVec2, DVec3, Vec2, Vec3};

/// Where a ray map's rays come from: a two-dimensional field of rays, with coordinates in pixels.
pub trait RayField: Sync {
    /// Its width and height in pixels.
    fn size_px(&self) -> [f32; 2];

    /// What all its rays have in common.
    fn eye(&self) -> Eye;

    /// The ray at a place of the field, and from which distance on it counts.
    fn ray(&self, x_px: f32, y_px: f32) -> (Ray, f32);

    /// The place where a world point is seen; none behind the eye.
    fn place_of(&self, point: DVec3) -> Option<[f64; 2]>;

    /// The change of the two coordinates of [`Self::place_of`] with the point.
    fn place_change(&self, point: DVec3) -> [DVec3; 2];
}

/// Which rays are candidates for the reflections of a point.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum CandidateRule {
    /// Those that are nearer than all their neighbours in the map.
    LocalMinima,
    /// Of those, the ones whose expansion (to first order) finds the point's ray within so many times the distance to
    /// their neighbours, in the picture.
    InReach(f32),
    /// So many nearest ones.
    Nearest(usize),
}

/// What finds candidates quickly.
#[derive(Debug)]
pub enum CandidateFinder {
    /// For local minima and nearest rays.
    Tree(RayTree),
    /// For rays in reach.
    Tubes(RayTubes),
}

impl CandidateFinder {
    fn byte_count(&self) -> usize {
        match self {
            Self::Tree(tree) => tree.byte_count(),
            Self::Tubes(tubes) => tubes.byte_count(),
        }
    }
}

/// All outgoing rays of one path.
#[derive(Debug)]
pub struct PathRays {
    /// The path.
    pub path: SpecularPath,
    /// The samples.
    pub samples: Vec<RaySample>,
    /// The same rays as lines with their neighbours.
    pub lines: Lines,
    /// How far (in scene units on the first surface) a sample's neighbours are from it.
    pub reach: Vec<f32>,
    /// The same in pixels, where they are seen.
    reach_px: Vec<f32>,
    /// The change of the place where the first reflection point is seen with the bundle's parameters, in pixels.
    picture_change: Vec<DMat2>,
    /// What finds the candidates of a point.
    pub finder: CandidateFinder,
    rule: CandidateRule,
    /// The sample of each cell; [`NO_SAMPLE`] where the cell has none on this path.
    sample_of_cell: Vec<u32>,
}

/// A cell without a sample.
const NO_SAMPLE: u32 = u32::MAX;

/// A sparse sampling of a field of view rays.
#[derive(Debug, Default)]
pub struct RayMap {
    /// The rays of every path, in the order of the paths.
    pub groups: Vec<PathRays>,
    /// Rays traced to build it, bounces included.
    pub rays_traced: u64,
    /// Rays of the field that were sampled.
    pub samples: usize,
    index: CellIndex,
}

impl RayMap {
    /// Samples a field. The octrees cover `bounds`: points outside it are looked up one by one.
    pub fn build(
        specular: &Specular<'_>,
        field: &dyn RayField,
        sampling: &Sampling,
        bounds: &Aabb,
        rule: CandidateRule,
    ) -> Self {
        let cells = Cells::sample(specular, field, sampling, bounds);
        let rays_traced = cells.rays_traced();
        let paths = cells.paths();
        let neighbours = cells.neighbours();
        let mut groups: Vec<Group> = paths.into_iter().map(Group::new).collect();
        let samples = cells.len();
        // Of each cell, the place of its sample in every path's list.
        let mut places: Vec<Vec<(u32, u32)>> = vec![Vec::new(); samples];
        let (index, cell_samples) = cells.into_parts();
        for (cell, found) in cell_samples.into_iter().enumerate() {
            for (path, sample) in found {
                let Ok(group) = groups.binary_search_by(|group| group.path.cmp(&path)) else { continue };
                places[cell].push((group as u32, groups[group].samples.len() as u32));
                groups[group].cells.push(cell as u32);
                groups[group].samples.push(sample);
            }
        }
        let mut finished = parallel::map_collect(groups.len(), |index| {
            let group = &groups[index];
            let in_group = |cell: u32| {
                places[cell as usize].iter().find(|(path, _)| *path as usize == index).map(|(_, place)| *place)
            };
            let neighbours: Vec<Vec<u32>> = group
                .cells
                .iter()
                .map(|&cell| neighbours[cell as usize].iter().filter_map(|&other| in_group(other)).collect())
                .collect();
            group.finished(field, samples, &neighbours, bounds, rule)
        });
        // Samples are large: they are moved here, not copied there.
        for (rays, group) in finished.iter_mut().zip(groups) {
            (rays.path, rays.samples) = (group.path, group.samples);
        }
        Self { groups: finished, rays_traced, samples, index }
    }

    /// The index of a path's sample whose cell covers a place of the field.
    #[inline]
    pub fn sample_at(&self, group: &PathRays, place: [f64; 2]) -> Option<u32> {
        let sample = group.sample_of_cell[self.index.cell_at(place)? as usize];
        (sample != NO_SAMPLE).then_some(sample)
    }

    /// Memory of the samples and trees.
    pub fn byte_count(&self) -> u64 {
        let of_group = |group: &PathRays| {
            size_of_val(group.samples.as_slice()) + group.lines.byte_count() + group.finder.byte_count()
        };
        self.groups.iter().map(of_group).sum::<usize>() as u64
    }
}

struct Group {
    path: SpecularPath,
    samples: Vec<RaySample>,
    cells: Vec<u32>,
}

impl Group {
    fn new(path: SpecularPath) -> Self {
        Self { path, samples: Vec::new(), cells: Vec::new() }
    }

    /// What is found out about the samples; path and samples are still to be filled in.
    fn finished(
        &self,
        field: &dyn RayField,
        cells: usize,
        neighbours: &[Vec<u32>],
        bounds: &Aabb,
        rule: CandidateRule,
    ) -> PathRays {
        let ray = |sample: &RaySample| (sample.rays.origin.as_vec3(), sample.rays.direction.as_vec3());
        let lines = Lines::new(self.samples.iter().map(ray), neighbours);
        let reach = self.samples.iter().zip(neighbours).map(|(sample, neighbours)| {
            let distance = |&other: &u32| sample.first.value.distance(self.samples[other as usize].first.value) as f32;
            neighbours.iter().map(distance).fold(0.0, f32::max)
        });
        let reach: Vec<f32> = reach.collect();
        let place = |sample: &RaySample| field.place_of(sample.first.value).unwrap_or_default().map(|px| px as f32);
        let places: Vec<[f32; 2]> = self.samples.iter().map(place).collect();
        let reach_px = places.iter().zip(neighbours).map(|(&own, neighbours)| {
            let distance = |&other: &u32| Vec2::from(own).distance(places[other as usize].into());
            neighbours.iter().map(distance).fold(0.0, f32::max)
        });
        let reach_px: Vec<f32> = reach_px.collect();
        let picture_change = self.samples.iter().map(|sample| {
            let ([x, y], tangents) = (field.place_change(sample.first.value), sample.first.first);
            DMat2::from_cols_array_2d(&tangents.map(|tangent| [x.dot(tangent), y.dot(tangent)]))
        });
        let picture_change: Vec<DMat2> = picture_change.collect();
        let finder = match rule {
            CandidateRule::LocalMinima => CandidateFinder::Tree(RayTree::of_local_minima(&lines, bounds)),
            CandidateRule::Nearest(count) => CandidateFinder::Tree(RayTree::of_nearest(&lines, bounds, count)),
            CandidateRule::InReach(times) => {
                let trusted: Vec<f32> = reach_px.iter().map(|reach| reach * times).collect();
                CandidateFinder::Tubes(RayTubes::new(&self.samples, &picture_change, &trusted, &places))
            }
        };
        let mut sample_of_cell = vec![NO_SAMPLE; cells];
        for (sample, &cell) in self.cells.iter().enumerate() {
            sample_of_cell[cell as usize] = sample as u32;
        }
        PathRays {
            path: SpecularPath::default(),
            samples: Vec::new(),
            lines,
            reach,
            reach_px,
            picture_change,
            finder,
            rule,
            sample_of_cell,
        }
    }
}

/// Memory for look-ups, to be used again and again.
#[derive(Clone, Debug, Default)]
pub struct CandidateScratch {
    rays: Vec<u32>,
    distances: Vec<(f32, u32)>,
}

impl PathRays {
    /// How far from a sample parameters are seen, in pixels, to first order.
    #[inline]
    pub fn distance_px(&self, ray: u32, parameters: DVec2) -> f64 {
        (self.picture_change[ray as usize] * parameters).length()
    }

    /// The same in distances of its neighbours.
    #[inline]
    pub fn picture_distance(&self, ray: u32, parameters: DVec2) -> f64 {
        self.distance_px(ray, parameters) / f64::from(self.reach_px[ray as usize])
    }

    /// Calls `found` for every sample that is a candidate for the reflections of a point, by the rule that the map was
    /// built for; the nearest rays nearest first.
    #[inline]
    pub fn candidates(&self, point: Vec3, scratch: &mut CandidateScratch, mut found: impl FnMut(u32)) {
        let CandidateScratch { rays, distances } = scratch;
        rays.clear();
        match &self.finder {
            CandidateFinder::Tubes(tubes) => tubes.reaching(point, rays),
            CandidateFinder::Tree(tree) => match tree.candidates(&self.lines, point) {
                Some(candidates) => rays.extend_from_slice(candidates),
                None => rays.extend(0..self.lines.len() as u32),
            },
        }
        if let CandidateRule::Nearest(count) = self.rule {
            distances.clear();
            for &ray in rays.iter() {
                let own = self.lines.offset(ray, point);
                if own.along > 0.0 {
                    distances.push((own.across.length_squared(), ray));
                }
            }
            distances.sort_by(|a, b| a.0.total_cmp(&b.0).then(a.1.cmp(&b.1)));
            distances.iter().take(count).for_each(|(_, ray)| found(*ray));
        } else {
            for &ray in rays.iter() {
                let own = self.lines.offset(ray, point);
                if own.along > 0.0 && self.lines.is_local_minimum(ray, &own, point) {
                    found(ray);
                }
            }
        }
    }
}

#[cfg(test)]
mod tests;
