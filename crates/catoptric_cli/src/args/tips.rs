//! Tips for command lines of other programs.

use catoptric::picture::PictureFormat;
use clap::error::{ContextKind, ContextValue, ErrorKind};
use std::path::Path;

/// Options that other programs have, and what says the same here.
const OPTIONS: [(&str, &str); 8] = [
    ("--width", "the size of the picture is one option: --size 1280x720"),
    ("--height", "the size of the picture is one option: --size 1280x720"),
    ("--resolution", "the size of the picture is one option: --size 1280x720"),
    ("--ior", "the index of refraction follows the name of what is glass: --lens 'Vase:1.5'"),
    ("--json", "`render` writes its numbers as JSON with --stats FILE; `-` is standard output"),
    ("--fps", "frames are numbered; --turntable N and --frames 1..N draw them"),
    ("--input", "the scene stands by itself: catoptric render room.glb -o room.png"),
    ("--scene", "the scene stands by itself: catoptric render room.glb -o room.png"),
];

/// The message about a command line with a tip of ours; `None` where there is none.
pub(crate) fn with_tip(message: &clap::Error) -> Option<String> {
    let text = |kind| match message.get(kind) {
        Some(ContextValue::String(text)) => Some(text.as_str()),
        _ => None,
    };
    let tip = match message.kind() {
        ErrorKind::UnknownArgument => {
            let argument = text(ContextKind::InvalidArg)?;
            let name = argument.split('=').next()?;
            match OPTIONS.iter().find(|(option, _)| *option == name) {
                Some((_, tip)) => (*tip).to_owned(),
                None if !argument.starts_with('-') && PictureFormat::from_path(Path::new(argument)).is_some() => {
                    format!("the picture's file follows -o: -o {argument}")
                }
                None => return None,
            }
        }
        ErrorKind::InvalidSubcommand => {
            let word = text(ContextKind::InvalidSubcommand)?;
            if !word.contains(['.', '/', ':']) {
                return None;
            }
            format!("say what to do with it: catoptric render {word} -o picture.png")
        }
        _ => return None,
    };
    let whole = message.to_string();
    let (fault, usage) = (whole.lines().next()?, whole.find("Usage:").map_or("", |at| &whole[at..]));
    Some(format!("{fault}\n\n  tip: {tip}\n\n{usage}"))
}
