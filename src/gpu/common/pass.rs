//! The recorder: clears, copies and compute passes, as all subjects list them.

use std::ops::Range;

use super::timer::StageTimer;

/// The workgroups of a dispatch.
#[derive(Clone, Debug)]
pub(crate) enum Workgroups {
    /// Along x and y.
    Known([u32; 2]),
    /// The GPU decides, and writes them at this byte.
    Written(wgpu::Buffer, u64),
}

impl Workgroups {
    /// At least `count`, with fewer to spare than there are rows, or all that the device allows. In as few rows as it allows.
    pub(crate) fn over(device: &wgpu::Device, count: u32) -> Self {
        let most = device.limits().max_compute_workgroups_per_dimension;
        let rows = count.div_ceil(most).min(most);
        Self::Known([count.div_ceil(rows.max(1)).min(most), rows])
    }
}

/// One dispatch, with everything bound. [`Pipeline::dispatch`](super::pipelines::Pipeline::dispatch) makes it.
#[derive(Clone, Debug)]
pub(crate) struct Dispatch {
    pub(crate) pipeline: wgpu::ComputePipeline,
    pub(crate) group: wgpu::BindGroup,
    /// The dynamic offsets of the group's uniforms.
    pub(crate) offsets: Vec<u32>,
    pub(crate) workgroups: Workgroups,
}

/// A step of a recording.
#[derive(Clone, Debug)]
pub(crate) enum Step {
    /// Dispatches that are timed together, by this name. They may be of several pipelines.
    Pass(&'static str, Vec<Dispatch>),
    /// Sets a part of a buffer to zeros.
    Clear(wgpu::Buffer, Range<u64>),
    /// Copies bytes from an offset in a buffer to an offset in another.
    Copy([(wgpu::Buffer, u64); 2], u64),
}

impl Step {
    /// Clears a whole buffer.
    pub(crate) fn clear(buffer: &wgpu::Buffer) -> Self {
        Self::Clear(buffer.clone(), 0..buffer.size())
    }
}

/// Records all steps. With a timer, each pass has a separate compute pass. If not, passes that follow each other share one,
/// which costs less.
pub(crate) fn record<'s>(
    steps: impl IntoIterator<Item = &'s Step>,
    encoder: &mut wgpu::CommandEncoder,
    timer: Option<&mut StageTimer>,
) {
    record_with(steps, encoder, timer, None);
}

/// The same with a second bind group at an index.
pub(crate) fn record_with<'s>(
    steps: impl IntoIterator<Item = &'s Step>,
    encoder: &mut wgpu::CommandEncoder,
    mut timer: Option<&mut StageTimer>,
    further: Option<(u32, &wgpu::BindGroup)>,
) {
    let mut shared: Option<wgpu::ComputePass<'static>> = None;
    for step in steps {
        match step {
            Step::Pass(label, dispatches) => {
                let mut pass = shared.take().unwrap_or_else(|| {
                    let timestamp_writes = timer.as_deref_mut().and_then(|timer| timer.compute_pass(label));
                    let descriptor = wgpu::ComputePassDescriptor { label: Some(label), timestamp_writes };
                    encoder.begin_compute_pass(&descriptor).forget_lifetime()
                });
                if let Some((index, group)) = further {
                    pass.set_bind_group(index, group, &[]);
                }
                dispatch(&mut pass, dispatches);
                shared = Some(pass).filter(|_| timer.is_none());
            }
            Step::Clear(buffer, range) => {
                shared = None;
                encoder.clear_buffer(buffer, range.start, Some(range.end - range.start));
            }
            Step::Copy([(from, from_byte), (to, to_byte)], bytes) => {
                shared = None;
                encoder.copy_buffer_to_buffer(from, *from_byte, to, *to_byte, *bytes);
            }
        }
    }
}

fn dispatch(pass: &mut wgpu::ComputePass<'_>, dispatches: &[Dispatch]) {
    let mut set = None;
    for Dispatch { pipeline, group, offsets, workgroups } in dispatches {
        if set != Some(pipeline) {
            pass.set_pipeline(pipeline);
            set = Some(pipeline);
        }
        pass.set_bind_group(0, group, offsets);
        match workgroups {
            Workgroups::Known([x, y]) => pass.dispatch_workgroups(*x, *y, 1),
            Workgroups::Written(buffer, at) => pass.dispatch_workgroups_indirect(buffer, *at),
        }
    }
}
