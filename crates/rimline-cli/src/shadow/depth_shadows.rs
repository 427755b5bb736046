//! Shadows from depth maps that the lights see, which the command draws itself: `--from-depth`.

use std::sync::Arc;

use rimline::gpu::{
    DepthEdges, DepthMap, DepthMapCube, DepthMapFrame, DepthMapOptions, DepthMapPipelines, DepthMapVolumes, MeshDepth,
    ReadError, StageTimer, read_back_vec,
};
use rimline::{DepthDirection, Light, ShadowCamera, wgpu};

use super::extracted::Extracted;
use super::found::{FacingMasks, Found};
use super::light_maps::LightCameras;
use super::posed_model::PosedModel;
use super::shadows::{CastInputs, parity, put};
use crate::device::Gpu;
use crate::failure::{Failure, UsageError};
use crate::gpu_error::GpuError;

/// Floats tell the same part of any distance apart with reversed depth.
const MAP: wgpu::TextureFormat = wgpu::TextureFormat::Depth32Float;

/// What `--from-depth` and `--detector` ask for.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct FromDepth {
    /// Texels of a map, each way.
    pub(crate) side: u32,
    pub(crate) edges: DepthEdges,
}

impl FromDepth {
    /// Refuses what has no sensible result: six maps around a light have so near a near plane that all device depths are much the same.
    pub(crate) fn check(self, lights: &[Light], bodies: &[PosedModel<'_>]) -> Result<(), UsageError> {
        if !matches!(self.edges, DepthEdges::Differences { .. }) {
            return Ok(());
        }
        let points = points(bodies);
        let is_cube = |light: &Light| matches!(LightCameras::new(light, &points, self.side), LightCameras::Cube(_));
        lights.iter().position(is_cube).map_or(Ok(()), |light| Err(UsageError::DetectorInCube { light }))
    }
}

fn points(bodies: &[PosedModel<'_>]) -> Vec<[f32; 3]> {
    bodies.iter().flat_map(PosedModel::points).collect()
}

/// What was found in the maps of a light.
#[derive(Clone, Copy, Debug)]
pub(crate) struct DepthFound {
    /// Maps of the light: 1 or 6.
    pub(crate) maps: usize,
    /// Cells with a triangle in the boundary of its shadow.
    pub(crate) cells: u32,
}

pub(crate) struct DepthShadows {
    device: wgpu::Device,
    pipelines: Arc<DepthMapPipelines>,
    pub(super) from: FromDepth,
    max_lights: usize,
    files: Vec<File>,
    /// Of each light, from the first encode on.
    lights: Vec<LightMaps>,
}

/// The triangles of a file.
struct File {
    depth: MeshDepth,
    /// Which of them are turned to the lights.
    surface: Extracted,
}

struct LightMaps {
    maps: Maps,
    /// For each of the maps.
    views: Vec<wgpu::TextureView>,
    frame: Option<DepthMapFrame>,
}

enum Maps {
    One(Box<DepthMapVolumes>),
    Cube(Box<DepthMapCube>),
}

impl DepthShadows {
    pub(super) fn new(gpu: &Gpu, pipelines: &Arc<DepthMapPipelines>, from: FromDepth, max_lights: usize) -> Self {
        Self {
            device: gpu.device.clone(),
            pipelines: Arc::clone(pipelines),
            from,
            max_lights,
            files: Vec::new(),
            lights: Vec::new(),
        }
    }

    pub(super) fn place(&mut self, gpu: &Gpu, bodies: &[PosedModel<'_>]) -> Result<(), Failure> {
        for (number, body) in bodies.iter().enumerate() {
            if self.files.get(number).is_some_and(|file| file.surface.is_of(body)) {
                continue;
            }
            let mesh = body.triangles()?.map_or_else(|| body.mesh(), Ok)?;
            let depth = MeshDepth::new(&gpu.pipelines, &mesh, MAP, DepthDirection::Reversed);
            let depth = depth.map_err(|error| GpuError::from(error).on(gpu))?;
            put(
                &mut self.files,
                number,
                File { depth, surface: Extracted::of_mesh(gpu, &mesh, body, self.max_lights)? },
            );
        }
        Ok(())
    }

    pub(super) fn encode(
        &mut self,
        encoder: &mut wgpu::CommandEncoder,
        CastInputs { bodies, camera, lights }: CastInputs<'_>,
        mut timer: Option<&mut StageTimer>,
    ) -> Result<(), GpuError> {
        for (file, body) in self.files.iter_mut().zip(bodies) {
            file.surface.encode(encoder, body, lights, timer.as_deref_mut())?;
        }
        let points = points(bodies);
        for (number, light) in lights.iter().enumerate() {
            let cameras = LightCameras::new(light, &points, self.from.side);
            let fits = |maps: &LightMaps| match (&maps.maps, &cameras) {
                (Maps::One(_), LightCameras::One(_)) | (Maps::Cube(_), LightCameras::Cube(_)) => true,
                (Maps::One(_), LightCameras::Cube(_)) | (Maps::Cube(_), LightCameras::One(_)) => false,
            };
            if !self.lights.get(number).is_some_and(fits) {
                let made = LightMaps::new(&self.device, &self.pipelines, self.from, &cameras)?;
                put(&mut self.lights, number, made);
            }
            let Some(maps) = self.lights.get_mut(number) else { continue };
            let eyes = match &cameras {
                LightCameras::One(camera) => std::slice::from_ref(camera),
                LightCameras::Cube(cameras) => &cameras[..],
            };
            for (view, eye) in maps.views.iter().zip(eyes) {
                let timestamp_writes = timer.as_deref_mut().and_then(|timer| timer.render_pass("mesh_depth"));
                let ops = wgpu::Operations { load: wgpu::LoadOp::Clear(0.0), store: wgpu::StoreOp::Store };
                let mut pass = encoder.begin_render_pass(&wgpu::RenderPassDescriptor {
                    label: Some("depth map"),
                    depth_stencil_attachment: Some(wgpu::RenderPassDepthStencilAttachment {
                        view,
                        depth_ops: Some(ops),
                        stencil_ops: None,
                    }),
                    timestamp_writes,
                    ..Default::default()
                });
                for (file, body) in self.files.iter().zip(bodies) {
                    file.depth.draw(&mut pass, body.positions.buffer(), eye)?;
                }
            }
            maps.frame = Some(maps.find(encoder, &cameras, camera, timer.as_deref_mut())?);
        }
        self.lights.truncate(lights.len());
        Ok(())
    }

    pub(super) fn draw(
        &self,
        pass: &mut wgpu::RenderPass<'_>,
        pipelines: &DepthMapPipelines,
        light: usize,
    ) -> Result<(), GpuError> {
        match self.lights.get(light).and_then(|maps| maps.frame.as_ref()) {
            Some(frame) => Ok(frame.draw(pass, pipelines)?),
            None => Ok(()),
        }
    }

    pub(super) fn facing(&self, bodies: &[PosedModel<'_>]) -> Vec<FacingMasks> {
        self.files.iter().zip(bodies).map(|(file, body)| file.surface.facing(body)).collect()
    }

    /// What was found for each file: no volumes. Waits for the device.
    pub(super) fn found_of_files(&self, gpu: &Gpu) -> Result<Vec<Found>, ReadError> {
        let of_file = |file: &File| {
            let (silhouettes, extraction) = file.surface.found(gpu, self.max_lights)?;
            let lights = vec![bytemuck::Zeroable::zeroed(); self.max_lights];
            Ok(Found { lights, silhouettes, extraction, shadow: parity(), is_whole: true })
        };
        self.files.iter().map(of_file).collect()
    }

    /// What was found for each light. Waits for the device.
    pub(super) fn found(&self, gpu: &Gpu) -> Result<Vec<DepthFound>, ReadError> {
        let of_light = |LightMaps { maps, views, .. }: &LightMaps| {
            let list = match maps {
                Maps::One(volumes) => volumes.cells(),
                Maps::Cube(cube) => cube.cells(),
            };
            let list: Vec<u32> = read_back_vec(&gpu.device, &gpu.queue, list)?;
            Ok(DepthFound { maps: views.len(), cells: list.first().copied().unwrap_or(0) })
        };
        self.lights.iter().map(of_light).collect()
    }
}

impl LightMaps {
    fn new(
        device: &wgpu::Device,
        pipelines: &DepthMapPipelines,
        FromDepth { side, edges }: FromDepth,
        cameras: &LightCameras,
    ) -> Result<Self, GpuError> {
        let options = DepthMapOptions { edges, ..DepthMapOptions::default() };
        let (maps, count) = match cameras {
            LightCameras::One(_) => (Maps::One(Box::new(DepthMapVolumes::new(pipelines, [side; 2], options)?)), 1),
            LightCameras::Cube(cameras) => {
                (Maps::Cube(Box::new(DepthMapCube::new(pipelines, side, cameras, options)?)), 6)
            }
        };
        let view = |_| {
            let texture = device.create_texture(&wgpu::TextureDescriptor {
                label: Some("depth map"),
                size: wgpu::Extent3d { width: side, height: side, depth_or_array_layers: 1 },
                mip_level_count: 1,
                sample_count: 1,
                dimension: wgpu::TextureDimension::D2,
                format: MAP,
                usage: wgpu::TextureUsages::RENDER_ATTACHMENT | wgpu::TextureUsages::TEXTURE_BINDING,
                view_formats: &[],
            });
            texture.create_view(&wgpu::TextureViewDescriptor::default())
        };
        Ok(Self { maps, views: (0..count).map(view).collect(), frame: None })
    }

    fn find(
        &mut self,
        encoder: &mut wgpu::CommandEncoder,
        cameras: &LightCameras,
        eye: &ShadowCamera,
        timer: Option<&mut StageTimer>,
    ) -> Result<DepthMapFrame, GpuError> {
        let mut views = self.views.iter();
        match (&mut self.maps, cameras) {
            (Maps::Cube(cube), LightCameras::Cube(cameras)) => {
                cube.set_cameras(cameras)?;
                Ok(cube.encode(encoder, [0; 6].map(|_| views.next()), eye, timer)?)
            }
            (Maps::One(volumes), LightCameras::One(light)) => {
                let Some(texture) = views.next() else {
                    return Err(rimline::gpu::DepthMapDrawError::StaleFrame.into());
                };
                Ok(volumes.encode(encoder, &DepthMap { texture, light: *light }, eye, timer)?)
            }
            // `encode` makes maps that fit.
            _ => Err(rimline::gpu::DepthMapDrawError::StaleFrame.into()),
        }
    }
}
