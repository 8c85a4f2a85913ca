//! Error against time, as SVG.

use super::content::{Entry, Report};
use super::markers;
use crate::failure::Failure;
use plotters::coord::combinators::IntoLogRange;
use plotters::prelude::*;
use plotters::style::text_anchor::{HPos, Pos, VPos};

const SIZE_PX: (u32, u32) = (860, 420);
const LABEL_PX: i32 = 15;
const CHARACTER_PX: i32 = 7;
/// From the middle of a mark to its edge.
const MARK_PX: i32 = 8;
/// The place of a mark before a label.
const OWN_MARK_PX: i32 = 15;
/// A plot whose lines and letters take the colour of the text around it.
pub(super) struct Plot {
    svg: String,
}

struct Point {
    label: String,
    /// The method's number, for its colour and shape.
    number: usize,
    time_ms: f64,
    first_ms: f64,
    error: f64,
}

impl Plot {
    /// For use inside a page.
    pub(super) fn inline(&self) -> &str {
        &self.svg
    }

    /// As a file of its own, dark on white.
    pub(super) fn standalone(&self) -> String {
        self.svg.replacen("<svg ", "<svg style=\"color:#222;background:#fff\" ", 1)
    }
}

/// Mean FLIP against the time of a frame, both logarithmic: a filled mark for the median, an empty one for the first
/// frame. The time of the reference is a dashed line.
pub(super) fn error_against_time(report: &Report) -> Result<Plot, Failure> {
    let point = |(number, entry): (usize, &Entry)| {
        let measured = entry.measured()?;
        Some(Point {
            label: entry.label.clone(),
            number,
            time_ms: measured.stats.frame_ms.median.max(1e-3),
            first_ms: measured.stats.frame_ms.first.max(1e-3),
            error: measured.ranking_error()?,
        })
    };
    let points: Vec<Point> = report.methods().filter_map(point).collect();
    let reference_ms = report.reference_ms().map(|time| time.max(1e-3));
    let mut svg = String::new();
    draw(&mut svg, &points, reference_ms, report.reflector_pixels > 0)
        .map_err(|error| Failure::input(format!("the plot cannot be drawn: {error}")))?;
    Ok(Plot { svg: svg.replace("#000000", "currentColor") })
}

