//! A host's renderer that shadow volumes are dropped into: bodies and a floor at y = 0, ambient light first, then light
//! after light where the stencil is still 0. Twice as large as the picture, which averages it.
#![allow(dead_code, reason = "each example uses its part")]

use glam::{Mat4, Vec3, Vec4};
use rimline::{Light, Matrix3x4, wgpu};
use wgpu::{BindGroup, BindGroupLayout, BufferBinding, BufferSize, LoadOp, StoreOp, TextureFormat};

use super::support::{Canvas, PipelineOptions};

/// The format of the colour attachment in which light is added.
pub(crate) const COLOR: TextureFormat = TextureFormat::Rgba16Float;
/// The format of the depth and stencil attachment.
pub(crate) const DEPTH_STENCIL: TextureFormat = TextureFormat::Depth24PlusStencil8;

/// A camera with an infinite far plane and reversed depth.
#[derive(Clone, Copy)]
pub(crate) struct Camera {
    pub(crate) eye: [f32; 3],
    /// From positions less the eye to clip space, in columns.
    pub(crate) view_projection: [[f32; 4]; 4],
}

impl Camera {
    /// Vertical field of view in degrees; +Y is up.
    pub(crate) fn new(eye: [f32; 3], target: [f32; 3], field_of_view: f32) -> Self {
        let forward = (Vec3::from(target) - Vec3::from(eye)).normalize();
        let right = forward.cross(Vec3::Y).normalize();
        let scale = 1.0 / (0.5 * field_of_view.to_radians()).tan();
        let near = Vec4::new(0.0, 0.0, 0.0, 0.1);
        let rows = [(scale * right).extend(0.0), (scale * right.cross(forward)).extend(0.0), near, forward.extend(0.0)];
        let matrix = Mat4::from_cols(rows[0], rows[1], rows[2], rows[3]).transpose();
        Self { eye, view_projection: matrix.to_cols_array_2d() }
    }

    /// For a picture so many times as wide as high.
    pub(crate) fn wide(self, aspect: f32) -> Self {
        self.then(Mat4::from_scale(Vec3::new(1.0 / aspect, 1.0, 1.0)))
    }

    fn then(self, clip: Mat4) -> Self {
        let matrix = clip * Mat4::from_cols_array_2d(&self.view_projection);
        Self { view_projection: matrix.to_cols_array_2d(), ..self }
    }
}

/// A light and its colour. Without a range it does not fade; with one it fades to nothing there.
#[derive(Clone, Copy)]
pub(crate) struct Lamp {
    pub(crate) light: Light,
    pub(crate) color: [f32; 3],
}

/// Instances of one mesh, drawn by the renderer.
pub(crate) struct Body {
    group: BindGroup,
    corners: u32,
    instances: wgpu::Buffer,
    count: u32,
}

/// An instance of a mesh.
#[repr(C)]
#[derive(Clone, Copy, bytemuck::Pod, bytemuck::Zeroable)]
pub(crate) struct Placed {
    /// From its positions to world space.
    pub(crate) rows: Matrix3x4,
    /// The colour, linear.
    pub(crate) albedo: [f32; 3],
    /// Its vertex 0 in the buffer of positions.
    pub(crate) first_vertex: u32,
}

impl Default for Placed {
    /// Clay, in world space.
    fn default() -> Self {
        let rows = [[1.0, 0.0, 0.0, 0.0], [0.0, 1.0, 0.0, 0.0], [0.0, 0.0, 1.0, 0.0]];
        Self { rows, albedo: [0.66, 0.64, 0.60], first_vertex: 0 }
    }
}

/// Something else to draw: vertices without buffers, by shaders of its own.
pub(crate) struct Extra {
    /// In ambient light and for a light.
    pipelines: [wgpu::RenderPipeline; 2],
    vertices: u32,
}

/// The renderer.
pub(crate) struct Stage<'a> {
    canvas: &'a Canvas,
    layouts: [BindGroupLayout; 2],
    /// For each part its camera, then its lamps.
    slots: wgpu::Buffer,
    frame: BindGroup,
    cameras: Vec<Camera>,
    lamps: usize,
    /// In ambient light and for a light: bodies, floor.
    ambient: [wgpu::RenderPipeline; 2],
    lit: [wgpu::RenderPipeline; 2],
    /// Depth and stencil of these.
    states: [wgpu::DepthStencilState; 2],
    extras: Vec<Extra>,
    tone: (wgpu::RenderPipeline, BindGroup),
    /// A layer a part.
    color: wgpu::Texture,
    depth: wgpu::TextureView,
}

