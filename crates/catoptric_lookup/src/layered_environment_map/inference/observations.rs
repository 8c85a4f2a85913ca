//! Observations of the layers about a group in a picture from a viewpoint: the right-hand sides of inference.

use crate::layered_environment_map::mesh::visible::SeenSurfaces;
use crate::layered_environment_map::mesh::{AdaptiveMesh, same_way};
use crate::layered_environment_map::shells::distant_geometry::{LayerSpecs, further_hits};
use crate::layered_environment_map::shells::group_layers::GroupLayers;
use catoptric_core::math::portable::PortableMath;
use catoptric_core::parallel;
use catoptric_core::scene::shade::SurfacePoint;
use catoptric_core::scene::{Ray, RayDifferential, Scene, View};
use catoptric_engine::light::two_path_tracer::{SpecularChain, TwoPathTracer};
use catoptric_engine::optics::path::bundle::BounceKind;
use glam::{Vec3, Vec4};

/// Rays of a pixel whose directions are this far apart or further, in degrees, count nothing (Hakura, Snyder 2001,
/// section 4.3).
const MIN_CONFIDENT_DEG: f32 = 5.0;

/// Surfaces of a group behind the visible one to which a ray from the eye is continued, at most. A bound on time;
/// chosen, not measured.
const MAX_HIDDEN: usize = 4;

/// Observation of a pixel by one of its two paths.
#[derive(Clone, Copy, Debug)]
pub struct Observation {
    /// Column and row.
    pub pixel: [u32; 2],
    /// The first event of its path.
    pub first: BounceKind,
    /// The ray that leaves as the renderer has it.
    pub ray: Ray,
    /// The change of the ray from pixel to pixel.
    pub change: RayDifferential,
    /// Confidence from 0 to 1: less where the rays of a pixel go apart.
    pub confidence: f32,
}

/// Observations of a picture.
#[derive(Clone, Debug, Default)]
pub struct Observations {
    /// The observations.
    pub list: Vec<Observation>,
    /// The observed values of every layer, observation after observation: radiance times opacity, and opacity.
    seen: Vec<Vec4>,
    layers: usize,
}

impl Observations {
    /// Radiance and opacity of a layer in an observation.
    pub fn seen(&self, observation: usize, layer: usize) -> Vec4 {
        self.seen[observation * self.layers + layer]
    }

    /// Observations of the rows of a picture.
    fn joined(layers: usize, rows: Vec<Self>) -> Self {
        let mut all = Self { layers, ..Self::default() };
        for row in rows {
            all.list.extend(row.list);
            all.seen.extend(row.seen);
        }
        all
    }
}

/// Inputs of the picture of a group.
pub struct Observer<'a> {
    pub(crate) scene: &'a Scene,
    /// The group and its shells.
    pub known: &'a GroupLayers,
    /// The paths over the group.
    pub paths: TwoPathTracer<'a>,
    pub(crate) strata: &'a LayerSpecs<'a>,
    /// Rays a pixel, a square number.
    pub(crate) samples: u32,
}

