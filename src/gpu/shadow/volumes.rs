//! The shadow volumes of one caster.

use std::sync::Arc;

use super::buffers::{Buffers, CAP_COUNTS, CHOICES, Capacities, SIDE_COUNTS, fitting, fitting_caps};
use super::choice::{Choice, Groups};
use super::errors::{ShadowEncodeError, ShadowVolumesError};
use super::frame::{DrawGroups, ShadowFrame, Shared};
use super::options::ShadowOptions;
use super::pipelines::{Convention, ShadowPipelines};
use crate::gpu::common::dispatch_limits::{WORKGROUP, binding};
use crate::gpu::common::memory::MemoryError;
use crate::gpu::common::pipelines::group;
use crate::gpu::common::positions;
use crate::gpu::common::requirements::{Subject, check_same, check_timer};
use crate::gpu::common::timer::StageTimer;
use crate::gpu::common::uniforms::upload;
use crate::gpu::extract::errors::ExtractionIncludeError;
use crate::gpu::extract::extraction::{self, Extraction, Place};
use crate::gpu::extract::extractor::Extractor;
use crate::layout::{SceneCaster, SeenLight, ShadowDraw, ShadowShape};
use crate::light::{self, check_shadow_lights};
use crate::{Counting, ShadowCamera};

/// Where choices begin in the table of one caster, in units of 16 bytes.
const BEHIND_CASTER: u32 = (size_of::<SceneCaster>() / 16) as u32;

/// The largest number of turns of an invocation's loops. llvmpipe (Mesa 22.3) ends them after 65,535.
const MOST_TURNS: u32 = 60_000;

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
/// hairline of light or shadow can appear. See NUMERICS.md, "Hairlines".
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
/// let extraction = extractor.encode(encoder, vertices, &lights, None)?;
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
    choice: Choice,
    bound: Option<(Place, Arc<DrawGroups>)>,
    shape: ShadowShape,
}

impl ShadowVolumes {
    /// Makes buffers on the device of `pipelines`, for the mesh that `extractor` was made for. `extractor` must be on
    /// the same device. `pipelines` also provides the compute pipelines.
    ///
    /// # Errors
    /// [`ShadowVolumesError`] if the extractor lacks lists or facing masks or is on another device, or the mesh does
    /// not fit the device.
    pub fn new(
        pipelines: &ShadowPipelines,
        extractor: &Extractor,
        options: ShadowOptions,
    ) -> Result<Self, ShadowVolumesError> {
        let devices = [extractor.shared().device(), pipelines.shared().device()];
        check_same(["the extractor", "the pipelines"], devices)?;
        pipelines.shared().construct(Subject::Shadow, || Self::with(pipelines, extractor, options))
    }

    fn with(
        pipelines: &ShadowPipelines,
        extractor: &Extractor,
        options: ShadowOptions,
    ) -> Result<Self, ShadowVolumesError> {
        let source = extractor.shared();
        source.check_include()?;
        let (split, extraction) = (&source.limits, &source.shape);
        let face_count = extraction.faces;
        let capacities = capacities(source, pipelines.counting(), options);
        let shape = ShadowShape {
            casters: 1,
            lights: 0,
            batches: extraction.batches() as u32,
            faces: face_count as u32,
            edges: extraction.edges as u32,
            capacity: extraction.capacity,
            side_capacity: capacities.sides,
            near_capacity: capacities.near,
            far_capacity: capacities.far,
            averted: u32::from(!options.every_face),
            counting: pipelines.counting().code(),
            skip_unseen: u32::from(options.skip_unseen),
            end_at_range: u32::from(options.end_at_range),
            choices_at: BEHIND_CASTER,
            measures_at: BEHIND_CASTER + 2 * extraction.batches() as u32,
            lights_at: 0,
            face_chunks_at: 0,
            edge_chunks_at: 0,
            views: 1,
            count_batches: 1,
        };
        if source.buffers.faces.size() > split.binding {
            let (bytes, limit) = (source.buffers.faces.size(), split.binding);
            return Err(MemoryError::Binding { what: "faces", bytes, limit }.into());
        }
        let buffers = Buffers::new(source, capacities, options)?;
        let choice = Choice::new(pipelines.shared(), &buffers, source, pipelines.counting());
        let shared = Shared::new(Arc::clone(source), buffers, pipelines, options.end_at_range);
        Ok(Self { shared: Arc::new(shared), choice, bound: None, shape })
    }

