//! Pictures of an eye whose depth buffer is given: the stencil after the volumes of depth maps.

use std::ops::Range;
use std::sync::Arc;

use glam::DVec3;
use rimline::gpu::ShadowFormat;
use rimline::gpu::depth_map::{
    DepthCubeMaps, DepthMap, DepthMapCube, DepthMapFrame, DepthMapMethod, DepthMapOptions, DepthMapPipelines,
    DepthMapStatistics, DepthMapVolumes,
};
use rimline::internals::depth_map::DepthMapNearCap;
use rimline::{DepthDirection, ShadowCamera};
use rimline_testkit::device::Gpu;
use rimline_testkit::on_gpu::text;
use rimline_testkit::passes::{depth_pass, map_pipelines};
use wgpu::TextureFormat;

use crate::maps::Map;
use rimline_testkit::frames::Eye;
use rimline_testkit::textures::{Stencils, depth_view, sampled, texture};

pub(crate) const REVERSED: DepthDirection = DepthDirection::Reversed;
pub(crate) const STANDARD: DepthDirection = DepthDirection::Standard;
pub(crate) const EVERY_CELL: DepthMapMethod = DepthMapMethod::EveryCell;
pub(crate) const AUTOMATIC: DepthMapMethod = DepthMapMethod::Automatic { dangling: None };
pub(crate) const FACES: [usize; 6] = [0, 1, 2, 3, 4, 5];

pub(crate) fn differences(threshold: f32) -> DepthMapMethod {
    DepthMapMethod::Differences { threshold, dangling: None }
}

pub(crate) fn contours([threshold, sideways, depth]: [f32; 3]) -> DepthMapMethod {
    DepthMapMethod::Contours { threshold, sideways, depth }
}

/// A method, and nothing else that differs from the default.
pub(crate) fn by(method: DepthMapMethod) -> DepthMapOptions {
    DepthMapOptions { method, ..Default::default() }
}

/// A perspective view of reversed depth without a far plane, whose positions are taken relative to the eye.
pub(crate) fn look(position: DVec3, forward: DVec3, near: f64) -> Eye {
    Eye { position, forward, near, is_relative: true, depth: REVERSED, far: None, half_width: None }
}

/// The maps of a light, one or the six of a cube, with their cameras.
#[derive(Clone)]
pub(crate) struct Maps {
    pub(crate) views: Vec<Option<wgpu::TextureView>>,
    pub(crate) lights: Vec<ShadowCamera>,
    pub(crate) objects: Vec<Option<wgpu::TextureView>>,
    /// Texels of each, across and down.
    pub(crate) size: [u32; 2],
}

impl Maps {
    pub(crate) fn one(texture: &wgpu::Texture, light: ShadowCamera) -> Self {
        let size = [texture.width(), texture.height()];
        Self { views: vec![Some(depth_view(texture))], lights: vec![light], objects: vec![None], size }
    }

    pub(crate) fn of(gpu: &Gpu, map: &Map, format: TextureFormat, light: ShadowCamera) -> Result<Self, String> {
        Ok(Self::one(&texture(gpu, map.size, format, &map.depths)?, light))
    }

    /// One map, or six of which some are not there, of `side` texels.
    pub(crate) fn all(
        gpu: &Gpu,
        (maps, side): (&[Option<Map>], u32),
        format: TextureFormat,
        lights: &[ShadowCamera],
    ) -> Result<Self, String> {
        let view = |map: &Option<Map>| {
            let texture = map.as_ref().map(|map| texture(gpu, map.size, format, &map.depths)).transpose()?;
            Ok::<_, String>(texture.map(|texture| depth_view(&texture)))
        };
        let views = maps.iter().map(view).collect::<Result<Vec<_>, _>>()?;
        Ok(Self { objects: vec![None; views.len()], views, lights: lights.to_vec(), size: [side; 2] })
    }

    /// The same with maps in another order: a negative control.
    pub(crate) fn exchanged(&self, order: [usize; 6]) -> Self {
        Self { views: order.map(|face| self.views[face].clone()).to_vec(), ..self.clone() }
    }
}

/// Pipelines for a direction of depth, which draw into these bits.
pub(crate) fn pipelines(gpu: &Gpu, depth: DepthDirection, bits: Range<u32>) -> Result<Arc<DepthMapPipelines>, String> {
    map_pipelines(gpu, &ShadowFormat { depth, ..Default::default() }, bits)
}

pub(crate) enum Volumes {
    Map(Box<DepthMapVolumes>),
    Cube(Box<DepthMapCube>),
}

impl Volumes {
    /// For one map or six.
    pub(crate) fn new(
        pipelines: &DepthMapPipelines,
        maps: usize,
        size: [u32; 2],
        options: DepthMapOptions,
    ) -> Result<Self, String> {
        Ok(if maps == 1 {
            Self::Map(Box::new(DepthMapVolumes::new(pipelines, size, options).map_err(text)?))
        } else {
            Self::Cube(Box::new(DepthMapCube::new(pipelines, size[0], options).map_err(text)?))
        })
    }

