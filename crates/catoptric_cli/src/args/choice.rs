//! The options that choose among what a scene file has several of.

use clap::Args;
use serde::{Deserialize, Serialize};

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
