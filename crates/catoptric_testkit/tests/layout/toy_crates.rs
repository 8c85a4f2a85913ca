//! Tests of the reader itself, on small crates that are made up, and on a true one with a circle planted.

use crate::circles::{Circle, Imports, differences, read_list};
use crate::modules::Crate;
use crate::paths::child;
use crate::tokens::tokens;

/// A crate of files below its `src`, with their text.
fn toy(files: &[(&str, &str)]) -> Crate {
    let texts: Vec<(String, String)> =
        files.iter().map(|(path, text)| (format!("toy/src/{path}"), (*text).to_owned())).collect();
    Crate::read(&texts)
}

/// The imports among a toy's files: `a.rs:1 b.rs`.
fn imports(files: &[(&str, &str)]) -> Vec<String> {
    let toy = toy(files);
    let path = |number: usize| toy.files[number].path.trim_start_matches("toy/src/");
    let arrows = toy.arrows().into_iter();
    let mut found: Vec<String> =
        arrows.map(|((from, to), line)| format!("{}:{line} {}", path(from), path(to))).collect();
    found.sort();
    found
}

/// The differences of a toy's circles from those of a list.
fn wrong(files: &[(&str, &str)], known: &str) -> Vec<String> {
    differences(&[toy(files)], &read_list(known))
}

#[test]
fn comments_strings_and_numbers_are_no_tokens() {
    let text = r####"
        // a::b
        /* c /* d */ e */ f /// g
        "h\"i" 'j' '\'' '\u{6b}' &'l str b"m" r"\" r#"n"o"# 1.5e3 0..p::q 1.max(r) bar"#"
        s
    "####;
    let found: Vec<&str> = tokens(text).iter().map(|token| token.text).collect();
    let expected = ["f", "&", "l", "str", "..", "p", "::", "q", ".", "max", "(", "r", ")", "bar", "s"];
    assert_eq!(found, expected);
    assert_eq!(tokens(text).last().unwrap().line, 5);
}

#[test]
fn all_ways_to_name_a_path_are_read() {
    let files = [
        ("lib.rs", "pub mod a; mod b; pub mod c; mod d;"),
        ("a.rs", "pub(in crate::c) struct A;\nuse crate::{b::{self, B as Other}, c::inner::{Deep, *}};"),
        ("b.rs", "pub struct B;\nfn f() {\n    use super::d::D;\n    crate::c::g();\n}"),
        ("c/mod.rs", "mod inner;\npub fn g(x: &self::inner::Deep) {}\nfn h() { inner::f() }"),
        ("c/inner.rs", "use super::super::d;\nfn f(d: d::D) -> <T as super::Trait>::Item {}"),
        ("d.rs", "mod system {\n    use super::E;\n    use super::super::b::B;\n}"),
    ];
    let expected = [
        "a.rs:2 b.rs",
        "a.rs:2 c/inner.rs",
        "b.rs:3 d.rs",
        "b.rs:4 c/mod.rs",
        "c/inner.rs:2 c/mod.rs",
        "c/inner.rs:2 d.rs",
        "c/mod.rs:2 c/inner.rs",
        "d.rs:3 b.rs",
    ];
    assert_eq!(imports(&files), expected);
}

#[test]
fn re_exports_lead_to_the_file_that_defines() {
    let mut files = [
        ("lib.rs", "mod a; mod shapes; pub use shapes::Round;"),
        ("a.rs", "use crate::Round;\nuse crate::shapes::{Own, area, paint};\nuse crate::shapes::Plane;"),
        (
            "shapes/mod.rs",
            "mod area;\nmod flat;\npub use area::area;\npub use flat::{Flat as Plane, Round};\nstruct Own;",
        ),
        ("shapes/area.rs", "pub fn area() {}\nmacro_rules! paint { () => { $crate::a::A } }\npub(crate) use paint;"),
        ("shapes/flat.rs", "pub struct Flat; pub struct Round;"),
    ];
    let expected = ["a.rs:1 shapes/flat.rs", "a.rs:2 shapes/area.rs", "a.rs:2 shapes/mod.rs", "shapes/area.rs:2 a.rs"];
    assert_eq!(imports(&files), expected);
    // A module that uses what it hands on.
    files[2].1 = "pub use area::area;\nmod area;\nmod flat;\nfn f() {\n    area();\n}";
    assert!(imports(&files).contains(&"shapes/mod.rs:1 shapes/area.rs".into()));
}

#[test]
fn tests_and_declarations_import_nothing() {
    let files = [
        ("lib.rs", "mod a;\nmod b;\n#[cfg(test)]\n#[rustfmt::skip]\nmod checks;"),
        (
            "a.rs",
            "// use crate::b::B;\nconst TEXT: &str = \"crate::b::B\";\n#[cfg(test)]\nmod tests {\n use crate::b::B;\n}",
        ),
        ("b.rs", "#[cfg(test)]\nuse crate::{a::A};\n#[cfg(test)]\npub(crate) fn f() { crate::a::f() }\nmod tests;"),
        ("b/tests.rs", "use crate::a::A;"),
        ("checks.rs", "use crate::a::A;"),
    ];
    assert_eq!(imports(&files), [""; 0]);
}

