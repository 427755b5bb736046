//! Why pipelines and volumes cannot be made.

use crate::gpu::common::memory::MemoryError;
use crate::gpu::common::requirements::DeviceError;
use crate::gpu::shadow::ShadowFormatError;
use crate::shadow::CameraError;

/// Why pipelines cannot be made.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
#[non_exhaustive]
pub enum DepthMapPipelinesError {
    /// The device lacks what the volumes need, is lost, or cannot draw into the attachments.
    #[error(transparent)]
    Format(#[from] ShadowFormatError),
    /// There is no such bit in the stencil.
    #[error("the stencil has bits 0 to 7, and `bit` is {0}")]
    Bit(u32),
    /// There are no such bits in the stencil.
    #[error(
        "the stencil has bits 0 to 7, and `bits` are from {} to {} without the latter; take at least one of them",
        .0.start, .0.end
    )]
    Bits(std::ops::Range<u32>),
    /// Volumes of meshes count in the bit.
    #[error(
        "bit {bit} of the stencil is one of the {count_bits} that counts own (`ShadowFormat::count_bits`); take a higher one \
         for parity, or let counts own fewer, in the format of all pipelines and in `SceneOptions::count_bits`"
    )]
    Counted {
        /// The lowest bit given.
        bit: u32,
        /// Low bits that counts own.
        count_bits: u32,
    },
}

impl From<DeviceError> for DepthMapPipelinesError {
    fn from(error: DeviceError) -> Self {
        Self::Format(error.into())
    }
}

/// Why volumes cannot be made.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
#[non_exhaustive]
pub enum DepthMapVolumesError {
    /// The device lacks what the volumes need, or is lost.
    #[error(transparent)]
    Device(#[from] DeviceError),
    /// The buffers do not fit the device.
    #[error(transparent)]
    Memory(#[from] MemoryError),
    /// The map has no texel, or too many.
    #[error(
        "a map of {0} × {1} texels cannot be taken; it has at least one texel, and at most 2²⁹ cells: (width + 1) × (height + 1)"
    )]
    Size(u32, u32),
    /// The device has no texture of this size.
    #[error(
        "the device has textures of up to {most} texels a side, and one of {} × {} is needed; take a smaller map, or a device \
         with a larger `max_texture_dimension_2d`",
        .size[0], .size[1]
    )]
    Texture {
        /// Texels that the texture needs.
        size: [u32; 2],
        /// Largest side of textures on the device.
        most: u32,
    },
    /// No map is rounded to the format.
    #[error(
        "`rounded_to` is {0:?}, which is no format of a depth map; take Depth16Unorm, Depth24Plus, Depth32Float, or R32Float"
    )]
    RoundedTo(wgpu::TextureFormat),
    /// The threshold is no depth.
    #[error("the threshold of `DepthEdges::Differences` is {0}; device depth differs by 0 to 1")]
    Threshold(f32),
    /// The threshold is no distance.
    #[error("the threshold of `DepthEdges::WorldDifferences` is {0}; take a finite distance that is not negative")]
    WorldThreshold(f32),
    /// The thresholds of second differences are no depths.
    #[error(
        "the thresholds of `DepthEdges::SecondDifferences` are {low} and {high}; device depth differs by 0 to 1, and `low` is at \
         most `high`"
    )]
    SecondThresholds {
        /// The lower threshold.
        low: f32,
        /// The higher one.
        high: f32,
    },
    /// Edges would be continued by no threshold, or by too many cells.
    #[error("`dangling` is a share of {share} and {cells} cells; take a share from 0 to 1, and 1 to 64 cells")]
    Dangling {
        /// Part of the thresholds that is left.
        share: f32,
        /// Cells by which edges are continued.
        cells: u32,
    },
    /// No edge is left to be found.
    #[error(
        "`{0}` with `DepthEdges::EveryCell`, which takes every edge already; leave `{0}` out, or take another detector"
    )]
    EveryCell(&'static str),
    /// The stencil has not as many bits.
    #[error("`bits` is {0}; the stencil has 8, so take 1 to 8")]
    Bits(u32),
    /// Contours need a threshold of depths.
    #[error("`DepthMapReconstruction::Contours` with {0:?}; take `DepthEdges::Differences` or `DepthEdges::Outlines`")]
    ContourEdges(super::options::DepthEdges),
    /// Contours have one bit.
    #[error("`DepthMapReconstruction::Contours` with {0} bits; take 1, or `DepthMapReconstruction::Triangles`")]
    ContourBits(u32),
    /// Contours continue no edge.
    #[error(
        "`DepthMapReconstruction::Contours` with `dangling` edges; leave `dangling` out, or take \
         `DepthMapReconstruction::Triangles`"
    )]
    ContourDangling,
    /// A segment cannot be as far from its contour.
    #[error("`sideways` of `DepthMapReconstruction::Contours` is {0}; take 0 to 0.5 texels")]
    Sideways(f32),
    /// A wall cannot be as far from its surfaces.
    #[error("`depth` of `DepthMapReconstruction::Contours` is {0}; device depth differs by 0 to 1")]
    ContourDepth(f32),
    /// Contours cannot calculate with so large a bias.
    #[error(
        "`slope_bias` is {0}; with `DepthMapReconstruction::Contours` it is at most {most}",
        most = super::contours::MOST_SLOPE_BIAS
    )]
    ContourBias(f32),
    /// The bias would move the surface towards the light, or nowhere.
    #[error("`slope_bias` is {0}; take a finite number that is not negative")]
    Bias(f32),
}