const SLOT: u64 = 256;
/// How bright the light is that comes from everywhere, if nothing else is set.
const AMBIENT: f32 = 0.22;

/// Parts, if there are more than one: four each way.
pub(crate) const PARTS: usize = 16;

/// The pixel of each block of 4 × 4 that a part draws. `tone.wgsl` has the inverse. Parts 4n to 4n + 3 share a pixel of the
/// picture.
fn pixel_of_part(part: usize) -> [usize; 2] {
    let (within, pixel) = (part % 4, part / 4);
    [2 * (pixel & 1) + (within & 1), 2 * (pixel >> 1) + (within >> 1)]
}

impl<'a> Stage<'a> {
    /// `lit` is the depth-stencil state of the pipelines that add a light.
    pub(crate) fn new(canvas: &'a Canvas, camera: &Camera, lamps: &[Lamp], lit: wgpu::DepthStencilState) -> Self {
        Self::in_parts(canvas, camera, &[lamps], lit)
    }

    /// One part or [`PARTS`], with as many lamps each; the canvas's width and height are then even.
    pub(crate) fn in_parts<L: AsRef<[Lamp]>>(
        canvas: &'a Canvas,
        camera: &Camera,
        parts: &[L],
        lit: wgpu::DepthStencilState,
    ) -> Self {
        let pitch = if parts.len() == 1 { 1 } else { 4 };
        let size = canvas.size.map(|pixels| 2 * pixels);
        let (mut cameras, mut data) = (Vec::new(), Vec::<[f32; 64]>::new());
        for (part, lamps) in parts.iter().enumerate() {
            let [x, y] = [0, 1].map(|axis| {
                let at = if pitch == 1 { 0 } else { pixel_of_part(part)[axis] };
                (pitch as f32 - 2.0 * (at as f32 + 0.5)) / size[axis] as f32
            });
            let aside = Mat4::from_translation(Vec3::new(x, -y, 0.0));
            let camera = camera.then(aside);
            let mut frame = [0.0; 64];
            frame[..16].copy_from_slice(camera.view_projection.as_flattened());
            frame[16..19].copy_from_slice(&camera.eye);
            frame[19] = AMBIENT;
            data.push(frame);
            cameras.push(camera);
            for lamp in lamps.as_ref() {
                let mut slot = [0.0; 64];
                slot[..4].copy_from_slice(&lamp.light.to_array());
                slot[4..7].copy_from_slice(&lamp.color);
                slot[7] = lamp.light.range.powi(-2);
                data.push(slot);
            }
        }
        let lamps = data.len() / parts.len() - 1;
        let buffer = canvas.uniform(bytemuck::cast_slice(&data));
        let size = size.map(|pixels| pixels / pitch);
        // Never one layer alone, which OpenGL does not read as layers.
        let color = canvas.target(size, parts.len().max(2) as u32, COLOR);
        let view = wgpu::TextureViewDescriptor::default();
        let depth = canvas.target(size, 1, DEPTH_STENCIL).create_view(&view);
        let uniform = |has_dynamic_offset| wgpu::BindingType::Buffer {
            ty: wgpu::BufferBindingType::Uniform,
            has_dynamic_offset,
            min_binding_size: None,
        };
        let storage = wgpu::BindingType::Buffer {
            ty: wgpu::BufferBindingType::Storage { read_only: true },
            has_dynamic_offset: false,
            min_binding_size: None,
        };
        let texture = wgpu::BindingType::Texture {
            sample_type: wgpu::TextureSampleType::Float { filterable: false },
            view_dimension: wgpu::TextureViewDimension::D2Array,
            multisampled: false,
        };
        let layouts = [canvas.layout(&[uniform(true), uniform(true)]), canvas.layout(&[storage; 3])];
        let part = |size| BufferBinding { buffer: &buffer, offset: 0, size: BufferSize::new(size) };
        let parts = [part(80), part(32)].map(wgpu::BindingResource::Buffer);
        let frame = canvas.group(&layouts[0], &parts);
        let wgsl = include_str!("stage.wgsl");
        let pipelines = |fragment, blend, depth_stencil: wgpu::DepthStencilState| {
            [("body", wgpu::PrimitiveTopology::TriangleList), ("floor_quad", wgpu::PrimitiveTopology::TriangleStrip)]
                .map(|(vertex, topology)| {
                    canvas.pipeline(&PipelineOptions {
                        layouts: &[&layouts[0], &layouts[1]],
                        wgsl,
                        entry_points: [vertex, fragment],
                        topology,
                        format: COLOR,
                        blend,
                        depth_stencil: Some(depth_stencil.clone()),
                    })
                })
        };
        let nearer = nearer();
        let states = [nearer.clone(), lit.clone()];
        let ambient = pipelines("ambient", None, nearer);
        let lit = pipelines("lit", Some(ADD), lit);
        let read = canvas.layout(&[texture]);
        let tone = canvas.pipeline(&PipelineOptions {
            layouts: &[&read],
            wgsl: include_str!("tone.wgsl"),
            entry_points: ["cover", "tone"],
            topology: wgpu::PrimitiveTopology::TriangleList,
            format: Canvas::FORMAT,
            blend: None,
            depth_stencil: None,
        });
        let dimension = Some(wgpu::TextureViewDimension::D2Array);
        let layers = color.create_view(&wgpu::TextureViewDescriptor { dimension, ..view });
        let tone = (tone, canvas.group(&read, &[wgpu::BindingResource::TextureView(&layers)]));
        Self {
            canvas,
            layouts,
            slots: buffer,
            frame,
            cameras,
            lamps,
            ambient,
            lit,
            states,
            extras: Vec::new(),
            tone,
            color,
            depth,
        }
    }

