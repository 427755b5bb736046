//! Frames of one caster of more and more faces: volumes of its mesh, volumes of a depth map, and a lookup in the map, in turn.

use glam::DVec3;
use rimline::gpu::{
    DepthMapVolumes, Extractor, ExtractorOptions, ShadowFormat, ShadowOptions, ShadowPipelines, ShadowVolumes,
};
use rimline::{Counting, Light};
use rimline_measure::on_gpu::text;
use rimline_measure::shapes::{self, Shape};
use serde_json::json;

use crate::shade::Shade;
use crate::stage::{Bench, EYE, MAP, axes, camera, map_of, medians, pass, way};

/// Texels of the map and pixels of the picture a side.
const SIDE: u32 = 1024;
/// Of spheres: 8 n² faces.
const SUBDIVISIONS: [u32; 4] = [11, 35, 112, 354];

/// Methods as tables and data name them; the first is counted in none of the others.
const METHODS: [&str; 6] = [
    "the eye's depth, not counted below",
    "volumes of the mesh",
    "of the map, every cell",
    "of the map, automatic",
    "of the map, contours 0.005",
    "lookup",
];

/// Writes the times to a file, too, as `rimline bench --depth-maps` takes them.
pub(crate) fn measure(bench: &Bench, rounds: usize, json: Option<&str>) -> Result<(), String> {
    println!(
        "\nA sphere over a ground, picture and map of {SIDE}²: milliseconds of a frame's shadows, medians of {rounds} rounds in turn"
    );
    println!("| faces | {} |", METHODS.join(" | "));
    println!("|---:|{}", "---:|".repeat(METHODS.len()));
    let mut rows = Vec::new();
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
        let of_map = |volumes: &mut DepthMapVolumes| {
            bench.clock(|encoder| {
                Bench::draw_map(encoder, &sphere, &map, &light)?;
                let frame = volumes.encode(encoder, &map_of(&map, light), &eye, None).map_err(text)?;
                frame.draw(&mut pass(encoder, &target.all, None, true), &bench.pipelines).map_err(text)?;
                shade.stencil(encoder, &target);
                Ok(())
            })
        };
        let mut times = Vec::new();
        // One more, in which shaders are compiled.
        for round in 0..=rounds {
            let depth = bench.clock(|encoder| Bench::draw_eye(encoder, &[&sphere, &ground], &target, &eye))?;
            let of_mesh = bench.clock(|encoder| {
                let found = extractor.encode(encoder, sphere.positions(), &[lamp], None).map_err(text)?;
                let frame = volumes.encode(encoder, &found, &eye, None).map_err(text)?;
                frame.draw(&mut pass(encoder, &target.all, None, true), &pipelines, 0).map_err(text)?;
                shade.stencil(encoder, &target);
                Ok(())
            })?;
            let of_maps = of_maps.iter_mut().map(of_map).collect::<Result<Vec<_>, _>>()?;
            let &[every, automatic, contours] = &of_maps[..] else { return Err("a way is missing".to_owned()) };
            let lookup = bench.clock(|encoder| {
                Bench::draw_map(encoder, &sphere, &map, &light)?;
                shade.lookup(encoder, &group);
                Ok(())
            })?;
            times.extend((round > 0).then_some([depth, of_mesh, every, automatic, contours, lookup]));
        }
        let cells = medians(&times).map(|time| format!("{time:.1}"));
        println!("| {} | {} |", sphere.mesh.face_count(), cells.join(" | "));
        let of_rounds = |method: usize| times.iter().map(|round| round[method]).collect::<Vec<_>>();
        let methods = METHODS.iter().enumerate();
        let methods = methods.map(|(at, name)| json!({ "name": name, "ms_of_rounds": of_rounds(at) }));
        rows.push(json!({ "faces": sphere.mesh.face_count(), "methods": methods.collect::<Vec<_>>() }));
    }
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
