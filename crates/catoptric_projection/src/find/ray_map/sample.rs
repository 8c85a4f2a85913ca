//! Sample rays: followed through reflectors and lenses, with the expansions of all their neighbours.

use super::scatter::{Scattering, Specular, departure, is_spurious};
use catoptric_core::math::jet::{ScalarJet, VectorJet};
use catoptric_core::scene::Ray;
use catoptric_core::surface::patch::SurfacePatch;
use catoptric_engine::method::projector::{MAX_BOUNCES, SpecularPath};
use catoptric_engine::optics::path::bundle::{Bounce, BounceKind, Eye, FirstOrder, OutgoingRays, RayBundle};
use catoptric_engine::optics::path::manifold::{ManifoldVertex, SpecularSurfaces};
use catoptric_engine::optics::path::specular_solver::PathSites;
use glam::{DVec2, DVec3, Vec3};

/// One outgoing ray: the path that led to it and the expansion of its neighbours.
#[derive(Clone, Copy, Debug)]
pub struct RaySample {
    /// The first reflection point as a function of the bundle's parameters.
    pub first: VectorJet,
    /// The rays that leave the last bounce.
    pub rays: OutgoingRays,
    /// The bounce points.
    pub sites: PathSites,
    /// The parameters of every bounce point after the first, as functions of the bundle's.
    moves: [[ScalarJet; 2]; MAX_BOUNCES - 1],
    /// Optical length from the eye (its plane) to the last bounce.
    pub optical_length: f64,
    /// Index of refraction of the medium before each bounce and, at the place of the count, after the last.
    pub media: [f64; MAX_BOUNCES + 1],
    /// Focal points passed before the last bounce.
    pub focal_points_passed: u32,
    /// True for bounces that are met from the outer side.
    pub outside: [bool; MAX_BOUNCES],
}

/// Part of a Taylor expansion that is used (Chen and Arvo 2000, figure 13).
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub enum Approximation {
    /// The nearest sample as it is.
    Nearest,
    /// The path Jacobian.
    Linear,
    /// The path Jacobian and Hessian.
    Quadratic,
}

/// A sample's answer for a scene point near its ray.
#[derive(Clone, Copy, Debug)]
pub struct Neighbour {
    /// The first reflection point.
    pub reflection_point: DVec3,
    /// Distance of the scene point along the sample's ray.
    pub distance: f64,
    /// The parameters that were found.
    pub parameters: DVec2,
    /// Their first-order part.
    pub linear: DVec2,
    /// Second-order terms, used or not; zero if they are negligible.
    pub remainder: DVec2,
}

/// Motion of a first reflection point.
#[derive(Clone, Copy, Debug)]
pub struct Motion {
    /// The change of the first reflection point with a step of the scene point along each of `across`.
    pub change: [DVec3; 2],
    /// The axes of those steps.
    pub across: [DVec3; 2],
    /// Focal points passed, summed over the path.
    pub focal_index: u32,
}

impl Motion {
    /// Change of the place in the picture with the scene point, from that with the first reflection point.
    pub fn image_change(&self, gradients: [DVec3; 2]) -> [Vec3; 2] {
        let Self { change, across, .. } = self;
        // d place / d point = sum over lateral axes of (gradient . change_i) across_i.
        gradients.map(|gradient| (across[0] * gradient.dot(change[0]) + across[1] * gradient.dot(change[1])).as_vec3())
    }
}

impl RaySample {
    /// The reflection of a scene point near the ray; `None` at a focal point.
    #[inline]
    pub fn neighbour(&self, point: DVec3, approximation: Approximation) -> Option<Neighbour> {
        let first = self.rays.first_order(point)?;
        self.neighbour_at(&first, self.rays.second_order(&first), approximation)
    }

    /// [`Self::neighbour`] from the orders of its perturbation; `remainder` may be zero where it is not used.
    #[inline]
    pub fn neighbour_at(
        &self,
        first: &FirstOrder,
        remainder: DVec2,
        approximation: Approximation,
    ) -> Option<Neighbour> {
        let FirstOrder { linear, distance, .. } = *first;
        let (flat, parameters) = match approximation {
            Approximation::Nearest => (DVec2::ZERO, DVec2::ZERO),
            Approximation::Linear => (DVec2::ZERO, linear),
            Approximation::Quadratic => (linear, linear + remainder),
        };
        let jet = &self.first;
        let bend = jet.second[0] * (0.5 * flat.x * flat.x)
            + jet.second[1] * (flat.x * flat.y)
            + jet.second[2] * (0.5 * flat.y * flat.y);
        let reflection_point = jet.value + jet.first[0] * parameters.x + jet.first[1] * parameters.y + bend;
        reflection_point.is_finite().then_some(Neighbour { reflection_point, distance, parameters, linear, remainder })
    }

