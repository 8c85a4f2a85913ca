//! The view of a scene.

use crate::parse;
use clap::Args;
use glam::{DVec3, Vec3};

/// The field of view of `--eye` without `--fov`, in degrees.
pub const DEFAULT_FOV_DEG: f32 = 40.0;

/// The view of the scene.
#[derive(Args, Clone, Debug)]
#[command(next_help_heading = "View")]
pub struct ViewArgs {
    /// Picture size in pixels
    #[arg(long, value_name = "WxH", default_value = "1280x720", value_parser = parse::size)]
    pub size: [u32; 2],
    /// A camera of the scene [default: its first, else one that frames it]
    #[arg(long, value_name = "NAME or INDEX", conflicts_with = "eye")]
    pub camera: Option<String>,
    /// Position of the eye
    #[arg(long, value_name = "X,Y,Z", value_parser = parse::exact_vector)]
    #[arg(allow_hyphen_values = true)]
    pub eye: Option<DVec3>,
    /// Point that the eye looks at [default with --eye: the middle of the scene]
    #[arg(long, value_name = "X,Y,Z", value_parser = parse::exact_vector, allow_hyphen_values = true, requires = "eye")]
    pub target: Option<DVec3>,
    /// Upward direction [default: 0,1,0]
    #[arg(long, value_name = "X,Y,Z", value_parser = parse::vector, allow_hyphen_values = true, requires = "eye")]
    pub up: Option<Vec3>,
    /// Vertical field of view in degrees [default: the camera's; 40 with --eye]
    #[arg(long, value_name = "DEG", value_parser = parse::field_of_view, allow_hyphen_values = true)]
    pub fov: Option<f32>,
}
