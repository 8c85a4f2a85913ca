//! Bodies of glass and liquid that touch, overlap or lie within each other, against the laws of optics.

use catoptric::light::bodies::remarks_on_bodies;
use catoptric::light::path_tracer::{PathModel, PathTracer};
use catoptric::light::tracer::Tracer;
use catoptric::math::random::Stream;
use catoptric::optics::fresnel_dielectric;
use catoptric::scene::model::LocalTransform;
use catoptric::scene::roles::RoleRule;
use catoptric::scene::{Material, Ray, Scene};
use catoptric_testkit::scenes::SceneBuilder;
use glam::{DQuat, DVec3, Quat, Vec3};
use std::sync::Arc;

fn between(numbers: &mut Stream, low: f64, high: f64) -> f64 {
    low + (high - low) * f64::from(numbers.next_unit())
}

/// A slab across the axis.
#[derive(Clone, Copy, Debug)]
struct Slab {
    /// From below to above; both are numbers of single precision.
    z: [f64; 2],
    ior: f32,
}

/// Half of the width of slabs.
const REACH: f32 = 8.0;

/// A few slabs, each touching the one before, apart from it, overlapping it a little, or within it.
fn stack(numbers: &mut Stream) -> Vec<Slab> {
    let mut slabs: Vec<Slab> = Vec::new();
    let rounded = |value: f64| f64::from(value as f32);
    for _ in 0..2 + (numbers.next_unit() * 3.0) as usize {
        let thickness = between(numbers, 0.05, 0.6);
        let last = slabs.last().map_or([0.0, between(numbers, 0.2, 1.0)], |slab| slab.z);
        let z = match (numbers.next_unit() * 4.0) as u32 {
            0 => [last[0] - thickness, last[0]],
            1 => {
                let gap = 10f64.powf(between(numbers, -4.0, 0.0));
                [last[0] - gap - thickness, last[0] - gap]
            }
            2 => [last[0] - thickness, last[0] + 0.01],
            _ => {
                let inner = (last[1] - last[0]) * 0.5;
                [last[0] + 0.4 * inner, last[0] + 1.2 * inner]
            }
        };
        // Water, glass and flint, so that some are alike.
        let ior = [1.33, 1.5, 1.5, 1.8][(numbers.next_unit() * 4.0) as usize];
        slabs.push(Slab { z: z.map(rounded), ior });
    }
    slabs
}

/// The index of refraction at a height: of the smallest body that is there.
fn index_at(slabs: &[Slab], z: f64) -> f64 {
    let there = slabs.iter().filter(|slab| slab.z[0] < z && z < slab.z[1]);
    let thickness = |slab: &&Slab| slab.z[1] - slab.z[0];
    there.min_by(|one, other| thickness(one).total_cmp(&thickness(other))).map_or(1.0, |slab| f64::from(slab.ior))
}

/// The step aside of a ray that runs down from a height to another one, by Snell's law, and how often it is refracted.
fn step_aside(slabs: &[Slab], [top, bottom]: [f64; 2], sine: f64) -> (f64, u32) {
    let mut heights: Vec<f64> = slabs.iter().flat_map(|slab| slab.z).chain([top, bottom]).collect();
    heights.retain(|height| *height <= top);
    heights.sort_by(|one, other| other.total_cmp(one));
    let (mut aside, mut refractions, mut before) = (0.0, 0, 1.0);
    for pair in heights.windows(2).filter(|pair| pair[0] > pair[1]) {
        let index = index_at(slabs, 0.5 * (pair[0] + pair[1]));
        refractions += u32::from(index != before);
        before = index;
        let sine = sine / index;
        aside += (pair[0] - pair[1]) * sine / (1.0 - sine * sine).sqrt();
    }
    (aside, refractions)
}

