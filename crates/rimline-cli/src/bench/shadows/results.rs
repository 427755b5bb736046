//! Results of the shadow bench, and their JSON.

use serde_json::{Value, json};

use super::super::measure::Summary;
use super::super::summary_json::summary_json;
use super::method::{METHODS, ShadowMethod, Z_PASS};
use super::renderer::FrameTime;
use super::scene::Path;

/// Everything.
pub(crate) struct ShadowResults {
    /// Pixels across and down.
    pub(crate) size: u32,
    /// Frames of each path.
    pub(crate) frames: usize,
    pub(crate) rows: Vec<ShadowRow>,
    /// Rows that there would be, had nothing stopped the run.
    pub(crate) planned_rows: usize,
}

/// One model on one path.
pub(crate) struct ShadowRow {
    pub(crate) model: &'static str,
    pub(crate) faces: usize,
    pub(crate) path: Path,
    /// A method each, as in [`METHODS`].
    pub(crate) entries: Vec<ShadowEntry>,
}

/// One method on one path.
pub(crate) struct ShadowEntry {
    pub(crate) method: &'static ShadowMethod,
    /// A time each frame, a list each round.
    pub(crate) rounds: Vec<Vec<FrameTime>>,
    /// Wrong pixels of the frames that were held against rays.
    pub(crate) wrong_pixels: Vec<WrongPixels>,
}

/// A frame's pixels that are lit or shadowed wrongly.
#[derive(Clone, Copy, Debug)]
pub(crate) struct WrongPixels {
    pub(crate) frame: usize,
    pub(crate) pixels: usize,
}

/// Which of a frame's times.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Part {
    Stencil,
    Frame,
}

impl Part {
    pub(crate) fn of(self, time: &FrameTime) -> f64 {
        match self {
            Self::Stencil => time.stencil_ms,
            Self::Frame => time.frame_ms,
        }
    }
}

impl ShadowEntry {
    /// Milliseconds of a part, all frames together, round by round.
    fn totals(&self, part: Part) -> impl Iterator<Item = f64> {
        self.rounds.iter().map(move |frames| frames.iter().map(|time| part.of(time)).sum())
    }

    /// Milliseconds a frame, the mean over the path.
    pub(crate) fn mean(&self, part: Part) -> Option<Summary> {
        Summary::of(self.totals(part).zip(&self.rounds).map(|(total, frames)| total / frames.len().max(1) as f64))
    }

    /// Milliseconds of each frame, medians over the rounds.
    fn frames(&self, part: Part) -> Vec<f64> {
        let count = self.rounds.first().map_or(0, Vec::len);
        let of = |frame: usize| Summary::of(self.rounds.iter().map(|frames| part.of(&frames[frame])));
        (0..count).filter_map(of).map(|summary| summary.median).collect()
    }

    /// Wrong pixels a frame, the mean over those that were looked at.
    pub(crate) fn wrong(&self) -> f64 {
        let sum: usize = self.wrong_pixels.iter().map(|wrong| wrong.pixels).sum();
        sum as f64 / self.wrong_pixels.len().max(1) as f64
    }
}

impl ShadowRow {
    pub(crate) fn entry(&self, id: &str) -> Option<&ShadowEntry> {
        self.entries.iter().find(|entry| entry.method.id == id)
    }

    /// A method's time over the path divided by another's, round by round.
    pub(crate) fn ratio(&self, part: Part, id: &str, to: &str) -> Option<Summary> {
        let [own, other] = [self.entry(id)?, self.entry(to)?];
        Summary::of(own.totals(part).zip(other.totals(part)).map(|(own, other)| own / other))
    }

    /// A method's time divided by another's at each frame, medians over the rounds.
    pub(crate) fn ratios_of_frames(&self, part: Part, id: &str, to: &str) -> Vec<f64> {
        let (Some(own), Some(other)) = (self.entry(id), self.entry(to)) else { return Vec::new() };
        let count = own.rounds.first().map_or(0, Vec::len);
        let of = |frame: usize| {
            let rounds = own.rounds.iter().zip(&other.rounds);
            Summary::of(rounds.map(|(own, other)| part.of(&own[frame]) / part.of(&other[frame])))
        };
        (0..count).filter_map(of).map(|summary| summary.median).collect()
    }

    fn json(&self) -> Value {
        let results = self.entries.iter().map(|entry| {
            let summary = |values: Option<Summary>| values.as_ref().map_or(Value::Null, summary_json);
            let ratio = |part| summary(self.ratio(part, entry.method.id, Z_PASS));
            let wrong = entry.wrong_pixels.iter().map(|wrong| json!({ "frame": wrong.frame, "pixels": wrong.pixels }));
            json!({
                "method": entry.method.id,
                "stencil_ms": summary(entry.mean(Part::Stencil)),
                "frame_ms": summary(entry.mean(Part::Frame)),
                "stencil_to_z_pass": ratio(Part::Stencil),
                "frame_to_z_pass": ratio(Part::Frame),
                "stencil_ms_of_frames": entry.frames(Part::Stencil),
                "frame_ms_of_frames": entry.frames(Part::Frame),
                "wrong_pixels": wrong.collect::<Vec<_>>(),
            })
        });
        json!({
            "model": self.model,
            "faces": self.faces,
            "path": self.path.id(),
            "results": results.collect::<Vec<_>>(),
        })
    }
}

impl ShadowResults {
    /// The mean of a method's ratios to another over all paths and models, and the lowest and highest of them.
    pub(crate) fn mean_ratio(&self, part: Part, id: &str, to: &str) -> Option<(f64, [f64; 2])> {
        let ratios: Vec<f64> = self.rows.iter().filter_map(|row| Some(row.ratio(part, id, to)?.median)).collect();
        let range = Summary::of(ratios.iter().copied())?.range;
        Some((ratios.iter().sum::<f64>() / ratios.len() as f64, [range.0, range.1]))
    }

    /// JSON, as `bench.schema.json` describes it.
    pub(crate) fn json(&self) -> Value {
        let methods: Vec<Value> =
            METHODS.iter().map(|method| json!({ "id": method.id, "name": method.name })).collect();
        json!({
            "planned_rows": self.planned_rows,
            "size": self.size,
            "frames": self.frames,
            "methods": methods,
            "rows": self.rows.iter().map(ShadowRow::json).collect::<Vec<_>>(),
        })
    }
}
