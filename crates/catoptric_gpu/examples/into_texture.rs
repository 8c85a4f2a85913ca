//! Draws a scene into a texture of one's own, on a device of one's own, as an engine's plug-in or a window does.
//!
//! ```sh
//! cargo run --release -p catoptric_gpu --features wgpu --example into_texture
//! ```

use catoptric::methods::Quality;
use catoptric::progress::Silent;
use catoptric::scene::PoseOptions;
use catoptric_gpu::{Context, Renderer};
use catoptric_scenes::builtin;
use std::error::Error;
use std::sync::Arc;

const SIZE: [u32; 2] = [320, 192];
const FORMAT: wgpu::TextureFormat = wgpu::TextureFormat::Rgba8UnormSrgb;

fn main() -> Result<(), Box<dyn Error>> {
    // The caller's device, which has at least WebGPU's default limits.
    let instance = wgpu::Instance::new(wgpu::InstanceDescriptor::new_without_display_handle());
    let adapter = pollster::block_on(instance.request_adapter(&Default::default()))?;
    let (device, queue) = pollster::block_on(adapter.request_device(&Default::default()))?;
    let context = Context::of_device(device.clone(), queue.clone())?;

    let scene = Arc::new(builtin::load("sphere_room", &[])?.pose(&PoseOptions::default())?);
    // Any of the methods.
    let method = catoptric_gpu::create(&context, "multiperspective", &Default::default())?;
    let method = method.ok_or("the method draws on the processor alone")?;
    let quality = Quality { samples: 4, order: 2 };
    let mut renderer = Renderer::new(&method, &scene, quality, None, &Silent)?;

    // The caller's texture.
    let texture = device.create_texture(&wgpu::TextureDescriptor {
        label: Some("picture"),
        size: wgpu::Extent3d { width: SIZE[0], height: SIZE[1], depth_or_array_layers: 1 },
        mip_level_count: 1,
        sample_count: 1,
        dimension: wgpu::TextureDimension::D2,
        format: FORMAT,
        usage: wgpu::TextureUsages::RENDER_ATTACHMENT | wgpu::TextureUsages::COPY_SRC,
        view_formats: &[],
    });
    let target = texture.create_view(&Default::default());
    let view = scene.default_view(SIZE[0], SIZE[1]);
    let mut encoder = device.create_command_encoder(&Default::default());
    renderer.draw(&mut encoder, &view, (&target, FORMAT), &Silent)?;

    // Read back, to see that something is there.
    let buffer = device.create_buffer(&wgpu::BufferDescriptor {
        label: None,
        size: u64::from(SIZE[0] * SIZE[1] * 4),
        usage: wgpu::BufferUsages::COPY_DST | wgpu::BufferUsages::MAP_READ,
        mapped_at_creation: false,
    });
    let layout = wgpu::TexelCopyBufferLayout { offset: 0, bytes_per_row: Some(SIZE[0] * 4), rows_per_image: None };
    let destination = wgpu::TexelCopyBufferInfo { buffer: &buffer, layout };
    encoder.copy_texture_to_buffer(texture.as_image_copy(), destination, texture.size());
    queue.submit([encoder.finish()]);
    buffer.map_async(wgpu::MapMode::Read, .., |_| {});
    device.poll(wgpu::PollType::wait_indefinitely())?;
    let pixels = buffer.get_mapped_range(..)?;
    let mean = pixels.iter().map(|value| u64::from(*value)).sum::<u64>() as f64 / pixels.len() as f64;
    let mut out = std::io::stdout().lock();
    std::io::Write::write_fmt(&mut out, format_args!("{} x {} pixels, mean value {mean:.1}\n", SIZE[0], SIZE[1]))?;
    Ok(())
}
