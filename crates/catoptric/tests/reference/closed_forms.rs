//! The ray tracer against closed forms: where light comes from, and how much of it.

use catoptric::light::path_tracer::{PathModel, PathTracer};
use catoptric::light::tracer::Tracer;
use catoptric::methods::Quality;
use catoptric::optics::fresnel_dielectric;
use catoptric::scene::{Material, Ray, Scene};
use catoptric_testkit::drawing::picture;
use catoptric_testkit::scenes::{SceneBuilder, sphere_in_room};
use glam::{DVec3, Vec3};

fn radiance(scene: &Scene, model: PathModel, order: u32, origin: Vec3, direction: Vec3) -> Vec3 {
    let tracer = Tracer::build(scene, |_| true);
    let ray = Ray { origin, direction: direction.normalize() };
    PathTracer::new(scene, &tracer, model, order).radiance_along(ray, None, 0.0)
}

/// A ruler in the plane z = `z`, of side 20 about the axis; a colour there is the position / 20 + 1/2.
fn ruler_at(builder: &mut SceneBuilder, z: f32) {
    builder.ruler("ruler", Vec3::new(-10.0, -10.0, z), Vec3::X * 20.0, Vec3::Y * 20.0);
}

/// The position on the ruler that a colour stands for, whatever the light lost on its way.
fn position_of(color: Vec3) -> (f32, f32) {
    assert!(color.z > 0.0, "the ruler was missed: {color}");
    ((color.x / color.z - 0.5) * 20.0, (color.y / color.z - 0.5) * 20.0)
}

#[test]
fn planar_mirror_shows_the_mirrored_position() {
    let mut builder = SceneBuilder::new();
    let mirror = builder.material(Material::mirror("mirror", Vec3::new(0.8, 0.8, 0.8)));
    builder.quad("mirror", Vec3::new(-2.0, -2.0, 0.0), Vec3::X * 4.0, Vec3::Y * 4.0, mirror);
    ruler_at(&mut builder, 5.0);
    let scene = builder.build();
    let eye = Vec3::new(0.3, -0.2, 3.0);
    for direction in [Vec3::new(0.1, 0.2, -1.0), Vec3::new(-0.4, 0.05, -1.0), Vec3::new(0.0, 0.0, -1.0)] {
        let color = radiance(&scene, PathModel::Tree, 1, eye, direction);
        // From the eye's mirror image at z = -3 to the ruler at z = 5.
        let (x, y) = position_of(color);
        assert!((x - (eye.x + direction.x * 8.0)).abs() < 1e-4, "{x}");
        assert!((y - (eye.y + direction.y * 8.0)).abs() < 1e-4, "{y}");
        assert!((color.z - 0.8).abs() < 1e-6);
        assert_eq!(radiance(&scene, PathModel::Tree, 0, eye, direction), Vec3::ZERO);
    }
}

#[test]
fn sphere_mirror_follows_the_law_of_reflection() {
    let mut builder = SceneBuilder::new();
    let mirror = builder.material(Material::mirror("mirror", Vec3::ONE));
    builder.sphere("ball", Vec3::ZERO, 1.0, mirror);
    ruler_at(&mut builder, 6.0);
    let scene = builder.build();
    let eye = DVec3::new(0.2, 0.1, 4.0);
    for (x, y) in [(0.0, 0.0), (0.05, 0.02), (-0.08, 0.1), (0.03, -0.06)] {
        let direction = DVec3::new(x, y, -1.0).normalize();
        let (along, c) = (eye.dot(direction), eye.length_squared() - 1.0);
        let point = eye + direction * (-along - (along * along - c).sqrt());
        let outgoing = direction - point * 2.0 * direction.dot(point);
        let expected = point + outgoing * ((6.0 - point.z) / outgoing.z);
        let color = radiance(&scene, PathModel::Tree, 1, eye.as_vec3(), direction.as_vec3());
        let (x, y) = position_of(color);
        // Single precision in the eye's distance, magnified by the sphere.
        assert!((x as f64 - expected.x).abs() < 2e-4 && (y as f64 - expected.y).abs() < 2e-4, "{x} {y} {expected}");
    }
}

