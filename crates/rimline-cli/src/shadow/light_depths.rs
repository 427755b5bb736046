//! The depth maps of one light, and the shadows rebuilt from them.

use rimline::gpu::{
    DepthCubeMaps, DepthMap, DepthMapConversion, DepthMapCube, DepthMapError, DepthMapFrame, DepthMapPipelines,
    DepthMapVolumes, DepthMetric, DeviceError, StageTimer, read_back_vec,
};
use rimline::{Origin, ShadowCamera, wgpu};

use super::from_depth::{DepthFound, FromDepth, MAP, MapSource};
use super::light_maps::LightCameras;
use super::shown_maps::{ShownDepths, ShownMaps};
use crate::device::Gpu;
use crate::gpu_error::GpuError;
use crate::image::Picture;
use crate::npz::{DepthMapArrays, Depths, Metric};

pub(super) struct LightMaps {
    maps: Maps,
    /// For each of the maps.
    pub(super) views: Vec<wgpu::TextureView>,
    /// Distances that the maps are converted from: one for each map, or none if the maps are depths.
    distances: Vec<Distances>,
    objects: Option<wgpu::TextureView>,
    /// Cameras with which the maps were encoded.
    cameras: LightCameras,
    pub(super) frame: Option<DepthMapFrame>,
    shown: ShownMaps,
}

/// A map of distances, and what makes a map of depths of it.
struct Distances {
    given: wgpu::TextureView,
    conversion: DepthMapConversion,
    metric: DepthMetric,
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
        let maps = match cameras {
            LightCameras::One(_) => Maps::One(Box::new(DepthMapVolumes::new(pipelines, size, options)?)),
            LightCameras::Cube(_) => Maps::Cube(Box::new(DepthMapCube::new(pipelines, size[0], options)?)),
        };
        let (mut views, objects): (Vec<_>, _) = match &from.source {
            MapSource::Drawn { side } => (cameras.all().iter().map(|_| drawn(gpu, *side)).collect(), None),
            MapSource::Given(map) => (map.upload(gpu), map.upload_objects(gpu)),
        };
        let mut distances = Vec::new();
        if options.metric != DepthMetric::Device {
            for view in &mut views {
                let conversion = DepthMapConversion::new(&gpu.pipelines, size)?;
                let given = std::mem::replace(view, conversion.texture().clone());
                distances.push(Distances { given, conversion, metric: options.metric });
            }
        }
        Ok(Self {
            maps,
            views,
            distances,
            objects,
            cameras: cameras.clone(),
            frame: None,
            shown: ShownMaps::new(gpu, from.has_walls()),
        })
    }

    /// Whether these are as many maps.
    pub(super) fn fits(&self, cameras: &LightCameras) -> bool {
        match (&self.maps, cameras) {
            (Maps::One(_), LightCameras::One(_)) | (Maps::Cube(_), LightCameras::Cube(_)) => true,
            (Maps::One(_), LightCameras::Cube(_)) | (Maps::Cube(_), LightCameras::One(_)) => false,
        }
    }

    /// Records how shadows are rebuilt from what is in the maps.
    pub(super) fn find(
        &mut self,
        gpu: &Gpu,
        encoder: &mut wgpu::CommandEncoder,
        cameras: &LightCameras,
        eye: &ShadowCamera,
        timer: Option<&mut StageTimer>,
    ) -> Result<(), GpuError> {
        let mut timer = timer;
        for (Distances { given, conversion, metric }, light) in self.distances.iter().zip(cameras.all()) {
            let map = DepthMap { texture: given, light: *light, objects: None };
            conversion.encode(encoder, &map, *metric, timer.as_deref_mut())?;
        }
        let mut views = self.views.iter();
        let size = self.views.first().map_or([1; 2], |view| [view.texture().width(), view.texture().height()]);
        let frame = match (&mut self.maps, cameras) {
            (Maps::Cube(cube), LightCameras::Cube(cameras)) => {
                let textures = [0; 6].map(|_| views.next());
                let maps = DepthCubeMaps { textures, lights: **cameras, objects: [None; 6] };
                cube.encode(encoder, &maps, eye, timer)?
            }
            (Maps::One(volumes), LightCameras::One(light)) => {
                let texture = views.next().ok_or(DepthMapError::StaleFrame)?;
                let map = DepthMap { texture, light: *light, objects: self.objects.as_ref() };
                volumes.encode(encoder, &map, eye, timer)?
            }
            // The caller asks `fits`.
            _ => return Err(DepthMapError::StaleFrame.into()),
        };
        self.shown.encode(gpu, encoder, (cameras, size), eye, (frame.draw_arguments(), self.capacity()));
        self.cameras = cameras.clone();
        self.frame = Some(frame);
        Ok(())
    }

    /// Results in the maps. Waits for the device.
    pub(super) fn found(&self, gpu: &Gpu) -> Result<DepthFound, DeviceError> {
        let list: Vec<u32> = read_back_vec(&gpu.device, &gpu.queue, self.cells())?;
        let listed = list.first().copied().unwrap_or(0);
        Ok(DepthFound { maps: self.views.len(), listed, capacity: self.capacity() })
    }

    /// Contents of the overlay of the maps.
    pub(super) fn shown(&self) -> Option<ShownDepths<'_>> {
        let texture = match &self.maps {
            Maps::One(_) => self.views.first()?,
            Maps::Cube(cube) => cube.texture(),
        };
        Some(ShownDepths { shown: &self.shown, cells: self.cells(), texture })
    }

    fn capacity(&self) -> u32 {
        match &self.maps {
            Maps::One(volumes) => volumes.capacity(),
            Maps::Cube(cube) => cube.capacity(),
        }
    }

    fn cells(&self) -> &wgpu::Buffer {
        match &self.maps {
            Maps::One(volumes) => volumes.cells(),
            Maps::Cube(cube) => cube.cells(),
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
        let cameras = self.cameras.all();
        let rows =
            |camera: &ShadowCamera| [0, 1, 2, 3].map(|row| camera.view_projection.map(|column| f64::from(column[row])));
        Ok(DepthMapArrays {
            size,
            depths: Depths::F32(depths),
            view_projections: cameras.iter().map(rows).collect(),
            origin: cameras.first().map_or([0.0; 3], |camera| origin.to_world(camera.origin)),
            is_reversed: cameras.first().is_some_and(|camera| camera.depth == rimline::DepthDirection::Reversed),
            depth_bits: None,
            metric: Metric::Device,
            objects: None,
        })
    }
}

/// A map that is drawn into.
fn drawn(gpu: &Gpu, side: u32) -> wgpu::TextureView {
    let texture = gpu.device.create_texture(&wgpu::TextureDescriptor {
        label: Some("depth map"),
        size: wgpu::Extent3d { width: side, height: side, depth_or_array_layers: 1 },
        mip_level_count: 1,
        sample_count: 1,
        dimension: wgpu::TextureDimension::D2,
        format: MAP,
        usage: wgpu::TextureUsages::RENDER_ATTACHMENT
            | wgpu::TextureUsages::TEXTURE_BINDING
            | wgpu::TextureUsages::COPY_SRC,
        view_formats: &[],
    });
    texture.create_view(&wgpu::TextureViewDescriptor::default())
}
