//! `rimline bench`: its files, what they hold, and what Ctrl-C leaves. Nothing here depends on how long anything took.

use std::path::Path;

use serde_json::{Value, json};

use super::run::{folder, is_empty, rimline, with_signals, write_file};
use super::schema::validate;
use super::{Outcome, Test, ensure, plot_labels};

pub(crate) const TESTS: &[Test] = &[
    ("bench::report_and_data_are_as_described", report),
    ("bench::one_device_and_many_lights", on_the_cpu),
    ("bench::a_model_and_lights_of_the_user", user_model),
    ("bench::scenes_of_many_casters", many_casters),
    ("bench::scenes_that_measure_skipping", skipping),
    ("bench::times_of_depth_maps_are_shown", depth_maps),
    ("bench::the_schema_is_printed", schema_is_printed),
    ("bench::wrong_options_write_nothing", wrong_options),
    #[cfg(unix)]
    ("bench::ctrl_c_keeps_what_is_done", interrupted),
];

fn read_json(file: &Path) -> Result<Value, String> {
    let text = std::fs::read_to_string(file).map_err(|error| format!("{}: {error}", file.display()))?;
    serde_json::from_str(&text).map_err(|error| format!("{}: {error}", file.display()))
}

pub(crate) fn schema() -> Result<Value, String> {
    read_json(&Path::new(env!("CARGO_MANIFEST_DIR")).join("../rimline-bench/bench.schema.json"))
}

fn list(value: &Value) -> Vec<Value> {
    value.as_array().cloned().unwrap_or_default()
}

/// The rows of a section.
fn rows(data: &Value, section: &str) -> Vec<Value> {
    list(&data["rows"]).into_iter().filter(|row| row["section"] == section).collect()
}

fn variant<'a>(row: &'a Value, id: &str) -> Option<&'a Value> {
    row["variants"].as_array()?.iter().find(|variant| variant["variant"] == id)
}

/// The data are as the schema says, and what refers to a name refers to one that is there.
fn check_data(data: &Value) -> Outcome {
    validate(&schema()?, data)?;
    let rows = list(&data["rows"]);
    for row in &rows {
        let mut wholes: Vec<Vec<String>> = Vec::new();
        for found in list(&row["variants"]) {
            let times = found["times"].as_object().ok_or("no times")?;
            wholes.push(times.keys().cloned().collect());
            for time in times.values() {
                let rounds = list(&time["rounds"]).len();
                ensure!(rounds > 0 && time["runs"] == rounds, "runs are not those counted: {time}");
                let ordered = ["low", "q1", "median", "q3", "high"].map(|key| time[key].as_f64());
                ensure!(ordered.is_sorted(), "{time}");
            }
            for ratio in list(&found["ratios"]) {
                let [to, time] = ["to", "time"].map(|key| ratio[key].as_str().unwrap_or_default());
                ensure!(
                    variant(row, to).is_some_and(|to| to["times"].get(time).is_some()),
                    "{ratio} of nothing in {row}"
                );
            }
        }
        // Methods of the GPU have times of their own.
        ensure!(row["section"] == "extraction" || wholes.windows(2).all(|two| two[0] == two[1]), "{wholes:?} of {row}");
    }
    for row in rows.iter().filter(|row| row["section"] == "shadows") {
        let looked_at: Vec<usize> =
            list(&row["variants"]).iter().map(|v| list(&v["counts"]["wrong_pixels"]).len()).collect();
        let methods: Vec<Value> = list(&row["variants"]).iter().map(|v| v["variant"].clone()).collect();
        ensure!(methods == ["z-pass", "z-fail", "zp+paper", "zp+", "auto"], "methods of {row}");
        let is_one = row["frames"] == 1;
        ensure!(
            looked_at.iter().all(|&frames| frames > 0 && !(is_one && frames > 1)) || is_one,
            "{looked_at:?} of {row}"
        );
    }
    let caster_rows = check_casters(&data["casters"])?;
    check_skipping(data, data["adapter"]["timestamps"] == true)?;
    let all = rows.len() as u64 + caster_rows;
    let is_complete = data["planned_rows"] == all;
    ensure!(data["complete"].as_bool() == Some(is_complete), "{all} rows, complete: {}", data["complete"]);
    ensure!(data["date"].as_str().is_some_and(|date| date.len() == 20 && date.ends_with('Z')), "{}", data["date"]);
    Ok(())
}

