//! Figures 3 to 21 of Popescu, Sacks, Mei 2006, made again: sample-based cameras beside the reference.

mod accuracy;
mod construction;
mod highlights;
mod hybrid;
mod morphing;
mod rows;
mod sizes;
mod weights;

use crate::commands::{Figure, Line};
use crate::panels::{below, beside, beside_of_width, cut, save_small};
use crate::repository::root;
use crate::stage::{BUNDLE, CAMERAS, PINHOLE, Stage, count, flip, print, rgb};
use anyhow::Result;
use catoptric::framebuffer::Framebuffer;
use catoptric::methods::projection::sample_based_camera::{SampleBasedCameraSettings, visible_pieces};
use catoptric::progress::Silent;
use image::{Rgb, RgbImage};
use rows::{line, of_stage};
use sizes::{BALL, FULL, NARROW, PANEL};
use weights::weighed;

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

/// Figure 14: how the reflection is weighed against the reflector's own colour.
fn surface_properties() -> Result<RgbImage> {
    weighed("sphere_room?blend=both", BALL)
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
    use crate::stage;

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
