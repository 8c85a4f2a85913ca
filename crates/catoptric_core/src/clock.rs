//! Time for reports. On WebAssembly there is no clock: every time is 0 there.

/// Measures how long stages of work take.
#[derive(Clone, Copy, Debug)]
pub struct Stopwatch {
    #[cfg(not(target_family = "wasm"))]
    start: std::time::Instant,
}

impl Stopwatch {
    /// Starts now.
    #[allow(clippy::new_without_default)] // "default" would hide that a clock starts to run
    pub fn new() -> Self {
        Self {
            #[cfg(not(target_family = "wasm"))]
            start: std::time::Instant::now(),
        }
    }

    /// Milliseconds since the start or the last lap.
    pub fn elapsed_ms(&self) -> f64 {
        #[cfg(not(target_family = "wasm"))]
        return self.start.elapsed().as_secs_f64() * 1e3;
        #[cfg(target_family = "wasm")]
        0.0
    }

    /// Milliseconds since the start or the last lap, and starts the next lap.
    pub fn lap_ms(&mut self) -> f64 {
        #[cfg(not(target_family = "wasm"))]
        {
            let now = std::time::Instant::now();
            let lap = now - std::mem::replace(&mut self.start, now);
            lap.as_secs_f64() * 1e3
        }
        #[cfg(target_family = "wasm")]
        0.0
    }
}
