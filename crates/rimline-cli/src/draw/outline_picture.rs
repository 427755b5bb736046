//! The picture's passes, in order: survey, contact shadow, paper and model, occlusion, lines.

use rimline::gpu::{Extraction, PositionBuffer, include_wgsl, results_bind_group_layout};
use rimline::wgpu;
use wgpu::{BlendComponent, BlendFactor, BlendOperation, BlendState, PrimitiveTopology, TextureFormat, TextureUsages};

use super::contact_shadow;
use super::frame::Frame;
use super::passes::{color_pass, depth_test};
use super::survey::{SEEN, Survey};
use super::veils;
use crate::device::Gpu;
use crate::gpu_error::GpuError;
use crate::render::pipeline_factory::{Pass, PipelineFactory};

/// The picture's format: sRGB, so that blending and resolving work on light.
pub(super) const FORMAT: TextureFormat = TextureFormat::Rgba8UnormSrgb;
const SAMPLES: u32 = 4;

/// What is drawn.
pub(super) struct DrawInputs<'a> {
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
    subject: &DrawInputs<'_>,
) -> Result<wgpu::Texture, GpuError> {
    let canvas = Canvas::new(gpu, frame, size);
    let faces = canvas.model(gpu, encoder, frame, subject);
    canvas.occlusion(encoder);
    canvas.lines(gpu, encoder, frame, subject, &faces)?;
    Ok(canvas.finished)
}

