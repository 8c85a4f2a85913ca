//! The polish step of every projection method: Newton's method on the specular constraint, from where an approximation
//! has put the bounces.

use super::ray_map::Motion;
use super::work;
use catoptric_core::scene::PreciseView;
use catoptric_engine::method::projector::Projection;
use catoptric_engine::optics::path::bundle::{Eye, OutgoingRays};
use catoptric_engine::optics::path::manifold::SpecularSurfaces;
use catoptric_engine::optics::path::specular_solver::{PathSites, first_order_bundle_of, solve_within};
use glam::{DVec3, Vec2};

/// Residuals of the specular constraint below this count as solved. Chosen, not measured.
pub(crate) const SOLVED_RESIDUAL: f64 = 1e-10;

/// Work of the solver a bounce, of some steps.
const WORK_A_BOUNCE: u64 = 50;

/// Limits of the solver.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Effort {
    /// Steps at most.
    pub(crate) steps: u32,
    /// The first bounce may end up so far from where it started.
    pub(crate) reach: f64,
    /// True if paths whose residual is not below [`SOLVED_RESIDUAL`] by then are worth nothing.
    pub(crate) must_converge: bool,
}

/// A path through a scene point.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Polished {
    pub(crate) sites: PathSites,
    /// The last bounce point.
    pub(crate) last: DVec3,
    /// Motion of the first bounce point with the scene point.
    pub(crate) motion: Motion,
    /// True if the residual is below [`SOLVED_RESIDUAL`].
    pub(crate) converged: bool,
}

impl Polished {
    /// The appearance of a scene point by this path; `optical_length` is that of all of it.
    pub(crate) fn projection(
        &self,
        path: u32,
        view: &PreciseView,
        optical_length: f64,
        point: DVec3,
    ) -> Option<Projection> {
        let first = self.sites.sites[0].position;
        let [x, y] = view.place_of(first)?;
        let projection = Projection {
            path,
            focal_index: self.motion.focal_index,
            image_px: Vec2::new(x as f32, y as f32),
            image_change: self.motion.image_change(view.place_change(first)),
            path_length: optical_length as f32,
            reflection_point: first.as_vec3(),
            last_segment: self.last.distance(point) as f32,
            error_px: 0.0,
        };
        projection.if_meaningful()
    }
}

/// The path near `start` that leads to a point; returns `None` if the solver finds none, or one that meets surfaces
/// from other sides than `outside` gives.
pub(crate) fn polished(
    surfaces: &SpecularSurfaces<'_>,
    eye: &Eye,
    start: &PathSites,
    outside: &[bool],
    point: DVec3,
    effort: Effort,
) -> Option<Polished> {
    work::add(WORK_A_BOUNCE * start.count as u64);
    let solution = solve_within(surfaces, eye, point, start, effort.steps, SOLVED_RESIDUAL, effort.reach)?;
    if effort.must_converge && !solution.converged {
        return None;
    }
    let sites = solution.sites;
    // Stencils cut the picture at the border of the first surface; at those of the others nothing does.
    let is_within = |k: usize| surfaces.is_within(sites.bounces[k].object, &sites.sites[k]);
    if !(1..sites.count).all(is_within) {
        return None;
    }
    let (bundle, met_outside) = first_order_bundle_of(surfaces, eye, &sites)?;
    if met_outside[..sites.count] != outside[..sites.count] {
        return None;
    }
    let rays = OutgoingRays::new(&bundle)?;
    let last = sites.sites[sites.count - 1].position;
    let distance = last.distance(point);
    let focus = rays.focus(distance)?;
    let first = &bundle.first.first;
    let motion = Motion {
        change: [0, 1].map(|i: usize| first[0] * focus[0][i] + first[1] * focus[1][i]),
        across: rays.across,
        focal_index: bundle.focal_points_passed + rays.focal_points_before(distance),
    };
    Some(Polished { sites, last, motion, converged: solution.converged })
}
