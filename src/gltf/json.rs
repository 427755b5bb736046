//! A view of JSON that knows its path, so that every error names it.
//!
//! Derived types of serde are not used. They take an array for an object and null for nothing, and their messages speak
//! of Rust's types. Faults of single parts, and the lengths of lists that indices point into, would still need a walk.

use serde_json::{Map, Value};

use super::error::GltfError;
use super::warning::Warnings;

/// A JSON object and its path.
#[derive(Clone, Debug)]
pub(super) struct Json<'a> {
    object: &'a Map<String, Value>,
    pub(super) path: String,
}

/// A list of the document that indices point into.
#[derive(Clone, Copy, Debug)]
pub(super) struct List {
    pub(super) name: &'static str,
    pub(super) length: usize,
}

/// A JSON path, made where an error needs it.
type JsonPath<'p> = &'p dyn Fn() -> String;

/// A type of values that properties have.
pub(super) trait FromJson<'a>: Sized {
    fn read(value: &'a Value, json_path: JsonPath<'_>) -> Result<Self, GltfError>;
}

pub(super) const INDEX: &str = "an index (a whole number of 0 or more)";

impl<'a> FromJson<'a> for Json<'a> {
    fn read(value: &'a Value, json_path: JsonPath<'_>) -> Result<Self, GltfError> {
        Ok(Self { object: expect(value.as_object(), "an object", value, json_path)?, path: json_path() })
    }
}

impl<'a> FromJson<'a> for &'a str {
    fn read(value: &'a Value, json_path: JsonPath<'_>) -> Result<Self, GltfError> {
        expect(value.as_str(), "a string", value, json_path)
    }
}

impl FromJson<'_> for bool {
    fn read(value: &Value, json_path: JsonPath<'_>) -> Result<Self, GltfError> {
        expect(value.as_bool(), "true or false", value, json_path)
    }
}

impl FromJson<'_> for u64 {
    fn read(value: &Value, json_path: JsonPath<'_>) -> Result<Self, GltfError> {
        expect(whole(value), "a whole number of 0 or more", value, json_path)
    }
}

impl FromJson<'_> for f64 {
    fn read(value: &Value, json_path: JsonPath<'_>) -> Result<Self, GltfError> {
        expect(value.as_f64(), "a number", value, json_path)
    }
}

impl<'a, T: FromJson<'a>> FromJson<'a> for Vec<T> {
    fn read(value: &'a Value, json_path: JsonPath<'_>) -> Result<Self, GltfError> {
        let values = expect(value.as_array(), "an array", value, json_path)?;
        values.iter().enumerate().map(|(i, value)| T::read(value, &|| format!("{}[{i}]", json_path()))).collect()
    }
}

impl<const N: usize> FromJson<'_> for [f64; N] {
    fn read(value: &Value, json_path: JsonPath<'_>) -> Result<Self, GltfError> {
        let numbers = Vec::read(value, json_path)?;
        let count = numbers.len();
        numbers.try_into().map_err(|_| GltfError::count(json_path(), count, N))
    }
}

impl<'a> Json<'a> {
    /// The file as a whole. Its path is empty.
    pub(super) fn root(value: &'a Value) -> Result<Self, GltfError> {
        Ok(Self { path: String::new(), ..Self::read(value, &|| "the file".to_owned())? })
    }

    /// The path of one of its properties.
    pub(super) fn path_of(&self, key: &str) -> String {
        if self.path.is_empty() { key.to_owned() } else { format!("{}.{key}", self.path) }
    }

    pub(super) fn keys(&self) -> impl Iterator<Item = &'a str> + use<'a> {
        self.object.keys().map(String::as_str)
    }

    pub(super) fn has(&self, key: &str) -> bool {
        self.object.contains_key(key)
    }

