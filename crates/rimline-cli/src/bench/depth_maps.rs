//! Frames by depth maps, meshes and lookups, as `cargo bench --bench depth_maps -- casters --json FILE` measured them.

use std::path::Path;

use serde_json::{Value, json};

use super::measure::Summary;
use super::summary_json::summary_json;
use crate::failure::{Failure, InputError};
use crate::source;

/// Times of frames of one caster of more and more faces.
pub(crate) struct DepthMapResults {
    /// The device that they were measured on.
    pub(crate) device: String,
    /// Pixels of the picture and texels of the map, across and down.
    pub(crate) size: u64,
    pub(crate) rows: Vec<DepthMapRow>,
}

/// Methods by their names, with milliseconds of each round.
pub(crate) struct Times(Vec<(String, Vec<f64>)>);

/// One caster.
pub(crate) struct DepthMapRow {
    pub(crate) faces: u64,
    /// A frame's shadows.
    pub(crate) frames: Times,
    /// The part of `frames` that draws into the stencil.
    pub(crate) stencil_passes: Times,
}

impl DepthMapResults {
    pub(crate) fn read(file: &Path) -> Result<Self, Failure> {
        let read = || -> Result<Self, InputError> {
            let data: Value = serde_json::from_str(&source::read_text(file)?)
                .map_err(|error| InputError::DepthMapTimes { what: error.to_string() })?;
            Self::of(&data).ok_or_else(|| InputError::DepthMapTimes { what: "it has other keys or values".to_owned() })
        };
        read().map_err(Failure::input(file))
    }

    fn of(data: &Value) -> Option<Self> {
        let rows = data["rows"].as_array()?.iter().map(DepthMapRow::of).collect::<Option<Vec<_>>>()?;
        let is_ours = data["format"] == "rimline-depth-map-casters" && data["version"] == 1 && !rows.is_empty();
        is_ours.then_some(())?;
        Some(Self { device: data["device"].as_str()?.to_owned(), size: data["size"].as_u64()?, rows })
    }

    /// JSON, as `bench.schema.json` describes it.
    pub(crate) fn json(&self) -> Value {
        json!({
            "device": self.device,
            "size": self.size,
            "rows": self.rows.iter().map(DepthMapRow::json).collect::<Vec<_>>(),
        })
    }
}

impl Times {
    fn of(data: &Value) -> Option<Self> {
        let method = |method: &Value| {
            let rounds = method["ms_of_rounds"].as_array()?.iter().map(Value::as_f64).collect::<Option<Vec<_>>>()?;
            // A plot has logarithmic axes.
            let is_plotted = !rounds.is_empty() && rounds.iter().all(|ms| ms.is_finite() && *ms > 0.0);
            is_plotted.then_some((method["name"].as_str()?.to_owned(), rounds))
        };
        data.as_array()?.iter().map(method).collect::<Option<_>>().map(Self)
    }

    pub(crate) fn names(&self) -> impl Iterator<Item = &str> {
        self.0.iter().map(|(name, _)| name.as_str())
    }

    pub(crate) fn time(&self, name: &str) -> Option<Summary> {
        let (_, rounds) = self.0.iter().find(|(method, _)| method == name)?;
        Summary::of(rounds.iter().copied())
    }

    fn json(&self) -> Value {
        let method = |(name, rounds): &(String, Vec<f64>)| {
            let summary = Summary::of(rounds.iter().copied()).as_ref().map_or(Value::Null, summary_json);
            json!({ "name": name, "ms": summary, "ms_of_rounds": rounds })
        };
        self.0.iter().map(method).collect()
    }
}

impl DepthMapRow {
    fn of(data: &Value) -> Option<Self> {
        let faces = data["faces"].as_u64().filter(|faces| *faces > 0)?;
        Some(Self { faces, frames: Times::of(&data["methods"])?, stencil_passes: Times::of(&data["stencil_passes"])? })
    }

    fn json(&self) -> Value {
        json!({ "faces": self.faces, "methods": self.frames.json(), "stencil_passes": self.stencil_passes.json() })
    }
}
