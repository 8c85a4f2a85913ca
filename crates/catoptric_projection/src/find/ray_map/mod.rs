//! Ray maps: a sparse sampling of view rays, followed through reflectors and lenses, that can be asked near which of
//! its outgoing rays a scene point lies.

mod beam;
mod beam_tree;
mod beams;
mod candidate_filter;
mod cells;
mod field;
mod lines;
mod sample;
mod scatter;
mod second_order;
mod tree;

pub use beam::{Beam, Reach};
pub use beam_tree::BeamTree;
pub use beams::{RayBeams, Reaching};
pub use candidate_filter::{Attempt, CandidateFilter};
pub use cells::Sampling;
pub use field::{RayField, ViewField, eye_of};
pub use lines::{Lines, Offset};
pub use sample::{Approximation, Motion, Neighbour, RaySample, follow};
pub use scatter::{Scattering, Specular, departure, is_spurious};
pub use second_order::SecondOrderBound;
pub use tree::RayTree;

use catoptric_core::math::Aabb;
use catoptric_core::parallel;
use catoptric_core::progress::{Cancelled, Progress};
use catoptric_engine::method::projector::SpecularPath;
use catoptric_engine::optics::path::bundle::FirstOrder;
use catoptric_engine::raster::BlockMask;
use cells::{CellIndex, SampleCells};
use glam::{DMat2, DVec2, Vec2, Vec3};
use std::f64::consts::FRAC_1_SQRT_2;
use std::sync::OnceLock;

/// Rule for the candidate rays of a point.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum CandidateRule {
    /// Rays whose expansion (to first order) leads to the point's ray, in the picture, in about the distance in which
    /// it leads to their neighbours' rays, but at most in so many times the distance to these.
    InReach(f32),
    /// This number of nearest rays.
    Nearest(usize),
}

/// Acceleration structure of candidates.
#[derive(Debug)]
pub enum CandidateFinder {
    /// An octree for nearest rays.
    Tree(RayTree),
    /// Beams for rays in reach.
    Beams(RayBeams),
}

impl CandidateFinder {
    fn byte_count(&self) -> usize {
        match self {
            Self::Tree(tree) => tree.byte_count(),
            Self::Beams(beams) => beams.byte_count(),
        }
    }
}

/// The outgoing rays of one path.
#[derive(Debug)]
pub struct PathRays {
    /// The path.
    pub path: SpecularPath,
    /// The samples.
    pub samples: Vec<RaySample>,
    /// The rays as lines, with their neighbours.
    pub lines: Lines,
    /// The distance of each sample's neighbours, in scene units on the first surface.
    pub reach: Vec<f32>,
    /// The places where samples are seen in the field, in pixels.
    places: Vec<[f32; 2]>,
    /// The sizes of their cells, in pixels.
    size_px: Vec<f32>,
    /// `reach` as it is seen in the field, in pixels.
    reach_px: Vec<f32>,
    /// The greatest distance from each sample, in pixels and to first order, up to which its expansion is used.
    trusted_px: Vec<f32>,
    /// The change of the place where the first reflection point is seen with the bundle's parameters, in pixels.
    picture_change: Vec<DMat2>,
    /// Bounds of the second-order terms, in pixels.
    second_order: Vec<SecondOrderBound>,
    /// Acceleration structure of the candidates of a point.
    pub finder: CandidateFinder,
    /// The sample of each cell; [`NO_SAMPLE`] where the cell has none on this path.
    sample_of_cell: Vec<u32>,
    /// True for samples with which their neighbours disagree however fine the grid is: at the border of the path, and
    /// beside folds.
    is_rough: Vec<bool>,
    /// True for samples that are not rough, or have a neighbour that is not.
    beside_even: Vec<bool>,
    /// Beams of the `beside_even` samples, made when they are needed.
    even_beams: OnceLock<RayBeams>,
    /// Points are expected about so far away from the reflectors.
    typical_distance: f64,
}

