//! Pictures as text; their pixels are bytes.

use super::error::WireError;
use super::wish::WireWish;
use crate::studio::news::Picture;
use catoptric::framebuffer::Framebuffer;
use catoptric::methods::Report;
use serde::{Deserialize, Serialize};
use std::collections::BTreeMap;
use std::sync::{Arc, Mutex, PoisonError};

#[derive(Serialize, Deserialize)]
pub(super) struct WirePicture {
    side: usize,
    wish: WireWish,
    is_whole: bool,
    samples: u32,
    size: [u32; 2],
    stages_ms: Vec<(String, f64)>,
    counts: Vec<(String, u64)>,
    fallbacks: Vec<(String, u64)>,
    warnings: Vec<String>,
    frame_ms: f64,
    processor: String,
    pub(super) has_linear: bool,
}

/// Refuses pictures whose bytes do not fill them.
pub(super) fn check_length(length: usize, [width, height]: [u32; 2], bytes_a_pixel: usize) -> Result<(), WireError> {
    let wanted = (width as usize).checked_mul(height as usize).and_then(|pixels| pixels.checked_mul(bytes_a_pixel));
    if wanted == Some(length) {
        return Ok(());
    }
    Err(WireError::new(format!("{length} bytes for a picture of {width} x {height} pixels")))
}

impl From<&Picture> for WirePicture {
    fn from(picture: &Picture) -> Self {
        let Report { stages_ms, counts, fallbacks, warnings, .. } = &picture.report;
        let owned = |(name, count): (&&'static str, &u64)| ((*name).to_owned(), *count);
        Self {
            side: picture.side,
            wish: WireWish::from(&*picture.wish),
            is_whole: picture.is_whole,
            samples: picture.samples,
            size: picture.size,
            stages_ms: stages_ms.iter().map(|(name, ms)| ((*name).to_owned(), *ms)).collect(),
            counts: counts.iter().map(owned).collect(),
            fallbacks: fallbacks.iter().map(owned).collect(),
            warnings: warnings.clone(),
            frame_ms: picture.frame_ms,
            processor: picture.processor.clone(),
            // Drafts are neither saved nor compared.
            has_linear: picture.is_whole && picture.linear.is_some(),
        }
    }
}

impl WirePicture {
    pub(super) fn read(self, mut rgba: Vec<u8>) -> Result<Picture, WireError> {
        let [width, height] = self.size;
        let mut linear = None;
        check_length(rgba.len(), self.size, if self.has_linear { 20 } else { 4 })?;
        if self.has_linear {
            let floats = rgba.split_off(width as usize * height as usize * 4);
            let pixels = bytemuck::pod_collect_to_vec(&floats);
            linear = Some(Arc::new(Framebuffer::of_pixels(width, height, pixels)));
        }
        let named = |(name, count): (String, u64)| (kept(name), count);
        let report = Report {
            stages_ms: self.stages_ms.into_iter().map(|(name, ms)| (kept(name), ms)).collect(),
            counts: self.counts.into_iter().map(named).collect(),
            fallbacks: self.fallbacks.into_iter().map(named).collect(),
            warnings: self.warnings,
            ..Report::default()
        };
        Ok(Picture {
            side: self.side,
            wish: Arc::new(self.wish.read()?),
            is_whole: self.is_whole,
            samples: self.samples,
            size: self.size,
            linear,
            rgba,
            texture: None,
            report,
            frame_ms: self.frame_ms,
            processor: self.processor,
        })
    }
}

/// The name of a stage or count, of which there are a few dozen in the whole program: kept for good, once each.
fn kept(name: String) -> &'static str {
    static NAMES: Mutex<BTreeMap<String, &'static str>> = Mutex::new(BTreeMap::new());
    let mut names = NAMES.lock().unwrap_or_else(PoisonError::into_inner);
    names.entry(name).or_insert_with_key(|name| Box::leak(name.clone().into_boxed_str()))
}
