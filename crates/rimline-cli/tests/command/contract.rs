//! The arrays that `extract` writes, held against the contract entry by entry.

use super::archive::{Entry, FIRST_DAY, data, read_zip, words};
use super::makers::npz_mesh;
use super::run::folder;
use super::{Outcome, Test, ensure};

pub(crate) const TESTS: &[Test] =
    &[("contract::entries_order_time_and_bytes", entries), ("contract::bits_of_33_lights_are_exact", exact_bits)];

/// An open box without a lid, of two halves that meet in doubled vertices, and a triangle that names a vertex twice.
const POSITIONS: [[i8; 3]; 10] =
    [[0, 0, 0], [4, 0, 0], [4, 4, 0], [0, 4, 0], [0, 0, 4], [4, 0, 4], [4, 4, 4], [0, 4, 4], [4, 0, 0], [4, 4, 0]];
const FACES: [[u32; 3]; 11] = [
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

fn model() -> Vec<u8> {
    npz_mesh(&POSITIONS.map(|position| position.map(f32::from)), &FACES)
}

/// The result of an extraction.
fn extract(model: &[u8], device: &str) -> Result<Vec<u8>, String> {
    let folder = folder();
    folder.write("model.npz", model)?;
    let lights: Vec<String> = lights().iter().map(|[x, y, z, w]| format!("--light hom:{x},{y},{z},{w}")).collect();
    folder.run(&format!("extract @model.npz --out @out.npz --device {device} {}", lights.join(" "))).expect(0, &[])?;
    folder.read("out.npz")
}

const NAMES: [&str; 9] =
    ["positions", "faces", "lights", "edges", "edge_faces", "edge_kind", "facing", "silhouette", "winding"];

fn named<'a>(entries: &'a [Entry], name: &str) -> Result<&'a Entry, String> {
    let wanted = format!("{name}.npy");
    entries.iter().find(|entry| entry.name == wanted).ok_or_else(|| format!("there is no {wanted}"))
}

fn entries() -> Outcome {
    let archive = extract(&model(), "cpu")?;
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
    let archive = extract(&model(), "gpu")?;
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
