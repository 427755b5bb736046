//! Where the results go: JSON, a page, plots.

use std::fs::File;
use std::io::{ErrorKind, Read as _, Write as _};
use std::path::{Path, PathBuf};

use super::args::BenchArgs;
use super::figures;
use super::machine::Adapter;
use super::results::Results;
use super::text::grouped;
use crate::chart::{Target, write_png};
use crate::ending::{self, Written};
use crate::failure::{Failure, UsageError};
use crate::output::{Folder, Output, note};
use crate::page::{Fact, Page, Section};

/// The files that the command line asks for.
pub(super) struct Destination {
    folder: Option<(PathBuf, Folder)>,
    json: Option<Output>,
}

impl Destination {
    /// Makes the folder, and tries both places, so that an unwritable one is known before the long work.
    pub(super) fn new(args: &BenchArgs) -> Result<Self, Failure> {
        let folder = |path: &PathBuf| -> Result<_, Failure> {
            ending::check_report(path)?;
            check_own(path)?;
            let folder = Folder::create_all(path)?;
            drop(Output::create(&path.join("index.html"))?);
            Ok((path.clone(), folder))
        };
        args.json.as_deref().map_or(Ok(()), |file| ending::check(file, Written::Json))?;
        Ok(Self {
            folder: args.report.as_ref().map(folder).transpose()?,
            json: args.json.as_deref().map(Output::create).transpose()?,
        })
    }

    pub(super) fn write(self, results: &Results) -> Result<(), Failure> {
        let data = format!("{:#}\n", results.json());
        if let Some(file) = self.json {
            file.finish(|output| output.write_all(data.as_bytes()))?;
        }
        let Some((folder, _kept)) = &self.folder else { return Ok(()) };
        write(&folder.join("data.json"), data.as_bytes())?;
        let page = page(results);
        let origin = origin(results);
        let file = |id: &str| folder.join(format!("{id}.png"));
        // Plots of an earlier report may show results that this one does not have.
        for id in figures::PLOTS {
            match std::fs::remove_file(file(id)) {
                Err(source) if source.kind() != ErrorKind::NotFound => {
                    return Err(Failure::Output { file: file(id), source });
                }
                _ => {}
            }
        }
        for figure in page.sections.iter().flat_map(|section| &section.figures) {
            if let Some(chart) = &figure.chart {
                let target = Target::File { title: &figure.title, origin: &origin };
                Output::create(&file(figure.id))?.finish(|file| write_png(&chart.svg(target)?, file))?;
            }
        }
        let index = folder.join("index.html");
        Output::create(&index)?.finish(|file| file.write_all(page.html()?.as_bytes()))?;
        note(&format!("wrote {}", index.display()));
        Ok(())
    }
}

/// The title of a report's page, by which it is known.
const TITLE: &str = "Silhouettes and shadows: run time against error";

/// Refuses a folder where a report would replace files of somebody else: those that it writes are there, and the page is
/// not a report's.
fn check_own(folder: &Path) -> Result<(), UsageError> {
    let plots = figures::PLOTS.map(|id| format!("{id}.png"));
    let names = ["index.html", "data.json"].into_iter().chain(plots.iter().map(String::as_str));
    let there = names.map(|name| folder.join(name)).find(|file| file.symlink_metadata().is_ok());
    match there {
        Some(file) if !is_report(&folder.join("index.html")) => {
            Err(UsageError::NotAReport { folder: folder.to_owned(), file })
        }
        _ => Ok(()),
    }
}

/// Whether a page is one that this command wrote: its head has the title.
fn is_report(page: &Path) -> bool {
    const HEAD: u64 = 1 << 12;
    let mut head = Vec::new();
    // A pipe would be waited for.
    if page.is_file() {
        let _ = File::open(page).and_then(|file| file.take(HEAD).read_to_end(&mut head));
    }
    String::from_utf8_lossy(&head).contains(&format!("<title>{TITLE}</title>"))
}

fn write(file: &Path, bytes: &[u8]) -> Result<(), Failure> {
    Output::create(file)?.finish(|output| output.write_all(bytes))
}

/// The line below a plot that travels alone.
fn origin(results: &Results) -> String {
    let device = results.adapter.as_ref().map_or_else(|| "CPU only".to_owned(), Adapter::line);
    let machine = &results.machine;
    let day = machine.date.get(..10).unwrap_or_default();
    let origin = format!(
        "{device} · {}, {} threads · Rimline {} · {day}",
        machine.cpu,
        machine.threads,
        env!("CARGO_PKG_VERSION")
    );
    // The line has room for about so many letters.
    if origin.chars().count() > 165 { format!("{}…", origin.chars().take(164).collect::<String>()) } else { origin }
}

fn page(results: &Results) -> Page {
    let mut facts = Vec::new();
    let mut fact = |name: &'static str, value: String| facts.push(Fact { name, value });
    match &results.adapter {
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
    let machine = &results.machine;
    fact("CPU", format!("{}, {} threads", machine.cpu, machine.threads));
    fact("System", machine.os.clone());
    let runs = || results.rows.iter().flat_map(|row| &row.entries).map(|entry| entry.samples.len());
    if let (Some(least), Some(most)) = (runs().min(), runs().max()) {
        let runs = if least == most { most.to_string() } else { format!("{least} to {most}") };
        fact("Counted runs", format!("{runs} of each method, after warming up"));
    }
    fact("Rimline", env!("CARGO_PKG_VERSION").to_owned());
    fact("Date", machine.date.replace('T', " ").replace('Z', " UTC"));
    let mut notices = Vec::new();
    if !results.is_complete() {
        let [done, planned] = [results.rows_done(), results.rows_planned()].map(grouped);
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
        sections: sections(results),
    }
}

fn sections(results: &Results) -> Vec<Section> {
    let extraction = (!results.rows.is_empty()).then(|| figures::extraction(results));
    let shadows = results.shadows.as_ref().filter(|shadows| !shadows.rows.is_empty()).map(figures::shadows);
    let casters = results.casters.as_ref().filter(|casters| casters.rows_done() > 0).map(figures::casters);
    let skipping = results.skipping.as_ref().filter(|skipping| !skipping.rows.is_empty()).map(figures::skipping);
    let depth_maps = results.depth_maps.as_ref().map(figures::depth_maps);
    extraction.into_iter().chain(shadows).chain(casters).chain(skipping).chain(depth_maps).collect()
}
