//! SVG, PDF, DXF and JSON of one drawing, read by readers of their own: they hold the same lines.

use std::collections::BTreeMap;

use lopdf::content::Content;
use lopdf::{Dictionary, Document, Object};
use rimline_models::figure::{Figure, glb};
use rimline_testkit::shapes;
use serde_json::Value;

use super::super::archive::entry;
use super::super::makers::npz_model;
use super::super::run::{Folder, folder};
use super::super::{Outcome, Test, ensure, schema};

pub(crate) const TESTS: &[Test] = &[
    ("drawings::all_formats_hold_the_same_lines", formats_agree),
    ("drawings::dxf_has_coordinates_of_the_files", dxf_has_coordinates),
    ("drawings::json_is_as_its_schema_says", json_has_its_schema),
    ("drawings::json_has_numbers_of_the_files", json_has_numbers),
];

/// A polyline: its layer, whether it is closed, and its points in micrometres from the lower left corner.
type Line = (String, bool, Vec<[i64; 2]>);

fn text(error: impl std::fmt::Display) -> String {
    error.to_string()
}

/// The size of the page in micrometres, and its lines in order.
type Page = ([i64; 2], Vec<Line>);

fn page(size_mm: [f64; 2], mut lines: Vec<Line>) -> Page {
    lines.sort();
    (size_mm.map(micrometres), lines)
}

fn micrometres(mm: f64) -> i64 {
    (1000.0 * mm).round() as i64
}

/// The value of an attribute of the first tag of a text.
fn attribute<'a>(tag: &'a str, name: &str) -> Result<&'a str, String> {
    let after = tag.split_once(&format!(" {name}=\"")).ok_or_else(|| format!("no {name}: {tag:.200}"))?.1;
    Ok(after.split_once('"').ok_or("no end")?.0)
}

fn of_svg(svg: &str) -> Result<Page, String> {
    let side = |name| attribute(svg, name)?.strip_suffix("mm").ok_or("no millimetres")?.parse::<f64>().map_err(text);
    let size = [side("width")?, side("height")?];
    let mut lines = Vec::new();
    for group in svg.split("<g").skip(1) {
        let layer = attribute(group, "id")?;
        for path in group.split("<path").skip(1) {
            for part in attribute(path, "d")?.split('M').skip(1) {
                let (points, is_closed) = part.strip_suffix('z').map_or((part, false), |points| (points, true));
                let spaced = points.replace('l', " ").replace('-', " -");
                let numbers: Vec<f64> =
                    spaced.split_whitespace().map(str::parse).collect::<Result<_, _>>().map_err(text)?;
                let mut at = [0, micrometres(size[1])];
                let steps = numbers.as_chunks().0.iter().map(|&[dx, dy]| {
                    at = [at[0] + micrometres(dx), at[1] - micrometres(dy)];
                    at
                });
                lines.push((layer.to_owned(), is_closed, steps.collect()));
            }
        }
    }
    Ok(page(size, lines))
}