/// No light has other silhouettes in a scene than in the merged mesh, and each scene has what its size asks for; returns
/// the number of rows.
fn check_casters(casters: &Value) -> Result<u64, String> {
    let (rows, one_mesh) = (list(&casters["rows"]), list(&casters["one_mesh"]));
    for row in &rows {
        let number = row["casters"].as_u64().unwrap_or(0);
        let methods = [
            "scene-still",
            "scene-1-percent-moved",
            "scene-all-moved",
            "scene-light-moved",
            "scene-new-caster",
            "extractors",
        ];
        let methods = &methods[..if number > 100 { 5 } else { 6 }];
        ensure!(list(&row["recording"]).iter().map(|recorded| &recorded["method"]).eq(methods), "methods of {row}");
        let timed = ["extraction", "extraction-still", "stages", "draws", "frame"];
        ensure!(parts(&row["gpu"]) == timed[..if number > 1000 { 3 } else { 5 }], "parts of {row}");
    }
    for row in &one_mesh {
        ensure!(parts(&row["gpu"]) == ["extraction"], "parts of {row}");
    }
    for row in rows.iter().chain(&one_mesh) {
        let edges: Vec<u64> = list(&row["silhouette_edges"]).iter().filter_map(Value::as_u64).collect();
        ensure!(casters["lights"] == edges.len() && edges.iter().all(|&edges| edges > 0), "silhouettes of {row}");
        ensure!(row["wrong_lights"] == 0, "lights of {row} differ");
    }
    Ok((rows.len() + one_mesh.len()) as u64)
}

/// Each row has all choices of levels with all parts and counters, and ratios to all levels on.
fn check_skipping(data: &Value, has_timestamps: bool) -> Outcome {
    let levels = ["light-reach", "shadow-reach", "nothing-moved", "clusters", "hidden-receivers", "unneeded-figures"];
    let mut expected = vec!["all-off".to_owned(), "all-on".to_owned()];
    expected.extend(levels.map(|level| format!("without-{level}")));
    let of_big = ["all-off", "all-on", "without-clusters"].map(str::to_owned);
    for row in rows(data, "skipping") {
        let variants = list(&row["variants"]);
        let of_row: &[String] = if row["scene"] == "big" { &of_big } else { &expected };
        ensure!(variants.iter().map(|variant| &variant["variant"]).eq(of_row), "variants of {row}");
        let is_deformed = row["scene"] == "crowd";
        for variant in &variants {
            let times: Vec<&String> =
                variant["times"].as_object().into_iter().flatten().map(|(name, _)| name).collect();
            ensure!(times == ["compute", "deform", "frame", "recording", "stencil"], "{variant}");
            let stages = variant["stages"].as_object().ok_or("no stages")?;
            let deforms = stages.contains_key("deform");
            ensure!(!stages.is_empty() && (!has_timestamps || deforms == is_deformed), "stages of {variant}");
            for time in times {
                let is_timed = time != "deform" || (is_deformed && has_timestamps);
                ensure!(is_timed || variant["times"][time]["median"] == 0.0, "{time} of {row}");
                let ratio = list(&variant["ratios"]).into_iter().find(|ratio| ratio["time"] == *time);
                let is_divided = is_timed && variant["variant"] != "all-on";
                ensure!(ratio.is_some() == is_divided, "the ratio of {time} in {variant}");
            }
            let fragments = |variant: &Value| variant["counts"]["fragments"].as_u64();
            // Levels skip only unseen volumes, so no variant has fewer fragments than all levels on.
            ensure!(fragments(variant) >= fragments(&variants[1]), "levels add fragments: {variant}");
        }
    }
    Ok(())
}

/// A counter of a variant's stages.
fn count(variant: &Value, counter: &str) -> Option<u64> {
    variant["counts"][counter].as_u64()
}

/// The parts of a frame that are timed.
fn parts(gpu: &Value) -> Vec<&str> {
    gpu.as_array().into_iter().flatten().filter_map(|part| part["part"].as_str()).collect()
}

