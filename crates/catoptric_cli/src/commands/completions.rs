//! `catoptric completions`: scripts that complete commands, options, methods, settings and built-in scenes.

use crate::args::Cli;
use catoptric::methods::{self, MethodInfo};
use catoptric_scenes::builtin;
use clap::builder::{PossibleValue, PossibleValuesParser};
use clap::{Arg, Command, CommandFactory, ValueHint};
use clap_complete::Shell;

/// The commands that take a scene.
const SCENE_COMMANDS: [&str; 5] = ["render", "compare", "project", "bake", "info"];

/// The script of a shell.
pub(crate) fn run(shell: Shell) -> String {
    let mut command = Cli::command();
    for name in SCENE_COMMANDS {
        command = command.mut_subcommand(name, |command| with_values(command, name, shell));
    }
    let mut script = Vec::new();
    clap_complete::generate(shell, &mut command, "catoptric", &mut script);
    with_scenes(&String::from_utf8_lossy(&script), shell)
}

/// The command with the values that its options take.
fn with_values(command: Command, name: &str, shell: Shell) -> Command {
    let is_usable = |info: &&&MethodInfo| name != "bake" || info.bake.is_some();
    let infos: Vec<&MethodInfo> = methods::all().iter().filter(is_usable).copied().collect();
    let values = |arg: Arg| match arg.get_id().as_str() {
        "method" => {
            let mut values: Vec<PossibleValue> =
                infos.iter().map(|info| PossibleValue::new(info.id).help(info.summary)).collect();
            if name == "project" {
                values.push(PossibleValue::new("exact").help("the exact search"));
            }
            arg.value_parser(PossibleValuesParser::new(values))
        }
        "set" => {
            let of_method = |info: &&MethodInfo| -> Vec<String> {
                let settings = (info.settings)();
                let plain = settings.iter().map(|setting| format!("{}=", setting.name));
                let qualified = settings.iter().filter(|_| name == "compare");
                plain.chain(qualified.map(|setting| format!("{}.{}=", info.id, setting.name))).collect()
            };
            let mut names: Vec<String> = infos.iter().flat_map(of_method).collect();
            names.sort_unstable();
            names.dedup();
            arg.value_parser(PossibleValuesParser::new(names.into_iter().map(unending)))
        }
        // Where bash finds none of these it completes files.
        "scene" if shell == Shell::Bash => arg.value_parser(PossibleValuesParser::new(scenes().map(unending))),
        "scene" => arg.value_hint(ValueHint::FilePath),
        _ => arg,
    };
    let command = command.mut_args(values);
    command.mut_subcommands(|step| with_values(step, name, shell))
}

/// A text that lives as long as the program, which prints it and ends.
fn unending(text: String) -> &'static str {
    text.leak()
}

fn scenes() -> impl Iterator<Item = String> {
    builtin::all().iter().map(|scene| format!("builtin:{}", scene.name))
}

/// The script with built-in scenes beside files, in the way of its shell.
fn with_scenes(script: &str, shell: Shell) -> String {
    match shell {
        // Names of scenes have a colon, which begins a new word otherwise.
        Shell::Bash => format!("{script}\nCOMP_WORDBREAKS=${{COMP_WORDBREAKS//:}}\n"),
        Shell::Zsh => {
            let names: Vec<String> = scenes().map(|name| name.replace(':', "\\:")).collect();
            let function = format!(
                "#compdef catoptric\n\n_catoptric_scenes() {{\n    _alternative 'scenes:built-in scene:({})' \
                'files:scene file:_files'\n}}\n",
                names.join(" ")
            );
            let is_scene = |line: &str| line.trim_start().starts_with("':scene ");
            let lines = script.lines().map(|line| match is_scene(line) {
                true => line.replace(":_files'", ":_catoptric_scenes'"),
                false => line.to_owned(),
            });
            let script = lines.collect::<Vec<_>>().join("\n") + "\n";
            script.replacen("#compdef catoptric\n", &function, 1)
        }
        Shell::Fish => {
            let names: Vec<String> = scenes().collect();
            let line = |command: &str| {
                let condition = format!("__fish_catoptric_using_subcommand {command}");
                format!("complete -c catoptric -n \"{condition}\" -a \"{}\"\n", names.join(" "))
            };
            script.to_owned() + &SCENE_COMMANDS.map(line).concat()
        }
        _ => script.to_owned(),
    }
}
