//! Depth maps of the lights: the request, a map of the user (`--depth`), and the counts of cells or walls that were found.

use std::path::{Path, PathBuf};
use std::sync::Arc;

use glam::Vec3;
use rimline::gpu::depth_map::{DanglingEdges, DepthMapMethod, DepthMapOptions, DepthMetric};
use rimline::{CameraError, DepthDirection, Light, Origin, ShadowCamera, wgpu};
use rimline_files::npz::{self, DepthMapArrays, Depths};
use rimline_picture::{SceneBounds, ShadedLight, plain_texture, view};
use wgpu::{TextureFormat, TextureUsages};

use super::args::ShadowArgs;
use super::casting::PosedModel;
use super::light_maps::LightCameras;
use crate::device::{Gpu, GpuError};
use crate::failure::{Cause, Failure};
use crate::output::{Progress, note};
use crate::{coordinates, files};

/// The format of maps that the command draws. With reversed depth, floats have about the same relative precision at all
/// distances of a perspective map.
pub(super) const MAP: wgpu::TextureFormat = wgpu::TextureFormat::Depth32Float;

/// The request of `--from-depth` or `--depth`, `--detector` and `--dangling`.
#[derive(Clone, Debug)]
pub(crate) struct FromDepth {
    /// The map, or six, of the only light. `None`: the command draws one or six for each light.
    pub(crate) given: Option<Arc<GivenMap>>,
    pub(super) size: [u32; 2],
    pub(crate) method: DepthMapMethod,
}

impl FromDepth {
    /// The request, if there is one. Reads the file of `--depth`, with its cameras relative to `origin`.
    pub(crate) fn of(args: &ShadowArgs, origin: Origin) -> Result<Option<Self>, Failure> {
        // With every cell, objects of a given map also cast if they are not among the models.
        let usual = if args.from_depth.is_some() { DepthMapMethod::default() } else { DepthMapMethod::EveryCell };
        let method = args.detector.unwrap_or(usual);
        let (given, size) = match (args.from_depth, &args.depth) {
            (Some(side), _) => (None, [side; 2]),
            (None, Some(file)) => {
                let limit = args.scene.read.load.memory_limit;
                let map = GivenMap::read(file, method, limit, origin)?;
                let size = map.arrays.size;
                (Some(Arc::new(map)), size)
            }
            (None, None) => return Ok(None),
        };
        Ok(Some(Self { given, size, method: continued(method, args.dangling)? }))
    }

