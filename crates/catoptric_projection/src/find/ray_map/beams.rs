//! A hierarchy of beams around bundles of outgoing rays: which samples' expansions reach a point.
//!
//! A sample serves points that its expansion places, to first order, within some distance of its own place in the
//! picture: at a distance along the ray an ellipse around it, altogether an elliptic beam that opens linearly. Beams
//! of samples beside silhouettes are wide fans. A node's beam is cut out by planes, two across the widest spread of
//! its samples' beams, two across the other way, and one at their start, and holds all of them. So a look-up visits
//! only nodes whose beams hold the point, whatever the size of the scene, and nothing depends on earlier look-ups. (The
//! octree of Chen and Arvo 2000, [`super::RayTree`], answers from the point's cell, which beside silhouettes and
//! caustics holds hundreds of rays.)

use super::beam::Reach;
use super::beam_tree::BeamTree;
use super::sample::RaySample;
use catoptric_core::math::lanes::{LANES, Lanes, Vec3Lanes, bits_of};
use glam::{DMat2, DVec2, Vec2, Vec3};

/// Accepted points lie up to this much further out: single precision is no reason to lose one. Chosen well above
/// rounding, not measured.
const LEEWAY: f32 = 1.0 + 1e-3;

/// Squares of areas at this distance stay in single precision.
const FARTHEST: f32 = 1e12;

/// A sample in whose reach a point is.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Reaching {
    /// The sample.
    pub sample: u32,
    /// Place of the point by its expansion, to first order, in pixels of the field.
    pub place: Vec2,
    /// Square of the distance of that place from its own.
    pub distance2: f32,
    /// True if the surroundings of the point appear mirrored: this is another sheet than one where they do not.
    pub mirrored: bool,
}

/// Samples as arrays, one lane a sample.
#[derive(Clone, Copy, Debug)]
#[repr(align(32))]
struct BeamLeaf {
    origin: Vec3Lanes,
    direction: Vec3Lanes,
    across: [Vec3Lanes; 2],
    /// Lateral change of the origins and of the directions with the place in the picture, row by row.
    origin_change: [Lanes; 4],
    direction_change: [Lanes; 4],
    /// Place of the sample.
    place: [Lanes; 2],
    /// Square of the distance in the picture that is accepted; negative in empty lanes.
    reach2: Lanes,
    samples: [u32; LANES],
}

/// The hierarchy over the samples of a path.
#[derive(Clone, Debug, Default)]
pub struct RayBeams {
    tree: BeamTree,
    leaves: Vec<BeamLeaf>,
}

impl RayBeams {
    /// Over samples whose expansions are trusted for places in the picture up to `reach_px` away from where they are
    /// seen, `places` (samples for which it is below 0 are left out); `picture_change` is the change of places with the
    /// parameters of a sample's bundle. Points are expected about `distance` away from the reflectors.
    pub fn new(
        samples: &[RaySample],
        picture_change: &[DMat2],
        reach_px: &[f32],
        places: &[[f32; 2]],
        distance: f64,
    ) -> Self {
        let mut order: Vec<u32> = (0..samples.len() as u32).filter(|&index| reach_px[index as usize] >= 0.0).collect();
        let code = |index: u32| places.get(index as usize).map_or(0, |place| morton(*place));
        order.sort_by_key(|&index| (code(index), index));
        let mut leaves = Vec::with_capacity(order.len().div_ceil(LANES));
        // Reaches in the order of the leaves, and where those of each leaf end.
        let (mut reaches, mut ends) = (Vec::with_capacity(order.len()), Vec::new());
        for chunk in order.chunks(LANES) {
            let mut leaf = BeamLeaf::EMPTY;
            for (lane, &index) in chunk.iter().enumerate() {
                let place = index as usize;
                let (sample, change) = (&samples[place], &picture_change[place]);
                reaches.extend(leaf.set(lane, index, sample, change, reach_px[place], places[place]));
            }
            leaves.push(leaf);
            ends.push(reaches.len());
        }
        Self { tree: BeamTree::new(&reaches, ends, distance), leaves }
    }

    /// Appends all samples in whose reach a point is, or may be but for rounding. Points farther away than 1e12 are
    /// taken for points there.
    pub fn reaching(&self, point: Vec3, found: &mut Vec<Reaching>) {
        reaching(self, point.clamp_length_max(FARTHEST).to_array(), found);
    }

    /// True if a point of a ball may be in the reach of a sample.
    pub fn may_reach(&self, center: Vec3, radius: f32) -> bool {
        let is_far = !center.is_finite() || center.length() + radius >= FARTHEST;
        is_far || self.tree.may_hold_any(center.to_array(), radius)
    }

    /// Memory of the arrays.
    pub fn byte_count(&self) -> usize {
        self.tree.byte_count() + size_of_val(self.leaves.as_slice())
    }
}

#[multiversion::multiversion(targets("x86_64+avx2+bmi1+bmi2+popcnt+lzcnt"))]
fn reaching(beams: &RayBeams, point: [f32; 3], found: &mut Vec<Reaching>) {
    beams.tree.visit(point, |leaf| {
        if let Some(leaf) = beams.leaves.get(leaf as usize) {
            leaf.reaching(point, found);
        }
    });
}

