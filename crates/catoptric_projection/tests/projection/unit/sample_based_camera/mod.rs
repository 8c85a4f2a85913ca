//! Records, cube maps, the visibility of reflectors, and morphing.

mod cube;
mod morph;
mod primary_visibility;
mod words;
