//! Roles of objects, in the order in which the options stand: of several for an object the last holds.

use crate::PoseArgs;
use catoptric::scene::Role;
use catoptric::scene::roles::RoleRule;
use clap::ArgMatches;

/// A role as it was given on the command line: `reflector`, `lens` or `diffuse`, and a pattern.
pub type RoleWord = (String, String);

/// The roles given on the command line, in the order in which they stand there; `reflector` is what `--reflector`
/// gave, of programs in which it names a role.
pub fn role_words(reflector: &[String], pose: &PoseArgs, options: &ArgMatches) -> Vec<RoleWord> {
    let mut words: Vec<(usize, RoleWord)> = Vec::new();
    for (name, patterns) in [("reflector", reflector), ("lens", &pose.lens), ("diffuse", &pose.diffuse)] {
        let places = options.indices_of(name).into_iter().flatten();
        words.extend(places.zip(patterns).map(|(place, pattern)| (place, (name.to_owned(), pattern.clone()))));
    }
    words.sort_by_key(|(place, _)| *place);
    words.into_iter().map(|(_, word)| word).collect()
}

/// The parameters that the words stand for.
///
/// # Errors
/// Words about a pattern or an index of refraction that is not allowed, with the option.
pub fn rules(words: &[RoleWord]) -> Result<Vec<RoleRule>, String> {
    let rule = |(name, pattern): &RoleWord| {
        let rule = match name.as_str() {
            "reflector" => RoleRule::new(pattern, Role::Reflector, None),
            "lens" => RoleRule::parse_lens(pattern),
            _ => RoleRule::new(pattern, Role::Diffuse, None),
        };
        rule.map_err(|error| format!("--{name}: {error}"))
    };
    words.iter().map(rule).collect()
}
