//! `cargo bench --bench scene`: milliseconds of CPU time to record a scene, for 1 to 10,000 boxes and 5 lights where
//! all stand still, 1 in 100 moves, all move, a light moves, and a caster comes; and of GPU time to extract 200 boxes
//! and 200 figures, beside the same faces merged into one mesh. GPU times are of the device's clock, or of a wall clock
//! without.

use std::time::Instant;

use rimline::gpu::{
    Caster, CasterHandle, Extractor, ExtractorOptions, Pipelines, PositionBuffer, Scene, SceneOptions, StageTimer,
};
use rimline::mesh::Weld;
use rimline::{Light, Matrix3x4, Mesh, wgpu};
use rimline_measure::random::Random;
use rimline_measure::shapes::{self, Shape};

const ROUNDS: usize = 31;
const LIGHTS: usize = 5;

fn main() {
    let instance = wgpu::Instance::new(wgpu::InstanceDescriptor::new_without_display_handle().with_env());
    let adapter = pollster::block_on(instance.request_adapter(&wgpu::RequestAdapterOptions::default()));
    let Ok(adapter) = adapter else { return println!("no adapter") };
    let descriptor = wgpu::DeviceDescriptor {
        required_features: adapter.features() & wgpu::Features::TIMESTAMP_QUERY,
        ..Default::default()
    };
    let (device, queue) = pollster::block_on(adapter.request_device(&descriptor)).expect("default limits");
    let bench = Bench { pipelines: Pipelines::new(&device), device, queue };
    println!("{}; {LIGHTS} lights, median of {ROUNDS}, milliseconds", adapter.get_info().name);
    bench.recording();
    bench.extracting("box", &shapes::cube(), 200);
    bench.extracting("torus of 4,000 faces", &shapes::torus(50, 40, 1.0, 0.4), 200);
    bench.extracting("torus of 1,024 faces", &shapes::torus(32, 16, 1.0, 0.4), 1);
    bench.extracting("torus of a million faces", &shapes::torus(1024, 512, 1.0, 0.4), 1);
}

struct Bench {
    device: wgpu::Device,
    queue: wgpu::Queue,
    pipelines: Pipelines,
}

/// A place in a field of casters.
fn transform(random: &mut Random) -> Matrix3x4 {
    let angle = random.between(-3.0, 3.0);
    let (s, c) = angle.sin_cos();
    let [x, y, z] = [(); 3].map(|()| random.between(-50.0, 50.0));
    [[c, 0.0, s, x], [0.0, 1.0, 0.0, y], [-s, 0.0, c, z]]
}

fn light(random: &mut Random) -> Light {
    Light::point([(); 3].map(|()| random.between(-60.0, 60.0)))
}

/// Half of `ROUNDS` is above and half below.
fn median(mut measure: impl FnMut() -> f64) -> f64 {
    measure();
    let mut times: Vec<_> = (0..ROUNDS).map(|_| measure()).collect();
    times.sort_by(f64::total_cmp);
    times[ROUNDS / 2]
}

fn mesh(shape: &Shape) -> Mesh {
    Mesh::new(&shape.positions, &shape.faces, Weld::Position).expect("a shape is a mesh")
}

impl Bench {
    fn scene(&self, shape: &Shape, count: usize, random: &mut Random) -> (Scene, Vec<CasterHandle>, Vec<Matrix3x4>) {
        let options = SceneOptions { max_lights: 32, ..Default::default() };
        let mut scene = Scene::new(&self.pipelines, &self.queue, options).expect("a device");
        let mesh = scene.add_mesh(&mesh(shape), &shape.positions).expect("a mesh");
        let places: Vec<_> = (0..count).map(|_| transform(random)).collect();
        let insert = |&place: &Matrix3x4| scene.insert(Caster::rigid(mesh, place)).expect("a caster");
        let casters = places.iter().map(insert).collect();
        (scene, casters, places)
    }

    /// Milliseconds of `change` and of recording.
    fn record(&self, scene: &mut Scene, mut change: impl FnMut(&mut Scene)) -> f64 {
        median(|| {
            let mut encoder = self.device.create_command_encoder(&wgpu::CommandEncoderDescriptor::default());
            let begin = Instant::now();
            change(scene);
            scene.encode(&mut encoder, &[], None).expect("an encode");
            let commands = encoder.finish();
            let ms = begin.elapsed().as_secs_f64() * 1e3;
            self.queue.submit([commands]);
            self.device.poll(wgpu::PollType::wait_indefinitely()).expect("a device");
            ms
        })
    }

