//! Values that change evenly over the screen.

/// A value over the screen, in pixels, as its three corners have it.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Plane {
    from: [f64; 2],
    value: f64,
    /// Change a pixel to the right.
    pub(crate) right: f64,
    /// Change a pixel down.
    pub(crate) down: f64,
}

impl Plane {
    /// The plane through a value at each of three places; `None` if they lie on a line.
    pub(crate) fn through(places: [[f64; 2]; 3], values: [f64; 3]) -> Option<Self> {
        let [[x0, y0], [x1, y1], [x2, y2]] = places;
        let [[ax, ay], [bx, by]] = [[x1 - x0, y1 - y0], [x2 - x0, y2 - y0]];
        let area = ax * by - bx * ay;
        let [a, b] = [values[1] - values[0], values[2] - values[0]];
        let plane =
            Self { from: places[0], value: values[0], right: (a * by - b * ay) / area, down: (b * ax - a * bx) / area };
        (area != 0.0).then_some(plane)
    }

    /// The value in the middle of a pixel.
    pub(crate) fn at(&self, column: usize, row: usize) -> f64 {
        let [x, y] = self.from;
        self.value + self.right * (column as f64 + 0.5 - x) + self.down * (row as f64 + 0.5 - y)
    }
}
