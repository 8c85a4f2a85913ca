//! Time for reports; where there is no clock (in browsers without one for libraries) all times are 0.

/// Measures time since its start.
pub(crate) struct Stopwatch {
    #[cfg(not(target_family = "wasm"))]
    start: std::time::Instant,
}

impl Stopwatch {
    pub(crate) fn start() -> Self {
        Self {
            #[cfg(not(target_family = "wasm"))]
            start: std::time::Instant::now(),
        }
    }

    /// Milliseconds since the start.
    pub(crate) fn ms(&self) -> f64 {
        #[cfg(not(target_family = "wasm"))]
        {
            self.start.elapsed().as_secs_f64() * 1e3
        }
        #[cfg(target_family = "wasm")]
        {
            0.0
        }
    }
}
