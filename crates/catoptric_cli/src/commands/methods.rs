//! `catoptric methods`: the registry.

use super::pretty;
use crate::args::JsonArgs;
use crate::failure::Failure;
use catoptric::methods::{MethodInfo, SettingInfo, all};

#[derive(serde::Serialize)]
struct MethodRow {
    id: &'static str,
    family: &'static str,
    summary: &'static str,
    paper: &'static str,
    assumptions: &'static str,
    cpu: bool,
    gpu: bool,
    bake: bool,
    settings: Vec<SettingInfo>,
}

impl MethodRow {
    fn new(info: &MethodInfo) -> Self {
        Self {
            id: info.id,
            family: info.family.name(),
            summary: info.summary,
            paper: info.paper,
            assumptions: info.assumptions,
            cpu: info.cpu,
            gpu: info.gpu,
            bake: info.bake.is_some(),
            settings: (info.settings)(),
        }
    }
}

pub(crate) fn run(args: &JsonArgs) -> Result<String, Failure> {
    let entries: Vec<MethodRow> = all().iter().map(|info| MethodRow::new(info)).collect();
    if args.json {
        return pretty(&entries);
    }
    let mut text = String::new();
    for entry in &entries {
        let backends: Vec<&str> = [(entry.cpu, "cpu"), (entry.gpu, "gpu"), (entry.bake, "bake")]
            .iter()
            .filter(|b| b.0)
            .map(|b| b.1)
            .collect();
        text += &format!("{} ({}; {})\n  {}\n", entry.id, entry.family, backends.join(", "), entry.summary);
        text += &format!("  paper: {}\n  assumes: {}\n", entry.paper, entry.assumptions);
        for setting in &entry.settings {
            let values = if setting.values().is_empty() { String::new() } else { format!(" ({})", setting.values()) };
            text += &format!("  --set {}={}{values}: {}\n", setting.name, setting.default, setting.help);
            for choice in setting.choices {
                text += &format!("      {}: {}\n", choice.name, choice.help);
            }
        }
        text += "\n";
    }
    Ok(text.trim_end().to_owned() + "\n")
}