    fn recording(&self) {
        println!(
            "{:>7} {:>9} {:>9} {:>9} {:>9} {:>9} {:>9}",
            "boxes", "still", "1 in 100", "all", "a light", "one new", "B each"
        );
        for count in [1, 10, 100, 200, 1000, 10_000] {
            let mut random = Random::new(1);
            let (mut scene, casters, _) = self.scene(&shapes::cube(), count, &mut random);
            let lights: Vec<_> = (0..LIGHTS).map(|_| scene.add_light(light(&mut random)).expect("room")).collect();
            let still = self.record(&mut scene, |_| ());
            let mut some = |scene: &mut Scene, step: usize| {
                for &caster in casters.iter().step_by(step) {
                    scene.set_transform(caster, transform(&mut random)).expect("rigid");
                }
            };
            let moved = self.record(&mut scene, |scene| some(scene, 100));
            let all = self.record(&mut scene, |scene| some(scene, 1));
            let lit = self.record(&mut scene, |scene| scene.set_light(lights[2], light(&mut random)).expect("there"));
            let extra = scene.add_mesh(&mesh(&shapes::cube()), &shapes::cube().positions).expect("a mesh");
            let mut last = None;
            let new = self.record(&mut scene, |scene| {
                if let Some(last) = last.take() {
                    scene.remove(last).expect("there");
                }
                last = scene.insert(Caster::rigid(extra, transform(&mut random))).ok();
            });
            let mut encoder = self.device.create_command_encoder(&wgpu::CommandEncoderDescriptor::default());
            let frame = scene.encode(&mut encoder, &[], None).expect("an encode");
            let bytes = frame.results().map_or(0, |results| results.bytes) / count as u64;
            println!("{count:>7} {still:>9.3} {moved:>9.3} {all:>9.3} {lit:>9.3} {new:>9.3} {bytes:>9}");
        }
    }

    /// Milliseconds of the device for what `record` records.
    fn timed(&self, mut record: impl FnMut(&mut wgpu::CommandEncoder, Option<&mut StageTimer>)) -> (f64, String) {
        let mut timer = StageTimer::new(&self.device, &self.queue);
        let mut stages = String::new();
        let ms = median(|| {
            let mut encoder = self.device.create_command_encoder(&wgpu::CommandEncoderDescriptor::default());
            if let Some(timer) = &mut timer {
                timer.clear();
            }
            record(&mut encoder, timer.as_mut());
            if let Some(timer) = &timer {
                timer.resolve(&mut encoder);
            }
            let begin = Instant::now();
            self.queue.submit([encoder.finish()]);
            self.device.poll(wgpu::PollType::wait_indefinitely()).expect("a device");
            let ms = begin.elapsed().as_secs_f64() * 1e3;
            match &timer {
                None => ms,
                Some(timer) => {
                    let times = timer.read(&self.device, &self.queue).expect("times");
                    let times_of_stages: Vec<_> = times.iter().map(|(name, ms)| format!("{name} {ms:.3}")).collect();
                    stages = times_of_stages.join(" ");
                    times.iter().map(|(_, ms)| ms).sum()
                }
            }
        });
        (ms, stages)
    }

    /// Milliseconds of a wall clock from the submission on.
    fn clocked(&self, mut record: impl FnMut(&mut wgpu::CommandEncoder)) -> f64 {
        median(|| {
            let mut encoder = self.device.create_command_encoder(&wgpu::CommandEncoderDescriptor::default());
            record(&mut encoder);
            let commands = encoder.finish();
            let begin = Instant::now();
            self.queue.submit([commands]);
            self.device.poll(wgpu::PollType::wait_indefinitely()).expect("a device");
            begin.elapsed().as_secs_f64() * 1e3
        })
    }

    fn extracting(&self, name: &str, shape: &Shape, count: usize) {
        let mut random = Random::new(2);
        let (mut scene, _, places) = self.scene(shape, count, &mut random);
        let lights: Vec<_> = (0..LIGHTS).map(|_| light(&mut random)).collect();
        for &light in &lights {
            scene.add_light(light).expect("room");
        }
        let mut merged = Shape { positions: Vec::new(), faces: Vec::new() };
        for place in &places {
            let first = merged.positions.len() as u32;
            let placed = |&[x, y, z]: &[f32; 3]| place.map(|[a, b, c, d]| a * x + b * y + c * z + d);
            merged.positions.extend(shape.positions.iter().map(placed));
            merged.faces.extend(shape.faces.iter().map(|face| face.map(|vertex| first + vertex)));
        }
        let options = ExtractorOptions { max_lights: LIGHTS, ..Default::default() };
        // Vertices of two casters must not be welded.
        let whole = Mesh::new(&merged.positions, &merged.faces, Weld::Position).expect("a mesh");
        let mut extractor = Extractor::new(&self.pipelines, &whole, options).expect("an extractor");
        let buffer = self.device.create_buffer(&wgpu::BufferDescriptor {
            label: None,
            size: 12 * merged.positions.len() as u64,
            usage: wgpu::BufferUsages::STORAGE | wgpu::BufferUsages::COPY_DST,
            mapped_at_creation: false,
        });
        self.queue.write_buffer(&buffer, 0, bytemuck::cast_slice(&merged.positions));
        let positions = PositionBuffer { buffer: &buffer, offset: 0, stride: 12 };
        for _ in 0..2 {
            let (one, one_stages) = self.timed(|encoder, timer| {
                extractor.encode(encoder, positions, &lights, timer).expect("an encode");
            });
            let (many, many_stages) = self.timed(|encoder, timer| {
                scene.encode(encoder, &[], timer).expect("an encode");
            });
            println!("{count} × {name}: scene {many:.3}, merged {one:.3}, ratio {:.2}", many / one);
            println!("  scene: {many_stages}");
            println!("  merged: {one_stages}");
            let one = self.clocked(|encoder| _ = extractor.encode(encoder, positions, &lights, None));
            let many = self.clocked(|encoder| _ = scene.encode(encoder, &[], None));
            println!("  by a clock: scene {many:.3}, merged {one:.3}, ratio {:.2}", many / one);
        }
    }
}
