//! Draws a glTF file, or a torus, and says how long it took: `draw FILE.glb|torus:FACES [out=FILE.svg]
//! [AZIMUTH,ELEVATION] [persp] [thrice] [meet] [hidden] [threads=N]`.

use std::borrow::Cow;
use std::error::Error;
use std::fmt::Write as _;
use std::ops::ControlFlow;
use std::time::Instant;

use rimline::cpu::Threads;
use rimline::mesh::Weld;
use rimline::{Mesh, gltf::Asset, gltf::LoadOptions};
use rimline_lines::{Classes, Drawing, LineClass, LineOptions, Object, View, draw, objects_of_model};

fn main() -> Result<(), Box<dyn Error>> {
    let arguments: Vec<String> = std::env::args().skip(1).collect();
    let is_given = |word: &str| arguments.iter().any(|argument| argument == word);
    let model = arguments.first().ok_or("give a file, or torus:FACES")?;
    let begin = Instant::now();
    let objects = if let Some(faces) = model.strip_prefix("torus:") {
        vec![torus(faces.parse()?)?]
    } else {
        let asset = Asset::open(model, LoadOptions::default())?;
        objects_of_model(asset.model(), &asset.pose([], 0.0)?, Threads::all())?
    };
    let loaded = begin.elapsed();
    let angles = arguments.iter().find_map(|argument| argument.split_once(','));
    let [azimuth, elevation] = match angles {
        Some((azimuth, elevation)) => [azimuth.parse::<f64>()?, elevation.parse()?],
        None => [30.0, 25.0],
    };
    let view = view(&objects, azimuth.to_radians(), elevation.to_radians(), is_given("persp"))?;
    let threads = arguments.iter().find_map(|argument| argument.strip_prefix("threads="));
    let threads = threads.map(str::parse).transpose()?.map_or(Threads::all(), Threads::new);
    let classes = if is_given("meet") { Classes::ALL } else { Classes::ALL.without(LineClass::Intersection) };
    let options = LineOptions { threads, classes, ..LineOptions::default() };
    let mut drawing = Drawing::default();
    for _ in 0..if is_given("thrice") { 3 } else { 1 } {
        let begin = Instant::now();
        drawing = draw(&objects, &view, &options, |_, _| ControlFlow::Continue(()))?;
        println!("drawn in {:.4} s", begin.elapsed().as_secs_f64());
    }
    let faces: usize = objects.iter().map(|object| object.mesh.face_count()).sum();
    let visible = drawing.spans.iter().filter(|span| span.faces_in_front == 0).count();
    println!(
        "{faces} faces loaded in {:.4} s; {} spans, {visible} visible, {} chains; left out {:?}",
        loaded.as_secs_f64(),
        drawing.spans.len(),
        drawing.chains.len(),
        drawing.left_out
    );
    if let Some(out) = arguments.iter().find_map(|argument| argument.strip_prefix("out=")) {
        std::fs::write(out, svg(&drawing, is_given("hidden")))?;
    }
    Ok(())
}

/// A view of all objects from a direction; their up is y.
fn view(objects: &[Object<'_>], azimuth: f64, elevation: f64, is_perspective: bool) -> Result<View, Box<dyn Error>> {
    let towards = [elevation.cos() * azimuth.sin(), elevation.sin(), elevation.cos() * azimuth.cos()].map(|c| c as f32);
    let up = if towards[1].abs() > 0.99 { [0.0, 0.0, -1.0] } else { [0.0, 1.0, 0.0] };
    if !is_perspective {
        return Ok(View::orthographic(towards, up)?);
    }
    let points = || objects.iter().flat_map(|object| object.positions.iter());
    let low = points().fold([f32::INFINITY; 3], |low, p| [0, 1, 2].map(|axis| low[axis].min(p[axis])));
    let high = points().fold([f32::NEG_INFINITY; 3], |high, p| [0, 1, 2].map(|axis| high[axis].max(p[axis])));
    let size = (0..3).map(|axis| (high[axis] - low[axis]).powi(2)).sum::<f32>().sqrt();
    let middle = [0, 1, 2].map(|axis| 0.5 * (low[axis] + high[axis]));
    Ok(View::perspective([0, 1, 2].map(|axis| middle[axis] + 1.5 * size * towards[axis]), middle, up)?)
}

/// A torus of about so many triangles.
fn torus(faces: usize) -> Result<Object<'static>, Box<dyn Error>> {
    let segments = ((faces as f64 / 4.0).sqrt()).round().max(3.0) as u32;
    let rings = 2 * segments;
    let angle = |at: u32, of: u32| f64::from(at) / f64::from(of) * std::f64::consts::TAU;
    let mut positions = Vec::new();
    for (u, v) in (0..rings).flat_map(|ring| (0..segments).map(move |segment| (ring, segment))) {
        let (u, v) = (angle(u, rings), angle(v, segments));
        let radius = 1.0 + 0.4 * v.cos();
        positions.push([radius * u.cos(), 0.4 * v.sin(), radius * u.sin()].map(|c| c as f32));
    }
    let mut faces = Vec::new();
    for (ring, v) in (0..rings).flat_map(|ring| (0..segments).map(move |segment| (ring, segment))) {
        let (here, there, w) = (ring * segments, (ring + 1) % rings * segments, (v + 1) % segments);
        faces.extend([[here + v, here + w, there + w], [here + v, there + w, there + v]]);
    }
    let mesh = Mesh::new(&positions, &faces, Weld::Position)?;
    Ok(Object { name: "torus".into(), mesh: Cow::Owned(mesh), positions: Cow::Owned(positions), marked: Vec::new() })
}

/// 1000 units wide, with one path a chain.
fn svg(drawing: &Drawing, is_hidden_drawn: bool) -> String {
    let Some(bounds) = drawing.bounds(if is_hidden_drawn { u32::MAX } else { 0 }) else { return String::new() };
    let size = [0, 1].map(|axis| bounds.high[axis] - bounds.low[axis]);
    let scale = 1000.0 / size[0].max(size[1]);
    let (width, height) = (size[0] * scale + 40.0, size[1] * scale + 40.0);
    let mut text = format!(
        "<svg xmlns=\"http://www.w3.org/2000/svg\" width=\"{width:.0}\" height=\"{height:.0}\" fill=\"none\" \
         stroke=\"black\" stroke-linecap=\"round\" stroke-linejoin=\"round\">\n<rect width=\"100%\" height=\"100%\" fill=\"white\"/>\n"
    );
    for chain in drawing.chains.iter().filter(|chain| is_hidden_drawn || !chain.is_hidden).rev() {
        let points = drawing.page_points(chain);
        let mut path = String::new();
        for (at, [x, y]) in points.iter().enumerate() {
            let (x, y) = ((x - bounds.low[0]) * scale + 20.0, (bounds.high[1] - y) * scale + 20.0);
            let _ = write!(path, "{}{x:.2},{y:.2}", if at == 0 { "M" } else { " " });
        }
        let close = if chain.is_closed { "Z" } else { "" };
        let width = if chain.class.name() == "silhouette" { 2.0 } else { 1.0 };
        let style = if chain.is_hidden { " stroke-dasharray=\"3 3\" stroke=\"gray\"" } else { "" };
        let _ = writeln!(
            text,
            "<path class=\"{}\" stroke-width=\"{width}\"{style} d=\"{path}{close}\"/>",
            chain.class.name()
        );
    }
    text + "</svg>\n"
}
