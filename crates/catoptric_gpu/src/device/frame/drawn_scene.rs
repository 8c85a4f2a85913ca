//! A scene on a device as frames draw it.

use super::confined::VirtualTables;
use super::picture::PictureTables;
use super::reflections::Reflections;
use crate::device::scene::DeviceScene;
use std::sync::{Arc, Mutex, PoisonError};

/// A scene's tables, what becomes of light at its reflectors, and what the last picture was drawn with.
#[derive(Debug)]
pub(crate) struct DrawnScene {
    pub(crate) resident: DeviceScene,
    pub(crate) reflections: Reflections,
    /// Textures and tables of the size of the last picture.
    pub(super) picture: Mutex<Option<Arc<PictureTables>>>,
    /// For virtual geometry that is found on the device.
    pub(super) virtual_tables: Mutex<Option<Arc<VirtualTables>>>,
}

impl DrawnScene {
    /// A scene that draws on with the tables of the last picture of another moment of it, if that is given.
    pub(crate) fn new(resident: DeviceScene, reflections: Reflections, old: Option<&Self>) -> Self {
        let picture = old.and_then(|old| old.picture.lock().unwrap_or_else(PoisonError::into_inner).clone());
        let virtual_tables =
            old.and_then(|old| old.virtual_tables.lock().unwrap_or_else(PoisonError::into_inner).clone());
        Self { resident, reflections, picture: Mutex::new(picture), virtual_tables: Mutex::new(virtual_tables) }
    }
}
