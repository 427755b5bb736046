//! All that a run found: rows, and where they were measured. As JSON, as a report, as a few lines.

use serde_json::{Value, json};

use crate::Error;
use crate::casters::LIGHTS;
use crate::chart::{Target, png};
use crate::engine::Metric;
use crate::machine::{Adapter, Machine};
use crate::page::{Fact, Page};
use crate::row::{Row, Section, optional_json};
use crate::text::{grouped, three_digits};
use crate::{figures as charts, summary};

/// The title of a report's page, by which it is known.
pub const TITLE: &str = "Silhouettes and shadows: run time against error";

/// Everything one run found.
pub struct Results {
    pub(crate) machine: Machine,
    pub(crate) adapter: Option<Adapter>,
    pub(crate) rows: Vec<Row>,
    /// Rows that there would be, had nothing stopped the run.
    pub(crate) planned_rows: usize,
}

impl Results {
    /// Adds rows that were measured before.
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

    /// The machine and its device: lines above the summary.
    pub fn heading(&self) -> String {
        let gpu = match &self.adapter {
            None => "only the CPU is measured".to_owned(),
            Some(adapter) => {
                let clock = if adapter.has_timestamps { "timestamps" } else { "no timestamps, so by the clock" };
                format!("{}, {clock}, copies {} GB/s", adapter.line(), three_digits(adapter.copy_gb_per_s))
            }
        };
        let Machine { os, cpu, threads, .. } = &self.machine;
        format!("rimline {}\n{gpu}\n{cpu}, {threads} threads, {os}\n\n", env!("CARGO_PKG_VERSION"))
    }

    /// A line for each question that a user has.
    pub fn summary(&self) -> String {
        summary::summary(&self.rows)
    }

    /// JSON, as `bench.schema.json` describes it.
    pub fn json(&self) -> Value {
        let Machine { os, cpu, threads, is_optimised, date } = &self.machine;
        let of = |section: Section| self.rows.iter().filter(move |row| row.section == section);
        let is_of_casters = |row: &&Row| matches!(row.section, Section::Casters | Section::OneMesh);
        let casters: Vec<Value> = of(Section::Casters).map(casters_json).collect();
        let one_mesh: Vec<Value> = of(Section::OneMesh).map(one_mesh_json).collect();
        let size = of(Section::Casters).next().map(|row| row.number("size") as u32);
        json!({
            "format": "rimline-bench",
            "version": 2,
            "complete": self.is_complete(),
            "planned_rows": self.planned_rows,
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
            "rows": self.rows.iter().filter(|row| !is_of_casters(row)).map(Row::json).collect::<Vec<_>>(),
            "casters": size.map(|size| json!({ "lights": LIGHTS, "size": size, "rows": casters, "one_mesh": one_mesh })),
        })
    }

    /// The files of a report, by name.
    ///
    /// # Errors
    /// [`Error::Chart`] if a chart cannot be drawn.
    pub fn report(&self) -> Result<Vec<(String, Vec<u8>)>, Error> {
        let page = self.page();
        let origin = self.origin();
        let mut files = vec![("data.json".to_owned(), format!("{:#}\n", self.json()).into_bytes())];
        for figure in page.sections.iter().flat_map(|section| &section.figures) {
            if let Some(chart) = &figure.chart {
                let svg = chart.svg(Target::File { title: &figure.title, origin: &origin })?;
                files.push((format!("{}.png", figure.id), png(&svg)?));
            }
        }
        files.push(("index.html".to_owned(), page.html()?.into_bytes()));
        Ok(files)
    }

    /// The line below a chart that travels alone.
    fn origin(&self) -> String {
        let device = self.adapter.as_ref().map_or_else(|| "CPU only".to_owned(), Adapter::line);
        let Machine { cpu, threads, date, .. } = &self.machine;
        let day = date.get(..10).unwrap_or_default();
        let origin = format!("{device} · {cpu}, {threads} threads · Rimline {} · {day}", env!("CARGO_PKG_VERSION"));
        // The line has room for about so many letters.
        if origin.chars().count() > 140 {
            format!("{}…", origin.chars().take(139).collect::<String>())
        } else {
            origin
        }
    }

