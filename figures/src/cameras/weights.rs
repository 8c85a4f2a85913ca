//! Reflections weighed against the reflector's own colour.

use super::sizes::{FULL, NARROW};
use crate::panels::{below, beside_of_width, cut};
use crate::stage::{self, BUNDLE, CAMERAS, Stage, flip, print, rgb};
use anyhow::Result;
use catoptric::light::visibility::cast_shadows;
use catoptric::scene::Attenuation;
use image::RgbImage;

/// The weights of a reflection by angle and by distance.
type Weights = (Option<[f32; 2]>, Option<Attenuation>);

/// The weights of figure 14; distances are shares of a scene's size.
fn weights(scene_size: f32) -> [(&'static str, Weights); 8] {
    let fade = |share: f32, least, greatest| {
        (None, Some(Attenuation { distance: share * scene_size, specularity: [least, greatest] }))
    };
    let ramp = |least, greatest| (Some([least, greatest]), None);
    [
        ("a: all reflection", (None, None)),
        ("b: ramp 0.2/1 and fading 0.3/0.1/1", (Some([0.2, 1.0]), fade(0.3, 0.1, 1.0).1)),
        ("c1: ramp 0/0.5", ramp(0.0, 0.5)),
        ("c2: ramp 0/1", ramp(0.0, 1.0)),
        ("c3: ramp 0.5/1", ramp(0.5, 1.0)),
        ("d1: fading 0.15/0/0.25", fade(0.15, 0.0, 0.25)),
        ("d2: fading 0.3/0/0.25", fade(0.3, 0.0, 0.25)),
        ("d3: fading 0.3/0/0.5", fade(0.3, 0.0, 0.5)),
    ]
}

/// The pictures of figure 14 of a scene with a blended reflector: the part of each that shows it.
pub(super) fn weighed(specification: &str, part: [f32; 4]) -> Result<RgbImage> {
    let size = Stage::new(specification, FULL, 1)?.scene.bounds.diagonal();
    let weights = weights(size);
    let weighed = |(_, (fresnel, attenuation)): &(&str, Weights)| -> Result<Stage> {
        let mut stage = Stage::new(specification, FULL, 1)?.with_samples(16);
        for material in &mut stage.scene.materials {
            if let Some(blend) = &mut material.blend {
                (blend.fresnel, blend.attenuation) = (*fresnel, *attenuation);
            }
        }
        cast_shadows(&mut stage.scene);
        Ok(stage)
    };
    let stages = weights.iter().map(weighed).collect::<Result<Vec<_>>>()?;
    let mut session = stages[0].session(CAMERAS, BUNDLE)?;
    print("| picture | FLIP on the ball | frame ms |\n|---|---|---|")?;
    let mut panels = Vec::new();
    for ((label, _), stage) in weights.iter().zip(&stages) {
        // The mirror's shape stays, so the cameras and all virtual meshes do.
        session.update(&stage.scene)?;
        let drawn = stage::draw(&mut session, &stage.view, 1)?;
        let error = flip(&drawn.picture, &stage.truth()?, &stage.mask())?;
        print(&format!("| {label} | {error:.4} | {:.0} |", drawn.first_ms))?;
        panels.push(cut(&rgb(&drawn.picture)?, part));
    }
    let (above, under) = panels.split_at(4);
    Ok(below(&[above, under].map(|row| beside_of_width(row, NARROW))))
}
