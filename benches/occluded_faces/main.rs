//! `cargo bench --bench occluded_faces`: faces occluded by faces. How many sides they spare, what they do for a frame,
//! and how long the search takes. The first scenes are like those of Batagelo and Costa Júnior (1999), each with ten
//! lights. `--counts` uses no GPU. `--obj DIRECTORY` writes the paper's second scene of tetrahedra for `rimline
//! shadow`.

use std::ops::ControlFlow;

use rimline::cpu::{self, OccludedFaces, OcclusionCaster, OcclusionOptions, Threads};
use rimline::gpu::{Measuring, SceneOptions, ShadowFormat, ShadowPipelines};
use rimline::{Counting, Light, Mesh, Predicate};
use rimline_bench::Error;
use rimline_bench::arguments::value_of;
use rimline_bench::engine::{Contender, Rounds, clock, times};
use rimline_bench::gpu::{Gpu, Stopwatch};
use rimline_bench::random::Random;
use rimline_bench::record::{
    Camera, DEPTH, Drawn, FragmentCounter, IDENTITY, STENCIL, SceneRecorder, Setting as Recorded, Surfaces,
};
use rimline_bench::row::compare;
use rimline_bench::shapes::{self, Shape};

/// Pixels across and down.
const SIZE: u32 = 512;
const ROUNDS: usize = 7;
/// The parts of a frame.
const PARTS: [&str; 3] = ["stages", "depth", STENCIL];

