//! Many instances of one geometry: each throws its own shadow, also where its transform mirrors it in mid-film.

use rimline_models::maker::{Maker, U32};
use rimline_testkit::shapes::{self, Shape};
use serde_json::{Value, json};

use super::pictures::Image;
use super::run::folder;
use super::{Outcome, Test, ensure};

pub(crate) const TESTS: &[Test] =
    &[("instances::each_throws_its_own_shadow", crowd), ("instances::a_film_goes_on_where_one_is_mirrored", mirrored)];

/// A glTF with a mesh for each shape. The scale of the first node goes through `scales`, one a second, in steps.
fn gltf(shapes: &[Shape], nodes: &[Value], scales: &[[f32; 3]]) -> Vec<u8> {
    let mut maker = Maker::new();
    for shape in shapes {
        let primitive = maker.primitive(shape, U32);
        maker.mesh(&primitive);
    }
    maker.json["nodes"] = json!(nodes);
    maker.scene(&(0..nodes.len()).collect::<Vec<_>>());
    if !scales.is_empty() {
        let times: Vec<f32> = (0..scales.len()).map(|second| second as f32).collect();
        let (input, output) = (maker.floats("SCALAR", &times), maker.floats("VEC3", scales.as_flattened()));
        maker.json["animations"] = json!([{
            "samplers": [{ "input": input, "output": output, "interpolation": "STEP" }],
            "channels": [{ "sampler": 0, "target": { "node": 0, "path": "scale" } }],
        }]);
    }
    maker.gltf()
}

const COLUMNS: usize = 20;
const ROWS: usize = 15;
const SIZE: [usize; 2] = [440, 330];
/// The eye looks straight down from here, so that the picture is a map.
const HEIGHT: f64 = 120.0;
/// The field of view in degrees.
const FOV: f64 = 16.0;

fn position(instance: usize) -> [f64; 3] {
    [2.0 * (instance % COLUMNS) as f64 - 19.0, 1.0, 2.0 * (instance / COLUMNS) as f64 - 14.0]
}

/// Instances with something wrong in a mask: the ground is dark where the light along (`side`, −1, 0) lays the shadow, lit
/// beside it, and the top is lit.
fn wrong(mask: &Image, side: f64) -> Vec<usize> {
    let at = |[x, y, z]: [f64; 3]| {
        let scale = 0.5 * SIZE[1] as f64 / (0.5 * FOV.to_radians()).tan() / (HEIGHT - y);
        let pixel = |middle: usize, along: f64| (0.5 * middle as f64 + scale * along) as usize;
        mask.at(pixel(SIZE[0], x), pixel(SIZE[1], z))
    };
    let is_wrong = |instance: &usize| {
        let [x, y, z] = position(*instance);
        let [shadow, beside] = [z, z + 1.0].map(|z| at([x + side, 0.0, z]));
        (shadow, beside, at([x, y + 0.2, z])) != (0, 255, 255)
    };
    (0..COLUMNS * ROWS).filter(is_wrong).collect()
}

