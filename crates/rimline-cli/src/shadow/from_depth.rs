//! What is asked of depth maps of the lights, and what was found in them.

use std::sync::Arc;

use rimline::gpu::DepthEdges;
use rimline::{Light, wgpu};

use super::given_map::GivenMap;
use super::light_maps::LightCameras;
use super::posed_model::PosedModel;
use crate::failure::UsageError;
use crate::gpu_error::GpuError;

/// Floats tell the same part of any distance apart with reversed depth.
pub(super) const MAP: wgpu::TextureFormat = wgpu::TextureFormat::Depth32Float;

/// What `--from-depth` or `--depth`, and `--detector` ask for.
#[derive(Clone, Debug)]
pub(crate) struct FromDepth {
    pub(crate) source: MapSource,
    pub(crate) edges: DepthEdges,
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
    /// Refuses what has no sensible result: six maps around a light have so near a near plane that all device depths are much the same.
    pub(crate) fn check(&self, lights: &[Light], bodies: &[PosedModel<'_>]) -> Result<(), UsageError> {
        let MapSource::Drawn { side } = self.source else { return Ok(()) };
        if !matches!(self.edges, DepthEdges::Differences { .. }) {
            return Ok(());
        }
        let points = points(bodies);
        let is_cube = |light: &Light| matches!(LightCameras::new(light, &points, side), LightCameras::Cube(_));
        lights.iter().position(is_cube).map_or(Ok(()), |light| Err(UsageError::DetectorInCube { light }))
    }

    /// Texels of a map across and down.
    pub(super) fn size(&self) -> [u32; 2] {
        match &self.source {
            MapSource::Drawn { side } => [*side; 2],
            MapSource::Given(map) => map.size,
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

/// What was found in the maps of a light.
#[derive(Clone, Copy, Debug)]
pub(crate) struct DepthFound {
    /// Maps of the light: 1 or 6.
    pub(crate) maps: usize,
    /// Cells with a triangle in the boundary of its shadow.
    pub(crate) cells: u32,
}

/// What was found in the maps of all lights.
pub(crate) struct DepthsFound {
    /// Texels of a map across and down.
    pub(crate) size: [u32; 2],
    pub(crate) lights: Vec<DepthFound>,
}
