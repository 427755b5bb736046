//! Models with large coordinates: an origin near them, and coordinates at the interface as the files have them.

use std::fmt::Write as _;
use std::path::Path;

use serde_json::{Value, json};

use super::archive::{Entry, array, compare, data, read_zip, write_zip};
use super::run::{Folder, folder, on_cases, rimline, write_file};
use super::shadow::{Image, apart};
use super::{Outcome, Test, ensure};

pub(crate) const TESTS: &[Test] = &[
    ("origin::a_house_far_away_looks_as_one_at_zero", pictures),
    ("origin::archives_are_relative_to_it_and_are_read_back", archives),
    ("origin::points_of_queries_may_be_in_either_form", queries),
    ("origin::depth_maps_are_in_the_files_coordinates", depth_maps),
    ("origin::nodes_and_lights_of_a_gltf_far_away", gltf),
    ("origin::files_of_a_run_share_one", shared),
    ("origin::what_f32_loses_all_the_same_is_told", losses),
    ("origin::near_zero_there_is_none", none),
    ("origin::wrong_origins_are_refused", wrong),
];

/// The same on the shared cases; the house is like the one here.
pub(crate) fn trials() -> Vec<libtest_mimic::Trial> {
    on_cases(&[("origin::cases", "l_house.obj", house, true), ("origin::cases", "e4_utm.glb", ball, false)])
}

/// A place of a survey, in millimetres.
const FAR: [f64; 3] = [392_143.517, 34.128, -5_820_467.702];

/// Boxes of a house: walls, eaves that stand out by 0.2, three steps. Each by its lowest and highest corner.
const BOXES: [[[f64; 3]; 2]; 5] = [
    [[0.2, 0.0, 0.2], [4.8, 2.0, 3.8]],
    [[0.0, 2.0, 0.0], [5.0, 2.4, 4.0]],
    [[4.8, 0.0, 1.0], [5.1, 0.6, 2.2]],
    [[5.1, 0.0, 1.0], [5.4, 0.4, 2.2]],
    [[5.4, 0.0, 1.0], [5.7, 0.2, 2.2]],
];

/// Corners of the boxes' quadrilaterals, of which each has two triangles.
const SIDES: [[usize; 4]; 6] = [[0, 4, 6, 2], [1, 3, 7, 5], [0, 1, 5, 4], [2, 6, 7, 3], [0, 2, 3, 1], [4, 5, 7, 6]];

/// The house as an OBJ, at a place.
fn obj(at: [f64; 3]) -> String {
    let mut text = String::from("v 0 0 0\n");
    for (number, bounds) in BOXES.iter().enumerate() {
        for corner in 0..8 {
            let [x, y, z] = [0, 1, 2].map(|axis| bounds[corner >> axis & 1][axis] + at[axis]);
            let _ = writeln!(text, "v {x:.3} {y:.3} {z:.3}");
        }
        for side in SIDES {
            let [a, b, c, d] = side.map(|corner| 8 * number + corner + 2);
            let _ = writeln!(text, "f {a} {b} {c}\nf {a} {c} {d}");
        }
    }
    text
}

/// A folder with `far.obj` and `near.obj`.
fn houses() -> Result<Folder, String> {
    let folder = folder();
    for (name, at) in [("far.obj", FAR), ("near.obj", [0.0; 3])] {
        folder.write(name, obj(at))?;
    }
    Ok(folder)
}

