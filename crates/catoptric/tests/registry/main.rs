//! All registered methods: pictures of all built-in scenes within limits, degenerate scenes, declarations of settings.

mod cancelling;
mod degenerate;
mod matrix;
mod settings;