/// The slabs over a ruler, all so far away from the file's origin.
fn scene_of(slabs: &[Slab], ruler_z: f32, away: DVec3) -> Scene {
    let mut builder = SceneBuilder::new();
    for (index, slab) in slabs.iter().enumerate() {
        let glass = builder.material(Material::glass(&format!("glass {index}"), slab.ior));
        let [low, high] = slab.z.map(|z| z as f32);
        let (min, max) = (Vec3::new(-REACH, -REACH, low), Vec3::new(REACH, REACH, high));
        builder.cuboid(&format!("slab {index}"), min, max, false, glass);
    }
    builder.ruler("ruler", Vec3::new(-10.0, -10.0, ruler_z), Vec3::X * 20.0, Vec3::Y * 20.0);
    let model = builder.model_mut();
    for node in &mut model.nodes {
        node.local = LocalTransform::Rigid { translation: away, rotation: DQuat::IDENTITY };
    }
    model.move_near_origin().expect("the nodes are right");
    builder.build()
}

#[test]
fn stacks_of_slabs_refract_as_snell_says() {
    let mut numbers = Stream::new(7);
    let mut differing = 0;
    for number in 0..2000 {
        let slabs = stack(&mut numbers);
        let bottom = slabs.iter().map(|slab| slab.z[0]).fold(0.0, f64::min) - 0.5;
        let bottom = f64::from(bottom as f32);
        let away = match number % 3 {
            0 => DVec3::from_array([(); 3].map(|()| between(&mut numbers, -1e7, 1e7))),
            _ => DVec3::ZERO,
        };
        let scene = scene_of(&slabs, bottom as f32, away);
        let moved = (away - scene.origin).as_vec3();
        let tracer = Tracer::build(&scene, |_| true);
        for _ in 0..3 {
            // From above, or from within what is there.
            let top = if numbers.next_unit() < 0.7 { 2.5 } else { between(&mut numbers, bottom + 0.1, 1.5) };
            let top = f64::from(top as f32);
            let is_near_face = slabs.iter().flat_map(|slab| slab.z).any(|z| (z - top).abs() < 1e-3);
            let slope = between(&mut numbers, -0.9, 0.9);
            let direction = Vec3::new(slope as f32, 0.0, -1.0).normalize();
            let sine = f64::from(direction.x).abs() * index_at(&slabs, top);
            // Light that is reflected totally on its way does not arrive.
            if is_near_face || sine > 0.95 {
                continue;
            }
            let (aside, refractions) = step_aside(&slabs, [top, bottom], sine);
            let refractions = refractions - u32::from(index_at(&slabs, top) != 1.0);
            let expected = aside * slope.signum();
            let ray = Ray { origin: moved + Vec3::new(0.05, 0.02, top as f32), direction };
            let light = PathTracer::new(&scene, &tracer, PathModel::Tree, refractions).radiance_along(ray, None, 0.0);
            let found = (light.x / light.z - 0.5) * 20.0 - 0.05;
            // Not a number where nothing arrives.
            let is_right = (f64::from(found) - expected).abs() < 2e-3;
            assert!(is_right, "stack {number}: {found} {expected} {slabs:?} from {top}, slope {slope}");
            differing += u32::from(refractions > 1);
        }
    }
    assert!(differing > 2000, "{differing}");
}

#[test]
fn faces_in_one_place_reflect_as_one_interface() {
    // Water under glass, of the same faces in the same place; blocks of one glass; a block twice.
    let [glass, water] = [1.5, 1.33].map(|ior| (ior, [-1.0, 0.0]));
    for (slabs, reflected) in [
        (vec![(1.5, [0.0, 1.0]), water], fresnel_dielectric(1.0, 1.5 / 1.33)),
        (vec![(1.5, [0.0, 1.0]), glass], 0.0),
        (vec![(1.5, [-1.0, 1.0]), (1.5, [-1.0, 1.0])], 0.0),
    ] {
        let slabs: Vec<Slab> = slabs.into_iter().map(|(ior, z)| Slab { z, ior }).collect();
        let scene = scene_of(&slabs, -3.0, DVec3::ZERO);
        let tracer = Tracer::build(&scene, |_| true);
        let ray = Ray { origin: Vec3::new(0.3, 0.2, 2.0), direction: Vec3::NEG_Z };
        let light = PathTracer::new(&scene, &tracer, PathModel::Tree, 3).radiance_along(ray, None, 0.0);
        let last = slabs.last().map_or(1.0, |slab| slab.ior);
        let [first, second] = [1.0 / 1.5, last].map(|eta| 1.0 - fresnel_dielectric(1.0, eta));
        // Blue is 1 all over the ruler; orders above 3 would add what is reflected twice.
        let expected = first * second * (1.0 - reflected);
        assert!((light.z - expected).abs() < 1e-3, "{slabs:?}: {} {expected}", light.z);
    }
}

