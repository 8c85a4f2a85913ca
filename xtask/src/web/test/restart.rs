//! Workers that end or fail: another one goes on.

use super::expected::Settings;
use super::viewer::{SHARP, SIZE, STATE, drag, matches_the_library, matches_with_settings, save, state};
use crate::web::chromium::{Graphics, Page};
use anyhow::{Result, ensure};
use serde_json::json;

/// Ends a worker as browsers do that want its memory: the page is told nothing.
const END: &str = "setTimeout(() => close()); undefined";

/// The words for a worker that has ended in this way.
const ENDED: &str = "drawing has failed and was started again: the browser has ended the worker";

/// A worker is ended, another one fails at its work; then they end until no other is started.
pub(super) fn go_on(base: &str) -> Result<()> {
    let mut page = Page::open(Graphics::WebGl, SIZE)?;
    let settings = Settings::from([("size", json!(64))]);
    page.visit(&format!("{base}?scene=builtin:sphere_room&method=environment_map&set=size=64"))?;
    page.wait_for(SHARP)?;
    turn(&mut page)?;
    let eye = state(&mut page)?["eye"].clone();
    page.in_worker(END)?;
    wait_until_told(&mut page, ENDED, 1)?;
    page.wait_for(SHARP)?;
    ensure!(state(&mut page)?["eye"] == eye, "another worker has changed the view");
    matches_with_settings(&mut page, "environment_map", &settings)?;
    save(&page.screenshot()?, "restarted")?;
    println!("ok: a worker that the browser ends is started again and shows the same");
    turn(&mut page)?;
    matches_with_settings(&mut page, "environment_map", &settings)?;
    page.in_worker("performance.now = () => { throw new Error('the clock is broken'); }; undefined")?;
    drag(&mut page)?;
    wait_until_told(&mut page, "the clock is broken", 1)?;
    page.wait_for(SHARP)?;
    matches_with_settings(&mut page, "environment_map", &settings)?;
    println!("ok: a worker that fails at its work is started again and draws what was wanted of it");
    // The third and the fourth within a minute; on slow machines it may be more.
    let stopped = format!("{STATE}.messages.some(message => message.includes('drawing has stopped'))");
    for time in 2..=6 {
        page.in_worker(END)?;
        page.wait_for(&format!("{stopped} || {}", is_told(ENDED, time)))?;
        if page.value(&stopped)? == true {
            ensure!(time > 2, "it has stopped after two failures");
            save(&page.screenshot()?, "stopped")?;
            println!("ok: workers that go on ending are not started for ever");
            ensure!(page.complaints.is_empty(), "the page complains: {:?}", page.complaints);
            return Ok(());
        }
        page.wait_for(SHARP)?;
    }
    anyhow::bail!("workers are started for ever")
}

/// A worker that draws by WebGPU is ended: the next one draws by the CPU.
pub(super) fn go_on_without_device(base: &str) -> Result<()> {
    let mut page = Page::open(Graphics::WebGpu, SIZE)?;
    page.visit(&format!("{base}?scene=builtin:sphere_room&method=environment_map&processor=gpu"))?;
    page.wait_for(&format!(
        "typeof catoptric === 'object' && (state => state.sharp && /WebGPU/.test(state.processor))({STATE})"
    ))?;
    page.in_worker(END)?;
    wait_until_told(&mut page, ENDED, 1)?;
    page.wait_for(&format!(
        "(state => state.sharp && /CPU/.test(state.processor) && state.remark.includes('not used again'))({STATE})"
    ))?;
    matches_the_library(&mut page, "environment_map")?;
    ensure!(page.complaints.is_empty(), "the page complains: {:?}", page.complaints);
    println!("ok: by WebGPU: after a worker has ended the CPU draws");
    Ok(())
}

/// Turns the view, and waits until it is drawn.
fn turn(page: &mut Page) -> Result<()> {
    let eye = state(page)?["eye"].clone();
    drag(page)?;
    page.wait_for(&format!("(state => state.sharp && JSON.stringify(state.eye) !== '{eye}')({STATE})"))
}

/// True once the user was told these words as often.
fn is_told(words: &str, times: usize) -> String {
    format!("{STATE}.messages.filter(message => message.includes('{words}')).length >= {times}")
}

fn wait_until_told(page: &mut Page, words: &str, times: usize) -> Result<()> {
    page.wait_for(&is_told(words, times))
}