fn of_pdf(bytes: &[u8]) -> Result<Page, String> {
    let document = Document::load_mem(bytes).map_err(text)?;
    let id = *document.get_pages().get(&1).ok_or("no page")?;
    ensure!(document.get_pages().len() == 1, "it has several pages");
    let dictionary = document.get_dictionary(id).map_err(text)?;
    let unit = dictionary.get(b"UserUnit").and_then(Object::as_float).unwrap_or(1.0);
    let per_point = f64::from(unit) * 25.4 / 72.0;
    let sides = dictionary.get(b"MediaBox").and_then(Object::as_array).map_err(text)?;
    let sides: Vec<f64> = sides.iter().filter_map(|side| Some(per_point * f64::from(side.as_float().ok()?))).collect();
    let [0.0, 0.0, width, height] = sides[..] else { return Err(format!("a page from {sides:?}")) };
    // Names of layers by their keys in the page's resources.
    let resources = dictionary.get(b"Resources").and_then(Object::as_dict).map_err(text)?;
    let mut layers = BTreeMap::new();
    for (key, group) in resources.get(b"Properties").and_then(Object::as_dict).map_err(text)? {
        let group: &Dictionary = group.as_reference().and_then(|id| document.get_dictionary(id)).map_err(text)?;
        let name = group.get(b"Name").and_then(lopdf::decode_text_string).map_err(text)?;
        layers.insert(key.clone(), name);
    }
    let content = Content::decode(&document.get_page_content(id)).map_err(text)?;
    let (mut lines, mut points, mut layer) = (Vec::new(), Vec::new(), None);
    for operation in content.operations {
        match &*operation.operator {
            "BDC" => {
                let key = operation.operands.get(1).ok_or("no layer")?.as_name().map_err(text)?;
                layer = Some(layers.get(key).ok_or("a layer without a name")?.clone());
            }
            "EMC" => layer = None,
            "m" | "l" => {
                let numbers = operation.operands.iter().map(|number| number.as_float().map_err(text));
                let numbers: Vec<f32> = numbers.collect::<Result<_, _>>()?;
                let [x, y] = numbers[..] else { return Err(format!("no point: {numbers:?}")) };
                ensure!((operation.operator == "m") == points.is_empty(), "a path does not begin with a move");
                points.push([x, y].map(|points| micrometres(f64::from(points) * per_point)));
            }
            "S" | "s" => {
                let layer = layer.clone().ok_or("a line is in no layer")?;
                lines.push((layer, operation.operator == "s", std::mem::take(&mut points)));
            }
            "J" | "j" | "w" | "d" | "RG" => {}
            other => return Err(format!("operator {other}")),
        }
    }
    Ok(page([width, height], lines))
}

/// The group codes of a DXF with their values.
fn pairs(dxf: &str) -> Result<Vec<(u32, &str)>, String> {
    let lines: Vec<&str> = dxf.lines().collect();
    ensure!(lines.len().is_multiple_of(2), "a code has no value");
    let pairs = lines.as_chunks().0.iter();
    pairs.map(|&[code, value]| Ok((code.trim().parse().map_err(|error| format!("{code}: {error}"))?, value))).collect()
}

/// The numbers of a header variable.
fn variable(pairs: &[(u32, &str)], name: &str) -> Result<Vec<f64>, String> {
    let at = pairs.iter().position(|pair| *pair == (9, name)).ok_or_else(|| format!("no {name}"))?;
    let values = pairs[at + 1..].iter().take_while(|(code, _)| ![0, 9].contains(code));
    values.map(|(_, value)| value.trim().parse().map_err(text)).collect()
}

fn of_dxf(dxf: &str) -> Result<Page, String> {
    let pairs = pairs(dxf)?;
    ensure!(pairs.last() == Some(&(0, "EOF")), "it does not end");
    let [width, height] = variable(&pairs, "$LIMMAX")?[..] else { return Err("no limits".into()) };
    let section = |name| pairs.windows(2).position(|two| two == [(0, "SECTION"), (2, name)]).ok_or("no section");
    let [tables, entities] = [section("TABLES")?, section("ENTITIES")?];
    let of_kind =
        |kind: &'static str| pairs[tables..entities].iter().enumerate().filter(move |(_, pair)| **pair == (0, kind));
    let layers: Vec<&str> = of_kind("LAYER").map(|(at, _)| pairs[tables + at + 1].1).collect();
    let (mut lines, mut is_in_polyline) = (Vec::<Line>::new(), false);
    for entity in pairs[entities + 2..].chunk_by(|_, next| next.0 != 0) {
        let value = |wanted: u32| entity.iter().find(|(code, _)| *code == wanted).map(|(_, value)| value.trim());
        let number =
            |code: u32| value(code).ok_or("a number is missing")?.parse::<f64>().map(micrometres).map_err(text);
        if ["ENDSEC", "EOF"].contains(&entity[0].1) {
            continue;
        }
        let layer = value(8).ok_or("an entity is in no layer")?;
        ensure!(layers.contains(&layer), "the layer {layer} is in no table");
        let layer = layer.to_lowercase();
        match (entity[0].1, is_in_polyline) {
            ("LINE", false) => lines.push((layer, false, vec![[number(10)?, number(20)?], [number(11)?, number(21)?]])),
            ("POLYLINE", false) => {
                lines.push((layer, value(70) == Some("1"), Vec::new()));
                is_in_polyline = true;
            }
            ("VERTEX", true) => {
                let (layer_of_line, _, points) = lines.last_mut().ok_or("no polyline")?;
                ensure!(*layer_of_line == layer, "a vertex is in another layer");
                points.push([number(10)?, number(20)?]);
            }
            ("SEQEND", true) => is_in_polyline = false,
            (other, _) => return Err(format!("an entity {other}")),
        }
    }
    Ok(page([width, height], lines))
}

