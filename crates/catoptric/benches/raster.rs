//! The speed of the rasteriser: a textured, lit room of displaced walls at 1440 x 960 pixels.

use catoptric::framebuffer::Framebuffer;
use catoptric::progress::Silent;
use catoptric::raster::{SceneShader, draw, scene_draw_list};
use catoptric::scene::model::{MeshAsset, Node, Primitive};
use catoptric::scene::{
    Camera, Light, LightKind, Material, Model, PoseOptions, Sampler, Scene, Texture, TextureBinding, View,
};
use criterion::{BenchmarkId, Criterion, criterion_group, criterion_main};
use glam::{Affine2, Mat3, Vec2, Vec3};
use std::hint::black_box;
use std::sync::Arc;

/// Waves on the walls.
fn displacement(u: f32, v: f32) -> f32 {
    0.04 * ((u * 9.0).sin() * (v * 7.0).cos() + 0.5 * (u * 23.0 + v * 17.0).sin())
}

/// A room of six walls, each `cells` x `cells` displaced quads.
fn room(cells: u32) -> Scene {
    let size = 512u32;
    let texels: Vec<[u8; 4]> = (0..size * size)
        .map(|index| {
            let (x, y) = (index % size, index / size);
            let noise = (x.wrapping_mul(0x9e37_79b9) ^ y.wrapping_mul(0x85eb_ca6b)).wrapping_mul(0xc2b2_ae35) >> 26;
            let tile = if (x / 32 + y / 32) % 2 == 0 { 70 } else { 150 };
            [tile + noise as u8, tile, 200 - tile + noise as u8, 255]
        })
        .collect();
    let texture = Texture::from_srgb8("tiles", size, size, &texels, Sampler::default());
    let mut material = Material::diffuse("wall", Vec3::splat(0.8));
    material.base_texture = Some(TextureBinding { texture: 0, uv_channel: 0, texture_from_uv: Affine2::IDENTITY });
    let mut model = Model { name: "room".into(), ..Model::default() };
    model.textures.push(Arc::new(texture));
    model.materials.push(material);
    let mut mesh = MeshAsset { name: "walls".into(), ..MeshAsset::default() };
    for axis in 0..3 {
        for side in [-1.0f32, 1.0] {
            let frame =
                Mat3::from_cols(Vec3::AXES[(axis + 1) % 3], Vec3::AXES[(axis + 2) % 3], Vec3::AXES[axis] * side);
            let mut wall = Primitive { material: 0, ..Primitive::default() };
            for row in 0..=cells {
                for column in 0..=cells {
                    let (u, v) = (column as f32 / cells as f32, row as f32 / cells as f32);
                    let at = |u: f32, v: f32| {
                        let edge = 16.0 * u * (1.0 - u) * v * (1.0 - v);
                        frame * Vec3::new(u * 2.0 - 1.0, v * 2.0 - 1.0, 1.0 - edge * displacement(u, v))
                    };
                    let (du, dv) = (at(u + 0.01, v) - at(u - 0.01, v), at(u, v + 0.01) - at(u, v - 0.01));
                    wall.positions.push(at(u, v));
                    wall.normals.push(du.cross(dv).normalize() * -side);
                    wall.uvs[0].push(Vec2::new(u, v) * 3.0);
                }
            }
            for row in 0..cells {
                for column in 0..cells {
                    let a = row * (cells + 1) + column;
                    let (b, c, d) = (a + 1, a + cells + 2, a + cells + 1);
                    wall.triangles.extend([[a, b, c], [a, c, d]]);
                }
            }
            mesh.primitives.push(wall);
        }
    }
    model.meshes.push(mesh);
    model.nodes.push(Node { mesh: Some(0), ..Node::default() });
    let mut scene = model.pose(&PoseOptions::default()).expect("the room is a valid model");
    for position in [Vec3::new(0.3, 0.7, 0.2), Vec3::new(-0.6, 0.1, 0.5)] {
        let kind = LightKind::Point { range: f32::INFINITY };
        scene.lights.push(Light { kind, intensity: Vec3::splat(1.5), position, direction: Vec3::NEG_Y });
    }
    scene
}

fn view(scene: &Scene) -> View {
    let camera = Camera::look_at("eye", Vec3::new(0.8, 0.3, 0.8), Vec3::new(-0.3, -0.2, -0.3), Vec3::Y, 60.0);
    scene.view(&camera, 1440, 960)
}

fn frames(criterion: &mut Criterion) {
    let mut group = criterion.benchmark_group("frame 1440x960");
    group.sample_size(20);
    for cells in [41, 71] {
        let scene = room(cells);
        let view = view(&scene);
        let mut target = Framebuffer::new(view.width, view.height);
        for samples in [1, 4, 16] {
            let name = format!("{} triangles, {samples} samples", scene.triangles.len());
            group.bench_function(BenchmarkId::from_parameter(name), |bencher| {
                bencher.iter(|| {
                    let list = scene_draw_list(&scene, &view, |_| Some(0));
                    let report = draw(&view, samples, &[list], &SceneShader::new(&scene, &view), &mut target, &Silent);
                    black_box(report.expect("the bench asks for what is allowed"))
                });
            });
        }
    }
    group.finish();
}

criterion_group!(benches, frames);
criterion_main!(benches);
