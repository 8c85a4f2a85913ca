//! Finds what the surfaces of a scene see of its environment and of its emitters.

use super::super::super::light_visibility::{LightVisibility, ShadowStart};
use super::super::super::{Light, LightKind, Material, Scene};
use super::super::environment::map::Irradiance;
use super::Sky;
use super::emitters::EmitterPoint;
use super::shares::{Arriving, Node, SurfaceShares};
use super::suns::{self, SkyPart};
use crate::parallel;
use crate::progress::{Cancelled, Progress};
use glam::{IVec3, UVec2, Vec2, Vec3};
use std::collections::HashMap;

/// Parts into which the sky beside its suns is divided.
const SKY_PARTS: u32 = 256;

/// Columns of a picture that suns are sought in, at most.
const MOST_COLUMNS: u32 = 1024;

/// Points between corners at which shares are found, at most: those of large parts before those of small ones.
const MOST_POINTS: usize = 25_000;

/// Corners at which shares are found, at most; others have those of a near one.
const MOST_CORNERS: usize = 20_000;

/// Triangles are divided by halving their sides so often at most.
const LEVELS: u32 = 12;

/// A share between two points differs from their mean by no more than this, or the triangle is divided; light of
/// emitters by no more than this part of itself and of all light there.
const TOLERANCE: f32 = 0.03;

/// The light of emitters that is known to be none, in parts of the brightest that arrives anywhere.
const FAINT: f32 = 0.02;

/// A triangle is divided where its longest side is longer than this part of the scene's size, and never where it is
/// shorter than the other.
const LONGEST: f32 = 1.0 / 16.0;
const SHORTEST: f32 = 1.0 / 512.0;

/// The same beside a smaller object, in parts of that one's size.
const LONGEST_BESIDE: f32 = 1.0 / 4.0;
const SHORTEST_BESIDE: f32 = 1.0 / 64.0;

/// Pairs of a triangle and an object that are looked at, at most.
const MOST_PAIRS: usize = 20_000_000;

/// Points lie so far within their triangle, as a share of the way to its middle.
const WITHIN: f32 = 1e-3;

/// Points that a thread takes at once. A size for threads; chosen, not measured.
const AT_ONCE: usize = 64;

/// A node that may be divided.
#[derive(Clone, Copy)]
struct Candidate {
    node: u32,
    triangle: u32,
    /// Its corners: weights of the triangle's second and third corner, in units of 2^-[`LEVELS`].
    corners: [UVec2; 3],
}

/// A place where shares are sought.
#[derive(Clone, Copy)]
struct Place {
    triangle: u32,
    at: Vec2,
}

const WHOLE: u32 = 1 << LEVELS;

/// What shines on surfaces.
struct Sources {
    sky: Vec<SkyPart>,
    emitters: Vec<EmitterPoint>,
    /// The irradiance of a surface that sees all of the sky, about.
    sky_irradiance: f32,
}

impl Scene {
    /// What the surfaces see of the environment and of emitters, by means that tell what stands before them; nothing
    /// without either.
    ///
    /// # Errors
    /// [`Cancelled`].
    pub fn seen_sky(
        &self,
        visibility: &dyn LightVisibility,
        progress: &dyn Progress,
    ) -> Result<Option<Sky>, Cancelled> {
        let emitters = self.find_emitters();
        let picture = self.environment.as_ref().map(|environment| environment.picture_within(MOST_COLUMNS).1);
        if emitters.is_none() && picture.is_none() {
            return Ok(None);
        }
        let (width, height, radiance) = picture.unwrap_or((1, 1, vec![[0.0; 3]]));
        let (suns, rest) = suns::suns_and_rest(width, height, radiance);
        let sky = match self.environment {
            Some(_) => suns::parts(width, height, &rest, SKY_PARTS / 2),
            None => Vec::new(),
        };
        let points = emitters.as_ref().map_or(Vec::new(), |emitters| self.points_of(emitters));
        // A quarter of the light from all around, for each of the colours.
        let sky_irradiance = sky.iter().map(|part| part.brightness).sum::<f32>() * 0.25;
        let sources = Sources { sky, emitters: points, sky_irradiance };
        let shares = shares(&Finder { scene: self, visibility, sources: &sources, progress })?;
        Ok(Some(Sky::new(suns, Irradiance::new(width, height, &rest), shares, emitters)))
    }
}