/// In what the map of a cube differs from its neighbours.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[non_exhaustive]
pub enum CubeMismatch {
    /// Its depth direction.
    Direction,
    /// The angle that it sees.
    Width,
    /// Where it looks, or what is up.
    Axes,
    /// The place of the light.
    Place,
    /// Its near or far distance, or the scale of its matrix.
    Depths,
}

impl std::fmt::Display for CubeMismatch {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        f.write_str(match self {
            Self::Direction => "its depth direction differs",
            Self::Width => "the middles of its outermost texels are not 45° from its middle",
            Self::Axes => "it does not look along its axis of the cube, or is turned",
            Self::Place => "it is at another place",
            Self::Depths => "its near or far distance, or the scale of its matrix, differs",
        })
    }
}

/// Why volumes of a cube, or its cameras, cannot be made.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
#[non_exhaustive]
pub enum DepthMapCubeError {
    /// Maps of a cube take triangles.
    #[error("`DepthMapReconstruction::Contours` of a cube; take `DepthMapReconstruction::Triangles`")]
    Contours,
    /// As for volumes of one map.
    #[error(transparent)]
    Volumes(#[from] DepthMapVolumesError),
    /// The maps are too small.
    #[error("maps of a cube have at least 3 texels a side, and `side` is {0}")]
    Side(u32),
    /// There are too many cells.
    #[error(
        "six maps of {0} × {0} texels have more than the 2²⁹ cells that volumes can have, 6 · (side − 1)²; take a `side` of at \
         most 9,459"
    )]
    Cells(u32),
    /// The place of the light is none.
    #[error("the light is at {0:?}; take finite coordinates")]
    Place([f32; 3]),
    /// The near plane is nowhere before the light.
    #[error("`near` is {0}; take a finite distance above 0")]
    Near(f32),
    /// The far plane is not behind the near plane.
    #[error("`far` is {far} and `near` {near}; take a finite distance above `near`, or `None` for no far plane")]
    Far {
        /// The distance of the near plane.
        near: f32,
        /// That of the far plane.
        far: f32,
    },
    /// A camera is refused.
    #[error("the light of map {face}: {error}")]
    Light {
        /// Number of the map.
        face: usize,
        /// Why.
        error: CameraError,
    },
    /// A camera is orthographic.
    #[error("the camera of map {face} is orthographic; a light in a cube is at a place")]
    Parallel {
        /// Number of the map.
        face: usize,
    },
    /// Each map would be moved along its own axes, and leave the others.
    #[error("`bits` is {0}; a cube takes one")]
    Bits(u32),
    /// A map does not meet its neighbours.
    #[error(
        "map {face} does not meet the others: {what}; take the cameras of `DepthMapCube::cameras`, or turn them all \
         together"
    )]
    Apart {
        /// Number of the map.
        face: usize,
        /// In what it differs.
        what: CubeMismatch,
    },
}

impl From<DeviceError> for DepthMapCubeError {
    fn from(error: DeviceError) -> Self {
        Self::Volumes(error.into())
    }
}
