//! Settings, by links and by hand.

use super::expected::Settings;
use super::viewer::{MOST_OFF, SIZE, STATE, matches_with_settings, save, share_off};
use crate::web::chromium::{Graphics, Page};
use anyhow::{Context, Result, bail, ensure};
use serde_json::{Value, json};
use std::time::Duration;

/// The method whose settings are changed.
const METHOD: &str = "environment_map";

/// The middle of the panels, where the wheel scrolls them.
const PANELS: [f64; 2] = [150.0, 350.0];

/// Lowest points at which widgets are clicked: below is the line of the state.
const LOWEST: f64 = SIZE[1] as f64 - 60.0;

/// Settings come by a link, and are changed by the mouse on the widgets of the panel.
pub(super) fn change(base: &str) -> Result<()> {
    let mut page = Page::open(Graphics::WebGl, SIZE)?;
    page.visit(&format!("{base}?scene=builtin:sphere_room&method={METHOD}&set=capture_samples=1&set=size=64"))?;
    let mut settings = Settings::from([("capture_samples", json!(1)), ("size", json!(64))]);
    shows(&mut page, &settings)?;
    matches_with_settings(&mut page, METHOD, &settings)?;
    ensure!(share_off(&mut page, METHOD, &Settings::new())? > MOST_OFF, "the settings of the link change nothing");
    println!("ok: settings: a link has them");
    click(&mut page, "DisclosureTriangle", "Settings", "")?;
    // A list, and a value in it.
    open_list(&mut page, "parallax", "none", "box")?;
    click(&mut page, "Button", "box", "")?;
    let before = settings.clone();
    settings.insert("parallax", json!("box"));
    shows(&mut page, &settings)?;
    matches_with_settings(&mut page, METHOD, &settings)?;
    ensure!(share_off(&mut page, METHOD, &before)? > MOST_OFF, "another parallax changes nothing");
    println!("ok: settings: the mouse chooses another value from a list, and it is drawn");
    // A number that is typed, then what the method has of itself.
    click(&mut page, "SpinButton", "size", "64")?;
    // Letters go to the element that takes them for the window, once a text is edited.
    page.wait_for("document.activeElement?.tagName === 'INPUT'")?;
    page.wait_for("new Promise(done => requestAnimationFrame(() => requestAnimationFrame(() => done(true))))")?;
    page.write("8")?;
    page.key("Enter")?;
    settings.insert("size", json!(8));
    shows(&mut page, &settings)?;
    matches_with_settings(&mut page, METHOD, &settings)?;
    save(&page.screenshot()?, "settings")?;
    println!("ok: settings: a number is typed, and drawn");
    ensure!(page.complaints.is_empty(), "the page complains: {:?}", page.complaints);
    page.visit(&format!("{base}?scene=builtin:sphere_room&method={METHOD}&set=paralax=box"))?;
    page.wait_for("document.getElementById('words')?.textContent.includes('there is no setting `paralax`')")?;
    println!("ok: settings: those that do not exist are told in words");
    Ok(())
}

/// Waits until the page shows the method with these settings and no others.
fn shows(page: &mut Page, settings: &Settings) -> Result<()> {
    let wanted = serde_json::to_string(settings)?;
    let sorted = |object: &str| format!("JSON.stringify(Object.entries({object}).sort())");
    let (shown, wanted) = (sorted("state.settings"), sorted(&wanted));
    page.wait_for(&format!(
        "typeof catoptric === 'object' && (state => state.sharp && state.method === '{METHOD}' && {shown} === \
         {wanted})({STATE})"
    ))
}

/// Clicks a widget once it is there.
fn click(page: &mut Page, role: &str, label: &str, value: &str) -> Result<()> {
    let middle = widget(page, role, label, value)?;
    page.click(middle)
}

/// Opens a list until a value is there to be clicked: a list that was opened in a frame in which the panels moved is
/// closed by that.
fn open_list(page: &mut Page, label: &str, value: &str, wanted: &str) -> Result<()> {
    for _ in 0..10 {
        click(page, "ComboBox", label, value)?;
        for _ in 0..15 {
            if page.value(&found("Button", wanted, ""))?.is_array() {
                return Ok(());
            }
            std::thread::sleep(Duration::from_millis(200));
        }
    }
    bail!("the list `{label}` does not open")
}

/// JavaScript that finds the rectangle of a widget.
fn found(role: &str, label: &str, value: &str) -> String {
    format!(
        "JSON.parse(catoptric.widgets()).find(widget => widget.role === '{role}' && widget.label === '{label}' && \
         widget.value.startsWith('{value}'))?.rect"
    )
}

/// The middle of a widget, once it is there and rests, scrolled to where it is seen.
fn widget(page: &mut Page, role: &str, label: &str, value: &str) -> Result<[f64; 2]> {
    let find = found(role, label, value);
    page.wait_for(&format!("{find} !== undefined")).with_context(|| {
        let names = "JSON.parse(catoptric.widgets()).map(({ role, label, value }) => [role, label, value].join(' '))";
        let all = page.value(names).unwrap_or_default();
        format!("there is no {role} `{label}` with `{value}`, but {all}")
    })?;
    let mut last = Value::Null;
    loop {
        let rect = page.value(&find)?;
        let number = |index: usize| rect[index].as_f64().context("a widget has gone");
        let middle = [number(0)? + number(2)? / 2.0, number(1)? + number(3)? / 2.0];
        if rect == last && middle[1] < LOWEST {
            return Ok(middle);
        }
        if rect == last {
            page.wheel(PANELS, middle[1] - LOWEST + 20.0)?;
        }
        last = rect;
        std::thread::sleep(Duration::from_millis(200));
    }
}
