//! Figures 3 to 21 of Popescu, Sacks, Mei 2006, made again: sample-based cameras beside the reference.

mod accuracy;
mod construction;
mod highlights;
mod hybrid;
mod morphing;

use crate::commands::{Figure, Line, Shot, settings_of};
use crate::panels::{below, beside, beside_of_width, cut, save_small};
use crate::root;
use crate::stage::{self, Stage, count, flip, print, rgb};
use anyhow::Result;
use catoptric::framebuffer::Framebuffer;
use catoptric::light::visibility::cast_shadows;
use catoptric::methods::projection::sample_based_camera::{SampleBasedCameraSettings, visible_pieces};
use catoptric::progress::Silent;
use catoptric::scene::Attenuation;
use image::{Rgb, RgbImage};

/// The method of this page.
pub(crate) const CAMERAS: &str = "sample_based_camera";
/// The paper's cameras at the paper's accuracy.
pub(crate) const PINHOLE: &str = "preset = 'faithful'";
/// Ours, as they are without any setting.
const BUNDLE: &str = "";

/// The size of the paper's pictures.
const FULL: [u32; 2] = [720, 480];
/// The size of pictures that are shown in one panel only.
const PANEL: [u32; 2] = [360, 240];

/// The part of the pictures of `sphere_room` that shows the ball.
pub(crate) const BALL: [f32; 4] = [0.27, 0.1, 0.46, 0.72];
/// The width of panels that show the ball alone.
const NARROW: u32 = 240;

type Draw = fn() -> Result<RgbImage>;

/// Draws the figures whose names contain `wanted` (`cameras` alone: all) and prints their tables as Markdown.
pub(crate) fn draw(wanted: &str) -> Result<()> {
    let figures: [(&str, Draw); 10] = [
        ("cameras-03", three_methods),
        ("cameras-13", highlights::draw),
        ("cameras-14", surface_properties),
        ("cameras-14-lit", highlights::draw_weighed),
        ("cameras-15", morphing::draw),
        ("cameras-16", resolutions),
        ("cameras-17", accuracy::draw),
        ("cameras-18", four_scenes),
        ("cameras-20", pieces_and_lens),
        ("cameras-21", hybrid::draw),
    ];
    for (name, draw) in figures.iter().filter(|(name, _)| name.contains(wanted)) {
        print(&format!("\n{name}\n"))?;
        let number = name.strip_prefix("cameras-").unwrap_or(name);
        let path = root().join(format!("docs/pictures/sample_based_camera-figure-{number}.png"));
        save_small(&draw()?, &path)?;
    }
    if "cameras-19".contains(wanted) {
        print("\ncameras-19\n")?;
        construction::print_table()?;
    }
    if "cameras-walk".contains(wanted) {
        print("\ncameras-walk\n")?;
        morphing::print_walk()?;
    }
    Ok(())
}

/// A line of a figure: scene, size, samples, order, method, settings.
type Row<'a> = (&'a str, [u32; 2], u32, u32, &'a str, &'a str);

/// The line of what a [`Stage`] draws.
fn of_stage((scene, size, samples, order, method, settings): Row<'_>) -> Line {
    line((scene, size, samples, order, method, &stage::alone_if_cameras(method, settings)))
}

fn line((scene, size, samples, order, method, settings): Row<'_>) -> Line {
    let settings = settings_of(settings);
    let settings: Vec<&str> = settings.iter().map(String::as_str).collect();
    Shot { scene: &format!("builtin:{scene}"), size, samples, order }.drawn(method, &settings)
}

/// The lines of the figures that the program can draw: others turn, weigh or colour what it shows.
pub(crate) fn commands() -> Vec<Figure> {
    let page = "figures-sample-based-camera.md";
    let figure = |name: &str, lines: Vec<Line>| Figure { page, name: name.into(), lines };
    let of_room = |(_, method, settings): &(&str, &str, &str)| of_stage(("sphere_room", FULL, 16, 1, method, settings));
    let resolutions = RESOLUTIONS.iter().flat_map(|(_, settings)| {
        SPACINGS.map(|spacing| {
            of_stage(("sphere_room", FULL, 4, 1, CAMERAS, &format!("{settings}\ndownsampling = {spacing}")))
        })
    });
    let scenes = construction::SCENES.map(|(_, scene, order)| of_stage((scene, PANEL, 16, order, CAMERAS, OF_SCENES)));
    vec![
        figure("cameras-03", THREE.iter().map(of_room).collect()),
        figure("cameras-16", resolutions.collect()),
        figure(
            "cameras-17",
            accuracy::COMPARED
                .map(|(method, settings)| of_stage(("sphere_room?surface=analytic", FULL, 16, 1, method, settings)))
                .into(),
        ),
        figure("cameras-18", scenes.into()),
        figure("cameras-20", vec![of_stage(("lens", FULL, 16, 2, CAMERAS, BUNDLE))]),
        figure("cameras-21", hybrid::commands(of_stage)),
        figure("cameras-walk", morphing::commands(line)),
    ]
}

