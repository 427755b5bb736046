//! The shadow volumes of one caster.

use std::sync::Arc;
use std::sync::atomic::AtomicU64;

use super::buffers::SizedBuffers;
use super::errors::ShadowError;
use super::frame::{ShadowFrame, Shared};
use super::options::ShadowOptions;
use super::pipelines::{Convention, Part, ShadowPipelines};
use super::sizes::{GroupSize, Room, VolumeSizes};
use super::source::{GroupSource, VolumeSource};
use super::stages::{StagePipelines, VolumeStages};
use crate::ShadowCamera;
use crate::gpu::common::bindings::{Resource, whole};
use crate::gpu::common::device_error::DeviceError;
use crate::gpu::common::memory::{Allocation, buffer, guarded};
use crate::gpu::common::positions::{self, BoundPositions};
use crate::gpu::common::requirements::{Subject, check_same, check_timer};
use crate::gpu::common::timer::StageTimer;
use crate::gpu::common::uniforms::upload;
use crate::gpu::extract::extraction::{self, Extraction, Place};
use crate::gpu::extract::extractor::Extractor;
use crate::gpu::scene::options::SceneOptions;
#[cfg(feature = "reference")]
use crate::layout::ShadowShape;
use crate::layout::caster_flags::{CLOSED, PROXY};
use crate::layout::{SceneCaster, SeenLight};
use crate::light::{self, check_shadow_lights};

/// Near caps that there is room for besides sixteen times the root of the faces.
const FEW_CAPS: u32 = 1024;

/// The shadow volumes of one caster, for the lights of its [`Extractor`]. It records compute passes into the caller's
/// encoder after those of the extraction, and draws into the caller's render pass. It reads nothing back.
///
/// For each light, a pass clears the stencil to 0 and draws the volumes of all casters. Then the light is added where
/// the stencil is still 0. The depth buffer must contain the casters before.
/// [`ShadowFormat::depth_stencil`](crate::gpu::ShadowFormat::depth_stencil) says how precise depth must be.
///
/// In a closed and consistently oriented caster, the faces averted from the light cast, whichever way it is wound. Every
/// face casts where the light or the near rectangle may be within the caster's box, and in every other caster. A face
/// casts nothing if the light lies exactly in its plane. So a light may be on a face, an edge or a vertex. A light that
/// is next to an edge or a face, but not on it, casts an imprecise shadow. Keep it away by a ten-thousandth of the
/// caster's size or more.
///
/// Shadows can be wrong by one pixel at contours as the camera sees them. Rasterization rounds positions there, and a
/// hairline of light or shadow can appear. See docs/numerics/rasterisers.md, "Hairlines".
///
/// ```no_run
/// use rimline::gpu::{
///     Extractor, ExtractorOptions, PositionBuffer, ShadowFormat, ShadowOptions, ShadowPipelines, ShadowVolumes,
/// };
/// use rimline::{Counting, Light, Mesh, ShadowCamera, wgpu};
///
/// # fn shadows(
/// #     device: &wgpu::Device,
/// #     encoder: &mut wgpu::CommandEncoder,
/// #     mesh: &Mesh,
/// #     vertices: PositionBuffer<'_>,
/// #     camera: &ShadowCamera,
/// #     depth_stencil: &wgpu::TextureView,
/// #     draw_lit: impl Fn(&mut wgpu::RenderPass<'_>, &wgpu::DepthStencilState, usize),
/// # ) -> Result<(), Box<dyn std::error::Error>> {
/// // Once, with the format of your depth-stencil attachment and the depth of your camera:
/// let format = ShadowFormat { depth: camera.depth, ..ShadowFormat::default() };
/// // Your pipelines that add a light have this state, and blend by addition:
/// let lit: wgpu::DepthStencilState = format.light_pass_depth_stencil();
/// let pipelines = ShadowPipelines::new(device, &format, Counting::Auto)?;
/// // Once for each caster:
/// let mut extractor = Extractor::new(device, mesh, ExtractorOptions { max_lights: 2, ..Default::default() })?;
/// let mut volumes = ShadowVolumes::new(&pipelines, &extractor, ShadowOptions::default())?;
///
/// // Every frame:
/// let lights = [Light::point([0.0, 5.0, 2.0]), Light::directional([1.0, 1.0, 0.0])];
/// let extraction = extractor.encode(encoder, vertices, &lights)?;
/// let shadows = volumes.encode(encoder, &extraction, camera, None)?;
/// // After your depth pass, for each light. Put your colour attachments here and into the format:
/// for light in 0..lights.len() {
///     let mut pass = encoder.begin_render_pass(&wgpu::RenderPassDescriptor {
///         label: Some("light"),
///         depth_stencil_attachment: Some(wgpu::RenderPassDepthStencilAttachment {
///             view: depth_stencil,
///             depth_ops: Some(wgpu::Operations { load: wgpu::LoadOp::Load, store: wgpu::StoreOp::Store }),
///             stencil_ops: Some(wgpu::Operations { load: wgpu::LoadOp::Clear(0), store: wgpu::StoreOp::Store }),
///         }),
///         ..Default::default()
///     });
///     shadows.draw(&mut pass, &pipelines, light)?;
///     draw_lit(&mut pass, &lit, light);
/// }
/// # Ok(())
/// # }
/// ```
#[derive(Debug)]
pub struct ShadowVolumes {
    shared: Arc<Shared>,
    pipelines: StagePipelines,
    /// Made for the positions of the last encode.
    stages: Option<(Place, Arc<VolumeStages>)>,
}

