//! Parts of a glTF that are asked for by name, by number or all together, and parts that are damaged.

use std::path::{Path, PathBuf};

use rimline_cli::npz;
use serde_json::{Value, json};

use super::own_gltf::{self, Names};
use super::run::{Run, folder, rimline, write_file};
use super::{Outcome, Test, ensure};

pub(crate) const TESTS: &[Test] = &[
    ("parts::a_missing_animation_lists_what_is_there", missing_animation),
    ("parts::animations_play_together", together),
    ("parts::a_film_lasts_as_long_as_the_longest", film),
    ("parts::lights_without_names_have_numbers", light_numbers),
    ("parts::a_damaged_animation_is_refused_once_it_is_asked_for", damaged_animation),
    ("parts::a_damaged_light_is_refused_once_it_is_asked_for", damaged_light),
    ("parts::warnings_are_marked", warnings),
    ("parts::hidden_nodes_are_not_drawn", hidden),
    ("parts::positions_that_are_not_finite", not_finite),
];

/// Writes the tests' own glTF after a change.
fn write(folder: &Path, change: impl FnOnce(&mut Value)) -> Result<PathBuf, String> {
    let file = own_gltf::write(folder, &Names::default())?;
    let mut value = own_gltf::value(&Names::default());
    change(&mut value);
    write_file(&file, value.to_string())?;
    Ok(file)
}

/// Adds to a list.
fn add(list: &mut Value, item: &Value) {
    list.as_array_mut().into_iter().for_each(|list| list.push(item.clone()));
}

/// Two bodies; the first animation moves the first of them for a second, the second has one key for the other.
fn two_bodies(value: &mut Value) {
    add(&mut value["nodes"], &json!({ "mesh": 0, "translation": [0, 5, 0] }));
    value["scenes"][0]["nodes"] = json!([0, 1, 2]);
    value["animations"][0]["name"] = Value::Null;
    if let Some(animation) = value["animations"][0].as_object_mut() {
        animation.remove("name");
    }
    let accessor = |view: usize, offset: usize, kind: &str| json!({ "bufferView": view, "byteOffset": offset, "componentType": 5126, "count": 1, "type": kind });
    add(&mut value["accessors"], &accessor(2, 0, "SCALAR"));
    add(&mut value["accessors"], &accessor(3, 12, "VEC3"));
    let target = json!({ "node": 2, "path": "translation" });
    let (samplers, channels) = (json!([{ "input": 4, "output": 5 }]), json!([{ "sampler": 0, "target": target }]));
    add(&mut value["animations"], &json!({ "name": "hop", "samplers": samplers, "channels": channels }));
}

fn run(command: &str, file: &Path, options: &str, out: Option<&Path>) -> Run {
    let mut line = vec![command.into(), file.as_os_str().to_owned()];
    line.extend(options.split_whitespace().map(Into::into));
    if let Some(out) = out {
        line.extend(["--out".into(), out.as_os_str().to_owned()]);
    }
    rimline(line)
}

fn extract(file: &Path, options: &str) -> Run {
    let out = file.with_extension("npz");
    run("extract", file, &format!("--light dir:0,1,0 --device cpu {options}"), Some(&out))
}

/// The first vertex of both bodies.
fn places(file: &Path, options: &str) -> Result<[[f32; 3]; 2], String> {
    extract(file, options).expect(0, &[])?;
    let text = |error: &dyn std::fmt::Display| error.to_string();
    let archive = std::fs::File::open(file.with_extension("npz")).map_err(|error| text(&error))?;
    let arrays = npz::read(archive, 1 << 30).map_err(|error| text(&error))?;
    match arrays.positions[..] {
        [first, _, _, _, second, ..] => Ok([first, second]),
        _ => Err(format!("{} positions", arrays.positions.len())),
    }
}

fn missing_animation() -> Outcome {
    let folder = folder();
    let file = write(folder.path(), two_bodies)?;
    let there = "the file has 2 animations: 0 (without a name), 1 `hop`";
    extract(&file, "--animation Nope").expect(2, &["there is no animation `Nope`", there])?;
    extract(&file, "--animation hop --animation 2").expect(2, &["no animation `2`", there])?;
    let still = write(folder.path(), |value| value["animations"] = json!([]))?;
    extract(&still, "--animation all").expect(2, &["no animation `all`", "the file has none"])
}