/// The targets, and what reads them.
struct Canvas<'a> {
    factory: PipelineFactory<'a>,
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
        let factory =
            PipelineFactory::new(&gpu.device, &gpu.queue, include_str!("frame.wgsl"), bytemuck::bytes_of(frame));
        let target = |label, format, samples, usage| view(&factory.target(label, size, format, samples, usage));
        let readable = TextureUsages::TEXTURE_BINDING;
        let survey = Survey::new(&factory, size, frame.places());
        let seen_layout = factory.layout(&[SEEN]);
        Self {
            colour: target("colour", FORMAT, SAMPLES, TextureUsages::empty()),
            depth: target("depth", TextureFormat::Depth32Float, SAMPLES, TextureUsages::empty()),
            seen_group: factory.group(&seen_layout, &[wgpu::BindingResource::TextureView(&survey.seen)]),
            survey,
            seen_layout,
            occlusion: target("occlusion", TextureFormat::R8Unorm, 1, readable),
            finished: factory.target("picture", size, FORMAT, 1, TextureUsages::COPY_SRC),
            factory,
        }
    }

    /// The survey, paper, contact shadow and the shaded model; returns the buffer of faces.
    fn model(
        &self,
        gpu: &Gpu,
        encoder: &mut wgpu::CommandEncoder,
        frame: &Frame,
        subject: &DrawInputs<'_>,
    ) -> wgpu::Buffer {
        let factory = &self.factory;
        let storage = wgpu::BindingType::Buffer {
            ty: wgpu::BufferBindingType::Storage { read_only: true },
            has_dynamic_offset: false,
            min_binding_size: None,
        };
        let faces = factory.buffer(&gpu.queue, "drawn faces", bytemuck::cast_slice(subject.faces));
        let normals = factory.buffer(&gpu.queue, "normals", bytemuck::cast_slice(subject.normals));
        let layout = factory.layout(&[storage; 3]);
        let resources = [subject.positions.buffer, &faces, &normals].map(wgpu::Buffer::as_entire_binding);
        let geometry = factory.group(&layout, &resources);
        let corners = 3 * subject.faces.len() as u32;
        self.survey.record(factory, encoder, (&layout, &geometry), corners);
        let shadow =
            frame.sees_ground().then(|| contact_shadow::record(factory, encoder, (&layout, &geometry), corners));

        let triangles = PrimitiveTopology::TriangleList;
        let backdrop =
            onto_picture(factory, "backdrop", include_str!("backdrop.wgsl"), &[], triangles, None, Some(false));
        let surface =
            onto_picture(factory, "surface", include_str!("surface.wgsl"), &[&layout], triangles, None, Some(true));
        let clear = wgpu::LoadOp::Clear(wgpu::Color::WHITE);
        let mut pass = color_pass(encoder, "model", &self.colour, None, clear, Some(&self.depth));
        pass.set_bind_group(0, &factory.frame_group, &[]);
        pass.set_pipeline(&backdrop);
        pass.draw(0..3, 0..1);
        if let Some((layout, group)) = &shadow {
            let source = include_str!("shadow.wgsl");
            let strip = PrimitiveTopology::TriangleStrip;
            let pipeline = onto_picture(factory, "shadow", source, &[layout], strip, Some(MULTIPLY), Some(false));
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
        let pipeline = self.factory.pipeline(&Pass {
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
        pass.set_bind_group(0, &self.factory.frame_group, &[]);
        pass.set_bind_group(1, &self.seen_group, &[]);
        pass.draw(0..3, 0..1);
    }

    /// The occlusion darkens the model, and the lines go over it.
    fn lines(
        &self,
        gpu: &Gpu,
        encoder: &mut wgpu::CommandEncoder,
        frame: &Frame,
        subject: &DrawInputs<'_>,
        faces: &wgpu::Buffer,
    ) -> Result<(), GpuError> {
        let factory = &self.factory;
        let occlusion_type = wgpu::BindingType::Texture {
            sample_type: wgpu::TextureSampleType::Float { filterable: true },
            view_dimension: wgpu::TextureViewDimension::D2,
            multisampled: false,
        };
        let layout = factory.layout(&[SEEN, occlusion_type]);
        let group =
            factory.group(&layout, &[&self.survey.seen, &self.occlusion].map(wgpu::BindingResource::TextureView));
        let source = include_str!("darken.wgsl");
        let triangles = PrimitiveTopology::TriangleList;
        let darken = onto_picture(factory, "darken", source, &[&layout], triangles, Some(MULTIPLY), None);
        let extraction = subject.extraction;
        let results_layout = results_bind_group_layout(&gpu.device, wgpu::ShaderStages::VERTEX);
        let results = extraction.bind_group(&results_layout, 0)?;
        let (lines_layout, lines_group) = self.survey.group(factory, subject.positions.buffer, faces);
        let places = [self.finished.width(), self.finished.height()].map(|pixels| frame.places() * pixels);
        let veils = veils::record(factory, encoder, (&lines_layout, &lines_group), places);
        let lines = onto_picture(
            factory,
            "lines",
            &format!("{}\n{}", include_wgsl(2), include_str!("lines.wgsl")),
            &[&lines_layout, &results_layout, &veils::layout(factory)],
            PrimitiveTopology::TriangleStrip,
            Some(BlendState::ALPHA_BLENDING),
            None,
        );
        let finished = view(&self.finished);
        let load = wgpu::LoadOp::Load;
        let mut pass = color_pass(encoder, "lines", &self.colour, Some(&finished), load, None);
        pass.set_bind_group(0, &factory.frame_group, &[]);
        pass.set_pipeline(&darken);
        pass.set_bind_group(1, &group, &[]);
        pass.draw(0..3, 0..1);
        pass.set_pipeline(&lines);
        pass.set_bind_group(1, &lines_group, &[]);
        pass.set_bind_group(2, &results, &[]);
        pass.set_bind_group(3, &veils, &[]);
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
    factory: &PipelineFactory<'_>,
    name: &'static str,
    source: &str,
    groups: &[&wgpu::BindGroupLayout],
    topology: PrimitiveTopology,
    blend: Option<BlendState>,
    depth: Option<bool>,
) -> wgpu::RenderPipeline {
    factory.pipeline(&Pass {
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

/// What is there times what is drawn.
const MULTIPLY: BlendState = {
    let multiply =
        BlendComponent { src_factor: BlendFactor::Dst, dst_factor: BlendFactor::Zero, operation: BlendOperation::Add };
    BlendState { color: multiply, alpha: BlendComponent::OVER }
};
