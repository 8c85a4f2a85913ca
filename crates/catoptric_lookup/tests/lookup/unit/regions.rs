//! Boxes of reflectors.

use catoptric_core::math::Aabb;
use catoptric_lookup::parts::{MAX_REGIONS, Regions, few, merged};
use glam::Vec3;

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