fn together() -> Outcome {
    let folder = folder();
    let file = write(folder.path(), two_bodies)?;
    for (options, expected) in [
        ("", [[0.0, 0.0, 0.0], [0.0, 5.0, 0.0]]),
        ("--animation 0", [[0.5, 0.0, 0.0], [0.0, 5.0, 0.0]]),
        ("--animation hop", [[0.0, 0.0, 0.0], [1.0, 0.0, 0.0]]),
        ("--animation 0 --animation hop", [[0.5, 0.0, 0.0], [1.0, 0.0, 0.0]]),
        ("--animation all", [[0.5, 0.0, 0.0], [1.0, 0.0, 0.0]]),
    ] {
        let found = places(&file, &format!("{options} --time 0.5"))?;
        ensure!(found == expected, "{options}: {found:?}");
    }
    // Both move the same node.
    let file = write(folder.path(), |value| {
        two_bodies(value);
        value["animations"][1]["channels"][0]["target"]["node"] = json!(0);
    })?;
    let message = ["body.gltf", "animations 0 and 1 both move the translation of nodes[0]", "leave one of them out"];
    extract(&file, "--animation all").expect(2, &message)?;
    let out = folder.path().join("out.png");
    for command in ["draw", "shadow"] {
        run(command, &file, "--size 32x24 --animation all", Some(&out)).expect(2, &message)?;
    }
    extract(&file, "--animation 1 --animation 1").expect(0, &[])
}

fn film() -> Outcome {
    let folder = folder();
    let file = write(folder.path(), two_bodies)?;
    for (options, frames) in [("--animation hop", 1), ("--animation all", 4), ("--animation hop --animation 0", 4)] {
        let out = folder.path().join(options.replace(' ', ""));
        run("film", &file, &format!("--size 32x24 --fps 4 {options}"), Some(&out)).expect(0, &[])?;
        let found = std::fs::read_dir(&out).map_err(|error| error.to_string())?.count();
        ensure!(found == frames, "{options}: {found} pictures");
    }
    Ok(())
}

fn light_numbers() -> Outcome {
    let folder = folder();
    let file = write(folder.path(), |value| {
        value["extensions"]["KHR_lights_punctual"]["lights"] =
            json!([{ "type": "point" }, { "type": "directional", "name": "sun" }]);
        add(&mut value["nodes"], &json!({ "extensions": { "KHR_lights_punctual": { "light": 1 } } }));
        value["scenes"][0]["nodes"] = json!([0, 1, 2]);
    })?;
    let light =
        |spec: &str| run("extract", &file, &format!("--device cpu --light {spec}"), Some(&folder.path().join("o.npz")));
    for spec in ["file:0", "file:1", "file:sun", "file:all"] {
        light(spec).expect(0, &[])?;
    }
    let there = "it has 2 lights: 0 (without a name), 1 `sun`";
    for spec in ["file:moon", "file:2", "file:-1"] {
        light(spec).expect(2, &["the file has no light", there])?;
    }
    Ok(())
}

fn damaged_animation() -> Outcome {
    let folder = folder();
    let file = write(folder.path(), |value| {
        two_bodies(value);
        value["nodes"][2]["matrix"] = json!([1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1, 0, 0, 5, 0, 1]);
    })?;
    let says = ["rimline: warning: ", "animations[1].channels[0] moves nodes[2], which has a matrix"];
    extract(&file, "").expect(0, &says)?;
    extract(&file, "--animation 0").expect(0, &says)?;
    for options in ["--animation hop", "--animation all", "--animation 1"] {
        extract(&file, options).expect(1, &["rimline: error: ", "animation 1 cannot be played", "has a matrix"])?;
    }
    let info = rimline(["info".as_ref(), file.as_os_str()]);
    info.expect(0, &says)?;
    ensure!(info.stdout.contains("\"hop\", damaged"), "{}", info.stdout);
    let value = rimline(["info".as_ref(), "--json".as_ref(), file.as_os_str()]).json()?;
    ensure!(value["warnings"].as_array().map(Vec::len) == Some(1), "{}", value["warnings"]);
    // A film takes the first animation that can be played.
    let film = folder.path().join("film");
    run("film", &file, "--size 32x24 --frames 1", Some(&film)).expect(0, &["using animation 0"])
}

