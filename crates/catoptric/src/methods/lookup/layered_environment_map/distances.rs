//! How far things of a layer are from their shell: where rays really meet what a texture shows.

#![allow(clippy::needless_range_loop)] // lanes of several arrays, for the vectoriser

use super::shell::{RayLanes, Shell};
use super::texels::Layout;
use crate::methods::lookup::lanes::Lane;
use glam::Vec3;
use std::sync::Arc;

/// Shares by which a ray looks for what it meets grow by about this factor.
const STEP: f32 = 1.12;

/// As many of these steps are taken at most: where shares differ by more, they are longer.
const MOST_STEPS: f32 = 8.0;

/// Steps by which what was found between two shares is made exact.
const REFINEMENTS: usize = 6;

/// What was found within this of what is shown is exact, as a share: less than any texel is wide.
const EXACT: f32 = 2e-4;

/// Neighbouring texels whose shares differ by no more than this factor show one thing.
const ALIKE: f32 = 1.1;

/// Between the middles of texels things come nearer than in these by no more than this share, as far as is believed.
const BETWEEN_TEXELS: f32 = 0.1;

/// Where shares differ by no more than this, all is on the shell.
const ON_SHELL: f32 = 1e-3;

/// Of every texel of a texture's finest level how far from the centre what it shows is, as a share of the shell's distance: a shell that is
/// grown by that share about the centre goes through it.
#[derive(Clone, Debug)]
pub(super) struct Distances {
    layout: Layout,
    /// Infinite where nothing is shown.
    shares: Arc<[f32]>,
    /// The smallest and the largest finite one.
    range: [f32; 2],
    /// How far from the centre the nearest thing that is shown is.
    nearest: f32,
}

/// Rays as they meet what is shown.
#[derive(Clone, Copy, Debug)]
pub(super) struct Met<const LANES: usize> {
    /// By what share the shell is to be grown.
    pub(super) share: Lane<LANES>,
    /// Whether anything is met.
    pub(super) is_met: [bool; LANES],
}

impl Distances {
    /// Of a texture's finest level.
    pub(super) fn new(shell: &Shell, layout: Layout, shares: &[f32]) -> Self {
        let distance = |(texel, share): (usize, &f32)| {
            let direction = shell.towards(layout.middle_of(texel as u32)).normalize();
            share * shell.distance(Vec3::ZERO, direction)
        };
        let finite = shares.iter().enumerate().filter(|(_, share)| share.is_finite());
        let nearest = finite.map(distance).fold(f32::INFINITY, f32::min);
        let known = || shares.iter().copied().filter(|share| share.is_finite());
        let range = [known().fold(f32::INFINITY, f32::min), known().fold(0.0, f32::max)];
        // Texels beside the known ones may show a part of what these show: the nearest.
        let beside = |texel: usize| match shares[texel] {
            share if share.is_finite() => share,
            _ => layout.beside(texel as u32).map(|other| shares[other as usize]).fold(f32::INFINITY, f32::min),
        };
        Self { shares: (0..shares.len()).map(beside).collect(), layout, range, nearest }
    }

    /// How far from the centre the nearest thing that is shown is, but for what lies between the middles of texels.
    pub(super) fn nearest(&self) -> f32 {
        self.nearest * (1.0 - BETWEEN_TEXELS)
    }

