//! Shadows from depth maps of the lights: those that the command draws itself, `--from-depth`, or those of one light in a
//! file, `--depth`.

use std::sync::Arc;

use rimline::gpu::depth_map::{
    DepthCubeMaps, DepthMap, DepthMapCube, DepthMapError, DepthMapFrame, DepthMapMethod, DepthMapPipelines,
    DepthMapStatistics, DepthMapTexture, DepthMapVolumes, DepthMetric, MeshDepth,
};
use rimline::gpu::{ShadowStatistics, StageTimer};
use rimline::{DepthDirection, Origin, ShadowCamera, wgpu};
use rimline_files::npz::{DepthMapArrays, Depths};
use rimline_picture::{FacingMasks, plain_texture, view};
use wgpu::TextureUsages;

use super::casting::{CastInputs, Extracted, PosedModel, put};
use super::from_depth::{DepthFound, DepthsFound, FromDepth, MAP, points};
use super::light_maps::{LightCameras, ShownDepths, ShownMaps};
use super::shadows::{Choice, Found, Shadows, VolumePipelines};
use crate::device::{Gpu, GpuError, On as _};
use crate::failure::Failure;
use crate::image::Picture;

pub(super) struct DepthShadows<'a> {
    gpu: &'a Gpu,
    pipelines: Arc<DepthMapPipelines>,
    from: FromDepth,
    max_lights: usize,
    files: Vec<File>,
    lights: Vec<LightMaps>,
}

struct File {
    /// Draws the file into maps. `None`: the maps are given.
    depth: Option<MeshDepth>,
    surface: Extracted,
}

impl<'a> DepthShadows<'a> {
    pub(super) fn new(gpu: &'a Gpu, pipelines: &Arc<DepthMapPipelines>, from: &FromDepth, max_lights: usize) -> Self {
        let (files, lights) = (Vec::new(), Vec::new());
        Self { gpu, pipelines: Arc::clone(pipelines), from: from.clone(), max_lights, files, lights }
    }
}

