//! The passes of a picture with shadows, and of masks: whether a light reaches the surface at each pixel centre. And the
//! pipelines that draw bodies and ground.

use rimline::wgpu;
use wgpu::{
    BlendState, ColorWrites, CompareFunction, StencilFaceState, StencilOperation, TextureFormat, TextureUsages,
};

use super::casters::{Casters, DrawInputs};
use super::depth::depth_format;
use super::frame::{PARTS, Part};
use super::overlay::Overlay;
use super::render_resources::{Attachments, RenderResources, Target};
use super::shadows::{ShadowMethod, VolumePipelines};
use crate::gpu_error::GpuError;
use crate::render::pipeline_factory::{
    ADD, MULTIPLY, Pass, color_pass, depth_state, plain_texture, read_texture, view,
};
use crate::shadow::args::ModeArg;

/// Linear light, before it is exposed.
const LINEAR: Target = Target { format: TextureFormat::Rgba16Float, samples: 4 };
/// The same of a part of the picture.
const PART: Target = Target { format: LINEAR.format, samples: 1 };

pub(crate) struct Pictures {
    pub(crate) pipelines: VolumePipelines,
    /// Attachments of the whole picture or of its parts.
    attachments: Vec<Attachments>,
    /// The average of the whole picture's samples.
    resolved: Option<wgpu::TextureView>,
    finished: wgpu::Texture,
    backdrop: wgpu::RenderPipeline,
    ambient: ReceiverPipelines,
    lit: ReceiverPipelines,
    /// Marks what turns its back on the light, then shades what is marked or in shadow.
    shade: Option<[ReceiverPipelines; 2]>,
    tone: (wgpu::RenderPipeline, wgpu::BindGroup),
    overlay: Option<Overlay>,
}

impl Pictures {
    pub(crate) fn new(
        resources: &RenderResources<'_>,
        method: &ShadowMethod,
        mode: ModeArg,
        volumes: bool,
        in_parts: bool,
    ) -> Result<Self, GpuError> {
        let factory = &resources.factory;
        let linear = if in_parts { PART } else { LINEAR };
        let (attachments, light) = if in_parts { parts(resources) } else { whole(resources) };
        let dimension = if in_parts { wgpu::TextureViewDimension::D2Array } else { wgpu::TextureViewDimension::D2 };
        let source = include_str!("picture.wgsl");
        let layout = factory.layout(&[read_texture(dimension, false)]);
        let behind =
            depth_state(depth_format(&factory.gpu.device), false, CompareFunction::Always, StencilFaceState::IGNORE);
        let backdrop = factory.pipeline(&Pass {
            samples: linear.samples,
            depth: Some(behind),
            ..Pass::over("backdrop", source, &[], linear.format)
        });
        let format = TextureFormat::Rgba8UnormSrgb;
        let name = if in_parts { "tone_parts" } else { "tone" };
        let tone = factory.pipeline(&Pass::over(name, source, &[&layout], format));
        let group = factory.group(&layout, &[wgpu::BindingResource::TextureView(&light)]);
        let all = ColorWrites::ALL;
        let shade = match mode {
            ModeArg::Additive => None,
            ModeArg::Ambient => Some(("ambient", None)),
            ModeArg::Black => Some(("black", None)),
            ModeArg::Composited => Some(("dim", Some(MULTIPLY))),
        };
        Ok(Self {
            pipelines: resources.pipelines(linear, method)?,
            attachments,
            finished: factory.target("picture", resources.size, format, 1, TextureUsages::COPY_SRC),
            backdrop,
            ambient: ReceiverPipelines::new(resources, linear, ("ambient", Onto::Nearest), (None, all)),
            lit: ReceiverPipelines::new(resources, linear, ("lit", Onto::Lit), (Some(ADD), all)),
            shade: shade.map(|(fragment, blend)| {
                [
                    ReceiverPipelines::new(resources, linear, ("averted", Onto::Lit), (None, ColorWrites::empty())),
                    ReceiverPipelines::new(resources, linear, (fragment, Onto::Shadowed), (blend, all)),
                ]
            }),
            tone: (tone, group),
            resolved: (!in_parts).then_some(light),
            overlay: volumes.then(|| Overlay::new(resources, linear, method.from_depth.is_some())),
        })
    }