fn of_json(json: &Value) -> Result<Page, String> {
    let point = |point: &Value| [0, 1].map(|axis| micrometres(point[axis].as_f64().unwrap_or(f64::NAN)));
    let (list, number) =
        (|key: &str| json[key].as_array().ok_or("no list"), |value: &Value| value.as_u64().unwrap_or(0));
    let (spans, mut lines) = (list("spans")?, Vec::new());
    for chain in list("chains")? {
        let first = number(&chain["first"]) as usize;
        let spans = &spans[first..first + number(&chain["count"]) as usize];
        let is_closed = chain["closed"] == true;
        let last = spans.last().filter(|_| !is_closed).map(|span| point(&span["page"][1]));
        let mut points: Vec<_> = spans.iter().map(|span| point(&span["page"][0])).chain(last).collect();
        points.dedup();
        if is_closed && points.len() > 1 && points.first() == points.last() {
            points.pop();
        }
        let visible = if chain["hidden"] == true { "hidden" } else { "visible" };
        let class = chain["class"].as_str().ok_or("no class")?;
        if points.len() > 1 {
            lines.push((format!("{class}-{visible}"), is_closed, points));
        }
    }
    let size = [0, 1].map(|axis| json["page_mm"][axis].as_f64().unwrap_or(f64::NAN));
    Ok(page(size, lines))
}

