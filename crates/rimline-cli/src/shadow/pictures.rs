//! The passes of a picture with shadows.

use rimline::gpu::ShadowPipelines;
use rimline::{Counting, wgpu};
use wgpu::{ColorWrites, CompareFunction, LoadOp, PrimitiveTopology, StencilFaceState, TextureFormat, TextureUsages};

use super::depth::depth_format;
use super::glass::Glass;
use super::painter::{ADD, MULTIPLY, Onto, Painter, Target, depth_state};
use super::studio::{Attachments, Studio, Subject, draw_volumes};
use crate::device::Gpu;
use crate::gpu_error::GpuError;
use crate::render::kit::Pass;
use crate::shadow::args::ModeArg;

/// Linear light, before it is exposed.
pub(super) const LINEAR: Target = Target { format: TextureFormat::Rgba16Float, samples: 4 };

/// Draws pictures.
pub(crate) struct Pictures {
    pub(crate) pipelines: ShadowPipelines,
    attachments: Attachments,
    resolved: wgpu::TextureView,
    finished: wgpu::Texture,
    backdrop: wgpu::RenderPipeline,
    ambient: Painter,
    lit: Painter,
    /// Marks what turns its back on the light, then shades what is marked or in shadow.
    shade: Option<[Painter; 2]>,
    tone: (wgpu::RenderPipeline, wgpu::BindGroup),
    glass: Option<Glass>,
}

impl Pictures {
    pub(crate) fn new(
        gpu: &Gpu,
        studio: &Studio<'_>,
        counting: Counting,
        mode: ModeArg,
        volumes: bool,
    ) -> Result<Self, GpuError> {
        let kit = &studio.kit;
        let readable = TextureUsages::TEXTURE_BINDING;
        let resolved = studio.target("light", LINEAR.format, 1, readable);
        let format = TextureFormat::Rgba8UnormSrgb;
        let layout = kit.layout(&[wgpu::BindingType::Texture {
            sample_type: wgpu::TextureSampleType::Float { filterable: false },
            view_dimension: wgpu::TextureViewDimension::D2,
            multisampled: false,
        }]);
        let cover = |name, source, groups: &[_], target: Target, depth| {
            let topology = PrimitiveTopology::TriangleList;
            let Target { format, samples } = target;
            let write = ColorWrites::ALL;
            let (vertex, blend, constants) = (name, None, &[][..]);
            kit.pipeline(&Pass {
                name,
                vertex,
                source,
                groups,
                topology,
                format,
                blend,
                samples,
                write,
                depth,
                constants,
            })
        };
        let behind = depth_state(depth_format(kit.device), false, CompareFunction::Always, StencilFaceState::IGNORE);
        let group = kit.group(&layout, &[wgpu::BindingResource::TextureView(&resolved)]);
        let shade = match mode {
            ModeArg::Additive => None,
            ModeArg::Ambient => Some(("ambient", None)),
            ModeArg::Black => Some(("black", None)),
            ModeArg::Composited => Some(("dim", MULTIPLY)),
        };
        Ok(Self {
            pipelines: Studio::pipelines(gpu, LINEAR, counting)?,
            attachments: Attachments::new(studio, LINEAR),
            finished: kit.target("picture", studio.size, format, 1, TextureUsages::COPY_SRC),
            backdrop: cover("backdrop", include_str!("backdrop.wgsl"), &[], LINEAR, Some(behind)),
            ambient: studio.painter(LINEAR, "ambient", Onto::Nearest, None),
            lit: studio.painter(LINEAR, "lit", Onto::Lit, ADD),
            shade: shade.map(|(fragment, blend)| {
                let nothing = ColorWrites::empty();
                [
                    Painter::new(kit, &studio.layouts, LINEAR, "averted", Onto::Lit, None, nothing),
                    studio.painter(LINEAR, fragment, Onto::Shadowed, blend),
                ]
            }),
            tone: (cover("tone", include_str!("tone.wgsl"), &[&layout], Target { format, samples: 1 }, None), group),
            resolved,
            glass: volumes.then(|| Glass::new(gpu, studio)),
        })
    }

    /// Records a picture and returns its texture.
    pub(crate) fn record(
        &self,
        encoder: &mut wgpu::CommandEncoder,
        studio: &Studio<'_>,
        subject: &Subject<'_>,
    ) -> Result<&wgpu::Texture, GpuError> {
        let Subject { casters, has_ground, samples, .. } = *subject;
        let Self { attachments, pipelines, .. } = self;
        {
            let mut pass = attachments.pass(encoder, "ambient", Some(wgpu::Color::BLACK), None);
            studio.select(&mut pass, 0);
            pass.set_pipeline(&self.backdrop);
            pass.draw(0..3, 0..1);
            self.ambient.paint(&mut pass, casters, 0, has_ground);
        }
        for light in 0..samples {
            let mut pass = attachments.pass(encoder, "light", None, None);
            if self.shade.is_none() {
                draw_volumes(&mut pass, pipelines, casters, light)?;
            }
            studio.select(&mut pass, light);
            self.lit.paint(&mut pass, casters, light, has_ground);
        }
        if let Some(shade) = &self.shade {
            for light in 0..samples {
                let mut pass = attachments.pass(encoder, "shade", None, None);
                draw_volumes(&mut pass, pipelines, casters, light)?;
                studio.select(&mut pass, light);
                for painter in shade {
                    painter.paint(&mut pass, casters, light, has_ground);
                }
            }
        }
        let mut pass = attachments.pass(encoder, "resolve", None, Some(&self.resolved));
        if let Some(glass) = &self.glass {
            glass.draw(&mut pass, studio, subject)?;
        }
        drop(pass);
        let finished = self.finished.create_view(&wgpu::TextureViewDescriptor::default());
        let mut pass = encoder.begin_render_pass(&wgpu::RenderPassDescriptor {
            label: Some("tone"),
            color_attachments: &[Some(wgpu::RenderPassColorAttachment {
                view: &finished,
                depth_slice: None,
                resolve_target: None,
                ops: wgpu::Operations { load: LoadOp::Clear(wgpu::Color::BLACK), store: wgpu::StoreOp::Store },
            })],
            ..Default::default()
        });
        pass.set_bind_group(0, &studio.kit.frame_group, &[]);
        pass.set_bind_group(1, &self.tone.1, &[]);
        pass.set_pipeline(&self.tone.0);
        pass.draw(0..3, 0..1);
        Ok(&self.finished)
    }
}
