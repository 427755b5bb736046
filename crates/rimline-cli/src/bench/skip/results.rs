//! Results of the bench of skipping, and their JSON.

use bytemuck::Zeroable;
use rimline::gpu::{SceneStatistics, ShadowStatistics};
use serde_json::{Value, json};

use super::super::measure::Summary;
use super::super::summary_json::summary_json;
use super::levels::{LEVELS, Variant};
use super::scenes::SkipScene;

/// Everything.
pub(crate) struct SkipResults {
    /// Pixels across and down.
    pub(crate) size: u32,
    pub(crate) rows: Vec<SkipRow>,
    /// Rows that there would be, had nothing stopped the run.
    pub(crate) planned_rows: usize,
}

/// A scene in a view, with each choice of levels.
pub(crate) struct SkipRow {
    pub(crate) scene: SkipScene,
    pub(crate) casters: usize,
    /// Faces of all casters together.
    pub(crate) faces: usize,
    pub(crate) lights: usize,
    /// Pairs of caster and light in the light's range, in the first frame.
    pub(crate) pairs_in_range: usize,
    pub(crate) entries: Vec<SkipEntry>,
}

/// A choice of levels.
pub(crate) struct SkipEntry {
    pub(crate) variant: Variant,
    /// A run each, in the order of the rounds.
    pub(crate) stages: Vec<StageRun>,
    pub(crate) frames: Vec<FrameRun>,
    pub(crate) counted: Counted,
    /// Fragments of the volumes of all lights. `None` where the device's queries do not count.
    pub(crate) fragments: Option<u64>,
}

/// Milliseconds of the GPU for deforming and the compute stages of a frame.
#[derive(Clone, Debug, Default)]
pub(crate) struct StageRun {
    pub(crate) stages: Vec<(&'static str, f64)>,
}

/// Milliseconds of a frame with its draws.
#[derive(Clone, Copy, Debug, Default)]
#[expect(clippy::struct_field_names, reason = "a time's name ends in its unit")]
pub(crate) struct FrameRun {
    /// The stencil passes of all lights.
    pub(crate) stencil_ms: f64,
    /// By the clock: deforming, all stages, stencil passes.
    pub(crate) frame_ms: f64,
    /// Time of the CPU for recording the whole frame.
    pub(crate) recording_ms: f64,
}

/// Counters of a frame's stages.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Counted {
    pub(crate) scene: SceneStatistics,
    pub(crate) shadows: ShadowStatistics,
}

impl Default for Counted {
    fn default() -> Self {
        Self { scene: Zeroable::zeroed(), shadows: Zeroable::zeroed() }
    }
}

/// Something that stages count.
pub(crate) struct Counter {
    /// Name in the data.
    pub(crate) id: &'static str,
    pub(crate) name: &'static str,
    pub(crate) of: fn(&Counted) -> u32,
}

pub(crate) static COUNTERS: &[Counter] = &[
    Counter { id: "pairs", name: "pairs that may matter", of: |counted| counted.scene.pairs },
    Counter { id: "unreached-pairs", name: "pairs out of reach", of: |counted| counted.scene.unreached_pairs },
    Counter { id: "occluded-pairs", name: "pairs that occluders hide", of: |counted| counted.scene.occluded_pairs },
    Counter { id: "kept-pairs", name: "pairs kept", of: |counted| counted.scene.kept_pairs },
    Counter { id: "faces", name: "faces tested", of: |counted| counted.scene.faces },
    Counter { id: "edges", name: "edges tested", of: |counted| counted.scene.edges },
    Counter { id: "spared-faces", name: "faces that clusters spare", of: |counted| counted.scene.spared_faces },
    Counter { id: "spared-edges", name: "edges that clusters spare", of: |counted| counted.scene.spared_edges },
    Counter { id: "unneeded-figures", name: "figures not deformed", of: |counted| counted.scene.unneeded },
    Counter { id: "skipped-volumes", name: "volumes skipped", of: |counted| counted.shadows.skipped },
    Counter { id: "unreached-volumes", name: "of which out of reach", of: |counted| counted.shadows.unreached },
    Counter { id: "hidden-volumes", name: "and no receiver is in", of: |counted| counted.shadows.hidden },
    Counter { id: "kept-lists", name: "lists kept", of: |counted| counted.shadows.kept_lists },
    Counter { id: "capped-volumes", name: "volumes with near caps", of: |counted| counted.shadows.capped },
];

