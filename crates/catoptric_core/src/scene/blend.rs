//! Weights of mirrors' reflections against their own colour: the reflector surface properties of sample-based
//! cameras (Popescu, Sacks, Mei 2006, section V.D and figure 14).

use glam::Vec3;

/// The share of reflection in a mirror's radiance; the rest is its own diffuse shading.
///
/// The weights of angle and distance are multiplied. The tint of the mirror colours the reflection alone.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Blend {
    /// Least and greatest weight by the angle, 0 to 1; `None`: 1 at every angle. See [`Self::weight_at`].
    pub fresnel: Option<[f32; 2]>,
    /// The weight by the distance of the reflected surface; `None`: 1 at every distance.
    pub attenuation: Option<Attenuation>,
    /// The albedo of the mirror's own diffuse shading; `None`: the material's base colour, which is its tint.
    pub diffuse: Option<Vec3>,
    /// Perceptual roughness of the mirror for highlights of lights alone, while it reflects everything else as sharply
    /// as before (figure 13's h_R); `None`: its own.
    pub highlight_roughness: Option<f32>,
}

impl Blend {
    /// The weight by the cosine between the direction to the eye and the normal, on the visible side.
    ///
    /// "Blending weights proportional to the square of the dot product of the eye vector and the surface normal",
    /// "scaled linearly to the specularity interval" (section V.D). To the letter: so the weight *falls* towards
    /// grazing angles, where that of physical surfaces rises (Schlick's approximation stays the rule of metals without
    /// a ramp).
    #[inline]
    pub fn weight_at(&self, cosine: f32) -> f32 {
        let Some([least, greatest]) = self.fresnel else { return 1.0 };
        least + (greatest - least) * (cosine * cosine).min(1.0)
    }
}

/// The fading of a reflection with the distance of the reflected surface.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Attenuation {
    /// The distance from which on the weight is the least, in scene units; above 0.
    pub distance: f32,
    /// Least and greatest weight, 0 to 1.
    pub specularity: [f32; 2],
}

impl Attenuation {
    /// The weight of a surface reflected at this distance from the mirror, along the reflected ray; infinite: the sky.
    ///
    /// The paper attenuates with the square of the distance, from the greatest weight at 0 to the least at the full
    /// distance (section V.D). Read so: what is *lost* is proportional to the square, and near things keep almost all.
    /// The other quadratic between the same ends, with its vertex at the full distance, would fall linearly at first.
    #[inline]
    pub fn weight(&self, distance: f32) -> f32 {
        let [least, greatest] = self.specularity;
        let share = (distance / self.distance).min(1.0);
        greatest - (greatest - least) * (share * share)
    }
}
