//! The bodies of glass and liquid of a scene, and those that a ray is in.

use catoptric_core::math::Aabb;
use catoptric_core::scene::Scene;
use catoptric_core::scene::enclosure::FaceSums;
use glam::Vec3;
use std::cmp::Reverse;

/// Bodies that a ray is in at once, at most: of more, those that it enters last are left out.
const MOST_BODIES: usize = 6;

/// Boxes count as touching that are nearer than this share of their coordinates.
const TOUCHING: f32 = 1e-5;

/// Pairs of boxes that are looked at, at most.
const MOST_PAIRS: usize = 10_000_000;

/// The least volume of a body, in parts of its surface's size to the power of one and a half.
const LEAST_VOLUME: f64 = 1e-6;

const NONE: u32 = u32::MAX;

/// Bodies by their numbers.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub(crate) struct Bodies {
    objects: [u32; MOST_BODIES],
    count: u8,
}

impl Bodies {
    pub(super) fn all(&self) -> &[u32] {
        &self.objects[..self.count as usize]
    }

    #[must_use]
    pub(super) fn with(mut self, object: u32) -> Self {
        if let Some(place) = self.objects.get_mut(self.count as usize) {
            *place = object;
            self.count += 1;
        }
        self
    }

    #[must_use]
    pub(super) fn without(mut self, index: usize) -> Self {
        let count = self.count as usize;
        self.objects.copy_within(index + 1..count, index);
        self.objects[count - 1] = 0;
        self.count -= 1;
        self
    }
}

/// The bodies of a scene.
#[derive(Clone, Debug, Default)]
pub(crate) struct SceneBodies {
    /// For each object the body that it is the surface of, or a part of the surface, by the first of its objects;
    /// [`NONE`] for other objects. Empty where there is no body.
    of_objects: Vec<u32>,
    /// For each body its rank: of two bodies in one place the one with the lower rank is there.
    ranks: Vec<u32>,
    /// Their boxes, a little widened.
    boxes: Vec<(u32, Aabb)>,
    /// About all of them.
    bounds: Aabb,
    meet: bool,
}

/// Returns true if bodies of a scene may touch, overlap or lie within each other.
pub fn bodies_meet(scene: &Scene) -> bool {
    SceneBodies::new(scene, |_| true).meet
}

impl SceneBodies {
    /// The bodies of those objects of a scene for which `include` is true.
    pub(super) fn new(scene: &Scene, include: impl Fn(u32) -> bool) -> Self {
        let is_body = |object: &u32| include(*object) && scene.material_of(*object).has_inside();
        let objects: Vec<u32> = (0..scene.objects.len() as u32).filter(is_body).collect();
        if objects.is_empty() {
            return Self::default();
        }
        let widened = |object: u32| {
            let Aabb { min, max } = scene.objects[object as usize].bounds;
            let reach = min.abs().max(max.abs()).max_element() * TOUCHING;
            Aabb { min: min - reach, max: max + reach }
        };
        let mut boxes: Vec<(u32, Aabb)> = objects.iter().map(|object| (*object, widened(*object))).collect();
        boxes.sort_by(|(_, one), (_, other)| one.min.x.total_cmp(&other.min.x));
        let mut of_objects = vec![NONE; scene.objects.len()];
        for object in objects {
            of_objects[object as usize] = object;
        }
        join_open_parts(scene, &boxes, &mut of_objects);
        let mut bodies: Vec<(u32, Aabb)> = Vec::new();
        let mut places: Vec<usize> = vec![usize::MAX; scene.objects.len()];
        for (object, bounds) in boxes {
            let body = of_objects[object as usize];
            match bodies.get_mut(places[body as usize]) {
                Some((_, known)) => *known = Aabb { min: known.min.min(bounds.min), max: known.max.max(bounds.max) },
                None => {
                    places[body as usize] = bodies.len();
                    bodies.push((body, bounds));
                }
            }
        }
        // Among very many they are taken to.
        let meet =
            pairs(&bodies).take(MOST_PAIRS + 1).enumerate().any(|(index, pair)| index == MOST_PAIRS || touch(pair));
        let about_both =
            |one: Aabb, (_, other): &(u32, Aabb)| Aabb { min: one.min.min(other.min), max: one.max.max(other.max) };
        let bounds = bodies.iter().fold(Aabb::EMPTY, about_both);
        // A body within another one is smaller.
        let mut by_size = bodies.clone();
        let priority = |body: u32| Reverse(scene.material_of(body).priority);
        by_size.sort_by(|(a, one), (b, other)| {
            priority(*a).cmp(&priority(*b)).then(one.diagonal().total_cmp(&other.diagonal()))
        });
        let mut ranks = vec![NONE; scene.objects.len()];
        for (rank, (body, _)) in (0..).zip(by_size) {
            ranks[body as usize] = rank;
        }
        Self { of_objects, ranks, boxes: bodies, bounds, meet }
    }

