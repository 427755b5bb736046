//! Why volumes cannot be recorded or drawn.

use crate::gpu::common::requirements::DeviceError;
use crate::shadow::{CameraError, DepthDirection};

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
    /// The pipelines are of another device, or it refuses those of walls, which are made when volumes first need them.
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
