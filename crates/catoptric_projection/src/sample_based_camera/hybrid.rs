//! Reflectors that do not deserve cameras: the user's rule which of them show environment maps (Popescu, Sacks, Mei
//! 2006, section VII-C and Figure 21).

use super::rays::extent::extent;
use super::settings::{SampleBasedCameraSettings, patterns};
use crate::draw::MapsInView;
use crate::draw::stages::Stages;
use crate::find::ray_map::RayField;
use catoptric_core::progress::Progress;
use catoptric_core::scene::Scene;
use catoptric_engine::error::RenderError;
use catoptric_engine::method::reflector_maps::{ReflectorMapSettings, ReflectorMaps};
use catoptric_engine::method::{Report, Settings};

/// True for objects that show environment maps because of their names.
///
/// # Errors
/// Names that no reflector or lens has.
pub(super) fn named(settings: &SampleBasedCameraSettings, scene: &Scene) -> Result<Vec<bool>, RenderError> {
    let fail = |problem: String| RenderError::Setting { method: SampleBasedCameraSettings::METHOD, problem };
    let names = patterns(&settings.environment).map_err(fail)?;
    let mut mapped = vec![false; scene.objects.len()];
    let objects = scene.specular_objects();
    for &object in &objects {
        mapped[object as usize] = names.is_match(&scene.objects[object as usize].name);
    }
    if !names.is_empty() && !mapped.contains(&true) {
        let known: Vec<&str> = objects.iter().map(|&object| scene.objects[object as usize].name.as_str()).collect();
        let problem = format!(
            "environment = \"{}\" names no reflector or lens; there are: {}",
            settings.environment,
            known.join(", ")
        );
        return Err(fail(problem));
    }
    Ok(mapped)
}

/// True for objects that show environment maps by the settings' rule in a field of view rays.
///
/// # Errors
/// As for [`named`].
fn mapped(settings: &SampleBasedCameraSettings, scene: &Scene, field: &dyn RayField) -> Result<Vec<bool>, RenderError> {
    let mut mapped = named(settings, scene)?;
    for object in scene.specular_objects() {
        // A reflector that reaches behind the eye is not small.
        let small = extent(&scene.objects[object as usize].bounds, field).is_some_and(|[low, high]| {
            (high[0] - low[0]).max(high[1] - low[1]) < f64::from(settings.environment_below_px)
        });
        mapped[object as usize] |= small;
    }
    Ok(mapped)
}

/// The numbers of the objects of such a list.
pub(super) fn numbers(mapped: &[bool]) -> Vec<u32> {
    (0..).zip(mapped).filter(|(_, mapped)| **mapped).map(|(object, _)| object).collect()
}

/// The reflectors of a view that show environment maps.
pub(super) struct MappedReflectors {
    /// True for each object that does.
    pub(super) mapped: Vec<bool>,
    /// Their maps; `None` until they are captured.
    maps: Option<ReflectorMaps>,
}

impl MappedReflectors {
    /// The mapped reflectors of a view, by the settings' rule, without their maps.
    ///
    /// # Errors
    /// Names that no reflector or lens has.
    pub(super) fn new(
        settings: &SampleBasedCameraSettings,
        scene: &Scene,
        field: &dyn RayField,
    ) -> Result<Self, RenderError> {
        Ok(Self { mapped: mapped(settings, scene, field)?, maps: None })
    }

    /// True if another view or moment has the same mapped reflectors.
    ///
    /// # Errors
    /// As for [`Self::new`].
    pub(super) fn fits(
        &self,
        settings: &SampleBasedCameraSettings,
        scene: &Scene,
        field: &dyn RayField,
    ) -> Result<bool, RenderError> {
        Ok(self.mapped == mapped(settings, scene, field)?)
    }

    /// Captures the maps that are missing.
    ///
    /// # Errors
    /// As [`ReflectorMaps::capture`].
    pub(super) fn complete(
        &mut self,
        settings: &SampleBasedCameraSettings,
        (scene, order): (&Scene, u32),
        stages: &mut Stages<'_>,
    ) -> Result<(), RenderError> {
        if self.maps.is_none() && self.mapped.contains(&true) {
            self.maps = Some(captured(settings, scene, &self.mapped, order, stages.progress)?);
            stages.lap("capture");
        }
        Ok(())
    }

    /// Drops the maps, which show objects that have moved.
    pub(super) fn forget(&mut self) {
        self.maps = None;
    }

    /// The objects' numbers.
    pub(super) fn objects(&self) -> Vec<u32> {
        numbers(&self.mapped)
    }

    pub(super) fn describe(&self, report: &mut Report) {
        if let Some(maps) = &self.maps {
            report.fallbacks.insert("environment_mapped_reflectors", self.objects().len() as u64);
            report.bytes.insert("environment_maps", maps.byte_count());
        }
    }

    pub(super) fn in_view(&self) -> MapsInView<'_> {
        MapsInView { whole: self.maps.as_ref(), far: None }
    }
}

/// The environment maps of these objects. The order bounds how often reflectors show each other in them.
fn captured(
    settings: &SampleBasedCameraSettings,
    scene: &Scene,
    mapped: &[bool],
    order: u32,
    progress: &dyn Progress,
) -> Result<ReflectorMaps, RenderError> {
    let settings = ReflectorMapSettings { size: settings.environment_size, ..ReflectorMapSettings::default() };
    // All reflectors have maps during the capture: they are seen in each other.
    let maps = ReflectorMaps::capture(&settings, scene, &scene.specular_objects(), order, progress)?;
    Ok(maps.retaining(mapped))
}
