//! The command line of scenes and of views of them.

use crate::parse;
use clap::{Args, ValueEnum};
use glam::{DVec3, Vec3};
use serde::{Deserialize, Serialize};
use std::path::PathBuf;

/// The scene and the roles of its parts.
#[derive(Args)]
#[command(next_help_heading = "Scene")]
pub(crate) struct SceneArgs {
    /// A .glb, .gltf, .obj, .ply, .stl or .toml file, or builtin:NAME[?key=value&...]
    #[arg(value_name = "SCENE", display_order = 0)]
    pub(crate) scene: PathBuf,
    #[command(flatten)]
    pub(crate) environment: EnvironmentArgs,
    /// Make objects of this node or material name mirrors (repeat; of several roles of an object the last holds)
    #[arg(long, alias = "mirror", value_name = "GLOB")]
    pub(crate) reflector: Vec<String>,
    /// Shadows of the file's lights and of the environment, and the light of surfaces that emit it
    #[arg(long, value_enum, default_value = "on")]
    pub(crate) shadows: Shadows,
    #[command(flatten)]
    pub(crate) pose: PoseArgs,
}

/// Light from infinity.
#[derive(Args, Default)]
#[command(next_help_heading = "Scene")]
pub(crate) struct EnvironmentArgs {
    /// Light from infinity: `studio`, `sky` (clear, with the sun), or an equirectangular picture: .hdr, .exr (also cube
    /// maps), or 8-bit .png, .jpg, .webp [default: the scene's; a studio for glTF and OBJ files without light that have
    /// mirrors or glass]
    #[arg(long, aliases = ["hdri", "hdr", "env"], value_name = "NAME or FILE", value_parser = parse::file())]
    #[arg(display_order = 1)]
    pub(crate) environment: Option<PathBuf>,
    /// Turn the environment about the vertical axis y, counter-clockwise seen from above, in degrees
    #[arg(long, value_name = "DEG", value_parser = parse::rotation, allow_hyphen_values = true, display_order = 1)]
    pub(crate) environment_rotation: Option<f64>,
    /// Multiply the environment's light by this, 0 or more
    #[arg(long, value_name = "FACTOR", value_parser = parse::strength, allow_hyphen_values = true, display_order = 1)]
    pub(crate) environment_strength: Option<f64>,
}

/// Bodies of glass without a volume.
#[derive(Clone, Copy, Debug, PartialEq, Eq, ValueEnum)]
pub(crate) enum ThinGlass {
    /// Walls without thickness
    Thin,
    /// Glass all through
    Solid,
}

/// Roles of the scene's parts, and its moment.
#[derive(Args)]
#[command(next_help_heading = "Scene")]
pub(crate) struct PoseArgs {
    /// Make objects of this node or material name glass (repeat; of several roles of an object the last holds)
    #[arg(long, alias = "glass", value_name = "GLOB[:IOR]")]
    pub(crate) lens: Vec<String>,
    /// Make objects of this node or material name diffuse (repeat; of several roles of an object the last holds)
    #[arg(long, value_name = "GLOB")]
    pub(crate) diffuse: Vec<String>,
    /// Time in the file's animations, seconds; before their first keys and after their last ones they hold
    #[arg(long, value_name = "T", default_value = "0", value_parser = parse::number, allow_hyphen_values = true)]
    pub(crate) time: f32,
    #[command(flatten)]
    pub(crate) choice: ChoiceArgs,
}

#[derive(Clone, Copy, Debug, PartialEq, Eq, ValueEnum)]
pub(crate) enum Shadows {
    On,
    Off,
}

/// The view of the scene.
#[derive(Args)]
#[command(next_help_heading = "View")]
pub(crate) struct ViewArgs {
    /// Picture size in pixels
    #[arg(long, value_name = "WxH", default_value = "1280x720", value_parser = parse::size)]
    pub(crate) size: [u32; 2],
    /// A camera of the scene [default: its first, else one that frames it]
    #[arg(long, value_name = "NAME or INDEX", conflicts_with = "eye")]
    pub(crate) camera: Option<String>,
    /// Position of the eye
    #[arg(long, value_name = "X,Y,Z", value_parser = parse::exact_vector)]
    #[arg(allow_hyphen_values = true)]
    pub(crate) eye: Option<DVec3>,
    /// Point that the eye looks at [default with --eye: the middle of the scene]
    #[arg(long, value_name = "X,Y,Z", value_parser = parse::exact_vector, allow_hyphen_values = true, requires = "eye")]
    pub(crate) target: Option<DVec3>,
    /// Upward direction [default: 0,1,0]
    #[arg(long, value_name = "X,Y,Z", value_parser = parse::vector, allow_hyphen_values = true, requires = "eye")]
    pub(crate) up: Option<Vec3>,
    /// Vertical field of view in degrees [default: the camera's; 40 with --eye]
    #[arg(long, value_name = "DEG", value_parser = parse::field_of_view, allow_hyphen_values = true)]
    pub(crate) fov: Option<f32>,
}

/// Choices among what a scene's files have several of.
#[derive(Args, Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
#[command(next_help_heading = "Scene")]
pub(crate) struct ChoiceArgs {
    /// The variant of the glTF file's materials, as `catoptric info` lists them [default: the scene file's, else the
    /// default materials]
    #[arg(long, value_name = "NAME")]
    pub(crate) variant: Option<String>,
    /// The animation that plays, alone; `catoptric info` lists them [default: all, but for those that move what an
    /// earlier one moves]
    #[arg(long, value_name = "NAME or INDEX")]
    pub(crate) animation: Option<String>,
    /// Open files that a glTF or OBJ file names wherever they lie [default: in its folder, the one above, and below]
    #[arg(long)]
    #[serde(default, skip_serializing_if = "std::ops::Not::not")]
    pub(crate) allow_outside: bool,
}