/// A block of glass stands on a table, over a film of air, with a label in the plane of its upper side and a mirror in
/// that of the table beside it; all is turned, so that nothing is rounded alike.
#[test]
fn what_lies_in_the_plane_of_glass_and_mirrors_is_seen_wherever_rays_come_from() {
    let mut builder = SceneBuilder::new();
    let sheet = |builder: &mut SceneBuilder, name: &str, low: [f32; 2], size: [f32; 2], height: f32, material| {
        let corner = Vec3::new(low[0], low[1], height);
        builder.quad(name, corner, Vec3::X * size[0], Vec3::Y * size[1], material);
    };
    let [red, green, blue] = [Vec3::X, Vec3::Y, Vec3::Z].map(|color| builder.flat(&format!("{color}"), color));
    let glass = builder.material(Material::glass("glass", 1.5));
    let mirror = builder.material(Material::mirror("mirror", Vec3::ONE));
    sheet(&mut builder, "below the table", [-9.0; 2], [18.0; 2], -1.0, blue);
    sheet(&mut builder, "table", [-9.0; 2], [18.0; 2], 0.0, green);
    builder.cuboid("glass", Vec3::new(-1.0, -1.0, 0.0), Vec3::new(1.0, 1.0, 0.7), false, glass);
    sheet(&mut builder, "label", [-0.4, -0.3], [0.9, 0.5], 0.7, red);
    sheet(&mut builder, "mirror", [2.0, -1.0], [2.0, 2.0], 0.0, mirror);
    let turn = Quat::from_axis_angle(Vec3::new(0.3, 1.0, 0.2).normalize(), 0.9);
    for node in &mut builder.model_mut().nodes {
        node.local = LocalTransform::Rigid { translation: DVec3::ZERO, rotation: turn.as_dquat() };
    }
    let scene = builder.build();
    let tracer = Tracer::build(&scene, |_| true);
    let mut numbers = Stream::new(5);
    let mut random = |low: f32, high: f32| low + (high - low) * numbers.next_unit();
    for _ in 0..2000 {
        let towards = Vec3::new(random(-1.0, 1.0), random(-1.0, 1.0), random(-2.0, -0.7)).normalize();
        let arriving = |at: Vec3, order: u32| {
            let ray = Ray { origin: turn * (at - 3.0 * towards), direction: turn * towards };
            PathTracer::new(&scene, &tracer, PathModel::Tree, order).radiance_along(ray, None, 0.0)
        };
        assert_eq!(arriving(Vec3::new(random(-0.39, 0.49), random(-0.29, 0.19), 0.7), 4), Vec3::X);
        // At order 0 the mirror is black.
        assert_eq!(arriving(Vec3::new(random(2.2, 3.8), random(-0.8, 0.8), 0.0), 0), Vec3::ZERO);
        assert_eq!(arriving(Vec3::new(random(-9.0, -4.0), random(-4.0, 4.0), 0.0), 4), Vec3::Y);
        // The table is seen by what the upper and the lower side of the glass let pass.
        let through = arriving(Vec3::new(random(-0.2, 0.2), random(0.3, 0.45), 0.7), 2);
        let expected = Vec3::Y * (1.0 - fresnel_dielectric(-towards.z, 1.0 / 1.5)).powi(2);
        assert!((through - expected).abs().max_element() < 1e-3, "{through} {expected} {towards}");
    }
}

