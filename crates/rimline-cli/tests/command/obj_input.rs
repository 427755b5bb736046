//! Wavefront OBJ files, good and bad.

use std::ffi::OsString;

use rimline_testkit::random::Random;
use serde_json::json;

use super::npz_polygons::words;
use super::run::{Run, folder, is_empty, read_file, rimline, write_file};
use super::{Outcome, Test, ensure};

pub(crate) const TESTS: &[Test] = &[
    ("obj_input::every_way_to_write_a_model_reads_alike", ways),
    ("obj_input::polygons_stay_whole_if_asked", polygons),
    ("obj_input::info_says_how_lights_see_polygons", seen),
    ("obj_input::gpu_and_cpu_extract_polygons_alike", on_gpu),
    ("obj_input::triangles_are_a_plain_mesh", triangles),
    ("obj_input::bad_files_are_named_by_line", bad),
    ("obj_input::what_takes_more_than_the_limit_is_refused", limits),
    ("obj_input::mutated_files_never_panic", mutated),
];

/// A cube of quadrilaterals.
const CUBE: &str = "\
v 0 0 0\nv 1 0 0\nv 1 1 0\nv 0 1 0\nv 0 0 1\nv 1 0 1\nv 1 1 1\nv 0 1 1\n\
f 1 4 3 2\nf 5 6 7 8\nf 1 2 6 5\nf 2 3 7 6\nf 3 4 8 7\nf 4 1 5 8\n";

/// Extracts from these bytes on the CPU; the result's bytes, too.
fn extract(model: &[u8]) -> Result<(Run, Vec<u8>), String> {
    extract_with(model, &[])
}

fn extract_with(model: &[u8], options: &[&str]) -> Result<(Run, Vec<u8>), String> {
    let folder = folder();
    let at = |name: &str| folder.path().join(name).into_os_string();
    write_file(at("model.obj"), model)?;
    let words = ["extract", "--device", "cpu", "--light", "point:2,3,4", "--light", "dir:-1,-2e-1,.5", "--out"];
    let options = options.iter().map(OsString::from);
    let run = rimline(words.map(OsString::from).into_iter().chain([at("out.npz"), at("model.obj")]).chain(options));
    let result = std::fs::read(at("out.npz")).unwrap_or_default();
    std::fs::remove_file(at("model.obj")).map_err(|error| error.to_string())?;
    if run.code != 0 {
        is_empty(folder.path())?;
    }
    Ok((run, result))
}

/// A square, a bow tie as seen from above, a triangle, and a square that stands on end.
const SEEN: &str = "\
v 0 0 0\nv 1 0 0\nv 1 1 0\nv 0 1 0\nf 1 2 3 4\n\
v 3 0 0\nv 4 1 .1\nv 4 0 .2\nv 3 1 -.2\nf 5 6 7 8\n\
v 6 0 0\nv 7 0 0\nv 6 1 0\nf 9 10 11\n\
v 8 0 0\nv 9 0 0\nv 9 0 1\nv 8 0 1\nf 12 13 14 15\n";

fn seen() -> Outcome {
    let folder = folder();
    let file = folder.path().join("model.obj");
    write_file(&file, SEEN)?;
    let words = ["info", "--json", "--light", "dir:0,0,1", "--light", "dir:0,0,-1"];
    let info = rimline(words.map(OsString::from).into_iter().chain([file.into_os_string()])).json()?;
    let above = json!({ "facing": 2, "averted": 0, "in_plane": 1, "twisted": 1 });
    let below = json!({ "facing": 0, "averted": 2, "in_plane": 1, "twisted": 1 });
    let expected = json!({
        "triangles": 1, "quadrilaterals": 3, "larger": 0, "most_corners": 4, "with_holes": 0, "nonplanar": 1,
        "non_finite": 0, "seen": [above, below],
    });
    ensure!(info["polygons"] == expected, "{}", info["polygons"]);
    ensure!(info["placed"]["faces"] == 7, "triangles: {}", info["placed"]);
    let whole =
        words.map(OsString::from).into_iter().chain(["--polygons".into(), folder.path().join("model.obj").into()]);
    let whole = rimline(whole).json()?;
    ensure!(whole["polygons"] == expected && whole["placed"]["faces"] == 4, "{}", whole["placed"]);
    Ok(())
}

/// Not only these: the archives are equal byte for byte.
fn on_gpu() -> Outcome {
    let folder = folder();
    let at = |name: &str| folder.path().join(name).into_os_string();
    let cases = [CUBE, SEEN].into_iter().flat_map(|model| [(model, None), (model, Some("--polygons".into()))]);
    for (number, (model, option)) in cases.enumerate() {
        write_file(at("model.obj"), model)?;
        let found = ["cpu", "gpu"].map(|device| {
            let out = at(&format!("{device}{number}.npz"));
            let words = ["extract", "--device", device, "--light", "point:2,3,4", "--light", "dir:0,0,1", "--out"];
            let words = words.map(OsString::from).into_iter().chain([out.clone(), at("model.obj")]);
            rimline(words.chain(option.clone())).expect(0, &[])?;
            read_file(out)
        });
        let [cpu, gpu] = found;
        ensure!(cpu? == gpu?, "model {number}");
    }
    Ok(())
}

