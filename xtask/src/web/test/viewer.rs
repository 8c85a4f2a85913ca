//! The viewer in a page: its state, what is done to it by mouse and fingers, and its picture beside the library's.

use super::expected::{self, Picture, Settings};
use crate::web::chromium::Page;
use anyhow::{Context, Result, bail, ensure};
use serde_json::Value;
use std::path::Path;
use std::time::{Duration, Instant};

/// The size of the page.
pub(super) const SIZE: [u32; 2] = [900, 700];

/// The share of pixels that may be off by more than 0.1: edges may fall otherwise on another processor.
pub(super) const MOST_OFF: f64 = 0.005;

/// Points beside the picture's edges that labels may cover.
const LABELS: u32 = 40;

/// The viewer's state.
pub(super) const STATE: &str = "JSON.parse(catoptric.state())";

/// True once everything is there that is wanted.
pub(super) const SHARP: &str = "typeof catoptric === 'object' && JSON.parse(catoptric.state()).sharp";

/// The state that the viewer tells of itself.
pub(super) fn state(page: &mut Page) -> Result<Value> {
    page.value(STATE)
}

/// Drops files with these names and texts onto the picture.
pub(super) fn drop_files(page: &mut Page, files: &[(&str, &str)]) -> Result<()> {
    let file = |(name, text): &(&str, &str)| format!("files.items.add(new File(['{text}'], '{name}'));");
    let files: String = files.iter().map(file).collect();
    page.value(&format!(
        "(() => {{ const files = new DataTransfer(); {files} for (const kind of ['dragenter', 'dragover', 'drop']) {{ \
         document.querySelector('canvas').dispatchEvent(new DragEvent(kind, {{ dataTransfer: files, bubbles: true, \
         cancelable: true }})); }} }})()"
    ))
    .map(drop)
}

/// The eye's distance from the middle of the world.
pub(super) fn distance(page: &mut Page) -> Result<f64> {
    page.value(&format!("Math.hypot(...{STATE}.eye)"))?.as_f64().context("no eye")
}

/// Two fingers on the picture move apart.
pub(super) fn pinch(page: &mut Page) -> Result<()> {
    let middle = middle(page)?;
    let fingers = |apart: f64| [[middle[0] - apart, middle[1]], [middle[0] + apart, middle[1]]];
    page.touch("touchStart", &fingers(40.0))?;
    for step in 1..=8 {
        page.touch("touchMove", &fingers(40.0 + 6.0 * f64::from(step)))?;
    }
    page.touch("touchEnd", &[])
}

/// The middle of the picture.
fn middle(page: &mut Page) -> Result<[f64; 2]> {
    let rect = state(page)?["rect"].clone();
    let number = |index: usize| rect[index].as_f64().context("no place of the picture");
    Ok([number(0)? + number(2)? / 2.0, number(1)? + number(3)? / 2.0])
}

/// Turns the view by the mouse.
pub(super) fn drag(page: &mut Page) -> Result<()> {
    let middle = middle(page)?;
    page.mouse("mouseMoved", middle, false)?;
    page.mouse("mousePressed", middle, true)?;
    for step in 1..=6 {
        page.mouse("mouseMoved", [middle[0] + 6.0 * f64::from(step), middle[1]], true)?;
    }
    page.mouse("mouseReleased", [middle[0] + 36.0, middle[1]], false)
}

/// Turns the view to and fro for some seconds, and until there are some pictures. Tells how many that gave.
pub(super) fn motion(page: &mut Page) -> Result<String> {
    /// A device may have to end a whole picture first, and a busy machine may take long for that.
    const SECONDS: [f64; 2] = [4.0, 120.0];
    const PICTURES: f64 = 3.0;
    let shown = |page: &mut Page| Ok::<f64, anyhow::Error>(state(page)?["pictures"].as_f64().unwrap_or_default());
    let middle = middle(page)?;
    page.mouse("mouseMoved", middle, false)?;
    page.mouse("mousePressed", middle, true)?;
    let (before, start) = (shown(page)?, Instant::now());
    let (mut step, mut pictures) = (0, 0.0);
    while start.elapsed().as_secs_f64() < SECONDS[0] || pictures < PICTURES {
        ensure!(start.elapsed().as_secs_f64() < SECONDS[1], "{pictures} pictures in {} s of motion", SECONDS[1]);
        step += 1;
        let turned = f64::from((step % 120 - 60_i32).abs() - 60) * 1.5;
        page.mouse("mouseMoved", [middle[0] + turned, middle[1]], true)?;
        std::thread::sleep(Duration::from_millis(15));
        pictures = shown(page)? - before;
    }
    let seconds = start.elapsed().as_secs_f64();
    page.mouse("mouseReleased", middle, false)?;
    Ok(format!("{:.1} pictures a second while the view turns", pictures / seconds))
}

/// Compares what is on the screen with what the library draws here. Returns the share of pixels that are off.
pub(super) fn matches_the_library(page: &mut Page, method: &str) -> Result<f64> {
    matches_with_settings(page, method, &Settings::new())
}

/// The same for a method with settings.
pub(super) fn matches_with_settings(page: &mut Page, method: &str, settings: &Settings) -> Result<f64> {
    let share = share_off(page, method, settings)?;
    if share > MOST_OFF {
        bail!("{:.2} % of the pixels of `{method}` are off", share * 100.0);
    }
    Ok(share)
}

/// The share of pixels on the screen that are off by more than 0.1 from what the library draws here.
pub(super) fn share_off(page: &mut Page, method: &str, settings: &Settings) -> Result<f64> {
    let shown = state(page)?;
    let camera = page.value("JSON.parse(catoptric.camera())")?;
    let [width, height] = [0, 1].map(|index| shown["size"][index].as_u64().unwrap_or_default() as u32);
    let expected = expected::drawn(method, settings, &camera, [width, height])?;
    let screen = page.screenshot()?;
    save(&screen, method)?;
    let screen = Picture::read(&screen)?;
    let [left, top] = [0, 1].map(|index| shown["rect"][index].as_f64().unwrap_or_default() as u32);
    let (mut off, mut all) = (0, 0);
    for y in LABELS..height {
        for x in 0..width {
            let (seen, wanted) = (screen.pixel(left + x, top + y), expected.pixel(x, y));
            off += usize::from(seen.iter().zip(wanted).any(|(a, b)| a.abs_diff(*b) > 25));
            all += 1;
        }
    }
    Ok(off as f64 / all.max(1) as f64)
}

/// Keeps a picture of the screen, if it is wanted.
pub(super) fn save(screen: &[u8], name: &str) -> Result<()> {
    if let Some(folder) = std::env::var_os("CATOPTRIC_SCREENSHOTS") {
        let path = Path::new(&folder).join(format!("page-{name}.png"));
        std::fs::write(path, screen).context("cannot save the screen")?;
    }
    Ok(())
}