fn damaged_light() -> Outcome {
    let folder = folder();
    let file = write(folder.path(), |value| {
        value["extensions"]["KHR_lights_punctual"]["lights"] =
            json!([{ "type": "area", "name": "panel" }, { "type": "point", "name": "lamp" }]);
        add(&mut value["nodes"], &json!({ "extensions": { "KHR_lights_punctual": { "light": 1 } } }));
        value["scenes"][0]["nodes"] = json!([0, 1, 2]);
    })?;
    let light =
        |spec: &str| run("extract", &file, &format!("--device cpu --light {spec}"), Some(&folder.path().join("o.npz")));
    for spec in ["dir:0,1,0", "file:lamp", "file:1"] {
        light(spec).expect(0, &["rimline: warning: ", "lights[0].type"])?;
    }
    for spec in ["file:panel", "file:0", "file:all"] {
        light(spec).expect(1, &["rimline: error: ", "the light of nodes[1] cannot be used", "lights[0].type"])?;
    }
    let value = rimline(["info".as_ref(), "--json".as_ref(), file.as_os_str()]).json()?;
    ensure!(value["lights"][0] == json!({ "name": "panel", "kind": null, "xyzw": null }), "{}", value["lights"]);
    Ok(())
}

/// Every line on standard error is the command's own, and every warning says that it is one.
fn warnings() -> Outcome {
    let folder = folder();
    let file = write(folder.path(), |value| {
        value["extensionsUsed"] = json!(["KHR_lights_punctual", "ACME_fold"]);
        add(&mut value["meshes"][0]["primitives"], &json!({ "attributes": { "POSITION": 0 }, "mode": 0 }));
        value["skins"] = json!([{ "joints": [] }]);
        add(&mut value["animations"][0]["channels"], &json!({ "sampler": 0, "target": { "path": "scale" } }));
    })?;
    let run = extract(&file, "--time 2");
    run.expect(
        0,
        &["ACME_fold", "skipped 1 point primitives", "skins[0].joints is missing", "moves nothing", "--time has no"],
    )?;
    let unmarked: Vec<_> = run.stderr.lines().filter(|line| !line.starts_with("rimline: warning: ")).collect();
    ensure!(unmarked.is_empty(), "{unmarked:?}");
    let many = write(folder.path(), |value| {
        let skins: Vec<Value> = (100..150).map(|node| json!({ "joints": [node] })).collect();
        value["skins"] = skins.into();
    })?;
    let run = extract(&many, "");
    run.expect(0, &["30 more warnings"])?;
    ensure!(run.stderr.lines().count() == 21, "{}", run.stderr);
    Ok(())
}

fn hidden() -> Outcome {
    let folder = folder();
    let hide = |value: &mut Value, node: usize| {
        value["nodes"][node]["extensions"]["KHR_node_visibility"] = json!({ "visible": false });
    };
    let file = write(folder.path(), |value| {
        two_bodies(value);
        hide(value, 2);
    })?;
    let info = run("info", &file, "--json", None).json()?;
    ensure!(info["instances"] == 1 && info["hidden_nodes"] == 1 && info["warnings"] == json!([]), "{info}");
    // The lamp is hidden, so there is none.
    let file = write(folder.path(), |value| hide(value, 1))?;
    let out = folder.path().join("o.npz");
    run("extract", &file, "--device cpu --light file:all", Some(&out)).expect(2, &["the file has no lights"])
}

fn not_finite() -> Outcome {
    let folder = folder();
    let file = write(folder.path(), |_| ())?;
    let mut bytes = own_gltf::buffer();
    bytes[36..40].copy_from_slice(&f32::NAN.to_le_bytes());
    folder.write("body.bin", bytes)?;
    let says = ["rimline: warning: ", "1 vertex is infinite or NaN"];
    let run = extract(&file, "");
    run.expect(0, &says)?;
    ensure!(run.stderr.lines().count() == 1, "said more than once: {}", run.stderr);
    for command in ["draw", "shadow"] {
        let out = folder.path().join("p.png");
        super::parts::run(command, &file, "--size 32x24", Some(&out)).expect(0, &says)?;
    }
    rimline(["info".as_ref(), file.as_os_str()]).expect(0, &says)
}
