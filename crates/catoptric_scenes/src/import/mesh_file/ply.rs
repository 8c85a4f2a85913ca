//! Polygon files (`.ply`, Turk 1994): vertices with normals and colours, and faces; as text and binary of both orders
//! of bytes. Other elements and properties are passed over.

use super::model::Mesh;
use super::polygons::PolygonDivider;
use catoptric_core::error::SceneError;
use catoptric_core::framebuffer::linear_from_srgb;
use catoptric_core::scene::model::Model;
use glam::DVec3;
use std::str::{Lines, SplitAsciiWhitespace};

/// The kind of a number in the file.
#[derive(Clone, Copy, Debug, PartialEq)]
enum Scalar {
    Int8,
    Uint8,
    Int16,
    Uint16,
    Int32,
    Uint32,
    Float32,
    Float64,
}

impl Scalar {
    fn parse(word: &str) -> Option<Self> {
        Some(match word {
            "char" | "int8" => Self::Int8,
            "uchar" | "uint8" => Self::Uint8,
            "short" | "int16" => Self::Int16,
            "ushort" | "uint16" => Self::Uint16,
            "int" | "int32" => Self::Int32,
            "uint" | "uint32" => Self::Uint32,
            "float" | "float32" => Self::Float32,
            "double" | "float64" => Self::Float64,
            _ => return None,
        })
    }

    fn bytes(self) -> usize {
        match self {
            Self::Int8 | Self::Uint8 => 1,
            Self::Int16 | Self::Uint16 => 2,
            Self::Int32 | Self::Uint32 | Self::Float32 => 4,
            Self::Float64 => 8,
        }
    }

    /// The factor that makes a colour of this kind go from 0 to 1.
    fn color_scale(self) -> f32 {
        match self {
            Self::Float32 | Self::Float64 => 1.0,
            Self::Uint16 | Self::Int16 => 1.0 / 65535.0,
            _ => 1.0 / 255.0,
        }
    }
}

/// A property of an element: its name, the kind of a list's length if it is a list, and the kind of its numbers.
struct Property {
    name: String,
    length: Option<Scalar>,
    scalar: Scalar,
}

struct Element {
    name: String,
    count: usize,
    properties: Vec<Property>,
}

/// Reads a mesh from memory; `name` is for messages.
///
/// # Errors
/// [`SceneError`] when the header is none of a polygon file, the data ends too early or a number is none.
pub(in super::super) fn from_slice(name: &str, bytes: &[u8]) -> Result<Model, SceneError> {
    let invalid = |(field, problem): (String, String)| SceneError::invalid(name, field, problem);
    let (elements, mut data) = header(bytes).map_err(invalid)?;
    let mut mesh = Mesh::default();
    let mut faces = Faces::default();
    let (mut values, mut begins) = (Vec::new(), Vec::new());
    for element in &elements {
        let place = |row: usize| format!("{}[{row}]", element.name);
        let columns = Columns::of(element);
        if element.name == "vertex" && columns.position.contains(&None) {
            return Err(SceneError::invalid(name, "header", "element vertex has no properties x, y and z"));
        }
        let list = element.properties.iter().position(|property| {
            property.length.is_some() && ["vertex_indices", "vertex_index"].contains(&property.name.as_str())
        });
        for row in 0..element.count {
            data.row(element, &mut values, &mut begins).map_err(|problem| invalid((place(row), problem)))?;
            let of_list = || list.map_or(&[][..], |list| &values[begins[list]..begins[list + 1]]);
            match element.name.as_str() {
                "vertex" => columns.add(&values, &begins, &mut mesh),
                "face" => faces.add(of_list().iter().copied()),
                "tristrips" => of_list().split(|index| *index < 0.0).for_each(|strip| {
                    strip.windows(3).enumerate().for_each(|(index, corners)| {
                        // Every second triangle of a strip turns the other way.
                        let [a, b] = if index % 2 == 0 { [0, 1] } else { [1, 0] };
                        faces.add([corners[a], corners[b], corners[2]].into_iter());
                    });
                }),
                _ => {}
            }
        }
    }
    Ok(faces.into_model(mesh, name))
}

/// Places of the numbers of a vertex among its properties.
struct Columns {
    position: [Option<usize>; 3],
    normal: [Option<usize>; 3],
    color: [Option<usize>; 3],
    color_scale: f32,
}

