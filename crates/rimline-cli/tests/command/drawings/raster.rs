//! Drawings in SVG, rendered by resvg, against faces traced at each pixel: no visible line where the faces show nothing, and none
//! missing.

use std::borrow::Cow;
use std::path::Path;

use libtest_mimic::Trial;
use resvg::{tiny_skia, usvg};
use rimline::Mesh;
use rimline::cpu::Threads;
use rimline::gltf::{Asset, LoadOptions};
use rimline::mesh::Weld;
use rimline_lines::{Object, objects_of_model};
use rimline_models::figure::{Figure, glb};
use rimline_testkit::harness::on_files;
use rimline_testkit::{assets, shapes};

use super::super::makers::{npz_mesh, obj};
use super::super::run::{Folder, folder};
use super::super::{Outcome, Test, ensure};
use super::scene::{Between, Eye, Scene};

pub(crate) const TESTS: &[Test] = &[
    ("drawings::pictures_of_shapes_show_their_lines", shapes_show_lines),
    ("drawings::pictures_of_polygons_show_their_lines", polygons_show_lines),
    ("drawings::pictures_of_the_figure_show_its_lines", walker_shows_lines),
];

/// Real files: a scan, many parts, skins, seams of skin data, parts that coincide, parts that pass through each other.
const DRAWN: [&str; 6] = [
    "FlightHelmet.glb",
    "CesiumMan_8influences_morph.glb",
    "CesiumMilkTruck_quantized.glb",
    "Fox.glb",
    "Knight.glb",
    "RobotExpressive.glb",
];

pub(crate) fn trials() -> Vec<Trial> {
    on_files("drawings_show_lines::", assets(), &DRAWN, |file| {
        let folder = folder();
        check(&folder, &file.to_string_lossy(), &of_gltf(file)?, "--view 35,20").map(drop)
    })
}

const SIDE_MM: usize = 110;
/// Two pixels and one, also where lines are so near to each other that they have thinner pens by default.
const PENS: &str = "[silhouette]\nwidth = 0.5\n[boundary]\nwidth = 0.5\n[non-manifold]\nwidth = 0.35\n[crease]\nwidth = 0.25\n\
                    [intersection]\nwidth = 0.25";
const PIXELS_PER_MM: usize = 4;
const SIDE: usize = SIDE_MM * PIXELS_PER_MM;

/// How dark each pixel is, 0 to 1.
fn render(svg: &str) -> Result<Vec<f32>, String> {
    let tree = usvg::Tree::from_str(svg, &usvg::Options::default()).map_err(|error| error.to_string())?;
    let mut pixels = tiny_skia::Pixmap::new(SIDE as u32, SIDE as u32).ok_or("no picture")?;
    pixels.fill(tiny_skia::Color::WHITE);
    let scale = SIDE as f32 / tree.size().width();
    resvg::render(&tree, tiny_skia::Transform::from_scale(scale, scale), &mut pixels.as_mut());
    Ok(pixels.pixels().iter().map(|pixel| 1.0 - f32::from(pixel.red()) / 255.0).collect())
}

/// Pixels of lines that the faces do not show, and points where they show a line and there is none.
#[derive(Debug)]
struct Found {
    ink: usize,
    stray: Vec<[usize; 2]>,
    lines: usize,
    missing: Vec<[f64; 2]>,
}

/// The pixels whose middles are not farther than this from a point.
fn near([x, y]: [f64; 2], reach: f64) -> impl Iterator<Item = [usize; 2]> {
    let range = move |at: f64| {
        let low = (at - reach).ceil().max(0.0) as usize;
        low..((at + reach).floor() + 1.0).clamp(0.0, SIDE as f64) as usize
    };
    range(y).flat_map(move |row| range(x).map(move |column| [column, row]))
}

fn compare(scene: &Scene, ink: &[f32]) -> Found {
    let is_ink = |[column, row]: [usize; 2], least: f32| ink[row * SIDE + column] >= least;
    let changes = scene.look([0.5; 2], 1.0, SIDE).changes();
    let mut is_near_change = vec![false; SIDE * SIDE];
    let (mut lines, mut missing) = (0, Vec::new());
    for (at, between) in changes {
        let at = at.map(|c| c - 0.5);
        near(at, 2.0).for_each(|[column, row]| is_near_change[row * SIDE + column] = true);
        if between == Between::Line {
            lines += 1;
            if !near(at, 1.5).any(|pixel| is_ink(pixel, 0.3)) {
                missing.push(at);
            }
        }
    }
    let pixels = (0..SIDE).flat_map(|row| (0..SIDE).map(move |column| [column, row]));
    let pixels: Vec<_> = pixels.filter(|&pixel| is_ink(pixel, 0.5)).collect();
    // A line between the middles of pixels needs a closer look.
    let is_stray = |&[column, row]: &[usize; 2]| {
        !is_near_change[row * SIDE + column] && {
            let low = [column, row].map(|at| at as f64 + 0.5 - 2.0);
            scene.look(low, 1.0 / 64.0, 256).changes().is_empty()
        }
    };
    let stray = pixels.iter().copied().filter(is_stray).collect();
    Found { ink: pixels.len(), stray, lines, missing }
}

