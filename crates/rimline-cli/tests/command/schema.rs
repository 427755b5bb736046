//! Data held against a JSON Schema, by the keywords of `bench.schema.json` and `docs/lines.schema.json`. Two rules are
//! stricter than the standard's: a key that the schema does not describe is an error, and so is a keyword that is not known
//! here, since JSON Schema passes over misspelt ones.

use std::collections::BTreeSet;

use serde_json::{Value, json};

use super::{Outcome, Test, ensure};

pub(crate) const TESTS: &[Test] = &[("schema::the_validator_finds_what_is_wrong", negative)];

/// Nothing, or what in `data` is not as `schema` says, with where in the data it is.
pub(crate) fn validate(schema: &Value, data: &Value) -> Outcome {
    is_understood(schema, schema)?;
    whole(schema, schema, data, "the top")
}

/// Every part of the schema is one that `part` knows.
fn is_understood(root: &Value, schema: &Value) -> Outcome {
    for (keyword, rule) in schema.as_object().ok_or("a schema is no object")? {
        let is_known = match (keyword.as_str(), rule) {
            ("properties" | "$defs", Value::Object(schemas)) => {
                schemas.values().try_for_each(|schema| is_understood(root, schema))?;
                true
            }
            ("allOf" | "anyOf", Value::Array(schemas)) => {
                schemas.iter().try_for_each(|schema| is_understood(root, schema))?;
                true
            }
            ("items" | "additionalProperties", schema) => is_understood(root, schema).map(|()| true)?,
            ("type", kinds) => kinds_of(kinds)
                .all(|kind| ["null", "boolean", "integer", "number", "string", "array", "object"].contains(&kind)),
            ("$ref", Value::String(to)) => to.strip_prefix('#').is_some_and(|to| root.pointer(to).is_some()),
            ("required", Value::Array(keys)) => keys.iter().all(Value::is_string),
            ("format", format) => format == "date-time",
            ("minimum", rule) => rule.is_number(),
            ("enum", rule) => rule.is_array(),
            ("$schema" | "description" | "title", rule) => rule.is_string(),
            (keyword, _) => keyword == "const",
        };
        ensure!(is_known, "the schema's {keyword} is not known here: {rule}");
    }
    Ok(())
}

/// The names in a `type`, which are one or a list.
fn kinds_of(kinds: &Value) -> impl Iterator<Item = &str> {
    let list = kinds.as_array().map_or(std::slice::from_ref(kinds), Vec::as_slice);
    list.iter().map(|kind| kind.as_str().unwrap_or("no name"))
}

/// The data are as the schema says, and all their keys are described.
fn whole(root: &Value, schema: &Value, data: &Value, at: &str) -> Outcome {
    let mut described = BTreeSet::new();
    part(root, schema, data, at, &mut described)?;
    let other = data.as_object().into_iter().flatten().find(|(key, _)| !described.contains(*key));
    ensure!(other.is_none(), "at {at}: the key {other:?} is not described");
    Ok(())
}

/// The data are as the schema says, which adds the keys that it describes.
fn part(root: &Value, schema: &Value, data: &Value, at: &str, described: &mut BTreeSet<String>) -> Outcome {
    let list = |rule: &Value| rule.as_array().cloned().unwrap_or_default();
    for (keyword, rule) in schema.as_object().into_iter().flatten() {
        let is_met = match keyword.as_str() {
            "type" => kinds_of(rule).any(|kind| is_a(kind, data)),
            "const" => data == rule,
            "enum" => list(rule).contains(data),
            "minimum" => data.as_f64().is_none_or(|number| Some(number) >= rule.as_f64()),
            "format" => data.as_str().is_none_or(is_time),
            "required" => {
                !data.is_object() || list(rule).iter().all(|key| data.get(key.as_str().unwrap_or("")).is_some())
            }
            "properties" => {
                for (key, schema) in rule.as_object().into_iter().flatten() {
                    described.insert(key.clone());
                    data.get(key).map_or(Ok(()), |value| whole(root, schema, value, &format!("{at}, {key}")))?;
                }
                true
            }
            "additionalProperties" => {
                let known = schema["properties"].as_object();
                let mut others = data.as_object().into_iter().flatten();
                others.try_for_each(|(key, value)| {
                    if known.is_some_and(|known| known.contains_key(key)) {
                        return Ok(());
                    }
                    described.insert(key.clone());
                    whole(root, rule, value, &format!("{at}, {key}"))
                })?;
                true
            }
            "items" => {
                let mut items = data.as_array().into_iter().flatten().enumerate();
                items.try_for_each(|(index, item)| whole(root, rule, item, &format!("{at}, {index}")))?;
                true
            }
            "allOf" => {
                list(rule).iter().try_for_each(|schema| part(root, schema, data, at, described)).map(|()| true)?
            }
            "anyOf" => list(rule).iter().fold(false, |is_met, schema| {
                let mut keys = BTreeSet::new();
                let is_this = part(root, schema, data, at, &mut keys).is_ok();
                described.extend(keys.into_iter().filter(|_| is_this));
                is_met || is_this
            }),
            "$ref" => {
                let to = rule.as_str().and_then(|to| root.pointer(&to[1..])).ok_or("a reference leads nowhere")?;
                part(root, to, data, at, described).map(|()| true)?
            }
            _ => true,
        };
        ensure!(is_met, "at {at}: {data} is not as `{keyword}` says: {rule}");
    }
    Ok(())
}

