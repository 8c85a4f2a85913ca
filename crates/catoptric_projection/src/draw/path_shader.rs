//! Colours of surfaces that are seen directly and at the ends of specular paths.

use super::drawn_by::{PixelsByOthers, ReflectorPixels};
use super::far_maps::MapsInView;
use super::lobe_lights::LobeLights;
use super::mesh_neighbours::{BESIDE, MeshNeighbours};
use super::rough::RoughReflections;
use catoptric_core::scene::shade::SurfacePoint;
use catoptric_core::scene::{Environment, Material, Ray, RayDifferential, Role, Scene, View, ViewRays};
use catoptric_engine::light::reflector_shader::ReflectorShader;
use catoptric_engine::light::tracer::Tracer;
use catoptric_engine::method::Report;
use catoptric_engine::method::reflector_maps::ReflectorMaps;
use catoptric_engine::optics::path::bundle::BounceKind;
use catoptric_engine::optics::step::{Deferred, LightStep, crossed_medium, medium_after, transmittance};
use catoptric_engine::raster::{Fragment, FragmentBatch, LayerSurface, LookShader, ShadingRequest};
use glam::{Vec2, Vec3};
use std::borrow::Cow;
use std::sync::atomic::{AtomicU64, Ordering};

/// Shorter segments than this share of the coordinates' size have no direction of their own: it is lost in rounding.
/// Chosen, not measured.
const SHORT: f32 = 1e-4;

/// A place in a triangle's plane at a path's end belongs to it up to this far beside it, in sizes of the triangle:
/// beyond, textures may show what belongs to others. Chosen, not measured.
const HARDLY_BESIDE: f32 = 0.1;

/// The change of direction within a part of a pixel above which directions are followed from four places in it, because
/// they change unevenly. Chosen between time and error: a fifth of it takes a mirrored bunny under a studio's lights
/// from 0.5 to 0.4 % of wrong pixels in 1.5 times the time.
const EVEN_CHANGE: f32 = 0.1;

/// Refracted rays with a smaller cosine to the normal change quickly: there a fragment is shaded at several places.
/// Chosen, not measured.
const STEEP_COSINE: f32 = 0.1;

/// The difference of colour between a fragment's quarters below which more places would not improve the mean.
const EVEN_COLOR: f32 = 0.02;

/// The light of a fragment, gathered along its path up to a rough mirror.
struct RoughWalk {
    /// The colour so far.
    sum: Vec3,
    /// The factor of the light from the rest of the path.
    throughput: Vec3,
    deferred: Option<Deferred>,
    /// The factor by which the footprints of textures at the path's end are widened.
    widening: f32,
    /// The colour before a rough mirror on the path, and the light that its grid of sharp rays adds.
    blurred: Option<(Vec3, Vec3)>,
}

impl RoughWalk {
    /// Adds the blurred light of a mirror or lens (an object at a bounce) by an event, which has a factor: 0 where
    /// another fragment of the same event adds it. False if nothing follows. Without the light of a mirror on the way
    /// nothing is added, and [`Self::blurred`] stays `None`.
    #[inline(never)] // rarely needed: kept out of the walk
    fn meet(
        &mut self,
        rough: &RoughReflections<'_>,
        (object, bounce): (u32, usize),
        position: Vec2,
        (kind, weight): (BounceKind, Vec3),
    ) -> bool {
        if let Some((before, sharp)) = self.blurred {
            // The mirror is seen in another rough mirror, whose sharp rays already have its light.
            self.sum = before + sharp;
            return false;
        }
        let light = if bounce == 0 { rough.at(object, position) } else { None };
        let Some(light) = light else { return true };
        let mut attenuation = 1.0;
        if let Some(waiting) = self.deferred.take() {
            let own;
            (own, attenuation) = waiting.settled(light.distance);
            self.sum += own;
        }
        let factor = self.throughput * light.share * attenuation;
        let mean = if kind == BounceKind::Transmit { light.refracted } else { light.radiance };
        self.sum += factor * weight * mean;
        let rest = 1.0 - light.weight;
        self.throughput = factor * rest;
        // Light that bumps spread is traced at the surface where it meets a rough mirror.
        let sharp = self.throughput * weight * light.sharp;
        self.blurred = rough.is_rough(object).then_some((self.sum, sharp));
        // Textures are blurred by the lobe; edges are not.
        self.widening *= (1.0 + light.width_px * light.width_px).sqrt();
        rest > 0.0
    }
}

