//! Slabs as work in units: a row of views each.

use super::capture::{Capture, leaves};
use super::layout::{FieldLayout, SLABS};
use super::settings::{Layout, LightFieldSettings};
use super::slabs::Slabs;
use super::slabs::form::ViewForm;
use super::slabs::rows::{Rows, ViewRow};
#[cfg(feature = "files")]
use super::slabs::views::Views;
use crate::shared::memory::fit_into_memory;
use crate::shared::regions::Regions;
use catoptric_core::progress::Progress;
use catoptric_core::scene::Scene;
use catoptric_engine::error::RenderError;
use catoptric_engine::method::bake::{BakeUnit, BakeWork, Baked, MadeUnit, UnitMaker};
use catoptric_engine::method::{Quality, Settings};
use std::ops::Range;
use std::sync::Arc;

/// The layout of a unit's bytes: texels or blocks of a row of views, then their parallaxes. Also how they are captured:
/// the version changes with the contents.
const PAYLOAD_VERSION: u32 = 3;

/// The names of slabs.
const NAMES: [&str; SLABS] = ["+x", "-x", "+y", "-y", "+z", "-z"];

/// The front of the number that stands for pictures of views, where these are not at hand: they are baked.
const PICTURES: &str = "pictures:";

/// Source of views.
enum ViewSource {
    /// The scene: they are captured.
    Scene,
    /// Pictures, with a number that stands for them.
    #[cfg(feature = "files")]
    Pictures(Views, String),
    /// A bake of the pictures that this number stands for.
    Baked(String),
}

/// The slabs about all regions of a scene.
pub(super) struct SlabsWork<'a> {
    source: ViewSource,
    scene: &'a Scene,
    settings: LightFieldSettings,
    /// Highest number of specular events on a path from the eye.
    order: u32,
    pub(super) regions: Regions,
    layouts: Vec<FieldLayout>,
    form: ViewForm,
}

impl<'a> SlabsWork<'a> {
    /// The work for settings that are allowed.
    ///
    /// # Errors
    /// [`RenderError::Setting`] where views are given that are not of the scene's region.
    pub(super) fn new(settings: &LightFieldSettings, scene: &'a Scene, quality: Quality) -> Result<Self, RenderError> {
        let regions = Regions::of(scene, settings.region_margin);
        // At order 0 no reflector is seen.
        let count = if quality.order == 0 { 0 } else { regions.boxes.len() };
        let layouts = regions.boxes[..count].iter().map(|region| FieldLayout::new(settings, *region));
        let layouts: Vec<FieldLayout> = layouts.collect();
        if !settings.views.is_empty() && settings.layout != Layout::Slabs {
            let problem = "views: pictures made elsewhere are views of slabs; set layout=slabs, or leave views out";
            return Err(RenderError::Setting { method: LightFieldSettings::METHOD, problem: problem.into() });
        }
        let source = if settings.views.is_empty() || count == 0 {
            ViewSource::Scene
        } else if settings.views.starts_with(PICTURES) {
            ViewSource::Baked(settings.views.clone())
        } else {
            Self::pictures(settings, &layouts)?
        };
        let (settings, form) = (settings.clone(), ViewForm::new(settings.uv, settings.compression));
        Ok(Self { source, scene, settings, order: quality.order, regions, layouts, form })
    }

    #[cfg(feature = "files")]
    fn pictures(settings: &LightFieldSettings, layouts: &[FieldLayout]) -> Result<ViewSource, RenderError> {
        let views = Views::open(std::path::Path::new(&settings.views))?;
        views.check(settings, layouts)?;
        let number = format!("{PICTURES}{}", views.fingerprint()?);
        Ok(ViewSource::Pictures(views, number))
    }

    #[cfg(not(feature = "files"))]
    fn pictures(_: &LightFieldSettings, _: &[FieldLayout]) -> Result<ViewSource, RenderError> {
        Err(RenderError::Setting {
            method: LightFieldSettings::METHOD,
            problem: "views: this program reads no files".into(),
        })
    }