/// The methods of figure 3.
const THREE: [(&str, &str, &str); 3] = [
    ("environment map", "environment_map", ""),
    ("sample-based camera, pinholes", CAMERAS, PINHOLE),
    ("sample-based camera, ray bundles", CAMERAS, BUNDLE),
];

/// The cameras of figure 16, and the spacings of their rays.
const RESOLUTIONS: [(&str, &str); 2] = [("pinholes", PINHOLE), ("ray bundles, 1 px", "accuracy_px = 1.0")];
const SPACINGS: [u32; 4] = [32, 16, 8, 4];

/// The cameras of figure 18.
const OF_SCENES: &str = "preset = 'fast'\ndownsampling = 2";

/// Figure 3: environment map, sample-based camera, ray tracing.
fn three_methods() -> Result<RgbImage> {
    let stage = Stage::new("sphere_room", FULL, 1)?.with_samples(16);
    let (truth, mask) = (stage.truth()?, stage.mask());
    print("| picture | FLIP on the ball | first frame ms | later frames ms |\n|---|---|---|---|")?;
    let mut panels = Vec::new();
    for (label, method, settings) in THREE {
        let drawn = stage.draw(method, settings, 4)?;
        let error = flip(&drawn.picture, &truth, &mask)?;
        print(&format!("| {label} | {error:.4} | {:.0} | {:.0} |", drawn.first_ms, drawn.later_ms))?;
        panels.push(rgb(&drawn.picture)?);
    }
    let reference = stage.draw("reference", "", 3)?;
    print(&format!("| reference | | {:.0} | {:.0} |", reference.first_ms, reference.later_ms))?;
    panels.push(rgb(&truth)?);
    let (above, under) = panels.split_at(2);
    Ok(below(&[beside(above), beside(under)]))
}

/// The weights of a reflection by angle and by distance.
type Weights = (Option<[f32; 2]>, Option<Attenuation>);

/// Those of figure 14; distances are shares of a scene's size.
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

/// Figure 14: how the reflection is weighed against the reflector's own colour.
fn surface_properties() -> Result<RgbImage> {
    weighed("sphere_room?blend=both", BALL)
}

