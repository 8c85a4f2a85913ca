//! Scenes of lights and of surfaces that are neither perfect mirrors nor dull.

mod brushed;
mod highlights;
mod rippled;
mod workshop;

pub(super) use brushed::BRUSHED;
pub(super) use highlights::HIGHLIGHTS;
pub(super) use rippled::RIPPLED;
pub(super) use workshop::WORKSHOP;
