//! Scenes of lights and of surfaces that are neither perfect mirrors nor dull.

mod brushed;
mod highlights;
mod rippled;

pub(super) use brushed::BRUSHED;
pub(super) use highlights::HIGHLIGHTS;
pub(super) use rippled::RIPPLED;
