//! `catoptric methods`: the registry.

use super::pretty;
use crate::args::{ExplainArgs, JsonArgs};
use crate::failure::Failure;
use catoptric::methods::{About, MethodInfo, SettingInfo, all, find};

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

    /// The processors that draw it, and whether it bakes.
    fn processors(&self) -> String {
        let abilities = [(self.cpu, "cpu"), (self.gpu, "gpu"), (self.bake, "bake")];
        let abilities: Vec<&str> = abilities.iter().filter(|(has, _)| *has).map(|(_, name)| *name).collect();
        abilities.join(", ")
    }
}

pub(crate) fn run(args: &JsonArgs) -> Result<String, Failure> {
    let entries: Vec<MethodRow> = all().iter().map(|info| MethodRow::new(info)).collect();
    if args.json {
        return pretty(&entries);
    }
    let mut text = String::new();
    for entry in &entries {
        text += &format!("{} ({}; {})\n  {}\n", entry.id, entry.family, entry.processors(), entry.summary);
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

/// Columns of the text that explains a method.
const COLUMNS: usize = 80;

/// `catoptric explain`: one method in some lines.
pub(crate) fn explain(args: &ExplainArgs) -> Result<String, Failure> {
    let info = find(&args.method).map_err(Failure::usage)?;
    let row = MethodRow::new(info);
    let About { draws, costs, cannot, useful, .. } = info.about;
    let is_useful = |setting: &&SettingInfo| useful.contains(&setting.name);
    let settings: Vec<&SettingInfo> = row.settings.iter().filter(is_useful).collect();
    let idea = info.about.idea();
    if args.format.json {
        return pretty(&serde_json::json!({
            "id": row.id, "family": row.family, "paper": row.paper, "idea": idea, "draws": draws, "costs": costs,
            "assumptions": row.assumptions, "cannot": cannot, "cpu": row.cpu, "gpu": row.gpu, "bake": row.bake,
            "useful": settings,
        }));
    }
    let mut text = format!("{} ({}; {})\n", row.id, row.family, row.processors());
    let facts = [("paper", info.paper), ("idea", &idea), ("draws", draws), ("costs", costs)];
    for (name, fact) in facts.into_iter().chain([("assumes", info.assumptions), ("faults", cannot)]) {
        text += &wrapped(&format!("{name}: {fact}"));
    }
    for setting in settings {
        let values = if setting.values().is_empty() { String::new() } else { format!(" ({})", setting.values()) };
        text += &wrapped(&format!("--set {}={}{values}: {}", setting.name, setting.default, setting.help));
    }
    Ok(text)
}

/// A paragraph in lines, indented, and more so from the second on.
fn wrapped(paragraph: &str) -> String {
    let mut lines = vec![String::from(" ")];
    for word in paragraph.split_whitespace() {
        let line = lines.len() - 1;
        if lines[line].chars().count() + 1 + word.chars().count() > COLUMNS {
            lines.push(format!("    {word}"));
        } else {
            lines[line] += " ";
            lines[line] += word;
        }
    }
    lines.join("\n") + "\n"
}
