//! `cargo bench --bench occluded_faces`: faces occluded by faces. How many sides they spare, what they do for a frame,
//! and how long the search takes. The first scenes are like those of Batagelo and Costa Júnior (1999), each with ten
//! lights. `--counts` uses no GPU. `--obj DIRECTORY` writes the paper's second scene of tetrahedra for `rimline
//! shadow`.

mod scenes;

use std::cell::RefCell;
use std::ops::ControlFlow;

use rimline::cpu::{self, OccludedFaces, OcclusionCaster, OcclusionOptions, Threads};
use rimline::gpu::{Measuring, SceneOptions, ShadowFormat, ShadowPipelines};
use rimline::{Counting, Light, Predicate};
use rimline_bench::Error;
use rimline_bench::engine::{Contender, Metric, Rounds, clock, interleave};
use rimline_bench::gpu::{Gpu, Stopwatch};
use rimline_bench::record::{
    DEPTH, FragmentCounter, Pass, Recorder as _, SceneRecorder, Setting as Recorded, Surfaces, Until, stencil_pass,
};
use rimline_bench::row::{Entry, Variant};
use rimline_bench::shapes::Shape;
use scenes::{Body, Setting};

/// Pixels across and down.
const SIZE: u32 = 512;
const ROUNDS: usize = 7;
/// The parts of a frame.
const PARTS: [Metric; 3] = [Metric::Time("stages"), Metric::Time("depth"), Metric::Time("volumes")];

fn main() -> Result<(), Error> {
    let arguments: Vec<String> = std::env::args().collect();
    if let Some(at) = arguments.iter().position(|argument| argument == "--obj") {
        return Ok(write(&arguments[at + 1])?);
    }
    let of_the_paper = scenes::of_the_paper();
    let large = [scenes::city(100_000), scenes::forest(100_000), scenes::building(100_000)];
    counts(of_the_paper.iter().chain(&large));
    times();
    if arguments.iter().any(|argument| argument == "--counts") {
        return Ok(());
    }
    let (gpu, name) = Gpu::first()?;
    println!("\n{name}, {SIZE}x{SIZE} pixels; medians of {ROUNDS} frames in turn, means of all lights, milliseconds");
    compare(&gpu, &of_the_paper, true)?;
    println!("\nLarge scenes");
    compare(&gpu, &large, false)
}

fn casters(setting: &Setting) -> Vec<OcclusionCaster<'_>> {
    let casters = setting.bodies.iter();
    casters.map(|Body { positions, mesh }| OcclusionCaster { mesh, positions, version: Some(0) }).collect()
}

fn find(light: Light, casters: &[OcclusionCaster<'_>], options: OcclusionOptions) -> OccludedFaces {
    OccludedFaces::find(light, casters, options, |_, _| ControlFlow::Continue(())).expect("found")
}

/// The faces that cast: back-facing ones of closed casters, and all of others.
fn casting(setting: &Setting, light: Light) -> Vec<[[f32; 3]; 3]> {
    let mut faces = Vec::new();
    for Body { positions, mesh } in &setting.bodies {
        let facing = cpu::extract(positions, mesh, &[light], Predicate::Exact, Threads::ONE).expect("a light").facing;
        let casting = mesh.faces().iter().zip(facing).filter(|(_, mask)| !mesh.is_closed() || mask & 1 == 0);
        faces.extend(casting.map(|(face, _)| face.map(|vertex| positions[vertex as usize])));
    }
    faces
}

/// Sides of shadow volumes: the paper's figure 10, and what the product chooses.
fn counts<'a>(settings: impl Iterator<Item = &'a Setting>) {
    println!(
        "| scene | faces | occluded | left out | undecided | sides, plain | silhouettes | without all occluded faces | without those left out | nodes |"
    );
    println!("|---|---:|---:|---:|---:|---:|---:|---:|---:|---:|");
    for setting in settings {
        let casters = casters(setting);
        let faces: usize = casters.iter().map(|caster| caster.mesh.faces().len()).sum();
        let mut sums = [0; 8];
        for &light in &setting.lights {
            let found = find(light, &casters, OcclusionOptions::default()).statistics();
            let all = find(light, &casters, OcclusionOptions { leave_out_all: true, ..OcclusionOptions::default() });
            let plain = 3 * casting(setting, light).len();
            let counts = [found.occluded, found.left_out, found.undecided, plain, found.sides];
            let counts = counts.into_iter().chain([all.statistics().sides_left, found.sides_left, found.nodes]);
            sums.iter_mut().zip(counts).for_each(|(sum, count)| *sum += count);
        }
        let means = sums.map(|sum| (sum / setting.lights.len()).to_string());
        println!("| {} | {faces} | {} |", setting.name, means.join(" | "));
    }
}

