//! Hits of rays on the depths of textures.

use catoptric_core::math::Aabb;
use catoptric_core::math::lanes::Vec3Lanes;
use catoptric_core::math::random::Stream;
use catoptric_core::scene::Ray;
use catoptric_engine::light::parallax_proxy::ParallaxProxy;
use catoptric_lookup::parts::{Depth, Distances, Layer, LayerTexture, RayLanes, Shell, TexelLayout};
use glam::{Vec2, Vec3};

const RADIUS: f32 = 3.0;

/// Depths from the centre of a spherical shell by direction, in units of its radius (`None`: no surface).
fn seen(size: u32, distance: impl Fn(Vec3) -> Option<f32>) -> (Shell, Distances) {
    solid(size, |direction| distance(direction).map(|distance| [distance; 2]))
}

/// A layer of solids on a sphere, by the distances at which they begin and end.
fn solid(size: u32, distances: impl Fn(Vec3) -> Option<[f32; 2]>) -> (Shell, Distances) {
    solid_on(ParallaxProxy::Sphere(RADIUS), size, distances)
}

/// A layer of solids on any shell.
fn solid_on(surround: ParallaxProxy, size: u32, distances: impl Fn(Vec3) -> Option<[f32; 2]>) -> (Shell, Distances) {
    let layout = TexelLayout::cube(size);
    let shell = Shell::Around(surround);
    let texel = |index: u32| {
        let direction = layout.middle_of(index).normalize();
        let own = shell.distance(Vec3::ZERO, direction);
        let depth = |[front, back]: [f32; 2]| Depth { front: front / own, back: back / own };
        distances(direction).map_or(Depth::NOTHING, depth)
    };
    let depths: Vec<Depth> = (0..6 * size * size).map(texel).collect();
    (shell, Distances::new(&shell, layout, &depths))
}

/// Distance of a ray's hit.
fn met(shell: &Shell, distances: &Distances, origin: Vec3, direction: Vec3) -> Option<Vec3> {
    let rays = RayLanes::sharp(Vec3Lanes::one(origin), Vec3Lanes::one(direction));
    let met = distances.met(shell, &rays, &[true]);
    met.is_met[0].then(|| origin + direction * met.distance[0])
}

#[test]
fn rays_meet_planes_where_planes_are() {
    let mut random = Stream::new(4);
    for normal in [Vec3::Z, Vec3::new(0.6, 0.0, 0.8), Vec3::new(-0.2, -0.9, 0.3).normalize()] {
        let plane = |direction: Vec3| {
            let distance = 2.0 / direction.dot(normal);
            (distance > 0.0 && distance < 8.0).then_some(distance)
        };
        let (shell, distances) = seen(256, plane);
        let (mut checked, mut worst) = (0, 0.0f32);
        for _ in 0..2000 {
            let mut vector = || Vec3::from([0; 3].map(|_| random.next_between(-1.0, 1.0)));
            let (origin, direction) = (vector() * 0.8, vector().normalize());
            let truth = origin + direction * (2.0 - origin.dot(normal)) / direction.dot(normal);
            // Only places away from the rim of the visible part count.
            if direction.dot(normal) < 0.2 || truth.length() > 7.0 {
                continue;
            }
            let found = met(&shell, &distances, origin, direction);
            let off = found.map_or(f32::INFINITY, |found| found.normalize().distance(truth.normalize()));
            (checked, worst) = (checked + 1, worst.max(off));
        }
        // A texel is 0.008 wide in the middle of a face.
        assert!(checked > 500 && worst < 0.008, "{normal}: {checked} rays, {worst}");
    }
}

/// Distances at which a ray from the centre enters and leaves a ball.
fn through_ball(middle: Vec3, radius: f32, direction: Vec3) -> Option<[f32; 2]> {
    let along = direction.dot(middle);
    let under_root = along * along - middle.length_squared() + radius * radius;
    (along > 0.0 && under_root > 0.0).then(|| [along - under_root.sqrt(), along + under_root.sqrt()])
}

