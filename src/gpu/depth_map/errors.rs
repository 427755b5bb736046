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

/// A texture that an encode takes.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[non_exhaustive]
pub enum DepthMapTexture {
    /// The map.
    Map,
    /// The objects of the map.
    Objects,
    /// The map of a cube with this number, in the order of the cameras, from 0.
    CubeMap(usize),
    /// The objects of that map.
    CubeObjects(usize),
    /// The map of a merge with this number, 0 or 1.
    MergedMap(usize),
}

impl std::fmt::Display for DepthMapTexture {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        match self {
            Self::Map => f.write_str("the map"),
            Self::Objects => f.write_str("the texture of objects"),
            Self::CubeMap(face) => write!(f, "map {face} of the cube"),
            Self::CubeObjects(face) => write!(f, "the texture of objects of map {face} of the cube"),
            Self::MergedMap(number) => write!(f, "map {number} of the merge"),
        }
    }
}

fn of_face(face: Option<usize>) -> String {
    let with = || " (`encode_objects`, or `objects` of a caster)".to_owned();
    face.map_or_else(with, |face| format!(" for map {face} of the cube, too"))
}

impl DepthMapTexture {
    /// Which size it has to have.
    fn size_needed(self) -> &'static str {
        match self {
            Self::Map => "give a map of the size of `DepthMapVolumes::new`, or make volumes of this one",
            Self::Objects => "give objects of the size of `DepthMapVolumes::new`, one for each texel of the map",
            Self::CubeMap(_) => "give six maps of the `side` of `DepthMapCube::new`, or make a cube of this one",
            Self::CubeObjects(_) => "give objects of the `side` of `DepthMapCube::new`, one for each texel of the map",
            Self::MergedMap(_) => "give two maps of the size of `DepthMapMerge::new`",
        }
    }

    /// Which formats it may have.
    fn formats(self) -> &'static str {
        match self {
            Self::Objects | Self::CubeObjects(_) => "no format of objects; take R32Uint",
            Self::Map | Self::CubeMap(_) | Self::MergedMap(_) => {
                "no format of a depth map; take Depth16Unorm, Depth24Plus, Depth32Float, or R32Float"
            }
        }
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
        "rounding put the far plane of the map's camera behind infinity; use a projection without a far plane, or a larger near \
         distance"
    )]
    FarPlane,
    /// A texture is of another size than the volumes, or the merge, were made for.
    #[error(
        "{texture} has {} × {} texels, and {} × {} are needed; {}",
        .given[0], .given[1], .made[0], .made[1], .texture.size_needed()
    )]
    Size {
        /// Which texture.
        texture: DepthMapTexture,
        /// Its size.
        given: [u32; 2],
        /// The size that is needed.
        made: [u32; 2],
    },
    /// A texture holds no depths that are known, or no objects.
    #[error("{texture} has {format:?}, which is {}", .texture.formats())]
    Format {
        /// Which texture.
        texture: DepthMapTexture,
        /// Its format.
        format: wgpu::TextureFormat,
    },
    /// A texture cannot be read.
    #[error("{texture} has {samples} samples a texel; resolve it, or render it with one")]
    Samples {
        /// Which texture.
        texture: DepthMapTexture,
        /// Its samples.
        samples: u32,
    },
    /// A texture has several levels. wgpu does not tell which of them a view shows, and so of which size it is.
    #[error("{texture} has {levels} mip levels; give a texture of one, for example a copy of that level")]
    MipLevels {
        /// Which texture.
        texture: DepthMapTexture,
        /// Its levels.
        levels: u32,
    },
    /// A texture lacks a usage.
    #[error("{0} lacks usage TEXTURE_BINDING; make the texture with it")]
    Usage(DepthMapTexture),
    /// The depth at infinity is too far from the range of depths.
    #[error(
        "near and far plane of the map's camera are within a thousandth of each other; move them apart for a threshold in world \
         units"
    )]
    NearFar,
    /// The texture of objects is missing.
    #[error("the options say `objects`; give a texture of them{}", of_face(*.face))]
    NoObjects {
        /// The map of a cube that lacks it. `None`: there is one map, or no texture was given at all.
        face: Option<usize>,
    },
    /// The texture of objects would not be read.
    #[error("the options do not say `objects`; set it to true, or give no texture of them")]
    UnusedObjects,
    /// The map is the result that is written.
    #[error("a map is the result of the same merge or conversion; give it to another one")]
    OwnResult,
    /// The texture holds no distances.
    #[error("{0:?} is no format of distances; take R32Float, or `DepthMetric::Device` for device depths")]
    DistanceFormat(wgpu::TextureFormat),
    /// Distances cannot be told apart in the map's range of depths.
    #[error(
        "distances are not converted for a camera with its near plane at {near} and its far plane at {far}, or as wide or as \
         far aside; the planes are from 2⁻¹⁰⁰ to 2¹⁰⁰ units away and not within a thousandth of each other, and rays at most 1000 times longer than the \
         way along the axis"
    )]
    Distances {
        /// Distance of the near plane, as the metric has it.
        near: f64,
        /// Distance of the far plane.
        far: f64,
    },
    /// The device refuses to bind the texture.
    #[error(
        "the device refuses the textures: {message}; give two-dimensional views of one layer and aspect, on the device of the \
         volumes"
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
    /// The formats of depth differ, and so does what the boundary is moved by.
    #[error(
        "the volumes were made for an eye's depth of {volumes:?}, and the pipelines have {pipelines:?}; use the same \
         `ShadowFormat::depth_stencil`"
    )]
    DepthFormat {
        /// Format of the pipelines that the volumes were made with.
        volumes: wgpu::TextureFormat,
        /// Format of the pipelines.
        pipelines: wgpu::TextureFormat,
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
