//! Errors on built-in scenes.

use catoptric_engine::method::limits::{ErrorLimits, below, scene};

/// The limits.
pub(super) static LIMITS: ErrorLimits = ErrorLimits {
    settings: "",
    scenes: &[
        scene("sphere_room", [below(1.000, 1.000), below(1.000, 1.000)]),
        scene("two_spheres", [below(1.000, 1.000), below(1.000, 1.000)]),
        scene("vase", [below(1.000, 1.000), below(1.000, 1.000)]),
        scene("teapot", [below(1.000, 0.960), below(1.000, 0.979)]),
        scene("glass_sphere", [below(1.000, 0.391), below(1.000, 0.984)]),
        scene("glass_slab", [below(0.592, 0.263), below(1.000, 0.942)]),
        scene("lens", [below(0.908, 0.288), below(1.000, 1.000)]),
        scene("dish", [below(1.000, 1.000), below(1.000, 1.000)]),
        scene("planar_mirror", [below(0.005, 0.010), below(0.005, 0.011)]),
        scene("ellipsoid", [below(1.000, 1.000), below(1.000, 1.000)]),
        scene("torus", [below(1.000, 0.990), below(1.000, 1.000)]),
        scene("car", [below(1.000, 0.918), below(1.000, 0.920)]),
        scene("large_room", [below(1.000, 0.997), below(1.000, 0.997)]),
        scene("colonnade", [below(1.000, 0.518), below(1.000, 0.952)]),
        scene("highlights", [below(1.000, 0.624), below(1.000, 0.624)]),
        scene("brushed", [below(1.000, 0.903), below(1.000, 0.926)]),
        scene("rippled", [below(0.234, 0.176), below(0.373, 0.275)]),
        scene("workshop", [below(0.447, 0.284), below(0.550, 0.348)]),
    ],
};