impl ShadowVolumes {
    /// Makes buffers on the device of `pipelines`, for the mesh that `extractor` was made for. `extractor` must be on
    /// the same device. `pipelines` also provides the compute pipelines.
    ///
    /// # Errors
    /// [`ShadowError`] if the extractor lacks lists or facing masks or is on another device, or the mesh does
    /// not fit the device.
    pub fn new(
        pipelines: &ShadowPipelines,
        extractor: &Extractor,
        options: ShadowOptions,
    ) -> Result<Self, ShadowError> {
        let devices = [extractor.shared().device(), pipelines.shared().device()];
        check_same(["the extractor", "the pipelines"], devices)?;
        pipelines.shared().construct(Subject::Shadow, || Self::with(pipelines, extractor, options))
    }

    fn with(pipelines: &ShadowPipelines, extractor: &Extractor, options: ShadowOptions) -> Result<Self, ShadowError> {
        let source = extractor.shared();
        source.check_include()?;
        if source.buffers.faces.size() > source.limits.binding {
            let (bytes, limit) = (source.buffers.faces.size(), source.limits.binding);
            return Err(DeviceError::BindingTooLarge { what: "faces", bytes, limit }.into());
        }
        let scene = options.of_scene(pipelines.convention);
        let has_pieces = source.buffers.polygons.is_some();
        let sizes = sizes(source, scene, options.in_depth);
        let [_, choices] = sizes.choice_bytes();
        let table = Allocation { label: "shadow table", bytes: size_of::<SceneCaster>() as u64 + choices };
        let device = source.device();
        let buffers = SizedBuffers::new(device, sizes, table, &source.limits)?;
        let usage = wgpu::BufferUsages::STORAGE | wgpu::BufferUsages::COPY_DST;
        let table = guarded(device, table.bytes, || buffer(device, table.label, table.bytes, usage))?;
        let stage_pipelines = StagePipelines::new(pipelines.shared(), false, has_pieces, &scene);
        if has_pieces {
            pipelines.of(Part::Pieces);
        }
        if options.end_at_range {
            pipelines.of(Part::Ends);
        }
        if buffers.sizes.has_proxies() {
            pipelines.of(Part::Proxies);
        }
        let (source, convention) = (Arc::clone(source), pipelines.convention);
        let shared = Shared { source, buffers, table, convention, encodes: AtomicU64::new(0) };
        Ok(Self { shared: Arc::new(shared), pipelines: stage_pipelines, stages: None })
    }