/// Wrong pixels of a method's frames on one path.
fn wrong_pixels(data: &Value, path: &str, method: &str) -> f64 {
    let rows = rows(data, "shadows").into_iter().filter(|row| row["scene"] == path);
    let counts = rows.flat_map(|row| {
        let pixels = &variant(&row, method).map(|found| found["counts"]["wrong_pixels"].clone()).unwrap_or_default();
        pixels.as_array().cloned().unwrap_or_else(|| vec![pixels.clone()])
    });
    counts.filter_map(|pixels| pixels.as_f64()).sum()
}

/// All errors of the methods whose id is `chosen`, over all rows.
fn errors(data: &Value, chosen: impl Fn(&str) -> bool) -> u64 {
    let of = |found: &Value| {
        let keys = ["wrong_facing_bits", "wrong_silhouette_bits", "unclosed_vertices"];
        keys.iter().map(|key| count(found, key).unwrap_or(u64::MAX / 1000)).sum::<u64>()
    };
    let variants = rows(data, "extraction").into_iter().flat_map(|row| list(&row["variants"]));
    variants.filter(|found| found["variant"].as_str().is_some_and(&chosen)).map(|found| of(&found)).sum()
}

/// Width and height of a picture that shows something.
fn picture_size(file: &Path) -> Result<[u32; 2], String> {
    let failed = |error: &dyn std::fmt::Display| format!("{}: {error}", file.display());
    let bytes = std::fs::read(file).map_err(|error| failed(&error))?;
    let mut reader = png::Decoder::new(std::io::Cursor::new(bytes)).read_info().map_err(|error| failed(&error))?;
    let mut data = vec![0; reader.output_buffer_size().ok_or("the picture is too large")?];
    let info = reader.next_frame(&mut data).map_err(|error| failed(&error))?;
    // Letters are near black; without a font there would be none.
    let dark = data.chunks_exact(3).filter(|pixel| pixel.iter().all(|&c| c < 80)).count();
    ensure!(dark > 500, "{}: {dark} dark pixels, so there is no text", file.display());
    Ok([info.width, info.height])
}

/// The page stands alone, and each of its plots has a file.
fn check_report(folder: &Path) -> Result<String, String> {
    let html = std::fs::read_to_string(folder.join("index.html")).map_err(|error| error.to_string())?;
    for outside in ["http", "//", "src=", "href=", "@import", "url(", "<script", "<link", "<iframe"] {
        ensure!(!html.contains(outside), "the page refers to elsewhere: {outside}");
    }
    let plots: Vec<&str> = html.split("<figure id=\"").skip(1).filter(|plot| plot.contains("<svg")).collect();
    ensure!(!plots.is_empty(), "no plots");
    for plot in &plots {
        let id = plot.split('"').next().unwrap_or_default();
        let [width, height] = picture_size(&folder.join(format!("{id}.png")))?;
        ensure!(width == 1920 && height > 300, "{id}: {width} by {height}");
        ensure!(plot.contains("<table>"), "{id} has no table");
        // One drawing for wide screens and one for phones, whose letters are as large.
        let drawings: Vec<&str> = plot.split_inclusive("</svg>").filter(|part| part.contains("<svg")).collect();
        for (drawing, part) in drawings.iter().zip(["class=\"wide\"", "class=\"narrow\""]) {
            ensure!(drawing.contains(part), "{id} has no {part}");
            let svg = drawing.split_once("<svg").map_or("", |(_, svg)| svg);
            plot_labels::check(svg).map_err(|error| format!("{id}, {part}: {error}"))?;
        }
        ensure!(drawings.len() == 2, "{} drawings of {id}", drawings.len());
    }
    ensure!(html.contains("name=\"viewport\" content=\"width=device-width"), "a phone would show it in small");
    for element in ["html", "body", "main", "section", "figure", "svg", "table", "details", "dl"] {
        let [opened, closed] = [format!("<{element}"), format!("</{element}>")].map(|tag| html.matches(&*tag).count());
        ensure!(opened == closed, "{opened} of {element} begin, {closed} end");
    }
    let pictures = std::fs::read_dir(folder).map_err(|error| error.to_string())?.count() - 2;
    ensure!(pictures == plots.len(), "{pictures} pictures of {} plots", plots.len());
    Ok(html)
}

