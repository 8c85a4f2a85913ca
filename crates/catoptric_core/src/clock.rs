//! Time for reports. On WebAssembly there is a clock with the feature `browser` alone: without it every time is 0.

#[cfg(not(target_family = "wasm"))]
use std::time::Instant;
#[cfg(all(target_family = "wasm", feature = "browser"))]
use web_time::Instant;

/// Measures how long stages of work take.
#[derive(Clone, Copy, Debug)]
pub struct Stopwatch {
    #[cfg(any(not(target_family = "wasm"), feature = "browser"))]
    start: Instant,
}

impl Stopwatch {
    /// Starts now.
    #[allow(clippy::new_without_default)] // "default" would hide that a clock starts to run
    pub fn new() -> Self {
        Self {
            #[cfg(any(not(target_family = "wasm"), feature = "browser"))]
            start: Instant::now(),
        }
    }

    /// Milliseconds since the start or the last lap.
    pub fn elapsed_ms(&self) -> f64 {
        #[cfg(any(not(target_family = "wasm"), feature = "browser"))]
        return self.start.elapsed().as_secs_f64() * 1e3;
        #[cfg(all(target_family = "wasm", not(feature = "browser")))]
        0.0
    }

    /// Milliseconds since the start or the last lap, and starts the next lap.
    pub fn lap_ms(&mut self) -> f64 {
        #[cfg(any(not(target_family = "wasm"), feature = "browser"))]
        {
            let now = Instant::now();
            let lap = now - std::mem::replace(&mut self.start, now);
            lap.as_secs_f64() * 1e3
        }
        #[cfg(all(target_family = "wasm", not(feature = "browser")))]
        0.0
    }
}
