//! Closed surfaces of slivers that leave the picture, as plain triangles in clip space. A driver that rasterises them
//! rightly covers each pixel by as many fronts as backs.
//!
//! Vulkan lets a driver take the facing of a triangle from its area before or after clipping. It then has to fill the
//! triangle for both signs. `SwiftShader` takes the direction of the edges of the clipped polygon from the same
//! sign, of vertices that are rounded to a sixteenth of a pixel before clipping, in `f32`. A sliver whose far vertices lie
//! outside the picture gets the wrong sign and covers other pixels than its neighbours leave to it.
//! docs/numerics/rasterisers.md, "Clipped slivers".

use crate::pipelines::{ADDED, Drawing, pixels, texture};
use crate::random::Random;

/// A triangle in clip space, counter-clockwise if it is a front.
pub type Triangle = [[f32; 4]; 3];

pub const SIZE: u32 = 256;

/// Corners of each end of the tube.
const CORNERS: usize = 3000;

/// Where a tube of slivers ends.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum End {
    /// So many times as far from the light as it begins.
    Times(f64),
    /// At infinity. Clip w is 0 there.
    Infinity,
}

impl End {
    pub const INSIDE: Self = Self::Times(1.25);
    pub const OUTSIDE: Self = Self::Times(30.0);
}

/// A tube from a ring round the middle of the picture away from a light, with both ends. Neighbours share vertices bit for
/// bit.
pub fn tube(end: End, seed: u64) -> Vec<Triangle> {
    let mut random = Random::new(seed);
    let light = [random.between(-0.09, -0.08), random.between(0.66, 0.67)].map(f64::from);
    let clip = |[x, y]: [f64; 2]| [x as f32, y as f32, 0.5, 1.0];
    let mut pair = |corner: usize| {
        let angle = corner as f64 / CORNERS as f64 * std::f64::consts::TAU;
        let radius = 0.35 + 0.05 * (7.0 * angle).sin();
        let near = [angle.cos(), angle.sin()].map(|c| radius * c + f64::from(random.between(-5e-4, 5e-4)));
        let away = [0, 1].map(|axis| near[axis] - light[axis]);
        let far = match end {
            End::Times(times) => clip([0, 1].map(|axis| light[axis] + times * away[axis])),
            End::Infinity => [away[0] as f32, away[1] as f32, 0.0, 0.0],
        };
        [clip(near), far]
    };
    let ring: Vec<[[f32; 4]; 2]> = (0..CORNERS).map(&mut pair).collect();
    let [first_near, first_far] = ring[0];
    let mut triangles = Vec::new();
    for (corner, &[near, far]) in ring.iter().enumerate() {
        let [next_near, next_far] = ring[(corner + 1) % CORNERS];
        triangles.extend([[near, next_near, next_far], [near, next_far, far]]);
        if corner > 0 && corner + 1 < CORNERS {
            triangles.extend([[first_near, next_near, near], [first_far, far, next_far]]);
        }
    }
    triangles
}

const DRAWING: &str = "
@vertex fn triangle(@location(0) clip: vec4<f32>) -> @invariant @builtin(position) vec4<f32> { return clip; }
@fragment fn count(@builtin(front_facing) is_front: bool) -> @location(0) vec4<f32> {
  return select(vec4<f32>(0.0, 1.0 / 255.0, 0.0, 0.0), vec4<f32>(1.0 / 255.0, 0.0, 0.0, 0.0), is_front);
}
";

/// How many fronts and how many backs cover each pixel, row by row, up to 255. Colours add them up, so OpenGL can do it, too.
pub fn coverage(device: &wgpu::Device, queue: &wgpu::Queue, triangles: &[Triangle]) -> Result<Vec<[u8; 2]>, String> {
    let (needed, most) = (size_of_val(triangles) as u64, device.limits().max_buffer_size);
    if needed > most {
        return Err(format!("the trial needs a buffer of {needed} bytes, and the device has at most {most}"));
    }
    let format = wgpu::TextureFormat::Rgba8Unorm;
    let target = wgpu::ColorTargetState { blend: Some(ADDED), ..format.into() };
    let attributes = &wgpu::vertex_attr_array![0 => Float32x4];
    let step_mode = wgpu::VertexStepMode::Vertex;
    let pipeline = Drawing {
        label: "slivers",
        source: DRAWING,
        buffers: &[Some(wgpu::VertexBufferLayout { array_stride: 16, step_mode, attributes })],
        targets: &[Some(target)],
        ..Drawing::default()
    }
    .pipeline(device);
    let vertices = device.create_buffer(&wgpu::BufferDescriptor {
        label: Some("slivers"),
        size: size_of_val(triangles) as u64,
        usage: wgpu::BufferUsages::VERTEX | wgpu::BufferUsages::COPY_DST,
        mapped_at_creation: false,
    });
    queue.write_buffer(&vertices, 0, bytemuck::cast_slice(triangles));
    let picture = texture(device, [SIZE; 2], format);
    let mut encoder = device.create_command_encoder(&wgpu::CommandEncoderDescriptor::default());
    let color = wgpu::RenderPassColorAttachment {
        view: &picture,
        depth_slice: None,
        resolve_target: None,
        ops: wgpu::Operations { load: wgpu::LoadOp::Clear(wgpu::Color::TRANSPARENT), store: wgpu::StoreOp::Store },
    };
    let mut pass = encoder.begin_render_pass(&wgpu::RenderPassDescriptor {
        label: Some("slivers"),
        color_attachments: &[Some(color)],
        ..Default::default()
    });
    pass.set_pipeline(&pipeline);
    pass.set_vertex_buffer(0, vertices.slice(..));
    pass.draw(0..3 * triangles.len() as u32, 0..1);
    drop(pass);
    let pixels = pixels((device, queue), encoder, &picture, wgpu::TextureAspect::All);
    let pixels = pixels.map_err(|error| error.to_string())?;
    Ok(pixels.chunks(4).map(|pixel| [pixel[0], pixel[1]]).collect())
}

/// Pixels that fronts and backs of a closed surface do not cover equally often.
pub fn unbalanced(device: &wgpu::Device, queue: &wgpu::Queue, triangles: &[Triangle]) -> Result<usize, String> {
    let counts = coverage(device, queue, triangles)?;
    if counts.iter().all(|&[fronts, backs]| fronts == 0 && backs == 0) {
        return Err("the device draws nothing".into());
    }
    Ok(counts.iter().filter(|[fronts, backs]| fronts != backs).count())
}

/// The small trial that tells whether a driver has the fault: pixels counted wrongly of two tubes that leave the picture,
/// one to infinity.
pub fn wrong_pixels(device: &wgpu::Device, queue: &wgpu::Queue) -> Result<usize, String> {
    let tubes = [End::OUTSIDE, End::Infinity].map(|end| unbalanced(device, queue, &tube(end, 1)));
    tubes.into_iter().sum()
}
