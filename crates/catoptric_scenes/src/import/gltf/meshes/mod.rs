//! Primitives: triangles of every mode, vertex attributes, morph targets.

mod draco;

use super::accessors::{Component, Elements};
use super::schema::{self, Mesh};
use super::source::Source;
use catoptric_core::error::SceneError;
use catoptric_core::scene::model::{MorphTarget, Primitive};
use glam::{Vec2, Vec3, Vec4};
use std::collections::BTreeMap;

/// The sets of texture coordinates that a material reads, one a channel.
pub(super) type TextureSets = [Option<u32>; 2];

/// The attributes of vertices that a material needs.
#[derive(Clone, Copy, Debug, Default)]
pub(super) struct VertexNeeds {
    pub(super) sets: TextureSets,
    /// The channel of the normal map's texture coordinates, if there is a normal map.
    pub(super) normal_map: Option<usize>,
}

/// A vertex attribute from an accessor or from a compressed mesh.
pub(super) enum Attribute<'s> {
    Elements(Elements<'s>),
    /// Numbers of all vertices in one row, `width` a vertex.
    Decoded {
        width: usize,
        numbers: Vec<f32>,
    },
}

impl Attribute<'_> {
    fn count(&self) -> usize {
        match self {
            Self::Elements(elements) => elements.count,
            Self::Decoded { width, numbers } => numbers.len() / width.max(&1),
        }
    }

    fn width(&self) -> usize {
        match self {
            Self::Elements(elements) => elements.width,
            Self::Decoded { width, .. } => *width,
        }
    }

    fn floats<const N: usize>(&self, vertex: usize) -> [f32; N] {
        match self {
            Self::Elements(elements) => elements.floats(vertex),
            Self::Decoded { width, numbers } => std::array::from_fn(|number| {
                let inside = number < *width;
                inside.then(|| numbers.get(vertex * width + number)).flatten().copied().unwrap_or(0.0)
            }),
        }
    }

    fn joints(&self, vertex: usize) -> [u16; 4] {
        let index = |number| match self {
            Self::Elements(elements) => elements.index(vertex, number),
            Self::Decoded { .. } => self.floats::<4>(vertex)[number] as u32,
        };
        // A joint beyond 65535 cannot be; the weight of one that does not exist counts for nothing.
        std::array::from_fn(|number| index(number).min(u16::MAX.into()) as u16)
    }
}

/// The vertices that a primitive keeps.
enum Kept {
    All(usize),
    /// Only these; the triangles count in them.
    Some(Vec<u32>),
}

impl Kept {
    fn len(&self) -> usize {
        match self {
            Self::All(count) => *count,
            Self::Some(vertices) => vertices.len(),
        }
    }

    fn collect<T>(&self, mut value: impl FnMut(usize) -> T) -> Vec<T> {
        match self {
            Self::All(count) => (0..*count).map(value).collect(),
            Self::Some(vertices) => vertices.iter().map(|&vertex| value(vertex as usize)).collect(),
        }
    }
}

/// One primitive of a mesh while it is read.
pub(super) struct PrimitiveReader<'r, 's> {
    source: &'s Source<'r>,
    primitive: &'s schema::Primitive,
    /// The primitive's place in the file, for messages.
    owner: String,
    decoded: Option<draco::DecodedMesh>,
}

impl<'r, 's> PrimitiveReader<'r, 's> {
    pub(super) fn new(
        source: &'s Source<'r>,
        primitive: &'s schema::Primitive,
        owner: String,
    ) -> Result<Self, SceneError> {
        let field = || owner.clone();
        let compressed: Option<schema::Draco> = source.extension(&field, &primitive.extensions, draco::EXTENSION)?;
        let decoded = compressed.map(|compressed| draco::decode(source, &compressed, &owner)).transpose()?;
        Ok(Self { source, primitive, owner, decoded })
    }

    fn field(&self, part: &str) -> String {
        format!("{}.{part}", self.owner)
    }

