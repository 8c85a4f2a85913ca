//! Groups of a scene and the shells about them, without textures.

use super::capture::projected_layers;
use super::distant_geometry::{DistantGeometry, LayerSpecs};
use super::group_layers::GroupLayers;
use super::groups::LensGroup;
use super::layers::LayerSpec;
use super::shared_layer::SharedLayer;
use super::viewpoints::Shares;
use crate::layered_environment_map::mesh::welds::Welds;
use crate::layered_environment_map::settings::LayeredEnvironmentMapSettings;
use crate::layered_environment_map::shell::Shell;
use crate::layered_environment_map::textures::depths::DEPTH_BYTES;
use crate::layered_environment_map::textures::maps::{Layer, LayersAbout};
use crate::layered_environment_map::textures::texture::TEXEL_BYTES;
use crate::shared::memory::fit_into_memory;
use catoptric_core::progress::{Cancelled, Progress};
use catoptric_core::scene::{Projection, Scene, View};
use catoptric_engine::error::RenderError;
use catoptric_engine::light::tracer::Tracer;
use catoptric_engine::light::two_path_tracer::TwoPathTracer;
use catoptric_engine::method::Settings;
use glam::Vec3;
use std::ops::Range;

/// The shells of a part, about their centre.
#[derive(Clone, Debug, PartialEq)]
pub struct PartShells {
    /// The centre, in world space.
    pub center: Vec3,
    /// The shells of all layers.
    pub shells: Vec<Shell>,
}

/// The groups of a scene with their shells.
pub struct LayerGeometry {
    pub(crate) groups: Vec<GroupLayers>,
    /// The farthest layer of all of them, where they share one.
    pub(crate) shared: Option<SharedLayer>,
    /// Number of the group of every object.
    group_of: Vec<Option<u32>>,
    /// Hierarchy of all objects.
    pub(crate) everything: Tracer,
    /// Vertices in one place.
    pub welds: Welds,
    /// Highest number of specular events of a path.
    pub(crate) order: u32,
}

impl LayerGeometry {
    /// The groups of a scene, for paths of at most `order` specular events.
    pub fn new(settings: &LayeredEnvironmentMapSettings, scene: &Scene, order: u32) -> Self {
        // Without bounces nothing is looked up.
        let groups = if order == 0 { Vec::new() } else { LensGroup::all(scene) };
        let everything = Tracer::build(scene, |_| !groups.is_empty());
        let mut group_of = vec![None; scene.objects.len()];
        for (number, group) in groups.iter().enumerate() {
            group.objects.iter().for_each(|object| group_of[*object as usize] = Some(number as u32));
        }
        let counted = |group: LensGroup| if settings.count_tests { group.counting_tests() } else { group };
        let (mut layers, mut meetings) = (Vec::with_capacity(groups.len()), Vec::new());
        for group in groups {
            let (group, met) = GroupLayers::new(settings, scene, &everything, counted(group), order);
            layers.push(group);
            if settings.share_far {
                meetings.push(met);
            }
        }
        let shared = match settings.share_far {
            true => SharedLayer::taken_from(&mut layers, &meetings, settings.shells),
            false => None,
        };
        Self { groups: layers, shared, group_of, everything, welds: Welds::new(scene), order }
    }

    /// Known shells about the scene's groups: those of so many groups come first, then that of the layer that all
    /// share. Nothing but these groups can be met by rays.
    pub(crate) fn of_shells(
        settings: &LayeredEnvironmentMapSettings,
        scene: &Scene,
        order: u32,
        (parts, group_count): (&[PartShells], usize),
    ) -> Self {
        let groups = LensGroup::all(scene);
        let mut group_of = vec![None; scene.objects.len()];
        for (number, group) in groups.iter().enumerate() {
            group.objects.iter().for_each(|object| group_of[*object as usize] = Some(number as u32));
        }
        let layers = |(group, part): (LensGroup, &PartShells)| {
            let group = if settings.count_tests { group.counting_tests() } else { group };
            GroupLayers::of_shells(settings, scene, group, &part.shells)
        };
        let shared = parts.get(group_count).and_then(|part| {
            let stratum = LayerSpec::of_shell(part.shells.first()?);
            Some(SharedLayer { center: part.center, stratum, within: Vec::new() })
        });
        let groups = groups.into_iter().zip(parts).map(layers).collect();
        let everything = Tracer::build(scene, |_| false);
        Self { groups, shared, group_of, everything, welds: Welds::new(scene), order }
    }

    /// # Errors
    /// [`RenderError::Limit`] where the textures of so many viewpoints (of every group) and their depths do not fit
    /// into memory.
    pub(crate) fn check_memory(
        &self,
        settings: &LayeredEnvironmentMapSettings,
        viewpoints: usize,
    ) -> Result<(), RenderError> {
        let size = settings.sized().size;
        let layouts =
            (0..self.part_count()).flat_map(|part| self.strata_of(part)).map(|layer| layer.shell.layout(size));
        let bytes = layouts.map(|layout| {
            let depths = if settings.depth { layout.finest_count() * DEPTH_BYTES } else { 0 };
            (layout.texel_count() * viewpoints * TEXEL_BYTES + depths) as u64
        });
        let bytes = bytes.sum();
        let table = format!("layers of size = {size} about {} groups, for {viewpoints} viewpoints,", self.groups.len());
        fit_into_memory(LayeredEnvironmentMapSettings::METHOD, &table, bytes, "fewer layers")
    }

