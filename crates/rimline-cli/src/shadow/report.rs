//! Output of `rimline shadow`: what it says, and the files that it writes: a picture, and for each light a mask and its depth
//! maps.

use std::fmt::Write as _;
use std::ops::Range;
use std::path::{Path, PathBuf};

use rimline::cpu::OcclusionStatistics;
use rimline::gpu::ShadowStatistics;
use rimline::{MAX_LIGHTS, Origin};
use rimline_picture::ShadedLight;
use serde_json::{Value, json};

use super::args::{ShadowArgs, ShadowSceneArgs, method_name};
use super::casters::Casters;
use super::casting::Occlusion;
use super::from_depth::{DepthFound, DepthsFound};
use super::shadow_scene::ShadowScene;
use super::shadows::{Found, each};
use crate::coordinates;
use crate::device::{GpuError, describe};
use crate::failure::Failure;
use crate::files::{Inputs, check_ending, is_same_file, is_written};
use crate::image::wrote;
use crate::output::{Filled, Line, Output};
use crate::report::{self, Lines, Times};
use crate::spec::{LightSpec, ShadedLightSpec};

pub(super) struct Report<'a> {
    set: &'a ShadowScene<'a>,
    adapter: String,
    /// For each file.
    found: Vec<Found>,
    pub(super) all: ShadowStatistics,
    occlusion: Option<&'a Occlusion>,
    left_out: usize,
    depth: Option<DepthsFound>,
}

impl<'a> Report<'a> {
    /// Waits for the device.
    pub(super) fn read(
        set: &'a ShadowScene<'_>,
        casters: &Casters<'_>,
        occlusion: Option<&'a Occlusion>,
    ) -> Result<Self, GpuError> {
        let Casters { shadows, .. } = casters;
        Ok(Self {
            set,
            adapter: describe(&casters.gpu().info),
            found: shadows.found()?,
            all: shadows.statistics()?,
            occlusion,
            left_out: shadows.left_out(),
            depth: shadows.depths_found()?,
        })
    }

    fn origin(&self) -> Origin {
        self.set.bodies.first().map_or(Origin::ZERO, |body| body.input.origin())
    }

    /// The files, with what was found for them.
    fn files(&self) -> impl Iterator<Item = (String, &Found)> {
        let names = self.set.bodies.iter().map(|body| body.input.file.display().to_string());
        names.zip(&self.found)
    }

    /// Keys may be added, but never change or go.
    pub(super) fn json(&self, args: &ShadowSceneArgs, times: &Times) -> String {
        let lights = &self.set.shaded_lights;
        let of_lights = lights.iter().enumerate().map(|(number, light)| self.light_json(number, light));
        let report = json!({
            "adapter": self.adapter,
            "method": if self.depth.is_some() { "parity" } else { method_name(args.method) },
            "mode": args.mode.name(),
            "files": self.files().map(|(name, _)| name).collect::<Vec<_>>(),
            "faces": self.set.bodies.iter().map(|body| body.faces.len()).collect::<Vec<_>>(),
            "samples": lights.iter().map(|light| light.samples.len()).max(),
            "count_bound": self.all.count_bound,
            "may_wrap": self.all.may_wrap,
            "lights": of_lights.collect::<Vec<_>>(),
            "statistics": self.files().map(|(name, found)| self.file_json(&name, found)).collect::<Vec<_>>(),
            "totals": self.totals_json(),
        });
        report::json(report, self.origin(), times)
    }

    fn light_json(&self, number: usize, light: &ShadedLight) -> Value {
        let samples = self.set.samples_of(number);
        let caster = |(name, found): (String, &Found)| {
            let chosen = &found.lights[samples.clone()];
            json!({
                "file": name,
                "casting": per_sample(light, chosen.iter().map(|choice| choice.casting)),
                "counting": per_sample(light, chosen.iter().map(|choice| choice.counting)),
                "silhouette_edges": per_sample(light, found.silhouettes[samples.clone()].iter().copied()),
            })
        };
        let mut value = json!({
            "light": coordinates::light(&light.light, self.origin()),
            "range": light.range.is_finite().then_some(light.range),
            "color": light.color,
            "casters": self.files().map(caster).collect::<Vec<_>>(),
        });
        if let Some(occluded) = self.occlusion.and_then(|occlusion| occlusion.found.get(number)) {
            value["occluded"] = occlusion_json(occluded.statistics());
        }
        if let Some(found) = &self.depth {
            value["depth_map"] = depth_map_json(found, light, samples);
        }
        value
    }

    fn file_json(&self, name: &str, Found { shadow, extraction, .. }: &Found) -> Value {
        // A scene knows some bounds and overflows for all files together.
        let is_whole = self.found.len() == 1 || self.depth.is_some();
        let if_whole = |count: u32| is_whole.then_some(count);
        json!({
            "file": name,
            "skipped": shadow.skipped,
            "every_face": shadow.every_face,
            "near_capped": shadow.near_capped,
            "count_bound": if_whole(shadow.count_bound),
            "may_wrap": if_whole(shadow.may_wrap),
            "overflowed_caps": if_whole(shadow.overflowed_caps),
            "undecided_pairs": extraction.undecided_pairs,
            "overflowed_lists": extraction.overflowed_lists,
        })
    }

