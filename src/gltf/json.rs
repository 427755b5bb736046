//! A view of JSON that knows its path, so that every error names its place.

use gltf::json::Value;

use super::error::GltfError;
use super::warning::Warnings;

/// A JSON object and its path.
#[derive(Clone, Debug)]
pub(super) struct Json<'a> {
    object: &'a Value,
    path: String,
}

const INDEX: &str = "an index (a whole number of 0 or more)";
const WHOLE: &str = "a whole number of 0 or more";

impl<'a> Json<'a> {
    pub(super) fn new(value: &'a Value, path: String) -> Result<Self, GltfError> {
        match value {
            Value::Object(_) => Ok(Self { object: value, path }),
            other if path.is_empty() => Err(wrong("the file".to_owned(), "an object", other)),
            other => Err(wrong(path, "an object", other)),
        }
    }

    /// The path of this object.
    pub(super) fn path(&self) -> &str {
        if self.path.is_empty() { "the file" } else { &self.path }
    }

    /// The path of one of its properties.
    pub(super) fn at(&self, key: &str) -> String {
        if self.path.is_empty() { key.to_owned() } else { format!("{}.{key}", self.path) }
    }

    pub(super) fn keys(&self) -> impl Iterator<Item = &'a str> + use<'a> {
        self.object.as_object().into_iter().flat_map(|object| object.keys().map(String::as_str))
    }

