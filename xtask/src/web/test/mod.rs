//! The page in a real browser: what is seen is what the program draws.

mod expected;
mod restart;
mod settings;
mod viewer;

use super::build::build;
use super::chromium::{Graphics, Page, installed};
use super::serve;
use anyhow::{Context, Result, bail, ensure};
use std::path::PathBuf;
use std::sync::Arc;
use std::time::Instant;
use viewer::{SHARP, SIZE, STATE, distance, drag, drop_files, matches_the_library, motion, pinch, save, state};

/// A name, the graphics of the browser, and a test of the pages at an address.
type Test = (&'static str, Graphics, fn(&str) -> Result<()>);

const TESTS: [Test; 8] = [
    ("window by WebGPU", Graphics::WebGpu, |base| shows_the_picture(base, Graphics::WebGpu)),
    ("window by WebGL", Graphics::WebGl, |base| shows_the_picture(base, Graphics::WebGl)),
    ("scenes by WebGPU", Graphics::WebGpu, draws_by_webgpu),
    ("settings", Graphics::WebGl, settings::change),
    ("workers that end", Graphics::WebGl, restart::go_on),
    ("workers with a device that end", Graphics::WebGpu, restart::go_on_without_device),
    ("the element", Graphics::WebGl, stands_in_a_page),
    ("without graphics", Graphics::None, says_what_is_missing),
];

/// Tests a folder, which is built unless it is named, or says why it does not: `[FOLDER [WORD]] [--graphics KIND]`.
pub(super) fn run(words: &[&str]) -> Result<()> {
    let (folder, tests) = chosen(words)?;
    let folder = folder.map_or_else(build, Ok)?;
    if installed().is_none() {
        println!("skipped: Chromium is not installed (Debian: apt-get install chromium)");
        return Ok(());
    }
    if tests.iter().any(|(_, graphics, _)| *graphics != Graphics::None) {
        expected::build()?;
    }
    let server = Arc::new(serve::open(0)?);
    let port = server.server_addr().to_ip().context("a server without an address")?.port();
    let answering = server.clone();
    std::thread::spawn(move || serve::answer(&answering, &folder));
    let base = format!("http://127.0.0.1:{port}/");
    for (name, _, test) in tests {
        let start = Instant::now();
        test(&base).context(name)?;
        println!("ok: {name}: {:.1} s", start.elapsed().as_secs_f64());
    }
    server.unblock();
    Ok(())
}

/// The folder, and the tests with a word in their names and with one kind of graphics, where these are given.
fn chosen(words: &[&str]) -> Result<(Option<PathBuf>, Vec<Test>)> {
    let (mut places, mut graphics) = (Vec::new(), None);
    let mut words = words.iter();
    while let Some(word) = words.next() {
        match *word {
            "--graphics" => graphics = Some(Graphics::parse(words.next().context("--graphics KIND: no KIND")?)?),
            word if places.len() < 2 && !word.starts_with('-') => places.push(word),
            word => bail!("`{word}` is not understood"),
        }
    }
    let word = places.get(1).copied().unwrap_or_default();
    let is_chosen = |name: &str, kind: Graphics| name.contains(word) && graphics.is_none_or(|wanted| wanted == kind);
    let tests: Vec<_> = TESTS.into_iter().filter(|(name, kind, _)| is_chosen(name, *kind)).collect();
    ensure!(!tests.is_empty(), "there is no such test, but {:?}", TESTS.map(|(name, ..)| name));
    Ok((places.first().map(PathBuf::from), tests))
}

fn shows_the_picture(base: &str, graphics: Graphics) -> Result<()> {
    let mut page = Page::open(graphics, SIZE)?;
    let start = Instant::now();
    page.visit(&format!("{base}?scene=builtin:sphere_room&method=auto"))?;
    page.wait_for("typeof catoptric === 'object' && catoptric.pixels(0) !== undefined")?;
    println!("ok: {graphics:?}: first picture {:.1} s after the page was asked for", start.elapsed().as_secs_f64());
    page.wait_for(SHARP)?;
    let first = matches_the_library(&mut page, "auto")?;
    println!("ok: {graphics:?}: the picture is the library's: {:.3} % of its pixels are off", first * 100.0);
    let eye = state(&mut page)?["eye"].clone();
    drag(&mut page)?;
    page.wait_for(&format!("(state => state.sharp && JSON.stringify(state.eye) !== '{eye}')({STATE})"))?;
    matches_the_library(&mut page, "auto")?;
    println!("ok: {graphics:?}: dragging turns the view");
    println!("ok: {graphics:?}: by the CPU: {}", motion(&mut page)?);
    page.wait_for(SHARP)?;
    let far = distance(&mut page)?;
    pinch(&mut page)?;
    page.wait_for(&format!("(state => state.sharp && Math.hypot(...state.eye) < {far} * 0.9)({STATE})"))?;
    matches_the_library(&mut page, "auto")?;
    println!("ok: {graphics:?}: two fingers go nearer");
    page.value("catoptric.choose(0, 'environment_map')")?;
    page.wait_for(&format!("(state => state.sharp && state.method === 'environment_map')({STATE})"))?;
    matches_the_library(&mut page, "environment_map")?;
    println!("ok: {graphics:?}: another method is drawn");
    drop_files(&mut page, &[("broken.glb", "nothing")])?;
    page.wait_for(&format!("{STATE}.messages.some(message => message.includes('broken.glb'))"))?;
    println!("ok: {graphics:?}: a broken file is told in words");
    let ball = "[[reflector]]\\nname = 'ball'\\nsurface = 'sphere'\\ncenter = [0, 0, 0]\\nradius = 1\\n";
    page.value(&format!("catoptric.open('ball.toml', new TextEncoder().encode(\"{ball}\"))"))?;
    page.wait_for(&format!("(state => state.sharp && state.scene === 'ball.toml')({STATE})"))?;
    let ball = "mtllib ball.mtl\\nusemtl red\\nv 0 0 0\\nv 1 0 0\\nv 0 1 0\\nf 1 2 3\\n";
    drop_files(&mut page, &[("ball.mtl", "newmtl red\\nKd 1 0 0\\n"), ("ball.obj", ball)])?;
    page.wait_for(&format!("(state => state.sharp && state.scene === 'ball.obj')({STATE})"))?;
    println!("ok: {graphics:?}: files are opened, alone and with those that they name");
    ensure!(page.complaints.is_empty(), "the page complains: {:?}", page.complaints);
    Ok(())
}

/// Scenes drawn by WebGPU itself, on a driver that draws on the processor, which must be asked for.
fn draws_by_webgpu(base: &str) -> Result<()> {
    let mut page = Page::open(Graphics::WebGpu, SIZE)?;
    let start = Instant::now();
    page.visit(&format!("{base}?scene=builtin:sphere_room&method=multiperspective&processor=gpu"))?;
    page.wait_for("typeof catoptric === 'object' && catoptric.pixels(0) !== undefined")?;
    let first = start.elapsed().as_secs_f64();
    let drawn_by = |sharp: bool, processor: &str| {
        format!("(state => (state.sharp || !{sharp}) && /{processor}/.test(state.processor))({STATE})")
    };
    page.wait_for(&drawn_by(true, "WebGPU"))?;
    println!(
        "ok: by WebGPU: first picture {first:.1} s after the page was asked for, sharp after {:.1}",
        start.elapsed().as_secs_f64()
    );
    // Twice: programs of shaders for drafts are made in the first motion.
    motion(&mut page)?;
    println!("ok: by WebGPU: {}", motion(&mut page)?);
    page.wait_for(&drawn_by(true, "WebGPU"))?;
    for method in ["multiperspective", "environment_map", "planar_mirror", "reflector_search"] {
        page.value(&format!("catoptric.choose(0, '{method}')"))?;
        page.wait_for(&format!("(state => state.sharp && state.method === '{method}')({STATE})"))?;
        page.wait_for(&drawn_by(true, "WebGPU"))?;
        let off = matches_the_library(&mut page, method)?;
        println!("ok: by WebGPU: {method}: {:.3} % of its pixels are off", off * 100.0);
    }
    page.value("catoptric.choose(0, 'reference')")?;
    page.wait_for(&format!("(state => state.method === 'reference')({STATE})"))?;
    page.wait_for(&drawn_by(true, "CPU"))?;
    println!("ok: by WebGPU: what it does not draw, the CPU does");
    ensure!(page.complaints.is_empty(), "the page complains: {:?}", page.complaints);
    Ok(())
}

/// The custom element, in the example's page.
fn stands_in_a_page(base: &str) -> Result<()> {
    let mut page = Page::open(Graphics::WebGl, SIZE)?;
    page.visit(&format!("{base}example.html"))?;
    let shows = |scene: &str, method: &str| {
        format!("(state => state?.sharp && state.scene === '{scene}' && state.method === '{method}')({ELEMENT}.state)")
    };
    page.wait_for(&shows("builtin:sphere_room", "environment_map"))?;
    page.value(&format!("(window.told = [], {ELEMENT}.addEventListener('load', e => told.push(e.detail)))"))?;
    page.value(&format!("{ELEMENT}.setAttribute('method', 'auto')"))?;
    page.value(&format!("{ELEMENT}.setAttribute('src', 'scenes/two-mirrors.toml')"))?;
    page.wait_for(&shows("two-mirrors.toml", "auto"))?;
    page.wait_for("told.includes('two-mirrors.toml')")?;
    page.value(&format!("{ELEMENT}.setAttribute('method', 'environment_map')"))?;
    page.value(&format!("{ELEMENT}.setAttribute('settings', 'parallax=box, size=64')"))?;
    page.wait_for(&format!(
        "(state => state.sharp && state.settings.parallax === 'box' && state.settings.size === 64)({ELEMENT}.state)"
    ))?;
    page.value(&format!("{ELEMENT}.addEventListener('error', e => told.push(e.detail))"))?;
    page.value(&format!("{ELEMENT}.setAttribute('src', 'none.glb')"))?;
    page.wait_for("told.some(text => text.includes('none.glb cannot be loaded: 404'))")?;
    page.value(&format!("{ELEMENT}.setAttribute('settings', 'paralax=box')"))?;
    page.wait_for("told.some(text => text.includes('there is no setting `paralax`'))")?;
    save(&page.screenshot()?, "element")?;
    // Without the element its worker goes, too.
    page.value(&format!("{ELEMENT}.remove()"))?;
    page.complaints.retain(|complaint| !complaint.contains("404"));
    ensure!(page.complaints.is_empty(), "the page complains: {:?}", page.complaints);
    println!("ok: the element shows scenes, follows its attributes and tells what happens");
    Ok(())
}

/// The example's viewer.
const ELEMENT: &str = "document.querySelector('catoptric-viewer')";

fn says_what_is_missing(base: &str) -> Result<()> {
    let mut page = Page::open(Graphics::None, SIZE)?;
    page.visit(base)?;
    page.wait_for("document.getElementById('words')?.textContent.includes('WebGPU or WebGL 2')")?;
    println!("ok: without WebGPU and WebGL the page says what is missing");
    Ok(())
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn tests_are_chosen_by_words_and_graphics() {
        let names = |words: &[&str]| {
            let (folder, tests) = chosen(words).unwrap();
            (folder, tests.into_iter().map(|(name, ..)| name).collect::<Vec<_>>())
        };
        assert_eq!(names(&[]).1.len(), TESTS.len());
        assert_eq!(names(&["--graphics", "none"]), (None, vec!["without graphics"]));
        let webgl = names(&["dist", "window", "--graphics", "webgl"]);
        assert_eq!(webgl, (Some("dist".into()), vec!["window by WebGL"]));
        for words in [&["dist", "nothing"][..], &["--graphics"], &["--graphics", "vulkan"], &["--fast"]] {
            assert!(chosen(words).is_err(), "{words:?}");
        }
    }
}
