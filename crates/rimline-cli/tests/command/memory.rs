//! Charges against the limit of memory, compared with the peak of the process, as the system counts it.

use std::process::{Command, Stdio};

use super::archive::{array, write_zip};
use super::makers::{npz_mesh, obj, rows, tetrahedron};
use super::run::{Folder, folder};
use super::{Outcome, Test, ensure};

pub(crate) const TESTS: &[Test] = &[("memory::estimates_are_within_one_and_a_half_times", estimates)];

/// Rings of a torus, which has four triangles for each and its square.
const RINGS: u32 = 300;

/// The most bytes that a run takes, by the system; it must end well or with 1.
fn peak(folder: &Folder, line: &str) -> Result<u64, String> {
    let mut child = Command::new(env!("CARGO_BIN_EXE_rimline"))
        .args(line.replace('@', "").split(' '))
        .current_dir(folder.path())
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

/// A torus of triangles and of quadrilaterals.
fn write_models(folder: &Folder) -> Outcome {
    let sides = 2 * RINGS;
    let quads = || (0..RINGS).flat_map(|ring| (0..sides).map(move |side| (ring, side)));
    let position = |(ring, side): (u32, u32)| {
        let turn = |n: u32, of: u32| std::f64::consts::TAU * f64::from(n) / f64::from(of);
        let (a, b) = (turn(ring, RINGS), turn(side, sides));
        [(3.0 + a.cos()) * b.cos(), a.sin(), (3.0 + a.cos()) * b.sin()]
    };
    let index = |ring: u32, side: u32| ring % RINGS * sides + side % sides;
    let quad = |(r, s): (u32, u32)| [index(r, s), index(r, s + 1), index(r + 1, s + 1), index(r + 1, s)];
    let positions: Vec<[f64; 3]> = quads().map(position).collect();
    let quads: Vec<[u32; 4]> = quads().map(quad).collect();
    let triangles: Vec<[u32; 3]> = quads.iter().flat_map(|&[a, b, c, d]| [[a, b, c], [a, c, d]]).collect();
    let singles: Vec<[f32; 3]> = positions.iter().map(|p| p.map(|c| c as f32)).collect();
    let words = |name: &str, words: &[u32]| {
        let bytes: Vec<u8> = words.iter().flat_map(|word| word.to_le_bytes()).collect();
        array(name, "<u4", "False", &format!("({},)", words.len()), &bytes)
    };
    let polygons = [
        rows("positions", &singles),
        words("polygon_loops", &vec![1; quads.len()]),
        words("loop_sizes", &vec![4; quads.len()]),
        words("loop_corners", quads.as_flattened()),
    ];
    let corners = |face: &[u32]| face.iter().map(|&v| v as usize + 1).collect::<Vec<_>>();
    folder.write("triangles.npz", npz_mesh(&singles, &triangles))?;
    folder.write("polygons.npz", write_zip(&polygons))?;
    folder.write("triangles.obj", obj(positions.iter().copied(), triangles.iter().map(|face| corners(face))))?;
    folder.write("quads.obj", obj(positions.iter().copied(), quads.iter().map(|face| corners(face))))
}

fn estimates() -> Outcome {
    let folder = folder();
    write_models(&folder)?;
    folder.write("small.npz", tetrahedron())?;
    let line = |model: &str| format!("extract @{model} --device cpu --light dir:0,0,1 --out @out.npz");
    // A short run may end before its most is seen.
    let base = (0..8).try_fold(0, |most, _| peak(&folder, &line("small.npz")).map(|bytes| bytes.max(most)))?;
    for model in ["triangles.npz", "polygons.npz", "triangles.obj", "quads.obj"] {
        let taken = peak(&folder, &line(model))?.saturating_sub(base);
        let low = format!("{} --memory-limit {}", line(model), 2 * taken / 3);
        let high = format!("{} --memory-limit {}", line(model), 3 * taken / 2);
        for (line, code) in [(&low, 1), (&high, 0)] {
            let run = folder.run(line);
            run.expect(code, &[]).map_err(|error| format!("{model}: {taken} bytes taken: {error}"))?;
        }
        if model.ends_with("npz") {
            let refused = peak(&folder, &low)?.saturating_sub(base);
            ensure!(refused < taken / 10, "{model}: {refused} bytes taken before it was refused");
        }
    }
    Ok(())
}
