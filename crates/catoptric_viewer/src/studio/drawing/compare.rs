//! The error of the left side against the right one.

use crate::studio::news::{Compared, News, Tell};
use crate::studio::order::Wish;
use catoptric::framebuffer::Framebuffer;
use catoptric::metrics::{Comparison, heat_map_rgb8};
use std::sync::Arc;

/// Compares two whole pictures and tells the result, beside other work: a moving eye does not wait for it.
pub(in crate::studio) fn compare(wish: &Arc<Wish>, [left, right]: [Arc<Framebuffer>; 2], tell: Tell) {
    let wish = wish.clone();
    let work = move || {
        let [left, right] = [left, right].map(|picture| wish.display.exposed(&picture));
        let Ok(comparison) = Comparison::new(&left, &right) else { return };
        let error = comparison.whole();
        let compared = Compared {
            wish,
            flip_mean: error.map_or(0.0, |error| error.flip_mean),
            over_0_1: error.map_or(0.0, |error| error.over_0_1),
            heat_rgb: heat_map_rgb8(&comparison.flip),
            size: [comparison.width, comparison.height],
        };
        tell(News::Compared(Box::new(compared)));
    };
    #[cfg(not(target_family = "wasm"))]
    std::thread::spawn(work);
    #[cfg(target_family = "wasm")]
    work();
}
