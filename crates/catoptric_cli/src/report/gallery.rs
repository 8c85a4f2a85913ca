//! The pictures of a report's page: the reference and all methods, side by side.

use super::content::{Crop, Entry, Measured, Outcome, Pictures, Reference, Report};
use super::markers;
use super::table::milliseconds;
use base64::Engine;
use base64::prelude::BASE64_STANDARD;
use catoptric::metrics::heat_color;
use maud::{Markup, PreEscaped, html};
use std::collections::BTreeMap;
use std::fmt::Write;

/// The colours of errors that the page's script knows.
const HEAT_COLORS: u32 = 256;
const KEYS: &str = "Wheel, pinch or + and − zoom, dragging or the arrows move, 0 shows all: in all pictures alike. R \
    shows the reference in their place (hold it, or press it again), H where they differ from it. Point at a pixel for \
    its values.";

pub(super) fn gallery(report: &Report) -> Markup {
    let size = report.any_run().map_or([1, 1], |run| run.size);
    html! {
        h2.pictures { "Pictures" }
        section.gallery style={ "--ratio:" (size[0]) "/" (size[1]) } data-width=(size[0]) data-height=(size[1])
            data-heat=(heat_table()) {
            div.tools role="toolbar" aria-label="All pictures" {
                button type="button" data-do="in" title="Zoom in (+)" aria-label="Zoom in" { "+" }
                button type="button" data-do="out" title="Zoom out (−)" aria-label="Zoom out" { "−" }
                button type="button" data-do="whole" title="Show all (0)" { "Whole " kbd { "0" } }
                button type="button" data-do="reference" aria-pressed="false" { "Reference " kbd { "R" } }
                button type="button" data-do="heat" aria-pressed="false" { "Differences " kbd { "H" } }
                output.at {}
            }
            p.soft.keys { (KEYS) }
            div.views {
                (reference(report))
                @for (number, entry) in report.methods() { (view(report, number, entry)) }
            }
            p.soft.flip-scale { "Differences, FLIP: 0" (scale()) "1" }
        }
        @if let Some(crop) = &report.crop { (crops(report, crop)) }
    }
}

/// The place of a method's picture in the page; `None` stands for the reference.
pub(super) fn anchor(number: Option<usize>) -> String {
    number.map_or_else(|| "reference".into(), |number| format!("method-{number}"))
}

fn reference(report: &Report) -> Markup {
    let truth = report.entries.iter().find(|entry| entry.is_truth).and_then(Entry::measured);
    let (name, about) = match &report.reference {
        Reference::Traced(stats) => ("reference", format!("ray-traced, {} ms", milliseconds(stats.frame_ms.median))),
        Reference::File(name) => (name.as_str(), "all are measured against it".into()),
    };
    html! {
        figure.card id=(anchor(None)) {
            div.head { h3 { (name) } span.soft { (about) } }
            div.view.of-reference tabindex="0" role="group" aria-label="The reference" {
                img.own src=(data_uri(&report.picture)) alt="The reference";
                span.tag { (name) }
                i.cross {}
            }
            output.value {}
            @if let Some(measured) = truth { details { summary { "Times and counts" } (lists(measured)) } }
        }
    }
}

fn view(report: &Report, number: usize, entry: &Entry) -> Markup {
    html! {
        figure.card id=(anchor(Some(number))) {
            div.head {
                h3 { (PreEscaped(markers::inline(number))) (entry.label) }
                @if let Some(measured) = entry.measured() { span.soft { (in_short(measured)) } }
            }
            @match &entry.outcome {
                Outcome::Failed(problem) => { p.note { "Could not draw this scene: " (problem) } }
                Outcome::Measured(measured) => {
                    @if let Some(pictures) = &measured.pictures { (layers(entry, measured, pictures)) }
                    (remarks(report, measured))
                }
            }
            details {
                summary { "About, times and counts" }
                p { (entry.info.summary) }
                p.soft { "Paper: " (entry.info.paper) ". Assumes " (entry.info.assumptions) "." }
                @if let Some(measured) = entry.measured() { (lists(measured)) }
            }
        }
    }
}

fn in_short(measured: &Measured) -> String {
    let error = measured.ranking_error().map(|error| format!(", FLIP {error:.4}"));
    format!("{} ms{}", milliseconds(measured.stats.frame_ms.median), error.unwrap_or_default())
}

fn layers(entry: &Entry, measured: &Measured, pictures: &Pictures) -> Markup {
    let tiles = if is_by_tiles(measured) { ", mostly by tiles" } else { "" };
    html! {
        div.view tabindex="0" role="group" aria-label={ "Drawn by " (entry.label) } {
            img.under alt="";
            div.cut { img.own src=(data_uri(&pictures.picture)) alt={ "Drawn by " (entry.label) }; }
            img.heat src=(data_uri(&pictures.flip)) alt={ "Where " (entry.label) " differs from the reference" };
            span.tag data-own={ (entry.label) (tiles) } { (entry.label) (tiles) }
            i.cross {}
        }
        output.value {}
        div.under-view {
            label { "Reference" input type="range" min="0" max="100" step="0.5" value="0"
                aria-label={ "How much of the picture shows the reference, the rest " (entry.label) }; }
            button type="button" data-do="own-heat" aria-pressed="false"
                aria-label={ "Where " (entry.label) " differs from the reference" } { "Differences" }
        }
    }
}