fn main() -> Result<(), Error> {
    let arguments: Vec<String> = std::env::args().collect();
    if let Some(folder) = value_of("--obj", &arguments)? {
        return Ok(write(&folder)?);
    }
    let of_the_paper = of_the_paper();
    let large = [city(100_000), forest(100_000), building(100_000)];
    counts(of_the_paper.iter().chain(&large));
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
        let one_thread = OcclusionOptions { threads: Threads::ONE, ..OcclusionOptions::default() };
        // For each way: the search, the parts of the frame, fragments.
        let mut sums = [("each face", [0.0; 5]), ("silhouettes", [0.0; 5]), ("and occluded faces", [0.0; 5])];
        let sums = if has_plain { &mut sums[..] } else { &mut sums[1..] };
        for &light in &setting.lights {
            let mut found = None;
            let search = clock(|| found = Some(find(light, &casters, one_thread)));
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
        for (name, of) in &*sums {
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
    let settings = of_the_paper();
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

struct Setting {
    name: &'static str,
    /// In world space, Z up, each with its mesh.
    bodies: Vec<(Shape, Mesh)>,
    lights: Vec<Light>,
    eye: [f32; 3],
    target: [f32; 3],
    /// The height of the ground, which receives shadows.
    ground: f32,
}

impl Setting {
    /// Casters of the setting as they are recorded, with Y up.
    fn recorded(&self, shapes: Vec<Shape>, light: Light) -> Recorded {
        let upright = |[x, y, z]: [f32; 3]| [x, z, -y];
        let placed = (0..shapes.len()).map(|shape| (shape, IDENTITY)).collect();
        let shapes = shapes.into_iter().map(|shape| shape.placed(upright)).collect();
        let [eye, target] = [self.eye, self.target].map(|point| glam::Vec3::from(upright(point)));
        let camera = Camera::level(eye, target - eye, 2.0, 0.5);
        let light = Light { xyz: upright(light.xyz), ..light };
        Recorded { ground: Some(self.ground), ..Recorded::rigid(shapes, placed, vec![light], &camera) }
    }
}

fn placed(shape: &Shape, scale: [f32; 3], at: [f32; 3]) -> Shape {
    shape.clone().placed(|p| std::array::from_fn(|axis| p[axis] * scale[axis] + at[axis]))
}

fn with_meshes(bodies: Vec<Shape>) -> Vec<(Shape, Mesh)> {
    let with_mesh = |shape: Shape| {
        let mesh = shape.mesh().expect("a mesh");
        (shape, mesh)
    };
    bodies.into_iter().map(with_mesh).collect()
}

fn tetrahedron() -> Shape {
    let positions = vec![[1.0, 1.0, 1.0], [1.0, -1.0, -1.0], [-1.0, 1.0, -1.0], [-1.0, -1.0, 1.0]];
    Shape { positions, faces: vec![[0, 1, 2], [0, 2, 3], [0, 3, 1], [1, 3, 2]] }
}

fn icosahedron() -> Shape {
    let g = 0.5 * (1.0 + 5.0_f32.sqrt());
    let corners = [(1.0, g), (-1.0, g), (1.0, -g), (-1.0, -g)].map(|(a, b)| [[0.0, a, b], [a, b, 0.0], [b, 0.0, a]]);
    let mut shape = Shape { positions: corners.concat(), faces: Vec::new() };
    for (a, b, c) in (0..12).flat_map(|a| (a + 1..12).flat_map(move |b| (b + 1..12).map(move |c| (a, b, c)))) {
        let [u, v, w] = [a, b, c].map(|vertex| glam::Vec3::from(shape.positions[vertex as usize]));
        if [(u, v), (v, w), (w, u)].iter().all(|(from, to)| from.distance_squared(*to) < 4.5) {
            let is_outward = (v - u).cross(w - u).dot(u) > 0.0;
            shape.faces.push(if is_outward { [a, b, c] } else { [a, c, b] });
        }
    }
    shape
}

/// A square of four faces around its middle.
fn base() -> Shape {
    let positions = vec![[-1.0, -1.0, 0.0], [1.0, -1.0, 0.0], [1.0, 1.0, 0.0], [-1.0, 1.0, 0.0], [0.0, 0.0, 0.0]];
    Shape { positions, faces: vec![[0, 1, 4], [1, 2, 4], [2, 3, 4], [3, 0, 4]] }
}

/// `count` bodies at random positions on the ground.
fn strewn(seed: u64, count: usize, far: f32, shape: &Shape, scale: impl Fn(&mut Random) -> [f32; 3]) -> Vec<Shape> {
    let mut random = Random::new(seed);
    let body = |_| {
        let scale = scale(&mut random);
        placed(shape, scale, [random.between(-far, far), random.between(-far, far), scale[2]])
    };
    (0..count).map(body).collect()
}

/// The paper's scenes have 256, 96, 752, 752 and 1,502 polygons, and ten lights each.
fn of_the_paper() -> Vec<Setting> {
    let mut random = Random::new(1);
    let lights: Vec<Light> =
        (0..10).map(|_| Light::point([random.between(-9.0, 9.0), random.between(-9.0, 9.0), 20.0])).collect();
    let tetrahedra = |height: f32| {
        let mut bodies = strewn(7, 187, 10.0, &tetrahedron(), |_| [0.5; 3]);
        bodies.push(placed(&base(), [14.0, 14.0, 1.0], [0.0, 0.0, height]));
        bodies
    };
    let kinds = [(shapes::cube(), 2), (tetrahedron(), 2), (shapes::sphere(1), 3), (icosahedron(), 2)];
    let solids = kinds.iter().flat_map(|(shape, count)| std::iter::repeat_n(shape, *count)).enumerate();
    let solids = solids.map(|(number, shape)| {
        placed(shape, [1.0; 3], [6.0 * (number % 3) as f32 - 6.0, 6.0 * (number / 3) as f32 - 6.0, 2.0])
    });
    let cube = shapes::cube();
    let cubes = (0..125).map(|number| {
        let at = [number % 5, number / 5 % 5, number / 25].map(|step| 2.0 * step as f32);
        placed(&cube, [0.5; 3], [at[0] - 4.0, at[1] - 4.0, at[2] + 1.0])
    });
    let all = [
        ("sphere", vec![placed(&shapes::globe(16, 9), [3.0; 3], [0.0, 0.0, 3.0])]),
        ("solids", solids.collect()),
        ("tetrahedra 1", tetrahedra(-3.0)),
        ("tetrahedra 2", tetrahedra(4.0)),
        ("cubes", cubes.chain([placed(&shapes::square(), [14.0, 14.0, 1.0], [0.0, 0.0, -3.0])]).collect()),
    ];
    let (eye, target, ground) = ([6.0, -26.0, 11.0], [0.0, 0.0, -1.0], -5.0);
    let setting =
        |(name, bodies)| Setting { name, bodies: with_meshes(bodies), lights: lights.clone(), eye, target, ground };
    all.into_iter().map(setting).collect()
}

/// A large scene on the ground, that reaches so far, in the light of a direction, from a height.
fn large(name: &'static str, bodies: Vec<Shape>, light: [f32; 3], [far, height, aim]: [f32; 3]) -> Setting {
    let (eye, target) = ([-far, -1.2 * far, height], [0.0, 0.0, aim]);
    let lights = vec![Light::directional(light)];
    Setting { name, bodies: with_meshes(bodies), lights, eye, target, ground: 0.0 }
}

/// Boxes of 12 faces, so many faces in all.
fn city(faces: usize) -> Setting {
    let count = faces / 12;
    let far = 5.0 * (count as f32).sqrt();
    let boxes = strewn(3, count, far, &shapes::cube(), |random| [3.0, 3.0, random.between(2.0, 30.0)]);
    large("city", boxes, [1.0, 0.4, 0.5], [far, 90.0, 0.0])
}

fn forest(faces: usize) -> Setting {
    let tree = shapes::sphere(6);
    let count = faces / tree.faces.len();
    let far = 60.0 * (faces as f32 / 1e5).sqrt();
    let trees = strewn(4, count, far, &tree, |random| [1.0, 1.0, random.between(1.0, 6.0)]);
    large("forest", trees, [1.0, 0.4, 0.5], [far, 20.0, 0.0])
}

/// Boxes under a roof that all of the light comes from.
fn building(faces: usize) -> Setting {
    let far = 40.0 * (faces as f32 / 1e5).sqrt();
    let mut bodies = strewn(6, faces.saturating_sub(2) / 12, far, &shapes::cube(), |_| [0.4, 0.4, 1.0]);
    bodies.push(placed(&shapes::square(), [far + 10.0, far + 10.0, 1.0], [0.0, 0.0, 4.0]));
    large("building", bodies, [0.1, 0.2, 1.0], [far, 2.5, 1.0])
}