    /// Returns true if some may touch, overlap or lie within each other.
    pub(crate) fn meet(&self) -> bool {
        self.meet
    }

    /// The body of an object, if it is one.
    pub(super) fn of(&self, object: u32) -> Option<u32> {
        self.of_objects.get(object as usize).copied().filter(|body| *body != NONE)
    }

    /// The one of the bodies in one place that fills it.
    pub(super) fn filling(&self, bodies: &Bodies) -> Option<u32> {
        bodies.all().iter().copied().min_by_key(|body| self.ranks[*body as usize])
    }

    /// The bodies about whose boxes a point lies in.
    pub(super) fn about(&self, point: Vec3) -> impl Iterator<Item = u32> {
        let is_about = move |bounds: &Aabb| bounds.min.cmple(point).all() && bounds.max.cmpge(point).all();
        let boxes = if is_about(&self.bounds) { &self.boxes[..] } else { &[] };
        boxes.iter().filter(move |(_, bounds)| is_about(bounds)).map(|(body, _)| *body)
    }
}

/// Pairs of boxes that overlap along x, of those that are sorted along it.
fn pairs(boxes: &[(u32, Aabb)]) -> impl Iterator<Item = [&(u32, Aabb); 2]> {
    boxes.iter().enumerate().flat_map(|(index, one)| {
        let after = boxes[index + 1..].iter().take_while(|(_, other)| other.min.x <= one.1.max.x);
        after.map(move |other| [one, other])
    })
}

fn touch([(_, one), (_, other)]: [&(u32, Aabb); 2]) -> bool {
    one.min.cmple(other.max).all() && other.min.cmple(one.max).all()
}

/// Makes one body of objects of one material that are open, each for itself, and touch: as of a box whose faces are
/// objects.
fn join_open_parts(scene: &Scene, boxes: &[(u32, Aabb)], of_objects: &mut [u32]) {
    let open: Vec<(u32, Aabb)> = boxes.iter().filter(|(object, _)| is_open(scene, *object)).copied().collect();
    let material = |object: u32| scene.objects[object as usize].material;
    let root = |of_objects: &[u32], mut object: u32| {
        while of_objects[object as usize] != object {
            object = of_objects[object as usize];
        }
        object
    };
    for pair in pairs(&open).take(MOST_PAIRS) {
        let [one, other] = pair.map(|(object, _)| *object);
        if material(one) == material(other) && touch(pair) {
            let [one, other] = [one, other].map(|object| root(of_objects, object));
            of_objects[one.max(other) as usize] = one.min(other);
        }
    }
    for (object, _) in open {
        of_objects[object as usize] = root(of_objects, object);
    }
}

/// Returns true if the faces of an object do not enclose anything.
fn is_open(scene: &Scene, object: u32) -> bool {
    FaceSums::default().with(scene, object).are_open()
}

