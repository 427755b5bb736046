//! `rimline bench`: its files, what they hold, and what Ctrl-C leaves. Nothing here depends on how long anything took.

use std::path::Path;

use serde_json::{Value, json};

use super::run::{Folder, Run, folder, read_file};
use super::schema::validate;
use super::{Outcome, Test, ensure, plot_labels};

pub(crate) const TESTS: &[Test] = &[
    ("bench::report_and_data_are_as_described", report),
    ("bench::a_model_and_lights_of_the_user", user_model),
    ("bench::scenes_of_casters_and_what_is_skipped", scenes),
    ("bench::times_of_depth_maps_are_shown", depth_maps),
    #[cfg(unix)]
    ("bench::ctrl_c_keeps_what_is_done", interrupted),
];

fn read_json(file: impl AsRef<Path>) -> Result<Value, String> {
    serde_json::from_slice(&read_file(file)?).map_err(|error| error.to_string())
}

fn schema() -> Result<Value, String> {
    read_json(Path::new(env!("CARGO_MANIFEST_DIR")).join("../rimline-bench/bench.schema.json"))
}

fn list(value: &Value) -> Vec<Value> {
    value.as_array().cloned().unwrap_or_default()
}

/// The rows of a section.
fn rows(data: &Value, section: &str) -> Vec<Value> {
    list(&data["rows"]).into_iter().filter(|row| row["section"] == section).collect()
}

fn variant<'a>(row: &'a Value, id: &str) -> Result<&'a Value, String> {
    let found = row["variants"].as_array().into_iter().flatten().find(|variant| variant["variant"] == id);
    found.ok_or_else(|| format!("no {id} in {row}"))
}

/// Measures, and returns the data, which are as the schema says.
fn measure(folder: &Folder, options: &str) -> Result<(Run, Value), String> {
    let run = folder.run(&format!("bench --quick {options} --json @data.json"));
    run.expect(0, &[])?;
    let data = read_json(folder.path().join("data.json"))?;
    check_data(&data)?;
    Ok((run, data))
}

/// The data are as the schema says, and what refers to a name refers to one that is there.
fn check_data(data: &Value) -> Outcome {
    validate(&schema()?, data)?;
    let all = list(&data["rows"]);
    for row in &all {
        for found in list(&row["variants"]) {
            for time in found["times"].as_object().ok_or("no times")?.values().filter(|time| !time.is_null()) {
                let rounds = list(&time["rounds"]).len();
                ensure!(rounds > 0 && time["runs"] == rounds, "runs are not those counted: {time}");
                let ordered = ["low", "q1", "median", "q3", "high"].map(|key| time[key].as_f64());
                ensure!(ordered.is_sorted(), "{time}");
            }
            for ratio in list(&found["ratios"]) {
                let [to, time] = ["to", "time"].map(|key| ratio[key].as_str().unwrap_or_default());
                ensure!(variant(row, to)?["times"].get(time).is_some(), "{ratio} of nothing in {row}");
            }
        }
    }
    let [casters, one_mesh] = ["rows", "one_mesh"].map(|key| list(&data["casters"][key]));
    for row in casters.iter().chain(&one_mesh) {
        let edges: Vec<u64> = list(&row["silhouette_edges"]).iter().filter_map(Value::as_u64).collect();
        ensure!(data["casters"]["lights"] == edges.len() && !edges.contains(&0), "silhouettes of {row}");
        ensure!(row["wrong_lights"] == 0 && !list(&row["gpu"]).is_empty(), "lights of {row} differ");
    }
    for row in &casters {
        let methods = [
            "scene-still",
            "scene-1-percent-moved",
            "scene-all-moved",
            "scene-light-moved",
            "scene-new-caster",
            "extractors",
        ];
        ensure!(list(&row["recording"]).iter().map(|recorded| &recorded["method"]).eq(methods), "methods of {row}");
        ensure!(parts(row).eq(["extraction", "extraction-still", "stages", "draws", "frame"]), "parts of {row}");
    }
    ensure!(one_mesh.iter().all(|row| parts(row).eq(["extraction"])), "parts of {one_mesh:?}");
    for row in all.iter().filter(|row| row["section"] == "shadows") {
        let methods = ["z-pass", "z-fail", "zp+paper", "zp+", "auto"];
        ensure!(names(row).eq(methods), "methods of {row}");
    }
    check_skipping(data)?;
    let count = all.len() + casters.len() + one_mesh.len();
    let is_complete = data["planned_rows"] == count;
    ensure!(data["complete"].as_bool() == Some(is_complete), "{count} rows, complete: {}", data["complete"]);
    Ok(())
}

