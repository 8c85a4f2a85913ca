//! The ways in which light goes on at reflectors and lenses of a scene on a device.

use super::confined::{DeviceMirrors, OnDevice};
use super::lookup::{DeviceFields, DeviceLayers, DeviceMaps};
use super::paths::Way;
use crate::tables::SceneFeatures;

/// The way in which light goes on at reflectors and lenses.
#[derive(Debug)]
pub(crate) enum Reflections {
    /// Rays are followed.
    Followed,
    /// Light is looked up in environment maps.
    LookedUp(DeviceMaps),
    /// The scene is mirrored in flat mirrors.
    Mirrored(DeviceMirrors),
    /// Light is looked up in light fields about regions.
    Fields(DeviceFields),
    /// Light is looked up in layers about groups.
    Layers(Box<DeviceLayers>),
    /// Each frame comes with geometry that appears on paths; where the device can find that, what it takes.
    Projected(Option<OnDevice>),
}

impl Reflections {
    /// The light fields.
    pub(crate) fn fields(&self) -> Option<&DeviceFields> {
        match self {
            Self::Fields(fields) => Some(fields),
            _ => None,
        }
    }

    /// How what rays hit becomes known; `first_lists` if virtual geometry is found on the device.
    pub(super) fn way(&self, first_lists: bool) -> Way {
        match self {
            Self::Followed => Way::Tiles,
            Self::LookedUp(_) | Self::Fields(_) | Self::Layers(_) => Way::LookUp,
            Self::Mirrored(_) => Way::Mirrors,
            Self::Projected(_) if first_lists => Way::FirstLists,
            Self::Projected(_) => Way::Lists,
        }
    }

    /// The features of a scene that are drawn in this way.
    pub(crate) fn narrowed(&self, features: SceneFeatures) -> SceneFeatures {
        match self {
            Self::Mirrored(_) => features.of_smooth_mirrors(),
            Self::Projected(_) => features.with_lists(),
            _ => features,
        }
    }

    /// True for triangles of reflectors and lenses that show anything but their own light.
    pub(crate) fn show(&self, triangle: u32) -> bool {
        match self {
            Self::Mirrored(mirrors) => mirrors.shows(triangle),
            _ => true,
        }
    }
}
