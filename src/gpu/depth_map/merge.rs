//! Two depth maps of one light in one.

use bytemuck::Zeroable;

use super::errors::{DepthMapEncodeError, DepthMapTexture, DepthMapVolumesError};
use super::texture::{check_texture, written_texture};
use crate::gpu::common::dispatch_limits::WORKGROUP;
use crate::gpu::common::memory::{any_error, filled, guarded};
use crate::gpu::common::pipelines::{Pipeline, Pipelines};
use crate::gpu::common::requirements::{Subject, check_alive, check_timer};
use crate::gpu::common::timer::StageTimer;
use crate::gpu::common::uniforms::entry;
use crate::layout::DepthMapShape;
use crate::shadow::DepthDirection;
use crate::stages::DEPTH_MERGE;

/// Merges two depth maps of one light by the nearer depth, for example one of what never moves and one of what does. Both maps
/// are made with the same camera. They may have different formats.
///
/// The result is a map of `R32Float`, to be given to [`DepthMapVolumes`](crate::gpu::DepthMapVolumes). Where a map has a coarser
/// format, set [`DepthMapOptions::rounded_to`](crate::gpu::DepthMapOptions::rounded_to) to it, so that the boundary moves by the
/// map's errors. More maps are merged by further merges: the result of one may be a map of another.
#[derive(Debug)]
pub struct DepthMapMerge {
    shared: Pipelines,
    stage: Pipeline,
    shape: DepthMapShape,
    texture: wgpu::Texture,
    view: wgpu::TextureView,
}

impl DepthMapMerge {
    /// Makes a texture of `size` texels for the result.
    ///
    /// # Errors
    /// [`DepthMapVolumesError`] if the device lacks what the stage needs, or the texture does not fit it.
    pub fn new(pipelines: impl Into<Pipelines>, size: [u32; 2]) -> Result<Self, DepthMapVolumesError> {
        let pipelines = pipelines.into();
        pipelines.clone().construct(Subject::DepthMap, || Self::with(pipelines, size))
    }

    fn with(shared: Pipelines, size: [u32; 2]) -> Result<Self, DepthMapVolumesError> {
        let most = shared.device().limits().max_texture_dimension_2d;
        if size.contains(&0) {
            return Err(DepthMapVolumesError::Size(size[0], size[1]));
        }
        if size.into_iter().any(|side| side > most) {
            return Err(DepthMapVolumesError::Texture { size, most });
        }
        let texels = u64::from(size[0]) * u64::from(size[1]);
        let texture = guarded(shared.device(), 4 * texels, || {
            written_texture(shared.device(), "merged depth map", size, wgpu::TextureFormat::R32Float)
        })?;
        // Textures have at most 2²⁸ texels or so; a device with larger ones walks along the blocks all the same.
        let blocks = texels.div_ceil(u64::from(WORKGROUP)) as u32;
        let shape = DepthMapShape { size, blocks, faces: 1, ..DepthMapShape::zeroed() };
        let view = texture.create_view(&wgpu::TextureViewDescriptor::default());
        Ok(Self { stage: shared.compute(&DEPTH_MERGE, "depth_merge", &[]), shape, texture, view, shared })
    }

    /// Records the stage. `depth` is the direction of both maps. A texel of the result has the nearer of the two depths. NaN and
    /// what lies beyond the far end count as far. Draws of volumes read the result, too, so record them before the next merge.
    ///
    /// # Errors
    /// [`DepthMapEncodeError`] if a texture is refused. Nothing is recorded then.
    pub fn encode(
        &self,
        encoder: &mut wgpu::CommandEncoder,
        maps: [&wgpu::TextureView; 2],
        depth: DepthDirection,
        timer: Option<&mut StageTimer>,
    ) -> Result<(), DepthMapEncodeError> {
        let device = self.shared.device();
        check_timer(timer.as_deref(), device)?;
        for (number, map) in maps.into_iter().enumerate() {
            check_texture(map.texture(), self.shape.size, DepthMapTexture::MergedMap(number))?;
            if *map.texture() == self.texture {
                return Err(DepthMapEncodeError::OwnResult);
            }
        }
        check_alive(device)?;
        let is_reversed = u32::from(depth == DepthDirection::Reversed);
        let shape = DepthMapShape { is_reversed, ..self.shape };
        let bind = || {
            let uniform = filled(device, "depth map", bytemuck::bytes_of(&shape), wgpu::BufferUsages::UNIFORM);
            let [first, second] = maps.map(wgpu::BindingResource::TextureView);
            let merged = wgpu::BindingResource::TextureView(&self.view);
            self.stage.bind(
                device,
                &[
                    ("depth_map", entry::<DepthMapShape>(&uniform)),
                    ("depth_texture", first),
                    ("second_texture", second),
                    ("merged_texture", merged),
                ],
            )
        };
        let group = any_error(device, bind).map_err(|message| DepthMapEncodeError::Refused { message })?;
        let most = device.limits().max_compute_workgroups_per_dimension;
        let rows = shape.blocks.div_ceil(most).min(most);
        let timestamp_writes = timer.and_then(|timer| timer.compute_pass(self.stage.label));
        let label = Some(self.stage.label);
        let mut pass = encoder.begin_compute_pass(&wgpu::ComputePassDescriptor { label, timestamp_writes });
        pass.set_pipeline(&self.stage.compute);
        pass.set_bind_group(0, &group, &[0]);
        pass.dispatch_workgroups(shape.blocks.div_ceil(rows).min(most), rows, 1);
        Ok(())
    }

    /// The merged map: a view of `R32Float`.
    pub fn texture(&self) -> &wgpu::TextureView {
        &self.view
    }
}