/// `x,y,z` of a point beside the house, for either.
fn place(name: &str, point: [f64; 3]) -> String {
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

fn pictures() -> Outcome {
    let folder = houses()?;
    let size = "--size 160x120";
    for name in ["near", "far"] {
        let at = |point| place(name, point);
        folder.run(&format!("draw @{name}.obj {size} --out @{name}.png")).expect(0, &[])?;
        folder.run(&format!("shadow @{name}.obj {size} --out @{name}-s.png")).expect(0, &[])?;
        let (eye, target) = (at([9.0, 4.0, 8.0]), at([2.5, 1.0, 2.0]));
        let view = format!("{size} --eye {eye} --target {target} --fov 40");
        let ground = at([0.0, -0.5, 0.0]);
        let ground = ground.split(',').nth(1).ok_or("no height")?;
        let lights = format!("--light point:{} --light hom:{},0", at([7.0, 6.0, 5.0]), "1,2,0.5");
        let line = format!("shadow @{name}.obj {view} --ground {ground} {lights} --area disc:0.3 --samples 4");
        folder.run(&format!("{line} --out @{name}-a.png")).expect(0, &[])?;
        let line = format!("shadow @{name}.obj {view} --ground {ground} {lights} --mask @{name} --json");
        let json = folder.run(&line).json()?;
        // The light is told as it was given.
        let [x, y, z] = [0, 1, 2].map(|axis| [7.0, 6.0, 5.0][axis] + if name == "far" { FAR[axis] } else { 0.0 });
        let told = &json["lights"][0]["light"];
        let told: Vec<f64> = told.as_array().into_iter().flatten().filter_map(Value::as_f64).collect();
        ensure!(told == [x, y, z, 1.0].map(|c| (c * 1e3).round() / 1e3), "{told:?}");
        ensure!(json["lights"][1]["light"] == json!([1.0, 2.0, 0.5, 0.0]), "{}", json["lights"][1]);
        if name == "far" {
            let origin = origin(&json)?;
            ensure!(origin.iter().zip(FAR).all(|(origin, place)| (origin - place).abs() < 20.0), "{origin:?}");
        } else {
            ensure!(json.get("origin").is_none(), "an origin at zero: {json}");
        }
    }
    for suffix in [".png", "-s.png", "-a.png", ".0.png", ".1.png"] {
        let files = [format!("near{suffix}"), format!("far{suffix}")];
        let different = values_apart(folder.path(), [&files[0], &files[1]])?;
        ensure!(different <= 6, "{files:?}: {different} values differ");
    }
    // The comparison can fail: eaves that stand out by half as much.
    let other = obj([0.0; 3]).replace("v 0.000 2.", "v 0.100 2.").replace("v 5.000 2.", "v 4.900 2.");
    folder.write("other.obj", other)?;
    folder.run(&format!("draw @other.obj {size} --out @other.png")).expect(0, &[])?;
    let different = values_apart(folder.path(), ["near.png", "other.png"])?;
    ensure!(different > 60, "narrower eaves change {different} values only");
    // Films take the same way.
    folder.run(&format!("film @far.obj --frames 1 {size} --out @far-film")).expect(0, &[])?;
    let different = values_apart(folder.path(), ["near-s.png", "far-film/0000.png"])?;
    ensure!(different <= 6, "a film: {different} values differ");
    Ok(())
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
        let (point, corner) = (place(name, [7.0, 6.0, 5.0]), place(name, [5.0, 2.0, 4.0]));
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

fn points_f32(points: &[[f64; 3]]) -> Entry {
    let bytes: Vec<u8> = points.iter().flatten().flat_map(|&c| (c as f32).to_le_bytes()).collect();
    array("points", "<f4", "False", &format!("({}, 3)", points.len()), &bytes)
}

fn doubles(name: &str, shape: &str, values: &[f64]) -> Entry {
    array(name, "<f8", "False", shape, &values.iter().flat_map(|c| c.to_le_bytes()).collect::<Vec<_>>())
}

/// Under the eaves before a wall and beside one, on a step, in a wall, far above.
const POINTS: [[f64; 3]; 5] = [[2.5, 1.0, 0.1], [4.9, 1.9, 0.5], [5.25, 0.5, 1.5], [1.0, 1.0, 1.0], [2.5, 9.0, 2.0]];

fn queries() -> Outcome {
    let folder = houses()?;
    let write = |name: &str, entries: &[Entry]| folder.write(name, write_zip(entries));
    let far = POINTS.map(|point| [0, 1, 2].map(|axis| point[axis] + FAR[axis]));
    let at = [392_160.0, 32.0, -5_820_448.0];
    let relative = far.map(|point| [0, 1, 2].map(|axis| point[axis] - at[axis]));
    write("near.npz", &[points_f32(&POINTS)])?;
    write("double.npz", &[doubles("points", "(5, 3)", far.as_flattened())])?;
    write("relative.npz", &[points_f32(&relative), doubles("origin", "(3,)", &at)])?;
    write("both.npz", &[doubles("points", "(5, 3)", relative.as_flattened()), doubles("origin", "(3,)", &at)])?;
    let query = |model: &str, points: &str, device: &str| {
        let light = place(model, [7.0, 6.0, 5.0]);
        let line = format!("query @{model}.obj --points @{points}.npz --light dir:0,1,0 --light point:{light}");
        folder.run(&format!("{line} --device {device} --out @out.npz")).expect(0, &[])?;
        folder.read("out.npz")
    };
    let expected = query("near", "near", "cpu")?;
    let depth = |archive: &[u8]| Ok::<_, String>(entry(&read_zip(archive)?, "depth")?.bytes.clone());
    ensure!(entry(&read_zip(&expected)?, "origin").is_err(), "an origin at zero");
    let first = query("far", "double", "cpu")?;
    for (points, device) in [("double", "cpu"), ("double", "gpu"), ("relative", "cpu"), ("both", "cpu")] {
        let found = query("far", points, device)?;
        ensure!(depth(&found)? == depth(&expected)?, "{points} on {device}: other depths");
        // Points relative to another origin are rounded twice.
        if points == "double" {
            compare(&found, &first).map_err(|error| format!("{points} on {device}: {error}"))?;
        }
    }
    // A written result gives the same result when it is queried again.
    folder.write("again.npz", &first)?;
    compare(&query("far", "again", "cpu")?, &first)?;
    // Points in float32 without an origin are in the world, and too coarse there.
    write("coarse.npz", &[points_f32(&far)])?;
    ensure!(depth(&query("far", "coarse", "cpu")?)? != depth(&expected)?, "coarse points have the same depths");
    Ok(())
}

fn depth_maps() -> Outcome {
    let folder = houses()?;
    let lamp = |name: &str| place(name, [7.0, 6.0, 5.0]);
    let line = |name: &str, rest: &str| {
        let view = format!("--eye {} --target {}", place(name, [9.0, 4.0, 8.0]), place(name, [2.5, 1.0, 2.0]));
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
    let other = format!("--light point:{} --depth @far.0.npz --mask @x", place("far", [7.5, 6.0, 5.0]));
    folder.run(&line("far", &other)).expect(2, &["point:392151.017,40.128,-5820462.702", "point:392150.5"])
}

/// The house's walls and eaves as a glTF, in a node at a place, with a lamp.
fn gltf_text(at: [f64; 3], extension: Option<[f64; 3]>) -> String {
    use base64::Engine as _;
    let corner = |bounds: [[f64; 3]; 2], corner: usize| [0, 1, 2].map(|axis| bounds[corner >> axis & 1][axis] as f32);
    let sides = SIDES.iter().flat_map(|&[a, b, c, d]| [a, b, c, a, c, d]);
    let corners = BOXES[..2].iter().flat_map(|&bounds| sides.clone().map(move |side| corner(bounds, side)));
    let bytes: Vec<u8> = corners.flatten().flat_map(f32::to_le_bytes).collect();
    let data = base64::engine::general_purpose::STANDARD.encode(&bytes);
    let mut value = json!({
        "asset": { "version": "2.0" }, "extensionsUsed": ["KHR_lights_punctual"],
        "extensions": { "KHR_lights_punctual": { "lights": [{ "type": "point", "name": "lamp" }] } },
        "buffers": [{ "byteLength": bytes.len(), "uri": format!("data:application/octet-stream;base64,{data}") }],
        "bufferViews": [{ "buffer": 0, "byteLength": bytes.len() }],
        "accessors": [{ "bufferView": 0, "componentType": 5126, "count": 72, "type": "VEC3",
            "min": [0, 0, 0], "max": [5, 2.5, 4] }],
        "meshes": [{ "primitives": [{ "attributes": { "POSITION": 0 } }] }],
        "nodes": [{ "mesh": 0, "translation": at, "children": [1] },
            { "translation": [7, 6, 5], "extensions": { "KHR_lights_punctual": { "light": 0 } } }],
        "scenes": [{ "nodes": [0] }], "scene": 0,
    });
    if let Some(center) = extension {
        value["extensionsUsed"] = json!(["KHR_lights_punctual", "CESIUM_RTC"]);
        value["extensionsRequired"] = json!(["CESIUM_RTC"]);
        value["extensions"]["CESIUM_RTC"] = json!({ "center": center });
    }
    value.to_string()
}

/// `near.gltf`, `far.gltf` and one with a center, so far behind.
fn gltf_files(folder: &Path, behind: f64) -> Outcome {
    let [x, y, z] = FAR;
    let center = Some([x - 0.517, y, z]);
    for (name, at, center) in
        [("near", [0.0, 0.0, -behind], None), ("far", [x, y, z - behind], None), ("rtc", [0.517, 0.0, -behind], center)]
    {
        write_file(folder.join(format!("{name}.gltf")), gltf_text(at, center))?;
    }
    Ok(())
}

fn gltf() -> Outcome {
    let folder = folder();
    gltf_files(folder.path(), 0.0)?;
    for name in ["near", "far", "rtc"] {
        let view = "--size 160x120 --light file:lamp";
        let line = format!("shadow @{name}.gltf {view} --out @{name}.png --mask @{name} --json");
        let json = folder.run(&line).json()?;
        let info = folder.run(&format!("info @{name}.gltf --json")).json()?;
        if name == "near" {
            continue;
        }
        ensure!(origin(&json)? == origin(&info)?, "two origins: {json} {info}");
        for found in [&json["lights"][0]["light"], &info["lights"][0]["xyzw"]] {
            for (axis, beside) in [7.0, 6.0, 5.0].into_iter().enumerate() {
                let found = found[axis].as_f64().unwrap_or_default();
                ensure!((found - beside - FAR[axis]).abs() < 1e-5, "{name}, axis {axis}: the lamp at {found}");
            }
        }
        let (low, high) = (&info["placed"]["bounds"]["min"], &info["placed"]["bounds"]["max"]);
        let near = |value: &Value, expected: f64| (value.as_f64().unwrap_or_default() - expected).abs() < 1e-5;
        ensure!(near(&low[0], FAR[0]) && near(&high[0], FAR[0] + 5.0), "{name}: {low} to {high}");
        ensure!(near(&low[2], FAR[2]) && near(&high[2], FAR[2] + 4.0), "{name}: {low} to {high}");
        // In its own space the mesh is where it was.
        ensure!(info["meshes"][0]["bounds"]["max"] == json!([5.0, 2.4_f32, 4.0]), "{}", info["meshes"][0]["bounds"]);
        for suffix in [".png", ".0.png"] {
            let files = [format!("near{suffix}"), format!("{name}{suffix}")];
            ensure!(values_apart(folder.path(), [&files[0], &files[1]])? <= 6, "{files:?} differ");
        }
    }
    Ok(())
}

fn shared() -> Outcome {
    let folder = houses()?;
    gltf_files(folder.path(), 6.0)?;
    for name in ["near", "far"] {
        let view = format!("--eye {} --target {}", place(name, [9.0, 4.0, 8.0]), place(name, [2.5, 1.0, 2.0]));
        // The second house casts onto the first; archives come with the origin that they were written with.
        let light = format!("--light point:{}", place(name, [7.0, 6.0, 5.0]));
        folder.run(&format!("extract @{name}.obj {light} --device cpu --out @{name}.npz")).expect(0, &[])?;
        for (number, first) in ["obj", "npz"].into_iter().enumerate() {
            let line =
                format!("shadow @{name}.{first} @{name}.gltf --size 160x120 {view} {light} --mask @{name}{number}");
            folder.run(&line).expect(0, &[])?;
        }
    }
    for number in 0..2 {
        let files = [format!("near{number}.0.png"), format!("far{number}.0.png")];
        ensure!(values_apart(folder.path(), [&files[0], &files[1]])? <= 6, "{files:?} differ");
    }
    Ok(())
}

fn losses() -> Outcome {
    let folder = houses()?;
    // Near and far together: no origin serves both.
    let both = folder.run("shadow @far.obj @near.obj --size 96x72 --out @both.png");
    both.expect(0, &["warning: ", "near.obj: 32-bit floats move its vertices by up to 2.5"])?;
    ensure!(!both.stderr.contains("far.obj: 32"), "{}", both.stderr);
    for file in ["far.obj", "near.obj"] {
        let alone = folder.run(&format!("shadow @{file} --size 96x72 --out @alone.png"));
        ensure!(alone.stderr.is_empty(), "{file}: {}", alone.stderr);
    }
    // Archives without an origin are used bit for bit, wherever they are.
    let far = BOXES[0].map(|corner| [0, 1, 2].map(|axis| corner[axis] + FAR[axis]));
    let corners: Vec<u8> = [far[0], far[1], [far[0][0], far[1][1], far[0][2]]]
        .iter()
        .flatten()
        .flat_map(|&c| (c as f32).to_le_bytes())
        .collect();
    let entries =
        [array("positions", "<f4", "False", "(3, 3)", &corners), array("faces", "|u1", "False", "(1, 3)", &[0, 1, 2])];
    folder.write("coarse.npz", write_zip(&entries))?;
    let info = folder.run("info @coarse.npz --json");
    info.expect(0, &["warning: ", "coarse.npz: 32-bit floats move its vertices by up to 2.5"])?;
    ensure!(info.json()?.get("origin").is_none(), "{}", info.stdout);
    Ok(())
}

fn none() -> Outcome {
    let folder = houses()?;
    // Thirty times its size away `f32` is fine for a house.
    folder.write("beside.obj", obj([150.0, 0.0, -90.0]))?;
    for name in ["near", "beside"] {
        let info = folder.run(&format!("info @{name}.obj --json"));
        ensure!(info.json()?.get("origin").is_none() && info.stderr.is_empty(), "{name}: {}", info.stdout);
        let line = format!("extract @{name}.obj --no-weld --light dir:1,2,3 --device cpu --out @{name}.npz");
        folder.run(&line).expect(0, &[])?;
        let entries = read_zip(&folder.read(format!("{name}.npz"))?)?;
        ensure!(entry(&entries, "origin").is_err(), "{name} has an origin");
        // Each coordinate is the text's nearest float32.
        let text = obj(if name == "near" { [0.0; 3] } else { [150.0, 0.0, -90.0] });
        let numbers = text.lines().filter_map(|line| line.strip_prefix("v ")).flat_map(|line| line.split(' '));
        let expected: Vec<f64> = numbers.filter_map(|word| word.parse::<f32>().ok()).map(f64::from).collect();
        ensure!(singles(&entries, "positions")? == expected, "{name}: other positions");
    }
    Ok(())
}

fn wrong() -> Outcome {
    let folder = folder();
    let corners: Vec<u8> =
        [0.0_f32, 0.0, 0.0, 1.0, 0.0, 0.0, 0.0, 1.0, 0.0].iter().flat_map(|c| c.to_le_bytes()).collect();
    let model = |origin: Entry| {
        let positions = array("positions", "<f4", "False", "(3, 3)", &corners);
        write_zip(&[positions, array("faces", "|u1", "False", "(1, 3)", &[0, 1, 2]), origin])
    };
    for (origin, parts) in [
        (doubles("origin", "(1, 3)", &[0.0; 3]), ["`origin`", "(1, 3)"]),
        (doubles("origin", "(3,)", &[0.0, f64::NAN, 0.0]), ["`origin`", "NaN"]),
        (array("origin", "<i4", "False", "(3,)", &[0; 12]), ["`origin`", "<i4"]),
    ] {
        let file = folder.path().join("model.npz");
        write_file(&file, model(origin))?;
        rimline([std::ffi::OsStr::new("info"), file.as_os_str()]).expect(1, &parts)?;
    }
    Ok(())
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
