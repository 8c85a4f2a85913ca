//! From linear radiance to PNG pictures: exposure and tone.

use crate::args::DisplayArgs;
use catoptric::framebuffer::Framebuffer;
use catoptric::light::path_tracer::surface_mask;
use catoptric::scene::{Scene, View};
use catoptric::tone::{self, ToneCurve, automatic_exposure};
use catoptric_options::parse::Exposure;

/// The exposure and tone of all pictures of a command.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Display {
    shown: tone::Display,
    /// The exposure was chosen here, as little could be seen at the usual one.
    is_chosen: bool,
}

impl Display {
    /// The display that the command line asks for, by a picture of a view of the scene: the pixels that show surfaces
    /// count.
    pub(crate) fn new(args: &DisplayArgs, scene: &Scene, view: &View, picture: &Framebuffer) -> Self {
        let stops = match args.exposure {
            Some(Exposure::Stops(stops)) => Some(stops),
            Some(Exposure::Auto) | None => None,
        };
        let chosen_curve = args.tone.map(ToneCurve::from);
        if let Some(stops) = stops {
            let shown = tone::Display { exposure_stops: stops, curve: chosen_curve.unwrap_or_default() };
            return Self { shown, is_chosen: false };
        }
        let mask = surface_mask(scene, view);
        let mut shown = match args.exposure {
            None => tone::Display::fitting(picture, &mask),
            Some(_) => tone::Display { exposure_stops: automatic_exposure(picture, &mask), curve: ToneCurve::Neutral },
        };
        let is_chosen = args.exposure.is_none() && shown != tone::Display::default();
        shown.curve = chosen_curve.unwrap_or(shown.curve);
        Self { shown, is_chosen }
    }

    /// The display that the command line asks for where nothing is to be chosen here; `None` if it asks for that.
    pub(crate) fn given(args: &DisplayArgs) -> Option<Self> {
        let exposure_stops = match args.exposure {
            Some(Exposure::Stops(stops)) => stops,
            Some(Exposure::Auto) => return None,
            None => 0.0,
        };
        let curve = args.tone.map(ToneCurve::from).unwrap_or_default();
        Some(Self { shown: tone::Display { exposure_stops, curve }, is_chosen: false })
    }

    /// The picture as it is to be shown, linear.
    pub(crate) fn of(&self, picture: &Framebuffer) -> Framebuffer {
        self.shown.of(picture)
    }

    /// The picture as it is to be compared: at the same exposure, without a tone curve.
    pub(crate) fn exposed(&self, picture: &Framebuffer) -> Framebuffer {
        self.shown.exposed(picture)
    }

    /// A remark for the user that the exposure was chosen here; `None` if it was not.
    pub(crate) fn remark(&self) -> Option<String> {
        let stops = self.shown.exposure_stops;
        self.is_chosen.then(|| {
            let fault = if stops < 0.0 { "bright" } else { "dark" };
            format!("the picture would be too {fault}: shown at {stops:+.1} EV (--exposure 0 leaves it)")
        })
    }
}
