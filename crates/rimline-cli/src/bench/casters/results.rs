//! What the bench of scenes found, and its JSON.

use serde_json::{Value, json};

use super::super::measure::Summary;
use super::super::summary_json::summary_json;
use super::field::{CasterMesh, LIGHTS};
use super::measure::FrameTimes;
use crate::chart::Key;

/// Everything.
pub(crate) struct CastersResults {
    /// Pixels across and down.
    pub(crate) size: u32,
    pub(crate) rows: Vec<CastersRow>,
    pub(crate) one_mesh: Vec<OneMeshRow>,
    /// Rows of both kinds that there would be, had nothing stopped the run.
    pub(crate) planned_rows: usize,
}

/// A scene.
pub(crate) struct CastersRow {
    pub(crate) mesh: CasterMesh,
    /// Of each caster.
    pub(crate) faces: usize,
    pub(crate) casters: usize,
    /// Milliseconds of the CPU for recording a frame, a value a round.
    pub(crate) recording: Vec<(Change, Vec<f64>)>,
    /// The scene's buffers but topology.
    pub(crate) scene_bytes: u64,
    /// What the device allocated for the scene, topology included. `None` where it does not tell.
    pub(crate) scene_device_bytes: Option<u64>,
    /// The same of an extractor with volumes for each caster.
    pub(crate) extractors_device_bytes: Option<u64>,
    /// Against the same faces as one mesh. `None` where there are too many casters.
    pub(crate) compared: Option<Compared>,
    /// Silhouette edges of each light: in the scene, in the merged mesh.
    pub(crate) edges: [[u64; LIGHTS]; 2],
}

/// A scene of one caster, against an extractor. Only extraction is timed.
pub(crate) struct OneMeshRow {
    pub(crate) faces: usize,
    pub(crate) compared: Compared,
    /// Silhouette edges of each light: in the scene, of the extractor.
    pub(crate) edges: [[u64; LIGHTS]; 2],
}

/// What happens before a frame is recorded, and who records it.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Change {
    /// A scene in which nothing moves.
    Still,
    /// A scene in which a hundredth of the casters move, and at least one.
    OneInHundred,
    /// A scene in which all casters move.
    All,
    /// An extractor with shadow volumes for each caster.
    Extractors,
}

impl Change {
    /// What the data call it.
    pub(crate) fn id(self) -> &'static str {
        match self {
            Self::Still => "scene-still",
            Self::OneInHundred => "scene-1-percent-moved",
            Self::All => "scene-all-moved",
            Self::Extractors => "extractors",
        }
    }

    pub(crate) fn name(self) -> &'static str {
        match self {
            Self::Still => "scene, nothing moved",
            Self::OneInHundred => "scene, 1 % moved",
            Self::All => "scene, all moved",
            Self::Extractors => "an extractor a caster",
        }
    }

    /// Its mark in the plot.
    pub(crate) fn key(self) -> Key {
        let (colour, shape) = match self {
            Self::Still => (3, 3),
            Self::OneInHundred => (4, 0),
            Self::All => (6, 1),
            Self::Extractors => (0, 2),
        };
        Key { name: self.name().to_owned(), colour, shape, hollow: false }
    }
}

/// GPU times of a scene and of what it is held against, by the rounds.
pub(crate) struct Compared {
    pub(crate) scene: Vec<FrameTimes>,
    pub(crate) other: Vec<FrameTimes>,
}

/// Which of a frame's times.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Part {
    Extraction,
    Stages,
    Draws,
    Frame,
}

const PARTS: [Part; 4] = [Part::Extraction, Part::Stages, Part::Draws, Part::Frame];

impl Part {
    fn id(self) -> &'static str {
        match self {
            Self::Extraction => "extraction",
            Self::Stages => "stages",
            Self::Draws => "draws",
            Self::Frame => "frame",
        }
    }

    fn of(self, times: &FrameTimes) -> f64 {
        match self {
            Self::Extraction => times.extraction_ms,
            Self::Stages => times.stages_ms,
            Self::Draws => times.draws_ms,
            Self::Frame => times.frame_ms,
        }
    }
}

impl Compared {
    pub(crate) fn scene(&self, part: Part) -> Option<Summary> {
        Summary::of(self.scene.iter().map(|times| part.of(times)))
    }

    pub(crate) fn other(&self, part: Part) -> Option<Summary> {
        Summary::of(self.other.iter().map(|times| part.of(times)))
    }

