//! How far things of a layer are from their shell: where rays really meet what a texture shows.

#![allow(clippy::needless_range_loop)] // lanes of several arrays, for the vectoriser

#[cfg(test)]
mod tests;

use super::bounds::{Bounds, Range};
use super::depths::{Depth, Depths};
use super::shell::{RayLanes, Shell};
use super::texels::Layout;
use crate::methods::lookup::lanes::{Lane, vector};
use glam::Vec3;
use std::sync::Arc;

/// Distances at which a ray looks for what it meets grow by about this factor.
const STEP: f32 = 1.06;

/// As many of these steps are taken at most: where distances differ by more, they are longer.
const MOST_STEPS: f32 = 12.0;

/// Rays from beside the centre begin with steps of about this share of the largest distance.
const NEAREST_STEP: f32 = 1.0 / 64.0;

/// Steps by which what was found between two shares is made exact.
const REFINEMENTS: usize = 8;

/// What was found within this of what is shown is exact, in widths of a texel.
const EXACT_TEXELS: f32 = 0.1;

/// Neighbouring texels whose shares differ by no more than this factor show one thing.
const ALIKE: f32 = 1.1;

/// A ray that has come to be further behind what is shown than by this factor has come past the edge of a thing; by less, and it has met a
/// surface that is seen at a flat angle.
const EDGE: f32 = 1.03;

/// As often as this a ray that passes behind the edge of a thing is followed on.
const MOST_EDGES: usize = 3;

/// Between the middles of texels things come nearer than in these by no more than this share, as far as is believed.
const BETWEEN_TEXELS: f32 = 0.1;

/// Where shares differ by no more than this, all is on the shell.
const ON_SHELL: f32 = 1e-3;

/// Of every texel of a texture's finest level how far from the centre what it shows is, as a share of the shell's distance: a shell that is
/// grown by that share about the centre goes through it. Also how far that thing reaches behind what is shown: rays that come past its edge
/// meet it there, and pass what is further behind.
#[derive(Clone, Debug)]
pub(super) struct Distances {
    layout: Layout,
    depths: Depths,
    /// The smallest and the largest finite share of what is shown.
    range: [f32; 2],
    /// Of parts of the texture; none for a square, where straight ways may lead around it.
    bounds: Option<Arc<Bounds>>,
    /// How far from the centre the nearest thing that is shown is.
    nearest: f32,
}

/// Places side by side, by shares, and what is shown in their directions.
#[derive(Clone, Copy)]
struct Shown<const LANES: usize> {
    own: Lane<LANES>,
    front: Lane<LANES>,
    back: Lane<LANES>,
}

/// Where along rays things may be met.
struct Span<const LANES: usize> {
    start: Lane<LANES>,
    furthest: Lane<LANES>,
    /// Whether there is such a part of the ray.
    open: [bool; LANES],
}

/// Rays where they come to be behind what is shown, or within it.
struct Changed<const LANES: usize> {
    /// Along the ray.
    distance: Lane<LANES>,
    /// Whether something is met there.
    is_met: [bool; LANES],
    /// Whether they come past the edge of a thing there, to be behind it.
    is_passed: [bool; LANES],
    /// What that thing may hide.
    hidden: Hidden<LANES>,
}

/// What is shown beside the edge of a thing that rays have come to be behind: it is taken to go on behind that, with the shell.
#[derive(Clone, Copy)]
struct Hidden<const LANES: usize> {
    share: Lane<LANES>,
    /// Along the ray, the last place before the edge.
    edge: Lane<LANES>,
}

/// Whether a place behind what is shown is on that, or within what reaches behind it.
#[inline(always)] // for the instructions of its caller
fn is_on(own: f32, front: f32, back: f32) -> bool {
    own <= front * EDGE || own <= back
}

/// Rays as they meet what is shown.
#[derive(Clone, Copy, Debug)]
pub(super) struct Met<const LANES: usize> {
    /// How far along the ray.
    pub(super) distance: Lane<LANES>,
    /// By what share the shell is to be grown.
    pub(super) share: Lane<LANES>,
    /// Whether anything is met.
    pub(super) is_met: [bool; LANES],
    /// Whether the ray meets the grown shell there from outside: it comes nearer to the centre.
    pub(super) is_inward: [bool; LANES],
    /// How far along the ray it leaves the grown shell.
    pub(super) outward: Lane<LANES>,
}