/// Finds what arrives at places of a scene.
struct Finder<'a> {
    scene: &'a Scene,
    visibility: &'a dyn LightVisibility,
    sources: &'a Sources,
    progress: &'a dyn Progress,
}

/// What arrives at all places of a scene's triangles.
fn shares(finder: &Finder<'_>) -> Result<SurfaceShares, Cancelled> {
    let Finder { scene, sources, .. } = *finder;
    let mut arriving = of_corners(finder)?;
    let differs = Difference::new(&arriving, sources);
    let mut nodes: Vec<Node> = scene.triangles.iter().map(|corners| Node { corners: *corners, parts: 0 }).collect();
    let near = Neighbours::new(scene);
    let whole = [UVec2::ZERO, UVec2::new(WHOLE, 0), UVec2::new(0, WHOLE)];
    let mut candidates: Vec<Candidate> = (0..scene.triangles.len() as u32)
        .filter(|triangle| is_lit(scene.material_of(scene.triangle_objects[*triangle as usize])))
        .map(|triangle| Candidate { node: triangle, triangle, corners: whole })
        .collect();
    let mut known: HashMap<(u32, UVec2), u32> = HashMap::new();
    let mut points = 0;
    for _ in 0..LEVELS {
        let limits = parallel::map_collect(candidates.len(), |index| near.limits(scene, &candidates[index]));
        // Those that are not too small already, and their lengths; large ones if they are too many.
        let mut divisible: Vec<(Candidate, f32, bool)> = candidates
            .iter()
            .zip(limits)
            .filter(|(_, (length, [_, least]))| length > least)
            .map(|(candidate, (length, [most, _]))| (*candidate, length, length > most))
            .collect();
        // Each asks for three points at most; half of what is left is for later levels.
        let most = (MOST_POINTS - points) / 6;
        if divisible.len() > most {
            divisible.sort_by(|(_, one, _), (_, other, _)| other.total_cmp(one));
            divisible.truncate(most);
        }
        let (kept, large): (Vec<Candidate>, Vec<bool>) =
            divisible.into_iter().map(|(candidate, _, is_large)| (candidate, is_large)).unzip();
        candidates = kept;
        // The middles of sides, each of a triangle once.
        let (mut places, first) = (Vec::new(), arriving.len());
        let middles: Vec<[u32; 3]> = candidates
            .iter()
            .map(|candidate| {
                let [a, b, c] = candidate.corners;
                [(a, b), (b, c), (c, a)].map(|(one, other)| {
                    let at = (one + other) / 2;
                    *known.entry((candidate.triangle, at)).or_insert_with(|| {
                        places.push(Place { triangle: candidate.triangle, at: at.as_vec2() / WHOLE as f32 });
                        (first + places.len() - 1) as u32
                    })
                })
            })
            .collect();
        if places.is_empty() {
            break;
        }
        points += places.len();
        arriving.extend(finder.found(&places)?);
        let mut next = Vec::new();
        for ((candidate, middles), is_large) in candidates.iter().zip(&middles).zip(&large) {
            let corners = nodes[candidate.node as usize].corners;
            let differs = (0..3).any(|side| {
                let [one, other, middle] = [corners[side], corners[(side + 1) % 3], middles[side]];
                differs.is_seen([one, other, middle].map(|index| &arriving[index as usize]))
            });
            if differs || *is_large {
                divide(&mut nodes, candidate, middles, &mut next);
            }
        }
        candidates = next;
    }
    Ok(SurfaceShares { arriving, nodes })
}

/// Differences between what arrives in the middle of a side and the mean of its ends.
struct Difference {
    /// Light that is always there.
    steady: f32,
}

impl Difference {
    fn new(corners: &[Arriving], sources: &Sources) -> Self {
        let brightest = corners.iter().flat_map(|corner| corner.emitted).map(Vec3::element_sum).fold(0.0, f32::max);
        Self { steady: FAINT * brightest + sources.sky_irradiance * FAINT }
    }

