//! Why volumes from depth maps cannot be made, recorded or drawn.

use crate::gpu::common::memory::MemoryError;
use crate::gpu::common::positions::PositionError;
use crate::gpu::common::requirements::DeviceError;
use crate::gpu::scene::errors::SceneError;
use crate::gpu::shadow::ShadowFormatError;
use crate::shadow::{CameraError, DepthDirection};

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
    #[error("the stencil has bits 0 to 7, and `bits` are from {} to {} without the latter; take at least one of them", .0.start, .0.end)]
    Bits(std::ops::Range<u32>),
    /// Volumes of meshes count in the bit.
    #[error(
        "bit {bit} of the stencil is one of the {count_bits} that counts own (`ShadowFormat::count_bits`); take a higher one for parity, or \
         fewer for counts"
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
    #[error("the device has textures of up to {most} texels a side, and {size:?} are needed")]
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
        "the thresholds of `DepthEdges::SecondDifferences` are {low} and {high}; device depth differs by 0 to 1, and `low` is at most `high`"
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
        "`DepthMapReconstruction::Contours` with `dangling` edges; leave `dangling` out, or take `DepthMapReconstruction::Triangles`"
    )]
    ContourDangling,
    /// A segment cannot be as far from its contour.
    #[error("`sideways` of `DepthMapReconstruction::Contours` is {0}; take 0 to 0.5 texels")]
    Sideways(f32),
    /// A wall cannot be as far from its surfaces.
    #[error("`depth` of `DepthMapReconstruction::Contours` is {0}; device depth differs by 0 to 1")]
    ContourDepth(f32),
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

/// Why volumes of a cube cannot be made.
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
        "map {face} does not meet the others: {what}; take the cameras of `DepthMapCube::cameras`, or turn them all together"
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

/// Why volumes cannot be recorded.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
#[non_exhaustive]
pub enum DepthMapEncodeError {
    /// The device is lost, or is not the timer's device.
    #[error(transparent)]
    Device(#[from] DeviceError),
    /// The camera is refused.
    #[error("the eye: {0}")]
    Camera(CameraError),
    /// The camera of the map is refused.
    #[error("the light of the map: {0}")]
    Light(CameraError),
    /// Some depths of the map lie behind infinity.
    #[error(
        "rounding put the far plane of the map's camera behind infinity; use a projection without a far plane, or a larger near distance"
    )]
    FarPlane,
    /// The texture is of another size than the volumes were made for.
    #[error("the map has {given:?} texels, and the volumes were made for {made:?}; make volumes of this size")]
    Size {
        /// Size of the texture.
        given: [u32; 2],
        /// Size given to [`DepthMapVolumes::new`](crate::gpu::DepthMapVolumes::new).
        made: [u32; 2],
    },
    /// The texture holds no depths that are known.
    #[error("{0:?} is no format of a depth map; take Depth16Unorm, Depth24Plus, Depth32Float, or R32Float")]
    Format(wgpu::TextureFormat),
    /// The texture cannot be read.
    #[error("the map's texture has {0} samples a texel; resolve it, or render the map with one")]
    Samples(u32),
    /// The depth at infinity is too far from the range of depths.
    #[error(
        "near and far plane of the map's camera are within a thousandth of each other; move them apart for a threshold in world units"
    )]
    NearFar,
    /// The texture of objects is missing.
    #[error("the options say `objects`; take `encode_objects`, with a texture of them")]
    NoObjects,
    /// The texture of objects would not be read.
    #[error("the options do not say `objects`; set it to true, or take `encode`")]
    UnusedObjects,
    /// The texture holds no objects.
    #[error("{0:?} is no format of objects; take R32Uint")]
    ObjectFormat(wgpu::TextureFormat),
    /// The map is the result that is written.
    #[error("a map is the result of the same merge or conversion; give it to another one")]
    OwnResult,
    /// The texture holds no distances.
    #[error("{0:?} is no format of distances; take R32Float, or `DepthMetric::Device` for device depths")]
    DistanceFormat(wgpu::TextureFormat),
    /// Distances cannot be told apart in the map's range of depths.
    #[error(
        "distances are not converted for a camera with its near plane at {near} and its far plane at {far}, or as wide or as far aside; the \
         planes are from 2⁻¹⁰⁰ to 2¹⁰⁰ units away and not within a thousandth of each other, and rays at most 1000 times longer than the \
         way along the axis"
    )]
    Distances {
        /// Distance of the near plane, as the metric has it.
        near: f64,
        /// Distance of the far plane.
        far: f64,
    },
    /// The texture lacks a usage.
    #[error("the map's texture lacks usage TEXTURE_BINDING")]
    Usage,
    /// The device refuses to bind the texture.
    #[error(
        "the device refuses the map's texture: {message}; give a two-dimensional view of one level, layer and aspect, on the device of the volumes"
    )]
    Refused {
        /// The message of the device.
        message: String,
    },
    /// The depth directions of camera and pipelines differ.
    #[error(
        "the eye's depth is {camera:?}, and the pipelines have {pipelines:?}; set `ShadowFormat::depth` to the camera's"
    )]
    Depth {
        /// Depth direction of the camera.
        camera: DepthDirection,
        /// Depth direction of the pipelines.
        pipelines: DepthDirection,
    },
}

