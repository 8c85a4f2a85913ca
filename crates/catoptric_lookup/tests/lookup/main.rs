//! The methods of the lookup family, against the reference and on scenes for which they are exact.
#![expect(clippy::unwrap_used, reason = "a test that cannot go on must fail")]

mod environment_map;
mod layered_environment_map;
mod light_field;
mod unit;
