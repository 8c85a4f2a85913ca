//! Rough and bumpy mirrors: pictures, errors and times beside the reference's.

use crate::panels::{below, beside_of_width, save_small};
use crate::repository::root;
use crate::stage::{Stage, flip, print, rgb, stage_ms};
use anyhow::{Context, Error, Result};
use catoptric::light::visibility::cast_shadows;
use catoptric::metrics::Comparison;
use catoptric::scene::{Environment, Microfacets, Role};
use glam::Vec3;
use image::RgbImage;
use std::sync::Arc;

/// The size of pictures.
const SIZE: [u32; 2] = [720, 480];
/// The size of pictures whose time is taken.
const TIMED: [u32; 2] = [1280, 720];
/// The width of panels.
const WIDTH: u32 = 360;

/// Rays from each place of a rough mirror that make the truth, and another truth: their difference is its noise.
const TRUTH: &str = "rough_rays = 64";
const OTHER_TRUTH: &str = "rough_rays = 64\nseed = 1";

/// Frames of which the shortest tells the cost of light.
const FRAMES: u32 = 15;

type Draw = fn() -> Result<Option<RgbImage>>;

/// Draws the figures whose names contain `wanted` (`surfaces` alone: all) and prints their tables as Markdown.
pub(crate) fn draw(wanted: &str) -> Result<()> {
    let figures: [(&str, Draw); 4] = [
        ("surfaces-rough", rough),
        ("surfaces-bumpy", bumpy),
        ("surfaces-workshop", workshop),
        ("surfaces-cost", cost),
    ];
    for (name, draw) in figures.iter().filter(|(name, _)| name.contains(wanted)) {
        print(&format!("\n{name}\n"))?;
        if let Some(picture) = draw()? {
            save_small(&picture, &root().join(format!("docs/pictures/{name}.png")))?;
        }
    }
    Ok(())
}

/// Balls of three roughnesses: reference, multiperspective rasterisation, environment map.
fn rough() -> Result<Option<RgbImage>> {
    print(
        "| roughness | picture | FLIP on the balls | frame ms | of these, grids and blur | reference ms |\n\
        |---|---|---|---|---|---|",
    )?;
    let mut rows = Vec::new();
    for roughness in [0.1, 0.2, 0.4] {
        let specification = format!("brushed?roughness={roughness}");
        let stage = Stage::new(&specification, SIZE, 2)?.with_samples(16);
        let (mask, truth) = (stage.mask(), stage.draw("reference", TRUTH, 1)?.picture);
        let noise = flip(&stage.draw("reference", OTHER_TRUTH, 1)?.picture, &truth, &mask)?;
        print(&format!("| {roughness} | reference, other rays | {noise:.4} | | | |"))?;
        let timed = Stage::new(&specification, TIMED, 2)?;
        let reference_ms = timed.draw("reference", "", 1)?.first_ms;
        let mut row = vec![rgb(&truth)?];
        for method in ["multiperspective", "environment_map", "light_field", "layered_environment_map"] {
            let picture = stage.draw(method, "", 1)?.picture;
            let frames = timed.draw(method, "", 4)?;
            let rough_ms = match stage_ms(&frames.report, "rough") {
                0.0 => String::new(),
                time => format!("{time:.0}"),
            };
            print(&format!(
                "| {roughness} | {method} | {:.4} | {:.0} | {rough_ms} | {reference_ms:.0} |",
                flip(&picture, &truth, &mask)?,
                frames.later_ms,
            ))?;
            if row.len() < 3 {
                row.push(rgb(&picture)?);
            }
        }
        rows.push(beside_of_width(&row, WIDTH));
    }
    Ok(Some(below(&rows)))
}

/// Water, a wavy mirror and a pane: reference, multiperspective rasterisation, environment map.
fn bumpy() -> Result<Option<RgbImage>> {
    print(
        "| scene | picture | reflector pixels off by > 0.1 | FLIP on them | frame ms | smooth ms | reference ms |\n\
        |---|---|---|---|---|---|---|",
    )?;
    let mut rows = Vec::new();
    for (specification, camera) in [("rippled", 0), ("rippled", 1), ("rippled?copies=40", 0)] {
        let seen = |specification: &str, size: [u32; 2]| -> Result<Stage> {
            let mut stage = Stage::new(specification, size, 2)?;
            stage.view = stage.scene.view(&stage.scene.cameras[camera], size[0], size[1]);
            Ok(stage)
        };
        let stage = seen(specification, SIZE)?.with_samples(16);
        let (mask, truth) = (stage.mask(), stage.truth()?);
        let timed = seen(specification, TIMED)?;
        let smooth = seen("rippled?bumps=0", TIMED)?;
        let reference_ms = timed.draw("reference", "", 1)?.first_ms;
        let mut row = vec![rgb(&truth)?];
        for method in ["multiperspective", "environment_map"] {
            let picture = stage.draw(method, "", 1)?.picture;
            let error = Comparison::new(&picture, &truth)?.masked(&mask)?.context("no reflector is seen")?;
            print(&format!(
                "| `{specification}`, camera {camera} | {method} | {:.2} % | {:.4} | {:.0} | {:.0} \
                | {reference_ms:.0} |",
                100.0 * error.over_0_1,
                error.flip_mean,
                timed.draw(method, "", 4)?.later_ms,
                smooth.draw(method, "", 4)?.later_ms,
            ))?;
            row.push(rgb(&picture)?);
        }
        rows.push(beside_of_width(&row, WIDTH));
    }
    Ok(Some(below(&rows)))
}