/// Draws a model and compares; returns the drawing and the scene.
fn check(folder: &Folder, model: &str, objects: &[Object<'_>], view: &str) -> Result<(String, Scene), String> {
    folder.write("pens.toml", PENS)?;
    for ending in ["svg", "json"] {
        let pens = if ending == "svg" { "--style @pens.toml" } else { "" };
        let line = format!("lines {model} --page {SIDE_MM}x{SIDE_MM} {view} {pens} --out @drawing.{ending}");
        folder.run(&line).expect(0, &[])?;
    }
    let read = |name: &str| String::from_utf8(folder.read(name)?).map_err(|error| error.to_string());
    let (svg, json) = (read("drawing.svg")?, read("drawing.json")?);
    let json = serde_json::from_str(&json).map_err(|error| error.to_string())?;
    let scene = Scene::new(objects, &Eye::of(&json, PIXELS_PER_MM as f64)?);
    let found = compare(&scene, &render(&svg)?);
    let [stray, missing] = [found.stray.len(), found.missing.len()];
    println!("{model} {view}: {} of ink, {stray} stray; {} with a line, {missing} without", found.ink, found.lines);
    ensure!(found.ink > 300 && found.lines > 300, "{model} {view}: little to compare: {found:?}");
    ensure!(stray == 0 && missing == 0, "{model} {view}: {:?} stray, {:?} missing", found.stray, found.missing);
    Ok((svg, scene))
}

/// A line taken away and one that nothing shows are noticed.
fn control(svg: &str, scene: &Scene) -> Outcome {
    let paths = svg.split(" d=\"").skip(1).filter_map(|after| after.split('"').next());
    let lines = paths.flat_map(|path| path.split('M').skip(1));
    let longest = lines.max_by_key(|line| line.len()).ok_or("no line")?;
    let found = compare(scene, &render(&svg.replacen(longest, "0 0", 1))?);
    ensure!(found.missing.len() > 10 && found.stray.is_empty(), "a missing line passes: {found:?}");
    let (look, ink) = (scene.look([0.5; 2], 1.0, SIDE), render(svg)?);
    let is_free = |&[column, row]: &[usize; 2]| {
        let middle = [column as f64 + 4.0, row as f64];
        look.has_face(column, row) && near(middle, 8.0).all(|[column, row]| ink[row * SIDE + column] == 0.0)
    };
    let mut free = (0..SIDE).flat_map(|row| (0..SIDE - 8).map(move |column| [column, row])).filter(is_free);
    let [x, y] = free.next().ok_or("no room for a line")?.map(|at| (at as f64 + 0.5) / PIXELS_PER_MM as f64);
    let line = format!("<path d=\"M{x} {y}l1 0\" stroke=\"#000000\" stroke-width=\"0.25\"/></svg>");
    let found = compare(scene, &render(&svg.replace("</svg>", &line))?);
    ensure!(found.stray.len() > 1 && found.missing.is_empty(), "a stray line passes: {found:?}");
    Ok(())
}

/// Writes triangles as a file, and takes them as an object.
fn written(folder: &Folder, name: &str, positions: &[[f32; 3]], faces: &[[u32; 3]]) -> Result<Object<'static>, String> {
    folder.write(name, npz_mesh(positions, faces))?;
    object(positions.to_vec(), faces)
}

fn object(positions: Vec<[f32; 3]>, faces: &[[u32; 3]]) -> Result<Object<'static>, String> {
    let mesh = Mesh::new(&positions, faces, Weld::Keep).map_err(|error| error.to_string())?;
    Ok(Object { name: String::new(), mesh: Cow::Owned(mesh), positions: positions.into(), marked: Vec::new() })
}

fn of_gltf(file: &Path) -> Result<Vec<Object<'static>>, String> {
    let text = |error: &dyn std::fmt::Display| format!("{}: {error}", file.display());
    // The command's default. Else a pose rounds vertices with different skin data to different positions, and their seam opens.
    let asset = Asset::open(file, LoadOptions::from(Weld::Position)).map_err(|error| text(&error))?;
    let pose = asset.pose([], 0.0).map_err(|error| text(&error))?;
    objects_of_model(asset.model(), &pose, Threads::all()).map_err(|error| text(&error))
}

