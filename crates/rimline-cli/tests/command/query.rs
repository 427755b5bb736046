//! `rimline query` as a user runs it: what it writes, that devices agree, and what it refuses.

use std::ffi::OsStr;
use std::path::Path;

use super::archive::{Entry, FIRST_DAY, array, compare, data, read_zip, words, write_zip};
use super::npz_input::tetrahedron;
use super::run::{Run, folder, rimline, write_file};
use super::{Outcome, Test, ensure};

pub(crate) const TESTS: &[Test] = &[
    ("query::depths_of_a_tetrahedron", depths),
    ("query::devices_write_the_same_bytes", agree),
    ("query::no_points_are_no_depths", no_points),
    ("query::bad_points_are_refused", bad_points),
    ("query::bad_use_is_refused", bad_use),
];

/// Inside, outside, behind, on a corner, not finite.
const POINTS: [[f32; 3]; 5] =
    [[0.125, 0.125, 0.125], [2.0, 2.0, 2.0], [-1.0, 0.25, 0.25], [0.0, 0.0, 0.0], [f32::NAN, 0.0, 0.0]];

fn points_array(points: &[[f32; 3]]) -> Entry {
    let bytes: Vec<u8> = points.iter().flatten().flat_map(|c| c.to_le_bytes()).collect();
    array("points", "<f4", "False", &format!("({}, 3)", points.len()), &bytes)
}

/// Queries the tetrahedron with the points of an archive; the result's bytes, too, if there are any.
fn query(folder: &Path, points: &[u8], options: &[&str]) -> Result<(Run, Option<Vec<u8>>), String> {
    let [model, file, out] = ["model.npz", "points.npz", "out.npz"].map(|name| folder.join(name));
    write_file(&model, tetrahedron())?;
    write_file(&file, points)?;
    let mut line = vec![OsStr::new("query"), model.as_os_str(), OsStr::new("--points"), file.as_os_str()];
    line.extend([OsStr::new("--out"), out.as_os_str()]);
    line.extend(options.iter().map(OsStr::new));
    let run = rimline(line);
    let result = std::fs::read(&out).ok();
    if run.code != 0 {
        let left = std::fs::read_dir(folder).map_err(|error| error.to_string())?.count();
        ensure!(left == 2, "{left} files, where only the model and the points should be");
    } else {
        std::fs::remove_file(&out).map_err(|error| error.to_string())?;
    }
    Ok((run, result))
}

const LIGHTS: [&str; 6] = ["--light", "dir:1,0,0", "--light", "point:9,0.25,0.25", "--light", "hom:0.5,0.5,0.5,4"];

fn depths() -> Outcome {
    let folder = folder();
    let archive = write_zip(&[points_array(&POINTS)]);
    for device in ["cpu", "gpu"] {
        let options = [&LIGHTS[..], &["--device", device, "--json"]].concat();
        let (run, result) = query(folder.path(), &archive, &options)?;
        let json = run.json()?;
        ensure!(json["points"] == 5 && json["non_finite_points"] == 1 && json["faces"] == 4, "{device}: {json}");
        ensure!(json["points_in_shadow"] == serde_json::json!([3, 3, 2]), "{device}: {json}");
        ensure!(json["deepest"] == serde_json::json!([2, 2, 1]), "{device}: {json}");
        let entries = read_zip(&result.ok_or("nothing was written")?)?;
        let names: Vec<&str> = entries.iter().map(|entry| entry.name.as_str()).collect();
        ensure!(names == ["points.npy", "lights.npy", "depth.npy"], "the entries are {names:?}");
        ensure!(entries.iter().all(|entry| entry.method == 0 && entry.time == FIRST_DAY), "not stored, or dated");
        let points = words(data(&entries[0], "<f4", "(5, 3)")?);
        let given: Vec<u32> = POINTS.iter().flatten().map(|c| c.to_bits()).collect();
        ensure!(points == given, "{device}: the points changed");
        let lights = words(data(&entries[1], "<f4", "(3, 4)")?);
        let given = [[1.0, 0.0, 0.0, 0.0], [9.0, 0.25, 0.25, 1.0], [0.5, 0.5, 0.5, 4.0_f32]];
        ensure!(lights == given.as_flattened().iter().map(|c| c.to_bits()).collect::<Vec<_>>(), "{device}: lights");
        let depth: Vec<i32> = words(data(&entries[2], "<i4", "(5, 3)")?).into_iter().map(u32::cast_signed).collect();
        // The third light is at the first point, inside: nothing lies between these. From the corner, the first light is
        // moved to where its rays run within, and out by the one face that does not touch the corner.
        let right = [[1, 1, 0], [0, 0, 1], [2, 2, 1], [1, 1, 0], [-1, -1, -1]];
        ensure!(depth == right.as_flattened(), "{device}: the depths are {depth:?}");
    }
    let (run, _) = query(folder.path(), &archive, &LIGHTS)?;
    run.expect(0, &[])?;
    for part in ["points             5", "1 not finite", "points in shadow   3, 3, 2", "deepest            2, 2, 1"] {
        ensure!(run.stdout.contains(part), "the report lacks `{part}`: {}", run.stdout);
    }
    Ok(())
}