/// A workbench with things of a dozen materials: reference and multiperspective rasterisation.
fn workshop() -> Result<Option<RgbImage>> {
    print("| camera | FLIP on reflectors | frame ms | reference ms |\n|---|---|---|---|")?;
    let mut rows = Vec::new();
    for camera in 0..2 {
        let mut stage = Stage::new("workshop", SIZE, 3)?;
        cast_shadows(&mut stage.scene);
        stage.view = stage.scene.view(&stage.scene.cameras[camera], SIZE[0], SIZE[1]);
        let truth = stage.draw("reference", TRUTH, 1)?.picture;
        let reference_ms = stage.draw("reference", "", 1)?.first_ms;
        let frames = stage.draw("multiperspective", "", 4)?;
        print(&format!(
            "| {} | {:.4} | {:.0} | {reference_ms:.0} |",
            stage.scene.cameras[camera].name,
            flip(&frames.picture, &truth, &stage.mask())?,
            frames.later_ms,
        ))?;
        rows.push(beside_of_width(&[rgb(&truth)?, rgb(&frames.picture)?], 540));
    }
    Ok(Some(below(&rows)))
}

/// The costs of lights, normal maps and an environment where nothing mirrors.
fn cost() -> Result<Option<RgbImage>> {
    print(
        "| surfaces | Lambert's law ms | metallic-roughness ms | ratio | with shadows ms | reference, Lambert ms | \
        ratio |\n|---|---|---|---|---|---|---|",
    )?;
    for specification in ["workshop", "highlights", "brushed"] {
        let mut stage = Stage::new(specification, TIMED, 1)?;
        stage.scene.environment = Some(Arc::new(sky()));
        for material in &mut stage.scene.materials {
            material.role = Role::Diffuse;
            material.microfacets.get_or_insert_with(|| Microfacets { roughness: 0.5, ..Microfacets::default() });
        }
        let mut plain = Stage::new(specification, TIMED, 1)?;
        plain.scene = stage.scene.clone();
        for material in &mut plain.scene.materials {
            (material.microfacets, material.normal_map, material.occlusion_map) = (None, None, None);
        }
        let mut shadowed = Stage::new(specification, TIMED, 1)?;
        shadowed.scene = stage.scene.clone();
        cast_shadows(&mut shadowed.scene);
        let time = |stage: &Stage, method: &str, frames: u32| Ok::<_, Error>(stage.draw(method, "", frames)?.later_ms);
        let (lambert, facets) = (time(&plain, "auto", FRAMES)?, time(&stage, "auto", FRAMES)?);
        let with_shadows = time(&shadowed, "auto", FRAMES)?;
        let (of_plain, of_facets) = (time(&plain, "reference", 3)?, time(&stage, "reference", 3)?);
        print(&format!(
            "| {specification} | {lambert:.1} | {facets:.1} | {:.2} | {with_shadows:.1} | {of_plain:.0} | {:.2} |",
            facets / lambert,
            of_facets / of_plain,
        ))?;
    }
    Ok(None)
}

/// A sky that is brighter above, with a sun.
fn sky() -> Environment {
    let (width, height) = (256u32, 128u32);
    let sun = Vec3::new(0.4, 0.7, 0.6).normalize();
    let texel = |index: u32| {
        let (u, v) = ((index % width) as f32 + 0.5, (index / width) as f32 + 0.5);
        let direction = Environment::direction(u / width as f32, v / height as f32);
        let above = Vec3::new(0.5, 0.7, 1.0) * (0.3 + 0.7 * direction.y.max(0.0));
        (above + Vec3::splat(20.0) * (direction.dot(sun) - 0.99).max(0.0)).to_array()
    };
    Environment::new("sky", width, height, (0..width * height).map(texel).collect())
}
