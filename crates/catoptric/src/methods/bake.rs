//! Long precomputation of methods, in units that can be made anywhere and in any order.
//!
//! A method says here what its units are and makes them; planning, publishing, resuming and merging them, and the file that
//! results, are the crate `catoptric_bake`'s.

use crate::error::RenderError;
use crate::methods::Quality;
use crate::scene::Scene;

/// What a method precomputes for a scene.
///
/// A unit's bytes depend on the scene, the settings and its number alone: neither on threads, nor on the machine (of the same
/// floating point), nor on other units.
pub trait BakeWork: Sync {
    /// The version of the layout of the units' bytes: bytes of another version are not understood.
    fn payload_version(&self) -> u32;

    /// The settings that units depend on, with their values in force.
    fn settings(&self) -> toml::Table;

    /// Gives a hasher all of the scene that units depend on.
    fn write_scene(&self, sink: &mut dyn FnMut(&[u8]));

    /// The units, in order.
    fn units(&self) -> Vec<BakeUnit>;

    /// What makes them; builds what all units share.
    ///
    /// # Errors
    /// [`RenderError::Setting`] where what they are made of is not at hand.
    fn maker<'b>(&'b self) -> Result<Box<dyn UnitMaker + 'b>, RenderError>;
}

/// Makes the units of a bake, on any thread.
pub trait UnitMaker: Sync {
    /// A unit; empty where there is none of that number.
    ///
    /// # Errors
    /// [`RenderError::Setting`] where a file that a setting names cannot be used.
    fn make(&self, number: usize) -> Result<MadeUnit, RenderError>;

    /// Time that one core takes for all units, about, in seconds: found by making a small part of them.
    fn estimate_core_secs(&self) -> f64;
}

/// A unit that was made.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct MadeUnit {
    /// Its bytes.
    pub bytes: Vec<u8>,
    /// What people may want to know of how it was made, such as what is left of an error; no part of the bake.
    pub note: Option<String>,
}

/// One unit of a bake.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct BakeUnit {
    /// What it is, for people.
    pub name: String,
    /// How many bytes it has.
    pub bytes: u64,
}

/// All units of a finished bake.
pub trait Baked: Send + Sync {
    /// How many there are.
    fn unit_count(&self) -> usize;

    /// The bytes of a unit; empty where there is none of that number.
    fn unit(&self, number: usize) -> &[u8];
}

/// Makes the work of a method from a table of its settings.
pub type MakeBakeWork = for<'a> fn(&toml::Table, &'a Scene, Quality) -> Result<Box<dyn BakeWork + 'a>, RenderError>;
