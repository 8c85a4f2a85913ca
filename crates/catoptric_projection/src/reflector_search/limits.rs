//! Errors on built-in scenes.

use catoptric_engine::method::limits::{ErrorLimits, below, scene};

/// The limits.
pub(super) static LIMITS: ErrorLimits = ErrorLimits {
    settings: "edge_error_px = 2\npiece_px = 4\nwork = 150\nbeyond_work = 'coarse'",
    scenes: &[
        scene("sphere_room", [below(0.021, 0.030), below(0.021, 0.030)]),
        scene("two_spheres", [below(0.016, 0.030), below(0.015, 0.030)]),
        scene("vase", [below(0.046, 0.061), below(0.046, 0.061)]),
        scene("teapot", [below(0.322, 0.262), below(0.319, 0.261)]),
        scene("glass_sphere", [below(0.017, 0.024), below(0.518, 0.346)]),
        scene("glass_slab", [below(0.043, 0.045), below(0.085, 0.075)]),
        scene("lens", [below(0.003, 0.011), below(0.219, 0.173)]),
        scene("dish", [below(0.019, 0.036), below(0.019, 0.036)]),
        scene("planar_mirror", [below(0.030, 0.032), below(0.028, 0.032)]),
        scene("ellipsoid", [below(0.006, 0.030), below(0.006, 0.030)]),
        scene("torus", [below(0.118, 0.131), below(0.140, 0.145)]),
        scene("car", [below(0.084, 0.090), below(0.095, 0.095)]),
        scene("large_room", [below(0.018, 0.038), below(0.018, 0.038)]),
        scene("colonnade", [below(0.200, 0.163), below(0.623, 0.389)]),
        scene("highlights", [below(0.023, 0.090), below(0.023, 0.090)]),
        scene("brushed", [below(0.080, 0.085), below(0.058, 0.080)]),
        scene("rippled", [below(0.229, 0.152), below(0.256, 0.151)]),
        scene("workshop", [below(0.122, 0.111), below(0.244, 0.186)]),
    ],
};
