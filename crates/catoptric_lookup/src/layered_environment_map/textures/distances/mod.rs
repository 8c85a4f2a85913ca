//! Depths of a layer's surfaces by texel, and hits of rays on them.

#![allow(clippy::needless_range_loop)] // lanes of several arrays, for the vectoriser

use super::bounds::{DepthBounds, Range};
use super::depths::{Depth, Depths};
use crate::layered_environment_map::shell::{RayLanes, Shell};
use crate::layered_environment_map::texels::TexelLayout;
use catoptric_core::math::lanes::Lanes;
use glam::Vec3;
use std::sync::Arc;

/// The distances at which a ray is compared with depths grow by the factor e in about this many steps: by 1.06 in one.
/// Found by errors from above the plane of viewpoints: fewer steps have more, and gain little time.
const STEPS_A_LOGARITHM: f32 = 17.16;

/// Largest number of these steps: they are longer if distances differ by more. A bound on time; chosen, not measured.
const MAX_STEPS: f32 = 12.0;

/// Rays from beside the centre begin with steps of about this share of the largest distance. Chosen, not measured.
const NEAREST_STEP: f32 = 1.0 / 64.0;

/// Steps by which a hit found between two shares is made exact. Chosen, not measured.
const REFINEMENTS: usize = 8;

/// Distance from a depth up to which a hit is exact, in widths of a texel. Chosen, not measured.
const EXACT_TEXELS: f32 = 0.1;

/// Neighbouring texels whose shares differ by no more than this factor show one thing. Chosen, not measured.
const ALIKE: f32 = 1.1;

/// The factor behind the depth shown beyond which a ray has passed the edge of an object; below, it has met a surface
/// that is seen at a flat angle. Chosen, not measured.
const EDGE: f32 = 1.03;

/// Largest number of edges behind which a ray is followed on. A bound on time; chosen, not measured.
const MAX_EDGES: usize = 3;

/// The assumed bound of how much nearer surfaces come between the middles of texels than in these, as a share. Chosen,
/// not measured.
const BETWEEN_TEXELS: f32 = 0.1;

/// Relative difference of depths up to which all surfaces lie on the shell. Chosen, not measured.
const ON_SHELL: f32 = 1e-3;

/// The depths of a texture's finest level, for every texel: the distance from the centre of the surface that it shows,
/// as a share of the shell's distance (a shell scaled by that share about the centre goes through it), and the depth to
/// which the object reaches behind that. Rays that come past its edge meet it there, and pass whatever is further
/// behind.
#[derive(Clone, Debug)]
pub struct Distances {
    /// The layout of its texels.
    pub layout: TexelLayout,
    depths: Depths,
    /// The smallest and the largest finite depth, as a share.
    range: [f32; 2],
    /// Bounds of parts of the texture; `None` for a square, since straight lines may lead around it.
    bounds: Option<Arc<DepthBounds>>,
    /// The distance from the centre of the nearest surface that is shown.
    nearest: f32,
}

/// Places side by side, as shares, and the depths shown in their directions.
#[derive(Clone, Copy)]
struct TexelDepths<const LANES: usize> {
    own: Lanes<LANES>,
    front: Lanes<LANES>,
    back: Lanes<LANES>,
}

/// Intervals of distances along rays in which they may hit surfaces.
struct SearchInterval<const LANES: usize> {
    start: Lanes<LANES>,
    furthest: Lanes<LANES>,
    /// True for rays with such an interval.
    open: [bool; LANES],
}

/// Rays where they come to be behind the surface shown, or within its object.
struct Changed<const LANES: usize> {
    /// Along the ray.
    distance: Lanes<LANES>,
    /// True for rays that hit a surface there.
    is_met: [bool; LANES],
    /// True for rays that pass behind the edge of a surface there.
    is_passed: [bool; LANES],
    /// Surface that may lie hidden behind that edge.
    hidden: HiddenSurface<LANES>,
}

/// The surface shown beside the edge of an object that rays have come to be behind: it is assumed to go on behind that,
/// with the shell.
#[derive(Clone, Copy)]
struct HiddenSurface<const LANES: usize> {
    share: Lanes<LANES>,
    /// Along the ray, the last place before the edge.
    edge: Lanes<LANES>,
}