/// Draws in all formats and reads them.
fn drawn(folder: &Folder, options: &str) -> Result<[(&'static str, Page); 4], String> {
    let written = |ending: &str| {
        folder.run(&format!("lines {options} --out @drawing.{ending}")).expect(0, &[])?;
        folder.read(format!("drawing.{ending}"))
    };
    let read = |ending: &str| String::from_utf8(written(ending)?).map_err(text);
    let json = serde_json::from_str(&read("json")?).map_err(text)?;
    Ok([
        ("JSON", of_json(&json)?),
        ("SVG", of_svg(&read("svg")?)?),
        ("PDF", of_pdf(&written("pdf")?)?),
        ("DXF", of_dxf(&read("dxf")?)?),
    ])
}

fn models(folder: &Folder) -> Outcome {
    folder.write("torus.npz", npz_model(&shapes::torus(24, 16, 1.0, 0.4), 1.0, [0.0; 3]))?;
    folder.write("cube.npz", npz_model(&shapes::cube(), 0.4, [0.9, 0.1, 0.2]))?;
    folder.write("figure.glb", glb::encode(&Figure::new()))
}

/// Whether all is equal, but for a micrometre of rounding.
fn is_same((layer, is_closed, points): &Line, (other, is_other_closed, others): &Line) -> bool {
    let is_near = |(a, b): (&[i64; 2], &[i64; 2])| a[0].abs_diff(b[0]) <= 1 && a[1].abs_diff(b[1]) <= 1;
    let is_like = (layer, is_closed, points.len()) == (other, is_other_closed, others.len());
    is_like && points.iter().zip(others).all(is_near)
}

fn formats_agree() -> Outcome {
    let folder = folder();
    models(&folder)?;
    let mut drawings = Vec::new();
    for options in [
        "@torus.npz @cube.npz --hidden dashed --view 30,25 --crease 10",
        "@figure.glb --hidden thin --eye 1,2,3 --fov 40",
        "@cube.npz --hidden dashed --page 8000x7000 --view 10,10",
    ] {
        let [json, others @ ..] = drawn(&folder, options)?;
        ensure!(json.1.1.iter().any(|(layer, ..)| layer.ends_with("hidden")), "{options}: nothing is hidden");
        for (format, page) in others {
            ensure!(page.0 == json.1.0, "{options}: {format} has a page of {:?}, and JSON of {:?}", page.0, json.1.0);
            let apart = page.1.iter().zip(&json.1.1).find(|(line, expected)| !is_same(line, expected));
            let [found, all] = [page.1.len(), json.1.1.len()];
            ensure!(
                apart.is_none() && found == all,
                "{options}: {format}: {found} of {all} lines, differing: {apart:?}"
            );
        }
        drawings.push(json);
    }
    ensure!(drawings[0].1.1 != drawings[1].1.1, "drawings are not told apart");
    Ok(())
}

/// In the unit of the files the ends of lines are where JSON has them in the world, as seen from the top.
fn dxf_has_coordinates() -> Outcome {
    let folder = folder();
    for (at, scale) in [([1250.0, 3.0, -77.5], 20.0), ([0.0; 3], 1e-3)] {
        folder.write("torus.npz", npz_model(&shapes::torus(24, 16, 1.0, 0.4), scale, at))?;
        for (ending, options) in [("dxf", "--dxf-units model --unit mm --hidden thin"), ("json", "")] {
            let line = format!("lines @torus.npz --view top --crease 10 {options} --out @drawing.{ending}");
            folder.run(&line).expect(0, &[])?;
        }
        let dxf = String::from_utf8(folder.read("drawing.dxf")?).map_err(text)?;
        let pairs = pairs(&dxf)?;
        ensure!(variable(&pairs, "$INSUNITS")? == [4.0], "its unit is no millimetre");
        let begin = pairs.iter().position(|pair| *pair == (2, "ENTITIES")).ok_or("no entities")?;
        let entities = pairs[begin + 1..].chunk_by(|_, next| next.0 != 0).filter(|entity| entity[0].1 != "POLYLINE");
        let values = |codes: [u32; 2]| {
            let values = entities.clone().flatten().filter(move |(code, _)| codes.contains(code));
            values.map(|(_, value)| value.parse::<f64>().unwrap_or(f64::NAN))
        };
        let found: Vec<[f64; 2]> = values([10, 11]).zip(values([20, 21])).map(|(x, y)| [x, y]).collect();
        let drawing: Value = serde_json::from_slice(&folder.read("drawing.json")?).map_err(text)?;
        let spans = drawing["spans"].as_array().ok_or("no spans")?;
        let ends = spans.iter().flat_map(|span| span["world"].as_array().into_iter().flatten());
        let ends = ends.filter_map(|end| Some([end[0].as_f64()?, -end[2].as_f64()?]));
        let expected: Vec<[f64; 2]> = ends.collect();
        ensure!(expected.len() > 50 && found.len() > 50, "{} and {} points", expected.len(), found.len());
        let near = 1e-9 * f64::from(scale + at[0].abs());
        let is_near = |p: &[f64], q: &[f64]| p.iter().zip(q).all(|(p, q)| (p - q).abs() <= near);
        let is_there = |list: &[[f64; 2]], p: &[f64; 2]| list.iter().any(|q| is_near(p, q));
        let lost = expected.iter().find(|p| !is_there(&found, p)).or(found.iter().find(|p| !is_there(&expected, p)));
        ensure!(lost.is_none(), "a point is in one file and not in the other: {lost:?}");
        let low = variable(&pairs, "$EXTMIN")?;
        let least = [0, 1].map(|axis| expected.iter().map(|p| p[axis]).fold(f64::INFINITY, f64::min));
        ensure!(is_near(&low, &least), "extents from {low:?}, not {least:?}");
    }
    Ok(())
}

fn json_has_its_schema() -> Outcome {
    let schema: Value = serde_json::from_str(include_str!("../../../../../docs/lines.schema.json")).map_err(text)?;
    let folder = folder();
    models(&folder)?;
    for options in ["@torus.npz @cube.npz @figure.glb --view 30,25", "@cube.npz @torus.npz --fov 40 --no-weld"] {
        folder.run(&format!("lines {options} --out @drawing.json")).expect(0, &[])?;
        let mut drawing: Value = serde_json::from_slice(&folder.read("drawing.json")?).map_err(text)?;
        schema::validate(&schema, &drawing)?;
        for (pointer, wrong) in [
            ("/spans/0/class", serde_json::json!("edge")),
            ("/spans/0/faces_in_front", serde_json::json!(-1)),
            ("/spans/0/world/0/0", serde_json::json!(null)),
            ("/chains/0/closed", serde_json::json!(0)),
            ("/view", serde_json::json!({ "eye": [0.0, 0.0, 1.0, 0.0] })),
        ] {
            let value = drawing.pointer_mut(pointer).ok_or("nothing is there")?;
            let right = std::mem::replace(value, wrong);
            ensure!(schema::validate(&schema, &drawing).is_err(), "a wrong {pointer} passed");
            *drawing.pointer_mut(pointer).ok_or("nothing is there")? = right;
        }
    }
    Ok(())
}

/// The rows of an array of numbers of 32 bits.
fn rows<const N: usize>(archive: &[u8], name: &str) -> Result<Vec<[u32; N]>, String> {
    let words: Vec<u32> =
        entry(archive, name)?.bytes[128..].as_chunks().0.iter().map(|bytes| u32::from_le_bytes(*bytes)).collect();
    Ok(words.as_chunks().0.to_vec())
}

/// Edges and faces are those of `extract`, also behind faces that are not finite: spans lie on them.
fn json_has_numbers() -> Outcome {
    let folder = folder();
    models(&folder)?;
    let mut torus = shapes::torus(24, 16, 1.0, 0.4);
    torus.positions[0] = [f32::NAN; 3];
    folder.write("torn.npz", npz_model(&torus, 1.0, [0.0; 3]))?;
    let mut meshes = Vec::new();
    for model in ["cube", "torn"] {
        let line = format!("extract @{model}.npz --device cpu --light dir:0,0,1 --out @extracted.npz");
        folder.run(&line).expect(0, &[])?;
        let archive = folder.read("extracted.npz")?;
        let positions = rows::<3>(&archive, "positions")?;
        let positions: Vec<[f64; 3]> = positions.iter().map(|p| p.map(|bits| f32::from_bits(bits).into())).collect();
        meshes.push((positions, rows::<3>(&archive, "faces")?, rows::<2>(&archive, "edges")?));
    }
    let line = "lines @cube.npz @torn.npz --crease 10 --view 30,25 --hidden thin --out @drawing.json";
    folder.run(line).expect(0, &[])?;
    let drawing: Value = serde_json::from_slice(&folder.read("drawing.json")?).map_err(text)?;
    let number = |value: &Value| value.as_u64().map_or(usize::MAX, |number| number as usize);
    let mut found = BTreeMap::new();
    for span in drawing["spans"].as_array().ok_or("no spans")? {
        let ends = [0, 1].map(|end| [0, 1, 2].map(|axis| span["world"][end][axis].as_f64().unwrap_or(f64::NAN)));
        // In the box around these vertices.
        let is_between = |mesh: usize, vertices: &[u32]| {
            let (positions, ..) = &meshes[mesh];
            (0..3).all(|axis| {
                let all = || vertices.iter().map(|&vertex| positions[vertex as usize][axis]);
                let (low, high) = (all().fold(f64::INFINITY, f64::min), all().fold(f64::NEG_INFINITY, f64::max));
                ends.iter().all(|end| end[axis] >= low - 1e-6 && end[axis] <= high + 1e-6)
            })
        };
        let mesh = number(&span["object"]);
        let edge = span["edge"].as_u64().map(|edge| meshes[mesh].2[edge as usize]);
        ensure!(edge.is_none_or(|edge| is_between(mesh, &edge)), "it is not on its edge: {span}");
        for face in span["faces"].as_array().ok_or("no faces")? {
            let mesh = number(&face["object"]);
            let corners = meshes[mesh].1[number(&face["face"])];
            let has_edge = edge.is_none_or(|edge| edge.iter().all(|vertex| corners.contains(vertex)));
            ensure!(has_edge && is_between(mesh, &corners), "it is not on its face {face}: {span}");
        }
        *found.entry(span["class"].as_str().ok_or("no class")?).or_insert(0) += 1;
    }
    for class in ["silhouette", "boundary", "crease", "intersection"] {
        ensure!(found.contains_key(class), "no {class}: {found:?}");
    }
    Ok(())
}