    /// Records the stages that choose and list for `camera`, and returns what can be drawn. Call it after the encode that
    /// returned `extraction`. Lights and their ranges are those of the extraction; it may have none. The camera takes
    /// positions in their own space. `timer` takes a timestamp around each stage.
    ///
    /// # Errors
    /// [`ShadowError`] if camera or lights are refused, or the extraction belongs to another extractor or is out
    /// of date. Nothing is recorded then.
    pub fn encode(
        &mut self,
        encoder: &mut wgpu::CommandEncoder,
        extraction: &Extraction,
        camera: &ShadowCamera,
        timer: Option<&mut StageTimer>,
    ) -> Result<ShadowFrame, ShadowError> {
        self.check(extraction, camera)?;
        check_timer(timer.as_deref(), extraction.shared.device())?;
        camera.check_hand(self.shared.convention.mirrors)?;
        let view = camera.view()?;
        let lights = extraction.lights();
        let bound = extraction.bound()?;
        let stages = self.bind(extraction, &bound)?;
        let Shared { buffers, source, table, .. } = &*self.shared;
        let seen = |&light| SeenLight { view, light: camera.light(&view, light), ..bytemuck::Zeroable::zeroed() };
        let mut seen: Vec<SeenLight> = lights.iter().map(seen).collect();
        // Numbers without a light are seen in no view.
        seen.resize(buffers.sizes.lights, bytemuck::Zeroable::zeroed());
        let caster = caster(source, buffers.sizes.has_proxies(), &bound);
        let uploads: [(&wgpu::Buffer, &[u8]); 2] =
            [(&buffers.of.seen, bytemuck::cast_slice(&seen)), (table, bytemuck::bytes_of(&caster))];
        upload(source.device(), encoder, &uploads)?;
        stages.record(encoder, light::batches(lights.len()), timer);
        Ok(ShadowFrame::new(Arc::clone(&self.shared), stages, extraction.clone()))
    }

    /// The [`ShadowStatistics`](crate::gpu::ShadowStatistics) of the last encode, once its encoder was submitted. Usage
    /// `COPY_SRC`.
    pub fn statistics(&self) -> &wgpu::Buffer {
        &self.shared.buffers.of.statistics
    }

    /// The choices for the last encode, once its encoder was submitted: what `reference::cpu::chosen` reads. Usage
    /// `COPY_SRC`.
    #[cfg(feature = "reference")]
    pub fn choices(&self) -> &wgpu::Buffer {
        &self.shared.buffers.of.choices
    }

    /// Lights and camera of the last encode, as [`SeenLight`]s, once its encoder was submitted. Usage `COPY_SRC`.
    #[cfg(feature = "reference")]
    pub fn seen(&self) -> &wgpu::Buffer {
        &self.shared.buffers.of.seen
    }

    /// The sizes of the volumes, for as many lights as there is room for.
    #[cfg(feature = "reference")]
    pub fn shape(&self) -> ShadowShape {
        self.shared.buffers.sizes.shape(0)
    }

    /// One buffer with the draws of each light, as [`ShadowDraws`](crate::layout::ShadowDraws), once the encoder was submitted.
    /// Usages `INDIRECT` and `COPY_SRC`.
    #[cfg(feature = "reference")]
    pub fn draw_arguments(&self) -> &[wgpu::Buffer] {
        &self.shared.buffers.of.draws
    }

    /// Refuses input that would draw wrong shadows: an extraction of another extractor or out of date, or a camera that
    /// the pipelines are not for.
    fn check(&self, extraction: &Extraction, camera: &ShadowCamera) -> Result<(), ShadowError> {
        let Shared { source, convention, .. } = &*self.shared;
        if !Arc::ptr_eq(source, &extraction.shared) {
            return Err(ShadowError::OtherExtractor);
        }
        extraction.check_current()?;
        check_shadow_lights(extraction.lights(), source.shape.max_lights)?;
        let &Convention { counting, depth, .. } = convention;
        if camera.depth != depth {
            return Err(ShadowError::CameraDepth { camera: camera.depth, pipelines: depth });
        }
        if convention.needs_far_end() && camera.has_far_plane() {
            return Err(ShadowError::FarPlane { counting });
        }
        Ok(())
    }