    /// Records the stages that choose and list for `camera`, and returns what can be drawn. Call it after the encode that
    /// returned `extraction`. Lights and their ranges are those of the extraction; it may have none. The camera takes
    /// positions in their own space. `timer` takes a timestamp around each stage.
    ///
    /// # Errors
    /// [`ShadowEncodeError`] if camera or lights are refused, or the extraction belongs to another extractor or is out
    /// of date. Nothing is recorded then.
    pub fn encode(
        &mut self,
        encoder: &mut wgpu::CommandEncoder,
        extraction: &Extraction,
        camera: &ShadowCamera,
        timer: Option<&mut StageTimer>,
    ) -> Result<ShadowFrame, ShadowEncodeError> {
        self.check(extraction, camera)?;
        check_timer(timer.as_deref(), extraction.shared.device())?;
        let view = camera.view()?;
        let lights = extraction.lights();
        let bound = extraction.bound()?;
        let groups = self.bind(extraction)?;
        let Shared { buffers, source, .. } = &*self.shared;
        let shape = ShadowShape { lights: lights.len() as u32, ..self.shape };
        let seen = |&light| SeenLight { view, light: camera.light(&view, light), reserved: [[0; 4]; 15] };
        let seen: Vec<SeenLight> = lights.iter().map(seen).collect();
        let caster = SceneCaster {
            row_0: [1.0, 0.0, 0.0, 0.0],
            row_1: [0.0, 1.0, 0.0, 0.0],
            row_2: [0.0, 0.0, 1.0, 0.0],
            low: [0.0; 3],
            scale: 1.0,
            high: [0.0; 3],
            flags: u32::from(source.is_closed),
            first_face_slot: 0,
            faces: shape.faces,
            first_face: 0,
            position_offset: bound.offset_words,
            first_edge_slot: 0,
            edges: shape.edges,
            first_edge: 0,
            position_stride: bound.stride_words,
            reserved: [0; 4],
        };
        let uploads: [(&wgpu::Buffer, &[u8]); 3] = [
            (&buffers.shape, bytemuck::bytes_of(&shape)),
            (&buffers.seen, bytemuck::cast_slice(&seen)),
            (&buffers.table, bytemuck::bytes_of(&caster)),
        ];
        upload(source.device(), encoder, &uploads)?;
        encoder.clear_buffer(&buffers.boxes, 0, None);
        encoder.clear_buffer(&buffers.choices, 0, Some(CHOICES * u64::from(shape.batches)));
        for (lists, counts) in [(&buffers.sides, SIDE_COUNTS), (&buffers.caps, CAP_COUNTS)] {
            for list in lists.iter().take(light::batches(lights.len())) {
                encoder.clear_buffer(list, 0, Some(counts));
            }
        }
        encoder.clear_buffer(&buffers.draws, 0, None);
        encoder.clear_buffer(&buffers.statistics, 0, None);
        if let Some(bound) = &buffers.bound {
            encoder.clear_buffer(&bound.crossings, 0, None);
        }
        if !lights.is_empty() {
            let work = self.workgroups(lights.len());
            self.choice.record(encoder, buffers, work, lights.len(), timer);
        }
        Ok(ShadowFrame::new(Arc::clone(&self.shared), groups, extraction.clone()))
    }

    /// The [`ShadowStatistics`](crate::gpu::ShadowStatistics) of the last encode, once its encoder was submitted. Usage
    /// `COPY_SRC`.
    pub fn statistics(&self) -> &wgpu::Buffer {
        &self.shared.buffers.statistics
    }

    /// The choices for the last encode, once its encoder was submitted: what `reference::cpu::chosen` reads. Usage
    /// `COPY_SRC`.
    #[cfg(feature = "reference")]
    pub fn choices(&self) -> &wgpu::Buffer {
        &self.shared.buffers.choices
    }

    /// Lights and camera of the last encode, as [`SeenLight`]s, once its encoder was submitted. Usage `COPY_SRC`.
    #[cfg(feature = "reference")]
    pub fn seen(&self) -> &wgpu::Buffer {
        &self.shared.buffers.seen
    }

    /// The sizes of the volumes, for no lights.
    #[cfg(feature = "reference")]
    pub fn shape(&self) -> ShadowShape {
        self.shape
    }

    /// The draws of each light, as [`ShadowDraws`](crate::layout::ShadowDraws), once the encoder was submitted. Usages
    /// `INDIRECT` and `COPY_SRC`.
    #[cfg(feature = "reference")]
    pub fn draw_arguments(&self) -> &wgpu::Buffer {
        &self.shared.buffers.draws
    }

    /// The workgroups of the stages for this number of lights.
    fn workgroups(&self, lights: usize) -> Groups {
        let source = &self.shared.source;
        let most = u32::try_from(source.limits.workgroups).unwrap_or(u32::MAX);
        let faces = source.shape.faces as u32;
        // A CPU executes invocations without work one after another, so it gets few, each of which takes many faces. There
        // are never so many that an invocation's loops end early: ARCHITECTURE.md, "Limits of devices".
        let is_cpu = source.device().adapter_info().device_type == wgpu::DeviceType::Cpu;
        let fewest = if is_cpu { 64 } else { 4096 };
        let turns = MOST_TURNS / 33;
        Groups {
            // An invocation takes some 64 faces. So there are few atomics, and all cores have work.
            bounds: faces.div_ceil(64 * 64).clamp(1, 1024).min(most),
            lights: (lights as u32).div_ceil(64).min(most),
            caps: faces.div_ceil(WORKGROUP).clamp(1, fewest).max(faces.div_ceil(WORKGROUP * turns)).min(most),
            // An invocation takes some sixteen sides of a list that is full.
            sides: self.shape.side_capacity.div_ceil(16 * 64).clamp(1, 256).min(most),
        }
    }

