//! The picture's passes, in order: survey, contact shadow, paper and model, occlusion, lines.

use rimline::gpu::{Extraction, PositionBuffer, include_wgsl, results_bind_group_layout};
use rimline::wgpu;
use wgpu::{BlendComponent, BlendFactor, BlendOperation, BlendState, PrimitiveTopology, TextureFormat, TextureUsages};

use super::contact;
use super::frame::Frame;
use super::survey::{SEEN, Survey};
use crate::device::Gpu;
use crate::gpu_error::GpuError;
use crate::render::kit::{Kit, Pass};

/// The picture's format: sRGB, so that blending and resolving work on light.
pub(super) const FORMAT: TextureFormat = TextureFormat::Rgba8UnormSrgb;
const SAMPLES: u32 = 4;

/// What is drawn.
pub(super) struct Subject<'a> {
    /// Tightly packed.
    pub(super) positions: PositionBuffer<'a>,
    /// Faces with finite corners only.
    pub(super) faces: &'a [[u32; 3]],
    /// One a corner, see [`super::normals`].
    pub(super) normals: &'a [u32],
    /// Its lists hold the silhouette for the eye, as light 0.
    pub(super) extraction: &'a Extraction,
}

/// Records everything and returns the finished picture's texture.
pub(super) fn record(
    gpu: &Gpu,
    encoder: &mut wgpu::CommandEncoder,
    frame: &Frame,
    size: [u32; 2],
    subject: &Subject<'_>,
) -> Result<wgpu::Texture, GpuError> {
    let canvas = Canvas::new(gpu, frame, size);
    let faces = canvas.model(gpu, encoder, frame, subject);
    canvas.occlusion(encoder);
    canvas.lines(gpu, encoder, subject, &faces)?;
    Ok(canvas.finished)
}

/// The targets, and what reads them.
struct Canvas<'a> {
    kit: Kit<'a>,
    colour: wgpu::TextureView,
    depth: wgpu::TextureView,
    survey: Survey,
    seen_layout: wgpu::BindGroupLayout,
    seen_group: wgpu::BindGroup,
    occlusion: wgpu::TextureView,
    finished: wgpu::Texture,
}

impl<'a> Canvas<'a> {
    fn new(gpu: &'a Gpu, frame: &Frame, size: [u32; 2]) -> Self {
        let kit = Kit::new(&gpu.device, &gpu.queue, include_str!("frame.wgsl"), bytemuck::bytes_of(frame));
        let target = |label, format, samples, usage| view(&kit.target(label, size, format, samples, usage));
        let readable = TextureUsages::TEXTURE_BINDING;
        let survey = Survey::new(&kit, size, frame.places());
        let seen_layout = kit.layout(&[SEEN]);
        Self {
            colour: target("colour", FORMAT, SAMPLES, TextureUsages::empty()),
            depth: target("depth", TextureFormat::Depth32Float, SAMPLES, TextureUsages::empty()),
            seen_group: kit.group(&seen_layout, &[wgpu::BindingResource::TextureView(&survey.seen)]),
            survey,
            seen_layout,
            occlusion: target("occlusion", TextureFormat::R8Unorm, 1, readable),
            finished: kit.target("picture", size, FORMAT, 1, TextureUsages::COPY_SRC),
            kit,
        }
    }