    /// Binds the stages and draws to positions, unless they are bound to this place.
    fn bind(&mut self, extraction: &Extraction, bound: &BoundPositions) -> Result<Arc<VolumeStages>, ShadowError> {
        if let Some((place, stages)) = &self.stages
            && *place == extraction.place
        {
            return Ok(Arc::clone(stages));
        }
        let Shared { buffers, source, table, .. } = &*self.shared;
        source.check_single_bindings(bound)?;
        let place = extraction.positions();
        let stages = positions::bound(source.device(), || {
            let positions = bound.first_binding(place.buffer);
            VolumeStages::new(&self.pipelines, buffers, &volume_source(source, table, positions))
        })?;
        let stages = Arc::new(stages);
        self.stages = Some((extraction.place.clone(), Arc::clone(&stages)));
        Ok(stages)
    }
}

fn sizes(source: &extraction::Shared, options: SceneOptions, in_depth: bool) -> VolumeSizes {
    let shape = &source.shape;
    let (faces, edges) = (shape.faces as u32, shape.edges as u32);
    let proxies = if in_depth { 0 } else { faces };
    let group = GroupSize { faces, edges, proxies, ..GroupSize::default() };
    let pieces = shape.polygons.map_or(0, |polygons| polygons.pieces);
    let room = |batch| {
        let lights = shape.batch_lights(batch) as u32;
        Room { pieces, ..Room::new(&options, &group, FEW_CAPS, shape.capacity, lights, &source.limits) }
    };
    VolumeSizes {
        options,
        casters: 1,
        lights: shape.max_lights,
        views: 1,
        choices_at: size_of::<SceneCaster>() / 16,
        groups: vec![group],
        rooms: (0..shape.batches()).map(room).collect(),
        receivers: 0,
    }
}

/// The caster: all slots, in the space of its positions.
fn caster(source: &extraction::Shared, is_proxy: bool, positions: &BoundPositions) -> SceneCaster {
    SceneCaster {
        row_0: [1.0, 0.0, 0.0, 0.0],
        row_1: [0.0, 1.0, 0.0, 0.0],
        row_2: [0.0, 0.0, 1.0, 0.0],
        scale: 1.0,
        flags: if source.is_closed { CLOSED } else { 0 } | if is_proxy { PROXY } else { 0 },
        faces: source.shape.faces as u32,
        position_offset: positions.offset_words,
        edges: source.shape.edges as u32,
        position_stride: positions.stride_words,
        ..bytemuck::Zeroable::zeroed()
    }
}

fn volume_source<'a>(
    source: &'a extraction::Shared,
    table: &'a wgpu::Buffer,
    positions: Resource<'a>,
) -> VolumeSource<'a> {
    let extracted = &source.buffers;
    let lists = extracted.facing.iter().zip(&extracted.excluded).zip(&extracted.lists);
    let pieces = extracted.polygons.as_ref().map_or(&[][..], |polygons| &polygons.pieces);
    let batches = lists.enumerate().map(|(batch, ((facing, excluded), silhouettes))| {
        let mut named = vec![
            ("facing_masks", whole(facing)),
            ("excluded_masks", whole(excluded)),
            ("silhouette_counts", whole(&extracted.counts)),
            ("silhouettes", whole(silhouettes)),
            ("extraction_statistics", whole(&extracted.statistics)),
        ];
        named.extend(pieces.get(batch).map(|pieces| ("pieces", whole(pieces))));
        named
    });
    let group = GroupSource {
        named: vec![
            ("faces", whole(&extracted.faces)),
            ("edge_vertices", whole(&extracted.edge_vertices)),
            ("edge_faces", whole(&extracted.edge_faces)),
            ("positions", positions),
        ],
        has_boxes: false,
        batches: batches.collect(),
    };
    VolumeSource { table, named: vec![("all_statistics", whole(&extracted.statistics))], groups: vec![group] }
}
