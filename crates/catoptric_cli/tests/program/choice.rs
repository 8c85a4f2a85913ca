//! Choices among the parts of a scene file: its variants and animations.

use crate::workplace::Workplace;
use serde_json::{Value, json};

/// Numbers and where they lie in `data.bin`: a triangle, two times, and the ways of two animations.
const NUMBERS: [f32; 23] = [
    0.0, 0.0, 0.0, 1.0, 0.0, 0.0, 0.0, 1.0, 0.0, // the triangle
    0.0, 2.0, // times
    0.0, 0.0, 0.0, 4.0, 0.0, 0.0, // along x
    0.0, 0.0, 0.0, 0.0, 6.0, 0.0, // along y
];

/// A triangle with two variants, and two animations that move it in two seconds.
fn place() -> Workplace {
    let place = Workplace::new();
    let bytes: Vec<u8> = NUMBERS.iter().flat_map(|number| number.to_le_bytes()).collect();
    place.write("data.bin", &bytes);
    let views = [(0, 36), (36, 8), (44, 24), (68, 24)]
        .map(|(offset, length)| json!({ "buffer": 0, "byteOffset": offset, "byteLength": length }));
    let accessors: Vec<Value> = [(0, "VEC3", 3), (1, "SCALAR", 2), (2, "VEC3", 2), (3, "VEC3", 2)]
        .map(|(view, kind, count)| json!({ "bufferView": view, "componentType": 5126, "type": kind, "count": count }))
        .into();
    let animation = |name: &str, output: u32| {
        let target = json!({ "node": 0, "path": "translation" });
        let channels = [json!({ "sampler": 0, "target": target })];
        json!({ "name": name, "channels": channels, "samplers": [{ "input": 1, "output": output }] })
    };
    let mappings = json!({ "mappings": [{ "material": 1, "variants": [1] }] });
    let file = json!({
        "asset": { "version": "2.0" },
        "extensionsUsed": ["KHR_materials_variants"],
        "extensions": { "KHR_materials_variants": { "variants": [{ "name": "Plain" }, { "name": "Golden" }] } },
        "buffers": [{ "uri": "data.bin", "byteLength": bytes.len() }],
        "bufferViews": views,
        "accessors": accessors,
        "materials": [{ "name": "paint" }, { "name": "gold" }],
        "meshes": [{ "primitives": [{
            "attributes": { "POSITION": 0 }, "material": 0, "extensions": { "KHR_materials_variants": mappings }
        }] }],
        "nodes": [{ "name": "thing", "mesh": 0 }],
        "animations": [animation("slide", 2), animation("rise", 3)]
    });
    place.write("thing.gltf", file.to_string());
    place.write("gold.toml", "gltf = ['thing.gltf']\nvariant = 'Golden'\n");
    place
}

#[test]
fn variants_have_their_materials() {
    let place = place();
    for (words, chosen, material) in [
        (&["thing.gltf"][..], Value::Null, "paint"),
        (&["thing.gltf", "--variant", "Plain"], json!("Plain"), "paint"),
        (&["thing.gltf", "--variant", "Golden"], json!("Golden"), "gold"),
        (&["gold.toml"], json!("Golden"), "gold"),
        (&["gold.toml", "--variant", "Plain"], json!("Plain"), "paint"),
    ] {
        let info = place.listed(&[&["info", "--json"], words].concat());
        assert_eq!(info["variants"], json!(["Plain", "Golden"]), "{words:?}");
        assert_eq!((&info["variant"], &info["objects"][0]["material"]), (&chosen, &json!(material)), "{words:?}");
    }
    let text = place.ok(&["info", "thing.gltf", "--variant", "Golden"]);
    assert!(text.contains("Variants (2)\n  0  Plain\n  1  Golden  chosen\n"), "{text}");
    place.write("points.csv", "x,y,z\n0,0,0\n");
    for command in [
        &["info"][..],
        &["render", "-o", "out.png"],
        &["compare", "--report", "report"],
        &["project", "--eye", "0,0,3", "--points", "points.csv", "-o", "out.csv"],
        &["bake", "--method", "light_field", "-o", "out.bake"],
    ] {
        let message = place.fails(1, &[command, &["thing.gltf", "--variant", "Goldn"]].concat());
        let expected = "thing.gltf: --variant: there is no variant `Goldn` (did you mean `Golden`?); there are: Plain, \
                        Golden";
        assert!(message.contains(expected), "{command:?}: {message}");
    }
    let message = place.fails(1, &["info", "scene.toml", "--variant", "Golden"]);
    assert!(message.contains("scene.toml: --variant: there is no variant `Golden`; there are: none"), "{message}");
    place.write("wrong.toml", "gltf = ['thing.gltf']\nvariant = 'Gilt'\n");
    let message = place.fails(1, &["info", "wrong.toml"]);
    assert!(message.contains("wrong.toml: line 2: variant: there is no variant `Gilt`"), "{message}");
    let message = place.fails(1, &["info", "builtin:vase", "--variant", "Golden"]);
    assert!(message.contains("built-in scenes have no variants"), "{message}");
}