fn remarks(report: &Report, measured: &Measured) -> Markup {
    let stats = &measured.stats;
    let fallbacks: Vec<String> = stats
        .counts
        .fallbacks
        .iter()
        .filter(|(_, count)| **count > 0)
        .map(|(name, count)| format!("{} {}", name.replace('_', " "), grouped(*count)))
        .collect();
    let of_all = report.warnings_of_all();
    let own = stats.warnings.iter().filter(|text| !of_all.contains(&text.as_str()));
    html! {
        @if let Some(reason) = measured.unusable { p.note { "Not usable: " (reason) } }
        @for warning in own { p.note { (warning) } }
        @if is_by_tiles(measured) {
            p.info {
                "Over half of the reflectors is drawn by tiles and rays (the method multiperspective), not by this \
                method: " (stats.drawn_by.map_or_else(String::new, |by| by.words()))
            }
        }
        @if let Some(chosen) = stats.chosen() { p.info { "Reflectors: " (chosen) } }
        @if let Some(noise) = stats.noise {
            p.info { "Standard error of a pixel by sampling: " (format!("{noise:.4}")) }
        }
        @if !fallbacks.is_empty() { p.info { "Exceptions, counted: " (fallbacks.join(", ")) } }
    }
}

/// True if tiles, and rays at their rims, have drawn over half of the reflectors' pixels in the method's place.
fn is_by_tiles(measured: &Measured) -> bool {
    measured.stats.share_left_to_tiles() > 0.5
}

fn crops(report: &Report, crop: &Crop) -> Markup {
    let ([x, y], [width, height]) = (crop.region.corner, crop.region.size);
    let name = match &report.reference {
        Reference::Traced(_) => "reference",
        Reference::File(name) => name,
    };
    let own = |entry: &Entry| entry.measured()?.pictures.as_ref()?.crop.as_deref().map(data_uri);
    html! {
        section.crop style={ "--ratio:" (width) "/" (height) } {
            h2 { "Crop" }
            p.soft.keys { (width) " × " (height) " pixels from " (x) ", " (y) " of each picture" }
            div.crops {
                figure { img src=(data_uri(&crop.picture)) alt="Crop of the reference"; figcaption { (name) } }
                @for (number, entry) in report.methods() {
                    @if let Some(picture) = own(entry) {
                        figure {
                            img src=(picture) alt={ "Crop of " (entry.label) };
                            figcaption { (PreEscaped(markers::inline(number))) (entry.label) }
                        }
                    }
                }
            }
        }
    }
}

fn lists(measured: &Measured) -> Markup {
    let stats = &measured.stats;
    let times = |times: &[(String, f64)]| -> Vec<(String, String)> {
        times.iter().map(|(name, time)| (name.clone(), format!("{} ms", milliseconds(*time)))).collect()
    };
    let counted = |counts: &BTreeMap<String, u64>| -> Vec<(String, String)> {
        counts.iter().map(|(name, count)| (name.replace('_', " "), grouped(*count))).collect()
    };
    let settings = stats
        .settings
        .iter()
        .map(|(name, value)| (name.clone(), value.as_str().map_or_else(|| value.to_string(), ToOwned::to_owned)));
    let frame = [
        ("first", stats.frame_ms.first),
        ("median", stats.frame_ms.median),
        ("fastest", stats.frame_ms.min),
        ("slowest", stats.frame_ms.max),
    ];
    let lists = [
        ("Settings", settings.collect()),
        ("A frame", times(&frame.map(|(name, time)| (name.to_owned(), time)))),
        ("Stages of a frame", times(&stats.stages_ms.0)),
        ("Set-up, once", times(&stats.setup_ms.0)),
        ("Counts", counted(&stats.counts.named)),
        ("Exceptions", counted(&stats.counts.fallbacks)),
        ("Memory, bytes", counted(&stats.bytes)),
    ];
    html! {
        div.lists {
            @for (title, rows) in lists.iter().filter(|list: &&(&str, Vec<(String, String)>)| !list.1.is_empty()) {
                div {
                    h4 { (title) }
                    ul { @for (name, value) in rows { li { span { (name) } span { (value) } } } }
                }
            }
        }
    }
}

/// The colours of errors from 0 to 1, six hexadecimal digits each.
fn heat_table() -> String {
    let mut table = String::new();
    for step in 0..HEAT_COLORS {
        let [r, g, b] = heat_color(step as f32 / (HEAT_COLORS - 1) as f32);
        // Writing into a text does not fail.
        let _ = write!(table, "{r:02x}{g:02x}{b:02x}");
    }
    table
}

fn scale() -> Markup {
    let stops: Vec<String> = (0..=8)
        .map(|step| {
            let [r, g, b] = heat_color(step as f32 / 8.0);
            format!("rgb({r} {g} {b})")
        })
        .collect();
    html! { span.scale style={ "background:linear-gradient(90deg," (stops.join(",")) ")" } {} }
}

fn data_uri(png: impl AsRef<[u8]>) -> String {
    format!("data:image/png;base64,{}", BASE64_STANDARD.encode(png))
}

/// A whole number in groups of three digits.
fn grouped(count: u64) -> String {
    let digits = count.to_string();
    let mut text = String::new();
    for (index, digit) in digits.chars().enumerate() {
        if index > 0 && (digits.len() - index).is_multiple_of(3) {
            text.push('\u{202f}');
        }
        text.push(digit);
    }
    text
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn numbers_are_legible() {
        assert_eq!(grouped(0), "0");
        assert_eq!(grouped(1_234_567), "1\u{202f}234\u{202f}567");
    }
}
