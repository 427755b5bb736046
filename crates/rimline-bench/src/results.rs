//! All that a run found: rows, and where they were measured. As JSON, as a report, as a few lines.

use serde_json::{Value, json};

use crate::Error;
use crate::chart::{Target, png};
use crate::engine::Metric;
use crate::machine::{Adapter, Machine};
use crate::page::Page;
use crate::row::{Row, Section, summary_json};
use crate::text::{grouped, three_digits};
use crate::{figures, summary};

/// The title of a report's page, by which it is known.
pub const TITLE: &str = "Silhouettes and shadows: run time against error";
const VERSION: &str = env!("CARGO_PKG_VERSION");

pub struct Results {
    pub(crate) machine: Machine,
    pub(crate) adapter: Option<Adapter>,
    pub(crate) rows: Vec<Row>,
    /// Rows that there would be, had nothing stopped the run.
    pub(crate) planned_rows: usize,
}

impl Results {
    pub fn add(&mut self, rows: Vec<Row>) {
        self.planned_rows += rows.len();
        self.rows.extend(rows);
    }

    pub fn is_empty(&self) -> bool {
        self.rows.is_empty()
    }

    pub fn is_complete(&self) -> bool {
        self.rows.len() == self.planned_rows
    }

    pub fn is_optimised(&self) -> bool {
        self.machine.is_optimised
    }

    /// The device and the machine.
    fn devices(&self) -> [String; 2] {
        let gpu = match &self.adapter {
            None => "only the CPU is measured".to_owned(),
            Some(adapter) => {
                let clock = if adapter.has_timestamps { "timestamps" } else { "no timestamps, so by the clock" };
                format!("{}, {clock}, copies {} GB/s", adapter.line(), three_digits(adapter.copy_gb_per_s))
            }
        };
        let Machine { os, cpu, threads, .. } = &self.machine;
        [gpu, format!("{cpu}, {threads} threads, {os}")]
    }

    /// The machine and its device: lines above the summary.
    pub fn heading(&self) -> String {
        let [gpu, cpu] = self.devices();
        format!("rimline {VERSION}\n{gpu}\n{cpu}\n\n")
    }

    pub fn summary(&self) -> String {
        summary::summary(&self.rows)
    }

    pub fn json(&self) -> Value {
        let Machine { os, cpu, threads, is_optimised, date } = &self.machine;
        let of = |section: Section| self.rows.iter().filter(move |row| row.section == section);
        let is_of_casters = |row: &&Row| matches!(row.section, Section::Casters | Section::OneMesh);
        let casters = self.rows.iter().find(is_of_casters).map(|first| {
            json!({
                "lights": first.lights(),
                "size": first.fact("size"),
                "rows": of(Section::Casters).map(casters_json).collect::<Vec<_>>(),
                "one_mesh": of(Section::OneMesh).map(one_mesh_json).collect::<Vec<_>>(),
            })
        });
        json!({
            "format": "rimline-bench",
            "version": 3,
            "complete": self.is_complete(),
            "planned_rows": self.planned_rows,
            "rimline": VERSION,
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
            "rows": self.rows.iter().filter(|row| !is_of_casters(row)).map(Row::json).collect::<Vec<_>>(),
            "casters": casters,
        })
    }

    /// The files of a report, by name.
    pub fn report(&self) -> Result<Vec<(String, Vec<u8>)>, Error> {
        let page = self.page();
        let device = self.adapter.as_ref().map_or_else(|| "CPU only".to_owned(), Adapter::line);
        let Machine { cpu, threads, date, .. } = &self.machine;
        let origin = format!("{device} · {cpu}, {threads} threads · Rimline {VERSION} · {date:.10}");
        // The line below a chart has room for about so many letters.
        let origin: String = origin.chars().take(140).collect();
        let mut files = vec![("data.json".to_owned(), format!("{:#}\n", self.json()).into_bytes())];
        for figure in page.sections.iter().flat_map(|section| &section.figures) {
            if let Some(chart) = &figure.chart {
                let target = Target::File { title: &figure.title, origin: &origin };
                let svg = chart.svg(target, "xmlns=\"http://www.w3.org/2000/svg\"");
                files.push((format!("{}.png", figure.id), png(&svg)?));
            }
        }
        files.push(("index.html".to_owned(), page.html().into_bytes()));
        Ok(files)
    }

