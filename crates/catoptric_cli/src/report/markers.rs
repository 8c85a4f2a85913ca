//! Colours and shapes by which methods are told apart in plots and tables.

use std::fmt::Write;

/// The first seven are those of Okabe and Ito; four more are as far from these and each other as can be, also to eyes
/// that lack one kind of cones. An outline in the text's colour makes them legible on white and on black.
const COLORS: [&str; 11] = [
    "#0072b2", "#e69f00", "#009e73", "#cc79a7", "#f0e442", "#d55e00", "#56b4e9", "#1a1a8c", "#80f0f0", "#8c1aff",
    "#661a1a",
];
const SHAPES: usize = 11;
/// Markers lie in a square of this side.
pub(super) const SIDE: f64 = 16.0;

/// The colour of a method, by its number.
pub(super) fn color(index: usize) -> &'static str {
    COLORS[index % COLORS.len()]
}

/// The outline of a method's shape as a path of SVG, in a square of [`SIDE`] about the origin. With the colour it is
/// the same for no two of 121 methods.
pub(super) fn path(index: usize) -> String {
    match (index + index / COLORS.len()) % SHAPES {
        0 => "M-6 0A6 6 0 1 0 6 0A6 6 0 1 0 -6 0Z".into(),
        1 => polygon(4, 1.0, 45.0),
        2 => polygon(3, 1.0, 0.0),
        3 => polygon(4, 1.0, 0.0),
        4 => star(5, 0.45, 0.0),
        5 => polygon(3, 1.0, 180.0),
        6 => star(4, 0.4, 45.0),
        7 => polygon(6, 1.0, 0.0),
        8 => "M-2.4 -7H2.4V-2.4H7V2.4H2.4V7H-2.4V2.4H-7V-2.4H-2.4Z".into(),
        9 => "M-3.8 -7H3.8V7H-3.8Z".into(),
        _ => "M-7 -3.8H7V3.8H-7Z".into(),
    }
}

/// A marker in the text.
pub(super) fn inline(index: usize) -> String {
    let (path, color, half) = (path(index), color(index), SIDE / 2.0 + 1.0);
    let side = 2.0 * half;
    format!(
        "<svg class=\"marker\" viewBox=\"-{half} -{half} {side} {side}\" aria-hidden=\"true\">\
         <path d=\"{path}\" fill=\"{color}\" stroke=\"currentColor\"/></svg>"
    )
}

fn polygon(corners: u32, radius: f64, turn_deg: f64) -> String {
    outline((0..corners).map(|corner| (radius, turn_deg + 360.0 * f64::from(corner) / f64::from(corners))))
}

fn star(points: u32, inner: f64, turn_deg: f64) -> String {
    let angle = |corner: u32| turn_deg + 180.0 * f64::from(corner) / f64::from(points);
    outline((0..2 * points).map(|corner| (if corner % 2 == 0 { 1.0 } else { inner }, angle(corner))))
}

/// Corners by their distance, 1 being as far as shapes reach, and their angle in degrees from the top.
fn outline(corners: impl Iterator<Item = (f64, f64)>) -> String {
    let mut path = String::new();
    for (index, (radius, degrees)) in corners.enumerate() {
        let (sin, cos) = degrees.to_radians().sin_cos();
        let reach = 7.5 * radius;
        // Writing into a text does not fail.
        let _ = write!(path, "{}{:.2} {:.2}", if index == 0 { "M" } else { "L" }, reach * sin, -reach * cos);
    }
    path + "Z"
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::collections::HashSet;

    #[test]
    fn no_two_methods_look_alike() {
        let eleven: HashSet<&str> = (0..11).map(color).collect();
        let shapes: HashSet<String> = (0..11).map(path).collect();
        let both: HashSet<(&str, String)> = (0..121).map(|index| (color(index), path(index))).collect();
        assert_eq!([eleven.len(), shapes.len(), both.len()], [11, 11, 121]);
    }
}