    /// Sets how bright the light is that comes from everywhere.
    pub(crate) fn set_ambient(&self, ambient: f32) {
        for part in 0..self.cameras.len() {
            let at = (part * (1 + self.lamps)) as u64 * SLOT + 4 * 19;
            self.canvas.queue.write_buffer(&self.slots, at, bytemuck::bytes_of(&ambient));
        }
    }

    /// Also draws what a vertex shader of `wgsl` makes of so many vertices, which goes behind `stage.wgsl`. The
    /// fragment shaders are for ambient light and for a light.
    pub(crate) fn add_extra(&mut self, wgsl: &str, vertex: &str, fragments: [&str; 2], vertices: u32) {
        let wgsl = format!("{}{wgsl}", include_str!("stage.wgsl"));
        let pipeline = |at: usize| {
            self.canvas.pipeline(&PipelineOptions {
                layouts: &[&self.layouts[0]],
                wgsl: &wgsl,
                entry_points: [vertex, fragments[at]],
                topology: wgpu::PrimitiveTopology::TriangleList,
                format: COLOR,
                blend: (at == 1).then_some(ADD),
                depth_stencil: Some(self.states[at].clone()),
            })
        };
        self.extras.push(Extra { pipelines: [0, 1].map(pipeline), vertices });
    }

    /// Draws these once more, as another camera sees them, into a depth map with reversed depth. It has the depth
    /// format of the picture.
    pub(crate) fn draw_extras_into(&self, encoder: &mut wgpu::CommandEncoder, camera: &Camera, map: &wgpu::Texture) {
        let mut frame = [0.0_f32; 128];
        frame[..16].copy_from_slice(camera.view_projection.as_flattened());
        frame[16..19].copy_from_slice(&camera.eye);
        let buffer = self.canvas.uniform(bytemuck::cast_slice(&frame));
        let part = |size| BufferBinding { buffer: &buffer, offset: 0, size: BufferSize::new(size) };
        let group = self.canvas.group(&self.layouts[0], &[part(80), part(32)].map(wgpu::BindingResource::Buffer));
        let unused = self.canvas.target([map.width(), map.height()], 1, COLOR);
        let [color, depth] = [&unused, map].map(|texture| texture.create_view(&wgpu::TextureViewDescriptor::default()));
        let mut pass = begin(encoder, &color, &depth, (LoadOp::Clear(wgpu::Color::BLACK), LoadOp::Clear(0.0)));
        pass.set_bind_group(0, &group, &[0, 0]);
        for extra in &self.extras {
            pass.set_pipeline(&extra.pipelines[0]);
            pass.draw(0..extra.vertices, 0..1);
        }
    }

