//! Triangles of many points as shading needs them, and the points sorted by material.

use super::super::super::Scene;
use super::query::SurfaceQuery;
use glam::{Vec2, Vec3, Vec4};

/// A triangle's attributes: position, normal and coordinates in the material's first texture of its first corner, and
/// their change to the second and third.
#[derive(Clone, Copy, Debug, Default)]
#[repr(C, align(32))]
pub(super) struct TriangleRows {
    pub(super) first: [f32; 8],
    pub(super) second: [f32; 8],
    pub(super) third: [f32; 8],
    /// Normal to its plane, on the side of its corners' normals.
    pub(super) face: Vec3,
    material: u32,
}

impl TriangleRows {
    fn new(scene: &Scene, triangle: u32) -> Self {
        let material = scene.objects[scene.triangle_objects[triangle as usize] as usize].material;
        let binding = scene.materials[material as usize].bindings().next();
        let channel = binding.map_or(0, |binding| binding.uv_channel as usize & 1);
        let corners = scene.triangles[triangle as usize].map(|vertex| vertex as usize);
        let [pa, pb, pc] = corners.map(|vertex| scene.positions[vertex]);
        let [na, nb, nc] = corners.map(|vertex| scene.normals[vertex]);
        let [ua, ub, uc] = corners.map(|vertex| scene.uvs[vertex][channel]);
        let (ab, ac) = (pb - pa, pc - pa);
        let face = ab.cross(ac);
        let face = if face.length_squared() > 1e-36 { face } else { na };
        let face = if face.dot(na + nb + nc) < 0.0 { -face } else { face };
        let row = |position: Vec3, normal: Vec3, uv: Vec2| {
            [position.x, position.y, position.z, normal.x, normal.y, normal.z, uv.x, uv.y]
        };
        let (at, change) = match binding {
            Some(binding) => {
                let map = &binding.texture_from_uv;
                (map.transform_point2(ua), [ub, uc].map(|uv| map.matrix2 * (uv - ua)))
            }
            None => (Vec2::ZERO, [Vec2::ZERO; 2]),
        };
        Self {
            first: row(pa, na, at),
            second: row(ab, nb - na, change[0]),
            third: row(ac, nc - na, change[1]),
            face,
            material,
        }
    }
}

/// Slots of the cache that finds triangles again.
const CACHE_LOG2: u32 = 9;

/// The triangles of queries, and the queries' order: by material, else as they came.
#[derive(Debug)]
pub(super) struct TriangleTable {
    triangles: Vec<TriangleRows>,
    /// The colours of the triangles' corners; empty where the scene has none.
    vertex_colors: Vec<[Vec4; 3]>,
    /// The number of each query's triangle.
    numbers: Vec<u32>,
    order: Vec<u32>,
    /// The materials in their order: where each one's queries end.
    ends: Vec<usize>,
}

impl TriangleTable {
    pub(super) fn new(scene: &Scene, queries: &[SurfaceQuery]) -> Self {
        let mut table = Self {
            triangles: Vec::with_capacity(queries.len() / 16 + 16),
            vertex_colors: Vec::new(),
            numbers: Vec::with_capacity(queries.len()),
            order: Vec::with_capacity(queries.len()),
            ends: Vec::new(),
        };
        table.find_triangles(scene, queries);
        table.sort();
        table
    }

    fn find_triangles(&mut self, scene: &Scene, queries: &[SurfaceQuery]) {
        // A triangle (plus 1) and its number. What does not fit is in the table twice.
        let mut cache = [(0u32, 0u32); 1 << CACHE_LOG2];
        let mut last = (0, 0);
        for query in queries {
            let key = query.triangle.wrapping_add(1);
            if key != last.0 || key == 0 {
                let place = (key.wrapping_mul(0x9e37_79b9) >> (32 - CACHE_LOG2)) as usize;
                if cache[place].0 != key || key == 0 {
                    cache[place] = (key, self.triangles.len() as u32);
                    self.triangles.push(TriangleRows::new(scene, query.triangle));
                    if !scene.colors.is_empty() {
                        let corners = scene.triangles[query.triangle as usize];
                        self.vertex_colors.push(corners.map(|vertex| Vec4::from(scene.colors[vertex as usize])));
                    }
                }
                last = cache[place];
            }
            self.numbers.push(last.1);
        }
    }

    /// Sorts the queries by material.
    fn sort(&mut self) {
        let Self { triangles, numbers, order, ends, .. } = self;
        let count = numbers.len();
        let Some(first) = triangles.first() else { return };
        if triangles.iter().all(|triangle| triangle.material == first.material) {
            order.extend(0..count as u32);
            ends.push(count);
            return;
        }
        let mut materials: Vec<u32> = triangles.iter().map(|triangle| triangle.material).collect();
        materials.sort_unstable();
        materials.dedup();
        let ranks: Vec<usize> = triangles
            .iter()
            .map(|triangle| materials.partition_point(|material| *material < triangle.material))
            .collect();
        ends.resize(materials.len(), 0);
        for &number in numbers.iter() {
            ends[ranks[number as usize]] += 1;
        }
        let mut sum = 0;
        for end in ends.iter_mut() {
            // The start for now: the end when all are placed.
            sum += std::mem::replace(end, sum);
        }
        order.resize(count, 0);
        for (query, &number) in numbers.iter().enumerate() {
            let place = &mut ends[ranks[number as usize]];
            order[*place] = query as u32;
            *place += 1;
        }
    }

    /// Indices of queries.
    pub(super) fn order(&self) -> &[u32] {
        &self.order
    }

    /// The material of the query at a place of the order.
    pub(super) fn material_at(&self, place: usize) -> Option<u32> {
        self.order.get(place).map(|&query| self.triangle_of(query).material)
    }

    /// The place in the order where the queries of the material at a place end.
    pub(super) fn end_of_material(&self, place: usize) -> usize {
        self.ends[self.ends.partition_point(|end| *end <= place)]
    }

    /// The number of a query's triangle.
    #[inline(always)]
    pub(super) fn number_of(&self, query: u32) -> usize {
        self.numbers[query as usize] as usize
    }

    #[inline(always)]
    pub(super) fn triangle_of(&self, query: u32) -> &TriangleRows {
        &self.triangles[self.number_of(query)]
    }

    /// The colours of the corners of all triangles, if the scene has any.
    pub(super) fn vertex_colors(&self) -> Option<&[[Vec4; 3]]> {
        (!self.vertex_colors.is_empty()).then_some(&self.vertex_colors)
    }
}
