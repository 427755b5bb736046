//! Options for depth maps of the lights, and results in these maps.

use std::sync::Arc;

use rimline::gpu::depth_map::{DanglingEdges, DepthMapMethod, DepthMapOptions};
use rimline::{Light, Origin, wgpu};

use super::args::ShadowArgs;
use super::given_map::GivenMap;
use super::light_maps::LightCameras;
use super::posed_model::PosedModel;
use crate::failure::{Failure, UsageError};
use crate::gpu_error::GpuError;
use crate::output::note;
use crate::progress::Progress;

/// Floats tell the same part of any distance apart with reversed depth.
pub(super) const MAP: wgpu::TextureFormat = wgpu::TextureFormat::Depth32Float;

/// The request of `--from-depth` or `--depth`, `--detector` and `--dangling`.
#[derive(Clone, Debug)]
pub(crate) struct FromDepth {
    pub(crate) source: MapSource,
    pub(crate) method: DepthMapMethod,
}

/// Where maps come from.
#[derive(Clone, Debug)]
pub(crate) enum MapSource {
    /// Each light sees the models in maps of `side` texels each way.
    Drawn { side: u32 },
    /// The only light has this.
    Given(Arc<GivenMap>),
}

impl FromDepth {
    /// The depth maps that cast, if there are any, relative to the origin. Reads the file of `--depth`.
    pub(crate) fn of(args: &ShadowArgs, origin: Origin) -> Result<Option<Self>, Failure> {
        // With every cell, a given map may cast objects that are not among the models.
        let usual = if args.from_depth.is_some() { DepthMapMethod::default() } else { DepthMapMethod::EveryCell };
        let method = args.detector.unwrap_or(usual);
        let source = match (args.from_depth, &args.depth) {
            (Some(side), _) => MapSource::Drawn { side },
            (None, Some(file)) => {
                let limit = args.scene.load.memory_limit;
                MapSource::Given(Arc::new(GivenMap::read(file, method, limit, origin)?))
            }
            (None, None) => return Ok(None),
        };
        Ok(Some(Self::new(source, method, args.dangling)?))
    }

