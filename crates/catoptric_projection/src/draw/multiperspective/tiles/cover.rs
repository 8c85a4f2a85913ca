//! The surfaces that a tile's samples show, found among its candidates.

use super::super::bundles::beam::CandidateList;
use super::super::bundles::bundle::RayBundle;
use super::super::bundles::coverage::{DrawnTriangle, NOTHING, ROOT, RayModel, TileArea, TileSamples};
use super::super::bundles::edges::EdgeFunctions;
use super::super::bundles::least_squares::TERMS;
use super::found::FoundSurface;
use super::own::{OwnRule, TOUCHING};
use super::reflections::{Reflections, Root};
use catoptric_core::scene::shade::Barycentrics;
use catoptric_engine::light::wide_hierarchy::NO_TRIANGLE;
use catoptric_engine::raster::source::found_id;
use glam::{Vec2, Vec3};

/// Columns and rows of a block that triangles are tested against before they are drawn.
const BLOCK: usize = 8;

/// An object's own triangles count from so much beyond the start of rays, as a share of a tile's extent.
const OWN_MARGIN: f32 = 1e-3;

/// Buffers of the work on one tile.
#[derive(Default)]
pub(super) struct CoverWork {
    pub(super) samples: TileSamples,
    /// Triangles that may show, with their numbers in the scene.
    pub(super) drawn: Vec<(u32, DrawnTriangle)>,
    tested: Vec<usize>,
    /// For each of `drawn`: the last pixel (plus 1) that has a surface for it, and that surface's number.
    numbers: Vec<(u32, u32)>,
}

/// A tile whose candidates are drawn.
pub(super) struct Drawing<'a, M> {
    pub(super) bundle: &'a RayBundle,
    pub(super) model: &'a M,
    pub(super) list: &'a CandidateList,
    /// Pixels along its side.
    pub(super) side: usize,
    pub(super) area: TileArea,
    pub(super) own: OwnRule,
    /// The model may miss the rays' starts by this much.
    pub(super) start_error: f32,
    /// The places of samples in one of the area's pixels.
    pub(super) positions: &'a [Vec2],
}

/// A function of the place from a pixel's centre, by its value there and its changes.
#[inline(always)]
fn linear([value, dx, dy]: [f32; 3]) -> [f32; TERMS] {
    [value, dx, dy, 0.0, 0.0, 0.0]
}