impl<const LANES: usize> Met<LANES> {
    /// Nothing is met.
    #[inline(always)] // for the instructions of its caller
    fn nothing(distance: &Lane<LANES>, share: &Lane<LANES>) -> Self {
        let no = [false; LANES];
        Self { distance: *distance, share: *share, is_met: no, is_inward: no, outward: *distance }
    }
}

impl Distances {
    /// Of a texture's finest level.
    pub(super) fn new(shell: &Shell, layout: Layout, depths: &[Depth]) -> Self {
        let known = || depths.iter().enumerate().filter(|(_, depth)| depth.front.is_finite());
        let distance = |(texel, depth): (usize, &Depth)| {
            let direction = shell.towards(layout.middle_of(texel as u32)).normalize();
            depth.front * shell.distance(Vec3::ZERO, direction)
        };
        let nearest = known().map(distance).fold(f32::INFINITY, f32::min);
        // Texels beside the known ones may show a part of what these show: the nearest.
        let beside = |texel: usize| {
            let others = layout.beside(texel as u32).map(|other| depths[other as usize]);
            match depths[texel] {
                depth if depth.front.is_finite() => depth,
                _ => others.min_by(|a, b| a.front.total_cmp(&b.front)).unwrap_or(Depth::NOTHING),
            }
        };
        let depths = Depths::new((0..depths.len()).map(beside));
        let fronts = || depths.iter().map(|depth| depth.front).filter(|front| front.is_finite());
        let range = [fronts().fold(f32::INFINITY, f32::min), fronts().fold(0.0, f32::max)];
        let bounds = (layout.faces() == 6).then(|| Arc::new(Bounds::new(&layout, &depths)));
        Self { depths, layout, range, bounds, nearest }
    }

    /// How far from the centre the nearest thing that is shown is, but for what lies between the middles of texels.
    pub(super) fn nearest(&self) -> f32 {
        self.nearest * (1.0 - BETWEEN_TEXELS)
    }

