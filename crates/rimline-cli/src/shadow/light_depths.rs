//! The depth maps of one light, and the shadows rebuilt from them.

use rimline::gpu::StageTimer;
use rimline::gpu::depth_map::{
    DepthCubeMaps, DepthMap, DepthMapConversion, DepthMapCube, DepthMapError, DepthMapFrame, DepthMapPipelines,
    DepthMapVolumes, DepthMetric,
};
use rimline::{DepthDirection, Origin, ShadowCamera, wgpu};
use wgpu::TextureUsages;

use super::from_depth::{DepthFound, FromDepth, MAP, MapSource};
use super::light_maps::LightCameras;
use super::shown_maps::{ShownDepths, ShownMaps};
use crate::device::Gpu;
use crate::gpu_error::GpuError;
use crate::image::Picture;
use crate::npz::{DepthMapArrays, Depths};
use crate::render::pipeline_factory::{plain_texture, view};

pub(super) struct LightMaps {
    maps: Maps,
    /// For each of the maps.
    pub(super) views: Vec<wgpu::TextureView>,
    /// Distances that maps are converted from, and what converts them: one for each map, or none if the maps are depths.
    distances: Vec<(wgpu::TextureView, DepthMapConversion, DepthMetric)>,
    objects: Option<wgpu::TextureView>,
    /// Cameras with which the maps were encoded.
    cameras: LightCameras,
    pub(super) frame: Option<DepthMapFrame>,
    shown: ShownMaps,
}

enum Maps {
    One(Box<DepthMapVolumes>),
    Cube(Box<DepthMapCube>),
}

impl LightMaps {
    pub(super) fn new(
        gpu: &Gpu,
        pipelines: &DepthMapPipelines,
        from: &FromDepth,
        cameras: &LightCameras,
    ) -> Result<Self, GpuError> {
        let (options, size) = (from.options(), from.size());
        let maps = if cameras.is_cube() {
            Maps::Cube(Box::new(DepthMapCube::new(pipelines, size[0], options)?))
        } else {
            Maps::One(Box::new(DepthMapVolumes::new(pipelines, size, options)?))
        };
        let usage = TextureUsages::RENDER_ATTACHMENT | TextureUsages::TEXTURE_BINDING | TextureUsages::COPY_SRC;
        let drawn = |_| view(&gpu.device.create_texture(&plain_texture("depth map", size, MAP, usage)));
        let (mut views, objects): (Vec<_>, _) = match &from.source {
            MapSource::Drawn { .. } => (cameras.0.iter().map(drawn).collect(), None),
            MapSource::Given(map) => (map.upload(gpu), map.upload_objects(gpu)),
        };
        let mut distances = Vec::new();
        if options.metric != DepthMetric::Device {
            for view in &mut views {
                let conversion = DepthMapConversion::new(&gpu.pipelines, size)?;
                let given = std::mem::replace(view, conversion.texture().clone());
                distances.push((given, conversion, options.metric));
            }
        }
        let (cameras, shown) = (cameras.clone(), ShownMaps::new(gpu, from.has_walls()));
        Ok(Self { maps, views, distances, objects, cameras, frame: None, shown })
    }

    /// Whether these are as many maps.
    pub(super) fn fits(&self, cameras: &LightCameras) -> bool {
        self.cameras.is_cube() == cameras.is_cube()
    }

    /// Records how shadows are rebuilt from what is in the maps.
    pub(super) fn find(
        &mut self,
        gpu: &Gpu,
        encoder: &mut wgpu::CommandEncoder,
        cameras: &LightCameras,
        eye: &ShadowCamera,
        mut timer: Option<&mut StageTimer>,
    ) -> Result<(), GpuError> {
        for ((given, conversion, metric), light) in self.distances.iter().zip(&cameras.0) {
            let map = DepthMap { texture: given, light: *light, objects: None };
            conversion.encode_timed(encoder, &map, *metric, timer.as_deref_mut())?;
        }
        let mut views = self.views.iter();
        let size = self.views.first().map_or([1; 2], |view| [view.texture().width(), view.texture().height()]);
        let frame = match (&mut self.maps, &cameras.0[..]) {
            (Maps::Cube(cube), &[a, b, c, d, e, f]) => {
                let textures = [0; 6].map(|_| views.next());
                let maps = DepthCubeMaps { textures, lights: [a, b, c, d, e, f], objects: [None; 6] };
                cube.encode_timed(encoder, &maps, eye, timer)?
            }
            (Maps::One(volumes), &[light]) => {
                let texture = views.next().ok_or(DepthMapError::StaleFrame)?;
                let map = DepthMap { texture, light, objects: self.objects.as_ref() };
                volumes.encode_timed(encoder, &map, eye, timer)?
            }
            // The caller asks `fits`.
            _ => return Err(DepthMapError::StaleFrame.into()),
        };
        let (capacity, ..) = self.rebuilt();
        self.shown.encode(gpu, encoder, (cameras, size), eye, (frame.draw_arguments(), capacity));
        self.cameras = cameras.clone();
        self.frame = Some(frame);
        Ok(())
    }

    pub(super) fn found(&self, gpu: &Gpu) -> Result<DepthFound, GpuError> {
        let (capacity, cells, _) = self.rebuilt();
        Ok(DepthFound { maps: self.views.len(), listed: gpu.read_first(cells)?, capacity })
    }

    pub(super) fn shown(&self) -> Option<ShownDepths<'_>> {
        let (_, cells, texture) = self.rebuilt();
        Some(ShownDepths { shown: &self.shown, cells, texture: texture? })
    }

    /// The cells that the list has room for, the list, and one map or six in one.
    fn rebuilt(&self) -> (u32, &wgpu::Buffer, Option<&wgpu::TextureView>) {
        match &self.maps {
            Maps::One(volumes) => (volumes.capacity(), volumes.cells(), self.views.first()),
            Maps::Cube(cube) => (cube.capacity(), cube.cells(), Some(cube.texture())),
        }
    }

    /// The maps as they were drawn, and what they were drawn with. Waits for the device.
    pub(super) fn saved(&self, gpu: &Gpu, origin: Origin) -> Result<DepthMapArrays, GpuError> {
        let mut depths = Vec::new();
        let mut size = [0; 2];
        for view in &self.views {
            let texture = view.texture();
            size = [texture.width(), texture.height()];
            let map = Picture::read(gpu, texture)?;
            depths.extend(map.rows().flat_map(bytemuck::pod_collect_to_vec::<u8, f32>));
        }
        let cameras = &self.cameras.0;
        let rows =
            |camera: &ShadowCamera| [0, 1, 2, 3].map(|row| camera.view_projection.map(|column| f64::from(column[row])));
        Ok(DepthMapArrays {
            size,
            depths: Depths::F32(depths),
            view_projections: cameras.iter().map(rows).collect(),
            origin: cameras.first().map_or([0.0; 3], |camera| origin.to_world(camera.origin)),
            is_reversed: cameras.first().is_some_and(|camera| camera.depth == DepthDirection::Reversed),
            depth_bits: None,
            metric: DepthMetric::Device,
            objects: None,
        })
    }
}