/// Distances along rays at which they are compared with depths: steps of equal length in the inverse of about the
/// distance from the centre.
struct StepSchedule<const LANES: usize> {
    offset: [f32; LANES],
    /// Inverse of the offset distance at the start, and its change up to the end.
    first: [f32; LANES],
    change: [f32; LANES],
    /// Numbers of steps, whole numbers: a lane's is that which it has alone.
    steps: [f32; LANES],
    /// The largest of them.
    most_steps: u32,
}

impl<const LANES: usize> StepSchedule<LANES> {
    #[inline(always)] // for the instructions of its caller
    fn new(rays: &RayLanes<LANES>, start: &Lanes<LANES>, furthest: &Lanes<LANES>, wanted: &[bool; LANES]) -> Self {
        let (mut offset, mut first, mut change) = ([0.0; LANES], [0.0; LANES], [0.0; LANES]);
        let mut steps = [0.0; LANES];
        for lane in 0..LANES {
            offset[lane] = rays.origins.vector(lane).length().max(furthest[lane] * NEAREST_STEP);
            first[lane] = 1.0 / (start[lane] + offset[lane]);
            change[lane] = (1.0 / (furthest[lane] + offset[lane]) - first[lane]).min(0.0);
            let ratio = 1.0 + change[lane] / first[lane];
            // Twice the hyperbolic sine of half the ratio's logarithm: that logarithm, but for 2 % at the most steps.
            let logarithm = (1.0 - ratio) / ratio.sqrt();
            steps[lane] = (logarithm * STEPS_A_LOGARITHM).ceil().clamp(1.0, MAX_STEPS);
        }
        let mut most = 0.0;
        for lane in 0..LANES {
            most = if wanted[lane] && steps[lane] > most { steps[lane] } else { most };
        }
        Self { offset, first, change, steps, most_steps: most as u32 }
    }

    /// Distances along rays after a step from 1 on; rays with fewer steps stay at the last.
    #[inline(always)] // for the instructions of its caller
    fn place(&self, step: u32, start: &Lanes<LANES>, distances: &mut Lanes<LANES>) {
        for lane in 0..LANES {
            let part = (step as f32 / self.steps[lane]).min(1.0);
            let distance = 1.0 / (self.first[lane] + self.change[lane] * part) - self.offset[lane];
            distances[lane] = distance.max(start[lane]);
        }
    }
}

/// Intervals of distances along rays that hold a change from before to behind a surface.
struct Bracket<const LANES: usize> {
    near: Lanes<LANES>,
    far: Lanes<LANES>,
    /// Depth at the near end, as a share of the shell's distance.
    shown_near: Lanes<LANES>,
    /// Depth less the ray's own share at the near end.
    above: [f32; LANES],
    /// The ray's own share less the depth at the far end.
    below: [f32; LANES],
    /// True if the far end lies on the surface or within its extent, not behind an edge.
    is_flat: [bool; LANES],
    /// True for rays that enter a solid from behind it.
    from_behind: [bool; LANES],
}

/// Returns true for places behind a surface that lie on it or within its extent.
#[inline(always)] // for the instructions of its caller
fn is_on(own: f32, front: f32, back: f32) -> bool {
    own <= front * EDGE || own <= back
}

/// Hits of rays on the surfaces shown.
#[derive(Clone, Copy, Debug)]
pub struct HitLanes<const LANES: usize> {
    /// Distance along the ray.
    pub distance: Lanes<LANES>,
    /// Factor by which the shell is grown to go through the hit.
    pub share: Lanes<LANES>,
    /// True for rays that hit a surface.
    pub is_met: [bool; LANES],
    /// True for rays that meet the grown shell there from outside, towards the centre.
    pub is_inward: [bool; LANES],
    /// Distance along the ray at which it leaves the grown shell.
    pub(crate) outward: Lanes<LANES>,
}

impl<const LANES: usize> HitLanes<LANES> {
    /// Rays that meet nothing.
    #[inline(always)] // for the instructions of its caller
    fn nothing(distance: &Lanes<LANES>, share: &Lanes<LANES>) -> Self {
        let no = [false; LANES];
        Self { distance: *distance, share: *share, is_met: no, is_inward: no, outward: *distance }
    }
}

