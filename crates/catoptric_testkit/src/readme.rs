//! The tables of settings in the methods' READMEs, made from the settings' declarations.

use catoptric::methods::{Family, MethodInfo, SettingInfo, all};
use std::io;
use std::path::{Path, PathBuf};

/// The marks around a table; what is between them is generated.
const BEGIN: &str = "<!-- settings: generated -->";
const END: &str = "<!-- end of settings -->";

/// A method's README.
#[derive(Clone, Debug)]
pub struct Readme {
    /// The README's place.
    pub path: PathBuf,
    /// The README's text.
    pub text: String,
    /// The text with a current table.
    pub current: String,
}

/// The READMEs of all methods.
///
/// # Errors
/// The errors of reading the files; a file without the marks is invalid data.
pub fn readmes() -> io::Result<Vec<Readme>> {
    all().iter().map(|info| readme(info)).collect()
}

fn readme(info: &MethodInfo) -> io::Result<Readme> {
    let sources = match info.family {
        Family::Reference => "catoptric/src/methods",
        Family::Projection => "catoptric_projection/src",
        Family::Lookup => "catoptric_lookup/src",
    };
    let path = Path::new(env!("CARGO_MANIFEST_DIR")).join("..").join(sources).join(info.id).join("README.md");
    let fail = |problem: &str| io::Error::new(io::ErrorKind::InvalidData, format!("{}: {problem}", path.display()));
    let text = std::fs::read_to_string(&path).map_err(|error| fail(&error.to_string()))?;
    let parts = text.split_once(BEGIN).and_then(|(before, rest)| Some((before, rest.split_once(END)?.1)));
    let (before, after) = parts.ok_or_else(|| fail(&format!("the lines `{BEGIN}` and `{END}` are missing")))?;
    let current = format!("{before}{BEGIN}\n{}{END}{after}", table(&(info.settings)()));
    Ok(Readme { path, text, current })
}

/// A Markdown table of settings.
fn table(settings: &[SettingInfo]) -> String {
    let mut text = String::from("| setting | default | values | |\n|---|---|---|---|\n");
    for setting in settings {
        let values = match setting.choices {
            [] => setting.values(),
            choices => choices.iter().map(|choice| format!("`{}`", choice.name)).collect::<Vec<_>>().join(", "),
        };
        let mut help = setting.help.to_owned();
        for choice in setting.choices {
            help += &format!("<br>`{}`: {}", choice.name, choice.help);
        }
        text += &format!("| `{}` | `{}` | {values} | {} |\n", setting.name, setting.default, help.replace('|', "\\|"));
    }
    text
}