fn report() -> Outcome {
    let folder = folder();
    let (report, json) = (folder.path().join("a/report"), folder.path().join("data.json"));
    let line = "bench --quick --meshes 1024,2048 --scenes translation-1e6,plate-third --scene-faces 600 --lights 1,8 \
                --rounds 2 --frames 1";
    let files = ["--report".as_ref(), report.as_os_str(), "--json".as_ref(), json.as_os_str()];
    let run = rimline(line.split(' ').map(AsRef::as_ref).chain(files));
    run.expect(0, &["12/12"])?;
    is_short(&run.stdout, &["Against the method of 2003", "Price of exactness", "Wrong silhouette bits", "auto"])?;
    let data = read_json(&json)?;
    ensure!(data == read_json(&report.join("data.json"))?, "the two files of data differ");
    check_data(&data)?;
    let rows = rows(&data, "extraction");
    ensure!(rows.len() == 8 && data["complete"] == true, "{} rows", rows.len());
    ensure!(data["adapter"]["name"].is_string(), "no adapter");
    // Two methods more where there is one light and the mesh is closed.
    let methods: Vec<usize> = rows.iter().filter_map(|row| row["variants"].as_array().map(Vec::len)).collect();
    ensure!(methods == [13, 11, 13, 11, 13, 11, 11, 11], "methods a row: {methods:?}");
    let is_exact = |method: &str| method.contains("exact");
    ensure!(errors(&data, is_exact) == 0, "exact methods have errors");
    ensure!(errors(&data, |method| method.starts_with("gpu") && !is_exact(method)) > 0, "f32 has no errors here");
    ensure!(errors(&data, |method| method == "cpu-f32-all") > 0, "f32 has no errors here");
    for path in ["looks-away", "looks-at-occluder"] {
        let wrong = |method: &str| wrong_pixels(&data, path, method);
        ensure!(wrong("z-pass") > 1000.0, "{path}: z-pass is right in shadow");
        for method in ["z-fail", "zp+", "auto"] {
            ensure!(wrong(method) < 4.0, "{path}: {} pixels wrong by {method}", wrong(method));
        }
    }
    let html = check_report(&report)?;
    for (class, what) in
        [("ordinary", "Smooth closed meshes"), ("translation", "far from the origin"), ("plate", "Flat plates")]
    {
        let row = format!("<th scope=\"row\">{class}</th><td>");
        let text = html.split_once(&row).and_then(|(_, rest)| rest.split_once("</td>")).map_or("", |(text, _)| text);
        ensure!(text.contains(what), "the class {class} is not explained: {text}");
    }
    ensure!(!html.contains("was stopped"), "a complete run says that it was stopped");
    // A report may be made again in the same place.
    let line = "bench --device cpu --meshes none --scenes three-sheets --scene-faces 60 --lights 2 --rounds 1 --report";
    rimline(line.split(' ').map(AsRef::as_ref).chain([report.as_os_str()])).expect(0, &[])?;
    check_data(&read_json(&report.join("data.json"))?)?;
    // Plots that it does not show are gone.
    check_report(&report)?;

    // Negative controls of the checks above.
    let wrong_values = [
        ("/rows/0/variants/0/times/wall/median", "fast".into()),
        ("/rows/0/variants/0/times/wall/runs", 7.into()),
        ("/rows/0/variants/1/ratios/0/to", "nobody".into()),
        ("/rows/8/variants/0/variant", "zp+".into()),
        ("/planned_rows", 11.into()),
    ];
    for (pointer, wrong) in wrong_values {
        let mut other = data.clone();
        *other.pointer_mut(pointer).ok_or_else(|| format!("nothing is at {pointer}"))? = wrong;
        ensure!(check_data(&other).is_err(), "a wrong {pointer} passed");
    }
    let mut other = data.clone();
    other["rows"][0]["new_key"] = 1.into();
    ensure!(check_data(&other).is_err(), "a key without description passed");
    let mut other = data;
    other["rows"].as_array_mut().map(Vec::pop);
    ensure!(check_data(&other).is_err(), "a lost row passed");
    Ok(())
}

