//! The bodies and the ground as they are drawn, and pipelines that draw them.

use rimline::wgpu;
use wgpu::{BlendState, ColorWrites, CompareFunction, StencilOperation, TextureFormat};

use super::casters::DrawInputs;
use super::depth::depth_format;
use super::render_resources::{RenderResources, Target};
use crate::render::pipeline_factory::{Pass, depth_state};

#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Onto {
    /// The nearest surface, which this pass finds.
    Nearest,
    /// The nearest again, where the stencil is still 0; which it is no more afterwards, so that faces that coincide add
    /// their light once.
    Lit,
    /// The nearest again, where the stencil is not 0; which it is afterwards.
    Shadowed,
}

/// Draws bodies and ground with fragment shaders of one name.
pub(super) struct ReceiverPipelines {
    surface: wgpu::RenderPipeline,
    ground: wgpu::RenderPipeline,
}

impl ReceiverPipelines {
    pub(super) fn new(
        RenderResources { factory, shaded, geometry, .. }: &RenderResources<'_>,
        target: Target,
        (fragment, onto): (&'static str, Onto),
        (blend, write): (Option<BlendState>, ColorWrites),
    ) -> Self {
        let pipeline = |vertex, source, groups: &[&wgpu::BindGroupLayout]| {
            factory.pipeline(&Pass {
                vertex,
                blend,
                samples: target.samples,
                write,
                depth: Some(onto.state(depth_format(&factory.gpu.device))),
                ..Pass::new(fragment, source, groups, target.format)
            })
        };
        Self {
            surface: pipeline("surface", include_str!("surface.wgsl"), &[shaded, geometry]),
            ground: pipeline("ground", include_str!("ground.wgsl"), &[shaded]),
        }
    }

    /// Draws everything for one light.
    pub(super) fn paint(&self, pass: &mut wgpu::RenderPass<'_>, subject: &DrawInputs<'_>, light: usize) {
        subject.casters.resources.select(pass, light);
        pass.set_pipeline(&self.surface);
        for receiver in &subject.casters.receivers {
            receiver.draw(pass, light);
        }
        if subject.has_ground {
            pass.set_pipeline(&self.ground);
            pass.draw(0..12, 0..1);
        }
    }
}

impl Onto {
    pub(crate) fn state(self, format: TextureFormat) -> wgpu::DepthStencilState {
        let (compare, stencil, pass_op) = match self {
            Self::Nearest => (CompareFunction::Greater, CompareFunction::Always, StencilOperation::Keep),
            Self::Lit => (CompareFunction::Equal, CompareFunction::Equal, StencilOperation::IncrementClamp),
            Self::Shadowed => (CompareFunction::Equal, CompareFunction::NotEqual, StencilOperation::Zero),
        };
        let face = wgpu::StencilFaceState {
            compare: stencil,
            fail_op: StencilOperation::Keep,
            depth_fail_op: StencilOperation::Keep,
            pass_op,
        };
        depth_state(format, self == Self::Nearest, compare, face)
    }
}
