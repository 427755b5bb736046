//! Charges against the limit of memory, compared with the peak of the process, as the system counts it.

use std::fmt::Write as _;
use std::path::Path;
use std::process::{Command, Stdio};

use super::archive::{array, write_zip};
use super::run::{folder, rimline};
use super::{Outcome, Test, ensure};

pub(crate) const TESTS: &[Test] = &[("memory::estimates_are_within_one_and_a_half_times", estimates)];

/// Rings of a torus, which has four triangles for each and its square.
const RINGS: u32 = 400;

/// The most bytes that a run takes, by the system; it must end well or with 1.
fn peak(arguments: &[&str]) -> Result<u64, String> {
    let mut child = Command::new(env!("CARGO_BIN_EXE_rimline"))
        .args(arguments)
        .stdout(Stdio::null())
        .stderr(Stdio::null())
        .spawn()
        .map_err(|error| error.to_string())?;
    let status = format!("/proc/{}/status", child.id());
    let mut most = 0;
    // The number never falls, and the most is long before the end.
    while child.try_wait().map_err(|error| error.to_string())?.is_none() {
        let text = std::fs::read_to_string(&status).unwrap_or_default();
        let line = text.lines().find_map(|line| line.strip_prefix("VmHWM:"));
        let kilobytes = line.and_then(|line| line.trim().strip_suffix(" kB")).and_then(|number| number.parse().ok());
        most = most.max(1024 * kilobytes.unwrap_or(0_u64));
        std::thread::sleep(std::time::Duration::from_micros(200));
    }
    Ok(most)
}

/// Positions, and the corners of quadrilaterals.
fn torus() -> (Vec<[f32; 3]>, Vec<[u32; 4]>) {
    let sides = 2 * RINGS;
    let turn = |n: u32, of: u32| std::f32::consts::TAU * n as f32 / of as f32;
    let quads = || (0..RINGS).flat_map(|ring| (0..sides).map(move |side| (ring, side)));
    let position = |(ring, side): (u32, u32)| {
        let (a, b) = (turn(ring, RINGS), turn(side, sides));
        [(3.0 + a.cos()) * b.cos(), a.sin(), (3.0 + a.cos()) * b.sin()]
    };
    let index = |ring: u32, side: u32| ring % RINGS * sides + side % sides;
    let quad = |(r, s): (u32, u32)| [index(r, s), index(r, s + 1), index(r + 1, s + 1), index(r + 1, s)];
    (quads().map(position).collect(), quads().map(quad).collect())
}

fn write_models(folder: &Path) -> Outcome {
    let (positions, quads) = torus();
    let triangles: Vec<u32> = quads.iter().flat_map(|&[a, b, c, d]| [a, b, c, a, c, d]).collect();
    let bytes = |words: &[u32]| words.iter().flat_map(|word| word.to_le_bytes()).collect::<Vec<u8>>();
    let floats: Vec<u8> = positions.iter().flatten().flat_map(|c| c.to_le_bytes()).collect();
    let array_of = |name: &str, kind: &str, shape: String, data: &[u8]| array(name, kind, "False", &shape, data);
    let at_positions = array_of("positions", "<f4", format!("({}, 3)", positions.len()), &floats);
    let faces = array_of("faces", "<u4", format!("({}, 3)", triangles.len() / 3), &bytes(&triangles));
    let (count, corners) = (quads.len(), bytes(quads.as_flattened()));
    let polygons = [
        at_positions.clone(),
        array_of("polygon_loops", "<u4", format!("({count},)"), &bytes(&vec![1; count])),
        array_of("loop_sizes", "<u4", format!("({count},)"), &bytes(&vec![4; count])),
        array_of("loop_corners", "<u4", format!("({},)", 4 * count), &corners),
    ];
    let mut lines = String::new();
    for [x, y, z] in &positions {
        let _ = writeln!(lines, "v {x} {y} {z}");
    }
    let obj = |name: &str, faces: &mut dyn Iterator<Item = &[u32]>| {
        let mut text = lines.clone();
        for face in faces {
            let corners: Vec<String> = face.iter().map(|v| (v + 1).to_string()).collect();
            let _ = writeln!(text, "f {}", corners.join(" "));
        }
        std::fs::write(folder.join(name), text)
    };
    let written = obj("triangles.obj", &mut triangles.chunks(3))
        .and_then(|()| obj("quads.obj", &mut quads.iter().map(|quad| &quad[..])))
        .and_then(|()| std::fs::write(folder.join("triangles.npz"), write_zip(&[at_positions, faces])))
        .and_then(|()| std::fs::write(folder.join("polygons.npz"), write_zip(&polygons)));
    written.map_err(|error| error.to_string())
}

fn estimates() -> Outcome {
    let folder = folder();
    write_models(folder.path())?;
    folder.write("small.npz", super::makers::tetrahedron())?;
    let out = folder.path().join("out.npz").to_string_lossy().into_owned();
    let extract = |model: &str, options: &[&str]| {
        let model = folder.path().join(model).to_string_lossy().into_owned();
        let line = ["extract", &model, "--device", "cpu", "--light", "dir:0,0,1", "--out", &out];
        line.iter().chain(options).map(|word| (*word).to_owned()).collect::<Vec<String>>()
    };
    let peak = |line: Vec<String>| peak(&line.iter().map(String::as_str).collect::<Vec<_>>());
    let base = peak(extract("small.npz", &[]))?;
    for model in ["triangles.npz", "polygons.npz", "triangles.obj", "quads.obj"] {
        let taken = peak(extract(model, &[]))?.saturating_sub(base);
        let [low, high] = [2 * taken / 3, 3 * taken / 2];
        for (limit, code) in [(low, 1), (high, 0)] {
            let run = rimline(extract(model, &["--memory-limit", &limit.to_string()]));
            run.expect(code, &[]).map_err(|error| format!("{model}: {taken} bytes taken, limit {limit}: {error}"))?;
        }
        if Path::new(model).extension().is_some_and(|ending| ending == "npz") {
            let refused = peak(extract(model, &["--memory-limit", &low.to_string()]))?.saturating_sub(base);
            ensure!(refused < taken / 10, "{model}: {refused} bytes taken before it was refused");
        }
    }
    Ok(())
}
