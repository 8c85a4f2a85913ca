//! Scenes of lights and of surfaces that are neither perfect mirrors nor dull.

mod highlights;

pub(super) use highlights::HIGHLIGHTS;
