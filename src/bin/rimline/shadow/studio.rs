//! The passes of a picture with shadows.

use rimline::gpu::{Results, ShadowFormat, ShadowPipelines, include_wgsl, results_bind_group_layout};
use rimline::{Counting, wgpu};
use wgpu::{
    BlendState, ColorWrites, CompareFunction, LoadOp, PrimitiveTopology, StencilFaceState, TextureFormat, TextureUsages,
};

use super::body::Body;
use super::caster::Caster;
use super::frame::Frame;
use super::lamps::LampData;
use super::painter::{ADD, DEPTH, Layouts, MULTIPLY, Onto, Painter, Target, depth_state};
use crate::args::ModeArg;
use crate::device::Gpu;
use crate::gpu_error::GpuError;
use crate::render::kit::{Kit, Pass};

/// Linear light, before it is exposed.
const LINEAR: Target = Target { format: TextureFormat::Rgba16Float, samples: 4 };
/// Masks: 255 lit, 0 not, 128 nothing there.
const MASK: Target = Target { format: TextureFormat::R8Unorm, samples: 1 };

/// Everything that stays from frame to frame.
pub(crate) struct Studio<'a> {
    pub(crate) kit: Kit<'a>,
    layouts: Layouts,
    size: [u32; 2],
    lamps: wgpu::Buffer,
    lamp_group: wgpu::BindGroup,
}

/// What a picture is of.
pub(crate) struct Subject<'a> {
    pub(crate) casters: &'a [Caster],
    pub(crate) bodies: &'a [Body<'a>],
    /// Of all lights together.
    pub(crate) samples: usize,
    pub(crate) has_ground: bool,
}

/// From a light's data to the next's.
const STRIDE: u64 = 256;

impl<'a> Studio<'a> {
    pub(crate) fn new(gpu: &'a Gpu, frame: &Frame, size: [u32; 2], samples: usize) -> Self {
        let kit = Kit::new(&gpu.device, &gpu.queue, include_str!("scene.wgsl"), bytemuck::bytes_of(frame));
        let layouts = Layouts::new(&kit);
        let lamps = kit.uniform(&gpu.queue, "lamps", &vec![0; STRIDE as usize * samples]);
        let one = wgpu::BufferBinding {
            buffer: &lamps,
            offset: 0,
            size: wgpu::BufferSize::new(size_of::<LampData>() as u64),
        };
        let lamp_group = kit.group(&layouts.lamp, &[wgpu::BindingResource::Buffer(one)]);
        Self { kit, layouts, size, lamps, lamp_group }
    }

    pub(crate) fn geometry_layout(&self) -> &wgpu::BindGroupLayout {
        &self.layouts.geometry
    }

    /// Frame and lights, for what is submitted from now on.
    pub(crate) fn set(&self, gpu: &Gpu, frame: &Frame, lamps: &[LampData]) {
        self.kit.set_frame(&gpu.queue, bytemuck::bytes_of(frame));
        for (place, lamp) in (0..).map(|number| number * STRIDE).zip(lamps) {
            gpu.queue.write_buffer(&self.lamps, place, bytemuck::bytes_of(lamp));
        }
    }

    fn painter(&self, target: Target, fragment: &'static str, onto: Onto, blend: Option<BlendState>) -> Painter {
        Painter::new(&self.kit, &self.layouts, target, fragment, onto, blend, ColorWrites::ALL)
    }

    fn target(&self, label: &str, format: TextureFormat, samples: u32, usage: TextureUsages) -> wgpu::TextureView {
        self.kit.target(label, self.size, format, samples, usage).create_view(&wgpu::TextureViewDescriptor::default())
    }

    fn select(&self, pass: &mut wgpu::RenderPass<'_>, light: usize) {
        pass.set_bind_group(0, &self.kit.frame_group, &[]);
        pass.set_bind_group(1, &self.lamp_group, &[light as u32 * STRIDE as u32]);
    }

    fn pipelines(gpu: &Gpu, target: Target, counting: Counting) -> Result<ShadowPipelines, GpuError> {
        let format = ShadowFormat {
            depth_stencil: DEPTH,
            samples: target.samples,
            colors: vec![Some(target.format)],
            ..ShadowFormat::default()
        };
        Ok(ShadowPipelines::new(&gpu.device, &format, counting)?)
    }
}

/// A colour target and its depth and stencil.
struct Attachments {
    color: wgpu::TextureView,
    depth: wgpu::TextureView,
}

impl Attachments {
    fn new(studio: &Studio<'_>, target: Target) -> Self {
        let none = TextureUsages::empty();
        Self {
            color: studio.target("color", target.format, target.samples, none | TextureUsages::COPY_SRC),
            depth: studio.target("depth", DEPTH, target.samples, none),
        }
    }