fn draw(
    svg: &mut String,
    points: &[Point],
    reference_ms: Option<f64>,
    reflectors: bool,
) -> Result<(), DrawingAreaErrorKind<std::io::Error>> {
    let times = || points.iter().flat_map(|point| [point.time_ms, point.first_ms]).chain(reference_ms);
    let errors = || points.iter().map(|point| point.error).filter(|error| *error > 0.0);
    let (first, last) = (times().fold(f64::INFINITY, f64::min), times().fold(0.0, f64::max));
    let (first, last) = if last > 0.0 { (first, last) } else { (1.0, 1.0) };
    // Errors of 0 have no place on a logarithmic axis; they are drawn near its lower end.
    let lowest = errors().fold(0.02, f64::min) * 0.4;
    let (bottom, top) = (0.6 * lowest, errors().fold(0.1, f64::max) * 1.6);
    let (left, right) = (0.5 * first, 2.0 * last);
    let root = SVGBackend::with_string(svg, SIZE_PX).into_drawing_area();
    let mut chart = ChartBuilder::on(&root)
        .margin(12)
        .margin_right(24)
        .x_label_area_size(46)
        .y_label_area_size(74)
        .build_cartesian_2d((left..right).log_scale(), (bottom..top).log_scale())?;
    let what = if reflectors { "mean FLIP on reflectors" } else { "mean FLIP" };
    let text = |size: i32| ("sans-serif", size).into_font().color(&BLACK);
    // The axes' own ticks are powers of ten alone: too few for ranges this narrow.
    let unlabelled = |_: &f64| String::new();
    let mut mesh = chart.configure_mesh();
    mesh.disable_mesh().x_label_formatter(&unlabelled).y_label_formatter(&unlabelled);
    mesh.x_desc("time of a frame, ms").y_desc(what);
    mesh.set_all_tick_mark_size(0).axis_desc_style(text(15)).axis_style(BLACK.mix(0.5)).draw()?;
    for time in ticks(left, right) {
        let (x, y) = chart.backend_coord(&(time, bottom));
        chart.draw_series([PathElement::new([(time, bottom), (time, top)], BLACK.mix(0.12))])?;
        root.draw(&Text::new(short(time), (x, y + 8), text(13).pos(Pos::new(HPos::Center, VPos::Top))))?;
    }
    for error in ticks(bottom, top) {
        let (x, y) = chart.backend_coord(&(left, error));
        chart.draw_series([PathElement::new([(left, error), (right, error)], BLACK.mix(0.12))])?;
        root.draw(&Text::new(short(error), (x - 8, y), text(13).pos(Pos::new(HPos::Right, VPos::Center))))?;
    }
    if let Some(time) = reference_ms {
        chart.draw_series(DashedLineSeries::new([(time, bottom), (time, top)], 6, 5, BLACK.mix(0.6).into()))?;
    }
    let shown = |point: &Point| [point.time_ms, point.first_ms].map(|time| (time, point.error.max(lowest)));
    let mut labels = Labels::default();
    for ends in points.iter().map(|point| shown(point).map(|end| chart.backend_coord(&end))) {
        let marks = ends.map(|(x, y)| [x - MARK_PX, y - MARK_PX, x + MARK_PX, y + MARK_PX]);
        let [(later, y), (first, _)] = ends;
        labels.taken.extend(marks);
        labels.taken.push([later.min(first), y - 2, later.max(first), y + 2]);
    }
    if let Some(time) = reference_ms {
        let (x, y) = chart.backend_coord(&(time, top));
        labels.place("reference".into(), None, (x - 4, y + LABEL_PX / 2 + 4), false);
    }
    // From the top, so that labels that have to move stay in the order of their points.
    let mut sorted: Vec<&Point> = points.iter().collect();
    sorted.sort_by(|a, b| b.error.total_cmp(&a.error));
    let mut marks = String::new();
    for point in sorted {
        let ends = shown(point);
        chart.draw_series([PathElement::new(ends, BLACK.mix(0.4))])?;
        let [later, first] = ends.map(|end| chart.backend_coord(&end));
        marks += &mark(first, point.number, Mark::First);
        marks += &mark(later, point.number, Mark::Later);
        let label = if point.error > 0.0 { point.label.clone() } else { format!("{} (no error)", point.label) };
        // Away from the line between the two marks.
        labels.place(label, Some(point.number), later, first.0 > later.0 + 2 * MARK_PX);
    }
    for Label { text: label, number, left, middle } in labels.placed {
        marks += &number.map_or_else(String::new, |number| mark((left + 6, middle), number, Mark::OfLabel));
        let style = text(LABEL_PX - 1).pos(Pos::new(HPos::Left, VPos::Center));
        root.draw(&Text::new(label, (left + if number.is_some() { OWN_MARK_PX } else { 0 }, middle), style))?;
    }
    root.present()?;
    drop((chart, root));
    // Above all lines.
    *svg = svg.replacen("</svg>", &format!("{marks}</svg>"), 1);
    Ok(())
}

/// Labels of points, none over another or over a point as long as there is room.
#[derive(Default)]
struct Labels {
    /// Left, top, right and bottom of what is there already.
    taken: Vec<[i32; 4]>,
    placed: Vec<Label>,
}

struct Label {
    text: String,
    /// The method whose mark stands before it.
    number: Option<usize>,
    left: i32,
    middle: i32,
}

impl Labels {
    /// Finds a place for a label, to the right or left of a point, or as near as there is room.
    fn place(&mut self, text: String, number: Option<usize>, (x, y): (i32, i32), is_left_first: bool) {
        let own_mark = if number.is_some() { OWN_MARK_PX } else { 0 };
        let length = text.chars().count() as i32 * CHARACTER_PX + own_mark;
        let mut sides = [x + 12, x - 12 - length];
        if is_left_first {
            sides.reverse();
        }
        let steps = (0..24).flat_map(|step| [step * LABEL_PX / 2, -step * LABEL_PX / 2]);
        let area = [90, 12, SIZE_PX.0 as i32 - 4, SIZE_PX.1 as i32 - 62];
        let boxes = steps
            .flat_map(|step| sides.map(|left| [left, y + step - LABEL_PX / 2, left + length, y + step + LABEL_PX / 2]));
        let is_free = |it: &[i32; 4]| {
            let is_inside = it[0] >= area[0] && it[1] >= area[1] && it[2] <= area[2] && it[3] <= area[3];
            let hits = |other: &[i32; 4]| it[0] < other[2] && other[0] < it[2] && it[1] < other[3] && other[1] < it[3];
            is_inside && !self.taken.iter().any(hits)
        };
        let left = (x + 12).min(area[2] - length);
        let beside = [left, y - LABEL_PX / 2, left + length, y + LABEL_PX / 2];
        let found = boxes.into_iter().find(is_free).unwrap_or(beside);
        self.taken.push(found);
        self.placed.push(Label { text, number, left: found[0], middle: (found[1] + found[3]) / 2 });
    }
}

