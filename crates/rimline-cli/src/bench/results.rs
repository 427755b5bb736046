//! Results of measurements, and their JSON.

use rimline_bench::error_metrics::Score;
use serde_json::{Value, json};

use super::casters::results::CastersResults;
use super::depth_maps::DepthMapResults;
use super::machine::{Adapter, Machine};
use super::measure::{Sample, Summary};
use super::method::{CONTESTANTS, Contestant};
use super::shadows::results::ShadowResults;
use super::skip::results::SkipResults;
use super::summary_json::summary_json;

/// Everything one run of the command found.
pub(crate) struct Results {
    pub(crate) machine: Machine,
    pub(crate) adapter: Option<Adapter>,
    pub(crate) subjects: Vec<SubjectFacts>,
    pub(crate) rows: Vec<Row>,
    /// Rows of extraction that there would be, had nothing stopped the run.
    pub(crate) planned_rows: usize,
    /// `None` where none were asked for.
    pub(crate) shadows: Option<ShadowResults>,
    /// `None` where none were asked for.
    pub(crate) casters: Option<CastersResults>,
    /// `None` where none were asked for.
    pub(crate) skipping: Option<SkipResults>,
    /// Measured before, by another program. `None` where none were given.
    pub(crate) depth_maps: Option<DepthMapResults>,
}

/// A mesh that was measured.
#[derive(Clone, Debug)]
pub(crate) struct SubjectFacts {
    pub(crate) name: String,
    pub(crate) class: &'static str,
    pub(crate) vertices: usize,
    pub(crate) faces: usize,
    pub(crate) edges: usize,
    pub(crate) is_closed: bool,
    pub(crate) topology_ms: f64,
    pub(crate) topology_bytes: usize,
}

/// One mesh with some lights: all its methods ran in turn.
pub(crate) struct Row {
    pub(crate) subject: SubjectFacts,
    pub(crate) lights: usize,
    pub(crate) entries: Vec<Entry>,
}

/// One method in a row.
pub(crate) struct Entry {
    pub(crate) contestant: &'static Contestant,
    /// A run each, in the order of the rounds.
    pub(crate) samples: Vec<Sample>,
    pub(crate) score: Score,
    /// Pairs of face and light that an exact method settled in integers.
    pub(crate) undecided_pairs: u32,
}

impl Results {
    pub(crate) fn is_empty(&self) -> bool {
        self.rows_done() == 0 && self.depth_maps.is_none()
    }

    /// Rows measured, of extraction, of shadows, of scenes of many casters and of skipping.
    pub(crate) fn rows_done(&self) -> usize {
        let shadows = self.shadows.as_ref().map_or(0, |shadows| shadows.rows.len());
        let skipping = self.skipping.as_ref().map_or(0, |skipping| skipping.rows.len());
        self.rows.len() + shadows + self.casters.as_ref().map_or(0, CastersResults::rows_done) + skipping
    }

    /// Rows that there would be, had nothing stopped the run.
    pub(crate) fn rows_planned(&self) -> usize {
        let shadows = self.shadows.as_ref().map_or(0, |shadows| shadows.planned_rows);
        let casters = self.casters.as_ref().map_or(0, |casters| casters.planned_rows);
        self.planned_rows + shadows + casters + self.skipping.as_ref().map_or(0, |skipping| skipping.planned_rows)
    }

    pub(crate) fn is_complete(&self) -> bool {
        self.rows_done() == self.rows_planned()
    }

    /// JSON, as `bench.schema.json` describes it.
    pub(crate) fn json(&self) -> Value {
        let Machine { os, cpu, threads, is_optimised, date } = &self.machine;
        let methods: Vec<Value> = self.contestants().map(|contestant| {
            json!({ "id": contestant.id, "name": contestant.name, "device": if contestant.is_gpu() { "gpu" } else { "cpu" } })
        }).collect();
        json!({
            "format": "rimline-bench",
            "version": 1,
            "complete": self.is_complete(),
            "rimline": env!("CARGO_PKG_VERSION"),
            "date": date,
            "machine": { "os": os, "cpu": cpu, "threads": threads, "optimised": is_optimised },
            "adapter": self.adapter.as_ref().map(|adapter| json!({
                "name": adapter.name,
                "backend": adapter.backend,
                "type": adapter.kind,
                "driver": adapter.driver,
                "timestamps": adapter.has_timestamps,
                "copy_gb_per_s": adapter.copy_gb_per_s,
            })),
            "extraction": {
                "planned_rows": self.planned_rows,
                "methods": methods,
                "subjects": self.subjects.iter().map(SubjectFacts::json).collect::<Vec<_>>(),
                "rows": self.rows.iter().map(Row::json).collect::<Vec<_>>(),
            },
            "shadows": self.shadows.as_ref().map(ShadowResults::json),
            "casters": self.casters.as_ref().map(CastersResults::json),
            "skipping": self.skipping.as_ref().map(SkipResults::json),
            "depth_maps": self.depth_maps.as_ref().map(DepthMapResults::json),
        })
    }

