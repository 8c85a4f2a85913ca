//! Times of the stages of a frame, by the device's own clock.

use crate::device::context::Context;
use crate::device::readback::{Label, Readback};
use crate::error::GpuError;
use wgpu::{BufferUsages, ComputePassTimestampWrites, QuerySet, RenderPassTimestampWrites};

/// The most passes whose times are taken; those after them are left out.
const MAX_PASSES: u32 = 2048;

/// Takes the times of passes, where the device can.
#[derive(Debug)]
pub(crate) struct Timer {
    queries: Option<QuerySet>,
    /// The stage of each pass.
    stages: Vec<&'static str>,
}

impl Timer {
    /// A timer that takes no times.
    pub(crate) fn none() -> Self {
        Self { queries: None, stages: Vec::new() }
    }

    pub(crate) fn new(context: &Context) -> Self {
        let descriptor =
            wgpu::QuerySetDescriptor { label: Some("times"), ty: wgpu::QueryType::Timestamp, count: MAX_PASSES * 2 };
        let queries = context.has_clock().then(|| context.device.create_query_set(&descriptor));
        Self { queries, stages: Vec::new() }
    }

    /// The first query of the next pass, which belongs to a stage.
    fn next(&mut self, stage: &'static str) -> Option<(&QuerySet, u32)> {
        let queries = self.queries.as_ref().filter(|_| self.stages.len() < MAX_PASSES as usize)?;
        self.stages.push(stage);
        Some((queries, 2 * (self.stages.len() as u32 - 1)))
    }

    /// For the next pass, of a stage.
    pub(crate) fn compute(&mut self, stage: &'static str) -> Option<ComputePassTimestampWrites<'_>> {
        let (query_set, first) = self.next(stage)?;
        let (beginning_of_pass_write_index, end_of_pass_write_index) = (Some(first), Some(first + 1));
        Some(ComputePassTimestampWrites { query_set, beginning_of_pass_write_index, end_of_pass_write_index })
    }

    /// The same for passes that render.
    pub(crate) fn render(&mut self, stage: &'static str) -> Option<RenderPassTimestampWrites<'_>> {
        let (query_set, first) = self.next(stage)?;
        let (beginning_of_pass_write_index, end_of_pass_write_index) = (Some(first), Some(first + 1));
        Some(RenderPassTimestampWrites { query_set, beginning_of_pass_write_index, end_of_pass_write_index })
    }

    /// Copies the times, to be read once the work is done.
    pub(crate) fn copy(&self, context: &Context, encoder: &mut wgpu::CommandEncoder, readback: &mut Readback) {
        let count = 2 * self.stages.len() as u32;
        let (Some(queries), true) = (&self.queries, count > 0) else { return };
        let resolved = context.device.create_buffer(&wgpu::BufferDescriptor {
            label: Some("times"),
            size: u64::from(count) * 8,
            usage: BufferUsages::QUERY_RESOLVE | BufferUsages::COPY_SRC,
            mapped_at_creation: false,
        });
        encoder.resolve_query_set(queries, 0..count, &resolved, 0);
        readback.buffer(&context.device, encoder, Label::Times, (&resolved, 0, u64::from(count) * 8));
    }

    /// The times of all stages in milliseconds, in the order of their first passes, from what was copied.
    pub(crate) fn stages_ms(
        &self,
        context: &Context,
        readback: &Readback,
    ) -> Result<Vec<(&'static str, f64)>, GpuError> {
        let ticks: Vec<u64> = readback.records(Label::Times)?;
        let Some(mut last) = ticks.first().copied() else { return Ok(Vec::new()) };
        let period_ms = f64::from(context.queue.get_timestamp_period()) * 1e-6;
        let mut times: Vec<(&'static str, f64)> = Vec::new();
        // From end to end: some drivers begin to count once the work is done.
        for (stage, pass) in self.stages.iter().zip(ticks.chunks_exact(2)) {
            let time = pass[1].saturating_sub(last) as f64 * period_ms;
            last = pass[1];
            match times.iter_mut().find(|(known, _)| known == stage) {
                Some((_, sum)) => *sum += time,
                None => times.push((stage, time)),
            }
        }
        Ok(times)
    }
}
