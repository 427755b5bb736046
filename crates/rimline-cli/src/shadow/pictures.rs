//! The passes of a picture with shadows.

use rimline::wgpu;
use wgpu::{ColorWrites, CompareFunction, LoadOp, PrimitiveTopology, StencilFaceState, TextureFormat, TextureUsages};

use super::depth::depth_format;
use super::depth_overlay::DepthOverlay;
use super::part::{PARTS, Part};
use super::receiver_pipelines::{ADD, MULTIPLY, Onto, ReceiverPipelines, Target, depth_state};
use super::render_resources::{Attachments, DrawInputs, RenderResources};
use super::shadows::{ShadowMethod, VolumePipelines};
use super::volume_overlay::VolumeOverlay;
use crate::device::Gpu;
use crate::gpu_error::GpuError;
use crate::render::pipeline_factory::Pass;
use crate::shadow::args::ModeArg;

/// Linear light, before it is exposed.
const LINEAR: Target = Target { format: TextureFormat::Rgba16Float, samples: 4 };
/// The same of a part of the picture.
const PART: Target = Target { format: LINEAR.format, samples: 1 };

/// Draws pictures.
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

/// Draws what bounds the shadows.
enum Overlay {
    Volumes(VolumeOverlay),
    Depths(DepthOverlay),
}

impl Overlay {
    fn new(gpu: &Gpu, resources: &RenderResources<'_>, target: Target, method: &ShadowMethod) -> Self {
        if method.has_depth_maps() {
            Self::Depths(DepthOverlay::new(gpu, resources, target))
        } else {
            Self::Volumes(VolumeOverlay::new(gpu, resources, target))
        }
    }
}