    fn page(&self) -> Page {
        let mut notices = Vec::new();
        if !self.is_complete() {
            let [done, planned] = [self.rows.len(), self.planned_rows].map(grouped);
            notices.push(format!("This run was stopped: {done} of {planned} rows are measured, and shown."));
        }
        if !self.is_optimised() {
            notices.push("This build was not optimised: its CPU times mean nothing.".to_owned());
        }
        let ([gpu, cpu], date) = (self.devices(), self.machine.date.replace('T', " ").replace('Z', " UTC"));
        Page {
            title: TITLE.to_owned(),
            lead: "Which edges of a mesh are silhouettes, and the shadows whose volumes they bound. Rimline decides in exact \
                   arithmetic, the methods before it in floating point. A bit is wrong where it differs from exact arithmetic \
                   on the positions as they lie in memory (integers on the CPU, which Rimline's tests hold against big \
                   integers by other hands). A loop is open at a vertex where silhouettes do not close, which tears a shadow \
                   volume."
                .to_owned(),
            facts: vec![("GPU", gpu), ("CPU", cpu), ("Rimline", VERSION.to_owned()), ("Date", date)],
            notices,
            sections: figures::sections(&self.rows),
        }
    }
}

/// GPU times of a scene and of another variant: the parts' names, their times, and the scene's variants.
fn compared(row: &Row, other: &str, key: &str, parts: &[(&str, &'static str, &str)]) -> Value {
    let part = |(name, time, of): &(&str, &'static str, &str)| {
        let metric = Metric::Time(time);
        let (scene, found) = (row.summary(of, metric)?, row.summary(other, metric)?);
        let ratio = summary_json(row.ratio(metric, of, other));
        Some(
            json!({ "part": name, "scene_ms": summary_json(Some(scene)), key: summary_json(Some(found)), "ratio": ratio }),
        )
    };
    parts.iter().filter_map(part).collect()
}

/// A row of `casters.rows`, whose keys stay.
fn casters_json(row: &Row) -> Value {
    let metric = Metric::Time("recording");
    let recording = row.entries.iter().filter(|entry| entry.summary(metric).is_some()).map(|entry| {
        let (ms, rounds) = (summary_json(entry.summary(metric)), entry.values(metric));
        json!({ "method": entry.variant.id, "cpu_ms": ms, "cpu_ms_of_rounds": rounds })
    });
    let parts = [
        ("extraction", "extraction", "scene"),
        ("extraction-still", "extraction", "scene-still"),
        ("stages", "stages", "scene"),
        ("draws", "stencil", "scene"),
        ("frame", "frame", "scene"),
    ];
    let bytes = |id: &str, name| row.entry(id)?.values(Metric::Count(name)).first().map(|bytes| *bytes as u64);
    let scene_bytes = bytes("scene-still", "bytes").unwrap_or(0);
    json!({
        "mesh": row.scene,
        "faces": row.fact("faces"),
        "casters": row.fact("casters"),
        "recording": recording.collect::<Vec<_>>(),
        "scene_bytes": scene_bytes,
        "scene_bytes_per_caster": scene_bytes as f64 / row.number("casters"),
        "scene_device_bytes": bytes("scene-still", "device_bytes"),
        "extractors_device_bytes": bytes("extractors", "device_bytes"),
        "gpu": compared(row, "merged", "merged_ms", &parts),
        "silhouette_edges": row.fact("silhouette_edges"),
        "wrong_lights": row.fact("wrong_lights"),
    })
}

fn one_mesh_json(row: &Row) -> Value {
    json!({
        "faces": row.fact("faces"),
        "gpu": compared(row, "extractor", "extractor_ms", &[("extraction", "extraction", "scene")]),
        "silhouette_edges": row.fact("silhouette_edges"),
        "wrong_lights": row.fact("wrong_lights"),
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_scene_of_one_mesh_is_in_the_data_without_scenes_of_many_casters() {
        let name = || "one-mesh".to_owned();
        let facts = vec![("faces", json!(8)), ("lights", json!(5)), ("size", json!(256))];
        let (section, entries) = (Section::OneMesh, Vec::new());
        let row = Row { section, scene: name(), title: name(), group: name(), facts, entries };
        let data = Results { machine: Machine::this(), adapter: None, rows: vec![row], planned_rows: 1 }.json();
        let casters = &data["casters"];
        assert_eq!(
            (&casters["size"], &casters["rows"], &casters["one_mesh"][0]["faces"]),
            (&json!(256), &json!([]), &json!(8))
        );
    }
}
