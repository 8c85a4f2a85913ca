//! Both paths of a lens against the reference.

use catoptric_core::math::random::Stream;
use catoptric_core::scene::{Ray, RayDifferential, Role, Scene};
use catoptric_engine::light::path_tracer::{PathModel, PathTracer};
use catoptric_engine::light::radiance_field::RadianceField;
use catoptric_engine::light::reflector_shader::FirstSurface;
use catoptric_engine::light::tracer::Tracer;
use catoptric_engine::light::two_path_tracer::TwoPathTracer;
use catoptric_engine::optics::path::bundle::BounceKind;
use catoptric_scenes::builtin;
use glam::Vec3;

/// Radiance that encodes its direction.
#[derive(Clone, Copy)]
struct Sky;

impl Sky {
    fn of(direction: Vec3) -> Vec3 {
        direction * 0.5 + 0.6
    }
}

impl RadianceField for Sky {
    fn radiance(&self, _: &Scene, ray: &Ray, _: Option<&RayDifferential>) -> Vec3 {
        Self::of(ray.direction)
    }
}

#[test]
fn both_paths_are_those_of_the_reference() {
    // A pot of glass and a mirror cup: each is seen in the other.
    let scene = builtin::parse("colonnade?tess=24").unwrap().pose(&Default::default()).unwrap();
    let tracer = Tracer::build(&scene, |object| scene.role_of(object).is_specular());
    let order = 6;
    let paths = TwoPathTracer { scene: &scene, tracer: &tracer, order };
    let mut reference = PathTracer::with_field(&scene, &tracer, PathModel::TwoPath, order, Sky);
    let view = scene.default_view(320, 240);
    let mut random = Stream::new(4);
    let (mut checked, mut divided_later) = (0, 0);
    for _ in 0..40_000 {
        let ray = view.ray(random.next_between(0.0, 320.0), random.next_between(0.0, 240.0));
        let Some(hit) = tracer.first_hit(&scene, &ray, 0.0) else { continue };
        let point = tracer.point(&scene, &ray, &hit);
        let FirstSurface { own, shares, .. } = FirstSurface::of(&scene, &point, ray.direction, |_| None);
        let found = BounceKind::BOTH.into_iter().zip(shares).fold(own, |sum, (first, share)| {
            let path = paths.follow(ray.direction, point, first);
            let arrives = path.leaving.map_or(Vec3::ZERO, |leaving| path.share * Sky::of(leaving.direction));
            let is_mirror = scene.role_of(point.object) != Role::Lens;
            divided_later += u32::from(is_mirror && first == BounceKind::Transmit && path.divides);
            sum + share * (path.added + arrives)
        });
        let truth = reference.radiance_along(ray, None, 0.0);
        checked += 1;
        // The reference lets go of what counts less than a hundred thousandth.
        assert!((found - truth).abs().max_element() < 1e-4, "{found} against {truth}");
    }
    assert!(checked > 2000 && divided_later > 20, "{checked} rays, {divided_later} that divide after a mirror");
}