impl Pictures {
    pub(crate) fn new(
        gpu: &Gpu,
        resources: &RenderResources<'_>,
        method: &ShadowMethod,
        mode: ModeArg,
        volumes: bool,
        in_parts: bool,
    ) -> Result<Self, GpuError> {
        let factory = &resources.factory;
        let linear = if in_parts { PART } else { LINEAR };
        let (attachments, light) = if in_parts { parts(resources) } else { whole(resources) };
        let load = if in_parts { include_str!("parts.wgsl") } else { include_str!("whole.wgsl") };
        let view_dimension =
            if in_parts { wgpu::TextureViewDimension::D2Array } else { wgpu::TextureViewDimension::D2 };
        let format = TextureFormat::Rgba8UnormSrgb;
        let layout = factory.layout(&[wgpu::BindingType::Texture {
            sample_type: wgpu::TextureSampleType::Float { filterable: false },
            view_dimension,
            multisampled: false,
        }]);
        let cover = |name, source, groups: &[_], target: Target, depth| {
            let topology = PrimitiveTopology::TriangleList;
            let Target { format, samples } = target;
            let write = ColorWrites::ALL;
            let (vertex, blend, constants) = (name, None, &[][..]);
            factory.pipeline(&Pass {
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
        let behind =
            depth_state(depth_format(factory.device), false, CompareFunction::Always, StencilFaceState::IGNORE);
        let group = factory.group(&layout, &[wgpu::BindingResource::TextureView(&light)]);
        let tone = format!("{load}\n{}", include_str!("tone.wgsl"));
        let shade = match mode {
            ModeArg::Additive => None,
            ModeArg::Ambient => Some(("ambient", None)),
            ModeArg::Black => Some(("black", None)),
            ModeArg::Composited => Some(("dim", MULTIPLY)),
        };
        Ok(Self {
            pipelines: RenderResources::pipelines(gpu, linear, method)?,
            attachments,
            finished: factory.target("picture", resources.size, format, 1, TextureUsages::COPY_SRC),
            backdrop: cover("backdrop", include_str!("backdrop.wgsl"), &[], linear, Some(behind)),
            ambient: resources.receivers(linear, "ambient", Onto::Nearest, None),
            lit: resources.receivers(linear, "lit", Onto::Lit, ADD),
            shade: shade.map(|(fragment, blend)| {
                let nothing = ColorWrites::empty();
                [
                    ReceiverPipelines::new(factory, &resources.layouts, linear, "averted", Onto::Lit, None, nothing),
                    resources.receivers(linear, fragment, Onto::Shadowed, blend),
                ]
            }),
            tone: (cover("tone", &tone, &[&layout], Target { format, samples: 1 }, None), group),
            resolved: (!in_parts).then_some(light),
            overlay: volumes.then(|| Overlay::new(gpu, resources, linear, method)),
        })
    }

    /// Records the whole picture's light, or a part's.
    pub(crate) fn record(
        &self,
        encoder: &mut wgpu::CommandEncoder,
        resources: &RenderResources<'_>,
        subject: &DrawInputs<'_>,
        part: usize,
    ) -> Result<(), GpuError> {
        let DrawInputs { casters, has_ground, samples, .. } = *subject;
        let Self { pipelines, .. } = self;
        let attachments = &self.attachments[part];
        {
            let mut pass = subject.begin(attachments.pass(encoder, "ambient", Some(wgpu::Color::BLACK), None));
            resources.select(&mut pass, 0);
            pass.set_pipeline(&self.backdrop);
            pass.draw(0..3, 0..1);
            self.ambient.paint(&mut pass, casters, 0, has_ground);
        }
        for light in 0..samples {
            let mut pass = subject.begin(attachments.pass(encoder, "light", None, None));
            if self.shade.is_none() {
                casters.shadows.draw(&mut pass, pipelines, light)?;
            }
            resources.select(&mut pass, light);
            self.lit.paint(&mut pass, casters, light, has_ground);
        }
        if let Some(shade) = &self.shade {
            for light in 0..samples {
                let mut pass = subject.begin(attachments.pass(encoder, "shade", None, None));
                casters.shadows.draw(&mut pass, pipelines, light)?;
                resources.select(&mut pass, light);
                for receivers in shade {
                    receivers.paint(&mut pass, casters, light, has_ground);
                }
            }
        }
        let mut pass = subject.begin(attachments.pass(encoder, "resolve", None, self.resolved.as_ref()));
        match &self.overlay {
            Some(Overlay::Volumes(overlay)) => overlay.draw(&mut pass, resources, subject)?,
            Some(Overlay::Depths(overlay)) => overlay.draw(&mut pass, resources, subject),
            None => {}
        }
        Ok(())
    }

    /// Records how the light becomes a picture, and returns its texture.
    pub(crate) fn develop(
        &self,
        encoder: &mut wgpu::CommandEncoder,
        resources: &RenderResources<'_>,
    ) -> &wgpu::Texture {
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
        pass.set_bind_group(0, &resources.factory.frame_group, &[]);
        pass.set_bind_group(1, &self.tone.1, &[]);
        pass.set_pipeline(&self.tone.0);
        pass.draw(0..3, 0..1);
        &self.finished
    }
}

/// The attachments of a whole picture and the texture of its light.
fn whole(resources: &RenderResources<'_>) -> (Vec<Attachments>, wgpu::TextureView) {
    let light = resources.target("light", LINEAR.format, 1, TextureUsages::TEXTURE_BINDING);
    (vec![Attachments::new(resources, LINEAR)], light)
}

/// The attachments of a picture's parts and the layers of their light.
fn parts(resources: &RenderResources<'_>) -> (Vec<Attachments>, wgpu::TextureView) {
    let size = Part::size(resources.size);
    let none = TextureUsages::empty();
    let depth = resources
        .factory
        .target("depth", size, depth_format(resources.factory.device), 1, none)
        .create_view(&wgpu::TextureViewDescriptor::default());
    let layers = resources.factory.layers("light", size, PARTS as u32, PART.format, TextureUsages::TEXTURE_BINDING);
    let attachments = (0..PARTS as u32).map(|layer| {
        let color = layers.create_view(&wgpu::TextureViewDescriptor {
            dimension: Some(wgpu::TextureViewDimension::D2),
            base_array_layer: layer,
            array_layer_count: Some(1),
            ..Default::default()
        });
        Attachments { color, depth: depth.clone() }
    });
    (attachments.collect(), layers.create_view(&wgpu::TextureViewDescriptor::default()))
}
