//! The pipelines of masks.

use super::errors::{MaskError, refused};
use crate::gpu::common::bindings::entries;
use crate::gpu::common::memory::any_error;
use crate::gpu::common::pipelines::Pipelines;
use crate::gpu::shadow::pipelines::Convention;
use crate::gpu::shadow::{ShadowFormat, ShadowPipelines};
use crate::stages::{MASK_SAMPLES, SHADOW_MASKS};

/// The settings of the pipelines of a pass of volumes.
#[derive(Clone, PartialEq, Eq, Debug)]
pub(super) struct Setting {
    pub(super) convention: Convention,
    pub(super) is_in_batches: bool,
    pub(super) depth_stencil: wgpu::TextureFormat,
    /// The format of the bits of lights, or of the target.
    pub(super) color: wgpu::TextureFormat,
    /// Whether the only light is drawn into the target.
    pub(super) is_direct: bool,
    pub(super) samples: u32,
    pub(super) trim: bool,
}

/// The pipelines of a pass of volumes.
#[derive(Debug)]
pub(super) struct Counting {
    pub(super) volumes: ShadowPipelines,
    pub(super) depth: wgpu::RenderPipeline,
    pub(super) bit: wgpu::RenderPipeline,
}

impl Counting {
    pub(super) fn new(shared: &Pipelines, setting: &Setting) -> Result<Self, MaskError> {
        let &Setting { convention, is_in_batches, depth_stencil, color, is_direct, samples, trim } = setting;
        let format = ShadowFormat {
            depth_stencil,
            depth: convention.depth,
            samples,
            colors: vec![Some(color)],
            front_face: convention.front_face(),
            has_far_plane: convention.is_unclipped,
            count_bits: convention.count_bits,
            trim,
        };
        let make = if is_in_batches { ShadowPipelines::in_batches } else { ShadowPipelines::new };
        let volumes = make(shared, &format, convention.counting)?;
        let state = |writes_depth, stencil| wgpu::DepthStencilState {
            format: depth_stencil,
            depth_write_enabled: Some(writes_depth),
            depth_compare: Some(wgpu::CompareFunction::Always),
            stencil,
            bias: wgpu::DepthBiasState::default(),
        };
        // Draws where the stencil is not 0, the reference, and sets it to 0.
        let dark = wgpu::StencilFaceState {
            compare: wgpu::CompareFunction::NotEqual,
            pass_op: wgpu::StencilOperation::Zero,
            ..wgpu::StencilFaceState::IGNORE
        };
        let stencil = wgpu::StencilState { front: dark, back: dark, read_mask: 0xff, write_mask: 0xff };
        let sum = wgpu::BlendComponent {
            src_factor: wgpu::BlendFactor::One,
            dst_factor: wgpu::BlendFactor::One,
            operation: wgpu::BlendOperation::Add,
        };
        let unchanged = wgpu::ColorTargetState { write_mask: wgpu::ColorWrites::empty(), ..color.into() };
        let blend = (!is_direct).then_some(wgpu::BlendState { color: sum, alpha: sum });
        let written = wgpu::ColorTargetState { blend, ..color.into() };
        let entry_point = match color {
            _ if !is_direct => "mask_bit",
            wgpu::TextureFormat::R8Unorm => "mask_dark",
            _ => "mask_dark_bit",
        };
        let is_sampled = samples > 1;
        let pipelines = any_error(shared.device(), || {
            let whole = wgpu::StencilState::default();
            [("mask_depth", unchanged, state(true, whole)), (entry_point, written, state(false, stencil))].map(
                |(entry_point, target, state)| pipeline(shared, is_sampled, entry_point, target, Some(state), samples),
            )
        });
        let [depth, bit] = pipelines.map_err(|message| refused(shared.device(), "pipelines of masks", message))?;
        Ok(Self { volumes, depth, bit })
    }
}

/// The layout of the bind group: the texture that is read.
pub(super) fn layout(shared: &Pipelines, is_sampled: bool) -> wgpu::BindGroupLayout {
    let source = wgpu::BindingType::Texture {
        sample_type: wgpu::TextureSampleType::Float { filterable: false },
        view_dimension: wgpu::TextureViewDimension::D2,
        multisampled: is_sampled,
    };
    shared.layout("mask", entries(wgpu::ShaderStages::FRAGMENT, [(0, source)]))
}

/// A pipeline for a full-screen draw that reads a texture with one sample or several.
pub(super) fn pipeline(
    shared: &Pipelines,
    is_sampled: bool,
    entry_point: &str,
    target: wgpu::ColorTargetState,
    depth_stencil: Option<wgpu::DepthStencilState>,
    samples: u32,
) -> wgpu::RenderPipeline {
    let device = shared.device();
    let stage = if is_sampled { &MASK_SAMPLES } else { &SHADOW_MASKS };
    let module = &shared.module(stage.module, &stage.wgsl());
    let (label, options) = (Some(entry_point), wgpu::PipelineCompilationOptions::default());
    let layout = device.create_pipeline_layout(&wgpu::PipelineLayoutDescriptor {
        label,
        bind_group_layouts: &[Some(&layout(shared, is_sampled))],
        immediate_size: 0,
    });
    device.create_render_pipeline(&wgpu::RenderPipelineDescriptor {
        label,
        layout: Some(&layout),
        vertex: wgpu::VertexState {
            module,
            entry_point: Some("mask_whole"),
            compilation_options: options.clone(),
            buffers: &[],
        },
        primitive: wgpu::PrimitiveState::default(),
        depth_stencil,
        multisample: wgpu::MultisampleState { count: samples, ..Default::default() },
        fragment: Some(wgpu::FragmentState {
            module,
            entry_point: label,
            compilation_options: options,
            targets: &[Some(target)],
        }),
        multiview_mask: None,
        cache: None,
    })
}
