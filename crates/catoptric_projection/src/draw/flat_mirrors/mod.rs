//! Flat mirrors: copies of the scene mirrored in each, as lists that stencils confine to where the mirror shows.

mod paths;
mod planes;

pub(crate) use paths::{MirrorPath, visible_paths};
pub use planes::Mirrors;
pub(crate) use planes::{MirrorPlane, has_flat_faces};

use catoptric_core::parallel;
use catoptric_core::scene::{Role, Scene, View};
use catoptric_engine::raster::{DrawList, DrawTriangle, Stencil, is_seen_from_behind, patch_of_triangle};

/// The treatment of lenses, and of reflectors that are not flat.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum OtherReflectors {
    /// Black.
    Black,
    /// Something else goes on from them: they have groups that no list belongs to.
    GoOn,
}

/// The copies of a scene in its flat mirrors.
pub(crate) struct MirroredScenes<'a> {
    pub(crate) scene: &'a Scene,
    pub(crate) mirrors: &'a Mirrors,
    pub(crate) view: &'a View,
    /// Highest number of bounces.
    pub(crate) order: u32,
    pub(crate) others: OtherReflectors,
    /// Rays follow lenses: nothing is drawn behind them.
    pub(crate) follows_lenses: bool,
}

impl MirroredScenes<'_> {
    /// The scene as it is seen at the end of a path, in front of its last mirror.
    pub(crate) fn list(&self, path: &MirrorPath) -> DrawList {
        let Self { scene, mirrors, others, .. } = *self;
        let goes_on = path.order < self.order;
        let picture = self.view.picture_from_moved(&path.world_from_scene);
        // Work for all cores: the direct view of a scene without flat mirrors is the only list.
        let vertices = parallel::map_collect(scene.positions.len(), |vertex| picture.apply(scene.positions[vertex]));
        let clip_distances: Vec<f32> = match path.mirror {
            Some(_) => {
                let height = |position: &glam::Vec3| path.height(mirrors, position.as_dvec3()) as f32;
                scene.positions.iter().map(height).collect()
            }
            None => Vec::new(),
        };
        // The eye where the mirrors show it.
        let world_from_view = path.scene_from_world.as_affine3a() * self.view.world_from_view;
        let from_mirror = View { world_from_view, ..self.view.clone() };
        let own = path.mirror.map_or(0, |mirror| mirror + 1);
        let visible = |triangle: &u32| {
            let corners = scene.triangles[*triangle as usize];
            let in_front = path.mirror.is_none() || corners.iter().any(|&vertex| clip_distances[vertex as usize] > 0.0);
            let is_hidden = scene.is_one_sided(scene.triangle_objects[*triangle as usize])
                && is_seen_from_behind(scene, *triangle, &from_mirror);
            !is_hidden && in_front && (own == 0 || mirrors.mirror_of_triangle[*triangle as usize] != own)
        };
        let first_other = mirrors.planes.len() as u32 + 1;
        let triangles = (0..scene.triangles.len() as u32).filter(visible).map(|triangle| {
            let object = scene.triangle_objects[triangle as usize];
            // Group 0 of a reflector is black: those of the last order, for instance.
            let group = match (goes_on, mirrors.mirror_of_triangle[triangle as usize]) {
                (false, _) => 0,
                (true, 0) if self.follows_lenses && scene.role_of(object) == Role::Lens => 0,
                (true, 0) if others == OtherReflectors::GoOn && scene.role_of(object).is_specular() => {
                    first_other + object
                }
                (true, mirror) => mirror,
            };
            DrawTriangle {
                vertices: scene.triangles[triangle as usize],
                source: triangle,
                patch: if others == OtherReflectors::GoOn { patch_of_triangle(scene, triangle) } else { 0 },
                group,
                alpha_tested: scene.is_alpha_tested(object),
            }
        });
        let stencil = path.parent.map(|list| Stencil { list, group: own, ..Stencil::default() });
        DrawList {
            triangles: triangles.collect(),
            vertices,
            clip_distances,
            layer: path.order,
            stencil,
            ..DrawList::default()
        }
    }
}