    /// Whether the middle of a side is seen to be other than the mean of its two ends.
    fn is_seen(&self, [one, other, middle]: [&Arriving; 3]) -> bool {
        (0..2).any(|face| {
            let emitted = [one, other, middle].map(|arriving| arriving.emitted[face].element_sum());
            let apart = (0.5 * (emitted[0] + emitted[1]) - emitted[2]).abs();
            let is_emitted = apart > TOLERANCE * (emitted[0].max(emitted[1]).max(emitted[2]) + self.steady);
            let of_sky = 0.5 * (one.sky[face] + other.sky[face]) - middle.sky[face];
            of_sky.abs().max_element() > TOLERANCE || is_emitted
        })
    }
}

/// Divides a node by the middles of its sides.
fn divide(nodes: &mut Vec<Node>, candidate: &Candidate, middles: &[u32; 3], next: &mut Vec<Candidate>) {
    let first = nodes.len() as u32;
    let node = &mut nodes[candidate.node as usize];
    node.parts = first;
    let ([a, b, c], [ab, bc, ca]) = (node.corners, *middles);
    let [at_a, at_b, at_c] = candidate.corners;
    let [at_ab, at_bc, at_ca] = [(at_a, at_b), (at_b, at_c), (at_c, at_a)].map(|(one, other)| (one + other) / 2);
    let parts = [
        ([a, ab, ca], [at_a, at_ab, at_ca]),
        ([ab, b, bc], [at_ab, at_b, at_bc]),
        ([ca, bc, c], [at_ca, at_bc, at_c]),
        ([bc, ca, ab], [at_bc, at_ca, at_ab]),
    ];
    for (corners, places) in parts {
        next.push(Candidate { node: nodes.len() as u32, triangle: candidate.triangle, corners: places });
        nodes.push(Node { corners, parts: 0 });
    }
}

/// Whether light from infinity on a surface is seen.
fn is_lit(material: &Material) -> bool {
    !material.unlit
}

/// Whether the other side of a surface is seen, or lets light pass.
fn has_two_sides(material: &Material) -> bool {
    material.double_sided || material.lobes().is_some_and(|lobes| lobes.diffuse_transmission > 0.0)
}

/// What arrives at all vertices.
fn of_corners(finder: &Finder<'_>) -> Result<Vec<Arriving>, Cancelled> {
    let scene = finder.scene;
    let mut places: Vec<Option<Place>> = vec![None; scene.positions.len()];
    for (triangle, corners) in (0..).zip(&scene.triangles) {
        if is_lit(scene.material_of(scene.triangle_objects[triangle as usize])) {
            for (vertex, at) in corners.iter().zip([Vec2::ZERO, Vec2::X, Vec2::Y]) {
                places[*vertex as usize].get_or_insert(Place { triangle, at });
            }
        }
    }
    let (size, mut cell) = (scene.bounds.diagonal(), 0.0);
    let mut groups = groups(scene, &places, cell);
    while groups.1.len() > MOST_CORNERS {
        // In cells as large as all numbers there are no more groups than directions.
        let least = if size > 0.0 && size.is_finite() { size / 512.0 } else { 1.0 };
        cell = f32::max(cell * 2.0, least);
        groups = self::groups(scene, &places, cell);
    }
    let (group_of, firsts) = groups;
    let of_groups = finder.found(&firsts)?;
    let mut arriving: Vec<Arriving> =
        group_of.iter().map(|group| of_groups.get(*group as usize).copied().unwrap_or(Arriving::OPEN)).collect();
    if cell > 0.0 {
        smooth(scene, &mut arriving);
        smooth(scene, &mut arriving);
    }
    Ok(arriving)
}

