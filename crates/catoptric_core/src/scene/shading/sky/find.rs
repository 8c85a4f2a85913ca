//! Finds what the surfaces of a scene see of its environment and of its emitters.

use super::super::super::{LightVisibility, Scene};
use super::super::environment::map::Irradiance;
use super::Sky;
use super::corners::Corners;
use super::gather::{Gatherer, Sources};
use super::refine::refined;
use super::suns;
use crate::progress::{Cancelled, Progress};

/// Parts into which the sky beside its suns is divided.
const SKY_PARTS: u32 = 160;

/// Columns of a picture that suns are sought in, at most.
const MOST_COLUMNS: u32 = 1024;

impl Scene {
    /// The sky and the emitters as the surfaces see them, by means that tell what stands before them; `None` without
    /// either.
    ///
    /// # Errors
    /// [`Cancelled`].
    pub fn seen_sky(
        &self,
        visibility: &dyn LightVisibility,
        progress: &dyn Progress,
    ) -> Result<Option<Sky>, Cancelled> {
        let emitters = self.find_emitters();
        let picture = self.environment.as_ref().map(|environment| environment.picture.within(MOST_COLUMNS).1);
        if emitters.is_none() && picture.is_none() {
            return Ok(None);
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
        let gatherer = Gatherer { scene: self, visibility, sources: &Sources { sky, emitters: points }, progress };
        let shares = refined(&gatherer, &Corners::new(self))?;
        Ok(Some(Sky::new(suns, Irradiance::new(width, height, &rest), shares, emitters)))
    }
}