impl Shadows for DepthShadows<'_> {
    fn set_bodies(&mut self, bodies: &[PosedModel<'_>]) -> Result<(), Failure> {
        let gpu = self.gpu;
        for (number, body) in bodies.iter().enumerate() {
            if self.files.get(number).is_some_and(|file| file.surface.is_of(body)) {
                continue;
            }
            let mesh = body.triangles()?.map_or_else(|| body.mesh(), Ok)?;
            let depth = || MeshDepth::new(&gpu.pipelines, &mesh, MAP, DepthDirection::Reversed);
            let depth = self.from.given.is_none().then(depth).transpose().on(gpu)?;
            let surface = Extracted::new(gpu, &mesh, body, self.max_lights)?;
            put(&mut self.files, number, File { depth, surface });
        }
        Ok(())
    }

    fn encode(
        &mut self,
        encoder: &mut wgpu::CommandEncoder,
        CastInputs { bodies, seen, camera, lights }: CastInputs<'_>,
        mut timer: Option<&mut StageTimer>,
    ) -> Result<(), GpuError> {
        for (file, body) in self.files.iter_mut().zip(bodies) {
            file.surface.encode(encoder, body, lights, timer.as_deref_mut())?;
        }
        let points = points(seen);
        let Self { gpu, pipelines, from, files, lights: made, .. } = self;
        for (number, light) in lights.iter().enumerate() {
            let cameras = match &from.given {
                None => LightCameras::new(light, &points, from.size[0])?,
                Some(map) => map.cameras.clone(),
            };
            if made.get(number).is_none_or(|maps| maps.cameras.is_cube() != cameras.is_cube()) {
                let maps = LightMaps::new(gpu, pipelines, from, &cameras).map_err(|error| from.failed(error))?;
                put(made, number, maps);
            }
            let Some(maps) = made.get_mut(number) else { continue };
            if from.given.is_none() {
                for (view, eye) in maps.views.iter().zip(&cameras.0) {
                    draw_map(encoder, (view, eye), files, bodies, timer.as_deref_mut())?;
                }
            }
            let found = maps.find(gpu, encoder, &cameras, camera, timer.as_deref_mut());
            found.map_err(|error| from.failed(error))?;
        }
        made.truncate(lights.len());
        Ok(())
    }

    fn draw(&self, pass: &mut wgpu::RenderPass<'_>, pipelines: &VolumePipelines, light: usize) -> Result<(), GpuError> {
        let VolumePipelines::Depth(plain, _) = pipelines else { return Ok(()) };
        let frame = self.lights.get(light).and_then(|maps| maps.frame.as_ref());
        Ok(frame.map_or(Ok(()), |frame| frame.draw(pass, plain))?)
    }

    fn facing(&self, bodies: &[PosedModel<'_>]) -> Result<Vec<FacingMasks>, GpuError> {
        Ok(self.files.iter().zip(bodies).map(|(file, body)| file.surface.facing(body)).collect())
    }

    fn found(&self) -> Result<Vec<Found>, GpuError> {
        let of_file = |file: &File| {
            let (silhouettes, extraction) = file.surface.found(self.gpu, self.max_lights)?;
            let lights = vec![Choice { casting: "depth map", counting: "parity" }; self.max_lights];
            Ok(Found { lights, silhouettes, extraction, shadow: self.statistics()? })
        };
        self.files.iter().map(of_file).collect()
    }

    /// No volume of a mesh, and a count of 0 or 1.
    fn statistics(&self) -> Result<ShadowStatistics, GpuError> {
        Ok(ShadowStatistics { count_bound: 1, ..bytemuck::Zeroable::zeroed() })
    }

    fn depths_found(&self) -> Result<Option<DepthsFound>, GpuError> {
        // Lists may have hundreds of megabytes, so only their counts are read.
        let (mut encoder, mut copies) = (self.gpu.encoder("counts of depth maps"), Vec::new());
        for LightMaps { views, frame, .. } in &self.lights {
            let Some(frame) = frame else { continue };
            copies.push((views.len(), frame.statistics(&mut encoder)?));
        }
        self.gpu.submit(encoder);
        let found = |(maps, counts): (usize, wgpu::Buffer)| {
            let DepthMapStatistics { found: listed, capacity, .. } = self.gpu.read_first(&counts)?;
            Ok::<_, GpuError>(DepthFound { maps, listed, capacity })
        };
        let lights = copies.into_iter().map(found).collect::<Result<_, _>>()?;
        let takes_every = self.from.method == DepthMapMethod::EveryCell;
        Ok(Some(DepthsFound { size: self.from.size, takes_every, has_walls: self.from.has_walls(), lights }))
    }

    fn shown_maps(&self, light: usize) -> Option<ShownDepths<'_>> {
        let maps = self.lights.get(light)?;
        let Rebuilt { cells, texture, .. } = maps.rebuilt();
        Some(ShownDepths { shown: &maps.shown, cells, texture: texture? })
    }

    fn saved_maps(&self, light: usize, origin: Origin) -> Result<Option<DepthMapArrays>, GpuError> {
        self.lights.get(light).map(|maps| maps.saved(self.gpu, origin)).transpose()
    }
}

fn draw_map(
    encoder: &mut wgpu::CommandEncoder,
    (view, eye): (&wgpu::TextureView, &ShadowCamera),
    files: &[File],
    bodies: &[PosedModel<'_>],
    timer: Option<&mut StageTimer>,
) -> Result<(), GpuError> {
    let ops = wgpu::Operations { load: wgpu::LoadOp::Clear(0.0), store: wgpu::StoreOp::Store };
    let mut pass = encoder.begin_render_pass(&wgpu::RenderPassDescriptor {
        label: Some("depth map"),
        depth_stencil_attachment: Some(wgpu::RenderPassDepthStencilAttachment {
            view,
            depth_ops: Some(ops),
            stencil_ops: None,
        }),
        timestamp_writes: timer.and_then(|timer| timer.render_pass("mesh_depth")),
        ..Default::default()
    });
    for (file, body) in files.iter().zip(bodies) {
        if let Some(depth) = &file.depth {
            depth.draw(&mut pass, body.positions.buffer(), eye)?;
        }
    }
    Ok(())
}

struct LightMaps {
    maps: Maps,
    /// The maps of device depths: drawn, given, or converted from `distances`.
    views: Vec<wgpu::TextureView>,
    /// One for each map, or none if the maps are depths.
    distances: Vec<Distances>,
    objects: Option<wgpu::TextureView>,
    /// Cameras with which the maps were encoded.
    cameras: LightCameras,
    frame: Option<DepthMapFrame>,
    shown: ShownMaps,
}

/// Distances, and the map that they are converted to.
struct Distances {
    texture: wgpu::TextureView,
    converted: DepthMapTexture,
    metric: DepthMetric,
}

/// The shadows that were rebuilt from maps.
struct Rebuilt<'a> {
    /// Cells, or walls and flaps, that the list has room for.
    capacity: u32,
    /// The list, which begins with its count.
    cells: &'a wgpu::Buffer,
    /// One map, or six in one.
    texture: Option<&'a wgpu::TextureView>,
}

