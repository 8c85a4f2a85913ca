//! Regions: boxes about reflectors that belong together, in world space.

use catoptric_core::math::Aabb;
use catoptric_core::scene::Scene;
use glam::Vec3;

/// Boxes are no flatter than this share of their diagonal. Chosen, not measured.
const MIN_DEPTH: f32 = 0.02;

/// No more regions than this: what is around each is captured. A bound on time and memory; chosen, not measured.
const MAX_REGIONS: usize = 4;

/// More regions than this are captured with as many texels together, where nothing is baked. A bound on time and
/// memory; chosen, not measured.
const MAX_FULL_REGIONS: usize = 2;

/// Boxes of reflectors and lenses, and who is in which.
pub(crate) struct Regions {
    pub(crate) boxes: Vec<Aabb>,
    /// Boxes that do not overlap and have become one all the same, because there were too many.
    pub(crate) joined: u64,
    /// Of every object of the scene.
    pub(crate) region_of: Vec<Option<u32>>,
}

impl Regions {
    /// The scene's region, with the reflectors and lenses in it; where it has none, a box about each of them, larger by
    /// a share of its diagonal, and one about those whose boxes overlap, or that are nearest where there are too many.
    pub(crate) fn of(scene: &Scene, margin: f32) -> Self {
        let specular = scene.specular_objects();
        let (boxes, joined) = match scene.region {
            Some(region) => (vec![region], 0),
            None => {
                let around = |object: &u32| {
                    let bounds = scene.objects[*object as usize].bounds;
                    let room = Vec3::splat((margin * bounds.diagonal()).max(rounding(&bounds)));
                    // Flat ones are given a depth.
                    let room = room.max((MIN_DEPTH * bounds.diagonal() - bounds.size()) * 0.5);
                    Aabb { min: bounds.min - room, max: bounds.max + room }
                };
                few(merged(specular.iter().map(around).filter(|bounds| bounds.size().min_element() > 0.0).collect()))
            }
        };
        let mut region_of = vec![None; scene.objects.len()];
        for object in specular {
            let region = boxes.iter().position(|region| is_within(scene, object, region));
            region_of[object as usize] = region.map(|region| region as u32);
        }
        Self { boxes, joined, region_of }
    }

    /// The share of a side's texels that each region has where all of them are captured at once.
    pub(crate) fn share_of_side(&self) -> f32 {
        (MAX_FULL_REGIONS as f32 / self.boxes.len().max(1) as f32).sqrt().min(1.0)
    }
}

/// Returns true for objects whose bounds lie in a region.
pub(crate) fn is_within(scene: &Scene, object: u32, region: &Aabb) -> bool {
    let bounds = &scene.objects[object as usize].bounds;
    let rounding = 1e-5 * region.diagonal();
    bounds.min.cmpge(region.min - rounding).all() && bounds.max.cmple(region.max + rounding).all()
}

/// How far positions of an object may be off by rounding.
fn rounding(bounds: &Aabb) -> f32 {
    64.0 * f32::EPSILON * bounds.center().abs().max_element()
}

/// Boxes that do not overlap, about those that do.
fn merged(mut boxes: Vec<Aabb>) -> Vec<Aabb> {
    let mut index = 0;
    while index < boxes.len() {
        match (index + 1..boxes.len()).find(|other| overlap(&boxes[index], &boxes[*other])) {
            Some(other) => {
                boxes[index] = boxes[index].union(boxes.swap_remove(other));
                // It has grown: it may reach others now, also earlier ones.
                index = 0;
            }
            None => index += 1,
        }
    }
    boxes
}

