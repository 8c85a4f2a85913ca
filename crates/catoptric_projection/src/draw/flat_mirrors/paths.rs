//! Visible sequences of mirrors, and their places on the picture.

use super::planes::{MirrorPlane, Mirrors};
use catoptric_core::scene::{PictureTransform, Projection, Scene, View};
use glam::{DAffine3, DVec3, Vec2, Vec3};

/// A chain of mirrors from the eye, and the mirrored scene that is seen at its end.
#[derive(Clone, Debug)]
pub(crate) struct MirrorPath {
    /// The path without its last mirror, as an index; `None` for direct view.
    pub(crate) parent: Option<u32>,
    /// The last mirror.
    pub(crate) mirror: Option<u32>,
    /// Number of mirrors.
    pub(crate) order: u32,
    /// Moves the scene to where it is seen.
    pub(crate) world_from_scene: DAffine3,
    /// Moves the eye and its rays to where they are in the scene.
    pub(crate) scene_from_world: DAffine3,
    /// Sign: points behind the last mirror have negative heights times this.
    pub(crate) side: f64,
    /// The part of the picture where it can be seen.
    extent: Rectangle,
}

#[derive(Clone, Copy, Debug)]
struct Rectangle {
    min: Vec2,
    max: Vec2,
}

impl Rectangle {
    fn intersection(self, other: Self) -> Self {
        Self { min: self.min.max(other.min), max: self.max.min(other.max) }
    }

    fn is_empty(&self) -> bool {
        !(self.min.cmplt(self.max).all())
    }
}

/// The sequences of up to `order` mirrors that can be seen, shorter ones first; at most `max_paths`.
///
/// The second value counts the paths that were left out because of the limit.
pub(crate) fn visible_paths(
    scene: &Scene,
    mirrors: &Mirrors,
    view: &View,
    order: u32,
    max_paths: usize,
) -> (Vec<MirrorPath>, u64) {
    let whole = Rectangle { min: Vec2::ZERO, max: Vec2::new(view.width as f32, view.height as f32) };
    let mut paths = vec![MirrorPath {
        parent: None,
        mirror: None,
        order: 0,
        world_from_scene: DAffine3::IDENTITY,
        scene_from_world: DAffine3::IDENTITY,
        side: 1.0,
        extent: whole,
    }];
    let mut left_out = 0;
    let mut next = 0;
    while next < paths.len() {
        let parent = paths[next].clone();
        let parent_index = next as u32;
        next += 1;
        if parent.order >= order {
            continue;
        }
        let picture = view.picture_from_moved(&parent.world_from_scene);
        for (index, mirror) in mirrors.planes.iter().enumerate() {
            if parent.mirror == Some(index as u32) {
                continue; // a plane never shows itself
            }
            let Some(side) = seen_side(mirror, view, &parent.scene_from_world) else { continue };
            let behind = parent.mirror.map(|last| (&mirrors.planes[last as usize], parent.side));
            let extent = extent(scene, mirror, &picture, view.near, behind, whole).intersection(parent.extent);
            if extent.is_empty() {
                continue;
            }
            if paths.len() >= max_paths {
                left_out += 1;
                continue;
            }
            // The image of the scene in the mirror, then in the mirrors before it.
            let reflection = mirror.reflection();
            paths.push(MirrorPath {
                parent: Some(parent_index),
                mirror: Some(index as u32),
                order: parent.order + 1,
                world_from_scene: parent.world_from_scene * reflection,
                scene_from_world: reflection * parent.scene_from_world,
                side,
                extent,
            });
        }
    }
    (paths, left_out)
}

/// The side of a mirror that the (mirrored) eye is on: 1 on the outer side, -1 on the inner; returns `None` if the
/// mirror does not face it.
fn seen_side(mirror: &MirrorPlane, view: &View, scene_from_world: &DAffine3) -> Option<f64> {
    let height = match view.projection {
        Projection::Perspective { .. } => mirror.height(scene_from_world.transform_point3(view.eye().as_dvec3())),
        Projection::Orthographic { .. } => {
            let back = Vec3::from(view.world_from_view.matrix3.z_axis).as_dvec3();
            mirror.normal.dot(scene_from_world.transform_vector3(back))
        }
    };
    if height == 0.0 || !height.is_finite() || (mirror.inside && height > 0.0) {
        return None; // seen edge-on, or its blind side
    }
    Some(height.signum())
}

/// The rectangle on the picture where a mirror can be seen, through the mirror before it.
fn extent(
    scene: &Scene,
    mirror: &MirrorPlane,
    picture: &PictureTransform,
    near: f32,
    behind: Option<(&MirrorPlane, f64)>,
    whole: Rectangle,
) -> Rectangle {
    let empty = Rectangle { min: Vec2::INFINITY, max: Vec2::NEG_INFINITY };
    let mut found = empty;
    let mut in_front = behind.is_none();
    let mut beyond_near = false;
    for &triangle in &mirror.triangles {
        for vertex in scene.triangles[triangle as usize] {
            let position = scene.positions[vertex as usize];
            if let Some((last, side)) = behind {
                in_front |= last.height(position.as_dvec3()) * side > 0.0;
            }
            let point = picture.apply(position);
            if point.depth < near {
                beyond_near = true;
                continue;
            }
            let at = point.xy / point.w;
            found = Rectangle { min: found.min.min(at), max: found.max.max(at) };
        }
    }
    match (in_front, beyond_near) {
        (false, _) => empty,
        // A mirror that reaches behind the eye may be seen anywhere.
        (true, true) => whole,
        (true, false) => found,
    }
}

impl MirrorPath {
    /// Height of a scene point in front of the path's last mirror; points below 0 are not seen.
    pub(crate) fn height(&self, mirrors: &Mirrors, point: DVec3) -> f64 {
        match self.mirror {
            Some(mirror) => mirrors.planes[mirror as usize].height(point) * self.side,
            None => f64::INFINITY,
        }
    }
}
