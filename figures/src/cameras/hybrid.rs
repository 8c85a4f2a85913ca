//! Figure 21: some reflectors show environment maps, the others what sample-based cameras give.

use super::rows::Row;
use super::sizes::FULL;
use crate::commands::Line;
use crate::panels::{below, beside_of_width};
use crate::stage::{CAMERAS, Frames, Stage, flip, print, rgb};
use anyhow::Result;
use image::RgbImage;

/// The scenes with the reflectors that do not deserve cameras.
const SCENES: [(&str, &str); 2] = [("teapot", "*spout,*handle"), ("car", "nose,tail,window*")];

/// The width of a panel.
const WIDTH: u32 = 480;

/// The lines of the figure.
pub(super) fn commands(line: impl Fn(Row<'_>) -> Line) -> Vec<Line> {
    let of_scene = |(scene, mapped): (&str, &str)| {
        [settings(mapped), String::new()].map(|settings| line((scene, FULL, 16, 1, CAMERAS, &settings)))
    };
    SCENES.into_iter().flat_map(of_scene).collect()
}

/// A row for each scene: hybrid, cameras for all reflectors, reference.
pub(crate) fn draw() -> Result<RgbImage> {
    print(
        "| scene | reflectors with environment maps | mapped | FLIP on reflectors | first frame ms | later frames ms |",
    )?;
    print("|---|---|---|---|---|---|")?;
    let mut rows = Vec::new();
    for (specification, mapped) in SCENES {
        let stage = Stage::new(specification, FULL, 1)?.with_samples(16);
        let (truth, mask) = (stage.truth()?, stage.mask());
        let mut row = Vec::new();
        for names in [mapped, ""] {
            let drawn = stage.draw(CAMERAS, &settings(names), 3)?;
            print(&format!(
                "| {specification} | {} | {} | {:.4} | {:.0} | {:.0} |",
                if names.is_empty() { "none" } else { names }.replace('*', "\\*"),
                mapped_count(&drawn),
                flip(&drawn.picture, &truth, &mask)?,
                drawn.first_ms,
                drawn.later_ms,
            ))?;
            row.push(rgb(&drawn.picture)?);
        }
        row.push(rgb(&truth)?);
        rows.push(beside_of_width(&row, WIDTH));
    }
    Ok(below(&rows))
}

/// The number of reflectors that show environment maps.
fn mapped_count(drawn: &Frames) -> u64 {
    drawn.report.fallbacks.get("environment_mapped_reflectors").copied().unwrap_or_default()
}

/// The default's settings and which reflectors show environment maps.
fn settings(names: &str) -> String {
    format!("environment = '{names}'")
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn named_reflectors_of_both_scenes_are_mapped() {
        for (specification, names) in SCENES {
            let stage = Stage::new(specification, [36, 24], 1).unwrap();
            let mapped = |names: &str| mapped_count(&stage.draw(CAMERAS, &settings(names), 1).unwrap());
            assert!(mapped(names) > 0, "{specification}");
            assert_eq!(mapped(""), 0, "{specification}");
        }
    }
}
