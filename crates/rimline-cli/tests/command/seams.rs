//! Seams that rounding leaves open: what `info` says of them, the distance that closes them, what is drawn. T-junctions.

use std::fmt::Write as _;
use std::path::Path;

use rimline_testkit::random::Random;
use serde_json::Value;

use super::models_of_code::{PROFILES, lathe};
use super::pictures::{is_ink, is_orange};
use super::run::{folder, on_cases, run, write_file};
use super::{Outcome, Test, ensure};

pub(crate) const TESTS: &[Test] = &[
    ("seams::bodies_of_revolution_are_closed_by_the_distance_that_is_named", revolved),
    ("seams::t_junctions_are_those_of_the_definition", t_junctions),
];

/// The same on the shared cases.
pub(crate) fn trials() -> Vec<libtest_mimic::Trial> {
    let is_closed = |file: &Path| closes(file, &file.to_string_lossy(), true);
    on_cases(&[("seams::cases", "h_torus.glb", is_closed, true), ("seams::cases", "h_cylinder.glb", is_closed, false)])
}

/// An open model that `info` names a distance for, is closed by it, and is drawn without a seam in any case.
fn closes(model: &Path, name: &str, is_drawn: bool) -> Outcome {
    let folder = folder();
    let copy = format!("m.{}", model.extension().and_then(|ending| ending.to_str()).unwrap_or_default());
    std::fs::copy(model, folder.path().join(&copy)).map_err(|error| error.to_string())?;
    let info = |options: &str| folder.run(&format!("info @{copy} {options} --json")).json();
    let open = info("")?;
    let seams = &open["meshes"][0]["near_boundary"];
    ensure!(open["placed"]["closed"] == false && seams["edges"].as_u64() > Some(0), "{name}: {}", open["meshes"]);
    ensure!(seams["closes"] == seams["edges"], "{name}: {seams}");
    let distance = seams["weld_distance"].as_f64().ok_or_else(|| format!("{name}: {seams}"))?;
    let gap = seams["gap"].as_f64().ok_or_else(|| format!("{name}: {seams}"))?;
    ensure!(gap > 0.0 && gap <= distance, "{name}: {seams}");
    let text = folder.run(&format!("info @{copy}"));
    let said = format!("boundary edges lie within {gap:.0e} of each other: ");
    ensure!(text.stdout.contains(&said), "{name}: no `{said}` in {}", text.stdout);
    let weld = format!("--weld-distance {distance:e}");
    ensure!(text.stdout.contains(&format!("{weld} closes them")), "{name}: {}", text.stdout);
    let closed = info(&weld)?;
    ensure!(closed["placed"]["closed"] == true, "{name}: {}", closed["placed"]);
    let closed = &closed["meshes"][0];
    ensure!(closed["near_boundary"].is_null(), "{name}: {closed}");
    let [before, after] = [&open["meshes"][0], closed].map(|mesh| mesh["degenerate_faces"].as_u64());
    let collapsed = after.zip(before).map(|(after, before)| after - before);
    ensure!(collapsed == seams["collapses"].as_u64(), "{name}: {collapsed:?} faces collapse, {seams}");
    let drawn = [("", false), ("--show-boundary", true), (&format!("{weld} --show-boundary"), false)];
    for (options, has_orange) in drawn.into_iter().filter(|_| is_drawn) {
        folder.run(&format!("draw @{copy} {options} --size 200x150 --out @p.png")).expect(0, &[])?;
        let image = folder.image("p.png")?;
        let orange = image.count_pixels(is_orange)?;
        ensure!(
            (orange > 20) == has_orange && (orange == 0) != has_orange,
            "{name}, {options}: {orange} orange pixels"
        );
        ensure!(image.count_pixels(is_ink)? > 60, "{name}, {options}: no outline");
    }
    Ok(())
}

fn revolved() -> Outcome {
    let folder = folder();
    let file = folder.path().join("lathe.obj");
    for (number, profile) in PROFILES.into_iter().enumerate() {
        for (kind, (steps, size)) in [(12, 1.0), (96, 1.0), (32, 1000.0), (32, 0.001)].into_iter().enumerate() {
            write_file(&file, lathe(profile, steps, size))?;
            let name = format!("{} rings, {steps} steps, size {size}", profile.len());
            closes(&file, &name, kind == number + usize::from(number > 0))?;
        }
    }
    Ok(())
}

fn count(folder: &Path, text: &str) -> Result<Value, String> {
    write_file(folder.join("t.obj"), text)?;
    Ok(run(folder, "info @t.obj --json").json()?["placed"]["t_junctions"].clone())
}

/// Triangles on a small lattice, all whose edges are boundaries, held against whole numbers.
fn t_junctions() -> Outcome {
    let folder = folder();
    let seed = 32;
    let mut random = Random::new(seed);
    let mut counts = [0; 2];
    for round in 0..40 {
        let side = 3 + round % 4;
        let mut edges = std::collections::BTreeSet::new();
        let mut text = String::new();
        for _ in 0..2 + 2 * round {
            let corners: [[i32; 3]; 3] = std::array::from_fn(|_| std::array::from_fn(|_| random.below(side) as i32));
            let [a, b, c] = corners;
            let sides = [[a, b], [b, c], [c, a]].map(|[p, q]| [p.min(q), p.max(q)]);
            if cross(a, b, c) == [0; 3] || sides.iter().any(|side| edges.contains(side)) {
                continue;
            }
            edges.extend(sides);
            for [x, y, z] in corners {
                let _ = writeln!(text, "v {x} {y} {z}");
            }
            text += "f -3 -2 -1\n";
        }
        let points: std::collections::BTreeSet<[i32; 3]> = edges.iter().flatten().copied().collect();
        let is_between = |p: [i32; 3], [a, b]: [[i32; 3]; 2]| {
            let along = |q: [i32; 3]| (0..3).map(|c| (q[c] - a[c]) * (b[c] - a[c])).sum::<i32>();
            cross(a, b, p) == [0; 3] && along(p) > 0 && along(p) < along(b)
        };
        let right = points.iter().filter(|p| edges.iter().any(|edge| is_between(**p, *edge))).count();
        let found = count(folder.path(), &text)?;
        ensure!(found == right, "seed {seed}, round {round}: {found} instead of {right}:\n{text}");
        counts[usize::from(right == 0)] += 1;
    }
    ensure!(counts[0] > 20, "hardly any junctions: {counts:?}");
    Ok(())
}

fn cross(a: [i32; 3], b: [i32; 3], c: [i32; 3]) -> [i32; 3] {
    let [u, v] = [b, c].map(|q| [0, 1, 2].map(|axis| q[axis] - a[axis]));
    [u[1] * v[2] - u[2] * v[1], u[2] * v[0] - u[0] * v[2], u[0] * v[1] - u[1] * v[0]]
}
