//! A picture of outlines: the model's depth, then its lines, read back.

use rimline::gpu::{
    Extractor, ExtractorOptions, ListOptions, Outline, OutlineFormat, OutlineInputs, OutlinePipeline, OutlineSource,
    OutlineStyle, PositionBuffer, read_back_vec,
};
use rimline::{DepthDirection, Light, ShadowCamera};
use rimline_testkit::cases::Case;
use rimline_testkit::device::Gpu;
use rimline_testkit::on_gpu::text;
use rimline_testkit::pipelines::{Drawing, SURFACE, depth};

/// Pixels along a side of the picture.
pub(crate) const SIDE: u32 = 256;

/// Textures that are drawn into and read.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Attachments {
    pub(crate) depth: wgpu::TextureFormat,
    /// Samples of the depth that is read.
    pub(crate) depth_samples: u32,
    /// Whether that depth is attached, read-only, while it is read. Otherwise there is no depth attachment.
    pub(crate) is_attached: bool,
    /// The bias that its rounding needs.
    pub(crate) bias: f32,
}

impl Attachments {
    pub(crate) const ALL: [Self; 4] = [
        Self { depth: wgpu::TextureFormat::Depth32Float, depth_samples: 1, is_attached: true, bias: 1e-6 },
        Self { depth: wgpu::TextureFormat::Depth24Plus, depth_samples: 4, is_attached: false, bias: 1e-6 },
        Self { depth: wgpu::TextureFormat::Depth32Float, depth_samples: 4, is_attached: true, bias: 1e-6 },
        Self { depth: wgpu::TextureFormat::Depth16Unorm, depth_samples: 1, is_attached: false, bias: 4e-5 },
    ];

    fn format(self) -> OutlineFormat {
        OutlineFormat {
            color: wgpu::TextureFormat::Rgba8Unorm,
            depth_stencil: self.is_attached.then_some(self.depth),
            samples: if self.is_attached { self.depth_samples } else { 1 },
            is_depth_multisampled: self.depth_samples > 1,
        }
    }
}

/// The camera and the faces of a picture, and what it is drawn into.
pub(crate) struct Picture<'a> {
    pub(crate) camera: &'a ShadowCamera,
    /// Three corners a face, in world space.
    pub(crate) corners: Vec<[f32; 3]>,
    pub(crate) attachments: Attachments,
}

pub(crate) struct Inputs<'a> {
    pub(crate) case: &'a Case,
    pub(crate) camera: &'a ShadowCamera,
    pub(crate) light: Light,
    pub(crate) style: OutlineStyle,
    pub(crate) marks: Option<&'a [u32]>,
    pub(crate) capacity: Option<u32>,
    pub(crate) attachments: Attachments,
}

fn texture(gpu: &Gpu, format: wgpu::TextureFormat, samples: u32) -> wgpu::Texture {
    let mut usage = wgpu::TextureUsages::RENDER_ATTACHMENT;
    if format.has_depth_aspect() {
        usage |= wgpu::TextureUsages::TEXTURE_BINDING;
    } else if samples == 1 {
        usage |= wgpu::TextureUsages::COPY_SRC;
    }
    gpu.device.create_texture(&wgpu::TextureDescriptor {
        label: Some("outlines"),
        size: wgpu::Extent3d { width: SIDE, height: SIDE, depth_or_array_layers: 1 },
        mip_level_count: 1,
        sample_count: samples,
        dimension: wgpu::TextureDimension::D2,
        format,
        usage,
        view_formats: &[],
    })
}

/// The corners of the faces of a mesh.
pub(crate) fn corners((_, positions, mesh): &Case) -> Vec<[f32; 3]> {
    mesh.faces().iter().flatten().map(|&v| positions[v as usize]).collect()
}

/// The picture of an extraction's outline: see [`Picture::ink`].
pub(crate) fn render(gpu: &Gpu, inputs: &Inputs<'_>) -> Result<Vec<u8>, String> {
    let Inputs { case, camera, light, style, marks, capacity, attachments } = *inputs;
    let (_, positions, mesh) = case;
    let lists = Some(ListOptions { capacity, ..ListOptions::default() });
    let options = ExtractorOptions { lists, ..ExtractorOptions::default() };
    let mut extractor = Extractor::new(&gpu.pipelines, mesh, options).map_err(text)?;
    let vertices = gpu.storage(positions);
    let marks = marks.map(|marks| gpu.storage(marks));
    Picture { camera, corners: corners(case), attachments }.ink(gpu, |encoder, outlines, depth| {
        let positions = PositionBuffer { buffer: &vertices, offset: 0, stride: 12 };
        let extraction = extractor.encode(encoder, positions, &[light]).map_err(text)?;
        let of = OutlineSource::Extraction(&extraction, 0);
        let marked = marks.as_ref();
        outlines.prepare(&OutlineInputs { of, camera, depth, style, marked }).map_err(text)
    })
}

