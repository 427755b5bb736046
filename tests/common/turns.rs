//! The turns of loops, as comments in the WGSL tell them, against the most that a driver allows an entry point.

use rimline::gpu::include_wgsl;
use rimline::internals::stages::{DEFORM, DRAWN, EXACT_FACING, SCENE_EXACT_FACING, STAGES, Stage};
use rimline::internals::turns::{EXACT_ITEMS, scene_exact_items};
use rimline_testkit::turns::{Limits, MOST_TURNS, limits, turns};

use crate::Outcome;

fn check(stage: &Stage, limits: &Limits<'_>) -> Outcome {
    for (entry, turns) in turns(&stage.wgsl(), limits).map_err(|error| format!("{}: {error}", stage.module))? {
        if turns > MOST_TURNS.into() {
            return Err(format!("{}, {entry}: {turns} turns, of which {MOST_TURNS} are allowed", stage.module));
        }
    }
    Ok(())
}

/// No entry point has more. Turns of exact facing in scenes depend on the number of lights.
pub(crate) fn stated() -> Outcome {
    for stage in STAGES.iter().chain(DRAWN) {
        check(stage, &limits(32, EXACT_ITEMS))?;
    }
    for lights in 1..=32 {
        check(&SCENE_EXACT_FACING, &limits(lights, scene_exact_items(lights)))?;
    }
    // Stages whose shares are twice as large, or whose loops have no comments.
    for stage in [EXACT_FACING, DEFORM] {
        let mut twice = limits(32, 2 * EXACT_ITEMS);
        twice.entry("DEFORM_TERMS").and_modify(|terms| *terms *= 2);
        let bare = turns(&stage.wgsl().replace("// Turns: ", "// "), &limits(32, EXACT_ITEMS));
        if check(&stage, &twice).is_ok() || bare.is_ok() {
            return Err(format!("negative control: turns of {} went unnoticed", stage.name));
        }
    }
    Ok(())
}

/// The shaders of pictures with loops, with what they are compiled with. A vertex or a pixel has few turns.
pub(crate) fn of_command() -> Outcome {
    let folder = crate::root().join("crates");
    let read = |file: &str| std::fs::read_to_string(folder.join(file)).map_err(|error| format!("{file}: {error}"));
    let (common, scene) = ("rimline-picture/src/common.wgsl", "rimline-picture/src/scene.wgsl");
    let frame = "rimline-cli/src/draw/frame.wgsl";
    let modules: [&[&str]; 5] = [
        &[common, frame, "rimline-cli/src/draw/screen.wgsl"],
        &[common, frame, "rimline-cli/src/draw/veil.wgsl"],
        &[common, frame, "", "rimline-cli/src/draw/lines.wgsl"],
        &[common, scene, "rimline-picture/src/picture.wgsl"],
        &[common, scene, "", "rimline-picture/src/overlay.wgsl", "rimline-cli/src/shadow/depth_overlay.wgsl"],
    ];
    for files in modules {
        let texts = files.iter().map(|file| if file.is_empty() { Ok(include_wgsl(2)) } else { read(file) });
        let source = texts.collect::<Result<Vec<_>, _>>()?.join("\n");
        for (entry, turns) in turns(&source, &limits(32, EXACT_ITEMS)).map_err(|error| format!("{files:?}: {error}"))? {
            if turns > 1000 {
                return Err(format!("{files:?}: {entry} has {turns} turns"));
            }
        }
    }
    // A compute shader goes over the faces and corners that share a normal.
    let source = [read(common)?, read("rimline-picture/src/normals.wgsl")?].join("\n");
    for (entry, turns) in turns(&source, &limits(32, EXACT_ITEMS))? {
        if turns > MOST_TURNS.into() {
            return Err(format!("{entry}: {turns} turns, of which {MOST_TURNS} are allowed"));
        }
    }
    // Others have no loops.
    let known = [&["rimline-picture/src/normals.wgsl"][..], &modules.concat()].concat();
    let mut left = ["rimline-cli/src", "rimline-picture/src"].map(|name| folder.join(name)).to_vec();
    while let Some(path) = left.pop() {
        if let Ok(entries) = std::fs::read_dir(&path) {
            left.extend(entries.filter_map(|entry| Some(entry.ok()?.path())));
        } else if path.extension().is_some_and(|ending| ending == "wgsl") && !known.iter().any(|of| path.ends_with(of))
        {
            let text = read(&path.to_string_lossy())?;
            if ["for (", "while (", "loop {"].iter().any(|head| text.contains(head)) {
                return Err(format!("{} has loops that are in no module of this test", path.display()));
            }
        }
    }
    Ok(())
}

/// A loop whose turns nothing states, and the cost of a loop in a branch that is not taken.
pub(crate) fn unstated() -> Outcome {
    let source = |comment: &str, head: &str| {
        format!(
            "@group(0) @binding(0) var<storage, read_write> a: array<u32>;\nconst N: u32 = 5u;\n\
             fn inner() {{\n  for (var i = 0u; i < 2u * N; i += 3u) {{ a[i] = 1u; }}\n}}\n\
             @compute @workgroup_size(1) fn main() {{\n  {comment}\n  {head} {{ if (a[0] > 1u) {{ inner(); }} a[0] -= 1u; }}\n}}\n"
        )
    };
    // Four turns of the inner loop and the end, each time, and once more by no lane; and those of the outer one.
    let each = [
        ("", "for (var k = 0; k < 3; k++)", Some(3 * 5 + 1 + 4)),
        ("", "for (var rest = a[2]; rest != 0u; rest &= rest - 1u)", Some(32 * 5 + 1 + 33)),
        ("// Turns: 2 * N.", "while (a[1] > 2u)", Some(10 * 5 + 1 + 11)),
        ("// Turns: 2 * N in all.", "while (a[1] > 2u)", Some(10 * 5 + 1 + 11)),
        ("// Turns: 2 * M.", "while (a[1] > 2u)", None),
        ("", "while (a[1] > 2u)", None),
        ("", "for (var k = 0u; k < a[1]; k++)", None),
    ];
    for (comment, head, expected) in each {
        let found = turns(&source(comment, head), &limits(32, EXACT_ITEMS)).ok().map(|found| found[0].1);
        if found != expected {
            return Err(format!("{comment} {head}: {found:?}, expected {expected:?}"));
        }
    }
    Ok(())
}
