//! Why a scene refuses something.

use crate::gpu::common::memory::MemoryError;
use crate::gpu::common::positions::PositionError;
use crate::gpu::common::requirements::DeviceError;
use crate::gpu::shadow::ShadowFormatError;
use crate::gpu::shadow::errors::ShadowDrawError;
use crate::light::LightError;
use crate::shadow::{CameraError, Counting};

/// Why a scene cannot be made, changed or recorded.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
#[non_exhaustive]
pub enum SceneError {
    /// The device lacks what extraction needs, is lost, or is not the timer's.
    #[error(transparent)]
    Device(#[from] DeviceError),
    /// A light is refused, or `max_lights` is impossible.
    #[error(transparent)]
    Light(#[from] LightError),
    /// `count_bits` is impossible.
    #[error("`SceneOptions`: {0}")]
    Format(#[from] ShadowFormatError),
    /// All bits of lights are in use.
    #[error("the scene has room for {limit} lights; remove one first, or make the scene with a larger `max_lights`")]
    NoLightBit {
        /// The `max_lights` of the scene.
        limit: usize,
    },
    /// The position buffer of a caster is refused.
    #[error(transparent)]
    Positions(#[from] PositionError),
    /// A mesh, or the scene as a whole, does not fit the device or the memory limit.
    #[error(transparent)]
    Memory(#[from] MemoryError),
    /// The mesh has polygons, which scenes do not take so far.
    #[error(
        "the mesh has faces of more than three corners, which a scene does not take; make a mesh of its triangles by \
         `Mesh::from_polygons`, or take `Extractor` and `ShadowVolumes`"
    )]
    Polygons,
    /// There are fewer positions than the mesh has vertices.
    #[error("{given} positions given, and the mesh has {needed} vertices; give one for each source vertex")]
    TooFewPositions {
        /// Positions given.
        given: usize,
        /// Vertices of the mesh.
        needed: u32,
    },
    /// A handle belongs to another scene.
    #[error("the handle of a {what} is of another scene; use it with the scene that returned it")]
    OtherScene {
        /// The kind of the handle.
        what: &'static str,
    },
    /// The mesh, caster or light of a handle was removed.
    #[error("the {what} of this handle was removed from the scene; use the handle that the last insertion returned")]
    Stale {
        /// The kind of the handle.
        what: &'static str,
    },
    /// A caster was given twice to [`Scene::encode_needs`](crate::gpu::Scene::encode_needs).
    #[error("caster {caster} of those listed is there twice; list each once")]
    ListedTwice {
        /// The later place in the list.
        caster: usize,
    },
    /// The scene, its lights or the cameras are not those that needs were found for.
    #[error(
        "the scene or the cameras changed since `encode_needs`, or these needs are a part or not the last; call `encode_needs` \
         after all \
         changes, deform by what it returns, and pass the same to `encode_needed`"
    )]
    StaleNeeds,
    /// A mesh cannot be removed while casters use it.
    #[error("{casters} casters still use the mesh; remove them first")]
    MeshInUse {
        /// The number of casters.
        casters: usize,
    },
    /// Hidden faces of a list of casters, and another number of casters.
    #[error(
        "the hidden faces are those of {found} casters, and {given} casters are given; give those that were searched"
    )]
    HiddenCasters {
        /// Casters given.
        given: usize,
        /// Casters that were searched.
        found: usize,
    },
    /// Hidden faces of another mesh, or of a caster given twice.
    #[error(
        "caster {caster} of the list has {faces} faces or stands in the list twice, and hidden faces are those of a mesh with \
         {found} faces; give the casters once and in the order of the search"
    )]
    HiddenCaster {
        /// Number of the caster in the list.
        caster: usize,
        /// Faces of its mesh.
        faces: usize,
        /// Faces of the mesh that was searched.
        found: usize,
    },
    /// A face that the mesh does not have was to be excluded.
    #[error("face {face} is to be excluded, and the mesh of the caster has {faces} faces; faces count from 0")]
    NoSuchFace {
        /// The face given.
        face: u32,
        /// Faces of the mesh.
        faces: u32,
    },
    /// A transform was given for a caster whose positions lie in a buffer in world space.
    #[error(
        "the caster has positions in a buffer, in world space, and no transform; give it `CasterPositions::Rigid` by \
         `Scene::set_positions`"
    )]
    NotRigid,
    /// A version or a box of positions is given for a rigid caster.
    #[error("the caster is rigid, so there is no version and no box of its positions; move it by `set_transform`")]
    NoBuffer,
    /// A box is none.
    #[error("the box from {low:?} to {high:?} is none; give finite corners, the lowest first")]
    Bounds {
        /// The lowest corner given.
        low: [f32; 3],
        /// The highest corner given.
        high: [f32; 3],
    },
    /// A polygon is no occluder of the caster.
    #[error("occluder {number}: {error}")]
    Occluder {
        /// The number of the polygon.
        number: usize,
        /// Why.
        error: OccluderError,
    },
    /// A camera is refused.
    #[error("view {view}: {error}")]
    Camera {
        /// The number of the view.
        view: usize,
        /// Why.
        error: CameraError,
    },
    /// The receivers of a view are refused.
    #[error("view {view}: {error}")]
    Receivers {
        /// The number of the view.
        view: usize,
        /// Why.
        error: ReceiversError,
    },
    /// The scene's counting method needs what the published method of one caster has.
    #[error("scenes are not counted by {0:?}, which is for a single caster; take `ShadowVolumes`")]
    Counting(Counting),
    /// The frame has no view with this number.
    #[error("view {view} asked for, and {views} cameras were encoded; views count from 0")]
    NoSuchView {
        /// The view that was asked for.
        view: usize,
        /// Views of the frame.
        views: usize,
    },
    /// The pipelines and the scene do not agree on whether casters are counted in batches.
    #[error(
        "the scene counts its casters in {count_batches} batches (`SceneOptions::count_batches`); draw several with \
         `ScenePipelines::in_batches`, and one with `ScenePipelines::new`"
    )]
    CountBatches {
        /// Batches of the scene.
        count_batches: u32,
    },
    /// The light was not in the scene when the frame was encoded.
    #[error("the light was not in the scene when this frame was encoded; add it before `Scene::encode`")]
    NotEncoded,
    /// The pipelines do not go with the scene.
    #[error(transparent)]
    Draw(#[from] ShadowDrawError),
    /// A later encode overwrote the results of the frame.
    #[error(
        "this frame is out of date: its scene was encoded again, which overwrites the results; use the value that the \
         last encode returned"
    )]
    StaleFrame,
}

