//! A hierarchy of tubes around bundles of outgoing rays: which samples' expansions reach a point.
//!
//! A sample answers for points whose ray is seen within some distance of its own in the picture, which at a distance
//! along the ray is an ellipse around it, and altogether a tube that grows linearly. A node's tube holds those of all
//! samples below it. So a look-up visits only nodes whose tubes hold the point, whatever the size of the scene, and
//! nothing depends on earlier look-ups. (The octree of Chen and Arvo 2000, [`super::RayTree`], answers from the
//! point's cell, which beside silhouettes and caustics holds hundreds of rays.)

use super::sample::RaySample;
use glam::{DMat2, DVec2, DVec3, Vec3};

/// Samples of a leaf, tested at once.
const LANES: usize = 8;

/// Tubes that open faster than this have no bound worth speaking of.
const WIDEST_SLOPE: f64 = 0.7;

/// Accepted points lie up to this much further out: single precision is no reason to lose one.
const LEEWAY: f32 = 1.0 + 1e-3;

/// A ray with a radius that grows along it. Points behind its start are in it as far as it is wide there.
#[derive(Clone, Copy, Debug)]
struct Tube {
    origin: Vec3,
    direction: Vec3,
    /// Radius at the origin; negative: the tube is empty; infinite: it is all of space.
    radius: f32,
    /// Growth of the radius a unit of length.
    slope: f32,
}

impl Tube {
    const EMPTY: Self = Self { origin: Vec3::ZERO, direction: Vec3::ZERO, radius: -1.0, slope: 0.0 };

    /// A tube that holds all of `tubes`.
    fn around(tubes: &[Self]) -> Self {
        let all = || tubes.iter().filter(|tube| tube.radius >= 0.0);
        let count = all().count() as f64;
        if count == 0.0 {
            return Self::EMPTY;
        }
        let origin = all().map(|tube| tube.origin.as_dvec3()).sum::<DVec3>() / count;
        let sum: DVec3 = all().map(|tube| tube.direction.as_dvec3()).sum();
        let direction = sum.try_normalize().unwrap_or(DVec3::Z);
        // A point beside a child's ray at a distance t along it is from o + t d at most alpha + beta t away.
        let (mut alpha, mut beta) = (0f64, 0f64);
        for tube in all() {
            alpha = alpha.max(tube.origin.as_dvec3().distance(origin) + f64::from(tube.radius));
            beta = beta.max(tube.direction.as_dvec3().distance(direction) + f64::from(tube.slope));
        }
        let (origin, direction) = (origin.as_vec3(), direction.as_vec3());
        // Its distance s along this ray is at least t - alpha - beta t.
        if beta.is_nan() || beta > WIDEST_SLOPE || !alpha.is_finite() {
            return Self { origin, direction, radius: f32::INFINITY, slope: 0.0 };
        }
        let wider = f64::from(LEEWAY) / (1.0 - beta);
        Self { origin, direction, radius: (alpha * wider) as f32, slope: (beta * wider) as f32 }
    }
}

/// Samples as arrays, one lane a sample.
#[derive(Clone, Copy, Debug)]
#[repr(align(32))]
struct Leaf {
    origin: [[f32; LANES]; 3],
    direction: [[f32; LANES]; 3],
    across: [[[f32; LANES]; 3]; 2],
    /// Lateral change of the origins and of the directions with the place in the picture, row by row.
    origin_change: [[f32; LANES]; 4],
    direction_change: [[f32; LANES]; 4],
    /// Square of the distance in the picture that is accepted; negative in empty lanes.
    reach2: [f32; LANES],
    samples: [u32; LANES],
}

/// The tubes of eight nodes of the next level (or of eight leaves), one lane a tube.
#[derive(Clone, Copy, Debug)]
#[repr(align(32))]
struct Node {
    origin: [[f32; LANES]; 3],
    direction: [[f32; LANES]; 3],
    radius: [f32; LANES],
    slope: [f32; LANES],
}

