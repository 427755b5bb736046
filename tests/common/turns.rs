//! The turns of loops, as comments in the WGSL tell them, against the bound of each entry point.

use rimline::gpu::include_wgsl;
use rimline::internals::stages::{DEFORM, DRAWN, EXACT_FACING, SCENE_EXACT_FACING, STAGES, Stage};
use rimline::internals::turns::{EXACT_ITEMS, scene_exact_items};
use rimline_testkit::turns::{MOST_TURNS, TURNS, limits, turns};

use crate::Outcome;

/// The turns of the entry points of a stage. Turns of exact facing depend on the number of lights: here the maximum over all
/// numbers.
fn found(stage: &Stage) -> Result<Vec<(String, u64)>, String> {
    let is_scene = *stage == SCENE_EXACT_FACING;
    let lights = if is_scene { 1..=32 } else { 32..=32 };
    let mut most: Vec<(String, u64)> = Vec::new();
    for lights in lights {
        let items = if is_scene { scene_exact_items(lights) } else { EXACT_ITEMS };
        let each = turns(&stage.wgsl(), &limits(lights, items));
        for (at, (name, turns)) in each.map_err(|error| format!("{}: {error}", stage.module))?.into_iter().enumerate() {
            match most.get_mut(at) {
                Some((_, before)) => *before = turns.max(*before),
                None => most.push((name, turns)),
            }
        }
    }
    Ok(most)
}

fn check(table: &[(&str, &str, u32)]) -> Outcome {
    let mut listed: Vec<_> = table.to_vec();
    let mut wrong = Vec::new();
    for stage in STAGES.iter().chain(DRAWN) {
        let module = stage.module;
        let found = match found(stage) {
            Ok(found) => found,
            Err(error) => {
                wrong.push(error);
                continue;
            }
        };
        for (entry, turns) in found {
            let index = listed.iter().position(|(of, name, _)| *of == module && *name == entry);
            let stated = index.map(|index| listed.swap_remove(index).2);
            let fits = stated.map_or(turns == 0, |stated| turns <= stated.into() && stated <= MOST_TURNS);
            if !fits {
                wrong.push(format!("(\"{module}\", \"{entry}\", {turns}), stated {stated:?}"));
            }
        }
    }
    wrong.extend(listed.iter().map(|(module, entry, _)| format!("{module}, {entry}: there is none")));
    if wrong.is_empty() { Ok(()) } else { Err(format!("at most {MOST_TURNS} turns:\n{}", wrong.join("\n"))) }
}

/// Each entry point has a bound below the turns that a driver allows, and its loops have no more.
pub(crate) fn stated() -> Outcome {
    check(TURNS)?;
    let less: Vec<_> =
        TURNS.iter().map(|&(module, entry, turns)| (module, entry, turns.saturating_sub(turns / 2))).collect();
    match check(&less) {
        Ok(()) => Err("negative control: half the turns went unnoticed".to_owned()),
        Err(_) => Ok(()),
    }
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
    let mut left = ["rimline-cli/src", "rimline-picture/src"].map(|name| folder.join(name)).to_vec();
    while let Some(path) = left.pop() {
        if path.is_dir() {
            let entries = std::fs::read_dir(&path).map_err(|error| error.to_string())?;
            left.extend(entries.filter_map(|entry| Some(entry.ok()?.path())));
        } else if path.extension().is_some_and(|ending| ending == "wgsl") {
            let name =
                path.strip_prefix(&folder).map_err(|error| error.to_string())?.to_string_lossy().replace('\\', "/");
            let text = read(&name)?;
            let loops = text
                .lines()
                .any(|line| ["for (", "while (", "loop {"].iter().any(|head| line.trim().starts_with(head)));
            // A compute shader, whose loops go over the faces and corners that share a normal.
            let is_compute = name == "rimline-picture/src/normals.wgsl";
            if loops && !is_compute && !modules.concat().contains(&name.as_str()) {
                return Err(format!("{name} has loops that are in no module of this test"));
            }
        }
    }
    Ok(())
}

/// A loop whose turns nothing states, and the cost of a loop in a branch that is not taken.
pub(crate) fn unstated() -> Outcome {
    let limits = limits(32, EXACT_ITEMS);
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
        let found = turns(&source(comment, head), &limits).ok().map(|found| found[0].1);
        if found != expected {
            return Err(format!("{comment} {head}: {found:?}, expected {expected:?}"));
        }
    }
    // The stages themselves, without their comments.
    for stage in [EXACT_FACING, DEFORM] {
        let bare = stage.wgsl().replace("// Turns: ", "// ");
        if turns(&bare, &limits).is_ok() {
            return Err(format!("{}: loops without a bound went unnoticed", stage.name));
        }
    }
    Ok(())
}