/// Samples are asked for points on their neighbours' rays at these shares of the scene's size. Chosen, not measured.
const PROBED_SHARES: [f64; 4] = [0.03, 0.15, 0.4, 0.9];

/// Samples reach this share of the way to their neighbours: from there on the neighbours' expansions are better.
/// Chosen, not measured.
const NEEDED_SHARE: f32 = 0.75;

/// The least reach of samples, in distances of their neighbours. Chosen, not measured.
const MIN_REACH: f32 = 0.75;

/// The least reach beside the border of their path: at silhouettes, where directions change with the square root of the
/// distance, expansions see points on the silhouette itself twice as far away. By that reasoning, not measured.
const BORDER_REACH: f32 = 2.0;

/// Beams are widest across which they are so at this share of the scene's size. Chosen, not measured.
const TYPICAL_SHARE: f64 = 0.25;

/// The reach of samples where nearest rays are asked for, in distances of their neighbours. Chosen, not measured.
const NEAREST_REACH: f32 = 3.0;

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
    /// Cells that disagree with their neighbours, but are not divided since there would be too many.
    pub left_coarse: u64,
    index: CellIndex,
}

impl RayMap {
    /// Samples a field. The octrees cover `bounds`: points outside it are looked up one by one.
    ///
    /// # Errors
    /// [`Cancelled`].
    pub fn build(
        specular: &Specular<'_>,
        field: &dyn RayField,
        sampling: &Sampling,
        bounds: &Aabb,
        rule: CandidateRule,
        progress: &dyn Progress,
    ) -> Result<Self, Cancelled> {
        let cells = SampleCells::sample(specular, field, sampling, bounds, progress)?;
        let (rays_traced, left_coarse) = (cells.rays_traced(), cells.left_coarse());
        let paths = cells.paths();
        let neighbours_of_cells = cells.neighbours();
        let sizes_px = cells.sizes_px();
        let finest_px = sizes_px.iter().copied().fold(f32::INFINITY, f32::min);
        let is_finest = |cell: u32| finest_px < sampling.spacing_px && sizes_px[cell as usize] == finest_px;
        let mut groups: Vec<Group> = paths.into_iter().map(Group::new).collect();
        let samples = cells.len();
        // For each cell, the place of its sample in every path's list.
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
        let mut finished = parallel::map_stage(progress, "expanding rays", groups.len(), |index| {
            let group = &groups[index];
            let in_group = |cell: u32| {
                places[cell as usize].iter().find(|(path, _)| *path as usize == index).map(|(_, place)| *place)
            };
            let neighbours: Vec<Vec<u32>> = group
                .cells
                .iter()
                .map(|&cell| neighbours_of_cells[cell as usize].iter().filter_map(|&other| in_group(other)).collect())
                .collect();
            let at_border =
                |(cell, inside): (&u32, &Vec<u32>)| inside.len() < neighbours_of_cells[*cell as usize].len();
            let at_border: Vec<bool> = group.cells.iter().zip(&neighbours).map(at_border).collect();
            let is_rough = parallel::map_collect(group.samples.len(), |sample| {
                let predicts_badly = |&other: &u32| {
                    let (own, other) = (&group.samples[sample], &group.samples[other as usize]);
                    cells::predicts_badly(field, own, other, sampling.accuracy_px, bounds)
                };
                is_finest(group.cells[sample]) && (at_border[sample] || neighbours[sample].iter().any(predicts_badly))
            });
            let neighbourhood = Neighbourhood { neighbours: &neighbours, at_border: &at_border };
            let mut rays = group.finished(field, samples, neighbourhood, bounds, rule);
            let is_even = |sample: &u32| !is_rough[*sample as usize];
            rays.beside_even = (0..group.samples.len() as u32)
                .map(|sample| is_even(&sample) || neighbours[sample as usize].iter().any(is_even))
                .collect();
            rays.is_rough = is_rough;
            rays.size_px = group.cells.iter().map(|&cell| sizes_px[cell as usize]).collect();
            rays
        })?;
        // Samples are large: they are moved here, not copied there.
        for (rays, group) in finished.iter_mut().zip(groups) {
            (rays.path, rays.samples) = (group.path, group.samples);
        }
        Ok(Self { groups: finished, rays_traced, samples, left_coarse, index })
    }