impl Node {
    fn of(tubes: &[Tube]) -> Self {
        let lane = |lane: usize| tubes.get(lane).copied().unwrap_or(Tube::EMPTY);
        let lanes: [Tube; LANES] = std::array::from_fn(lane);
        Self {
            origin: [0, 1, 2].map(|axis| lanes.map(|tube| tube.origin[axis])),
            direction: [0, 1, 2].map(|axis| lanes.map(|tube| tube.direction[axis])),
            radius: lanes.map(|tube| tube.radius),
            slope: lanes.map(|tube| tube.slope),
        }
    }

    /// Which of its tubes hold a point.
    #[inline(always)]
    fn holding(&self, point: [f32; 3]) -> [bool; LANES] {
        let mut holding = [false; LANES];
        for (lane, holding) in holding.iter_mut().enumerate() {
            let relative = [0, 1, 2].map(|axis: usize| point[axis] - self.origin[axis][lane]);
            let direction = [0, 1, 2].map(|axis: usize| self.direction[axis][lane]);
            let along = relative[0] * direction[0] + relative[1] * direction[1] + relative[2] * direction[2];
            let across = [0, 1, 2].map(|axis: usize| relative[axis] - along * direction[axis]);
            let distance2 = across[0] * across[0] + across[1] * across[1] + across[2] * across[2];
            let start = self.radius[lane];
            let radius = start + self.slope[lane] * along.max(0.0);
            // Behind its start the tube goes on as far as it is wide there.
            *holding = (distance2 <= radius * radius * LEEWAY) & (along >= -start) & (start >= 0.0);
        }
        holding
    }
}

/// The hierarchy over the samples of a path.
#[derive(Clone, Debug, Default)]
pub struct RayTubes {
    /// The root first, then level by level; the last level's children are the leaves.
    nodes: Vec<Node>,
    /// Where the children of a node's first lane are: among the nodes, or from `nodes.len()` on among the leaves.
    first_children: Vec<u32>,
    leaves: Vec<Leaf>,
}

impl RayTubes {
    /// Over samples whose expansions are trusted for places in the picture up to `reach_px` away from where they are
    /// seen, `places`; `picture_change` is the change of places with the parameters of a sample's bundle.
    pub fn new(samples: &[RaySample], picture_change: &[DMat2], reach_px: &[f32], places: &[[f32; 2]]) -> Self {
        let mut order: Vec<u32> = (0..samples.len() as u32).collect();
        let code = |index: u32| places.get(index as usize).map_or(0, |place| morton(*place));
        order.sort_by_key(|&index| (code(index), index));
        let mut leaves = Vec::with_capacity(order.len().div_ceil(LANES));
        let mut tubes = Vec::with_capacity(leaves.capacity());
        for chunk in order.chunks(LANES) {
            let mut leaf = Leaf::EMPTY;
            let mut own = [Tube::EMPTY; LANES];
            for (lane, &index) in chunk.iter().enumerate() {
                let place = index as usize;
                own[lane] = leaf.set(lane, index, &samples[place], &picture_change[place], reach_px[place]);
            }
            leaves.push(leaf);
            tubes.push(Tube::around(&own));
        }
        // Levels from the leaves up.
        let mut levels: Vec<Vec<Node>> = Vec::new();
        while levels.is_empty() || tubes.len() > 1 {
            levels.push(tubes.chunks(LANES).map(Node::of).collect());
            tubes = tubes.chunks(LANES).map(Tube::around).collect();
        }
        let (mut nodes, mut first_children) = (Vec::new(), Vec::new());
        for level in levels.iter().rev() {
            let next = nodes.len() + level.len();
            first_children.extend((0..level.len()).map(|node| (next + node * LANES) as u32));
            nodes.extend_from_slice(level);
        }
        Self { nodes, first_children, leaves }
    }

    /// Appends all samples in whose reach a point is, or may be but for rounding.
    pub fn reaching(&self, point: Vec3, found: &mut Vec<u32>) {
        reaching(self, point.to_array(), found);
    }

    /// Memory of the arrays.
    pub fn byte_count(&self) -> usize {
        size_of_val(self.nodes.as_slice())
            + size_of_val(self.first_children.as_slice())
            + size_of_val(self.leaves.as_slice())
    }
}

/// Of at most eleven levels (2^32 samples) each has at most eight waiting.
const MOST_WAITING: usize = 12 * LANES;