/// The stage that deforms, as the timer has it.
pub(crate) const DEFORM: &str = "deform";

/// A part of a frame.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum SkipPart {
    Deform,
    Compute,
    Stencil,
    Frame,
    Recording,
}

pub(crate) const PARTS: [SkipPart; 5] =
    [SkipPart::Deform, SkipPart::Compute, SkipPart::Stencil, SkipPart::Frame, SkipPart::Recording];

impl SkipPart {
    /// Name in the data.
    pub(crate) fn id(self) -> &'static str {
        match self {
            Self::Deform => "deform",
            Self::Compute => "compute",
            Self::Stencil => "stencil",
            Self::Frame => "frame",
            Self::Recording => "recording",
        }
    }

    pub(crate) fn name(self) -> &'static str {
        match self {
            Self::Deform => "deforming",
            Self::Compute => "compute",
            Self::Stencil => "stencil passes",
            Self::Frame => "whole frame",
            Self::Recording => "recording (CPU)",
        }
    }
}

impl StageRun {
    pub(crate) fn of(&self, stage: &str) -> f64 {
        self.stages.iter().filter(|(name, _)| *name == stage).map(|(_, ms)| ms).sum()
    }

    /// All stages but the one that deforms.
    pub(crate) fn compute_ms(&self) -> f64 {
        self.stages.iter().filter(|(name, _)| *name != DEFORM).map(|(_, ms)| ms).sum()
    }
}

impl SkipEntry {
    /// Milliseconds, round by round.
    fn rounds(&self, part: SkipPart) -> Vec<f64> {
        let of_stages = |of: fn(&StageRun) -> f64| self.stages.iter().map(of).collect();
        let of_frames = |of: fn(&FrameRun) -> f64| self.frames.iter().map(of).collect();
        match part {
            SkipPart::Deform => of_stages(|run| run.of(DEFORM)),
            SkipPart::Compute => of_stages(StageRun::compute_ms),
            SkipPart::Stencil => of_frames(|run| run.stencil_ms),
            SkipPart::Frame => of_frames(|run| run.frame_ms),
            SkipPart::Recording => of_frames(|run| run.recording_ms),
        }
    }

    pub(crate) fn part(&self, part: SkipPart) -> Option<Summary> {
        Summary::of(self.rounds(part))
    }

    /// Deforming, compute and stencil passes together, divided by the whole frame of the same round. About 1 where times can be
    /// trusted: stages and frames are timed one after the other, and only the frame is by the clock.
    pub(crate) fn parts_of_frame(&self) -> Option<Summary> {
        let [deform, compute, stencil, frame] =
            [SkipPart::Deform, SkipPart::Compute, SkipPart::Stencil, SkipPart::Frame].map(|part| self.rounds(part));
        let share = |round: usize| Some((deform[round] + compute[round] + stencil.get(round)?) / frame.get(round)?);
        Summary::of((0..deform.len()).filter_map(share).filter(|share| share.is_finite()))
    }

    /// The names of all stages, in the order of the frame.
    pub(crate) fn stage_names(&self) -> Vec<&'static str> {
        let mut names = Vec::new();
        for (name, _) in self.stages.iter().flat_map(|run| &run.stages) {
            if !names.contains(name) {
                names.push(*name);
            }
        }
        names
    }

    pub(crate) fn stage(&self, stage: &str) -> Option<Summary> {
        Summary::of(self.stages.iter().map(|run| run.of(stage)))
    }
}

impl SkipRow {
    pub(crate) fn title(&self) -> String {
        self.scene.title(self.casters)
    }

    /// The entry that all others are compared with: all levels on.
    pub(crate) fn all_on(&self) -> Option<&SkipEntry> {
        self.entries.iter().find(|entry| matches!(entry.variant, Variant::AllOn))
    }

    /// Times of a part divided by those with all levels on, round by round. `None` where there is no such part.
    pub(crate) fn ratio(&self, entry: &SkipEntry, part: SkipPart) -> Option<Summary> {
        let all_on = self.all_on()?.rounds(part);
        let ratios = entry.rounds(part).into_iter().zip(all_on).map(|(one, other)| one / other);
        Summary::of(ratios.filter(|ratio| ratio.is_finite()))
    }

