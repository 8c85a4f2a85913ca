//! The table of a report: its rows, columns and best values, for the page, the console and files.

use super::content::{Entry, Measured, Report};
use catoptric::metrics::PictureError;

/// A column.
pub(super) struct Column {
    /// Columns of one group stand side by side.
    pub(super) group: &'static str,
    pub(super) heading: &'static str,
    /// The column's name in files.
    pub(super) key: &'static str,
    /// The heading on the console, for the most important ones.
    console: Option<&'static str>,
    /// The meaning, in a line.
    pub(super) line: &'static str,
    value: fn(&Report, &Measured) -> Option<Value>,
    style: Style,
    best: Best,
}

/// The content of a cell.
pub(super) enum Value {
    Number(f64),
    Text(String),
}

/// The way to write numbers.
#[derive(Clone, Copy)]
enum Style {
    Digits(usize),
    /// A share in per cent.
    Percent,
    Milliseconds,
    Times,
}

/// The value that is best.
#[derive(Clone, Copy, PartialEq)]
enum Best {
    Lowest,
    Highest,
    None,
}

pub(super) const SPEED: &str = "Speed-up";
const TIME: &str = "Time, ms";
const REFLECTORS: &str = "Reflectors";
const PICTURE: &str = "Whole picture";
const PROJECTION: &str = "Projection, pixels";

