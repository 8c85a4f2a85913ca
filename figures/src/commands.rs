//! The program's command lines that figures are made with: run, and written below the figures in the documents.

use anyhow::{Context, Result, bail};
use std::path::{Path, PathBuf};

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

/// A page with the current lines of its figures.
pub(crate) struct Page {
    pub(crate) path: PathBuf,
    pub(crate) text: String,
    pub(crate) current: String,
}

/// The pages of a folder that have these figures.
pub(crate) fn pages(folder: &Path, figures: &[Figure]) -> Result<Vec<Page>> {
    let mut pages: Vec<Page> = Vec::new();
    for figure in figures {
        let path = folder.join(figure.page);
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

/// Writes the lines of figures into their pages.
pub(crate) fn write(folder: &Path, figures: &[Figure]) -> Result<()> {
    for page in pages(folder, figures)?.into_iter().filter(|page| page.text != page.current) {
        std::fs::write(&page.path, page.current).with_context(|| format!("cannot write {}", page.path.display()))?;
    }
    Ok(())
}
