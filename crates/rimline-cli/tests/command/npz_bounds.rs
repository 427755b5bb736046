//! Archives that take much, positions that are not finite, and displacements that would end the process.

use std::ffi::OsString;

use super::archive::{Entry, array, write_zip};
use super::run::{folder, is_empty, rimline, write_file};
use super::{Outcome, Test, ensure};

pub(crate) const TESTS: &[Test] = &[
    ("npz_bounds::what_takes_more_than_the_limit_is_refused", limits),
    ("npz_bounds::entries_longer_than_their_shape_are_refused", longer),
    ("npz_bounds::a_shape_of_many_numbers_makes_a_short_message", many_numbers),
    ("npz_bounds::non_finite_positions_are_taken_alike", non_finite),
    ("npz_bounds::a_displacement_that_nests_deep_is_refused", deep),
];

fn floats(name: &str, columns: usize, values: &[f32]) -> Entry {
    let data: Vec<u8> = values.iter().flat_map(|c| c.to_le_bytes()).collect();
    array(name, "<f4", "False", &format!("({}, {columns})", values.len() / columns), &data)
}

const TETRAHEDRON: [f32; 12] = [0.0, 0.0, 0.0, 1.0, 0.0, 0.0, 0.0, 1.0, 0.0, 0.0, 0.0, 1.0];

fn tetrahedron(positions: &[f32; 12]) -> Vec<u8> {
    let faces = array("faces", "|u1", "False", "(4, 3)", &[0, 2, 1, 0, 1, 3, 1, 2, 3, 2, 0, 3]);
    write_zip(&[floats("positions", 3, positions), faces])
}

/// 100,000 vertices count 5.2 MB, and as many points 1.6 MB.
fn limits() -> Outcome {
    let folder = folder();
    let file = |name: &str| folder.path().join(name).into_os_string();
    let positions = floats("positions", 3, &vec![0.5; 300_000]);
    let faces = array("faces", "|u1", "False", "(1, 3)", &[0, 1, 2]);
    let packed = Entry { method: 8, ..positions.clone() };
    let write = |name: &str, bytes: Vec<u8>| write_file(file(name), bytes);
    write("large.npz", write_zip(&[positions, faces.clone()]))?;
    write("packed.npz", write_zip(&[packed, faces]))?;
    write("small.npz", tetrahedron(&TETRAHEDRON))?;
    write("points.npz", write_zip(&[floats("points", 3, &vec![0.5; 300_000])]))?;
    let out = file("out.npz");
    let words = |line: &str| line.split(' ').map(OsString::from).collect::<Vec<_>>();
    for model in ["large.npz", "packed.npz"] {
        for line in ["info", "extract --device cpu --light dir:0,0,1 --out"] {
            let arguments = |limit: &str| {
                let mut arguments = words(line);
                arguments.extend((line != "info").then(|| out.clone()));
                arguments.extend([file(model), "--memory-limit".into(), limit.into()]);
                arguments
            };
            rimline(arguments("4MiB")).expect(1, &[model, "`positions`", "100000 rows", "--memory-limit"])?;
            ensure!(!std::path::Path::new(&out).exists(), "a result was begun");
            rimline(arguments("8MiB")).expect(0, &[])?;
            let _ = std::fs::remove_file(&out);
        }
    }
    let query = |limit: &str| {
        let mut arguments = words("query --device cpu --light dir:0,0,1 --light dir:0,1,1 --memory-limit");
        arguments.extend([limit.into(), file("small.npz"), "--points".into(), file("points.npz")]);
        rimline(arguments.into_iter().chain(["--out".into(), out.clone()]))
    };
    query("1MiB").expect(1, &["points.npz", "`points`", "100000 rows"])?;
    query("2MiB").expect(0, &[])
}

