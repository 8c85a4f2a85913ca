//! A scene as flat tables for shaders.
//!
//! [`SceneTables`] has everything that can move; textures and the environment, which cannot, have tables of their own.

mod features;
mod fields;
mod layers;
mod light;
mod maps;
mod moved;
mod sky;
mod surfaces;
mod textures;

pub use features::SceneFeatures;
pub use fields::{FieldTables, field_tables, slab_pictures, slab_sizes, slab_tables};
pub use layers::{LayerMaps, layer_maps};
pub use light::{EnvironmentPlaces, EnvironmentTexels, environment_texels, light_records};
pub use maps::{MapTables, map_tables};
pub use moved::Moved;
#[cfg(feature = "wgpu")]
pub(crate) use moved::has_pictures;
pub use sky::sky_texels;
pub use surfaces::surface_records;
pub use textures::{TextureTables, texture_tables};

use crate::hierarchy::Hierarchy;
use crate::layout::{Surface, Vertex, bits, hit_flags};
use catoptric::methods::projection::multiperspective::ObjectShape;
use catoptric::scene::{Role, Scene};

/// Another moment of a scene, of which some things may hold still.
#[derive(Clone, Copy, Debug)]
pub struct Earlier<'a> {
    /// The scene then.
    pub scene: &'a Scene,
    /// The hierarchy over that scene.
    pub hierarchy: &'a Hierarchy,
    /// The shapes of its objects.
    pub shapes: &'a [ObjectShape],
}

/// A scene as shaders read it, beside lights, textures and environment.
#[derive(Clone, Debug)]
pub struct SceneTables {
    /// All vertices.
    pub vertices: Vec<Vertex>,
    /// Three vertices and the object of every triangle; behind them the light on them: see [`sky_texels`].
    pub triangles: Vec<[u32; 4]>,
    /// Objects with their materials.
    pub surfaces: Vec<Surface>,
    /// Texels behind the objects: programs of expressions, and lobes.
    pub behind_surfaces: Vec<[u32; 4]>,
    /// True if rays follow the lobes of surfaces.
    pub follows_lobes: bool,
    /// The shapes of objects.
    pub shapes: Vec<ObjectShape>,
    /// Over all triangles.
    pub hierarchy: Hierarchy,
    /// The triangles in the order in which they are drawn, with [`hit_flags`]: those without holes first.
    pub draw_order: Vec<u32>,
    /// How many have no holes.
    pub solid_count: u32,
}

impl SceneTables {
    /// The tables of a scene, with what holds of an earlier moment of it. Of triangles of mirrors and glass that do not
    /// show anything the own light alone is seen. Lobes are followed if `follows_lobes`.
    pub fn new(scene: &Scene, earlier: Option<Earlier<'_>>, shows: impl Fn(u32) -> bool, follows_lobes: bool) -> Self {
        let tested = |triangle: &u32| scene.is_alpha_tested(scene.triangle_objects[*triangle as usize]);
        let all = 0..scene.triangles.len() as u32;
        let (with_holes, mut draw_order): (Vec<u32>, Vec<u32>) = all.partition(tested);
        let solid_count = draw_order.len() as u32;
        draw_order.extend(with_holes);
        for triangle in &mut draw_order {
            let bits = if shows(*triangle) { onward_bits(scene, *triangle, follows_lobes) } else { 0 };
            *triangle = (*triangle + 1) | bits;
        }
        let shapes = surfaces::shapes(scene, earlier.map(|earlier| (earlier.scene, earlier.shapes)));
        let refitted = earlier.and_then(|earlier| earlier.hierarchy.refitted(scene));
        let of_object = scene.triangles.iter().zip(&scene.triangle_objects);
        let mut triangles: Vec<_> = of_object.map(|(&[a, b, c], object)| [a, b, c, *object]).collect();
        triangles.extend(sky_texels(scene.sky.as_deref(), triangles.len()));
        let (surfaces, behind_surfaces) = surface_records(scene, &shapes, follows_lobes);
        Self {
            vertices: vertices(scene),
            triangles,
            surfaces,
            behind_surfaces,
            follows_lobes,
            shapes,
            hierarchy: refitted.unwrap_or_else(|| Hierarchy::new(scene)),
            draw_order,
            solid_count,
        }
    }
}

/// The bits of hits on a triangle that say how light goes on from there.
pub(crate) fn onward_bits(scene: &Scene, triangle: u32, follows_lobes: bool) -> u32 {
    let material = scene.material_of(scene.triangle_objects[triangle as usize]);
    let (role, has_lobes) = (material.role, follows_lobes && material.lobes().is_some());
    bits(&[
        (hit_flags::HIT_REFLECTS, role != Role::Diffuse || has_lobes),
        (hit_flags::HIT_REFRACTS, role == Role::Lens),
        (hit_flags::HIT_BLURRED, has_lobes),
    ])
}

fn vertices(scene: &Scene) -> Vec<Vertex> {
    let mut parts = vec![0; scene.positions.len()];
    for (triangle, part) in scene.triangles.iter().zip(&scene.triangle_parts) {
        triangle.iter().for_each(|vertex| parts[*vertex as usize] = *part);
    }
    parts.into_iter().enumerate().map(|(index, part)| vertex(scene, index, part)).collect()
}

/// The record of a vertex, whose triangles are of a part.
fn vertex(scene: &Scene, index: usize, part: u32) -> Vertex {
    let [first, second] = scene.uvs[index];
    Vertex {
        position: scene.positions[index].to_array(),
        u0: first.x,
        normal: scene.normals[index].to_array(),
        v0: first.y,
        color: scene.colors.get(index).copied().unwrap_or([1.0; 4]),
        tangent: scene.tangents.get(index).copied().unwrap_or_default().to_array(),
        uv1: second.to_array(),
        part,
        unused: 0,
    }
}
