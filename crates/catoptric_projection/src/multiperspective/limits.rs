//! Errors on built-in scenes.

use catoptric_engine::method::limits::{ErrorLimits, below, scene};

/// The limits.
pub(super) static LIMITS: ErrorLimits = ErrorLimits {
    settings: "",
    scenes: &[
        scene("sphere_room", [below(0.024, 0.035), below(0.024, 0.035)]),
        scene("two_spheres", [below(0.023, 0.044), below(0.023, 0.044)]),
        scene("vase", [below(0.003, 0.020), below(0.003, 0.020)]),
        scene("teapot", [below(0.030, 0.047), below(0.035, 0.052)]),
        scene("glass_sphere", [below(0.006, 0.020), below(0.050, 0.069)]),
        scene("glass_slab", [below(0.016, 0.020), below(0.018, 0.021)]),
        scene("lens", [below(0.003, 0.008), below(0.066, 0.078)]),
        scene("dish", [below(0.003, 0.012), below(0.003, 0.012)]),
        scene("planar_mirror", [below(0.045, 0.047), below(0.076, 0.095)]),
        scene("ellipsoid", [below(0.006, 0.021), below(0.006, 0.021)]),
        scene("torus", [below(0.005, 0.027), below(0.007, 0.030)]),
        scene("car", [below(0.030, 0.059), below(0.027, 0.049)]),
        scene("large_room", [below(0.020, 0.043), below(0.020, 0.043)]),
        scene("colonnade", [below(0.025, 0.031), below(0.035, 0.056)]),
        scene("highlights", [below(0.023, 0.093), below(0.023, 0.093)]),
        scene("brushed", [below(0.027, 0.058), below(0.061, 0.080)]),
        scene("rippled", [below(0.039, 0.060), below(0.015, 0.064)]),
        scene("workshop", [below(0.019, 0.055), below(0.023, 0.058)]),
    ],
};
