//! Vertices and faces of `.obj` files.

use super::text::{LineWarnings, Statement, number, statements};
use glam::{DVec3, Vec2, Vec3};
use std::collections::HashMap;

/// The number of a texture coordinate or normal that a corner does without.
pub(super) const NONE: u32 = u32::MAX;

/// A corner of a face: numbers of vertices, texture coordinates and normals from 0.
#[derive(Clone, Copy, PartialEq, Eq, Hash)]
pub(super) struct Corner {
    pub(super) position: u32,
    pub(super) uv: u32,
    pub(super) normal: u32,
}

/// A face: where its corners end in those of its part, its smoothing group (0: none), and its line.
#[derive(Clone, Copy)]
pub(super) struct Face {
    pub(super) end: u32,
    pub(super) smoothing: u32,
    pub(super) line: usize,
}

/// The faces of one object or group with one material.
pub(super) struct Part {
    /// The name of the object or group; empty before the first.
    pub(super) name: String,
    /// The name of the material; empty without one.
    pub(super) material: String,
    pub(super) corners: Vec<Corner>,
    pub(super) faces: Vec<Face>,
}

/// All that the statements of a file bring.
#[derive(Default)]
pub(super) struct Geometry {
    /// Not a number where a line is broken: the numbers of others hold.
    pub(super) positions: Vec<DVec3>,
    /// As they stand, or empty; see [`linear_colors`](super::linear_colors).
    pub(super) colors: Vec<[f32; 3]>,
    /// From the lower left corner.
    pub(super) uvs: Vec<Vec2>,
    pub(super) normals: Vec<Vec3>,
    pub(super) parts: Vec<Part>,
    /// The arguments of `mtllib` statements.
    pub(super) libraries: Vec<String>,
    pub(super) warnings: LineWarnings,
    /// Curves and surfaces that are not drawn.
    pub(super) curves: usize,
    /// How many statements have keywords of the format.
    pub(super) known_statements: usize,
}

/// The state that statements change for the faces after them.
#[derive(Default)]
struct Current {
    name: String,
    material: String,
    smoothing: u32,
    part: Option<usize>,
    parts: HashMap<(String, String), usize>,
}

/// Reads the statements of a file. Broken ones are left out with a warning.
pub(super) fn read(text: &str) -> Geometry {
    let mut geometry = Geometry::default();
    let mut current = Current::default();
    for statement in statements(text) {
        geometry.known_statements += 1;
        match statement.keyword() {
            "v" => geometry.add_position(&statement),
            "vt" => {
                let [u, v] = geometry.numbers(&statement, 1).unwrap_or_default();
                geometry.uvs.push(Vec2::new(u as f32, v as f32));
            }
            "vn" => {
                let normal: [f64; 3] = geometry.numbers(&statement, 3).unwrap_or_default();
                geometry.normals.push(DVec3::from(normal).as_vec3());
            }
            "f" | "fo" => geometry.add_face(&statement, &mut current),
            "o" | "g" => {
                let is_new = !statement.rest().is_empty() || statement.keyword() == "g";
                if is_new && current.name != statement.rest() {
                    current.name = statement.rest().into();
                    current.part = None;
                }
            }
            "usemtl" => {
                current.material = statement.rest().into();
                current.part = None;
            }
            "s" => {
                let group = statement.words().next().unwrap_or_default();
                current.smoothing = if group == "on" { 1 } else { group.parse().unwrap_or(0) };
            }
            "mtllib" => geometry.libraries.push(statement.rest().into()),
            "curv" | "curv2" | "surf" => geometry.curves += 1,
            "p" | "l" | "vp" | "cstype" | "deg" | "bmat" | "step" | "parm" | "trim" | "hole" | "scrv" | "sp"
            | "end" | "con" | "mg" | "bevel" | "c_interp" | "d_interp" | "lod" | "shadow_obj" | "trace_obj"
            | "ctech" | "stech" | "call" | "csh" | "usemap" | "maplib" => {}
            _ => geometry.known_statements -= 1,
        }
    }
    geometry
}

impl Geometry {
    /// The first numbers of a statement, 0 where there are fewer; `None`, with a warning, if fewer than `needed` are
    /// there or one is no number.
    fn numbers<const N: usize>(&mut self, statement: &Statement<'_>, needed: usize) -> Option<[f64; N]> {
        let mut numbers = [0.0; N];
        let mut count = 0;
        for (place, word) in numbers.iter_mut().zip(statement.words()) {
            let Some(number) = number(word) else {
                self.warnings.add(statement.line, || format!("`{word}` is no number; the line is left out"));
                return None;
            };
            *place = number;
            count += 1;
        }
        if count < needed {
            let problem = || format!("{count} numbers, at least {needed} are needed; the line is left out");
            self.warnings.add(statement.line, problem);
            return None;
        }
        Some(numbers)
    }

    fn add_position(&mut self, statement: &Statement<'_>) {
        let position = self.numbers::<3>(statement, 3).map_or(DVec3::NAN, DVec3::from);
        // Three more numbers are a colour; a fourth one alone is the weight of a control point.
        let rest: Vec<f32> = statement.words().skip(3).map_while(number).map(|number| number as f32).collect();
        let color = rest.first_chunk::<3>();
        if color.is_some() || !self.colors.is_empty() {
            self.colors.resize(self.positions.len(), [1.0; 3]);
            self.colors.push(color.copied().unwrap_or([1.0; 3]));
        }
        self.positions.push(position);
    }

    fn add_face(&mut self, statement: &Statement<'_>, current: &mut Current) {
        let part = *current.part.get_or_insert_with(|| {
            let key = (current.name.clone(), current.material.clone());
            *current.parts.entry(key).or_insert_with_key(|(name, material)| {
                let (name, material) = (name.clone(), material.clone());
                self.parts.push(Part { name, material, corners: Vec::new(), faces: Vec::new() });
                self.parts.len() - 1
            })
        });
        let counts = [self.positions.len(), self.uvs.len(), self.normals.len()];
        let part = &mut self.parts[part];
        let begin = part.corners.len();
        for word in statement.words() {
            let Some(corner) = corner(word, counts) else {
                self.warnings.add(statement.line, || format!("`{word}` is no corner of a face; the face is left out"));
                part.corners.truncate(begin);
                return;
            };
            part.corners.push(corner);
        }
        if part.corners.len() < begin + 3 {
            self.warnings.add(statement.line, || "a face of fewer than three corners is left out".into());
            part.corners.truncate(begin);
            return;
        }
        part.faces.push(Face { end: part.corners.len() as u32, smoothing: current.smoothing, line: statement.line });
    }
}

/// The corner in a word such as `3`, `3/1`, `3//2` or `-1/-1/-1`; numbers may point to what comes later.
fn corner(word: &str, counts: [usize; 3]) -> Option<Corner> {
    let mut parts = word.split('/');
    let mut index = |count: usize| -> Option<Option<u32>> {
        let Some(part) = parts.next().filter(|part| !part.is_empty()) else { return Some(None) };
        let number: i64 = part.parse().ok()?;
        if number == 0 {
            return Some(None);
        }
        let index = if number < 0 { i64::try_from(count).ok()? + number } else { number - 1 };
        u32::try_from(index).ok().filter(|index| *index != NONE).map(Some)
    };
    let [position, uv, normal] = [index(counts[0])?, index(counts[1])?, index(counts[2])?];
    Some(Corner { position: position?, uv: uv.unwrap_or(NONE), normal: normal.unwrap_or(NONE) })
}