/// The search against the number of faces.
fn times() {
    let threads = Threads::all().count();
    println!("\nThe search, milliseconds, on one thread and on {threads}; the least of three");
    println!("| faces | city | | forest | | building | |");
    println!("|---:|---:|---:|---:|---:|---:|---:|");
    for faces in [1_000, 3_000, 10_000, 30_000, 100_000, 200_000] {
        let cells = [scenes::city(faces), scenes::forest(faces), scenes::building(faces)].map(|setting| {
            let casters = casters(&setting);
            let mut least = [f64::INFINITY; 2];
            for _ in 0..3 {
                for (threads, least) in [Threads::ONE, Threads::all()].into_iter().zip(&mut least) {
                    let options = OcclusionOptions { threads, ..OcclusionOptions::default() };
                    *least = least.min(clock(|| drop(find(setting.lights[0], &casters, options))));
                }
            }
            least.map(|time| format!("{time:.1}")).join(" | ")
        });
        println!("| {faces} | {} |", cells.join(" | "));
    }
}

/// A body as it is recorded.
fn shape(body: &Body) -> Shape {
    Shape { positions: body.positions.clone(), faces: body.mesh.faces().to_vec() }
}

/// Loose faces: each has three sides.
fn loose(faces: &[[[f32; 3]; 3]]) -> Shape {
    let corners = (0..faces.len() as u32).map(|face| [3 * face, 3 * face + 1, 3 * face + 2]).collect();
    Shape { positions: faces.iter().flatten().copied().collect(), faces: corners }
}

/// Frames with each face's own volume, with silhouettes, and without occluded faces.
fn compare(gpu: &Gpu, settings: &[Setting], has_plain: bool) -> Result<(), Error> {
    println!(
        "| scene | | search | stages | depth | volumes | frame | fragments | volumes, ratio | frame, ratio | frame and search, ratio |"
    );
    println!("|---|---|---:|---:|---:|---:|---:|---:|---:|---:|---:|");
    let names = ["each face", "silhouettes", "and occluded faces"];
    for setting in settings {
        let casters = casters(setting);
        let mut sums = [[0.0; 5]; 3];
        for &light in &setting.lights {
            let mut found = None;
            let search = clock(|| found = Some(find(light, &casters, OcclusionOptions::default())));
            let bodies: Vec<Shape> = setting.bodies.iter().map(shape).collect();
            let plain = has_plain.then(|| vec![loose(&casting(setting, light))]);
            let ways = [plain, Some(bodies.clone()), Some(bodies)];
            let of_ways = frames(gpu, setting, light, ways, found.as_ref())?;
            for ((sums, parts), search) in sums.iter_mut().zip(of_ways).zip([0.0, 0.0, search]) {
                let parts = [search].into_iter().chain(parts);
                sums.iter_mut().zip(parts).for_each(|(sum, part)| *sum += part / setting.lights.len() as f64);
            }
        }
        let frame = |sums: &[f64; 5]| sums[1..4].iter().sum::<f64>();
        let base = if has_plain { sums[0] } else { sums[1] };
        for (name, of) in names.into_iter().zip(&sums).filter(|(_, of)| frame(of) > 0.0) {
            let ratios = [base[3] / of[3], frame(&base) / frame(of), frame(&base) / (frame(of) + of[0])];
            let [search, stages, depth, volumes, fragments] = of;
            println!(
                "| {} | {name} | {search:.2} | {stages:.2} | {depth:.2} | {volumes:.2} | {:.2} | {fragments:.0} | {} |",
                setting.name,
                frame(of),
                ratios.map(|ratio| format!("{ratio:.2}")).join(" | ")
            );
        }
    }
    Ok(())
}