    /// Something to draw: tightly packed positions and faces.
    pub(crate) fn body(&self, positions: &wgpu::Buffer, faces: &[[u32; 3]]) -> Body {
        self.bodies(positions, faces, &[Placed::default()])
    }

    /// Instances of something to draw.
    pub(crate) fn bodies(&self, positions: &wgpu::Buffer, faces: &[[u32; 3]], placed: &[Placed]) -> Body {
        let instances = self.canvas.storage(bytemuck::cast_slice(placed));
        let buffers = [positions, &self.canvas.storage(bytemuck::cast_slice(faces)), &instances];
        let group = self.canvas.group(&self.layouts[1], &buffers.map(wgpu::Buffer::as_entire_binding));
        Body { group, corners: 3 * faces.len() as u32, instances, count: placed.len() as u32 }
    }

    /// Moves the instances of a body, as many as it was made with.
    pub(crate) fn move_instances(&self, body: &Body, placed: &[Placed]) {
        self.canvas.queue.write_buffer(&body.instances, 0, bytemuck::cast_slice(placed));
    }

    /// The camera of a part, from which its shadow volumes are seen.
    pub(crate) fn camera(&self, part: usize) -> &Camera {
        &self.cameras[part]
    }

    /// Draws everything, in one part. `shade` draws a light's shadow volumes into the stencil, which is 0 everywhere; its
    /// errors are handed on.
    pub(crate) fn draw<E>(
        &self,
        encoder: &mut wgpu::CommandEncoder,
        bodies: &[Body],
        shade: impl Fn(&mut wgpu::RenderPass<'_>, usize) -> Result<(), E>,
    ) -> Result<(), E> {
        self.draw_part(encoder, 0, bodies, shade)?;
        self.develop(encoder);
        Ok(())
    }

    /// Draws everything in one of its parts.
    pub(crate) fn draw_part<E>(
        &self,
        encoder: &mut wgpu::CommandEncoder,
        part: usize,
        bodies: &[Body],
        shade: impl Fn(&mut wgpu::RenderPass<'_>, usize) -> Result<(), E>,
    ) -> Result<(), E> {
        self.depth_pass(encoder, part, bodies);
        for lamp in 0..self.lamps {
            let mut pass = self.light_pass(encoder, part);
            shade(&mut pass, lamp)?;
            self.add_light(&mut pass, part, bodies, lamp);
        }
        Ok(())
    }

    /// The first pass of a part: everything in ambient light. It leaves the depths that shadow volumes are tested against.
    pub(crate) fn depth_pass(&self, encoder: &mut wgpu::CommandEncoder, part: usize, bodies: &[Body]) {
        let sky = wgpu::Color { r: 0.62, g: 0.62, b: 0.63, a: 1.0 };
        let slot = part * (1 + self.lamps);
        let mut pass = self.pass(encoder, part, (LoadOp::Clear(sky), LoadOp::Clear(0.0)));
        self.everything(&mut pass, &self.ambient, bodies, [slot, slot]);
    }

    /// A pass for a light, with its stencil at 0.
    pub(crate) fn light_pass<'e>(&self, encoder: &'e mut wgpu::CommandEncoder, part: usize) -> wgpu::RenderPass<'e> {
        self.pass(encoder, part, (LoadOp::Load, LoadOp::Load))
    }

    /// Adds a light in its pass, where the stencil is still 0.
    pub(crate) fn add_light(&self, pass: &mut wgpu::RenderPass<'_>, part: usize, bodies: &[Body], lamp: usize) {
        let slot = part * (1 + self.lamps);
        self.everything(pass, &self.lit, bodies, [slot, slot + 1 + lamp]);
    }

    /// The depth of what was drawn, for shaders to read.
    pub(crate) fn depth(&self) -> wgpu::TextureView {
        let aspect = wgpu::TextureAspect::DepthOnly;
        self.depth.texture().create_view(&wgpu::TextureViewDescriptor { aspect, ..Default::default() })
    }