/// The parts of a frame that are timed, of a row of casters.
fn parts(row: &Value) -> impl Iterator<Item = &Value> {
    row["gpu"].as_array().into_iter().flatten().map(|part| &part["part"])
}

fn names(row: &Value) -> impl Iterator<Item = &Value> {
    row["variants"].as_array().into_iter().flatten().map(|variant| &variant["variant"])
}

/// Each row has all choices of levels, and ratios of its times to all levels on.
fn check_skipping(data: &Value) -> Outcome {
    let levels = ["light-reach", "shadow-reach", "nothing-moved", "clusters", "hidden-receivers", "unneeded-figures"];
    let has_timestamps = data["adapter"]["timestamps"] == true;
    for row in rows(data, "skipping") {
        let levels = if row["scene"] == "big" { &levels[3..4] } else { &levels[..] };
        let without = levels.iter().map(|level| format!("without-{level}"));
        let expected: Vec<String> = ["all-off", "all-on"].map(str::to_owned).into_iter().chain(without).collect();
        ensure!(names(&row).eq(&expected), "variants of {row}");
        let on = variant(&row, "all-on")?["counts"]["fragments"].as_u64();
        for found in list(&row["variants"]) {
            for time in ["compute", "deform", "frame", "recording", "stencil"] {
                let is_timed = time != "deform" || (row["scene"] == "crowd" && has_timestamps);
                // Without timestamps deforming is in the time of all stages.
                let none = if has_timestamps { json!(0.0) } else { Value::Null };
                let is_there = found["times"].get(time).is_some();
                ensure!(is_there && (is_timed || found["times"][time]["median"] == none), "{time} of {row}");
                let is_divided = list(&found["ratios"]).iter().any(|ratio| ratio["time"] == time);
                ensure!(is_divided == (is_timed && found["variant"] != "all-on"), "the ratio of {time} in {found}");
            }
            // Levels skip only unseen volumes, so no variant has fewer fragments than all levels on.
            ensure!(found["counts"]["fragments"].as_u64() >= on, "levels add fragments: {found}");
        }
    }
    Ok(())
}

/// Changed data do not pass.
fn must_fail(data: &Value, changes: &[(&str, Value)]) -> Outcome {
    for (pointer, wrong) in changes {
        let mut other = data.clone();
        *other.pointer_mut(pointer).ok_or_else(|| format!("nothing is at {pointer}"))? = wrong.clone();
        ensure!(check_data(&other).is_err(), "a wrong {pointer} passed");
    }
    Ok(())
}

