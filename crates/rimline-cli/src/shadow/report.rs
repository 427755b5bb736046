//! Output of `rimline shadow`: what it says, and the files that it writes: a picture, and for each light a mask and its depth
//! maps.

use std::fmt::Write as _;
use std::ops::Range;
use std::path::{Path, PathBuf};

use rimline::cpu::{OccludedFaces, OcclusionStatistics};
use rimline::internals::layout::ShadowStatistics;
use rimline::{MAX_LIGHTS, Origin};
use serde_json::{Value, json};

use super::args::ShadowArgs;
use super::casters::Casters;
use super::casting::CoveredFaces;
use super::depth;
use super::from_depth::{DepthFound, DepthsFound};
use super::posed_model::PosedModel;
use super::shadow_scene::ShadowScene;
use super::shadows::Found;
use crate::coordinates;
use crate::device::{Gpu, describe};
use crate::failure::{Failure, UsageError};
use crate::gpu_error::{GpuError, On as _};
use crate::image::Picture;
use crate::output::Output;
use crate::report::{self, Lines, Times};
use crate::shadow::args::{ShadowSceneArgs, value_name};
use crate::shown::Line;
use crate::spec::LightSpec;
use crate::target::{Inputs, check_ending, is_same_file};

struct File {
    name: String,
    faces: usize,
    found: Found,
}

pub(super) struct Report {
    adapter: String,
    files: Vec<File>,
    /// Statistics of all files together.
    pub(super) all: ShadowStatistics,
    origin: Origin,
    lights: Vec<Light>,
    /// Statistics of occluded faces for each light, if they were asked for.
    covered: Option<Vec<OcclusionStatistics>>,
    left_out: usize,
    /// If maps of the lights cast.
    depth: Option<DepthsFound>,
}

struct Light {
    /// The light in the files' coordinates.
    given: Value,
    range: f32,
    color: [f32; 3],
    /// The numbers of its samples among those of all lights.
    samples: Range<usize>,
    has_area: bool,
}

fn covered_json(covered: &OcclusionStatistics) -> Value {
    let OcclusionStatistics { tried, occluded, left_out, undecided, without_room, sides, sides_left, .. } = covered;
    json!({
        "tried": tried,
        "hidden": occluded,
        "undecided": undecided,
        "without_room": without_room,
        "left_out": left_out,
        "sides": sides,
        "sides_left": sides_left,
    })
}

impl Report {
    /// Waits for the device.
    pub(super) fn read(
        set: &ShadowScene<'_>,
        casters: &Casters<'_>,
        covered: Option<&CoveredFaces>,
    ) -> Result<Self, GpuError> {
        let origin = set.bodies.first().map_or(Origin::ZERO, |body| body.input.origin());
        let found = casters.shadows.found()?;
        let file = |(body, found): (&PosedModel<'_>, Found)| File {
            name: body.input.file.display().to_string(),
            faces: body.faces.len(),
            found,
        };
        Ok(Self {
            adapter: describe(&casters.gpu().info),
            origin,
            files: set.bodies.iter().zip(found).map(file).collect(),
            all: casters.shadows.statistics()?,
            lights: set
                .shaded_lights
                .iter()
                .enumerate()
                .map(|(number, shaded)| Light {
                    given: coordinates::light(&shaded.light, origin),
                    range: shaded.range,
                    color: shaded.color,
                    samples: set.samples_of(number),
                    has_area: shaded.area.is_some(),
                })
                .collect(),
            covered: covered.map(|covered| covered.found.iter().map(OccludedFaces::statistics).collect()),
            left_out: casters.shadows.left_out(),
            depth: casters.shadows.depths_found()?,
        })
    }

