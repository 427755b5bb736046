//! Why depth maps cannot cast in a scene.

use super::caster::DepthMapCasterHandle;
use super::frame_errors::{DepthMapDrawError, DepthMapEncodeError};
use super::volumes_errors::DepthMapCubeError;
use crate::gpu::LightHandle;
use crate::gpu::common::requirements::DeviceError;
use crate::shadow::CameraError;

/// Why depth maps cannot cast in a scene.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
#[non_exhaustive]
pub enum DepthMapCastersError {
    /// The device is lost, or something is of another device.
    #[error(transparent)]
    Device(#[from] DeviceError),
    /// A texture, its objects or the camera of a map do not fit its volumes.
    #[error(transparent)]
    Refused(DepthMapEncodeError),
    /// The cameras of six maps do not meet.
    #[error(transparent)]
    Cube(#[from] DepthMapCubeError),
    /// The handle is of a caster with one map, or with six.
    #[error("the handle is of a caster with {own}; use `{with}`")]
    Kind {
        /// What the caster has.
        own: &'static str,
        /// The function that changes it.
        with: &'static str,
    },
    /// A map cannot be encoded for a camera.
    #[error("a map of the light with bit {}, view {view}: {error}", light.bit())]
    Map {
        /// The caster.
        caster: DepthMapCasterHandle,
        /// Its light.
        light: LightHandle,
        /// The number of the camera.
        view: usize,
        /// Why.
        error: DepthMapEncodeError,
    },
    /// A camera is refused.
    #[error("view {view}: {error}")]
    Camera {
        /// The number of the camera.
        view: usize,
        /// Why.
        error: CameraError,
    },
    /// There are more boxes than cameras.
    #[error("{given} boxes of what receives given for {views} cameras; give at most one for each camera")]
    TooManyBounds {
        /// Boxes given.
        given: usize,
        /// Cameras given.
        views: usize,
    },
    /// A box is none.
    #[error("view {view}: the box from {low:?} to {high:?} is none; give finite corners, the lowest first")]
    Bounds {
        /// The number of the camera.
        view: usize,
        /// The lowest corner given.
        low: [f32; 3],
        /// The highest corner given.
        high: [f32; 3],
    },
    /// A handle or a frame is of another scene, or of other casters.
    #[error("the {what} is of another scene, or of other `DepthMapCasters`; use it with those that returned it")]
    OtherScene {
        /// What is.
        what: &'static str,
    },
    /// The caster was removed.
    #[error("the caster of this handle was removed; use the handle that the last insertion returned")]
    Stale,
    /// The frame has no view with this number.
    #[error("view {view} asked for, and {views} cameras were encoded; views count from 0")]
    NoSuchView {
        /// The view that was asked for.
        view: usize,
        /// Views of the frame.
        views: usize,
    },
    /// The light or the caster was not there when the frame was encoded.
    #[error("the {what} was not there when this frame was encoded; add it before the encode")]
    NotEncoded {
        /// What was not.
        what: &'static str,
    },
    /// Parities of several maps would undo each other.
    #[error(
        "the light has {casters} maps, whose parities would undo each other in one bit; take `DepthMapPipelines::counting` \
         and `DepthEdges::EveryCell`, or give each map bits of its own and draw it by `draw_caster`, or merge the maps"
    )]
    OneParity {
        /// Maps of the light.
        casters: usize,
    },
    /// Counts of the scene's meshes own the bit of a parity.
    #[error(
        "bit {bit} of the stencil is one of the {count_bits} that counts of the scene own (`SceneOptions::count_bits`); take a \
         higher one for parity, or make the scene with fewer"
    )]
    Counted {
        /// The lowest bit of the pipelines.
        bit: u32,
        /// Low bits that counts of the scene own.
        count_bits: u32,
    },
    /// Maps would be counted in other bits than the scene's meshes.
    #[error(
        "the scene counts in {scene} bits, and the pipelines in {pipelines}; use the same `ShadowFormat::count_bits` and \
         `SceneOptions::count_bits`"
    )]
    CountBits {
        /// Low bits that counts of the scene own.
        scene: u32,
        /// Low bits that the pipelines count in.
        pipelines: u32,
    },
    /// The pipelines do not fit, or a later encode overwrites what is drawn.
    #[error(transparent)]
    Draw(#[from] DepthMapDrawError),
}