    pub(crate) fn encode(
        &mut self,
        encoder: &mut wgpu::CommandEncoder,
        maps: &Maps,
        eye: &ShadowCamera,
    ) -> Result<DepthMapFrame, String> {
        match self {
            Self::Map(volumes) => {
                let texture = maps.views[0].as_ref().ok_or("no map")?;
                let map = DepthMap { texture, light: maps.lights[0], objects: maps.objects[0].as_ref() };
                volumes.encode(encoder, &map, eye).map_err(text)
            }
            Self::Cube(volumes) => {
                let lights = maps.lights[..].try_into().map_err(text)?;
                let [textures, objects] =
                    [&maps.views, &maps.objects].map(|views| FACES.map(|face| views[face].as_ref()));
                volumes.encode(encoder, &DepthCubeMaps { textures, lights, objects }, eye).map_err(text)
            }
        }
    }

    pub(crate) fn cells(&self) -> &wgpu::Buffer {
        match self {
            Self::Map(volumes) => volumes.cells(),
            Self::Cube(volumes) => volumes.cells(),
        }
    }
}

/// An encode, and its statistics.
pub(crate) struct Encoded {
    pub(crate) volumes: Volumes,
    pub(crate) frame: DepthMapFrame,
    pub(crate) statistics: DepthMapStatistics,
}

impl Encoded {
    pub(crate) fn new(
        gpu: &Gpu,
        pipelines: &DepthMapPipelines,
        maps: &Maps,
        eye: &ShadowCamera,
        options: DepthMapOptions,
    ) -> Result<Self, String> {
        let mut volumes = Volumes::new(pipelines, maps.lights.len(), maps.size, options)?;
        let (frame, statistics) = gpu.submit(|encoder| {
            let frame = volumes.encode(encoder, maps, eye)?;
            let statistics = frame.statistics(encoder).map_err(text)?;
            Ok((frame, statistics))
        })?;
        Ok(Self { volumes, frame, statistics: gpu.read(&statistics, 1)?[0] })
    }

    /// Its list of cells: how many were found, and those that there is room for.
    pub(crate) fn list(&self, gpu: &Gpu) -> Result<Vec<u32>, String> {
        let count = self.statistics.found.min(self.statistics.capacity);
        gpu.read(self.volumes.cells(), 1 + count as usize)
    }

    /// Whether its near cap is skipped (0), skipped by the GPU (1), or drawn (2).
    pub(crate) fn cap_kind(&self) -> usize {
        let is_skipped = *self.frame.near_cap() == DepthMapNearCap::Skipped;
        if self.has_cap() { 2 } else { usize::from(!is_skipped) }
    }

    /// Whether a near cap is drawn.
    pub(crate) fn has_cap(&self) -> bool {
        self.statistics.near_cap_vertices != 0
    }
}

/// A square picture: its eye, the depths of its samples row by row, and the bits that are drawn into.
#[derive(Clone)]
pub(crate) struct Target<'a> {
    pub(crate) eye: ShadowCamera,
    pub(crate) depths: &'a [f32],
    pub(crate) format: TextureFormat,
    pub(crate) samples: u32,
    pub(crate) bits: Range<u32>,
}

impl<'a> Target<'a> {
    pub(crate) fn new(eye: ShadowCamera, depths: &'a [f32]) -> Self {
        Self { eye, depths, format: TextureFormat::Depth24PlusStencil8, samples: 1, bits: 0..1 }
    }

    /// The stencil of each sample, from 0 on.
    pub(crate) fn stencil(&self, gpu: &Gpu, maps: &Maps, options: DepthMapOptions) -> Result<Vec<u8>, String> {
        Ok(self.draw(gpu, maps, options)?.0)
    }

    pub(crate) fn draw(&self, gpu: &Gpu, maps: &Maps, options: DepthMapOptions) -> Result<(Vec<u8>, Encoded), String> {
        let Self { eye, depths, format, samples, ref bits } = *self;
        let shadow_format = ShadowFormat { depth_stencil: format, depth: eye.depth, samples, ..Default::default() };
        let pipelines = map_pipelines(gpu, &shadow_format, bits.clone())?;
        let side = (depths.len() / samples as usize).isqrt() as u32;
        let target = sampled(gpu, [side; 2], (format, samples), depths)?;
        let view = target.create_view(&wgpu::TextureViewDescriptor::default());
        let encoded = Encoded::new(gpu, &pipelines, maps, &eye, options)?;
        let stencils = gpu.submit(|encoder| {
            let pass = depth_pass(&view, (None, Some(wgpu::LoadOp::Load)));
            encoded.frame.draw(&mut encoder.begin_render_pass(&pass), &pipelines).map_err(text)?;
            Stencils::of(gpu, encoder, &target)
        })?;
        Ok((stencils.read(gpu)?, encoded))
    }
}