    /// The index of a path's sample whose cell covers a place of the field.
    #[inline]
    pub fn sample_at(&self, group: &PathRays, place: [f64; 2]) -> Option<u32> {
        let sample = group.sample_of_cell[self.index.cell_at(place)? as usize];
        (sample != NO_SAMPLE).then_some(sample)
    }

    /// The blocks of a picture where a path is not seen, or neighbouring rays disagree however fine the grid is. The
    /// field has so many pixels more than the picture on every side.
    pub fn rough_blocks(&self, group: &PathRays, margin_px: f32, picture: [u32; 2]) -> BlockMask {
        let picture = picture.map(|pixels| pixels as usize);
        let [mut seen, mut rough] = [BlockMask::new(picture), BlockMask::new(picture)];
        for (sample, place) in group.places.iter().enumerate() {
            let place = Vec2::from(*place) - margin_px;
            let half = Vec2::splat(0.5 * group.size_px[sample] - 0.01);
            let blocks = if group.is_rough[sample] { &mut rough } else { &mut seen };
            blocks.add_box(place - half, place + half);
        }
        seen.invert();
        seen.add(&rough);
        seen
    }

    /// True if a place of the field is where neighbouring rays of a path agree, or beside such a place.
    #[inline]
    pub fn is_beside_even(&self, group: &PathRays, place: Vec2) -> bool {
        let sample = self.sample_at(group, [place.x.into(), place.y.into()]);
        sample.is_some_and(|sample| group.beside_even[sample as usize])
    }

    /// Memory of the samples and trees.
    pub fn byte_count(&self) -> u64 {
        let of_group = |group: &PathRays| {
            size_of_val(group.samples.as_slice()) + group.lines.byte_count() + group.finder.byte_count()
        };
        self.groups.iter().map(of_group).sum::<usize>() as u64
    }
}

/// The distance from a sample, in pixels, that its expansion must reach to find the reflections of points on a
/// neighbour's ray.
fn needed_px(sample: &RaySample, neighbour: &RaySample, picture_change: &DMat2, bounds: &Aabb) -> f32 {
    let (rays, other) = (&sample.rays, &neighbour.rays);
    let size = f64::from(bounds.diagonal());
    let at = |share: f64| {
        let distance = share * size;
        let point = other.origin + other.direction * distance;
        // On another sheet the expansion leads elsewhere.
        if rays.focal_points_before(distance) != other.focal_points_before(distance) {
            return f32::INFINITY;
        }
        let Some(perturbation) = rays.perturbed(point) else { return f32::INFINITY };
        let needed = (*picture_change * perturbation.linear).length() as f32;
        if needed.is_nan() { f32::INFINITY } else { needed }
    };
    NEEDED_SHARE * PROBED_SHARES.into_iter().map(at).fold(0.0, f32::max)
}

