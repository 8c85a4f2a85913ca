//! How points of surfaces look: textures, lights, environment, normal maps, in the library and in shaders.

use super::resources::SceneResources;
use super::twins::run;
use bytemuck::{Pod, Zeroable};
use catoptric::math::random::Stream;
use catoptric::scene::shade::SurfacePoint;
use catoptric::scene::{Environment, Scene, UvFootprint};
use catoptric_gpu::Context;
use catoptric_scenes::builtin;
use glam::{Vec2, Vec3, Vec4};
use libtest_mimic::{Failed, Trial};
use std::sync::Arc;

const COUNT: usize = 100_000;
/// The largest difference that is allowed, as a share of 1 plus the size of what is compared.
const TOLERANCE: f32 = 1e-3;
/// The share of inputs that may be off by more: where rounding decides on another number of probes in a texture, or on
/// another side of a surface.
const MOST_OFF: f64 = 1e-4;

#[derive(Clone, Copy, Debug, Default, Pod, Zeroable)]
#[repr(C)]
struct Input {
    position: Vec3,
    object: u32,
    geometric_normal: Vec3,
    normal_change2: f32,
    normal: Vec3,
    samples: u32,
    viewer: Vec3,
    alpha: f32,
    tangent: Vec4,
    uvs: [Vec2; 2],
    uvs_dx: [Vec2; 2],
    uvs_dy: [Vec2; 2],
    change_x: Vec3,
    unused0: f32,
    change_y: Vec3,
    unused1: f32,
}

/// Base colour, own light and the variance of normals, highlights, the turned normal; the environment sharply, over a
/// cone, over a highlight, and as irradiance.
#[derive(Clone, Copy, Debug, Default, Pod, Zeroable)]
#[repr(C)]
struct Output([Vec4; 8]);

const NAMES: [&str; 8] =
    ["base colour", "own light", "highlights", "turned normal", "environment", "cone", "glossy", "irradiance"];

pub(crate) fn trial(context: &Arc<Context>) -> Trial {
    let context = context.clone();
    Trial::test(format!("twins of shading on {COUNT} points"), move || compare(&context))
}

/// Metals, coats, normal maps and lamps, under a sky that is turned.
fn scene() -> Result<Scene, Failed> {
    let mut scene = builtin::parse("workshop")?.pose(&Default::default())?;
    let texel = |index: usize| {
        let (x, y) = (index % 256, index / 256);
        let wave = |period: f32| 0.5 + 0.5 * (x as f32 / period).sin() * (y as f32 / period).cos();
        [wave(9.0), wave(17.0), 2.0 * wave(31.0)]
    };
    let sky = Environment::new("sky", 256, 128, (0..256 * 128).map(texel).collect());
    scene.environment = Some(Arc::new(sky.turned(0.7)));
    Ok(scene)
}

fn inputs(scene: &Scene) -> Vec<Input> {
    let mut random = Stream::new(28);
    let mut input = || {
        let mut between = |low: f32, high: f32| random.next_between(low, high);
        let mut unit = || loop {
            let vector = Vec3::from_array([0, 1, 2].map(|_| between(-1.0, 1.0)));
            if (0.01..1.0).contains(&vector.length_squared()) {
                return vector.normalize();
            }
        };
        let [geometric_normal, turn, viewer, along, change_x, change_y] = [0; 6].map(|_| unit());
        let scale = 10f32.powf(between(-4.0, 0.0));
        let mut pair = |size: f32| [0, 1].map(|_| Vec2::new(between(-size, size), between(-size, size)));
        let [uvs, uvs_dx, uvs_dy] = [pair(2.0), pair(scale), pair(scale)];
        let position = scene.bounds.min + scene.bounds.size() * Vec3::from_array([0, 1, 2].map(|_| between(0.0, 1.0)));
        Input {
            position,
            object: between(0.0, scene.objects.len() as f32 - 0.5) as u32,
            geometric_normal,
            normal: (geometric_normal + turn * 0.2).normalize(),
            normal_change2: between(0.0, 0.1).powi(2),
            samples: if between(0.0, 1.0) < 0.5 { 1 } else { 4 },
            viewer,
            alpha: between(0.0, 1.0).powi(2),
            tangent: along.extend(if between(0.0, 1.0) < 0.5 { 1.0 } else { -1.0 }),
            uvs,
            uvs_dx,
            uvs_dy,
            change_x: change_x * between(0.0, 0.3).powi(2),
            change_y: change_y * between(0.0, 0.3).powi(2),
            ..Input::default()
        }
    };
    (0..COUNT).map(|_| input()).collect()
}

/// The library's results.
fn expected(scene: &Scene, given: &Input) -> Output {
    let footprint =
        |index: usize| UvFootprint { dx: given.uvs_dx[index], dy: given.uvs_dy[index], samples: given.samples };
    let point = SurfacePoint {
        object: given.object,
        position: given.position,
        geometric_normal: given.geometric_normal,
        normal: given.normal,
        uvs: given.uvs,
        footprints: [footprint(0), footprint(1)],
        color: Vec4::ONE,
        tangent: given.tangent,
        normal_change2: given.normal_change2,
        triangle: u32::MAX,
        ..SurfacePoint::default()
    };
    let material = scene.material_of(given.object);
    let (turned, variance) = scene.turned_normal_and_variance(material, &point);
    let sky = scene.environment.as_ref().expect("it has one");
    Output([
        scene.base_color(material, &point),
        scene.own_radiance(&point, given.viewer).extend(variance),
        scene.highlights(&point, given.viewer).extend(0.0),
        turned.extend(0.0),
        sky.radiance(given.viewer).extend(0.0),
        sky.radiance_over(given.viewer, [given.change_x, given.change_y]).extend(0.0),
        sky.glossy(given.viewer, given.alpha).extend(0.0),
        sky.irradiance(given.viewer).extend(0.0),
    ])
}

fn compare(context: &Context) -> Result<(), Failed> {
    let scene = scene()?;
    let inputs = inputs(&scene);
    let outputs = evaluate(context, &scene, &inputs)?;
    let mut off = [0usize; NAMES.len()];
    for (given, found) in inputs.iter().zip(&outputs) {
        let known = expected(&scene, given);
        for (count, (known, found)) in off.iter_mut().zip(known.0.iter().zip(&found.0)) {
            let is_near = (*known - *found).abs().max_element() <= TOLERANCE * (1.0 + known.abs().max_element());
            *count += usize::from(!is_near);
        }
    }
    let problems = NAMES.iter().zip(off).filter(|(_, count)| *count as f64 > MOST_OFF * COUNT as f64);
    let problems: Vec<String> = problems.map(|(name, count)| format!("{name}: {count} of {COUNT}")).collect();
    if problems.is_empty() { Ok(()) } else { Err(problems.join(", ").into()) }
}

/// The shaders' results.
fn evaluate(context: &Context, scene: &Scene, inputs: &[Input]) -> Result<Vec<Output>, Failed> {
    let resources = SceneResources::new(context, scene)?;
    let all: Vec<u32> = (0..=9).collect();
    let (first, second) = (resources.of_scene(&all), resources.of_hierarchy());
    run(context, "twins/points.wgsl", &resources.constants, inputs, &first, &second)
}