    fn totals_json(&self) -> Value {
        let extraction = self.found.iter().map(|found| found.extraction);
        let extraction = extraction.reduce(|one, other| each(one, other, u32::saturating_add));
        let mut totals = json!({
            "skipped": self.all.skipped,
            "every_face": self.all.every_face,
            "near_capped": self.all.near_capped,
            "overflowed_caps": self.all.overflowed_caps,
            "overflowed_sides": self.all.overflowed_sides,
            "undecided_pairs": extraction.map(|all| all.undecided_pairs),
            "overflowed_lists": extraction.map(|all| all.overflowed_lists),
        });
        if self.occlusion.is_some() {
            totals["occluded_faces"] = self.left_out.into();
        }
        totals
    }

    /// `pictures` of this size and `archives` were written.
    pub(super) fn text(&self, [pictures, archives]: &[Vec<PathBuf>; 2], size: [u32; 2], times: &Times) -> String {
        let mut lines = Lines::default();
        lines.line("device", &self.adapter);
        lines.origin(self.origin());
        for (body, Found { lights, silhouettes, shadow, .. }) in self.set.bodies.iter().zip(&self.found) {
            lines.line("caster", format!("{}, {} faces", Line(body.input.file.display()), body.faces.len()));
            let edges: u64 = silhouettes.iter().copied().map(u64::from).sum();
            let sum = if lights.len() == 1 { String::new() } else { format!(" for {} lights", lights.len()) };
            lines.line("silhouette edges", format!("{edges}{sum}"));
            let ShadowStatistics { skipped, near_capped, .. } = shadow;
            let counted = |count: u32| format!("for {count} of {} lights", lights.len());
            lines.line("near caps", if *near_capped == 0 { "none needed".to_owned() } else { counted(*near_capped) });
            if *skipped > 0 {
                lines.line("no shadow", format!("{}: the shadow is out of range or out of sight", counted(*skipped)));
            }
        }
        let what = match self.depth.as_ref().map(|found| found.has_walls) {
            Some(true) => "walls and flaps of",
            _ => "cells with",
        };
        for (light, found) in self.depth.iter().flat_map(|found| &found.lights).enumerate() {
            let DepthFound { maps, listed, capacity } = *found;
            let maps = if maps == 1 { "one map".to_owned() } else { format!("{maps} maps") };
            let mut value = format!("light {light}: {maps}, {listed} {what} a border of the shadow");
            if found.is_overflowed() {
                let _ = write!(value, "; their list has room for {capacity}, so every cell is drawn");
            }
            lines.line("depth map", value);
        }
        for found in self.occlusion.iter().flat_map(|occlusion| &occlusion.found) {
            let OcclusionStatistics { tried, occluded, left_out, sides, sides_left, .. } = found.statistics();
            let value = format!(
                "{occluded} of {tried} faces are occluded, {left_out} left out; sides {sides} before, {sides_left} after"
            );
            lines.line("occluded", value);
        }
        lines.times(times);
        let pictures = pictures.iter().map(|file| wrote(file, size));
        let archives = archives.iter().map(|file| format!("wrote {}", Line(file.display())));
        let wrote: String = pictures.chain(archives).map(|line| line + "\n").collect();
        lines.0 + &wrote
    }
}

/// The value of a light, or for one with an area a list with the value of each sample.
fn per_sample<T: Into<Value>>(light: &ShadedLight, values: impl Iterator<Item = T>) -> Value {
    let values: Vec<Value> = values.map(Into::into).collect();
    match (light.area.is_some(), values.first()) {
        (false, Some(one)) => one.clone(),
        _ => values.into(),
    }
}

fn occlusion_json(statistics: OcclusionStatistics) -> Value {
    let OcclusionStatistics { tried, occluded, left_out, undecided, without_room, sides, sides_left, .. } = statistics;
    json!({
        "tried": tried, "occluded": occluded, "undecided": undecided, "without_room": without_room,
        "left_out": left_out, "sides": sides, "sides_left": sides_left,
    })
}

/// The maps of a light, whose `samples` are these of all samples.
fn depth_map_json(found: &DepthsFound, light: &ShadedLight, samples: Range<usize>) -> Value {
    let DepthsFound { size, has_walls, lights, .. } = found;
    let found: Vec<DepthFound> = samples.filter_map(|sample| lights.get(sample).copied()).collect();
    let each = |value: fn(&DepthFound) -> Value| per_sample(light, found.iter().map(value));
    let side = (size[0] == size[1]).then_some(size[0]);
    let (maps, listed) = (each(|found| found.maps.into()), each(|found| found.listed.into()));
    let overflowed = each(|found| found.is_overflowed().into());
    let (name, cells, walls) =
        if *has_walls { ("contours", Value::Null, listed) } else { ("triangles", listed, Value::Null) };
    json!({
        "size": size, "side": side, "maps": maps, "reconstruction": name, "cells": cells, "walls": walls,
        "overflowed": overflowed,
    })
}

