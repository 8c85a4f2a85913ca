//! The layout of the sources: which module may use which, circles of modules, how large folders are and how long lines.

mod circles;
mod graph;
mod layers;
mod modules;
mod paths;
mod tokens;
mod toy_crates;

use crate::modules::Crate;
use std::collections::BTreeMap;
use std::path::{Path, PathBuf};
use std::sync::LazyLock;

const MAX_FILES: usize = 12;
const MAX_CODE_COLUMNS: usize = 120;
const MAX_PROSE_COLUMNS: usize = 100;

/// The repository's folder.
fn root() -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).join("../..").canonicalize().expect("the crate lies in the repository")
}

/// All files below a folder, relative to the repository; without hidden and built ones.
fn files_below(root: &Path, folder: &Path) -> Vec<PathBuf> {
    let mut found = Vec::new();
    for entry in std::fs::read_dir(root.join(folder)).expect("the folder can be read") {
        let entry = entry.expect("the folder can be read");
        let name = entry.file_name().into_string().expect("names are Unicode");
        let path = folder.join(&name);
        match entry.file_type().expect("the folder can be read").is_dir() {
            _ if name.starts_with('.') || name == "target" => {}
            true => found.extend(files_below(root, &path)),
            false => found.push(path),
        }
    }
    found.sort();
    found
}

/// The files with an extension below the given folders, with their text.
fn texts(folders: &[&str], extension: &str) -> Vec<(String, String)> {
    let root = root();
    let files = folders.iter().flat_map(|folder| files_below(&root, Path::new(folder)));
    let wanted = files.filter(|path| path.extension().is_some_and(|found| found == extension));
    wanted
        .map(|path| {
            let text = std::fs::read_to_string(root.join(&path)).expect("the file can be read");
            (path.to_str().expect("names are Unicode").replace('\\', "/"), text)
        })
        .collect()
}

/// The modules of all crates of the workspace.
static CRATES: LazyLock<Vec<Crate>> = LazyLock::new(|| {
    let root = root();
    let names = |folder: &str| {
        let entries = std::fs::read_dir(root.join(folder)).expect("the folder can be read");
        entries
            .map(|entry| entry.expect("the folder can be read").file_name().into_string().expect("names are Unicode"))
    };
    let crates = names("crates").map(|name| format!("crates/{name}/src"));
    let mut folders: Vec<String> = crates.chain(names(".").map(|name| format!("{name}/src"))).collect();
    folders.retain(|folder| root.join(folder).is_dir());
    folders.sort();
    folders.iter().map(|folder| Crate::read(&texts(&[folder], "rs"))).collect()
});

#[test]
fn folders_have_few_files() {
    let root = root();
    let mut counts = BTreeMap::<String, usize>::new();
    for folder in ["crates", "figures", "xtask", "fuzz"] {
        for path in files_below(&root, Path::new(folder)) {
            let parent = path.parent().and_then(Path::to_str).expect("names are Unicode").replace('\\', "/");
            *counts.entry(parent).or_default() += 1;
        }
    }
    let large: Vec<&String> = counts.iter().filter(|(_, count)| **count > MAX_FILES).map(|(path, _)| path).collect();
    assert!(large.is_empty(), "folders with more than {MAX_FILES} files: {large:?}");
}

#[test]
fn lines_of_code_are_short() {
    let mut long = Vec::new();
    for (path, text) in texts(&["crates", "figures", "xtask", "fuzz"], "rs") {
        for (number, line) in text.lines().enumerate() {
            if line.chars().count() > MAX_CODE_COLUMNS {
                long.push(format!("{path}:{}", number + 1));
            }
        }
    }
    assert!(long.is_empty(), "lines of over {MAX_CODE_COLUMNS} columns:\n{}", long.join("\n"));
}