/// A square part of a fragment: its middle, from the fragment's position, and its side, in pixels.
#[derive(Clone, Copy, Debug)]
pub(super) struct Part {
    pub(super) offset: Vec2,
    pub(super) side: f32,
}

impl Part {
    /// The part of a whole pixel that one of its samples stands for.
    pub(super) fn at_sample(self, positions: &[Vec2], index: usize) -> Self {
        let side = self.side / (positions.len() as f32).sqrt();
        Self { offset: self.offset + (positions[index] - 0.5) * self.side, side }
    }

    pub(super) fn quarters(self) -> [Self; 4] {
        let quarter =
            |x: f32, y: f32| Self { offset: self.offset + Vec2::new(x, y) * (0.25 * self.side), side: 0.5 * self.side };
        [quarter(-1.0, -1.0), quarter(1.0, -1.0), quarter(-1.0, 1.0), quarter(1.0, 1.0)]
    }
}

/// The factor of blurred light by an event at a bounce, in a fragment: where light divides again later on, the fragment
/// that takes the first ways there has all of it.
fn blurred_weight(fragment: &Fragment<'_>, bounce: usize, step: &LightStep, kind: BounceKind) -> Vec3 {
    if fragment.second_branches >> (bounce + 1) == 0 { step.weight(kind) } else { Vec3::ZERO }
}

/// True if a ray meets a lens from within near the angle of total reflection.
#[inline(always)]
fn is_steep_at(step: &LightStep, direction: Vec3) -> bool {
    let cosine = direction.dot(step.facing.normal);
    let refracted_cosine2 = 1.0 - step.eta * step.eta * (1.0 - cosine * cosine);
    (step.eta > 1.0) & (refracted_cosine2.abs() < STEEP_COSINE * STEEP_COSINE)
}

/// Walks along the surfaces that a fragment shows.
///
/// Triangles of reflectors and lenses at which paths go on have groups other than 0; those of group 0 are black, but
/// for the light that they scatter themselves. A mirror whose reflection fades with distance waits for the next
/// surface. Where nothing is seen at the end of a path the environment is.
pub(crate) struct PathShader<'a> {
    pub(super) scene: &'a Scene,
    pub(super) rays: ViewRays,
    /// Reflectors with maps of all look these up, after fewer bounces than the order.
    maps: MapsInView<'a>,
    order: usize,
    /// Samples a pixel.
    pub(super) samples: u32,
    /// The neighbours of triangles, where a picture's edges are off by parts of a pixel.
    neighbours: Option<&'a MeshNeighbours>,
    /// Normal maps turn rays.
    turns_normals: bool,
    /// The reflections of rough mirrors; `None`: they are drawn as smooth ones.
    rough: Option<&'a RoughReflections<'a>>,
    /// The tracer of rays over the lobes of surfaces at the ends of paths, and the order of the picture; `None`: such
    /// surfaces are drawn with the shading of their microfacets alone.
    pub(super) lobes: Option<(&'a Tracer, u32)>,
    /// The light over lobes that are seen directly.
    pub(super) lobe_lights: Option<&'a LobeLights>,
    /// Paths that ended at the highest order.
    ended: AtomicU64,
    reflector_pixels: ReflectorPixels,
}

impl<'a> PathShader<'a> {
    /// A shader for paths from the eye of a view, for pictures with so many samples a pixel.
    pub(crate) fn new(scene: &'a Scene, view: &View, samples: u32) -> Self {
        Self {
            scene,
            rays: view.rays(),
            maps: MapsInView::default(),
            order: 0,
            samples,
            neighbours: None,
            turns_normals: false,
            rough: None,
            lobes: None,
            lobe_lights: None,
            ended: AtomicU64::new(0),
            reflector_pixels: ReflectorPixels::default(),
        }
    }

