//! Data held against a JSON Schema. The crate `jsonschema` decides; two rules are added for these tests alone: a key that
//! the schema does not describe is an error, and so is a keyword that is not in the list below, since JSON Schema passes
//! over misspelt ones.

use serde_json::{Value, json};

use super::{Outcome, Test, ensure};

pub(crate) const TESTS: &[Test] = &[
    ("schema::the_validator_finds_what_is_wrong", negative),
    ("schema::the_bench_schema_finds_what_is_wrong", bench_negative),
];

const KEYWORDS: [&str; 15] = [
    "$defs",
    "$ref",
    "$schema",
    "allOf",
    "anyOf",
    "const",
    "description",
    "enum",
    "format",
    "items",
    "minimum",
    "properties",
    "required",
    "title",
    "type",
];

/// Everything in `data` that is not as `schema` says, with where in the data it is.
pub(crate) fn validate(schema: &Value, data: &Value) -> Outcome {
    jsonschema::meta::validate(schema).map_err(|error| format!("the schema is none: {error}"))?;
    let mut closed = schema.clone();
    close(&mut closed, true)?;
    let options = jsonschema::options().should_validate_formats(true);
    let validator = options.build(&closed).map_err(|error| format!("the schema is none: {error}"))?;
    let errors: Vec<String> =
        validator.iter_errors(data).map(|error| format!("at {}: {error}", error.instance_path())).collect();
    ensure!(errors.is_empty(), "{}", errors.join("\n"));
    Ok(())
}

/// Forbids keys that are not described. A part of another schema (`is_whole` false) leaves that to the whole one, which
/// sees the keys of all its parts.
fn close(schema: &mut Value, is_whole: bool) -> Outcome {
    let schema = schema.as_object_mut().ok_or("a schema is no object")?;
    for (keyword, value) in schema.iter_mut() {
        ensure!(KEYWORDS.contains(&&**keyword), "the schema's keyword {keyword} is not known here");
        match (keyword.as_str(), value) {
            ("properties", Value::Object(schemas)) => {
                schemas.values_mut().try_for_each(|schema| close(schema, true))?;
            }
            ("$defs", Value::Object(schemas)) => schemas.values_mut().try_for_each(|schema| close(schema, false))?,
            ("allOf" | "anyOf", Value::Array(schemas)) => {
                schemas.iter_mut().try_for_each(|schema| close(schema, false))?;
            }
            ("items", schema) => close(schema, true)?,
            _ => {}
        }
    }
    if is_whole {
        schema.insert("unevaluatedProperties".to_owned(), json!(false));
    }
    Ok(())
}

fn negative() -> Outcome {
    let schema = json!({
        "type": "object",
        "required": ["a", "list"],
        "properties": {
            "a": { "type": ["integer", "null"], "minimum": 1 },
            "b": { "enum": ["x", "y"] },
            "day": { "type": "string", "format": "date-time" },
            "list": { "type": "array", "items": { "allOf": [{ "$ref": "#/$defs/n" }] } },
        },
        "$defs": { "n": { "type": "object", "required": ["n"], "properties": { "n": { "type": "number" } } } },
    });
    for good in [
        json!({ "a": 1, "list": [], "day": "2026-01-02T03:04:05Z" }),
        json!({ "a": null, "b": "y", "list": [{ "n": 0.5 }] }),
    ] {
        validate(&schema, &good)?;
    }
    for bad in [
        json!([]),
        json!({ "a": 1 }),
        json!({ "a": 0, "list": [] }),
        json!({ "a": 1.5, "list": [] }),
        json!({ "a": 1, "b": "z", "list": [] }),
        json!({ "a": 1, "day": "2026-13-02T03:04:05Z", "list": [] }),
        json!({ "a": 1, "list": [{}] }),
        json!({ "a": 1, "list": [{ "n": "0" }] }),
        json!({ "a": 1, "list": [{ "n": 0, "m": 0 }] }),
        json!({ "a": 1, "c": 1, "list": [] }),
    ] {
        ensure!(validate(&schema, &bad).is_err(), "{bad} passed");
    }
    for wrong in [json!({ "maximun": 3 }), json!({ "type": "nothing" }), json!({ "$ref": "#/$defs/nowhere" })] {
        ensure!(validate(&wrong, &json!(2)).is_err(), "the schema {wrong} passed");
    }
    Ok(())
}

