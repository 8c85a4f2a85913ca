//! Long precomputation of methods, in units that can be made anywhere and in any order.
//!
//! A method declares its units here and makes them; planning, publishing, resuming and merging them, and the file that
//! results, are the crate `catoptric_bake`'s.

use crate::error::RenderError;
use crate::methods::Quality;
use crate::scene::Scene;

/// The long precomputation of a method for a scene.
///
/// A unit's bytes depend on the scene, the settings and its number alone: neither on threads, nor on the machine (of
/// the same floating point), nor on other units.
pub trait BakeWork: Sync {
    /// The version of the layout of the units' bytes: bytes of another version are not understood.
    fn payload_version(&self) -> u32;

    /// The settings that units depend on, with their values in force.
    fn settings(&self) -> toml::Table;

    /// Writes all of the scene that units depend on into a hasher.
    fn write_scene(&self, sink: &mut dyn FnMut(&[u8]));

    /// The units, in order.
    fn units(&self) -> Vec<BakeUnit>;

    /// The maker of the units; builds what all units share.
    ///
    /// # Errors
    /// [`RenderError::Setting`] if an input that they are made of is missing.
    fn maker<'b>(&'b self) -> Result<Box<dyn UnitMaker + 'b>, RenderError>;
}

/// Makes the units of a bake, on any thread.
pub trait UnitMaker: Sync {
    /// A unit; empty if there is none of that number.
    ///
    /// # Errors
    /// [`RenderError::Setting`] if a file that a setting names cannot be used.
    fn make(&self, number: usize) -> Result<MadeUnit, RenderError>;

    /// Time that one core takes for all units, about, in seconds: found by making a small part of them.
    fn estimate_core_secs(&self) -> f64;
}

/// A unit that was made.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct MadeUnit {
    /// Its bytes.
    pub bytes: Vec<u8>,
    /// A note for people on how it was made, such as the remaining error; no part of the bake.
    pub note: Option<String>,
}

/// One unit of a bake.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct BakeUnit {
    /// Its name, for people.
    pub name: String,
    /// Its number of bytes.
    pub bytes: u64,
}

/// All units of a finished bake.
pub trait Baked: Send + Sync {
    /// The number of units.
    fn unit_count(&self) -> usize;

    /// The bytes of a unit; empty if there is none of that number.
    fn unit(&self, number: usize) -> &[u8];
}

/// Makes the work of a method from a table of its settings.
pub type MakeBakeWork = for<'a> fn(&toml::Table, &'a Scene, Quality) -> Result<Box<dyn BakeWork + 'a>, RenderError>;