/// The samples around each sample of a path.
struct Neighbourhood<'a> {
    /// The neighbours of each sample on the same path.
    neighbours: &'a [Vec<u32>],
    /// True if there are others: the path ends somewhere between.
    at_border: &'a [bool],
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

    /// Neighbourhoods of the samples; path and samples are still to be filled in.
    fn finished(
        &self,
        field: &dyn RayField,
        cells: usize,
        neighbourhood: Neighbourhood<'_>,
        bounds: &Aabb,
        rule: CandidateRule,
    ) -> PathRays {
        let neighbours = neighbourhood.neighbours;
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
        let second_order = self.samples.iter().zip(&picture_change).map(|(sample, picture_change)| {
            SecondOrderBound::new(sample, picture_change, field.place_change(sample.first.value))
        });
        let second_order = second_order.collect();
        let trusted_px = match rule {
            CandidateRule::InReach(most) => parallel::map_collect(self.samples.len(), |index| {
                let most = most * reach_px[index];
                let least = if neighbourhood.at_border[index] { BORDER_REACH } else { MIN_REACH } * reach_px[index];
                let needed = neighbours[index].iter().fold(0.0, |needed: f32, &other| {
                    let (own, other) = (&self.samples[index], &self.samples[other as usize]);
                    needed.max(needed_px(own, other, &picture_change[index], bounds))
                });
                needed.clamp(least, most.max(least))
            }),
            CandidateRule::Nearest(_) => reach_px.iter().map(|reach| reach * NEAREST_REACH).collect(),
        };
        let typical_distance = TYPICAL_SHARE * f64::from(bounds.diagonal());
        let finder = match rule {
            CandidateRule::Nearest(count) => CandidateFinder::Tree(RayTree::new(&lines, bounds, count)),
            CandidateRule::InReach(_) => CandidateFinder::Beams(RayBeams::new(
                &self.samples,
                &picture_change,
                &trusted_px,
                &places,
                typical_distance,
            )),
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
            places,
            size_px: Vec::new(),
            reach_px,
            trusted_px,
            picture_change,
            second_order,
            finder,
            sample_of_cell,
            is_rough: Vec::new(),
            beside_even: Vec::new(),
            even_beams: OnceLock::new(),
            typical_distance,
        }
    }
}

/// The largest length of the image of a unit vector: the larger singular value. Not a number, or infinite, if the
/// matrix is not finite.
pub fn largest_stretch(matrix: DMat2) -> f64 {
    let [a, b, c, d] = matrix.to_cols_array();
    let (sum, product) = (a * a + b * b + c * c + d * d, a * d - b * c);
    let difference = (sum * sum - 4.0 * product * product).max(0.0).sqrt();
    (0.5 * (sum + difference)).sqrt()
}

/// A sample that may lead to a reflection of a point.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Candidate {
    /// The sample.
    pub ray: u32,
    /// Place that it leads to, if predicted ([`CandidateRule::InReach`]).
    pub reaching: Option<Reaching>,
}

/// Memory for look-ups, to be used again and again.
#[derive(Clone, Debug, Default)]
pub struct CandidateScratch {
    reaching: Vec<Reaching>,
    order: Vec<u64>,
    distances: Vec<(f32, u32)>,
}

impl PathRays {
    /// The distance between a sample and the place where parameters are seen, in pixels, to first order.
    #[inline]
    pub fn distance_px(&self, ray: u32, parameters: DVec2) -> f64 {
        (self.picture_change[ray as usize] * parameters).length()
    }

    /// The change of a sample's place in the picture with its outgoing ray's direction: pixels a radian, along that
    /// ray's two axes; not finite where the picture shows the same direction all around.
    #[inline]
    pub fn place_change_with_direction(&self, ray: u32) -> DMat2 {
        self.picture_change[ray as usize] * self.samples[ray as usize].rays.direction_change().inverse()
    }

    /// The angle between a sample's outgoing ray and those halfway to its neighbours, to the corners of its cell, to
    /// first order, in radians.
    #[inline]
    pub fn turn(&self, ray: u32) -> f64 {
        let change = self.samples[ray as usize].rays.direction_change() * self.picture_change[ray as usize].inverse();
        largest_stretch(change) * f64::from(self.reach_px[ray as usize]) * FRAC_1_SQRT_2
    }

    /// The most that the second order of a sample's expansion moves an appearance, in pixels.
    #[inline]
    pub fn second_order_px(&self, ray: u32, first: &FirstOrder) -> f64 {
        self.second_order[ray as usize].px(&self.picture_change[ray as usize], first)
    }

