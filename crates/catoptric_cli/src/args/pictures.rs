//! The command line of the pictures that `catoptric render` writes.

use crate::parse::{self, FramesWanted, Region};
use clap::{Args, ValueEnum};
use std::path::PathBuf;

/// Bits of each channel of PNG pictures.
#[derive(Clone, Copy, Debug, PartialEq, Eq, ValueEnum)]
pub(crate) enum Bits {
    #[value(name = "8")]
    Eight,
    #[value(name = "16")]
    Sixteen,
}

/// Which frames there are.
#[derive(Args)]
#[command(next_help_heading = "View")]
pub(crate) struct SequenceArgs {
    /// Frames to draw: N, of which the last one is written, or all of them where the name in -o has a pattern; A..B
    /// writes frames A to B, numbered from 1 [default: 1]
    #[arg(long, value_name = "N or A..B", value_parser = parse::frames_wanted, conflicts_with = "turntable")]
    pub(crate) frames: Option<FramesWanted>,
    /// Frames a second of --motion animation: frame n shows the time --time + (n - 1) / FPS
    #[arg(long, value_name = "FPS", default_value = "30", value_parser = parse::frames_per_second)]
    pub(crate) fps: f32,
    /// Draw N frames while the eye goes once around the middle of the scene: an eye that frames all of it, whatever
    /// cameras there are, or that of --eye or --camera
    #[arg(long, value_name = "N", value_parser = clap::value_parser!(u32).range(1..=100_000))]
    #[arg(conflicts_with = "motion")]
    pub(crate) turntable: Option<u32>,
}

/// The content of pictures beside their colours, and its format.
#[derive(Args)]
#[command(next_help_heading = "Output")]
pub(crate) struct PictureArgs {
    /// Bits a channel of PNG pictures [default: 8]
    #[arg(long, value_enum, value_name = "N")]
    pub(crate) bits: Option<Bits>,
    /// Write EXR pictures with half floats, in place of 32-bit ones
    #[arg(long)]
    pub(crate) half: bool,
    /// Write this part of the picture alone: the left top corner and the size, in pixels. All of it is drawn, which
    /// takes as long
    #[arg(long, value_name = "X,Y,W,H", value_parser = parse::region)]
    pub(crate) region: Option<Region>,
    /// Leave out the background that the eye sees directly: alpha is the share of a pixel that shows a surface (glass
    /// is opaque). Colours are multiplied by it in EXR, and are not in PNG and WebP
    #[arg(long)]
    pub(crate) transparent: bool,
    /// Write more layers into the EXR picture: depth, normal, object.id, and reflection, which is what mirrors and
    /// glass add to the picture
    #[arg(long)]
    pub(crate) layers: bool,
    /// Picture of the share of each pixel whose first surface is a reflector or lens (.png or .exr)
    #[arg(long, value_name = "FILE", value_parser = parse::mask_path())]
    pub(crate) mask: Option<PathBuf>,
}