/// The pictures of figure 14 of a scene with a blended reflector: the part of each that shows it.
fn weighed(specification: &str, part: [f32; 4]) -> Result<RgbImage> {
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

/// Figure 16: resolutions of the ray map.
fn resolutions() -> Result<RgbImage> {
    let stage = Stage::new("sphere_room", FULL, 1)?;
    let (truth, mask) = (stage.truth()?, stage.mask());
    print(
        "| cameras | ray map | rays | leaves | ray lists | rays in lists | FLIP on the ball | p50 px | p99 px | max px \
        | missing % |",
    )?;
    print("|---|---|---|---|---|---|---|---|---|---|---|")?;
    let mut rows = Vec::new();
    for (label, settings) in RESOLUTIONS {
        let mut panels = Vec::new();
        for spacing in SPACINGS {
            let settings = format!("{settings}\ndownsampling = {spacing}");
            let drawn = stage.draw(CAMERAS, &settings, 1)?;
            let error = stage.projection_error(CAMERAS, &settings, 2)?;
            let report = &drawn.report;
            let pixels = |error: Option<f64>| error.map_or("".into(), |error| format!("{error:.3}"));
            print(&format!(
                "| {label} | {}x{}/{spacing} | {} | {} | {} | {} | {:.4} | {} | {} | {} | {:.3} |",
                FULL[0] / spacing,
                FULL[1] / spacing,
                count(report, "ray_map_rays"),
                count(report, "leaves"),
                count(report, "ray_lists"),
                count(report, "rays_in_lists"),
                flip(&drawn.picture, &truth, &mask)?,
                pixels(error.p50),
                pixels(error.p99),
                pixels(error.max),
                100.0 * error.missing,
            ))?;
            panels.push(cut(&rgb(&drawn.picture)?, BALL));
        }
        rows.push(beside_of_width(&panels, NARROW));
    }
    Ok(below(&rows))
}

/// Figure 18: the scenes of the table; below, the reference.
fn four_scenes() -> Result<RgbImage> {
    print(
        "| scene | FLIP on reflectors | first frame ms | later frames ms | reference, 16 samples, ms \
        |\n|---|---|---|---|---|",
    )?;
    let mut rows = [Vec::new(), Vec::new()];
    for (label, specification, order) in construction::SCENES {
        let stage = Stage::new(specification, PANEL, order)?.with_samples(16);
        let reference = stage.draw("reference", "", 1)?;
        let drawn = stage.draw(CAMERAS, OF_SCENES, 3)?;
        print(&format!(
            "| {label} | {:.4} | {:.0} | {:.0} | {:.0} |",
            flip(&drawn.picture, &reference.picture, &stage.mask())?,
            drawn.first_ms,
            drawn.later_ms,
            reference.first_ms
        ))?;
        for (row, picture) in rows.iter_mut().zip([drawn.picture, reference.picture]) {
            row.push(rgb(&picture)?);
        }
    }
    Ok(below(&rows.map(|row| beside_of_width(&row, 288))))
}

/// Figure 20: the pieces of a compound reflector, and refraction through a lens.
fn pieces_and_lens() -> Result<RgbImage> {
    let car = Stage::new("car", FULL, 1)?;
    let (paths, pieces) = visible_pieces(&car.scene, &car.view, &SampleBasedCameraSettings::default(), &Silent)?;
    let mut coloured = car.panel("reference", "")?;
    let mut counted = std::collections::BTreeMap::<[u32; 2], u32>::new();
    for ((pixel, piece), seen) in coloured.pixels_mut().zip(&pieces).zip(car.mask()) {
        if let (Some(piece), true) = (piece, seen) {
            *counted.entry(*piece).or_default() += 1;
            let shade = pixel.0.map(|channel| channel / 3);
            let [red, green, blue] = colour_of(*piece);
            *pixel = Rgb([red / 3 * 2 + shade[0], green / 3 * 2 + shade[1], blue / 3 * 2 + shade[2]]);
        }
    }
    print(&format!("Automobile: {} reflectors, {} pieces with visible pixels:\n", paths.len(), counted.len()))?;
    print("| reflector | pieces | of more than 100 pixels | pixels |\n|---|---|---|---|")?;
    for (path, number) in paths.iter().zip(0..) {
        let own: Vec<u32> = counted.iter().filter(|([of, _], _)| *of == number).map(|(_, pixels)| *pixels).collect();
        let large = own.iter().filter(|pixels| **pixels > 100).count();
        print(&format!("| {} | {} | {large} | {} |", path.names(&car.scene), own.len(), own.iter().sum::<u32>()))?;
    }
    let lens = Stage::new("lens", FULL, 2)?.with_samples(16);
    let truth: Framebuffer = lens.truth()?;
    let drawn = lens.draw(CAMERAS, BUNDLE, 3)?;
    print(&format!(
        "\nLens, order 2: FLIP on the lens {:.4}, first frame {:.0} ms, later frames {:.0} ms",
        flip(&drawn.picture, &truth, &lens.mask())?,
        drawn.first_ms,
        drawn.later_ms
    ))?;
    Ok(beside_of_width(&[coloured, rgb(&drawn.picture)?, rgb(&truth)?], 480))
}

/// A colour for every piece of every reflector: reflectors that follow each other differ most in hue.
fn colour_of([path, piece]: [u32; 2]) -> [u8; 3] {
    let hue = (path as f32 * 0.381_966 + piece as f32 * 0.137_2).fract() * 6.0;
    [0.0, 4.0, 2.0].map(|offset: f32| {
        let distance = ((hue + offset) % 6.0 - 3.0).abs();
        (255.0 * (distance - 1.0).clamp(0.0, 1.0)) as u8
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_ball_is_one_piece_of_one_reflector() {
        let stage = Stage::new("sphere_room", [90, 60], 1).unwrap();
        let (paths, pieces) =
            visible_pieces(&stage.scene, &stage.view, &SampleBasedCameraSettings::default(), &Silent).unwrap();
        assert_eq!(paths.len(), 1);
        for (piece, seen) in pieces.iter().zip(stage.mask()) {
            assert!(!seen || *piece == Some([0, 0]), "{piece:?}");
        }
    }

    #[test]
    fn what_is_prepared_for_a_view_is_not_made_again() {
        let stage = Stage::new("sphere_room", [90, 60], 1).unwrap();
        let mut session = stage.session(CAMERAS, BUNDLE).unwrap();
        let report = session.prepare_view(&stage.view).unwrap();
        assert!(count(&report, "rays_traced") > 0 && count(&report, "leaves") > 0);
        let drawn = stage::draw(&mut session, &stage.view, 1).unwrap();
        assert_eq!(count(&drawn.report, "rays_traced"), 0);
        assert_eq!(count(&drawn.report, "leaves"), count(&report, "leaves"));
    }
}