/// A person sees the machine, and a line for each question, with all of `parts`.
fn is_short(stdout: &str, parts: &[&str]) -> Outcome {
    let lines = stdout.lines().count();
    ensure!((5..=25).contains(&lines), "{lines} lines: {stdout}");
    for part in parts {
        ensure!(stdout.contains(part), "no `{part}` in {stdout}");
    }
    Ok(())
}

/// The user's own model and lights, instead of all that is made by code.
fn user_model() -> Outcome {
    let folder = folder();
    let (model, json) = (folder.path().join("own.obj"), folder.path().join("data.json"));
    write_file(&model, "v 0 0 0\nv 2 0 0\nv 0 2 0\nv 0 0 2\nf 1 3 2\nf 1 2 4\nf 1 4 3\nf 2 3 4\n")?;
    let line = "bench --quick --rounds 1 --frames 1 --light point:5,1,2 --light dir:0,1,0 --json";
    let run = rimline(line.split(' ').map(AsRef::as_ref).chain([json.as_os_str(), model.as_os_str()]));
    run.expect(0, &["5/5"])?;
    is_short(&run.stdout, &["your model of 4 faces", "at 2 lights", "Shadows against z-pass, whole frame"])?;
    let data = read_json(&json)?;
    check_data(&data)?;
    let found = rows(&data, "extraction");
    ensure!(found.len() == 1 && found[0]["group"] == "own" && found[0]["lights"] == 2, "{found:?}");
    ensure!(rows(&data, "shadows").len() == 4 && data["casters"].is_null(), "other rows");
    let line = "bench --quick --rounds 1 --device cpu --json";
    let run = rimline(line.split(' ').map(AsRef::as_ref).chain([json.as_os_str(), model.as_os_str()]));
    run.expect(0, &["3/3"])?;
    let lights: Vec<Value> = rows(&read_json(&json)?, "extraction").iter().map(|row| row["lights"].clone()).collect();
    ensure!(lights == [1, 8, 32], "{lights:?}");
    Ok(())
}

fn on_the_cpu() -> Outcome {
    let folder = folder();
    let json = folder.path().join("data.json");
    let line =
        "bench --device cpu --meshes none --scenes moebius-strip --scene-faces 200 --lights 40 --rounds 1 --json";
    rimline(line.split(' ').map(AsRef::as_ref).chain([json.as_os_str()])).expect(0, &[])?;
    let data = read_json(&json)?;
    check_data(&data)?;
    ensure!(data["adapter"].is_null(), "{}", data["adapter"]);
    ensure!(errors(&data, |method| method.contains("exact")) == 0, "exact methods have errors");
    ensure!(data["rows"][0]["lights"] == 40, "{}", data["rows"][0]["lights"]);
    Ok(())
}

fn many_casters() -> Outcome {
    let folder = folder();
    let (report, json) = (folder.path().join("report"), folder.path().join("data.json"));
    let line = "bench --scene casters --casters 1,3 --meshes none --frames 0 --rounds 1 --quick";
    let files = ["--report".as_ref(), report.as_os_str(), "--json".as_ref(), json.as_os_str()];
    let run = rimline(line.split(' ').map(AsRef::as_ref).chain(files));
    run.expect(0, &["6/6"])?;
    is_short(&run.stdout, &["Recording a frame of 3 figures", "Scene of 3 boxes"])?;
    let data = read_json(&json)?;
    check_data(&data)?;
    ensure!(data["complete"] == true && data["planned_rows"] == 6, "more was measured");
    let rows = |list: &str, keys: [&str; 2]| -> Vec<[Value; 2]> {
        let rows = data["casters"][list].as_array().into_iter().flatten();
        rows.map(|row| keys.map(|key| row[key].clone())).collect()
    };
    let expected = [("box", 1), ("box", 3), ("figure", 1), ("figure", 3)]
        .map(|(mesh, casters)| [Value::from(mesh), Value::from(casters)]);
    ensure!(rows("rows", ["mesh", "casters"]) == expected, "{}", data["casters"]["rows"]);
    ensure!(
        rows("one_mesh", ["faces", "wrong_lights"]) == [1024, 16384].map(|faces| [faces, 0].map(Value::from)),
        "one mesh"
    );
    // A convex box has a silhouette of four or six edges, but for lights in the planes of its faces.
    let edges = data["casters"]["rows"][1]["silhouette_edges"].as_array().ok_or("no silhouettes")?;
    ensure!(edges.iter().all(|edges| (12..=18).contains(&edges.as_u64().unwrap_or(0))), "{edges:?}");
    let html = check_report(&report)?;
    ensure!(html.contains("of 30 pairs of scene and light, 0 differ"), "the page does not say how many lights differ");

    // Negative controls of the checks above.
    let wrong_values = [
        ("/casters/rows/1/wrong_lights", 1.into()),
        ("/casters/rows/0/recording/0/cpu_ms/median", "fast".into()),
        ("/casters/rows/2/recording/5/method", "scene-still".into()),
        ("/casters/rows/2/gpu", Value::Null),
        ("/casters/rows/3/silhouette_edges/4", 0.into()),
        ("/casters/one_mesh/0/gpu/0/part", "frame".into()),
        ("/planned_rows", 7.into()),
    ];
    for (pointer, wrong) in wrong_values {
        let mut other = data.clone();
        *other.pointer_mut(pointer).ok_or("nothing is there")? = wrong;
        ensure!(check_data(&other).is_err(), "a wrong {pointer} passed");
    }
    Ok(())
}

