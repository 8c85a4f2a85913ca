//! Regions: boxes about reflectors that belong together, in world space.

use catoptric_core::math::Aabb;
use catoptric_core::scene::Scene;
use glam::Vec3;

/// Boxes are no flatter than this share of their diagonal. Chosen, not measured.
const MIN_DEPTH: f32 = 0.02;

/// The maximum number of regions: the surroundings of each are captured. A bound on time and memory; chosen, not
/// measured.
pub const MAX_REGIONS: usize = 4;

/// The maximum number of regions with captures of full size; more share as many texels, where nothing is baked. A bound
/// on time and memory; chosen, not measured.
const MAX_FULL_REGIONS: usize = 2;

/// Boxes of reflectors and lenses, and the box of each object.
pub struct Regions {
    /// Their boxes.
    pub boxes: Vec<Aabb>,
    /// Boxes that do not overlap and have become one all the same, because there were too many.
    pub(crate) joined: u64,
    /// The number of each object's region, for every object of the scene.
    pub region_of: Vec<Option<u32>>,
}

impl Regions {
    /// The scene's region, with the reflectors and lenses in it; where it has none, a box about each of them, larger by
    /// a share of its diagonal, and one about those whose boxes overlap, or that are nearest where there are too many.
    pub fn of(scene: &Scene, margin: f32) -> Self {
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

/// A bound of the rounding error of an object's positions.
fn rounding(bounds: &Aabb) -> f32 {
    64.0 * f32::EPSILON * bounds.center().abs().max_element()
}

/// Boxes that do not overlap, about those that do.
pub fn merged(mut boxes: Vec<Aabb>) -> Vec<Aabb> {
    let mut index = 0;
    while index < boxes.len() {
        match (index + 1..boxes.len()).find(|other| overlap(&boxes[index], &boxes[*other])) {
            Some(other) => {
                boxes[index] = boxes[index].union(boxes.swap_remove(other));
                // The box has grown: it may reach others now, also earlier ones.
                index = 0;
            }
            None => index += 1,
        }
    }
    boxes
}

/// Joins boxes that do not overlap until there are at most [`MAX_REGIONS`]: those whose union is smallest become one,
/// with all that it reaches. The second value counts the boxes that others take in. Takes time with the square of their
/// number.
pub fn few(mut boxes: Vec<Aabb>) -> (Vec<Aabb>, u64) {
    let mut left: Vec<bool> = vec![true; boxes.len()];
    // The size of the smallest union of each box, and the box that it is with.
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
            // The union may reach others.
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
