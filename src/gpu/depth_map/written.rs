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
use crate::stages::{DEPTH_MERGE, DEPTH_METRIC};

/// A depth map that a stage writes: of two maps, or of distances. It has the format `R32Float`, and is given to
/// [`DepthMapVolumes`](crate::gpu::depth_map::DepthMapVolumes), as a map of a cube, or to [`Self::merge`] of another one.
/// Draws of volumes read it, too, so record them before it is written again.
///
/// ```no_run
/// use rimline::gpu::depth_map::{DepthMap, DepthMapOptions, DepthMapPipelines, DepthMapTexture, DepthMapVolumes, DepthMetric};
/// use rimline::{ShadowCamera, wgpu};
///
/// # fn shadows(
/// #     (pipelines, encoder): (&DepthMapPipelines, &mut wgpu::CommandEncoder),
/// #     (device, distances): (&wgpu::Device, &wgpu::TextureView),
/// #     (light, camera): (ShadowCamera, &ShadowCamera),
/// # ) -> Result<(), Box<dyn std::error::Error>> {
/// // Once:
/// let metric = DepthMetric::AlongRay;
/// let map = DepthMapTexture::new(device, [512, 512])?;
/// let options = DepthMapOptions { metric, ..Default::default() };
/// let mut volumes = DepthMapVolumes::new(pipelines, [512, 512], options)?;
/// // Every frame, after what writes `distances`:
/// map.convert(encoder, &DepthMap::new(distances, light), metric)?;
/// let shadows = volumes.encode(encoder, &DepthMap::new(map.view(), light), camera)?;
/// # Ok(())
/// # }
/// ```
#[derive(Debug)]
pub struct DepthMapTexture {
    shared: Pipelines,
    merge: Pipeline,
    convert: Pipeline,
    shape: DepthMapShape,
    view: wgpu::TextureView,
}

impl DepthMapTexture {
    /// Makes a texture of `size` texels, and the pipelines of both stages.
    ///
    /// # Errors
    /// [`DepthMapError`] if the device lacks what the stages need, or the texture does not fit it.
    pub fn new(pipelines: impl Into<Pipelines>, size: [u32; 2]) -> Result<Self, DepthMapError> {
        let shared = pipelines.into();
        shared.clone().construct(Subject::DepthMap, || {
            let max_side = shared.device().limits().max_texture_dimension_2d;
            if size.contains(&0) {
                return Err(DepthMapError::Size(size[0], size[1]));
            }
            if size.into_iter().any(|side| side > max_side) {
                return Err(DepthMapError::Texture { size, max_side });
            }
            let texels = u64::from(size[0]) * u64::from(size[1]);
            let view = written_texture(shared.device(), "written depth map", size, wgpu::TextureFormat::R32Float)?;
            // Fits: textures have at most about 2²⁸ texels.
            let blocks = texels.div_ceil(u64::from(WORKGROUP)) as u32;
            let shape = DepthMapShape { size, blocks, faces: 1, ..DepthMapShape::zeroed() };
            let [merge, convert] = [&DEPTH_MERGE, &DEPTH_METRIC].map(|stage| shared.compute(stage, stage.name, &[]));
            Ok(Self { shared, merge, convert, shape, view })
        })
    }

    /// Records a merge of two depth maps of one light by the nearer depth, for example one of static casters and one of
    /// moving ones. Both maps are made with the same camera, whose depth direction is `depth`. They may have different
    /// formats. NaN and depths beyond the far end count as far.
    ///
    /// Where a map has a coarser format, set
    /// [`DepthMapOptions::rounded_to`](crate::gpu::depth_map::DepthMapOptions::rounded_to) to it, so that the boundary moves
    /// by the map's errors.
    ///
    /// # Errors
    /// [`DepthMapError`] if a texture is refused. Nothing is recorded then.
    pub fn merge(
        &self,
        encoder: &mut wgpu::CommandEncoder,
        maps: [&wgpu::TextureView; 2],
        depth: DepthDirection,
    ) -> Result<(), DepthMapError> {
        for (index, map) in maps.into_iter().enumerate() {
            self.check(map, &format!("map {index} of the merge"))?;
        }
        let [first, second] = maps;
        let textures = [("depth_texture", first), ("second_texture", second), ("merged_texture", &self.view)];
        self.record(encoder, &self.merge, depth, &textures, None, None)
    }

    /// Records a conversion of distances, as ray-marched distance fields and range images have them, to the device depths
    /// of the map's camera. `map` has distances of `metric` in a texture of `R32Float`, and the camera that they were
    /// measured for; its objects are ignored. With [`DepthMetric::Device`] it may have any format of a map, and the result
    /// has its depths, clamped.
    ///
    /// Set [`DepthMapOptions::metric`](crate::gpu::depth_map::DepthMapOptions::metric) to the same metric, so that the
    /// boundary moves by the error of the conversion.
    ///
    /// # Errors
    /// [`DepthMapError`] if the texture or the camera is refused. Nothing is recorded then.
    pub fn convert(
        &self,
        encoder: &mut wgpu::CommandEncoder,
        map: &DepthMap<'_>,
        metric: DepthMetric,
    ) -> Result<(), DepthMapError> {
        self.convert_timed(encoder, map, metric, None)
    }

    /// The same with a timestamp around each stage.
    ///
    /// # Errors
    /// The errors of [`Self::convert`], and [`DepthMapError::Device`] for a timer of another device.
    pub fn convert_timed(
        &self,
        encoder: &mut wgpu::CommandEncoder,
        map: &DepthMap<'_>,
        metric: DepthMetric,
        timer: Option<&mut StageTimer>,
    ) -> Result<(), DepthMapError> {
        let format = self.check(map.texture, "the map")?;
        if metric != DepthMetric::Device && format != wgpu::TextureFormat::R32Float {
            let accepted = "R32Float for distances, or `DepthMetric::Device` for device depths";
            return Err(DepthMapError::MapFormat { map: "the map".to_owned(), format, accepted });
        }
        let view = metric_view(&map.light, self.shape.size, metric)?;
        let textures = [("depth_texture", map.texture), ("converted_texture", &self.view)];
        self.record(encoder, &self.convert, map.light.depth, &textures, Some(&view), timer)
    }

    /// The map: a view of `R32Float`.
    pub fn view(&self) -> &wgpu::TextureView {
        &self.view
    }

    /// Refuses a map that cannot be read. Returns its format.
    fn check(&self, map: &wgpu::TextureView, name: &str) -> Result<wgpu::TextureFormat, DepthMapError> {
        let format = check_texture(map.texture(), self.shape.size, name)?;
        if map.texture() == self.view.texture() { Err(DepthMapError::MapIsResult) } else { Ok(format) }
    }

    /// Records a stage. `textures`: those that it reads, and the map that it writes, by name. `metric`: that of the map,
    /// if the stage converts it.
    fn record(
        &self,
        encoder: &mut wgpu::CommandEncoder,
        stage: &Pipeline,
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
            stage.dispatch(device, Workgroups::over(device, shape.blocks), |name| match name {
                "depth_map" => Some(uniform::<DepthMapShape>(&shape_buffer, 0)),
                "metric_view" => metric_buffer.as_ref().map(whole),
                _ => textures.iter().find(|(of, _)| *of == name).map(|(_, view)| texture(view)),
            })
        };
        let dispatch = guard(device, bind)?;
        record([&stage.pass([dispatch])], encoder, timer);
        Ok(())
    }
}