/// The kinds of marks.
enum Mark {
    Later,
    First,
    /// A label, by which its point is found.
    OfLabel,
}

/// A method's mark.
fn mark((x, y): (i32, i32), number: usize, kind: Mark) -> String {
    let (path, color) = (markers::path(number), markers::color(number));
    let filled = |class: &str| format!("class=\"{class}\" fill=\"{color}\" stroke=\"currentColor\"");
    let (look, scale) = match kind {
        Mark::Later => (filled("later"), ""),
        Mark::First => (format!("class=\"first\" fill=\"none\" stroke=\"{color}\" stroke-width=\"2.5\""), ""),
        Mark::OfLabel => (filled("label"), " scale(0.6)"),
    };
    format!("<path {look} transform=\"translate({x} {y}){scale}\" d=\"{path}\"/>\n")
}

/// The numbers 1, 2 and 5 times powers of ten in a range, thinned to powers of ten when there are many.
fn ticks(from: f64, to: f64) -> Vec<f64> {
    let decades = from.log10().floor() as i32..=to.log10().ceil() as i32;
    let steps: &[f64] = if decades.clone().count() > 5 { &[1.0] } else { &[1.0, 2.0, 5.0] };
    let all = decades.flat_map(|decade| steps.iter().map(move |step| step * 10f64.powi(decade)));
    all.filter(|value| (from..=to).contains(value)).collect()
}

/// A number for an axis.
fn short(value: f64) -> String {
    let text = if value >= 1000.0 {
        format!("{value:.0}")
    } else {
        // Three digits from the first that is not 0.
        let digits = (2 - value.max(1e-9).log10().floor() as i32).clamp(0, 9) as usize;
        format!("{value:.digits$}")
    };
    if text.contains('.') { text.trim_end_matches('0').trim_end_matches('.').into() } else { text }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn point(label: &str, time_ms: f64, error: f64) -> Point {
        Point { label: label.into(), number: 0, time_ms, first_ms: 2.0 * time_ms, error }
    }

    #[test]
    fn plots_of_none_one_and_equal_points_are_drawn() {
        for points in [
            vec![],
            vec![point("only", 3.0, 0.2)],
            vec![point("a", 1e-3, 0.0), point("b", 1e-3, 0.0), point("c", 1e6, 1.0)],
            vec![point("<&>", 10.0, 1e-6)],
        ] {
            let mut svg = String::new();
            draw(&mut svg, &points, Some(12.0), true).unwrap();
            assert!(svg.contains("</svg>") && svg.contains("reference"));
            assert!(!svg.contains("NaN") && !svg.contains("<&>"));
            for kind in ["later", "first"] {
                assert_eq!(svg.matches(&format!("class=\"{kind}\"")).count(), points.len(), "{kind}");
            }
        }
        let mut svg = String::new();
        draw(&mut svg, &[], None, false).unwrap();
        assert!(svg.contains("</svg>") && !svg.contains("reference") && !svg.contains("NaN"));
    }

    #[test]
    fn every_range_has_ticks() {
        assert_eq!(ticks(0.9, 6.0), [1.0, 2.0, 5.0]);
        assert_eq!(ticks(1e-3, 1e4).len(), 8);
        for start in [1e-3, 0.7, 3.3, 5.1, 900.0] {
            assert!(!ticks(start, 4.0 * start).is_empty());
        }
    }

    #[test]
    fn axis_numbers_are_short() {
        assert_eq!(["0.001", "0.05", "2", "100", "12000"], [0.001, 0.05, 2.0, 100.0, 12_000.0].map(short)[..]);
    }
}