#[test]
fn circles_of_files_are_found() {
    let chain = [
        ("lib.rs", "mod a; mod b; mod c; mod d;"),
        ("a.rs", "use crate::b::B;"),
        ("b.rs", "use crate::c::C;"),
        ("c.rs", "use crate::d::D;"),
        ("d.rs", ""),
    ];
    assert_eq!(wrong(&chain, ""), [""; 0]);
    let mut ring = chain;
    ring[3].1 = "use crate::d::D;\n\nuse super::{a::A, b::B};";
    let begin = "a new circle of 3 files:\n\ntoy/src/a.rs\ntoy/src/b.rs\ntoy/src/c.rs\n\n";
    let end = ":\n\n    toy/src/b.rs:1 imports from toy/src/c.rs\n    toy/src/c.rs:3 imports from toy/src/b.rs\n";
    let found = wrong(&ring, "");
    assert!(found.len() == 1 && found[0].starts_with(begin) && found[0].ends_with(end), "{found:?}");
    // A module and one below it.
    let family = [("lib.rs", "mod a;"), ("a/mod.rs", "mod b;\nfn f(b: b::B) {}"), ("a/b.rs", "use super::A;")];
    assert!(wrong(&family, "")[0].contains("toy/src/a/b.rs:1 imports from toy/src/a/mod.rs"));
    let family = [("lib.rs", "mod a;"), ("a/mod.rs", "mod b;"), ("a/b.rs", "use super::A;")];
    assert_eq!(wrong(&family, ""), [""; 0]);
}

#[test]
fn circles_of_folders_are_found() {
    let files = [
        ("lib.rs", "mod draw; mod find;\nuse find::search::Search;"),
        ("draw/mod.rs", "mod mesh;\nmod pass;"),
        ("draw/mesh.rs", "use crate::find::search::Search;"),
        ("draw/pass.rs", ""),
        ("find/mod.rs", "mod search;\nmod view;\nuse view::View;"),
        ("find/search.rs", ""),
        ("find/view.rs", "\nuse crate::draw::pass::Pass;"),
    ];
    let found = wrong(&files, "");
    let begin = "a new circle of 2 folders:\n\ntoy/src/draw/\ntoy/src/find/\n\n";
    let end = "    toy/src/draw/mesh.rs:1 imports from toy/src/find/search.rs\n    toy/src/find/view.rs:2 imports from \
               toy/src/draw/pass.rs\n";
    assert!(found.len() == 1 && found[0].starts_with(begin) && found[0].ends_with(end), "{found:?}");
    assert_eq!(wrong(&files, "# known\ntoy/src/draw/\ntoy/src/find/\n"), [""; 0]);
}

#[test]
fn the_list_may_only_become_shorter() {
    let files = [
        ("lib.rs", "mod a; mod b; mod c; mod d;"),
        ("a.rs", "use crate::b::B;"),
        ("b.rs", "use crate::a::A;"),
        ("c.rs", "use crate::d::D;"),
        ("d.rs", "use crate::c::C;"),
    ];
    let [ab, cd] = ["toy/src/a.rs\ntoy/src/b.rs\n", "toy/src/c.rs\ntoy/src/d.rs\n"];
    assert_eq!(wrong(&files, &format!("# two\n\n{ab}\n\n{cd}")), [""; 0]);
    assert!(wrong(&files, ab)[0].starts_with(&format!("a new circle of 2 files:\n\n{cd}")));
    let gone = wrong(&files, &format!("{ab}\n{cd}\ntoy/src/lib.rs\ntoy/src/main.rs"));
    assert!(gone.len() == 1 && gone[0].contains("has gone, remove it") && gone[0].contains("lib.rs"), "{gone:?}");
    let smaller = wrong(&files, &format!("{ab}{cd}"));
    assert!(smaller.len() == 1 && smaller[0].ends_with(&format!("to\n\n{ab}\n{cd}")), "{smaller:?}");
    // One more file joins.
    let mut joined = files;
    joined[2].1 = "use crate::a::A;\nuse crate::c::C;";
    joined[3].1 = "use crate::b::B;";
    let found = wrong(&joined, ab);
    assert!(
        found.len() == 1 && found[0].starts_with("a known circle grows by 1 to 3 files:\n\ntoy/src/c.rs\n\n"),
        "{found:?}"
    );
    assert!(found[0].contains("toy/src/b.rs:2 imports from toy/src/c.rs"), "{found:?}");
    // Two become one.
    joined[3].1 = "use crate::{b::B, d::D};";
    let found = wrong(&joined, &format!("{ab}\n{cd}"));
    assert!(
        found.len() == 1 && found[0].starts_with("2 known circles and 0 more files become one of 4\n"),
        "{found:?}"
    );
}

/// Imports of a true crate that are turned round are found as circles.
#[test]
fn planted_circles_are_found() {
    let texts = crate::texts(&["crates/catoptric_core/src"], "rs");
    let circles = |texts: &[(String, String)]| Imports::of_files(&[Crate::read(texts)]).circles(false);
    let core = Crate::read(&texts);
    let known: Circle = circles(&texts).into_iter().flatten().collect();
    let ends = core.arrows().into_keys().map(|(from, to)| [&core.files[from], &core.files[to]]);
    let planted: Vec<_> = ends.filter(|ends| !ends.iter().any(|end| known.contains(&end.path))).step_by(8).collect();
    assert!(planted.len() > 5, "{}", planted.len());
    for [from, to] in planted {
        let mut texts = texts.clone();
        let text = texts.iter_mut().find(|(path, _)| *path == to.path).expect("it is one of them");
        text.1 += &format!("use crate::{};\n", child(&from.module, "Planted"));
        let is_found = circles(&texts).iter().any(|circle| circle.contains(&from.path) && circle.contains(&to.path));
        assert!(is_found, "{} {}", from.path, to.path);
    }
}