    /// True if a sample's expansion may lead that far.
    #[inline]
    pub fn is_trusted(&self, ray: u32, parameters: DVec2) -> bool {
        self.distance_px(ray, parameters) <= f64::from(self.trusted_px[ray as usize])
    }

    /// The distance between a sample and the place where parameters are seen, in distances of its neighbours.
    #[inline]
    pub fn picture_distance(&self, ray: u32, parameters: DVec2) -> f64 {
        self.distance_px(ray, parameters) / f64::from(self.reach_px[ray as usize])
    }

    /// True if a sample's neighbours disagree with it however fine the grid is.
    #[inline]
    pub fn is_rough(&self, ray: u32) -> bool {
        self.is_rough[ray as usize]
    }

    /// The beams of samples with whose expansions their neighbours agree, or beside one of these.
    fn even_beams(&self) -> &RayBeams {
        self.even_beams.get_or_init(|| {
            // Samples that reach nothing are left out.
            let reach_px: Vec<f32> = self
                .trusted_px
                .iter()
                .zip(&self.beside_even)
                .map(|(px, even)| if *even { *px } else { -1.0 })
                .collect();
            RayBeams::new(&self.samples, &self.picture_change, &reach_px, &self.places, self.typical_distance)
        })
    }

    /// True if a point of a ball may be in the reach of a sample with whose expansion its neighbours agree, or beside
    /// one of these.
    pub fn may_be_even(&self, center: Vec3, radius: f32) -> bool {
        self.even_beams().may_reach(center, radius)
    }

    /// Like [`Self::candidates`] by reach, but only samples with which their neighbours agree, or those beside one.
    #[inline]
    pub fn even_candidates(&self, point: Vec3, scratch: &mut CandidateScratch, found: impl FnMut(Candidate)) {
        nearest_first(self.even_beams(), point, scratch, found);
    }

    /// Calls `found` for every sample that is a candidate for the reflections of a point, by the rule that the map was
    /// built for; the nearest first.
    #[inline]
    pub fn candidates(&self, point: Vec3, scratch: &mut CandidateScratch, mut found: impl FnMut(Candidate)) {
        let tree = match &self.finder {
            CandidateFinder::Beams(beams) => return nearest_first(beams, point, scratch, found),
            CandidateFinder::Tree(tree) => tree,
        };
        let distances = &mut scratch.distances;
        let candidates = tree.candidates(&self.lines, point);
        let all = 0..if candidates.is_none() { self.lines.len() as u32 } else { 0 };
        let rays = candidates.unwrap_or(&[]).iter().copied().chain(all);
        let offsets = rays.map(|ray| (ray, self.lines.offset(ray, point))).filter(|(_, own)| own.along > 0.0);
        distances.clear();
        distances.extend(offsets.map(|(ray, own)| (own.across.length_squared(), ray)));
        distances.sort_by(|a, b| a.0.total_cmp(&b.0).then(a.1.cmp(&b.1)));
        let nearest = distances.iter().take(tree.count());
        nearest.for_each(|(_, ray)| found(Candidate { ray: *ray, reaching: None }));
    }
}

/// Calls `found` for every sample in whose reach a point is, the nearest first.
#[inline]
fn nearest_first(beams: &RayBeams, point: Vec3, scratch: &mut CandidateScratch, mut found: impl FnMut(Candidate)) {
    let CandidateScratch { reaching, order, .. } = scratch;
    reaching.clear();
    beams.reaching(point, reaching);
    // Positive numbers sort like their bits, and whole numbers sort fastest.
    let key = |(place, one): (usize, &Reaching)| u64::from(one.distance2.to_bits()) << 32 | place as u64;
    order.clear();
    order.extend(reaching.iter().enumerate().map(key));
    order.sort_unstable();
    let in_order = order.iter().map(|&key| reaching[key as u32 as usize]);
    in_order.for_each(|one| found(Candidate { ray: one.sample, reaching: Some(one) }));
}