/// The group of each vertex, and a place in each group: vertices whose normals are alike, within cells of a grid.
fn groups(scene: &Scene, places: &[Option<Place>], cell: f32) -> (Vec<u32>, Vec<Place>) {
    let (mut group_of, mut firsts) = (vec![u32::MAX; places.len()], Vec::new());
    let mut known: HashMap<(IVec3, IVec3), u32> = HashMap::new();
    for (vertex, place) in places.iter().enumerate() {
        let Some(place) = place else { continue };
        let mut add = || {
            firsts.push(*place);
            firsts.len() as u32 - 1
        };
        group_of[vertex] = if cell > 0.0 {
            let at = ((scene.positions[vertex] - scene.bounds.min) / cell).floor().as_ivec3();
            let faces = (scene.normals[vertex] * 1.5).round().as_ivec3();
            *known.entry((at, faces)).or_insert_with(add)
        } else {
            add()
        };
    }
    (group_of, firsts)
}

/// Takes the mean of each vertex and its neighbours, as to vertices of one group the same arrives.
fn smooth(scene: &Scene, arriving: &mut [Arriving]) {
    let mut sums: Vec<(Arriving, f32)> = arriving.iter().map(|arriving| (*arriving, 1.0)).collect();
    for corners in &scene.triangles {
        for (one, other) in [(0, 1), (1, 2), (2, 0)].map(|(one, other)| (corners[one], corners[other])) {
            for (to, from) in [(one, other), (other, one)] {
                let (sum, count) = &mut sums[to as usize];
                (*sum, *count) = (sum.plus(&arriving[from as usize], 1.0), *count + 1.0);
            }
        }
    }
    for (arriving, (sum, count)) in arriving.iter_mut().zip(sums) {
        let none = Arriving { sky: [Vec3::ZERO; 2], emitted: [Vec3::ZERO; 2] };
        *arriving = none.plus(&sum, 1.0 / count);
    }
}

/// What lies near triangles, for how finely they are to be divided.
struct Neighbours {
    scene_size: f32,
    /// The sizes of objects, small ones first, with their numbers; none where there are too many to ask for.
    sizes: Vec<(f32, u32)>,
}

impl Neighbours {
    fn new(scene: &Scene) -> Self {
        let mut sizes: Vec<(f32, u32)> =
            (0..).zip(&scene.objects).map(|(index, object)| (object.bounds.diagonal(), index)).collect();
        sizes.sort_by(|one, other| one.0.total_cmp(&other.0));
        if sizes.len() * scene.triangles.len() > MOST_PAIRS {
            sizes.clear();
        }
        Self { scene_size: scene.bounds.diagonal(), sizes }
    }

    /// The longest side of a part of a triangle, and the lengths beyond and below which it is always and never divided.
    fn limits(&self, scene: &Scene, candidate: &Candidate) -> (f32, [f32; 2]) {
        let corners = scene.triangles[candidate.triangle as usize].map(|vertex| scene.positions[vertex as usize]);
        let place = |at: UVec2| {
            let at = at.as_vec2() / WHOLE as f32;
            corners[0] + (corners[1] - corners[0]) * at.x + (corners[2] - corners[0]) * at.y
        };
        let [a, b, c] = candidate.corners.map(place);
        let length = a.distance(b).max(b.distance(c)).max(c.distance(a));
        let mut limits = [self.scene_size * LONGEST, self.scene_size * SHORTEST];
        let (low, high) = (a.min(b).min(c) - length, a.max(b).max(c) + length);
        let own = scene.triangle_objects[candidate.triangle as usize];
        // Larger objects do not ask for smaller parts than these.
        for (size, index) in self.sizes.iter().take_while(|(size, _)| size * SHORTEST_BESIDE < length) {
            let bounds = &scene.objects[*index as usize].bounds;
            if *index != own && bounds.min.cmple(high).all() && bounds.max.cmpge(low).all() {
                limits = [limits[0].min(size * LONGEST_BESIDE), limits[1].min(size * SHORTEST_BESIDE)];
            }
        }
        (length, limits)
    }
}

impl Finder<'_> {
    /// What arrives at places.
    fn found(&self, places: &[Place]) -> Result<Vec<Arriving>, Cancelled> {
        let count = places.len().div_ceil(AT_ONCE);
        let chunks = parallel::map_stage(self.progress, "light from all around", count, |chunk| {
            let first = chunk * AT_ONCE;
            of_places(self.scene, self.visibility, self.sources, &places[first..(first + AT_ONCE).min(places.len())])
        })?;
        Ok(chunks.into_iter().flatten().collect())
    }
}

