//! The report's page: one file that opens from disk, with its pictures beside it.

use super::plot::{self, Plot};
use super::{Entry, Measured, Outcome, Report};
use catoptric::metrics::{PictureError, heat_color};
use maud::{DOCTYPE, Markup, PreEscaped, html};
use plotters::style::RGBColor;

const STYLE: &str = include_str!("style.css");
const SCRIPT: &str = include_str!("script.js");

/// A column of the table: its heading, its value, how it is written.
type Column = (&'static str, fn(&Measured) -> Option<f64>, fn(f64) -> String);

/// The group of columns that has one more: what has drawn them.
const REFLECTORS: &str = "Reflectors";
const REFLECTOR_COLUMNS: [Column; 4] = [
    ("FLIP mean", |m| m.error.reflector.map(|e| e.flip_mean), four_digits),
    ("FLIP p99", |m| m.error.reflector.map(|e| e.flip_p99), four_digits),
    ("RMSE", |m| m.error.reflector.map(|e| e.rmse), four_digits),
    ("off by > 0.1", |m| m.error.reflector.map(|e| e.over_0_1), percent),
];
const PICTURE_COLUMNS: [Column; 2] = [
    ("FLIP mean", |m| m.error.image.map(|e| e.flip_mean), four_digits),
    ("RMSE", |m| m.error.image.map(|e| e.rmse), four_digits),
];
const PROJECTION_COLUMNS: [Column; 5] = [
    ("p50", |m| m.error.projection_px.as_ref()?.all.p50, four_digits),
    ("p99", |m| m.error.projection_px.as_ref()?.all.p99, four_digits),
    ("max", |m| m.error.projection_px.as_ref()?.all.max, four_digits),
    ("missing", |m| m.error.projection_px.as_ref().map(|error| error.all.missing), percent),
    ("invented", |m| m.error.projection_px.as_ref().map(|error| error.all.invented), percent),
];
const TIME_COLUMNS: [Column; 3] = [
    ("a frame", |m| Some(m.stats.frame_ms.median), milliseconds),
    ("first frame", |m| Some(m.stats.frame_ms.first), milliseconds),
    ("set-up", |m| Some(m.stats.setup_ms.0.iter().map(|(_, time)| time).sum()), milliseconds),
];

pub(super) fn page(report: &Report, plot: &Plot) -> Markup {
    let truth = &report.truth;
    html! {
        (DOCTYPE)
        html lang="en" {
            head {
                meta charset="utf-8";
                meta name="viewport" content="width=device-width, initial-scale=1";
                title { "catoptric: methods on " (truth.scene) }
                style { (PreEscaped(STYLE)) }
            }
            body {
                main {
                    h1 { "Methods on " (truth.scene) }
                    p.soft { "Each method drew the same view as the ray-traced reference and was measured against it." }
                    pre { (report.command) }
                    (facts(report))
                    h2 { "Error beside time" }
                    div.card.wide { (table(report)) }
                    p.soft {
                        "FLIP is the difference that people see when they flip between two pictures: 0 is none, 1 the \
                        largest. "
                        "RMSE is of linear values. “Off by > 0.1” is the share of pixels with an sRGB channel off by \
                        more than 0.1. "
                        "Projection is how far from a pixel's centre the method finds the point that the pixel shows \
                        in a mirror or "
                        "through glass; missing is the share of points that it does not find, invented that of answers "
                        "where the point does not appear. "
                        "Drawn by: the shares of the reflectors' pixels by what has drawn them: the method's own \
                        geometry, tiles (the method multiperspective), or rays, one by one; a pixel of which \
                        tiles have drawn any part counts as theirs. "
                        @if report.any_left_to_tiles() {
                            "Projection is measured on the paths that the method's own geometry has drawn, and on \
                            none where it has drawn none. "
                        }
                        "A frame is the median of the frames after the first; the first, a circle in the plot, makes "
                        "what later ones keep. "
                        "Reflectors are the pixels whose first surface is a reflector or a lens. A star marks the best \
                        method."
                    }
                    div.card.wide.plot { (PreEscaped(plot.inline())) }
                    h2 { "Pictures" }
                    (truth_card(report))
                    @for (index, entry) in report.entries.iter().enumerate() {
                        @if !entry.is_truth { (card(index, entry)) }
                    }
                }
                script { (PreEscaped(SCRIPT)) }
            }
        }
    }
}

fn facts(report: &Report) -> Markup {
    let truth = &report.truth;
    let [width, height] = truth.size;
    let share = report.reflector_pixels as f64 / (f64::from(width) * f64::from(height));
    let frames = match (truth.frames, truth.motion) {
        (1, _) => "1".to_owned(),
        (frames, "none") => format!("{frames}, times are medians after the first"),
        (frames, motion) => format!("{frames}, moving: {motion}; times are medians after the first"),
    };
    let facts = [
        ("Picture", format!("{width} × {height}")),
        ("Samples a pixel", truth.samples.to_string()),
        ("Highest order", truth.order.to_string()),
        ("Reflector pixels", percent(share)),
        ("Frames", frames),
        ("Machine", truth.device.clone()),
        ("Threads", truth.threads.to_string()),
        ("Version", truth.version.to_owned()),
    ];
    html! {
        dl.facts { @for (name, value) in facts { div { dt { (name) } dd { (value) } } } }
    }
}

fn table(report: &Report) -> Markup {
    // Times first: they are what narrow windows show beside the names.
    let mut groups: Vec<(&str, &[Column])> =
        vec![("Time, ms", &TIME_COLUMNS), (REFLECTORS, &REFLECTOR_COLUMNS), ("Whole picture", &PICTURE_COLUMNS)];
    if report.measured().any(|(_, measured)| measured.error.projection_px.is_some()) {
        groups.push(("Projection, pixels", &PROJECTION_COLUMNS));
    }
    let is_counted = report.measured().any(|(_, measured)| measured.stats.drawn_by.is_some());
    let has_words = |name: &str| is_counted && name == REFLECTORS;
    let width = groups.iter().map(|(_, columns)| columns.len()).sum::<usize>() + usize::from(is_counted);
    let reference_ms = report.truth.frame_ms.median;
    html! {
        table {
            thead {
                tr {
                    th {}
                    th.group {}
                    @for (name, columns) in &groups {
                        th.group colspan=(columns.len() + usize::from(has_words(name))) { (name) }
                    }
                }
                tr {
                    th { "Method" }
                    th.group { "Speed-up, first / later" }
                    @for (name, columns) in &groups {
                        @for (index, column) in columns.iter().enumerate() { th.group[index == 0] { (column.0) } }
                        @if has_words(name) { th { "drawn by" } }
                    }
                }
            }
            tbody {
                @for (index, entry) in report.entries.iter().enumerate() {
                    tr {
                        th { (dot(index)) a href={ "#" (anchor(index, entry)) } { (breakable(&entry.label)) } }
                        @match &entry.outcome {
                            Outcome::Measured(measured) => {
                                td.group { (speedup(reference_ms, measured)) }
                                @for (name, columns) in &groups {
                                    @for (index, column) in columns.iter().enumerate() {
                                        td.group[index == 0].best[is_best(report, entry, column)] {
                                            (column.1(measured).map_or("–".into(), column.2))
                                        }
                                    }
                                    @if has_words(name) {
                                        td { (measured.stats.drawn_by.map_or("–".into(), |by| by.words())) }
                                    }
                                }
                            }
                            Outcome::Failed(_) => { td colspan=(width + 1) style="text-align:left" {
                                "could not draw this scene, see below"
                            } }
                        }
                    }
                }
            }
        }
    }
}

/// True if no other method has a lower value. The reference does not compete, and a single method is not best.
fn is_best(report: &Report, entry: &Entry, column: &Column) -> bool {
    let competitors = || report.measured().filter(|(other, _)| !other.is_truth).map(|(_, measured)| measured);
    if entry.is_truth || competitors().count() < 2 {
        return false;
    }
    let lowest = competitors().filter_map(column.1).fold(f64::INFINITY, f64::min);
    match &entry.outcome {
        Outcome::Measured(measured) => column.1(measured).is_some_and(|value| value <= lowest),
        Outcome::Failed(_) => false,
    }
}

fn truth_card(report: &Report) -> Markup {
    let compared = report.entries.iter().position(|entry| entry.is_truth);
    html! {
        section.card id=[compared.map(|index| anchor(index, &report.entries[index]))] {
            h3 { "The reference" }
            p.soft { "Ray-traced; " (milliseconds(report.truth.frame_ms.median)) " ms a frame." }
            div.figures.one { figure { div.frame { img src="reference.png" alt="The scene, ray-traced"; } } }
            @if let Some(Outcome::Measured(measured)) = compared.map(|index| &report.entries[index].outcome) {
                (details(measured))
            }
        }
    }
}

fn card(index: usize, entry: &Entry) -> Markup {
    html! {
        section.card id=(anchor(index, entry)) {
            h3 { (dot(index)) (entry.label) }
            p.soft { (entry.info.summary) }
            p.soft { "Paper: " (entry.info.paper) ". Assumes " (entry.info.assumptions) "." }
            @match &entry.outcome {
                Outcome::Failed(problem) => { p.note { "Could not draw this scene: " (problem) } }
                Outcome::Measured(measured) => {
                    div.figures {
                        (slider(entry, measured))
                        @if let Some(flip) = &measured.flip { (heat_map(entry, measured, flip)) }
                    }
                    @if is_by_tiles(measured) {
                        p.note {
                            "Over half of the reflectors is drawn by tiles and rays (the method multiperspective), not \
                            by this method: "
                            (measured.stats.drawn_by.map_or_else(String::new, |by| by.words()))
                        }
                    }
                    @if let Some(chosen) = measured.stats.chosen() { p.note { "reflectors: " (chosen) } }
                    @if let Some(noise) = measured.stats.noise {
                        p.note { "standard error of a pixel by sampling: " (format!("{noise:.4}")) }
                    }
                    @for warning in &measured.stats.warnings { p.note { (warning) } }
                    @for (name, count) in measured.stats.counts.fallbacks.iter().filter(|(_, count)| **count > 0) {
                        p.note { "Could not be done as it should: " (name.replace('_', " ")) ", " (grouped(*count)) " \
                            times" }
                    }
                    (details(measured))
                }
            }
        }
    }
}

/// True if tiles, and rays at their rims, have drawn over half of the reflectors' pixels in the method's place.
fn is_by_tiles(measured: &Measured) -> bool {
    measured.stats.share_left_to_tiles() > 0.5
}

fn slider(entry: &Entry, measured: &Measured) -> Markup {
    html! {
        figure {
            div.frame.slider {
                img src="reference.png" alt="The reference";
                img.over src=(measured.picture) alt={ "Drawn by " (entry.label) };
                span.tag.left { (entry.label) @if is_by_tiles(measured) { ", mostly by tiles" } }
                span.tag.right { "reference" }
                input type="range" min="0" max="100" step="0.5" value="50"
                    aria-label={ "How much of the picture " (entry.label) " shows, the reference shows the rest" };
            }
            figcaption {
                span { "Drag to compare" }
                span { a href=(measured.picture) { "method" } " · " a href="reference.png" { "reference" } }
            }
        }
    }
}

fn heat_map(entry: &Entry, measured: &Measured, flip: &str) -> Markup {
    let mean = |error: Option<PictureError>| error.map_or("none".into(), |error| four_digits(error.flip_mean));
    let stops: Vec<String> = (0..=8)
        .map(|step| {
            let [r, g, b] = heat_color(step as f32 / 8.0);
            format!("rgb({r} {g} {b})")
        })
        .collect();
    html! {
        figure {
            div.frame { img src=(flip) alt={ "Where " (entry.label) " differs from the reference" }; }
            figcaption {
                span {
                    "FLIP: 0" span.scale style={ "background:linear-gradient(90deg," (stops.join(",")) ")" } {} "1"
                }
                span { "reflectors " (mean(measured.error.reflector)) ", picture " (mean(measured.error.image)) }
            }
        }
    }
}

fn details(measured: &Measured) -> Markup {
    let stats = &measured.stats;
    let times = |times: &[(String, f64)]| -> Vec<(String, String)> {
        times.iter().map(|(name, time)| (name.clone(), format!("{} ms", milliseconds(*time)))).collect()
    };
    let counted = |counts: &std::collections::BTreeMap<String, u64>| -> Vec<(String, String)> {
        counts.iter().map(|(name, count)| (name.replace('_', " "), grouped(*count))).collect()
    };
    let settings = stats
        .settings
        .iter()
        .map(|(name, value)| (name.clone(), value.as_str().map_or_else(|| value.to_string(), ToOwned::to_owned)));
    let frame = vec![
        ("first".to_owned(), format!("{} ms", milliseconds(stats.frame_ms.first))),
        ("median".to_owned(), format!("{} ms", milliseconds(stats.frame_ms.median))),
        ("fastest".to_owned(), format!("{} ms", milliseconds(stats.frame_ms.min))),
        ("slowest".to_owned(), format!("{} ms", milliseconds(stats.frame_ms.max))),
    ];
    let lists = [
        ("Settings", settings.collect()),
        ("A frame", frame),
        ("Stages of a frame", times(&stats.stages_ms.0)),
        ("Set-up, once", times(&stats.setup_ms.0)),
        ("Counts", counted(&stats.counts.named)),
        ("Fallbacks", counted(&stats.counts.fallbacks)),
        ("Memory, bytes", counted(&stats.bytes)),
    ];
    html! {
        details {
            summary { "Settings, times and counts" }
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
}

/// A label that may go on in the next line after its punctuation.
fn breakable(label: &str) -> Markup {
    html! { @for part in label.split_inclusive([':', ',', '_']) { (part) wbr; } }
}

fn anchor(index: usize, entry: &Entry) -> String {
    format!("m{index}-{}", entry.info.id)
}

fn dot(index: usize) -> Markup {
    let RGBColor(r, g, b) = plot::color(index);
    html! { span.dot style={ "--dot:rgb(" (r) " " (g) " " (b) ")" } {} }
}

/// How many times shorter the first frame and those after it are than the reference's.
fn speedup(reference_ms: f64, measured: &Measured) -> String {
    let times = |own: f64| if own > 0.0 { format!("{:.2}×", reference_ms / own) } else { "–".into() };
    format!("{} / {}", times(measured.stats.frame_ms.first), times(measured.stats.frame_ms.median))
}

fn four_digits(value: f64) -> String {
    if value.is_finite() { format!("{value:.4}") } else { "∞".into() }
}

fn percent(share: f64) -> String {
    format!("{:.2} %", share * 100.0)
}

fn milliseconds(value: f64) -> String {
    match value {
        value if value >= 100.0 => format!("{value:.0}"),
        value if value >= 1.0 => format!("{value:.1}"),
        value => format!("{value:.3}"),
    }
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
        assert_eq!(milliseconds(1234.5), "1234");
        assert_eq!(milliseconds(0.01), "0.010");
        assert_eq!(four_digits(f64::INFINITY), "∞");
    }
}
