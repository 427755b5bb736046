//! Frames by depth maps, meshes and lookups, as `cargo bench --bench depth_maps -- casters --json FILE` measured them.

use serde_json::{Value, json};

use crate::engine::Metric;
use crate::row::{Entry, Row, Section, Variant, grouped};

const FORMAT: &str = "rimline-depth-map-casters";

/// Methods as the bench names them, with colour and shape.
const METHODS: [(&str, usize, usize); 6] = [
    ("the eye's depth, not counted below", 7, 4),
    ("volumes of the mesh", 4, 0),
    ("of the map, every cell", 5, 4),
    ("of the map, automatic", 0, 1),
    ("of the map, contours 0.005", 1, 2),
    ("lookup", 2, 3),
];

/// The whole time of a frame's shadows; and that of its draws into the stencil once more by themselves, which is no part of
/// it.
pub const FRAME: Metric = Metric::Time("frame");
pub const STENCIL: Metric = Metric::Time("stencil");

/// A variant of the bench.
pub fn variant(name: &str) -> Variant {
    let (_, colour, shape) = METHODS.into_iter().find(|known| known.0 == name).unwrap_or((name, 6, 4));
    Variant::new(name, name, colour, shape)
}

/// A row of a caster of so many faces.
pub fn row(faces: u64, size: u64, device: &str, entries: Vec<Entry>) -> Row {
    Row {
        section: Section::DepthMaps,
        scene: "sphere".to_owned(),
        title: format!("{} faces", grouped(faces as usize)),
        group: device.to_owned(),
        facts: vec![("faces", json!(faces)), ("lights", json!(1)), ("size", json!(size))],
        entries,
    }
}

/// The file of the bench.
pub fn to_json(rows: &[Row]) -> Value {
    json!({ "format": FORMAT, "version": 2, "rows": rows.iter().map(Row::json).collect::<Vec<_>>() })
}

/// Rows of such a file, or what is wrong with it.
pub fn from_json(text: &str) -> Result<Vec<Row>, String> {
    let data: Value = serde_json::from_str(text).map_err(|error| error.to_string())?;
    let rows = data["rows"].as_array().and_then(|rows| rows.iter().map(read).collect::<Option<Vec<_>>>());
    let is_ours = data["format"] == FORMAT && data["version"] == 2;
    rows.filter(|rows| is_ours && !rows.is_empty()).ok_or_else(|| "it has other keys or values".to_owned())
}

fn read(data: &Value) -> Option<Row> {
    let entry = |variant_data: &Value| {
        let mut entry = Entry::new(variant(variant_data["variant"].as_str()?), &[]);
        for (name, metric) in [("frame", FRAME), ("stencil", STENCIL)] {
            let Some(time) = variant_data["times"].get(name) else { continue };
            let rounds = time["rounds"].as_array()?.iter().map(Value::as_f64).collect::<Option<Vec<_>>>()?;
            // A plot has logarithmic axes.
            let is_plotted = !rounds.is_empty() && rounds.iter().all(|ms| ms.is_finite() && *ms > 0.0);
            is_plotted.then_some(())?;
            entry = entry.with(metric, rounds);
        }
        entry.summary(FRAME).map(|_| entry)
    };
    let faces = data["faces"].as_u64().filter(|faces| *faces > 0)?;
    let entries = data["variants"].as_array()?.iter().map(entry).collect::<Option<Vec<_>>>()?;
    Some(row(faces, data["size"].as_u64()?, data["group"].as_str()?, entries))
}
