//! A stage that is bound, to be recorded.

use crate::gpu::common::pipelines::Pipeline;

/// A stage that is bound, and its workgroups.
pub(super) type BoundStage<'a> = (&'a Pipeline, wgpu::BindGroup, Workgroups);

/// Workgroups of a stage.
pub(super) enum Workgroups {
    /// Across and down.
    Known([u32; 2]),
    /// A stage before writes them, at this byte.
    Written(wgpu::Buffer, u64),
}
