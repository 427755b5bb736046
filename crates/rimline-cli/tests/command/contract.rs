//! The arrays that `extract` writes, held against the contract entry by entry.

use std::ffi::OsStr;

use super::archive::{Entry, FIRST_DAY, array, compare, data, read_zip, words, write_zip};
use super::run::{folder, read_file, rimline, write_file};
use super::{Outcome, Test, ensure};

pub(crate) const TESTS: &[Test] = &[
    ("contract::entries_order_time_and_bytes", entries),
    ("contract::bits_of_33_lights_are_exact", exact_bits),
    ("contract::cpu_gpu_and_repeats_agree", agree),
    ("contract::non_finite_positions_face_nothing", non_finite),
    ("contract::displacement_moves_positions", displaced),
    ("contract::per_edge_keeps_the_face_bits", per_edge),
];

/// An open box without a lid, of two halves that meet in doubled vertices, and a triangle that names a vertex twice.
const POSITIONS: [[i8; 3]; 10] =
    [[0, 0, 0], [4, 0, 0], [4, 4, 0], [0, 4, 0], [0, 0, 4], [4, 0, 4], [4, 4, 4], [0, 4, 4], [4, 0, 0], [4, 4, 0]];
const FACES: [[u8; 3]; 11] = [
    [0, 2, 1],
    [0, 3, 2],
    [0, 1, 5],
    [0, 5, 4],
    [8, 9, 6],
    [8, 6, 5],
    [3, 7, 6],
    [3, 6, 2],
    [0, 4, 7],
    [0, 7, 3],
    [1, 8, 2],
];

fn lights() -> Vec<[i8; 4]> {
    let light = |i: i32| [7 * i % 13 - 6, 5 * i % 11 - 5, 3 * i % 17 - 8, (i % 3).min(1)].map(|c| c as i8);
    (1..34).map(light).collect()
}

fn model(scale: f32) -> Vec<u8> {
    let positions: Vec<u8> = POSITIONS.iter().flatten().flat_map(|&c| (f32::from(c) * scale).to_le_bytes()).collect();
    write_zip(&[
        array("positions", "<f4", "False", "(10, 3)", &positions),
        array("faces", "|u1", "False", "(11, 3)", FACES.as_flattened()),
    ])
}

/// Extracts from an archive, and again as often as there are lists of options.
fn extract<const N: usize>(model: &[u8], lights: &[[i8; 4]], options: [&[&str]; N]) -> Result<[Vec<u8>; N], String> {
    let folder = folder();
    let file = folder.path().join("model.npz");
    write_file(&file, model)?;
    let specs: Vec<String> = lights.iter().map(|[x, y, z, w]| format!("hom:{x},{y},{z},{w}")).collect();
    let mut results = [const { Vec::new() }; N];
    for (options, result) in options.into_iter().zip(&mut results) {
        let out = folder.path().join("out.npz");
        let mut line = vec!["extract".as_ref(), file.as_os_str(), "--out".as_ref(), out.as_os_str()];
        line.extend(options.iter().map(AsRef::<OsStr>::as_ref));
        for spec in &specs {
            line.extend([OsStr::new("--light"), OsStr::new(spec)]);
        }
        rimline(line).expect(0, &[])?;
        *result = read_file(&out)?;
    }
    Ok(results)
}

const NAMES: [&str; 9] =
    ["positions", "faces", "lights", "edges", "edge_faces", "edge_kind", "facing", "silhouette", "winding"];

fn named<'a>(entries: &'a [Entry], name: &str) -> Result<&'a Entry, String> {
    let wanted = format!("{name}.npy");
    entries.iter().find(|entry| entry.name == wanted).ok_or_else(|| format!("there is no {wanted}"))
}