    /// The scene's times divided by the other's, round by round.
    pub(crate) fn ratio(&self, part: Part) -> Option<Summary> {
        let rounds = self.scene.iter().zip(&self.other);
        let ratios = rounds.map(|(scene, other)| part.of(scene) / part.of(other));
        Summary::of(ratios.filter(|ratio| ratio.is_finite()))
    }

    /// For each of `parts` a summary in milliseconds of both, and of the ratio.
    fn json(&self, other: &str, parts: &[Part]) -> Value {
        let summary = |summary: Option<Summary>| summary.as_ref().map_or(Value::Null, summary_json);
        let part = |part: &Part| {
            json!({
                "part": part.id(),
                "scene_ms": summary(self.scene(*part)),
                other: summary(self.other(*part)),
                "ratio": summary(self.ratio(*part)),
            })
        };
        parts.iter().map(part).collect()
    }
}

/// Lights whose silhouette edges are not as many as they should be.
fn wrong_lights([scene, other]: &[[u64; LIGHTS]; 2]) -> usize {
    scene.iter().zip(other).filter(|(scene, other)| scene != other).count()
}

impl CastersRow {
    pub(crate) fn recording(&self, change: Change) -> Option<Summary> {
        let (_, ms) = self.recording.iter().find(|(recorded, _)| *recorded == change)?;
        Summary::of(ms.iter().copied())
    }

    /// The same by the casters, in bytes.
    pub(crate) fn per_caster(&self, bytes: u64) -> f64 {
        bytes as f64 / self.casters as f64
    }

    pub(crate) fn wrong_lights(&self) -> usize {
        wrong_lights(&self.edges)
    }

    fn json(&self) -> Value {
        let recording = self.recording.iter().map(|(change, ms)| {
            let summary = Summary::of(ms.iter().copied()).as_ref().map_or(Value::Null, summary_json);
            json!({ "method": change.id(), "cpu_ms": summary, "cpu_ms_of_rounds": ms })
        });
        json!({
            "mesh": self.mesh.id(),
            "faces": self.faces,
            "casters": self.casters,
            "recording": recording.collect::<Vec<_>>(),
            "scene_bytes": self.scene_bytes,
            "scene_bytes_per_caster": self.per_caster(self.scene_bytes),
            "scene_device_bytes": self.scene_device_bytes,
            "extractors_device_bytes": self.extractors_device_bytes,
            "gpu": self.compared.as_ref().map(|compared| compared.json("merged_ms", &PARTS)),
            "silhouette_edges": self.edges[0],
            "wrong_lights": self.wrong_lights(),
        })
    }
}

impl OneMeshRow {
    pub(crate) fn wrong_lights(&self) -> usize {
        wrong_lights(&self.edges)
    }

    fn json(&self) -> Value {
        json!({
            "faces": self.faces,
            "gpu": self.compared.json("extractor_ms", &[Part::Extraction]),
            "silhouette_edges": self.edges[0],
            "wrong_lights": self.wrong_lights(),
        })
    }
}

impl CastersResults {
    pub(crate) fn rows_done(&self) -> usize {
        self.rows.len() + self.one_mesh.len()
    }

    /// As `bench.schema.json` describes.
    pub(crate) fn json(&self) -> Value {
        json!({
            "planned_rows": self.planned_rows,
            "lights": LIGHTS,
            "size": self.size,
            "rows": self.rows.iter().map(CastersRow::json).collect::<Vec<_>>(),
            "one_mesh": self.one_mesh.iter().map(OneMeshRow::json).collect::<Vec<_>>(),
        })
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn ratios_are_of_rounds_and_a_wrong_light_is_counted() {
        let times = |ms: f64| FrameTimes { extraction_ms: ms, ..FrameTimes::default() };
        let compared = Compared { scene: [2.0, 9.0, 6.0].map(times).into(), other: [1.0, 3.0, 1.0].map(times).into() };
        assert_eq!(compared.ratio(Part::Extraction).map(|ratio| ratio.median), Some(3.0));
        assert_eq!(compared.ratio(Part::Frame), None, "nothing of it was timed");
        let mut edges = [[7, 8, 9, 10, 11]; 2];
        assert_eq!(wrong_lights(&edges), 0);
        edges[1][3] += 1;
        assert_eq!(wrong_lights(&edges), 1);
    }
}