/// No more boxes than [`MAX_REGIONS`], of such that do not overlap: those whose union is smallest become one, with all
/// that it reaches. The second value counts the boxes that others take in. Takes time with the square of their number.
fn few(mut boxes: Vec<Aabb>) -> (Vec<Aabb>, u64) {
    let mut left: Vec<bool> = vec![true; boxes.len()];
    // For each the size of the smallest union, and with which.
    let nearest = |boxes: &[Aabb], left: &[bool], one: usize| -> (f32, usize) {
        let others = (0..boxes.len()).filter(|&other| other != one && left[other]);
        let unions = others.map(|other| (boxes[one].union(boxes[other]).diagonal(), other));
        unions.min_by(|a, b| a.0.total_cmp(&b.0)).unwrap_or((f32::INFINITY, one))
    };
    let mut count = boxes.len();
    let mut joined = 0;
    let mut near: Vec<(f32, usize)> = Vec::new();
    while count > MAX_REGIONS {
        if near.is_empty() {
            near = (0..boxes.len()).map(|one| nearest(&boxes, &left, one)).collect();
        }
        let smallest = (0..boxes.len()).filter(|one| left[*one]).min_by(|a, b| near[*a].0.total_cmp(&near[*b].0));
        let Some(one) = smallest else { break };
        let mut next = Some(near[one].1);
        while let Some(other) = next {
            boxes[one] = boxes[one].union(boxes[other]);
            left[other] = false;
            (count, joined) = (count - 1, joined + 1);
            // It may reach others now.
            next = (0..boxes.len()).find(|&other| other != one && left[other] && overlap(&boxes[one], &boxes[other]));
        }
        for other in (0..boxes.len()).filter(|&other| left[other]).collect::<Vec<_>>() {
            let union = boxes[one].union(boxes[other]).diagonal();
            if other == one || near[other].1 == one || !left[near[other].1] {
                near[other] = nearest(&boxes, &left, other);
            } else if union < near[other].0 {
                near[other] = (union, one);
            }
        }
    }
    let kept = boxes.into_iter().zip(left).filter_map(|(bounds, left)| left.then_some(bounds));
    (kept.collect(), joined)
}

fn overlap(a: &Aabb, b: &Aabb) -> bool {
    a.min.cmple(b.max).all() && b.min.cmple(a.max).all()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn overlapping_boxes_become_one() {
        let cube = |x: f32| Aabb { min: Vec3::new(x, 0.0, 0.0), max: Vec3::new(x + 1.0, 1.0, 1.0) };
        let found = merged(vec![cube(0.0), cube(5.0), cube(1.5), cube(0.8)]);
        assert_eq!(found.len(), 2);
        assert!(found.contains(&Aabb { min: Vec3::ZERO, max: Vec3::new(2.5, 1.0, 1.0) }));
    }

    #[test]
    fn the_nearest_of_many_boxes_become_one() {
        let cube = |x: f32| Aabb { min: Vec3::new(x, 0.0, 0.0), max: Vec3::new(x + 1.0, 1.0, 1.0) };
        let (found, joined) = few([0.0, 1.5, 10.0, 20.0, 30.0, 32.0].map(cube).to_vec());
        assert_eq!((found.len(), joined), (4, 2));
        assert!(found.contains(&cube(0.0).union(cube(1.5))) && found.contains(&cube(30.0).union(cube(32.0))));
        assert_eq!(few(vec![cube(0.0), cube(3.0)]).1, 0);
    }

    #[test]
    fn many_boxes_become_few_that_hold_them_all_and_do_not_overlap() {
        let mut random = catoptric_core::math::random::Stream::new(5);
        let mut cube = || {
            let min = Vec3::from([0; 3].map(|_| random.next_between(-9.0, 9.0)));
            Aabb { min, max: min + 0.1 }
        };
        let all: Vec<Aabb> = (0..2000).map(|_| cube()).collect();
        let apart = merged(all.clone());
        let (found, joined) = few(apart.clone());
        assert!(found.len() <= MAX_REGIONS && joined as usize == apart.len() - found.len(), "{found:?}");
        assert_eq!(merged(found.clone()).len(), found.len());
        let holds = |region: &Aabb, one: &Aabb| region.contains(one.min) && region.contains(one.max);
        assert!(all.iter().all(|one| found.iter().any(|region| holds(region, one))));
    }

    #[test]
    fn every_reflector_of_a_scene_without_a_region_is_in_one() {
        for name in ["sphere_room", "two_spheres", "planar_mirror", "car"] {
            let scene = catoptric_scenes::builtin::parse(name).unwrap().pose(&Default::default()).unwrap();
            let regions = Regions::of(&scene, 0.02);
            assert!(scene.specular_objects().iter().all(|object| regions.region_of[*object as usize].is_some()));
        }
    }
}