const fn column(
    (group, heading, key): (&'static str, &'static str, &'static str),
    console: Option<&'static str>,
    (style, best): (Style, Best),
    value: fn(&Report, &Measured) -> Option<Value>,
    line: &'static str,
) -> Column {
    Column { group, heading, key, console, line, value, style, best }
}

const FINE: (Style, Best) = (Style::Digits(4), Best::Lowest);
const LINEAR: (Style, Best) = (Style::Digits(5), Best::Lowest);
const SHARE: (Style, Best) = (Style::Percent, Best::Lowest);
const SPENT: (Style, Best) = (Style::Milliseconds, Best::Lowest);

const ALL: [Column; 17] = [
    column(
        (SPEED, "a frame", "speedup"),
        Some("speed-up"),
        (Style::Times, Best::Highest),
        |report, m| speedup(report, m.stats.frame_ms.median),
        "the reference's time of a frame divided by the method's: 2× is twice as fast",
    ),
    column(
        (SPEED, "first", "speedup_first"),
        None,
        (Style::Times, Best::Highest),
        |report, m| speedup(report, m.stats.frame_ms.first).filter(|_| has_later(m)),
        "the same for the first frame, which also makes what later ones keep",
    ),
    column(
        (TIME, "a frame", "frame_ms"),
        Some("frame ms"),
        SPENT,
        |_, m| number(m.stats.frame_ms.median),
        "one frame; with several the median of those after the first",
    ),
    column(
        (TIME, "first", "first_frame_ms"),
        None,
        SPENT,
        |_, m| number(m.stats.frame_ms.first).filter(|_| has_later(m)),
        "the first frame, an empty mark in the plot",
    ),
    column(
        (TIME, "set-up", "setup_ms"),
        None,
        SPENT,
        |_, m| number(m.stats.setup_ms.0.iter().map(|(_, time)| time).sum()),
        "once, before any frame: loading, and what the method prepares",
    ),
    column(
        (REFLECTORS, "FLIP mean", "reflector_flip_mean"),
        Some("FLIP reflectors"),
        FINE,
        |_, m| error(m.error.reflector, |error| error.flip_mean),
        "the difference that people see when pictures flip, 0 (none) to 1: the mean of the pixels whose first surface \
         is a reflector or a lens",
    ),
    column(
        (REFLECTORS, "FLIP p99", "reflector_flip_p99"),
        None,
        FINE,
        |_, m| error(m.error.reflector, |error| error.flip_p99),
        "the FLIP that 99 of 100 of these pixels do not exceed",
    ),
    column(
        (REFLECTORS, "RMSE", "reflector_rmse"),
        None,
        LINEAR,
        |_, m| error(m.error.reflector, |error| error.rmse),
        "root mean square difference of their linear red, green and blue",
    ),
    column(
        (REFLECTORS, "off > 0.1", "reflector_over_0_1"),
        None,
        SHARE,
        |_, m| error(m.error.reflector, |error| error.over_0_1),
        "the share of these pixels with an sRGB channel off by more than 0.1 of 1",
    ),
    column(
        (REFLECTORS, "drawn by", "drawn_by"),
        Some("drawn by"),
        (Style::Percent, Best::None),
        |_, m| m.stats.drawn_by.map(|drawn_by| Value::Text(drawn_by.words())),
        "their shares by what has drawn them: the method's own geometry, tiles (the method multiperspective), or rays, \
         one by one; a pixel of which tiles have drawn any part counts as theirs",
    ),
    column(
        (PICTURE, "FLIP mean", "flip_mean"),
        Some("FLIP picture"),
        FINE,
        |_, m| error(m.error.image, |error| error.flip_mean),
        "mean FLIP of all pixels",
    ),
    column(
        (PICTURE, "RMSE", "rmse"),
        Some("RMSE picture"),
        LINEAR,
        |_, m| error(m.error.image, |error| error.rmse),
        "RMSE of all pixels",
    ),
    column(
        (PROJECTION, "p50", "projection_px_p50"),
        Some("px p50"),
        FINE,
        |_, m| m.error.projection_px.as_ref()?.all.p50.and_then(number),
        "how far from a pixel's middle the method finds the point that the pixel shows in a mirror or through glass: \
         the median",
    ),
    column(
        (PROJECTION, "p99", "projection_px_p99"),
        Some("px p99"),
        FINE,
        |_, m| m.error.projection_px.as_ref()?.all.p99.and_then(number),
        "what 99 of 100 do not exceed",
    ),
    column(
        (PROJECTION, "max", "projection_px_max"),
        None,
        FINE,
        |_, m| m.error.projection_px.as_ref()?.all.max.and_then(number),
        "the largest",
    ),
    column(
        (PROJECTION, "missing", "projection_missing"),
        Some("missing"),
        SHARE,
        |_, m| number(m.error.projection_px.as_ref()?.all.missing),
        "the share of points seen in mirrors or through glass that it does not find",
    ),
    column(
        (PROJECTION, "invented", "projection_invented"),
        Some("invented"),
        SHARE,
        |_, m| number(m.error.projection_px.as_ref()?.all.invented),
        "the share of its answers that are at places where the point does not appear",
    ),
];

fn number(value: f64) -> Option<Value> {
    Some(Value::Number(value))
}

fn error(error: Option<PictureError>, part: fn(&PictureError) -> f64) -> Option<Value> {
    error.as_ref().map(part).and_then(number)
}

fn speedup(report: &Report, own_ms: f64) -> Option<Value> {
    report.reference_ms().filter(|_| own_ms > 0.0).and_then(|reference_ms| number(reference_ms / own_ms))
}

/// True if later frames have times of their own.
fn has_later(measured: &Measured) -> bool {
    measured.stats.frames > 1
}

/// A method's row.
pub(super) struct Row<'a> {
    /// The method's number for colours and shapes; `None` of the run that all are measured against.
    pub(super) number: Option<usize>,
    pub(super) entry: &'a Entry,
}

/// The rows, the reference first.
pub(super) fn rows(report: &Report) -> Vec<Row<'_>> {
    let truth = report.entries.iter().filter(|entry| entry.is_truth).map(|entry| Row { number: None, entry });
    truth.chain(report.methods().map(|(number, entry)| Row { number: Some(number), entry })).collect()
}

/// The columns in which any method has a value. Where the reference is alone, those that it has.
pub(super) fn columns(report: &Report) -> Vec<&'static Column> {
    let is_alone = !report.measured().any(|(entry, _)| !entry.is_truth);
    let has_value = |column: &&Column| {
        let mut shown = report.measured().filter(|(entry, _)| is_alone || !entry.is_truth);
        shown.any(|(_, measured)| (column.value)(report, measured).is_some())
    };
    ALL.iter().filter(has_value).collect()
}

