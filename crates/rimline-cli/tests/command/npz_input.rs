//! Archives that other programs might write, good and bad.

use super::archive::{Entry, array, compare, write_zip};
use super::run::{Run, folder, is_empty, rimline, write_file};
use super::{Outcome, Test, ensure};

pub(crate) const TESTS: &[Test] = &[
    ("npz_input::every_layout_reads_alike", layouts),
    ("npz_input::bad_archives_are_refused", bad_archives),
    ("npz_input::mutated_archives_never_panic", mutated),
];

const POSITIONS: [[f32; 3]; 4] = [[0.0, 0.0, 0.0], [1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0]];
const FACES: [[u8; 3]; 4] = [[0, 2, 1], [0, 1, 3], [1, 2, 3], [2, 0, 3]];

fn positions() -> Entry {
    let data: Vec<u8> = POSITIONS.iter().flatten().flat_map(|c| c.to_le_bytes()).collect();
    array("positions", "<f4", "False", "(4, 3)", &data)
}

fn faces() -> Entry {
    array("faces", "|u1", "False", "(4, 3)", FACES.as_flattened())
}

/// A tetrahedron at the origin, as an archive.
pub(crate) fn tetrahedron() -> Vec<u8> {
    write_zip(&[positions(), faces()])
}

/// Extracts from these bytes on the CPU; the result's bytes, too.
pub(crate) fn extract(archive: &[u8]) -> Result<(Run, Vec<u8>), String> {
    let folder = folder();
    let (model, out) = (folder.path().join("model.npz"), folder.path().join("out.npz"));
    write_file(&model, archive)?;
    let arguments = ["extract", "--device", "cpu", "--light", "point:2,3,4", "--light", "dir:-1,-2e-1,.5"];
    let run = rimline(arguments.map(Into::into).into_iter().chain([
        model.clone().into_os_string(),
        "--out".into(),
        out.clone().into_os_string(),
    ]));
    let result = std::fs::read(&out).unwrap_or_default();
    std::fs::remove_file(&model).map_err(|error| error.to_string())?;
    if run.code != 0 {
        is_empty(folder.path())?;
    }
    Ok((run, result))
}

fn layouts() -> Outcome {
    let (run, expected) = extract(&tetrahedron())?;
    run.expect(0, &[])?;
    let indices = || FACES.as_flattened().iter().map(|&index| i64::from(index));
    let transposed =
        |values: &[[u8; 3]]| -> Vec<u8> { (0..3).flat_map(|c| values.iter().map(move |v| v[c])).collect() };
    let big_endian: Vec<u8> = POSITIONS.iter().flatten().flat_map(|c| c.to_be_bytes()).collect();
    let columns: Vec<u8> = (0..3).flat_map(|c| POSITIONS.iter().flat_map(move |p| p[c].to_le_bytes())).collect();
    let other_faces = [
        array("faces", "|i1", "False", "(4, 3)", FACES.as_flattened()),
        array("faces", "<u2", "False", "(4, 3)", &indices().flat_map(|i| (i as u16).to_le_bytes()).collect::<Vec<_>>()),
        array("faces", ">i2", "False", "(4, 3)", &indices().flat_map(|i| (i as i16).to_be_bytes()).collect::<Vec<_>>()),
        array("faces", "<i4", "False", "(4, 3)", &indices().flat_map(|i| (i as i32).to_le_bytes()).collect::<Vec<_>>()),
        array("faces", ">u4", "False", "(4, 3)", &indices().flat_map(|i| (i as u32).to_be_bytes()).collect::<Vec<_>>()),
        array("faces", "<i8", "False", "(4, 3)", &indices().flat_map(i64::to_le_bytes).collect::<Vec<_>>()),
        array("faces", "<u8", "False", "(4, 3)", &indices().flat_map(|i| (i as u64).to_le_bytes()).collect::<Vec<_>>()),
        array("faces", "|u1", "True", "(4, 3)", &transposed(&FACES)),
        Entry { method: 8, ..faces() },
    ];
    let other_positions = [
        array("positions", ">f4", "False", "(4, 3)", &big_endian),
        array("positions", "<f4", "True", "(4,3)", &columns),
        Entry { method: 8, ..positions() },
    ];
    let with_faces = other_faces.into_iter().map(|faces| vec![positions(), faces]);
    let with_positions = other_positions.into_iter().map(|positions| vec![faces(), positions]);
    for entries in with_faces.chain(with_positions) {
        let what = format!(
            "{:?}",
            entries.iter().map(|entry| String::from_utf8_lossy(&entry.bytes[10..60])).collect::<Vec<_>>()
        );
        let (run, result) = extract(&write_zip(&entries))?;
        run.expect(0, &[]).map_err(|error| format!("{what}: {error}"))?;
        compare(&expected, &result).map_err(|error| format!("{what}: {error}"))?;
    }
    Ok(())
}