/// Files in the making. A file that is dropped before it is finished leaves nothing.
pub(super) struct ResultFiles {
    pub(super) picture: Option<Output>,
    /// Not open: a process may have a thousand files open, and there may be as many lights.
    pub(super) masks: Vec<PathBuf>,
    pub(super) maps: Vec<PathBuf>,
    /// The files that are complete. They are finished together.
    pub(super) filled: Vec<Filled>,
    /// Names of picture and masks, and names of maps.
    pub(super) names: [Vec<PathBuf>; 2],
}

impl ResultFiles {
    /// Refuses a picture that is named as another format.
    pub(super) fn check(args: &ShadowArgs) -> Result<(), Failure> {
        args.out.as_deref().map_or(Ok(()), |out| check_ending(out, "png"))
    }

    /// Begins those whose names are known from the command line, so that an unwritable path is known at once.
    pub(super) fn begin(args: &ShadowArgs, inputs: &Inputs) -> Result<Self, Failure> {
        args.out.as_deref().map_or(Ok(()), |out| inputs.spare(out))?;
        // There is a first light in any case; how many there are is known later.
        for first in of_lights(args, 1).into_iter().flatten() {
            inputs.spare(&first)?;
            Output::check(&first)?;
        }
        let picture = args.out.as_deref().map(Output::create).transpose()?;
        let names = [args.out.iter().cloned().collect(), Vec::new()];
        Ok(Self { picture, masks: Vec::new(), maps: Vec::new(), filled: Vec::new(), names })
    }

    /// Tries those of all lights.
    pub(super) fn begin_lights(&mut self, args: &ShadowArgs, inputs: &Inputs, lights: usize) -> Result<(), Failure> {
        let files = of_lights(args, lights);
        let is_any = |out: &&Path| files.iter().flatten().any(|file| is_same_file(out, file));
        if let Some(out) = args.out.as_deref().filter(is_any) {
            return Err(Failure::usage(format!(
                "--out and --mask would both write {}; change one of them",
                out.display()
            )));
        }
        files.iter().flatten().try_for_each(|file| inputs.spare(file))?;
        files.iter().flatten().try_for_each(|file| Output::check(file))?;
        for (names, files) in self.names.iter_mut().zip(&files) {
            names.extend_from_slice(files);
        }
        [self.masks, self.maps] = files;
        Ok(())
    }
}

/// All files that may be written: how many lights a model has is known when it is read.
pub(crate) fn files(args: &ShadowArgs) -> Vec<PathBuf> {
    files_with(args, MAX_LIGHTS)
}

/// Whether all files are there. Only where they may be, the model is read to know how many lights it has.
pub(crate) fn are_written(args: &ShadowArgs) -> bool {
    let are_there = |of_file| files_with(args, of_file).iter().all(|file| is_written(file));
    if args.scene.lights.iter().all(|light| light.light != LightSpec::All) {
        return are_there(0);
    }
    let lights = || {
        let file = rimline_files::read(args.scene.files.first()?, &args.scene.read.options()).ok()?;
        file.asset().map(|asset| asset.light_names().len()).filter(|&lights| lights > 0)
    };
    are_there(1) && lights().is_some_and(are_there)
}

/// The files that are written where a model has so many lights of its own.
fn files_with(args: &ShadowArgs, of_file: usize) -> Vec<PathBuf> {
    let count = |light: &ShadedLightSpec| if light.light == LightSpec::All { of_file } else { 1 };
    let lights = args.scene.lights.iter().map(count).sum::<usize>().clamp(1, MAX_LIGHTS);
    args.out.iter().cloned().chain(of_lights(args, lights).into_iter().flatten()).collect()
}

fn of_lights(args: &ShadowArgs, lights: usize) -> [Vec<PathBuf>; 2] {
    [(&args.mask, "png"), (&args.save_depth, "npz")].map(|(prefix, ending)| {
        prefix.iter().flat_map(|prefix| (0..lights).map(|light| numbered(prefix, light, ending))).collect()
    })
}

/// `PREFIX.<light>.<ending>`.
fn numbered(prefix: &Path, light: usize, ending: &str) -> PathBuf {
    let mut name = prefix.as_os_str().to_owned();
    name.push(format!(".{light}.{ending}"));
    name.into()
}

#[cfg(test)]
mod tests {

    #[test]
    fn masks_are_numbered_after_their_prefix() {
        assert_eq!(super::numbered("a/b.x".as_ref(), 3, "png"), super::Path::new("a/b.x.3.png"));
    }
}
