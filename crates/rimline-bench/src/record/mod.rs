//! Recording: settings of casters, lights and a camera; their silhouettes and volumes, by scenes and mesh by mesh; the
//! surfaces that receive.

mod fragments;
mod meshes;
mod one_caster;
mod scene;
mod setting;
mod surfaces;

use rimline::gpu::StageTimer;
use wgpu::{LoadOp, Operations, StoreOp, TextureFormat};

pub use fragments::FragmentCounter;
pub use meshes::Meshes;
pub use one_caster::{OneCaster, OneCasterOptions, OneFrame};
pub use scene::{Counted, SceneRecorder};
pub use setting::{Camera, Casters, IDENTITY, Setting};
pub use surfaces::{Pass, Surface, Surfaces};

use crate::Error;

/// A format that every device has.
pub const DEPTH: TextureFormat = TextureFormat::Depth24PlusStencil8;

/// How far a frame is recorded.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Until {
    /// Silhouettes are extracted.
    Extraction,
    /// Volumes are prepared for a view.
    Volumes,
}

/// Records the compute stages of frames, and draws their volumes.
pub trait Recorder {
    fn encode(
        &mut self,
        encoder: &mut wgpu::CommandEncoder,
        until: Until,
        timer: Option<&mut StageTimer>,
    ) -> Result<(), Error>;

    /// Draws the volumes of a light into a stencil pass.
    fn draw(&self, pass: &mut wgpu::RenderPass<'_>, light: usize) -> Result<(), Error>;
}

/// The pass of [`stencil_pass`], as the timer has it.
pub const STENCIL: &str = "stencil";

/// A pass that counts the volumes of a light, from 0 on.
pub fn stencil_pass<'a>(
    encoder: &'a mut wgpu::CommandEncoder,
    depth: &wgpu::TextureView,
    load: LoadOp<f32>,
    timer: Option<&mut StageTimer>,
    queries: Option<&wgpu::QuerySet>,
) -> wgpu::RenderPass<'a> {
    encoder.begin_render_pass(&wgpu::RenderPassDescriptor {
        label: Some(STENCIL),
        color_attachments: &[],
        depth_stencil_attachment: Some(wgpu::RenderPassDepthStencilAttachment {
            view: depth,
            depth_ops: Some(Operations { load, store: StoreOp::Store }),
            stencil_ops: Some(Operations { load: LoadOp::Clear(0), store: StoreOp::Store }),
        }),
        timestamp_writes: timer.and_then(|timer| timer.render_pass(STENCIL)),
        occlusion_query_set: queries,
        multiview_mask: None,
    })
}
