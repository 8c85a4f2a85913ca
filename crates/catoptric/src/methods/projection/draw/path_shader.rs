//! Colours of what is seen directly and at the ends of specular paths.

use super::MapsInView;
use crate::light::reflector_shader::ReflectorShader;
use crate::methods::reflector_maps::ReflectorMaps;
use crate::optics::path::bundle::BounceKind;
use crate::optics::step::{Deferred, LightStep, crossed_medium, medium_after, transmittance};
use crate::raster::{Fragment, LayerSurface, LookShader, ShadingRequest};
use crate::scene::shade::SurfacePoint;
use crate::scene::{Ray, RayDifferential, Role, Scene, View, ViewRays};
use glam::{Vec2, Vec3};

/// Shorter segments than this share of the coordinates' size have no direction of their own: it is lost in rounding.
/// Chosen, not measured.
const SHORT: f32 = 1e-4;

/// A place in a triangle's plane belongs to it up to this far beside it, in sizes of the triangle: pictures are off by
/// parts of a pixel. Chosen, not measured.
const BESIDE: f32 = 3.0;

/// Walks along the surfaces that a fragment shows.
///
/// Triangles of reflectors and lenses at which paths go on have groups other than 0; those of group 0 are black, but
/// for what they scatter themselves. A mirror whose reflection fades with distance waits for the next surface. Where
/// nothing is seen at the end of a path the environment is.
pub(in crate::methods::projection) struct PathShader<'a> {
    scene: &'a Scene,
    rays: ViewRays,
    /// Reflectors with maps of all look these up, after fewer bounces than the order.
    maps: MapsInView<'a>,
    order: usize,
}

impl<'a> PathShader<'a> {
    /// A shader for paths from the eye of a view.
    pub(in crate::methods::projection) fn new(scene: &'a Scene, view: &View) -> Self {
        Self { scene, rays: view.rays(), maps: MapsInView::default(), order: 0 }
    }

    /// The same with environment maps, for pictures of an order.
    pub(super) fn with_maps(self, maps: MapsInView<'a>, order: u32) -> Self {
        Self { maps, order: order as usize, ..self }
    }

    /// Colour of a reflector with an environment map. Rarely needed: kept out of the walk.
    #[inline(never)]
    fn mapped(
        &self,
        maps: &ReflectorMaps,
        fragment: &Fragment<'_>,
        surface: &LayerSurface,
        ray: &Ray,
        bounce: usize,
    ) -> Vec3 {
        // How reflected rays differ from pixel to pixel is not known here: what they meet is not filtered.
        let change = match bounce {
            0 => self.rays.ray_with_differential(fragment.position.x, fragment.position.y).1,
            _ => RayDifferential::default(),
        };
        let encounter = self.scene.drawn_encounter(surface.source, &surface.barycentrics, ray, &change);
        maps.radiance(self.scene, &encounter, ray, &change)
    }

    /// The radiance from a direction behind all that a fragment shows.
    #[inline]
    fn behind(&self, fragment: &Fragment<'_>, direction: Vec3) -> Vec3 {
        let Some(last) = fragment.chain.last() else { return self.scene.background(direction) };
        if let Some(far) = self.maps.far {
            let reflector = self.scene.triangle_objects[last.source as usize];
            return far.behind(self.scene, reflector, direction, || self.change_behind(fragment));
        }
        match &self.scene.environment {
            // The fragment stands for several samples, whose directions differ.
            Some(environment) if last.barycentrics.samples > 1 => {
                let change = self.change_behind(fragment);
                environment.radiance_over(direction, [change.direction_dx, change.direction_dy])
            }
            _ => self.scene.background(direction),
        }
    }

    /// The change from pixel to pixel of the ray that leaves the last surface of a fragment.
    fn change_behind(&self, fragment: &Fragment<'_>) -> RayDifferential {
        let scene = self.scene;
        let (mut ray, mut change) = self.rays.ray_with_differential(fragment.position.x, fragment.position.y);
        for (bounce, surface) in fragment.chain.iter().enumerate() {
            let surface = &mut { *surface };
            if bounce > 0 {
                meet_known_surface(scene, &mut ray, surface);
            }
            let encounter = scene.drawn_encounter(surface.source, &surface.barycentrics, &ray, &change);
            let step = LightStep::at(scene, scene.material_of(encounter.point.object), &encounter.point, ray.direction);
            let refracts = fragment.second_branches >> bounce & 1 != 0;
            let kind = if refracts { BounceKind::Transmit } else { BounceKind::Reflect };
            let Some(direction) = step.outgoing(kind, ray.direction) else { break };
            change = step.outgoing_change(kind, ray.direction, &change, &encounter);
            ray = Ray { origin: encounter.point.position, direction };
        }
        change
    }

    /// Distance of the surface at the end of a segment from its start. Rarely needed: kept out of the walk.
    #[inline(never)]
    fn distance(&self, ray: &Ray, surface: &LayerSurface) -> f32 {
        length(ray, &self.scene.drawn_point(surface.source, &surface.barycentrics, ray))
    }
}