    /// A pass that clears the stencil and goes on with what is there, or clears everything.
    fn pass<'e>(
        &self,
        encoder: &'e mut wgpu::CommandEncoder,
        label: &str,
        clear: Option<wgpu::Color>,
        resolve_target: Option<&wgpu::TextureView>,
    ) -> wgpu::RenderPass<'e> {
        let store = wgpu::StoreOp::Store;
        let depth = if clear.is_some() { LoadOp::Clear(0.0) } else { LoadOp::Load };
        encoder.begin_render_pass(&wgpu::RenderPassDescriptor {
            label: Some(label),
            color_attachments: &[Some(wgpu::RenderPassColorAttachment {
                view: &self.color,
                depth_slice: None,
                resolve_target,
                ops: wgpu::Operations { load: clear.map_or(LoadOp::Load, LoadOp::Clear), store },
            })],
            depth_stencil_attachment: Some(wgpu::RenderPassDepthStencilAttachment {
                view: &self.depth,
                depth_ops: Some(wgpu::Operations { load: depth, store }),
                stencil_ops: Some(wgpu::Operations { load: LoadOp::Clear(0), store }),
            }),
            timestamp_writes: None,
            occlusion_query_set: None,
            multiview_mask: None,
        })
    }
}

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
        let behind = depth_state(false, CompareFunction::Always, StencilFaceState::IGNORE);
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
                casters.iter().for_each(|caster| caster.volumes.draw(&mut pass, pipelines, light));
            }
            studio.select(&mut pass, light);
            self.lit.paint(&mut pass, casters, light, has_ground);
        }
        if let Some(shade) = &self.shade {
            for light in 0..samples {
                let mut pass = attachments.pass(encoder, "shade", None, None);
                casters.iter().for_each(|caster| caster.volumes.draw(&mut pass, pipelines, light));
                studio.select(&mut pass, light);
                shade.iter().for_each(|painter| painter.paint(&mut pass, casters, light, has_ground));
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

/// Draws the volumes themselves.
struct Glass {
    layout: wgpu::BindGroupLayout,
    sides: wgpu::RenderPipeline,
    edges: wgpu::RenderPipeline,
}

impl Glass {
    fn new(gpu: &Gpu, studio: &Studio<'_>) -> Self {
        let layout = results_bind_group_layout(&gpu.device, wgpu::ShaderStages::VERTEX);
        let source = format!("{}\n{}", include_wgsl(2), include_str!("volumes.wgsl"));
        let pipeline = |name, topology| {
            studio.kit.pipeline(&Pass {
                name,
                vertex: name,
                source: &source,
                groups: &[&studio.layouts.lamp, &layout],
                topology,
                format: LINEAR.format,
                blend: Some(BlendState::ALPHA_BLENDING),
                samples: LINEAR.samples,
                write: ColorWrites::ALL,
                depth: Some(depth_state(false, CompareFunction::Greater, StencilFaceState::IGNORE)),
                constants: &[],
            })
        };
        Self {
            sides: pipeline("volumes", PrimitiveTopology::TriangleStrip),
            edges: pipeline("edges", PrimitiveTopology::LineStrip),
            layout,
        }
    }

    fn draw(
        &self,
        pass: &mut wgpu::RenderPass<'_>,
        studio: &Studio<'_>,
        subject: &Subject<'_>,
    ) -> Result<(), GpuError> {
        for (caster, body) in subject.casters.iter().zip(subject.bodies) {
            let extractor = &caster.extractor;
            for light in 0..subject.samples {
                let group = extractor.results_bind_group(&self.layout, light / 32, body.positions.buffer())?;
                studio.select(pass, light);
                pass.set_bind_group(2, &group, &[]);
                for pipeline in [&self.sides, &self.edges] {
                    pass.set_pipeline(pipeline);
                    pass.draw_indirect(extractor.results().draw_arguments, Results::draw_offset(light));
                }
            }
        }
        Ok(())
    }
}

/// Draws masks: of one light or sample at a time.
pub(crate) struct Masks {
    pub(crate) pipelines: ShadowPipelines,
    attachments: Attachments,
    finished: wgpu::Texture,
    dark: Painter,
    lit: Painter,
}

impl Masks {
    pub(crate) fn new(gpu: &Gpu, studio: &Studio<'_>, counting: Counting) -> Result<Self, GpuError> {
        let finished = studio.kit.target("mask", studio.size, MASK.format, MASK.samples, TextureUsages::COPY_SRC);
        let color = finished.create_view(&wgpu::TextureViewDescriptor::default());
        let depth = studio.target("depth", DEPTH, MASK.samples, TextureUsages::empty());
        Ok(Self {
            pipelines: Studio::pipelines(gpu, MASK, counting)?,
            attachments: Attachments { color, depth },
            dark: studio.painter(MASK, "dark", Onto::Nearest, None),
            lit: studio.painter(MASK, "mask", Onto::Lit, None),
            finished,
        })
    }

    /// Records a light's mask and returns its texture.
    pub(crate) fn record(
        &self,
        encoder: &mut wgpu::CommandEncoder,
        studio: &Studio<'_>,
        subject: &Subject<'_>,
        light: usize,
    ) -> &wgpu::Texture {
        let Subject { casters, has_ground, .. } = *subject;
        let grey = 128.0 / 255.0;
        let nothing = wgpu::Color { r: grey, g: grey, b: grey, a: 1.0 };
        let mut pass = self.attachments.pass(encoder, "mask", Some(nothing), None);
        studio.select(&mut pass, light);
        self.dark.paint(&mut pass, casters, light, has_ground);
        casters.iter().for_each(|caster| caster.volumes.draw(&mut pass, &self.pipelines, light));
        studio.select(&mut pass, light);
        self.lit.paint(&mut pass, casters, light, has_ground);
        &self.finished
    }
}