    /// The survey, paper, contact shadow and the shaded model; returns the buffer of faces.
    fn model(
        &self,
        gpu: &Gpu,
        encoder: &mut wgpu::CommandEncoder,
        frame: &Frame,
        subject: &Subject<'_>,
    ) -> wgpu::Buffer {
        let kit = &self.kit;
        let storage = wgpu::BindingType::Buffer {
            ty: wgpu::BufferBindingType::Storage { read_only: true },
            has_dynamic_offset: false,
            min_binding_size: None,
        };
        let faces = kit.buffer(&gpu.queue, "drawn faces", bytemuck::cast_slice(subject.faces));
        let normals = kit.buffer(&gpu.queue, "normals", bytemuck::cast_slice(subject.normals));
        let layout = kit.layout(&[storage; 3]);
        let resources = [subject.positions.buffer, &faces, &normals].map(wgpu::Buffer::as_entire_binding);
        let geometry = kit.group(&layout, &resources);
        let corners = 3 * subject.faces.len() as u32;
        self.survey.record(kit, encoder, (&layout, &geometry), corners);
        let shadow = frame.sees_ground().then(|| contact::record(kit, encoder, (&layout, &geometry), corners));

        let triangles = PrimitiveTopology::TriangleList;
        let backdrop = onto_picture(kit, "backdrop", include_str!("backdrop.wgsl"), &[], triangles, None, Some(false));
        let surface =
            onto_picture(kit, "surface", include_str!("surface.wgsl"), &[&layout], triangles, None, Some(true));
        let clear = wgpu::LoadOp::Clear(wgpu::Color::WHITE);
        let mut pass = color_pass(encoder, "model", &self.colour, None, clear, Some(&self.depth));
        pass.set_bind_group(0, &kit.frame_group, &[]);
        pass.set_pipeline(&backdrop);
        pass.draw(0..3, 0..1);
        if let Some((layout, group)) = &shadow {
            let source = include_str!("shadow.wgsl");
            let strip = PrimitiveTopology::TriangleStrip;
            let pipeline = onto_picture(kit, "shadow", source, &[layout], strip, Some(MULTIPLY), Some(false));
            pass.set_pipeline(&pipeline);
            pass.set_bind_group(1, group, &[]);
            pass.draw(0..4, 0..1);
        }
        pass.set_pipeline(&surface);
        pass.set_bind_group(1, &geometry, &[]);
        pass.draw(0..corners, 0..1);
        drop(pass);
        faces
    }

    /// How little light from all around comes to each pixel.
    fn occlusion(&self, encoder: &mut wgpu::CommandEncoder) {
        let pipeline = self.kit.pipeline(&Pass {
            name: "occlusion",
            vertex: "occlusion",
            source: include_str!("occlusion.wgsl"),
            groups: &[&self.seen_layout],
            topology: PrimitiveTopology::TriangleList,
            format: TextureFormat::R8Unorm,
            blend: None,
            samples: 1,
            write: wgpu::ColorWrites::ALL,
            depth: None,
            constants: &[],
        });
        let clear = wgpu::LoadOp::Clear(wgpu::Color::WHITE);
        let mut pass = color_pass(encoder, "occlusion", &self.occlusion, None, clear, None);
        pass.set_pipeline(&pipeline);
        pass.set_bind_group(0, &self.kit.frame_group, &[]);
        pass.set_bind_group(1, &self.seen_group, &[]);
        pass.draw(0..3, 0..1);
    }

