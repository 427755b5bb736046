//! Stages that are bound to be recorded, and stages that edges of objects are a part of.

use std::sync::OnceLock;

use crate::gpu::common::pipelines::{Pipeline, Pipelines};
use crate::gpu::common::timer::StageTimer;
use crate::stages::Stage;

/// A stage that is bound. Its groups are dispatched one after another, in one pass.
pub(super) struct BoundStage {
    pub(super) stage: Pipeline,
    pub(super) groups: Vec<wgpu::BindGroup>,
    pub(super) workgroups: Workgroups,
}

/// Workgroups of a stage.
pub(super) enum Workgroups {
    /// Across and down.
    Known([u32; 2]),
    /// A stage before writes them, at this byte.
    Written(wgpu::Buffer, u64),
}

impl Workgroups {
    /// So many, in as few rows as the device allows.
    pub(super) fn over(device: &wgpu::Device, count: u32) -> Self {
        let most = device.limits().max_compute_workgroups_per_dimension;
        let rows = count.div_ceil(most).min(most);
        Self::Known([count.div_ceil(rows.max(1)).min(most), rows])
    }
}

impl BoundStage {
    pub(super) fn record(&self, encoder: &mut wgpu::CommandEncoder, timer: Option<&mut StageTimer>) {
        let timestamp_writes = timer.and_then(|timer| timer.compute_pass(self.stage.label));
        let label = Some(self.stage.label);
        let mut pass = encoder.begin_compute_pass(&wgpu::ComputePassDescriptor { label, timestamp_writes });
        pass.set_pipeline(&self.stage.compute);
        // Each uniform begins at its buffer's start.
        let offsets = vec![0; self.stage.uniforms()];
        for group in &self.groups {
            pass.set_bind_group(0, group, &offsets);
            match &self.workgroups {
                Workgroups::Known([x, y]) => pass.dispatch_workgroups(*x, *y, 1),
                Workgroups::Written(buffer, at) => pass.dispatch_workgroups_indirect(buffer, *at),
            }
        }
    }
}

/// A stage with and without edges of objects. A pipeline without them is smaller, and the other is made with the first objects.
#[derive(Debug)]
pub(super) struct ObjectStage {
    stage: &'static Stage,
    entry_point: &'static str,
    constants: Vec<(&'static str, f64)>,
    made: [OnceLock<Pipeline>; 2],
}

impl ObjectStage {
    pub(super) fn new(
        shared: &Pipelines,
        stage: &'static Stage,
        entry_point: &'static str,
        constants: &[(&'static str, u32)],
    ) -> Self {
        let constants = constants.iter().map(|&(name, value)| (name, f64::from(value))).collect();
        let own = Self { stage, entry_point, constants, made: [const { OnceLock::new() }; 2] };
        own.get(shared, false);
        own
    }

    pub(super) fn get(&self, shared: &Pipelines, objects: bool) -> Pipeline {
        let make = || {
            let constants = [&self.constants[..], &[("OBJECTS", f64::from(u8::from(objects)))]].concat();
            shared.compute(self.stage, self.entry_point, &constants)
        };
        self.made[usize::from(objects)].get_or_init(make).clone()
    }
}
