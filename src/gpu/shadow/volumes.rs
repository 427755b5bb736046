//! The shadow volumes of one caster.

use std::sync::Arc;

use super::buffers::{Buffers, SIDE_COUNTS, fitting_capacity, fitting_sides};
use super::choice::{Choice, Groups};
use super::draws::DrawGroups;
use super::errors::{ShadowEncodeError, ShadowVolumesError};
use super::frame::{ShadowFrame, Shared};
use super::options::ShadowOptions;
use super::pipelines::{Convention, ShadowPipelines};
use crate::ShadowCamera;
use crate::gpu::common::dispatch_limits::{WORKGROUP, binding};
use crate::gpu::common::memory::MemoryError;
use crate::gpu::common::pipelines::group;
use crate::gpu::common::positions;
use crate::gpu::common::requirements::{Subject, check_same, check_timer};
use crate::gpu::common::timer::StageTimer;
use crate::gpu::common::uniforms::upload;
use crate::gpu::extract::errors::ExtractionIncludeError;
use crate::gpu::extract::extraction::{Extraction, Place};
use crate::gpu::extract::extractor::Extractor;
use crate::layout::{ShadowDraw, ShadowLight, ShadowShape};
use crate::light::{self, check_shadow_lights};

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
        let (device, split, extraction) = (source.device(), &source.limits, &source.shape);
        let face_count = extraction.faces;
        let fitting = u32::try_from(fitting_sides(extraction.batch_lights(0), split)).unwrap_or(u32::MAX);
        let side_capacity = extraction.capacity.min(fitting);
        let lists_all = options.end_at_range || pipelines.counting().may_fail();
        let cap_capacity = options.cap_capacity.map_or_else(
            || {
                let wanted = if lists_all { face_count } else { 1024 + 16 * face_count.isqrt() };
                wanted.min(fitting_capacity(extraction, split, side_capacity, options.memory_limit))
            },
            |capacity| capacity as usize,
        );
        let cap_capacity = cap_capacity.clamp(1, face_count.max(1));
        let workgroups = device.limits().max_compute_workgroups_per_dimension;
        let most = |wanted: usize| (wanted as u32).clamp(1, workgroups);
        let shape = ShadowShape {
            lights: 0,
            faces: face_count as u32,
            edges: extraction.edges as u32,
            capacity: extraction.capacity,
            cap_capacity: cap_capacity as u32,
            averted: u32::from(source.is_closed && !options.every_face),
            counting: pipelines.counting().code(),
            skip_unseen: u32::from(options.skip_unseen),
            position_offset: 0,
            position_stride: 0,
            cap_groups: most(face_count.div_ceil(WORKGROUP as usize)),
            end_at_range: u32::from(options.end_at_range),
            side_capacity,
            reserved_0: 0,
            reserved_1: 0,
            reserved_2: 0,
        };
        if source.buffers.faces.size() > split.binding {
            let (bytes, limit) = (source.buffers.faces.size(), split.binding);
            return Err(MemoryError::Binding { what: "faces", bytes, limit }.into());
        }
        let buffers = Buffers::new(source, cap_capacity, side_capacity, options.memory_limit)?;
        let choice = Choice::new(
            pipelines.shared(),
            &buffers,
            &source.results(),
            &source.buffers.excluded,
            pipelines.counting(),
            options,
        );
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
        let shape = ShadowShape {
            lights: lights.len() as u32,
            position_offset: bound.offset_words,
            position_stride: bound.stride_words,
            ..self.shape
        };
        let seen: Vec<ShadowLight> = lights.iter().map(|&light| camera.light(&view, light)).collect();
        let batches = light::batches(lights.len());
        let Shared { buffers, source, .. } = &*self.shared;
        let device = source.device();
        upload(device, encoder, &buffers.shape, bytemuck::bytes_of(&shape))?;
        upload(device, encoder, &buffers.view, bytemuck::bytes_of(&view))?;
        upload(device, encoder, &buffers.lights, bytemuck::cast_slice(&seen))?;
        upload(device, encoder, &buffers.bounds, bytemuck::cast_slice(&[u32::MAX, u32::MAX, u32::MAX, 0, 0, 0, 0]))?;
        upload(device, encoder, &buffers.cap_dispatches, bytemuck::cast_slice(&[0_u32, 1, 1].repeat(batches)))?;
        encoder.clear_buffer(&buffers.cap_counts, 0, None);
        for sides in buffers.sides.iter().take(batches) {
            encoder.clear_buffer(sides, 0, Some(SIDE_COUNTS));
        }
        encoder.clear_buffer(&buffers.draws, 0, None);
        encoder.clear_buffer(&buffers.statistics, 0, None);
        if !lights.is_empty() {
            // An invocation takes some 64 faces. So there are few atomics, and all cores have work.
            let most = u32::try_from(source.limits.workgroups).unwrap_or(u32::MAX);
            let groups = Groups {
                bounds: (source.shape.faces as u32).div_ceil(64 * 64).clamp(1, 1024).min(most),
                lights: (lights.len() as u32).div_ceil(64).min(most),
                // An invocation takes some sixteen sides of a list that is full.
                sides: self.shape.side_capacity.div_ceil(16 * 64).clamp(1, 256).min(most),
            };
            self.choice.record(encoder, buffers, groups, lights.len(), timer);
        }
        Ok(ShadowFrame::new(Arc::clone(&self.shared), groups, extraction.clone()))
    }

    /// The [`ShadowStatistics`](crate::gpu::ShadowStatistics) of the last encode, once its encoder was submitted. Usage
    /// `COPY_SRC`.
    pub fn statistics(&self) -> &wgpu::Buffer {
        &self.shared.buffers.statistics
    }

    /// The choices for each light of the last encode, as [`ShadowLight`]s, once its encoder was submitted. Usage
    /// `COPY_SRC`.
    #[cfg(feature = "reference")]
    pub fn lights(&self) -> &wgpu::Buffer {
        &self.shared.buffers.lights
    }

    /// The draws of each light, as [`ShadowDraws`](crate::layout::ShadowDraws), once the encoder was submitted. Usages
    /// `INDIRECT` and `COPY_SRC`.
    #[cfg(feature = "reference")]
    pub fn draw_arguments(&self) -> &wgpu::Buffer {
        &self.shared.buffers.draws
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
            self.choice.bind_positions(device, buffers, &results, excluded, place.buffer, &bound);
        })?;
        let whole = wgpu::Buffer::as_entire_binding;
        let group = |layout: &wgpu::BindGroupLayout, resources: &[wgpu::BindingResource<'_>]| {
            group(device, "shadow volumes", layout, resources)
        };
        let frame = group(
            &layouts.frame,
            &[
                whole(&buffers.shape),
                whole(&buffers.view),
                binding(&buffers.draw_lights, 0..size_of::<ShadowDraw>() as u64),
                whole(&buffers.lights),
            ],
        );
        let placed = bound.first_binding(place.buffer);
        let per_batch = || results.facing.iter().zip(excluded);
        let caps = per_batch().zip(&buffers.cap_lists).map(|((facing, excluded), list)| {
            let [faces, facing, counts] = [&buffers.faces, facing, &buffers.cap_counts].map(whole);
            group(&layouts.cap_data, &[placed.clone(), faces, facing, counts, whole(list), whole(excluded)])
        });
        let sides = per_batch().zip(&buffers.sides).map(|((facing, excluded), sides)| {
            let [vertices, faces] = [results.edge_vertices, results.edge_faces].map(whole);
            group(&layouts.side_data, &[placed.clone(), vertices, faces, whole(facing), whole(excluded), whole(sides)])
        });
        let groups = Arc::new(DrawGroups { frame, sides: sides.collect(), caps: caps.collect() });
        self.bound = Some((extraction.place.clone(), Arc::clone(&groups)));
        Ok(groups)
    }
}
