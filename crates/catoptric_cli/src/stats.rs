//! The JSON object that describes a run: what was drawn, how long it took, and, in comparisons, how wrong it is.

use crate::drawing::{Drawing, Shot};
use crate::settings::{self, Chosen};
use catoptric::methods::Choice;
use catoptric::methods::projection::measure::round_trip::RoundTrip;
use catoptric::metrics::PictureError;
use catoptric::scene::Role;
use serde::ser::{Serialize, SerializeMap, Serializer};
use std::collections::BTreeMap;

/// Named times in their own order.
#[derive(Clone, Debug, Default)]
pub(crate) struct Times(pub(crate) Vec<(String, f64)>);

impl Serialize for Times {
    fn serialize<S: Serializer>(&self, serializer: S) -> Result<S::Ok, S::Error> {
        let mut map = serializer.serialize_map(Some(self.0.len()))?;
        for (name, time) in &self.0 {
            map.serialize_entry(name, &rounded(*time))?;
        }
        map.end()
    }
}

/// Microseconds are as fine as clocks are honest.
fn rounded(milliseconds: f64) -> f64 {
    (milliseconds * 1e3).round() / 1e3
}

/// Times of frames, in milliseconds.
#[derive(Clone, Debug, serde::Serialize)]
pub(crate) struct FrameTimes {
    /// The first frame, which makes what later ones keep.
    pub(crate) first: f64,
    /// The median of the frames after the first where there are several.
    pub(crate) median: f64,
    pub(crate) min: f64,
    pub(crate) max: f64,
}

impl FrameTimes {
    /// The times of some frames, in order; all 0 where there are none.
    fn new(times: &[f64]) -> Self {
        let later = if times.len() > 1 { &times[1..] } else { times };
        Self {
            first: rounded(times.first().copied().unwrap_or_default()),
            median: rounded(median(later)),
            min: rounded(times.iter().copied().reduce(f64::min).unwrap_or_default()),
            max: rounded(times.iter().copied().reduce(f64::max).unwrap_or_default()),
        }
    }
}

#[derive(Clone, Debug, serde::Serialize)]
pub(crate) struct Counts {
    #[serde(flatten)]
    pub(crate) named: BTreeMap<String, u64>,
    pub(crate) fallbacks: BTreeMap<String, u64>,
}

/// The shares of the reflectors' pixels in the last frame, by what has drawn them.
#[derive(Clone, Copy, Debug, PartialEq, serde::Serialize)]
pub(crate) struct DrawnBy {
    /// The method's own geometry.
    pub(crate) method: f64,
    /// Tiles, which are the method `multiperspective`.
    pub(crate) tiles: f64,
    /// Rays, one by one.
    pub(crate) rays: f64,
}

impl DrawnBy {
    /// By a run's counts; `None` where nothing was counted, or no reflector is seen.
    fn of(counts: &BTreeMap<String, u64>) -> Option<Self> {
        let count = |by: &str| counts.get(&format!("reflector_pixels{by}")).map(|count| *count as f64);
        let all = count("").filter(|all| *all > 0.0)?;
        Some(Self {
            method: count("_by_method")? / all,
            tiles: count("_by_tiles")? / all,
            rays: count("_by_rays")? / all,
        })
    }

    /// In words, those that have drawn anything: `own 93 %, tiles 5 %, rays 2 %`.
    pub(crate) fn words(&self) -> String {
        let percent = |share: f64| match share * 100.0 {
            share if share < 1.0 => "< 1 %".to_owned(),
            share if share > 99.0 && share < 100.0 => "> 99 %".to_owned(),
            share => format!("{share:.0} %"),
        };
        let parts = [("own", self.method), ("tiles", self.tiles), ("rays", self.rays)];
        let shown = parts.iter().filter(|(_, share)| *share > 0.0);
        shown.map(|(name, share)| format!("{name} {}", percent(*share))).collect::<Vec<_>>().join(", ")
    }
}