    /// Records the whole picture's light, or a part's.
    pub(crate) fn record(
        &self,
        encoder: &mut wgpu::CommandEncoder,
        subject: &DrawInputs<'_>,
        part: usize,
    ) -> Result<(), GpuError> {
        let shadows = &subject.casters.shadows;
        let attachments = &self.attachments[part];
        let mut pass = subject.begin(attachments.pass(encoder, "ambient", Some(wgpu::Color::BLACK), None));
        subject.casters.resources.factory.draw(&mut pass, &self.backdrop, &[], 3);
        self.ambient.paint(&mut pass, subject, 0);
        drop(pass);
        for light in 0..subject.samples {
            let mut pass = subject.begin(attachments.pass(encoder, "light", None, None));
            if self.shade.is_none() {
                shadows.draw(&mut pass, &self.pipelines, light)?;
            }
            self.lit.paint(&mut pass, subject, light);
        }
        for (light, shade) in (0..subject.samples).flat_map(|light| self.shade.iter().map(move |shade| (light, shade)))
        {
            let mut pass = subject.begin(attachments.pass(encoder, "shade", None, None));
            shadows.draw(&mut pass, &self.pipelines, light)?;
            for receivers in shade {
                receivers.paint(&mut pass, subject, light);
            }
        }
        let mut pass = subject.begin(attachments.pass(encoder, "resolve", None, self.resolved.as_ref()));
        self.overlay.as_ref().map_or(Ok(()), |overlay| overlay.draw(&mut pass, subject))
    }

    /// Records how the light becomes a picture, and returns its texture.
    pub(crate) fn develop(&self, encoder: &mut wgpu::CommandEncoder, casters: &Casters<'_>) -> &wgpu::Texture {
        let (target, black) = (view(&self.finished), Some(wgpu::Color::BLACK));
        let mut pass = color_pass(encoder, "tone", (&target, None), black, None);
        casters.resources.factory.draw(&mut pass, &self.tone.0, &[&self.tone.1], 3);
        drop(pass);
        &self.finished
    }
}

/// The attachments of a whole picture and the texture of its light.
fn whole(resources: &RenderResources<'_>) -> (Vec<Attachments>, wgpu::TextureView) {
    let light = resources.target("light", LINEAR.format, 1, TextureUsages::TEXTURE_BINDING);
    let color = resources.target("color", LINEAR.format, LINEAR.samples, TextureUsages::COPY_SRC);
    (vec![Attachments { color, depth: resources.depth(LINEAR) }], light)
}

/// The attachments of a picture's parts and the layers of their light.
fn parts(resources: &RenderResources<'_>) -> (Vec<Attachments>, wgpu::TextureView) {
    let size = Part::size(resources.size);
    let factory = &resources.factory;
    let depth = view(&factory.target("depth", size, depth_format(&factory.gpu.device), 1, TextureUsages::empty()));
    let usage = TextureUsages::TEXTURE_BINDING | TextureUsages::RENDER_ATTACHMENT;
    let plain = plain_texture("light", size, PART.format, usage);
    let size = wgpu::Extent3d { depth_or_array_layers: PARTS as u32, ..plain.size };
    let layers = factory.gpu.device.create_texture(&wgpu::TextureDescriptor { size, ..plain });
    let attachments = (0..PARTS as u32).map(|layer| {
        let color = layers.create_view(&wgpu::TextureViewDescriptor {
            dimension: Some(wgpu::TextureViewDimension::D2),
            base_array_layer: layer,
            array_layer_count: Some(1),
            ..Default::default()
        });
        Attachments { color, depth: depth.clone() }
    });
    (attachments.collect(), view(&layers))
}

/// 255 lit, 0 not, 128 nothing there.
const MASK: Target = Target { format: TextureFormat::R8Unorm, samples: 1 };

/// Draws masks: of one light or sample at a time.
pub(crate) struct Masks {
    pub(crate) pipelines: VolumePipelines,
    attachments: Attachments,
    finished: wgpu::Texture,
    dark: ReceiverPipelines,
    lit: ReceiverPipelines,
}

impl Masks {
    pub(crate) fn new(resources: &RenderResources<'_>, method: &ShadowMethod) -> Result<Self, GpuError> {
        let finished = resources.factory.target("mask", resources.size, MASK.format, 1, TextureUsages::COPY_SRC);
        let (color, all) = (view(&finished), ColorWrites::ALL);
        Ok(Self {
            pipelines: resources.pipelines(MASK, method)?,
            attachments: Attachments { color, depth: resources.depth(MASK) },
            dark: ReceiverPipelines::new(resources, MASK, ("dark", Onto::Nearest), (None, all)),
            lit: ReceiverPipelines::new(resources, MASK, ("mask", Onto::Lit), (None, all)),
            finished,
        })
    }

    /// Records a light's mask and returns its texture.
    pub(crate) fn record(
        &self,
        encoder: &mut wgpu::CommandEncoder,
        subject: &DrawInputs<'_>,
        light: usize,
    ) -> Result<&wgpu::Texture, GpuError> {
        let grey = 128.0 / 255.0;
        let nothing = wgpu::Color { r: grey, g: grey, b: grey, a: 1.0 };
        let mut pass = subject.begin(self.attachments.pass(encoder, "mask", Some(nothing), None));
        self.dark.paint(&mut pass, subject, light);
        subject.casters.shadows.draw(&mut pass, &self.pipelines, light)?;
        self.lit.paint(&mut pass, subject, light);
        Ok(&self.finished)
    }
}

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