    /// Tests of rays against triangles and surfaces of all groups so far; `None` if they are not counted.
    pub(crate) fn test_count(&self) -> Option<u64> {
        self.groups.iter().map(|group| group.group.tracer.test_count()).sum()
    }

    /// The number of an object's group.
    #[inline]
    pub(crate) fn group_of(&self, object: u32) -> Option<usize> {
        self.group_of[object as usize].map(|group| group as usize)
    }

    /// The number of each object's group.
    pub(crate) fn group_of_objects(&self) -> &[Option<u32>] {
        &self.group_of
    }

    /// The paths among an object's group.
    #[inline]
    pub fn paths<'a>(&'a self, scene: &'a Scene, object: u32) -> Option<TwoPathTracer<'a>> {
        let tracer = &self.groups[self.group_of(object)?].group.tracer;
        Some(TwoPathTracer { scene, tracer, order: self.order })
    }

    /// Layers of every part, captured from the centres of their shells.
    pub fn projected(
        &self,
        settings: &LayeredEnvironmentMapSettings,
        scene: &Scene,
        progress: &dyn Progress,
    ) -> Result<Vec<Vec<Layer>>, Cancelled> {
        (0..self.part_count()).map(|part| self.projected_part(settings, scene, part, progress)).collect()
    }

    /// The layers of one part, captured from the centre of their shells.
    pub(crate) fn projected_part(
        &self,
        settings: &LayeredEnvironmentMapSettings,
        scene: &Scene,
        part: usize,
        progress: &dyn Progress,
    ) -> Result<Vec<Layer>, Cancelled> {
        let settings = &settings.sized();
        projected_layers(settings, &self.apart(settings, scene, part), self.strata_of(part), progress)
    }

    /// The things of a part's layers, apart; for a group also those of the layer that all share, as the last.
    pub(crate) fn apart<'a>(
        &'a self,
        settings: &LayeredEnvironmentMapSettings,
        scene: &'a Scene,
        part: usize,
    ) -> LayerSpecs<'a> {
        let within = match (self.groups.get(part), &self.shared) {
            (Some(group), _) => &group.group.objects[..],
            (None, Some(shared)) => &shared.within[..],
            (None, None) => &[][..],
        };
        let around = DistantGeometry { scene, everything: &self.everything, within, center: self.center_of(part) };
        let shared = self.shared.as_ref().filter(|_| part < self.groups.len()).map(|shared| &shared.stratum);
        let strata = self.strata_of(part).iter().chain(shared);
        LayerSpecs::new(around, strata, self.order.saturating_sub(1), settings.continued)
    }

    /// The number of parts, whose layers are made together: the groups, and last the layer that they share.
    pub(crate) fn part_count(&self) -> usize {
        self.groups.len() + usize::from(self.shared.is_some())
    }

    /// The middle of a part's shells.
    pub(crate) fn center_of(&self, part: usize) -> Vec3 {
        let shared = || self.shared.as_ref().map_or(Vec3::ZERO, |shared| shared.center);
        self.groups.get(part).map_or_else(shared, |group| group.group.center())
    }

    /// The layers of a part.
    pub(crate) fn strata_of(&self, part: usize) -> &[LayerSpec] {
        let shared = || self.shared.as_ref().map_or(&[][..], |shared| std::slice::from_ref(&shared.stratum));
        self.groups.get(part).map_or_else(shared, |group| &group.strata)
    }

    /// The groups whose rays look up a part's layers.
    pub(crate) fn groups_of(&self, part: usize) -> Range<usize> {
        if part < self.groups.len() { part..part + 1 } else { 0..self.groups.len() }
    }

    /// The number that a part's layer (that of an index) has among those that a group's rays look up.
    pub(crate) fn number_of(&self, part: usize, group: usize, index: usize) -> usize {
        if part < self.groups.len() { index } else { self.groups[group].strata.len() + index }
    }

    /// The layers that a group's rays look up, of those of all parts.
    pub(crate) fn layers_about<'a>(&self, group: usize, of_part: impl Fn(usize) -> &'a [Layer]) -> LayersAbout<'a> {
        let shared = (self.groups.len()..self.part_count()).flat_map(&of_part);
        of_part(group).iter().chain(shared).collect()
    }

    /// The number of viewpoints of each part.
    pub(crate) fn viewpoint_count(&self) -> u32 {
        self.groups.first().map_or(0, |group| group.viewspace.count())
    }

    /// The viewpoints about a view's eye; orthographic views have an eye far away.
    pub(crate) fn shares(&self, group: usize, scene: &Scene, view: &View) -> Shares {
        let far = match view.projection {
            Projection::Perspective { .. } => Vec3::ZERO,
            Projection::Orthographic { .. } => {
                Vec3::from(view.world_from_view.matrix3.z_axis) * (1e3 * scene.bounds.diagonal())
            }
        };
        self.groups[group].viewspace.around(view.eye() + far)
    }
}
