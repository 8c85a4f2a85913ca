//! Lenses: two profiles, and the edge between them.

use super::super::super::key_error::MAX_LENGTH;
use super::super::keys::Keys;
use super::profile::Profile;
use super::reading::{Kind, explain, read_length, read_profile};
use super::sheet::{Sheet, Window, halves};
use catoptric_core::error::SceneError;
use glam::DVec3;

/// Distances from the axis at which the faces of a lens are compared.
const STEPS: u32 = 512;
/// Lenses whose edge is lower than this share of their radius are sharp.
const SHARP: f64 = 1e-6;

/// Takes the keys of a lens. Its middle lies between the vertices; the front is at -y.
pub(super) fn read(table: &mut Keys<'_, '_>) -> Result<Vec<Sheet>, SceneError> {
    let radius = read_length(table, "aperture_radius")?;
    let given = read_thickness(table)?;
    let window = Window::Round { radius, center: DVec3::ZERO };
    let (front, front_sheet) = read_face(table, "front", &window)?;
    let (back, back_sheet) = read_face(table, "back", &window)?;
    let thickness = match given {
        Thickness::OfAxis(thickness) => thickness,
        Thickness::OfEdge(edge) => edge + front.sag(radius) - back.sag(radius),
    };
    let gap = |step: u32| {
        let distance = radius * f64::from(step) / f64::from(STEPS);
        thickness + back.sag(distance) - front.sag(distance)
    };
    let least = (0..=STEPS).map(gap).fold(f64::INFINITY, f64::min);
    if least < -SHARP * radius {
        let problem = format!("the faces meet within the aperture: it must be {:.4} more", -least);
        return Err(table.blame(given.key(), problem));
    }
    let (bottom, edge) = (front.sag(radius) - 0.5 * thickness, gap(STEPS));
    let mut sheets = vec![front_sheet.named("front", -0.5 * thickness), back_sheet.named("back", 0.5 * thickness)];
    if edge > SHARP * radius {
        let sides = halves(edge, [radius; 2], ["left edge", "right edge"]).map_err(|error| explain(table, error))?;
        sheets.extend(sides.into_iter().map(|side| Sheet { at: DVec3::Y * (bottom + 0.5 * edge), ..side }));
    }
    Ok(sheets)
}

/// The thickness of a lens, as it is given.
#[derive(Clone, Copy)]
enum Thickness {
    OfAxis(f64),
    OfEdge(f64),
}

impl Thickness {
    fn key(self) -> &'static str {
        match self {
            Self::OfAxis(_) => "thickness",
            Self::OfEdge(_) => "edge",
        }
    }
}

fn read_thickness(table: &mut Keys<'_, '_>) -> Result<Thickness, SceneError> {
    match (table.has("thickness"), table.number("edge")?) {
        (true, Some(edge)) => Err(table.wrong("edge", edge.begin, "follows from `thickness`: leave out one of them")),
        (false, Some(edge)) if (0.0..=MAX_LENGTH).contains(&edge.value) => Ok(Thickness::OfEdge(edge.value)),
        (false, Some(edge)) => Err(table.wrong("edge", edge.begin, format!("{}; must be 0 or a length", edge.value))),
        (_, None) => Ok(Thickness::OfAxis(read_length(table, "thickness")?)),
    }
}

/// A face by its own table; without one it is flat.
fn read_face(table: &mut Keys<'_, '_>, key: &'static str, window: &Window) -> Result<(Profile, Sheet), SceneError> {
    let is_up = key == "back";
    let profile = match table.table(key)? {
        Some(mut inner) => {
            let profile = read_profile(&mut inner, Kind::Lens)?;
            inner.finish()?;
            profile
        }
        None => Profile { curvature: 0.0, conic: 0.0, terms: [0.0; 4] },
    };
    let sheet = profile.sheet(window, is_up).map_err(|error| explain(table, error))?;
    Ok((profile, sheet))
}