impl Observer<'_> {
    /// The observations of a picture whose adaptive mesh was seen like this.
    pub(crate) fn observe(&self, view: &View, mesh: &AdaptiveMesh, seen: &SeenSurfaces) -> Observations {
        let layers = self.strata.count;
        let rows = parallel::map_collect(view.height as usize, |y| {
            let mut found = Observations { layers, ..Observations::default() };
            for x in 0..view.width {
                let surface = seen.at(x, y as u32);
                let Some(blend) = surface.and_then(|surface| mesh.blend(surface)) else { continue };
                for first in BounceKind::BOTH {
                    // Paths that take different ways make the rays of a pixel go apart: they would count nothing.
                    let Some((path, change)) = blend.path(first as usize) else { continue };
                    if let Some(leaving) = path.leaving {
                        let pixel = [x, y as u32];
                        let observation = Observation { pixel, first, ray: leaving, change, confidence: 0.0 };
                        let rays = self.sampled(view, pixel).filter_map(|ray| self.leaving(&ray, first));
                        self.pixel(observation, &rays.collect::<Vec<_>>(), &mut found);
                    }
                }
            }
            found
        });
        Observations::joined(layers, rows)
    }

    /// Observations of the parts of the group that others hide in a picture: rays from the eye go on through their
    /// first hit, to the next surface that faces them (Hakura, Snyder 2001, figure 4b).
    ///
    /// Neighbouring rays are traced: hidden parts have no adaptive mesh.
    pub fn observe_hidden(&self, view: &View) -> Observations {
        let layers = self.strata.count;
        let rows = parallel::map_collect(view.height as usize, |y| {
            let mut found = Observations { layers, ..Observations::default() };
            for x in 0..view.width {
                let at = |right: f32, down: f32| self.hidden(view.ray(x as f32 + 0.5 + right, y as f32 + 0.5 + down));
                let middle = at(0.0, 0.0);
                if middle.points.is_empty() {
                    continue;
                }
                let (pixel, neighbours) = ([x, y as u32], [at(1.0, 0.0), at(0.0, 1.0)]);
                let samples: Vec<HiddenSurfaces> = self.sampled(view, pixel).map(|ray| self.hidden(ray)).collect();
                for (number, point) in middle.points.iter().enumerate() {
                    for first in BounceKind::BOTH {
                        let follow = |surfaces: &HiddenSurfaces| {
                            let same = surfaces.points.get(number).filter(|other| other.object == point.object)?;
                            Some(self.paths.follow(surfaces.direction, *same, first))
                        };
                        let Some((ray, change)) = ray_among(&middle, &neighbours, follow) else { continue };
                        let observation = Observation { pixel, first, ray, change, confidence: 0.0 };
                        let rays = samples.iter().filter_map(|surfaces| follow(surfaces)?.leaving);
                        self.pixel(observation, &rays.collect::<Vec<_>>(), &mut found);
                    }
                }
            }
            found
        });
        Observations::joined(layers, rows)
    }

    /// Surfaces of the group behind the first one that face a ray, the nearest first.
    fn hidden(&self, ray: Ray) -> HiddenSurfaces {
        let (scene, tracer) = (self.scene, &self.known.group.tracer);
        let met = further_hits(scene, tracer, ray).skip(1).map(|hit| tracer.point(scene, &ray, &hit));
        let faced = met.filter(|point| ray.direction.dot(point.geometric_normal) < 0.0);
        HiddenSurfaces { direction: ray.direction, points: faced.take(MAX_HIDDEN).collect() }
    }

    /// Observes the surroundings of the group without the group, in a view that looks at its centre: rays begin where
    /// they pass the plane through the centre, as those that go straight through a lens.
    pub(crate) fn observe_directly(&self, view: &View) -> Observations {
        let layers = self.strata.count;
        let (eye, center) = (view.eye(), self.strata.around.center);
        let arm = center - eye;
        let past = |ray: &Ray| {
            let distance = arm.length_squared() / ray.direction.dot(arm);
            Some(Ray { origin: ray.origin + ray.direction * distance, ..*ray }).filter(|ray| ray.origin.is_finite())
        };
        let rows = parallel::map_collect(view.height as usize, |y| {
            let mut found = Observations { layers, ..Observations::default() };
            for x in 0..view.width {
                let at = |right: f32, down: f32| past(&view.ray(x as f32 + 0.5 + right, y as f32 + 0.5 + down));
                let (Some(ray), Some(right), Some(below)) = (at(0.0, 0.0), at(1.0, 0.0), at(0.0, 1.0)) else {
                    continue;
                };
                let (pixel, change) = ([x, y as u32], differences(&ray, &right, &below));
                let observation = Observation { pixel, first: BounceKind::Transmit, ray, change, confidence: 0.0 };
                let rays = self.sampled(view, pixel).filter_map(|ray| past(&ray));
                self.pixel(observation, &rays.collect::<Vec<_>>(), &mut found);
            }
            found
        });
        Observations::joined(layers, rows)
    }

    /// Rays of a pixel.
    fn sampled(&self, view: &View, [x, y]: [u32; 2]) -> impl Iterator<Item = Ray> {
        let count = self.samples.isqrt();
        (0..count * count).map(move |sample| {
            let at = |place: u32, cell: u32| place as f32 + (cell as f32 + 0.5) / count as f32;
            view.ray(at(x, sample % count), at(y, sample / count))
        })
    }

    /// Appends the observation of a pixel, where its rays (as they are around the group) leave in about one direction.
    fn pixel(&self, observation: Observation, rays: &[Ray], found: &mut Observations) {
        let (layers, count) = (found.layers, self.samples.isqrt());
        let confidence = confidence(rays);
        if confidence <= 0.0 {
            return;
        }
        // Textures are seen as blurred as a ray's share of the pixel is wide.
        let change = observation.change.scaled(1.0 / count as f32);
        let start = found.seen.len();
        found.seen.resize(start + layers, Vec4::ZERO);
        let seen = &mut found.seen[start..];
        rays.iter().for_each(|ray| self.strata.add_seen(ray, Some(&change), self.strata.all(), seen));
        seen.iter_mut().for_each(|seen| *seen /= rays.len() as f32);
        found.list.push(Observation { confidence, ..observation });
    }

    fn leaving(&self, ray: &Ray, first: BounceKind) -> Option<Ray> {
        let (scene, tracer) = (self.scene, &self.known.group.tracer);
        let hit = tracer.first_hit(scene, ray, 0.0)?;
        let point = tracer.point(scene, ray, &hit);
        self.paths.follow(ray.direction, point, first).leaving
    }
}

