//! `cargo bench --bench pipelines`: milliseconds to make a further extractor with its shadow volumes, and to use them
//! first, where each has pipelines of its own, where drawing ones are shared, and where all are. A driver's own cache on
//! disk helps the former; Mesa's is off with `MESA_SHADER_CACHE_DISABLE=true`.

use std::time::Instant;

use glam::{Mat4, Vec4};
use rimline::gpu::{
    Extractor, ExtractorOptions, Pipelines, PositionBuffer, ShadowFormat, ShadowOptions, ShadowPipelines, ShadowVolumes,
};
use rimline::{Counting, DepthDirection, Light, Mesh, ShadowCamera, wgpu};
use rimline_testkit::shapes;

const ROUNDS: usize = 15;

/// Pipelines that a further mesh finds made.
#[derive(Clone, Copy, PartialEq)]
enum Shared {
    Nothing,
    Drawing,
    All,
}

fn main() {
    let instance = wgpu::Instance::new(wgpu::InstanceDescriptor::new_without_display_handle().with_env());
    let adapter = pollster::block_on(instance.request_adapter(&wgpu::RequestAdapterOptions::default()));
    let Ok(adapter) = adapter else { return println!("no adapter") };
    let (device, queue) =
        pollster::block_on(adapter.request_device(&wgpu::DeviceDescriptor::default())).expect("default limits");
    let bench = Bench::new(device, queue);
    println!("{}; median of {ROUNDS}, milliseconds", adapter.get_info().name);
    println!("{:<42} {:>8} {:>10}", "", "making", "first use");
    for (what, shared) in [
        ("nothing shared", Shared::Nothing),
        ("one `ShadowPipelines`", Shared::Drawing),
        ("one `Pipelines`", Shared::All),
    ] {
        let all = Pipelines::new(&bench.device);
        let drawing = Bench::drawing(&all);
        // The first mesh, which compiles what is shared.
        bench.run(shared, &all, &drawing);
        let mut times: Vec<_> = (0..ROUNDS).map(|_| bench.run(shared, &all, &drawing)).collect();
        let [making, using] = [0, 1].map(|part| {
            times.sort_by(|a, b| a[part].total_cmp(&b[part]));
            times[ROUNDS / 2][part]
        });
        println!("{what:<42} {making:>8.2} {using:>10.2}");
    }
}

struct Bench {
    device: wgpu::Device,
    queue: wgpu::Queue,
    mesh: Mesh,
    positions: wgpu::Buffer,
}

impl Bench {
    fn new(device: wgpu::Device, queue: wgpu::Queue) -> Self {
        // Small, so that pipelines are what takes time.
        let shape = shapes::torus(24, 16, 1.0, 0.4);
        let positions = device.create_buffer(&wgpu::BufferDescriptor {
            label: Some("positions"),
            size: size_of_val(&shape.positions[..]) as u64,
            usage: wgpu::BufferUsages::STORAGE | wgpu::BufferUsages::COPY_DST,
            mapped_at_creation: false,
        });
        queue.write_buffer(&positions, 0, bytemuck::cast_slice(&shape.positions));
        Self { device, queue, mesh: shape.mesh().expect("a shape is a mesh"), positions }
    }

    fn drawing(pipelines: &Pipelines) -> ShadowPipelines {
        ShadowPipelines::new(pipelines, &ShadowFormat::default(), Counting::Auto).expect("a format that serves")
    }

    /// Milliseconds to make an extractor and volumes, and to encode, submit and wait for them once.
    fn run(&self, shared: Shared, all: &Pipelines, drawing: &ShadowPipelines) -> [f64; 2] {
        let begin = Instant::now();
        let all = if shared == Shared::All { all.clone() } else { Pipelines::new(&self.device) };
        let own = (shared == Shared::Nothing).then(|| Self::drawing(&all));
        let mut extractor = Extractor::new(&all, &self.mesh, ExtractorOptions::default()).expect("a small mesh fits");
        let mut volumes = ShadowVolumes::new(own.as_ref().unwrap_or(drawing), &extractor, ShadowOptions::default())
            .expect("a small mesh fits");
        let made = Instant::now();
        let camera = ShadowCamera {
            view_projection: Mat4::from_cols(Vec4::X, Vec4::Y, -Vec4::W, Vec4::Z * 0.1).to_cols_array_2d(),
            origin: [0.0, 0.0, 5.0],
            depth: DepthDirection::Reversed,
        };
        let light = Light::point([0.0, 5.0, 2.0]);
        let positions = PositionBuffer { buffer: &self.positions, offset: 0, stride: 12 };
        let mut encoder = self.device.create_command_encoder(&wgpu::CommandEncoderDescriptor::default());
        let extraction = extractor.encode(&mut encoder, positions, &[light], None).expect("good input");
        volumes.encode(&mut encoder, &extraction, &camera, None).expect("good input");
        self.queue.submit([encoder.finish()]);
        self.device.poll(wgpu::PollType::wait_indefinitely()).expect("the device is there");
        [made.duration_since(begin), made.elapsed()].map(|time| time.as_secs_f64() * 1e3)
    }
}
