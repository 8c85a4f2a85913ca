//! Division of pieces of triangles, whatever their corners are.
//!
//! The edge that needs a division most is halved, then both pieces are looked at again. Where pictures are stretched in
//! one direction (beside folds and silhouettes a thousandfold) pieces become as slender as they have to be (Cohen,
//! Mirebeau 2012, Greedy bisection generates optimally adapted triangulations). Which edges are divided in the end is
//! the rule's decision alone, not that of the order.

use super::shapes::{PieceQueue, PieceShape, Strip, TrianglePiece};
use crate::find::work;
use catoptric_engine::method::projector::Projection;
use glam::Vec3;

/// Work that a piece counts as, beside that of the points projected for it: it is drawn, too. About the rasteriser's
/// work for a triangle of some pixels.
pub(in super::super) const WORK_A_PIECE: u64 = 20;

/// Pieces are halved this many times at the most. A bound on time; chosen, not measured.
pub(in super::super) const MAX_DEPTH: u32 = 80;

/// Pairs of appearances at the ends of an edge that are compared, each with its rivals, in a unit of work.
pub(in super::super) const COMPARISONS_A_UNIT: u32 = 2;

/// Pieces that are thinner than this in all their pictures, in pixels, are left out: the edges beside them agree.
/// Chosen, not measured.
const THIN_PX: f32 = 0.02;

/// True if a piece is so thin that nothing of it is seen, by its corners' appearances.
pub(in super::super) fn is_thin<'a>([a, b, c]: [Vec3; 3], appearances: impl Iterator<Item = &'a Projection>) -> bool {
    let sides = [c - b, a - c, b - a];
    let longest =
        (0..3).fold(0, |best, k| if sides[k].length_squared() > sides[best].length_squared() { k } else { best });
    // Vectors along the longest side, and to the corner opposite to it.
    let (side, to_corner) = (sides[longest], sides[(longest + 2) % 3]);
    let height = to_corner - side * (to_corner.dot(side) / side.length_squared());
    let is_thin = |one: &Projection| one.predicted(height).distance(one.image_px) < THIN_PX;
    // A piece that shows nothing at its corners counts as not thin.
    let mut shown = appearances.peekable();
    !height.is_nan() && shown.peek().is_some() && shown.all(is_thin)
}

/// Divides pieces until no edge needs it any more.
pub(in super::super) trait Division {
    /// A corner of a piece.
    type Corner: Copy;

    /// The priority of an edge's division; 0 if it needs none.
    fn split_priority(&mut self, a: &Self::Corner, b: &Self::Corner) -> f32;

    /// The middle of an edge, the same from both of its sides.
    fn middle(&mut self, a: &Self::Corner, b: &Self::Corner) -> Self::Corner;

    /// True if a piece is so thin that nothing of it is seen.
    fn is_line(&self, corners: &[Self::Corner; 3]) -> bool;

    /// True if no more is divided; counted if so.
    fn is_last(&mut self, depth: u32) -> bool;

    /// Takes a piece that is not divided.
    fn emit(&mut self, corners: &[Self::Corner; 3]);

    /// The pieces that wait for their division.
    fn queue(&mut self) -> &mut PieceQueue<Self::Corner>;

    /// Divides a triangle, and its pieces.
    fn divide_all(&mut self, triangle: TrianglePiece<Self::Corner>) {
        self.later(PieceShape::Triangle(triangle));
        while let Some(shape) = self.queue().pop() {
            match shape {
                PieceShape::Triangle(piece) => self.divide(&piece),
                PieceShape::Strip(strip) => self.divide_strip(&strip),
            }
        }
    }

    /// Divides a shape when its turn comes; at once where there is nothing to divide.
    fn later(&mut self, shape: PieceShape<Self::Corner>) {
        let all: &[f32] = match &shape {
            PieceShape::Triangle(piece) => &piece.split_priority,
            PieceShape::Strip(strip) => &[strip.sides[0], strip.sides[1], strip.ends[0], strip.ends[1]],
        };
        let split_priority = all.iter().copied().fold(0.0, f32::max);
        match shape {
            PieceShape::Triangle(piece) if split_priority <= 0.0 => self.emit(&piece.corners),
            shape => {
                // Pieces in the queue are drawn in the end, divided or not.
                work::add(WORK_A_PIECE);
                self.queue().push(split_priority, shape);
            }
        }
    }

