//! `cargo bench --bench occluded_faces`: faces occluded by faces. How many sides they spare, what they do for a frame,
//! and how long the search takes. The first scenes are like those of Batagelo and Costa Júnior (1999), each with ten
//! lights. `--counts` uses no GPU. `--obj DIRECTORY` writes the paper's second scene of tetrahedra for `rimline
//! shadow`.

mod scenes;

use std::ops::ControlFlow;

use rimline::cpu::{self, OccludedFaces, OcclusionCaster, OcclusionOptions, Threads};
use rimline::gpu::{Measuring, SceneOptions, ShadowFormat, ShadowPipelines};
use rimline::{Counting, Light, Predicate};
use rimline_bench::Error;
use rimline_bench::engine::{Contender, Rounds, clock, times};
use rimline_bench::gpu::{Gpu, Stopwatch};
use rimline_bench::record::{DEPTH, Drawn, FragmentCounter, STENCIL, SceneRecorder, Setting as Recorded, Surfaces};
use rimline_bench::row::compare;
use rimline_bench::shapes::Shape;
use scenes::Setting;

/// Pixels across and down.
const SIZE: u32 = 512;
const ROUNDS: usize = 7;
/// The parts of a frame.
const PARTS: [&str; 3] = ["stages", "depth", STENCIL];

fn main() -> Result<(), Error> {
    let arguments: Vec<String> = std::env::args().collect();
    if let Some(at) = arguments.iter().position(|argument| argument == "--obj") {
        return Ok(write(&arguments[at + 1])?);
    }
    let of_the_paper = scenes::of_the_paper();
    let large = [scenes::city(100_000), scenes::forest(100_000), scenes::building(100_000)];
    counts(of_the_paper.iter().chain(&large));
    searches();
    if arguments.iter().any(|argument| argument == "--counts") {
        return Ok(());
    }
    let (gpu, name) = Gpu::first(wgpu::Features::empty())?;
    println!("\n{name}, {SIZE}x{SIZE} pixels; medians of {ROUNDS} frames in turn, means of all lights, milliseconds");
    compare_frames(&gpu, &of_the_paper, true)?;
    println!("\nLarge scenes");
    compare_frames(&gpu, &large, false)
}

fn casters(setting: &Setting) -> Vec<OcclusionCaster<'_>> {
    let bodies = setting.bodies.iter();
    bodies.map(|(Shape { positions, .. }, mesh)| OcclusionCaster { mesh, positions, version: Some(0) }).collect()
}

