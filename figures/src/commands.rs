//! The program's command lines that figures are made with: run, and written below the figures in the documents.

use crate::{cameras, layered, light_field, perturbation, root, virtual_objects};
use anyhow::{Context, Result, bail};
use std::path::PathBuf;
use std::process::Command;

/// The marks around a figure's lines in a page; what is between them is generated.
const BEGIN: &str = "<!-- commands: ";
const END: &str = "<!-- end of commands -->\n";

/// Settings with which projection methods draw all paths themselves, however long that takes.
pub(crate) const ALONE: [&str; 2] = ["work=150", "beyond_work=coarse"];

/// Columns of a page.
const COLUMNS: usize = 100;

/// A command line of the program: the words behind its name.
#[derive(Clone, Debug, PartialEq)]
pub(crate) struct Line(pub(crate) Vec<String>);

/// How a scene is drawn.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Shot<'a> {
    /// The scene, as the program takes it.
    pub(crate) scene: &'a str,
    pub(crate) size: [u32; 2],
    pub(crate) samples: u32,
    pub(crate) order: u32,
}

/// A figure of a page with the lines that make its panels or rows.
pub(crate) struct Figure {
    pub(crate) page: &'static str,
    pub(crate) name: String,
    pub(crate) lines: Vec<Line>,
}

impl Shot<'_> {
    /// The line that draws it by a method with these settings (`name=value`).
    pub(crate) fn drawn(&self, method: &str, settings: &[&str]) -> Line {
        let Self { scene, size: [width, height], samples, order } = self;
        let mut line = Line::of(&["render", scene]);
        line.add(&["--size", &format!("{width}x{height}"), "--samples", &samples.to_string()]);
        line.add(&["--order", &order.to_string(), "--method", method]);
        settings.iter().for_each(|setting| line.add(&["--set", setting]));
        line
    }
}

impl Line {
    pub(crate) fn of(words: &[&str]) -> Self {
        Self(words.iter().map(|word| (*word).into()).collect())
    }

    /// Adds words.
    pub(crate) fn add(&mut self, words: &[&str]) {
        self.0.extend(words.iter().map(|word| (*word).to_owned()));
    }

    /// The command that runs it.
    pub(crate) fn command(&self) -> Command {
        let words: Vec<&str> = self.0.iter().map(String::as_str).collect();
        crate::program::catoptric(&words)
    }

    /// The line as it is typed, broken where a page ends.
    fn text(&self) -> String {
        let (mut text, mut column) = (String::from("catoptric"), "catoptric".len());
        for word in &self.0 {
            let is_plain = |letter: char| letter.is_ascii_alphanumeric() || "-_=.,:/+".contains(letter);
            let word = if word.chars().all(is_plain) { word.clone() } else { format!("'{word}'") };
            // Two columns are left for the backslash.
            if column + 1 + word.len() > COLUMNS - 2 {
                text += " \\\n   ";
                column = 3;
            }
            column += 1 + word.len();
            text += " ";
            text += &word;
        }
        text
    }
}

/// Lines of TOML as the program's settings.
pub(crate) fn settings_of(toml: &str) -> Vec<String> {
    let lines = toml.lines().filter(|line| !line.trim().is_empty());
    lines.map(|line| line.replacen(" = ", "=", 1).replace(['\'', '"'], "")).collect()
}

/// All figures whose lines are written into pages.
pub(crate) fn all() -> Result<Vec<Figure>> {
    let mut all = perturbation::commands();
    all.extend(virtual_objects::commands());
    all.extend(light_field::commands());
    all.extend(cameras::commands());
    all.extend(layered::commands()?);
    Ok(all)
}

/// A page with the current lines of its figures.
struct Page {
    path: PathBuf,
    text: String,
    current: String,
}

