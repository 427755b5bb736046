//! Models with large coordinates: an origin near them, and coordinates at the interface as the files have them.

use std::path::Path;

use serde_json::Value;

use super::archive::{Entry, array, compare, data, read_zip, write_zip};
use super::models_of_code::house as house_obj;
use super::pictures::{Image, apart};
use super::run::{Folder, folder, on_cases};
use super::{Outcome, Test, ensure};

pub(crate) const TESTS: &[Test] = &[
    ("origin::archives_are_relative_to_it_and_are_read_back", archives),
    ("origin::depth_maps_are_in_the_files_coordinates", depth_maps),
];

/// The same on the shared cases; the house is like the one here.
pub(crate) fn trials() -> Vec<libtest_mimic::Trial> {
    on_cases(&[("origin::cases", "l_house.obj", house, true), ("origin::cases", "e4_utm.glb", ball, false)])
}

/// A place of a survey, in millimetres.
const FAR: [f64; 3] = [392_143.517, 34.128, -5_820_467.702];

/// A folder with `far.obj` and `near.obj`.
fn houses() -> Result<Folder, String> {
    let folder = folder();
    for (name, at) in [("far.obj", FAR), ("near.obj", [0.0; 3])] {
        folder.write(name, house_obj(at))?;
    }
    Ok(folder)
}

/// `x,y,z` of a point beside the house, for either.
fn beside_house(name: &str, point: [f64; 3]) -> String {
    let at = if name == "far" { FAR } else { [0.0; 3] };
    let [x, y, z] = [0, 1, 2].map(|axis| point[axis] + at[axis]);
    format!("{x:.3},{y:.3},{z:.3}")
}

/// Values of two pictures that are further apart than rounding to 8 bits takes them.
fn values_apart(folder: &Path, files: [&str; 2]) -> Result<usize, String> {
    let [a, b] = files.map(|name| Image::read(&folder.join(name)));
    apart([&a?.bytes, &b?.bytes], 1, 24)
}

fn origin(json: &Value) -> Result<[f64; 3], String> {
    let numbers = json["origin"].as_array().ok_or_else(|| format!("no origin: {json}"))?;
    let numbers: Vec<f64> = numbers.iter().filter_map(Value::as_f64).collect();
    numbers.try_into().map_err(|numbers| format!("{numbers:?}"))
}

fn entry<'a>(entries: &'a [Entry], name: &str) -> Result<&'a Entry, String> {
    entries.iter().find(|entry| entry.name == format!("{name}.npy")).ok_or_else(|| format!("no {name}"))
}

fn singles(entries: &[Entry], name: &str) -> Result<Vec<f64>, String> {
    let bytes = &entry(entries, name)?.bytes[128..];
    Ok(bytes.as_chunks::<4>().0.iter().map(|bytes| f64::from(f32::from_le_bytes(*bytes))).collect())
}

