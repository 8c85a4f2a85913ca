//! Reflection points as polynomials in the weights of the four nodes around the eye.
//!
//! The nodes' values with their derivatives with respect to the eye give a polynomial of second degree over the
//! tetrahedron: the weighted mean of the nodes' linear predictions, each over half of the way. Everything is counted
//! from the first node's values, so that little is lost in single precision.

use glam::{DVec3, Vec3, Vec4};

/// The nodes.
pub(crate) const CORNERS: usize = 4;

/// Pairs of nodes, in the order of the form's last coefficients.
const PAIRS: [[usize; 2]; 6] = [[0, 1], [0, 2], [0, 3], [1, 2], [1, 3], [2, 3]];

/// Weights of the nodes, and their powers in the order of the coefficients behind the first.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct FormWeights {
    of_nodes: [f32; CORNERS],
    powers: [f32; CORNERS - 1 + PAIRS.len()],
}

impl FormWeights {
    /// Powers of weights whose sum is 1.
    pub fn new(weights: [f32; CORNERS]) -> Self {
        let mut powers = [0.0; CORNERS - 1 + PAIRS.len()];
        powers[..CORNERS - 1].copy_from_slice(&weights[1..]);
        for (power, [one, other]) in powers[CORNERS - 1..].iter_mut().zip(PAIRS) {
            *power = weights[one] * weights[other];
        }
        Self { of_nodes: weights, powers }
    }

    /// The weights.
    pub(crate) fn of_nodes(&self) -> [f32; CORNERS] {
        self.of_nodes
    }
}

/// A place and a length.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct PlaceAndLength {
    /// The place.
    pub place: Vec3,
    /// The length.
    pub length: f32,
}

impl PlaceAndLength {
    fn all(self) -> Vec4 {
        self.place.extend(self.length)
    }
}

/// First reflection point and path length of a scene point as the eye moves among four nodes.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct TetrahedronForm {
    first: Vec4,
    corners: [Vec4; CORNERS - 1],
    /// Coefficients of the products of two weights, as [`half_kept`] numbers.
    bows: [Vec4; PAIRS.len()],
}

/// The nearest number whose lower half has no bits. Coefficients of products are small, and less than half a percent of
/// them is lost.
fn half_kept(number: f32) -> f32 {
    f32::from_bits(number.to_bits().saturating_add(0x8000) & 0xFFFF_0000)
}

impl TetrahedronForm {
    /// A form from the values at the nodes, and from the deviation of the middle between two nodes, given by their
    /// numbers, from the mean of their values, times four.
    #[inline]
    pub fn new(corners: [PlaceAndLength; CORNERS], bow: impl Fn(usize, usize) -> PlaceAndLength) -> Self {
        let first = corners[0].all();
        let mut form = Self { first, corners: [Vec4::ZERO; CORNERS - 1], bows: [Vec4::ZERO; PAIRS.len()] };
        for (kept, corner) in form.corners.iter_mut().zip(&corners[1..]) {
            *kept = corner.all() - first;
        }
        for (kept, [from, to]) in form.bows.iter_mut().zip(PAIRS) {
            let [x, y, z, length] = bow(from, to).all().to_array();
            *kept = Vec4::new(half_kept(x), half_kept(y), half_kept(z), half_kept(length));
        }
        form
    }

    /// The place and the length where the nodes have these weights.
    #[inline]
    pub fn at(&self, weights: &FormWeights) -> (DVec3, f32) {
        let numbers = self.corners.iter().chain(&self.bows);
        let offset = numbers.zip(weights.powers).fold(Vec4::ZERO, |sum, (number, weight)| sum + *number * weight);
        (self.first.truncate().as_dvec3() + offset.truncate().as_dvec3(), self.first.w + offset.w)
    }

    /// True if all its numbers are finite.
    pub(crate) fn is_finite(&self) -> bool {
        self.first.is_finite() && self.corners.iter().chain(&self.bows).all(|number| number.is_finite())
    }
}

/// Points that are evaluated at once.
pub(crate) const LANES: usize = 8;

/// The numbers of a block's points: x, y, z and the length of each.
type BlockOf<T> = [T; 4 * LANES];

/// The forms of some points, number by number, in as few bytes as they take: memory limits how fast they are evaluated.
#[derive(Clone, Debug)]
pub struct FormBlock {
    first: BlockOf<f32>,
    corners: [BlockOf<f32>; CORNERS - 1],
    /// The upper halves of the numbers.
    bows: [BlockOf<u16>; PAIRS.len()],
}

impl FormBlock {
    /// A block of [`LANES`] forms. Of fewer forms the last is repeated; without any, all values are 0.
    pub fn new(forms: &[TetrahedronForm]) -> Self {
        let mut block = Self {
            first: [0.0; 4 * LANES],
            corners: [[0.0; 4 * LANES]; CORNERS - 1],
            bows: [[0; 4 * LANES]; PAIRS.len()],
        };
        for lane in 0..LANES {
            let Some(form) = forms.get(lane).or(forms.last()) else { break };
            for part in 0..4 {
                let place = part * LANES + lane;
                block.first[place] = form.first[part];
                for (numbers, corner) in block.corners.iter_mut().zip(&form.corners) {
                    numbers[place] = corner[part];
                }
                for (numbers, bow) in block.bows.iter_mut().zip(&form.bows) {
                    numbers[place] = (bow[part].to_bits() >> 16) as u16;
                }
            }
        }
        block
    }

    /// The places (x, y and z of all points) and the lengths where the nodes have these weights, to the bit as
    /// [`TetrahedronForm::at`] has them.
    #[inline(always)]
    pub fn at(&self, weights: &FormWeights) -> ([[f64; LANES]; 3], [f32; LANES]) {
        let mut place = [[0.0f64; LANES]; 3];
        for (axis, place) in place.iter_mut().enumerate() {
            let offset = self.offset(axis, weights);
            for (lane, place) in place.iter_mut().enumerate() {
                *place = f64::from(self.first[axis * LANES + lane]) + f64::from(offset[lane]);
            }
        }
        let mut lengths = self.offset(3, weights);
        for (lane, length) in lengths.iter_mut().enumerate() {
            *length += self.first[3 * LANES + lane];
        }
        (place, lengths)
    }

    /// The difference of one of x, y, z and the length from the first node's value: as much as a register of sums
    /// holds.
    #[inline(always)]
    fn offset(&self, part: usize, weights: &FormWeights) -> [f32; LANES] {
        let (of_corners, of_bows) = weights.powers.split_at(CORNERS - 1);
        let mut sums = [0.0f32; LANES];
        for (numbers, weight) in self.corners.iter().zip(of_corners) {
            for (lane, sum) in sums.iter_mut().enumerate() {
                *sum += numbers[part * LANES + lane] * *weight;
            }
        }
        for (numbers, weight) in self.bows.iter().zip(of_bows) {
            for (lane, sum) in sums.iter_mut().enumerate() {
                *sum += f32::from_bits(u32::from(numbers[part * LANES + lane]) << 16) * *weight;
            }
        }
        sums
    }
}
