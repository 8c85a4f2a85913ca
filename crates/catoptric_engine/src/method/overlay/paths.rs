//! Pixels by the path of light that they show, the same for all methods.

use super::{Overlay, OverlayKind};
use crate::method::projector::SpecularPath;
use crate::optics::path::bundle::Bounce;
use catoptric_core::scene::Scene;
use rustc_hash::FxHashMap;
use std::cmp::Ordering;
use std::collections::{BTreeMap, BTreeSet};
use std::hash::Hash;
use std::sync::{Mutex, PoisonError};

/// A path's name: for each bounce its kind and its object, from the eye on.
pub fn name_of(scene: &Scene, path: &SpecularPath) -> String {
    let name = |bounce: &Bounce| format!("{} {}", bounce.kind.letter(), scene.objects[bounce.object as usize].name);
    path.bounces.iter().map(name).collect::<Vec<_>>().join(" > ")
}

/// Short paths first.
fn by_length(path: &SpecularPath) -> (usize, &[Bounce]) {
    (path.bounces.len(), &path.bounces)
}

/// Pixels by the path that they show, row by row; those without a bounce have no group. Groups of short paths come
/// first.
pub fn of_pixels(scene: &Scene, size: [u32; 2], pixels: &[&SpecularPath]) -> Overlay {
    of_named(size, pixels, |path| name_of(scene, path))
}

/// The same with names that are given.
pub fn of_named(size: [u32; 2], pixels: &[&SpecularPath], name: impl Fn(&SpecularPath) -> String) -> Overlay {
    let mut overlay = Overlay::new(OverlayKind::Paths, size);
    let paths: BTreeSet<(usize, &[Bounce])> = pixels.iter().map(|path| by_length(path)).collect();
    let group = |(length, bounces): (usize, &[Bounce])| match length {
        0 => 0,
        _ => overlay.group(name(&SpecularPath { bounces: bounces.to_vec() })),
    };
    let groups: Vec<u16> = paths.iter().copied().map(group).collect();
    let group_of: BTreeMap<(usize, &[Bounce]), u16> = paths.into_iter().zip(groups).collect();
    overlay.pixels = pixels.iter().map(|path| group_of.get(&by_length(path)).copied().unwrap_or(0)).collect();
    overlay
}

/// Numbers of things that shaders find, as threads come upon them: colours that are exact in single precision.
pub struct Numbers<T>(Mutex<FxHashMap<T, u32>>);

impl<T> Default for Numbers<T> {
    fn default() -> Self {
        Self(Mutex::default())
    }
}

impl<T: Eq + Hash> Numbers<T> {
    /// The number of a thing: its own, or the next.
    pub fn number(&self, thing: T) -> u32 {
        let mut known = self.0.lock().unwrap_or_else(PoisonError::into_inner);
        let next = known.len() as u32;
        *known.entry(thing).or_insert(next)
    }

    /// All things in an order that does not depend on threads, and the place there of each number.
    pub fn sorted(self, compare: impl Fn(&T, &T) -> Ordering) -> (Vec<T>, Vec<u32>) {
        let found = self.0.into_inner().unwrap_or_else(PoisonError::into_inner);
        let mut sorted: Vec<(T, u32)> = found.into_iter().collect();
        sorted.sort_by(|(one, _), (other, _)| compare(one, other));
        let mut places = vec![0; sorted.len()];
        for (place, (_, number)) in sorted.iter().enumerate() {
            places[*number as usize] = place as u32;
        }
        (sorted.into_iter().map(|(thing, _)| thing).collect(), places)
    }
}