impl Distances {
    /// Distances of a texture's finest level.
    pub fn new(shell: &Shell, layout: TexelLayout, depths: &[Depth]) -> Self {
        let known = depths.iter().enumerate().filter(|(_, depth)| depth.front.is_finite());
        let distance = |(texel, depth): (usize, &Depth)| {
            let direction = shell.towards(layout.middle_of(texel as u32)).normalize();
            depth.front * shell.distance(Vec3::ZERO, direction)
        };
        let nearest = known.map(distance).fold(f32::INFINITY, f32::min);
        // Texels beside the known ones may show the nearest part of the same surface.
        let beside = |texel: usize| {
            let others = layout.beside(texel as u32).map(|other| depths[other as usize]);
            match depths[texel] {
                depth if depth.front.is_finite() => depth,
                _ => others.min_by(|a, b| a.front.total_cmp(&b.front)).unwrap_or(Depth::NOTHING),
            }
        };
        let depths = Depths::new((0..depths.len()).map(beside));
        Self::of_parts(layout, depths, nearest)
    }

    /// The depths from [`Self::depths_and_nearest`].
    pub(crate) fn of_parts(layout: TexelLayout, depths: Depths, nearest: f32) -> Self {
        let fronts = || depths.iter().map(|depth| depth.front).filter(|front| front.is_finite());
        let range = [fronts().fold(f32::INFINITY, f32::min), fronts().fold(0.0, f32::max)];
        let bounds = (layout.faces() == 6).then(|| Arc::new(DepthBounds::new(&layout, &depths)));
        Self { depths, layout, range, bounds, nearest }
    }

    /// Depths of the finest level's texels, as they are kept, and how far from the centre the nearest thing is that is
    /// shown in the middle of a texel.
    pub(crate) fn depths_and_nearest(&self) -> (&Depths, f32) {
        (&self.depths, self.nearest)
    }

    /// The distance from the centre of the nearest surface that is shown, less a margin for surfaces between the
    /// middles of texels.
    pub(crate) fn nearest(&self) -> f32 {
        self.nearest * (1.0 - BETWEEN_TEXELS)
    }

    /// The first hits of rays on the surfaces shown: the places where rays reach the depth that is seen in their
    /// direction, or lie within the object behind it. Rays that are not wanted meet nothing. A ray's hit does not
    /// depend on the rays beside it.
    #[inline(always)] // for the instructions of its caller
    pub fn met<const LANES: usize>(
        &self,
        shell: &Shell,
        rays: &RayLanes<LANES>,
        wanted: &[bool; LANES],
    ) -> HitLanes<LANES> {
        let [least, most] = self.range;
        if most <= least * (1.0 + ON_SHELL) {
            let is_met = if least <= most { *wanted } else { [false; LANES] };
            let share = Lanes::splat(most.max(f32::MIN_POSITIVE));
            let distance = shell.distances_grown(rays, &share);
            return HitLanes { distance, share, is_met, is_inward: [false; LANES], outward: distance };
        }
        let begin = shell.shell_scale(&rays.origins);
        let (mut nearest, mut most_distant) = (Lanes::splat(least), Lanes::splat(most));
        let mut span = self.span(shell, rays, &begin, [&nearest, &most_distant], wanted);
        if let Some(bounds) = &self.bounds {
            // Without closures, which are not compiled for the instructions of their caller.
            let start = self.layout.in_texels(&shell.seen_at(&rays.at(&span.start)));
            let furthest = self.layout.in_texels(&shell.seen_at(&rays.at(&span.furthest)));
            if bounds.is_nothing_between([&start, &furthest], &span.open) {
                return HitLanes::nothing(&span.start, &begin);
            }
            let ranges = bounds.between([&start, &furthest], &span.open);
            let mut open = span.open;
            for lane in 0..LANES {
                let Range { least: nearer, most: further } = ranges[lane];
                open[lane] &= nearer <= further;
                nearest[lane] = if open[lane] { least.max(nearer) } else { least };
                most_distant[lane] = if open[lane] { most.min(further) } else { most };
            }
            if !open.contains(&true) {
                return HitLanes::nothing(&span.start, &begin);
            }
            span = self.span(shell, rays, &begin, [&nearest, &most_distant], &open);
        }
        let SearchInterval { mut start, furthest, mut open } = span;
        let mut met = HitLanes {
            distance: start,
            share: begin,
            is_met: [false; LANES],
            is_inward: [false; LANES],
            outward: furthest,
        };
        let mut hidden = HiddenSurface { share: Lanes::splat(f32::INFINITY), edge: start };
        for _ in 0..=MAX_EDGES {
            let changed = self.changed(shell, rays, [&start, &furthest], &hidden, &open);
            for lane in 0..LANES {
                met.distance[lane] = if changed.is_met[lane] { changed.distance[lane] } else { met.distance[lane] };
                met.is_met[lane] |= changed.is_met[lane];
                // Past an edge: on from there.
                open[lane] = changed.is_passed[lane];
                start[lane] = if changed.is_passed[lane] { changed.distance[lane] } else { start[lane] };
            }
            if !open.contains(&true) {
                break;
            }
            hidden = changed.hidden;
        }
        if !met.is_met.contains(&true) {
            return met;
        }
        met.share = shell.shell_scale(&rays.at(&met.distance));
        // Shells are convex: a ray meets one on its way in, where it does not meet it on its way out.
        met.outward = shell.distances_grown(rays, &met.share);
        for lane in 0..LANES {
            met.is_inward[lane] = met.distance[lane] < met.outward[lane] * (1.0 - ON_SHELL);
        }
        met
    }

