//! A new method: its folder with all roles, its lines in the registry, a test and a bench that fail until it draws.

use crate::command::root;
use anyhow::{Context, Result, bail, ensure};
use std::fs;
use std::path::{Path, PathBuf};

const REGISTRY: &str = "crates/catoptric/src/methods/mod.rs";
const BENCH: &str = "crates/catoptric/benches/methods.rs";

/// The words of the command line.
#[derive(Debug, PartialEq)]
struct Request {
    name: String,
    /// `lookup` or `projection`, and the role that is the method's heart.
    family: &'static str,
    role: &'static str,
    has_bake: bool,
    has_layout: bool,
}

impl Request {
    fn parse(words: &[&str]) -> Result<Self> {
        let (mut name, mut family, mut has_bake, mut has_layout) = (None, None, false, false);
        let mut words = words.iter();
        while let Some(word) = words.next() {
            match *word {
                "--family" => family = words.next(),
                "--bake" => has_bake = true,
                "--layout" => has_layout = true,
                word if name.is_none() && !word.starts_with('-') => name = Some(word.to_owned()),
                word => bail!("`{word}` is not understood"),
            }
        }
        let name = name.context("a NAME is missing")?;
        let is_snake = |name: &str| {
            let pieces = || name.split('_');
            pieces()
                .all(|piece| !piece.is_empty() && piece.chars().all(|c| c.is_ascii_lowercase() || c.is_ascii_digit()))
                && !name.starts_with(|first: char| first.is_ascii_digit())
        };
        ensure!(is_snake(&name), "`{name}` is no name of a folder: lower-case words joined by `_`");
        let (family, role) = match family.copied() {
            Some("lookup") => ("lookup", "lookup"),
            Some("projection") => ("projection", "project"),
            _ => bail!("`--family` must be lookup (rays fetch radiance) or projection (moved geometry is drawn)"),
        };
        Ok(Self { name, family, role, has_bake, has_layout })
    }

    /// The name as words, the first one with a capital.
    fn title(&self) -> String {
        let words = self.name.replace('_', " ");
        words[..1].to_uppercase() + &words[1..]
    }

    /// The name as that of a type.
    fn type_name(&self) -> String {
        self.name.split('_').map(|word| word[..1].to_uppercase() + &word[1..]).collect()
    }

    /// The files of the method's folder, with their templates.
    fn files(&self) -> Vec<(String, &'static str)> {
        let role = match self.role {
            "lookup" => include_str!("../templates/lookup.rs"),
            _ => include_str!("../templates/project.rs"),
        };
        let mut files = vec![
            ("README.md".into(), include_str!("../templates/README.md")),
            ("mod.rs".into(), include_str!("../templates/mod.rs")),
            ("limits.rs".into(), include_str!("../templates/limits.rs")),
            (format!("{}.rs", self.role), role),
            ("settings.rs".into(), include_str!("../templates/settings.rs")),
        ];
        files.extend(self.has_bake.then(|| ("bake.rs".into(), include_str!("../templates/bake.rs"))));
        files.extend(self.has_layout.then(|| ("layout.rs".into(), include_str!("../templates/layout.rs"))));
        files
    }

    fn fill(&self, template: &str) -> String {
        let mut modules = vec!["limits", self.role, "settings"];
        modules.extend(self.has_bake.then_some("bake"));
        modules.extend(self.has_layout.then_some("layout"));
        modules.sort_unstable();
        let modules = modules.iter().map(|name| format!("mod {name};\n")).collect::<String>();
        let (draw_use, draw) = match self.role {
            "lookup" => (
                "use catoptric_engine::method::lookup_shader::draw;",
                "        let mut report = draw(&job, tables, |_| true, target)?;",
            ),
            _ => (
                "use crate::draw::draw_paths;",
                "        let paths = tables.paths(scene, &self.view, quality.order);\n        \
                 let mut report = Report::default();\n        \
                 report.add_raster(&draw_paths(&job, paths, target)?);",
            ),
        };
        let layout_use = if self.has_layout { "pub use layout::{{type}}Texel;\n" } else { "" };
        let pairs = [
            ("{{modules}}\n", modules),
            ("{{draw_use}}", draw_use.into()),
            ("{{draw}}", draw.into()),
            ("{{role_use}}", format!("use {}::{{{{type}}}}Tables;", self.role)),
            ("{{layout_use}}", layout_use.into()),
            ("{{bake}}", if self.has_bake { "Some(bake::work)".into() } else { "None".to_owned() }),
            ("{{family_type}}", if self.role == "lookup" { "Lookup".into() } else { "Projection".to_owned() }),
            ("{{family}}", self.family.into()),
            ("{{role}}", self.role.into()),
            ("{{name}}", self.name.clone()),
            ("{{title}}", self.title()),
            ("{{type}}", self.type_name()),
        ];
        pairs.iter().fold(template.to_owned(), |text, (from, to)| text.replace(from, to))
    }

