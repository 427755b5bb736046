//! Results of the bench of scenes, and their JSON.

use serde_json::{Value, json};

use super::super::measure::Summary;
use super::super::summary_json::summary_json;
use super::field::{CasterMesh, LIGHTS};
use super::measure::{DrawTimes, StageTimes};
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

/// Silhouette edges of each light: in a scene, and in what it is held against.
pub(crate) type Edges = [[u64; LIGHTS]; 2];

/// A scene.
pub(crate) struct CastersRow {
    pub(crate) mesh: CasterMesh,
    /// Faces of each caster.
    pub(crate) faces: usize,
    pub(crate) casters: usize,
    /// Milliseconds of the CPU for recording a frame, a value a round.
    pub(crate) recording: Vec<(Change, Vec<f64>)>,
    /// The scene's buffers but topology.
    pub(crate) scene_bytes: u64,
    /// Bytes that the device allocated for the scene, topology included. `None` where the device does not report them.
    pub(crate) scene_device_bytes: Option<u64>,
    /// The same of an extractor with volumes for each caster.
    pub(crate) extractors_device_bytes: Option<u64>,
    /// Against the same faces as one mesh.
    pub(crate) compared: Compared,
    /// In the scene, in the merged mesh.
    pub(crate) edges: Edges,
}

/// A scene of one caster, against an extractor. Only extraction is timed.
pub(crate) struct OneMeshRow {
    pub(crate) faces: usize,
    pub(crate) compared: Compared,
    /// In the scene, of the extractor.
    pub(crate) edges: Edges,
}

/// Changes of a scene before a frame is recorded, and the alternative to a scene.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Change {
    /// A scene in which nothing moves.
    Still,
    /// A scene in which a hundredth of the casters move, and at least one.
    OneInHundred,
    /// A scene in which all casters move.
    All,
    /// A scene in which a light moves.
    Light,
    /// A scene in which a caster comes, and the one that came last goes.
    NewCaster,
    /// An extractor with shadow volumes for each caster.
    Extractors,
}

impl Change {
    /// Name in the data.
    pub(crate) fn id(self) -> &'static str {
        match self {
            Self::Still => "scene-still",
            Self::OneInHundred => "scene-1-percent-moved",
            Self::All => "scene-all-moved",
            Self::Light => "scene-light-moved",
            Self::NewCaster => "scene-new-caster",
            Self::Extractors => "extractors",
        }
    }

    pub(crate) fn name(self) -> &'static str {
        match self {
            Self::Still => "scene, nothing moved",
            Self::OneInHundred => "scene, 1 % moved",
            Self::All => "scene, all moved",
            Self::Light => "scene, a light moved",
            Self::NewCaster => "scene, a new caster",
            Self::Extractors => "an extractor a caster",
        }
    }

    /// Its mark in the plot.
    pub(crate) fn key(self) -> Key {
        let (colour, shape) = match self {
            Self::Still => (3, 3),
            Self::OneInHundred => (4, 0),
            Self::All => (6, 1),
            Self::Light => (1, 4),
            Self::NewCaster => (2, 4),
            Self::Extractors => (0, 2),
        };
        Key { name: self.name().to_owned(), colour, shape, hollow: false }
    }
}

/// GPU times of a scene and of what it is held against.
#[derive(Default)]
pub(crate) struct Compared {
    pub(crate) stages: BothTimes<StageTimes>,
    /// Times of a scene in which nothing changed since the last frame, with new times of what it is compared with.
    pub(crate) still: BothTimes<StageTimes>,
    /// Empty where nothing is drawn.
    pub(crate) draws: BothTimes<DrawTimes>,
}

/// Times of both, by the rounds.
#[derive(Default)]
pub(crate) struct BothTimes<T> {
    pub(crate) scene: Vec<T>,
    pub(crate) other: Vec<T>,
}

/// Which of a frame's times.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Part {
    Extraction,
    /// Stages of a scene in which nothing changed.
    Still,
    Stages,
    Draws,
    Frame,
}

pub(crate) const PARTS: [Part; 5] = [Part::Extraction, Part::Still, Part::Stages, Part::Draws, Part::Frame];

impl Part {
    /// Name in the data.
    fn id(self) -> &'static str {
        match self {
            Self::Extraction => "extraction",
            Self::Still => "extraction-still",
            Self::Stages => "stages",
            Self::Draws => "draws",
            Self::Frame => "frame",
        }
    }

    pub(crate) fn name(self) -> &'static str {
        match self {
            Self::Extraction => "extraction",
            Self::Still => "extraction, nothing moved",
            Self::Stages => "all stages",
            Self::Draws => "stencil passes",
            Self::Frame => "whole frame",
        }
    }
}

impl Compared {
    /// Milliseconds of the scene and of the other, round by round.
    fn rounds(&self, part: Part) -> Vec<[f64; 2]> {
        fn pairs<T>(times: &BothTimes<T>, of: fn(&T) -> f64) -> Vec<[f64; 2]> {
            times.scene.iter().zip(&times.other).map(|(scene, other)| [of(scene), of(other)]).collect()
        }
        match part {
            Part::Extraction => pairs(&self.stages, |times| times.extraction_ms),
            Part::Still => pairs(&self.still, |times| times.extraction_ms),
            Part::Stages => pairs(&self.stages, |times| times.all_ms),
            Part::Draws => pairs(&self.draws, |times| times.stencil_ms),
            Part::Frame => pairs(&self.draws, |times| times.frame_ms),
        }
    }

    pub(crate) fn scene(&self, part: Part) -> Option<Summary> {
        Summary::of(self.rounds(part).into_iter().map(|[scene, _]| scene))
    }

    pub(crate) fn other(&self, part: Part) -> Option<Summary> {
        Summary::of(self.rounds(part).into_iter().map(|[_, other]| other))
    }

    /// The scene's times divided by the other's, round by round.
    pub(crate) fn ratio(&self, part: Part) -> Option<Summary> {
        let ratios = self.rounds(part).into_iter().map(|[scene, other]| scene / other);
        Summary::of(ratios.filter(|ratio| ratio.is_finite()))
    }

    /// For each of `parts` that was measured a summary in milliseconds of both, and of the ratio.
    fn json(&self, other: &str, parts: &[Part]) -> Value {
        let part = |part: &Part| {
            let (scene, found) = (self.scene(*part)?, self.other(*part)?);
            Some(json!({
                "part": part.id(),
                "scene_ms": summary_json(&scene),
                other: summary_json(&found),
                "ratio": self.ratio(*part).as_ref().map_or(Value::Null, summary_json),
            }))
        };
        parts.iter().filter_map(part).collect()
    }
}

/// Lights whose silhouette edges are not as many as they should be.
fn wrong_lights([scene, other]: &Edges) -> usize {
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
            "gpu": self.compared.json("merged_ms", &PARTS),
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

    /// JSON, as `bench.schema.json` describes it.
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
        let times = |ms: f64| StageTimes { extraction_ms: ms, all_ms: ms };
        let stages = BothTimes { scene: [2.0, 9.0, 6.0].map(times).into(), other: [1.0, 3.0, 1.0].map(times).into() };
        let compared = Compared { stages, ..Compared::default() };
        assert_eq!(compared.ratio(Part::Extraction).map(|ratio| ratio.median), Some(3.0));
        assert_eq!(compared.ratio(Part::Frame), None, "nothing of it was timed");
        let mut edges = [[7, 8, 9, 10, 11]; 2];
        assert_eq!(wrong_lights(&edges), 0);
        edges[1][3] += 1;
        assert_eq!(wrong_lights(&edges), 1);
    }
}
