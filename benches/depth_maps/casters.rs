//! Frames of one caster of more and more faces: volumes of its mesh, volumes of a depth map, and a lookup in the map, in turn.

use glam::DVec3;
use rimline::gpu::{
    DepthMapVolumes, Extractor, ExtractorOptions, ShadowFormat, ShadowOptions, ShadowPipelines, ShadowVolumes,
};
use rimline::{Counting, Light};
use rimline_testkit::on_gpu::text;
use rimline_testkit::shapes::{self, Shape};
use serde_json::{Value, json};

use crate::shade::Shade;
use crate::stage::{Bench, EYE, MAP, axes, camera, map_of, medians, pass, way};

/// Texels of the map and pixels of the picture a side.
const SIDE: u32 = 1024;
/// Subdivisions n of the spheres: 8 n² faces.
const SUBDIVISIONS: [u32; 4] = [11, 35, 112, 354];

/// Methods as tables and data name them; the first is counted in none of the others.
const METHODS: [&str; 6] =
    ["the eye's depth, not counted below", VOLUMES[0], VOLUMES[1], VOLUMES[2], VOLUMES[3], "lookup"];
/// Methods that draw volumes.
const VOLUMES: [&str; 4] =
    ["volumes of the mesh", "of the map, every cell", "of the map, automatic", "of the map, contours 0.005"];

/// Prints medians of faces in rows.
fn print(title: &str, names: &[&str], rows: &[(usize, Vec<f64>)]) {
    println!("\n{title}\n\n| faces | {} |\n|---:|{}", names.join(" | "), "---:|".repeat(names.len()));
    for (faces, medians) in rows {
        let cells: Vec<_> = medians.iter().map(|time| format!("{time:.1}")).collect();
        println!("| {faces} | {} |", cells.join(" | "));
    }
}

/// Names with the times of rounds.
fn rounds_json<const N: usize>(names: [&str; N], times: &[[f64; N]]) -> Vec<Value> {
    let of_rounds = |at: usize| times.iter().map(|round| round[at]).collect::<Vec<_>>();
    names.iter().enumerate().map(|(at, name)| json!({ "name": name, "ms_of_rounds": of_rounds(at) })).collect()
}

/// Writes the times to a file, too, as `rimline bench --depth-maps` takes them.
pub(crate) fn measure(bench: &Bench, rounds: usize, json: Option<&str>) -> Result<(), String> {
    let (mut rows, mut of_frames, mut of_passes) = (Vec::new(), Vec::new(), Vec::new());
    let down = DVec3::new(0.4, -1.0, 0.3).normalize();
    let (distance, radius) = (6.0, 2.0);
    let light = camera(axes(down, DVec3::Z), distance, radius, true);
    let lamp = Light::point((-distance * down).as_vec3().to_array());
    let ahead = DVec3::new(-0.3, -0.5, -1.0).normalize();
    let eye = camera(axes(ahead, DVec3::Y), 8.0, 3.0, false);
    let ground = Shape {
        positions: shapes::cube().positions.iter().map(|[x, y, z]| [4.0 * x, 0.01 * y - 1.3, 4.0 * z]).collect(),
        faces: shapes::cube().faces,
    };
    let ground = bench.drawn(&ground)?;
    let pipelines =
        ShadowPipelines::new(&bench.gpu.pipelines, &ShadowFormat::default(), Counting::Auto).map_err(text)?;
    let (map, target, shade) = (bench.target(SIDE, MAP), bench.target(SIDE, EYE), Shade::new(bench, SIDE));
    let group = shade.group(bench, [&target, &map], [&eye, &light]);
    let mut of_maps = Vec::new();
    for name in ["every cell", "automatic", "contours 0.005"] {
        of_maps.push(bench.volumes(SIDE, way(name)?)?);
    }
    for subdivisions in SUBDIVISIONS {
        let sphere = bench.drawn(&shapes::sphere(subdivisions))?;
        let options = ExtractorOptions { max_lights: 1, ..Default::default() };
        let mut extractor = Extractor::new(&bench.gpu.pipelines, &sphere.mesh, options).map_err(text)?;
        let mut volumes = ShadowVolumes::new(&pipelines, &extractor, ShadowOptions::default()).map_err(text)?;
        // Times of a frame's shadows, and of its stencil pass, which is drawn again.
        let of_map = |volumes: &mut DepthMapVolumes| {
            let mut drawn = None;
            let frame = bench.clock(|encoder| {
                Bench::draw_map(encoder, &sphere, &map, &light)?;
                let frame = volumes.encode(encoder, &map_of(&map, light), &eye, None).map_err(text)?;
                frame.draw(&mut pass(encoder, &target.all, None, true), &bench.pipelines).map_err(text)?;
                shade.stencil(encoder, &target);
                drawn = Some(frame);
                Ok(())
            })?;
            let drawn = drawn.ok_or("no frame")?;
            let stencil = bench.clock(|encoder| {
                drawn.draw(&mut pass(encoder, &target.all, None, true), &bench.pipelines).map_err(text)
            })?;
            Ok::<_, String>([frame, stencil])
        };
        let (mut frames, mut passes) = (Vec::new(), Vec::new());
        // One more, in which shaders are compiled.
        for round in 0..=rounds {
            let depth = bench.clock(|encoder| Bench::draw_eye(encoder, &[&sphere, &ground], &target, &eye))?;
            let mut drawn = None;
            let of_mesh = bench.clock(|encoder| {
                let found = extractor.encode(encoder, sphere.positions(), &[lamp], None).map_err(text)?;
                let frame = volumes.encode(encoder, &found, &eye, None).map_err(text)?;
                frame.draw(&mut pass(encoder, &target.all, None, true), &pipelines, 0).map_err(text)?;
                shade.stencil(encoder, &target);
                drawn = Some(frame);
                Ok(())
            })?;
            let drawn = drawn.ok_or("no frame")?;
            let mesh_pass = bench.clock(|encoder| {
                drawn.draw(&mut pass(encoder, &target.all, None, true), &pipelines, 0).map_err(text)
            })?;
            let of_maps = of_maps.iter_mut().map(of_map).collect::<Result<Vec<_>, _>>()?;
            let &[every, automatic, contours] = &of_maps[..] else { return Err("a way is missing".to_owned()) };
            let lookup = bench.clock(|encoder| {
                Bench::draw_map(encoder, &sphere, &map, &light)?;
                shade.lookup(encoder, &group);
                Ok(())
            })?;
            if round > 0 {
                frames.push([depth, of_mesh, every[0], automatic[0], contours[0], lookup]);
                passes.push([mesh_pass, every[1], automatic[1], contours[1]]);
            }
        }
        let faces = sphere.mesh.face_count();
        of_frames.push((faces, medians(&frames).to_vec()));
        of_passes.push((faces, medians(&passes).to_vec()));
        rows.push(json!({
            "faces": faces,
            "methods": rounds_json(METHODS, &frames),
            "stencil_passes": rounds_json(VOLUMES, &passes),
        }));
    }
    println!("\nA sphere over a ground, picture and map of {SIDE}²: milliseconds, medians of {rounds} rounds in turn");
    print("A frame's shadows:", &METHODS, &of_frames);
    print("Its stencil pass alone:", &VOLUMES, &of_passes);
    let Some(file) = json else { return Ok(()) };
    let data = json!({
        "format": "rimline-depth-map-casters",
        "version": 1,
        "device": bench.gpu.name,
        "size": SIDE,
        "rows": rows,
    });
    std::fs::write(file, format!("{data:#}\n")).map_err(|error| format!("{file}: {error}"))
}