    /// Refuses detectors with thresholds for six maps around a light: their near plane is so near that all device depths
    /// are nearly equal.
    pub(crate) fn check(&self, lights: &[Light], bodies: &[PosedModel<'_>]) -> Result<(), Failure> {
        use DepthMapMethod::{Contours, Differences, SecondDifferences};
        if self.given.is_some()
            || !matches!(self.method, Contours { .. } | Differences { .. } | SecondDifferences { .. })
        {
            return Ok(());
        }
        let points = points(bodies);
        let is_cube =
            |light: &Light| LightCameras::new(light, &points, self.size[0]).map_or(true, |cameras| cameras.is_cube());
        lights.iter().position(is_cube).map_or(Ok(()), |light| {
            Err(Failure::usage(format!(
                "light {light} is among the models or close to them, so it has six depth maps, whose device \
                 depths are nearly all alike; take --detector every or automatic"
            )))
        })
    }

    /// Whether walls over contours are drawn. Triangles between samples are then drawn only if the list of walls overflows.
    pub(super) fn has_walls(&self) -> bool {
        matches!(self.method, DepthMapMethod::Contours { .. })
    }

    pub(super) fn options(&self) -> DepthMapOptions {
        let mut options = DepthMapOptions { method: self.method, ..DepthMapOptions::default() };
        if let Some(map) = &self.given {
            options.rounded_to = map.rounded_to;
            options.metric = map.arrays.metric;
        }
        // No depth difference exceeds 1, so edges come from objects and far samples only. A bias would move the boundary off
        // the steep sides of objects (`DepthMap`).
        if matches!(self.method, DepthMapMethod::Differences { threshold: 1.0, .. }) {
            options.slope_bias = 0.0;
        }
        options
    }

    /// The error, as one of the given map's file if the map is its reason.
    pub(super) fn failed(&self, error: GpuError) -> GpuError {
        match &self.given {
            Some(map) => error.of_map(&map.file),
            None => error,
        }
    }
}

/// The method with `--dangling`. Refuses it for methods that continue no edges.
fn continued(mut method: DepthMapMethod, by: Option<DanglingEdges>) -> Result<DepthMapMethod, Failure> {
    match &mut method {
        DepthMapMethod::Automatic { dangling }
        | DepthMapMethod::Differences { dangling, .. }
        | DepthMapMethod::SecondDifferences { dangling, .. } => *dangling = by,
        _ if by.is_some() => {
            return Err(Failure::usage(
                "--dangling continues edges that a detector finds; add --detector automatic, second=LOW,HIGH or \
                 differences=T",
            ));
        }
        _ => {}
    }
    Ok(method)
}

pub(super) fn points(bodies: &[PosedModel<'_>]) -> Vec<[f32; 3]> {
    bodies.iter().flat_map(PosedModel::points).collect()
}

#[derive(Clone, Copy, Debug)]
pub(crate) struct DepthFound {
    /// Maps of the light: 1 or 6.
    pub(crate) maps: usize,
    /// Cells with a triangle in the boundary of its shadow; with contours, walls and flaps.
    pub(crate) listed: u32,
    /// Entries that the list has room for. If `listed` is more, every cell is drawn.
    pub(crate) capacity: u32,
}

impl DepthFound {
    pub(super) fn is_overflowed(self) -> bool {
        self.listed > self.capacity
    }
}

/// Drawing more cells or walls than this takes long on any device. Maps of bodies have some thousands with the default
/// detector.
const BUSY: u64 = 1 << 20;

impl DepthsFound {
    /// Returns a line of progress if more than `BUSY` cells are drawn. Warns if a detector found so many, as it does for a map
    /// of noise: each bounds a volume as long as the shadow.
    pub(crate) fn warn_if_busy(&self, progress: &Progress) -> Option<String> {
        let (drawn, cells) = self.busy()?;
        if self.is_noise() {
            progress.aside(|| {
                note(&format!(
                    "warning: {drawn} of the {cells} cells of the depth maps hold a border of the shadow, as if they were \
                     noise, and each is drawn through all of the picture, which may take minutes; a smaller map, a \
                     --detector that tells surfaces from noise, such as differences=T, or a smaller --size takes less"
                ));
            });
        }
        Some(format!("drawing {drawn} borders of shadow, which takes long"))
    }

    /// Whether so many borders are found that the maps seem to be noise.
    fn is_noise(&self) -> bool {
        !self.takes_every && self.busy().is_some()
    }

    /// The numbers of drawn cells or walls, and of all cells, if drawing takes long.
    fn busy(&self) -> Option<(u64, u64)> {
        // Cells lie between texels, and of one map also around the outermost.
        let of_light = |found: &DepthFound| {
            let side = |side: u32| if found.maps == 1 { u64::from(side) + 1 } else { u64::from(side) - 1 };
            found.maps as u64 * self.size.map(side).into_iter().product::<u64>()
        };
        // If the list overflowed, every cell is drawn.
        let drawn = |found: &DepthFound| if found.is_overflowed() { of_light(found) } else { found.listed.into() };
        let drawn = self.lights.iter().map(drawn).sum();
        (drawn > BUSY).then(|| (drawn, self.lights.iter().map(of_light).sum()))
    }
}

pub(crate) struct DepthsFound {
    pub(crate) size: [u32; 2],
    /// Whether the detector takes every cell that a surface crosses.
    pub(crate) takes_every: bool,
    pub(crate) has_walls: bool,
    pub(crate) lights: Vec<DepthFound>,
}

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
        let read = || -> Result<_, Cause> {
            let arrays = npz::read_depth_map(files::archive(file, memory_limit)?, memory_limit, takes)?;
            Ok(Self::new(file, arrays, origin)?)
        };
        read().map_err(|error| Failure::input(file, error))
    }

