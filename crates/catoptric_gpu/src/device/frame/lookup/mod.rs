//! Pictures of the surroundings in which light at mirrors and glass is looked up, in a device's memory.

mod fields;
mod layers;
mod maps;

pub(crate) use fields::DeviceFields;
pub(crate) use layers::DeviceLayers;
pub(crate) use maps::DeviceMaps;
