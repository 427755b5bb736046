//! Small files that once came out wrong. Each kind has tests on models of our own elsewhere, so these run if long trials are
//! wanted, and are listed as ignored otherwise.

use std::collections::BTreeSet;
use std::fmt::Write as _;
use std::path::Path;

use libtest_mimic::Trial;
use rimline_testkit::harness::on_files;
use rimline_testkit::{is_long, shared_cases};

use super::archive::entry;
use super::pictures::apart;
use super::run::{Folder, folder};
use super::{Outcome, ensure};

pub(crate) fn trials() -> Vec<Trial> {
    type Case = (&'static str, fn(&Path) -> Outcome);
    let cases: [Case; 5] = [
        ("m2_screw.obj", screw),
        ("f6b_dup_flipped.glb", twice),
        ("g1_leaky.glb", few_layers),
        ("g3_shade.glb", few_layers),
        ("g7_louvres.glb", many_layers),
    ];
    let trials = cases.into_iter().flat_map(|(file, test)| on_files("cases::", shared_cases(), &[file], test));
    trials.map(|trial| trial.with_ignored_flag(!is_long())).collect()
}

fn copied(file: &Path, name: &str) -> Result<Folder, String> {
    let folder = folder();
    std::fs::copy(file, folder.path().join(name)).map_err(|error| error.to_string())?;
    Ok(folder)
}

/// Pixels that differ by more than rounding.
fn differing(folder: &Folder, files: [&str; 2]) -> Result<usize, String> {
    let [a, b] = files.map(|name| folder.image(name));
    apart([&a?.bytes, &b?.bytes], 3, 24)
}

/// The quadrilaterals look like the same bar of triangles.
fn screw(file: &Path) -> Outcome {
    let folder = copied(file, "quads.obj")?;
    let triangles = file.with_file_name("m2_screw_tri.obj");
    std::fs::copy(triangles, folder.path().join("triangles.obj")).map_err(|error| error.to_string())?;
    let view = "--eye 2.5,3.2,4 --target 0,1.2,0 --fov 40 --size 240x180";
    for name in ["quads", "triangles"] {
        folder.run(&format!("draw @{name}.obj {view} --out @{name}.png")).expect(0, &[])?;
        let shadow = format!("shadow @{name}.obj --light dir:.6,1,.5 {view} --mask @{name}");
        folder.run(&shadow).expect(0, &[])?;
    }
    let count = differing(&folder, ["quads.png", "triangles.png"])?;
    ensure!(count == 0, "{count} pixels of the pictures differ");
    let [quads, triangles] = ["quads.0.png", "triangles.0.png"].map(|name| folder.mask(name));
    let count = apart([&quads?.bytes, &triangles?.bytes], 1, 0)?;
    ensure!(count == 0, "{count} pixels of the masks differ");
    // By the loop rule it is another.
    folder.run(&format!("draw @quads.obj --polygons {view} --out @quads.png")).expect(0, &[])?;
    let count = differing(&folder, ["quads.png", "triangles.png"])?;
    ensure!(count > 100, "the comparison cannot fail: {count} pixels");
    Ok(())
}

/// It looks like the body with one face of each two.
fn twice(file: &Path) -> Outcome {
    let folder = copied(file, "twice.glb")?;
    let placed = &folder.run("info @twice.glb --json").json()?["placed"];
    ensure!(placed["faces"] == 24 && placed["flipped_faces"] == 12, "{placed}");
    folder.run("extract @twice.glb --device cpu --light dir:1,2,3 --out @twice.npz").expect(0, &[])?;
    let archive = folder.read("twice.npz")?;
    let words = |name| -> Result<Vec<u32>, String> {
        let bytes = &entry(&archive, name)?.bytes[128..];
        Ok(bytes.as_chunks().0.iter().map(|word| u32::from_le_bytes(*word)).collect())
    };
    let (positions, faces) = (words("positions")?, words("faces")?);
    let (mut once, mut seen) = (String::new(), BTreeSet::new());
    for corner in positions.as_chunks::<3>().0 {
        let [x, y, z] = corner.map(f32::from_bits);
        let _ = writeln!(once, "v {x} {y} {z}");
    }
    for face in faces.as_chunks::<3>().0 {
        let mut corners = *face;
        corners.sort_unstable();
        if seen.insert(corners) {
            let [a, b, c] = face.map(|v| v + 1);
            let _ = writeln!(once, "f {a} {b} {c}");
        }
    }
    folder.write("once.obj", once)?;
    for command in ["draw", "shadow --light point:3,5,4", "shadow --light dir:.6,1,.5 --method z-fail"] {
        for name in ["twice.glb", "once.obj"] {
            let line = format!("{command} @{name} --eye 4,3,5 --size 200x150 --out @{}.png", &name[..4]);
            folder.run(&line).expect(0, &[])?;
        }
        let count = differing(&folder, ["twic.png", "once.png"])?;
        ensure!(count <= 60, "{command}: {count} pixels differ");
    }
    Ok(())
}

/// Their deepest points are at 1 and 2, for a light anywhere in them.
fn few_layers(file: &Path) -> Outcome {
    let folder = copied(file, "m.glb")?;
    for light in ["point:0,1.2,0", "point:0,2,0", "point:0.1,2.19,0.05"] {
        let found = folder.run(&format!("shadow @m.glb --size 64x48 --light {light} --mask @m --json"));
        let json = found.json()?;
        ensure!(json["may_wrap"] == 0 && !found.stderr.contains("256"), "{light}: {json} {}", found.stderr);
        ensure!(json["count_bound"].as_u64().is_some_and(|bound| bound < 256), "{light}: {json}");
    }
    Ok(())
}

/// More than a stencil counts at once; every method finds the same.
fn many_layers(file: &Path) -> Outcome {
    let folder = copied(file, "m.glb")?;
    let mut masks = Vec::new();
    for method in ["auto", "z-pass", "z-fail"] {
        let line = format!("shadow @m.glb --size 120x90 --light dir:0.05,1,0.02 --method {method} --mask @m --json");
        let found = folder.run(&line);
        let json = found.json()?;
        ensure!(json["may_wrap"] == 0 && !found.stderr.contains("256"), "{method}: {json} {}", found.stderr);
        ensure!(json["count_bound"].as_u64() > Some(255), "{method}: {json}");
        masks.push(folder.mask("m.0.png")?.bytes);
    }
    let dark: usize = masks[0].iter().map(|value| usize::from(*value == 0)).sum();
    ensure!(dark > 300, "{dark} dark pixels");
    for mask in &masks[1..] {
        let count = apart([mask, &masks[0]], 1, 0)?;
        ensure!(count <= 2, "{count} pixels differ");
    }
    Ok(())
}
