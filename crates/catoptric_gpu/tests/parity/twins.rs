//! Twins: functions of the library and of the shaders on the same inputs.

use bytemuck::{Pod, Zeroable};
use catoptric::math::random::Stream;
use catoptric::optics::path::bundle::BounceKind;
use catoptric::optics::step::{Facing, fresnel_dielectric, reflected_change, refracted_change};
use catoptric::scene::microfacets::{lobe, widened_alpha};
use catoptric_gpu::{Context, shader};
use glam::{Vec2, Vec3};
use libtest_mimic::{Failed, Trial};
use std::sync::Arc;
use wgpu::BufferUsages;
use wgpu::util::DeviceExt;

const COUNT: usize = 100_000;

#[derive(Clone, Copy, Debug, Default, Pod, Zeroable)]
#[repr(C)]
struct Input {
    direction: Vec3,
    eta: f32,
    geometric: Vec3,
    cosine: f32,
    shading: Vec3,
    alpha: f32,
    direction_change: Vec3,
    half_cosine2: f32,
    normal_change: Vec3,
    n_v: f32,
}

#[derive(Clone, Copy, Debug, Default, Pod, Zeroable)]
#[repr(C)]
struct Output {
    reflected: Vec3,
    fresnel: f32,
    refracted: Vec3,
    lobe: f32,
    reflected_change: Vec3,
    widened: f32,
    refracted_change: Vec3,
    outside: f32,
}

pub(crate) fn trial(context: &Arc<Context>) -> Trial {
    let context = context.clone();
    Trial::test(format!("twins on {COUNT} inputs"), move || compare(&context))
}

fn inputs() -> Vec<Input> {
    let mut random = Stream::new(2811);
    let mut input = || {
        let mut unit = || loop {
            let vector = Vec3::from_array([0, 1, 2].map(|_| random.next_between(-1.0, 1.0)));
            if (0.01..1.0).contains(&vector.length_squared()) {
                return vector.normalize();
            }
        };
        let (direction, geometric, turn) = (unit(), unit(), unit());
        let (direction_change, normal_change) = (unit() * 0.01, unit() * 0.01);
        let shading = (geometric + turn * 0.3).normalize();
        let eta = if random.next_unit() < 0.5 { random.next_between(0.4, 1.0) } else { random.next_between(1.0, 2.4) };
        let [cosine, n_v] = [0, 1].map(|_| random.next_between(0.001, 1.0));
        // Squared: sharp highlights are in it, too.
        let alpha = random.next_between(0.03, 1.0).powi(2);
        let half_cosine2 = 1.0 - random.next_unit().powi(4);
        Input { direction, eta, geometric, cosine, shading, alpha, direction_change, half_cosine2, normal_change, n_v }
    };
    (0..COUNT).map(|_| input()).collect()
}

/// The library's results.
fn expected(given: &Input) -> Output {
    let facing = Facing::new(given.direction, given.geometric, given.shading);
    let outgoing = |kind| facing.outgoing(kind, given.direction, given.eta).unwrap_or(Vec3::ZERO);
    let Input { direction, direction_change, normal_change, eta, .. } = *given;
    Output {
        reflected: outgoing(BounceKind::Reflect),
        refracted: outgoing(BounceKind::Transmit),
        fresnel: fresnel_dielectric(given.cosine, eta),
        lobe: lobe(given.alpha, given.half_cosine2, 1.0 - given.half_cosine2, given.cosine, given.n_v),
        widened: widened_alpha(given.alpha, given.n_v),
        reflected_change: reflected_change(direction, direction_change, facing.normal, normal_change),
        refracted_change: refracted_change(direction, direction_change, facing.normal, normal_change, eta),
        outside: f32::from(facing.outside),
    }
}

/// The share of the cosine of refraction, squared, below which rounding decides much: near total reflection.
const CRITICAL: f32 = 1e-3;