/// Why volumes cannot be drawn.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
#[non_exhaustive]
pub enum DepthMapDrawError {
    /// The pipelines are of another device.
    #[error(transparent)]
    Device(#[from] DeviceError),
    /// The depth directions of volumes and pipelines differ.
    #[error(
        "the volumes were encoded for {volumes:?} depth, and the pipelines have {pipelines:?}; use the same `ShadowFormat::depth`"
    )]
    Depth {
        /// Depth direction of the volumes.
        volumes: DepthDirection,
        /// Depth direction of the pipelines.
        pipelines: DepthDirection,
    },
    /// The numbers of bits differ.
    #[error(
        "the volumes were made with {volumes} bits, and the pipelines have {pipelines}; use the same `DepthMapOptions::bits`"
    )]
    Bits {
        /// Bits of the volumes' options.
        volumes: u32,
        /// Bits of the pipelines.
        pipelines: u32,
    },
    /// Walls are not counted.
    #[error(
        "the volumes have walls (`DepthMapReconstruction::Contours`), and the pipelines count; take `DepthMapPipelines::new`, or \
         `DepthMapReconstruction::Triangles`"
    )]
    CountedWalls,
    /// A later encode overwrites what is drawn.
    #[error(
        "a later encode of these volumes overwrites this frame; draw a frame before the next encode, or make further volumes"
    )]
    StaleFrame,
}

/// Why the depth of a mesh cannot be drawn into a depth map.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
#[non_exhaustive]
pub enum MeshDepthError {
    /// The device lacks what the draw needs, or is lost.
    #[error(transparent)]
    Device(#[from] DeviceError),
    /// The positions cannot be read.
    #[error(transparent)]
    Positions(#[from] PositionError),
    /// The light's camera is refused.
    #[error(transparent)]
    Light(#[from] CameraError),
    /// The format holds no depth.
    #[error("{0:?} has no depth; take a depth format, such as Depth32Float")]
    Format(wgpu::TextureFormat),
    /// One draw cannot have so many vertices.
    #[error("the mesh has {0} faces, and one draw has at most 1,431,655,765; divide the mesh")]
    Faces(usize),
    /// The device refuses a buffer, a pipeline or a bind group.
    #[error("the device refuses to draw the depth of a mesh: {message}")]
    Refused {
        /// The message of the device.
        message: String,
    },
    /// The depth directions of light and pipeline differ.
    #[error("the light's depth is {light:?}, and this was made for {made:?}; give `MeshDepth::new` the light's")]
    Depth {
        /// Depth direction of the light.
        light: DepthDirection,
        /// Depth direction given to [`MeshDepth::new`](crate::gpu::MeshDepth::new).
        made: DepthDirection,
    },
}

/// Why the depth of the casters of a scene cannot be drawn into a depth map.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
#[non_exhaustive]
pub enum SceneDepthError {
    /// The device lacks what the draw needs, or is lost.
    #[error(transparent)]
    Device(#[from] DeviceError),
    /// A handle is of another scene, or names what was removed.
    #[error(transparent)]
    Scene(#[from] SceneError),
    /// The light's camera is refused.
    #[error(transparent)]
    Light(#[from] CameraError),
    /// What is drawn together does not fit one binding.
    #[error(transparent)]
    Memory(#[from] MemoryError),
    /// The format holds no depth.
    #[error("{0:?} has no depth; take a depth format, such as Depth32Float")]
    Format(wgpu::TextureFormat),
    /// The device refuses a buffer, a pipeline or a bind group.
    #[error(
        "the device refuses to draw the depth of a scene: {message}; the scene must be on the same device, and its buffers not destroyed"
    )]
    Refused {
        /// The message of the device.
        message: String,
    },
    /// The depth directions of light and pipeline differ.
    #[error("the light's depth is {light:?}, and this was made for {made:?}; give `SceneDepth::new` the light's")]
    Depth {
        /// Depth direction of the light.
        light: DepthDirection,
        /// Depth direction given to [`SceneDepth::new`](crate::gpu::SceneDepth::new).
        made: DepthDirection,
    },
}
