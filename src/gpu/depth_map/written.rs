//! Maps that stages write: of two maps, and of distances.

use bytemuck::Zeroable;

use super::error::{DepthMapError, guard};
use super::metric::{DepthMetric, metric_view};
use super::options::DepthMap;
use super::texture::{check_texture, written_texture};
use crate::gpu::common::bindings::{texture, uniform, whole};
use crate::gpu::common::dispatch_limits::WORKGROUP;
use crate::gpu::common::memory::filled;
use crate::gpu::common::pass::{Workgroups, record};
use crate::gpu::common::pipelines::{Pipeline, Pipelines};
use crate::gpu::common::requirements::{Subject, check_alive, check_timer};
use crate::gpu::common::timer::StageTimer;
use crate::layout::{DepthMapShape, DepthMetricView};
use crate::shadow::DepthDirection;
use crate::stages::{DEPTH_MERGE, DEPTH_METRIC, Stage};

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
        let textures = [("depth_texture", first), ("second_texture", second), ("merged_texture", &self.merged.view)];
        self.merged.record(encoder, depth, &textures, None, timer)
    }

    /// The merged map: a view of `R32Float`.
    pub fn texture(&self) -> &wgpu::TextureView {
        &self.merged.view
    }
}

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
        let view = metric_view(&map.light, self.converted.shape.size, metric)?;
        let textures = [("depth_texture", map.texture), ("converted_texture", &self.converted.view)];
        self.converted.record(encoder, map.light.depth, &textures, Some(&view), timer)
    }

    /// The converted map: a view of `R32Float`.
    pub fn texture(&self) -> &wgpu::TextureView {
        &self.converted.view
    }
}

/// A stage with the map that it writes.
#[derive(Debug)]
struct WrittenMap {
    shared: Pipelines,
    stage: Pipeline,
    shape: DepthMapShape,
    view: wgpu::TextureView,
}

impl WrittenMap {
    /// A texture of `size` texels, and the pipeline of a stage.
    fn new(
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

    /// Refuses a map that cannot be read. Returns its format.
    fn check(&self, map: &wgpu::TextureView, name: &str) -> Result<wgpu::TextureFormat, DepthMapError> {
        let format = check_texture(map.texture(), self.shape.size, name)?;
        if map.texture() == self.view.texture() { Err(DepthMapError::MapIsResult) } else { Ok(format) }
    }

    /// Records the stage. `textures`: those that it reads, and the map that it writes, by name. `metric`: that of the map,
    /// if the stage converts it.
    fn record(
        &self,
        encoder: &mut wgpu::CommandEncoder,
        depth: DepthDirection,
        textures: &[(&str, &wgpu::TextureView)],
        metric: Option<&DepthMetricView>,
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
            let metric_buffer = metric.map(|metric| buffer(bytemuck::bytes_of(metric)));
            self.stage.dispatch(device, Workgroups::over(device, shape.blocks), |name| match name {
                "depth_map" => Some(uniform::<DepthMapShape>(&shape_buffer, 0)),
                "metric_view" => metric_buffer.as_ref().map(whole),
                _ => textures.iter().find(|(of, _)| *of == name).map(|(_, view)| texture(view)),
            })
        };
        let dispatch = guard(device, bind)?;
        record([&self.stage.pass([dispatch])], encoder, 0..1, timer);
        Ok(())
    }
}