    /// Expected manifest of views that are made elsewhere.
    ///
    /// # Errors
    /// [`RenderError::Setting`] where the scene has not just one region.
    #[cfg(feature = "files")]
    pub(super) fn manifest(&self) -> Result<String, RenderError> {
        match &self.layouts[..] {
            [FieldLayout::Slabs(layout)] => super::slabs::views::manifest(layout),
            [FieldLayout::Box(_)] => {
                let problem = "views made elsewhere are those of slabs: set layout=slabs".into();
                Err(RenderError::Setting { method: LightFieldSettings::METHOD, problem })
            }
            others => {
                let problem = format!("views are of one region, the scene has {}; give it a [region]", others.len());
                Err(RenderError::Setting { method: LightFieldSettings::METHOD, problem })
            }
        }
    }

    /// The work of a bake.
    ///
    /// # Errors
    /// [`RenderError::Limit`] where there is nothing to be baked.
    pub(super) fn for_baking(
        settings: &LightFieldSettings,
        scene: &'a Scene,
        quality: Quality,
    ) -> Result<Self, RenderError> {
        let work = Self::new(settings, scene, quality)?;
        let problem = match () {
            () if quality.order == 0 => "order 0 shows no reflection: there is nothing to bake",
            () if work.layouts.is_empty() => "the scene has neither a region nor a reflector: there is nothing to bake",
            () => return Ok(work),
        };
        Err(RenderError::Limit { method: LightFieldSettings::METHOD, problem: problem.into() })
    }

    /// A number that changes with all that the slabs hold.
    pub(super) fn fingerprint(&self) -> [u8; 32] {
        let mut hasher = blake3::Hasher::new();
        self.write_scene(&mut |piece| {
            hasher.update(piece);
        });
        hasher.update(self.settings().to_string().as_bytes());
        hasher.finalize().into()
    }

    /// Slabs of every region, captured now.
    ///
    /// # Errors
    /// [`RenderError::Setting`] where pictures of views cannot be used.
    /// [`RenderError::Limit`] where they would not fit into memory.
    pub(super) fn captured(&self, progress: &dyn Progress) -> Result<Vec<Slabs>, RenderError> {
        self.fit_into_memory()?;
        let maker = self.row_maker()?;
        let slabs = |(region, layout): (usize, &FieldLayout)| {
            let rows = Rows::captured(layout, &self.form, progress, |row| maker.row(region, row))?;
            Ok(Slabs::new(&self.settings, layout.clone(), rows))
        };
        self.layouts.iter().enumerate().map(slabs).collect()
    }

    /// Slabs of every region, from a bake.
    ///
    /// # Errors
    /// [`RenderError::Limit`] where it is one of other regions or sizes.
    pub(super) fn baked(&self, units: &Arc<dyn Baked>) -> Result<Vec<Slabs>, RenderError> {
        let wrong = || {
            let (found, wanted) = (units.unit_count(), self.row_count());
            let problem =
                format!("the baked file has {found} units where the scene needs {wanted}, or of another size");
            RenderError::Limit { method: LightFieldSettings::METHOD, problem }
        };
        if units.unit_count() != self.row_count() {
            return Err(wrong());
        }
        let mut first = 0;
        let slabs = |layout: &FieldLayout| {
            let rows = Rows::baked(units, first, layout, &self.form).ok_or_else(wrong)?;
            first += layout.row_count();
            Ok(Slabs::new(&self.settings, layout.clone(), rows))
        };
        self.layouts.iter().map(slabs).collect()
    }

    /// # Errors
    /// [`RenderError::Limit`] where they do not.
    fn fit_into_memory(&self) -> Result<(), RenderError> {
        let bytes = self.layouts.iter().map(|layout| layout.view_count() * self.form.bytes_a_view() as u64).sum();
        let LightFieldSettings { st, uv, .. } = self.settings;
        let table = format!("slabs of st = {st} and uv = {uv} about {} regions", self.layouts.len());
        fit_into_memory(LightFieldSettings::METHOD, &table, bytes, "bake them: such files need no memory")
    }