    /// Intervals along rays in which surfaces between two shares may be hit.
    #[inline(always)] // for the instructions of its caller
    fn span<const LANES: usize>(
        &self,
        shell: &Shell,
        rays: &RayLanes<LANES>,
        begin: &Lanes<LANES>,
        [least, most]: [&Lanes<LANES>; 2],
        wanted: &[bool; LANES],
    ) -> SearchInterval<LANES> {
        // Rays from within the nearest share meet nothing before it; behind the largest there is nothing.
        let nearest = shell.distances_grown(rays, &(*least * (1.0 - ON_SHELL)));
        let furthest = shell.distances_grown(rays, &(*most * (1.0 + ON_SHELL)));
        let mut span = SearchInterval { start: Lanes::ZERO, furthest, open: *wanted };
        for lane in 0..LANES {
            span.start[lane] = if begin[lane] < least[lane] { nearest[lane] } else { 0.0 };
            span.open[lane] &= furthest[lane] > span.start[lane] && furthest[lane] < f32::INFINITY;
        }
        span
    }

    /// The first change, between two distances along rays, from before to behind the surface shown, or from behind an
    /// object into it, or to the surface that it hides.
    #[inline(always)] // for the instructions of its caller
    fn changed<const LANES: usize>(
        &self,
        shell: &Shell,
        rays: &RayLanes<LANES>,
        [start, furthest]: [&Lanes<LANES>; 2],
        hidden: &HiddenSurface<LANES>,
        wanted: &[bool; LANES],
    ) -> Changed<LANES> {
        let schedule = StepSchedule::new(rays, start, furthest, wanted);
        let mut tried = *start;
        let TexelDepths { own, front, back } = self.shown(shell, rays, start);
        let mut bracket = Bracket {
            near: *start,
            far: *start,
            shown_near: front,
            above: [0.0; LANES],
            below: [0.0; LANES],
            is_flat: [false; LANES],
            from_behind: [false; LANES],
        };
        let (mut is_before, mut is_beyond, mut is_found) = ([false; LANES], [false; LANES], [false; LANES]);
        let (mut reaches_hidden, mut hidden_share) = ([false; LANES], hidden.share);
        for lane in 0..LANES {
            is_before[lane] = wanted[lane] && front[lane] > own[lane];
            is_beyond[lane] = wanted[lane] && back[lane] < own[lane];
            bracket.above[lane] = front[lane] - own[lane];
        }
        for step in 1..=schedule.most_steps {
            schedule.place(step, start, &mut tried);
            let TexelDepths { own, front, back } = self.shown(shell, rays, &tried);
            for lane in 0..LANES {
                let is_behind = front[lane] <= own[lane];
                let is_within = is_behind && own[lane] <= back[lane];
                hidden_share[lane] = if is_behind { hidden_share[lane] } else { f32::INFINITY };
                let is_at_hidden = is_beyond[lane] && own[lane] >= hidden_share[lane];
                let enters = (is_behind && is_before[lane]) || (is_within && is_beyond[lane]);
                // Steps beyond a lane's own are other lanes' alone.
                let is_own = step as f32 <= schedule.steps[lane];
                let is_first = (enters || is_at_hidden) && !is_found[lane] && is_own;
                bracket.from_behind[lane] |= is_first && is_beyond[lane];
                reaches_hidden[lane] |= is_first && is_at_hidden;
                bracket.far[lane] = if is_first { tried[lane] } else { bracket.far[lane] };
                bracket.below[lane] = if is_first { own[lane] - front[lane] } else { bracket.below[lane] };
                bracket.is_flat[lane] |= is_first && is_on(own[lane], front[lane], back[lane]);
                is_found[lane] |= is_first;
                let is_open = !is_found[lane] && wanted[lane];
                bracket.near[lane] = if is_open { tried[lane] } else { bracket.near[lane] };
                bracket.shown_near[lane] = if is_open { front[lane] } else { bracket.shown_near[lane] };
                bracket.above[lane] = if is_open { front[lane] - own[lane] } else { bracket.above[lane] };
                is_before[lane] = is_open && !is_behind;
                is_beyond[lane] = is_open && is_behind && !is_within;
            }
            if (0..LANES).all(|lane| is_found[lane] || !wanted[lane]) {
                break;
            }
        }
        if !is_found.contains(&true) {
            return Changed { distance: bracket.far, is_met: is_found, is_passed: is_found, hidden: *hidden };
        }
        let mut is_exact = [false; LANES];
        for lane in 0..LANES {
            is_exact[lane] = !is_found[lane] || reaches_hidden[lane];
        }
        let distance = self.refined(shell, rays, &mut bracket, &mut is_exact);
        let hidden_behind = HiddenSurface { share: bracket.shown_near, edge: bracket.near };
        let mut changed =
            Changed { distance, is_met: [false; LANES], is_passed: [false; LANES], hidden: hidden_behind };
        for lane in 0..LANES {
            changed.distance[lane] = if reaches_hidden[lane] { hidden.edge[lane] } else { distance[lane] };
            let is_there = is_exact[lane] || bracket.is_flat[lane];
            changed.is_met[lane] = is_found[lane] && is_there;
            changed.is_passed[lane] = is_found[lane] && !is_there;
        }
        changed
    }