    /// This shader with environment maps, for pictures of an order.
    pub(super) fn with_maps(self, maps: MapsInView<'a>, order: u32) -> Self {
        Self { maps, order: order as usize, ..self }
    }

    /// This shader for pictures whose surfaces may be neighbours of those that rays meet.
    pub(super) fn with_neighbours(self, neighbours: &'a MeshNeighbours) -> Self {
        Self { neighbours: Some(neighbours), ..self }
    }

    /// This shader for paths whose rays may have been turned by normal maps.
    pub(super) fn with_turned_normals(self, turns_normals: bool) -> Self {
        Self { turns_normals, ..self }
    }

    /// This shader with the light of rough mirrors.
    pub(super) fn with_rough(self, rough: Option<&'a RoughReflections<'a>>) -> Self {
        Self { rough, ..self }
    }

    /// This shader with rays that sample lobes, for pictures of an order.
    pub(super) fn with_lobes(self, tracer: Option<&'a Tracer>, order: u32) -> Self {
        Self { lobes: tracer.map(|tracer| (tracer, order)), ..self }
    }

    /// This shader with the known light over lobes that are seen directly.
    pub(super) fn with_lobe_lights(self, lobe_lights: Option<&'a LobeLights>) -> Self {
        Self { lobe_lights, ..self }
    }

    /// Adds to a picture's report the number of paths that ended at the highest order while they carried light that is
    /// seen (one a fragment at reflectors, one a ray beyond surfaces with lobes), and the numbers of pixels of
    /// reflectors by the way in which they were drawn.
    pub(crate) fn describe(&self, by_others: PixelsByOthers, report: &mut Report) {
        report.counts.insert("paths_ended", self.ended.load(Ordering::Relaxed));
        self.reflector_pixels.describe(by_others, report);
    }

    pub(super) fn note_ended(&self, count: u64) {
        if count > 0 {
            self.ended.fetch_add(count, Ordering::Relaxed);
        }
    }

    /// Returns true if rays follow a lens that is met after some bounces: no list or tile goes on from it, though the
    /// order allows for more bounces.
    #[inline(always)] // for the instructions of its caller
    fn follows_lens(&self, material: &Material, surface: &LayerSurface, bounce: usize) -> bool {
        let goes_on = || self.lobes.is_some_and(|(_, order)| order > bounce as u32);
        material.role == Role::Lens && surface.group == 0 && goes_on()
    }

    /// Returns true if the rays of a whole pixel follow the lens at the end of a fragment's chain.
    fn is_lens_followed(&self, fragment: &Fragment<'_>) -> bool {
        let Some(last) = fragment.chain.last() else { return false };
        let material = self.scene.material_of(self.scene.triangle_objects[last.source as usize]);
        last.barycentrics.samples == self.samples && self.follows_lens(material, last, fragment.chain.len() - 1)
    }

    /// The appearance of a fragment whose path ends on a diffuse surface, or on a lens that rays follow, after some
    /// bounces: the sum so far, and the factor of the surface's radiance.
    #[inline(always)] // for the instructions of its caller
    fn end(
        &self,
        fragment: &Fragment<'_>,
        (surface, bounce): (&LayerSurface, usize),
        (ray, part): (&Ray, Part),
        (sum, throughput): (Vec3, Vec3),
    ) -> ShadingRequest {
        let material = self.scene.material_of(self.scene.triangle_objects[surface.source as usize]);
        match self.lobes.filter(|_| material.lobes().is_some() || material.role == Role::Lens) {
            Some(lobes) => {
                let light = match bounce {
                    0 => self.followed(lobes, fragment, part),
                    _ => self.followed_on(lobes, (surface, bounce), ray),
                };
                ShadingRequest::Color(sum + throughput * light)
            }
            None => ShadingRequest::of_diffuse(self.scene, surface, ray, throughput, sum),
        }
    }