#[test]
fn a_slab_displaces_and_dims_as_snell_and_fresnel_say() {
    let (ior, thickness) = (1.5f64, 1.0f64);
    let mut builder = SceneBuilder::new();
    let glass = builder.material(Material { absorption: Vec3::new(0.0, 0.0, 0.3), ..Material::glass("glass", 1.5) });
    builder.cuboid("slab", Vec3::new(-8.0, -8.0, 0.0), Vec3::new(8.0, 8.0, 1.0), false, glass);
    ruler_at(&mut builder, -3.0);
    let mut scene = builder.build();
    for angle in [0.0f64, 0.3, 0.7, 1.0] {
        let inside = (angle.sin() / ior).asin();
        let expected = 2.0 * angle.tan() + thickness * inside.tan() + 3.0 * angle.tan();
        let direction = Vec3::new(angle.sin() as f32, 0.0, -angle.cos() as f32);
        let color = radiance(&scene, PathModel::Tree, 2, Vec3::new(0.0, 0.0, 3.0), direction);
        let through = (1.0 - fresnel_dielectric(angle.cos() as f32, 1.0 / 1.5)).powi(2);
        let share = (color.x / through) as f64;
        assert!(((share - 0.5) * 20.0 - expected).abs() < 1e-4, "{angle}: {share}");
        let absorbed = (-0.3 * thickness / inside.cos()).exp() as f32;
        assert!((color.z - through * absorbed).abs() < 1e-5, "{angle}: {color}");
        // The two-path model goes on by refraction here, and reflects into nothing.
        let greedy = radiance(&scene, PathModel::TwoPath, 2, Vec3::new(0.0, 0.0, 3.0), direction);
        assert!((greedy - color).length() < 1e-6);
    }
    // Without absorption, all orders together lose nothing: a white surround stays white.
    scene.materials[glass].absorption = Vec3::ZERO;
    scene.objects.retain(|object| object.name != "ruler");
    let white = catoptric::scene::Environment::new("white", 8, 4, vec![[1.0; 3]; 32]);
    scene.environment = Some(std::sync::Arc::new(white));
    let color = radiance(&scene, PathModel::Tree, 16, Vec3::new(0.0, 0.0, 3.0), Vec3::new(0.2, 0.1, -1.0));
    assert!((color - Vec3::ONE).abs().max_element() < 1e-4, "{color}");
}

#[test]
fn a_ball_lens_focuses_at_its_paraxial_focus() {
    let mut builder = SceneBuilder::new();
    let glass = builder.material(Material::glass("glass", 1.5));
    builder.sphere("ball", Vec3::ZERO, 1.0, glass);
    // Back focal length of a ball: R (2 - n) / (2 (n - 1)) = R / 2 behind its surface.
    ruler_at(&mut builder, -1.5);
    let scene = builder.build();
    for height in [0.01f32, 0.02, -0.03] {
        let color = radiance(&scene, PathModel::Tree, 2, Vec3::new(height, 0.0, 5.0), Vec3::NEG_Z);
        let (x, _) = position_of(color);
        // Spherical aberration grows with the cube of the height.
        assert!(x.abs() < 2.0 * height.abs().powi(3) + 1e-5, "{height}: {x}");
    }
}

#[test]
fn a_meshed_lens_focuses_like_the_exact_one() {
    let mut builder = SceneBuilder::new();
    let glass = builder.material(Material::glass("glass", 1.5));
    builder.sphere_mesh("ball", Vec3::ZERO, 1.0, 256, glass);
    ruler_at(&mut builder, -1.5);
    let scene = builder.build();
    for (x, y) in [(0.1, 0.05), (-0.2, 0.1), (0.0, 0.3)] {
        let mut exact = SceneBuilder::new();
        let glass = exact.material(Material::glass("glass", 1.5));
        exact.sphere("ball", Vec3::ZERO, 1.0, glass);
        ruler_at(&mut exact, -1.5);
        let exact = exact.build();
        let start = Vec3::new(x, y, 5.0);
        let (ax, ay) = position_of(radiance(&scene, PathModel::Tree, 2, start, Vec3::NEG_Z));
        let (bx, by) = position_of(radiance(&exact, PathModel::Tree, 2, start, Vec3::NEG_Z));
        assert!((ax - bx).hypot(ay - by) < 1e-3, "{ax} {ay} against {bx} {by}");
    }
}

