//! Kept rays against the laws of optics.

use catoptric_core::math::random::Stream;
use catoptric_core::progress::Silent;
use catoptric_core::scene::model::{AnalyticAsset, Model, Node};
use catoptric_core::scene::{Material, Ray, Scene};
use catoptric_core::surface::AnalyticSurface;
use catoptric_engine::light::tracer::Tracer;
use catoptric_engine::optics::path::bundle::BounceKind;
use catoptric_engine::optics::{fresnel_dielectric, reflect, refract};
use catoptric_lookup::parts::{RayTransfer, Regions};
use glam::Vec3;

const RADIUS: f32 = 0.7;

fn ball(material: Material) -> Scene {
    let mut model = Model { materials: vec![material], ..Model::default() };
    let surface = AnalyticSurface::Sphere { radius: f64::from(RADIUS) };
    let analytic = Some(AnalyticAsset { surface, material: 0, inside: false });
    model.nodes.push(Node { analytic, ..Node::default() });
    model.pose(&Default::default()).unwrap()
}

fn captured(scene: &Scene, sizes: [u32; 2], order: u32, has_lenses: bool) -> RayTransfer {
    let region = Regions::of(scene, 0.0).boxes[0];
    let tracer = Tracer::build(scene, |_| true);
    RayTransfer::capture(scene, &tracer, &region, sizes, order, has_lenses, &Silent).unwrap()
}

/// Places of the ball, and directions from there that do not graze it.
fn seen(random: &mut Stream, least_cosine: f32) -> (Vec3, Vec3) {
    loop {
        let mut unit = || Vec3::from([0; 3].map(|_| random.next_between(-1.0, 1.0))).normalize();
        let (normal, towards) = (unit(), unit());
        if normal.dot(towards) > least_cosine {
            return (normal, towards);
        }
    }
}

/// The distance between two rays a few radii away.
fn apart(found: &Ray, origin: Vec3, direction: Vec3) -> f32 {
    let off = found.origin + found.direction * 3.0 - origin;
    (off - direction * off.dot(direction)).length()
}

#[test]
fn a_mirror_ball_sends_rays_where_the_law_says_and_better_with_more_views() {
    let scene = ball(Material::mirror("", Vec3::ONE));
    let mut means = Vec::new();
    for sizes in [[6, 24], [12, 48], [24, 96]] {
        let transfer = captured(&scene, sizes, 1, false);
        let (mut random, mut sum) = (Stream::new(3), 0.0);
        for _ in 0..2000 {
            let (normal, towards) = seen(&mut random, 0.3);
            let found = transfer.look_up(normal * RADIUS, towards, BounceKind::Reflect).expect("it is seen");
            assert!(found.share.distance(Vec3::ONE) < 0.01);
            sum += apart(&found.ray, normal * RADIUS, reflect(-towards, normal));
            assert!(transfer.look_up(normal * RADIUS, towards, BounceKind::Transmit).is_none());
        }
        means.push(sum / 2000.0);
    }
    // Errors of a linear blend fall with the square of the step.
    assert!(means[1] < 0.4 * means[0] && means[2] < 0.4 * means[1] && means[2] < 0.02, "{means:?}");
}

#[test]
fn a_glass_ball_refracts_rays_twice_and_keeps_their_light() {
    const IOR: f32 = 1.4;
    let scene = ball(Material::glass("", IOR));
    let transfer = captured(&scene, [24, 96], 2, true);
    let mut random = Stream::new(4);
    let (mut off, mut lost) = (0.0, 0.0);
    for _ in 0..1000 {
        let (normal, towards) = seen(&mut random, 0.4);
        let inner = refract(-towards, normal, 1.0 / IOR).unwrap();
        let back = normal - inner * (2.0 * normal.dot(inner));
        let outer = refract(inner, -back, IOR).unwrap();
        let transmitted = 1.0 - fresnel_dielectric(inner.dot(back), IOR);
        let found = transfer.look_up(normal * RADIUS, towards, BounceKind::Transmit).expect("it is seen");
        lost += (found.share.x - transmitted).abs() / 1000.0;
        off += apart(&found.ray, back * RADIUS, outer) / 1000.0;
    }
    assert!(off < 0.02 && lost < 0.005, "{off} apart, {lost} of the light");
    // A single event is not enough to get out.
    let short = captured(&scene, [6, 24], 1, true);
    assert!(short.look_up(Vec3::X * RADIUS, Vec3::X, BounceKind::Transmit).is_none());
}

#[test]
fn what_is_no_ray_of_the_region_has_no_answer() {
    let transfer = captured(&ball(Material::mirror("", Vec3::ONE)), [4, 8], 1, false);
    for (position, towards) in [
        (Vec3::NAN, Vec3::X),
        (Vec3::ZERO, Vec3::NAN),
        (Vec3::ZERO, Vec3::ZERO),
        (Vec3::splat(50.0), Vec3::X),
        (Vec3::splat(-50.0), Vec3::X),
    ] {
        let found = transfer.look_up(position, towards, BounceKind::Reflect);
        assert!(found.is_none_or(|found| found.ray.direction.is_finite()), "{position} {towards}");
    }
    assert!(transfer.look_up(Vec3::NAN, Vec3::X, BounceKind::Reflect).is_none());
}
