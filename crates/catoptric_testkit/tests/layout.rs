//! The layout of the sources: which module may use which, how large folders are and how long lines.

use std::collections::{BTreeMap, BTreeSet};
use std::path::{Path, PathBuf};

/// The modules of the library from the lowest layer up: a module uses those of lower layers only.
const LAYERS: [&[&str]; 9] = [
    &["clock", "progress"],
    &["error", "parallel"],
    &["math"],
    &["framebuffer", "output"],
    &["picture", "surface"],
    &["scene"],
    &["optics"],
    &["light", "metrics", "raster"],
    &["methods"],
];

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

/// The library's modules with their code: path below `src` (`scene/view`), text without comments and inline tests.
fn library() -> Vec<(Vec<String>, String)> {
    let mut modules = Vec::new();
    for (path, text) in texts(&["crates/catoptric/src", "crates/catoptric_core/src"], "rs") {
        let path = path.split_once("/src/").expect("it lies below src").1.trim_end_matches(".rs");
        let module: Vec<String> = path.trim_end_matches("/mod").split('/').map(String::from).collect();
        if path == "lib" || module.iter().any(|part| part == "tests") {
            continue;
        }
        let mut code = String::new();
        let mut in_tests = false;
        for line in text.lines() {
            in_tests = (in_tests && line != "}") || line == "mod tests {";
            if !in_tests {
                code += line.split("//").next().unwrap_or_default();
                code.push('\n');
            }
        }
        modules.push((module, code));
    }
    modules
}

/// Appends the paths of a `use` tree or expression, such as `a::{b, c::d}`, each behind `prefix`; returns the rest.
fn read_paths<'a>(mut code: &'a str, mut prefix: Vec<String>, found: &mut Vec<Vec<String>>) -> &'a str {
    loop {
        code = code.trim_start();
        if let Some(mut group) = code.strip_prefix('{') {
            loop {
                group = read_paths(group, prefix.clone(), found).trim_start();
                match group.strip_prefix(',') {
                    Some(rest) => group = rest,
                    None => return group.strip_prefix('}').unwrap_or(group),
                }
            }
        }
        let end = code.find(|c: char| !c.is_alphanumeric() && c != '_').unwrap_or(code.len());
        match &code[..end] {
            "" | "self" => {}
            "super" => drop(prefix.pop()),
            name => prefix.push(name.into()),
        }
        code = &code[end..];
        match code.strip_prefix("::") {
            Some(rest) if end > 0 => code = rest,
            _ => break,
        }
    }
    found.push(prefix);
    // A new name, as in `Scene as Model`.
    let end = code.find(['\n', ',', '}', ';']).unwrap_or(code.len());
    if code.trim_start().starts_with("as ") { &code[end..] } else { code }
}

/// The library's modules that a module's code names from the root of a crate or from the module above.
fn used(module: &[String], code: &str) -> Vec<Vec<String>> {
    let mut found = Vec::new();
    let starts = [("crate::", &[][..]), ("catoptric_core::", &[][..]), ("super::", &module[..module.len() - 1])];
    for (start, prefix) in starts {
        for (position, _) in code.match_indices(start) {
            let before = code[..position].chars().next_back();
            // Not within a name, nor a second `super`.
            if !before.is_some_and(|c| c.is_alphanumeric() || c == '_' || c == ':') {
                read_paths(&code[position + start.len()..], prefix.to_vec(), &mut found);
            }
        }
    }
    found
}

#[test]
fn modules_use_lower_layers_only() {
    let layer = |name: &String| LAYERS.iter().position(|layer| layer.contains(&name.as_str()));
    let mut wrong = Vec::new();
    for (module, code) in library() {
        let own = layer(&module[0]).unwrap_or_else(|| panic!("{} has a layer", module[0]));
        for path in used(&module, &code) {
            // Names at the root that are no modules are macros.
            let Some(other) = path.first().and_then(layer) else { continue };
            if path[0] != module[0] && other >= own {
                wrong.push(format!("{} uses {}", module.join("/"), path.join("::")));
            }
        }
    }
    assert!(wrong.is_empty(), "a module uses one of its own layer or a higher one:\n{}", wrong.join("\n"));
}

/// Methods, which have settings, use shared modules of their family and nothing of each other or of another family.
#[test]
fn methods_do_not_use_each_other() {
    let library = library();
    let folder = |module: &[String]| module.join("/");
    let methods: BTreeSet<String> = library
        .iter()
        .filter(|(module, _)| module.len() > 2 && module[0] == "methods" && module.last().unwrap() == "settings")
        .map(|(module, _)| folder(&module[..module.len() - 1]))
        .collect();
    assert!(methods.len() >= 8, "{methods:?}");
    // The method that a path lies in, else its family, else all methods.
    let owner = |path: &[String]| {
        let method = (1..=path.len()).map(|length| folder(&path[..length])).find(|folder| methods.contains(folder));
        let family = || path.get(1).filter(|family| ["lookup", "projection"].contains(&family.as_str()));
        method.or_else(|| family().map(|family| format!("methods/{family}"))).unwrap_or_else(|| "methods".into())
    };
    let mut wrong = Vec::new();
    for (module, code) in library.iter().filter(|(module, _)| module[0] == "methods") {
        let own = owner(module);
        for path in used(module, code).into_iter().filter(|path| path[0] == "methods") {
            let other = owner(&path);
            if other == own
                || other == "methods"
                || (own.starts_with(&format!("{other}/")) && !methods.contains(&other))
            {
                continue;
            }
            wrong.push(format!("{} uses {}", folder(module), path.join("::")));
        }
    }
    assert!(wrong.is_empty(), "methods or families use each other:\n{}", wrong.join("\n"));
}

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

/// What is baked has the same bits on every machine, so scenes and radiance take no function from the system's
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
        "surface/analytic/superquadric",
        "implicit/expression",
        "metrics/",
    ];
    let mut found = Vec::new();
    let folders = ["crates/catoptric/src", "crates/catoptric_core/src", "crates/catoptric_scenes/src"];
    for (path, text) in texts(&folders, "rs") {
        let is_test = path.contains("/tests/") || path.ends_with("/tests.rs");
        if is_test || ELSEWHERE.iter().any(|part| path.contains(part)) {
            continue;
        }
        let code = text.split("#[cfg(test)]\nmod tests {").next().unwrap_or_default();
        for (number, line) in code.lines().enumerate() {
            let code = line.split("//").next().unwrap_or_default();
            let of_numbers = |name: &str| ["f32", "f64"].map(|number| format!("{number}::{name}"));
            let is_called = |name: &str| {
                let ends = |rest: &str| !rest.starts_with(|next: char| next.is_alphanumeric() || next == '_');
                code.contains(&format!(".{name}("))
                    || of_numbers(name).iter().any(|call| code.split(call.as_str()).skip(1).any(ends))
            };
            let of_system = OF_THE_SYSTEM.into_iter().filter(|name| is_called(name));
            let of_glam = OF_GLAM.into_iter().filter(|name| code.contains(&format!("::{name}(")));
            found.extend(of_system.chain(of_glam).map(|name| format!("{path}:{}: {name}", number + 1)));
        }
    }
    assert!(found.is_empty(), "use math::portable in place of:\n{}", found.join("\n"));
}
