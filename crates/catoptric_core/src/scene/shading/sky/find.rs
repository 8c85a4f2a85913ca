//! Finds what the surfaces of a scene see of its environment, of its emitters, and of each other.

use super::super::super::{LightVisibility, Scene};
use super::super::environment::map::Irradiance;
use super::corners::Corners;
use super::gather::{Gatherer, Sources};
use super::refine::{Places, refined};
use super::scattered::Scattering;
use super::{Sky, suns};
use crate::progress::{Cancelled, Progress};
use std::sync::Arc;

/// Parts into which the sky beside its suns is divided.
const SKY_PARTS: u32 = 160;

/// Columns of a picture that suns are sought in, at most.
const MOST_COLUMNS: u32 = 1024;

impl Scene {
    /// Sets what the surfaces see of the sky and of emitters, and after so many bounces of each other, by means that
    /// tell what stands before them, which become those of the scene; nothing where no such light is.
    ///
    /// # Errors
    /// [`Cancelled`]; nothing is shadowed then.
    pub fn see_sky(
        &mut self,
        visibility: Arc<dyn LightVisibility>,
        bounces: u32,
        progress: &dyn Progress,
    ) -> Result<(), Cancelled> {
        self.sky = None;
        let emitters = self.find_emitters();
        let picture = self.environment.as_ref().map(|environment| environment.picture.within(MOST_COLUMNS).1);
        if emitters.is_none() && picture.is_none() && (bounces == 0 || self.lights.is_empty()) {
            return Ok(());
        }
        let (width, height, radiance) = picture.unwrap_or((1, 1, vec![[0.0; 3]]));
        let (mut suns, rest) = suns::suns_and_rest(width, height, radiance);
        let mut sky = Vec::new();
        if let Some(environment) = &self.environment {
            sky = suns::parts(width, height, &rest, SKY_PARTS / 2);
            sky.iter_mut().for_each(|part| part.towards = environment.scene_from_picture(part.towards));
            suns.iter_mut().for_each(|sun| sun.direction = environment.scene_from_picture(sun.direction));
        }
        let points = emitters.as_ref().map_or(Vec::new(), |emitters| self.points_of(emitters));
        let sources = Sources { sky, emitters: points };
        let gatherer = Gatherer { scene: self, visibility: &*visibility, sources: &sources, progress };
        let corners = Corners::new(self);
        let mut places = Places::new(&corners);
        let shares = refined(&gatherer, &mut places)?;
        let rest = Irradiance::new(width, height, &rest);
        let mut sky = Arc::new(Sky { suns, rest, shares, emitters, is_scattered: false });
        let before = self.light_visibility.replace(visibility.clone());
        self.sky = Some(sky.clone());
        let size = self.bounds.diagonal().max(f32::MIN_POSITIVE);
        let scattering = Scattering { scene: self, size, sky: &sky, visibility: &*visibility, progress };
        let irradiances = (bounces > 0).then(|| scattering.irradiances(&places, bounces)).transpose();
        self.sky = None;
        let irradiances = irradiances.inspect_err(|_| self.light_visibility = before)?;
        if let (Some(irradiances), Some(sky)) = (irradiances, Arc::get_mut(&mut sky)) {
            for (arriving, irradiance) in sky.shares.arriving.iter_mut().zip(irradiances) {
                for (sum, irradiance) in
                    arriving.by_surfaces.iter_mut().zip(irradiance).filter(|(_, more)| more.is_finite())
                {
                    *sum += irradiance;
                }
            }
            sky.is_scattered = true;
        }
        self.sky = Some(sky);
        Ok(())
    }
}
