//! `cargo bench --bench hidden_faces`: faces hidden by faces. How many sides they spare, what they do for a frame, and how long the
//! search takes. The first scenes are like those of Batagelo and Costa Júnior (1999), each with ten lights. `--counts` uses no
//! GPU, `--caps` compares caps only. `--obj DIRECTORY` writes the paper's second scene of tetrahedra for `rimline shadow`.

mod capping;
mod frames;
mod scenes;

use std::ops::ControlFlow;
use std::rc::Rc;
use std::time::Instant;

use frames::{Frames, Measured};
use rimline::cpu::{self, HiddenCaster, HiddenFaces, HiddenOptions, Threads};
use rimline::{Counting, Light, Mesh, Predicate};
use scenes::{Body, Setting};

fn main() {
    let arguments: Vec<String> = std::env::args().collect();
    if let Some(at) = arguments.iter().position(|argument| argument == "--obj") {
        return write(&arguments[at + 1]).expect("files that can be written");
    }
    if arguments.iter().any(|argument| argument == "--caps") {
        return capping::compare(&scenes::in_shadow()).expect("frames");
    }
    let of_the_paper = scenes::of_the_paper();
    let large = [scenes::city(100_000), scenes::forest(100_000), scenes::building(100_000)];
    counts(of_the_paper.iter().chain(&large));
    times();
    if arguments.iter().any(|argument| argument == "--counts") {
        return;
    }
    let frames = Frames::new(Counting::Auto).expect("a device");
    println!(
        "\n{}, {}x{} pixels; means of all lights, milliseconds",
        frames.gpu.name,
        frames::SIZE[0],
        frames::SIZE[1]
    );
    compare(&frames, &of_the_paper, true);
    println!("\nLarge scenes");
    compare(&frames, &large, false);
    drop(frames);
    println!("\nCaps, from eyes in shadow");
    capping::compare(&scenes::in_shadow()).expect("frames");
}

fn casters(setting: &Setting) -> Vec<HiddenCaster<'_>> {
    let casters = setting.bodies.iter();
    casters.map(|Body { positions, mesh }| HiddenCaster { mesh, positions, version: Some(0) }).collect()
}

fn find(light: Light, casters: &[HiddenCaster<'_>], options: HiddenOptions) -> HiddenFaces {
    HiddenFaces::find(light, casters, options, |_, _| ControlFlow::Continue(())).expect("found")
}

/// The faces that cast: averted ones of closed casters, and all of others.
fn casting(setting: &Setting, light: Light) -> Vec<[[f32; 3]; 3]> {
    let mut faces = Vec::new();
    for Body { positions, mesh } in &setting.bodies {
        let facing = cpu::extract(positions, mesh, &[light], Predicate::Exact, Threads::ONE).expect("a light").facing;
        let own = mesh.faces().iter().zip(facing).filter(|(_, mask)| !mesh.is_closed() || mask & 1 == 0);
        faces.extend(own.map(|(face, _)| face.map(|vertex| positions[vertex as usize])));
    }
    faces
}

/// Sides of shadow volumes: the paper's figure 10, and what the product chooses.
fn counts<'a>(settings: impl Iterator<Item = &'a Setting>) {
    println!(
        "| scene | faces | hidden | left out | undecided | sides, plain | silhouettes | without all hidden faces | without those left out | nodes |"
    );
    println!("|---|---:|---:|---:|---:|---:|---:|---:|---:|---:|");
    for setting in settings {
        let casters = casters(setting);
        let faces: usize = casters.iter().map(|caster| caster.mesh.faces().len()).sum();
        let mut sums = [0; 8];
        for &light in &setting.lights {
            let found = find(light, &casters, HiddenOptions::default()).statistics();
            let all = find(light, &casters, HiddenOptions { leave_out_all: true, ..HiddenOptions::default() });
            let plain = 3 * casting(setting, light).len();
            let counts = [found.hidden, found.left_out, found.undecided, plain, found.sides];
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
                    let begin = Instant::now();
                    let found =
                        find(setting.lights[0], &casters, HiddenOptions { threads, ..HiddenOptions::default() });
                    *least = least.min(begin.elapsed().as_secs_f64() * 1e3);
                    assert_eq!(found.statistics().without_room, 0, "{} of {faces} faces", setting.name);
                }
            }
            least.map(|time| format!("{time:.1}")).join(" | ")
        });
        println!("| {faces} | {} |", cells.join(" | "));
    }
}

/// Loose faces as a body: each has three sides.
fn loose(faces: &[[[f32; 3]; 3]]) -> Body {
    let count = faces.len() as u32;
    let corners = (0..count).map(|face| [3 * face, 3 * face + 1, 3 * face + 2]).collect();
    let mesh = Mesh::from_faces(3 * faces.len(), corners).expect("a mesh");
    Body { positions: faces.iter().flatten().copied().collect(), mesh: Rc::new(mesh) }
}

/// Frames with each face's own volume, with silhouettes, and without hidden faces.
fn compare(frames: &Frames, settings: &[Setting], has_plain: bool) {
    println!(
        "| scene | | search | stages | depth | volumes | frame | fragments | volumes, ratio | frame, ratio | frame and search, ratio |"
    );
    println!("|---|---|---:|---:|---:|---:|---:|---:|---:|---:|---:|");
    for setting in settings {
        let view = frames.view(setting);
        let [mut plain, mut outline, mut hidden] = [Measured::default(); 3];
        let mut search = 0.0;
        let casters = casters(setting);
        let make = |bodies: &[Body]| frames.casting(bodies, setting.lights[0]).expect("a scene");
        let [mut all, mut less] = [make(&setting.bodies), make(&setting.bodies)];
        for &light in &setting.lights {
            all.set_light(light).expect("a light");
            less.set_light(light).expect("a light");
            let begin = Instant::now();
            let found = find(light, &casters, HiddenOptions::default());
            search += begin.elapsed().as_secs_f64() * 1e3;
            less.set_hidden(Some(&found)).expect("casters");
            let [of_all, of_less] = frames.measure(&view, [&mut all, &mut less]).expect("frames");
            outline.add(&of_all);
            hidden.add(&of_less);
            if has_plain {
                let mut each = make(&[loose(&casting(setting, light))]);
                each.set_light(light).expect("a light");
                let [of_each] = frames.measure(&view, [&mut each]).expect("frames");
                plain.add(&of_each);
            }
        }
        let base = if has_plain { plain } else { outline };
        for (name, of, search) in
            [("each face", plain, 0.0), ("silhouettes", outline, 0.0), ("and hidden faces", hidden, search)]
        {
            if !has_plain && name == "each face" {
                continue;
            }
            let count = setting.lights.len() as f64;
            let parts = [search, of.stages, of.depth, of.stencil, of.frame()].map(|sum| format!("{:.2}", sum / count));
            let ratios = [base.stencil / of.stencil, base.frame() / of.frame(), base.frame() / (of.frame() + search)];
            let ratios = ratios.map(|ratio| format!("{ratio:.2}"));
            let fragments = of.fragments / setting.lights.len() as u64;
            println!("| {} | {name} | {} | {fragments} | {} |", setting.name, parts.join(" | "), ratios.join(" | "));
        }
    }
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