/// The pages that have figures with lines.
fn pages() -> Result<Vec<Page>> {
    let mut pages: Vec<Page> = Vec::new();
    for figure in all()? {
        let path = root().join("docs").join(figure.page);
        let index = match pages.iter().position(|page| page.path == path) {
            Some(index) => index,
            None => {
                let text = std::fs::read_to_string(&path).with_context(|| path.display().to_string())?;
                pages.push(Page { path, current: text.clone(), text });
                pages.len() - 1
            }
        };
        let current = &mut pages[index].current;
        let mark = format!("{BEGIN}{} -->\n", figure.name);
        let parts = current.split_once(&mark).and_then(|(before, rest)| Some((before, rest.split_once(END)?.1)));
        let Some((before, after)) = parts else {
            bail!("{}: the lines `{}` and `{}` are missing", figure.page, mark.trim_end(), END.trim_end())
        };
        let lines: Vec<String> = figure.lines.iter().map(Line::text).collect();
        *current = format!("{before}{mark}```sh\n{}\n```\n{END}{after}", lines.join("\n"));
    }
    Ok(pages)
}

/// Writes the lines of all figures into their pages.
pub(crate) fn write() -> Result<()> {
    for page in pages()?.into_iter().filter(|page| page.text != page.current) {
        std::fs::write(&page.path, page.current).with_context(|| format!("cannot write {}", page.path.display()))?;
    }
    Ok(())
}

#[cfg(test)]
mod tests {
    use super::*;
    use catoptric::methods::{Quality, Report, setting_value};
    use catoptric_testkit::Session;
    use catoptric_testkit::drawing::scene;

    #[test]
    fn pages_have_the_lines_that_their_figures_are_made_with() {
        for page in pages().expect("all pages have their marks") {
            assert!(page.text == page.current, "{}: run `cargo figures commands`", page.path.display());
        }
    }

    /// Lines of a page by their words, the broken ones joined.
    fn lines_of(page: &str) -> Vec<Vec<String>> {
        let text = std::fs::read_to_string(root().join("docs").join(page)).expect("the page is there");
        let text = text.replace("\\\n", " ");
        let lines = text.lines().filter(|line| line.starts_with("catoptric render"));
        lines.map(|line| line.split_whitespace().skip(1).map(|word| word.replace('\'', "")).collect()).collect()
    }

    /// The value of an option of a line.
    fn option<'a>(line: &'a [String], name: &str) -> Option<&'a str> {
        Some(line.get(line.iter().position(|word| word == name)? + 1)?)
    }

    /// The report of a small picture that is drawn as a printed line says.
    fn drawn(line: &[String]) -> Report {
        let scene = scene(line[1].strip_prefix("builtin:").expect("a built-in scene"));
        let method = option(line, "--method").expect("a method");
        let order = option(line, "--order").and_then(|order| order.parse().ok()).expect("an order");
        let settings = line.windows(2).filter(|words| words[0] == "--set").map(|words| {
            let (name, given) = words[1].split_once('=').expect("name=value");
            format!("{name} = {}", setting_value(given))
        });
        let settings = settings.collect::<Vec<_>>().join("\n");
        let mut session = Session::new(method, &settings, &scene, Quality { samples: 1, order }).expect("valid");
        session.draw(&scene.default_view(96, 72)).expect("valid").report
    }

    /// What the pages print is enough to have the methods draw for themselves.
    #[test]
    fn printed_lines_are_drawn_by_the_method_itself() {
        for (page, method) in [
            ("figures-path-perturbation.md", "path_perturbation"),
            ("figures-virtual-objects.md", "reflector_search"),
            ("figures-sample-based-camera.md", "sample_based_camera"),
        ] {
            let lines = lines_of(page);
            let line =
                lines.iter().find(|line| option(line, "--method") == Some(method)).expect("a line of the method");
            let report = drawn(line);
            assert!(!report.counts.contains_key("tiles") && report.counts["paths"] > 0, "{line:?}: {report:?}");
        }
    }
}
