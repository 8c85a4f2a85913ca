//! `catoptric scenes`: the built-in scenes.

use super::pretty;
use crate::args::JsonArgs;
use crate::failure::Failure;
use catoptric_scenes::builtin;
use serde_json::json;

pub(crate) fn run(args: &JsonArgs) -> Result<String, Failure> {
    if args.json {
        let scenes: Vec<serde_json::Value> = builtin::all()
            .iter()
            .map(|scene| {
                let parameters: Vec<serde_json::Value> = scene
                    .parameters
                    .iter()
                    .map(|parameter| {
                        json!({ "name": parameter.name, "default": parameter.default, "help": parameter.help })
                    })
                    .collect();
                let (name, summary, command) = (scene.name, scene.summary, scene.command);
                json!({ "name": name, "summary": summary, "parameters": parameters, "command": command })
            })
            .collect();
        return pretty(&scenes);
    }
    let mut text = String::new();
    for scene in builtin::all() {
        text += &format!("builtin:{}\n  {}\n", scene.name, scene.summary);
        for parameter in scene.parameters {
            text += &format!("  ?{}={}: {}\n", parameter.name, parameter.default, parameter.help);
        }
        text += &format!("  {}\n\n", scene.command);
    }
    Ok(text.trim_end().to_owned() + "\n")
}