    /// The parameters of the family's ray through a first reflection point, to first order.
    #[inline]
    pub fn parameters_of(&self, reflection_point: DVec3) -> DVec2 {
        let step = reflection_point - self.first.value;
        DVec2::new(self.first.first[0].dot(step), self.first.first[1].dot(step))
    }

    /// The motion of the first reflection point with a scene point that lies on the ray with these parameters, to first
    /// order in them; `None` at a focal point.
    #[inline]
    pub fn motion(&self, distance: f64, z: DVec2) -> Option<Motion> {
        let spread = self.rays.spread_near(distance, z);
        let determinant = spread[0][0] * spread[1][1] - spread[0][1] * spread[1][0];
        let inverse = 1.0 / determinant;
        if !inverse.is_finite() {
            return None;
        }
        let jet = &self.first;
        let tangent = [
            jet.first[0] + jet.second[0] * z.x + jet.second[1] * z.y,
            jet.first[1] + jet.second[1] * z.x + jet.second[2] * z.y,
        ];
        let change = [
            (tangent[0] * spread[1][1] - tangent[1] * spread[1][0]) * inverse,
            (tangent[1] * spread[0][0] - tangent[0] * spread[0][1]) * inverse,
        ];
        let focal_index = self.focal_points_passed + self.rays.focal_points_near(distance, z, determinant);
        Some(Motion { change, across: self.rays.across_near(z), focal_index })
    }

    /// The optical length from the eye to a scene point, to second order in its distance from the ray.
    #[inline]
    pub fn optical_length_to(&self, point: DVec3) -> f64 {
        let relative = point - self.rays.origin;
        let distance = relative.dot(self.rays.direction);
        let bend = self.rays.wavefront_bend(distance, relative);
        // The wavefront bends at least within the distance: beyond that the expansion means nothing.
        let across2 = (relative.length_squared() - distance * distance).max(0.0);
        let limit = 0.5 * across2 / distance.abs().max(1e-12);
        self.optical_length + self.media[self.sites.count] * (distance + bend.clamp(-limit, limit))
    }

    /// The optical length from the eye to a scene point along other bounce points on the same path.
    pub fn optical_length_along(&self, eye: &Eye, sites: &PathSites, point: DVec3) -> f64 {
        let sites = &sites.sites[..sites.count];
        let first = sites.first().map_or(point, |site| site.position);
        let mut sum = match *eye {
            Eye::Point(eye) => self.media[0] * eye.distance(first),
            // Lengths are counted from the plane from which the sample's own length is.
            Eye::Direction(direction) => {
                let before = self.optical_length - self.length_between_bounces();
                before + self.media[0] * (first - self.first.value).dot(direction)
            }
        };
        for (k, pair) in sites.windows(2).enumerate() {
            sum += self.media[k + 1] * pair[0].position.distance(pair[1].position);
        }
        sum + self.media[sites.len()] * sites.last().map_or(0.0, |site| site.position.distance(point))
    }

    /// The optical length from the first bounce to the last.
    fn length_between_bounces(&self) -> f64 {
        let sites = &self.sites.sites[..self.sites.count];
        let lengths = sites.windows(2).map(|pair| pair[0].position.distance(pair[1].position));
        lengths.zip(&self.media[1..]).map(|(length, medium)| length * medium).sum()
    }

    /// The bounce points at other parameters, as a start for the solver; returns `None` if they leave their surfaces.
    pub fn sites_at(&self, surfaces: &SpecularSurfaces<'_>, z: DVec2) -> Option<PathSites> {
        let mut sites = self.sites;
        for index in 0..sites.count {
            let step = match index {
                0 => z,
                _ => {
                    let moved = |jet: &ScalarJet| jet.first[0] * z.x + jet.first[1] * z.y;
                    DVec2::new(moved(&self.moves[index - 1][0]), moved(&self.moves[index - 1][1]))
                }
            };
            sites.sites[index] = surfaces.moved(sites.bounces[index].object, &sites.sites[index], step)?;
        }
        Some(sites)
    }
}

/// A path that a ray has followed so far.
#[derive(Clone)]
struct Followed {
    bundle: RayBundle,
    path: SpecularPath,
    sites: PathSites,
    moves: [[ScalarJet; 2]; MAX_BOUNCES - 1],
    optical_length: f64,
    outside: [bool; MAX_BOUNCES],
    media: [f64; MAX_BOUNCES + 1],
    /// A point a little off the last surface, from which the next ray can start.
    departure: Vec3,
}