/// A place that looks around.
struct Seen {
    normal: Vec3,
    origins: [Vec3; 2],
    has_two_sides: bool,
    /// The light of the sky that would arrive on each side, and that which does, for each colour.
    light: [(f32, Vec3); 2],
    emitted: [Vec3; 2],
}

impl Seen {
    /// The side of the surface that faces a direction, if that side is seen.
    fn side_towards(&self, towards: Vec3) -> Option<usize> {
        let side = usize::from(self.normal.dot(towards) < 0.0);
        (side == 0 || self.has_two_sides).then_some(side)
    }
}

/// The same of a few places: for each part of the sky all of them together.
fn of_places(scene: &Scene, visibility: &dyn LightVisibility, sources: &Sources, places: &[Place]) -> Vec<Arriving> {
    let start = |place: &Place| {
        // A little within the triangle, as what touches its edge shades it on one side alone.
        let (triangle, at) = (place.triangle, place.at.lerp(Vec2::splat(1.0 / 3.0), WITHIN));
        let [a, b, c] = scene.triangles[triangle as usize].map(|vertex| scene.normals[vertex as usize]);
        let material = scene.material_of(scene.triangle_objects[triangle as usize]);
        Seen {
            normal: (a + (b - a) * at.x + (c - a) * at.y).normalize_or(a),
            origins: [1.0, -1.0].map(|side| ShadowStart::on_triangle(scene, triangle, at, side).origin),
            has_two_sides: has_two_sides(material),
            light: [(0.0, Vec3::ZERO); 2],
            emitted: [Vec3::ZERO; 2],
        }
    };
    let mut seen: Vec<Seen> = places.iter().map(start).collect();
    let (mut asked, mut points, mut passing) = (Vec::new(), Vec::new(), Vec::new());
    for part in &sources.sky {
        asked.clear();
        points.clear();
        for (index, place) in seen.iter().enumerate() {
            if let Some(side) = place.side_towards(part.towards) {
                asked.push((index, side, place.normal.dot(part.towards).abs() * part.brightness));
                points.push(place.origins[side]);
            }
        }
        passing.clear();
        passing.resize(points.len(), Vec3::ONE);
        let kind = LightKind::Directional;
        let light = Light { kind, intensity: Vec3::ONE, position: Vec3::ZERO, direction: -part.towards };
        visibility.find_passing(scene, &light, &points, &mut passing);
        for ((index, side, light), passing) in asked.iter().zip(&passing) {
            let (all, arriving) = &mut seen[*index].light[*side];
            *all += light;
            *arriving += *passing * *light;
        }
    }
    let mut asked: Vec<(usize, usize, Vec3)> = Vec::new();
    for emitter in &sources.emitters {
        asked.clear();
        points.clear();
        for (index, place) in seen.iter().enumerate() {
            let Some(side) = place.side_towards(emitter.position - place.origins[0]) else { continue };
            let normal = place.normal * [1.0, -1.0][side];
            let irradiance = emitter.irradiance(place.origins[side], normal);
            if irradiance != Vec3::ZERO {
                asked.push((index, side, irradiance));
                points.push(place.origins[side]);
            }
        }
        passing.clear();
        passing.resize(points.len(), Vec3::ONE);
        let kind = LightKind::Point { range: f32::INFINITY };
        let light = Light { kind, intensity: Vec3::ONE, position: emitter.position, direction: Vec3::NEG_Z };
        visibility.find_passing(scene, &light, &points, &mut passing);
        for ((index, side, irradiance), passing) in asked.iter().zip(&passing) {
            seen[*index].emitted[*side] += *irradiance * *passing;
        }
    }
    let share = |(all, arriving): (f32, Vec3)| if all > 0.0 { arriving / all } else { Vec3::ONE };
    seen.into_iter().map(|place| Arriving { sky: place.light.map(share), emitted: place.emitted }).collect()
}