#[test]
fn rays_meet_a_table_up_to_its_rim_and_pass_over_it() {
    const RIM: f32 = 2.5;
    let (top, bottom) = (-0.6, -0.7);
    let table = |direction: Vec3| {
        let aside = Vec2::new(direction.x, direction.z).length();
        let (front, back) = (top / direction.y, (bottom / direction.y).min(RIM / aside));
        (direction.y < 0.0 && front * aside < RIM).then_some([front, back])
    };
    let (shell, distances) = solid(256, table);
    let mut random = Stream::new(9);
    let (mut on_it, mut past_it) = (0, 0);
    for _ in 0..2000 {
        let mut number = |low: f32, high: f32| random.next_between(low, high);
        let origin = Vec3::new(number(-0.8, 0.8), number(-0.3, 0.8), number(-0.8, 0.8));
        let (out, turn) = (number(0.5, 3.5), number(0.0, std::f32::consts::TAU));
        let target = Vec3::new(out * turn.cos(), top, out * turn.sin());
        let direction = (target - origin).normalize();
        let found = met(&shell, &distances, origin, direction);
        if out < RIM - 0.05 {
            let off = found.map_or(f32::INFINITY, |found| found.distance(target));
            assert!(off < 0.05, "{origin} to {target}: {found:?}");
            on_it += 1;
        } else if out > RIM + 0.3 {
            // Within an edge's tolerance of the rim it may still be taken for the rim's.
            assert!(
                found.is_none_or(|found| Vec2::new(found.x, found.z).length() < RIM + 0.2),
                "{origin} to {target}: {found:?}"
            );
            past_it += u32::from(found.is_none());
        }
    }
    assert!(on_it > 800 && past_it > 300, "{on_it}, {past_it}");
}

#[test]
fn rays_meet_things_on_their_way_into_shells_too() {
    // A ball on the bottom of a wide box: the higher a place near it is, the smaller is the box that goes through it.
    let (middle, radius) = (Vec3::new(0.1, -0.4, 1.2), 0.25);
    let bounds = Aabb { min: Vec3::new(-8.0, -0.7, -8.0), max: Vec3::new(8.0, 3.0, 8.0) };
    let (shell, distances) =
        solid_on(ParallaxProxy::Box(bounds), 256, |direction| through_ball(middle, radius, direction));
    let layout = distances.layout.clone();
    let texture = LayerTexture { layout, texels: Vec::new() };
    let layer = Layer { center: Vec3::ZERO, shell, distances: Some(distances.clone()), texture };
    let mut random = Stream::new(12);
    let mut checked = 0;
    for _ in 0..2000 {
        let mut number = |low: f32, high: f32| random.next_between(low, high);
        let origin = Vec3::new(number(-0.4, 0.4), number(-0.69, 0.0), number(-0.2, 0.6));
        let target = middle + radius * 0.8 * Vec3::new(number(-0.5, 0.5), number(-0.5, 0.5), number(-0.5, 0.5));
        let direction = (target - origin).normalize();
        let arm = origin - middle;
        let along = arm.dot(direction);
        let truth = -along - (along * along - arm.length_squared() + radius * radius).max(0.0).sqrt();
        let place = origin + direction * truth;
        // The place is in sight from the centre, and away from the edge of the visible part.
        if (place - middle).dot(place) > -0.15 * radius * place.length() {
            continue;
        }
        let found = met(&shell, &distances, origin, direction);
        let off = found.map_or(f32::INFINITY, |found| found.distance(place));
        assert!(off < 0.03, "{origin} to {target}: {found:?}, not {place}");
        // The texel that is looked up lies there, too.
        let texel = layer.texel_at(&Ray { origin, direction }).expect("it is met");
        assert!(layer.texture.layout.middle_of(texel).angle_between(place) < 0.03, "{origin} to {target}");
        checked += 1;
    }
    assert!(checked > 1000, "{checked}");
}

#[test]
fn what_a_thing_hides_goes_on_behind_it() {
    // A floor, a part of which is behind a ball.
    let (middle, radius) = (Vec3::new(1.5, -0.2, 0.0), 0.3);
    let look = |direction: Vec3| {
        let floor = Some(-0.6 / direction.y).filter(|distance| *distance > 0.0 && *distance < 8.0);
        through_ball(middle, radius, direction).or(floor.map(|distance| [distance; 2]))
    };
    let (shell, distances) = solid(256, look);
    let (origin, target) = (Vec3::new(0.6, -0.3, 0.8), Vec3::new(2.4, -0.6, 0.0));
    assert!(through_ball(middle, radius, target.normalize()).is_some(), "the ball hides it from the centre");
    let found = met(&shell, &distances, origin, (target - origin).normalize()).expect("the floor goes on");
    // The floor is seen, beside the ball.
    let texel = 2.0 / 256.0;
    assert!(found.angle_between(middle) > (radius / middle.length()).asin() - texel, "{found}");
    // A part of the floor that is in sight is met in its place, on either side of the ball.
    for target in [Vec3::new(1.2, -0.6, 1.2), Vec3::new(1.9, -0.6, -2.5)] {
        let found = met(&shell, &distances, origin, (target - origin).normalize()).expect("the floor is in sight");
        assert!(found.distance(target) < 0.05, "{found}, {target}");
    }
}