fn agree() -> Outcome {
    let folder = folder();
    // Whole and half numbers, so that segments meet corners and edges.
    let points: Vec<[f32; 3]> = (0..700).map(|i| [i % 7, i / 7 % 9, i / 63].map(|c| 0.5 * c as f32 - 1.0)).collect();
    let archive = write_zip(&[points_array(&points)]);
    let mut results = Vec::new();
    for device in ["cpu", "gpu", "gpu"] {
        let (run, result) = query(folder.path(), &archive, &[&LIGHTS[..], &["--device", device]].concat())?;
        run.expect(0, &[])?;
        results.push(result.ok_or("nothing was written")?);
    }
    ensure!(results[0] == results[1] && results[1] == results[2], "devices or runs differ");
    compare(&results[0], &results[1])?;
    let (_, other) = query(folder.path(), &archive, &["--light", "dir:0,1,0", "--device", "cpu"])?;
    ensure!(other.as_ref() != results.first(), "another light changed nothing");
    Ok(())
}

fn no_points() -> Outcome {
    let folder = folder();
    for device in ["cpu", "gpu"] {
        let options = [&LIGHTS[..], &["--device", device]].concat();
        let (run, result) = query(folder.path(), &write_zip(&[points_array(&[])]), &options)?;
        run.expect(0, &[])?;
        let entries = read_zip(&result.ok_or("nothing was written")?)?;
        data(&entries[2], "<i4", "(0, 3)")?;
    }
    Ok(())
}

fn bad_points() -> Outcome {
    let folder = folder();
    let floats = &points_array(&POINTS).bytes[128..];
    let mut short = points_array(&POINTS);
    short.bytes.truncate(150);
    let cases: Vec<(Vec<u8>, &[&str])> = vec![
        (write_zip(&[]), &["`points`", "none"]),
        (tetrahedron(), &["`points`", "positions.npy"]),
        (write_zip(&[array("points", "<f2", "False", "(1, 3)", &[0; 6])]), &["`points`", "<f2", "float32"]),
        (write_zip(&[array("points", "<i4", "False", "(5, 3)", floats)]), &["`points`", "<i4", "float32"]),
        (write_zip(&[array("points", "<f4", "False", "(3, 5)", floats)]), &["`points`", "(3, 5)", "(P, 3)"]),
        (write_zip(&[array("points", "<f4", "False", "(15,)", floats)]), &["`points`", "(15)"]),
        (write_zip(&[array("points", "<f4", "False", "(4000000000, 3)", &[0; 12])]), &["`points`", "48000000"]),
        (write_zip(&[short]), &["`points`", "188", "150"]),
        (vec![1; 300], &["ZIP"]),
        (vec![], &["it is empty"]),
    ];
    for (points, parts) in cases {
        let (run, _) = query(folder.path(), &points, &["--light", "dir:0,1,0", "--device", "cpu"])?;
        run.expect(1, parts).map_err(|error| format!("{parts:?}: {error}"))?;
        run.expect(1, &["points.npz"])?;
    }
    Ok(())
}

fn bad_use() -> Outcome {
    let folder = folder();
    let archive = write_zip(&[points_array(&POINTS)]);
    let cases = [
        ("", "--light"),
        ("--light hom:1,1,1,-1", "w = -1"),
        ("--light dir:0,0,0", "zero"),
        ("--light point:1,2,nan", "nan"),
        ("--light file:all", "no lights"),
        ("--light dir:0,1,0 --animation Run", "Run"),
        ("--light dir:0,1,0 --device cpu --displace a.wgsl", "--displace"),
    ];
    for (options, part) in cases {
        let options: Vec<&str> = options.split_whitespace().collect();
        let (run, _) = query(folder.path(), &archive, &options)?;
        run.expect(2, &[part]).map_err(|error| format!("{options:?}: {error}"))?;
    }
    rimline(["query", "model.npz", "--light", "dir:0,1,0", "--out", "o.npz"]).expect(2, &["--points"])?;
    let missing = ["query", "m.npz", "--points", "p.npz", "--light", "dir:0,1,0", "--out", "o.npz", "--device", "cpu"];
    rimline(missing).expect(1, &["m.npz"])
}