    /// Keys are stable: they are only ever added to.
    pub(super) fn json(&self, args: &ShadowSceneArgs, times: &Times) -> String {
        let light = |(number, of_light): (usize, &Light)| {
            let Light { given: light, range, color, samples: of, has_area } = of_light;
            let per_sample = |values: Vec<Value>| match (has_area, values.first()) {
                (false, Some(one)) => one.clone(),
                _ => values.into(),
            };
            let caster = |File { name, found, .. }: &File| {
                let chosen = &found.lights[of.clone()];
                json!({
                    "file": name,
                    "casting": per_sample(chosen.iter().map(|light| light.casting.into()).collect()),
                    "counting": per_sample(chosen.iter().map(|light| light.counting.into()).collect()),
                    "silhouette_edges": per_sample(found.silhouettes[of.clone()].iter().map(|&n| n.into()).collect()),
                })
            };
            let mut of_light = json!({
                "light": light,
                "range": range.is_finite().then_some(range),
                "color": color,
                "casters": self.files.iter().map(caster).collect::<Vec<_>>(),
            });
            if let Some(covered) = self.covered.as_ref().and_then(|covered| covered.get(number)) {
                of_light["covered"] = covered_json(covered);
            }
            if let Some(DepthsFound { size, has_walls, lights: found }) = &self.depth {
                let of_sample = |at: usize| found.get(at).copied();
                let each =
                    |value: fn(DepthFound) -> Value| per_sample(of.clone().filter_map(of_sample).map(value).collect());
                let side = (size[0] == size[1]).then_some(size[0]);
                let (maps, listed) = (each(|found| found.maps.into()), each(|found| found.listed.into()));
                let overflowed = each(|found| found.is_overflowed().into());
                let (name, cells, walls) =
                    if *has_walls { ("contours", Value::Null, listed) } else { ("triangles", listed, Value::Null) };
                of_light["depth_map"] = json!({
                    "size": size, "side": side, "maps": maps, "reconstruction": name, "cells": cells, "walls": walls,
                    "overflowed": overflowed,
                });
            }
            of_light
        };
        let statistics = |File { name, found: Found { shadow, extraction, is_whole, .. }, .. }: &File| {
            // With several files, these are known for all of them together.
            let if_whole = |count: u32| is_whole.then_some(count);
            json!({
                "file": name,
                "skipped": shadow.skipped,
                "every_face": shadow.every_face,
                "capped": shadow.near_capped,
                "count_bound": if_whole(shadow.count_bound),
                "may_wrap": if_whole(shadow.may_wrap),
                "overflowed_caps": if_whole(shadow.overflowed_caps),
                "undecided_pairs": extraction.undecided_pairs,
                "overflowed_lists": extraction.overflowed_lists,
            })
        };
        let extraction = self.files.iter().map(|file| file.found.extraction).reduce(depth::sum);
        let mut totals = json!({
            "skipped": self.all.skipped,
            "every_face": self.all.every_face,
            "capped": self.all.near_capped,
            "overflowed_caps": self.all.overflowed_caps,
            "overflowed_sides": self.all.overflowed_sides,
            "undecided_pairs": extraction.map(|all| all.undecided_pairs),
            "overflowed_lists": extraction.map(|all| all.overflowed_lists),
        });
        if self.covered.is_some() {
            totals["covered_faces"] = self.left_out.into();
        }
        let report = json!({
            "adapter": self.adapter,
            "method": if self.depth.is_some() { "parity".to_owned() } else { value_name(&args.method) },
            "mode": value_name(&args.mode),
            "files": self.files.iter().map(|file| &file.name).collect::<Vec<_>>(),
            "faces": self.files.iter().map(|file| file.faces).collect::<Vec<_>>(),
            "samples": self.lights.iter().map(|light| light.samples.len()).max(),
            "count_bound": self.all.count_bound,
            "may_wrap": self.all.may_wrap,
            "lights": self.lights.iter().enumerate().map(light).collect::<Vec<_>>(),
            "statistics": self.files.iter().map(statistics).collect::<Vec<_>>(),
            "totals": totals,
        });
        report::json(report, self.origin, times)
    }