fn skipping() -> Outcome {
    let folder = folder();
    let (report, json) = (folder.path().join("report"), folder.path().join("data.json"));
    let line = "bench --scene still,city,crowd,moving,big --casters 3 --meshes none --frames 0 --rounds 1 --quick";
    let files = ["--report".as_ref(), report.as_os_str(), "--json".as_ref(), json.as_os_str()];
    let run = rimline(line.split(' ').map(AsRef::as_ref).chain(files));
    run.expect(0, &["7/7"])?;
    is_short(&run.stdout, &["Without skipping, city, 3 buildings, obliquely", "frame"])?;
    let data = read_json(&json)?;
    check_data(&data)?;
    ensure!(data["complete"] == true && data["casters"].is_null(), "more was measured");
    let rows = rows(&data, "skipping");
    let expected = [
        ("still", "whole", 5),
        ("city", "along-street", 1),
        ("city", "oblique", 1),
        ("crowd", "whole", 32),
        ("crowd", "within", 32),
        ("moving", "whole", 5),
    ];
    let expected =
        expected.map(|(scene, view, lights)| [Value::from(scene), view.into(), 3.into(), lights.into()]).into_iter();
    let expected = expected.chain([["big".into(), "whole".into(), 1.into(), 1.into()]]);
    let found = rows.iter().map(|row| ["scene", "view", "casters", "lights"].map(|key| row[key].clone()));
    ensure!(found.eq(expected), "{rows:?}");
    for row in &rows {
        let number = |key: &str| row[key].as_u64().unwrap_or(0);
        let of = |name: &str| variant(row, name).ok_or(format!("no {name} in {row}"));
        let [off, on] = [of("all-off")?, of("all-on")?];
        let pairs = number("casters") * number("lights");
        ensure!(number("pairs_in_range") <= pairs, "{row}");
        ensure!(count(off, "faces") == Some(number("faces")), "faces of {off}");
        ensure!(count(off, "pairs") == Some(pairs) && count(off, "kept-pairs") == Some(0), "pairs of {off}");
        if row["scene"] == "big" {
            let [tested, spared] = ["faces", "spared-faces"].map(|counter| count(on, counter).unwrap_or(0));
            ensure!(tested + spared == number("faces") && 2 * tested < spared, "{on}");
            let without = of("without-clusters")?;
            ensure!(count(without, "faces") == Some(number("faces")), "faces of {without}");
            ensure!(count(without, "spared-faces") == Some(0), "faces of {without}");
            continue;
        }
        let moved = of("without-nothing-moved")?;
        ensure!(count(moved, "kept-pairs") == Some(0), "pairs of {moved}");
        let needed = of("without-unneeded-figures")?;
        ensure!([off, needed].map(|one| count(one, "unneeded-figures")) == [Some(0); 2], "figures of {needed}");
        ensure!((count(on, "unneeded-figures") > Some(0)) == (row["view"] == "within"), "figures of {on}");
        // Where nothing moves nothing is tested, and lamps may reach none of few figures.
        if row["scene"] == "moving" {
            ensure!(count(on, "skipped-volumes") == Some(0) && count(on, "kept-pairs") == Some(0), "{on}");
        } else if row["scene"] != "crowd" {
            ensure!(on["counts"]["fragments"] != 0, "no fragments of {on}");
            let tested = ["faces", "edges", "kept-pairs"].map(|counter| count(on, counter));
            ensure!(tested == [Some(0), Some(0), Some(pairs)], "{on}");
        }
    }
    let html = check_report(&report)?;
    ensure!(html.contains("work goes, and what is skipped"), "no section");
    ensure!(report.join("skipping_work.png").exists(), "no plot");

    // Negative controls of the checks above.
    let wrong_values = [
        ("/rows/0/section", "village".into()),
        ("/rows/1/variants/0/variant", "all-on".into()),
        ("/rows/2/variants/0/ratios", json!([])),
        ("/rows/2/variants/1/times/deform/median", 1.0.into()),
        ("/rows/3/variants/1/counts/faces", "none".into()),
        ("/rows/1/variants/1/counts/fragments", 1_000_000_000.into()),
        ("/planned_rows", 8.into()),
    ];
    for (pointer, wrong) in wrong_values {
        let mut other = data.clone();
        *other.pointer_mut(pointer).ok_or_else(|| format!("nothing is at {pointer}"))? = wrong;
        ensure!(check_data(&other).is_err(), "a wrong {pointer} passed");
    }
    Ok(())
}