/// The view of an eye within water through a wall of glass, and how much the water absorbs.
#[test]
fn an_eye_within_a_body_sees_by_its_medium() {
    let mut builder = SceneBuilder::new();
    let absorption = Vec3::splat(0.4);
    let water = builder.material(Material { absorption, ..Material::glass("water", 1.33) });
    builder.cuboid("water", Vec3::splat(-2.0), Vec3::splat(2.0), false, water);
    let paint = builder.flat("paint", Vec3::ONE);
    builder.cuboid("stone", Vec3::new(-0.5, -0.5, -1.5), Vec3::new(0.5, 0.5, -1.0), false, paint);
    let scene = builder.build();
    let tracer = Tracer::build(&scene, |_| true);
    let ray = Ray { origin: Vec3::new(0.1, 0.1, 1.0), direction: Vec3::NEG_Z };
    let light = PathTracer::new(&scene, &tracer, PathModel::Tree, 2).radiance_along(ray, None, 0.0);
    let expected = (-0.4f32 * 2.0).exp();
    assert!((light.x - expected).abs() < 1e-4, "{} {expected}", light.x);
}

/// Ice that reaches out of the water, and the same with the water's priority above it.
#[test]
fn of_bodies_in_one_place_that_of_the_greater_priority_is_there() {
    for (priority, expected) in [(0, 1.3), (2, 1.7)] {
        let mut builder = SceneBuilder::new();
        let water = builder.material(Material { priority, ..Material::glass("water", 1.7) });
        builder.cuboid("water", Vec3::splat(-2.0), Vec3::splat(1.0), false, water);
        let ice = builder.material(Material::glass("ice", 1.3));
        builder.cuboid("ice", Vec3::new(-0.5, -0.5, -0.5), Vec3::new(0.5, 0.5, 0.5), false, ice);
        let paint = builder.flat("paint", Vec3::ONE);
        builder.cuboid("stone", Vec3::splat(-0.2), Vec3::splat(0.2), false, paint);
        let scene = builder.build();
        let tracer = Tracer::build(&scene, |_| true);
        let ray = Ray { origin: Vec3::new(0.1, 0.1, 2.0), direction: Vec3::NEG_Z };
        let light = PathTracer::new(&scene, &tracer, PathModel::Tree, 3).radiance_along(ray, None, 0.0);
        let transmitted = |eta: f32| 1.0 - fresnel_dielectric(1.0, eta);
        let expected = transmitted(1.0 / 1.7) * transmitted(1.7 / expected);
        assert!((light.x - expected).abs() < 1e-4, "{priority}: {} {expected}", light.x);
    }
}

/// A pane of one sheet that is glass by a role: light passes it straight, and both of its sides reflect. A box of such
/// sheets is a body.
#[test]
fn open_sheets_that_are_glass_by_a_role_are_plates() {
    let scene = |is_box: bool| {
        let mut builder = SceneBuilder::new();
        let paint = builder.material(Material::diffuse("paint", Vec3::ONE));
        let behind = builder.flat("behind", Vec3::new(0.0, 0.0, 1.0));
        let before = builder.flat("before", Vec3::new(1.0, 0.0, 0.0));
        let (x, y, z) = (Vec3::X * 2.0, Vec3::Y * 2.0, Vec3::Z * 2.0);
        let low = Vec3::new(-1.0, -1.0, -2.0);
        builder.quad("pane", low + z, x, y, paint);
        if is_box {
            for (number, [corner, u, v]) in
                [[low, y, x], [low, x, z], [low + y, z, x], [low, z, y], [low + x, y, z]].into_iter().enumerate()
            {
                builder.quad(&format!("pane {number}"), corner, u, v, paint);
            }
        }
        builder.quad("behind", Vec3::new(-50.0, -50.0, -5.0), Vec3::X * 100.0, Vec3::Y * 100.0, behind);
        builder.quad("before", Vec3::new(50.0, -50.0, 5.0), Vec3::X * -100.0, Vec3::Y * 100.0, before);
        builder.model_mut().roles.push(RoleRule::parse_lens("pane*:1.6").unwrap());
        builder.build()
    };
    let pane = scene(false);
    let tracer = Tracer::build(&pane, |_| true);
    let mut numbers = Stream::new(3);
    for _ in 0..200 {
        let towards = Vec3::new(0.8 * (numbers.next_unit() - 0.5), numbers.next_unit(), -0.6).normalize();
        let ray = Ray { origin: -towards, direction: towards };
        let light = PathTracer::new(&pane, &tracer, PathModel::Tree, 2).radiance_along(ray, None, 0.0);
        let one_side = fresnel_dielectric(-towards.z, 1.0 / 1.6);
        let reflected = 2.0 * one_side / (1.0 + one_side);
        let expected = Vec3::new(reflected, 0.0, 1.0 - reflected);
        assert!((light - expected).abs().max_element() < 1e-4, "{light} {expected}");
    }
    let told = remarks_on_bodies(&pane);
    assert!(matches!(&told[..], [one] if one.contains("`pane` is open: drawn as a thin plate")), "{told:?}");
    let closed = scene(true);
    assert!(closed.specular_objects().len() == 6 && remarks_on_bodies(&closed).is_empty());
}

