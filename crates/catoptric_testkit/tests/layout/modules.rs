//! The modules of a crate, and the files that their paths lead to.

use crate::paths::{Kind, Mention, Source, child};
use std::collections::{BTreeMap, HashMap, HashSet};

/// Re-exports of re-exports that are followed.
const MAX_STEPS: usize = 8;

/// A crate's library, or its program if it has none.
pub(crate) struct Crate {
    /// Without those of tests.
    pub(crate) files: Vec<File>,
    /// The numbers of the files that modules lie in.
    modules: HashMap<String, usize>,
    /// The paths that modules' names stand for, by their `use` lines.
    names: HashMap<(String, String), Vec<Name>>,
}

pub(crate) struct File {
    /// The path in the repository.
    pub(crate) path: String,
    pub(crate) module: String,
    pub(crate) mentions: Vec<Mention>,
}

struct Name {
    path: Vec<String>,
    /// The name is imported within a function of the module.
    is_local: bool,
}

/// The numbers of two files, of which the first imports something of the other, with the first line that does so.
pub(crate) type Arrows = BTreeMap<(usize, usize), usize>;

impl Crate {
    /// Reads files: their paths, such as `crates/toy/src/scene/view.rs`, and texts.
    pub(crate) fn read(texts: &[(String, String)]) -> Self {
        let has_library = texts.iter().any(|(path, _)| path.ends_with("/src/lib.rs"));
        let mut files = Vec::new();
        let (mut inner, mut tests) = (Vec::new(), HashSet::new());
        for (path, text) in texts.iter().filter(|(path, _)| !(has_library && path.ends_with("/src/main.rs"))) {
            let module = module_of(path);
            let source = Source::read(&module, text);
            inner.extend(source.inner.into_iter().map(|module| (module, path)));
            tests.extend(source.tests);
            files.push(File { path: path.clone(), module, mentions: source.mentions });
        }
        files.retain(|file| {
            let mut modules = ancestors(&file.module).chain([file.module.as_str()]);
            !modules.any(|module| tests.contains(module) || module.rsplit("::").next() == Some("tests"))
        });
        let mut modules: HashMap<String, usize> =
            files.iter().enumerate().map(|(number, file)| (file.module.clone(), number)).collect();
        for (module, path) in inner {
            if let Some(number) = files.iter().position(|file| file.path == *path) {
                modules.insert(module, number);
            }
        }
        let mut names = HashMap::<_, Vec<Name>>::new();
        for mention in files.iter().flat_map(|file| &file.mentions) {
            let (name, is_local) = match &mention.kind {
                Kind::Import { name, .. } => (name, false),
                Kind::LocalImport { name } => (name, true),
                Kind::Inline => continue,
            };
            // The name of a macro that the module defines.
            if mention.path.len() > 1 || mention.path.first() != Some(name) {
                let path = mention.path.clone();
                names.entry((mention.module.clone(), name.clone())).or_default().push(Name { path, is_local });
            }
        }
        Self { files, modules, names }
    }

    /// A mention's path from the root of its crate: behind `crate`, or the name of another crate. Several, if a name
    /// stands for several things.
    pub(crate) fn absolute(&self, mention: &Mention) -> Vec<Vec<String>> {
        let own = match &mention.kind {
            Kind::Import { name, .. } | Kind::LocalImport { name } => Some(name.as_str()),
            Kind::Inline => None,
        };
        let mut found = Vec::new();
        self.find_absolute(&mention.module, &mention.path, own, MAX_STEPS, &mut found);
        found
    }