    fn attribute(&mut self, name: &str, kinds: &[&str]) -> Result<Option<Attribute<'s>>, SceneError> {
        let Some(&accessor) = self.primitive.attributes.get(name) else { return Ok(None) };
        if let Some((width, numbers)) = self.decoded.as_mut().and_then(|mesh| mesh.attributes.remove(name)) {
            return Ok(Some(Attribute::Decoded { width, numbers }));
        }
        let field = format!("{}.attributes.{name}", self.owner);
        Ok(Some(Attribute::Elements(self.source.elements(accessor, kinds, &|| field.clone())?)))
    }

    /// The triangles and vertices, or nothing where there is nothing to draw.
    pub(super) fn read(
        mut self,
        needs: VertexNeeds,
        skinned: bool,
        material: usize,
    ) -> Result<Option<Primitive>, SceneError> {
        let mode = self.primitive.mode.unwrap_or(4);
        match mode {
            0..=3 => {
                self.source.warn(format!("{}: points and lines are not drawn", self.owner));
                return Ok(None);
            }
            4..=6 => {}
            _ => return Err(self.source.invalid(self.field("mode"), format!("{mode}; allowed are 0 to 6"))),
        }
        let accessors = &self.source.document.accessors;
        let is_empty = |accessor: usize| accessors.get(accessor).is_some_and(|accessor| accessor.count == 0);
        let mut listed = self.primitive.attributes.get("POSITION").into_iter().chain(&self.primitive.indices);
        if listed.any(|accessor| is_empty(*accessor)) {
            self.source.warn(format!("{}: is empty (an accessor of count 0) and is left out", self.owner));
            return Ok(None);
        }
        let Some(positions) = self.attribute("POSITION", &["VEC3"])? else {
            self.source.warn(format!("{}: without POSITION, not drawn", self.owner));
            return Ok(None);
        };
        let vertex_count = positions.count();
        let mut triangles = self.triangles(mode, vertex_count)?;
        let kept = keep_used(&mut triangles, vertex_count);
        self.spend(kept.len(), 12)?;
        let mut result = Primitive {
            positions: kept.collect(|vertex| Vec3::from(positions.floats(vertex))),
            triangles,
            material,
            ..Primitive::default()
        };
        drop(positions);
        if result.positions.iter().any(|position| !position.is_finite()) {
            self.source.warn(format!("{}: triangles with positions that are not finite are not drawn", self.owner));
        }
        if let Some(normals) = self.vertex_attribute("NORMAL", &["VEC3"], vertex_count)? {
            self.spend(kept.len(), 12)?;
            result.normals = kept.collect(|vertex| Vec3::from(normals.floats(vertex)));
        }
        for (set, uvs) in needs.sets.into_iter().zip(&mut result.uvs) {
            let Some(set) = set else { continue };
            let name = format!("TEXCOORD_{set}");
            match self.vertex_attribute(&name, &["VEC2"], vertex_count)? {
                Some(values) => {
                    self.spend(kept.len(), 8)?;
                    *uvs = kept.collect(|vertex| Vec2::from(values.floats(vertex)));
                }
                None => {
                    self.source.warn(format!("{}: its material's texture needs {name}, which is missing", self.owner))
                }
            }
        }
        if needs.normal_map.is_some()
            && let Some(tangents) = self.vertex_attribute("TANGENT", &["VEC4"], vertex_count)?
        {
            self.spend(kept.len(), 16)?;
            result.tangents = kept.collect(|vertex| Vec4::from(tangents.floats(vertex)));
        }
        if let Some(colors) = self.vertex_attribute("COLOR_0", &["VEC3", "VEC4"], vertex_count)? {
            self.spend(kept.len(), 16)?;
            let has_alpha = colors.width() == 4;
            let colors = as_fractions(colors);
            result.colors = kept.collect(|vertex| {
                let [r, g, b, a] = colors.floats(vertex);
                [r, g, b, if has_alpha { a } else { 1.0 }]
            });
        }
        if skinned {
            self.read_influences(&mut result, &kept, vertex_count)?;
        }
        self.read_targets(&mut result, &kept, vertex_count)?;
        if let Some(channel) = needs.normal_map {
            self.spend(result.triangles.len(), 48)?;
            crate::tangents::complete(&mut result, channel);
        }
        Ok(Some(result))
    }

    fn spend(&self, count: usize, bytes: usize) -> Result<(), SceneError> {
        self.source.spend((count * bytes) as u64, &|| self.owner.clone())
    }

    /// An attribute that must have as many elements as there are vertices.
    fn vertex_attribute(
        &mut self,
        name: &str,
        kinds: &[&str],
        vertex_count: usize,
    ) -> Result<Option<Attribute<'s>>, SceneError> {
        let attribute = self.attribute(name, kinds)?;
        match attribute.as_ref().map(Attribute::count) {
            Some(count) if count != vertex_count => {
                let problem = format!("{count} elements for {vertex_count} positions");
                Err(self.source.invalid(self.field(&format!("attributes.{name}")), problem))
            }
            _ => Ok(attribute),
        }
    }

    fn triangles(&mut self, mode: u32, vertex_count: usize) -> Result<Vec<[u32; 3]>, SceneError> {
        let indices: Vec<u32> =
            match (self.decoded.as_mut().map(|mesh| std::mem::take(&mut mesh.indices)), self.primitive.indices) {
                (Some(indices), _) => indices,
                (None, Some(accessor)) => {
                    let elements = self.source.elements(accessor, &["SCALAR"], &|| self.field("indices"))?;
                    if !matches!(elements.component, Component::U8 | Component::U16 | Component::U32) {
                        return Err(self.source.invalid(self.field("indices"), "indices must be unsigned integers"));
                    }
                    self.spend(elements.count, 4)?;
                    (0..elements.count).map(|element| elements.index(element, 0)).collect()
                }
                (None, None) => {
                    self.spend(vertex_count, 4)?;
                    (0..u32::try_from(vertex_count).unwrap_or(u32::MAX)).collect()
                }
            };
        if let Some((place, index)) = indices.iter().enumerate().find(|(_, index)| **index as usize >= vertex_count) {
            let problem = format!("element {place} is {index}, but there are only {vertex_count} vertices");
            return Err(self.source.invalid(self.field("indices"), problem));
        }
        self.spend(if mode == 4 { indices.len() / 3 } else { indices.len() }, 12)?;
        let mut triangles: Vec<[u32; 3]> = match mode {
            5 => {
                let turned =
                    |(place, t): (usize, &[u32])| if place % 2 == 0 { [t[0], t[1], t[2]] } else { [t[1], t[0], t[2]] };
                indices.windows(3).enumerate().map(turned).collect()
            }
            6 => {
                let center = indices.first().copied().unwrap_or(0);
                indices.get(1..).unwrap_or(&[]).windows(2).map(|edge| [center, edge[0], edge[1]]).collect()
            }
            _ => {
                if !indices.len().is_multiple_of(3) {
                    self.source.warn(format!(
                        "{}: the last {} indices make no triangle",
                        self.owner,
                        indices.len() % 3
                    ));
                }
                indices.chunks_exact(3).map(|t| [t[0], t[1], t[2]]).collect()
            }
        };
        // Strips use triangles without area to jump.
        triangles.retain(|[a, b, c]| a != b && b != c && a != c);
        Ok(triangles)
    }

    /// The four strongest joints of each vertex.
    fn read_influences(&mut self, result: &mut Primitive, kept: &Kept, vertex_count: usize) -> Result<(), SceneError> {
        let mut sets = Vec::new();
        while let Some(joints) = self.vertex_attribute(&format!("JOINTS_{}", sets.len()), &["VEC4"], vertex_count)? {
            let name = format!("WEIGHTS_{}", sets.len());
            let Some(weights) = self.vertex_attribute(&name, &["VEC4"], vertex_count)? else {
                return Err(self
                    .source
                    .invalid(self.field(&format!("attributes.{name}")), "missing, though there are joints"));
            };
            sets.push((joints, as_fractions(weights)));
        }
        if sets.is_empty() {
            return Ok(());
        }
        if sets.len() > 1 {
            self.source.warn(format!("{}: only the four strongest joints of a vertex are used", self.owner));
        }
        self.spend(kept.len(), 24)?;
        let mut influences: Vec<(u16, f32)> = Vec::new();
        let strongest = kept.collect(|vertex| {
            influences.clear();
            for (joints, weights) in &sets {
                influences.extend(joints.joints(vertex).into_iter().zip(weights.floats::<4>(vertex)));
            }
            if sets.len() > 1 {
                influences.sort_by(|a, b| b.1.total_cmp(&a.1));
            }
            std::array::from_fn::<(u16, f32), 4, _>(|influence| influences[influence])
        });
        result.joints = strongest.iter().map(|four| four.map(|(joint, _)| joint)).collect();
        result.weights = strongest.iter().map(|four| four.map(|(_, weight)| weight)).collect();
        Ok(())
    }

    fn read_targets(&self, result: &mut Primitive, kept: &Kept, vertex_count: usize) -> Result<(), SceneError> {
        for (index, target) in self.primitive.targets.iter().enumerate() {
            let offsets = |name: &str| -> Result<Vec<Vec3>, SceneError> {
                let Some(&accessor) = target.get(name) else { return Ok(Vec::new()) };
                let field = || self.field(&format!("targets[{index}].{name}"));
                let elements = self.source.elements(accessor, &["VEC3"], &field)?;
                if elements.count != vertex_count {
                    let problem = format!("{} elements for {vertex_count} positions", elements.count);
                    return Err(self.source.invalid(field(), problem));
                }
                self.spend(kept.len(), 12)?;
                Ok(kept.collect(|vertex| Vec3::from(elements.floats(vertex))))
            };
            result.morph_targets.push(MorphTarget {
                positions: offsets("POSITION")?,
                normals: offsets("NORMAL")?,
                tangents: if result.tangents.is_empty() { Vec::new() } else { offsets("TANGENT")? },
            });
        }
        Ok(())
    }
}

/// Integers of colours and weights are fractions even if the file lacks the flag.
fn as_fractions(attribute: Attribute<'_>) -> Attribute<'_> {
    match attribute {
        Attribute::Elements(elements) => Attribute::Elements(elements.normalized()),
        decoded => decoded,
    }
}

/// Many primitives may share one large array: keeps only the vertices of these triangles if they are less than half.
fn keep_used(triangles: &mut [[u32; 3]], vertex_count: usize) -> Kept {
    if triangles.len() * 3 * 2 >= vertex_count * 3 {
        return Kept::All(vertex_count);
    }
    let mut renumbered: BTreeMap<u32, u32> = triangles.iter().flatten().map(|&vertex| (vertex, 0)).collect();
    for (new, (_, number)) in renumbered.iter_mut().enumerate() {
        *number = new as u32;
    }
    for vertex in triangles.iter_mut().flatten() {
        *vertex = renumbered.get(vertex).copied().unwrap_or(0);
    }
    Kept::Some(renumbered.into_keys().collect())
}

/// The number of morph targets of a mesh's primitives.
pub(super) fn target_count(mesh: &Mesh) -> usize {
    mesh.primitives.iter().map(|primitive| primitive.targets.len()).max().unwrap_or(0)
}