/// Views along and aside the axes, and with perspective.
const VIEWS: [&str; 3] = ["--view 30,25", "--view iso", "--eye 3,2.1,4 --target 0,0,0"];

fn shapes_show_lines() -> Outcome {
    let folder = folder();
    let torus = shapes::torus(96, 48, 1.0, 0.4);
    let turn = |&[x, y, z]: &[f32; 3]| [x + 0.5, z, y];
    let turned: Vec<_> = torus.positions.iter().map(turn).collect();
    let cube = shapes::cube();
    let slanted_cube = |by: [[f32; 3]; 3]| {
        let transform = |p: &[f32; 3]| by.map(|row| row[0] * p[0] + row[1] * p[1] + row[2] * p[2]);
        cube.positions.iter().map(transform).collect::<Vec<_>>()
    };
    let slanted = slanted_cube([[0.56, -0.42, 0.0], [0.42, 0.56, 0.21], [0.0, 0.0, 0.7]]);
    let column = slanted_cube([[0.3, 0.0, 0.0], [0.0, 1.5, 0.0], [0.0, 0.0, 0.3]]);
    let models = [
        vec![written(&folder, "torus.npz", &torus.positions, &torus.faces)?],
        vec![
            written(&folder, "ring.npz", &torus.positions, &torus.faces)?,
            written(&folder, "turned.npz", &turned, &torus.faces)?,
        ],
        vec![
            written(&folder, "slanted.npz", &slanted, &cube.faces)?,
            written(&folder, "column.npz", &column, &cube.faces)?,
        ],
    ];
    let names = ["@torus.npz", "@ring.npz @turned.npz", "@slanted.npz @column.npz"];
    for (model, (objects, names)) in models.iter().zip(names).enumerate() {
        for (number, view) in VIEWS.iter().enumerate() {
            let (svg, scene) = check(&folder, names, objects, view)?;
            // Each model and each view once.
            if number == model {
                control(&svg, &scene)?;
            }
        }
    }
    Ok(())
}

/// A house with an inner corner, its walls, floors and roofs polygons.
fn polygons_show_lines() -> Outcome {
    let plan = [[-1.0, -1.0], [1.0, -1.0], [1.0, 0.2], [0.1, 0.2], [0.1, 1.0], [-1.0, 1.0]];
    let (mut vertices, mut polygons, mut triangles) = (Vec::new(), Vec::new(), Vec::new());
    for height in [-0.6, 0.5] {
        vertices.extend(plan.map(|[x, z]| [x, height, z]));
    }
    let walls = (0..6).map(|at| [at, at + 6, (at + 1) % 6 + 6, (at + 1) % 6]);
    polygons.extend(walls.map(Vec::from));
    polygons.extend([(0..6).collect(), (6..12).rev().collect::<Vec<usize>>()]);
    for &[a, b, c, d] in polygons.iter().filter_map(|wall| wall.first_chunk::<4>()).take(6) {
        triangles.extend([[a, b, c], [a, c, d]]);
    }
    // Triangles of the plan around its inner corner.
    for first in [0, 6] {
        let fan = [[3, 4, 5], [3, 5, 0], [3, 0, 1], [3, 1, 2]];
        triangles.extend(fan.map(
            |[a, b, c]: [usize; 3]| {
                if first == 0 { [a, b, c].map(|v| v + first) } else { [a, c, b].map(|v| v + first) }
            },
        ));
    }
    let folder = folder();
    folder.write(
        "house.obj",
        obj(vertices.iter().copied(), polygons.iter().map(|one| one.iter().map(|v| v + 1).collect())),
    )?;
    let positions = vertices.iter().map(|p| p.map(|c: f64| c as f32)).collect();
    let faces: Vec<_> = triangles.iter().map(|face| face.map(|vertex| vertex as u32)).collect();
    let house = [object(positions, &faces)?];
    VIEWS.iter().try_for_each(|view| check(&folder, "@house.obj --polygons", &house, view).map(drop))
}

fn walker_shows_lines() -> Outcome {
    let folder = folder();
    folder.write("figure.glb", glb::encode(&Figure::new()))?;
    let objects = of_gltf(&folder.path().join("figure.glb"))?;
    let (svg, scene) = check(&folder, "@figure.glb", &objects, "--view 30,10")?;
    control(&svg, &scene)?;
    check(&folder, "@figure.glb", &objects, "--eye 2,3,-2.5 --target 0,0,0").map(drop)
}