    /// The occlusion darkens the model, and the lines go over it.
    fn lines(
        &self,
        gpu: &Gpu,
        encoder: &mut wgpu::CommandEncoder,
        subject: &Subject<'_>,
        faces: &wgpu::Buffer,
    ) -> Result<(), GpuError> {
        let kit = &self.kit;
        let occlusion_type = wgpu::BindingType::Texture {
            sample_type: wgpu::TextureSampleType::Float { filterable: true },
            view_dimension: wgpu::TextureViewDimension::D2,
            multisampled: false,
        };
        let layout = kit.layout(&[SEEN, occlusion_type]);
        let group = kit.group(&layout, &[&self.survey.seen, &self.occlusion].map(wgpu::BindingResource::TextureView));
        let source = include_str!("darken.wgsl");
        let triangles = PrimitiveTopology::TriangleList;
        let darken = onto_picture(kit, "darken", source, &[&layout], triangles, Some(MULTIPLY), None);
        let extraction = subject.extraction;
        let results_layout = results_bind_group_layout(&gpu.device, wgpu::ShaderStages::VERTEX);
        let results = extraction.bind_group(&results_layout, 0)?;
        let (lines_layout, lines_group) = self.survey.group(kit, subject.positions.buffer, faces);
        let lines = onto_picture(
            kit,
            "lines",
            &format!("{}\n{}", include_wgsl(2), include_str!("lines.wgsl")),
            &[&lines_layout, &results_layout],
            PrimitiveTopology::TriangleStrip,
            Some(BlendState::ALPHA_BLENDING),
            None,
        );
        let finished = view(&self.finished);
        let load = wgpu::LoadOp::Load;
        let mut pass = color_pass(encoder, "lines", &self.colour, Some(&finished), load, None);
        pass.set_bind_group(0, &kit.frame_group, &[]);
        pass.set_pipeline(&darken);
        pass.set_bind_group(1, &group, &[]);
        pass.draw(0..3, 0..1);
        pass.set_pipeline(&lines);
        pass.set_bind_group(1, &lines_group, &[]);
        pass.set_bind_group(2, &results, &[]);
        // As many lines as the GPU found; the CPU never learns how many.
        extraction.draw(&mut pass, 0)?;
        Ok(())
    }
}

fn view(texture: &wgpu::Texture) -> wgpu::TextureView {
    texture.create_view(&wgpu::TextureViewDescriptor::default())
}

/// A pipeline onto the multisampled picture.
fn onto_picture(
    kit: &Kit<'_>,
    name: &'static str,
    source: &str,
    groups: &[&wgpu::BindGroupLayout],
    topology: PrimitiveTopology,
    blend: Option<BlendState>,
    depth: Option<bool>,
) -> wgpu::RenderPipeline {
    kit.pipeline(&Pass {
        name,
        vertex: name,
        source,
        groups,
        topology,
        format: FORMAT,
        blend,
        samples: SAMPLES,
        write: wgpu::ColorWrites::ALL,
        depth: depth.map(depth_test),
        constants: &[],
    })
}

/// The nearest is drawn and written, or whatever comes without being written.
pub(super) fn depth_test(write: bool) -> wgpu::DepthStencilState {
    wgpu::DepthStencilState {
        format: TextureFormat::Depth32Float,
        depth_write_enabled: Some(write),
        depth_compare: Some(if write { wgpu::CompareFunction::Greater } else { wgpu::CompareFunction::Always }),
        stencil: wgpu::StencilState::default(),
        bias: wgpu::DepthBiasState::default(),
    }
}

/// What is there times what is drawn.
const MULTIPLY: BlendState = {
    let multiply =
        BlendComponent { src_factor: BlendFactor::Dst, dst_factor: BlendFactor::Zero, operation: BlendOperation::Add };
    BlendState { color: multiply, alpha: BlendComponent::OVER }
};

/// A pass onto one colour target, and a depth buffer that is cleared to the infinitely far.
pub(super) fn color_pass<'e>(
    encoder: &'e mut wgpu::CommandEncoder,
    label: &str,
    target: &wgpu::TextureView,
    resolve_target: Option<&wgpu::TextureView>,
    load: wgpu::LoadOp<wgpu::Color>,
    depth: Option<&wgpu::TextureView>,
) -> wgpu::RenderPass<'e> {
    encoder.begin_render_pass(&wgpu::RenderPassDescriptor {
        label: Some(label),
        color_attachments: &[Some(wgpu::RenderPassColorAttachment {
            view: target,
            depth_slice: None,
            resolve_target,
            ops: wgpu::Operations { load, store: wgpu::StoreOp::Store },
        })],
        depth_stencil_attachment: depth.map(|view| wgpu::RenderPassDepthStencilAttachment {
            view,
            depth_ops: Some(wgpu::Operations { load: wgpu::LoadOp::Clear(0.0), store: wgpu::StoreOp::Store }),
            stencil_ops: None,
        }),
        timestamp_writes: None,
        occlusion_query_set: None,
        multiview_mask: None,
    })
}
