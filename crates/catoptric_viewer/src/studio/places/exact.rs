//! The picked path as a solver's: where it leads to other points is found by following it there.

use crate::studio::pick::Bounce;
use catoptric::light::tracer::Tracer;
use catoptric::optics::path::bundle::{Bounce as PathBounce, Eye};
use catoptric::optics::path::manifold::SpecularSurfaces;
use catoptric::optics::path::specular_solver::{PathSites, Solution, solve};
use catoptric::scene::{Projection, Ray, Scene, View};
use glam::{DVec2, DVec3, DVec4, Vec3};

/// Newton steps at the most.
const MAX_STEPS: u32 = 24;

/// Paths with smaller residuals of the specular constraint are solutions.
const SOLVED: f64 = 1e-11;

/// The longest step in the picture on the way to another point, in pixels: on the same sheet neighbours are near.
const LONGEST_STEP_PX: f64 = 24.0;

/// The smallest step on the way to another point, as a share of it: where a path cannot be followed further, its sheet
/// ends.
const SMALLEST_STEP: f64 = 1e-4;

/// A path from the eye that can be followed.
pub(super) struct ExactPath<'a> {
    surfaces: SpecularSurfaces<'a>,
    view: &'a View,
    eye: Eye,
    sites: PathSites,
}

/// A path that leads to a point.
#[derive(Clone, Copy, Debug)]
pub(super) struct Found {
    /// Where it leaves the picture, in pixels.
    pub(super) px: DVec2,
    /// The place of the last bounce, and the unit direction from there to the point.
    pub(super) last: DVec3,
    pub(super) leaving: DVec3,
    sites: PathSites,
}

impl<'a> ExactPath<'a> {
    /// The path of the ray through a place of the picture with these bounces.
    pub(super) fn new(
        scene: &'a Scene,
        tracer: &Tracer,
        view: &'a View,
        [x_px, y_px]: [f32; 2],
        bounces: &[(Bounce, PathBounce)],
    ) -> Option<Self> {
        let surfaces = SpecularSurfaces::new(scene);
        let mut origin = view.ray(x_px, y_px).origin;
        let mut sites = Vec::with_capacity(bounces.len());
        for (picked, bounce) in bounces {
            let way = picked.position - origin;
            let ray = Ray { origin, direction: way.try_normalize()? };
            // Not the surface that it leaves.
            let hit = tracer.first_hit(scene, &ray, 0.5 * way.length())?;
            let (object, site) = surfaces.site_of(&ray, &hit)?;
            if object != bounce.object {
                return None;
            }
            sites.push((*bounce, site));
            origin = picked.position;
        }
        let eye = match view.projection {
            Projection::Perspective { .. } => Eye::Point(view.eye().as_dvec3()),
            Projection::Orthographic { .. } => {
                Eye::Direction(-Vec3::from(view.world_from_view.matrix3.z_axis).as_dvec3().normalize())
            }
        };
        Some(Self { surfaces, view, eye, sites: PathSites::new(&sites)? })
    }

    fn found(&self, point: DVec3, start: &PathSites) -> Option<Found> {
        let solution = solve(&self.surfaces, &self.eye, point, start, MAX_STEPS, SOLVED)?;
        let Solution { sites, converged: true, .. } = solution else { return None };
        let last = sites.sites[sites.count.checked_sub(1)?].position;
        let px = self.view.pixel_of_exact(sites.sites[0].position)?;
        Some(Found { px, last, leaving: (point - last).try_normalize()?, sites })
    }

    /// The exact path to the point that the ray has met.
    pub(super) fn solved(&self, point: DVec3) -> Option<Found> {
        self.found(point, &self.sites)
    }

    /// The path to another point, in homogeneous coordinates, that a path to `point` becomes on a straight way there;
    /// `None` if its sheet ends before, or it leaves the reflectors.
    pub(super) fn followed(&self, path: &Found, point: DVec3, target: DVec4) -> Option<Found> {
        // The same point with about the target's weight, so that equal shares are even steps.
        let from =
            point.extend(1.0) * (target.truncate().length() / point.length().max(f64::MIN_POSITIVE)).max(target.w);
        let at = |share: f64| {
            let place = from.lerp(target, share);
            place.truncate() / place.w
        };
        let (mut now, mut share, mut step) = (*path, 0.0f64, 0.25f64);
        while share < 1.0 {
            let next = (share + step).min(1.0);
            let found = self.found(at(next), &now.sites).filter(|next| next.px.distance(now.px) < LONGEST_STEP_PX);
            match found {
                Some(found) => (now, share, step) = (found, next, 2.0 * step),
                None if step < SMALLEST_STEP => return None,
                None => step *= 0.5,
            }
        }
        let mut sites = now.sites.sites.iter().zip(&now.sites.bounces).take(now.sites.count);
        let is_within = sites.all(|(site, bounce)| self.surfaces.is_within(bounce.object, site));
        is_within.then_some(now)
    }
}
