//! The keys of a mirror's blend, the same in `.toml` scenes and in glTF extras.

use super::key_error::{KeyError, positive, wrong};
use catoptric_core::scene::{Attenuation, Blend};
use glam::Vec3;

/// The keys as they were given.
#[derive(Clone, Debug, Default)]
pub(super) struct BlendKeys {
    pub(super) fresnel: Option<[f64; 2]>,
    pub(super) attenuation: Option<AttenuationKeys>,
    pub(super) diffuse: Option<[f64; 3]>,
    pub(super) highlight_roughness: Option<f64>,
}

/// The keys of an attenuation as they were given.
#[derive(Clone, Debug, Default)]
pub(super) struct AttenuationKeys {
    pub(super) distance: Option<f64>,
    pub(super) specularity: Option<[f64; 2]>,
}

/// The rule for lists of weights.
const WEIGHTS: &str = "[least, greatest] with 0 <= least <= greatest <= 1";

impl BlendKeys {
    /// The name of a key that was given.
    pub(super) fn any(&self) -> Option<&'static str> {
        let given = [
            ("fresnel", self.fresnel.is_some()),
            ("attenuation", self.attenuation.is_some()),
            ("diffuse", self.diffuse.is_some()),
            ("highlight_roughness", self.highlight_roughness.is_some()),
        ];
        given.into_iter().find(|(_, given)| *given).map(|(key, _)| key)
    }

    /// The blend they describe; returns `None` if no key was given.
    pub(super) fn blend(&self) -> Result<Option<Blend>, KeyError> {
        let fresnel = self.fresnel.map(|weights| checked("fresnel", weights)).transpose()?;
        let attenuation = self.attenuation.as_ref().map(AttenuationKeys::attenuation).transpose()?;
        let highlight_roughness = self.highlight_roughness.map(checked_roughness).transpose()?;
        let Some(diffuse) = self.diffuse else {
            let any = fresnel.is_some() || attenuation.is_some() || highlight_roughness.is_some();
            return Ok(any.then_some(Blend { fresnel, attenuation, diffuse: None, highlight_roughness }));
        };
        if diffuse.iter().any(|number| !(0.0..=1.0).contains(number)) {
            return wrong("diffuse", format!("{diffuse:?}; every number must be from 0 to 1"));
        }
        if fresnel.is_none() && attenuation.is_none() {
            let remedy = "add `attenuation`, or `fresnel = [0.5, 0.5]` for half reflection at every angle";
            return wrong("diffuse", format!("shows nowhere while all is reflection: {remedy}"));
        }
        let diffuse = Some(Vec3::from(diffuse.map(|number| number as f32)));
        Ok(Some(Blend { fresnel, attenuation, diffuse, highlight_roughness }))
    }
}

impl AttenuationKeys {
    fn attenuation(&self) -> Result<Attenuation, KeyError> {
        let needed = "needed is `attenuation = { distance = 1, specularity = [least, greatest] }`";
        let Some(distance) = self.distance else {
            return wrong("attenuation.distance", format!("missing; {needed}"));
        };
        let Some(specularity) = self.specularity else {
            return wrong("attenuation.specularity", format!("missing; {needed}"));
        };
        let distance = positive("attenuation.distance", distance)? as f32;
        Ok(Attenuation { distance, specularity: checked("attenuation.specularity", specularity)? })
    }
}

fn checked_roughness(roughness: f64) -> Result<f32, KeyError> {
    if !(0.03..=1.0).contains(&roughness) {
        return wrong("highlight_roughness", format!("{roughness}; allowed is 0.03 to 1"));
    }
    Ok(roughness as f32)
}

fn checked(key: &'static str, weights: [f64; 2]) -> Result<[f32; 2], KeyError> {
    let [least, greatest] = weights;
    if !(0.0 <= least && least <= greatest && greatest <= 1.0) {
        return wrong(key, format!("{weights:?}; must be {WEIGHTS}"));
    }
    Ok(weights.map(|weight| weight as f32))
}
