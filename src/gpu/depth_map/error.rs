//! Errors of depth maps.

use std::ops::Range;

use crate::gpu::common::device_error::{DeviceError, contain};
use crate::gpu::common::memory::any_error;
use crate::gpu::shadow::errors::ShadowError;
use crate::shadow::{CameraError, DepthDirection};

/// Why a depth map, its volumes or its pipelines cannot be made, recorded or drawn.
///
/// `map` names a texture: the map, its objects, one map of a cube or of a merge, or the objects of a cube's map.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
#[non_exhaustive]
#[allow(missing_docs, reason = "the messages say what fields are")]
pub enum DepthMapError {
    /// The device lacks something, is lost, or is another one. Or buffers or textures do not fit it, or the positions of a
    /// mesh cannot be read.
    #[error(transparent)]
    Device(#[from] DeviceError),
    /// The attachments or their counting bits are refused, or the device refuses pipelines for them. Or a handle is of another
    /// scene or was removed.
    #[error(transparent)]
    Shadow(ShadowError),
    /// The camera of the eye is refused.
    #[error("the eye: {0}")]
    Camera(CameraError),
    /// The camera of a map is refused.
    #[error("the light of the map: {0}")]
    Light(#[from] CameraError),
    /// The device refuses a texture, a pipeline or a bind group.
    #[error(
        "the device refuses a resource of depth maps: {message}; give two-dimensional views of one layer and aspect, and \
         buffers that are not destroyed, all on the same device"
    )]
    Refused { message: String },
    /// Two things that are used together have different depth directions.
    #[error("{what} has {given:?} depth, and {made:?} is needed; give both the same `DepthDirection`")]
    Depth { what: &'static str, given: DepthDirection, made: DepthDirection },

    /// The range of bits is empty, or the stencil has no such bits.
    #[error(
        "the stencil has bits 0 to 7, and `bits` are from {} to {} without the latter; take at least one of them",
        .0.start, .0.end
    )]
    Bits(Range<u32>),
    /// The bit is one of those in which volumes of meshes count.
    #[error(
        "bit {bit} of the stencil is one of the {count_bits} bits of counts (`ShadowFormat::count_bits`); take a higher bit \
         for parity, or fewer bits of counts, in the format of all pipelines and in `SceneOptions::stencil`"
    )]
    Counted { bit: u32, count_bits: u32 },

    /// The map has no texel, or too many.
    #[error(
        "a map of {0} × {1} texels is refused; a map has at least one texel, and at most 2²⁹ cells: \
         (width + 1) × (height + 1)"
    )]
    Size(u32, u32),
    /// The device has no texture of this size.
    #[error(
        "the device has textures of up to {max_side} texels a side, and one of {} × {} is needed; take a smaller map, \
         or a device with a larger `max_texture_dimension_2d`",
        .size[0], .size[1]
    )]
    Texture { size: [u32; 2], max_side: u32 },
    /// A value of [`DepthMapOptions`](crate::gpu::depth_map::DepthMapOptions), its method or a cube is out of range.
    #[error("`{name}` is {given}; take {range}")]
    Option { name: &'static str, given: f32, range: &'static str },
    /// `rounded_to` is not a format of maps.
    #[error(
        "`rounded_to` is {0:?}, which is not a format of depth maps; take Depth16Unorm, Depth24Plus, Depth32Float, \
         or R32Float"
    )]
    RoundedTo(wgpu::TextureFormat),
    /// Contours and cubes need pipelines of one bit.
    #[error("pipelines of {0} bits; contours and cubes take those of one bit")]
    OneBit(u32),
    /// A cube cannot have contours.
    #[error("`DepthMapMethod::Contours` of a cube; take another method")]
    CubeContours,

    /// The maps of a cube are too small.
    #[error("maps of a cube have at least 3 texels a side, and `side` is {0}")]
    Side(u32),
    /// The maps of a cube have too many cells.
    #[error(
        "six maps of {0} × {0} texels have more than the 2²⁹ cells that volumes can have, 6 · (side − 1)²; take a `side` of at \
         most 9,460"
    )]
    Cells(u32),
    /// The position of the light of a cube is not finite.
    #[error("the light is at {0:?}; take finite coordinates")]
    Position([f32; 3]),
    /// The far distance is not above the near distance, or not finite.
    #[error("`far` is {far} and `near` {near}; take a finite distance above `near`, or `None` for no far plane")]
    Far { near: f32, far: f32 },
    /// A camera of a cube is refused.
    #[error("the light of map {face}: {error}")]
    CubeLight { face: usize, error: CameraError },
    /// A camera of a cube is orthographic.
    #[error("the camera of map {face} is orthographic; a light in a cube has a position")]
    Parallel { face: usize },
    /// A map of a cube does not meet its neighbours.
    #[error(
        "map {face} does not meet the others: {what}; take the cameras of `DepthMapCube::cameras`, or rotate them all \
         together"
    )]
    Apart { face: usize, what: &'static str },

    /// A texture does not have the size that was given to `new`.
    #[error(
        "{map} has {} × {} texels, and {} × {} are needed; give textures of the size that was given to `new`, \
         or call `new` again",
        .given[0], .given[1], .made[0], .made[1]
    )]
    MapSize { map: String, given: [u32; 2], made: [u32; 2] },
    /// A texture has a format that is not accepted.
    #[error("{map} has {format:?}; take {accepted}")]
    MapFormat { map: String, format: wgpu::TextureFormat, accepted: &'static str },
    /// A texture has several samples a texel.
    #[error("{map} has {samples} samples a texel; resolve it, or render it with one")]
    Samples { map: String, samples: u32 },
    /// A texture has several levels. wgpu does not say which one a view shows.
    #[error("{map} has {levels} mip levels; give a texture of one, for example a copy of that level")]
    MipLevels { map: String, levels: u32 },
    /// A texture lacks a usage.
    #[error("{0} lacks usage TEXTURE_BINDING; make the texture with it")]
    Usage(String),
    /// A map of a cube has no objects, and another has.
    #[error("map {face} of the cube has no texture of objects; give one for each map that is there, or none")]
    NoObjects { face: usize },
    /// The map is the result that is written.
    #[error("a map is the result of the same merge or conversion; give it to another one")]
    MapIsResult,
    /// The far plane of a map's camera is, at a corner of the map, at infinity or behind it.
    #[error(
        "rounding put the far plane of the map's camera behind infinity; use a projection without a far plane, or a larger near \
         distance"
    )]
    FarPlane,
    /// The camera is out of the range for which distances are converted. `near` and `far` are distances along its axis. Those
    /// of an orthographic camera are in the metric, from the near plane.
    #[error(
        "distances are not converted for a camera with its near plane at {near} and its far plane at {far}, or as wide or as \
         far aside; the planes are from 2⁻¹⁰⁰ to 2¹⁰⁰ units away and not within a thousandth of each other, and rays at most 1000 \
         times longer than the way along the axis"
    )]
    Distances { near: f64, far: f64 },

    /// The formats of the eye's depth differ, so the bias of the boundary is wrong.
    #[error(
        "the volumes were made for an eye's depth of {volumes:?}, and the pipelines have {pipelines:?}; use the same \
         `ShadowFormat::depth_stencil`"
    )]
    DepthFormat { volumes: wgpu::TextureFormat, pipelines: wgpu::TextureFormat },
    /// The counts of bits differ.
    #[error("the volumes were made with {volumes} bits, and the pipelines have {pipelines}; take the same pipelines")]
    DrawBits { volumes: u32, pipelines: u32 },
    /// A later encode overwrites what is drawn.
    #[error(
        "a later encode of these volumes overwrites this frame; draw a frame before the next encode, or make further volumes"
    )]
    StaleFrame,

    /// The format of a map to draw into has no depth.
    #[error("{0:?} has no depth; take a depth format, such as Depth32Float")]
    NoDepth(wgpu::TextureFormat),
    /// One draw cannot have so many vertices.
    #[error("the mesh has {0} faces, and one draw has at most 1,431,655,765; divide the mesh")]
    Faces(usize),
}

/// Calls `make`. An error of the device within it is [`DepthMapError::Refused`].
pub(super) fn guard<T>(device: &wgpu::Device, make: impl FnOnce() -> T) -> Result<T, DepthMapError> {
    any_error(device, make).map_err(|message| DepthMapError::Refused { message })
}

contain!(ShadowError in DepthMapError::Shadow but Device);