    /// Refuses what has no sensible result: six maps around a light have so near a near plane that all device depths are much the
    /// same.
    pub(crate) fn check(&self, lights: &[Light], bodies: &[PosedModel<'_>]) -> Result<(), UsageError> {
        use DepthMapMethod::{Contours, Differences, SecondDifferences};
        let MapSource::Drawn { side } = self.source else { return Ok(()) };
        if !matches!(self.method, Contours { .. } | Differences { .. } | SecondDifferences { .. }) {
            return Ok(());
        }
        let points = points(bodies);
        let is_cube = |light: &Light| LightCameras::new(light, &points, side).map_or(true, |cameras| cameras.is_cube());
        lights.iter().position(is_cube).map_or(Ok(()), |light| Err(UsageError::DetectorInCube { light }))
    }

    /// Refuses edges that are continued where none can be.
    fn new(
        source: MapSource,
        mut method: DepthMapMethod,
        continued: Option<DanglingEdges>,
    ) -> Result<Self, UsageError> {
        match &mut method {
            DepthMapMethod::Automatic { dangling }
            | DepthMapMethod::Differences { dangling, .. }
            | DepthMapMethod::SecondDifferences { dangling, .. } => *dangling = continued,
            _ if continued.is_some() => return Err(UsageError::Dangling),
            _ => {}
        }
        Ok(Self { source, method })
    }

    /// Whether walls over contours are drawn, and no triangles between samples.
    pub(super) fn has_walls(&self) -> bool {
        matches!(self.method, DepthMapMethod::Contours { .. })
    }

    pub(super) fn options(&self) -> DepthMapOptions {
        let mut options = DepthMapOptions { method: self.method, ..DepthMapOptions::default() };
        if let MapSource::Given(map) = &self.source {
            options.rounded_to = map.rounded_to;
            options.metric = map.arrays.metric;
        }
        // Outlines and objects alone are found: moved by their slopes, steep sides would leave the object (`DepthMap::objects`).
        if matches!(self.method, DepthMapMethod::Differences { threshold: 1.0, .. }) {
            options.slope_bias = 0.0;
        }
        options
    }

    pub(super) fn size(&self) -> [u32; 2] {
        match &self.source {
            MapSource::Drawn { side } => [*side; 2],
            MapSource::Given(map) => map.arrays.size,
        }
    }

    pub(crate) fn given(&self) -> Option<&GivenMap> {
        match &self.source {
            MapSource::Drawn { .. } => None,
            MapSource::Given(map) => Some(map),
        }
    }

    /// An error that a given map is the reason of, where there is one.
    pub(super) fn failed(&self, error: GpuError) -> GpuError {
        match self.given() {
            Some(map) => error.of_map(&map.file),
            None => error,
        }
    }
}

pub(super) fn points(bodies: &[PosedModel<'_>]) -> Vec<[f32; 3]> {
    bodies.iter().flat_map(PosedModel::points).collect()
}

#[derive(Clone, Copy, Debug)]
pub(crate) struct DepthFound {
    /// Maps of the light: 1 or 6.
    pub(crate) maps: usize,
    /// Cells with a triangle in the boundary of its shadow, or walls.
    pub(crate) listed: u32,
    /// Cells or walls that the list has room for. With more listed, every cell is drawn.
    pub(crate) capacity: u32,
}

impl DepthFound {
    pub(super) fn is_overflowed(self) -> bool {
        self.listed > self.capacity
    }
}

/// Cells with a border of shadow from which on drawing takes long on any device: maps of bodies have some thousands.
const BUSY: u64 = 1 << 20;

impl DepthsFound {
    /// Tells the user where maps are borders all over, such as noise: each cell bounds a volume as long as the shadow. Returns
    /// a line of progress for it.
    pub(crate) fn warn_if_busy(&self, progress: &Progress) -> Option<String> {
        let (drawn, cells) = self.busy()?;
        progress.aside(|| {
            note(&format!(
                "warning: {drawn} of the {cells} cells of the depth maps hold a border of the shadow, as if they were noise, and \
                 each is drawn through all of the picture, which may take minutes; a smaller map, a --detector that tells \
                 surfaces from noise, such as differences=T, or a smaller --size takes less"
            ));
        });
        Some(format!("drawing {drawn} borders of shadow, which takes long"))
    }

    /// Cells, or walls, that are drawn, and all cells, where it takes long.
    fn busy(&self) -> Option<(u64, u64)> {
        // Cells lie between texels, and around the outermost.
        let of_map = self.size.map(|side| u64::from(side) + 1).into_iter().product::<u64>();
        let cells: u64 = self.lights.iter().map(|found| found.maps as u64 * of_map).sum();
        // Where the list has no room, every cell is drawn.
        let drawn =
            |found: &DepthFound| if found.is_overflowed() { found.maps as u64 * of_map } else { found.listed.into() };
        let drawn = self.lights.iter().map(drawn).sum();
        (drawn > BUSY).then_some((drawn, cells))
    }
}

pub(crate) struct DepthsFound {
    pub(crate) size: [u32; 2],
    pub(crate) has_walls: bool,
    pub(crate) lights: Vec<DepthFound>,
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn maps_that_are_borders_all_over_are_busy() {
        let found = |listed, capacity, side| DepthsFound {
            size: [side; 2],
            has_walls: false,
            lights: vec![DepthFound { maps: 1, listed, capacity }],
        };
        assert_eq!(found(50_000, 100_000, 4096).busy(), None);
        assert_eq!(found(1000, 500, 512).busy(), None);
        for (listed, capacity, drawn) in [(12_000_000, 16_000_000, 12_000_000), (12_000_000, 500_000, 4097 * 4097)] {
            let busy = found(listed, capacity, 4096).busy();
            assert_eq!(busy, Some((drawn, 4097 * 4097)));
        }
    }
}