    /// Where rays meet what is shown first: where they are as far from the centre as it is seen in their direction. Shares are tried from
    /// small to large, and the first change from before to behind is made exact. Rays that are not wanted meet nothing.
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
            return Met { share: [most.max(f32::MIN_POSITIVE); LANES], is_met };
        }
        let steps = ((most / least).ln() / STEP.ln()).ceil().clamp(1.0, MOST_STEPS);
        // What is nearer than a ray's origin is behind it.
        let mut near = shell.shares_of(&rays.origins);
        let (mut first, mut change) = ([0.0; LANES], [0.0; LANES]);
        for lane in 0..LANES {
            near[lane] = near[lane].max(least * (1.0 - ON_SHELL));
            // Steps are of equal length in the inverse.
            first[lane] = 1.0 / near[lane];
            change[lane] = (1.0 / (most * (1.0 + ON_SHELL)) - first[lane]).min(0.0) / steps;
        }
        let mut far = near;
        let (mut above, mut below) = (self.shown(shell, rays, &near), [0.0; LANES]);
        let mut is_before = [false; LANES];
        let mut is_met = [false; LANES];
        let mut tried = near;
        for lane in 0..LANES {
            is_before[lane] = wanted[lane] && above[lane] > near[lane];
        }
        for step in 1..=steps as u32 {
            for lane in 0..LANES {
                tried[lane] = 1.0 / (first[lane] + change[lane] * step as f32);
            }
            let shown = self.shown(shell, rays, &tried);
            for lane in 0..LANES {
                let is_behind = shown[lane] <= tried[lane];
                let is_found = is_behind && is_before[lane] && !is_met[lane];
                far[lane] = if is_found { tried[lane] } else { far[lane] };
                below[lane] = if is_found { shown[lane] } else { below[lane] };
                is_met[lane] |= is_found;
                let is_nearer = !is_behind && !is_met[lane];
                near[lane] = if is_nearer { tried[lane] } else { near[lane] };
                above[lane] = if is_nearer { shown[lane] } else { above[lane] };
                is_before[lane] |= is_nearer && wanted[lane];
            }
            if (0..LANES).all(|lane| is_met[lane] || !wanted[lane]) {
                break;
            }
        }
        if !is_met.contains(&true) {
            return Met { share: far, is_met };
        }
        let mut share = far;
        let mut is_exact = is_met.map(|is_met| !is_met);
        for refinement in 0..REFINEMENTS {
            for lane in 0..LANES {
                // By the rule of false position, and half way in turn; half way, too, where nothing is shown at one end.
                let (before, behind) = (above[lane] - near[lane], far[lane] - below[lane]);
                let part = before / (before + behind);
                let is_within = part > 0.0 && part < 1.0 && refinement % 2 == 0;
                let part = if is_within { part } else { 0.5 };
                tried[lane] = near[lane] + (far[lane] - near[lane]) * part;
            }
            let shown = self.smooth(shell, rays, &tried);
            for lane in 0..LANES {
                let is_behind = shown[lane] <= tried[lane];
                far[lane] = if is_behind { tried[lane] } else { far[lane] };
                below[lane] = if is_behind { shown[lane] } else { below[lane] };
                near[lane] = if is_behind { near[lane] } else { tried[lane] };
                above[lane] = if is_behind { above[lane] } else { shown[lane] };
                // What is exact stays as it is, whatever other rays need.
                let off = (shown[lane] - tried[lane]).abs();
                let best = if off < tried[lane] * EXACT { tried[lane] } else { far[lane] };
                share[lane] = if is_exact[lane] { share[lane] } else { best };
                is_exact[lane] |= off < tried[lane] * EXACT;
            }
            if !is_exact.contains(&false) {
                break;
            }
        }
        Met { share, is_met }
    }

    /// The shares of what is shown in the texels where rays meet a shell that is grown by shares.
    #[inline(always)] // for the instructions of its caller
    fn shown<const LANES: usize>(&self, shell: &Shell, rays: &RayLanes<LANES>, shares: &Lane<LANES>) -> Lane<LANES> {
        let texels = self.layout.nearest(&shell.directions(rays, shares));
        let mut shown = [f32::INFINITY; LANES];
        for lane in 0..LANES {
            shown[lane] = self.share_of(texels[lane]);
        }
        shown
    }

    /// The same, between the middles of texels where these show much the same.
    #[inline(always)] // for the instructions of its caller
    fn smooth<const LANES: usize>(&self, shell: &Shell, rays: &RayLanes<LANES>, shares: &Lane<LANES>) -> Lane<LANES> {
        let (texels, aside) = self.layout.quads(&shell.directions(rays, shares));
        let mut corners = [[f32::INFINITY; LANES]; 4];
        for lane in 0..LANES {
            for corner in 0..4 {
                corners[corner][lane] = self.share_of(texels[lane][corner]);
            }
        }
        let mut shown = [f32::INFINITY; LANES];
        // Nothing is no number here: what the library's minimum makes of those takes twice as long.
        let less = |a: f32, b: f32| if a < b { a } else { b };
        let more = |a: f32, b: f32| if a > b { a } else { b };
        for lane in 0..LANES {
            let [right, down] = [aside[0][lane], aside[1][lane]];
            let [a, b, c, d] = [corners[0][lane], corners[1][lane], corners[2][lane], corners[3][lane]];
            let (least, most) = (less(less(a, b), less(c, d)), more(more(a, b), more(c, d)));
            let nearest_above = if right > 0.5 { b } else { a };
            let nearest_below = if right > 0.5 { d } else { c };
            let nearest = if down > 0.5 { nearest_below } else { nearest_above };
            let (above, below) = (a + (b - a) * right, c + (d - c) * right);
            let smooth = above + (below - above) * down;
            shown[lane] = if most <= least * ALIKE { smooth } else { nearest };
        }
        shown
    }

    /// What a texel shows; nothing beyond the last.
    #[inline(always)] // for the instructions of its caller
    fn share_of(&self, texel: u32) -> f32 {
        self.shares.get(texel as usize).copied().unwrap_or(f32::INFINITY)
    }

    /// Memory.
    pub(super) fn byte_count(&self) -> u64 {
        size_of_val(&self.shares[..]) as u64
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::math::random::Stream;
    use crate::methods::lookup::lanes::one;
    use crate::methods::lookup::surround::Surround;
    use glam::Vec2;

    const RADIUS: f32 = 3.0;

    /// What is seen from the centre of a spherical shell in directions, by how far away it is (none: nothing is).
    fn seen(size: u32, distance: impl Fn(Vec3) -> Option<f32>) -> (Shell, Distances) {
        let layout = Layout::cube(size);
        let texel = |index: u32| {
            let (face, x, y) = (index / (size * size), index % size, index / size % size);
            let at = (Vec2::new(x as f32, y as f32) + 0.5) * (2.0 / size as f32) - 1.0;
            distance(layout.place_of(face, at).normalize()).map_or(f32::INFINITY, |distance| distance / RADIUS)
        };
        let shares: Vec<f32> = (0..6 * size * size).map(texel).collect();
        let shell = Shell::Around(Surround::Sphere(RADIUS));
        (shell, Distances::new(&shell, layout, &shares))
    }

    /// Where a ray meets what is seen.
    fn met(shell: &Shell, distances: &Distances, origin: Vec3, direction: Vec3) -> Option<Vec3> {
        let rays = RayLanes::sharp(one(origin), one(direction));
        let Met { share: [share], is_met: [is_met] } = distances.met(shell, &rays, &[true]);
        is_met.then(|| origin + direction * (share * shell.distance(origin / share, direction)))
    }

    #[test]
    fn rays_meet_planes_where_planes_are() {
        let mut random = Stream::new(4);
        for normal in [Vec3::Z, Vec3::new(0.6, 0.0, 0.8), Vec3::new(-0.2, -0.9, 0.3).normalize()] {
            let plane = |direction: Vec3| {
                let distance = 2.0 / direction.dot(normal);
                (distance > 0.0 && distance < 8.0).then_some(distance)
            };
            let (shell, distances) = seen(256, plane);
            let (mut checked, mut worst) = (0, 0.0f32);
            for _ in 0..2000 {
                let mut vector = || Vec3::from([0; 3].map(|_| random.next_between(-1.0, 1.0)));
                let (origin, direction) = (vector() * 0.8, vector().normalize());
                let truth = origin + direction * (2.0 - origin.dot(normal)) / direction.dot(normal);
                // Away from the rim of what is seen.
                if direction.dot(normal) < 0.2 || truth.length() > 7.0 {
                    continue;
                }
                let found = met(&shell, &distances, origin, direction);
                let off = found.map_or(f32::INFINITY, |found| found.normalize().distance(truth.normalize()));
                (checked, worst) = (checked + 1, worst.max(off));
            }
            // A texel is 0.008 wide in the middle of a face.
            assert!(checked > 500 && worst < 0.008, "{normal}: {checked} rays, {worst}");
        }
    }

    #[test]
    fn rays_pass_what_they_do_not_meet() {
        // A small ball in front of the centre.
        let middle = Vec3::new(0.0, 0.0, 2.0);
        let ball = |direction: Vec3| {
            let along = direction.dot(middle);
            let under_root = along * along - middle.length_squared() + 0.25;
            (along > 0.0 && under_root > 0.0).then(|| along - under_root.sqrt())
        };
        let (shell, distances) = seen(128, ball);
        let origin = Vec3::new(1.0, 0.0, 0.0);
        let towards = |target: Vec3| met(&shell, &distances, origin, (target - origin).normalize());
        let found = towards(middle).expect("the ball is there");
        assert!((found.distance(middle) - 0.5).abs() < 0.03, "{found}");
        // Before it, beside it, and away from it.
        assert_eq!(towards(Vec3::new(0.0, 0.0, 1.0)), None);
        assert_eq!(towards(Vec3::new(2.0, 0.0, 2.0)), None);
        assert_eq!(towards(Vec3::new(-1.0, 3.0, 0.0)), None);
        let (shell, nothing) = seen(8, |_| None);
        assert_eq!(met(&shell, &nothing, Vec3::ZERO, Vec3::X), None);
    }
}