/// A run of one method.
#[derive(Clone, Debug, serde::Serialize)]
pub(crate) struct Stats {
    pub(crate) version: &'static str,
    pub(crate) scene: String,
    pub(crate) method: &'static str,
    pub(crate) settings: serde_json::Map<String, serde_json::Value>,
    pub(crate) backend: &'static str,
    pub(crate) device: String,
    pub(crate) threads: usize,
    pub(crate) size: [u32; 2],
    pub(crate) samples: u32,
    pub(crate) order: u32,
    pub(crate) frames: u32,
    pub(crate) motion: &'static str,
    pub(crate) setup_ms: Times,
    pub(crate) frame_ms: FrameTimes,
    pub(crate) stages_ms: Times,
    /// Times of the first frame alone, which makes what later frames keep.
    pub(crate) first_stages_ms: Times,
    pub(crate) counts: Counts,
    /// Shares of reflectors and lenses by what has drawn them, of methods that count it.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub(crate) drawn_by: Option<DrawnBy>,
    pub(crate) bytes: BTreeMap<String, u64>,
    pub(crate) warnings: Vec<String>,
    /// The way to draw each reflector, of methods that choose one.
    #[serde(skip_serializing_if = "Vec::is_empty")]
    pub(crate) choices: Vec<ChosenWay>,
    /// The largest error of accepted approximations in pixels, of methods that measure it.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub(crate) error_px: Option<f64>,
    /// The standard error of a pixel by sampling, linear, of methods that estimate it.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub(crate) noise: Option<f64>,
}

/// The way to draw a reflector.
#[derive(Clone, Debug, serde::Serialize)]
pub(crate) struct ChosenWay {
    pub(crate) object: String,
    pub(crate) method: &'static str,
    pub(crate) reason: String,
}

/// The error of a picture against the reference.
#[derive(Clone, Debug, serde::Serialize)]
pub(crate) struct ErrorReport {
    /// The error over the whole picture.
    pub(crate) image: Option<PictureError>,
    /// The error over the pixels that show a reflector or lens; null if there are none.
    pub(crate) reflector: Option<PictureError>,
    /// The projection error in pixels, of paths that the method's own geometry has drawn; null for methods that do not
    /// project points, and where tiles have drawn all paths.
    pub(crate) projection_px: Option<RoundTrip>,
}

impl Stats {
    pub(crate) fn new(shot: &Shot<'_>, chosen: &Chosen, drawing: &Drawing) -> Self {
        let scene = &drawing.scene;
        let mut named: BTreeMap<String, u64> = owned(&drawing.counts);
        named.entry("scene_triangles".into()).or_insert(scene.triangles.len() as u64);
        let reflector_triangles =
            scene.objects.iter().filter(|object| scene.materials[object.material as usize].role != Role::Diffuse);
        let reflector_triangles = reflector_triangles.map(|object| object.triangles.len() as u64).sum();
        named.entry("reflector_triangles".into()).or_insert(reflector_triangles);
        Self {
            version: env!("CARGO_PKG_VERSION"),
            scene: shot.model.name.clone(),
            method: chosen.info.id,
            settings: settings::effective(chosen.info, &chosen.settings),
            backend: drawing.processor.backend,
            device: drawing.processor.device.clone(),
            threads: catoptric::parallel::thread_count(),
            size: [drawing.view.width, drawing.view.height],
            samples: shot.quality.samples,
            order: shot.quality.order,
            frames: shot.frames,
            motion: shot.motion.name(),
            setup_ms: Times(drawing.setup_ms.clone()),
            frame_ms: FrameTimes::new(&drawing.frame_ms),
            stages_ms: Times(drawing.stages_ms.iter().map(|(name, times)| (name.clone(), median(times))).collect()),
            first_stages_ms: Times(drawing.first_stages_ms.clone()),
            drawn_by: DrawnBy::of(&named),
            counts: Counts { named, fallbacks: owned(&drawing.fallbacks) },
            bytes: owned(&drawing.bytes),
            warnings: shot.model.warnings.iter().chain(&drawing.warnings).cloned().collect(),
            choices: drawing.choices.iter().map(ChosenWay::new).collect(),
            error_px: drawing.error_px,
            noise: drawing.noise,
        }
    }

