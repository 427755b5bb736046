//! The files that a glTF names, whether they are read or not.

use std::path::{Path, PathBuf};

use gltf::json::Value;
use percent_encoding::percent_decode_str;

/// All files that a glTF names, in no order: buffers, images, and what extensions name by a `uri`. They need not exist.
pub(super) fn find(json: &Value, base: Option<&Path>) -> Vec<PathBuf> {
    let Some(base) = base else { return Vec::new() };
    let (mut files, mut rest) = (Vec::new(), vec![json]);
    while let Some(value) = rest.pop() {
        match value {
            Value::Array(values) => rest.extend(values),
            Value::Object(object) => {
                rest.extend(object.values());
                if let Some(Value::String(uri)) = object.get("uri") {
                    add(&mut files, uri, base);
                }
            }
            _ => {}
        }
    }
    files
}

fn add(files: &mut Vec<PathBuf>, uri: &str, base: &Path) {
    if uri.get(..5).is_some_and(|scheme| scheme.eq_ignore_ascii_case("data:")) {
        return;
    }
    let decoded = percent_decode_str(uri).decode_utf8_lossy();
    // Some exporters write names as they are, with percent signs.
    if decoded != uri {
        files.push(base.join(uri));
    }
    files.push(base.join(&*decoded));
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn buffers_pictures_and_extensions() {
        let json: Value = gltf::json::deserialize::from_str(
            r#"{"buffers": [{"uri": "a.bin"}, {"uri": "data:;base64,AA"}, {}], "images": [{"uri": "b%20c.png"}],
                "extensions": {"X": {"sounds": [{"uri": "../d.mp3"}]}}, "extras": {"uri": 5}}"#,
        )
        .expect("it is JSON");
        let mut files = find(&json, Some(Path::new("m")));
        files.sort();
        assert_eq!(files, ["m/../d.mp3", "m/a.bin", "m/b c.png", "m/b%20c.png"].map(PathBuf::from));
        assert!(find(&json, None).is_empty());
    }
}