    /// Distances along rays at which their brackets close: within [`EXACT_TEXELS`], where `is_exact` becomes true, or
    /// after [`REFINEMENTS`] steps. Rays that are exact already keep the far end of their bracket.
    #[inline(always)] // for the instructions of its caller
    fn refined<const LANES: usize>(
        &self,
        shell: &Shell,
        rays: &RayLanes<LANES>,
        bracket: &mut Bracket<LANES>,
        is_exact: &mut [bool; LANES],
    ) -> Lanes<LANES> {
        // Share of the distance that a texel in the middle of a face spans, times the tolerance in texels.
        let exact = EXACT_TEXELS * 2.0 / self.layout.size() as f32;
        let mut distance = bracket.far;
        let mut tried = bracket.far;
        for refinement in 0..REFINEMENTS {
            for lane in 0..LANES {
                // The next place is found by the rule of false position, and half way in turn; also half way if nothing
                // is shown at one end.
                let part = bracket.above[lane] / (bracket.above[lane] + bracket.below[lane]);
                let is_between = part > 0.0 && part < 1.0 && refinement % 2 == 0;
                let part = if is_between { part } else { 0.5 };
                tried[lane] = bracket.near[lane] + (bracket.far[lane] - bracket.near[lane]) * part;
            }
            let TexelDepths { own, front, back } = self.smooth(shell, rays, &tried);
            for lane in 0..LANES {
                let is_in = front[lane] <= own[lane] && (own[lane] <= back[lane] || !bracket.from_behind[lane]);
                bracket.far[lane] = if is_in { tried[lane] } else { bracket.far[lane] };
                bracket.below[lane] = if is_in { own[lane] - front[lane] } else { bracket.below[lane] };
                bracket.is_flat[lane] =
                    if is_in { is_on(own[lane], front[lane], back[lane]) } else { bracket.is_flat[lane] };
                bracket.near[lane] = if is_in { bracket.near[lane] } else { tried[lane] };
                bracket.above[lane] = if is_in { bracket.above[lane] } else { front[lane] - own[lane] };
                bracket.shown_near[lane] = if is_in { bracket.shown_near[lane] } else { front[lane] };
                // Exact lanes stay as they are, whatever the others need.
                let is_there = (front[lane] - own[lane]).abs() < own[lane] * exact;
                let best = if is_there { tried[lane] } else { bracket.far[lane] };
                distance[lane] = if is_exact[lane] { distance[lane] } else { best };
                is_exact[lane] |= is_there;
            }
            if !is_exact.contains(&false) {
                break;
            }
        }
        distance
    }

