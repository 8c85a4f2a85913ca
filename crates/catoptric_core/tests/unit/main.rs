//! Numbers, surfaces, shading, views, pictures and files, against closed forms and other ways to compute them.
#![expect(clippy::unwrap_used, reason = "a test that cannot go on must fail")]

mod error;
mod framebuffer;
mod math;
#[cfg(feature = "outputs")]
mod output;
mod parallel;
#[cfg(feature = "files")]
mod picture;
mod scene;
mod surface;
mod tone;
