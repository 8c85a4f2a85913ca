//! Points of a grid on the surfaces of objects.

use crate::failure::Failure;
use crate::parse::Grid;
use catoptric::error::did_you_mean;
use catoptric::scene::roles::RoleRule;
use catoptric::scene::{Role, Scene};
use glam::{DVec2, DVec3};

/// The most points of a grid.
const MOST_POINTS: usize = 4_000_000;
/// The most places that are looked at for them.
const MOST_PLACES: f64 = 1e9;

/// The points of a grid, in the coordinates of the scene's file: the middles of square cells from the lower corner of
/// each object's box on, projected along the axis that is steepest to each triangle. A plane face has one point for
/// each cell, however it is divided into triangles.
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
        cells.lower = scene.objects[object as usize].bounds.min.as_dvec3();
        cells.cover(triangle.map(|vertex| scene.positions[vertex as usize].as_dvec3()));
        if cells.points.len() > MOST_POINTS || cells.places > MOST_PLACES {
            return Err(usage(format!("the step is too small: there are more than {MOST_POINTS} points")));
        }
    }
    cells.points.iter_mut().for_each(|point| *point += scene.origin);
    Ok(cells.points)
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
    /// Appends the points on a triangle, until there are more than allowed.
    fn cover(&mut self, corners: [DVec3; 3]) {
        let normal = (corners[1] - corners[0]).cross(corners[2] - corners[0]);
        let steepest = (0..3).max_by(|a, b| normal[*a].abs().total_cmp(&normal[*b].abs())).unwrap_or(0);
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
        let least = flats[0].min(flats[1]).min(flats[2]).ceil();
        let most = flats[0].max(flats[1]).max(flats[2]).floor();
        if least.cmpgt(most).any() {
            return;
        }
        let count = most - least + 1.0;
        self.places += count.x * count.y;
        if self.places > MOST_PLACES {
            return;
        }
        for row in 0..count.y as u64 {
            for column in 0..count.x as u64 {
                let place = least + DVec2::new(column as f64, row as f64);
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
                if self.points.len() > MOST_POINTS {
                    return;
                }
            }
        }
    }
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