/// Tables, code, and lines that one link or path alone makes long are as long as they must be.
#[test]
fn lines_of_prose_are_short() {
    let mut long = Vec::new();
    for (path, text) in texts(&["."], "md") {
        let mut in_code = false;
        for (number, line) in text.lines().enumerate() {
            in_code ^= line.trim_start().starts_with("```");
            let is_prose = !in_code && !line.trim_start().starts_with('|') && !line.starts_with("    ");
            let unbroken = line.split_whitespace().map(|word| word.chars().count()).max().unwrap_or_default();
            if is_prose && !line.contains("](") && line.chars().count() > MAX_PROSE_COLUMNS.max(unbroken + 4) {
                long.push(format!("{path}:{}", number + 1));
            }
        }
    }
    assert!(long.is_empty(), "lines of prose of over {MAX_PROSE_COLUMNS} columns:\n{}", long.join("\n"));
}

/// Libraries that are not compiled for tests of their own would leave out such tests without a word.
#[test]
fn tests_stand_where_they_are_run() {
    let mut left_out = Vec::new();
    let is_without = |manifest: &str| manifest.lines().any(|line| line.trim() == "test = false");
    let without = texts(&["crates"], "toml").into_iter().filter(|(_, manifest)| is_without(manifest));
    let folders: Vec<String> = without.filter_map(|(path, _)| Some(path.strip_suffix("Cargo.toml")?.into())).collect();
    assert!(folders.iter().any(|folder| folder == "crates/catoptric_engine/"), "{folders:?}");
    for folder in &folders {
        for (path, text) in texts(&[&format!("{folder}src")], "rs") {
            left_out.extend(["cfg(test)", "#[test]"].iter().any(|word| text.contains(word)).then_some(path));
        }
    }
    assert!(left_out.is_empty(), "tests of these are for the crate's tests/:\n{}", left_out.join("\n"));
}

/// Baked data has the same bits on every machine, therefore scenes and radiance take no function from the system's
/// library: those of `math::portable` are for them.
#[test]
fn elementary_functions_are_portable() {
    const OF_THE_SYSTEM: [&str; 21] = [
        "sin", "cos", "tan", "asin", "acos", "atan", "atan2", "sin_cos", "exp", "exp2", "exp_m1", "ln", "ln_1p", "log",
        "log2", "log10", "powf", "cbrt", "sinh", "cosh", "hypot",
    ];
    const OF_GLAM: [&str; 9] = [
        "from_rotation_x",
        "from_rotation_y",
        "from_rotation_z",
        "from_axis_angle",
        "from_euler",
        "from_angle",
        "slerp",
        "from_scaled_axis",
        "rotate_towards",
    ];
    // Numbers of several kinds have methods of these names, which call the portable ones; a measure bakes nothing.
    const ELSEWHERE: [&str; 6] = [
        "math/scalar",
        "math/interval",
        "math/jet",
        "surface/analytic/shapes/superquadric",
        "implicit/expression",
        "metrics/",
    ];
    let mut found = Vec::new();
    let crates = ["", "_core", "_engine", "_lookup", "_projection", "_scenes"];
    let folders = crates.map(|name| format!("crates/catoptric{name}/src"));
    let folders = folders.each_ref().map(String::as_str);
    for (path, text) in texts(&folders, "rs") {
        if ELSEWHERE.iter().any(|part| path.contains(part)) {
            continue;
        }
        for (number, line) in text.lines().enumerate() {
            let code = line.split("//").next().unwrap_or_default();
            let of_numbers = |name: &str| ["f32", "f64"].map(|number| format!("{number}::{name}"));
            let is_called = |name: &str| {
                let ends = |rest: &str| !rest.starts_with(|next: char| next.is_alphanumeric() || next == '_');
                code.contains(name)
                    && (code.contains(&format!(".{name}("))
                        || of_numbers(name).iter().any(|call| code.split(call.as_str()).skip(1).any(ends)))
            };
            let of_system = OF_THE_SYSTEM.into_iter().filter(|name| is_called(name));
            let of_glam =
                OF_GLAM.into_iter().filter(|name| code.contains(name) && code.contains(&format!("::{name}(")));
            found.extend(of_system.chain(of_glam).map(|name| format!("{path}:{}: {name}", number + 1)));
        }
    }
    assert!(found.is_empty(), "use math::portable in place of:\n{}", found.join("\n"));
}
