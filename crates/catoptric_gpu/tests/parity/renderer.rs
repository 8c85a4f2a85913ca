//! Pictures in textures of the caller's: two views drawn before any is submitted.

use catoptric::framebuffer::Framebuffer;
use catoptric::methods::{self, Quality};
use catoptric::progress::Silent;
use catoptric::scene::View;
use catoptric::tone::{Display, ToneCurve};
use catoptric_gpu::{Context, Encoding, Pixels, Renderer};
use catoptric_scenes::builtin;
use libtest_mimic::{Failed, Trial};
use std::sync::Arc;
use wgpu::{BufferUsages, TextureFormat, TextureUsages};

/// Rows of buffers are multiples of 256 bytes.
const SIZE: [u32; 2] = [64, 40];
const FORMAT: TextureFormat = TextureFormat::Rgba32Float;
const QUALITY: Quality = Quality { samples: 4, order: 2 };

/// A method of each kind, and a scene.
const DRAWN: [(&str, &str); 6] = [
    ("multiperspective", "brushed"),
    ("environment_map", "planar_mirror"),
    ("planar_mirror", "planar_mirror"),
    ("light_field", "sphere_room"),
    ("layered_environment_map", "sphere_room"),
    ("sample_based_camera", "sphere_room"),
];

pub(crate) fn trials(context: &Arc<Context>) -> impl Iterator<Item = Trial> {
    let curves = ToneCurve::NAMES.iter().cycle();
    DRAWN.into_iter().zip(curves).flat_map(|((id, scene), (curve, name))| {
        let display = Display { exposure_stops: 0.75, curve: *curve };
        let [drawing, reading] = [context.clone(), context.clone()];
        [
            Trial::test(format!("textures of the caller's, {id}: {scene}"), move || draw(&drawing, id, scene)),
            Trial::test(format!("read without waiting, {id}: {scene}, tone {name}"), move || {
                read_later(&reading, id, scene, display)
            }),
        ]
    })
}

/// A scene's renderer, and two views of it.
fn begin(context: &Arc<Context>, id: &str, scene: &str, width: u32) -> Result<(Renderer, [View; 2]), Failed> {
    let scene = Arc::new(builtin::parse(scene)?.pose(&Default::default())?);
    let first = scene.default_view(width, SIZE[1]);
    let mut second = first.clone();
    second.world_from_view.translation.y += 0.2;
    let settings = methods::find(id)?.limits.settings.parse()?;
    let method = catoptric_gpu::create(context, id, &settings)?.ok_or("drawn on the CPU")?;
    Ok((Renderer::new(&method, &scene, QUALITY, None, &Silent)?, [first, second]))
}

/// Two views are begun before the first is read, in rows of a length that buffers have not.
fn read_later(context: &Arc<Context>, id: &str, scene: &str, display: Display) -> Result<(), Failed> {
    let (mut renderer, views) = begin(context, id, scene, SIZE[0] - 3)?;
    renderer.set_display(display);
    let begun = views.each_ref().map(|view| {
        let of_view =
            [Encoding::Linear, Encoding::Srgba8].map(|encoding| renderer.begin_reading(view, encoding, &Silent));
        of_view.into_iter().collect::<Result<Vec<_>, _>>()
    });
    for (begun, view) in begun.into_iter().zip(&views) {
        for reading in begun? {
            // As often: what is known of a view that was just drawn is not found, and not counted, again.
            let mut expected = Framebuffer::new(view.width, view.height);
            let waited = renderer.read(view, &mut expected, &Silent)?;
            while !reading.is_ready() {
                std::thread::yield_now();
            }
            let (pixels, report) = reading.finish()?;
            let is_same = match &pixels {
                Pixels::Linear(picture) => picture.pixels == expected.pixels,
                // The device rounds as it likes.
                Pixels::Srgba8(bytes) => {
                    let all = bytes.iter().zip(display.of(&expected).to_srgba8());
                    bytes.len() == expected.pixels.len() * 4 && all.map(|(a, b)| a.abs_diff(b)).max() <= Some(1)
                }
            };
            if !is_same {
                return Err("another picture was read without waiting".into());
            }
            if report.counts != waited.counts {
                return Err(format!("{:?} counted, {:?} expected", report.counts, waited.counts).into());
            }
        }
    }
    Ok(())
}

fn draw(context: &Arc<Context>, id: &str, scene: &str) -> Result<(), Failed> {
    let (mut renderer, views) = begin(context, id, scene, SIZE[0])?;
    let mut encoder = context.device().create_command_encoder(&Default::default());
    let mut buffers = Vec::new();
    for view in &views {
        buffers.push(draw_view(context, &mut renderer, view, &mut encoder)?);
    }
    context.queue().submit([encoder.finish()]);
    for (view, buffer) in views.iter().zip(&buffers) {
        buffer.map_async(wgpu::MapMode::Read, .., |_| {});
        context.device().poll(wgpu::PollType::wait_indefinitely())?;
        let mapped = buffer.get_mapped_range(..)?;
        let mut picture = Framebuffer::new(SIZE[0], SIZE[1]);
        renderer.read(view, &mut picture, &Silent)?;
        if bytemuck::cast_slice::<_, [f32; 4]>(&mapped) != picture.pixels {
            return Err("the texture shows another picture than the method's".into());
        }
    }
    context.check()?;
    Ok(())
}

/// A buffer that will hold what a texture shows.
fn draw_view(
    context: &Context,
    renderer: &mut Renderer,
    view: &View,
    encoder: &mut wgpu::CommandEncoder,
) -> Result<wgpu::Buffer, Failed> {
    let texture = context.device().create_texture(&wgpu::TextureDescriptor {
        label: None,
        size: wgpu::Extent3d { width: SIZE[0], height: SIZE[1], depth_or_array_layers: 1 },
        mip_level_count: 1,
        sample_count: 1,
        dimension: wgpu::TextureDimension::D2,
        format: FORMAT,
        usage: TextureUsages::RENDER_ATTACHMENT | TextureUsages::COPY_SRC,
        view_formats: &[],
    });
    renderer.draw(encoder, view, (&texture.create_view(&Default::default()), FORMAT), &Silent)?;
    let buffer = context.device().create_buffer(&wgpu::BufferDescriptor {
        label: None,
        size: u64::from(SIZE[0] * SIZE[1] * 16),
        usage: BufferUsages::COPY_DST | BufferUsages::MAP_READ,
        mapped_at_creation: false,
    });
    let layout = wgpu::TexelCopyBufferLayout { offset: 0, bytes_per_row: Some(SIZE[0] * 16), rows_per_image: None };
    let destination = wgpu::TexelCopyBufferInfo { buffer: &buffer, layout };
    encoder.copy_texture_to_buffer(texture.as_image_copy(), destination, texture.size());
    Ok(buffer)
}