    /// A property, or `None` if it is missing.
    pub(super) fn get<T: FromJson<'a>>(&self, key: &str) -> Result<Option<T>, GltfError> {
        self.object.get(key).map(|value| T::read(value, &|| self.path_of(key))).transpose()
    }

    /// A property that must be there.
    pub(super) fn need<T: FromJson<'a>>(&self, key: &str) -> Result<T, GltfError> {
        self.get(key)?.ok_or_else(|| GltfError::missing(self.path_of(key)))
    }

    /// The elements of an array, or none if it is missing.
    pub(super) fn list<T: FromJson<'a>>(&self, key: &str) -> Result<Vec<T>, GltfError> {
        Ok(self.get(key)?.unwrap_or_default())
    }

    fn values(&self, key: &str) -> Result<&'a [Value], GltfError> {
        let Some(value) = self.object.get(key) else { return Ok(&[]) };
        expect(value.as_array().map(Vec::as_slice), "an array", value, &|| self.path_of(key))
    }

    /// An array that indices point into. It is empty if it is missing.
    pub(super) fn length(&self, name: &'static str) -> Result<List, GltfError> {
        Ok(List { name, length: self.values(name)?.len() })
    }

    /// The objects of an array, or none if it is missing. Each element that is no object is a separate fault.
    pub(super) fn elements(
        &self,
        key: &str,
    ) -> Result<impl Iterator<Item = Result<Self, GltfError>> + use<'a>, GltfError> {
        let list = self.path_of(key);
        let element = move |(i, value): (usize, &'a Value)| Self::read(value, &|| format!("{list}[{i}]"));
        Ok(self.values(key)?.iter().enumerate().map(element))
    }

    /// An extension's object.
    pub(super) fn extension(&self, name: &str) -> Result<Option<Self>, GltfError> {
        self.get::<Self>("extensions")?.map_or(Ok(None), |extensions| extensions.get(name))
    }

    /// The name. One that is no text is left out.
    pub(super) fn name(&self, warnings: &Warnings<'_>) -> Result<Option<String>, GltfError> {
        Ok(warnings.leave_out(self.get::<&str>("name"))?.flatten().map(str::to_owned))
    }

    pub(super) fn index(&self, key: &str, list: List) -> Result<Option<usize>, GltfError> {
        self.object.get(key).map(|value| index(value, list, &|| self.path_of(key))).transpose()
    }

    pub(super) fn need_index(&self, key: &str, list: List) -> Result<usize, GltfError> {
        self.index(key, list)?.ok_or_else(|| GltfError::missing(self.path_of(key)))
    }

    pub(super) fn indices(&self, key: &str, list: List) -> Result<Vec<usize>, GltfError> {
        let values = self.values(key)?.iter().enumerate();
        values.map(|(i, value)| index(value, list, &|| format!("{}[{i}]", self.path_of(key)))).collect()
    }

    /// An error about the value of a property.
    pub(super) fn wrong(&self, key: &str, expected: &str) -> GltfError {
        wrong(self.path_of(key), expected, self.object.get(key).unwrap_or(&Value::Null))
    }
}

/// A whole number. JSON writers may write it as `1.0`.
pub(super) fn whole(value: &Value) -> Option<u64> {
    value.as_u64().or_else(|| {
        let number = value.as_f64()?;
        (number >= 0.0 && number <= 2_f64.powi(53) && number.fract() == 0.0).then_some(number as u64)
    })
}

fn index(value: &Value, list: List, json_path: JsonPath<'_>) -> Result<usize, GltfError> {
    let index = expect(whole(value), INDEX, value, json_path)?;
    let List { name, length } = list;
    if index < length as u64 {
        return Ok(index as usize);
    }
    Err(GltfError::invalid(json_path(), format!(" is {index}, but the file has {length} {name}")))
}

fn expect<T>(found: Option<T>, expected: &str, value: &Value, json_path: JsonPath<'_>) -> Result<T, GltfError> {
    found.ok_or_else(|| wrong(json_path(), expected, value))
}

/// An error about a value. It quotes a plain value, shortened.
pub(super) fn wrong(json_path: String, expected: &str, value: &Value) -> GltfError {
    let found = match value {
        Value::Array(_) => "an array".to_owned(),
        Value::Object(_) => "an object".to_owned(),
        other => shorten(&other.to_string()),
    };
    GltfError::invalid(json_path, format!(": expected {expected}, found {found}"))
}

/// At most the first 60 characters.
pub(super) fn shorten(text: &str) -> String {
    match text.char_indices().nth(60) {
        Some((end, _)) => format!("{}…", &text[..end]),
        None => text.to_owned(),
    }
}
