//! Colours for error maps: from black over violet and orange to pale yellow, rising evenly in lightness.

/// Stops of the scale at equal distances, sRGB: each lighter than the one before, so that it also reads in grey.
const STOPS: [[f32; 3]; 9] = [
    [0.0, 0.0, 4.0],
    [28.0, 16.0, 70.0],
    [80.0, 18.0, 124.0],
    [130.0, 37.0, 129.0],
    [182.0, 55.0, 122.0],
    [230.0, 80.0, 98.0],
    [251.0, 135.0, 97.0],
    [254.0, 194.0, 137.0],
    [252.0, 253.0, 191.0],
];

/// The 8-bit sRGB colour of an error from 0 to 1; NaN counts as 0.
pub fn heat_color(error: f32) -> [u8; 3] {
    let last = STOPS.len() - 1;
    let place = if error > 0.0 { error.min(1.0) } else { 0.0 } * last as f32;
    let index = (place as usize).min(last - 1);
    let part = place - index as f32;
    std::array::from_fn(|channel| {
        let (from, to) = (STOPS[index][channel], STOPS[index + 1][channel]);
        (from + (to - from) * part + 0.5) as u8
    })
}

/// A map of errors as 8-bit sRGB, three bytes a pixel.
pub fn heat_map_rgb8(errors: &[f32]) -> Vec<u8> {
    errors.iter().flat_map(|&error| heat_color(error)).collect()
}