    fn capture(&self, layout: &FieldLayout) -> Capture<'a> {
        Capture::new(self.scene, layout, self.settings.capture_samples, self.order.saturating_sub(1))
    }

    /// # Errors
    /// [`RenderError::Setting`] where the pictures of the views are not at hand.
    fn row_maker(&self) -> Result<RowMaker<'_>, RenderError> {
        let captures = match &self.source {
            ViewSource::Scene => self.layouts.iter().map(|layout| self.capture(layout)).collect(),
            #[cfg(feature = "files")]
            ViewSource::Pictures(..) => Vec::new(),
            ViewSource::Baked(number) => {
                let problem = format!("views = `{number}` are those of a bake: give that, or the pictures' manifest");
                return Err(RenderError::Setting { method: LightFieldSettings::METHOD, problem });
            }
        };
        Ok(RowMaker { work: self, captures })
    }

    /// Regions that have slabs.
    pub(super) fn region_count(&self) -> usize {
        self.layouts.len()
    }

    /// Rows of views of all regions.
    fn row_count(&self) -> usize {
        self.layouts.iter().map(FieldLayout::row_count).sum()
    }

    /// The region of a row by its number among those of all regions, and its number among that region's.
    fn region_of_row(&self, number: usize) -> Option<(usize, usize)> {
        let mut row = number;
        for (region, layout) in self.layouts.iter().enumerate() {
            match row.checked_sub(layout.row_count()) {
                Some(rest) => row = rest,
                None => return Some((region, row)),
            }
        }
        None
    }
}

impl BakeWork for SlabsWork<'_> {
    fn payload_version(&self) -> u32 {
        PAYLOAD_VERSION
    }

    fn settings(&self) -> toml::Table {
        let pictures = match &self.source {
            ViewSource::Scene => None,
            #[cfg(feature = "files")]
            ViewSource::Pictures(_, number) => Some(number),
            ViewSource::Baked(number) => Some(number),
        };
        let mut table = self.settings.baked();
        match pictures {
            Some(number) => {
                table.remove("capture_samples");
                table.insert("views".into(), number.as_str().into());
            }
            None => drop(table.insert("order".into(), i64::from(self.order).into())),
        }
        if self.scene.region.is_some() {
            table.remove("region_margin");
        }
        table
    }

    fn write_scene(&self, sink: &mut dyn FnMut(&[u8])) {
        let ViewSource::Scene = self.source else {
            // Pictures are of places alone.
            self.layouts.iter().for_each(|layout| sink(format!("{:?}", layout.region()).as_bytes()));
            return;
        };
        // Reflectors may move within a region that is given.
        let moves = |object: u32| self.scene.region.is_some_and(|region| leaves(self.scene, object, &region));
        self.scene.write_identity(moves, sink);
    }

    fn units(&self) -> Result<Vec<BakeUnit>, RenderError> {
        let of_region = |(region, layout): (usize, &FieldLayout)| -> Vec<BakeUnit> {
            let unit = |number: usize| {
                let (slab, row) = layout.place_of_row(number);
                let bytes = u64::from(layout.views_in_row(number)) * self.form.bytes_a_view() as u64;
                let name = format!("region {region}, slab {}, row {row}", NAMES[slab]);
                BakeUnit { name, bytes, at_most: false, with_previous: false }
            };
            (0..layout.row_count()).map(unit).collect()
        };
        Ok(self.layouts.iter().enumerate().flat_map(of_region).collect())
    }

    fn maker<'b>(&'b self) -> Result<Box<dyn UnitMaker + 'b>, RenderError> {
        Ok(Box::new(self.row_maker()?))
    }
}

/// Makes rows of all regions.
struct RowMaker<'a> {
    work: &'a SlabsWork<'a>,
    /// Captures of every region.
    captures: Vec<Capture<'a>>,
}

impl RowMaker<'_> {
    fn row(&self, region: usize, row: usize) -> Result<ViewRow, RenderError> {
        match (&self.work.source, &self.work.layouts[region]) {
            #[cfg(feature = "files")]
            (ViewSource::Pictures(views, _), FieldLayout::Slabs(layout)) => views.row(layout, row),
            _ => Ok(self.captures[region].row(row)),
        }
    }
}

impl UnitMaker for RowMaker<'_> {
    fn make(&self, batch: Range<usize>) -> Result<Vec<MadeUnit>, RenderError> {
        let rows = batch.filter_map(|number| self.work.region_of_row(number));
        let unit = |(region, row): (usize, usize)| {
            Ok(MadeUnit { bytes: self.row(region, row)?.baked(&self.work.form), note: None })
        };
        rows.map(unit).collect()
    }

    fn estimate_core_secs(&self) -> f64 {
        // Pictures are read as fast as the disk is.
        self.captures.iter().map(|capture| capture.estimate_core_secs(self.work.settings.compression)).sum()
    }
}