fn entries() -> Outcome {
    let [archive] = extract(&model(1.0), &lights(), [&["--device", "cpu"]])?;
    let entries = read_zip(&archive)?;
    let names: Vec<&str> = entries.iter().map(|entry| entry.name.trim_end_matches(".npy")).collect();
    ensure!(names == NAMES, "the entries are {names:?}");
    for entry in &entries {
        ensure!(entry.method == 0 && entry.time == FIRST_DAY, "{}: not stored, or dated", entry.name);
        ensure!(entry.flags & 0x0009 == 0, "{}: encrypted or sized afterwards", entry.name);
    }
    let edges = named(&entries, "edge_kind")?.bytes.len() - 128;
    // Vertices 8 and 9 lie on 1 and 2: eight are left, in order of their lowest index.
    let positions = words(data(named(&entries, "positions")?, "<f4", "(8, 3)")?);
    let expected: Vec<u32> = POSITIONS[..8].iter().flatten().map(|&c| f32::from(c).to_bits()).collect();
    ensure!(positions == expected, "the positions changed");
    let faces = words(data(named(&entries, "faces")?, "<u4", "(11, 3)")?);
    ensure!(faces[12..18] == [1, 2, 6, 1, 6, 5] && faces[30..] == [1, 1, 2], "the faces are {faces:?}");
    let given: Vec<u32> = lights().iter().flatten().map(|&c| f32::from(c).to_bits()).collect();
    ensure!(words(data(named(&entries, "lights")?, "<f4", "(33, 4)")?) == given, "the lights changed");
    let pairs = format!("({edges}, 2)");
    let edge_faces = words(data(named(&entries, "edge_faces")?, "<u4", &pairs)?);
    let edge_vertices = words(data(named(&entries, "edges")?, "<u4", &pairs)?);
    let kinds = data(named(&entries, "edge_kind")?, "|u1", &format!("({edges},)"))?;
    ensure!(
        edge_faces.iter().filter(|&&face| face == u32::MAX).count() == 4,
        "a box without a lid has four open edges"
    );
    let has = |face: u32, a: u32, b: u32| {
        let face = &faces[3 * face as usize..][..3];
        (0..3).any(|i| face[i] == a && face[(i + 1) % 3] == b)
    };
    for ((edge, of), &kind) in edge_vertices.chunks(2).zip(edge_faces.chunks(2)).zip(kinds) {
        ensure!(has(of[0], edge[0], edge[1]), "face 0 of {edge:?} does not run along it");
        match kind {
            2 => ensure!(of[1] == u32::MAX, "an open edge has a face 1"),
            _ => ensure!(of[0] < of[1] && has(of[1], edge[1], edge[0]), "face 1 of {edge:?} runs along it"),
        }
    }
    for name in ["facing", "silhouette", "winding"] {
        let rows = if name == "facing" { 11 } else { edges };
        let masks = words(data(named(&entries, name)?, "<u4", &format!("({rows}, 2)"))?);
        ensure!(masks.iter().skip(1).step_by(2).all(|word| *word < 2), "{name}: bits beyond the lights are set");
    }
    Ok(())
}

/// Everything again from whole numbers, in exact arithmetic.
fn exact_bits() -> Outcome {
    let [archive] = extract(&model(1.0), &lights(), [&["--device", "gpu"]])?;
    let entries = read_zip(&archive)?;
    let edges = named(&entries, "edge_kind")?.bytes.len() - 128;
    let table = |name: &str, descr: &str, rows: usize, columns: usize| -> Result<Vec<u32>, String> {
        Ok(words(data(named(&entries, name)?, descr, &format!("({rows}, {columns})"))?))
    };
    let faces = table("faces", "<u4", 11, 3)?;
    let facing = table("facing", "<u4", 11, 2)?;
    let silhouette = table("silhouette", "<u4", edges, 2)?;
    let winding = table("winding", "<u4", edges, 2)?;
    let edge_faces = table("edge_faces", "<u4", edges, 2)?;
    let kinds = data(named(&entries, "edge_kind")?, "|u1", &format!("({edges},)"))?;
    for (l, light) in lights().into_iter().enumerate() {
        let bit = |masks: &[u32], row: usize| masks[2 * row + l / 32] >> (l % 32) & 1 == 1;
        let oracle = |face: usize| {
            let [a, b, c] = [0, 1, 2].map(|i| POSITIONS[faces[3 * face + i] as usize].map(i64::from));
            let minus = |p: [i64; 3], q: [i64; 3]| [0, 1, 2].map(|i| p[i] - q[i]);
            let (u, v) = (minus(b, a), minus(c, a));
            let [x, y, z, w] = light.map(i64::from);
            let d = minus([x, y, z], a.map(|c| w * c));
            let cross = [u[1] * v[2] - u[2] * v[1], u[2] * v[0] - u[0] * v[2], u[0] * v[1] - u[1] * v[0]];
            cross.iter().zip(d).map(|(n, d)| n * d).sum::<i64>() > 0
        };
        for face in 0..11 {
            ensure!(bit(&facing, face) == oracle(face), "face {face}, light {l}: wrong side");
        }
        for edge in 0..edges {
            let (f0, f1) = (edge_faces[2 * edge], edge_faces[2 * edge + 1]);
            let expected = kinds[edge] == 2 || oracle(f0 as usize) != oracle(f1 as usize);
            ensure!(bit(&silhouette, edge) == expected, "edge {edge}, light {l}: silhouette");
            ensure!(bit(&winding, edge) == oracle(f0 as usize), "edge {edge}, light {l}: winding");
        }
    }
    Ok(())
}

