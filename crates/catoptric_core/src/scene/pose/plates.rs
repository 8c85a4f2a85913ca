//! Open sheets that are glass by a role: plates.

use super::super::enclosure::FaceSums;
use super::super::{Lobes, Material, Microfacets, Role, Scene};
use crate::math::Aabb;
use std::collections::HashMap;

/// Pairs of sheets that are looked at, at most.
const MOST_PAIRS: usize = 10_000_000;

/// Makes plates of open sheets that are glass by a role, for which `by_role` is true of their material: what passes
/// them goes straight on. Sheets of one material that touch and close each other, as the faces of a box, are a body.
pub(super) fn make_plates(scene: &mut Scene, by_role: impl Fn(u32) -> bool) {
    let open = |(object, sums): &(u32, FaceSums)| {
        let of = &scene.objects[*object as usize];
        of.surface.is_none() && sums.are_open()
    };
    let of_role = (0..scene.objects.len() as u32).filter(|object| by_role(scene.objects[*object as usize].material));
    let sums = of_role.map(|object| (object, FaceSums::default().with(scene, object)));
    let sheets: Vec<(u32, FaceSums)> = sums.filter(open).collect();
    let mut plates: HashMap<u32, u32> = HashMap::new();
    for group in touching(scene, &sheets) {
        let all = group.iter().fold(FaceSums::default(), |all, index| all.plus(sheets[*index].1));
        if !all.are_sheet() {
            continue;
        }
        for index in group {
            let object = sheets[index].0 as usize;
            let material = scene.objects[object].material;
            let plate = *plates.entry(material).or_insert_with(|| {
                scene.materials.push(plate(&scene.materials[material as usize]));
                scene.materials.len() as u32 - 1
            });
            scene.objects[object].material = plate;
        }
    }
}

/// Groups of sheets of one material whose boxes touch, by their indices.
fn touching(scene: &Scene, sheets: &[(u32, FaceSums)]) -> Vec<Vec<usize>> {
    let object = |index: usize| &scene.objects[sheets[index].0 as usize];
    let mut groups: Vec<Vec<usize>> = (0..sheets.len()).map(|index| vec![index]).collect();
    let mut group_of: Vec<usize> = (0..sheets.len()).collect();
    let pairs = (0..sheets.len()).flat_map(|one| (0..one).map(move |other| (one, other)));
    for (one, other) in pairs.take(MOST_PAIRS) {
        let [into, from] = [group_of[other], group_of[one]];
        let is_one_material = object(one).material == object(other).material;
        if into == from || !is_one_material || !touch(&object(one).bounds, &object(other).bounds) {
            continue;
        }
        let moved = std::mem::take(&mut groups[from]);
        moved.iter().for_each(|index| group_of[*index] = into);
        groups[into].extend(moved);
    }
    groups.retain(|group| !group.is_empty());
    groups
}

fn touch(one: &Aabb, other: &Aabb) -> bool {
    let reach = 1e-5 * one.union(*other).corners().iter().map(|corner| corner.abs().max_element()).fold(0.0, f32::max);
    (one.min - reach).cmple(other.max).all() && (other.min - reach).cmple(one.max).all()
}

/// Glass as a plate.
fn plate(glass: &Material) -> Material {
    let at_normal = ((glass.ior - 1.0) / (glass.ior + 1.0)).powi(2);
    let facets = Microfacets { roughness: 0.0, specular: glam::Vec3::splat(at_normal), ..Microfacets::default() };
    Material {
        role: Role::Diffuse,
        microfacets: Some(facets),
        lobes: Some(Box::new(Lobes { transmission: 1.0, is_thin: true, is_plate: true, ..Lobes::default() })),
        double_sided: true,
        unlit: false,
        ..glass.clone()
    }
}