fn find(light: Light, casters: &[OcclusionCaster<'_>], options: OcclusionOptions) -> OccludedFaces {
    OccludedFaces::find(light, casters, options, |_, _| ControlFlow::Continue(())).expect("found")
}

/// The faces that cast: back-facing ones of closed casters, and all of others.
fn casting(setting: &Setting, light: Light) -> Vec<[[f32; 3]; 3]> {
    let mut faces = Vec::new();
    for (Shape { positions, .. }, mesh) in &setting.bodies {
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
fn searches() {
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

/// Loose faces: each has three sides.
fn loose(faces: &[[[f32; 3]; 3]]) -> Shape {
    let corners = (0..faces.len() as u32).map(|face| [3 * face, 3 * face + 1, 3 * face + 2]).collect();
    Shape { positions: faces.iter().flatten().copied().collect(), faces: corners }
}

/// Frames with each face's own volume, with silhouettes, and without occluded faces.
fn compare_frames(gpu: &Gpu, settings: &[Setting], has_plain: bool) -> Result<(), Error> {
    println!(
        "| scene | | search | stages | depth | volumes | frame | fragments | volumes, ratio | frame, ratio | frame and search, ratio |"
    );
    println!("|---|---|---:|---:|---:|---:|---:|---:|---:|---:|---:|");
    for setting in settings {
        let casters = casters(setting);
        // For each way: the search, the parts of the frame, fragments.
        let mut sums = [("each face", [0.0; 5]), ("silhouettes", [0.0; 5]), ("and occluded faces", [0.0; 5])];
        let sums = if has_plain { &mut sums[..] } else { &mut sums[1..] };
        for &light in &setting.lights {
            let mut found = None;
            let search = clock(|| found = Some(find(light, &casters, OcclusionOptions::default())));
            let bodies = setting.recorded(setting.bodies.iter().map(|(shape, _)| shape.clone()).collect(), light);
            let plain = has_plain.then(|| setting.recorded(vec![loose(&casting(setting, light))], light));
            let ways = plain.iter().map(|plain| (plain, None)).chain([(&bodies, None), (&bodies, found.as_ref())]);
            let found = frames(gpu, &ways.collect::<Vec<_>>())?;
            for ((name, sums), parts) in sums.iter_mut().zip(found) {
                let search = if *name == "and occluded faces" { search } else { 0.0 };
                let parts = [search].into_iter().chain(parts);
                sums.iter_mut().zip(parts).for_each(|(sum, part)| *sum += part / setting.lights.len() as f64);
            }
        }
        let frame = |sums: &[f64; 5]| sums[1..4].iter().sum::<f64>();
        let base = sums[0].1;
        for (name, of) in sums {
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

/// Milliseconds of the parts of frames, and fragments, of each way: casters, and faces to leave out. All receive on the
/// surfaces of the last.
fn frames(gpu: &Gpu, ways: &[(&Recorded, Option<&OccludedFaces>)]) -> Result<Vec<[f64; 4]>, Error> {
    let format = ShadowFormat { depth_stencil: DEPTH, ..ShadowFormat::default() };
    let pipelines = ShadowPipelines::new(&gpu.pipelines, &format, Counting::Auto)?;
    let counter = FragmentCounter::new(gpu, SIZE, 1)?;
    let mut options = SceneOptions { max_lights: 1, ..SceneOptions::default() };
    options.measuring.set(Measuring::CACHED_BITS, true);
    let mut drawn = Vec::new();
    for &(setting, occluded) in ways {
        let mut scene = SceneRecorder::new(gpu, setting, Some(&pipelines), options)?;
        if let Some(occluded) = occluded {
            let (light, casters) = (scene.lights[0], scene.casters.clone());
            scene.scene.set_occluded_faces(light, &casters, Some(occluded))?;
        }
        let surfaces = ways.last().map(|(setting, _)| Surfaces::of(gpu, DEPTH, setting, None));
        drawn.push(Drawn { scene, surfaces, depth: gpu.texture([SIZE; 2], DEPTH), receivers: None });
    }
    let stopwatch = Stopwatch::new(gpu);
    let contenders = drawn.iter_mut().map(|drawn| -> (&str, Contender<'_>) {
        let stopwatch = &stopwatch;
        let run = move || {
            let mut ms = |part| Ok::<_, Error>(stopwatch.by_clock(|encoder| drawn.record(encoder, part, None))?[1]);
            Ok(times([(PARTS[0], ms(PARTS[0])?), (PARTS[1], ms(PARTS[1])?), (PARTS[2], ms(PARTS[2])?)]))
        };
        ("", Box::new(run))
    });
    let entries = compare(Rounds::exactly(ROUNDS), contenders.collect(), &())?;
    let found = drawn.iter().zip(entries).map(|(drawn, entry)| {
        let fragments = counter.as_ref().map(|counter| counter.count(gpu, |pass, _| drawn.scene.draw(pass, 0)));
        let [stages, depth, volumes] = PARTS.map(|part| entry.ms(part));
        Ok([stages, depth, volumes, fragments.transpose()?.unwrap_or(0) as f64])
    });
    found.collect()
}

/// Writes `below.obj`, and `base.obj` with the polygon that covers it. Y is up there.
fn write(folder: &str) -> std::io::Result<()> {
    let settings = scenes::of_the_paper();
    let setting = settings.iter().find(|setting| setting.name == "tetrahedra 2").expect("a scene");
    let (base, below) = setting.bodies.split_last().expect("a body");
    for (name, bodies) in [("below.obj", below), ("base.obj", std::slice::from_ref(base))] {
        let Shape { positions, faces } = Shape::joined(bodies.iter().map(|(shape, _)| shape));
        let vertices = positions.iter().map(|[x, y, z]| format!("v {x} {z} {}\n", -y));
        let faces = faces.iter().map(|face| {
            let [a, b, c] = face.map(|vertex| vertex + 1);
            format!("f {a} {b} {c}\n")
        });
        std::fs::write(std::path::Path::new(folder).join(name), vertices.chain(faces).collect::<String>())?;
    }
    Ok(())
}
