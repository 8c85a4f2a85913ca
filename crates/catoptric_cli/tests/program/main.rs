//! The program as its users meet it: exit codes, messages, files and numbers.
#![expect(clippy::unwrap_used, reason = "a test that cannot go on must fail")]

mod bake;
mod choice;
mod commands;
mod frames;
mod help;
mod messages;
mod outputs;
mod pictures;
mod project;
mod render;
mod sequences;
mod workplace;