fn compare(context: &Context) -> Result<(), Failed> {
    let inputs = inputs();
    let outputs = evaluate(context, &inputs)?;
    let mut worst = [0f32; 5];
    for (given, found) in inputs.iter().zip(&outputs) {
        let known = expected(given);
        if known.outside != found.outside {
            return Err(format!("another side: {given:?}").into());
        }
        let facing = Facing::new(given.direction, given.geometric, given.shading);
        let cosine = given.direction.dot(facing.normal);
        let is_critical = (1.0 - given.eta * given.eta * (1.0 - cosine * cosine)).abs() < CRITICAL;
        let sine2 = given.eta * given.eta * (1.0 - given.cosine * given.cosine);
        let fresnel = if (1.0 - sine2).abs() < CRITICAL { 0.0 } else { (known.fresnel - found.fresnel).abs() };
        let of_refraction = match is_critical {
            true => Vec2::ZERO,
            false => Vec2::new(
                known.refracted.distance(found.refracted),
                known.refracted_change.distance(found.refracted_change),
            ),
        };
        let errors = [
            known.reflected.distance(found.reflected).max(known.reflected_change.distance(found.reflected_change)),
            fresnel,
            (known.lobe / found.lobe - 1.0).abs().max((known.widened - found.widened).abs()),
            of_refraction.x,
            of_refraction.y,
        ];
        for (worst, error) in worst.iter_mut().zip(errors) {
            *worst = if error <= *worst { *worst } else { error };
        }
    }
    // Reflection, Fresnel's share, facets, refraction and its change: rounding, more of it near critical angles.
    let limits = [2e-6, 3e-5, 1e-4, 2e-5, 1e-4];
    match worst.iter().zip(limits).all(|(worst, limit)| *worst <= limit) {
        true => Ok(()),
        false => Err(format!("largest differences {worst:?}, allowed {limits:?}").into()),
    }
}

/// The shaders' results.
fn evaluate(context: &Context, inputs: &[Input]) -> Result<Vec<Output>, Failed> {
    run(context, "twins/events.wgsl", &[], inputs, &[], &[])
}

fn entry(binding: u32, buffer: &wgpu::Buffer) -> wgpu::BindGroupEntry<'_> {
    wgpu::BindGroupEntry { binding, resource: buffer.as_entire_binding() }
}

/// Feeds inputs to a shader's `evaluate`, which reads them at binding 20 and writes as many outputs at binding 21; what
/// else it reads is given for the first two groups.
pub(crate) fn run<I: Pod, O: Pod>(
    context: &Context,
    path: &str,
    constants: &[(&str, f64)],
    inputs: &[I],
    first: &[wgpu::BindGroupEntry<'_>],
    second: &[wgpu::BindGroupEntry<'_>],
) -> Result<Vec<O>, Failed> {
    let (device, queue) = (context.device(), context.queue());
    let source = wgpu::ShaderSource::Wgsl(shader::source(path).into());
    let module = device.create_shader_module(wgpu::ShaderModuleDescriptor { label: Some(path), source });
    let pipeline = device.create_compute_pipeline(&wgpu::ComputePipelineDescriptor {
        label: Some(path),
        layout: None,
        module: &module,
        entry_point: Some("evaluate"),
        compilation_options: wgpu::PipelineCompilationOptions { constants, ..Default::default() },
        cache: None,
    });
    let given = device.create_buffer_init(&wgpu::util::BufferInitDescriptor {
        label: None,
        contents: bytemuck::cast_slice(inputs),
        usage: BufferUsages::STORAGE,
    });
    let size = (inputs.len() * size_of::<O>()) as u64;
    let buffer =
        |usage| device.create_buffer(&wgpu::BufferDescriptor { label: None, size, usage, mapped_at_creation: false });
    let results = buffer(BufferUsages::STORAGE | BufferUsages::COPY_SRC);
    let read = buffer(BufferUsages::COPY_DST | BufferUsages::MAP_READ);
    let group = |index: u32, entries: &[wgpu::BindGroupEntry<'_>]| {
        let layout = &pipeline.get_bind_group_layout(index);
        device.create_bind_group(&wgpu::BindGroupDescriptor { label: None, layout, entries })
    };
    let of_test = [entry(20, &given), entry(21, &results)];
    let first = group(0, &first.iter().cloned().chain(of_test).collect::<Vec<_>>());
    let second = (!second.is_empty()).then(|| group(1, second));
    let mut encoder = device.create_command_encoder(&Default::default());
    let mut pass = encoder.begin_compute_pass(&Default::default());
    pass.set_pipeline(&pipeline);
    pass.set_bind_group(0, &first, &[]);
    if let Some(second) = &second {
        pass.set_bind_group(1, second, &[]);
    }
    pass.dispatch_workgroups(inputs.len().div_ceil(64) as u32, 1, 1);
    drop(pass);
    encoder.copy_buffer_to_buffer(&results, 0, &read, 0, size);
    queue.submit([encoder.finish()]);
    read.map_async(wgpu::MapMode::Read, .., |_| {});
    device.poll(wgpu::PollType::wait_indefinitely())?;
    let mapped = read.get_mapped_range(..)?;
    let outputs = bytemuck::pod_collect_to_vec(&mapped);
    context.check()?;
    Ok(outputs)
}