fn depth_maps() -> Outcome {
    let folder = folder();
    let (times, report) = (folder.path().join("times.json"), folder.path().join("report"));
    let line = "bench --meshes none --scenes none --device cpu --depth-maps";
    let bench = || {
        let files = [times.as_os_str(), "--report".as_ref(), report.as_os_str()];
        rimline(line.split(' ').map(AsRef::as_ref).chain(files))
    };
    let rounds = |ms: f64| json!({ "rounds": [ms, 2.0 * ms, 3.0 * ms] });
    let row = |faces: u64, ms: f64| {
        let names = ["volumes of the mesh", "of the map, automatic", "lookup", "another"];
        let variant = |(times, name): (i32, &str)| {
            let frame = rounds(f64::from(times) * ms);
            json!({ "variant": name, "times": { "frame": frame, "stencil": rounds(ms / f64::from(times)) } })
        };
        let variants: Vec<Value> = (1..).zip(names).map(variant).collect();
        json!({ "faces": faces, "size": 64, "group": "a device", "variants": variants })
    };
    let good =
        json!({ "format": "rimline-depth-map-casters", "version": 2, "rows": [row(1000, 1.5), row(1_000_000, 40.0)] });
    write_file(&times, good.to_string())?;
    bench().expect(0, &[])?;
    let data = read_json(&report.join("data.json"))?;
    check_data(&data)?;
    let first = &data["rows"][0]["variants"][2];
    ensure!(first["variant"] == "lookup" && first["times"]["frame"]["median"] == 9.0, "{first:#}");
    let pass = &data["rows"][1]["variants"][1];
    ensure!(pass["variant"] == "of the map, automatic" && pass["times"]["stencil"]["median"] == 40.0, "{pass:#}");
    let html = check_report(&report)?;
    ensure!(html.contains("a device") && html.contains("of the map, automatic"), "the section is not there");
    for plot in ["depth_maps_against_meshes.png", "depth_maps_stencil_passes.png"] {
        ensure!(report.join(plot).exists(), "no {plot}");
    }
    // Refused before anything is written.
    std::fs::remove_dir_all(&report).map_err(|error| error.to_string())?;
    let mut negative = good.clone();
    negative["rows"][1]["variants"][0]["times"]["frame"]["rounds"][1] = (-1.0).into();
    let mut empty = good.clone();
    empty["rows"] = json!([]);
    let mut other = good.clone();
    other["format"] = "rimline-bench".into();
    let mut without = good.clone();
    without["rows"][0]["variants"] = Value::Null;
    for text in [
        without.to_string(),
        negative.to_string(),
        empty.to_string(),
        other.to_string(),
        "{".to_owned(),
        "3".to_owned(),
    ] {
        write_file(&times, &text)?;
        bench().expect(1, &["times.json", "it is not what `cargo bench --bench depth_maps"])?;
        ensure!(!report.exists(), "{text:.40}: a report");
    }
    Ok(())
}

