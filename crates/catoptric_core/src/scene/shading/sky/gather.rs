//! Gathers the light of the sky and of emitters that arrives at places of surfaces.

use super::super::super::shadows::ShadowStart;
use super::super::super::{Light, LightKind, LightVisibility, Material, Scene};
use super::emitters::EmitterPoint;
use super::shares::Arriving;
use super::suns::SkyPart;
use crate::math::random;
use crate::parallel;
use crate::progress::{Cancelled, Progress};
use glam::{Vec2, Vec3, Vec4};

/// Light comes from so many groups of directions: a place is looked around from in all of them, from points near it
/// that differ, so that no single point on an edge or within another thing decides.
pub(super) const GROUPS: usize = 32;

/// Points of a surface that a thread takes at once: as many as share enough directions to be traced together.
const AT_ONCE: usize = 2048;

/// Points lie so far within their triangle, as a share of the way to its middle.
const WITHIN: f32 = 1e-3;

/// All that shines on surfaces.
pub(super) struct Sources {
    pub(super) sky: Vec<SkyPart>,
    pub(super) emitters: Vec<EmitterPoint>,
}

impl Sources {
    /// The irradiance of a surface that sees all of the sky, about: a quarter of the light from all around, summed over
    /// the colours.
    pub(super) fn sky_irradiance(&self) -> f32 {
        self.sky.iter().map(|part| part.light.element_sum()).sum::<f32>() * 0.25
    }
}

/// A point of a triangle that looks in one group of directions for a place.
#[derive(Clone, Copy)]
pub(super) struct Sample {
    pub(super) triangle: u32,
    pub(super) at: Vec2,
    pub(super) group: u8,
}

/// The light that arrives at a place, on the side of its normals and on the other: of the sky, then of emitters.
#[derive(Clone, Copy, Debug, Default)]
pub(super) struct Gathered {
    /// The shares of each colour that arrive, times a weight, and that: the light that would arrive if nothing stood
    /// before it.
    light: [Vec4; 4],
    /// The irradiance by emitters if nothing stood before them.
    open: [Vec3; 2],
}

impl Gathered {
    /// The irradiance on both sides by surfaces around, how many rays meet these, and how near: the sums over so many
    /// rays.
    pub(super) fn of_surfaces(irradiance: [Vec3; 2], hits: [f32; 2], nearness: [f32; 2], rays: [f32; 2]) -> Self {
        let [near_front, near_back] = [0, 1].map(|side| Vec4::new(hits[side], nearness[side], 0.0, rays[side]));
        let [front, back] = [0, 1].map(|side| irradiance[side].extend(rays[side]));
        Self { light: [near_front, near_back, front, back], open: [Vec3::ZERO; 2] }
    }

    /// The sums of the irradiance by surfaces, with the number of rays.
    pub(super) fn by_surfaces(&self) -> [Vec4; 2] {
        [self.light[2], self.light[3]]
    }

    /// The share of rays that meet them, and how near they are.
    pub(super) fn hits_and_nearness(&self) -> [[f32; 2]; 2] {
        [0, 1].map(|part| [0, 1].map(|side| self.light[side][part] / self.light[side].w.max(1.0)))
    }

    /// Adds a part of another place's light, for a place that is lit alike.
    pub(super) fn add_shares(&mut self, other: &Self, weight: f32) {
        for (light, other) in self.light.iter_mut().zip(other.light) {
            *light += other * weight;
        }
    }

    /// The light that arrives; all of it where nothing is known.
    pub(super) fn arriving(&self) -> Arriving {
        let share = |light: Vec4| if light.w > 0.0 { light.truncate() / light.w } else { Vec3::ONE };
        Arriving {
            sky: [0, 1].map(|side| share(self.light[side])),
            by_surfaces: [0, 1].map(|side| self.open[side] * share(self.light[2 + side])),
        }
    }
}

/// Returns true if the other side of a surface is seen, or lets light pass.
fn has_two_sides(material: &Material) -> bool {
    material.double_sided || material.lobes().is_some_and(|lobes| lobes.diffuse_transmission > 0.0)
}

/// Finds what arrives at places of a scene.
pub(super) struct Gatherer<'a> {
    pub(super) scene: &'a Scene,
    pub(super) visibility: &'a dyn LightVisibility,
    pub(super) sources: &'a Sources,
    pub(super) progress: &'a dyn Progress,
}

