//! Parts of optical surfaces, and the windows that cut them out.

use super::super::super::key_error::KeyError;
use catoptric_core::surface::{AnalyticSurface, Quadric, SurfaceError};
use glam::{DQuat, DVec3};

/// A surface in the frame of the whole mirror or lens.
#[derive(Clone, Debug)]
pub(in super::super) struct Sheet {
    /// The word behind the name of the whole; empty if there is one sheet.
    pub(in super::super) name: &'static str,
    pub(in super::super) form: Form,
    pub(in super::super) turn: DQuat,
    pub(in super::super) at: DVec3,
}

/// The shape of a sheet, about its own origin.
#[derive(Clone, Debug)]
pub(in super::super) enum Form {
    /// A surface by a formula.
    Exact(Box<AnalyticSurface>),
    /// A flat round face in the xz plane, as a mesh, whose outer side is at +y or at -y.
    Disk {
        /// The radius.
        radius: f64,
        /// Towards +y.
        is_up: bool,
    },
}

impl Sheet {
    pub(in super::super) fn in_place(form: Form) -> Self {
        Self { name: "", form, turn: DQuat::IDENTITY, at: DVec3::ZERO }
    }

    /// The sheet with a name, further along the axis y.
    #[must_use]
    pub(super) fn named(self, name: &'static str, height: f64) -> Self {
        Self { name, at: self.at + DVec3::Y * height, ..self }
    }
}

/// The part of a surface that is there, as seen along the axis y; the heights of centres are 0.
#[derive(Clone, Debug, PartialEq)]
pub(super) enum Window {
    Round { radius: f64, center: DVec3 },
    Rectangle { half: DVec3, center: DVec3 },
}

impl Window {
    /// The key of its size.
    pub(super) fn key(&self) -> &'static str {
        match self {
            Self::Round { .. } => "aperture_radius",
            Self::Rectangle { .. } => "aperture_size",
        }
    }

    /// The error about a window in which there is no surface that could be drawn.
    pub(super) fn wrong_part(&self, error: &SurfaceError) -> KeyError {
        let problem =
            format!("there is nothing to draw in it: the surface is too high, or too flat ({})", error.problem);
        KeyError { key: self.key(), problem }
    }

    /// The largest distance from the axis.
    pub(super) fn farthest(&self) -> f64 {
        match self {
            Self::Round { radius, center } => center.length() + radius,
            Self::Rectangle { half, center } => (center.abs() + *half).length(),
        }
    }

    /// The smallest distance from the axis.
    pub(super) fn nearest(&self) -> f64 {
        match self {
            Self::Round { radius, center } => (center.length() - radius).max(0.0),
            Self::Rectangle { half, center } => (center.abs() - *half).max(DVec3::ZERO).length(),
        }
    }

    /// The corners of the rectangle around it, with room for rounding if it is round.
    pub(super) fn corners(&self) -> [DVec3; 2] {
        let (half, center) = match self {
            Self::Round { radius, center } => (DVec3::new(1.0, 0.0, 1.0) * (radius * (1.0 + 1e-9)), *center),
            Self::Rectangle { half, center } => (*half, *center),
        };
        [center - half, center + half]
    }
}

/// The side of a body about the axis y, with its middle at the origin, in two halves: by the radii of its base and top.
///
/// A whole tube would pass for a body of its own, as its faces look in all directions alike.
pub(super) fn halves(height: f64, [base, top]: [f64; 2], names: [&'static str; 2]) -> Result<Vec<Sheet>, KeyError> {
    // x^2 + z^2 - (middle + slope y)^2, near the surface a length.
    let (middle, slope, widest) = (0.5 * (base + top), (top - base) / height, base.max(top));
    let factor = 0.5 / widest;
    let squares = [1.0, -slope * slope, 1.0, 0.0, 0.0, 0.0, 0.0, -2.0 * middle * slope, 0.0, -middle * middle];
    let wide = widest * (1.0 + 1e-9);
    let half = |name, low: f64, high: f64| {
        let (min, max) = ([low, -0.5 * height, -wide], [high, 0.5 * height, wide]);
        let surface = AnalyticSurface::Quadric(Quadric::new(squares.map(|number| number * factor), min, max)?);
        Ok::<_, KeyError>(Sheet { name, ..Sheet::in_place(Form::Exact(Box::new(surface))) })
    };
    Ok(vec![half(names[0], -wide, 0.0)?, half(names[1], 0.0, wide)?])
}
