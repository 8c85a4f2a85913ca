//! All specular paths of one bounce between an eye and a point: every point of an analytic surface at which the
//! specular constraint holds, by subdivision.
//!
//! Pieces of the surface that cannot hold a root are discarded, by bounds of the half vector and of the normals over
//! them at first, by a bound of the constraint's second derivative when they are small; pieces on which the constraint
//! is one to one are solved by Newton's method; the rest is split. That makes the search sure as far as its bounds
//! are: they are proven for the directions to eye and point, and for the normals they rest on the tessellation and
//! on local third derivatives with margins (stated where they are made). A feature of the surface that is smaller
//! than the triangles of its tessellation, and show at none of their corners, can be missed.

mod constraint;
mod cover;

use super::bundle::{BounceKind, Eye};
use catoptric_core::surface::PlacedSurface;
use constraint::{Sides, SpecularConstraint, Verdict};
use cover::{Cover, CoverContent, SurfaceCell};
use glam::DVec3;

/// The result of a search for all roots.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum RootCount {
    /// All roots were found.
    #[default]
    Finite,
    /// There are curves (or a whole surface) of roots: eye, centre and point of a sphere in one line, say.
    Infinite,
    /// The search was given up: at or very near a caustic's cusp, or very near to infinitely many roots. What it had
    /// found is kept.
    Unresolved,
}

/// Cells smaller than this, in diagonals of the surface's box, are split no more: their roots are (nearly) multiple.
const SMALLEST_CELL: f64 = 1e-7;

/// Roots nearer to each other than this, in the same unit, are one.
const EQUAL_ROOTS: f64 = 1e-9;

/// Multiple roots nearer than this are one: a threefold root is exact to the cube root of the rounding only.
const EQUAL_MULTIPLE_ROOTS: f64 = 1e-5;

/// Length of the steps along a supposed curve of roots, in the same unit.
const CURVE_STEP: f64 = 1e-3;

/// The number of steps that make a curve.
const CURVE_STEPS: u32 = 4;

/// Cells after which a search is given up.
const MAX_CELLS: usize = 200_000;

/// Finds all specular paths of one bounce on a surface. Building it costs a pass over the surface's tessellation.
#[derive(Clone, Debug)]
pub struct RootFinder {
    surface: PlacedSurface,
    cover: Cover,
}

/// All specular paths of one bounce on a surface, by a [`RootFinder`] for this configuration alone; see
/// [`RootFinder::roots`].
pub fn all_reflections(
    surface: &PlacedSurface,
    eye: &Eye,
    point: DVec3,
    kind: BounceKind,
    index: f64,
    out: &mut Vec<DVec3>,
) -> RootCount {
    RootFinder::new(surface).roots(eye, point, kind, index, out)
}

impl RootFinder {
    /// Makes ready for a surface.
    pub fn new(surface: &PlacedSurface) -> Self {
        Self { surface: surface.clone(), cover: Cover::new(surface) }
    }

    /// Appends all points of the surface at which light from the eye to the point is reflected or refracted
    /// (`index` of the inside over that of the outside), the shortest path (optically) first.
    ///
    /// Occlusion is ignored. Both sides of a surface reflect: eye and point must lie on the same side of the tangent
    /// plane, and for refraction on different ones. With infinitely many roots none are appended; input that is not
    /// finite has none. Roots are exact to about 1e-15 over their distance (relative) from a caustic; those within
    /// 1e-7 of the surface's size of each other may be merged.
    pub fn roots(&self, eye: &Eye, point: DVec3, kind: BounceKind, index: f64, out: &mut Vec<DVec3>) -> RootCount {
        let eye_is_finite = match eye {
            Eye::Point(at) => at.is_finite(),
            Eye::Direction(direction) => direction.is_finite() && direction.length_squared() > 0.0,
        };
        if !(eye_is_finite && point.is_finite() && index.is_finite() && index > 0.0) {
            return RootCount::Finite;
        }
        let tasks: &[(Sides, [f64; 2])] = match kind {
            BounceKind::Reflect => &[(Sides::Same, [1.0; 2])],
            BounceKind::Transmit => &[(Sides::EyeOutside, [1.0, index]), (Sides::EyeInside, [index, 1.0])],
        };
        let before = out.len();
        let mut count = RootCount::Finite;
        for &(sides, weights) in tasks {
            let constraint = SpecularConstraint { eye: *eye, point, weights, sides };
            let start = out.len();
            let mut search = RootSearch { finder: self, constraint, roots: out, start, cells: 0 };
            match search.run() {
                RootCount::Finite => {}
                RootCount::Infinite => {
                    out.truncate(before);
                    return RootCount::Infinite;
                }
                RootCount::Unresolved => count = RootCount::Unresolved,
            }
            let length = |at: DVec3| {
                let towards_eye = match *eye {
                    Eye::Point(eye) => eye.distance(at),
                    Eye::Direction(direction) => direction.dot(at),
                };
                weights[0] * towards_eye + weights[1] * point.distance(at)
            };
            out[start..].sort_by(|a, b| length(*a).total_cmp(&length(*b)));
        }
        count
    }
}

