//! Points of a grid on the surfaces of objects.

use crate::failure::Failure;
use crate::parse::Grid;
use catoptric::error::did_you_mean;
use catoptric::scene::roles::RoleRule;
use catoptric::scene::{Role, Scene};
use catoptric::surface::PlacedSurface;
use glam::{DVec2, DVec3};

/// The most points of a grid.
const MOST_POINTS: usize = 4_000_000;
/// The most places that are looked at for them.
const MOST_PLACES: f64 = 5e7;
/// An axis is taken for steeper than one before it if it is by this share: faces at even angles to two axes have one.
const CLEARLY: f64 = 1.0 + 1e-3;
/// Steps of Newton's method from a triangle to the exact surface.
const STEPS: usize = 4;

/// The points of a grid, in the coordinates of the scene's file: the middles of square cells from the lower corner of
/// each object's box on, projected along the axis that is steepest to each triangle. A plane face has one point for
/// each cell that is seen along that axis, however it is divided into triangles. Exact surfaces have them, not their
/// triangles.
pub(super) fn points(grid: &Grid, scene: &Scene) -> Result<Vec<DVec3>, Failure> {
    let Grid { node, step } = grid;
    let usage = |problem: String| Failure::usage(format!("--points {}{node}:{step}: {problem}", Grid::PREFIX));
    let rule = RoleRule::new(node, Role::Diffuse, None).map_err(|error| usage(error.to_string()))?;
    let name = |object: u32| scene.objects[object as usize].name.as_str();
    let all = 0..scene.objects.len() as u32;
    let matches = |object: u32| rule.matches(name(object), &scene.material_of(object).name);
    let chosen: Vec<bool> = all.clone().map(matches).collect();
    if !chosen.contains(&true) {
        let hint = did_you_mean(node, all.map(name));
        return Err(Failure::input(format!("{}: --points: there is no node or material `{node}`{hint}", scene.name)));
    }
    let mut cells = Cells { step: *step, lower: DVec3::ZERO, places: 0.0, points: Vec::new() };
    for (triangle, &object) in scene.triangles.iter().zip(&scene.triangle_objects) {
        if !chosen[object as usize] {
            continue;
        }
        let object = &scene.objects[object as usize];
        cells.lower = object.bounds.min.as_dvec3();
        let first = cells.points.len();
        cells.cover(triangle.map(|vertex| scene.positions[vertex as usize].as_dvec3()));
        if cells.points.len() > MOST_POINTS {
            return Err(usage(format!("the step is too small: there are more than {MOST_POINTS} points")));
        }
        if cells.is_overrun() {
            return Err(usage(format!("the step is too small: it makes more than {MOST_PLACES} cells")));
        }
        if let Some(surface) = &object.surface {
            cells.points[first..].iter_mut().for_each(|point| *point = onto(surface, *point));
        }
    }
    if cells.points.is_empty() {
        return Err(usage("no cell of this size has its middle on it; choose a smaller step".into()));
    }
    cells.points.iter_mut().for_each(|point| *point += scene.origin);
    Ok(cells.points)
}

/// The point of an exact surface near one of its triangles.
fn onto(surface: &PlacedSurface, triangle_point: DVec3) -> DVec3 {
    let mut point = triangle_point;
    for _ in 0..STEPS {
        let taylor = surface.taylor2(point);
        let step = taylor.gradient * (taylor.value / taylor.gradient.length_squared());
        if !step.is_finite() {
            return triangle_point;
        }
        point -= step;
    }
    point
}

/// Square cells in which triangles are covered.
struct Cells {
    step: f64,
    lower: DVec3,
    /// The number of places that were looked at.
    places: f64,
    points: Vec<DVec3>,
}

impl Cells {
    /// True if more places are to be looked at than is allowed, or they cannot be counted.
    fn is_overrun(&self) -> bool {
        self.places.is_nan() || self.places > MOST_PLACES
    }

    /// Appends the points on a triangle, until there are more than allowed.
    fn cover(&mut self, corners: [DVec3; 3]) {
        let normal = (corners[1] - corners[0]).cross(corners[2] - corners[0]);
        let steeper = |best: usize, axis| if normal[axis].abs() > CLEARLY * normal[best].abs() { axis } else { best };
        let steepest = [1, 2].into_iter().fold(0, steeper);
        if normal[steepest] == 0.0 || !normal.is_finite() {
            return;
        }
        let [across, along] = [(steepest + 1) % 3, (steepest + 2) % 3];
        let flat = |point: DVec3| {
            let relative = point - self.lower;
            DVec2::new(relative[across], relative[along]) / self.step - 0.5
        };
        let mut flats = corners.map(flat);
        // Two axes in cyclic order see the triangle from the third: it must turn to the left.
        if normal[steepest] < 0.0 {
            flats.swap(1, 2);
        }
        let heights = flats.map(|corner| corner.y);
        let (first, last) =
            (heights.iter().fold(f64::MAX, |a, b| a.min(*b)), heights.iter().fold(f64::MIN, |a, b| a.max(*b)));
        let rows = (last.floor() - first.ceil() + 1.0).max(0.0);
        self.places += rows;
        if self.is_overrun() {
            return;
        }
        for row in 0..rows as u64 {
            let y = first.ceil() + row as f64;
            let [least, most] = span(flats, y);
            self.places += most - least + 1.0;
            for column in 0..(most - least + 1.0) as u64 {
                let place = DVec2::new(least + column as f64, y);
                if self.is_overrun() || self.points.len() > MOST_POINTS {
                    return;
                }
                if !(0..3).all(|edge| is_inside(flats[edge], flats[(edge + 1) % 3], place)) {
                    continue;
                }
                let mut point = self.lower;
                point[across] += (place.x + 0.5) * self.step;
                point[along] += (place.y + 0.5) * self.step;
                let relative = point - corners[0];
                let aside = normal[across] * relative[across] + normal[along] * relative[along];
                point[steepest] = corners[0][steepest] - aside / normal[steepest];
                self.points.push(point);
            }
        }
    }
}

/// The first and last whole number along a row that may lie in a triangle, and one more on each side for rounding.
fn span(corners: [DVec2; 3], y: f64) -> [f64; 2] {
    let mut range = [f64::MAX, f64::MIN];
    for edge in 0..3 {
        let (from, to) = (corners[edge], corners[(edge + 1) % 3]);
        let [low, high] = if from.y < to.y { [from, to] } else { [to, from] };
        if (low.y..=high.y).contains(&y) {
            let share = if high.y > low.y { (y - low.y) / (high.y - low.y) } else { 0.0 };
            let ends = if high.y > low.y { [low.x + (high.x - low.x) * share; 2] } else { [low.x, high.x] };
            range = [range[0].min(ends[0]).min(ends[1]), range[1].max(ends[0]).max(ends[1])];
        }
    }
    [range[0].floor() - 1.0, range[1].ceil() + 1.0]
}

/// True for places on the left of an edge, and for those on it if it runs forward: of two triangles that share an edge
/// one has the place.
fn is_inside(from: DVec2, to: DVec2, place: DVec2) -> bool {
    // Computed alike for both directions of the edge.
    let is_forward = (from.x, from.y) < (to.x, to.y);
    let [low, high] = if is_forward { [from, to] } else { [to, from] };
    let side = (high - low).perp_dot(place - low);
    if is_forward { side >= 0.0 } else { side < 0.0 }
}