    /// `pictures` of this size and `archives` were written.
    pub(super) fn text(&self, [pictures, archives]: &[Vec<PathBuf>; 2], size: [u32; 2], times: &Times) -> String {
        let mut lines = Lines::default();
        lines.line("device", &self.adapter);
        lines.origin(self.origin);
        for File { name, faces, found: Found { lights, silhouettes, shadow, .. } } in &self.files {
            lines.line("caster", format!("{}, {faces} faces", Line(name)));
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
        for covered in self.covered.iter().flatten() {
            let OcclusionStatistics { tried, occluded, left_out, sides, sides_left, .. } = covered;
            let value = format!(
                "{occluded} of {tried} faces are hidden from the light, {left_out} left out; sides {sides} before, {sides_left} \
                 after"
            );
            lines.line("covered", value);
        }
        lines.times(times);
        let pictures = pictures.iter().map(|file| crate::image::wrote(file, size));
        let archives = archives.iter().map(|file| format!("wrote {}", Line(file.display())));
        let wrote: String = pictures.chain(archives).map(|line| line + "\n").collect();
        lines.0 + &wrote
    }
}

/// Files in the making. A file that is dropped before it is finished leaves nothing.
pub(super) struct ResultFiles {
    picture: Option<Output>,
    masks: Vec<Output>,
    maps: Vec<Output>,
    /// Names of picture and masks, and names of maps.
    pub(super) names: [Vec<PathBuf>; 2],
}

impl ResultFiles {
    /// Refuses a picture that is named as another format.
    pub(super) fn check(args: &ShadowArgs) -> Result<(), UsageError> {
        args.out.as_deref().map_or(Ok(()), |out| check_ending(out, "png"))
    }

    /// Begins those whose names are known from the command line, so that an unwritable place is known at once.
    pub(super) fn begin(args: &ShadowArgs, inputs: &Inputs) -> Result<Self, Failure> {
        args.out.as_deref().map_or(Ok(()), |out| inputs.spare(out))?;
        // There is a first light in any case; how many there are is known later.
        for first in of_lights(args, 1).into_iter().flatten() {
            inputs.spare(&first)?;
            drop(Output::create(&first)?);
        }
        let picture = args.out.as_deref().map(Output::create).transpose()?;
        let names = [args.out.iter().cloned().collect(), Vec::new()];
        Ok(Self { picture, masks: Vec::new(), maps: Vec::new(), names })
    }

    /// Begins those of all lights.
    pub(super) fn begin_lights(&mut self, args: &ShadowArgs, inputs: &Inputs, lights: usize) -> Result<(), Failure> {
        let files = of_lights(args, lights);
        let is_any = |out: &&Path| files.iter().flatten().any(|file| is_same_file(out, file));
        if let Some(out) = args.out.as_deref().filter(is_any) {
            return Err(UsageError::SameOutput { file: out.to_owned() }.into());
        }
        files.iter().flatten().try_for_each(|file| inputs.spare(file))?;
        for ((outputs, names), files) in [&mut self.masks, &mut self.maps].into_iter().zip(&mut self.names).zip(files) {
            *outputs = files.iter().map(|file| Output::create(file)).collect::<Result<_, _>>()?;
            names.extend(files);
        }
        Ok(())
    }

    pub(super) fn finish_picture(&mut self, gpu: &Gpu, picture: &Picture) -> Result<(), Failure> {
        gpu.check()?;
        self.picture.take().map_or(Ok(()), |output| output.finish(|file| picture.write_png(file, None)))
    }

    /// Writes the masks that `draw` draws for each light.
    pub(super) fn finish_masks(
        &mut self,
        gpu: &Gpu,
        mut draw: impl FnMut(usize) -> Result<Picture, Failure>,
    ) -> Result<(), Failure> {
        for (light, output) in std::mem::take(&mut self.masks).into_iter().enumerate() {
            let mask = draw(light)?;
            gpu.check()?;
            output.finish(|file| mask.write_png(file, None))?;
        }
        Ok(())
    }

    /// Writes the depth maps of each light as they were drawn.
    pub(super) fn finish_maps(&mut self, gpu: &Gpu, casters: &Casters<'_>, origin: Origin) -> Result<(), Failure> {
        for (light, output) in std::mem::take(&mut self.maps).into_iter().enumerate() {
            let maps = casters.shadows.saved_maps(light, origin).on(gpu)?;
            gpu.check()?;
            maps.map_or(Ok(()), |maps| output.finish(|file| maps.write(file)))?;
        }
        Ok(())
    }
}

/// All files that may be written: how many lights a model has is known when it is read.
pub(crate) fn files(args: &ShadowArgs) -> Vec<PathBuf> {
    let has_all = args.scene.lights.iter().any(|light| light.light == LightSpec::All);
    let lights = if has_all { MAX_LIGHTS } else { args.scene.lights.len().max(1) };
    args.out.iter().cloned().chain(of_lights(args, lights).into_iter().flatten()).collect()
}

/// The names of masks and of maps.
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
