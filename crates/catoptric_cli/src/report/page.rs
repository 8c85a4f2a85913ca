//! The report's page: one file, with its pictures inside.

use super::content::{Entry, Outcome, Reference, Report};
use super::plot::Plot;
use super::table::{self, Column, Row, columns, percent, rows};
use super::{gallery, markers};
use maud::{DOCTYPE, Markup, PreEscaped, html};

const STYLE: &str = include_str!("style.css");
const SCRIPT: &str = include_str!("script.js");

pub(super) fn page(report: &Report, plot: &Plot) -> Markup {
    let scene = report.any_run().map_or("", |run| run.scene.as_str());
    html! {
        (DOCTYPE)
        html lang="en" {
            head {
                meta charset="utf-8";
                meta name="viewport" content="width=device-width, initial-scale=1";
                title { "catoptric: methods on " (scene) }
                style { (PreEscaped(STYLE)) }
            }
            body.with-crop[report.crop.is_some()] {
                main {
                    h1 { "Methods on " (scene) }
                    p.soft {
                        @match &report.reference {
                            Reference::Traced(_) => {
                                "Each method drew the same view as the ray-traced reference and was measured \
                                against it."
                            }
                            Reference::File(name) => {
                                "Each method drew the same view and was measured against the picture " b { (name) } ", \
                                which another program has drawn."
                            }
                        }
                    }
                    pre { (report.command) }
                    (facts(report))
                    @for warning in report.warnings_of_all() { p.note { (warning) } }
                    h2 { "Error beside time" }
                    div.card.wide { (table(report)) }
                    div.explained {
                        (legend(report))
                        div.card.wide.plot { (PreEscaped(plot.inline())) }
                    }
                    (gallery::gallery(report))
                }
                script { (PreEscaped(SCRIPT)) }
            }
        }
    }
}

fn facts(report: &Report) -> Markup {
    let Some(run) = report.any_run() else { return html! {} };
    let [width, height] = run.size;
    let share = report.reflector_pixels as f64 / (f64::from(width) * f64::from(height));
    let frames = match (run.frames, run.motion) {
        (1, _) => "1".to_owned(),
        (frames, "none") => format!("{frames}, times are medians after the first"),
        (frames, motion) => format!("{frames}, moving: {motion}; times are medians after the first"),
    };
    let reference = match &report.reference {
        Reference::Traced(_) => "ray-traced by catoptric".to_owned(),
        Reference::File(name) => name.clone(),
    };
    let facts = [
        ("Reference", reference),
        ("Picture", format!("{width} × {height}")),
        ("Samples a pixel", run.samples.to_string()),
        ("Highest order", run.order.to_string()),
        ("Reflector pixels", percent(share)),
        ("Frames", frames),
        ("Machine", run.device.clone()),
        ("Threads", run.threads.to_string()),
        ("Version", run.version.to_owned()),
    ];
    html! {
        dl.facts { @for (name, value) in facts { div { dt { (name) } dd { (value) } } } }
    }
}

/// Columns of one group.
type Group = (&'static str, Vec<&'static Column>);

fn groups(report: &Report) -> Vec<Group> {
    let mut groups: Vec<Group> = Vec::new();
    for column in columns(report) {
        match groups.last_mut() {
            Some((name, columns)) if *name == column.group => columns.push(column),
            _ => groups.push((column.group, vec![column])),
        }
    }
    groups
}

fn table(report: &Report) -> Markup {
    let groups = groups(report);
    let width = groups.iter().map(|(_, columns)| columns.len()).sum::<usize>();
    html! {
        table {
            thead {
                tr {
                    th {}
                    @for (name, columns) in &groups { th.group colspan=(columns.len()) scope="colgroup" { (name) } }
                }
                tr {
                    th scope="col" { "Method" }
                    @for (_, columns) in &groups {
                        @for (index, column) in columns.iter().enumerate() {
                            th.group[index == 0] scope="col" { (column.heading) }
                        }
                    }
                }
            }
            tbody {
                @for row in rows(report) {
                    tr.truth[row.entry.is_truth] {
                        th scope="row" { (name(&row)) }
                        @match &row.entry.outcome {
                            Outcome::Measured(_) => { (cells(report, row.entry, &groups)) }
                            Outcome::Failed(_) => {
                                td.failed colspan=(width) { "could not draw this scene, see below" }
                            }
                        }
                    }
                }
            }
        }
    }
}

fn name(row: &Row<'_>) -> Markup {
    let unusable = row.entry.measured().and_then(|measured| measured.unusable);
    html! {
        @if let Some(number) = row.number { (PreEscaped(markers::inline(number))) }
        a href={ "#" (gallery::anchor(row.number)) } { (breakable(&row.entry.label)) }
        @if let Some(reason) = unusable { span.unusable { " " (reason) } }
    }
}

fn cells(report: &Report, entry: &Entry, groups: &[Group]) -> Markup {
    html! {
        @for (group, columns) in groups {
            @for (index, column) in columns.iter().enumerate() {
                @let is_empty = column.value(report, entry).is_none();
                td.group[index == 0].best[column.is_best(report, entry)].words[column.is_words()].none[is_empty]
                    data-name={ (group) ": " (column.heading) } { (column.text(report, entry)) }
            }
        }
    }
}

/// A line for each column.
fn legend(report: &Report) -> Markup {
    let has_stars = rows(report).iter().any(|row| columns(report).iter().any(|it| it.is_best(report, row.entry)));
    html! {
        dl.legend {
            @for (group, columns) in groups(report) {
                div {
                    @for column in columns { div { dt { (group) ": " (column.heading) } dd { (column.line) } } }
                }
            }
            div {
                @if has_stars { div { dt { "★" } dd { (table::line_of_stars(report)) } } }
                @if report.any_left_to_tiles() {
                    div {
                        dt { "–" }
                        dd {
                            "Projection is measured on the paths that the method's own geometry has drawn, and on \
                            none where it has drawn none."
                        }
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
