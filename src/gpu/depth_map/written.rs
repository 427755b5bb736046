//! A map that a stage writes: a texture of `R32Float`, and the dispatch.

use bytemuck::Zeroable;

use super::error::{DepthMapError, guard};
use crate::gpu::common::bindings::{texture, uniform, whole};
use crate::gpu::common::dispatch_limits::WORKGROUP;
use crate::gpu::common::memory::filled;
use crate::gpu::common::pass::{Workgroups, record};
use crate::gpu::common::pipelines::{Pipeline, Pipelines};
use crate::gpu::common::requirements::{check_alive, check_timer};
use crate::gpu::common::timer::StageTimer;
use crate::layout::DepthMapShape;
use crate::shadow::DepthDirection;
use crate::stages::Stage;

use super::texture::{check_texture, written_texture};

/// A stage with the map that it writes.
#[derive(Debug)]
pub(super) struct WrittenMap {
    shared: Pipelines,
    stage: Pipeline,
    shape: DepthMapShape,
    view: wgpu::TextureView,
}

impl WrittenMap {
    /// A texture of `size` texels, and the pipeline of a stage.
    pub(super) fn new(
        shared: Pipelines,
        stage: &'static Stage,
        label: &'static str,
        size: [u32; 2],
    ) -> Result<Self, DepthMapError> {
        let max_side = shared.device().limits().max_texture_dimension_2d;
        if size.contains(&0) {
            return Err(DepthMapError::Size(size[0], size[1]));
        }
        if size.into_iter().any(|side| side > max_side) {
            return Err(DepthMapError::Texture { size, max_side });
        }
        let texels = u64::from(size[0]) * u64::from(size[1]);
        let view = written_texture(shared.device(), label, size, wgpu::TextureFormat::R32Float)?;
        // Fits: textures have at most about 2²⁸ texels.
        let blocks = texels.div_ceil(u64::from(WORKGROUP)) as u32;
        let shape = DepthMapShape { size, blocks, faces: 1, ..DepthMapShape::zeroed() };
        Ok(Self { stage: shared.compute(stage, stage.name, &[]), shape, view, shared })
    }

    pub(super) fn view(&self) -> &wgpu::TextureView {
        &self.view
    }

    pub(super) fn size(&self) -> [u32; 2] {
        self.shape.size
    }

    /// Refuses a map that cannot be read. Returns its format.
    pub(super) fn check(&self, map: &wgpu::TextureView, name: &str) -> Result<wgpu::TextureFormat, DepthMapError> {
        let format = check_texture(map.texture(), self.shape.size, name)?;
        if map.texture() == self.view.texture() { Err(DepthMapError::OwnResult) } else { Ok(format) }
    }

    /// Records the stage. `maps`: the textures that it reads, by name. `written`: the name of the map. `uniform`: name and
    /// bytes of another uniform.
    pub(super) fn record(
        &self,
        encoder: &mut wgpu::CommandEncoder,
        depth: DepthDirection,
        (maps, written): (&[(&str, &wgpu::TextureView)], &str),
        other_uniform: Option<(&str, &[u8])>,
        timer: Option<&mut StageTimer>,
    ) -> Result<(), DepthMapError> {
        let device = self.shared.device();
        check_timer(timer.as_deref(), device)?;
        check_alive(device)?;
        let is_reversed = u32::from(depth == DepthDirection::Reversed);
        let shape = DepthMapShape { is_reversed, ..self.shape };
        let bind = || {
            let buffer = |bytes: &[u8]| filled(device, "depth map", bytes, wgpu::BufferUsages::UNIFORM);
            let shape_buffer = buffer(bytemuck::bytes_of(&shape));
            let other = other_uniform.map(|(name, bytes)| (name, buffer(bytes)));
            self.stage.dispatch(device, Workgroups::over(device, shape.blocks), |name| {
                let map = maps.iter().find(|(of, _)| *of == name);
                let other = other.as_ref().filter(|(of, _)| *of == name);
                match name {
                    "depth_map" => Some(uniform::<DepthMapShape>(&shape_buffer, 0)),
                    _ if name == written => Some(texture(&self.view)),
                    _ => map.map(|(_, map)| texture(map)).or_else(|| other.map(|(_, buffer)| whole(buffer))),
                }
            })
        };
        let dispatch = guard(device, bind)?;
        record([&self.stage.pass([dispatch])], encoder, 0..1, timer);
        Ok(())
    }
}