/// The directory says 36 bytes of faces; the packed data has more.
fn longer() -> Outcome {
    let folder = folder();
    let model = folder.path().join("model.npz");
    let faces = array("faces", "|u1", "False", "(1, 3)", &[0, 1, 2]);
    let mut long = faces.clone();
    long.bytes.extend([0; 1000]);
    let zip = write_zip(&[floats("positions", 3, &TETRAHEDRON), Entry { method: 8, ..long.clone() }]);
    // The true length stands in the entry's own header and in the directory.
    let (truth, claim) = ((long.bytes.len() as u32).to_le_bytes(), (faces.bytes.len() as u32).to_le_bytes());
    let mut forged = zip.clone();
    let places: Vec<_> = (0..zip.len() - 4).filter(|&at| zip[at..at + 4] == truth).collect();
    ensure!(places.len() == 2, "the length stands at {places:?}");
    for at in places {
        forged[at..at + 4].copy_from_slice(&claim);
    }
    write_file(&model, forged)?;
    let run = rimline([OsString::from("info"), model.clone().into()]);
    run.expect(1, &["`faces`"])?;
    std::fs::remove_file(&model).map_err(|error| error.to_string())?;
    is_empty(folder.path())
}

fn non_finite() -> Outcome {
    for (value, count) in
        [(f32::NAN, "1 vertex is infinite or NaN; its faces"), (f32::INFINITY, "1 vertex is"), (1.0, "")]
    {
        let folder = folder();
        let file = |name: &str| folder.path().join(name).into_os_string();
        let mut positions = TETRAHEDRON;
        positions[11] = value;
        write_file(file("model.npz"), tetrahedron(&positions))?;
        let points = write_zip(&[floats("points", 3, &[0.1, 0.1, 0.1, 9.0, 9.0, 9.0])]);
        write_file(file("points.npz"), points)?;
        let lines = [
            "info model.npz",
            "info --json model.npz",
            "extract model.npz --device cpu --light dir:0,0,1 --out out.npz",
            "query model.npz --device cpu --points points.npz --light dir:0,0,1 --out depths.npz",
            "draw model.npz --size 32x32 --out drawn.png",
            "shadow model.npz --size 32x32 --light dir:0,0,1 --out shadow.png",
        ];
        // Pictures are asked for once with such a vertex and once without.
        for line in &lines[..if value.is_infinite() { 4 } else { 6 }] {
            let word = |word: &str| {
                if word.contains(".npz") || word.contains(".png") { file(word) } else { OsString::from(word) }
            };
            let run = rimline(line.split(' ').map(word));
            run.expect(0, &[count]).map_err(|error| format!("{line}: {error}"))?;
            let is_warned = run.stderr.contains("infinite or NaN");
            ensure!(is_warned != value.is_finite(), "{line} with {value}: {}", run.stderr);
        }
    }
    Ok(())
}

/// Without bounds naga overflows the stack: the process ends by a signal.
fn deep() -> Outcome {
    let folder = folder();
    let file = |name: &str| folder.path().join(name).into_os_string();
    write_file(file("model.npz"), tetrahedron(&TETRAHEDRON))?;
    let head = "fn displace(position: vec3<f32>, vertex: u32, time: f32) -> vec3<f32> {";
    for (source, part) in [
        (format!("{head} return position * (1.0{}); }}", " + time".repeat(5000)), "within each other"),
        (format!("{head} return position * (1.0{}); }}", " + time".repeat(500_000)), "bytes of source"),
        (format!("var<private> a: array<f32, 60000>; {head} return position * a[vertex]; }}"), "private variables"),
    ] {
        write_file(file("deep.wgsl"), source)?;
        let line = "extract --light dir:0,0,1 --displace".split(' ').map(OsString::from);
        let files = [file("deep.wgsl"), file("model.npz"), "--out".into(), file("out.npz")];
        rimline(line.chain(files)).expect(1, &["deep.wgsl", "line 1", part])?;
    }
    Ok(())
}

fn many_numbers() -> Outcome {
    let folder = folder();
    let file = folder.path().join("m.npz");
    let shape = format!("(4, {})", vec!["3"; 3000].join(", "));
    let faces = array("faces", "|u1", "False", &shape, &[0; 12]);
    write_file(&file, write_zip(&[floats("positions", 3, &TETRAHEDRON), faces]))?;
    let run = rimline([OsString::from("info"), file.into_os_string()]);
    run.expect(1, &["`faces`", "(4, 3, 3, 3, 3, 3, 3, 3, … 3001 numbers in all)"])?;
    ensure!(run.stderr.len() < 500, "a message of {} bytes", run.stderr.len());
    Ok(())
}
