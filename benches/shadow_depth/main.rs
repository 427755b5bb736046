//! `cargo bench --bench shadow_depth`: triples of point, light and face a second, on the GPU and on the CPU, with and
//! without skipping; points on the mesh and around it. `--quick` for a small mesh, `--large` for one of a million faces.

use std::time::Instant;

use rimline::gpu::{PositionBuffer, ShadowQuery, ShadowQueryOptions, read_back_vec};
use rimline::reference::cpu::{Threads, shadow_depth};
use rimline::{Light, Mesh, wgpu};
use rimline_testkit::shapes::{self, Shape};

const ROUNDS: usize = 5;

fn main() {
    let has = |wanted: &str| std::env::args().any(|argument| argument == wanted);
    let (shape, points) = match (has("--quick"), has("--large")) {
        (true, _) => (shapes::torus(64, 32, 1.0, 0.4), 1 << 12),
        (_, true) => (shapes::torus(1024, 512, 1.0, 0.4), 1 << 20),
        _ => (shapes::torus(256, 128, 1.0, 0.4), 1 << 16),
    };
    let lights = [Light::point([2.5, 1.5, 3.0])];
    let gpu = Gpu::new();
    println!("{} faces, {points} points, 1 light; median of {ROUNDS}", shape.faces.len());
    println!("adapter: {}", gpu.as_ref().map_or("none", |gpu| &gpu.name));
    for (what, shape) in [("in order", shape.clone()), ("shuffled", shape.shuffled(1))] {
        let on_mesh: Vec<_> = (0..points).map(|i| on_face(&shape, i)).collect();
        let around: Vec<_> = on_mesh.iter().map(|p| p.map(|c| 1.3 * c + 0.01)).collect();
        for (place, points) in [("on the mesh", &on_mesh), ("around it", &around)] {
            println!("faces {what}, points {place}");
            // Without skipping, a part of the points is enough.
            for (skip, part) in [(true, 1), (false, 16)] {
                let points = &points[..points.len() / if what == "shuffled" { 16 } else { part }];
                let depths = gpu.as_ref().map(|gpu| gpu.measure(&shape, points, &lights, skip));
                let name = if skip { "GPU" } else { "GPU, no skipping" };
                let depths = depths.map(|(seconds, depths)| (print(name, &shape, points.len(), seconds), depths).1);
                if skip {
                    let points = &points[..points.len() / 16];
                    let mut found = Vec::new();
                    let mesh = Mesh::from_faces(shape.positions.len(), shape.faces.clone()).expect("a mesh");
                    let run = || {
                        found = shadow_depth(&shape.positions, &mesh, points, &lights, Threads::all())
                            .expect("good lights");
                    };
                    print("CPU", &shape, points.len(), median(run));
                    assert!(depths.is_none_or(|depths| depths.starts_with(&found)), "GPU and CPU differ");
                }
            }
        }
    }
}

/// A point on a face, spread over the mesh.
fn on_face(shape: &Shape, index: usize) -> [f32; 3] {
    let face = shape.faces[index.wrapping_mul(0x9e37_79b1) % shape.faces.len()];
    let [a, b, c] = face.map(|vertex| shape.positions[vertex as usize]);
    let (s, t) = (0.1 + 0.1 * (index % 4) as f32, 0.1 + 0.1 * (index % 5) as f32);
    std::array::from_fn(|axis| a[axis] + s * (b[axis] - a[axis]) + t * (c[axis] - a[axis]))
}

fn median(mut run: impl FnMut()) -> f64 {
    run();
    let mut seconds: Vec<f64> = (0..ROUNDS)
        .map(|_| {
            let start = Instant::now();
            run();
            start.elapsed().as_secs_f64()
        })
        .collect();
    seconds.sort_by(f64::total_cmp);
    seconds[ROUNDS / 2]
}

fn print(name: &str, shape: &Shape, points: usize, seconds: f64) {
    let pairs = points as f64 * shape.faces.len() as f64;
    println!(
        "  {name:<18} {points:>8} points {:>10.2} ms {:>8.2} M points/s {:>9.2} G pairs of point and face/s",
        seconds * 1e3,
        points as f64 / seconds / 1e6,
        pairs / seconds / 1e9
    );
}

struct Gpu {
    name: String,
    device: wgpu::Device,
    queue: wgpu::Queue,
}

impl Gpu {
    fn new() -> Option<Self> {
        let instance = wgpu::Instance::new(wgpu::InstanceDescriptor::new_without_display_handle());
        let options = wgpu::RequestAdapterOptions {
            power_preference: wgpu::PowerPreference::HighPerformance,
            ..Default::default()
        };
        let adapter = pollster::block_on(instance.request_adapter(&options)).ok()?;
        let limits = wgpu::Limits {
            max_buffer_size: adapter.limits().max_buffer_size,
            max_storage_buffer_binding_size: adapter.limits().max_storage_buffer_binding_size,
            ..wgpu::Limits::default()
        };
        let (device, queue) = pollster::block_on(
            adapter.request_device(&wgpu::DeviceDescriptor { required_limits: limits, ..Default::default() }),
        )
        .ok()?;
        Some(Self { name: adapter.get_info().name, device, queue })
    }

    fn storage(&self, points: &[[f32; 3]]) -> wgpu::Buffer {
        let buffer = self.device.create_buffer(&wgpu::BufferDescriptor {
            label: None,
            size: size_of_val(points) as u64,
            usage: wgpu::BufferUsages::STORAGE | wgpu::BufferUsages::COPY_DST,
            mapped_at_creation: false,
        });
        self.queue.write_buffer(&buffer, 0, bytemuck::cast_slice(points));
        buffer
    }

    /// Seconds from recording to the end of the work, and the depths.
    fn measure(&self, shape: &Shape, points: &[[f32; 3]], lights: &[Light], skip: bool) -> (f64, Vec<i32>) {
        let options = ShadowQueryOptions { max_points: points.len() as u32, skip_by_boxes: skip, ..Default::default() };
        let mesh = shape.mesh().expect("a shape is a mesh");
        let mut query = ShadowQuery::new(&self.device, &mesh, options).expect("it fits");
        let buffers = [&shape.positions[..], points].map(|points| self.storage(points));
        let [positions, bound] = [0, 1].map(|at| PositionBuffer { buffer: &buffers[at], offset: 0, stride: 12 });
        let seconds = median(|| {
            let mut encoder = self.device.create_command_encoder(&wgpu::CommandEncoderDescriptor::default());
            query.encode_at(&mut encoder, positions, bound, points.len() as u32, lights, None).expect("good input");
            self.queue.submit([encoder.finish()]);
            self.device.poll(wgpu::PollType::wait_indefinitely()).expect("the device is there");
        });
        let depths = read_back_vec(&self.device, &self.queue, query.depths()).expect("the device is there");
        (seconds, depths)
    }
}