impl Picture<'_> {
    /// The ink of each pixel, 0 to 255: black lines on white. `outline` is given the depth of the faces.
    pub(crate) fn ink(
        &self,
        gpu: &Gpu,
        outline: impl FnOnce(&mut wgpu::CommandEncoder, &OutlinePipeline, &wgpu::TextureView) -> Result<Outline, String>,
    ) -> Result<Vec<u8>, String> {
        let Self { camera, corners, attachments } = self;
        let Attachments { depth: format, depth_samples, is_attached, .. } = *attachments;
        let is_reversed = camera.depth == DepthDirection::Reversed;
        let (nearer, far) =
            if is_reversed { (wgpu::CompareFunction::Greater, 0.0) } else { (wgpu::CompareFunction::Less, 1.0) };
        let surface = gpu.kept(&format!("surface {format:?} {depth_samples} {is_reversed}"), || {
            let depth_stencil = Some(depth(format, nearer, true));
            let drawing = Drawing { source: SURFACE, depth_stencil, samples: depth_samples, ..Drawing::default() };
            Ok(drawing.pipeline(&gpu.device))
        })?;
        let of_pass = attachments.format();
        let outlines =
            gpu.kept(&format!("{of_pass:?}"), || OutlinePipeline::new(&gpu.pipelines, &of_pass).map_err(text))?;

        let [x, y, z] = camera.origin;
        let words = [camera.view_projection.concat(), vec![x, y, z, 0.0]].concat();
        let buffers = [gpu.storage(&words), gpu.storage(corners)];
        let entries = [0, 1].map(|binding| wgpu::BindGroupEntry {
            binding: binding as u32,
            resource: buffers[binding].as_entire_binding(),
        });
        let layout = &surface.get_bind_group_layout(0);
        let group = gpu.device.create_bind_group(&wgpu::BindGroupDescriptor { label: None, layout, entries: &entries });

        let target = texture(gpu, of_pass.color, 1);
        let view = |texture: &wgpu::Texture| texture.create_view(&wgpu::TextureViewDescriptor::default());
        let depth_view = view(&texture(gpu, format, depth_samples));
        let sampled = (of_pass.samples > 1).then(|| view(&texture(gpu, of_pass.color, of_pass.samples)));

        let pixels = gpu.storage(&vec![0_u32; (SIDE * SIDE) as usize]);
        gpu.submit(|encoder| {
            let outline = outline(encoder, &outlines, &depth_view)?;
            {
                let mut pass = encoder.begin_render_pass(&wgpu::RenderPassDescriptor {
                    label: Some("surface"),
                    depth_stencil_attachment: Some(wgpu::RenderPassDepthStencilAttachment {
                        view: &depth_view,
                        depth_ops: Some(wgpu::Operations {
                            load: wgpu::LoadOp::Clear(far),
                            store: wgpu::StoreOp::Store,
                        }),
                        stencil_ops: None,
                    }),
                    ..Default::default()
                });
                pass.set_pipeline(&surface);
                pass.set_bind_group(0, &group, &[]);
                pass.draw(0..corners.len() as u32, 0..1);
            }
            let target_view = view(&target);
            let mut pass = encoder.begin_render_pass(&wgpu::RenderPassDescriptor {
                label: Some("outlines"),
                color_attachments: &[Some(wgpu::RenderPassColorAttachment {
                    view: sampled.as_ref().unwrap_or(&target_view),
                    depth_slice: None,
                    resolve_target: sampled.as_ref().map(|_| &target_view),
                    ops: wgpu::Operations {
                        load: wgpu::LoadOp::Clear(wgpu::Color::WHITE),
                        store: wgpu::StoreOp::Store,
                    },
                })],
                depth_stencil_attachment: is_attached.then_some(wgpu::RenderPassDepthStencilAttachment {
                    view: &depth_view,
                    depth_ops: None,
                    stencil_ops: None,
                }),
                ..Default::default()
            });
            outline.draw(&mut pass).map_err(text)?;
            drop(pass);
            encoder.copy_texture_to_buffer(
                target.as_image_copy(),
                wgpu::TexelCopyBufferInfo {
                    buffer: &pixels,
                    layout: wgpu::TexelCopyBufferLayout {
                        offset: 0,
                        bytes_per_row: Some(4 * SIDE),
                        rows_per_image: None,
                    },
                },
                target.size(),
            );
            Ok(())
        })?;
        let rows: Vec<[u8; 4]> = read_back_vec(&gpu.device, &gpu.queue, &pixels).map_err(text)?;
        Ok(rows.into_iter().map(|[red, ..]| 255 - red).collect())
    }
}