    /// The methods that took part, in their usual order.
    pub(crate) fn contestants(&self) -> impl Iterator<Item = &'static Contestant> {
        CONTESTANTS.iter().filter(|contestant| self.rows.iter().any(|row| row.entry(contestant.id).is_some()))
    }
}

impl SubjectFacts {
    fn json(&self) -> Value {
        json!({
            "name": self.name,
            "class": self.class,
            "vertices": self.vertices,
            "faces": self.faces,
            "edges": self.edges,
            "closed": self.is_closed,
            "topology_ms": self.topology_ms,
            "topology_bytes": self.topology_bytes,
        })
    }
}

impl Row {
    pub(crate) fn entry(&self, id: &str) -> Option<&Entry> {
        self.entries.iter().find(|entry| entry.contestant.id == id)
    }

    /// Times of one method divided by those of another, round by round.
    pub(crate) fn ratio(&self, id: &str, to: &str) -> Option<Summary> {
        let [own, other] = [self.entry(id)?, self.entry(to)?];
        Summary::of(own.samples.iter().zip(&other.samples).map(|(own, other)| own.time_ms() / other.time_ms()))
    }

    fn json(&self) -> Value {
        let results = self.entries.iter().map(|entry| {
            let ratios = entry.contestant.compared_to.iter().filter(|to| **to != entry.contestant.id);
            let ratios: Vec<Value> = ratios
                .filter_map(|to| {
                    let mut ratio = summary_json(&self.ratio(entry.contestant.id, to)?);
                    ratio["to"] = (*to).into();
                    Some(ratio)
                })
                .collect();
            let Score { wrong_facing_bits, wrong_silhouette_bits, unclosed_vertices, .. } = entry.score;
            let stages: Vec<Value> = entry
                .stages()
                .into_iter()
                .map(|(stage, milliseconds)| json!({ "stage": stage, "ms": milliseconds }))
                .collect();
            let summary = |values: Option<Summary>| values.as_ref().map_or(Value::Null, summary_json);
            json!({
                "method": entry.contestant.id,
                "wall_ms": summary(entry.wall()),
                "wall_ms_of_rounds": entry.samples.iter().map(|sample| sample.wall_ms).collect::<Vec<_>>(),
                "gpu_ms": summary(entry.gpu()),
                "gpu_ms_of_rounds": entry.samples.iter().filter_map(|sample| sample.gpu_ms).collect::<Vec<_>>(),
                "stages": stages,
                "ratios": ratios,
                "wrong_facing_bits": wrong_facing_bits,
                "wrong_silhouette_bits": wrong_silhouette_bits,
                "unclosed_vertices": unclosed_vertices,
                "undecided_pairs": entry.undecided_pairs,
            })
        });
        json!({
            "subject": self.subject.name,
            "lights": self.lights,
            "facing_bits": self.subject.faces * self.lights,
            "silhouette_bits": self.subject.edges * self.lights,
            "results": results.collect::<Vec<_>>(),
        })
    }
}

impl Entry {
    /// The GPU's own time where it is known, else the clock's.
    pub(crate) fn time(&self) -> Option<Summary> {
        Summary::of(self.samples.iter().map(Sample::time_ms))
    }

    fn wall(&self) -> Option<Summary> {
        Summary::of(self.samples.iter().map(|sample| sample.wall_ms))
    }

    fn gpu(&self) -> Option<Summary> {
        Summary::of(self.samples.iter().filter_map(|sample| sample.gpu_ms))
    }

    /// Milliseconds of each stage in the run whose time is the median, or the one above it.
    pub(crate) fn stages(&self) -> Vec<(&'static str, f64)> {
        self.median_run().map(|sample| sample.stages.clone()).unwrap_or_default()
    }

    /// The run whose time is the median, or the one above it.
    pub(crate) fn median_run(&self) -> Option<&Sample> {
        let mut sorted: Vec<&Sample> = self.samples.iter().collect();
        sorted.sort_by(|a, b| a.time_ms().total_cmp(&b.time_ms()));
        sorted.get(sorted.len() / 2).copied()
    }
}