enum Maps {
    One(Box<DepthMapVolumes>),
    Cube(Box<DepthMapCube>),
}

impl LightMaps {
    fn new(
        gpu: &Gpu,
        pipelines: &DepthMapPipelines,
        from: &FromDepth,
        cameras: &LightCameras,
    ) -> Result<Self, GpuError> {
        let (options, size) = (from.options(), from.size);
        let maps = if cameras.is_cube() {
            Maps::Cube(Box::new(DepthMapCube::new(pipelines, size[0], options)?))
        } else {
            Maps::One(Box::new(DepthMapVolumes::new(pipelines, size, options)?))
        };
        let usage = TextureUsages::RENDER_ATTACHMENT | TextureUsages::TEXTURE_BINDING | TextureUsages::COPY_SRC;
        let drawn = |_| view(&gpu.device.create_texture(&plain_texture("depth map", size, MAP, usage)));
        let (mut views, objects): (Vec<_>, _) = match &from.given {
            None => (cameras.0.iter().map(drawn).collect(), None),
            Some(map) => (map.upload(gpu), map.upload_objects(gpu)),
        };
        let mut distances = Vec::new();
        if options.metric != DepthMetric::Device {
            for view in &mut views {
                let converted = DepthMapTexture::new(&gpu.pipelines, size)?;
                let texture = std::mem::replace(view, converted.view().clone());
                distances.push(Distances { texture, converted, metric: options.metric });
            }
        }
        let (cameras, shown) = (cameras.clone(), ShownMaps::new(gpu, from.has_walls()));
        Ok(Self { maps, views, distances, objects, cameras, frame: None, shown })
    }

    /// Records how shadows are rebuilt from what is in the maps.
    fn find(
        &mut self,
        gpu: &Gpu,
        encoder: &mut wgpu::CommandEncoder,
        cameras: &LightCameras,
        eye: &ShadowCamera,
        mut timer: Option<&mut StageTimer>,
    ) -> Result<(), GpuError> {
        for (Distances { texture, converted, metric }, light) in self.distances.iter().zip(&cameras.0) {
            let map = DepthMap { texture, light: *light, objects: None };
            converted.convert_timed(encoder, &map, *metric, timer.as_deref_mut())?;
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
            // Not reached: `encode` makes other maps if the number of cameras changes.
            _ => return Err(DepthMapError::StaleFrame.into()),
        };
        let capacity = self.rebuilt().capacity;
        self.shown.encode(gpu, encoder, (cameras, size), eye, (frame.draw_arguments(), capacity));
        self.cameras = cameras.clone();
        self.frame = Some(frame);
        Ok(())
    }

    fn rebuilt(&self) -> Rebuilt<'_> {
        match &self.maps {
            Maps::One(volumes) => {
                Rebuilt { capacity: volumes.capacity(), cells: volumes.cells(), texture: self.views.first() }
            }
            Maps::Cube(cube) => {
                Rebuilt { capacity: cube.capacity(), cells: cube.cells(), texture: Some(cube.texture()) }
            }
        }
    }

    /// The maps as the command drew them, and what they were drawn with. Given maps cannot be copied. Waits for the device.
    fn saved(&self, gpu: &Gpu, origin: Origin) -> Result<DepthMapArrays, GpuError> {
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
