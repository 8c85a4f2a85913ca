//! Errors on built-in scenes.

use catoptric_engine::method::limits::{ErrorLimits, below, scene};

/// The limits.
pub(super) static LIMITS: ErrorLimits = ErrorLimits {
    settings: "st = 4\nuv = 16",
    scenes: &[
        scene("sphere_room", [below(0.259, 0.216), below(0.259, 0.216)]),
        scene("two_spheres", [below(0.394, 0.315), below(0.396, 0.316)]),
        scene("vase", [below(0.247, 0.144), below(0.249, 0.145)]),
        scene("teapot", [below(0.390, 0.246), below(0.417, 0.250)]),
        scene("glass_sphere", [below(0.036, 0.048), below(0.648, 0.374)]),
        scene("glass_slab", [below(0.027, 0.042), below(0.601, 0.309)]),
        scene("lens", [below(0.003, 0.022), below(0.847, 0.333)]),
        scene("dish", [below(0.479, 0.377), below(0.479, 0.377)]),
        scene("planar_mirror", [below(0.797, 0.600), below(0.775, 0.512)]),
        scene("ellipsoid", [below(0.218, 0.147), below(0.218, 0.147)]),
        scene("torus", [below(0.200, 0.159), below(0.182, 0.160)]),
        scene("car", [below(0.256, 0.174), below(0.253, 0.174)]),
        scene("large_room", [below(0.330, 0.197), below(0.330, 0.197)]),
        scene("colonnade", [below(0.195, 0.136), below(0.727, 0.500)]),
        scene("highlights", [below(0.159, 0.188), below(0.159, 0.188)]),
        scene("brushed", [below(0.415, 0.271), below(0.393, 0.268)]),
        scene("rippled", [below(0.493, 0.381), below(0.502, 0.407)]),
        scene("workshop", [below(0.061, 0.094), below(0.099, 0.105)]),
    ],
};
