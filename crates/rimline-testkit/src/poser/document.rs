//! A glTF file's JSON and buffers, and what its accessors hold (glTF 2.0, section 3.6), for good files alone.

use std::path::Path;

use serde_json::Value;

/// A file in memory.
pub(super) struct Document {
    pub(super) json: Value,
    buffers: Vec<Vec<u8>>,
}

/// An accessor's values, element after element.
pub(super) struct Values {
    pub(super) values: Vec<f64>,
    pub(super) width: usize,
}

impl Values {
    pub(super) fn len(&self) -> usize {
        self.values.len() / self.width
    }

    pub(super) fn get(&self, element: usize) -> &[f64] {
        &self.values[element * self.width..][..self.width]
    }

    pub(super) fn vector<const N: usize>(&self, element: usize) -> [f64; N] {
        self.get(element).try_into().expect("the accessor's type fits its use")
    }
}

/// A number of the JSON as an index or a size.
pub(super) fn index(value: &Value) -> usize {
    value.as_u64().unwrap_or_else(|| panic!("{value} is no index")) as usize
}

/// The numbers of a JSON array; `None` where there is none.
pub(super) fn numbers(value: &Value) -> Option<Vec<f64>> {
    let number = |value: &Value| value.as_f64().expect("a number");
    value.as_array().map(|values| values.iter().map(number).collect())
}

/// The members of a JSON array, none where it is missing.
pub(super) fn list(value: &Value) -> &[Value] {
    value.as_array().map_or(&[], Vec::as_slice)
}

impl Document {
    pub(super) fn open(path: &Path) -> Result<Self, String> {
        let text = |error: &dyn std::fmt::Display| format!("{}: {error}", path.display());
        let bytes = std::fs::read(path).map_err(|error| text(&error))?;
        let word = |at: usize| u32::from_le_bytes(bytes[at..at + 4].try_into().expect("four bytes")) as usize;
        let (json, binary) = if bytes.starts_with(b"glTF") {
            let json = &bytes[20..20 + word(12)];
            let second = 20 + word(12);
            let binary = if second < bytes.len() { &bytes[second + 8..][..word(second)] } else { &[] };
            (json, binary.to_vec())
        } else {
            (&bytes[..], Vec::new())
        };
        let json: Value = serde_json::from_slice(json).map_err(|error| text(&error))?;
        let mut buffers = Vec::new();
        for buffer in list(&json["buffers"]) {
            buffers.push(match buffer["uri"].as_str() {
                None => binary.clone(),
                Some(uri) => match uri.split_once(";base64,") {
                    Some((_, data)) => base64(data),
                    None => std::fs::read(path.with_file_name(uri)).map_err(|error| text(&error))?,
                },
            });
        }
        Ok(Self { json, buffers })
    }

    /// `count` elements of `width` components each, as floating point numbers.
    fn read(&self, view: &Value, offset: &Value, component: u64, width: usize, count: usize) -> Vec<f64> {
        let view = &self.json["bufferViews"][index(view)];
        let optional = |value: &Value| value.as_u64().unwrap_or(0) as usize;
        let bytes =
            &self.buffers[index(&view["buffer"])][optional(&view["byteOffset"])..][..index(&view["byteLength"])];
        let size = match component {
            5120 | 5121 => 1,
            5122 | 5123 => 2,
            _ => 4,
        };
        let stride = view["byteStride"].as_u64().map_or(size * width, |stride| stride as usize);
        let mut values = Vec::with_capacity(count * width);
        for element in 0..count {
            for at in 0..width {
                let at = optional(offset) + element * stride + at * size;
                let mut four = [0; 4];
                four[..size].copy_from_slice(&bytes[at..at + size]);
                let [a, b, c, d] = four;
                values.push(match component {
                    5120 => f64::from(a as i8),
                    5121 => f64::from(a),
                    5122 => f64::from(i16::from_le_bytes([a, b])),
                    5123 => f64::from(u16::from_le_bytes([a, b])),
                    5125 => f64::from(u32::from_le_bytes([a, b, c, d])),
                    _ => f64::from(f32::from_le_bytes([a, b, c, d])),
                });
            }
        }
        values
    }

    /// Values of an accessor: zeros where it has no view, then the sparse elements, then normalised.
    pub(super) fn accessor(&self, number: &Value) -> Values {
        let accessor = &self.json["accessors"][index(number)];
        let count = index(&accessor["count"]);
        let component = accessor["componentType"].as_u64().expect("a component type");
        let width = match accessor["type"].as_str() {
            Some("SCALAR") => 1,
            Some("VEC2") => 2,
            Some("VEC3") => 3,
            Some("MAT4") => 16,
            _ => 4,
        };
        let mut values = match &accessor["bufferView"] {
            Value::Null => vec![0.0; count * width],
            view => self.read(view, &accessor["byteOffset"], component, width, count),
        };
        let sparse = &accessor["sparse"];
        if !sparse.is_null() {
            let (count, of) = (index(&sparse["count"]), &sparse["indices"]);
            let type_ = of["componentType"].as_u64().expect("a component type");
            let indices = self.read(&of["bufferView"], &of["byteOffset"], type_, 1, count);
            let of = &sparse["values"];
            let replaced = self.read(&of["bufferView"], &of["byteOffset"], component, width, count);
            for (index, value) in indices.into_iter().zip(replaced.chunks(width)) {
                values[index as usize * width..][..width].copy_from_slice(value);
            }
        }
        if accessor["normalized"] == Value::Bool(true) {
            let largest = match component {
                5120 => 127.0,
                5121 => 255.0,
                5122 => 32767.0,
                _ => 65535.0,
            };
            values = values.into_iter().map(|value: f64| (value / largest).max(-1.0)).collect();
        }
        Values { values, width }
    }
}

fn base64(text: &str) -> Vec<u8> {
    const DIGITS: &[u8] = b"ABCDEFGHIJKLMNOPQRSTUVWXYZabcdefghijklmnopqrstuvwxyz0123456789+/";
    let (mut bytes, mut bits, mut count) = (Vec::new(), 0_u32, 0);
    for digit in text.bytes().filter_map(|byte| DIGITS.iter().position(|&digit| digit == byte)) {
        bits = (bits << 6) | digit as u32;
        count += 6;
        if count >= 8 {
            count -= 8;
            bytes.push((bits >> count) as u8);
        }
    }
    bytes
}