    /// Writes the files and the lines of the registry into a copy of the project; gives what is new or changed.
    fn write(&self, root: &Path) -> Result<Vec<PathBuf>> {
        let sources = root.join(sources(self.family));
        let folder = sources.join(&self.name);
        let tests = root.join(tests(self.family));
        let test = tests.join(format!("{}.rs", self.name));
        for new in [&folder, &test] {
            ensure!(!new.exists(), "{} exists", new.display());
        }
        // All changes are made before the first is written.
        let mut texts = vec![
            (root.join(REGISTRY), self.registered(&root.join(REGISTRY))?),
            {
                let path = sources.join("lib.rs");
                let text = with_module(&read(&path)?, "pub ", &self.name)?;
                (path, text)
            },
            {
                let text = read(&root.join(BENCH))?;
                let case = format!("    (\"sphere_room\", \"{}\", \"\"),", self.name);
                (root.join(BENCH), after_last(&text, "    (\"", &case)?)
            },
            {
                let path = tests.join("main.rs");
                let text = with_module(&read(&path)?, "", &self.name)?;
                (path, text)
            },
            (test, self.fill(include_str!("../templates/pictures.rs"))),
        ];
        texts.extend(self.files().into_iter().map(|(name, template)| (folder.join(name), self.fill(template))));
        fs::create_dir_all(&folder).with_context(|| format!("cannot make {}", folder.display()))?;
        for (path, text) in &texts {
            fs::write(path, text).with_context(|| format!("cannot write {}", path.display()))?;
        }
        Ok(texts.into_iter().map(|(path, _)| path).collect())
    }

    /// The registry with the method's line after the last of its family.
    fn registered(&self, path: &Path) -> Result<String> {
        let text = read(path)?;
        let has_name = |line: &str| {
            let entry = line.trim_start().strip_prefix('&').and_then(|line| line.strip_suffix("::INFO,"));
            entry.is_some_and(|path| path.rsplit("::").next() == Some(&self.name))
        };
        ensure!(!text.lines().any(has_name), "`{}` is a method already", self.name);
        let start = format!("        &{}::", self.family);
        after_last(&text, &start, &format!("{start}{}::INFO,", self.name))
    }
}

/// The folder of a family's methods.
fn sources(family: &str) -> String {
    format!("crates/catoptric_{family}/src")
}

/// The folder of the tests of a family's methods.
fn tests(family: &str) -> String {
    format!("crates/catoptric_{family}/tests/{family}")
}

fn read(path: &Path) -> Result<String> {
    fs::read_to_string(path).with_context(|| format!("cannot read {}", path.display()))
}

/// The text with a line after the last one that starts so.
fn after_last(text: &str, start: &str, line: &str) -> Result<String> {
    let mut lines: Vec<&str> = text.lines().collect();
    let last = lines.iter().rposition(|line| line.starts_with(start));
    lines.insert(last.with_context(|| format!("no line starts with `{start}`"))? + 1, line);
    Ok(lines.join("\n") + "\n")
}

/// The text with a module of that visibility among its modules, which are in alphabetical order.
fn with_module(text: &str, visibility: &str, name: &str) -> Result<String> {
    let module = |line: &str| Some(line.strip_suffix(';')?.split_once("mod ")?.1.to_owned());
    let mut lines: Vec<&str> = text.lines().collect();
    let last = lines.iter().rposition(|line| module(line).is_some()).context("there are no modules")?;
    let later = |line: &&str| module(line).is_some_and(|other| *other > *name);
    let line = format!("{visibility}mod {name};");
    lines.insert(lines.iter().position(later).unwrap_or(last + 1), &line);
    Ok(lines.join("\n") + "\n")
}

