//! A depth map from a map of distances.

use super::error::DepthMapError;
use super::metric::{DepthMetric, metric_view};
use super::options::DepthMap;
use super::written::WrittenMap;
use crate::gpu::common::pipelines::Pipelines;
use crate::gpu::common::requirements::Subject;
use crate::gpu::common::timer::StageTimer;
use crate::stages::DEPTH_METRIC;

/// Makes a depth map from a map of distances, as ray-marched distance fields and range images have them.
///
/// The result is a map of `R32Float` with the device depths of the map's camera, to be given to
/// [`DepthMapVolumes`](crate::gpu::depth_map::DepthMapVolumes) with the same camera, to
/// [`DepthMapMerge`](crate::gpu::depth_map::DepthMapMerge), or as a map of a cube. Set
/// [`DepthMapOptions::metric`](crate::gpu::depth_map::DepthMapOptions::metric) to the same metric, so that the boundary
/// moves by the error of the conversion.
///
/// ```no_run
/// use rimline::gpu::depth_map::{DepthMap, DepthMapConversion, DepthMapOptions, DepthMapPipelines, DepthMapVolumes, DepthMetric};
/// use rimline::{ShadowCamera, wgpu};
///
/// # fn shadows(
/// #     (pipelines, encoder): (&DepthMapPipelines, &mut wgpu::CommandEncoder),
/// #     (device, distances): (&wgpu::Device, &wgpu::TextureView),
/// #     (light, camera): (ShadowCamera, &ShadowCamera),
/// # ) -> Result<(), Box<dyn std::error::Error>> {
/// // Once:
/// let metric = DepthMetric::AlongRay;
/// let conversion = DepthMapConversion::new(device, [512, 512])?;
/// let options = DepthMapOptions { metric, ..Default::default() };
/// let mut volumes = DepthMapVolumes::new(pipelines, [512, 512], options)?;
/// // Every frame, after what writes `distances`:
/// conversion.encode(encoder, &DepthMap::new(distances, light), metric)?;
/// let shadows = volumes.encode(encoder, &DepthMap::new(conversion.texture(), light), camera)?;
/// # Ok(())
/// # }
/// ```
#[derive(Debug)]
pub struct DepthMapConversion {
    converted: WrittenMap,
}

impl DepthMapConversion {
    /// Makes a texture of `size` texels for the result.
    ///
    /// # Errors
    /// [`DepthMapError`] if the device lacks what the stage needs, or the texture does not fit it.
    pub fn new(pipelines: impl Into<Pipelines>, size: [u32; 2]) -> Result<Self, DepthMapError> {
        let pipelines = pipelines.into();
        pipelines.clone().construct(Subject::DepthMap, || {
            Ok(Self { converted: WrittenMap::new(pipelines, &DEPTH_METRIC, "converted depth map", size)? })
        })
    }

    /// Records the stage. `map` has distances of `metric` in a texture of `R32Float`, and the camera that they were measured
    /// for; its objects are ignored. With [`DepthMetric::Device`] it may have any format of a map, and the result has its
    /// depths, clamped. Draws of volumes read the result, too, so record them before the next conversion.
    ///
    /// # Errors
    /// [`DepthMapError`] if the texture or the camera is refused. Nothing is recorded then.
    pub fn encode(
        &self,
        encoder: &mut wgpu::CommandEncoder,
        map: &DepthMap<'_>,
        metric: DepthMetric,
    ) -> Result<(), DepthMapError> {
        self.encode_timed(encoder, map, metric, None)
    }

    /// The same with a timestamp around each stage.
    ///
    /// # Errors
    /// The errors of [`Self::encode`], and [`DepthMapError::Device`] for a timer of another device.
    pub fn encode_timed(
        &self,
        encoder: &mut wgpu::CommandEncoder,
        map: &DepthMap<'_>,
        metric: DepthMetric,
        timer: Option<&mut StageTimer>,
    ) -> Result<(), DepthMapError> {
        let format = self.converted.check(map.texture, "the map")?;
        if metric != DepthMetric::Device && format != wgpu::TextureFormat::R32Float {
            let accepted = "R32Float for distances, or `DepthMetric::Device` for device depths";
            return Err(DepthMapError::MapFormat { map: "the map".to_owned(), format, accepted });
        }
        let view = metric_view(&map.light, self.converted.size(), metric)?;
        let maps = [("depth_texture", map.texture)];
        let uniform = Some(("metric_view", bytemuck::bytes_of(&view)));
        self.converted.record(encoder, map.light.depth, (&maps, "converted_texture"), uniform, timer)
    }

    /// The converted map: a view of `R32Float`.
    pub fn texture(&self) -> &wgpu::TextureView {
        self.converted.view()
    }
}