    fn divide(&mut self, piece: &TrianglePiece<Self::Corner>) {
        let [x, y, z] = piece.split_priority;
        let count = [x, y, z].into_iter().filter(|split_priority| *split_priority > 0.0).count();
        if self.is_line(&piece.corners) {
            return;
        }
        if self.is_last(piece.depth) {
            return self.emit(&piece.corners);
        }
        let depth = piece.depth + 1;
        if count == 2 {
            // The top of a wedge, and a strip below.
            let base = if x <= 0.0 {
                0
            } else if y <= 0.0 {
                1
            } else {
                2
            };
            let [top, left, right] = [0, 1, 2].map(|k| piece.corners[(k + base) % 3]);
            let (west, east) = (self.middle(&top, &left), self.middle(&top, &right));
            let across = self.split_priority(&west, &east);
            let above = [self.split_priority(&top, &east), self.split_priority(&top, &west)];
            let below = [self.split_priority(&west, &left), self.split_priority(&east, &right)];
            self.later(PieceShape::Strip(Strip {
                corners: [west, left, right, east],
                sides: below,
                ends: [0.0, across],
                depth,
            }));
            let split_priority = [across, above[0], above[1]];
            self.later(PieceShape::Triangle(TrianglePiece { corners: [top, west, east], split_priority, depth }));
            return;
        }
        let worst = if x >= y && x >= z {
            0
        } else if y >= z {
            1
        } else {
            2
        };
        let turned = |k: usize| (k + worst) % 3;
        let [top, left, right] = [0, 1, 2].map(|k| piece.corners[turned(k)]);
        let [_, right_strain, left_strain] = [0, 1, 2].map(|k| piece.split_priority[turned(k)]);
        let middle = self.middle(&left, &right);
        let median = self.split_priority(&top, &middle);
        let halves = [self.split_priority(&left, &middle), self.split_priority(&middle, &right)];
        let east =
            TrianglePiece { corners: [top, middle, right], split_priority: [halves[1], right_strain, median], depth };
        let west =
            TrianglePiece { corners: [top, left, middle], split_priority: [halves[0], median, left_strain], depth };
        self.later(PieceShape::Triangle(east));
        self.later(PieceShape::Triangle(west));
    }

    fn divide_strip(&mut self, strip: &Strip<Self::Corner>) {
        let [a, b, c, d] = strip.corners;
        let [left, right] = strip.sides;
        let depth = strip.depth + 1;
        if strip.ends != [0.0; 2] || left <= 0.0 && right <= 0.0 || self.is_last(strip.depth) {
            return self.halve_strip(strip);
        }
        if left > 0.0 && right > 0.0 {
            let (west, east) = (self.middle(&a, &b), self.middle(&d, &c));
            let across = self.split_priority(&west, &east);
            let upper = [self.split_priority(&a, &west), self.split_priority(&d, &east)];
            let lower = [self.split_priority(&west, &b), self.split_priority(&east, &c)];
            self.later(PieceShape::Strip(Strip {
                corners: [west, b, c, east],
                sides: lower,
                ends: [0.0, across],
                depth,
            }));
            self.later(PieceShape::Strip(Strip {
                corners: [a, west, east, d],
                sides: upper,
                ends: [across, 0.0],
                depth,
            }));
            return;
        }
        // If only one side is divided, the strip is turned so that this is the left one.
        let (a, b, c, d) = if left > 0.0 { (a, b, c, d) } else { (c, d, a, b) };
        let middle = self.middle(&a, &b);
        let (to_d, to_c) = (self.split_priority(&middle, &d), self.split_priority(&middle, &c));
        let (upper, lower) = (self.split_priority(&a, &middle), self.split_priority(&middle, &b));
        let three = [
            TrianglePiece { corners: [a, middle, d], split_priority: [to_d, 0.0, upper], depth },
            TrianglePiece { corners: [middle, c, d], split_priority: [0.0, to_d, to_c], depth },
            TrianglePiece { corners: [middle, b, c], split_priority: [0.0, to_c, lower], depth },
        ];
        three.into_iter().for_each(|piece| self.later(PieceShape::Triangle(piece)));
    }

    /// Two triangles of a strip.
    fn halve_strip(&mut self, strip: &Strip<Self::Corner>) {
        let [a, b, c, d] = strip.corners;
        let ([left, right], [lower, upper]) = (strip.sides, strip.ends);
        let depth = strip.depth + 1;
        let diagonals = [self.split_priority(&a, &c), self.split_priority(&b, &d)];
        let pair = if diagonals[0] <= diagonals[1] {
            let diagonal = diagonals[0];
            [
                TrianglePiece { corners: [a, b, c], split_priority: [lower, diagonal, left], depth },
                TrianglePiece { corners: [a, c, d], split_priority: [right, upper, diagonal], depth },
            ]
        } else {
            let diagonal = diagonals[1];
            [
                TrianglePiece { corners: [a, b, d], split_priority: [diagonal, upper, left], depth },
                TrianglePiece { corners: [b, c, d], split_priority: [right, diagonal, lower], depth },
            ]
        };
        pair.into_iter().for_each(|piece| self.later(PieceShape::Triangle(piece)));
    }
}