impl BeamLeaf {
    const EMPTY: Self = Self {
        origin: Vec3Lanes::ZERO,
        direction: Vec3Lanes::ZERO,
        across: [Vec3Lanes::ZERO; 2],
        origin_change: [Lanes::ZERO; 4],
        direction_change: [Lanes::ZERO; 4],
        place: [Lanes::ZERO; 2],
        reach2: Lanes::splat(-1.0),
        samples: [0; LANES],
    };

    /// Fills a lane; returns the reach of the sample, `None` if it is seen edge-on.
    fn set(
        &mut self,
        lane: usize,
        index: u32,
        sample: &RaySample,
        picture_change: &DMat2,
        reach_px: f32,
        place: [f32; 2],
    ) -> Option<Reach> {
        let rays = &sample.rays;
        self.origin.set(lane, rays.origin.as_vec3());
        self.direction.set(lane, rays.direction.as_vec3());
        for (own, across) in self.across.iter_mut().zip(&rays.across) {
            own.set(lane, across.as_vec3());
        }
        let inverse = picture_change.inverse();
        if !inverse.is_finite() {
            return None;
        }
        // Rows: lateral axes. Columns: coordinates of the picture.
        let [near, far] = [0.0, 1.0].map(|distance| {
            let [row, other] = rays.spread(distance).map(DVec2::from);
            [inverse.transpose() * row, inverse.transpose() * other]
        });
        let slope = [far[0] - near[0], far[1] - near[1]];
        for k in 0..4 {
            self.origin_change[k][lane] = near[k / 2][k % 2] as f32;
            self.direction_change[k][lane] = slope[k / 2][k % 2] as f32;
        }
        for (own, place) in self.place.iter_mut().zip(place) {
            own[lane] = place;
        }
        self.reach2[lane] = reach_px * reach_px * LEEWAY;
        self.samples[lane] = index;
        let radius = f64::from(reach_px * LEEWAY);
        let columns = |rows: [DVec2; 2]| {
            [0, 1].map(|column| (rays.across[0] * rows[0][column] + rays.across[1] * rows[1][column]) * radius)
        };
        Some(Reach {
            origin: rays.origin,
            direction: rays.direction,
            origin_change: columns(near),
            direction_change: columns(slope),
        })
    }

    #[inline(always)]
    fn reaching(&self, point: [f32; 3], found: &mut Vec<Reaching>) {
        let mut accepted = [false; LANES];
        let (mut places, mut distances, mut determinants) = ([[0.0; LANES]; 2], [0.0; LANES], [0.0; LANES]);
        for lane in 0..LANES {
            let relative: [f32; 3] = [0, 1, 2].map(|axis: usize| point[axis] - self.origin[axis][lane]);
            let dot = |axes: &Vec3Lanes| {
                relative[0] * axes[0][lane] + relative[1] * axes[1][lane] + relative[2] * axes[2][lane]
            };
            let along = dot(&self.direction);
            let (x, y) = (dot(&self.across[0]), dot(&self.across[1]));
            let entry = |k: usize| self.origin_change[k][lane] + along * self.direction_change[k][lane];
            let (a, b, c, d) = (entry(0), entry(1), entry(2), entry(3));
            let determinant = a * d - b * c;
            // The way in the picture, times the determinant.
            let (u, v) = (d * x - b * y, a * y - c * x);
            let (right, down) = (u / determinant, v / determinant);
            places[0][lane] = self.place[0][lane] + right;
            places[1][lane] = self.place[1][lane] + down;
            distances[lane] = right * right + down * down;
            determinants[lane] = determinant;
            // A determinant of zero is a focus: comparisons with values that are not numbers are false.
            accepted[lane] = (distances[lane] <= self.reach2[lane]) & (along > 0.0);
        }
        let mut accepted = bits_of(accepted);
        while accepted != 0 {
            let lane = accepted.trailing_zeros() as usize;
            accepted &= accepted - 1;
            let place = Vec2::new(places[0][lane], places[1][lane]);
            let (sample, distance2) = (self.samples[lane], distances[lane]);
            found.push(Reaching { sample, place, distance2, mirrored: determinants[lane] < 0.0 });
        }
    }
}

/// The bits of two coordinates in turn: neighbours on this curve are mostly neighbours in the plane.
fn morton([x, y]: [f32; 2]) -> u64 {
    let spread = |value: f32| {
        // Sixteenths of a pixel, of fields up to a hundred thousand pixels.
        let mut bits = (value * 16.0).clamp(0.0, u32::MAX as f32 * 0.4) as u64;
        bits = (bits | bits << 16) & 0x0000_ffff_0000_ffff;
        bits = (bits | bits << 8) & 0x00ff_00ff_00ff_00ff;
        bits = (bits | bits << 4) & 0x0f0f_0f0f_0f0f_0f0f;
        bits = (bits | bits << 2) & 0x3333_3333_3333_3333;
        (bits | bits << 1) & 0x5555_5555_5555_5555
    };
    spread(x) | spread(y) << 1
}
