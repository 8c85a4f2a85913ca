//! Curves of times, both axes logarithmic, as SVG.

use anyhow::{Result, anyhow};
use plotters::coord::Shift;
use plotters::coord::combinators::IntoLogRange;
use plotters::prelude::*;
use plotters::style::text_anchor::{HPos, Pos, VPos};

const SIZE_PX: (u32, u32) = (1000, 720);
const COLOURS: [RGBColor; 4] =
    [RGBColor(60, 60, 60), RGBColor(222, 85, 46), RGBColor(59, 130, 246), RGBColor(32, 150, 130)];

/// Times against what varies.
pub(super) struct Curve {
    pub(super) label: &'static str,
    pub(super) points: Vec<(f64, f64)>,
}

/// Curves in one frame.
pub(super) struct Plot {
    pub(super) what: &'static str,
    pub(super) curves: Vec<Curve>,
}

type Drawing<'a> = DrawingArea<SVGBackend<'a>, Shift>;

/// Four plots, two by two.
pub(super) fn draw(plots: &[Plot]) -> Result<String> {
    let mut svg = String::new();
    {
        let root = SVGBackend::with_string(&mut svg, SIZE_PX).into_drawing_area();
        let failed = |error: DrawingAreaErrorKind<std::io::Error>| anyhow!("the plots cannot be drawn: {error}");
        root.fill(&WHITE).map_err(failed)?;
        for (area, plot) in root.split_evenly((2, 2)).iter().zip(plots) {
            draw_one(area, plot).map_err(failed)?;
        }
        root.present().map_err(failed)?;
    }
    Ok(svg)
}

fn draw_one(area: &Drawing<'_>, plot: &Plot) -> Result<(), DrawingAreaErrorKind<std::io::Error>> {
    let points = || plot.curves.iter().flat_map(|curve| &curve.points).map(|(at, time)| (*at, time.max(0.1)));
    let least = |value: fn((f64, f64)) -> f64| points().map(value).fold(f64::INFINITY, f64::min);
    let most = |value: fn((f64, f64)) -> f64| points().map(value).fold(0.0, f64::max);
    let (left, right) = (least(|point| point.0) / 1.15, most(|point| point.0) * 1.15);
    let (bottom, top) = (least(|point| point.1) / 1.5, most(|point| point.1) * 3.0);
    let mut chart = ChartBuilder::on(area)
        .margin(10)
        .x_label_area_size(44)
        .y_label_area_size(70)
        .build_cartesian_2d((left..right).log_scale(), (bottom..top).log_scale())?;
    let text = |size: i32| ("sans-serif", size).into_font().color(&BLACK);
    let unlabelled = |_: &f64| String::new();
    let mut mesh = chart.configure_mesh();
    mesh.disable_mesh().x_label_formatter(&unlabelled).y_label_formatter(&unlabelled);
    mesh.x_desc(plot.what).y_desc("ms").axis_desc_style(text(15)).set_all_tick_mark_size(0).draw()?;
    let corner = area.get_base_pixel();
    let local = |(x, y): (i32, i32)| (x - corner.0, y - corner.1);
    for power in -1..5 {
        let time = 10f64.powi(power);
        if time < bottom || time > top {
            continue;
        }
        chart.draw_series([PathElement::new([(left, time), (right, time)], BLACK.mix(0.15))])?;
        let (x, y) = local(chart.backend_coord(&(left, time)));
        area.draw(&Text::new(format!("{time}"), (x - 8, y), text(13).pos(Pos::new(HPos::Right, VPos::Center))))?;
    }
    let places = plot.curves.first().map(|curve| curve.points.as_slice()).unwrap_or_default();
    for (at, _) in places {
        let (x, y) = local(chart.backend_coord(&(*at, bottom)));
        area.draw(&Text::new(format!("{at}"), (x, y + 6), text(13).pos(Pos::new(HPos::Center, VPos::Top))))?;
    }
    for (index, (curve, colour)) in plot.curves.iter().zip(COLOURS).enumerate() {
        let points = || curve.points.iter().map(|(at, time)| (*at, time.max(0.1)));
        chart.draw_series(LineSeries::new(points(), colour.stroke_width(2)))?;
        chart.draw_series(points().map(|point| Circle::new(point, 4, colour.filled())))?;
        let (x, y) = local(chart.backend_coord(&(left, top)));
        let place = (x + 12 + 190 * (index as i32 % 2), y + 6 + 18 * (index as i32 / 2));
        area.draw(&Rectangle::new([(place.0, place.1 + 3), (place.0 + 10, place.1 + 11)], colour.filled()))?;
        area.draw(&Text::new(curve.label, (place.0 + 16, place.1), text(14)))?;
    }
    Ok(())
}