    /// Appends the paths from a crate's root; `own` is the name that the path itself gives its module.
    fn find_absolute(
        &self,
        module: &str,
        path: &[String],
        own: Option<&str>,
        steps: usize,
        found: &mut Vec<Vec<String>>,
    ) {
        let Some((first, rest)) = path.split_first() else { return };
        let at_root = |module: &str, rest: &[String]| {
            let parts = module.split("::").filter(|part| !part.is_empty()).map(String::from);
            ["crate".to_owned()].into_iter().chain(parts).chain(rest.iter().cloned()).collect()
        };
        match first.as_str() {
            "crate" => found.push(path.to_vec()),
            "self" => found.push(at_root(module, rest)),
            "super" => {
                let above = parent(module).unwrap_or_default();
                if rest.first().is_some_and(|next| next == "super") {
                    self.find_absolute(above, rest, own, steps, found);
                } else {
                    found.push(at_root(above, rest));
                }
            }
            _ if self.modules.contains_key(&child(module, first)) => found.push(at_root(module, path)),
            name => {
                let names = self.names.get(&(module.to_owned(), name.to_owned())).filter(|_| own != Some(name));
                match names {
                    Some(names) if steps > 0 => {
                        for target in names {
                            let whole: Vec<String> = target.path.iter().chain(rest).cloned().collect();
                            self.find_absolute(module, &whole, Some(name), steps - 1, found);
                        }
                    }
                    _ => found.push(path.to_vec()),
                }
            }
        }
    }

    /// Appends the files that define what a path from the crate's root names. The name of a module alone leads to no
    /// file: what is named through it does.
    fn find_files(&self, path: &[String], steps: usize, found: &mut Vec<usize>) {
        let Some((_, parts)) = path.split_first().filter(|(first, _)| *first == "crate") else { return };
        let mut module = String::new();
        for (index, part) in parts.iter().enumerate() {
            let rest = &parts[index + 1..];
            let inner = child(&module, part);
            let is_module = self.modules.contains_key(&inner);
            let names = self.names.get(&(module.clone(), part.clone())).filter(|_| !is_module || rest.is_empty());
            let targets = || names.into_iter().flatten().filter(|target| !target.is_local);
            if steps > 0 && targets().next().is_some() {
                for target in targets() {
                    let mut whole = Vec::new();
                    self.find_absolute(&module, &target.path, Some(part), steps, &mut whole);
                    for mut target in whole {
                        target.extend_from_slice(rest);
                        self.find_files(&target, steps - 1, found);
                    }
                }
                return;
            }
            if !is_module {
                found.extend(self.modules.get(&module));
                return;
            }
            module = inner;
        }
    }

    /// The path of a module's folder, which ends with a slash, or of its file if it has no folder.
    pub(crate) fn place(&self, module: &str) -> String {
        let file = &self.files[self.modules[module]];
        let source = file.path.rfind("/src/").map_or("", |end| &file.path[..end + "/src/".len()]);
        let begin = child(module, "");
        match self.files.iter().any(|file| file.module.starts_with(&begin)) {
            true => format!("{source}{}", begin.replace("::", "/")),
            false => file.path.clone(),
        }
    }

    pub(crate) fn arrows(&self) -> Arrows {
        let mut arrows = Arrows::new();
        for (number, file) in self.files.iter().enumerate() {
            for mention in file.mentions.iter().filter(|mention| !mention.is_re_export()) {
                let mut found = Vec::new();
                for path in self.absolute(mention) {
                    self.find_files(&path, MAX_STEPS, &mut found);
                }
                for other in found.into_iter().filter(|other| *other != number) {
                    let line = arrows.entry((number, other)).or_insert(mention.line);
                    *line = mention.line.min(*line);
                }
            }
        }
        arrows
    }
}

/// The module of a file's path below `src`: `scene::view` of `scene/view.rs`, `scene` of `scene/mod.rs`.
fn module_of(path: &str) -> String {
    let path = path.rsplit_once("/src/").map_or(path, |(_, below)| below).trim_end_matches(".rs");
    match path.strip_suffix("mod").and_then(|folder| folder.strip_suffix('/')) {
        Some(folder) => folder.replace('/', "::"),
        None if ["lib", "main"].contains(&path) => String::new(),
        None => path.replace('/', "::"),
    }
}

/// The module above; `None` for the root.
pub(crate) fn parent(module: &str) -> Option<&str> {
    (!module.is_empty()).then(|| module.rsplit_once("::").map_or("", |(above, _)| above))
}

/// The modules above, from the nearest up to the root.
pub(crate) fn ancestors(module: &str) -> impl Iterator<Item = &str> {
    std::iter::successors(parent(module), |module| parent(module))
}