fn ways() -> Outcome {
    let (run, expected) = extract(CUBE.as_bytes())?;
    run.expect(0, &[])?;
    let vertices = CUBE.lines().filter(|line| line.starts_with('v'));
    let faces = || CUBE.lines().filter(|line| line.starts_with('f'));
    let corners = |to: fn(i32) -> String| -> String {
        let line =
            |line: &str| line[2..].split(' ').map(|word| to(word.parse().unwrap_or(0))).collect::<Vec<_>>().join(" ");
        faces().map(|face| format!("f {}\n", line(face))).collect::<Vec<_>>().concat()
    };
    let head: String = vertices.clone().map(|line| format!("{line}\n")).collect::<Vec<_>>().concat();
    let weighted: String = vertices.clone().map(|line| format!("{line} 2.5\n")).collect::<Vec<_>>().concat();
    let coloured: String = vertices
        .clone()
        .enumerate()
        .map(|(i, line)| format!("{line}{}\n", [" 1 0 .5", ""][i % 2]))
        .collect::<Vec<_>>()
        .concat();
    let mut latin = b"# caf\xe9 C:\\models\\\no \xfc # x\n".to_vec();
    latin.extend(CUBE.bytes());
    let cases: [(&str, Vec<u8>); 18] = [
        ("CRLF", CUBE.replace('\n', "\r\n").into()),
        ("CR", CUBE.replace('\n', "\r").into()),
        ("CR CR LF, continued", CUBE.replace("4 3 2", "4 \\\n3 2").replace('\n', "\r\r\n").into()),
        ("CR, continued, and all ends mixed", CUBE.replace("4 3 2", "4 \\\r3 2").replacen('\n', "\r", 5).into()),
        ("a mark of the byte order", format!("\u{feff}{CUBE}").into()),
        ("no last line end", CUBE.trim_end().into()),
        ("tabs and spaces", CUBE.replace(' ', " \t ").replace('f', "  f").into()),
        ("continued lines", CUBE.replace("4 3 2", "4 \\\n3\\\r\n 2").into()),
        ("comments", CUBE.replace('\n', " # v 1 2\n").into()),
        ("Latin-1", latin),
        ("texture coordinates", format!("{head}vt 0 0\n{}", corners(|v| format!("{v}/1"))).into()),
        ("normals", format!("{head}vn 0 0 1\n{}", corners(|v| format!("{v}//1"))).into()),
        ("both, backwards", format!("{head}{}", corners(|v| format!("{}/-1/-1", v - 9))).into()),
        ("faces first", format!("{}{head}", corners(|v| v.to_string())).into()),
        ("weights", format!("{weighted}{}", corners(|v| v.to_string())).into()),
        ("colours of some", format!("{coloured}{}", corners(|v| v.to_string())).into()),
        ("groups and materials", CUBE.replace("f ", "mtllib a.mtl\ng a b\ns off\nusemtl\no\nf ").into()),
        ("lines and points", format!("{CUBE}l 1 2 3 4\np 1 2\nl 99 98\nvp 1\n").into()),
    ];
    for (name, model) in cases {
        let (run, found) = extract(&model)?;
        run.expect(0, &[]).map_err(|error| format!("{name}: {error}"))?;
        ensure!(found == expected, "{name}: another archive");
    }
    // A position or a face that differs is seen.
    for other in [CUBE.replace("v 1 1 1", "v 1 1 1.5"), CUBE.replace("f 4 1 5 8", "f 4 1 5")] {
        ensure!(extract(other.as_bytes())?.1 != expected, "the same archive");
    }
    Ok(())
}

fn polygons() -> Outcome {
    let (run, out) = extract_with(format!("{CUBE}f 1 2 3 4 5\n").as_bytes(), &["--polygons"])?;
    run.expect(0, &[])?;
    ensure!(words(&out, "loop_sizes")? == [4, 4, 4, 4, 4, 4, 5], "corners of polygons");
    ensure!(words(&out, "loop_corners")?[..4] == [0, 3, 2, 1], "corners as written");
    let (_, out) = extract_with(CUBE.as_bytes(), &["--polygons"])?;
    ensure!(words(&out, "edges")?.len() == 2 * 12, "no diagonals among the edge records");
    let (_, out) = extract(CUBE.as_bytes())?;
    ensure!(words(&out, "edges")?.len() == 2 * 18 && words(&out, "faces")?.len() == 3 * 12, "triangles by default");
    ensure!(words(&out, "loop_sizes").is_err(), "polygons without being asked");
    let folder = folder();
    let at = |name: &str| folder.path().join(name).into_os_string();
    write_file(at("cube.obj"), CUBE)?;
    rimline([OsString::from("info"), at("cube.obj")]).expect(0, &[])
}