/// The repository's schema with data of one row, and with that row changed.
fn bench_negative() -> Outcome {
    let schema = super::bench::schema()?;
    let summary = json!({ "median": 2.0, "q1": 1.0, "q3": 3.0, "low": 1.0, "high": 3.0, "runs": 3 });
    let mut ratio = summary.clone();
    ratio["to"] = json!("cpu-f32-all");
    let result = json!({
        "method": "cpu-exact-all", "wall_ms": summary, "wall_ms_of_rounds": [2.0, 1.0, 3.0], "gpu_ms": null,
        "gpu_ms_of_rounds": [], "stages": [{ "stage": "facing", "ms": 1.5 }], "ratios": [ratio],
        "wrong_facing_bits": 0, "wrong_silhouette_bits": 0, "unclosed_vertices": 0, "undecided_pairs": 7,
    });
    let row = json!({ "subject": "torus-4", "lights": 1, "facing_bits": 4, "silhouette_bits": 6, "results": [result] });
    let mut part = json!({ "part": "extraction", "scene_ms": summary, "merged_ms": summary, "ratio": null });
    let scene = json!({
        "mesh": "box", "faces": 12, "casters": 3, "scene_bytes": 4800, "scene_bytes_per_caster": 1600.0,
        "scene_device_bytes": 9000, "extractors_device_bytes": null, "gpu": [part], "silhouette_edges": [12, 14],
        "wrong_lights": 0,
        "recording": [{ "method": "scene-still", "cpu_ms": summary, "cpu_ms_of_rounds": [1.0, 2.0, 3.0] }],
    });
    let merged = part.as_object_mut().and_then(|part| part.remove("merged_ms"));
    part["extractor_ms"] = merged.ok_or("no merged mesh")?;
    part["ratio"] = summary.clone();
    let one_mesh = json!({ "faces": 1024, "gpu": [part], "silhouette_edges": [60, 70], "wrong_lights": 0 });
    let casters = json!({ "planned_rows": 2, "lights": 2, "size": 256, "rows": [scene], "one_mesh": [one_mesh] });
    let counters = json!([{ "counter": "faces", "count": 12 }]);
    let variant = json!({
        "variant": "all-off", "parts": [{ "part": "compute", "ms": summary, "ratio": null }],
        "parts_of_frame": summary, "stages": [{ "stage": "facing", "ms": summary }], "counters": counters, "fragments": null,
        "fragments_ratio": 1.5,
    });
    let row_of_skipping = json!({
        "scene": "city", "view": "oblique", "casters": 1, "faces": 12, "lights": 1, "pairs_in_range": 0, "variants": [variant],
    });
    let levels = json!([{ "id": "shadow-reach", "name": "shadow reach" }]);
    let skipping = json!({ "planned_rows": 1, "size": 256, "levels": levels, "rows": [row_of_skipping] });
    let data = json!({
        "format": "rimline-bench", "version": 1, "complete": true, "rimline": "0.1.0", "date": "2026-01-02T03:04:05Z",
        "machine": { "os": "Linux", "cpu": "one", "threads": 1, "optimised": true }, "adapter": null, "shadows": null,
        "casters": casters, "skipping": skipping, "depth_maps": null,
        "extraction": { "planned_rows": 1, "methods": [], "subjects": [], "rows": [row] },
    });
    validate(&schema, &data)?;
    for (pointer, wrong) in [
        ("/format", json!("other")),
        ("/depth_maps", json!("none")),
        ("/date", json!("yesterday")),
        ("/machine/threads", json!(0)),
        ("/extraction/rows/0/lights", json!(1.5)),
        ("/extraction/rows/0/results/0/gpu_ms", json!({ "median": 1.0 })),
        ("/extraction/rows/0/results/0/stages/0/ms", json!(-1.0)),
        ("/extraction/rows/0/results/0/ratios/0/to", json!(3)),
        ("/extraction/rows/0/results/0/ratios/0/runs", json!(null)),
        ("/casters/lights", json!(0)),
        ("/casters/rows/0/mesh", json!("sphere")),
        ("/casters/rows/0/recording/0/method", json!("other")),
        ("/casters/rows/0/recording/0/cpu_ms", json!(null)),
        ("/casters/rows/0/scene_device_bytes", json!(-1)),
        ("/casters/rows/0/gpu/0/part", json!("light")),
        ("/casters/rows/0/gpu/0/ratio", json!(1.2)),
        ("/casters/rows/0/silhouette_edges/0", json!(0.5)),
        ("/casters/one_mesh/0/gpu", json!(null)),
        ("/casters/one_mesh/0/wrong_lights", json!("none")),
        ("/skipping/rows/0/scene", json!("casters")),
        ("/skipping/rows/0/view", json!("above")),
        ("/skipping/rows/0/casters", json!(0)),
        ("/skipping/rows/0/variants/0/parts/0/part", json!("light")),
        ("/skipping/rows/0/variants/0/parts/0/ms", json!(null)),
        ("/skipping/rows/0/variants/0/stages/0/ms", json!(1.0)),
        ("/skipping/rows/0/variants/0/counters/0/count", json!(-1)),
        ("/skipping/rows/0/variants/0/parts_of_frame", json!(1.0)),
        ("/skipping/rows/0/variants/0/fragments", json!(0.5)),
        ("/skipping/rows/0/variants/0/fragments_ratio", json!("none")),
        ("/skipping/levels/0", json!("shadow-reach")),
    ] {
        let mut changed = data.clone();
        *changed.pointer_mut(pointer).ok_or("nothing is there")? = wrong;
        ensure!(validate(&schema, &changed).is_err(), "a wrong {pointer} passed");
    }
    let places = ["", "/machine", "/extraction/rows/0", "/extraction/rows/0/results/0/ratios/0"];
    for place in places.into_iter().chain([
        "/casters",
        "/casters/rows/0/gpu/0",
        "/casters/one_mesh/0",
        "/skipping",
        "/skipping/rows/0/variants/0",
    ]) {
        let mut changed = data.clone();
        changed.pointer_mut(place).ok_or("nothing is there")?["unheard_of"] = json!(0);
        ensure!(validate(&schema, &changed).is_err(), "a key that is not described passed at `{place}`");
    }
    Ok(())
}