fn agree() -> Outcome {
    let lights = &lights()[..5];
    let [cpu, gpu, again] =
        extract(&model(0.3), lights, [&["--device", "cpu"], &["--device", "gpu"], &["--device", "gpu"]])?;
    compare(&cpu, &gpu)?;
    compare(&gpu, &again)?;
    let [kept] = extract(&cpu, lights, [&["--device", "gpu", "--no-weld"]])?;
    compare(&cpu, &kept)?;
    let [unwelded] = extract(&model(0.3), lights, [&["--device", "cpu", "--no-weld"]])?;
    ensure!(compare(&cpu, &unwelded).is_err(), "--no-weld changed nothing");
    Ok(())
}

fn non_finite() -> Outcome {
    let folder = folder();
    let (file, out) = (folder.path().join("m.npz"), folder.path().join("o.npz"));
    let mut positions: Vec<u8> = POSITIONS.iter().flatten().flat_map(|&c| f32::from(c).to_le_bytes()).collect();
    positions[4 * 12..][..4].copy_from_slice(&f32::NAN.to_le_bytes());
    let bytes = write_zip(&[
        array("positions", "<f4", "False", "(10, 3)", &positions),
        array("faces", "|u1", "False", "(11, 3)", FACES.as_flattened()),
    ]);
    write_file(&file, bytes)?;
    for device in ["cpu", "gpu"] {
        let line = ["extract", "--light", "dir:0,0,1", "--light", "point:9,9,9", "--json", "--device", device, "--out"];
        let mut line: Vec<&OsStr> = line.iter().map(AsRef::as_ref).collect();
        line.extend([out.as_os_str(), file.as_os_str()]);
        let json = rimline(line).json()?;
        // Vertex 4 has three faces.
        ensure!(json["non_finite_faces"] == 2 || json["non_finite_faces"] == 3, "{device}: {json}");
        ensure!(json["unclosed_vertices"] == serde_json::json!([0, 0]), "{device}: {json}");
        let entries = read_zip(&read_file(&out)?)?;
        let facing = words(data(named(&entries, "facing")?, "<u4", "(11, 1)")?);
        let touching = FACES.iter().enumerate().filter(|(_, face)| face.contains(&4));
        for (face, _) in touching {
            ensure!(facing[face] == 0, "{device}: face {face} faces a light");
        }
    }
    Ok(())
}

fn displaced() -> Outcome {
    let folder = folder();
    let wgsl = folder.path().join("shift.wgsl");
    let source = "fn displace(position: vec3<f32>, vertex: u32, time: f32) -> vec3<f32> {\n  \
                  return position + vec3<f32>(time, f32(vertex), 0.0);\n}\n";
    write_file(&wgsl, source)?;
    let path = wgsl.to_string_lossy().into_owned();
    let options: &[&str] = &["--device", "gpu", "--displace", &path, "--time", "2"];
    let [archive] = extract(&model(1.0), &lights()[..1], [options])?;
    let entries = read_zip(&archive)?;
    let positions = words(data(named(&entries, "positions")?, "<f4", "(8, 3)")?);
    for (vertex, (found, p)) in positions.chunks(3).zip(&POSITIONS).enumerate() {
        let expected = [f32::from(p[0]) + 2.0, f32::from(p[1]) + vertex as f32, f32::from(p[2])];
        ensure!(found == expected.map(f32::to_bits), "vertex {vertex} is elsewhere");
    }
    // An error in the WGSL is reported with its own line.
    write_file(&wgsl, source.replace("time,", "tyme,"))?;
    let model_file = folder.path().join("m.npz");
    write_file(&model_file, model(1.0))?;
    let (file, out) = (model_file.to_string_lossy(), folder.path().join("o.npz"));
    let line = ["extract", &file, "--light", "dir:0,1,0", "--displace", &path, "--out", &out.to_string_lossy()];
    rimline(line).expect(1, &["shift.wgsl", "line 2", "tyme"])?;
    ensure!(!out.exists(), "a result in spite of the error");
    Ok(())
}

fn per_edge() -> Outcome {
    for device in ["cpu", "gpu"] {
        for predicate in ["fast", "plane"] {
            let per_edge = ["--device", device, "--method", "per-edge", "--predicate", predicate];
            let options: [&[&str]; 2] = [&["--device", device], &per_edge];
            let [faces, edges] = extract(&model(1.0), &lights(), options)?;
            let (faces, edges) = (read_zip(&faces)?, read_zip(&edges)?);
            ensure!(named(&faces, "facing")? == named(&edges, "facing")?, "{device}: the face bits differ");
            ensure!(edges.len() == NAMES.len(), "{device}: entries are missing");
        }
    }
    Ok(())
}