    pub(super) fn value(&self, key: &str) -> Option<&'a Value> {
        self.object.get(key)
    }

    pub(super) fn object(&self, key: &str) -> Result<Option<Self>, GltfError> {
        self.value(key).map(|v| Self::new(v, self.at(key))).transpose()
    }

    /// An extension's object.
    pub(super) fn extension(&self, name: &str) -> Result<Option<Self>, GltfError> {
        match self.object("extensions")? {
            Some(extensions) => extensions.object(name),
            None => Ok(None),
        }
    }

    fn values(&self, key: &str) -> Result<&'a [Value], GltfError> {
        match self.value(key) {
            None => Ok(&[]),
            Some(Value::Array(values)) => Ok(values),
            Some(other) => Err(wrong(self.at(key), "an array", other)),
        }
    }

    /// The length of an array, or 0 if it is missing.
    pub(super) fn count(&self, key: &str) -> Result<usize, GltfError> {
        Ok(self.values(key)?.len())
    }

    /// The objects of an array, or none if it is missing.
    pub(super) fn objects(&self, key: &str) -> Result<Vec<Self>, GltfError> {
        self.values(key)?.iter().enumerate().map(|(i, v)| Self::new(v, format!("{}[{i}]", self.at(key)))).collect()
    }

    /// The elements of an array, or none if it is missing. Each that is no object is a fault of its own.
    pub(super) fn elements(
        &self,
        key: &str,
    ) -> Result<impl Iterator<Item = Result<Self, GltfError>> + use<'a>, GltfError> {
        let list = self.at(key);
        let element = move |(i, v): (usize, &'a Value)| Self::new(v, format!("{list}[{i}]"));
        Ok(self.values(key)?.iter().enumerate().map(element))
    }

    pub(super) fn strings(&self, key: &str) -> Result<Vec<&'a str>, GltfError> {
        let text = |(i, v): (usize, &'a Value)| {
            v.as_str().ok_or_else(|| wrong(format!("{}[{i}]", self.at(key)), "a string", v))
        };
        self.values(key)?.iter().enumerate().map(text).collect()
    }

    pub(super) fn string(&self, key: &str) -> Result<Option<&'a str>, GltfError> {
        self.value(key).map(|v| v.as_str().ok_or_else(|| wrong(self.at(key), "a string", v))).transpose()
    }

    /// The name. One that is no text is left out.
    pub(super) fn name(&self, warnings: &Warnings<'_>) -> Result<Option<String>, GltfError> {
        Ok(warnings.leave_out(self.string("name"))?.flatten().map(str::to_owned))
    }

    pub(super) fn flag(&self, key: &str) -> Result<bool, GltfError> {
        match self.value(key) {
            None => Ok(false),
            Some(Value::Bool(flag)) => Ok(*flag),
            Some(other) => Err(wrong(self.at(key), "true or false", other)),
        }
    }

    pub(super) fn whole(&self, key: &str) -> Result<Option<u64>, GltfError> {
        self.value(key).map(|v| whole(v).ok_or_else(|| wrong(self.at(key), WHOLE, v))).transpose()
    }

    /// An index into an array of `count` elements of the given kind.
    pub(super) fn index(&self, key: &str, kind: &'static str, count: usize) -> Result<Option<usize>, GltfError> {
        self.value(key).map(|v| index(v, || self.at(key), kind, count)).transpose()
    }

    pub(super) fn indices(&self, key: &str, kind: &'static str, count: usize) -> Result<Vec<usize>, GltfError> {
        self.values(key)?
            .iter()
            .enumerate()
            .map(|(i, v)| index(v, || format!("{}[{i}]", self.at(key)), kind, count))
            .collect()
    }

    pub(super) fn number(&self, key: &str) -> Result<Option<f64>, GltfError> {
        self.value(key).map(|v| v.as_f64().ok_or_else(|| wrong(self.at(key), "a number", v))).transpose()
    }

    pub(super) fn numbers(&self, key: &str) -> Result<Option<Vec<f64>>, GltfError> {
        if self.value(key).is_none() {
            return Ok(None);
        }
        let number =
            |(i, v): (usize, &Value)| v.as_f64().ok_or_else(|| wrong(format!("{}[{i}]", self.at(key)), "a number", v));
        self.values(key)?.iter().enumerate().map(number).collect::<Result<_, _>>().map(Some)
    }

    /// Exactly `N` numbers.
    pub(super) fn vector<const N: usize>(&self, key: &str) -> Result<Option<[f64; N]>, GltfError> {
        let Some(numbers) = self.numbers(key)? else {
            return Ok(None);
        };
        let count = numbers.len();
        let vector = numbers.try_into().map_err(|_| GltfError::Count { place: self.at(key), count, expected: N })?;
        Ok(Some(vector))
    }

    /// The property, or an error that it is missing.
    pub(super) fn required<T>(&self, key: &str, value: Option<T>) -> Result<T, GltfError> {
        value.ok_or_else(|| GltfError::Missing { place: self.at(key) })
    }

    /// An error about the value of a property.
    pub(super) fn wrong(&self, key: &str, expected: &'static str) -> GltfError {
        wrong(self.at(key), expected, self.value(key).unwrap_or(&Value::Null))
    }
}

/// A whole number. JSON writers may write it as `1.0`.
pub(super) fn whole(value: &Value) -> Option<u64> {
    value.as_u64().or_else(|| {
        let number = value.as_f64()?;
        (number >= 0.0 && number <= 2_f64.powi(53) && number.fract() == 0.0).then_some(number as u64)
    })
}

fn index(value: &Value, place: impl Fn() -> String, kind: &'static str, count: usize) -> Result<usize, GltfError> {
    let index = whole(value).ok_or_else(|| wrong(place(), INDEX, value))?;
    if index < count as u64 {
        Ok(index as usize)
    } else {
        let place = place();
        Err(GltfError::Reference { place, kind, index, count })
    }
}

/// An error about a value. It quotes the value, shortened.
pub(super) fn wrong(place: String, expected: &'static str, value: &Value) -> GltfError {
    let found = match value {
        Value::Array(_) => "an array".to_owned(),
        Value::Object(_) => "an object".to_owned(),
        other => shorten(&other.to_string()),
    };
    GltfError::Property { place, expected, found }
}

/// At most the first 60 characters.
pub(super) fn shorten(text: &str) -> String {
    match text.char_indices().nth(60) {
        Some((end, _)) => format!("{}…", &text[..end]),
        None => text.to_owned(),
    }
}
