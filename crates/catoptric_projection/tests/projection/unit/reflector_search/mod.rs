//! The search in pictures of reflectors.

mod cube;
mod search;
mod starts;
