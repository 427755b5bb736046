//! Recording: settings of casters, lights and a camera; their silhouettes and volumes, by scenes and extractors; the
//! surfaces that receive.

mod fragments;
mod scene;
mod setting;
mod surfaces;

use rimline::gpu::StageTimer;
use wgpu::{LoadOp, Operations, StoreOp, TextureFormat, TextureView};

pub use fragments::FragmentCounter;
pub use scene::{Counted, Drawn, ExtractorRecorder, SceneRecorder, Until, made_anew};
pub use setting::{Camera, Casters, IDENTITY, Setting};
pub use surfaces::{Pass, Surface, Surfaces};

/// A format that every device has.
pub const DEPTH: TextureFormat = TextureFormat::Depth24PlusStencil8;

/// The pass of [`Target::counting`], as the timer has it.
pub const STENCIL: &str = "stencil";

/// A pass: what it draws into, and how that begins. Depths and stencils without a beginning are only read.
#[derive(Clone, Copy, Default)]
pub struct Target<'a> {
    pub color: Option<(&'a TextureView, LoadOp<wgpu::Color>)>,
    pub depth_stencil: Option<&'a TextureView>,
    pub depth: Option<LoadOp<f32>>,
    pub stencil: Option<LoadOp<u32>>,
}

impl<'a> Target<'a> {
    /// Counts volumes, from 0 on.
    pub fn counting(view: &'a TextureView, depth: LoadOp<f32>) -> Self {
        let stencil = Some(LoadOp::Clear(0));
        Self { color: None, depth_stencil: Some(view), depth: Some(depth), stencil }
    }

    pub fn begin(self, encoder: &mut wgpu::CommandEncoder) -> wgpu::RenderPass<'_> {
        self.begin_timed(encoder, "pass", None, None)
    }

    /// The same, timed under a name, with queries.
    pub fn begin_timed<'e>(
        self,
        encoder: &'e mut wgpu::CommandEncoder,
        name: &'static str,
        timer: Option<&mut StageTimer>,
        queries: Option<&wgpu::QuerySet>,
    ) -> wgpu::RenderPass<'e> {
        let store = StoreOp::Store;
        let color = self.color.map(|(view, load)| wgpu::RenderPassColorAttachment {
            view,
            depth_slice: None,
            resolve_target: None,
            ops: Operations { load, store },
        });
        encoder.begin_render_pass(&wgpu::RenderPassDescriptor {
            label: Some(name),
            color_attachments: if color.is_some() { std::slice::from_ref(&color) } else { &[] },
            depth_stencil_attachment: self.depth_stencil.map(|view| wgpu::RenderPassDepthStencilAttachment {
                view,
                depth_ops: self.depth.map(|load| Operations { load, store }),
                stencil_ops: self.stencil.map(|load| Operations { load, store }),
            }),
            timestamp_writes: timer.and_then(|timer| timer.render_pass(name)),
            occlusion_query_set: queries,
            multiview_mask: None,
        })
    }
}
