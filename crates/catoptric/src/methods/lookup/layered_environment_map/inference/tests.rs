//! Tests of inference as a whole: its matrix and its solutions.

use super::*;
use crate::math::random::Stream;
use crate::methods::lookup::layered_environment_map::textures::maps::radiance;
use catoptric_scenes::builtin;
use glam::{Vec3, Vec4Swizzles};

/// Inference for a scene, of textures of a size from pictures of a size, with all else as it is by default.
fn with_inference(name: &str, size: u32, picture_size: u32, work: impl FnOnce(&Inference<'_>, &[Layer])) {
    let scene = builtin::parse(name).unwrap().pose(&Default::default()).unwrap();
    let settings = LayeredEnvironmentMapSettings { size, picture_size, ..LayeredEnvironmentMapSettings::default() };
    let known = LayerGeometry::new(&settings, &scene, 4);
    let projected = known.projected(&settings, &scene, &Silent).unwrap();
    work(&Inference { scene: &scene, settings: &settings, known: &known }, &projected[0]);
}

#[test]
fn textures_that_made_the_pictures_come_back() {
    // Pictures as they are made of a scene, where random textures with mip levels show in its place.
    with_inference("sphere_room?tess=16", 16, 384, |inference, projected| {
        let systems = inference.systems(0, projected, 0, &Silent).unwrap();
        let mut random = Stream::new(8);
        for (number, (systems, layer)) in systems.into_iter().zip(projected).enumerate() {
            let layout = &layer.texture.layout;
            // Half floats hold them, and their means.
            let mut eighths = || (random.next_between(0.2, 1.0) * 8.0).round() / 8.0;
            let mut truth: Vec<Vec4> =
                (0..layout.texel_count()).map(|_| Vec4::new(eighths(), eighths(), 0.625, 1.0)).collect();
            layout.fill_coarser(&mut truth);
            let mut equations = Equations::joined(systems);
            equations.show(&truth);
            let read = equations.squares(layout.texel_count());
            let (found, residual) = inference.fitted(layer, equations);
            let mut checked = 0u32;
            let (mut off, mut was_off, mut worst) = (0.0f32, 0.0f32, 0.0f32);
            // Trust pulls these by half a percent at most to what was expected, which is far off.
            for (texel, truth) in truth.iter().enumerate().filter(|(texel, _)| read[*texel] > 1.0) {
                let of = |texture: &LayerTexture| (texture.texels[texel].value() - *truth) / *truth;
                checked += 1;
                off += of(&found).length_squared();
                was_off += of(&layer.texture).length_squared();
                worst = worst.max(of(&found).abs().max_element());
            }
            let [off, was_off] = [off, was_off].map(|sum| (sum / (4 * checked) as f32).sqrt());
            let found = format!("{number}: {checked} off by {off}, {worst} at worst, before {was_off}; {residual:?}");
            assert!(checked > 180 && off < 0.005 && worst < 0.065 && was_off > 0.45, "{found}");
            assert!(residual.after < 0.006 * residual.before && residual.steps < STOP.most_steps, "{found}");
        }
    });
}

#[test]
fn the_matrix_times_the_texture_is_what_is_drawn() {
    // Rays of a picture, side by side as they are drawn, by layers with depths that rays search.
    with_inference("colonnade?tess=12", 64, 192, |inference, projected| {
        let observations = inference.seen(0, 0).unwrap();
        let rays: Vec<_> = observations.list.iter().map(|observation| (observation.ray, observation.change)).collect();
        for (number, layer) in projected.iter().enumerate() {
            assert!(layer.distances.is_some(), "depths are the default");
            let texels: Vec<Vec4> = layer.texture.texels.iter().map(|texel| texel.value()).collect();
            let matrix = equations(layer, &observations, number, |_| 1.0);
            let mut seen = vec![Vec4::ZERO; rays.len()];
            matrix.times(&texels, &mut seen);
            let (mut part, mut nothing) = (0, 0);
            radiance(&[(vec![layer], 1.0)], inference.scene, &rays, |index, drawn| {
                let seen = seen[index];
                assert_eq!(inference.scene.background(rays[index].0.direction), Vec3::ZERO, "layers are seen alone");
                let expected = seen.xyz().max(Vec3::ZERO);
                let off = (drawn - expected).abs().max_element();
                assert!(off <= 2e-5 * drawn.max_element().max(1.0), "{number}, {index}: {drawn}, not {expected}");
                part += u32::from(seen.w > 0.5);
                nothing += u32::from(seen.w == 0.0);
            });
            assert!(part > 1000 && nothing > 1300, "{number}: {part} rays meet it, {nothing} do not");
        }
        assert!(projected.len() == 3 && rays.len() > 8000, "{} rays", rays.len());
    });
}