impl Columns {
    fn of(element: &Element) -> Self {
        let column =
            |names: &[&str]| element.properties.iter().position(|property| names.contains(&property.name.as_str()));
        let color = [
            column(&["red", "r", "diffuse_red"]),
            column(&["green", "g", "diffuse_green"]),
            column(&["blue", "b", "diffuse_blue"]),
        ];
        Self {
            position: ["x", "y", "z"].map(|name| column(&[name])),
            normal: ["nx", "ny", "nz"].map(|name| column(&[name])),
            color,
            color_scale: color[0].map_or(1.0, |column| element.properties[column].scalar.color_scale()),
        }
    }
}

impl Columns {
    /// Adds a vertex, whose properties begin at these places of its numbers.
    fn add(&self, values: &[f64], begins: &[usize], mesh: &mut Mesh) {
        let three = |columns: [Option<usize>; 3]| -> Option<DVec3> {
            let [x, y, z] = columns.map(|column| values.get(*begins.get(column?)?).copied());
            Some(DVec3::new(x?, y?, z?))
        };
        mesh.positions.push(three(self.position).unwrap_or(DVec3::NAN));
        mesh.normals.extend(three(self.normal).map(|normal| normal.as_vec3()));
        mesh.colors.extend(three(self.color).map(|color| {
            let [red, green, blue] = (color.as_vec3() * self.color_scale)
                .to_array()
                .map(|value| linear_from_srgb(if value.is_finite() { value.clamp(0.0, 1.0) } else { 1.0 }));
            [red, green, blue, 1.0]
        }));
    }
}

/// Faces by the numbers of their vertices.
#[derive(Default)]
struct Faces {
    corners: Vec<u32>,
    /// Where the corners of each face end.
    ends: Vec<usize>,
}

impl Faces {
    fn add(&mut self, corners: impl Iterator<Item = f64>) {
        // Numbers that are no index become one that no vertex has.
        self.corners.extend(corners.map(|index| if index < 0.0 { u32::MAX } else { index as u32 }));
        self.ends.push(self.corners.len());
    }

    /// The mesh with triangles; faces that name vertices that are not there are left out, with a warning.
    fn into_model(self, mut mesh: Mesh, name: &str) -> Model {
        let mut divider = PolygonDivider::default();
        let (mut left_out, mut begin) = (0, 0);
        let mut places = Vec::new();
        for end in &self.ends {
            let face = &self.corners[begin..*end];
            begin = *end;
            places.clear();
            places.extend(face.iter().filter_map(|index| mesh.positions.get(*index as usize)).copied());
            if places.len() < face.len().max(3) {
                left_out += 1;
                continue;
            }
            let of_face = divider.divide(&places).as_chunks::<3>().0;
            mesh.triangles.extend(of_face.iter().map(|corners| corners.map(|corner| face[corner as usize])));
        }
        let has_points_alone = self.ends.is_empty() && !mesh.positions.is_empty();
        let mut model = mesh.into_model(name);
        if left_out > 0 {
            model.warnings.push(format!("{left_out} faces are left out: they do not have three vertices of the file"));
        }
        if has_points_alone {
            model.warnings.push("the file has points and no faces; points are not drawn".into());
        }
        model
    }
}

/// The numbers after the header.
enum Data<'a> {
    /// The lines after the current one, and its words: a row begins on a line of its own, and may go on in the next.
    Text {
        lines: Lines<'a>,
        words: SplitAsciiWhitespace<'a>,
    },
    Binary {
        bytes: &'a [u8],
        is_big_endian: bool,
    },
}