#[test]
fn rays_pass_what_they_do_not_meet() {
    // A small ball in front of the centre.
    let middle = Vec3::new(0.0, 0.0, 2.0);
    let ball = |direction: Vec3| through_ball(middle, 0.5, direction);
    let (shell, distances) = solid(128, ball);
    let origin = Vec3::new(1.0, 0.0, 0.0);
    let towards = |target: Vec3| met(&shell, &distances, origin, (target - origin).normalize());
    let found = towards(middle).expect("the ball is there");
    assert!((found.distance(middle) - 0.5).abs() < 0.03, "{found}");
    // These rays go before it, beside it, and away from it.
    assert_eq!(towards(Vec3::new(0.0, 0.0, 1.0)), None);
    assert_eq!(towards(Vec3::new(2.0, 0.0, 2.0)), None);
    assert_eq!(towards(Vec3::new(-1.0, 3.0, 0.0)), None);
    // Past it, and on where it is between the ray and the centre.
    let beyond = Vec3::new(0.0, 0.0, 4.0);
    assert_eq!(met(&shell, &distances, origin + Vec3::Z, (beyond - origin - Vec3::Z).normalize()), None);
    let (shell, nothing) = seen(8, |_| None);
    assert_eq!(met(&shell, &nothing, Vec3::ZERO, Vec3::X), None);
}

#[test]
fn what_a_ray_meets_does_not_depend_on_those_beside_it() {
    // A floor with two balls on it, in a box: depths with edges, and rays that differ much.
    let balls = [(Vec3::new(1.5, -0.2, 0.0), 0.3), (Vec3::new(-0.6, -0.1, 1.4), 0.4)];
    let look = |direction: Vec3| {
        let floor = Some(-0.6 / direction.y).filter(|distance| *distance > 0.0 && *distance < 8.0);
        let ball = balls.into_iter().find_map(|(middle, radius)| through_ball(middle, radius, direction));
        ball.or(floor.map(|distance| [distance; 2]))
    };
    let bounds = Aabb { min: Vec3::new(-8.0, -0.7, -8.0), max: Vec3::new(8.0, 3.0, 8.0) };
    let mut random = Stream::new(17);
    for surround in [ParallaxProxy::Sphere(RADIUS), ParallaxProxy::Box(bounds)] {
        let (shell, distances) = solid_on(surround, 128, look);
        let (mut met, mut passed) = (0, 0);
        for batch in 0..200 {
            let mut vector = |size: f32| Vec3::from([0; 3].map(|_| random.next_between(-size, size)));
            // The batches go from rays that stay together to rays that go anywhere.
            let spread: f32 = [0.02, 0.2, 1.0, 3.0][batch % 4];
            let (origin, target) = (vector(0.5), vector(2.0));
            let origins: [Vec3; 32] = std::array::from_fn(|_| origin + vector(0.2 * spread.min(1.0)));
            let directions = origins.map(|origin| (target + vector(spread) - origin).normalize());
            let wanted = std::array::from_fn(|lane| lane % 7 != 3);
            let rays = RayLanes::sharp(Vec3Lanes::new(&origins), Vec3Lanes::new(&directions));
            let together = distances.met(&shell, &rays, &wanted);
            for lane in (0..32).filter(|lane| wanted[*lane]) {
                let ray = RayLanes::sharp(Vec3Lanes::one(origins[lane]), Vec3Lanes::one(directions[lane]));
                let alone = distances.met(&shell, &ray, &[true]);
                assert_eq!(together.is_met[lane], alone.is_met[0], "batch {batch}, lane {lane}");
                if alone.is_met[0] {
                    let of = |hit: f32, share: f32| (hit.to_bits(), share.to_bits());
                    let found = of(together.distance[lane], together.share[lane]);
                    assert_eq!(found, of(alone.distance[0], alone.share[0]), "batch {batch}, lane {lane}");
                    assert_eq!(together.is_inward[lane], alone.is_inward[0]);
                }
                met += u32::from(alone.is_met[0]);
                passed += u32::from(!alone.is_met[0]);
            }
        }
        assert!(met > 1000 && passed > 1000, "{met}, {passed}");
    }
}
