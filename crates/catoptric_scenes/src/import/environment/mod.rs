//! Light from infinity from pictures: `.hdr` (Radiance), `.exr` (OpenEXR), and 8-bit ones.

mod canvas;
mod colors;
mod cube;
mod exr;
mod exr_header;
mod hdr;
mod screen;
mod unfolded;

use super::files::{self, MAX_SCENE_BYTES};
use crate::studio::{ENVIRONMENT_NAMES, named_environment};
use catoptric_core::error::SceneError;
use catoptric_core::scene::{Environment, Model};
use std::path::Path;
use std::sync::Arc;

/// The extensions of pictures of environments.
const EXTENSIONS: [&str; 7] = ["hdr", "pic", "exr", "png", "jpg", "jpeg", "webp"];

/// One of [`ENVIRONMENT_NAMES`], or an equirectangular picture in linear radiance: Radiance `.hdr`, OpenEXR (also as a
/// cube map), or an 8-bit PNG, JPEG or WebP. The file's content decides, not its name.
///
/// Pictures of more than 8192 x 4096 pixels are read at half their size, a quarter and so on, averaged in linear
/// light. What is not as the file says is added to `warnings`, in sentences that begin with the file's name.
///
/// # Errors
/// [`SceneError`] when the file cannot be read, is broken, is of another kind or wider or higher than 32768 pixels.
pub fn load_environment(path: &Path, warnings: &mut Vec<String>) -> Result<Environment, SceneError> {
    let name = path.display().to_string();
    if let Some(environment) = named_environment(&name) {
        return Ok(environment);
    }
    let bytes = files::read(path, MAX_SCENE_BYTES).map_err(|error| match error {
        SceneError::Read { source, .. } if source.kind() == std::io::ErrorKind::NotFound => {
            let names = ENVIRONMENT_NAMES.join(", ");
            let problem = format!("there is no such file; give a picture ({}), or one of: {names}", extensions());
            SceneError::invalid(&name, "environment", problem)
        }
        other => other,
    })?;
    environment_from(&name, &bytes, warnings)
}

/// The same from memory; `name` is for messages.
pub(super) fn environment_from(
    name: &str,
    bytes: &[u8],
    warnings: &mut Vec<String>,
) -> Result<Environment, SceneError> {
    let read = match bytes {
        [0x76, 0x2f, 0x31, 0x01, ..] => exr::read,
        [b'#', b'?', ..] => hdr::read,
        _ if screen::is_picture(bytes) => screen::read,
        _ => return Err(SceneError::invalid(name, "picture", unknown(name))),
    };
    let mut found = Vec::new();
    let picture = read(bytes, &mut found).and_then(|picture| unfolded::unfolded(picture, &mut found));
    let picture = picture.map_err(|problem| SceneError::invalid(name, "picture", problem))?;
    warnings.extend(found.into_iter().map(|problem| format!("{name}: {problem}")));
    Ok(Environment::new(files::file_name(name), picture.width, picture.height, picture.radiance))
}

/// How an environment is turned and scaled.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct EnvironmentEdit {
    /// Degrees about the scene's vertical axis y, counter-clockwise seen from above.
    pub rotation_deg: Option<f64>,
    /// A factor for all its light, 0 or more.
    pub strength: Option<f64>,
}

impl EnvironmentEdit {
    /// Larger angles, to either side, are taken for slips.
    pub const MOST_ROTATION_DEG: f64 = 1e6;
    /// Larger factors are taken for slips.
    pub const MOST_STRENGTH: f64 = 1e6;

    /// Turns and scales a model's environment; false if it has none and something is wanted.
    #[must_use]
    pub fn apply(&self, model: &mut Model) -> bool {
        if *self == Self::default() {
            return true;
        }
        let Some(environment) = model.environment.take() else { return false };
        let mut environment = Arc::unwrap_or_clone(environment);
        if let Some(degrees) = self.rotation_deg {
            environment = environment.turned(degrees.to_radians());
        }
        if let Some(factor) = self.strength {
            environment = environment.scaled(factor as f32);
        }
        model.environment = Some(Arc::new(environment));
        true
    }

    /// The key in scene files of what is wanted.
    pub(super) fn key(&self) -> &'static str {
        if self.rotation_deg.is_some() { "environment_rotation_deg" } else { "environment_strength" }
    }
}

/// The extensions as messages tell them.
pub(super) fn extensions() -> String {
    EXTENSIONS.map(|extension| format!(".{extension}")).join(", ")
}

/// True for names that pictures of environments have.
pub(super) fn is_name(name: &str) -> bool {
    EXTENSIONS.contains(&files::extension(Path::new(name)).as_str())
}

/// The message about content that is none of a picture's.
fn unknown(name: &str) -> String {
    let kinds = "save it as Radiance (.hdr) or OpenEXR (.exr), or as an 8-bit .png, .jpg or .webp";
    match files::extension(Path::new(name)).as_str() {
        "hdr" | "pic" => format!("does not begin with `#?RADIANCE` or `#?RGBE`: it is no Radiance picture; {kinds}"),
        "exr" => format!("does not begin as OpenEXR pictures do; {kinds}"),
        _ => format!("is no kind of picture that environments are read from; {kinds}"),
    }
}