#[test]
fn total_internal_reflection_is_complete() {
    // The eye and the ruler are inside one block of glass; its top face reflects.
    let mut builder = SceneBuilder::new();
    let glass = builder.material(Material::glass("glass", 1.5));
    builder.cuboid("block", Vec3::splat(-50.0), Vec3::new(50.0, 50.0, 4.0), false, glass);
    ruler_at(&mut builder, -3.0);
    let scene = builder.build();
    let critical = (1.0f32 / 1.5).asin();
    for (angle, total) in [(critical + 0.01, true), (critical - 0.01, false), (0.3, false)] {
        let direction = Vec3::new(angle.sin(), 0.0, angle.cos());
        let color = radiance(&scene, PathModel::Tree, 1, Vec3::new(-5.0, 0.0, 2.0), direction);
        let (x, _) = position_of(color);
        assert!((x - (-5.0 + (2.0 + 7.0) * angle.tan())).abs() < 1e-3, "{x}");
        let expected = if total { 1.0 } else { fresnel_dielectric(angle.cos(), 1.5) };
        assert!((color.z - expected).abs() < 1e-4, "{angle}: {color}");
        assert_eq!(color.z > 0.9999, total);
    }
}

#[test]
fn a_concave_mirror_focuses_parallel_light_at_half_its_radius() {
    let mut builder = SceneBuilder::new();
    let mirror = builder.material(Material::mirror("mirror", Vec3::ONE));
    builder.sphere("bowl", Vec3::ZERO, 2.0, mirror);
    let small = builder.flat("detector", Vec3::new(0.0, 1.0, 0.0));
    // A small detector about the focus at z = -1, visible edge-free from below only.
    builder.quad("detector", Vec3::new(-1e-3, -1e-3, -1.0), Vec3::X * 2e-3, Vec3::Y * 2e-3, small);
    let scene = builder.build();
    for height in [0.05f32, 0.08, -0.06] {
        let color = radiance(&scene, PathModel::Tree, 1, Vec3::new(height, 0.0, 0.0), Vec3::NEG_Z);
        assert_eq!(color, Vec3::new(0.0, 1.0, 0.0), "{height}");
    }
}

#[test]
fn an_inside_mirror_is_black_from_outside() {
    let mut builder = SceneBuilder::new();
    let mirror = builder.material(Material::mirror("mirror", Vec3::ONE));
    let surface = catoptric::surface::AnalyticSurface::Sphere { radius: 1.0 };
    builder.analytic("bowl", glam::Affine3A::IDENTITY, surface, mirror, true);
    ruler_at(&mut builder, 6.0);
    let mut scene = builder.build();
    let look = |scene: &Scene| radiance(scene, PathModel::Tree, 2, Vec3::new(0.0, 0.0, 4.0), Vec3::NEG_Z);
    assert_eq!(look(&scene), Vec3::ZERO);
    scene.objects[0].inside = false;
    assert!(look(&scene).z > 0.0);
}

#[test]
fn pictures_do_not_depend_on_the_thread_count() {
    let scene = sphere_in_room(false);
    let view = scene.default_view(97, 61);
    let draw = |threads: usize, samples: u32, settings: &str| {
        let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build().unwrap();
        pool.install(|| picture("reference", settings, &scene, &view, Quality { samples, order: 3 }))
    };
    for (samples, settings) in [(1, ""), (4, ""), (5, "samples = 'random'\nseed = 3")] {
        let one = draw(1, samples, settings);
        assert_eq!(one, draw(2, samples, settings));
        assert_eq!(one, draw(5, samples, settings));
    }
}
