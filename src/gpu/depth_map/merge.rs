//! Merges two depth maps of one light.

use super::error::DepthMapError;
use super::written::WrittenMap;
use crate::gpu::common::pipelines::Pipelines;
use crate::gpu::common::requirements::Subject;
use crate::gpu::common::timer::StageTimer;
use crate::shadow::DepthDirection;
use crate::stages::DEPTH_MERGE;

/// Merges two depth maps of one light by the nearer depth, for example one of static casters and one of moving ones. Both
/// maps are made with the same camera. They may have different formats.
///
/// The result is a map of `R32Float`, to be given to [`DepthMapVolumes`](crate::gpu::depth_map::DepthMapVolumes). Where a
/// map has a coarser format, set [`DepthMapOptions::rounded_to`](crate::gpu::depth_map::DepthMapOptions::rounded_to) to it,
/// so that the boundary moves by the map's errors. More maps are merged by further merges: the result of one may be a map of
/// another.
#[derive(Debug)]
pub struct DepthMapMerge {
    merged: WrittenMap,
}

impl DepthMapMerge {
    /// Makes a texture of `size` texels for the result.
    ///
    /// # Errors
    /// [`DepthMapError`] if the device lacks what the stage needs, or the texture does not fit it.
    pub fn new(pipelines: impl Into<Pipelines>, size: [u32; 2]) -> Result<Self, DepthMapError> {
        let pipelines = pipelines.into();
        pipelines.clone().construct(Subject::DepthMap, || {
            Ok(Self { merged: WrittenMap::new(pipelines, &DEPTH_MERGE, "merged depth map", size)? })
        })
    }

    /// Records the stage. `depth` is the direction of both maps. A texel of the result has the nearer of the two depths. NaN
    /// and depths beyond the far end count as far. Draws of volumes read the result, too, so record them before the next
    /// merge.
    ///
    /// # Errors
    /// [`DepthMapError`] if a texture is refused. Nothing is recorded then.
    pub fn encode(
        &self,
        encoder: &mut wgpu::CommandEncoder,
        maps: [&wgpu::TextureView; 2],
        depth: DepthDirection,
    ) -> Result<(), DepthMapError> {
        self.encode_timed(encoder, maps, depth, None)
    }

    /// The same with a timestamp around each stage.
    ///
    /// # Errors
    /// The errors of [`Self::encode`], and [`DepthMapError::Device`] for a timer of another device.
    pub fn encode_timed(
        &self,
        encoder: &mut wgpu::CommandEncoder,
        maps: [&wgpu::TextureView; 2],
        depth: DepthDirection,
        timer: Option<&mut StageTimer>,
    ) -> Result<(), DepthMapError> {
        for (index, map) in maps.into_iter().enumerate() {
            self.merged.check(map, &format!("map {index} of the merge"))?;
        }
        let [first, second] = maps;
        let maps = [("depth_texture", first), ("second_texture", second)];
        self.merged.record(encoder, depth, (&maps, "merged_texture"), None, timer)
    }

    /// The merged map: a view of `R32Float`.
    pub fn texture(&self) -> &wgpu::TextureView {
        self.merged.view()
    }
}