/// Makes the method that the words of the command line describe.
pub(crate) fn make(words: &[&str]) -> Result<()> {
    let request = Request::parse(words)?;
    for path in request.write(&root())? {
        println!("{}", path.strip_prefix(root()).unwrap_or(&path).display());
    }
    let Request { name, family, role, .. } = &request;
    println!(
        "\nIt draws reflectors black. Fill in {}/{name}/{role}.rs,\n\
         then the texts in mod.rs and README.md:\n  \
         cargo run --release -p catoptric_cli -- render builtin:sphere_room --method {name} -o {name}.png\n  \
         cargo test --release -p catoptric_{family} --test {family} {name}\n  \
         cargo test --release -p catoptric --test registry     prints the rows of limits.rs\n  \
         cargo bench -p catoptric --bench methods -- {name}",
        sources(family)
    );
    Ok(())
}

#[cfg(test)]
mod tests {
    use super::*;

    /// A folder with the files of the project that are changed.
    fn project() -> tempfile::TempDir {
        let folder = tempfile::tempdir().unwrap();
        copy(folder.path(), REGISTRY);
        copy(folder.path(), BENCH);
        for family in ["lookup", "projection"] {
            copy(folder.path(), &format!("{}/lib.rs", sources(family)));
            copy(folder.path(), &format!("{}/main.rs", tests(family)));
        }
        folder
    }

    fn copy(folder: &Path, name: &str) {
        fs::create_dir_all(folder.join(name).parent().unwrap()).unwrap();
        fs::copy(root().join(name), folder.join(name)).unwrap();
    }

    #[test]
    fn files_and_lines_of_the_registry_appear() {
        for (words, role, roles) in [
            (&["toy_map", "--family", "lookup"][..], "lookup.rs", 5),
            (&["toy_map", "--family", "projection", "--bake", "--layout"], "project.rs", 7),
        ] {
            let project = project();
            let request = Request::parse(words).unwrap();
            let changed = request.write(project.path()).unwrap();
            assert_eq!(changed.len(), roles + 5);
            for path in &changed {
                let text = fs::read_to_string(path).unwrap();
                assert!(!text.contains("{{") || path.ends_with("methods.rs"), "{}: {text}", path.display());
                assert!(
                    text.contains("toy_map")
                        || text.contains("ToyMap")
                        || text.contains("Toy map")
                        || path.ends_with("limits.rs")
                );
            }
            let read = |name: &str| fs::read_to_string(project.path().join(name)).unwrap();
            let family = request.family;
            assert!(project.path().join(format!("{}/toy_map/{role}", sources(family))).exists());
            assert_eq!(read(REGISTRY).matches(&format!("&{family}::toy_map::INFO,")).count(), 1);
            assert_eq!(read(&format!("{}/lib.rs", sources(family))).matches("pub mod toy_map;").count(), 1);
            assert!(read(BENCH).contains("\"toy_map\""));
            assert_eq!(read(&format!("{}/main.rs", tests(family))).matches("mod toy_map;").count(), 1);
            assert!(read(&format!("{}/toy_map.rs", tests(family))).contains(role));
            // Not over what is there.
            assert!(request.write(project.path()).unwrap_err().to_string().contains("exists"));
        }
    }

    #[test]
    fn other_words_are_refused() {
        for words in [&[][..], &["toy"], &["Toy", "--family", "lookup"], &["a__b", "--family", "lookup"]] {
            assert!(Request::parse(words).is_err(), "{words:?}");
        }
        assert!(Request::parse(&["toy", "--family", "reference"]).unwrap_err().to_string().contains("projection"));
        assert!(Request::parse(&["toy", "more", "--family", "lookup"]).is_err());
    }

    #[test]
    fn methods_that_there_are_stay_as_they_are() {
        for name in ["light_field", "reference"] {
            let request = Request::parse(&[name, "--family", "projection"]).unwrap();
            assert!(request.write(project().path()).unwrap_err().to_string().contains("already"), "{name}");
        }
        // A part of a name is another one.
        let request = Request::parse(&["field", "--family", "lookup"]).unwrap();
        assert!(request.write(project().path()).is_ok());
    }
}