/// The page stands alone, and each of its plots has a file.
fn check_report(folder: &Folder, report: &str) -> Result<String, String> {
    let html = String::from_utf8_lossy(&folder.read(format!("{report}/index.html"))?).into_owned();
    for outside in ["http", "//", "src=", "href=", "@import", "url(", "<script", "<link", "<iframe"] {
        ensure!(!html.contains(outside), "the page refers to elsewhere: {outside}");
    }
    let plots: Vec<&str> = html.split("<figure id=\"").skip(1).filter(|plot| plot.contains("<svg")).collect();
    for plot in &plots {
        let id = plot.split('"').next().unwrap_or_default();
        let picture = folder.image(format!("{report}/{id}.png"))?;
        // Letters are near black; without a font there would be none.
        let dark = picture.count_pixels(|pixel| pixel.iter().all(|&c| c < 80))?;
        ensure!(picture.size[0] == 1920 && dark > 500 && plot.contains("<table>"), "{id}: {:?}, {dark}", picture.size);
        // One drawing for wide screens and one for phones, whose letters are as large.
        let drawings: Vec<&str> = plot.split_inclusive("</svg>").filter(|part| part.contains("<svg")).collect();
        ensure!(drawings.len() == 2, "{} drawings of {id}", drawings.len());
        for (drawing, part) in drawings.iter().zip(["class=\"wide\"", "class=\"narrow\""]) {
            ensure!(drawing.contains(part), "{id} has no {part}");
            let svg = drawing.split_once("<svg").map_or("", |(_, svg)| svg);
            plot_labels::check(svg).map_err(|error| format!("{id}, {part}: {error}"))?;
        }
    }
    for element in ["html", "body", "main", "section", "figure", "svg", "table", "details", "dl"] {
        let [opened, closed] = [format!("<{element}"), format!("</{element}>")].map(|tag| html.matches(&*tag).count());
        ensure!(opened == closed, "{opened} of {element} begin, {closed} end");
    }
    let pictures = std::fs::read_dir(folder.path().join(report)).map_err(|error| error.to_string())?.count() - 2;
    ensure!(pictures == plots.len() && pictures > 0, "{pictures} pictures of {} plots", plots.len());
    Ok(html)
}

fn report() -> Outcome {
    let folder = folder();
    let options =
        "--meshes 1024,2048 --scenes translation-1e6,plate-third --scene-faces 600 --lights 1,8 --rounds 2 --frames 1";
    let (run, data) = measure(&folder, &format!("{options} --report @a/report"))?;
    run.expect(0, &["12/12"])?;
    is_short(&run.stdout, &["Against the method of 2003", "Price of exactness", "Wrong silhouette bits", "auto"])?;
    ensure!(data == read_json(folder.path().join("a/report/data.json"))?, "the two files of data differ");
    ensure!(folder.run("bench --schema").json()? == schema()?, "another schema than the repository's");
    let found = rows(&data, "extraction");
    // Two methods more where there is one light and the mesh is closed.
    let methods: Vec<usize> = found.iter().map(|row| list(&row["variants"]).len()).collect();
    ensure!(methods == [13, 11, 13, 11, 13, 11, 11, 11] && data["complete"] == true, "methods a row: {methods:?}");
    ensure!(data["adapter"]["name"].is_string(), "no adapter");
    let errors = |is_chosen: fn(&str) -> bool| {
        let variants = found.iter().flat_map(|row| list(&row["variants"]));
        let counts = variants.filter(|one| is_chosen(one["variant"].as_str().unwrap_or(""))).flat_map(|one| {
            ["wrong_facing_bits", "wrong_silhouette_bits", "unclosed_vertices"].map(|key| one["counts"][key].as_u64())
        });
        counts.sum::<Option<u64>>()
    };
    ensure!(errors(|method| method.contains("exact")) == Some(0), "exact methods have errors");
    ensure!(errors(|method| method == "cpu-f32-all") > Some(0), "f32 has no errors here");
    let is_f32_of_gpu = |method: &str| method.starts_with("gpu") && !method.contains("exact");
    ensure!(errors(is_f32_of_gpu) > Some(0), "f32 has no errors here");
    let is_inside = |row: &&Value| row["scene"] == "looks-away" || row["scene"] == "looks-at-occluder";
    for row in rows(&data, "shadows").iter().filter(is_inside) {
        let wrong = |method: &str| -> Result<f64, String> {
            let pixels = &variant(row, method)?["counts"]["wrong_pixels"];
            Ok(pixels.as_f64().unwrap_or_else(|| list(pixels).iter().filter_map(Value::as_f64).sum()))
        };
        ensure!(wrong("z-pass")? > 1000.0, "z-pass is right in shadow: {row}");
        for method in ["z-fail", "zp+", "auto"] {
            ensure!(wrong(method)? < 4.0, "{} pixels wrong by {method}", wrong(method)?);
        }
    }
    let html = check_report(&folder, "a/report")?;
    // Without two meshes nothing would be a curve.
    for chart in ["time_against_error", "speed_against_2003", "shadow_stencil"] {
        folder.image(format!("a/report/{chart}.png"))?;
    }
    let plate = html.split_once("<th scope=\"row\">plate</th><td>").map_or("", |(_, text)| text);
    ensure!(plate.split("</td>").next().is_some_and(|text| text.contains("Flat plates")), "a class is not explained");
    ensure!(!html.contains("was stopped"), "a complete run says that it was stopped");
    // A report may be made again in the same folder, and plots that it does not show are gone.
    let other = "--device cpu --meshes none --scenes moebius-strip --scene-faces 200 --lights 40 --rounds 1";
    let (_, again) = measure(&folder, &format!("{other} --report @a/report"))?;
    ensure!(again["adapter"].is_null() && again["rows"][0]["lights"] == 40, "{}", again["rows"][0]["lights"]);
    check_report(&folder, "a/report")?;
    must_fail(
        &data,
        &[
            ("/format", json!("other")),
            ("/date", json!("yesterday")),
            ("/machine", json!({ "os": "Linux" })),
            ("/rows/0/lights", json!(1.5)),
            ("/rows/0/variants/0/times/wall/median", json!("fast")),
            ("/rows/0/variants/0/times/wall/runs", json!(7)),
            ("/rows/0/variants/1/ratios/0/to", json!("nobody")),
            ("/rows/0/variants/0/counts/wrong_facing_bits", json!(-1)),
            ("/rows/0/variants/0/counts", json!({ "new_key": "none" })),
            ("/rows/0/section", json!("village")),
            ("/rows/8/variants/0/variant", json!("zp+")),
            ("/planned_rows", json!(11)),
        ],
    )
}