    /// Depths of the texels in the directions, from the centre, of places along rays.
    #[inline(always)] // for the instructions of its caller
    fn shown<const LANES: usize>(
        &self,
        shell: &Shell,
        rays: &RayLanes<LANES>,
        distances: &Lanes<LANES>,
    ) -> TexelDepths<LANES> {
        let places = rays.at(distances);
        let texels = self.layout.nearest(&shell.seen_at(&places));
        let own = shell.shell_scale(&places);
        let mut shown = TexelDepths { own, front: Lanes::splat(f32::INFINITY), back: Lanes::splat(f32::INFINITY) };
        // The loads come first, so that the rest becomes vector instructions.
        let mut words = [0; LANES];
        for lane in 0..LANES {
            words[lane] = self.depths.word(texels[lane]);
        }
        for lane in 0..LANES {
            shown.front[lane] = self.depths.front(words[lane]);
            shown.back[lane] = self.depths.back(words[lane]);
        }
        shown
    }

    /// The depths shown, interpolated between the middles of texels where these are much alike.
    #[inline(always)] // for the instructions of its caller
    fn smooth<const LANES: usize>(
        &self,
        shell: &Shell,
        rays: &RayLanes<LANES>,
        distances: &Lanes<LANES>,
    ) -> TexelDepths<LANES> {
        let places = rays.at(distances);
        let (texels, aside) = self.layout.quads(&shell.seen_at(&places));
        let own = shell.shell_scale(&places);
        let mut words = [[0; LANES]; 4];
        for lane in 0..LANES {
            let [a, b] = self.depths.words_of_two(texels[lane]);
            let [c, d] = self.depths.words_of_two(texels[lane].saturating_add(self.layout.size()));
            (words[0][lane], words[1][lane], words[2][lane], words[3][lane]) = (a, b, c, d);
        }
        let mut shown = TexelDepths { own, front: Lanes::splat(f32::INFINITY), back: Lanes::splat(f32::INFINITY) };
        // All values are numbers here, and the library's minimum, which respects others, takes twice as long.
        let less = |a: f32, b: f32| if a < b { a } else { b };
        let more = |a: f32, b: f32| if a > b { a } else { b };
        for lane in 0..LANES {
            let [right, down] = [aside[0][lane], aside[1][lane]];
            let above = if right > 0.5 { words[1][lane] } else { words[0][lane] };
            let below = if right > 0.5 { words[3][lane] } else { words[2][lane] };
            let nearest = if down > 0.5 { below } else { above };
            let (a, b) = (self.depths.front(words[0][lane]), self.depths.front(words[1][lane]));
            let (c, d) = (self.depths.front(words[2][lane]), self.depths.front(words[3][lane]));
            let (least, most) = (less(less(a, b), less(c, d)), more(more(a, b), more(c, d)));
            let (above, below) = (a + (b - a) * right, c + (d - c) * right);
            let smooth = above + (below - above) * down;
            let is_smooth = most <= (least * ALIKE).min(f32::MAX);
            shown.front[lane] = if is_smooth { smooth } else { self.depths.front(nearest) };
            shown.back[lane] = self.depths.back(nearest);
        }
        shown
    }

    /// The stored parts: depths, their range, and bounds of parts of the texture.
    pub(crate) fn parts(&self) -> (&Depths, [f32; 2], Option<&DepthBounds>) {
        (&self.depths, self.range, self.bounds.as_deref())
    }

    /// Memory.
    pub(crate) fn byte_count(&self) -> u64 {
        self.depths.byte_count() + self.bounds.as_ref().map_or(0, |bounds| bounds.byte_count())
    }
}