    /// Where rays meet what is shown first: where they come to be as far from the centre as it is seen in their direction, or within what reaches
    /// behind that. Rays that are not wanted meet nothing.
    #[inline(always)] // for the instructions of its caller
    pub(super) fn met<const LANES: usize>(
        &self,
        shell: &Shell,
        rays: &RayLanes<LANES>,
        wanted: &[bool; LANES],
    ) -> Met<LANES> {
        let [least, most] = self.range;
        if most <= least * (1.0 + ON_SHELL) {
            let is_met = if least <= most { *wanted } else { [false; LANES] };
            let share = [most.max(f32::MIN_POSITIVE); LANES];
            let distance = shell.distances_grown(rays, &share);
            return Met { distance, share, is_met, is_inward: [false; LANES], outward: distance };
        }
        let begin = shell.shares_of(&rays.origins);
        let mut span = self.span(shell, rays, &begin, self.range, wanted);
        if let Some(bounds) = &self.bounds {
            // Without closures, which are not compiled for the instructions of their caller.
            let start = self.layout.in_texels(&shell.seen_at(&rays.at(&span.start)));
            let furthest = self.layout.in_texels(&shell.seen_at(&rays.at(&span.furthest)));
            if let Some(Range { least: nearer, most: further }) = bounds.between([&start, &furthest], &span.open) {
                if nearer > further {
                    return Met::nothing(&span.start, &begin);
                }
                if nearer > least || further < most {
                    span = self.span(shell, rays, &begin, [least.max(nearer), most.min(further)], &span.open);
                }
            }
        }
        let Span { mut start, furthest, mut open } = span;
        let mut met =
            Met { distance: start, share: begin, is_met: [false; LANES], is_inward: [false; LANES], outward: furthest };
        let mut hidden = Hidden { share: [f32::INFINITY; LANES], edge: start };
        for _ in 0..=MOST_EDGES {
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
        met.share = shell.shares_of(&rays.at(&met.distance));
        // Shells are convex: a ray meets one on its way in, where it does not meet it on its way out.
        met.outward = shell.distances_grown(rays, &met.share);
        for lane in 0..LANES {
            met.is_inward[lane] = met.distance[lane] < met.outward[lane] * (1.0 - ON_SHELL);
        }
        met
    }

    /// Where along rays what is shown between two shares may be met.
    #[inline(always)] // for the instructions of its caller
    fn span<const LANES: usize>(
        &self,
        shell: &Shell,
        rays: &RayLanes<LANES>,
        begin: &Lane<LANES>,
        [least, most]: [f32; 2],
        wanted: &[bool; LANES],
    ) -> Span<LANES> {
        // Rays from within the nearest share meet nothing before it; behind the largest there is nothing.
        let nearest = shell.distances_grown(rays, &[least * (1.0 - ON_SHELL); LANES]);
        let furthest = shell.distances_grown(rays, &[most * (1.0 + ON_SHELL); LANES]);
        let mut span = Span { start: [0.0; LANES], furthest, open: *wanted };
        for lane in 0..LANES {
            span.start[lane] = if begin[lane] < least { nearest[lane] } else { 0.0 };
            span.open[lane] &= furthest[lane] > span.start[lane] && furthest[lane] < f32::INFINITY;
        }
        span
    }

    /// The first change, between two distances along rays, from before to behind what is shown, or from behind a thing into it or to what it
    /// hides.
    #[inline(always)] // for the instructions of its caller
    fn changed<const LANES: usize>(
        &self,
        shell: &Shell,
        rays: &RayLanes<LANES>,
        [start, furthest]: [&Lane<LANES>; 2],
        hidden: &Hidden<LANES>,
        wanted: &[bool; LANES],
    ) -> Changed<LANES> {
        let mut least = f32::MAX;
        let (mut offset, mut first, mut change) = ([0.0; LANES], [0.0; LANES], [0.0; LANES]);
        for lane in 0..LANES {
            // Steps are of equal length in the inverse of about the distance from the centre.
            offset[lane] = vector(&rays.origins, lane).length().max(furthest[lane] * NEAREST_STEP);
            first[lane] = 1.0 / (start[lane] + offset[lane]);
            change[lane] = (1.0 / (furthest[lane] + offset[lane]) - first[lane]).min(0.0);
            let ratio = 1.0 + change[lane] / first[lane];
            least = if wanted[lane] && ratio < least { ratio } else { least };
        }
        // A texel in the middle of a face spans this much of the distance.
        let exact = EXACT_TEXELS * 2.0 / self.layout.size() as f32;
        let steps = (-least.min(1.0).ln() / STEP.ln()).ceil().clamp(1.0, MOST_STEPS);
        let (mut near, mut far, mut tried) = (*start, *start, *start);
        let Shown { own, front, back } = self.shown(shell, rays, start);
        let (mut shown_near, mut above, mut below, mut is_flat) = (front, [0.0; LANES], [0.0; LANES], [false; LANES]);
        let (mut is_before, mut is_beyond, mut is_found, mut from_behind) =
            ([false; LANES], [false; LANES], [false; LANES], [false; LANES]);
        let (mut reaches_hidden, mut hidden_share) = ([false; LANES], hidden.share);
        for lane in 0..LANES {
            is_before[lane] = wanted[lane] && front[lane] > own[lane];
            is_beyond[lane] = wanted[lane] && back[lane] < own[lane];
            above[lane] = front[lane] - own[lane];
        }
        for step in 1..=steps as u32 {
            let part = step as f32 / steps;
            for lane in 0..LANES {
                tried[lane] = (1.0 / (first[lane] + change[lane] * part) - offset[lane]).max(start[lane]);
            }
            let Shown { own, front, back } = self.shown(shell, rays, &tried);
            for lane in 0..LANES {
                let is_behind = front[lane] <= own[lane];
                let is_within = is_behind && own[lane] <= back[lane];
                hidden_share[lane] = if is_behind { hidden_share[lane] } else { f32::INFINITY };
                let is_at_hidden = is_beyond[lane] && own[lane] >= hidden_share[lane];
                let enters = (is_behind && is_before[lane]) || (is_within && is_beyond[lane]);
                let is_first = (enters || is_at_hidden) && !is_found[lane];
                from_behind[lane] |= is_first && is_beyond[lane];
                reaches_hidden[lane] |= is_first && is_at_hidden;
                far[lane] = if is_first { tried[lane] } else { far[lane] };
                below[lane] = if is_first { own[lane] - front[lane] } else { below[lane] };
                is_flat[lane] |= is_first && is_on(own[lane], front[lane], back[lane]);
                is_found[lane] |= is_first;
                let is_open = !is_found[lane] && wanted[lane];
                near[lane] = if is_open { tried[lane] } else { near[lane] };
                shown_near[lane] = if is_open { front[lane] } else { shown_near[lane] };
                above[lane] = if is_open { front[lane] - own[lane] } else { above[lane] };
                is_before[lane] = is_open && !is_behind;
                is_beyond[lane] = is_open && is_behind && !is_within;
            }
            if (0..LANES).all(|lane| is_found[lane] || !wanted[lane]) {
                break;
            }
        }
        if !is_found.contains(&true) {
            return Changed { distance: far, is_met: is_found, is_passed: is_found, hidden: *hidden };
        }
        let mut distance = far;
        let mut is_exact = [false; LANES];
        for lane in 0..LANES {
            is_exact[lane] = !is_found[lane] || reaches_hidden[lane];
        }
        for refinement in 0..REFINEMENTS {
            for lane in 0..LANES {
                // By the rule of false position, and half way in turn; half way, too, where nothing is shown at one end.
                let part = above[lane] / (above[lane] + below[lane]);
                let is_between = part > 0.0 && part < 1.0 && refinement % 2 == 0;
                let part = if is_between { part } else { 0.5 };
                tried[lane] = near[lane] + (far[lane] - near[lane]) * part;
            }
            let Shown { own, front, back } = self.smooth(shell, rays, &tried);
            for lane in 0..LANES {
                let is_in = front[lane] <= own[lane] && (own[lane] <= back[lane] || !from_behind[lane]);
                far[lane] = if is_in { tried[lane] } else { far[lane] };
                below[lane] = if is_in { own[lane] - front[lane] } else { below[lane] };
                is_flat[lane] = if is_in { is_on(own[lane], front[lane], back[lane]) } else { is_flat[lane] };
                near[lane] = if is_in { near[lane] } else { tried[lane] };
                above[lane] = if is_in { above[lane] } else { front[lane] - own[lane] };
                shown_near[lane] = if is_in { shown_near[lane] } else { front[lane] };
                // What is exact stays as it is, whatever other rays need.
                let is_there = (front[lane] - own[lane]).abs() < own[lane] * exact;
                let best = if is_there { tried[lane] } else { far[lane] };
                distance[lane] = if is_exact[lane] { distance[lane] } else { best };
                is_exact[lane] |= is_there;
            }
            if !is_exact.contains(&false) {
                break;
            }
        }
        let hidden_behind = Hidden { share: shown_near, edge: near };
        let mut changed =
            Changed { distance, is_met: [false; LANES], is_passed: [false; LANES], hidden: hidden_behind };
        for lane in 0..LANES {
            changed.distance[lane] = if reaches_hidden[lane] { hidden.edge[lane] } else { distance[lane] };
            let is_there = is_exact[lane] || is_flat[lane];
            changed.is_met[lane] = is_found[lane] && is_there;
            changed.is_passed[lane] = is_found[lane] && !is_there;
        }
        changed
    }

    /// What is shown in the texels where places at distances along rays are seen from the centre.
    #[inline(always)] // for the instructions of its caller
    fn shown<const LANES: usize>(
        &self,
        shell: &Shell,
        rays: &RayLanes<LANES>,
        distances: &Lane<LANES>,
    ) -> Shown<LANES> {
        let places = rays.at(distances);
        let texels = self.layout.nearest(&shell.seen_at(&places));
        let own = shell.shares_of(&places);
        let mut shown = Shown { own, front: [f32::INFINITY; LANES], back: [f32::INFINITY; LANES] };
        // All loads come first, so that the rest becomes vector instructions.
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

    /// The same, between the middles of texels where these show much the same.
    #[inline(always)] // for the instructions of its caller
    fn smooth<const LANES: usize>(
        &self,
        shell: &Shell,
        rays: &RayLanes<LANES>,
        distances: &Lane<LANES>,
    ) -> Shown<LANES> {
        let places = rays.at(distances);
        let (texels, aside) = self.layout.quads(&shell.seen_at(&places));
        let own = shell.shares_of(&places);
        let mut words = [[0; LANES]; 4];
        for lane in 0..LANES {
            let [a, b] = self.depths.words_of_two(texels[lane]);
            let [c, d] = self.depths.words_of_two(texels[lane].saturating_add(self.layout.size()));
            (words[0][lane], words[1][lane], words[2][lane], words[3][lane]) = (a, b, c, d);
        }
        let mut shown = Shown { own, front: [f32::INFINITY; LANES], back: [f32::INFINITY; LANES] };
        // Nothing is no number here: what the library's minimum makes of those takes twice as long.
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

    /// Memory.
    pub(super) fn byte_count(&self) -> u64 {
        self.depths.byte_count() + self.bounds.as_ref().map_or(0, |bounds| bounds.byte_count())
    }
}
