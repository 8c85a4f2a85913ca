//! The reference and its parts, against closed forms, finite differences and independent derivations.

mod blend;
mod bodies;
mod bumps;
mod closed_forms;
mod lobes;
mod path_derivatives;
mod reflection_groups;
mod scale;
mod shadows;
mod sky;
mod visibility;