impl Column {
    pub(super) fn value(&self, report: &Report, entry: &Entry) -> Option<Value> {
        (self.value)(report, entry.measured()?)
    }

    /// The value as it is read by people; a dash where there is none.
    pub(super) fn text(&self, report: &Report, entry: &Entry) -> String {
        match self.value(report, entry) {
            None => "–".into(),
            Some(Value::Text(text)) => text,
            Some(Value::Number(value)) => self.style.text(value),
        }
    }

    /// True if it has words in place of numbers.
    pub(super) fn is_words(&self) -> bool {
        self.key == "drawn_by"
    }

    /// True if no other method with a usable picture has a better value. The reference does not compete, and a single
    /// method is not best.
    pub(super) fn is_best(&self, report: &Report, entry: &Entry) -> bool {
        let sign = match self.best {
            Best::Lowest => 1.0,
            Best::Highest => -1.0,
            Best::None => return false,
        };
        let is_usable = |entry: &Entry| entry.measured().is_some_and(|measured| measured.unusable.is_none());
        let others = || report.measured().map(|(entry, _)| entry).filter(|entry| !entry.is_truth);
        if entry.is_truth || !is_usable(entry) || others().count() < 2 {
            return false;
        }
        let cost = |entry: &Entry| match self.value(report, entry) {
            Some(Value::Number(value)) => Some(sign * value),
            _ => None,
        };
        let best = others().filter(|entry| is_usable(entry)).filter_map(cost).fold(f64::INFINITY, f64::min);
        // Numbers that read alike are alike.
        let text = |cost: f64| self.style.text(sign * cost);
        cost(entry).is_some_and(|cost| cost <= best || text(cost) == text(best))
    }
}

impl Style {
    fn text(self, value: f64) -> String {
        match self {
            _ if !value.is_finite() => "∞".into(),
            Self::Digits(digits) => format!("{value:.digits$}"),
            Self::Percent => percent(value),
            Self::Milliseconds => milliseconds(value),
            Self::Times if value < 0.1 => format!("{value:.3}×"),
            Self::Times => format!("{value:.2}×"),
        }
    }
}

pub(super) fn percent(share: f64) -> String {
    format!("{:.2} %", share * 100.0)
}

pub(super) fn milliseconds(value: f64) -> String {
    match value {
        value if value >= 100.0 => format!("{value:.0}"),
        value if value >= 1.0 => format!("{value:.1}"),
        value => format!("{value:.3}"),
    }
}

/// The meaning of the stars, and which pictures have none.
pub(super) fn line_of_stars(report: &Report) -> String {
    let place = if report.reflector_pixels > 0 { "its reflectors" } else { "it" };
    let nothing = match report.error_of_nothing {
        Some(error) => format!("that of drawing nothing there, {error:.4}"),
        None => "that of drawing nothing there".into(),
    };
    format!(
        "the best of the methods whose picture is usable: {place} must not be black in over half of the lit pixels, \
         and the mean FLIP must be below {nothing}"
    )
}

/// The most important columns, for the console: a row of headings, then a row a method.
pub(crate) fn console(report: &Report) -> Vec<Vec<String>> {
    let mut shown: Vec<(&str, &Column)> =
        columns(report).into_iter().filter_map(|column| Some((column.console?, column))).collect();
    // Errors first, as they have always been.
    shown.sort_by_key(|(_, column)| match column.group {
        TIME => 1,
        SPEED => 2,
        _ => 0,
    });
    let headings = std::iter::once("method").chain(shown.iter().map(|(heading, _)| *heading));
    let mut lines = vec![headings.map(String::from).collect()];
    for Row { entry, .. } in rows(report).into_iter().filter(|row| row.entry.measured().is_some()) {
        let cells = shown.iter().map(|(_, column)| column.text(report, entry));
        lines.push(std::iter::once(entry.label.clone()).chain(cells).collect());
    }
    lines
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn numbers_are_legible() {
        assert_eq!(milliseconds(1234.5), "1234");
        assert_eq!(milliseconds(0.01), "0.010");
        assert_eq!(Style::Digits(4).text(f64::INFINITY), "∞");
    }
}