fn triangles() -> Outcome {
    let tetrahedron = "v 0 0 0\nv 1 0 0\nv 0 1 0\nv 0 0 1\nf 1 3 2\nf 1 2 4\nf 2 3 4\nf 3 1 4\n";
    let (run, out) = extract(tetrahedron.as_bytes())?;
    run.expect(0, &[])?;
    let (_, same) = super::npz_input::extract(&super::npz_input::tetrahedron())?;
    ensure!(out == same, "another archive than that of the same triangles");
    ensure!(words(&out, "loop_sizes").is_err(), "no polygons");
    Ok(())
}

fn bad() -> Outcome {
    let four = "v 0 0 0\nv 1 0 0\nv 1 1 0\nv 0 1 0\n";
    let cases = [
        ("v 0 0\nf 1 1 1\n".to_owned(), "line 1: the vertex has 2 coordinates"),
        ("v 0 0 zero\n".to_owned(), "line 1: \"zero\" is no number"),
        ("v 0 0 0 red\n".to_owned(), "line 1: \"red\" is no number"),
        (four.replace('\n', "\r"), "it has no faces"),
        (format!("{four}\rf 1 2\r\r\nf 1 2 3\r").replace('\n', "\r"), "line 6: the face has 2 corners"),
        (format!("{four}f 1 2 3\ncall rest.obj 1\n"), "line 6: `call` stands for the lines of another file"),
        (format!("{four}csh -touch x\nf 1 2 3\n"), "line 5: `csh` asks to run a program"),
        (format!("{four}f 1 2\n"), "line 5: the face has 2 corners"),
        (format!("{four}\\\n\nf\n"), "line 7: the face has 0 corners"),
        (format!("{four}f 1 2 3 5\nf 1 2 3\n"), "line 5: a face names vertex 5, but there are 4 vertices"),
        (format!("{four}f 1 2 3 0\n"), "line 5: a face names vertex 0"),
        (format!("{four}f 1 2 -5\n"), "line 5: a face names vertex -5"),
        (format!("{four}f 1 2 {}\n", i64::MIN), "line 5: a face names vertex -9223372036854775808"),
        (format!("{four}f 1 2 {}\n", i64::MAX), "line 5: a face names vertex 9223372036854775807"),
        (format!("{four}f 1 2 4294967297\n"), "line 5: a face names vertex 4294967297"),
        (format!("{four}f 1 2 9223372036854775808\n"), "line 5: \"9223372036854775808\" is no corner"),
        (format!("{four}f 1 2 3/x\n"), "line 5: \"3/x\" is no corner"),
        (format!("{four}f 1 2 3/1/1/1\n"), "line 5: \"3/1/1/1\" is no corner"),
        (format!("{four}f 1 2 {}\n", "é".repeat(99)), "line 5: \"é"),
        (format!("{four}f 1 2 3\nsurf 0 1 0 1 1 2\n"), "line 6: `surf` is part of a curved surface"),
        (four.to_owned(), "it has no faces"),
        ("\0\u{1}\n\u{7f}".to_owned(), "it has no faces"),
    ];
    for (model, message) in cases {
        let (run, _) = extract(model.as_bytes())?;
        run.expect(1, &["model.obj: ", message]).map_err(|error| format!("{message}: {error}"))?;
        ensure!(run.stderr.len() < 500, "a message of {} bytes", run.stderr.len());
    }
    Ok(())
}

/// Many vertices, one face of many corners, and one line without an end.
fn limits() -> Outcome {
    let folder = folder();
    let at = |name: &str| folder.path().join(name).into_os_string();
    let triangle = "v 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 3\n";
    for (name, model, is_kept) in [
        ("vertices.obj", format!("{triangle}{}", "v 0 0 0\n".repeat(60_000)), true),
        ("corners.obj", format!("{triangle}f{}\n", " 1 2 3".repeat(6000)), true),
        ("long.obj", format!("{triangle}# {}", "x".repeat(3_000_000)), true),
        ("continued.obj", format!("{triangle}o {}", "\\\n".repeat(1_500_000)), true),
        ("small.obj", triangle.to_owned(), false),
    ] {
        write_file(at(name), model)?;
        let info = |limit: &str| rimline([OsString::from("info"), at(name), "--memory-limit".into(), limit.into()]);
        info("32MiB").expect(0, &[]).map_err(|error| format!("{name}: {error}"))?;
        if is_kept {
            info("1MiB").expect(1, &[name, "line ", "--memory-limit"])?;
        } else {
            info("1MiB").expect(0, &[])?;
        }
    }
    Ok(())
}

fn mutated() -> Outcome {
    const SEED: u64 = 15;
    let mut random = Random::new(SEED);
    for case in 0..60 {
        let mut model = CUBE.as_bytes().to_vec();
        for _ in 0..=random.below(6) {
            let at = random.below(model.len());
            model[at] = *b"0 9-/\\\n.fvex#\xff".get(random.below(14)).unwrap_or(&0);
        }
        let (run, _) = extract(&model)?;
        ensure!(run.code == 0 || run.code == 1, "seed {SEED}, case {case}: exit code {}: {}", run.code, run.stderr);
    }
    Ok(())
}
