//! A depth map that the caller made: `--depth`.

use std::path::{Path, PathBuf};

use glam::Vec3;
use rimline::gpu::depth_map::{DepthMapMethod, DepthMetric};
use rimline::{CameraError, DepthDirection, Light, Origin, ShadowCamera, wgpu};
use wgpu::{TextureFormat, TextureUsages};

use super::given_map_error::GivenMapError;
use super::light_maps::LightCameras;
use super::shaded_lights::{SceneBounds, ShadedLight};
use crate::device::Gpu;
use crate::failure::{Failure, InputError, UsageError};
use crate::npz::{self, DepthMapArrays, Depths};
use crate::render::pipeline_factory::{plain_texture, view};
use crate::{coordinates, source};

/// A map, or six, with what they were drawn with.
#[derive(Debug)]
pub(crate) struct GivenMap {
    pub(crate) file: PathBuf,
    /// With `objects` only if the detector takes them.
    pub(super) arrays: DepthMapArrays,
    pub(super) cameras: LightCameras,
    /// A format that the depths were rounded to, coarser than their own.
    pub(super) rounded_to: Option<TextureFormat>,
}

impl GivenMap {
    pub(super) fn read(
        file: &Path,
        method: DepthMapMethod,
        memory_limit: u64,
        origin: Origin,
    ) -> Result<Self, Failure> {
        let takes = method != DepthMapMethod::EveryCell;
        let read = || -> Result<_, InputError> {
            let arrays = npz::read_depth_map(source::archive(source::open(file)?)?, memory_limit, takes)?;
            Ok(Self::new(file, arrays, origin)?)
        };
        read().map_err(Failure::input(file))
    }

    fn new(file: &Path, arrays: DepthMapArrays, run: Origin) -> Result<Self, GivenMapError> {
        let DepthMapArrays { size, depths, metric, .. } = &arrays;
        let depth = if arrays.is_reversed { DepthDirection::Reversed } else { DepthDirection::Standard };
        let camera = |rows: &[[f64; 4]; 4]| {
            let (rows, origin) = relative(rows, arrays.origin, run);
            let view_projection = [0, 1, 2, 3].map(|column| rows.map(|row| row[column] as f32));
            ShadowCamera { view_projection, origin, depth }
        };
        let cameras: Vec<ShadowCamera> = arrays.view_projections.iter().map(camera).collect();
        for (map, camera) in cameras.iter().enumerate() {
            camera.check().map_err(|error| match error {
                CameraError::Mirrored => GivenMapError::Mirrored { map },
                error => GivenMapError::Camera { map, error },
            })?;
        }
        match cameras[..] {
            [_] => {}
            _ if size[0] != size[1] => return Err(GivenMapError::NotSquare(*size)),
            _ if arrays.objects.is_some() => return Err(GivenMapError::ObjectsOfCube),
            _ => {}
        }
        if *metric != DepthMetric::Device {
            if let Depths::U16(_) = depths {
                return Err(GivenMapError::DistanceType);
            }
            if arrays.depth_bits.is_some() {
                return Err(GivenMapError::DistanceBits);
            }
        }
        let rounded_to = match (arrays.depth_bits, depths) {
            (Some(16), Depths::F32(_)) => Some(TextureFormat::Depth16Unorm),
            (Some(24), Depths::F32(_)) => Some(TextureFormat::Depth24Plus),
            _ => None,
        };
        Ok(Self { file: file.to_owned(), arrays, cameras: LightCameras(cameras), rounded_to })
    }

    /// Copies the maps into textures, one for each.
    pub(super) fn upload(&self, gpu: &Gpu) -> Vec<wgpu::TextureView> {
        let texels = self.arrays.size.map(|side| side as usize).into_iter().product::<usize>();
        let (format, bytes, size) = match &self.arrays.depths {
            Depths::F32(depths) => (TextureFormat::R32Float, bytemuck::cast_slice(depths), 4),
            Depths::U16(depths) => (TextureFormat::Depth16Unorm, bytemuck::cast_slice::<_, u8>(depths), 2),
        };
        bytes.chunks(size * texels).map(|map| self.texture(gpu, format, map)).collect()
    }

    pub(super) fn upload_objects(&self, gpu: &Gpu) -> Option<wgpu::TextureView> {
        let objects = self.arrays.objects.as_ref()?;
        Some(self.texture(gpu, TextureFormat::R32Uint, bytemuck::cast_slice(objects)))
    }

    fn texture(&self, gpu: &Gpu, format: TextureFormat, bytes: &[u8]) -> wgpu::TextureView {
        let usage = TextureUsages::TEXTURE_BINDING | TextureUsages::COPY_DST;
        let texture = gpu.device.create_texture(&plain_texture("given depth map", self.arrays.size, format, usage));
        let bytes_per_row = format.block_copy_size(None).map(|texel| texel * self.arrays.size[0]);
        let layout = wgpu::TexelCopyBufferLayout { offset: 0, bytes_per_row, rows_per_image: None };
        gpu.queue.write_texture(texture.as_image_copy(), bytes, layout, texture.size());
        view(&texture)
    }
}

/// A matrix for positions less `origin` as one for positions relative to the run's origin, and less the point that is
/// returned. A matrix that is for plain positions takes the run's origin in, in `f64`.
fn relative(rows: &[[f64; 4]; 4], origin: [f64; 3], run: Origin) -> ([[f64; 4]; 4], [f32; 3]) {
    if run.is_zero() || origin != [0.0; 3] {
        return (*rows, run.position(origin));
    }
    let [ox, oy, oz] = run.to_array();
    (rows.map(|[x, y, z, shift]| [x, y, z, shift + x * ox + y * oy + z * oz]), [0.0; 3])
}

/// Refuses lights that are not the map's.
pub(super) fn check_lights(
    map: &GivenMap,
    lights: &[ShadedLight],
    stage: &SceneBounds,
    origin: Origin,
) -> Result<(), UsageError> {
    /// How far a light may be off, as a share of its distance or of the extent of the models.
    const MOST: f64 = 1e-3;
    /// Extents that count as any distance beyond them, and as a light at infinity.
    const FAR: f64 = 1e9;
    let [shaded] = lights else { return Err(UsageError::DepthLights { count: lights.len() }) };
    let centre = Vec3::from(stage.centre).as_dvec3();
    // In extents from the middle of the models.
    let place = |light: &Light| {
        let towards = Vec3::from(light.xyz).as_dvec3() - f64::from(light.w) * centre;
        let distance = if light.w == 0.0 { FAR } else { towards.length() / f64::from(light.w * stage.extent) };
        towards.normalize_or_zero() * distance.min(FAR)
    };
    let (map, given) = (map.cameras.light(), shaded.light);
    let is_near = (place(&map) - place(&given)).length() <= MOST * place(&given).length().max(1.0);
    if !is_near {
        return Err(UsageError::DepthLightApart { given: spec(&given, origin), map: spec(&map, origin) });
    }
    Ok(())
}

/// A light as it is given on the command line.
fn spec(light: &Light, origin: Origin) -> String {
    let at = |w: f32| coordinates::point(light.xyz, Origin::new(origin.to_array().map(|c| f64::from(w) * c)));
    match light.w {
        0.0 => format!("dir:{}", at(0.0)),
        1.0 => format!("point:{}", at(1.0)),
        w => format!("hom:{},{w}", at(w)),
    }
}
