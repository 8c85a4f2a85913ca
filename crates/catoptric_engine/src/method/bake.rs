//! Long precomputation of methods, in units that can be made anywhere and in any order.
//!
//! A method declares its units here and makes them; planning, publishing, resuming and merging them, and the file that
//! results, are the crate `catoptric_bake`'s.

use crate::error::RenderError;
use crate::method::Quality;
use catoptric_core::scene::Scene;
use std::ops::Range;

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

    /// The units, in order. What they are may follow from the scene, so this may take as long as a picture; it is not
    /// needed where a finished bake is looked up.
    ///
    /// # Errors
    /// [`RenderError::Limit`] where what is made at once does not fit into memory.
    fn units(&self) -> Result<Vec<BakeUnit>, RenderError>;

    /// The maker of the units; builds what all units share.
    ///
    /// # Errors
    /// [`RenderError::Setting`] if an input that they are made of is missing.
    fn maker<'b>(&'b self) -> Result<Box<dyn UnitMaker + 'b>, RenderError>;
}

/// Makes the units of a bake, on any thread.
pub trait UnitMaker: Sync {
    /// The units of a batch, by their numbers: a unit with all that follow it and are made together with it
    /// ([`BakeUnit::with_previous`]). None for other numbers.
    ///
    /// # Errors
    /// [`RenderError::Setting`] if a file that a setting names cannot be used.
    fn make(&self, batch: Range<usize>) -> Result<Vec<MadeUnit>, RenderError>;

    /// Time that one core takes for all units, about, in seconds: found by making a small part of them.
    fn estimate_core_secs(&self) -> f64;

    /// Bytes of all units, about, where some may have fewer than was said ([`BakeUnit::at_most`]); else `None`.
    fn estimate_bytes(&self) -> Option<u64> {
        None
    }
}

/// A unit that was made.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct MadeUnit {
    /// The bytes of the unit's payload.
    pub bytes: Vec<u8>,
    /// A note for people on how it was made, such as the remaining error; no part of the bake.
    pub note: Option<String>,
}

/// One unit of a bake.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct BakeUnit {
    /// The unit's name, for people.
    pub name: String,
    /// The number of bytes of the unit's payload, or the most that it may have.
    pub bytes: u64,
    /// The payload may have fewer bytes: how many is known only once it is made.
    pub at_most: bool,
    /// The unit is made at once with the unit before it, from the same work: both are of one batch, which no two
    /// machines share. Units are small for stores and for what a damaged one costs, batches as large as work is.
    pub with_previous: bool,
}

/// The batches of units: ranges of numbers that are made at once.
pub fn batches(with_previous: impl IntoIterator<Item = bool>) -> Vec<Range<usize>> {
    let mut batches: Vec<Range<usize>> = Vec::new();
    for (number, with_previous) in with_previous.into_iter().enumerate() {
        match batches.last_mut().filter(|_| with_previous) {
            Some(batch) => batch.end = number + 1,
            None => batches.push(number..number + 1),
        }
    }
    batches
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
