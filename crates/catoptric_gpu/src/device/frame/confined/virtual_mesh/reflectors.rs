//! Which reflectors' virtual geometry is found on the device, and where they are in a view.

use crate::layout::Reflection;
use crate::tables::SceneTables;
use catoptric::math::Aabb;
use catoptric::scene::{Object, Role, Scene, View};
use glam::{Mat4, Vec2, Vec3, Vec4};

/// Edges shorter than this share of the scene are never divided: as on the processor.
const SHORTEST: f32 = 1e-4;

/// Spheres are this much larger than what they are to hold: as on the processor.
const ROOM: f32 = 1.001;

/// A reflector's own picture shows this much more than the reflector, in pixels.
const MARGIN_PX: f32 = 2.0;

/// A reflector that appears larger than so many of its own pictures, along a side, is left to the processor: its
/// picture would be too coarse. Chosen, not measured.
const MOST_PICTURES: f32 = 4.0;

/// How virtual geometry is looked for, and how finely it is divided.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Search {
    /// Texels along a side of explosion maps; `None`: by the reflector's picture.
    pub(crate) map_size: Option<u32>,
    /// The error of edges, in pixels.
    pub(crate) edge_error_px: f32,
    /// The smallest pieces, in pixels.
    pub(crate) piece_px: f32,
}

/// A reflector whose virtual geometry a device can find.
#[derive(Clone, Copy, Debug)]
pub(super) struct Reflector {
    pub(super) object: u32,
    /// Every point appears once in it, and nothing of itself.
    pub(super) is_convex: bool,
}

/// The reflectors of a scene whose virtual geometry a device can find: if all are smooth. `None` for other scenes.
pub(super) fn reflectors_of(scene: &Scene, tables: &SceneTables) -> Option<Vec<Reflector>> {
    let objects = scene.specular_objects();
    let is_found = |index: &u32| {
        let material = scene.material_of(*index);
        let is_smooth = material.turning_map().is_none() && material.reflection_roughness() <= 0.0;
        material.role != Role::Lens && is_smooth && !scene.is_alpha_tested(*index)
    };
    let reflector = |object: &u32| {
        let shape = &tables.shapes[*object as usize];
        let is_convex = shape.is_convex && shape.is_closed && !scene.objects[*object as usize].inside;
        Reflector { object: *object, is_convex }
    };
    (!objects.is_empty() && objects.iter().all(is_found)).then(|| objects.iter().map(reflector).collect())
}

/// The reflectors that a view's picture may show; `None` if one of them reaches to behind the eye or around it, or is
/// seen from too near.
pub(super) fn seen_in(
    scene: &Scene,
    view: &View,
    reflectors: &[Reflector],
    search: &Search,
    clip_from_world: &Mat4,
) -> Option<Vec<Reflection>> {
    let mut all = Vec::new();
    let picture = Vec2::new(view.width as f32, view.height as f32);
    let axis = -Vec3::from(view.world_from_view.matrix3.z_axis);
    let depths = scene.bounds.corners().map(|corner| (corner - view.eye()).dot(axis));
    let farthest = depths.into_iter().fold(view.near, f32::max);
    for &Reflector { object: index, is_convex } in reflectors {
        let Object { bounds, triangles, vertices, .. } = &scene.objects[index as usize];
        let [low, high] = extent_px(view, bounds)?;
        let shown = [low.max(Vec2::ZERO), high.min(picture)];
        let size = high - low;
        if shown[0].cmpge(shown[1]).any() {
            continue;
        }
        if size.cmpgt(picture * MOST_PICTURES).any() || !size.is_finite() {
            return None;
        }
        let middle = bounds.center();
        let rays = view.rays();
        let towards = if rays.perspective { Vec3::from(rays.origin) - middle } else { -axis };
        let towards = towards.try_normalize()?;
        let (across, up) = towards.any_orthonormal_pair();
        let axes = [across, up, towards];
        let corners = scene.bounds.corners().map(|corner| corner.distance(middle));
        let far_radius = corners.into_iter().fold(bounds.diagonal(), f32::max) * ROOM;
        // From the clip space of the view's picture to that of the part.
        let (scale, middle_px) = (picture / size, (low + high) * 0.5);
        let at = Vec2::new(2.0 * middle_px.x / picture.x - 1.0, 1.0 - 2.0 * middle_px.y / picture.y);
        let part = Mat4::from_cols(
            Vec4::X * scale.x,
            Vec4::Y * scale.y,
            Vec4::Z,
            Vec4::new(-at.x * scale.x, -at.y * scale.y, 0.0, 1.0),
        );
        all.push(Reflection {
            clip_from_world: (part * *clip_from_world).to_cols_array_2d(),
            low: low.to_array(),
            size: size.to_array(),
            shown_low: shown[0].to_array(),
            shown_high: shown[1].to_array(),
            box_low: bounds.min.to_array(),
            radius: bounds.diagonal() * 0.5,
            box_high: bounds.max.to_array(),
            object: index,
            axis: axis.to_array(),
            near: view.near,
            // A path is no longer than the way there, through the scene, and the longest of ways in it.
            far: farthest + 2.0 * scene.bounds.diagonal(),
            edge_error_px: search.edge_error_px,
            piece_px: search.piece_px,
            shortest: SHORTEST * scene.bounds.diagonal(),
            own_vertices: [vertices.start, vertices.end],
            own_triangles: [triangles.start, triangles.end],
            vertex_count: scene.positions.len() as u32,
            triangle_count: scene.triangles.len() as u32,
            number: all.len() as u32,
            shows_itself: u32::from(!is_convex),
            map_x: axes[0].to_array(),
            far_radius,
            map_y: axes[1].to_array(),
            map_z: axes[2].to_array(),
            ..Reflection::default()
        });
    }
    Some(all)
}

/// The corners of what of a picture a box takes, with a margin; `None` if it reaches to behind the near plane.
fn extent_px(view: &View, bounds: &Aabb) -> Option<[Vec2; 2]> {
    let transform = view.picture_from_world();
    let (mut low, mut high) = (Vec2::INFINITY, Vec2::NEG_INFINITY);
    for corner in bounds.corners() {
        let point = transform.apply(corner);
        if point.depth.is_nan() || point.depth <= view.near {
            return None;
        }
        let at = point.xy / point.w;
        (low, high) = (low.min(at), high.max(at));
    }
    (low.is_finite() && high.is_finite()).then(|| [low - MARGIN_PX, high + MARGIN_PX])
}