/// Arrival of a ray at a specular surface.
struct PathArrival {
    object: u32,
    site: ManifoldVertex,
    patch: SurfacePatch,
    bundle: RayBundle,
    parameters: [ScalarJet; 2],
    length: f64,
}

/// Follows a view ray through all its specular paths and hands each outgoing ray to `found`.
pub fn follow(
    specular: &Specular<'_>,
    eye: &Eye,
    ray: &Ray,
    near: f32,
    found: &mut impl FnMut(SpecularPath, RaySample),
) {
    let Some(hit) = specular.tracer.first_hit(specular.scene, ray, near) else { return };
    let Some((object, site)) = specular.surfaces.site_of(ray, &hit) else { return };
    let Some(patch) = specular.surfaces.patch(object, &site) else { return };
    let Some(bundle) = RayBundle::arriving(eye, &patch) else { return };
    let length = (site.position - ray.origin.as_dvec3()).dot(bundle.direction.value);
    let Some(sites) = PathSites::new(&[]) else { return };
    let start = Followed {
        bundle,
        path: SpecularPath::default(),
        sites,
        moves: Default::default(),
        optical_length: 0.0,
        outside: [true; MAX_BOUNCES],
        media: [1.0; MAX_BOUNCES + 1],
        departure: ray.origin,
    };
    let parameters = RayBundle::own_parameters();
    let mut waiting = vec![(start, PathArrival { object, site, patch, bundle, parameters, length })];
    while let Some((before, arrival)) = waiting.pop() {
        for kind in [BounceKind::Transmit, BounceKind::Reflect] {
            let Some(followed) = bounce(specular, &before, &arrival, kind) else { continue };
            let Some(rays) = OutgoingRays::new(&followed.bundle) else { continue };
            found(
                followed.path.clone(),
                RaySample {
                    first: followed.bundle.first,
                    rays,
                    sites: followed.sites,
                    moves: followed.moves,
                    optical_length: followed.optical_length,
                    media: followed.media,
                    focal_points_passed: followed.bundle.focal_points_passed,
                    outside: followed.outside,
                },
            );
            if followed.sites.count < (specular.order as usize).min(MAX_BOUNCES)
                && let Some(next) = arrive(specular, &followed)
            {
                waiting.push((followed, next));
            }
        }
    }
}

/// The path after one more bounce; returns `None` if there is no such bounce.
fn bounce(specular: &Specular<'_>, before: &Followed, arrival: &PathArrival, kind: BounceKind) -> Option<Followed> {
    let cosine = arrival.bundle.direction.value.dot(arrival.patch.normal);
    let scattering = Scattering::new(specular, arrival.object, cosine, before.media[before.sites.count])?;
    let medium = scattering.medium_after(kind)?;
    let index = scattering.index;
    let bundle = arrival.bundle.scattered(&arrival.patch, &arrival.parameters, kind, index)?;
    let mut after = before.clone();
    let count = after.sites.count;
    let bounce = Bounce { object: arrival.object, kind };
    after.path.bounces.push(bounce);
    after.sites.bounces[count] = bounce;
    after.sites.sites[count] = arrival.site;
    after.sites.count = count + 1;
    after.outside[count] = scattering.outside;
    if count > 0 {
        after.moves[count - 1] = arrival.parameters;
    }
    after.media[count] = scattering.crossed;
    after.optical_length += scattering.crossed * arrival.length;
    after.media[count + 1] = medium;
    after.bundle = bundle;
    let patch = &arrival.patch;
    after.departure = departure(patch.position, patch.tangents[0].cross(patch.tangents[1]), bundle.direction.value);
    Some(after)
}

/// Arrival of a path's outgoing ray at the next specular surface.
fn arrive(specular: &Specular<'_>, followed: &Followed) -> Option<PathArrival> {
    let direction = followed.bundle.direction.value;
    let ray = Ray { origin: followed.departure, direction: direction.as_vec3().normalize() };
    let hit = specular.tracer.first_hit(specular.scene, &ray, 0.0)?;
    let (object, site) = specular.surfaces.site_of(&ray, &hit)?;
    let last = followed.sites.count - 1;
    if is_spurious(specular.surfaces, followed.sites.bounces[last], followed.outside[last], object) {
        return None;
    }
    let patch = specular.surfaces.patch(object, &site)?;
    let length = (site.position - followed.bundle.origin.value).dot(direction);
    let (bundle, parameters) = followed.bundle.advanced(&patch)?;
    Some(PathArrival { object, site, patch, bundle, parameters, length })
}