/// A person sees the machine, and a line for each question, with all of `parts`.
fn is_short(stdout: &str, parts: &[&str]) -> Outcome {
    let lines = stdout.lines().count();
    ensure!((5..=25).contains(&lines), "{lines} lines: {stdout}");
    let lost = parts.iter().find(|part| !stdout.contains(**part));
    ensure!(lost.is_none(), "no {lost:?} in {stdout}");
    Ok(())
}

/// The user's own model and lights, instead of all that is made by code.
fn user_model() -> Outcome {
    let folder = folder();
    folder.write("own.obj", "v 0 0 0\nv 2 0 0\nv 0 2 0\nv 0 0 2\nf 1 3 2\nf 1 2 4\nf 1 4 3\nf 2 3 4\n")?;
    let options = "--rounds 1 --frames 1 --light point:5,1,2 --light dir:0,1,0 @own.obj";
    let (run, data) = measure(&folder, options)?;
    run.expect(0, &["5/5"])?;
    is_short(&run.stdout, &["your model of 4 faces", "at 2 lights", "Shadows against z-pass, whole frame"])?;
    let found = rows(&data, "extraction");
    ensure!(found.len() == 1 && found[0]["group"] == "own" && found[0]["lights"] == 2, "{found:?}");
    ensure!(rows(&data, "shadows").len() == 4 && data["casters"].is_null(), "other rows");
    let (_, data) = measure(&folder, "--rounds 1 --device cpu @own.obj")?;
    let lights: Vec<Value> = rows(&data, "extraction").iter().map(|row| row["lights"].clone()).collect();
    ensure!(lights == [1, 8, 32], "{lights:?}");
    Ok(())
}