    /// The share of the reflectors' pixels that tiles, and rays at their rims, have drawn in the method's place.
    pub(crate) fn share_left_to_tiles(&self) -> f64 {
        let are_left = self.counts.fallbacks.contains_key("paths_drawn_by_tiles");
        self.drawn_by.filter(|_| are_left).map_or(0.0, |drawn_by| 1.0 - drawn_by.method)
    }

    /// The ways that were chosen, each with the number of its reflectors and the reason; `None` for methods that choose
    /// nothing.
    pub(crate) fn chosen(&self) -> Option<String> {
        let mut counts: Vec<(&ChosenWay, u32)> = Vec::new();
        for way in &self.choices {
            match counts.iter_mut().find(|(other, _)| (other.method, &other.reason) == (way.method, &way.reason)) {
                Some((_, count)) => *count += 1,
                None => counts.push((way, 1)),
            }
        }
        let line = |(way, count): &(&ChosenWay, u32)| format!("{count} by {} ({})", way.method, way.reason);
        let lines: Vec<String> = counts.iter().map(line).collect();
        (!lines.is_empty()).then(|| lines.join(", "))
    }
}

impl ChosenWay {
    fn new(choice: &Choice) -> Self {
        Self { object: choice.object.clone(), method: choice.method, reason: choice.reason.clone() }
    }
}

fn owned(counts: &BTreeMap<&'static str, u64>) -> BTreeMap<String, u64> {
    counts.iter().map(|(name, count)| ((*name).to_owned(), *count)).collect()
}

/// The middle of some times; of an even number the mean of the two in the middle; 0 when there are none.
fn median(times: &[f64]) -> f64 {
    let mut sorted = times.to_vec();
    sorted.sort_by(f64::total_cmp);
    let middle = sorted.len() / 2;
    match sorted.len() {
        0 => 0.0,
        length if length % 2 == 1 => sorted[middle],
        _ => 0.5 * (sorted[middle - 1] + sorted[middle]),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn medians() {
        assert_eq!(median(&[]), 0.0);
        assert_eq!(median(&[3.0]), 3.0);
        assert_eq!(median(&[5.0, 1.0, 3.0]), 3.0);
        assert_eq!(median(&[4.0, 1.0, 3.0, 100.0]), 3.5);
    }

    #[test]
    fn who_has_drawn_is_said_in_shares() {
        let counted = |counts: [u64; 4]| {
            let names = ["", "_by_method", "_by_tiles", "_by_rays"].map(|by| format!("reflector_pixels{by}"));
            DrawnBy::of(&names.into_iter().zip(counts).collect()).map(|drawn_by| drawn_by.words())
        };
        assert_eq!(counted([200, 186, 10, 4]).as_deref(), Some("own 93 %, tiles 5 %, rays 2 %"));
        assert_eq!(counted([1000, 999, 0, 1]).as_deref(), Some("own > 99 %, rays < 1 %"));
        assert_eq!(counted([7, 7, 0, 0]).as_deref(), Some("own 100 %"));
        assert_eq!((counted([0; 4]), DrawnBy::of(&BTreeMap::new())), (None, None));
    }

    #[test]
    fn the_first_frame_is_beside_the_median_of_the_others() {
        let FrameTimes { first, median, min, max } = FrameTimes::new(&[50.0, 3.0, 1.0, 2.0]);
        assert_eq!([first, median, min, max], [50.0, 2.0, 1.0, 50.0]);
        let FrameTimes { first, median, min, max } = FrameTimes::new(&[7.0]);
        assert_eq!([first, median, min, max], [7.0; 4]);
    }
}