    /// Colour of a rough mirror that is seen after some bounces, or whose light is not known.
    #[inline(never)] // rarely needed: kept out of the walk
    fn traced(&self, rough: &RoughReflections<'_>, surface: &LayerSurface, ray: &Ray, bounce: usize) -> Vec3 {
        // The differential of the ray is not known here.
        let change = RayDifferential::default();
        let encounter = self.scene.drawn_encounter(surface.source, &surface.barycentrics, ray, &change);
        rough.traced(bounce as u32, *ray, change, &encounter)
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
        // The differentials of reflected rays are not known here: textures that they meet are not filtered.
        let change = match bounce {
            0 => self.rays.ray_with_differential(fragment.position.x, fragment.position.y).1,
            _ => RayDifferential::default(),
        };
        let encounter = self.scene.drawn_encounter(surface.source, &surface.barycentrics, ray, &change);
        maps.radiance(self.scene, &encounter, ray, &change)
    }

    /// The radiance from a direction behind all that a fragment shows.
    #[inline]
    fn behind(&self, fragment: &Fragment<'_>, direction: Vec3, part: Part) -> Vec3 {
        let Some(last) = fragment.chain.last() else {
            return self.scene.background_seen(direction);
        };
        if let Some(far) = self.maps.far {
            let reflector = self.scene.triangle_objects[last.source as usize];
            return far.behind(self.scene, reflector, direction, || self.departure(fragment, Vec2::ZERO).1);
        }
        match &self.scene.environment {
            // The fragment stands for several samples, whose directions differ.
            Some(environment) if last.barycentrics.samples > 1 => self.environment_over(environment, fragment, part),
            _ => self.scene.background(direction),
        }
    }

    /// The side of the part of a pixel that a fragment stands for, in pixels.
    #[inline]
    pub(super) fn side(&self, fragment: &Fragment<'_>) -> f32 {
        let weight = fragment.chain.last().map_or(1, |last| last.barycentrics.samples);
        (weight as f32 / self.samples.max(1) as f32).min(1.0).sqrt()
    }

    /// The environment over a part of a pixel that shows a fragment.
    fn environment_over(&self, environment: &Environment, fragment: &Fragment<'_>, part: Part) -> Vec3 {
        let side = part.side;
        let over = |(direction, change): (Vec3, RayDifferential), side: f32| {
            environment.radiance_over(direction, [change.direction_dx * side, change.direction_dy * side])
        };
        let whole = self.departure(fragment, part.offset);
        let largest = whole.1.direction_dx.length_squared().max(whole.1.direction_dy.length_squared());
        // False if it is not a number.
        if largest * side * side > EVEN_CHANGE * EVEN_CHANGE {
            let of_quarter = |part: Part| over(self.departure(fragment, part.offset), part.side);
            return part.quarters().into_iter().map(of_quarter).sum::<Vec3>() * 0.25;
        }
        over(whole, side)
    }

    /// The ray that leaves the last surface of a fragment at a distance (in pixels) from its position: its direction,
    /// and its change from pixel to pixel.
    fn departure(&self, fragment: &Fragment<'_>, offset: Vec2) -> (Vec3, RayDifferential) {
        let scene = self.scene;
        let position = fragment.position + offset;
        let (mut ray, mut change) = self.rays.ray_with_differential(position.x, position.y);
        for (bounce, surface) in fragment.chain.iter().enumerate() {
            let surface = &mut { *surface };
            if bounce > 0 || offset != Vec2::ZERO {
                meet_known_surface(scene, self.neighbours, &mut ray, surface);
            }
            let encounter = scene.drawn_encounter(surface.source, &surface.barycentrics, &ray, &change);
            let material = scene.material_of(encounter.point.object);
            let encounter = match self.turns_normals {
                true => scene.turned_encounter(material, &encounter).encounter,
                false => Cow::Borrowed(&encounter),
            };
            let step = LightStep::at(scene, material, &encounter.point, ray.direction);
            let kind = BounceKind::at(bounce, fragment.second_branches);
            let Some(direction) = step.outgoing(kind, ray.direction) else { break };
            change = step.outgoing_change(kind, ray.direction, &change, &encounter);
            ray = Ray { origin: encounter.point.position, direction };
        }
        (ray.direction, change)
    }

