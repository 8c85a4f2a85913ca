//! Flat mirrors: the scene mirrored in each, drawn by hardware where the mirror is seen.

use super::records::{MOST_PATHS, PathRecords};
use crate::device::context::Context;
use crate::device::frame::targets::Targets;
use crate::device::frame::timer::Timer;
use crate::device::scene::{DeviceScene, Upload};
use crate::error::GpuError;
use crate::layout::MirrorPath;
use catoptric::methods::projection::planar_mirror::{FlatMirrors, MirrorView, PlanarMirrorSettings};
use catoptric::methods::{Quality, Report};
use catoptric::scene::{Scene, View};
use glam::{DMat4, Mat4};
use wgpu::{BindingResource, TextureView};

/// The flat mirrors of a scene on a device.
#[derive(Debug)]
pub(crate) struct DeviceMirrors {
    mirrors: FlatMirrors,
    settings: PlanarMirrorSettings,
    /// The mirror of every triangle.
    table: TextureView,
}

impl DeviceMirrors {
    /// The flat mirrors of a scene, and a report of what is none.
    pub(crate) fn new(
        context: &Context,
        scene: &Scene,
        settings: &PlanarMirrorSettings,
    ) -> Result<(Self, Report), GpuError> {
        let (mirrors, report) = FlatMirrors::find(scene);
        let table =
            Upload { context, byte_count: 0 }.numbers("the mirrors of triangles", mirrors.mirror_of_triangle())?;
        Ok((Self { mirrors, settings: settings.clone(), table }, report))
    }

    /// True for triangles that are part of a flat mirror.
    pub(crate) fn shows(&self, triangle: u32) -> bool {
        self.mirrors.mirror_of_triangle()[triangle as usize] != 0
    }

    /// Draws what a view shows after each number of mirrors. What has to be left out is added to a report.
    #[expect(clippy::too_many_arguments, reason = "a frame needs as many")]
    pub(crate) fn draw(
        &self,
        encoder: &mut wgpu::CommandEncoder,
        context: &Context,
        resident: &DeviceScene,
        (scene, view, quality): (&Scene, &View, Quality),
        clip_from_world: Mat4,
        targets: &Targets,
        timer: &mut Timer,
        report: &mut Report,
    ) -> Result<(), GpuError> {
        let Context { device, pipelines, .. } = context;
        let mut views = self.mirrors.views(&self.settings, scene, view, quality.order, report);
        if views.len() > MOST_PATHS {
            report.add_fallback("lists_left_out", (views.len() - MOST_PATHS) as u64);
            views.truncate(MOST_PATHS);
        }
        report.counts.insert("lists", views.len() as u64 + 1);
        let records = (1..).zip(&views).map(|(number, view)| record(view, number, clip_from_world));
        let records = PathRecords::new(device, records);
        let index = usize::from(quality.samples > 1);
        let mut last = &targets.ids;
        for (order, picture) in (1..).zip(&targets.drawn) {
            let table = (1, BindingResource::TextureView(&self.table));
            let group = pipelines.mirrors.group(device, index, records.binding(), Some(table), last);
            // Every sample is on one path of each order: all of them share the depth.
            let mut pass = targets.begin(encoder, picture, timer.render("mirrored"));
            pass.set_bind_group(0, &resident.scene, &[0]);
            pass.set_bind_group(1, &resident.order, &[]);
            let (solid, all) = (resident.solid_count * 3, resident.triangle_count * 3);
            for (has_holes, part) in [(false, 0..solid), (true, solid..all)] {
                if part.is_empty() {
                    continue;
                }
                pass.set_pipeline(&pipelines.mirrors.get(device, index, has_holes));
                for (place, _) in views.iter().enumerate().filter(|(_, view)| view.order == order) {
                    pass.set_bind_group(2, &group, &[PathRecords::offset(place)]);
                    pass.draw(part.clone(), 0..1);
                }
            }
            last = picture;
        }
        context.check()
    }
}

fn record(view: &MirrorView, number: u32, clip_from_world: Mat4) -> MirrorPath {
    let clip_from_scene = (clip_from_world.as_dmat4() * DMat4::from(view.world_from_scene)).as_mat4();
    MirrorPath {
        clip_from_scene: clip_from_scene.to_cols_array_2d(),
        plane: view.plane.as_vec4().to_array(),
        mirror: view.mirror,
        parent: view.parent,
        number,
        unused: 0,
    }
}