    fn new(file: &Path, arrays: DepthMapArrays, run: Origin) -> Result<Self, String> {
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
                CameraError::Mirrored => format!(
                    "`view_projection` of map {map} makes a mirror image; change the sign of its row of x or of y, \
                     whichever runs the wrong way (clip space has x to the right and y up), and turn the rows of \
                     `depth` to match"
                ),
                error => format!(
                    "`view_projection` of map {map}: {error}; its rows make clip space of positions less `origin`, \
                     and depth is as `reversed` says"
                ),
            })?;
        }
        match cameras[..] {
            [_] => {}
            _ if size[0] != size[1] => {
                return Err(format!("six maps are square, and these have {}×{} texels", size[0], size[1]));
            }
            _ if arrays.objects.is_some() => {
                return Err("`objects` go with one map, not with six; take another detector".to_owned());
            }
            _ => {}
        }
        if *metric != DepthMetric::Device {
            if let Depths::U16(_) = depths {
                return Err(
                    "`depth` is uint16, and `metric` says that it has distances; give distances as float32, in the \
                     units of the models"
                        .to_owned(),
                );
            }
            if arrays.depth_bits.is_some() {
                return Err(
                    "`depth_bits` is that of a depth buffer, and `metric` says that `depth` has distances; leave one \
                     of them out"
                        .to_owned(),
                );
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

/// Makes a matrix for positions relative to the run's origin from one for world positions less `origin`. The result is for
/// these positions less the returned point. With `origin` 0 the run's origin is added to the matrix, in `f64`.
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
) -> Result<(), Failure> {
    /// How far a light may be off, as a share of its distance from the models, or of their extent if that is larger.
    const MOST: f64 = 1e-3;
    /// Lights farther than this many extents count as this far, and so do lights at infinity.
    const FAR: f64 = 1e9;
    let [shaded] = lights else {
        return Err(Failure::usage(format!(
            "--depth is the map of one light, and --light gives {}; give one, or none: the light is then \
             where the map was seen from",
            lights.len()
        )));
    };
    let centre = stage.models.centre().as_dvec3();
    // The position from the middle of the models, in extents.
    let position = |light: &Light| {
        let towards = Vec3::from(light.xyz).as_dvec3() - f64::from(light.w) * centre;
        let distance = if light.w == 0.0 { FAR } else { towards.length() / f64::from(light.w * stage.models.extent()) };
        towards.normalize_or_zero() * distance.min(FAR)
    };
    let (map, given) = (map.cameras.light(), shaded.light);
    let is_near = (position(&map) - position(&given)).length() <= MOST * position(&given).length().max(1.0);
    if !is_near {
        let [given, map] = [given, map].map(|light| spec(&light, origin));
        return Err(Failure::usage(format!(
            "--light is {given}, but the map of --depth was seen from {map}; give this light, or leave --light out"
        )));
    }
    Ok(())
}

/// A light as `--light` takes it.
fn spec(light: &Light, origin: Origin) -> String {
    let at = |w: f32| coordinates::point(light.xyz, Origin::new(origin.to_array().map(|c| f64::from(w) * c)));
    match light.w {
        0.0 => format!("dir:{}", at(0.0)),
        1.0 => format!("point:{}", at(1.0)),
        w => format!("hom:{},{w}", at(w)),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn maps_that_are_borders_all_over_are_busy() {
        let found = |maps, listed, capacity, side| DepthsFound {
            size: [side; 2],
            takes_every: false,
            has_walls: false,
            lights: vec![DepthFound { maps, listed, capacity }],
        };
        assert_eq!(found(1, 50_000, 100_000, 4096).busy(), None);
        assert_eq!(found(1, 1000, 500, 512).busy(), None);
        for (maps, cells) in [(1, 4097 * 4097), (6, 6 * 4095 * 4095)] {
            for (capacity, drawn) in [(16_000_000, 12_000_000), (500_000, cells)] {
                let found = found(maps, 12_000_000, capacity, 4096);
                assert_eq!(found.busy(), Some((drawn, cells)));
                assert!(found.is_noise() && !DepthsFound { takes_every: true, ..found }.is_noise());
            }
        }
    }
}
