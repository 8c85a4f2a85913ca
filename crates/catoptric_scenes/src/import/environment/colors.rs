//! Colours of other primaries in those of Rec. 709 (sRGB), by CIE 1931 chromaticities.

use glam::{DMat3, DVec2, DVec3};

/// The chromaticities of a picture's red, green, blue and white.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Primaries {
    pub(super) red: DVec2,
    pub(super) green: DVec2,
    pub(super) blue: DVec2,
    pub(super) white: DVec2,
}

impl Primaries {
    const REC_709: Self = Self {
        red: DVec2::new(0.64, 0.33),
        green: DVec2::new(0.30, 0.60),
        blue: DVec2::new(0.15, 0.06),
        white: DVec2::new(0.3127, 0.3290),
    };

    /// The tristimulus values X, Y, Z as primaries.
    pub(super) const XYZ: Self =
        Self { red: DVec2::X, green: DVec2::Y, blue: DVec2::ZERO, white: DVec2::splat(1.0 / 3.0) };

    /// Converts these primaries' colours; `None`: they are those of Rec. 709, or no colours can be made of them, as of
    /// the zeros that Photoshop writes where it means those of Rec. 709. Another white becomes white (by Bradford's
    /// adaptation), but X, Y and Z are colours as they are.
    pub(super) fn to_rec_709(self) -> Option<Conversion> {
        let near = |other: &Self| {
            let pairs = [(self.red, other.red), (self.green, other.green), (self.blue, other.blue)];
            pairs.iter().chain([&(self.white, other.white)]).all(|(one, other)| one.distance(*other) < 2e-3)
        };
        if near(&Self::REC_709) {
            return None;
        }
        let adaptation = match near(&Self::XYZ) {
            true => DMat3::IDENTITY,
            false => bradford(self.white_xyz(), Self::REC_709.white_xyz()),
        };
        let matrix = Self::REC_709.to_xyz().inverse() * adaptation * self.to_xyz();
        let columns = matrix.to_cols_array();
        columns.iter().all(|value| value.abs() <= 1e3).then_some(Conversion(matrix))
    }

    /// The colour of white, its luminance 1.
    fn white_xyz(self) -> DVec3 {
        xyz(self.white) / self.white.y
    }

    /// From a colour to X, Y, Z, of which white has the luminance 1.
    fn to_xyz(self) -> DMat3 {
        let columns = DMat3::from_cols(xyz(self.red), xyz(self.green), xyz(self.blue));
        columns * DMat3::from_diagonal(columns.inverse() * self.white_xyz())
    }
}

/// The conversion of colours of one set of primaries to another.
#[derive(Clone, Copy, Debug)]
pub(super) struct Conversion(DMat3);

impl Conversion {
    /// A colour; its values that are no numbers count as none, infinite ones as the brightest of half floats.
    pub(super) fn of(&self, color: [f32; 3]) -> [f32; 3] {
        let finite = |value: f32| match value {
            f32::INFINITY => 65504.0,
            value if value.is_finite() => f64::from(value),
            _ => 0.0,
        };
        (self.0 * DVec3::from(color.map(finite))).as_vec3().to_array()
    }
}

fn xyz(chromaticity: DVec2) -> DVec3 {
    DVec3::new(chromaticity.x, chromaticity.y, 1.0 - chromaticity.x - chromaticity.y)
}

/// From colours under one white to those that look alike under another (Lam 1985).
fn bradford(from: DVec3, to: DVec3) -> DMat3 {
    let cones = DMat3::from_cols(
        DVec3::new(0.8951, -0.7502, 0.0389),
        DVec3::new(0.2664, 1.7135, -0.0685),
        DVec3::new(-0.1614, 0.0367, 1.0296),
    );
    cones.inverse() * DMat3::from_diagonal((cones * to) / (cones * from)) * cones
}