fn archives() -> Outcome {
    let folder = houses()?;
    let lights = |name: &str| {
        let (point, corner) = (beside_house(name, [7.0, 6.0, 5.0]), beside_house(name, [5.0, 2.0, 4.0]));
        format!("--light point:{point} --light dir:1,2,0.5 --light point:{corner}")
    };
    let line =
        |name: &str, out: &str| format!("extract @{name}.obj {} --device cpu --json --out @{out}.npz", lights(name));
    folder.run(&line("near", "near")).expect(0, &[])?;
    let json = folder.run(&line("far", "far")).json()?;
    let [near, far] = ["near.npz", "far.npz"].map(|name| folder.read(name));
    let (near, far) = (near?, far?);
    let (expected, found) = (read_zip(&near)?, read_zip(&far)?);
    // It comes last, in float64, and only where there is one.
    let names = |entries: &[Entry]| entries.iter().map(|entry| entry.name.clone()).collect::<Vec<_>>();
    ensure!(names(&found)[..found.len() - 1] == names(&expected)[..], "{:?}", names(&found));
    let last = data(&found[found.len() - 1], "<f8", "(3,)")?;
    let origin = origin(&json)?;
    ensure!(last == origin.iter().flat_map(|c| c.to_le_bytes()).collect::<Vec<_>>(), "origin.npy is not {origin:?}");
    // Decisions are the same as near zero.
    for name in ["faces", "edges", "edge_faces", "edge_kind", "facing", "silhouette", "winding"] {
        ensure!(entry(&found, name)? == entry(&expected, name)?, "{name} differs");
    }
    for (name, width) in [("positions", 3), ("lights", 4)] {
        let [found, expected] = [&found, &expected].map(|entries| singles(entries, name));
        for (number, (found, expected)) in found?.iter().zip(expected?).enumerate() {
            let (row, axis) = (number / width, number % width);
            // The vertex that no face has is at the world's zero, and a direction stays as it is.
            let stays = name == "lights" && (axis == 3 || row == 1);
            let is_unused = name == "positions" && row == 0;
            let shift = if stays {
                0.0
            } else if is_unused {
                -origin[axis]
            } else {
                FAR[axis] - origin[axis]
            };
            ensure!((found - expected - shift).abs() < 4e-6 * shift.abs().max(1.0), "{name} {number}: {found}");
        }
    }
    // It is a model again, bit for bit, on the CPU and on a GPU.
    for device in ["cpu", "gpu"] {
        let again = format!("extract @far.npz --no-weld {} --device {device} --out @again.npz", lights("far"));
        folder.run(&again).expect(0, &[])?;
        compare(&far, &folder.read("again.npz")?).map_err(|error| format!("{device}: {error}"))?;
    }
    folder.run("verify @").expect(0, &[])?;
    // Models that `verify` makes archives of have one, too.
    folder.run("verify --make @made @far.obj --faces 100").expect(0, &[])?;
    ensure!(entry(&read_zip(&folder.read("made/far.npz")?)?, "origin").is_ok(), "made without origin");
    folder.run("verify @made --device cpu").expect(0, &[])?;
    let info = folder.run("info @far.npz --json").json()?;
    let of_obj = folder.run("info @far.obj --json").json()?;
    let bounds = |low: f64, high: f64, axis: usize| [low + FAR[axis], high + FAR[axis]];
    let expected = [bounds(0.0, 5.7, 0), bounds(0.0, 2.4, 1), bounds(0.0, 4.0, 2)];
    for (axis, [low, high]) in expected.into_iter().enumerate() {
        let [low, high] = [low, high].map(|c| (c * 1e3).round() / 1e3);
        // Bounds are those of all vertices, and one that no face has is at zero.
        let [low, high] = [low.min(0.0), high.max(0.0)];
        for info in [&info, &of_obj] {
            let bounds = &info["placed"]["bounds"];
            ensure!(bounds["min"][axis] == low && bounds["max"][axis] == high, "{bounds} at {axis}: {low}, {high}");
        }
    }
    Ok(())
}

fn doubles(name: &str, shape: &str, values: &[f64]) -> Entry {
    array(name, "<f8", "False", shape, &values.iter().flat_map(|c| c.to_le_bytes()).collect::<Vec<_>>())
}