#[test]
fn one_animation_plays_alone() {
    let place = place();
    let origin = |words: &[&str]| {
        let info = place.listed(&[&["info", "thing.gltf", "--json"], words].concat());
        let plays: Vec<bool> = (0..2).map(|index| info["animations"][index]["plays"].as_bool().unwrap()).collect();
        let min = info["objects"][0]["bounds"]["min"].clone();
        assert_eq!(info["animations"][1]["duration"], json!(2.0), "{info}");
        ((min[0].as_f64().unwrap(), min[1].as_f64().unwrap()), plays)
    };
    for (words, place, plays) in [
        // Both move one thing: the first one does.
        (&["--time", "1"][..], (2.0, 0.0), [true, false]),
        (&["--time", "1", "--animation", "slide"], (2.0, 0.0), [true, false]),
        (&["--time", "1", "--animation", "rise"], (0.0, 3.0), [false, true]),
        (&["--time", "1", "--animation", "1"], (0.0, 3.0), [false, true]),
        (&["--time", "9", "--animation", "1"], (0.0, 6.0), [false, true]),
        (&["--time", "-1", "--animation", "rise"], (0.0, 0.0), [false, true]),
    ] {
        assert_eq!(origin(words), (place, plays.to_vec()), "{words:?}");
    }
    let text = place.ok(&["info", "thing.gltf", "--animation", "rise"]);
    assert!(text.contains("0  slide  2 s  1 channels\n  1  rise   2 s  1 channels  plays\n"), "{text}");
    let message = place.fails(1, &["info", "thing.gltf", "--animation", "rize"]);
    let expected = "thing.gltf: --animation: there is no animation `rize` (did you mean `rise`?); there are: \
                    0 `slide`, 1 `rise`";
    assert!(message.contains(expected), "{message}");
    let message = place.fails(1, &["render", "scene.toml", "--animation", "0", "-o", "out.png"]);
    assert!(message.contains("there is no animation `0`; there are: none in this scene"), "{message}");
}

#[test]
fn times_beyond_an_animation_are_said_once() {
    let place = place();
    let render = |words: &[&str]| {
        let output = place.run(&[&["render", "-o", "out.png", "--size", "8x8"], words].concat());
        let said = String::from_utf8(output.stderr).unwrap();
        assert!(output.status.success(), "{said}");
        said
    };
    let said = render(&["thing.gltf", "--time", "3"]);
    assert_eq!(said.matches("ends at 2 s and does not repeat; it holds its last pose").count(), 1, "{said}");
    assert!(render(&["thing.gltf", "--time", "-1"]).contains("it holds its first pose"));
    assert!(render(&["scene.toml", "--time", "1"]).contains("the scene has no animation"));
    assert!(!render(&["thing.gltf", "--time", "2"]).contains("--time"));
}

#[test]
fn bakes_know_what_is_chosen() {
    let place = place();
    let plan = |words: &[&str], folder: &str| {
        place.write("mirror.toml", "base = 'thing.gltf'\n[role]\nthing = 'reflector'\n");
        let sizes = ["--set", "st=2", "--set", "uv=4", "-o", folder];
        place.ok(&[&["bake", "plan", "mirror.toml", "--method", "light_field"], &sizes[..], words].concat());
        let plan = place.path(folder).join("plan.json");
        serde_json::from_slice::<Value>(&std::fs::read(plan).unwrap()).unwrap()
    };
    let rising = plan(&["--animation", "rise", "--time", "1"], "rising");
    assert_eq!(rising["recipe"]["choice"], json!({ "variant": null, "animation": "rise" }));
    let sliding = plan(&["--time", "1"], "sliding");
    assert_ne!(rising["identity"], sliding["identity"]);
    place.ok(&["bake", "run", "rising"]);
}