/// Bodies of glass or liquid whose surfaces cannot be meant as they are, a sentence a kind with the names of objects:
/// they are drawn as their normals say all the same. A sentence, too, of a scene with nothing but mirrors and glass,
/// in which nothing is to be seen.
pub fn remarks_on_bodies(scene: &Scene) -> Vec<String> {
    let bodies = SceneBodies::new(scene, |_| true);
    let mut of_bodies = vec![FaceSums::default(); scene.objects.len()];
    for object in 0..scene.objects.len() as u32 {
        if let Some(body) = bodies.of(object) {
            of_bodies[body as usize] = of_bodies[body as usize].with(scene, object);
        }
    }
    // Hollows in other bodies are bodies that are turned inside out, too. Among very many they are not looked for.
    let are_few = bodies.boxes.len().pow(2) <= MOST_PAIRS;
    let is_within_another = |body: u32| {
        let Some((_, own)) = bodies.boxes.iter().find(|(of, _)| *of == body) else { return false };
        let contains = |other: &Aabb| other.min.cmple(own.min).all() && other.max.cmpge(own.max).all();
        bodies.boxes.iter().any(|(other, bounds)| *other != body && contains(bounds))
    };
    let open = |_: u32, faces: &FaceSums| faces.are_open();
    let inverted = |body: u32, faces: &FaceSums| {
        let is_inverted = !faces.are_open() && faces.volume < -LEAST_VOLUME * faces.size * faces.size.sqrt();
        is_inverted && are_few && !is_within_another(body)
    };
    let bodies_of = |is_told: &dyn Fn(u32, &FaceSums) -> bool| -> Vec<u32> {
        let of_bodies = (0..).zip(&of_bodies).filter(|(body, _)| bodies.of(*body) == Some(*body));
        of_bodies.filter(|(body, faces)| is_told(*body, faces)).map(|(body, _)| body).collect()
    };
    let is_plate = |object: &u32| scene.material_of(*object).lobes().is_some_and(|lobes| lobes.is_plate);
    let plates: Vec<u32> = (0..scene.objects.len() as u32).filter(is_plate).collect();
    let (body, sheet) = ("body of glass or liquid", "sheet of glass");
    [
        told(
            scene,
            &bodies_of(&open),
            [body, "bodies of glass or liquid"],
            ["has", "have"],
            "no closed surface: light that enters and meets no other side of it goes on within",
        ),
        told(
            scene,
            &bodies_of(&inverted),
            [body, "bodies of glass or liquid"],
            ["is", "are"],
            "turned inside out (normals point inwards): drawn as a hollow within glass",
        ),
        told(
            scene,
            &plates,
            [sheet, "sheets of glass"],
            ["is", "are"],
            "open: drawn as a thin plate, which light passes straight; only a closed surface has an inside",
        ),
        told_of_dark(scene),
    ]
    .into_iter()
    .flatten()
    .collect()
}

/// A sentence about a scene whose surfaces all show something else, of which there is nothing.
fn told_of_dark(scene: &Scene) -> Option<String> {
    let only_shows_others = |object: u32| {
        let material = scene.material_of(object);
        material.role.is_specular() && !material.has_own_light() && material.emissive == Vec3::ZERO
    };
    let objects = 0..scene.objects.len() as u32;
    let is_dark = scene.environment.is_none() && scene.backdrop.is_none() && !objects.is_empty();
    (is_dark && objects.clone().all(only_shows_others)).then(|| {
        "there is nothing to be seen in mirrors: all surfaces are mirrors or glass, and there is no environment (add \
         other objects, or --environment studio)"
            .into()
    })
}

/// A sentence about some objects, which tells the name of the first one.
fn told(
    scene: &Scene,
    objects: &[u32],
    [thing, things]: [&str; 2],
    [one, more]: [&str; 2],
    what: &str,
) -> Option<String> {
    let first = *objects.first()?;
    let name = match scene.objects[first as usize].name.as_str() {
        "" => format!("object {first}"),
        name => format!("object {first} `{name}`"),
    };
    Some(match objects.len() {
        1 => format!("the {thing} of {name} {one} {what}"),
        count => format!("{count} {things} ({name}, ...) {more} {what}"),
    })
}