    /// Refuses input that would draw wrong shadows: an extraction of another extractor or out of date, or a camera that
    /// the pipelines are not for.
    fn check(&self, extraction: &Extraction, camera: &ShadowCamera) -> Result<(), ShadowEncodeError> {
        let Shared { source, convention, .. } = &*self.shared;
        if !Arc::ptr_eq(source, &extraction.shared) {
            return Err(ShadowEncodeError::OtherExtractor);
        }
        extraction.check_current()?;
        check_shadow_lights(extraction.lights(), source.shape.max_lights)?;
        let &Convention { counting, depth, .. } = convention;
        if camera.depth != depth {
            return Err(ShadowEncodeError::Depth { camera: camera.depth, pipelines: depth });
        }
        if convention.needs_far_end() && camera.has_far_plane() {
            return Err(ShadowEncodeError::FarPlane { counting });
        }
        Ok(())
    }

    /// Makes the bind groups that read positions, unless they exist for this place.
    fn bind(&mut self, extraction: &Extraction) -> Result<Arc<DrawGroups>, ShadowEncodeError> {
        if let Some((place, groups)) = &self.bound
            && *place == extraction.place
        {
            return Ok(Arc::clone(groups));
        }
        let Shared { buffers, source, layouts, .. } = &*self.shared;
        let (device, results) = (source.device(), source.results());
        let place = extraction.positions();
        let bound = extraction.bound()?;
        source.check_single_bindings(&bound).map_err(ExtractionIncludeError::from)?;
        let excluded = &source.buffers.excluded;
        positions::bound(device, || {
            self.choice.bind_positions(buffers, source, place.buffer, &bound);
        })?;
        let whole = wgpu::Buffer::as_entire_binding;
        let group = |layout: &wgpu::BindGroupLayout, resources: &[wgpu::BindingResource<'_>]| {
            group(device, "shadow volumes", layout, resources)
        };
        let frame = group(
            &layouts.frame,
            &[
                whole(&buffers.shape),
                binding(&buffers.draw_lights, 0..size_of::<ShadowDraw>() as u64),
                binding(&buffers.seen, 0..size_of::<SeenLight>() as u64),
                whole(&buffers.table),
            ],
        );
        let placed = bound.first_binding(place.buffer);
        let per_batch = || results.facing.iter().zip(excluded).map(|(facing, excluded)| [facing, excluded].map(whole));
        let caps = per_batch().zip(&buffers.caps).map(|([facing, excluded], list)| {
            group(&layouts.cap_data, &[placed.clone(), whole(&buffers.faces), facing, excluded, whole(list)])
        });
        let sides = per_batch().zip(&buffers.sides).map(|([facing, excluded], list)| {
            let [vertices, faces] = [results.edge_vertices, results.edge_faces].map(whole);
            group(&layouts.side_data, &[placed.clone(), vertices, faces, facing, excluded, whole(list)])
        });
        let groups = Arc::new(DrawGroups { frame, sides: sides.collect(), caps: caps.collect() });
        self.bound = Some((extraction.place.clone(), Arc::clone(&groups)));
        Ok(groups)
    }
}

/// Room for the lists of each light.
fn capacities(source: &extraction::Shared, counting: Counting, options: ShadowOptions) -> Capacities {
    let (split, shape) = (&source.limits, &source.shape);
    let faces = shape.faces.max(1) as u32;
    let sides = shape.capacity.min(fitting(shape.batch_lights(0), SIDE_COUNTS, split));
    let has_near = !matches!(counting, Counting::ZPass | Counting::ZFail);
    let has_far = counting.may_fail() || options.end_at_range;
    if let Some(capacity) = options.cap_capacity {
        let asked = |is_there: bool| if is_there { capacity.clamp(1, faces) } else { 1 };
        return Capacities { sides, near: asked(has_near), far: asked(has_far) };
    }
    let some = faces.min(1024 + 16 * faces.isqrt());
    let near = match (has_near, counting.is_zp_plus_2005()) {
        (true, true) => faces,
        (true, false) => some,
        (false, _) => 1,
    };
    let far = if has_far { faces } else { 1 };
    let room = fitting_caps(shape, split, Capacities { sides, near, far }, options.memory_limit);
    // What is short is shared in proportion.
    let share = |wanted: u32| {
        let share = u64::from(wanted) * u64::from(room) / u64::from(near + far);
        u32::try_from(share).unwrap_or(u32::MAX).clamp(1, wanted)
    };
    Capacities { sides, near: share(near), far: share(far) }
}