fn is_a(kind: &str, data: &Value) -> bool {
    match kind {
        "null" => data.is_null(),
        "boolean" => data.is_boolean(),
        "integer" => data.as_f64().is_some_and(|number| number.fract() == 0.0),
        "number" => data.is_number(),
        "string" => data.is_string(),
        "array" => data.is_array(),
        _ => data.is_object(),
    }
}

/// A moment in UTC in the one form that is written.
fn is_time(text: &str) -> bool {
    let shape: String = text.chars().map(|c| if c.is_ascii_digit() { '0' } else { c }).collect();
    let is_below = |(at, end): (usize, u32)| text[at..at + 2].parse::<u32>().is_ok_and(|number| number < end);
    shape == "0000-00-00T00:00:00Z" && [(5, 13), (8, 32), (11, 24), (14, 60), (17, 60)].into_iter().all(is_below)
}

fn negative() -> Outcome {
    let schema = json!({
        "type": "object",
        "required": ["a", "list"],
        "properties": {
            "a": { "type": ["integer", "null"], "minimum": 1 },
            "b": { "enum": ["x", "y"] },
            "day": { "type": "string", "format": "date-time" },
            "any": { "anyOf": [{ "const": "none" }, { "$ref": "#/$defs/n" }] },
            "list": { "type": "array", "items": { "allOf": [{ "$ref": "#/$defs/n" }] } },
            "more": { "type": "object", "properties": { "p": { "const": 1 } }, "additionalProperties": { "$ref": "#/$defs/n" } },
        },
        "$defs": { "n": { "type": "object", "required": ["n"], "properties": { "n": { "type": "number" } } } },
    });
    let good = [
        json!({ "a": 1, "list": [], "day": "2026-01-02T03:04:05Z" }),
        json!({ "a": null, "b": "y", "list": [{ "n": 0.5 }] }),
        json!({ "a": 2.0, "any": { "n": 1 }, "list": [], "more": { "p": 1, "q": { "n": 1 } } }),
    ];
    good.iter().try_for_each(|good| validate(&schema, good))?;
    for bad in [
        json!([]),
        json!({ "a": 1 }),
        json!({ "a": 0, "list": [] }),
        json!({ "a": 1.5, "list": [] }),
        json!({ "a": "1", "list": [] }),
        json!({ "a": 1, "list": {} }),
        json!({ "a": 1, "b": "z", "list": [] }),
        json!({ "a": 1, "c": 1, "list": [] }),
        json!({ "a": 1, "list": [{}] }),
        json!({ "a": 1, "list": [{ "n": "0" }] }),
        json!({ "a": 1, "list": [{ "n": 0, "m": 0 }] }),
        json!({ "a": 1, "day": "2026-13-02T03:04:05Z", "list": [] }),
        json!({ "a": 1, "any": [0], "list": [] }),
        json!({ "a": 1, "any": { "n": 1, "m": 2 }, "list": [] }),
        json!({ "a": 1, "list": [], "more": { "q": { "m": 1 } } }),
        json!({ "a": 1, "list": [], "more": { "p": 2 } }),
    ] {
        ensure!(validate(&schema, &bad).is_err(), "{bad} passed");
    }
    for wrong in [
        json!({ "maximun": 3 }),
        json!({ "type": "nothing" }),
        json!({ "$ref": "#/$defs/nowhere" }),
        json!({ "anyOf": [{ "type": "integer" }, { "format": "date" }] }),
        json!({ "$defs": { "n": { "minimum": "0" } } }),
    ] {
        ensure!(validate(&wrong, &json!(2)).is_err(), "the schema {wrong} passed");
    }
    Ok(())
}
