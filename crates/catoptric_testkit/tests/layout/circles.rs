//! Circles: files, or folders beside each other, that import each other. There are none: the list of known ones,
//! `known_circles.txt`, is empty.

use crate::graph::{Graph, circles, shortest_way};
use crate::modules::{Crate, ancestors};
use std::collections::{BTreeMap, BTreeSet};

const LIST: &str = "crates/catoptric_testkit/tests/known_circles.txt";

/// Files, or folders and files beside each other; folders end with a slash.
pub(crate) type Circle = BTreeSet<String>;

/// The imports among files or among folders.
#[derive(Default)]
pub(crate) struct Imports {
    graph: Graph,
    /// One import for each arrow.
    lines: BTreeMap<(String, String), Import>,
}

struct Import {
    /// File and line.
    place: String,
    /// The file that is imported from.
    file: String,
}

impl Imports {
    /// The imports among all files of crates.
    pub(crate) fn of_files(crates: &[Crate]) -> Self {
        let mut found = Self::default();
        found.add(crates, |of, from, to| Some((of.files[from].path.clone(), of.files[to].path.clone())));
        found
    }

    /// The imports among the folders and files that lie in one folder. A folder's own file, `mod.rs`, is above both.
    pub(crate) fn of_folders(crates: &[Crate]) -> Self {
        let mut found = Self::default();
        found.add(crates, |of, from, to| {
            let (from, to) = (&of.files[from].module, &of.files[to].module);
            let above: Vec<&str> = ancestors(from).collect();
            let common = ancestors(to).find(|module| above.contains(module))?;
            let part = |module: &str| {
                let lineage: Vec<&str> = [module].into_iter().chain(ancestors(module)).collect();
                lineage[lineage.iter().position(|above| *above == common).map_or(0, |at| at - 1)].to_owned()
            };
            let (from, to) = (part(from), part(to));
            (from != to).then(|| (of.place(&from), of.place(&to)))
        });
        found
    }

    /// Adds imports between files, by their numbers in a crate, as arrows between what `ends` gives for the two.
    fn add(&mut self, crates: &[Crate], ends: impl Fn(&Crate, usize, usize) -> Option<(String, String)>) {
        for of in crates {
            for ((from, to), line) in of.arrows() {
                let Some((begin, end)) = ends(of, from, to) else { continue };
                self.graph.entry(begin.clone()).or_default().insert(end.clone());
                let place = format!("{}:{line}", of.files[from].path);
                let import = Import { place, file: of.files[to].path.clone() };
                self.lines.entry((begin, end)).or_insert(import);
            }
        }
    }

    /// All circles; of folders only those that are not circles of files, too.
    pub(crate) fn circles(&self, are_folders: bool) -> Vec<Circle> {
        let mut found = circles(&self.graph);
        found.retain(|circle| is_of_folders(circle) == are_folders);
        found
    }

    /// The imports of the shortest ring within a circle that is not within a known one.
    fn shortest_ring(&self, circle: &Circle, known: &[Circle]) -> Vec<String> {
        let is_known = |from: &str, to: &str| known.iter().any(|known| known.contains(from) && known.contains(to));
        let arrows = self.lines.keys().filter(|(from, to)| circle.contains(from) && circle.contains(to));
        let new = arrows.filter(|(from, to)| !is_known(from, to));
        let rings = new.filter_map(|(from, to)| shortest_way(&self.graph, to, from));
        let Some(mut ring) = rings.min_by_key(Vec::len) else { return Vec::new() };
        let begin = ring.iter().enumerate().min_by_key(|(_, member)| *member).map_or(0, |(place, _)| place);
        ring.rotate_left(begin);
        let next = ring.iter().cycle().skip(1);
        ring.iter().zip(next).map(|(from, to)| self.describe(from, to)).collect()
    }

    fn describe(&self, from: &str, to: &str) -> String {
        let Import { place, file } = &self.lines[&(from.to_owned(), to.to_owned())];
        format!("    {place} imports from {file}")
    }
}

fn is_of_folders(circle: &Circle) -> bool {
    circle.iter().any(|member| member.ends_with('/'))
}

fn kind(circle: &Circle) -> &'static str {
    if is_of_folders(circle) { "folders" } else { "files" }
}

/// The circles that a list has: lines that follow each other; other blocks are apart by empty lines.
pub(crate) fn read_list(text: &str) -> Vec<Circle> {
    let mut found = vec![Circle::new()];
    for line in text.lines().map(str::trim).filter(|line| !line.starts_with('#')) {
        match found.last_mut() {
            Some(circle) if !line.is_empty() => drop(circle.insert(line.to_owned())),
            _ => found.push(Circle::new()),
        }
    }
    found.retain(|circle| !circle.is_empty());
    found
}

fn block(circle: &Circle) -> String {
    circle.iter().map(|member| format!("{member}\n")).collect()
}

/// The differences of the circles among crates' modules from the known ones.
pub(crate) fn differences(crates: &[Crate], known: &[Circle]) -> Vec<String> {
    let mut wrong = Vec::new();
    for (are_folders, imports) in [(false, Imports::of_files(crates)), (true, Imports::of_folders(crates))] {
        let found = imports.circles(are_folders);
        let known: Vec<Circle> = known.iter().filter(|circle| is_of_folders(circle) == are_folders).cloned().collect();
        let new = found.iter().filter(|circle| !known.iter().any(|known| circle.is_subset(known)));
        wrong.extend(new.map(|circle| describe_new(circle, &known, &imports)));
        wrong.extend(known.iter().filter_map(|known| describe_smaller(known, &found)));
    }
    wrong
}

/// The members that make a circle new, and the imports that close it.
fn describe_new(circle: &Circle, known: &[Circle], imports: &Imports) -> String {
    let kind = kind(circle);
    let is_new = |member: &&String| !known.iter().any(|known| known.contains(*member));
    let new: Circle = circle.iter().filter(is_new).cloned().collect();
    let joined = known.iter().filter(|known| !known.is_disjoint(circle)).count();
    let size = circle.len();
    let begin = match (joined, new.len()) {
        (0, _) => format!("a new circle of {size} {kind}"),
        (1, count) => format!("a known circle grows by {count} to {size} {kind}"),
        (_, count) => format!("{joined} known circles and {count} more {kind} become one of {size}"),
    };
    let ring = imports.shortest_ring(circle, known).join("\n");
    let block = if new.is_empty() { String::new() } else { format!(":\n\n{}", block(&new)) };
    format!(
        "{begin}{block}\none of these imports must go, as by moving what both need to a file below both:\n\n{ring}\n"
    )
}

/// The lines of the list that have to go for a circle that is smaller than it was; `None` if it is not.
fn describe_smaller(known: &Circle, found: &[Circle]) -> Option<String> {
    if found.iter().any(|circle| circle == known || !(circle.is_disjoint(known) || circle.is_subset(known))) {
        return None;
    }
    let left: Vec<String> = found.iter().filter(|circle| circle.is_subset(known)).map(block).collect();
    let (kind, block, left) = (kind(known), block(known), left.join("\n"));
    Some(match left.as_str() {
        "" => format!("a circle of {kind} has gone, remove it from {LIST}:\n\n{block}"),
        left => format!("a circle of {kind} has become smaller, shrink it in {LIST} from\n\n{block}\nto\n\n{left}"),
    })
}

#[test]
fn no_new_circles() {
    let known = std::fs::read_to_string(crate::root().join(LIST)).expect("the list can be read");
    let wrong = differences(&crate::CRATES, &read_list(&known));
    assert!(wrong.is_empty(), "circles of imports differ from the known ones:\n\n{}", wrong.join("\n"));
}
