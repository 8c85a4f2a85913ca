//! Exposure and tone of pictures for screens.

use crate::parse::{self, Exposure};
use catoptric::tone::ToneCurve;
use clap::{Args, ValueEnum};

/// Tone curves of pictures for screens.
#[derive(Clone, Copy, Debug, PartialEq, Eq, ValueEnum)]
pub enum Tone {
    /// Linear light, cut off at white
    None,
    /// Khronos PBR Neutral
    Neutral,
    /// AgX, as in Blender
    Agx,
    /// ACES, fitted
    Aces,
}

impl From<Tone> for ToneCurve {
    fn from(tone: Tone) -> Self {
        match tone {
            Tone::None => Self::None,
            Tone::Neutral => Self::Neutral,
            Tone::Agx => Self::Agx,
            Tone::Aces => Self::Aces,
        }
    }
}

/// Exposure and tone of pictures for a screen.
#[derive(Args, Clone, Copy, Debug)]
#[command(next_help_heading = "Output")]
pub struct DisplayArgs {
    /// Exposure of pictures other than EXR in stops, or `auto`: their mean becomes middle grey
    /// [default: 0, or as much as a screen needs where it would show little]
    #[arg(long, value_name = "EV", value_parser = parse::exposure, allow_hyphen_values = true)]
    pub exposure: Option<Exposure>,
    /// Tone curve of pictures other than EXR [default: none; neutral with an automatic exposure]
    #[arg(long, value_enum)]
    pub tone: Option<Tone>,
}
