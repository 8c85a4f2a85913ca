//! Tables and checks that several look-up methods share.

pub(crate) mod memory;
pub(crate) mod regions;
