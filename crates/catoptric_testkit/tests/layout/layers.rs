//! The layers of the library: a module uses those of lower layers only, and no method uses another.

use crate::modules::File;
use std::collections::BTreeSet;

/// The modules of `catoptric_core` and `catoptric_engine` from the lowest layer up: a module uses those of lower layers
/// only. Cargo itself holds the order of crates.
const LAYERS: [&[&str]; 9] = [
    &["clock", "progress"],
    &["error", "parallel"],
    &["math"],
    &["exr_blocks", "framebuffer", "input", "output"],
    &["picture", "surface", "tone"],
    &["scene"],
    &["optics"],
    &["light", "metrics", "raster"],
    &["method"],
];

/// A path of a module of a crate that another module names.
struct Use {
    /// The naming module, such as `["scene", "view"]`.
    module: Vec<String>,
    path: Vec<String>,
    /// File and line.
    place: String,
}

/// The modules of these crates, and the paths in these crates that they name.
fn modules_of(crates: &[&str]) -> (Vec<Vec<String>>, Vec<Use>) {
    let (mut modules, mut uses) = (Vec::new(), Vec::new());
    let is_inside = |file: &&File| {
        let of_crate = |name: &&str| file.path.starts_with(&format!("crates/{name}/"));
        crates.iter().any(of_crate) && !file.module.is_empty()
    };
    for (of, file) in crate::CRATES.iter().flat_map(|of| of.files.iter().filter(is_inside).map(move |file| (of, file)))
    {
        let module: Vec<String> = file.module.split("::").map(String::from).collect();
        for mention in &file.mentions {
            for mut path in of.absolute(mention) {
                let root = path.remove(0);
                if (root == "crate" || crates.contains(&root.as_str())) && !path.is_empty() {
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
    let (modules, uses) = modules_of(&["catoptric_core", "catoptric_engine"]);
    assert!(modules.len() > 150, "{} modules", modules.len());
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

/// Methods, which have settings, use shared modules of their family and nothing of each other; what a family shares
/// uses no method.
#[test]
fn methods_do_not_use_each_other() {
    for family in ["catoptric_projection", "catoptric_lookup"] {
        let (modules, uses) = modules_of(&[family]);
        let methods: BTreeSet<&String> = modules
            .iter()
            .filter(|module| module.len() == 2 && module[1] == "settings")
            .map(|module| &module[0])
            .collect();
        assert!(methods.len() >= 3, "{methods:?}");
        let is_wrong = |usage: &Use| methods.contains(&usage.path[0]) && usage.path[0] != usage.module[0];
        let wrong: Vec<String> = uses.iter().filter(|usage| is_wrong(usage)).map(Use::describe).collect();
        assert!(wrong.is_empty(), "methods use each other:\n{}", wrong.join("\n"));
    }
}

impl Use {
    fn describe(&self) -> String {
        format!("{} uses {}", self.place, self.path.join("::"))
    }
}
