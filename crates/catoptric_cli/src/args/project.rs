//! The options of `project`.

use super::PoseArgs;
use crate::parse::{self, FileOrStream, PointSource};
use clap::{Args, ValueHint};
use glam::{DVec3, Vec3};
use std::ffi::OsString;
use std::path::{Path, PathBuf};

#[derive(Args)]
pub(crate) struct ProjectArgs {
    /// A .glb, .gltf, .obj, .ply, .stl or .toml file, or builtin:NAME[?key=value&...]
    #[arg(value_name = "SCENE", help_heading = "Scene", display_order = 0)]
    pub(crate) scene: PathBuf,
    /// Make mirrors of what has this node or material name and is no reflector or lens, as in `render`; without --only
    /// paths are limited to what is named (repeat)
    #[arg(long, value_name = "NAME or GLOB", help_heading = "Scene", display_order = 1)]
    pub(crate) reflector: Vec<String>,
    /// Limit paths to reflectors and lenses of this node or material name; others still block (repeat) [default: all]
    #[arg(long, value_name = "NAME or GLOB", help_heading = "Scene", display_order = 2)]
    pub(crate) only: Vec<String>,
    /// Position of the eye [default: the camera's eye]
    #[arg(long, value_name = "X,Y,Z", value_parser = parse::exact_vector, allow_hyphen_values = true)]
    #[arg(help_heading = "View")]
    pub(crate) eye: Option<DVec3>,
    /// The points: .csv with the columns x, y, z, .jsonl, or .npy with N x 3 numbers; `-`: CSV from standard input.
    /// grid:NODE:STEP: the surface of a node, a point for each square of this side
    #[arg(long, value_name = "FILE or grid:NODE:STEP", value_parser = parse::points())]
    #[arg(value_hint = ValueHint::FilePath, help_heading = "Scene")]
    pub(crate) points: PointSource,
    /// File of the paths: .csv, .jsonl (a JSON object a line) or .npy; `-`: CSV to standard output
    #[arg(long, short, value_name = "FILE", value_parser = parse::table_path(), value_hint = ValueHint::FilePath)]
    #[arg(help_heading = "Output")]
    pub(crate) output: FileOrStream,
    /// The most bounces on a path; at a lens both branches count
    #[arg(long, value_name = "K", default_value = "1", value_parser = clap::value_parser!(u32).range(1..=4))]
    #[arg(help_heading = "Method")]
    pub(crate) order: u32,
    /// Picture size in pixels; fills image_x and image_y
    #[arg(long, value_name = "WxH", value_parser = parse::size, help_heading = "View")]
    pub(crate) size: Option<[u32; 2]>,
    /// A camera of the scene, or a .json file with OpenCV's K, R and t or a 3x4 matrix P; with --eye it is moved there
    /// [default: its first, else one that frames it]
    #[arg(long, value_name = "NAME, INDEX or FILE.json", conflicts_with = "target", help_heading = "View")]
    pub(crate) camera: Option<OsString>,
    /// File for the picture's camera as K, R, t and P
    #[arg(long, value_name = "FILE.json", value_parser = parse::camera_path(), help_heading = "Output")]
    pub(crate) write_camera: Option<PathBuf>,
    /// Point that the eye looks at, in place of the camera's direction
    #[arg(long, value_name = "X,Y,Z", value_parser = parse::exact_vector, allow_hyphen_values = true, requires = "eye")]
    #[arg(help_heading = "View")]
    pub(crate) target: Option<DVec3>,
    /// Upward direction [default: 0,1,0]
    #[arg(long, value_name = "X,Y,Z", value_parser = parse::vector, allow_hyphen_values = true, requires = "target")]
    #[arg(help_heading = "View")]
    pub(crate) up: Option<Vec3>,
    /// Vertical field of view in degrees [default: the camera's; 40 with --target]
    #[arg(long, value_name = "DEG", value_parser = parse::field_of_view, allow_hyphen_values = true)]
    #[arg(help_heading = "View")]
    pub(crate) fov: Option<f32>,
    /// Add rows for the straight line from the eye to each point (`kinds` and `path` are empty)
    #[arg(long, help_heading = "Output")]
    pub(crate) direct: bool,
    /// Add the derivative of the first bounce point
    #[arg(long, help_heading = "Output")]
    pub(crate) jacobian: bool,
    /// Keep paths that a reflector, a lens or the surface itself blocks: all of one bounce on exact surfaces; on
    /// meshes, and of more bounces, those found from rays that the eye sees
    #[arg(long, help_heading = "Method")]
    pub(crate) ignore_visibility: bool,
    /// `exact`, or a method that projects points (it works with --size)
    #[arg(long, value_name = "ID", default_value = "exact", help_heading = "Method", display_order = 0)]
    pub(crate) method: String,
    /// A setting of the method, over the scene's own (repeat)
    #[arg(long, value_name = "KEY=VALUE", value_parser = parse::key_value, help_heading = "Method", display_order = 0)]
    pub(crate) set: Vec<(String, String)>,
    #[command(flatten)]
    pub(crate) pose: PoseArgs,
}

impl ProjectArgs {
    /// The file of the camera; `None` if it is one of the scene.
    pub(crate) fn camera_file(&self) -> Option<&Path> {
        self.camera.as_deref().map(Path::new).filter(|camera| parse::is_camera(camera))
    }
}