impl Gatherer<'_> {
    /// Gathers the light at each of `count` places by so many samples, each in one group of directions.
    pub(super) fn gathered(
        &self,
        (count, samples): (usize, usize),
        sample: impl Fn(usize, usize) -> Sample + Sync + Send,
    ) -> Result<Vec<Gathered>, Cancelled> {
        let at_once = (AT_ONCE / samples).max(1);
        let chunks = parallel::map_stage(self.progress, "light from all around", count.div_ceil(at_once), |chunk| {
            let places = chunk * at_once..((chunk + 1) * at_once).min(count);
            let mut points: Vec<Point> = places
                .flat_map(|place| (0..samples).map(move |number| (place, number)))
                .map(|(place, number)| Point::new(self.scene, place - chunk * at_once, sample(place, number)))
                .collect();
            points.sort_by_key(|point| point.group);
            self.gathered_at(&points, (count - chunk * at_once).min(at_once))
        })?;
        Ok(chunks.into_iter().flatten().collect())
    }

    /// Gathers the light at places by their points, those of a group after each other: for each part of the light all
    /// of them together.
    fn gathered_at(&self, points: &[Point], places: usize) -> Vec<Gathered> {
        let mut sums = vec![[Sum::default(); 4]; places];
        let in_group = |group: usize| {
            let first = points.partition_point(|point| usize::from(point.group) < group);
            let count = points[first..].partition_point(|point| usize::from(point.group) == group);
            &points[first..first + count]
        };
        let mut asking = Asking::default();
        for (index, part) in self.sources.sky.iter().enumerate() {
            for point in in_group(index % GROUPS) {
                if let Some(side) = point.side_towards(part.towards) {
                    asking.ask(point, side, part.light * point.normal.dot(part.towards).abs());
                }
            }
            let kind = LightKind::Directional;
            let light = Light { kind, intensity: Vec3::ONE, position: Vec3::ZERO, direction: -part.towards };
            asking.answer(self, &light, |place, side, light| sums[place][side].add(light));
        }
        for (index, emitter) in self.sources.emitters.iter().enumerate() {
            for point in in_group(index % GROUPS) {
                if let Some((side, irradiance)) = point.lit_by(emitter) {
                    asking.ask(point, side, irradiance);
                }
            }
            let kind = LightKind::Point { range: f32::INFINITY };
            let light = Light { kind, intensity: Vec3::ONE, position: emitter.position, direction: Vec3::NEG_Z };
            asking.answer(self, &light, |place, side, light| sums[place][2 + side].add(light));
        }
        let light = |sums: [Sum; 4]| Gathered { light: sums.map(Sum::weighted_share), open: [Vec3::ZERO; 2] };
        let mut gathered: Vec<Gathered> = sums.into_iter().map(light).collect();
        if !self.sources.emitters.is_empty() {
            let mut is_known = vec![false; places];
            for point in points {
                if !std::mem::replace(&mut is_known[point.place], true) {
                    for (side, irradiance) in self.sources.emitters.iter().filter_map(|emitter| point.lit_by(emitter)) {
                        gathered[point.place].open[side] += irradiance;
                    }
                }
            }
        }
        gathered
    }
}

/// The light that would arrive if nothing stood before it, and that which does.
#[derive(Clone, Copy, Default)]
struct Sum {
    all: Vec3,
    arriving: Vec3,
}

impl Sum {
    fn add(&mut self, [all, arriving]: [Vec3; 2]) {
        self.all += all;
        self.arriving += arriving;
    }

    fn weighted_share(self) -> Vec4 {
        let weight = self.all.element_sum();
        let share = Vec3::select(self.all.cmpgt(Vec3::ZERO), self.arriving / self.all, Vec3::ONE);
        (share * weight).extend(weight)
    }
}

/// A point of a surface that looks around for a place.
pub(super) struct Point {
    place: usize,
    group: u8,
    pub(super) normal: Vec3,
    /// Above the side of the normals, and above the other.
    pub(super) origins: [Vec3; 2],
    pub(super) has_two_sides: bool,
}

impl Point {
    pub(super) fn new(scene: &Scene, place: usize, sample: Sample) -> Self {
        let triangle = sample.triangle;
        // Things that touch a triangle's edge shade it on one side alone.
        let at = sample.at.lerp(Vec2::splat(1.0 / 3.0), WITHIN);
        let [a, b, c] = scene.triangles[triangle as usize].map(|vertex| scene.normals[vertex as usize]);
        Self {
            place,
            group: sample.group,
            normal: (a + (b - a) * at.x + (c - a) * at.y).normalize_or(a),
            origins: [1.0, -1.0].map(|side| ShadowStart::on_triangle(scene, triangle, at, side).origin),
            has_two_sides: has_two_sides(scene.material_of(scene.triangle_objects[triangle as usize])),
        }
    }

    /// The side of the surface that faces a direction, if that side is seen.
    fn side_towards(&self, towards: Vec3) -> Option<usize> {
        let side = usize::from(self.normal.dot(towards) < 0.0);
        (side == 0 || self.has_two_sides).then_some(side)
    }

    /// The side that an emitter shines on, and the irradiance there.
    fn lit_by(&self, emitter: &EmitterPoint) -> Option<(usize, Vec3)> {
        let side = self.side_towards(emitter.position - self.origins[0])?;
        let irradiance = emitter.irradiance(self.origins[side], self.normal * [1.0, -1.0][side]);
        (irradiance != Vec3::ZERO).then_some((side, irradiance))
    }
}

/// Points that ask how much of one light arrives.
#[derive(Default)]
struct Asking {
    /// Their places, sides, and the light that would arrive.
    asked: Vec<(usize, usize, Vec3)>,
    origins: Vec<Vec3>,
    passing: Vec<Vec3>,
}

impl Asking {
    fn ask(&mut self, point: &Point, side: usize, light: Vec3) {
        self.asked.push((point.place, side, light));
        self.origins.push(point.origins[side]);
    }

    /// Answers all, and forgets them.
    fn answer(&mut self, gatherer: &Gatherer<'_>, light: &Light, mut add: impl FnMut(usize, usize, [Vec3; 2])) {
        self.passing.clear();
        self.passing.resize(self.origins.len(), Vec3::ONE);
        gatherer.visibility.find_passing(gatherer.scene, light, &self.origins, &mut self.passing);
        for ((place, side, light), passing) in self.asked.drain(..).zip(&self.passing) {
            add(place, side, [light, *passing * light]);
        }
        self.origins.clear();
    }
}

/// The place of a point near another one in a triangle, of the number of a sample: no further along the sides from its
/// first corner than given, in parts of them.
pub(super) fn near(at: Vec2, number: u32, reach: Vec2) -> Vec2 {
    let moved = (at + (random::spread(number) * 2.0 - 1.0) * reach).abs();
    let moved = if moved.element_sum() > 1.0 { Vec2::ONE - Vec2::new(moved.y, moved.x) } else { moved };
    moved.clamp(Vec2::ZERO, Vec2::ONE)
}
