//! The shapes of optics as surfaces of `[[reflector]]`: conics and aspheres with an aperture, cylinders, cones, disks
//! and lenses.

mod lens;
mod profile;
mod reading;
mod sheet;

use super::super::key_error::{KeyError, wrong};
use super::keys::{Keys, Text};
use catoptric_core::error::SceneError;
use catoptric_core::surface::{AnalyticSurface, Revolution};
pub(super) use reading::{Kind, kind_named, kind_names};
use reading::{explain, read_length, read_profile, read_window};
pub(super) use sheet::{Form, Sheet};

/// Takes the keys of a kind; `is_glass` closes cylinders and cones by flat lids.
pub(super) fn read(
    text: Text<'_>,
    table: &mut Keys<'_, '_>,
    kind: Kind,
    is_glass: bool,
) -> Result<Vec<Sheet>, SceneError> {
    match kind {
        Kind::Conic(..) | Kind::Asphere => {
            let profile = read_profile(table, kind)?;
            let window = read_window(text, table)?;
            Ok(vec![profile.sheet(&window, true).map_err(|error| explain(table, error))?])
        }
        Kind::Cylinder => {
            let [radius, height] = [read_length(table, "radius")?, read_length(table, "height")?];
            turned(height, [radius, radius], is_glass).map_err(|error| explain(table, error))
        }
        Kind::Cone => {
            let [radius, height] = [read_length(table, "radius")?, read_length(table, "height")?];
            let top = if table.has("top_radius") { read_length(table, "top_radius")? } else { 0.0 };
            turned(height, [radius, top], is_glass).map_err(|error| explain(table, error))
        }
        Kind::Disk => Ok(vec![Sheet::in_place(Form::Disk { radius: read_length(table, "radius")?, is_up: true })]),
        Kind::Lens if !is_glass => Err(table.missing("ior", "missing; a lens needs its index of refraction")),
        Kind::Lens => lens::read(table),
    }
}

/// A cylinder or cone about the axis y with its middle at the origin: the radii of its base and its top.
fn turned(height: f64, [base, top]: [f64; 2], is_closed: bool) -> Result<Vec<Sheet>, KeyError> {
    if is_closed {
        let mut sheets = sheet::halves(height, [base, top], ["left side", "right side"])?;
        let lid = |name, radius, is_up, height| Sheet::in_place(Form::Disk { radius, is_up }).named(name, height);
        sheets.push(lid("base", base, false, -0.5 * height));
        sheets.extend((top > 0.0).then(|| lid("top", top, true, 0.5 * height)));
        return Ok(sheets);
    }
    let side = match Revolution::new(height, [0.0, 0.0, top - base, base]) {
        Ok(side) => AnalyticSurface::Revolution(side),
        Err(error) => return wrong("radius", error.to_string()),
    };
    Ok(vec![Sheet::in_place(Form::Exact(Box::new(side))).named("", -0.5 * height)])
}