/// A ball and a hollow in it are as they should be, the same hollow alone is not, and a pane without an other side is
/// open.
#[test]
fn bodies_that_cannot_be_meant_so_are_told() {
    let remarks = |add: &dyn Fn(&mut SceneBuilder, usize)| {
        let mut builder = SceneBuilder::new();
        let glass = builder.material(Material::glass("glass", 1.5));
        let paint = builder.material(Material::diffuse("paint", Vec3::ONE));
        builder.quad("wall", Vec3::new(-9.0, -9.0, -5.0), Vec3::X, Vec3::Y, paint);
        add(&mut builder, glass);
        remarks_on_bodies(&builder.build())
    };
    let ball = |builder: &mut SceneBuilder, glass| builder.sphere_mesh("ball", Vec3::ZERO, 1.0, 8, glass);
    let hollow = |builder: &mut SceneBuilder, glass| {
        builder.cuboid("hollow", Vec3::splat(-0.3), Vec3::splat(0.3), true, glass);
    };
    assert_eq!(remarks(&ball), [""; 0]);
    let both = |builder: &mut SceneBuilder, glass| {
        ball(builder, glass);
        hollow(builder, glass);
    };
    assert_eq!(remarks(&both), [""; 0]);
    let told = remarks(&hollow);
    assert!(matches!(&told[..], [one] if one.contains("`hollow` is turned inside out")), "{told:?}");
    let told = remarks(&|builder, glass| builder.quad("pane", Vec3::ZERO, Vec3::X, Vec3::Y, glass));
    assert!(matches!(&told[..], [one] if one.contains("`pane` has no closed surface")), "{told:?}");
}

/// Mirrors and glass alone show nothing, but for light from infinity and a colour of their own.
#[test]
fn scenes_with_nothing_to_be_seen_in_mirrors_are_told() {
    let remarks = |mirror: Material, is_lit: bool| {
        let mut builder = SceneBuilder::new();
        let mirror = builder.material(mirror);
        builder.sphere_mesh("ball", Vec3::ZERO, 1.0, 8, mirror);
        builder.model_mut().environment = is_lit.then(|| Arc::new(catoptric_scenes::studio()));
        remarks_on_bodies(&builder.build())
    };
    let mirror = || Material::mirror("mirror", Vec3::ONE);
    for dark in [mirror(), Material::glass("glass", 1.5)] {
        let told = remarks(dark.clone(), false);
        assert!(matches!(&told[..], [one] if one.contains("nothing to be seen in mirrors")), "{told:?}");
        assert_eq!(remarks(dark, true), [""; 0]);
    }
    assert_eq!(remarks(Material { mirror_roughness: 0.3, ..mirror() }, false), [""; 0]);
    assert_eq!(remarks(Material::diffuse("paint", Vec3::ONE), false), [""; 0]);
}