fn scenes() -> Outcome {
    let folder = folder();
    let options = "--scene casters,still,city,crowd,moving,big --casters 3 --meshes none --frames 0 --rounds 1";
    let (run, data) = measure(&folder, &format!("{options} --report @report"))?;
    is_short(&run.stdout, &["Scene of 3 boxes", "Without skipping, city, 3 buildings, obliquely", "frame"])?;
    ensure!(data["complete"] == true, "not complete");
    let meshes: Vec<_> = list(&data["casters"]["rows"]).iter().map(|row| row["mesh"].clone()).collect();
    ensure!(meshes == ["box", "figure"], "{meshes:?}");
    // A convex box has a silhouette of four or six edges, but for lights in the planes of its faces.
    let edges = list(&data["casters"]["rows"][0]["silhouette_edges"]);
    ensure!(edges.iter().all(|edges| (12..=18).contains(&edges.as_u64().unwrap_or(0))), "{edges:?}");
    let found = rows(&data, "skipping");
    let names: Vec<_> = found.iter().map(|row| row["scene"].clone()).collect();
    ensure!(names == ["still", "city", "city", "crowd", "crowd", "moving", "big"], "{names:?}");
    for row in &found {
        let [off, on] = [variant(row, "all-off")?, variant(row, "all-on")?];
        let count = |variant: &Value, key: &str| variant["counts"][key].as_u64();
        ensure!(count(off, "faces") == row["faces"].as_u64() && count(off, "kept-pairs") == Some(0), "{off}");
        let number = |key: &str| row[key].as_u64();
        let pairs = number("casters").zip(number("lights")).map(|(casters, lights)| casters * lights);
        ensure!(count(off, "pairs") == pairs && number("pairs_in_range") <= pairs, "pairs of {off}");
        if row["scene"] == "big" {
            let [tested, spared] = ["faces", "spared-faces"].map(|key| count(on, key).unwrap_or(0));
            ensure!(Some(tested + spared) == number("faces") && 2 * tested < spared, "{on}");
            let all = ["faces", "spared-faces"].map(|key| count(variant(row, "without-clusters").ok()?, key));
            ensure!(all == [number("faces"), Some(0)], "faces without clusters of {row}");
            continue;
        }
        for (level, key) in [("nothing-moved", "kept-pairs"), ("unneeded-figures", "unneeded-figures")] {
            let without = variant(row, &format!("without-{level}"))?;
            ensure!([off, without].map(|one| count(one, key)) == [Some(0); 2], "{key} of {without}");
        }
        ensure!((count(on, "unneeded-figures") > Some(0)) == (row["view"] == "within"), "figures of {on}");
        // Where nothing moves nothing is tested, and lamps may reach none of few figures.
        if row["scene"] == "moving" {
            ensure!(["skipped-volumes", "kept-pairs"].map(|key| count(on, key)) == [Some(0); 2], "{on}");
        } else if row["scene"] != "crowd" {
            let tested = ["faces", "edges", "kept-pairs"].map(|key| count(on, key));
            ensure!(on["counts"]["fragments"] != 0 && tested == [Some(0), Some(0), pairs], "{on}");
        }
    }
    let html = check_report(&folder, "report")?;
    ensure!(
        html.contains("work goes, and what is skipped") && html.contains("of scene and light, 0 differ"),
        "no section"
    );
    let mut wrong = vec![
        ("/casters/rows/1/wrong_lights", json!(1)),
        ("/casters/rows/0/recording/0/cpu_ms/median", json!("fast")),
        ("/casters/rows/1/gpu", Value::Null),
        ("/casters/rows/1/silhouette_edges/4", json!(0)),
        ("/casters/rows/1/recording/5/method", json!("scene-still")),
        ("/casters/one_mesh/0/gpu/0/part", json!("frame")),
        ("/rows/1/variants/0/variant", json!("all-on")),
        ("/rows/1/variants/1/counts/fragments", json!(1_000_000_000)),
        ("/rows/2/variants/0/ratios", json!([])),
        ("/rows/3/variants/1/counts/faces", json!("none")),
    ];
    if data["adapter"]["timestamps"] == true {
        wrong.push(("/rows/2/variants/1/times/deform/median", json!(1.0)));
    }
    must_fail(&data, &wrong)
}