#[multiversion::multiversion(targets("x86_64+avx2+bmi1+bmi2+popcnt+lzcnt"))]
fn reaching(tubes: &RayTubes, point: [f32; 3], found: &mut Vec<u32>) {
    let mut waiting = [0u32; MOST_WAITING];
    let mut count = usize::from(!tubes.nodes.is_empty());
    while count > 0 {
        count -= 1;
        let node = waiting[count] as usize;
        let holding = tubes.nodes[node].holding(point);
        let first = tubes.first_children[node];
        for (lane, holds) in holding.into_iter().enumerate() {
            if !holds {
                continue;
            }
            let child = first + lane as u32;
            match tubes.leaves.get((child as usize).wrapping_sub(tubes.nodes.len())) {
                Some(leaf) => leaf.reaching(point, found),
                None => {
                    waiting[count] = child;
                    count += 1;
                }
            }
        }
    }
}

impl Leaf {
    const EMPTY: Self = Self {
        origin: [[0.0; LANES]; 3],
        direction: [[0.0; LANES]; 3],
        across: [[[0.0; LANES]; 3]; 2],
        origin_change: [[0.0; LANES]; 4],
        direction_change: [[0.0; LANES]; 4],
        reach2: [-1.0; LANES],
        samples: [0; LANES],
    };

    /// Fills a lane; returns the sample's tube.
    fn set(&mut self, lane: usize, index: u32, sample: &RaySample, picture_change: &DMat2, reach_px: f32) -> Tube {
        let rays = &sample.rays;
        let (origin, direction) = (rays.origin.as_vec3(), rays.direction.as_vec3());
        for axis in 0..3 {
            self.origin[axis][lane] = origin[axis];
            self.direction[axis][lane] = direction[axis];
            for (row, across) in rays.across.iter().enumerate() {
                self.across[row][axis][lane] = across[axis] as f32;
            }
        }
        let inverse = picture_change.inverse();
        if !inverse.is_finite() {
            return Tube::EMPTY; // seen edge-on
        }
        let [near, far] = [0.0, 1.0].map(|distance| {
            let [row, other] = rays.spread(distance).map(DVec2::from);
            [inverse.transpose() * row, inverse.transpose() * other].map(|row| row.to_array())
        });
        let mut change = [[0f64; 4]; 2];
        for k in 0..4 {
            change[0][k] = near[k / 2][k % 2];
            change[1][k] = far[k / 2][k % 2] - change[0][k];
            self.origin_change[k][lane] = change[0][k] as f32;
            self.direction_change[k][lane] = change[1][k] as f32;
        }
        self.reach2[lane] = reach_px * reach_px * LEEWAY;
        self.samples[lane] = index;
        // What a matrix does to a vector is at most its larger singular value.
        let norm = |[a, b, c, d]: &[f64; 4]| 0.5 * ((a + d).hypot(b - c) + (a - d).hypot(b + c));
        let [radius, slope] = change.map(|matrix| (norm(&matrix) * f64::from(reach_px * LEEWAY)) as f32);
        let rounding = 1e-5 * origin.abs().max_element();
        Tube { origin, direction, radius: radius + rounding, slope }
    }

    #[inline(always)]
    fn reaching(&self, point: [f32; 3], found: &mut Vec<u32>) {
        let mut accepted = [false; LANES];
        for (lane, accepted) in accepted.iter_mut().enumerate() {
            let relative: [f32; 3] = [0, 1, 2].map(|axis: usize| point[axis] - self.origin[axis][lane]);
            let dot = |axes: &[[f32; LANES]; 3]| {
                relative[0] * axes[0][lane] + relative[1] * axes[1][lane] + relative[2] * axes[2][lane]
            };
            let along = dot(&self.direction);
            let (x, y) = (dot(&self.across[0]), dot(&self.across[1]));
            let entry = |k: usize| self.origin_change[k][lane] + along * self.direction_change[k][lane];
            let (a, b, c, d) = (entry(0), entry(1), entry(2), entry(3));
            let determinant = a * d - b * c;
            // The parameters times the determinant.
            let (u, v) = (d * x - b * y, a * y - c * x);
            *accepted = (u * u + v * v <= self.reach2[lane] * determinant * determinant) & (along > 0.0);
        }
        for (sample, accepted) in self.samples.iter().zip(accepted) {
            if accepted {
                found.push(*sample);
            }
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
