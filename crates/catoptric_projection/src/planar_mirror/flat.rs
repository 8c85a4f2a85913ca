//! The flat mirrors of a scene, and the views in them, for other processors to draw.

use super::{PlanarMirrorSettings, find, left_out_warning, most_lists};
use crate::draw::flat_mirrors::{Mirrors, visible_paths};
use catoptric_core::scene::{Scene, View};
use catoptric_engine::method::Report;
use glam::{DAffine3, DVec4};

/// The flat mirrors of a scene.
#[derive(Clone, Debug)]
pub struct FlatMirrors {
    mirrors: Mirrors,
}

/// The scene in a mirror, or in several one after the other.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct MirrorView {
    /// The view in which its mirror is seen: 0 the view itself, else one before this, counted from 1.
    pub parent: u32,
    /// The mirror, as in [`FlatMirrors::mirror_of_triangle`].
    pub mirror: u32,
    /// The number of mirrors from the eye on.
    pub order: u32,
    /// Moves the scene to where it is seen.
    pub world_from_scene: DAffine3,
    /// The clipping plane: points `p` of the scene are seen if `plane . (p, 1)`, the distance from the mirror, is above
    /// 0.
    pub plane: DVec4,
}

impl FlatMirrors {
    /// Finds all flat mirrors of a scene; the report has the reflectors that are none.
    pub fn find(scene: &Scene) -> (Self, Report) {
        let (mirrors, report) = find(scene);
        (Self { mirrors }, report)
    }

    /// The number of the mirror of every triangle of the scene, from 1; 0: it is part of none.
    pub fn mirror_of_triangle(&self) -> &[u32] {
        &self.mirrors.mirror_of_triangle
    }

    /// The views in mirrors, after up to `order` of them, shorter paths first. Paths that have to be left out are added
    /// to a report.
    pub fn views(
        &self,
        settings: &PlanarMirrorSettings,
        scene: &Scene,
        view: &View,
        order: u32,
        report: &mut Report,
    ) -> Vec<MirrorView> {
        let (paths, left_out) = visible_paths(scene, &self.mirrors, view, order, most_lists(settings, scene));
        if left_out > 0 {
            report.fallbacks.insert("lists_left_out", left_out);
            report.warnings.push(left_out_warning(left_out));
        }
        // The first path is the view itself.
        let in_mirrors = paths.iter().filter_map(|path| Some((path, path.parent?, path.mirror?)));
        let view = |(path, parent, mirror): (&_, u32, u32)| {
            let super::MirrorPath { order, world_from_scene, side, .. } = *path;
            let plane = &self.mirrors.planes[mirror as usize];
            let plane = plane.normal.extend(-plane.offset) * side;
            MirrorView { parent, mirror: mirror + 1, order, world_from_scene, plane }
        };
        in_mirrors.map(view).collect()
    }
}