    /// Brings a ray and the surface that it shows together; `is_seen_there`: at the fragment's own position.
    #[inline(always)] // for the instructions of its caller
    fn meet(&self, role: Role, is_seen_there: bool, ray: &mut Ray, surface: &mut LayerSurface) {
        match (role, self.neighbours) {
            // The fragment's position may lie beyond the edge of the triangle that a sample shows.
            (Role::Reflector | Role::Coated | Role::Lens, Some(neighbours)) if is_seen_there => {
                neighbours.meet_seen(self.scene, ray, surface);
            }
            _ if is_seen_there => {}
            (Role::Diffuse, _) => meet_hardly_beside(self.scene, ray, surface),
            (_, neighbours) => meet_known_surface(self.scene, neighbours, ray, surface),
        }
    }

    /// The appearance of a part of a fragment; `is_steep` becomes true if it may change much within.
    #[inline(always)] // for the instructions of its caller
    fn walk(&self, fragment: &Fragment<'_>, part: Part, is_steep: &mut bool) -> ShadingRequest {
        let scene = self.scene;
        let position = fragment.position + part.offset;
        let mut ray = self.rays.ray(position.x, position.y);
        let (mut sum, mut throughput, mut absorption) = (Vec3::ZERO, Vec3::ONE, Vec3::ZERO);
        let mut deferred: Option<Deferred> = None;
        let mut widening = 1.0;
        let mut blurred = None;
        for (bounce, surface) in fragment.chain.iter().enumerate() {
            let surface = &mut { *surface };
            let object = scene.triangle_objects[surface.source as usize];
            let material = scene.material_of(object);
            self.meet(material.role, bounce == 0 && part.offset == Vec2::ZERO, &mut ray, surface);
            if let Some(waiting) = deferred.take() {
                let (own, weight) = waiting.settled(self.distance(&ray, surface));
                sum += own;
                throughput *= weight;
            }
            let maps = self.maps.whole.filter(|maps| bounce < self.order && maps.has(object));
            if absorption != Vec3::ZERO && (material.role == Role::Diffuse || maps.is_some()) {
                throughput *= transmittance(absorption, self.distance(&ray, surface));
            }
            if material.role == Role::Diffuse || self.follows_lens(material, surface, bounce) {
                surface.barycentrics = surface.barycentrics.widened(widening);
                return self.end(fragment, (surface, bounce), (&ray, part), (sum, throughput));
            }
            if let Some(maps) = maps {
                return ShadingRequest::Color(sum + throughput * self.mapped(maps, fragment, surface, &ray, bounce));
            }
            let ends = surface.group == 0;
            self.note_ended(u64::from(ends));
            if ends && !material.has_own_light() && !scene.ends_in_environment {
                return ShadingRequest::Color(sum);
            }
            let point = self.point(bounce, surface, material, &ray, (position, part.side));
            let normal = if self.turns_normals { scene.turned_normal(material, &point) } else { point.normal };
            let step = LightStep::with_normal(scene, material, &point, normal, ray.direction);
            absorption =
                crossed_medium(material.role == Role::Lens, step.facing.outside, material.absorption, absorption);
            throughput *= transmittance(absorption, length(&ray, &point));
            let (before, shown) = (sum, throughput);
            *is_steep |= material.role == Role::Lens && is_steep_at(&step, ray.direction);
            // Light scattered before the last second branch belongs to the fragment that takes the first branch there.
            let is_first_way = fragment.second_branches >> bounce == 0;
            let scatters = step.scattered > 0.0 && is_first_way;
            if is_first_way {
                sum += throughput * self.far_light(material, &step, &point, ray.direction, ends);
            }
            if step.attenuation.is_some() && !ends {
                let share = if scatters { throughput } else { Vec3::ZERO };
                deferred = step.deferred(share * scene.own_radiance(&point, -ray.direction));
            } else if scatters {
                sum += throughput * step.scattered * scene.own_radiance(&point, -ray.direction);
            }
            let kind = BounceKind::at(bounce, fragment.second_branches);
            // Blur by bumps within a pixel is known of mirrors and lenses that are seen directly.
            let is_rough = material.reflection_roughness() > 0.0;
            let may_be_rough = is_rough || bounce == 0 && material.may_spread_light();
            if let Some(rough) = self.rough.filter(|_| !ends && may_be_rough) {
                let mut walked = RoughWalk { sum, throughput, deferred, widening, blurred };
                let weight = blurred_weight(fragment, bounce, &step, kind);
                if !walked.meet(rough, (object, bounce), position, (kind, weight)) {
                    return ShadingRequest::Color(walked.sum);
                }
                if is_rough && walked.blurred.is_none() {
                    return ShadingRequest::Color(before + shown * self.traced(rough, surface, &ray, bounce));
                }
                RoughWalk { sum, throughput, deferred, widening, blurred } = walked;
            }
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
        ShadingRequest::Color(sum + throughput * self.behind(fragment, ray.direction, part))
    }

    /// The light of a reflector or lens that comes without a further surface: highlights of lights, and where a path
    /// ends the light from infinity.
    #[inline(always)] // for the instructions of its caller
    fn far_light(
        &self,
        material: &Material,
        step: &LightStep,
        point: &SurfacePoint,
        incoming: Vec3,
        ends: bool,
    ) -> Vec3 {
        let scene = self.scene;
        let highlights = if material.has_own_light() { scene.highlights(point, -incoming) } else { Vec3::ZERO };
        match ends && scene.ends_in_environment {
            true => highlights + step.background(scene, incoming, material.facets_alpha(0.0)),
            false => highlights,
        }
    }

    /// The point of a reflector or lens that is met after some bounces, by a part of a pixel at a position.
    ///
    /// Highlights are wider the more the surface bends within the part. Triangles give the bend; formulas give it for
    /// directly visible surfaces, from the differentials of rays.
    #[inline(always)] // for the instructions of its caller
    fn point(
        &self,
        bounce: usize,
        surface: &LayerSurface,
        material: &Material,
        ray: &Ray,
        (position, side): (Vec2, f32),
    ) -> SurfacePoint {
        let object = self.scene.triangle_objects[surface.source as usize];
        let is_formula = self.scene.objects[object as usize].surface.is_some();
        if bounce == 0 && is_formula && material.highlight_roughness().is_some() {
            let change = self.rays.ray_with_differential(position.x, position.y).1.scaled(side);
            return self.scene.drawn_encounter(surface.source, &surface.barycentrics, ray, &change).point;
        }
        self.scene.drawn_point(surface.source, &surface.barycentrics, ray)
    }

    /// The mean appearance of a fragment's parts, of which one in the middle is `seen`.
    #[inline(never)] // rarely needed: kept out of the walk
    fn look_at_parts(&self, fragment: &Fragment<'_>, whole: Part, seen: ShadingRequest) -> ShadingRequest {
        let mut query = match seen {
            ShadingRequest::Scattered { query, .. } => Some(query),
            ShadingRequest::Color(_) => None,
        };
        // The light of the parts themselves, and the share of the light scattered at the end.
        let mut look = |part: Part| match self.walk(fragment, part, &mut false) {
            ShadingRequest::Color(color) => (color, Vec3::ZERO),
            ShadingRequest::Scattered { query: found, throughput, added } => {
                query.get_or_insert(found);
                (added, throughput)
            }
        };
        let quarters = whole.quarters();
        let of_quarters = quarters.map(&mut look);
        let mut low = of_quarters[0];
        let mut high = low;
        for (added, throughput) in of_quarters {
            low = (low.0.min(added), low.1.min(throughput));
            high = (high.0.max(added), high.1.max(throughput));
        }
        let differs = (high.0 - low.0).max_element().max((high.1 - low.1).max_element()) > EVEN_COLOR;
        let mean = |parts: [(Vec3, Vec3); 4]| {
            let sum = parts.iter().fold((Vec3::ZERO, Vec3::ZERO), |sum, part| (sum.0 + part.0, sum.1 + part.1));
            (sum.0 * 0.25, sum.1 * 0.25)
        };
        // With more places than samples this would be nearer to the truth than the reference.
        let samples = fragment.chain.last().map_or(1, |last| last.barycentrics.samples);
        let (added, throughput) = match differs && samples > 4 {
            true => mean(quarters.map(|quarter| mean(quarter.quarters().map(&mut look)))),
            false => mean(of_quarters),
        };
        match query {
            Some(query) => ShadingRequest::Scattered { query, throughput, added },
            None => ShadingRequest::Color(added),
        }
    }

    /// Distance of the surface at the end of a segment from its start. Rarely needed: kept out of the walk.
    #[inline(never)]
    fn distance(&self, ray: &Ray, surface: &LayerSurface) -> f32 {
        length(ray, &self.scene.drawn_point(surface.source, &surface.barycentrics, ray))
    }
}

/// Brings a ray from the last bounce and the surface that is known to show at its end together: the ray is exact, the
/// place on the surface is that of a picture. The place is moved to where the ray meets the surface, also in another
/// triangle if neighbours are known, or else the triangle's plane; where that is far beside the triangle, or there is
/// no such place, the ray is turned to the surface.
///
/// Turning the ray would do elsewhere, too, but not within thin walls of glass, where an error of half a pixel is a
/// large angle; and where rays go on from beyond a triangle's edge they may start without the wall.
#[inline(always)] // for the instructions of its caller
pub(super) fn meet_known_surface(
    scene: &Scene,
    neighbours: Option<&MeshNeighbours>,
    ray: &mut Ray,
    surface: &mut LayerSurface,
) {
    if !neighbours.is_some_and(|neighbours| neighbours.meet(scene, ray, surface)) {
        meet_near(scene, ray, surface, BESIDE);
    }
}

/// Brings a ray and the surface at its end together, which may be seen a little beside the triangle.
pub(super) fn meet_hardly_beside(scene: &Scene, ray: &mut Ray, surface: &mut LayerSurface) {
    meet_near(scene, ray, surface, HARDLY_BESIDE);
}

/// [`meet_known_surface`] for places up to so far beside the triangle, in its sizes.
#[inline(always)] // for the instructions of its caller
fn meet_near(scene: &Scene, ray: &mut Ray, surface: &mut LayerSurface, beside: f32) {
    let is_near = |at: &Vec2| at.min_element() >= -beside && at.max_element() <= 1.0 + beside;
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
        let whole = Part { offset: Vec2::ZERO, side: self.side(fragment) };
        let mut is_steep = false;
        let seen = self.walk(fragment, whole, &mut is_steep);
        if is_steep && fragment.chain.last().is_some_and(|last| last.barycentrics.samples > 1) {
            return self.look_at_parts(fragment, whole, seen);
        }
        seen
    }

    #[inline(always)] // for the instructions of its caller
    fn is_followed(&self, fragment: &Fragment<'_>) -> bool {
        let [surface] = fragment.chain else { return false };
        let material = self.scene.material_of(self.scene.triangle_objects[surface.source as usize]);
        let has_lobes = || material.role == Role::Diffuse && material.lobes().is_some();
        self.lobes.is_some() && (has_lobes() || self.follows_lens(material, surface, 0))
    }

    fn begin_batch(&self, batch: &FragmentBatch<'_>) {
        self.reflector_pixels
            .add(self.scene, batch, |fragment| self.lobes.is_some() && self.is_lens_followed(fragment));
    }

    fn follow_together(&self, fragments: &mut [(u32, Fragment<'_>)], colors: &mut [Vec3]) {
        self.follow_all(fragments, colors);
    }

    fn eye(&self) -> Option<&ViewRays> {
        Some(&self.rays)
    }
}
