//! What is known of a scene before any texture is made: its groups and the shells about them.

use super::group_layers::GroupLayers;
use super::groups::LensGroup;
use super::maps::LayeredMap;
use super::settings::LayeredEnvironmentMapSettings;
use super::surroundings::{Strata, Surroundings};
use super::viewpoints::Shares;
use super::welds::Welds;
use crate::error::RenderError;
use crate::methods::lookup::greedy::GreedyPaths;
use crate::methods::lookup::memory::fit_into_memory;
use crate::progress::Progress;
use crate::scene::{Projection, Scene, View};
use crate::surface::tracer::Tracer;
use glam::{Vec3, Vec4};

/// The groups of a scene with their shells.
pub(super) struct Known {
    pub(super) groups: Vec<GroupLayers>,
    /// Of every object its group's number.
    group_of: Vec<Option<u32>>,
    /// Of everything.
    pub(super) everything: Tracer,
    pub(super) welds: Welds,
    /// Highest number of specular events of a path.
    pub(super) order: u32,
}

impl Known {
    pub(super) fn new(settings: &LayeredEnvironmentMapSettings, scene: &Scene, order: u32) -> Self {
        // Without bounces nothing is looked up.
        let groups = if order == 0 { Vec::new() } else { LensGroup::all(scene) };
        let everything = Tracer::build(scene, |_| !groups.is_empty());
        let mut group_of = vec![None; scene.objects.len()];
        for (number, group) in groups.iter().enumerate() {
            group.objects.iter().for_each(|object| group_of[*object as usize] = Some(number as u32));
        }
        let counted = |group: LensGroup| if settings.count_tests { group.counting_tests() } else { group };
        let layers = |group| GroupLayers::new(settings, scene, &everything, counted(group), order);
        let groups = groups.into_iter().map(layers).collect();
        Self { groups, group_of, everything, welds: Welds::new(scene), order }
    }

    /// # Errors
    /// [`RenderError::Limit`] where the textures of so many viewpoints (of every group) do not fit into memory.
    pub(super) fn check_memory(&self, size: u32, viewpoints: usize) -> Result<(), RenderError> {
        let strata = self.groups.iter().flat_map(|group| &group.strata);
        let texels: usize = strata.map(|stratum| stratum.shell.layout(size).texel_count()).sum();
        let table = format!("layers of size = {size} about {} groups, for {viewpoints} viewpoints,", self.groups.len());
        let bytes = (texels * viewpoints * size_of::<Vec4>()) as u64;
        fit_into_memory(super::INFO.id, &table, bytes, "fewer layers")
    }

    /// Tests of rays against triangles and surfaces of all groups so far; none where they are not counted.
    pub(super) fn test_count(&self) -> Option<u64> {
        self.groups.iter().map(|group| group.group.tracer.test_count()).sum()
    }

    /// Whether they are of a scene with as many objects.
    pub(super) fn fit(&self, scene: &Scene) -> bool {
        self.group_of.len() == scene.objects.len()
    }

    /// The number of an object's group.
    #[inline]
    pub(super) fn group_of(&self, object: u32) -> Option<usize> {
        self.group_of[object as usize].map(|group| group as usize)
    }

    /// The paths among an object's group.
    #[inline]
    pub(super) fn paths<'a>(&'a self, scene: &'a Scene, object: u32) -> Option<GreedyPaths<'a>> {
        let tracer = &self.groups[self.group_of(object)?].group.tracer;
        Some(GreedyPaths { scene, tracer, order: self.order })
    }

    /// Of every group the layers without textures.
    pub(super) fn bare(
        &self,
        settings: &LayeredEnvironmentMapSettings,
        scene: &Scene,
        progress: &dyn Progress,
    ) -> Vec<LayeredMap> {
        let map = |group: &GroupLayers| group.bare(settings, &self.apart(settings, scene, group), progress);
        self.groups.iter().map(map).collect()
    }

    /// Of every group the layers as they are seen from the middle of their shells.
    pub(super) fn projected(
        &self,
        settings: &LayeredEnvironmentMapSettings,
        scene: &Scene,
        progress: &dyn Progress,
    ) -> Vec<LayeredMap> {
        let map = |group: &GroupLayers| {
            let apart = self.apart(settings, scene, group);
            let mut map = group.bare(settings, &apart, progress);
            group.project(settings, &apart, &mut map, progress);
            map
        };
        self.groups.iter().map(map).collect()
    }

    /// The things of a group's layers, apart.
    pub(super) fn apart<'a>(
        &'a self,
        settings: &LayeredEnvironmentMapSettings,
        scene: &'a Scene,
        group: &'a GroupLayers,
    ) -> Strata<'a> {
        let around = Surroundings { scene, everything: &self.everything, group: &group.group };
        Strata::new(around, &group.strata, self.order.saturating_sub(1), settings.continued)
    }

    /// The viewpoints about a view's eye; orthographic views have an eye far away.
    pub(super) fn shares(&self, group: usize, scene: &Scene, view: &View) -> Shares {
        let far = match view.projection {
            Projection::Perspective { .. } => Vec3::ZERO,
            Projection::Orthographic { .. } => {
                Vec3::from(view.world_from_view.matrix3.z_axis) * (1e3 * scene.bounds.diagonal())
            }
        };
        self.groups[group].viewspace.around(view.eye() + far)
    }
}