    fn page(&self) -> Page {
        let mut facts = Vec::new();
        let mut fact = |name: &'static str, value: String| facts.push(Fact { name, value });
        match &self.adapter {
            None => fact("GPU", "none; only the CPU was measured".to_owned()),
            Some(adapter) => {
                fact("GPU", format!("{} ({})", adapter.name, adapter.kind));
                fact("Backend and driver", format!("{}, {}", adapter.backend, adapter.driver));
                let clock = if adapter.has_timestamps {
                    "the GPU's own timestamps"
                } else {
                    "the wall clock: it has no timestamps"
                };
                fact("GPU times by", clock.to_owned());
                fact("Copies", format!("{:.1} GB/s, read and written bytes counted", adapter.copy_gb_per_s));
            }
        }
        let machine = &self.machine;
        fact("CPU", format!("{}, {} threads", machine.cpu, machine.threads));
        fact("System", machine.os.clone());
        fact("Rimline", env!("CARGO_PKG_VERSION").to_owned());
        fact("Date", machine.date.replace('T', " ").replace('Z', " UTC"));
        let mut notices = Vec::new();
        if !self.is_complete() {
            let [done, planned] = [self.rows.len(), self.planned_rows].map(grouped);
            notices.push(format!("This run was stopped: {done} of {planned} rows are measured, and shown."));
        }
        if !machine.is_optimised {
            notices.push("This build was not optimised: its CPU times mean nothing.".to_owned());
        }
        Page {
            title: TITLE.to_owned(),
            lead: "Which edges of a mesh are silhouettes, and the shadows whose volumes they bound. Rimline decides in exact \
                   arithmetic, the methods before it in floating point. A bit is wrong where it differs from exact arithmetic \
                   on the positions as they lie in memory (integers on the CPU, which Rimline's tests hold against big \
                   integers by other hands). A loop is open at a vertex where silhouettes do not close, which tears a shadow \
                   volume."
                .to_owned(),
            facts,
            notices,
            sections: charts::sections(&self.rows),
        }
    }
}

/// GPU times of a scene and of what it is held against.
fn compared(row: &Row, other: &str, key: &str, parts: &[(&str, &'static str, &str)]) -> Value {
    let part = |(name, time, of): &(&str, &'static str, &str)| {
        let metric = Metric::Time(time);
        let [scene, found] = [*of, other].map(|id| row.summary(id, metric));
        scene.and(found)?;
        let ratio = optional_json(row.ratio(metric, of, other));
        Some(json!({ "part": name, "scene_ms": optional_json(scene), key: optional_json(found), "ratio": ratio }))
    };
    parts.iter().filter_map(part).collect()
}

/// A row of `casters.rows`, whose keys stay.
fn casters_json(row: &Row) -> Value {
    let metric = Metric::Time("recording");
    let recording = row.entries.iter().filter(|entry| entry.summary(metric).is_some()).map(|entry| {
        let (ms, rounds) = (optional_json(entry.summary(metric)), entry.values(metric));
        json!({ "method": entry.variant.id, "cpu_ms": ms, "cpu_ms_of_rounds": rounds })
    });
    let parts = [
        ("extraction", "extraction", "scene"),
        ("extraction-still", "extraction", "scene-still"),
        ("stages", "stages", "scene"),
        ("draws", "stencil", "scene"),
        ("frame", "frame", "scene"),
    ];
    json!({
        "mesh": row.scene,
        "faces": row.fact("faces"),
        "casters": row.fact("casters"),
        "recording": recording.collect::<Vec<_>>(),
        "scene_bytes": row.fact("scene_bytes"),
        "scene_bytes_per_caster": row.number("scene_bytes") / row.number("casters"),
        "scene_device_bytes": row.fact("scene_device_bytes"),
        "extractors_device_bytes": row.fact("extractors_device_bytes"),
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