fn bad_archives() -> Outcome {
    let position_data = &positions().bytes[128..];
    let face_data = FACES.as_flattened();
    let huge = |name, descr| array(name, descr, "False", "(4000000000, 3)", &[0; 12]);
    let mut negative = FACES;
    negative[2][1] = 255;
    let mut beyond = FACES;
    beyond[3][0] = 4;
    let mut truncated = faces();
    truncated.bytes.truncate(130);
    let mut longer = faces();
    longer.bytes.push(0);
    let faces_of =
        |descr: &str, shape: &str, data: &[u8]| vec![positions(), array("faces", descr, "False", shape, data)];
    let cases: Vec<(Vec<Entry>, &[&str])> = vec![
        (vec![], &["positions"]),
        (vec![positions()], &["`faces`", "positions.npy"]),
        (vec![faces()], &["`positions`"]),
        (vec![array("positions", "<f8", "False", "(4, 3)", &[0; 96]), faces()], &["`positions`", "<f8", "float32"]),
        (vec![array("positions", "<f4", "False", "(3, 4)", position_data), faces()], &["`positions`", "(3, 4)"]),
        (vec![array("positions", "<f4", "False", "(12,)", position_data), faces()], &["`positions`", "(12)"]),
        (vec![array("positions", "<f4", "Maybe", "(4, 3)", position_data), faces()], &["`positions`", "header"]),
        (vec![huge("positions", "<f4"), faces()], &["`positions`", "48000000"]),
        (vec![positions(), huge("faces", "<i8")], &["`faces`", "4000000000"]),
        (faces_of("<f4", "(4, 3)", position_data), &["`faces`", "integer"]),
        (faces_of("|i1", "(4, 3)", negative.as_flattened()), &["`faces`", "row 2", "-1"]),
        (faces_of("|u1", "(4, 3)", beyond.as_flattened()), &["`faces`", "row 3", "vertex 4"]),
        (faces_of("|u1", "(0, 3)", &[]), &["no faces"]),
        (faces_of("|u1", "(4, 3, 1)", face_data), &["`faces`", "(4, 3, 1)"]),
        (vec![positions(), truncated], &["`faces`", "140", "130"]),
        (vec![positions(), longer], &["`faces`", "140", "141"]),
        (vec![positions(), Entry { bytes: vec![], ..faces() }], &["`faces`", "header"]),
        (vec![positions(), Entry { bytes: b"not an array".to_vec(), ..faces() }], &["`faces`"]),
    ];
    for (entries, parts) in cases {
        let (run, _) = extract(&write_zip(&entries))?;
        run.expect(1, parts).map_err(|error| format!("{parts:?}: {error}"))?;
        run.expect(1, &["model.npz"])?;
    }
    for (bytes, what) in [(vec![], "it is empty"), (b"PK\x03\x04".to_vec(), "ZIP"), (vec![7; 5000], "ZIP")] {
        let (run, _) = extract(&bytes)?;
        run.expect(1, &["model.npz", what]).map_err(|error| format!("{what}: {error}"))?;
    }
    // A byte of data that does not go with its checksum.
    let mut damaged = tetrahedron();
    let at = damaged.windows(12).position(|window| window == face_data).map(|_| 31 + positions().name.len() + 140);
    damaged[at.ok_or("the faces are not there")?] ^= 1;
    let (run, _) = extract(&damaged)?;
    run.expect(1, &["`positions`"])
}

/// A small generator, so that a failure can be run again from its printed seed.
struct Random(u64);

impl Random {
    fn below(&mut self, bound: usize) -> usize {
        self.0 ^= self.0 << 13;
        self.0 ^= self.0 >> 7;
        self.0 ^= self.0 << 17;
        (self.0 >> 11) as usize % bound
    }
}

fn mutated() -> Outcome {
    let seed: u64 = 0x5eed_0001;
    println!("npz_input::mutated_archives_never_panic: seed {seed:#x}");
    let mut random = Random(seed);
    for case in 0..300 {
        let mut entries = vec![positions(), faces()];
        if case % 3 == 0 {
            entries[1].method = 8;
        }
        let in_arrays = case % 2 == 0;
        let mut archive = write_zip(&entries);
        for _ in 0..=random.below(3) {
            if in_arrays {
                // Inside the arrays, with checksums that fit, so that what is behind them is reached.
                let entry = random.below(2);
                let at = random.below(entries[entry].bytes.len());
                entries[entry].bytes[at] = random.below(256) as u8;
                archive = write_zip(&entries);
            } else {
                let at = random.below(archive.len());
                match random.below(3) {
                    0 => archive.truncate(at.max(1)),
                    1 => archive[at] ^= 1 << random.below(8),
                    _ => archive[at] = 255,
                }
            }
        }
        let (run, _) = extract(&archive)?;
        ensure!(
            matches!(run.code, 0 | 1) && !run.stderr.contains("panicked"),
            "case {case} of seed {seed:#x}: exit code {}: {}",
            run.code,
            run.stderr
        );
    }
    Ok(())
}