/// A search under way.
struct RootSearch<'a> {
    finder: &'a RootFinder,
    constraint: SpecularConstraint,
    roots: &'a mut Vec<DVec3>,
    /// Index of this search's first root.
    start: usize,
    cells: usize,
}

impl RootSearch<'_> {
    fn run(&mut self) -> RootCount {
        let RootFinder { surface, cover } = self.finder;
        if cover.nodes.is_empty() {
            return RootCount::Finite;
        }
        let mut nodes = vec![0u32];
        let mut cells: Vec<SurfaceCell> = Vec::new();
        while let Some(index) = nodes.pop() {
            let node = &cover.nodes[index as usize];
            if !self.constraint.possible(&node.bounds) {
                continue;
            }
            let (begin, end) = match node.content {
                CoverContent::Inner(first) => {
                    nodes.extend([first + 1, first]);
                    continue;
                }
                CoverContent::Leaf(begin, end) => (begin, end),
            };
            cells.extend(cover.cells(surface, begin, end).flatten());
            while let Some(cell) = cells.pop() {
                self.cells += 1;
                if self.cells > MAX_CELLS {
                    return RootCount::Unresolved;
                }
                if !self.constraint.possible(&cell.bounds) {
                    continue;
                }
                match self.constraint.verdict(surface, &cell) {
                    Verdict::Empty => {}
                    Verdict::One(root) => {
                        self.found(root, EQUAL_ROOTS);
                    }
                    Verdict::Open if cell.bounds.radius > SMALLEST_CELL * cover.size => {
                        cells.extend(cell.halves(surface).into_iter().flatten());
                    }
                    Verdict::Open => {
                        // Far enough that all cells about a multiple root find that root.
                        let reach = EQUAL_MULTIPLE_ROOTS * cover.size;
                        if let Some((root, true)) = self.constraint.newton(surface, cell.bounds.center, reach)
                            && self.found(root, EQUAL_MULTIPLE_ROOTS)
                            && self.is_on_a_curve_of_roots(root)
                        {
                            return RootCount::Infinite;
                        }
                    }
                }
            }
        }
        RootCount::Finite
    }

    /// Keeps a root if it is on the surface and new; whether it was.
    fn found(&mut self, root: DVec3, equal: f64) -> bool {
        let tolerance = equal * self.finder.cover.size;
        let known = self.roots[self.start..].iter().any(|other| other.distance(root) <= tolerance);
        let kept = !known && self.finder.surface.is_within_bounds(root);
        if kept {
            self.roots.push(root);
        }
        kept
    }

    /// Returns true if other roots follow from a multiple one in the direction in which the constraint does not change.
    fn is_on_a_curve_of_roots(&self, root: DVec3) -> bool {
        let RootFinder { surface, cover } = self.finder;
        let step = CURVE_STEP * cover.size;
        let (mut at, mut before) = (root, DVec3::ZERO);
        for _ in 0..CURVE_STEPS {
            let Some(direction) = self.constraint.unchanging_direction(surface, at) else { return false };
            let direction = if direction.dot(before) < 0.0 { -direction } else { direction };
            let expected = at + direction * step;
            match self.constraint.newton(surface, expected, 0.1 * step) {
                Some((next, true)) if next.distance(expected) < 0.5 * step => (at, before) = (next, direction),
                _ => return false,
            }
        }
        true
    }
}
