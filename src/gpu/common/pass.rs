//! A compute pass: one pipeline and its dispatches.

use std::ops::Range;

use super::dispatch_limits::WORKGROUP;
use super::pipelines::Pipeline;
use super::timer::StageTimer;

/// The pipeline of a stage and its dispatches.
#[derive(Debug)]
pub(crate) struct Pass {
    pub(crate) pipeline: Pipeline,
    pub(crate) dispatches: Vec<Dispatch>,
}

/// One dispatch over a chunk of items for one batch of lights.
#[derive(Clone, Debug)]
pub(crate) struct Dispatch {
    /// The batch of 32 lights.
    pub(crate) batch: usize,
    /// The range of faces or edges.
    pub(crate) items: Range<usize>,
    /// The offset of its `Chunk` in the table of chunks.
    pub(crate) chunk_offset: u32,
    /// The bind group. It is made once all its buffers are known.
    pub(crate) group: Option<wgpu::BindGroup>,
    /// The dynamic offsets of the group's uniforms.
    pub(crate) offsets: Vec<u32>,
    pub(crate) workgroups: u32,
    /// Workgroups along y.
    pub(crate) rows: u32,
    /// If the GPU decides how many workgroups there are: where it wrote that, and at which byte.
    pub(crate) indirect: Option<(wgpu::Buffer, u64)>,
}

impl Dispatch {
    /// A dispatch with one invocation for each item, not bound yet.
    pub(crate) fn over(batch: usize, items: Range<usize>, chunk_offset: u32) -> Self {
        let workgroups = (items.len() as u32).div_ceil(WORKGROUP);
        Self { batch, items, chunk_offset, group: None, offsets: Vec::new(), workgroups, rows: 1, indirect: None }
    }

    fn record(&self, pass: &mut wgpu::ComputePass<'_>) {
        pass.set_bind_group(0, self.group.as_ref(), &self.offsets);
        match &self.indirect {
            Some((arguments, at)) => pass.dispatch_workgroups_indirect(arguments, *at),
            None => pass.dispatch_workgroups(self.workgroups, self.rows, 1),
        }
    }

    /// The bytes of this chunk in an array of `bytes_per_item`.
    pub(crate) fn bytes(&self, bytes_per_item: u64) -> Range<u64> {
        self.items.start as u64 * bytes_per_item..self.items.end as u64 * bytes_per_item
    }
}

impl Pass {
    /// Records the dispatches of the batches `words`.
    pub(crate) fn record(
        &self,
        encoder: &mut wgpu::CommandEncoder,
        batches: Range<usize>,
        timer: Option<&mut StageTimer>,
    ) {
        self.record_with(encoder, |dispatch| batches.contains(&dispatch.batch), timer, None);
    }

    /// Records one dispatch.
    pub(crate) fn record_one(&self, encoder: &mut wgpu::CommandEncoder, index: usize, timer: Option<&mut StageTimer>) {
        let mut pass = self.begin(encoder, timer);
        if let Some(dispatch) = self.dispatches.get(index) {
            dispatch.record(&mut pass);
        }
    }

    /// Records all dispatches that `choose` selects, with a second bind group at the given index.
    pub(crate) fn record_with(
        &self,
        encoder: &mut wgpu::CommandEncoder,
        choose: impl Fn(&Dispatch) -> bool,
        timer: Option<&mut StageTimer>,
        further: Option<(u32, &wgpu::BindGroup)>,
    ) {
        let mut pass = self.begin(encoder, timer);
        if let Some((index, group)) = further {
            pass.set_bind_group(index, group, &[]);
        }
        for dispatch in self.dispatches.iter().filter(|dispatch| choose(dispatch)) {
            dispatch.record(&mut pass);
        }
    }

    /// Records the dispatches of the batches `words` of several passes. Without a timer they share one compute pass, which
    /// costs less.
    pub(crate) fn record_all<'p>(
        passes: impl IntoIterator<Item = &'p Self>,
        encoder: &mut wgpu::CommandEncoder,
        batches: Range<usize>,
        timer: Option<&mut StageTimer>,
    ) {
        let mut passes = passes.into_iter().peekable();
        if let Some(timer) = timer {
            for pass in passes {
                pass.record(encoder, batches.clone(), Some(&mut *timer));
            }
            return;
        }
        let label = passes.peek().map(|pass| pass.pipeline.label);
        let mut shared = encoder.begin_compute_pass(&wgpu::ComputePassDescriptor { label, timestamp_writes: None });
        for pass in passes {
            shared.set_pipeline(&pass.pipeline.compute);
            let recorded = pass.dispatches.iter().filter(|dispatch| batches.contains(&dispatch.batch));
            recorded.for_each(|dispatch| dispatch.record(&mut shared));
        }
    }

    /// Begins the compute pass of the stage.
    fn begin<'encoder>(
        &self,
        encoder: &'encoder mut wgpu::CommandEncoder,
        timer: Option<&mut StageTimer>,
    ) -> wgpu::ComputePass<'encoder> {
        let label = self.pipeline.label;
        let timestamp_writes = timer.and_then(|timer| timer.compute_pass(label));
        let mut pass =
            encoder.begin_compute_pass(&wgpu::ComputePassDescriptor { label: Some(label), timestamp_writes });
        pass.set_pipeline(&self.pipeline.compute);
        pass
    }
}