/// 300 cubes and spheres of a fifth of the size, every other one mirrored. The sphere has more faces than the scene's first
/// page, so casters of one file are in two groups, by turns.
fn crowd() -> Outcome {
    let folder = folder();
    let shapes = [shapes::cube(), shapes::sphere(46)];
    let nodes = || {
        (0..COLUMNS * ROWS).map(|instance| {
            let flip = if instance % 2 == 0 { 0.2 } else { -0.2 };
            let mesh = usize::from([70, 211].contains(&instance));
            json!({ "mesh": mesh, "translation": position(instance), "scale": [flip, 0.2, 0.2] })
        })
    };
    // The last of the lights is in the second batch, and shines the other way.
    let lights = "--light dir:1,1,0 ".repeat(32) + "--light dir:-1,1,0";
    let [width, height] = SIZE;
    let view = format!("--ground 0 --eye 0,{HEIGHT},0.0001 --target 0,0,0 --fov {FOV} --size {width}x{height}");
    let masks = |nodes: Vec<Value>, method: &str| {
        folder.write("crowd.gltf", gltf(&shapes, &nodes, &[]))?;
        let line = format!("shadow @crowd.gltf {view} {lights} --method {method} --mask @m --json");
        let json = folder.run(&line).json()?;
        let [first, last] = ["m.0.png", "m.32.png"].map(|name| folder.mask(name));
        Ok::<_, String>((json, [wrong(&first?, -1.0), wrong(&last?, 1.0)]))
    };
    let (json, found) = masks(nodes().collect(), "auto")?;
    ensure!(found.iter().all(Vec::is_empty), "wrong at {found:?}");
    // Casters of both groups are counted: a cube's silhouette from there is around its top and one side, and the shortest
    // way around a sphere has four edges for each of its subdivisions.
    let edges = |light: usize| json["lights"][light]["casters"][0]["silhouette_edges"].as_u64().unwrap_or(0);
    ensure!(edges(0) == edges(32) && edges(0) >= 6 * 298 + 2 * 4 * 46, "{} and {}", edges(0), edges(32));
    let casters = &json["lights"][32]["casters"][0];
    ensure!(casters["casting"] == "back-facing" && json["faces"][0] == 12 * 298 + 8 * 46 * 46 * 2, "{casters}");
    // By the other method, and the comparison can fail: one of the instances is not there, and no other is wrong.
    let all_but_one = nodes().enumerate().filter(|(instance, _)| *instance != 137).map(|(_, node)| node).collect();
    let (_, found) = masks(all_but_one, "z-fail")?;
    ensure!(found == [[137], [137]], "without 137: {found:?}");
    Ok(())
}

/// Small cubes at the corners of a box that holds all that moves, and its shadows. The ground ends where the shadows of all
/// moments end, so the box lets a film and its moments have the same ground.
fn corners() -> Shape {
    let cube = shapes::cube();
    let centres = (0..8).map(|corner| [0, 1, 2].map(|axis| if corner >> axis & 1 == 0 { -1.0 } else { 1.0 }));
    let moved = |[a, b, c]: [f32; 3]| {
        cube.positions.iter().map(move |&[x, y, z]| [9.0 * a + 0.01 * x, 2.6 + 2.5 * b + 0.01 * y, 9.0 * c + 0.01 * z])
    };
    let faces = (0..8).flat_map(|corner| cube.faces.iter().map(move |face| face.map(|v| v + 8 * corner)));
    Shape { positions: centres.flat_map(moved).collect(), faces: faces.collect() }
}

/// Each picture of the film is that of its moment by itself.
fn mirrored() -> Outcome {
    let folder = folder();
    // Off the middle, so that its mirror image is elsewhere.
    let mut shape = shapes::torus(24, 12, 1.0, 0.4);
    shape.positions.iter_mut().for_each(|position| position[0] = 0.7 * position[0] + 0.8);
    let at = |x: f64| json!({ "mesh": 0, "translation": [x, 1.0, 0.0] });
    let nodes = [at(0.0), at(4.0), json!({ "mesh": 1 })];
    let scales = [[1.0, 1.0, 1.0], [-1.0, 1.0, 1.0], [1.0, 1.0, 1.0], [1.0, 1.0, -1.0]];
    folder.write("m.gltf", gltf(&[shape, corners()], &nodes, &scales))?;
    let light = "--light dir:1,2,1 --light point:2,6,3";
    let view = "--ground 0 --eye 2,5,9 --target 2,1,0 --near 1 --size 96x72 --animation 0";
    for options in ["", "--method zp+paper", "--area disc --samples 2"] {
        let options = format!("@m.gltf {view} {light} {options}");
        folder.run(&format!("film {options} --fps 1 --frames 4 --out @film")).expect(0, &[])?;
        let bytes = |name: &str| folder.image(name).map(|image| image.bytes);
        let frames = ["film/0000.png", "film/0001.png", "film/0002.png", "film/0003.png"].map(bytes);
        ensure!(frames[0] == frames[2] && frames[0] != frames[1], "{options}: nothing moves, or not back");
        for second in [1, 3] {
            folder.run(&format!("shadow {options} --time {second} --out @p.png")).expect(0, &[])?;
            ensure!(frames[second] == bytes("p.png"), "{options}: picture {second} is not that of its moment");
        }
    }
    Ok(())
}
