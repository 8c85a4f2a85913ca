//! The JSON of glTF files.

use super::*;
use catoptric_core::error::SceneError;

fn parse(name: &str, json: &[u8]) -> Result<Model, SceneError> {
    from_slice(name, json, &NoFiles)
}

#[test]
fn errors_name_the_field() {
    let message = |json: &str| parse("a.gltf", json.as_bytes()).unwrap_err().to_string();
    let text = message(r#"{"asset":{"version":"2.0"},"nodes":[{},{"mesh":-1}]}"#);
    assert_eq!(text, "a.gltf: nodes[1].mesh: is integer `-1`; must be a whole number of 0 or more");
    assert!(message(r#"{"asset":{"version":"1.0"}}"#).contains("asset.version"));
    assert!(message("{}").contains("asset.version"));
    assert!(message("[]").contains("JSON"));
    assert!(message("").contains("JSON"));
    assert!(message(&format!("{}{}", "[".repeat(100_000), "]".repeat(100_000))).contains("JSON"));
}

#[test]
fn whole_numbers_may_be_written_as_floats() {
    let mut file = File::triangle();
    file.push("nodes", file.json["nodes"][0].clone());
    file.json["scene"] = json!(0.0);
    file.json["scenes"] = json!([{ "nodes": [1e0] }, { "nodes": [] }]);
    file.json["accessors"][0]["count"] = json!(3.0);
    let text = file.json.to_string();
    assert!(text.contains("\"scene\":0.0") && text.contains("[1.0]") && text.contains("\"count\":3.0"), "{text}");
    let model = file.model();
    assert_eq!((model.nodes[0].mesh, model.nodes[1].mesh), (None, Some(0)));
    assert_eq!(model.meshes[0].primitives[0].positions.len(), 3);
}

#[test]
fn too_many_values_are_refused() {
    let json = format!(r#"{{"asset":{{"version":"2.0"}},"x":[{}0]}}"#, "0,".repeat(8_000_001));
    assert!(parse("a", json.as_bytes()).unwrap_err().to_string().contains("more than"));
}