/// Surfaces of a group along a ray that others hide.
struct HiddenSurfaces {
    direction: Vec3,
    points: Vec<SurfacePoint>,
}

/// The ray that leaves in the end, with its differential; `None` if its neighbours (to the right, below) take other
/// ways.
fn ray_among(
    middle: &HiddenSurfaces,
    neighbours: &[HiddenSurfaces; 2],
    follow: impl Fn(&HiddenSurfaces) -> Option<SpecularChain>,
) -> Option<(Ray, RayDifferential)> {
    let path = follow(middle)?;
    let leaving = |surfaces: &HiddenSurfaces| follow(surfaces).filter(|other| same_way(&path, other))?.leaving;
    let (ray, right, below) = (path.leaving?, leaving(&neighbours[0])?, leaving(&neighbours[1])?);
    Some((ray, differences(&ray, &right, &below)))
}

/// The differential of a ray by its neighbours.
pub(crate) fn differences(ray: &Ray, right: &Ray, below: &Ray) -> RayDifferential {
    RayDifferential {
        origin_dx: right.origin - ray.origin,
        origin_dy: below.origin - ray.origin,
        direction_dx: right.direction - ray.direction,
        direction_dy: below.direction - ray.direction,
    }
}

/// The confidence by the largest angle between rays' directions: 1 if they are equal, 0 from the threshold on, or
/// without rays.
pub fn confidence(rays: &[Ray]) -> f32 {
    if rays.is_empty() {
        return 0.0;
    }
    let pairs = rays.iter().enumerate().flat_map(|(index, a)| rays[..index].iter().map(move |b| (a, b)));
    // The chord is exact for small angles, where the cosine is not.
    let chord = pairs.map(|(a, b)| a.direction.distance(b.direction)).fold(0.0, f32::max);
    let angle = 2.0 * (0.5 * chord).min(1.0).arc_sine();
    let share = (angle / MIN_CONFIDENT_DEG.to_radians()).min(1.0);
    1.0 - share * share
}
