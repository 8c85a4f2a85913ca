//! The paths on which it is known what rays hit.

use crate::device::scene::DeviceScene;

/// Longer paths are traced.
const MOST_EVENTS: u32 = 2;

/// The paths whose rays tiles follow, at an order.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) struct Paths {
    /// The most events.
    pub(crate) events: u32,
    has_lenses: bool,
    /// Grids of rays tell what rough mirrors reflect.
    pub(crate) has_grids: bool,
    pub(super) way: Way,
}

/// How what rays hit becomes known.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Way {
    /// Tiles follow rays.
    Tiles,
    /// Light is looked up at the first event.
    LookUp,
    /// Hardware has drawn what is seen after every number of mirrors.
    Mirrors,
    /// Hardware has drawn what is seen on some paths; tiles follow the others.
    Lists,
    /// Hardware has drawn a part of what is seen after one event; tiles follow the rest, and longer paths.
    FirstLists,
}

impl Way {
    pub(super) fn follows_rays(self) -> bool {
        matches!(self, Self::Tiles | Self::Lists | Self::FirstLists)
    }

    fn draws(self) -> bool {
        matches!(self, Self::Mirrors | Self::Lists | Self::FirstLists)
    }
}

impl Paths {
    /// The paths of a scene at an order, whose hits become known in a way.
    pub(super) fn of(scene: &DeviceScene, order: u32, way: Way) -> Self {
        let most = match way {
            Way::LookUp => 1,
            Way::Mirrors => order,
            Way::Tiles | Way::Lists | Way::FirstLists => MOST_EVENTS,
        };
        let events = if scene.has_specular { order.min(most) } else { 0 };
        let has_lenses = scene.features.has_lenses() && way.follows_rays();
        let has_grids = scene.features.has_rough() && way.follows_rays() && events > 0;
        Self { events, has_lenses, has_grids, way }
    }

    /// The most events after which the table of hits knows what rays hit.
    pub(crate) fn known_events(self) -> u32 {
        if self.way == Way::LookUp { 0 } else { self.events }
    }

    /// The number of paths on which hardware draws what is seen.
    pub(crate) fn drawn(self) -> usize {
        match self.way {
            Way::FirstLists => self.events.min(1) as usize,
            way if way.draws() => self.all().count(),
            _ => 0,
        }
    }

    /// Paths with their events and kinds, shorter ones first.
    pub(crate) fn all(self) -> impl Iterator<Item = (u32, u32)> {
        let kinds = move |events: u32| if self.has_lenses { 1 << events } else { 1 };
        (1..=self.events).flat_map(move |events| (0..kinds(events)).map(move |kinds| (events, kinds)))
    }

    /// Entries of the table of hits that a cell has.
    pub(crate) fn slots(self) -> u32 {
        if self.way == Way::LookUp { 1 } else { 1 + self.all().count() as u32 }
    }
}
