//! The scene, its environment, and the roles of its parts.

use crate::parse;
use catoptric::light::visibility::DIFFUSE_BOUNCES;
use catoptric_scenes::import::EnvironmentEdit;
use clap::{Args, ValueEnum};
use serde::{Deserialize, Serialize};
use std::path::PathBuf;

/// The scene and the roles of its parts.
#[derive(Args, Clone, Debug)]
#[command(next_help_heading = "Scene")]
pub struct SceneArgs {
    /// A .glb, .gltf, .obj, .ply, .stl or .toml file, or builtin:NAME[?key=value&...]
    #[arg(value_name = "SCENE", display_order = 0)]
    pub scene: PathBuf,
    /// Light from infinity.
    #[command(flatten)]
    pub environment: EnvironmentArgs,
    /// Make objects of this node or material name mirrors (repeat; of several roles of an object the last holds)
    #[arg(long, alias = "mirror", value_name = "GLOB")]
    pub reflector: Vec<String>,
    /// Shadows of the file's lights and of the environment, the light of surfaces that emit it, and that which surfaces
    /// scatter onto each other
    #[arg(long, value_enum, default_value = "on")]
    pub shadows: Shadows,
    /// Roles of other kinds, and the moment.
    #[command(flatten)]
    pub pose: PoseArgs,
}

/// Light from infinity.
#[derive(Args, Clone, Debug, Default)]
#[command(next_help_heading = "Scene")]
pub struct EnvironmentArgs {
    /// Light from infinity: `studio`, `sky` (clear, with the sun), or an equirectangular picture: .hdr, .exr (also cube
    /// maps), or 8-bit .png, .jpg, .webp [default: the scene's; a studio for glTF and OBJ files without light that have
    /// mirrors or glass]
    #[arg(long, aliases = ["hdri", "hdr", "env"], value_name = "NAME or FILE", value_parser = parse::file())]
    #[arg(display_order = 1)]
    pub environment: Option<PathBuf>,
    /// Turn the environment about the vertical axis y, counter-clockwise seen from above, in degrees
    #[arg(long, value_name = "DEG", value_parser = parse::rotation, allow_hyphen_values = true, display_order = 1)]
    pub environment_rotation: Option<f64>,
    /// Multiply the environment's light by this, 0 or more
    #[arg(long, value_name = "FACTOR", value_parser = parse::strength, allow_hyphen_values = true, display_order = 1)]
    pub environment_strength: Option<f64>,
}

impl EnvironmentArgs {
    /// How the environment is turned and scaled.
    pub fn edit(&self) -> EnvironmentEdit {
        EnvironmentEdit { rotation_deg: self.environment_rotation, strength: self.environment_strength }
    }
}

/// How bodies of glass without a volume are drawn.
#[derive(Args, Clone, Copy, Debug, Default)]
#[command(next_help_heading = "Scene")]
pub struct GlassArgs {
    /// Draw objects that let light pass and have no volume in the file this way [default: thin, as the format says]
    #[arg(long, value_enum)]
    pub thin_glass: Option<ThinGlass>,
}

/// Bodies of glass without a volume.
#[derive(Clone, Copy, Debug, PartialEq, Eq, ValueEnum)]
pub enum ThinGlass {
    /// Walls without thickness
    Thin,
    /// Glass all through
    Solid,
}

/// Roles of the scene's parts, and its moment.
#[derive(Args, Clone, Debug)]
#[command(next_help_heading = "Scene")]
pub struct PoseArgs {
    /// Make objects of this node or material name glass (repeat; of several roles of an object the last holds)
    #[arg(long, alias = "glass", value_name = "GLOB[:IOR]")]
    pub lens: Vec<String>,
    /// Make objects of this node or material name diffuse (repeat; of several roles of an object the last holds)
    #[arg(long, value_name = "GLOB")]
    pub diffuse: Vec<String>,
    /// Time in the file's animations, seconds; before their first keys and after their last ones they hold
    #[arg(long, value_name = "T", default_value = "0", value_parser = parse::number, allow_hyphen_values = true)]
    pub time: f32,
    /// The variant and the animation.
    #[command(flatten)]
    pub choice: ChoiceArgs,
}

/// Shadows of lights and of the environment.
#[derive(Clone, Copy, Debug, PartialEq, Eq, ValueEnum)]
pub enum Shadows {
    /// All of it, to four bounces between surfaces
    On,
    /// Without light from surface to surface
    Direct,
    /// Neither shadows nor light of surfaces
    Off,
}

impl Shadows {
    /// Bounces of light between surfaces; `None` without shadows.
    pub fn bounces(self) -> Option<u32> {
        match self {
            Self::On => Some(DIFFUSE_BOUNCES),
            Self::Direct => Some(0),
            Self::Off => None,
        }
    }
}

/// Choices among what a scene's files have several of.
#[derive(Args, Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
#[command(next_help_heading = "Scene")]
pub struct ChoiceArgs {
    /// The variant of the glTF file's materials, as `catoptric info` lists them [default: the scene file's, else the
    /// default materials]
    #[arg(long, value_name = "NAME")]
    pub variant: Option<String>,
    /// The animation that plays, alone; `catoptric info` lists them [default: all, but for those that move what an
    /// earlier one moves]
    #[arg(long, value_name = "NAME or INDEX")]
    pub animation: Option<String>,
    /// Open files that a glTF or OBJ file names wherever they lie [default: in its folder, the one above, and below]
    #[arg(long)]
    #[serde(default, skip_serializing_if = "std::ops::Not::not")]
    pub allow_outside: bool,
}
