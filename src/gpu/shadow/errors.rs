//! Why pipelines of shadow volumes, scenes and masks cannot be made, changed, recorded or drawn.

use super::format::{ShadowFormat, attachments};
use crate::gpu::common::device_error::{DeviceError, contain, feature_names};
use crate::gpu::deform::deformer::DeformError;
use crate::gpu::extract::errors::ExtractorError;
use crate::light::LightError;
use crate::shadow::{CameraError, Counting, DepthDirection};

/// Why pipelines of shadow volumes, a scene or masks cannot be made, changed, recorded or drawn.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
#[non_exhaustive]
#[allow(missing_docs, reason = "the messages say what fields are")]
pub enum ShadowError {
    /// The device lacks what is needed, is lost, or is not that of the pipelines or the timer. Or a mesh or the scene does not fit
    /// it or the memory limit, or a position buffer is refused.
    #[error(transparent)]
    Device(#[from] DeviceError),
    /// A model or its pose is refused.
    #[error(transparent)]
    Deform(#[from] DeformError),
    /// A light is refused, for example one with a negative `w`, or `max_lights` is impossible.
    #[error(transparent)]
    Light(#[from] LightError),
    /// The camera is refused. [`Self::ViewCamera`] is that of a scene.
    #[error(transparent)]
    Camera(#[from] CameraError),
    /// A polygon of a mesh has too many edges or triangles for the GPU.
    #[error(transparent)]
    Extraction(ExtractorError),

    /// The format lacks stencil or depth. The stencil counts, and the depth tells near from far.
    #[error("{0:?} does not hold both depth and stencil; take Depth24PlusStencil8 or Depth32FloatStencil8")]
    NoStencil(wgpu::TextureFormat),
    /// The device was not asked for the format's feature.
    #[error("{format:?} needs {}; make the device with it", feature_names(*.needed))]
    Feature { format: wgpu::TextureFormat, needed: wgpu::Features },
    /// The format does not allow this number of samples. Every device allows the supported ones, or some devices with
    /// `Features::TEXTURE_ADAPTER_SPECIFIC_FORMAT_FEATURES`.
    #[error("{samples} samples a pixel of {format:?} are not to be had; take one of {supported:?}")]
    Samples { samples: u32, format: wgpu::TextureFormat, supported: Vec<u32> },
    /// The device makes no pipelines for the attachments. For example a format cannot be drawn into, there are too many
    /// attachments, or the adapter lacks the sample count.
    #[error("the device refuses pipelines for these attachments: {message}")]
    Refused { message: String },
    /// The pass has no depth-stencil attachment.
    #[error(
        "the pass has no depth-stencil attachment, and shadow volumes count there; `ShadowFormat::attachment` makes it"
    )]
    NoDepthStencil,
    /// The pass has other attachments than the pipelines were made for.
    #[error(
        "the pass has {}, and the format has {}; make the format of this pass by `ShadowFormat::of_pass`, and pipelines of it",
        attachments(.pass), attachments(.format)
    )]
    OtherAttachments { pass: Box<ShadowFormat>, format: Box<ShadowFormat> },
    /// The pass does not clear its stencil to 0, where counts begin.
    #[error("the pass does not clear its stencil to 0, where counts begin; take `ShadowFormat::attachment`")]
    StencilNotCleared,
    /// The pass clears the depth.
    #[error(
        "the pass clears the depth, which shadow volumes are compared with; load the depths of the depth pass, as \
         `ShadowFormat::attachment` does"
    )]
    DepthCleared,
    /// Counts have too few bits of the stencil, or more than it has. They need two where casters are counted in batches.
    #[error("`count_bits` is {given}; give {least} to 8")]
    CountBits { given: u32, least: u32 },
    /// The far plane would cut off dark caps. The device needs `Features::DEPTH_CLIP_CONTROL`.
    #[error("z-fail with a far plane needs DEPTH_CLIP_CONTROL; use an infinite far plane, or `Counting::Auto`")]
    DepthClip,

    /// The pipelines have another counting method than the volumes.
    #[error(
        "volumes made for {volumes:?} drawn with pipelines of {pipelines:?}; draw them with pipelines of the counting \
         method of `SceneOptions::counting`"
    )]
    OtherCounting { volumes: Counting, pipelines: Counting },
    /// The pipelines have another depth direction than the volumes.
    #[error(
        "volumes made for {volumes:?} depth drawn with pipelines of {pipelines:?} depth; take a `ShadowFormat` of that"
    )]
    OtherDepth { volumes: DepthDirection, pipelines: DepthDirection },
    /// The camera of the volumes makes a mirror image and the pipelines are made for none, or the other way round. Near
    /// caps would be counted against the sides.
    #[error(
        "volumes whose camera needs front faces {volumes:?} drawn with pipelines of {pipelines:?}; change the sign of the row \
         of y of a camera that mirrors by mistake, or set `ShadowFormat::front_face`"
    )]
    OtherFrontFace { volumes: wgpu::FrontFace, pipelines: wgpu::FrontFace },
    /// The camera has a far plane, at which pipelines of z-fail must not clip, and these do.
    #[error(
        "volumes made for z-fail with a far plane drawn with pipelines for none; set `ShadowFormat::has_far_plane`"
    )]
    OtherFarPlane,
    /// The pipelines count in other bits than the volumes were made for, so counts wrap elsewhere.
    #[error(
        "volumes made for counts of {volumes} bits drawn with pipelines of {pipelines}; take a `ShadowFormat` of the same \
         `count_bits` (for a scene, `SceneOptions::stencil`)"
    )]
    OtherCountBits { volumes: u32, pipelines: u32 },

    /// All bits of lights are in use.
    #[error("the scene has room for {limit} lights; remove one first, or make the scene with a larger `max_lights`")]
    NoLightBit { limit: usize },
    /// Faces of a mesh of polygons were to be excluded, and polygons count as a whole.
    #[error(
        "the mesh has faces of more than three corners, and faces of such a mesh cannot be excluded; make a mesh of its \
         triangles by `Mesh::from_polygons`"
    )]
    Polygons,
    /// There are fewer positions than the mesh has vertices.
    #[error("{given} positions given, and the mesh has {needed} vertices; give one for each source vertex")]
    TooFewPositions { given: usize, needed: u32 },
    /// A handle belongs to another scene.
    #[error("the handle of a {what} is of another scene; use it with the scene that returned it")]
    OtherScene { what: &'static str },
    /// The mesh, caster, light or model of a handle was removed.
    #[error("the {what} of this handle was removed from the scene; use the handle that the last insertion returned")]
    Removed { what: &'static str },
    /// A mesh cannot be removed while casters use it.
    #[error("{casters} casters still use the mesh; remove them first")]
    MeshInUse { casters: usize },
    /// Occluded faces of a list of casters, and another number of casters.
    #[error(
        "the occluded faces are those of {found} casters, and {given} casters are given; give those that were searched"
    )]
    OcclusionCasters { given: usize, found: usize },
    /// Occluded faces of another mesh, or of a caster given twice.
    #[error(
        "caster {caster} of the list has {faces} faces or stands in the list twice, and occluded faces are those of a mesh with \
         {found} faces; give the casters once and in the order of the search"
    )]
    OcclusionCaster { caster: usize, faces: usize, found: usize },
    /// A face that the mesh does not have was to be excluded.
    #[error("face {face} is to be excluded, and the mesh of the caster has {faces} faces; faces count from 0")]
    NoSuchFace { face: u32, faces: u32 },
    /// A caster that is an instance of a model is to be moved or removed by itself.
    #[error(
        "the caster is an instance of a model; move it by `Scene::set_pose`, remove the model by `Scene::remove_model`, or let \
         the instance cast for no light by `Scene::set_lights`"
    )]
    OfModel,
    /// A transform or occluders were given for a caster whose positions lie in a buffer in world space.
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
    Bounds { low: [f32; 3], high: [f32; 3] },
    /// An occluder has too few or too many corners.
    #[error("occluder {number}: it has {corners} corners; give 3 to 8")]
    OccluderCorners { number: usize, corners: usize },
    /// A corner of an occluder is not on the mesh.
    #[error(
        "occluder {number}: corner {corner} at {position:?} is outside the box of the mesh's faces; give positions on its faces, \
         in mesh space"
    )]
    OccluderOutside { number: usize, corner: usize, position: [f32; 3] },
    /// The camera of a view of a scene is refused.
    #[error("view {view}: {error}")]
    ViewCamera { view: usize, error: CameraError },
    /// The texture of receivers has no depth.
    #[error("view {view}: the receivers have the format {format:?}, which has no depth; give the depth attachment")]
    ReceiversFormat { view: usize, format: wgpu::TextureFormat },
    /// The texture of receivers cannot be read.
    #[error("view {view}: the depth texture lacks the usage `TEXTURE_BINDING`; add it where the texture is made")]
    ReceiversUsage { view: usize },
    /// The device refuses to read the receivers.
    #[error(
        "view {view}: the device cannot read the depth: {message}; give a view of the depth aspect alone, of one layer"
    )]
    ReceiversRefused { view: usize, message: String },
    /// The frame has no view with this number.
    #[error("view {view} asked for, and {views} cameras were encoded; views count from 0")]
    NoSuchView { view: usize, views: usize },
    /// The pipelines and the scene do not agree on whether casters are counted in batches.
    #[error(
        "the scene counts its casters in {count_batches} batches (`StencilCounts::count_batches`); draw several with \
         `ShadowPipelines::in_batches`, and one with `ShadowPipelines::new`"
    )]
    CountBatches { count_batches: u32 },
    /// The light was not in the scene when the frame was encoded.
    #[error("the light was not in the scene when this frame was encoded; add it before `Scene::encode`")]
    NotEncoded,
    /// The view leaves out the light.
    #[error("view {view} was encoded without the shadows of this light; add the light to `View::lights`")]
    NotInView { view: usize },
    /// A later encode, or a deformation of the scene's models, overwrote the results of the frame.
    #[error(
        "this frame is out of date: its scene was encoded again, which overwrites the results; use the value that the \
         last encode returned"
    )]
    StaleFrame,

    /// The depth texture for masks has no depth, or shaders may not read it.
    #[error("the depth texture, of format {format:?}, cannot be read; give one with depth and usage TEXTURE_BINDING")]
    MaskDepth { format: wgpu::TextureFormat },
    /// Masks of depth of 32 bits need an optional format with stencil.
    #[error(
        "depth of format {format:?} is tested in Depth32FloatStencil8, which needs {}; make the device with it, or draw \
         the depth in Depth24Plus",
        feature_names(*.needed)
    )]
    MaskFeature { format: wgpu::TextureFormat, needed: wgpu::Features },
    /// The target is of no format that masks have.
    #[error("the target has the format {format:?}; masks are R8Uint, R32Uint or R8Unorm")]
    MaskFormat { format: wgpu::TextureFormat },
    /// The target of masks has several samples or three dimensions, or cannot be drawn into.
    #[error(
        "the target has {samples} samples, {dimension:?} and usages {usage:?}; give one with one sample, two dimensions and \
         usage RENDER_ATTACHMENT"
    )]
    MaskTarget { samples: u32, dimension: wgpu::TextureDimension, usage: wgpu::TextureUsages },
    /// The target of masks has not the size of the depth.
    #[error("the target has {target:?} pixels and the depth {depth:?}; give textures of one size")]
    MaskSize { target: [u32; 2], depth: [u32; 2] },
    /// There are more lights than the layers of the target hold.
    #[error(
        "{lights} lights need {needed} layers of {format:?}, and the target has {layers}; add layers, or give fewer lights"
    )]
    MaskLayers { lights: usize, needed: u32, format: wgpu::TextureFormat, layers: u32 },
    /// The device refuses a texture, a view or a pipeline of masks.
    #[error("the device refuses {what}: {message}")]
    MaskRefused { what: &'static str, message: String },
}

contain!(ExtractorError in ShadowError::Extraction but Device, Light);