/// Brings a ray from the last bounce and the surface that is known to show at its end together: the ray is exact, the
/// place on the surface is that of a picture. The place is moved to where the ray meets the triangle's plane; where
/// that is far beside the triangle, or there is no such place, the ray is turned to the surface.
///
/// Turning the ray would do elsewhere, too, but not within thin walls of glass, where an error of half a pixel is a
/// large angle.
#[inline]
pub(in crate::methods::projection) fn meet_known_surface(scene: &Scene, ray: &mut Ray, surface: &mut LayerSurface) {
    let is_near = |at: &Vec2| at.min_element() >= -BESIDE && at.max_element() <= 1.0 + BESIDE;
    match scene.plane_met(surface.source, ray).filter(|(at, distance)| *distance > 0.0 && is_near(at)) {
        Some((at, _)) => surface.barycentrics.value = at,
        None => aim(scene, ray, surface),
    }
}

/// Turns a ray from the last bounce towards the surface that is seen at its end.
#[inline(always)] // for the instructions of its caller
fn aim(scene: &Scene, ray: &mut Ray, surface: &LayerSurface) {
    let position = scene.position_on(surface.source, surface.barycentrics.value);
    let step = position - ray.origin;
    let length = step.length();
    if length > SHORT * position.abs().max_element() {
        ray.direction = step / length;
    }
}

/// The distance from the start of a segment to its end.
#[inline]
fn length(ray: &Ray, point: &SurfacePoint) -> f32 {
    (point.position - ray.origin).length()
}

impl LookShader for PathShader<'_> {
    fn scene(&self) -> &Scene {
        self.scene
    }

    #[inline(always)] // for the instructions of its caller
    fn look(&self, fragment: &Fragment<'_>) -> ShadingRequest {
        let scene = self.scene;
        let mut ray = self.rays.ray(fragment.position.x, fragment.position.y);
        let (mut sum, mut throughput, mut absorption) = (Vec3::ZERO, Vec3::ONE, Vec3::ZERO);
        let mut deferred: Option<Deferred> = None;
        for (bounce, surface) in fragment.chain.iter().enumerate() {
            let surface = &mut { *surface };
            let object = scene.triangle_objects[surface.source as usize];
            let material = scene.material_of(object);
            if bounce > 0 {
                match material.role {
                    Role::Diffuse => aim(scene, &mut ray, surface),
                    _ => meet_known_surface(scene, &mut ray, surface),
                }
            }
            if let Some(waiting) = deferred.take() {
                let (own, weight) = waiting.settled(self.distance(&ray, surface));
                sum += own;
                throughput *= weight;
            }
            let maps = self.maps.whole.filter(|maps| bounce < self.order && maps.has(object));
            if absorption != Vec3::ZERO && (material.role == Role::Diffuse || maps.is_some()) {
                throughput *= transmittance(
                    absorption,
                    length(&ray, &scene.drawn_point(surface.source, &surface.barycentrics, &ray)),
                );
            }
            if material.role == Role::Diffuse {
                return ShadingRequest::of_diffuse(scene, surface, &ray, throughput, sum);
            }
            if let Some(maps) = maps {
                return ShadingRequest::Color(sum + throughput * self.mapped(maps, fragment, surface, &ray, bounce));
            }
            let ends = surface.group == 0;
            if ends && material.role != Role::Coated && material.blend.is_none() {
                return ShadingRequest::Color(sum);
            }
            // What comes next on the path is known: a mirror's exact place would add nothing to it, but to its weights.
            let goes_on = bounce + 1 < fragment.chain.len();
            let plain = material.role == Role::Reflector && material.blend.is_none();
            let approximately = goes_on && plain && !scene.objects[object as usize].inside;
            let point = match approximately {
                true => scene.surface_point(surface.source, &surface.barycentrics),
                false => scene.drawn_point(surface.source, &surface.barycentrics, &ray),
            };
            let step = LightStep::at(scene, material, &point, ray.direction);
            absorption =
                crossed_medium(material.role == Role::Lens, step.facing.outside, material.absorption, absorption);
            throughput *= transmittance(absorption, length(&ray, &point));
            // What is scattered before the last second branch belongs to the fragment that takes the first one there.
            let scatters = step.scattered > 0.0 && fragment.second_branches >> bounce == 0;
            if step.attenuation.is_some() && !ends {
                let share = if scatters { throughput } else { Vec3::ZERO };
                deferred = step.deferred(share * scene.own_radiance(&point, -ray.direction));
            } else if scatters {
                sum += throughput * step.scattered * scene.own_radiance(&point, -ray.direction);
            }
            let refracts = fragment.second_branches >> bounce & 1 != 0;
            let kind = if refracts { BounceKind::Transmit } else { BounceKind::Reflect };
            throughput *= step.weight(kind);
            if ends || (throughput.max_element() <= 0.0 && deferred.is_none()) {
                return ShadingRequest::Color(sum);
            }
            absorption = medium_after(kind, step.facing.outside, material.absorption, absorption, Vec3::ZERO);
            let Some(direction) = step.outgoing(kind, ray.direction) else { return ShadingRequest::Color(sum) };
            ray = Ray { origin: point.position, direction };
        }
        if let Some(waiting) = deferred {
            let (own, weight) = waiting.settled(f32::INFINITY);
            sum += own;
            throughput *= weight;
        }
        ShadingRequest::Color(sum + throughput * self.behind(fragment, ray.direction))
    }

    fn eye(&self) -> Option<&ViewRays> {
        Some(&self.rays)
    }
}