impl Data<'_> {
    /// Reads the numbers of an element; `begins` are the places of its properties' among them, and their end.
    fn row(&mut self, element: &Element, values: &mut Vec<f64>, begins: &mut Vec<usize>) -> Result<(), String> {
        values.clear();
        begins.clear();
        if let Self::Text { words, .. } = self {
            // Numbers that the header does not announce are passed over.
            *words = "".split_ascii_whitespace();
        }
        for property in &element.properties {
            begins.push(values.len());
            let count = property.length.map_or(Ok(1.0), |length| self.number(length))?;
            if !(0.0..=f64::from(u32::MAX)).contains(&count) {
                return Err(format!("a list of {count} numbers"));
            }
            for _ in 0..count as usize {
                values.push(self.number(property.scalar)?);
            }
        }
        begins.push(values.len());
        Ok(())
    }

    fn number(&mut self, scalar: Scalar) -> Result<f64, String> {
        const ENDS: &str = "the file ends too early";
        match self {
            Self::Text { lines, words } => {
                let word = loop {
                    match words.next() {
                        Some(word) => break word,
                        None => *words = lines.next().ok_or(ENDS)?.split_ascii_whitespace(),
                    }
                };
                word.parse().map_err(|_| format!("`{}` is no number", word.chars().take(40).collect::<String>()))
            }
            Self::Binary { bytes, is_big_endian } => {
                let (number, rest) = bytes.split_at_checked(scalar.bytes()).ok_or(ENDS)?;
                *bytes = rest;
                let mut little = [0; 8];
                little[..number.len()].copy_from_slice(number);
                if *is_big_endian {
                    little[..number.len()].reverse();
                }
                let [a, b, c, d, ..] = little;
                Ok(match scalar {
                    Scalar::Int8 => f64::from(a as i8),
                    Scalar::Uint8 => f64::from(a),
                    Scalar::Int16 => f64::from(i16::from_le_bytes([a, b])),
                    Scalar::Uint16 => f64::from(u16::from_le_bytes([a, b])),
                    Scalar::Int32 => f64::from(i32::from_le_bytes([a, b, c, d])),
                    Scalar::Uint32 => f64::from(u32::from_le_bytes([a, b, c, d])),
                    Scalar::Float32 => f64::from(f32::from_le_bytes([a, b, c, d])),
                    Scalar::Float64 => f64::from_le_bytes(little),
                })
            }
        }
    }
}

/// The elements that a header announces, and the data after it; the error is a field and its problem.
fn header(bytes: &[u8]) -> Result<(Vec<Element>, Data<'_>), (String, String)> {
    let mut elements: Vec<Element> = Vec::new();
    let mut format = None;
    let mut rest = bytes;
    let mut number = 0;
    loop {
        number += 1;
        let wrong = |problem: &str| (format!("header, line {number}"), problem.to_owned());
        let end = rest.iter().position(|byte| matches!(byte, b'\n' | b'\r')).ok_or_else(|| wrong("has no end"))?;
        let line = String::from_utf8_lossy(&rest[..end]).into_owned();
        let break_length = if rest[end..].starts_with(b"\r\n") { 2 } else { 1 };
        rest = &rest[end + break_length..];
        let words: Vec<&str> = line.split_ascii_whitespace().collect();
        match words.as_slice() {
            ["ply"] if number == 1 => {}
            _ if number == 1 => return Err(wrong("a polygon file begins with `ply`")),
            ["format", kind, ..] => format = Some((*kind).to_owned()),
            ["element", name, count] => {
                let count = count.parse().map_err(|_| wrong("the number of elements is none"))?;
                elements.push(Element { name: (*name).into(), count, properties: Vec::new() });
            }
            ["property", "list", length, scalar, name] => {
                let scalars = Scalar::parse(length).zip(Scalar::parse(scalar));
                let (length, scalar) = scalars.ok_or_else(|| wrong("an unknown kind of number"))?;
                let element = elements.last_mut().ok_or_else(|| wrong("a property before any element"))?;
                element.properties.push(Property { name: (*name).into(), length: Some(length), scalar });
            }
            ["property", scalar, name] => {
                let scalar = Scalar::parse(scalar).ok_or_else(|| wrong("an unknown kind of number"))?;
                let element = elements.last_mut().ok_or_else(|| wrong("a property before any element"))?;
                element.properties.push(Property { name: (*name).into(), length: None, scalar });
            }
            ["end_header"] => break,
            ["element" | "property", ..] => return Err(wrong("is no whole element or property")),
            // Comments, and what programs write without calling it so.
            _ => {}
        }
    }
    // Elements without properties take no bytes: their number alone would cost time.
    elements.retain(|element| !element.properties.is_empty());
    let data = match format.as_deref() {
        Some("ascii") => match std::str::from_utf8(rest) {
            Ok(text) => Data::Text { lines: text.lines(), words: "".split_ascii_whitespace() },
            Err(_) => return Err(("data".into(), "is no text, though the header says ascii".into())),
        },
        Some("binary_little_endian") => Data::Binary { bytes: rest, is_big_endian: false },
        Some("binary_big_endian") => Data::Binary { bytes: rest, is_big_endian: true },
        _ => {
            return Err((
                "header, format".into(),
                "allowed are ascii, binary_little_endian and binary_big_endian".into(),
            ));
        }
    };
    Ok((elements, data))
}
