//! From linear radiance to PNG pictures: exposure and tone.

use crate::args::{DisplayArgs, Tone};
use crate::parse::Exposure;
use catoptric::framebuffer::Framebuffer;
use catoptric::light::path_tracer::surface_mask;
use catoptric::scene::{Scene, View};
use catoptric::tone::{ToneCurve, automatic_exposure, displayed, is_out_of_range};

/// The exposure and tone of all pictures of a command.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Display {
    stops: f32,
    curve: ToneCurve,
    /// It was chosen here, as little could be seen.
    is_chosen: bool,
}

impl Display {
    /// What the command line asks for, by a picture of a view of the scene: what surfaces show in it counts.
    pub(crate) fn new(args: &DisplayArgs, scene: &Scene, view: &View, picture: &Framebuffer) -> Self {
        let stops = match args.exposure {
            Some(Exposure::Stops(stops)) => Some(stops),
            Some(Exposure::Auto) | None => None,
        };
        let chosen_curve = args.tone.map(|tone| match tone {
            Tone::None => ToneCurve::None,
            Tone::Neutral => ToneCurve::Neutral,
            Tone::Agx => ToneCurve::Agx,
            Tone::Aces => ToneCurve::Aces,
        });
        if let Some(stops) = stops {
            return Self { stops, curve: chosen_curve.unwrap_or_default(), is_chosen: false };
        }
        let mask = surface_mask(scene, view);
        let pixels = || picture.pixels.iter().zip(&mask).filter(|(_, is_seen)| **is_seen).map(|(pixel, _)| *pixel);
        let is_chosen = args.exposure.is_none() && is_out_of_range(pixels());
        if args.exposure.is_none() && !is_chosen {
            return Self { stops: 0.0, curve: chosen_curve.unwrap_or_default(), is_chosen };
        }
        Self { stops: automatic_exposure(pixels()), curve: chosen_curve.unwrap_or(ToneCurve::Neutral), is_chosen }
    }

    /// The picture as it is to be shown, linear.
    pub(crate) fn of(&self, picture: &Framebuffer) -> Framebuffer {
        displayed(picture, self.stops, self.curve)
    }

    /// What the user should know of it.
    pub(crate) fn remark(&self) -> Option<String> {
        let stops = self.stops;
        self.is_chosen.then(|| {
            format!("the picture would be too dark or too bright: shown at {stops:+.1} EV (--exposure 0 leaves it)")
        })
    }
}