    /// A pass over what was drawn, without depth.
    pub(crate) fn overlay<'e>(&self, encoder: &'e mut wgpu::CommandEncoder) -> wgpu::RenderPass<'e> {
        encoder.begin_render_pass(&wgpu::RenderPassDescriptor {
            label: Some("overlay"),
            color_attachments: &[Some(wgpu::RenderPassColorAttachment {
                view: &self.layer(0),
                depth_slice: None,
                resolve_target: None,
                ops: wgpu::Operations { load: LoadOp::Load, store: StoreOp::Store },
            })],
            ..wgpu::RenderPassDescriptor::default()
        })
    }

    /// Makes the picture of what was drawn.
    pub(crate) fn develop(&self, encoder: &mut wgpu::CommandEncoder) {
        self.canvas.draw(encoder, |pass| {
            pass.set_pipeline(&self.tone.0);
            pass.set_bind_group(0, &self.tone.1, &[]);
            pass.draw(0..3, 0..1);
        });
    }

    fn everything(
        &self,
        pass: &mut wgpu::RenderPass<'_>,
        [body, floor]: &[wgpu::RenderPipeline; 2],
        bodies: &[Body],
        slots: [usize; 2],
    ) {
        pass.set_bind_group(0, &self.frame, &slots.map(|slot| (slot as u64 * SLOT) as u32));
        pass.set_pipeline(body);
        for body in bodies {
            pass.set_bind_group(1, &body.group, &[]);
            pass.draw(0..body.corners, 0..body.count);
        }
        pass.set_pipeline(floor);
        pass.draw(0..4, 0..1);
        for extra in &self.extras {
            pass.set_pipeline(&extra.pipelines[usize::from(slots[0] != slots[1])]);
            pass.draw(0..extra.vertices, 0..1);
        }
    }

    fn pass<'e>(
        &self,
        encoder: &'e mut wgpu::CommandEncoder,
        part: usize,
        (color, depth): (LoadOp<wgpu::Color>, LoadOp<f32>),
    ) -> wgpu::RenderPass<'e> {
        begin(encoder, &self.layer(part), &self.depth, (color, depth))
    }

    /// The colours of a part.
    fn layer(&self, part: usize) -> wgpu::TextureView {
        self.color.create_view(&wgpu::TextureViewDescriptor {
            dimension: Some(wgpu::TextureViewDimension::D2),
            base_array_layer: part as u32,
            array_layer_count: Some(1),
            ..wgpu::TextureViewDescriptor::default()
        })
    }
}

/// Ambient light goes everywhere, and leaves its depths.
pub(crate) fn nearer() -> wgpu::DepthStencilState {
    wgpu::DepthStencilState {
        format: DEPTH_STENCIL,
        depth_write_enabled: Some(true),
        depth_compare: Some(wgpu::CompareFunction::Greater),
        stencil: wgpu::StencilState::default(),
        bias: wgpu::DepthBiasState::default(),
    }
}

/// Adds to what is there.
const ADD: wgpu::BlendState = wgpu::BlendState { color: ADD_COMPONENT, alpha: ADD_COMPONENT };
const ADD_COMPONENT: wgpu::BlendComponent = wgpu::BlendComponent {
    src_factor: wgpu::BlendFactor::One,
    dst_factor: wgpu::BlendFactor::One,
    operation: wgpu::BlendOperation::Add,
};

/// A pass with a stencil of zeros.
pub(crate) fn begin<'e>(
    encoder: &'e mut wgpu::CommandEncoder,
    view: &wgpu::TextureView,
    depth_view: &wgpu::TextureView,
    (color, depth): (LoadOp<wgpu::Color>, LoadOp<f32>),
) -> wgpu::RenderPass<'e> {
    let store = StoreOp::Store;
    let has_stencil = depth_view.texture().format().has_stencil_aspect();
    encoder.begin_render_pass(&wgpu::RenderPassDescriptor {
        label: Some("stage"),
        color_attachments: &[Some(wgpu::RenderPassColorAttachment {
            view,
            depth_slice: None,
            resolve_target: None,
            ops: wgpu::Operations { load: color, store },
        })],
        depth_stencil_attachment: Some(wgpu::RenderPassDepthStencilAttachment {
            view: depth_view,
            depth_ops: Some(wgpu::Operations { load: depth, store }),
            stencil_ops: has_stencil.then_some(wgpu::Operations { load: LoadOp::Clear(0), store }),
        }),
        ..wgpu::RenderPassDescriptor::default()
    })
}