fn schema_is_printed() -> Outcome {
    let run = rimline(["bench", "--schema"]);
    ensure!(run.json()? == schema()?, "another schema than the repository's");
    Ok(())
}

fn wrong_options() -> Outcome {
    let folder = folder();
    let report = folder.path().join("report").to_string_lossy().into_owned();
    let cases = [
        ("--scenes nowhere", "nowhere"),
        ("--scenes casters,nowhere", "three-sheets, casters, still, city, crowd, moving, house, big, `all` and `none`"),
        ("--meshes none --scenes none --frames 0", "--meshes"),
        ("--meshes none --scenes none --device cpu", "--meshes"),
        ("--meshes none --scene casters --frames 0 --casters none", "--meshes"),
        ("--meshes none --scene casters --frames 0 --device cpu", "--meshes"),
        ("--scenes plate-third --casters 3", "add one of them to --scenes"),
        ("--meshes none --scene city --frames 0 --casters none", "--meshes"),
        ("--meshes none --scene crowd --frames 0 --device cpu", "--meshes"),
        ("--casters 0", "--casters"),
        ("--casters 100001", "100,000"),
        ("--meshes 0", "--meshes"),
        ("--meshes 12x", "12x"),
        ("--lights 1025", "1025"),
        ("--lights 0", "--lights"),
        ("--rounds 0", "--rounds"),
        ("--light dir:0,1,0", "FILE"),
        // A model would be replaced.
        ("--quick --json model.glb", "model.glb is written as JSON; give a name that ends in .json"),
        ("--quick --json figures.png", ".json"),
    ];
    for (options, part) in cases {
        let line = ["bench", "--report", &report].into_iter().chain(options.split(' '));
        rimline(line).expect(2, &[part]).map_err(|error| format!("{options}: {error}"))?;
        is_empty(folder.path()).map_err(|error| format!("{options}: {error}"))?;
    }
    let page = folder.path().join("report.html").to_string_lossy().into_owned();
    rimline(["bench", "--quick", "--report", &page]).expect(2, &["report.html looks like a file", "folder"])?;
    is_empty(folder.path())?;
    let file = folder.path().join("file");
    write_file(&file, "in the way")?;
    for option in ["--report", "--json"] {
        let path = file.join("below").to_string_lossy().into_owned();
        rimline(["bench", option, &path]).expect(4, &["cannot be written"])?;
    }
    Ok(())
}

/// The first Ctrl-C, after the first row of very many.
#[cfg(unix)]
fn interrupted() -> Outcome {
    use std::io::{BufRead, BufReader, Read};
    use std::process::{Command, Stdio};

    let folder = folder();
    let report = folder.path().join("report");
    let mut run = with_signals(env!("CARGO_BIN_EXE_rimline"))
        .args(["bench", "--device", "cpu", "--report"])
        .arg(&report)
        .stdout(Stdio::null())
        .stderr(Stdio::piped())
        .spawn()
        .map_err(|error| error.to_string())?;
    let mut messages = BufReader::new(run.stderr.take().ok_or("no standard error")?);
    let mut text = String::new();
    while !text.contains(" 1/") {
        let read = messages.read_line(&mut text).map_err(|error| error.to_string())?;
        ensure!(read > 0, "it ended before its first row: {text}");
    }
    let kill = Command::new("kill").args(["-INT", &run.id().to_string()]).status();
    ensure!(kill.is_ok_and(|status| status.success()), "no signal could be sent");
    messages.read_to_string(&mut text).map_err(|error| error.to_string())?;
    let status = run.wait().map_err(|error| error.to_string())?;
    ensure!(status.code() == Some(130), "{status}: {text}");
    let data = read_json(&report.join("data.json"))?;
    check_data(&data)?;
    ensure!(data["complete"] == false, "it says that it is complete");
    ensure!(!rows(&data, "extraction").is_empty(), "no rows");
    let html = check_report(&report)?;
    ensure!(html.contains("This run was stopped"), "the page does not say that it was stopped");
    Ok(())
}