impl Reflections<'_> {
    /// Draws a square of the root tile, whose first pixel has this column and row; true if anything shows.
    #[inline(always)]
    pub(super) fn draw_candidates<M: RayModel>(
        &self,
        root: &Root<'_, '_>,
        [first_column, first_row]: [usize; 2],
        drawing: &Drawing<'_, M>,
        work: &mut CoverWork,
        surfaces: &mut Vec<FoundSurface>,
        ids: &mut [u32],
    ) -> bool {
        self.cover(drawing, work);
        let Drawing { bundle, model, area, .. } = drawing;
        let CoverWork { samples, drawn, numbers, .. } = work;
        numbers.clear();
        numbers.resize(drawn.len(), (0, 0));
        let count = root.tile.positions.len();
        let mut any = false;
        for row in 0..area.size {
            for column in (0..area.size).filter(|column| area.rows[row] >> column & 1 != 0) {
                let first = root.first_sample(first_column + column, first_row + row);
                let shown = &samples.shown[(row * ROOT + column) * count..][..count];
                // A bundle has one function for all its pixels.
                let holder = if M::OF_LINES { (row * ROOT + column + 1) as u32 } else { 1 };
                for (id, &number) in ids[first..first + count].iter_mut().zip(shown) {
                    if number == NOTHING {
                        continue;
                    }
                    any = true;
                    let known = &mut numbers[number as usize];
                    if known.0 != holder {
                        *known = (holder, surfaces.len() as u32);
                        let (triangle, DrawnTriangle { functions, .. }) = &drawn[number as usize];
                        let (mut center, mut scale, mut functions) = (bundle.center, bundle.scale, *functions);
                        if M::OF_LINES {
                            center = root.corner(first_column + column, first_row + row) + 0.5;
                            scale = 1.0;
                            let pixels = bundle.scale * bundle.scale;
                            for function in &mut functions {
                                let [value, dx, dy] = model.pixel(function, [column, row]);
                                let [_, _, _, xx, xy, yy] = bundle.quadratic(function);
                                *function = [value, dx, dy, xx * pixels, xy * pixels, yy * pixels];
                            }
                        }
                        surfaces.push(self.found(root, *triangle, center, scale, functions));
                    }
                    *id = found_id(known.1);
                }
            }
        }
        any
    }

    /// Finds the candidates that the samples of a tile show.
    #[inline(always)]
    pub(super) fn cover<M: RayModel>(&self, drawing: &Drawing<'_, M>, work: &mut CoverWork) {
        let Drawing { bundle, model, list, side, area, own, start_error, positions } = drawing;
        let CoverWork { samples, drawn, tested, .. } = work;
        samples.begin(positions);
        drawn.clear();
        tested.clear();
        let axis = bundle.axes[2];
        let blocks = side.div_ceil(BLOCK);
        let half = 0.5 * (*side).min(BLOCK) as f32 * bundle.scale;
        let earliest_start = bundle.start_range[0] - start_error;
        let latest_start = bundle.start_range[1] + start_error;
        // The side alone tells triangles that rays leave from those that they meet, also across a thin wall.
        let own_margin = match own.is_closed() {
            true => -start_error,
            false => 2.0 * start_error + OWN_MARGIN * bundle.start_range[1],
        };
        for block in &list.blocks {
            let functions = EdgeFunctions::new(bundle, model.missed(), block);
            // Bits of lanes, for each part of the square and each sign.
            let mut meets = [[0u32; 2]; 4];
            for (part, meets) in meets.iter_mut().enumerate().take(blocks * blocks) {
                let first = half - 0.5 * *side as f32 * bundle.scale;
                let step = BLOCK as f32 * bundle.scale;
                let place = [first + (part % blocks) as f32 * step, first + (part / blocks) as f32 * step];
                *meets = functions.may_meet(place, [half; 2]);
            }
            let mut lanes = 0;
            for [plus, minus] in meets {
                lanes |= plus | minus;
            }
            while lanes != 0 {
                let lane = lanes.trailing_zeros() as usize;
                lanes &= lanes - 1;
                let triangle = block.triangles[lane];
                if triangle == NO_TRIANGLE {
                    continue;
                }
                let object = self.scene.triangle_objects[triangle as usize];
                let from = own.distances(self.scene, self.shapes, triangle);
                let depth = |corner: usize| {
                    let at = |axis: usize| block.corners[corner * 3 + axis][lane];
                    (Vec3::new(at(0), at(1), at(2)) - bundle.origin).dot(axis)
                };
                let depths = [depth(0), depth(1), depth(2)];
                for (index, sign) in [1.0, -1.0].into_iter().enumerate() {
                    let is_met = |part: usize| meets[part][index] >> lane & 1 != 0;
                    let margin = match object == own.object {
                        true if from[index] > 0.0 => from[index].max(own_margin),
                        true => own_margin,
                        false => from[index],
                    };
                    let [earliest, latest] = [earliest_start + margin, latest_start + margin];
                    if !(0..blocks * blocks).any(is_met) || depths.iter().all(|depth| *depth < earliest) {
                        continue;
                    }
                    let margin = depths.iter().any(|depth| *depth < latest).then_some(margin);
                    let number = drawn.len() as u32;
                    let mut functions = functions.of_lane::<M>(lane, sign);
                    if own.is_around(object) {
                        functions[3].iter_mut().for_each(|term| *term *= 1.0 - TOUCHING);
                    }
                    let one = DrawnTriangle { number, functions, margin };
                    drawn.push((triangle, one));
                    if self.scene.is_alpha_tested(object) {
                        tested.push(number as usize);
                        continue;
                    }
                    for part in (0..blocks * blocks).filter(|part| is_met(*part)) {
                        let row = part / blocks * BLOCK;
                        samples.draw(*model, area, &one, part % blocks * BLOCK, row..(row + BLOCK).min(area.size));
                    }
                }
            }
        }
        self.cover_tested(drawing, work);
    }

    /// Goes on with the triangles that show where an alpha test passes: most are hidden by now.
    #[inline(always)]
    fn cover_tested<M: RayModel>(&self, drawing: &Drawing<'_, M>, work: &mut CoverWork) {
        let CoverWork { samples, drawn, tested, .. } = work;
        for &index in tested.iter() {
            let (triangle, drawn) = &drawn[index];
            samples.draw_tested(drawing.model, &drawing.area, drawn, |[b, c, sum], place| {
                let functions = [linear(b), linear(c), linear(sum), [0.0; TERMS]];
                let (center, scale, is_bent) = (Vec2::ZERO, 1.0, false);
                let surface =
                    FoundSurface { triangle: *triangle, group: 0, patch: 0, center, scale, functions, is_bent };
                let at: Barycentrics = surface.surface(place, None).barycentrics;
                self.scene.is_surface_present(*triangle, &at)
            });
        }
    }
}
