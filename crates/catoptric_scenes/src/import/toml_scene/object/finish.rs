//! The finish of an object: what its surface reflects and lets pass, by the factors of glTF's materials.

use super::super::super::lobes::{Details, absorption, give_role_or_lobes};
use super::super::keys::{Keys, Located};
use catoptric_core::error::SceneError;
use catoptric_core::scene::{Lobes, Material, Microfacets};
use glam::Vec3;
use std::ops::RangeInclusive;

/// The keys, each with what is allowed and what stands for it where others are given.
const NUMBERS: [(&str, RangeInclusive<f64>, f64); 9] = [
    ("metallic", SHARE, 0.0),
    ("roughness", SHARE, 0.5),
    ("ior", 1.0..=10.0, 1.5),
    ("transmission", SHARE, 0.0),
    ("dispersion", 0.0..=20.0, 0.0),
    ("attenuation_distance", 1e-9..=1e9, f64::INFINITY),
    ("coat", SHARE, 0.0),
    ("coat_roughness", SHARE, 0.0),
    ("sheen_roughness", SHARE, 0.3),
];
const COLORS: [(&str, Vec3); 2] = [("attenuation_color", Vec3::ONE), ("sheen", Vec3::ZERO)];
const THIN: &str = "thin";
/// Keys that say something with another one alone.
const NEEDED: [(&str, &str); 7] = [
    (THIN, "transmission"),
    ("dispersion", "transmission"),
    ("attenuation_distance", "transmission"),
    ("attenuation_distance", "attenuation_color"),
    ("attenuation_color", "attenuation_distance"),
    ("coat_roughness", "coat"),
    ("sheen_roughness", "sheen"),
];
const SHARE: RangeInclusive<f64> = 0.0..=1.0;

/// The finish of a surface that is not matt.
pub(super) struct Finish {
    numbers: [f32; NUMBERS.len()],
    colors: [Vec3; COLORS.len()],
    thin: bool,
}

impl Finish {
    /// Reads the keys; `None` if there is none of them.
    pub(super) fn read(table: &mut Keys<'_, '_>, unlit: bool) -> Result<Option<Self>, SceneError> {
        let mut given = Vec::new();
        let mut numbers = [0.0; NUMBERS.len()];
        for (number, (key, allowed, otherwise)) in numbers.iter_mut().zip(NUMBERS) {
            let found = table.number(key)?;
            if let Some(Located { begin, value }) = &found
                && !allowed.contains(value)
            {
                let [least, most] = [allowed.start(), allowed.end()];
                return Err(table.wrong(key, *begin, format!("{value}; allowed is {least} to {most}")));
            }
            given.extend(found.as_ref().map(|_| key));
            *number = found.map_or(otherwise, |found| found.value) as f32;
        }
        let mut colors = [Vec3::ZERO; COLORS.len()];
        for (color, (key, otherwise)) in colors.iter_mut().zip(COLORS) {
            let found = table.color(key, 1.0)?;
            given.extend(found.map(|_| key));
            *color = found.unwrap_or(otherwise);
        }
        let thin = table.boolean("thin")?;
        given.extend(thin.as_ref().map(|_| THIN));
        let Some(first) = given.first() else { return Ok(None) };
        if unlit {
            let problem = "is not for what is `unlit`, as grids of points are: write `unlit = false`, or leave it out";
            return Err(table.blame(first, problem));
        }
        let lonely = NEEDED.iter().find(|(key, needed)| given.contains(key) && !given.contains(needed));
        if let Some((key, needed)) = lonely {
            return Err(table.blame(key, format!("has no effect without `{needed}`")));
        }
        Ok(Some(Self { numbers, colors, thin: thin.is_some_and(|thin| thin.value) }))
    }

    /// Gives it to a material.
    pub(super) fn apply(&self, material: &mut Material) {
        let [
            metallic,
            roughness,
            ior,
            transmission,
            dispersion,
            attenuation_distance,
            coat,
            coat_roughness,
            sheen_roughness,
        ] = self.numbers;
        let [attenuation_color, sheen] = self.colors;
        let specular = Vec3::splat(((ior - 1.0) / (ior + 1.0)).powi(2));
        material.microfacets =
            Some(Microfacets { metallic, roughness, specular, coat, coat_roughness, ..Microfacets::default() });
        material.ior = ior;
        material.coat = coat;
        if transmission > 0.0 && !self.thin {
            material.absorption = absorption(attenuation_color, attenuation_distance);
        }
        // As in glTF's files, which say neither where it does not matter.
        let is_thin = self.thin || transmission == 0.0;
        let sheen_roughness = if sheen == Vec3::ZERO { 0.0 } else { sheen_roughness };
        let lobes = Lobes { transmission, is_thin, dispersion, sheen, sheen_roughness, ..Lobes::default() };
        give_role_or_lobes(material, lobes, Details::default());
    }
}
