//! The built-in scenes, the studio and the importers, against closed forms and the formats.
#![expect(clippy::unwrap_used, reason = "a test that cannot go on must fail")]

mod builtin;
#[cfg(feature = "files")]
mod import;
mod studio;
