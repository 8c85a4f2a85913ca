//! The layers of the library: a module uses those of lower layers only, and no method uses another.

use crate::modules::File;
use std::collections::BTreeSet;

/// The modules of the library from the lowest layer up: a module uses those of lower layers only.
const LAYERS: [&[&str]; 9] = [
    &["clock", "progress"],
    &["error", "parallel"],
    &["math"],
    &["framebuffer", "output"],
    &["picture", "surface", "tone"],
    &["scene"],
    &["optics"],
    &["light", "metrics", "raster"],
    &["methods"],
];

/// A path of a module of the library that another one names.
struct Use {
    /// The naming module, such as `["scene", "view"]`.
    module: Vec<String>,
    path: Vec<String>,
    /// File and line.
    place: String,
}

/// The library's modules, of both its crates, and the paths that they name.
fn library() -> (Vec<Vec<String>>, Vec<Use>) {
    let (mut modules, mut uses) = (Vec::new(), Vec::new());
    let of_library = |file: &&File| {
        let is_inside = ["crates/catoptric/", "crates/catoptric_core/"].iter().any(|part| file.path.starts_with(part));
        is_inside && !file.module.is_empty()
    };
    for (of, file) in crate::CRATES.iter().flat_map(|of| of.files.iter().filter(of_library).map(move |file| (of, file)))
    {
        let module: Vec<String> = file.module.split("::").map(String::from).collect();
        for mention in &file.mentions {
            for mut path in of.absolute(mention) {
                if ["crate", "catoptric_core"].contains(&path.remove(0).as_str()) && !path.is_empty() {
                    let place = format!("{}:{}", file.path, mention.line);
                    uses.push(Use { module: module.clone(), path, place });
                }
            }
        }
        modules.push(module);
    }
    (modules, uses)
}

#[test]
fn modules_use_lower_layers_only() {
    let layer = |name: &String| LAYERS.iter().position(|layer| layer.contains(&name.as_str()));
    let (modules, uses) = library();
    assert!(modules.len() > 300, "{} modules", modules.len());
    let unknown: Vec<&Vec<String>> = modules.iter().filter(|module| layer(&module[0]).is_none()).collect();
    assert!(unknown.is_empty(), "modules without a layer: {unknown:?}");
    let is_wrong = |usage: &Use| {
        // Names at the root that are no modules are macros.
        let other = layer(&usage.path[0]);
        usage.path[0] != usage.module[0] && other.is_some_and(|other| Some(other) >= layer(&usage.module[0]))
    };
    let wrong: Vec<String> = uses.iter().filter(|usage| is_wrong(usage)).map(Use::describe).collect();
    assert!(wrong.is_empty(), "a module uses one of its own layer or a higher one:\n{}", wrong.join("\n"));
}

/// Methods, which have settings, use shared modules of their family and nothing of each other or of another family.
#[test]
fn methods_do_not_use_each_other() {
    let (modules, uses) = library();
    let methods: BTreeSet<String> = modules
        .iter()
        .filter(|module| module.len() > 2 && module[0] == "methods" && module.last().unwrap() == "settings")
        .map(|module| module[..module.len() - 1].join("/"))
        .collect();
    assert!(methods.len() >= 8, "{methods:?}");
    // The method that a path lies in, else its family, else all methods.
    let owner = |path: &[String]| {
        let method = (1..=path.len()).map(|length| path[..length].join("/")).find(|folder| methods.contains(folder));
        let family = || path.get(1).filter(|family| ["lookup", "projection"].contains(&family.as_str()));
        method.or_else(|| family().map(|family| format!("methods/{family}"))).unwrap_or_else(|| "methods".into())
    };
    let is_wrong = |usage: &Use| {
        let (own, other) = (owner(&usage.module), owner(&usage.path));
        let is_shared = own.starts_with(&format!("{other}/")) && !methods.contains(&other);
        let is_registry = usage.module == ["methods"] && usage.path.last().is_some_and(|name| name == "INFO");
        usage.module[0] == "methods"
            && usage.path[0] == "methods"
            && !is_registry
            && other != own
            && other != "methods"
            && !is_shared
    };
    let wrong: Vec<String> = uses.iter().filter(|usage| is_wrong(usage)).map(Use::describe).collect();
    assert!(wrong.is_empty(), "methods or families use each other:\n{}", wrong.join("\n"));
}

impl Use {
    fn describe(&self) -> String {
        format!("{} uses {}", self.place, self.path.join("::"))
    }
}