fn depth_maps() -> Outcome {
    let folder = folder();
    let rounds = |ms: f64| json!({ "rounds": [ms, 2.0 * ms, 3.0 * ms] });
    let row = |faces: u64, ms: f64| {
        let names = ["volumes of the mesh", "of the map, automatic", "lookup", "another"];
        // Each has times of its own, so that none is taken for another.
        let variant = |(times, name): (i32, &str)| {
            let [frame, stencil] = [ms * f64::from(times), ms / f64::from(times)].map(rounds);
            json!({ "variant": name, "times": { "frame": frame, "stencil": stencil } })
        };
        let variants: Vec<Value> = (1..).zip(names).map(variant).collect();
        json!({ "faces": faces, "size": 64, "group": "a device", "variants": variants })
    };
    let good =
        json!({ "format": "rimline-depth-map-casters", "version": 2, "rows": [row(1000, 1.5), row(1_000_000, 40.0)] });
    folder.write("times.json", good.to_string())?;
    let line = "--meshes none --scenes none --device cpu --depth-maps @times.json --report @report";
    let (_, data) = measure(&folder, line)?;
    let times = &variant(&data["rows"][1], "of the map, automatic")?["times"];
    ensure!(times["frame"]["median"] == 160.0 && times["stencil"]["median"] == 40.0, "{times:#}");
    let html = check_report(&folder, "report")?;
    ensure!(html.contains("a device") && html.contains("of the map, automatic"), "the section is not there");
    // An input that the report would replace, and a name that it cannot have, are refused before the work.
    folder.write("report/data.json", good.to_string())?;
    let replaced = format!("bench {}", line.replace("@times", "@report/data"));
    folder.run(&replaced).expect(2, &["data.json is an input"])?;
    let chart = folder.path().join("report/depth_maps_against_meshes.png");
    std::fs::remove_file(&chart).and_then(|()| std::fs::create_dir(&chart)).map_err(|error| error.to_string())?;
    let run = folder.run(&format!("bench {line}"));
    run.expect(4, &["it is a folder"])?;
    ensure!(run.stdout.is_empty(), "it began: {}", run.stdout);
    // Refused before anything is written.
    let wrong_values = [
        ("/rows/1/variants/0/times/frame/rounds/1", json!(-1.0)),
        ("/rows/0/variants", Value::Null),
        ("/rows", json!([])),
        ("/format", json!("rimline-bench")),
        ("", json!(3)),
    ];
    for (pointer, wrong) in wrong_values {
        let mut other = good.clone();
        *other.pointer_mut(pointer).ok_or("nothing is there")? = wrong;
        folder.write("times.json", other.to_string())?;
        let run = folder.run(&format!("bench {}", line.replace("@report", "@other")));
        run.expect(1, &["times.json", "it is not what `cargo bench --bench depth_maps"])?;
        ensure!(!folder.path().join("other").exists(), "{pointer}: a report");
    }
    Ok(())
}

/// The first Ctrl-C, after the first row of very many.
#[cfg(unix)]
fn interrupted() -> Outcome {
    let folder = folder();
    let mut command = super::run::with_signals(env!("CARGO_BIN_EXE_rimline"));
    command.args(["bench", "--device", "cpu", "--report"]).arg(folder.path().join("report"));
    let (code, text) = super::signals::after_a_row(&mut command, &["-INT"])?;
    ensure!(code == 130, "{code}: {text}");
    let data = read_json(folder.path().join("report/data.json"))?;
    check_data(&data)?;
    ensure!(data["complete"] == false && !rows(&data, "extraction").is_empty(), "no rows, or all");
    let html = check_report(&folder, "report")?;
    ensure!(html.contains("This run was stopped"), "the page does not say that it was stopped");
    Ok(())
}
