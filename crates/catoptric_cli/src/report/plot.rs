//! Error against time, as SVG.

use super::Report;
use crate::failure::Failure;
use plotters::coord::combinators::IntoLogRange;
use plotters::prelude::*;
use plotters::style::text_anchor::{HPos, Pos, VPos};

const SIZE_PX: (u32, u32) = (860, 420);
const LABEL_PX: i32 = 15;
const CHARACTER_PX: i32 = 8;
/// Legible on white and on black.
pub(super) const COLORS: [RGBColor; 8] = [
    RGBColor(59, 130, 246),
    RGBColor(222, 85, 46),
    RGBColor(32, 150, 130),
    RGBColor(190, 70, 190),
    RGBColor(190, 130, 0),
    RGBColor(105, 145, 30),
    RGBColor(125, 110, 240),
    RGBColor(150, 105, 80),
];

/// A plot whose lines and letters take the colour of the text around it.
pub(super) struct Plot {
    svg: String,
}

struct Point {
    label: String,
    time_ms: f64,
    first_ms: f64,
    error: f64,
    color: RGBColor,
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

/// The colour that an entry of the report has in the plot and in the page.
pub(super) fn color(index: usize) -> RGBColor {
    COLORS[index % COLORS.len()]
}

/// Mean FLIP against the time of a frame, both logarithmic: a disc for the median, a circle for the first frame.
/// The time of the reference is a dashed line.
pub(super) fn error_against_time(report: &Report) -> Result<Plot, Failure> {
    let points: Vec<Point> = report
        .entries
        .iter()
        .enumerate()
        .filter_map(|(index, entry)| match &entry.outcome {
            super::Outcome::Measured(measured) if !entry.is_truth => Some(Point {
                label: entry.label.clone(),
                time_ms: measured.stats.frame_ms.median.max(1e-3),
                first_ms: measured.stats.frame_ms.first.max(1e-3),
                error: measured.ranking_error()?,
                color: color(index),
            }),
            _ => None,
        })
        .collect();
    let reference_ms = report.truth.frame_ms.median.max(1e-3);
    let mut svg = String::new();
    draw(&mut svg, &points, reference_ms, report.reflector_pixels > 0)
        .map_err(|error| Failure::input(format!("the plot cannot be drawn: {error}")))?;
    Ok(Plot { svg: svg.replace("#000000", "currentColor") })
}

fn draw(
    svg: &mut String,
    points: &[Point],
    reference_ms: f64,
    reflectors: bool,
) -> Result<(), DrawingAreaErrorKind<std::io::Error>> {
    let times = || points.iter().flat_map(|point| [point.time_ms, point.first_ms]).chain([reference_ms]);
    let errors = || points.iter().map(|point| point.error).filter(|error| *error > 0.0);
    let (first, last) = (times().fold(f64::INFINITY, f64::min), times().fold(0.0, f64::max));
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
    let dashes = DashedLineSeries::new([(reference_ms, bottom), (reference_ms, top)], 6, 5, BLACK.mix(0.6).into());
    chart.draw_series(dashes)?;
    let mut taken: Vec<[i32; 4]> = Vec::new();
    let mut labels: Vec<(String, (i32, i32), HPos)> = Vec::new();
    let mut place = |label: String, (x, y): (i32, i32)| {
        let length = label.chars().count() as i32 * CHARACTER_PX;
        let left = x + 12 + length > SIZE_PX.0 as i32;
        let (start, anchor) = if left { (x - 12 - length, HPos::Right) } else { (x + 12, HPos::Left) };
        let mut y = y;
        // Labels that would lie on others move down, then give up rather than leave the plot.
        while y < SIZE_PX.1 as i32 - 70
            && taken
                .iter()
                .any(|other| start < other[2] && other[0] < start + length && y < other[3] && other[1] < y + LABEL_PX)
        {
            y += LABEL_PX;
        }
        taken.push([start, y, start + length, y + LABEL_PX]);
        labels.push((label, (if left { x - 12 } else { x + 12 }, y), anchor));
    };
    let (x, y) = chart.backend_coord(&(reference_ms, top));
    place("reference".into(), (x - 4, y + 4));
    // From the top, so that labels that have to move down stay in the order of their points.
    let mut sorted: Vec<&Point> = points.iter().collect();
    sorted.sort_by(|a, b| b.error.total_cmp(&a.error));
    for point in sorted {
        let shown = point.error.max(lowest);
        chart
            .draw_series([PathElement::new([(point.time_ms, shown), (point.first_ms, shown)], point.color.mix(0.5))])?;
        chart.draw_series([Circle::new((point.first_ms, shown), 5, point.color.stroke_width(2))])?;
        chart.draw_series([Circle::new((point.time_ms, shown), 6, point.color.filled())])?;
        let (x, y) = chart.backend_coord(&(point.time_ms, shown));
        let label = if point.error > 0.0 { point.label.clone() } else { format!("{} (no error)", point.label) };
        place(label, (x, y - LABEL_PX / 2));
    }
    for (label, at, anchor) in labels {
        let style = text(LABEL_PX - 1).pos(Pos::new(anchor, VPos::Top));
        root.draw(&Text::new(label, at, style))?;
    }
    root.present()
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
        Point { label: label.into(), time_ms, first_ms: 2.0 * time_ms, error, color: COLORS[0] }
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
            draw(&mut svg, &points, 12.0, true).unwrap();
            assert!(svg.contains("</svg>") && svg.contains("reference"));
            assert!(!svg.contains("NaN") && !svg.contains("<&>"));
            assert_eq!(svg.matches("<circle").count(), 2 * points.len(), "medians and first frames");
        }
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
