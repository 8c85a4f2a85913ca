//! Environment maps in a device's memory.

use crate::device::context::Context;
use crate::device::pipelines::group;
use crate::device::scene::Upload;
use crate::error::GpuError;
use crate::tables::{MapTables, map_tables};
use catoptric::methods::lookup::environment_map::ReflectorCubeMap;
use wgpu::{BindGroup, BindingResource, TextureView};

/// The maps of a scene's reflectors on a device.
#[derive(Debug)]
pub(crate) struct DeviceMaps {
    pub(crate) group: BindGroup,
    /// Memory that they take on the device.
    pub(crate) byte_count: u64,
}

impl DeviceMaps {
    pub(crate) fn new(context: &Context, maps: &[Option<ReflectorCubeMap>]) -> Result<Self, GpuError> {
        let mut upload = Upload { context, byte_count: 0 };
        let resources = map_views(&mut upload, &map_tables(maps)?)?;
        let resources = (0..).zip(resources.iter().map(BindingResource::TextureView));
        let group = group(&context.device, &context.pipelines.maps, resources);
        context.check()?;
        Ok(Self { group, byte_count: upload.byte_count })
    }
}

/// Loads the records of maps, and the texels of their cubes.
pub(super) fn map_views(upload: &mut Upload<'_>, tables: &MapTables) -> Result<[TextureView; 2], GpuError> {
    let records = upload.table("the environment maps' records", &tables.records)?;
    Ok([records, upload.colors("the environment maps", &tables.texels)?])
}