fn depth_maps() -> Outcome {
    let folder = houses()?;
    let lamp = |name: &str| beside_house(name, [7.0, 6.0, 5.0]);
    let line = |name: &str, rest: &str| {
        let view =
            format!("--eye {} --target {}", beside_house(name, [9.0, 4.0, 8.0]), beside_house(name, [2.5, 1.0, 2.0]));
        format!("shadow @{name}.obj --size 160x120 {view} {rest}")
    };
    for name in ["near", "far"] {
        let drawn = format!("--light point:{} --from-depth 256 --mask @{name} --save-depth @{name}", lamp(name));
        folder.run(&line(name, &drawn)).expect(0, &[])?;
        folder.run(&line(name, &format!("--depth @{name}.0.npz --mask @{name}-given"))).expect(0, &[])?;
        let files = [format!("{name}.0.png"), format!("{name}-given.0.png")];
        ensure!(values_apart(folder.path(), [&files[0], &files[1]])? == 0, "{name}: another shadow from the saved map");
    }
    ensure!(values_apart(folder.path(), ["near.0.png", "far.0.png"])? <= 6, "another shadow far away");
    // The same map with a matrix for plain positions of the world, in float64.
    let entries = read_zip(&folder.read("far.0.npz")?)?;
    let numbers = |name: &str, size: usize| -> Result<Vec<f64>, String> {
        let bytes = &entry(&entries, name)?.bytes[128..];
        Ok(match size {
            4 => bytes.as_chunks::<4>().0.iter().map(|bytes| f64::from(f32::from_le_bytes(*bytes))).collect(),
            _ => bytes.as_chunks::<8>().0.iter().map(|bytes| f64::from_le_bytes(*bytes)).collect(),
        })
    };
    let (mut matrix, at) = (numbers("view_projection", 4)?, numbers("origin", 8)?);
    ensure!(at.len() == 3 && (at[2] - FAR[2]).abs() < 20.0, "{at:?}");
    for row in matrix.chunks_mut(4) {
        row[3] -= row[0] * at[0] + row[1] * at[1] + row[2] * at[2];
    }
    let plain: Vec<Entry> = entries
        .iter()
        .filter(|entry| entry.name != "origin.npy")
        .map(|entry| match entry.name.as_str() {
            "view_projection.npy" => doubles("view_projection", "(4, 4)", &matrix),
            _ => entry.clone(),
        })
        .collect();
    folder.write("plain.npz", write_zip(&plain))?;
    folder.run(&line("far", "--depth @plain.npz --mask @plain")).expect(0, &[])?;
    ensure!(
        values_apart(folder.path(), ["far.0.png", "plain.0.png"])? <= 6,
        "another shadow by a matrix for the world"
    );
    // A light that is not the map's is told in the file's coordinates.
    let other = format!("--light point:{} --depth @far.0.npz --mask @x", beside_house("far", [7.5, 6.0, 5.0]));
    folder.run(&line("far", &other)).expect(2, &["point:392151.017,40.128,-5820462.702", "point:392150.5"])
}

fn house(file: &Path) -> Outcome {
    let folder = folder();
    for (name, file) in [("far", file.to_owned()), ("near", file.with_file_name("l_house_local.obj"))] {
        std::fs::copy(&file, folder.path().join(format!("{name}.obj"))).map_err(|error| error.to_string())?;
        folder.run(&format!("draw @{name}.obj --size 320x240 --out @{name}.png")).expect(0, &[])?;
        let line = format!("shadow @{name}.obj --size 320x240 --out @{name}-s.png --mask @{name}");
        folder.run(&line).expect(0, &[])?;
    }
    for suffix in [".png", "-s.png", ".0.png"] {
        let files = [format!("near{suffix}"), format!("far{suffix}")];
        ensure!(values_apart(folder.path(), [&files[0], &files[1]])? <= 6, "{files:?} differ");
    }
    Ok(())
}

fn ball(file: &Path) -> Outcome {
    let folder = folder();
    std::fs::copy(file, folder.path().join("ball.glb")).map_err(|error| error.to_string())?;
    let run = folder.run("shadow @ball.glb --size 160x120 --out @ball.png --json");
    run.expect(0, &["warning: ", "ball.glb: 32-bit floats move its vertices by up to 2."])?;
    ensure!(!run.stderr.contains("256"), "a false warning: {}", run.stderr);
    let origin = origin(&run.json()?)?;
    ensure!((origin[0] - 392_000.0).abs() < 16.0 && (origin[2] + 5_820_000.0).abs() < 16.0, "{origin:?}");
    Ok(())
}
