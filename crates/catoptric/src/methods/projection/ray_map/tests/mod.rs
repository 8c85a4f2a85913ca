mod candidates;
mod samples;
mod tubes;

use crate::math::random::Stream;
use glam::DVec3;

/// A vector in the unit ball, not too short.
fn vector(random: &mut Stream) -> DVec3 {
    loop {
        let mut next = || random.next_between(-1.0, 1.0) as f64;
        let vector = DVec3::new(next(), next(), next());
        if (0.01..1.0).contains(&vector.length_squared()) {
            return vector;
        }
    }
}
