//! `cargo bench --bench depth_maps`: volumes from depth maps. Words after `--` choose: `growth` counts their triangles
//! where the map's side is doubled; `casters` times frames against volumes of meshes and a lookup, `--json FILE` for a
//! chart by `rimline bench --depth-maps FILE`. `--rotations N` for another number than 1,000, `--quick` for few of all.

mod growth;
mod shade;
mod stage;

use std::cell::RefCell;

use glam::DVec3;
use rimline::Light;
use rimline::gpu::depth_map::DepthMapMethod;
use rimline::gpu::{ShadowFormat, ShadowPipelines};
use rimline_bench::engine::{Contender, Rounds, interleave};
use rimline_bench::record::{Meshes, Recorder as _, Until};
use rimline_bench::row::{Entry, Row};
use rimline_bench::shapes::{self, Shape};
use rimline_bench::{Error, depth_maps};

use shade::Shade;
use stage::{AUTOMATIC, Bench, CONTOURS, EYE, MAP, axes, camera, map_of, pass};

fn main() -> Result<(), Error> {
    let arguments: Vec<String> = std::env::args().collect();
    let has = |wanted: &str| arguments.iter().any(|argument| argument == wanted);
    let after = |name: &str| arguments.iter().skip_while(|argument| *argument != name).nth(1);
    let (growth, casters) = (has("growth"), has("casters"));
    let bench = Bench::new()?;
    println!("{}", bench.name);
    if growth || !casters {
        let rotations = after("--rotations").and_then(|given| given.parse().ok());
        growth::measure(&bench, rotations.unwrap_or(if has("--quick") { 20 } else { 1000 }))?;
    }
    if casters || !growth {
        let rows = measure(&bench, if has("--quick") { 3 } else { 15 })?;
        if let Some(file) = after("--json") {
            std::fs::write(file, format!("{:#}\n", depth_maps::to_json(&rows)))?;
        }
    }
    Ok(())
}

/// Texels of the map and pixels of the picture a side.
const SIDE: u32 = 1024;
/// Subdivisions n of the spheres: 8 n² faces.
const SUBDIVISIONS: [u32; 4] = [11, 35, 112, 354];
/// Ways to volumes of the map.
const WAYS: [(&str, DepthMapMethod); 3] = [
    ("of the map, every cell", DepthMapMethod::EveryCell),
    ("of the map, automatic", AUTOMATIC),
    ("of the map, contours 0.005", CONTOURS),
];

/// Frames of one caster of more and more faces: volumes of its mesh, volumes of a depth map, and a lookup in the map,
/// in turn.
fn measure(bench: &Bench, rounds: usize) -> Result<Vec<Row>, Error> {
    let (gpu, distance) = (&bench.gpu, 6.0);
    let down = DVec3::new(0.4, -1.0, 0.3).normalize();
    let light = camera(axes(down, DVec3::Z), distance, 2.0, true);
    let lamp = Light::point((-distance * down).as_vec3().to_array());
    let ahead = DVec3::new(-0.3, -0.5, -1.0).normalize();
    let eye = camera(axes(ahead, DVec3::Y), 8.0, 3.0, false);
    let ground = Shape {
        positions: shapes::cube().positions.iter().map(|[x, y, z]| [4.0 * x, 0.01 * y - 1.3, 4.0 * z]).collect(),
        faces: shapes::cube().faces,
    };
    let ground = bench.drawn(&ground)?;
    let pipelines = ShadowPipelines::new(&gpu.pipelines, &ShadowFormat::default(), rimline::Counting::Auto)?;
    let (map, target, shade) = (bench.target(SIDE, MAP), bench.target(SIDE, EYE), Shade::new(bench, SIDE));
    let group = shade.group(bench, [&target, &map], [&eye, &light]);
    let mut rows = Vec::new();
    println!(
        "\nA sphere over a ground, picture and map of {SIDE}²: milliseconds of a frame's shadows (of its stencil pass)"
    );
    for subdivisions in SUBDIVISIONS {
        let shape = shapes::sphere(subdivisions);
        let (sphere, faces) = (bench.drawn(&shape)?, shape.faces.len());
        let mut meshes = Meshes::new(Some(&pipelines), &[lamp], Some(eye));
        meshes.push_all(gpu, [shape])?;
        let meshes = RefCell::new(meshes);
        // Times of a frame's shadows, and of its stencil pass, which is drawn again.
        let of_mesh = || {
            let mut meshes = meshes.borrow_mut();
            let frame = bench.clock(|encoder| {
                meshes.encode(encoder, Until::Volumes, None)?;
                meshes.draw(&mut pass(encoder, &target.all, None, true), 0)?;
                shade.stencil(encoder, &target);
                Ok(())
            })?;
            let stencil = bench.clock(|encoder| meshes.draw(&mut pass(encoder, &target.all, None, true), 0))?;
            Ok(vec![(depth_maps::FRAME, frame), (depth_maps::STENCIL, stencil)])
        };
        let eyes_depth = || {
            let ms = bench.clock(|encoder| Bench::draw_eye(encoder, &[&sphere, &ground], &target, &eye))?;
            Ok(vec![(depth_maps::FRAME, ms)])
        };
        let lookup = || {
            let ms = bench.clock(|encoder| {
                Bench::draw_map(encoder, &sphere, &map, &light)?;
                shade.lookup(encoder, &group);
                Ok(())
            })?;
            Ok(vec![(depth_maps::FRAME, ms)])
        };
        let mut contenders: Vec<(&str, Contender<'_>)> = vec![
            ("the eye's depth, not counted below", Box::new(eyes_depth)),
            ("volumes of the mesh", Box::new(of_mesh)),
        ];
        for (name, way) in WAYS {
            let mut volumes = bench.volumes(SIDE, way)?;
            let (sphere, map, target, shade, light, eye) = (&sphere, &map, &target, &shade, &light, &eye);
            let run = move || {
                let mut drawn = None;
                let frame = bench.clock(|encoder| {
                    Bench::draw_map(encoder, sphere, map, light)?;
                    let frame = volumes.encode(encoder, &map_of(map, *light), eye)?;
                    frame.draw(&mut pass(encoder, &target.all, None, true), &bench.pipelines)?;
                    shade.stencil(encoder, target);
                    drawn = Some(frame);
                    Ok(())
                })?;
                let stencil = bench.clock(|encoder| {
                    let mut pass = pass(encoder, &target.all, None, true);
                    drawn.map_or(Ok(()), |drawn| Ok(drawn.draw(&mut pass, &bench.pipelines)?))
                })?;
                Ok(vec![(depth_maps::FRAME, frame), (depth_maps::STENCIL, stencil)])
            };
            contenders.push((name, Box::new(run)));
        }
        contenders.push(("lookup", Box::new(lookup)));
        let (names, contenders): (Vec<_>, Vec<_>) = contenders.into_iter().unzip();
        let samples = interleave(Rounds::exactly(rounds), contenders, &())?;
        let entries: Vec<Entry> =
            names.into_iter().zip(samples).map(|(name, of)| Entry::new(depth_maps::variant(name), &of)).collect();
        println!("{faces} faces");
        for entry in &entries {
            let [frame, stencil] = [depth_maps::FRAME, depth_maps::STENCIL].map(|metric| entry.median(metric));
            let stencil = stencil.map_or_else(String::new, |ms| format!(" ({ms:.1})"));
            println!("  {:<36} {:>8.1}{stencil}", entry.variant.name, frame.unwrap_or(f64::NAN));
        }
        rows.push(depth_maps::row(faces as u64, u64::from(SIDE), &bench.name, entries));
    }
    Ok(rows)
}