    /// The fragments divided by those with all levels on.
    pub(crate) fn fragments_ratio(&self, entry: &SkipEntry) -> Option<f64> {
        let ratio = entry.fragments? as f64 / self.all_on()?.fragments? as f64;
        ratio.is_finite().then_some(ratio)
    }

    fn json(&self) -> Value {
        let summary = |summary: Option<Summary>| summary.as_ref().map_or(Value::Null, summary_json);
        let variant = |entry: &SkipEntry| {
            let parts = PARTS.map(|part| {
                json!({ "part": part.id(), "ms": summary(entry.part(part)), "ratio": summary(self.ratio(entry, part)) })
            });
            let stages = entry.stage_names().into_iter();
            let stages = stages.map(|stage| json!({ "stage": stage, "ms": summary(entry.stage(stage)) }));
            let counters = COUNTERS.iter();
            let counters =
                counters.map(|counter| json!({ "counter": counter.id, "count": (counter.of)(&entry.counted) }));
            json!({
                "variant": entry.variant.id(),
                "parts": parts,
                "parts_of_frame": summary(entry.parts_of_frame()),
                "stages": stages.collect::<Vec<_>>(),
                "counters": counters.collect::<Vec<_>>(),
                "fragments": entry.fragments,
                "fragments_ratio": self.fragments_ratio(entry),
            })
        };
        json!({
            "scene": self.scene.name(),
            "view": self.scene.view(),
            "casters": self.casters,
            "faces": self.faces,
            "lights": self.lights,
            "pairs_in_range": self.pairs_in_range,
            "variants": self.entries.iter().map(variant).collect::<Vec<_>>(),
        })
    }
}

impl SkipResults {
    /// JSON, as `bench.schema.json` describes it.
    pub(crate) fn json(&self) -> Value {
        json!({
            "planned_rows": self.planned_rows,
            "size": self.size,
            "levels": LEVELS.iter().map(|level| json!({ "id": level.id, "name": level.name })).collect::<Vec<_>>(),
            "rows": self.rows.iter().map(SkipRow::json).collect::<Vec<_>>(),
        })
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn ratios_are_of_rounds_and_deforming_is_no_compute() {
        let entry = |variant, factors: [f64; 3], fragments| SkipEntry {
            variant,
            stages: factors.map(|ms| StageRun { stages: vec![(DEFORM, 8.0), ("reach", ms), ("facing", ms)] }).into(),
            frames: factors.map(|ms| FrameRun { stencil_ms: ms, frame_ms: 10.0 * ms, recording_ms: 0.0 }).into(),
            counted: Counted::default(),
            fragments,
        };
        let row = SkipRow {
            scene: SkipScene::Still,
            casters: 1,
            faces: 12,
            lights: 1,
            pairs_in_range: 1,
            entries: vec![
                entry(Variant::AllOff, [2.0, 9.0, 6.0], Some(30)),
                entry(Variant::AllOn, [1.0, 3.0, 1.0], Some(12)),
                entry(Variant::Without(&LEVELS[0]), [1.0; 3], None),
            ],
        };
        let median = |entry: usize, part| row.ratio(&row.entries[entry], part).map(|ratio| ratio.median);
        for part in [SkipPart::Compute, SkipPart::Stencil, SkipPart::Frame] {
            assert_eq!([0, 1, 2].map(|entry| median(entry, part)), [Some(3.0), Some(1.0), Some(1.0)]);
        }
        assert_eq!(median(0, SkipPart::Deform), Some(1.0));
        assert_eq!(median(0, SkipPart::Recording), None, "no ratio of zeros");
        assert_eq!(row.entries[0].part(SkipPart::Compute).map(|ms| ms.median), Some(12.0));
        // (8 + 2 · 6 + 6) / 60, the median of its rounds.
        assert_eq!(row.entries[0].parts_of_frame().map(|share| share.median), Some(26.0 / 60.0));
        assert_eq!([0, 1, 2].map(|entry| row.fragments_ratio(&row.entries[entry])), [Some(2.5), Some(1.0), None]);
    }

    #[test]
    fn counters_have_names_of_their_own() {
        let mut ids: Vec<&str> = COUNTERS.iter().map(|counter| counter.id).collect();
        ids.sort_unstable();
        ids.dedup();
        assert_eq!(ids.len(), COUNTERS.len());
    }
}
