//! Slabs as work in units: a row of views each.

use super::INFO;
use super::capture::{Capture, leaves};
use super::layout::{Layout, SLABS};
use super::regions::Regions;
use super::rows::{RowSize, Rows};
use super::settings::LightFieldSettings;
use super::slabs::Slabs;
use super::texels::Levels;
use crate::error::RenderError;
use crate::methods::Quality;
use crate::methods::bake::{BakeUnit, BakeWork, Baked, UnitMaker};
use crate::progress::Progress;
use crate::scene::Scene;
use std::hash::{DefaultHasher, Hasher};
use std::sync::Arc;

/// The layout of a unit's bytes: texels of a row of views, then their parallaxes. Also how they are captured: it changes with
/// what they hold.
const PAYLOAD_VERSION: u32 = 1;

/// The names of slabs.
const NAMES: [&str; SLABS] = ["+x", "-x", "+y", "-y", "+z", "-z"];

/// The slabs about all regions of a scene.
pub(super) struct SlabsWork<'a> {
    scene: &'a Scene,
    settings: LightFieldSettings,
    /// Highest number of specular events on a path from the eye.
    order: u32,
    pub(super) regions: Regions,
    layouts: Vec<Layout>,
}

impl<'a> SlabsWork<'a> {
    /// With settings that are allowed.
    pub(super) fn new(settings: &LightFieldSettings, scene: &'a Scene, quality: Quality) -> Self {
        let regions = Regions::of(scene, settings.region_margin);
        // Nothing of reflectors is seen at order 0.
        let count = if quality.order == 0 { 0 } else { regions.boxes.len() };
        let layouts = regions.boxes[..count].iter().map(|region| Layout::new(*region, settings.st, settings.uv));
        let layouts = layouts.collect();
        Self { scene, settings: settings.clone(), order: quality.order, regions, layouts }
    }

    /// For baking.
    ///
    /// # Errors
    /// [`RenderError::Limit`] where there is nothing to be baked.
    pub(super) fn for_baking(
        settings: &LightFieldSettings,
        scene: &'a Scene,
        quality: Quality,
    ) -> Result<Self, RenderError> {
        let work = Self::new(settings, scene, quality);
        let problem = match () {
            () if quality.order == 0 => "order 0 shows no reflection: there is nothing to bake",
            () if work.layouts.is_empty() => "the scene has neither a region nor a reflector: there is nothing to bake",
            () => return Ok(work),
        };
        Err(RenderError::Limit { method: INFO.id, problem: problem.into() })
    }

    /// A number that changes with all that the slabs hold.
    pub(super) fn fingerprint(&self) -> u64 {
        let mut hasher = DefaultHasher::new();
        self.write_scene(&mut |piece| hasher.write(piece));
        hasher.write(self.settings().to_string().as_bytes());
        hasher.finish()
    }

    /// Of every region, captured now.
    pub(super) fn captured(&self, progress: &dyn Progress) -> Vec<Slabs> {
        let slabs = |layout: &Layout| {
            let rows = self.capture(layout).rows(progress);
            Slabs::new(&self.settings, layout.clone(), Rows::Captured(rows))
        };
        self.layouts.iter().map(slabs).collect()
    }

    /// Of every region, from a bake.
    ///
    /// # Errors
    /// [`RenderError::Limit`] where it is one of other regions or sizes.
    pub(super) fn baked(&self, units: &Arc<dyn Baked>) -> Result<Vec<Slabs>, RenderError> {
        let wrong = || {
            let (found, wanted) = (units.unit_count(), self.units().len());
            let problem =
                format!("the baked file has {found} units where the scene needs {wanted}, or of another size");
            RenderError::Limit { method: INFO.id, problem }
        };
        if units.unit_count() != self.rows_a_region() * self.layouts.len() {
            return Err(wrong());
        }
        let slabs = |(number, layout): (usize, &Layout)| {
            let first = number * self.rows_a_region();
            let rows = Rows::baked(units, first, layout, &Levels::new(layout.uv)).ok_or_else(wrong)?;
            Ok(Slabs::new(&self.settings, layout.clone(), rows))
        };
        self.layouts.iter().enumerate().map(slabs).collect()
    }

    fn capture(&self, layout: &Layout) -> Capture<'a> {
        Capture::new(self.scene, layout, self.settings.capture_samples, self.order.saturating_sub(1))
    }

    fn rows_a_region(&self) -> usize {
        SLABS * self.settings.st as usize
    }
}

impl BakeWork for SlabsWork<'_> {
    fn payload_version(&self) -> u32 {
        PAYLOAD_VERSION
    }

    fn settings(&self) -> toml::Table {
        let LightFieldSettings { st, uv, capture_samples, region_margin, .. } = self.settings;
        let counts = [("st", st), ("uv", uv), ("capture_samples", capture_samples), ("order", self.order)];
        let mut table: toml::Table =
            counts.into_iter().map(|(name, count)| (name.to_owned(), i64::from(count).into())).collect();
        if self.scene.region.is_none() {
            table.insert("region_margin".into(), f64::from(region_margin).into());
        }
        table
    }

    fn write_scene(&self, sink: &mut dyn FnMut(&[u8])) {
        // Reflectors may move within a region that is given.
        let moves = |object: u32| self.scene.region.is_some_and(|region| leaves(self.scene, object, &region));
        self.scene.write_identity(moves, sink);
    }

    fn units(&self) -> Vec<BakeUnit> {
        let unit = |number: usize| {
            let (region, row) = (number / self.rows_a_region(), number % self.rows_a_region());
            let st = self.settings.st as usize;
            let layout = &self.layouts[region];
            let bytes = RowSize::new(layout, &Levels::new(layout.uv)).bytes() as u64;
            BakeUnit { name: format!("region {region}, slab {}, row {}", NAMES[row / st], row % st), bytes }
        };
        (0..self.rows_a_region() * self.layouts.len()).map(unit).collect()
    }

    fn maker<'b>(&'b self) -> Box<dyn UnitMaker + 'b> {
        let captures = self.layouts.iter().map(|layout| self.capture(layout)).collect();
        Box::new(RowMaker { captures, rows_a_region: self.rows_a_region() })
    }
}

/// Makes rows of all regions.
struct RowMaker<'a> {
    captures: Vec<Capture<'a>>,
    rows_a_region: usize,
}

impl UnitMaker for RowMaker<'_> {
    fn make(&self, number: usize) -> Vec<u8> {
        let capture = self.captures.get(number / self.rows_a_region);
        capture.map(|capture| capture.row(number % self.rows_a_region).bytes()).unwrap_or_default()
    }

    fn estimate_core_secs(&self) -> f64 {
        self.captures.iter().map(Capture::estimate_core_secs).sum()
    }
}
