//! What `rimline shadow` prints.

use std::fmt::Write as _;
use std::path::PathBuf;

use rimline::gpu::{ReadError, read_back_vec};
use rimline::reference::layout::{ExtractionStatistics, ShadowLight, ShadowStatistics};
use rimline::reference::shadow::{COUNT_Z_FAIL, COUNT_Z_PASS, COUNT_ZP_PLUS, COUNT_ZP_PLUS_2005};
use serde_json::{Value, json};

use super::caster::Caster;
use super::counts::{self, CountBound};
use super::shadow_scene::ShadowScene;
use crate::device::{Gpu, describe};
use crate::shadow::args::{ShadowSceneArgs, value_name};
use crate::shown::Line;
use crate::times::Times;

/// What one caster's stages found and chose.
struct Found {
    file: String,
    faces: usize,
    lights: Vec<ShadowLight>,
    silhouettes: Vec<u32>,
    shadow: ShadowStatistics,
    extraction: ExtractionStatistics,
}

/// What came out, in numbers.
pub(super) struct Report {
    adapter: String,
    found: Vec<Found>,
    /// Of each light, as given.
    lights: Vec<([f32; 4], f32, [f32; 3])>,
    samples: usize,
    pub(super) bound: CountBound,
}

fn casting(light: &ShadowLight) -> &'static str {
    ["nothing", "averted", "every"].get(light.casting as usize).copied().unwrap_or("unknown")
}

fn counting(light: &ShadowLight) -> &'static str {
    match light.counting {
        COUNT_Z_PASS => "z-pass",
        COUNT_ZP_PLUS => "zp+",
        COUNT_Z_FAIL => "z-fail",
        COUNT_ZP_PLUS_2005 => "zp+paper",
        _ => "unknown",
    }
}

impl Report {
    /// Waits for the device.
    pub(super) fn read(gpu: &Gpu, set: &ShadowScene<'_>, casters: &[Caster]) -> Result<Self, ReadError> {
        let (device, queue) = (&gpu.device, &gpu.queue);
        let samples = set.samples();
        let mut found = Vec::new();
        for (caster, body) in casters.iter().zip(&set.bodies) {
            let results = caster.extractor.results();
            let (lights, shadow) = counts::read(gpu, caster, samples)?;
            let mut silhouettes: Vec<u32> = read_back_vec(device, queue, results.counts)?;
            silhouettes.truncate(samples);
            let extraction: Vec<ExtractionStatistics> = read_back_vec(device, queue, results.statistics)?;
            found.push(Found {
                file: body.input.file.display().to_string(),
                faces: body.scene.mesh.faces().len(),
                lights,
                silhouettes,
                shadow,
                extraction: extraction.first().copied().unwrap_or(bytemuck::Zeroable::zeroed()),
            });
        }
        let bounds: Vec<_> = found.iter().map(|found| (found.lights.as_slice(), found.shadow)).collect();
        Ok(Self {
            adapter: describe(&gpu.info),
            bound: CountBound::new(&bounds),
            found,
            lights: set
                .shaded_lights
                .iter()
                .map(|shaded| (shaded.light.to_array(), shaded.range, shaded.color))
                .collect(),
            samples: samples / set.shaded_lights.len().max(1),
        })
    }

    /// Keys are stable: they are only ever added to.
    pub(super) fn json(&self, args: &ShadowSceneArgs, times: &Times) -> String {
        let is_soft = args.area.is_some();
        let per_sample = |values: Vec<Value>| match (is_soft, values.first()) {
            (false, Some(one)) => one.clone(),
            _ => values.into(),
        };
        let light = |(number, &(light, range, color)): (usize, &([f32; 4], f32, [f32; 3]))| {
            let of = number * self.samples..(number + 1) * self.samples;
            let caster = |found: &Found| {
                let chosen = &found.lights[of.clone()];
                json!({
                    "file": found.file,
                    "casting": per_sample(chosen.iter().map(|light| casting(light).into()).collect()),
                    "counting": per_sample(chosen.iter().map(|light| counting(light).into()).collect()),
                    "silhouette_edges": per_sample(found.silhouettes[of.clone()].iter().map(|&n| n.into()).collect()),
                })
            };
            json!({
                "light": light,
                "range": range.is_finite().then_some(range),
                "color": color,
                "casters": self.found.iter().map(caster).collect::<Vec<_>>(),
            })
        };
        let statistics = |Found { file, shadow, extraction, .. }: &Found| {
            json!({
                "file": file,
                "skipped": shadow.skipped,
                "every_face": shadow.every_face,
                "capped": shadow.capped,
                "count_bound": shadow.count_bound,
                "may_wrap": shadow.may_wrap,
                "overflowed_caps": shadow.overflowed_caps,
                "undecided_pairs": extraction.undecided_pairs,
                "overflowed_lists": extraction.overflowed_lists,
            })
        };
        let [set_up, work] = times.set_up_and_work();
        let report = json!({
            "adapter": self.adapter,
            "method": value_name(&args.method),
            "mode": value_name(&args.mode),
            "files": self.found.iter().map(|found| &found.file).collect::<Vec<_>>(),
            "faces": self.found.iter().map(|found| found.faces).collect::<Vec<_>>(),
            "samples": self.samples,
            "count_bound": self.bound.count_bound,
            "may_wrap": self.bound.may_wrap,
            "lights": self.lights.iter().enumerate().map(light).collect::<Vec<_>>(),
            "statistics": self.found.iter().map(statistics).collect::<Vec<_>>(),
            "milliseconds": times.json(),
            "set_up_milliseconds": set_up,
            "work_milliseconds": work,
        });
        format!("{report:#}\n")
    }

    pub(super) fn text(&self, written: &[PathBuf], size: [u32; 2], times: &Times) -> String {
        let mut text = String::new();
        let mut line = |name: &str, value: &str| {
            let _ = writeln!(text, "{name:<18} {value}");
        };
        line("device", &self.adapter);
        for Found { file, faces, lights, silhouettes, shadow, .. } in &self.found {
            line("caster", &format!("{}, {faces} faces", Line(file)));
            let edges: u64 = silhouettes.iter().copied().map(u64::from).sum();
            let sum = if lights.len() == 1 { String::new() } else { format!(" for {} lights", lights.len()) };
            line("silhouette edges", &format!("{edges}{sum}"));
            let ShadowStatistics { skipped, capped, .. } = shadow;
            let counted = |count: u32| format!("for {count} of {} lights", lights.len());
            line("near caps", &if *capped == 0 { "none needed".to_owned() } else { counted(*capped) });
            if *skipped > 0 {
                line("no shadow", &format!("{}: the shadow is out of range or out of sight", counted(*skipped)));
            }
        }
        line("milliseconds", &times.sums());
        line("by stage", &times.text());
        for file in written {
            let _ = writeln!(text, "{}", crate::image::wrote(file, size));
        }
        text
    }
}
