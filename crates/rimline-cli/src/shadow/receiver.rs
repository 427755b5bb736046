//! A body as it is drawn.

use std::ops::Range;

use rimline::wgpu;

use super::found::{FacingMasks, FacingRun};
use super::posed_model::PosedModel;
use crate::device::Gpu;
use crate::render::normals;
use crate::render::pipeline_factory::PipelineFactory;

/// Front and back of the first, second … body; then from the beginning again.
const CLAYS: [[[f32; 3]; 2]; 4] = [
    [[0.62, 0.60, 0.565], [0.50, 0.33, 0.24]],
    [[0.36, 0.49, 0.56], [0.58, 0.40, 0.29]],
    [[0.60, 0.42, 0.31], [0.33, 0.45, 0.51]],
    [[0.46, 0.54, 0.38], [0.58, 0.40, 0.29]],
];

/// The draws of a body where it is now.
pub(super) struct Receiver(Vec<Run>);

/// Faces that one buffer has the facing masks of.
struct Run {
    corners: Range<u32>,
    /// For each batch of 32 lights.
    groups: Vec<wgpu::BindGroup>,
}

impl Receiver {
    /// The body with this number.
    pub(super) fn new(
        gpu: &Gpu,
        factory: &PipelineFactory<'_>,
        layout: &wgpu::BindGroupLayout,
        body: &PosedModel<'_>,
        number: usize,
        masks: &FacingMasks,
    ) -> Self {
        let clay = CLAYS[number % CLAYS.len()].map(|[r, g, b]| [r, g, b, 0.0]);
        let clay = factory.uniform(&gpu.queue, "clay", bytemuck::cast_slice(&clay));
        let stored = |label, contents: &[u8]| factory.buffer(&gpu.queue, label, contents);
        let faces = stored("drawn faces", bytemuck::cast_slice(&body.faces));
        let normals = normals::corner_normals(&body.world, &body.faces);
        let normals = stored("normals", bytemuck::cast_slice(&normals));
        let slots = stored("slots", bytemuck::cast_slice(&masks.slots));
        let positions = body.positions.buffer();
        let group = |facing: &wgpu::Buffer| {
            let buffers = [&clay, positions.buffer, &faces, &normals, &slots, facing];
            factory.group(layout, &buffers.map(wgpu::Buffer::as_entire_binding))
        };
        let run = |run: &FacingRun| Run {
            corners: 3 * run.faces.start..3 * run.faces.end,
            groups: run.facing.iter().map(group).collect(),
        };
        Self(masks.runs.iter().map(run).collect())
    }

    /// Draws it for one light.
    pub(super) fn draw(&self, pass: &mut wgpu::RenderPass<'_>, light: usize) {
        for Run { corners, groups } in &self.0 {
            if let Some(group) = groups.get(light / 32) {
                pass.set_bind_group(2, group, &[]);
                pass.draw(corners.clone(), 0..1);
            }
        }
    }
}
