//! Data held against a JSON Schema, as far as the repository's schemas go: a keyword that is not known here is an error,
//! and so is a key that the schema does not describe.

use serde_json::{Value, json};

use super::{Outcome, Test, ensure};

pub(crate) const TESTS: &[Test] = &[("schema::the_validator_finds_what_is_wrong", negative)];

/// What of `data` is not as `schema` says; `at` is where in the data this is.
pub(crate) fn validate(root: &Value, schema: &Value, data: &Value, at: &str) -> Outcome {
    let keywords = schema.as_object().ok_or("a schema is no object")?;
    for (keyword, wanted) in keywords {
        match keyword.as_str() {
            "$schema" | "$defs" | "title" | "description" | "format" => {}
            "$ref" => validate(root, referred(root, wanted)?, data, at)?,
            "allOf" => list(wanted)?.iter().try_for_each(|schema| validate(root, schema, data, at))?,
            "anyOf" => {
                let fits = list(wanted)?.iter().any(|schema| validate(root, schema, data, at).is_ok());
                ensure!(fits, "{at}: {data} is nothing of {wanted}");
            }
            "const" => ensure!(data == wanted, "{at}: {data} instead of {wanted}"),
            "enum" => ensure!(list(wanted)?.contains(data), "{at}: {data} is none of {wanted}"),
            "type" => {
                let one = [wanted.clone()];
                let types = wanted.as_array().map_or(&one[..], Vec::as_slice);
                ensure!(types.iter().any(|name| has_type(data, name)), "{at}: {data} is no {wanted}");
            }
            "minimum" => {
                let (least, number) = (wanted.as_f64(), data.as_f64());
                ensure!(number.is_none() || number >= least, "{at}: {data} is below {wanted}");
            }
            "required" => {
                for key in list(wanted)? {
                    let is_there = !data.is_object() || key.as_str().is_some_and(|key| data.get(key).is_some());
                    ensure!(is_there, "{at}: {key} is missing");
                }
            }
            "properties" => {
                for (key, schema) in wanted.as_object().ok_or("properties are no object")? {
                    if let Some(data) = data.get(key) {
                        validate(root, schema, data, &format!("{at}.{key}"))?;
                    }
                }
            }
            "items" => {
                for (index, item) in data.as_array().into_iter().flatten().enumerate() {
                    validate(root, wanted, item, &format!("{at}[{index}]"))?;
                    for key in item.as_object().into_iter().flat_map(serde_json::Map::keys) {
                        ensure!(describes(root, wanted, key)?, "{at}[{index}]: {key} is not described");
                    }
                }
            }
            other => return Err(format!("the schema's keyword {other} is not known here")),
        }
    }
    Ok(())
}

/// Whether the schema has the key among its properties, or a schema that it consists of has.
fn describes(root: &Value, schema: &Value, key: &str) -> Result<bool, String> {
    let mut parts: Vec<&Value> = Vec::new();
    if let Some(reference) = schema.get("$ref") {
        parts.push(referred(root, reference)?);
    }
    for keyword in ["allOf", "anyOf"] {
        parts.extend(schema.get(keyword).and_then(Value::as_array).into_iter().flatten());
    }
    let mut is_described = schema["properties"].get(key).is_some();
    for part in parts {
        is_described |= describes(root, part, key)?;
    }
    Ok(is_described)
}

fn referred<'a>(root: &'a Value, reference: &Value) -> Result<&'a Value, String> {
    let path = reference.as_str().and_then(|path| path.strip_prefix('#')).ok_or("a reference to elsewhere")?;
    root.pointer(path).ok_or_else(|| format!("there is no {path}"))
}

fn list(value: &Value) -> Result<&Vec<Value>, String> {
    value.as_array().ok_or_else(|| format!("{value} is no list"))
}

fn has_type(data: &Value, name: &Value) -> bool {
    match name.as_str() {
        Some("object") => data.is_object(),
        Some("array") => data.is_array(),
        Some("string") => data.is_string(),
        Some("integer") => data.is_u64() || data.is_i64(),
        Some("number") => data.is_number(),
        Some("boolean") => data.is_boolean(),
        Some("null") => data.is_null(),
        _ => false,
    }
}

fn negative() -> Outcome {
    let schema = json!({
        "type": "object",
        "required": ["a", "list"],
        "properties": {
            "a": { "type": ["integer", "null"], "minimum": 1 },
            "b": { "enum": ["x", "y"] },
            "list": { "type": "array", "items": { "allOf": [{ "$ref": "#/$defs/n" }] } },
        },
        "$defs": { "n": { "type": "object", "required": ["n"], "properties": { "n": { "type": "number" } } } },
    });
    let check = |data: &Value| validate(&schema, &schema, data, "$");
    for good in [json!({ "a": 1, "list": [] }), json!({ "a": null, "b": "y", "list": [{ "n": 0.5 }] })] {
        check(&good)?;
    }
    for bad in [
        json!([]),
        json!({ "a": 1 }),
        json!({ "a": 0, "list": [] }),
        json!({ "a": 1.5, "list": [] }),
        json!({ "a": 1, "b": "z", "list": [] }),
        json!({ "a": 1, "list": [{}] }),
        json!({ "a": 1, "list": [{ "n": "0" }] }),
        json!({ "a": 1, "list": [{ "n": 0, "m": 0 }] }),
    ] {
        ensure!(check(&bad).is_err(), "{bad} passed");
    }
    let unknown = json!({ "maximum": 3 });
    ensure!(validate(&unknown, &unknown, &json!(2), "$").is_err(), "an unknown keyword passed");
    Ok(())
}
