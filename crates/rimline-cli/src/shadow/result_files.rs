//! The files that `rimline shadow` writes: a picture, and for each light a mask and its depth maps.

use std::path::{Path, PathBuf};

use rimline::Origin;

use super::args::ShadowArgs;
use super::casters::Casters;
use crate::device::Gpu;
use crate::failure::{Failure, UsageError};
use crate::gpu_error::On as _;
use crate::image::Picture;
use crate::output::Output;
use crate::target::{Inputs, check_ending, is_same_file};

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
        let out = args.out.as_deref();
        out.map_or(Ok(()), |out| inputs.spare(out))?;
        // There is a first light in any case; how many there are is known later.
        for first in Self::of_lights(args, 1).into_iter().flatten() {
            inputs.spare(&first)?;
            drop(Output::create(&first)?);
        }
        let picture = out.map(Output::create).transpose()?;
        Ok(Self {
            picture,
            masks: Vec::new(),
            maps: Vec::new(),
            names: [args.out.iter().cloned().collect(), Vec::new()],
        })
    }

    /// The names of masks and of maps.
    fn of_lights(args: &ShadowArgs, lights: usize) -> [Vec<PathBuf>; 2] {
        let numbered = |(prefix, ending): (&Option<PathBuf>, &str)| {
            let each = |prefix: &PathBuf| (0..lights).map(|light| numbered(prefix, light, ending)).collect();
            prefix.as_ref().map_or_else(Vec::new, each)
        };
        [(&args.mask, "png"), (&args.save_depth, "npz")].map(numbered)
    }

    /// Begins those of all lights.
    pub(super) fn begin_lights(&mut self, args: &ShadowArgs, inputs: &Inputs, lights: usize) -> Result<(), Failure> {
        let [masks, maps] = Self::of_lights(args, lights);
        let is_any = |out: &&Path| masks.iter().chain(&maps).any(|file| is_same_file(out, file));
        if let Some(out) = args.out.as_deref().filter(is_any) {
            return Err(UsageError::SameOutput { file: out.to_owned() }.into());
        }
        masks.iter().chain(&maps).try_for_each(|file| inputs.spare(file))?;
        let create = |files: &[PathBuf]| files.iter().map(|file| Output::create(file)).collect::<Result<Vec<_>, _>>();
        (self.masks, self.maps) = (create(&masks)?, create(&maps)?);
        let [pictures, archives] = &mut self.names;
        pictures.extend(masks);
        archives.extend(maps);
        Ok(())
    }

    pub(super) fn finish_picture(&mut self, gpu: &Gpu, picture: &Picture) -> Result<(), Failure> {
        gpu.check()?;
        self.picture.take().map_or(Ok(()), |output| output.finish(|file| picture.write_png(file)))
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
            output.finish(|file| mask.write_png(file))?;
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