/// Why the receivers of a view are refused.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
#[non_exhaustive]
pub enum ReceiversError {
    /// There are more receivers than views.
    #[error("{given} receivers given for {views} cameras; give at most one for each camera")]
    TooMany {
        /// Receivers given.
        given: usize,
        /// Cameras given.
        views: usize,
    },
    /// The texture has no depth.
    #[error("the receivers have the format {format:?}, which has no depth; give the depth attachment")]
    NoDepth {
        /// The format of the texture.
        format: wgpu::TextureFormat,
    },
    /// The texture cannot be read.
    #[error("the depth texture lacks the usage `TEXTURE_BINDING`; add it where the texture is made")]
    Usage,
    /// The device refuses to read the view.
    #[error(
        "the device cannot read the depth: {message}; give a view of the depth aspect alone, of one layer and level"
    )]
    Refused {
        /// The message of the device.
        message: String,
    },
}

/// Why a polygon is no occluder.
#[derive(Clone, Copy, Debug, PartialEq, thiserror::Error)]
#[non_exhaustive]
pub enum OccluderError {
    /// It has too few or too many corners.
    #[error("it has {corners} corners; give 3 to 8")]
    Corners {
        /// Corners given.
        corners: usize,
    },
    /// A corner is not on the mesh.
    #[error(
        "corner {corner} at {position:?} is outside the box of the mesh's faces; give positions on its faces, in mesh space"
    )]
    Outside {
        /// The number of the corner.
        corner: usize,
        /// Where it is.
        position: [f32; 3],
    },
}