/// Milliseconds of the parts of frames, and fragments, of scenes of these casters; the last one without occluded faces.
fn frames(
    gpu: &Gpu,
    setting: &Setting,
    light: Light,
    ways: [Option<Vec<Shape>>; 3],
    occluded: Option<&OccludedFaces>,
) -> Result<[[f64; 4]; 3], Error> {
    let format = ShadowFormat { depth_stencil: DEPTH, ..ShadowFormat::default() };
    let pipelines = ShadowPipelines::new(&gpu.pipelines, &format, Counting::Auto)?;
    let depth = gpu.texture(SIZE, DEPTH).create_view(&wgpu::TextureViewDescriptor::default());
    let counter = FragmentCounter::new(gpu, SIZE, 1)?;
    let recorded: Vec<Option<Recorded>> = ways.into_iter().map(|way| Some(setting.recorded(way?, light))).collect();
    let mut options = SceneOptions { max_lights: 1, ..SceneOptions::default() };
    options.measuring.set(Measuring::CACHED_BITS, true);
    let surfaces = recorded[1].as_ref().map(|setting| Surfaces::of(gpu, setting, None));
    let mut recorders = Vec::new();
    for (number, setting) in recorded.iter().enumerate() {
        let Some(setting) = setting else { continue };
        let mut recorder = SceneRecorder::new(gpu, setting, Some(&pipelines), options)?;
        if number == 2 {
            let (light, casters) = (recorder.lights[0], recorder.casters.clone());
            recorder.scene.set_occluded_faces(light, &casters, occluded)?;
        }
        recorders.push((number, RefCell::new(recorder)));
    }
    let stopwatch = Stopwatch::new(gpu);
    let contenders = recorders.iter().map(|(_, recorder)| -> Contender<'_> {
        let (stopwatch, surfaces, depth) = (&stopwatch, &surfaces, &depth);
        Box::new(move || {
            let mut recorder = recorder.borrow_mut();
            let stages = stopwatch.by_clock(|encoder| recorder.encode(encoder, Until::Volumes, None))?;
            let seen = stopwatch.by_clock(|encoder| {
                if let Some(surfaces) = surfaces {
                    surfaces.pass(encoder, depth, Pass::Depth, None);
                }
                Ok(())
            })?;
            let volumes = stopwatch.by_clock(|encoder| {
                recorder.draw(&mut stencil_pass(encoder, depth, wgpu::LoadOp::Load, None, None), 0)
            })?;
            Ok(PARTS.into_iter().zip([stages, seen, volumes].map(|[_, ms]| ms)).collect())
        })
    });
    let samples = interleave(Rounds::exactly(ROUNDS), contenders.collect(), &())?;
    let mut found = [[0.0; 4]; 3];
    for ((number, recorder), samples) in recorders.iter().zip(samples) {
        let entry = Entry::new(Variant::new("", "", 0, 0), &samples);
        let medians = PARTS.map(|part| entry.median(part).unwrap_or(f64::NAN));
        let fragments = counter.as_ref().map(|counter| counter.count(gpu, |pass, _| recorder.borrow().draw(pass, 0)));
        found[*number] = [medians[0], medians[1], medians[2], fragments.transpose()?.unwrap_or(0) as f64];
    }
    Ok(found)
}

/// Writes `below.obj`, and `base.obj` with the polygon that covers it. Y is up there.
fn write(folder: &str) -> std::io::Result<()> {
    let settings = scenes::of_the_paper();
    let setting = settings.iter().find(|setting| setting.name == "tetrahedra 2").expect("a scene");
    let (base, below) = setting.bodies.split_last().expect("a body");
    for (name, bodies) in [("below.obj", below), ("base.obj", std::slice::from_ref(base))] {
        let (mut text, mut first) = (String::new(), 1);
        for Body { positions, mesh } in bodies {
            text.extend(positions.iter().map(|[x, y, z]| format!("v {x} {z} {}\n", -y)));
            text.extend(mesh.faces().iter().map(|face| {
                let [a, b, c] = face.map(|vertex| vertex + first);
                format!("f {a} {b} {c}\n")
            }));
            first += positions.len() as u32;
        }
        std::fs::write(std::path::Path::new(folder).join(name), text)?;
    }
    Ok(())
}
