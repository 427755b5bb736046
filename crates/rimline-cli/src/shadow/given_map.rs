//! A depth map that the caller made: `--depth`.

use std::path::{Path, PathBuf};

use rimline::gpu::depth_map::{DepthMapMethod, DepthMetric};
use rimline::{CameraError, DepthDirection, Light, Origin, ShadowCamera, wgpu};
use wgpu::{TextureFormat, TextureUsages};

use super::given_map_error::GivenMapError;
use super::light_maps::LightCameras;
use crate::device::Gpu;
use crate::failure::{Failure, InputError};
use crate::npz::{self, DepthMapArrays, Depths, Metric};
use crate::render::pipeline_factory::{plain_texture, view};
use crate::{begins, source};

/// A map, or six, with what they were drawn with.
#[derive(Debug)]
pub(crate) struct GivenMap {
    pub(crate) file: PathBuf,
    pub(super) size: [u32; 2],
    pub(super) cameras: LightCameras,
    depths: Depths,
    /// For each texel of one map, if the detector takes them.
    objects: Option<Vec<u32>>,
    /// A format that the depths were rounded to, coarser than their own.
    pub(super) rounded_to: Option<TextureFormat>,
    /// Meaning of the depths.
    pub(super) metric: DepthMetric,
}

impl GivenMap {
    /// `objects` are read only if the detector takes them.
    pub(super) fn read(
        file: &Path,
        method: DepthMapMethod,
        memory_limit: u64,
        origin: Origin,
    ) -> Result<Self, Failure> {
        let takes = method != DepthMapMethod::EveryCell;
        let read = || -> Result<_, InputError> {
            let arrays = npz::read_depth_map(begins::archive(source::open(file)?)?, memory_limit, takes)?;
            Ok(Self::new(file, arrays, origin)?)
        };
        read().map_err(Failure::input(file))
    }

    fn new(file: &Path, arrays: DepthMapArrays, run: Origin) -> Result<Self, GivenMapError> {
        let DepthMapArrays { size, depths, view_projections, origin, is_reversed, depth_bits, metric, objects } =
            arrays;
        let depth = if is_reversed { DepthDirection::Reversed } else { DepthDirection::Standard };
        let camera = |rows: &[[f64; 4]; 4]| {
            let (rows, origin) = relative(rows, origin, run);
            let view_projection = [0, 1, 2, 3].map(|column| rows.map(|row| row[column] as f32));
            ShadowCamera { view_projection, origin, depth }
        };
        let cameras: Vec<ShadowCamera> = view_projections.iter().map(camera).collect();
        for (map, camera) in cameras.iter().enumerate() {
            camera.check().map_err(|error| match error {
                CameraError::Mirrored => GivenMapError::Mirrored { map },
                error => GivenMapError::Camera { map, error },
            })?;
        }
        let cameras = match (<[ShadowCamera; 6]>::try_from(cameras.as_slice()), &cameras[..]) {
            (Ok(_), _) if size[0] != size[1] => return Err(GivenMapError::NotSquare(size)),
            (Ok(_), _) if objects.is_some() => return Err(GivenMapError::ObjectsOfCube),
            (Ok(cube), _) => LightCameras::Cube(Box::new(cube)),
            (Err(_), [camera, ..]) => LightCameras::One(*camera),
            (Err(_), []) => return Err(GivenMapError::Camera { map: 0, error: CameraError::Singular }),
        };
        let metric = match metric {
            Metric::Device => DepthMetric::Device,
            Metric::AlongAxis => DepthMetric::AlongAxis,
            Metric::AlongRay => DepthMetric::AlongRay,
        };
        if metric != DepthMetric::Device {
            if let Depths::U16(_) = depths {
                return Err(GivenMapError::DistanceType);
            }
            if depth_bits.is_some() {
                return Err(GivenMapError::DistanceBits);
            }
        }
        let rounded_to = match (depth_bits, &depths) {
            (Some(16), Depths::F32(_)) => Some(TextureFormat::Depth16Unorm),
            (Some(24), Depths::F32(_)) => Some(TextureFormat::Depth24Plus),
            _ => None,
        };
        Ok(Self { file: file.to_owned(), size, cameras, depths, objects, rounded_to, metric })
    }

    /// Copies the maps into textures, one for each.
    pub(super) fn upload(&self, gpu: &Gpu) -> Vec<wgpu::TextureView> {
        let texels = self.size[0] as usize * self.size[1] as usize;
        let (format, bytes, size) = match &self.depths {
            Depths::F32(depths) => (TextureFormat::R32Float, bytemuck::cast_slice(depths), 4),
            Depths::U16(depths) => (TextureFormat::Depth16Unorm, bytemuck::cast_slice::<_, u8>(depths), 2),
        };
        bytes.chunks(size * texels).map(|map| self.texture(gpu, format, map)).collect()
    }

    pub(super) fn upload_objects(&self, gpu: &Gpu) -> Option<wgpu::TextureView> {
        let objects = self.objects.as_ref()?;
        Some(self.texture(gpu, TextureFormat::R32Uint, bytemuck::cast_slice(objects)))
    }

    fn texture(&self, gpu: &Gpu, format: TextureFormat, bytes: &[u8]) -> wgpu::TextureView {
        let usage = TextureUsages::TEXTURE_BINDING | TextureUsages::COPY_DST;
        let texture = gpu.device.create_texture(&plain_texture("given depth map", self.size, format, usage));
        let bytes_per_row = format.block_copy_size(None).map(|texel| texel * self.size[0]);
        let layout = wgpu::TexelCopyBufferLayout { offset: 0, bytes_per_row, rows_per_image: None };
        gpu.queue.write_texture(texture.as_image_copy(), bytes, layout, texture.size());
        view(&texture)
    }

    /// The light that the map is of.
    pub(crate) fn light(&self) -> Light {
        self.cameras.light()
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
