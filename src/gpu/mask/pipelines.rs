//! The pipelines of masks.

use crate::gpu::common::bindings::{entries, float_texture};
use crate::gpu::common::drawing::{Drawn, depth_stencil as state};
use crate::gpu::common::memory::any_error;
use crate::gpu::common::pipelines::Pipelines;
use crate::gpu::common::requirements::check_alive;
use crate::gpu::shadow::errors::ShadowError;
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
    pub(super) fn new(shared: &Pipelines, setting: &Setting) -> Result<Self, ShadowError> {
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
        let state = |writes_depth, stencil| state(depth_stencil, writes_depth, wgpu::CompareFunction::Always, stencil);
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
        let [depth, bit] = tried(shared.device(), ["pipelines of masks", ""], || {
            let whole = wgpu::StencilState::default();
            [("mask_depth", unchanged, state(true, whole)), (entry_point, written, state(false, stencil))].map(
                |(entry_point, target, state)| pipeline(shared, is_sampled, entry_point, target, Some(state), samples),
            )
        })?;
        Ok(Self { volumes, depth, bit })
    }
}

/// Runs `make`, and returns the message of a device that refuses, behind a hint, or that is lost.
pub(super) fn tried<T>(
    device: &wgpu::Device,
    [what, hint]: [&'static str; 2],
    make: impl FnOnce() -> T,
) -> Result<T, ShadowError> {
    any_error(device, make).map_err(|message| {
        let refused = |()| ShadowError::MaskRefused { what, message: format!("{hint}{message}") };
        check_alive(device).map_or_else(ShadowError::Device, refused)
    })
}

/// The layout of the bind group: the texture that is read.
pub(super) fn layout(shared: &Pipelines, is_sampled: bool) -> wgpu::BindGroupLayout {
    shared.layout("mask", entries(wgpu::ShaderStages::FRAGMENT, [(0, float_texture(is_sampled))]))
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
    let stage = if is_sampled { &MASK_SAMPLES } else { &SHADOW_MASKS };
    let module = &shared.module(stage.module, &stage.wgsl());
    shared.draws(&Drawn {
        label: entry_point,
        layouts: &[&layout(shared, is_sampled)],
        vertex: (module, "mask_whole"),
        fragment: Some((module, entry_point)),
        constants: &[],
        primitive: wgpu::PrimitiveState::default(),
        depth_stencil,
        samples,
        targets: &[Some(target)],
    })
}
