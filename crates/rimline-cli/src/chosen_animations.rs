//! The animations that `--animation` names.

use crate::failure::{Failure, UsageError};
use crate::input::{Input, Source};
use crate::input_args::PoseArgs;
use crate::listed::listed_animations;

/// The animations of each file that `--animation` names. Every name must be that of an animation in one of the files.
pub(crate) fn animations(inputs: &[Input], args: &PoseArgs) -> Result<Vec<Vec<usize>>, Failure> {
    let mut chosen = vec![Vec::new(); inputs.len()];
    for wanted in &args.animations {
        let found: Vec<_> = inputs.iter().map(|input| named(input, wanted)).collect();
        let is_there = found.iter().any(Result::is_ok);
        for (chosen, found) in chosen.iter_mut().zip(found) {
            match found {
                Ok(found) => chosen.extend(found),
                Err(missing) if !is_there => return Err(missing),
                Err(_) => {}
            }
        }
    }
    inputs.iter().zip(&chosen).try_for_each(|(input, chosen)| check(input, chosen))?;
    Ok(chosen)
}

/// The animations of a file that one `--animation` names, by their numbers: one, or all.
fn named(input: &Input, wanted: &str) -> Result<Vec<usize>, Failure> {
    let (found, there) = match &input.source {
        Source::Gltf(asset) if wanted == "all" => (0..asset.animations().len(), listed_animations(asset)),
        Source::Gltf(asset) => {
            let found = asset.animation_index(wanted).map_or(0..0, |index| index..index + 1);
            (found, listed_animations(asset))
        }
        Source::World { .. } => (0..0, "the file has none".to_owned()),
    };
    if found.is_empty() {
        return Err(UsageError::Animation { wanted: wanted.to_owned(), there }.into());
    }
    Ok(found.collect())
}

/// Checks that these animations can be played together.
fn check(input: &Input, animations: &[usize]) -> Result<(), Failure> {
    match &input.source {
        // An error at one time occurs at all times.
        Source::Gltf(asset) if !animations.is_empty() => {
            asset.each_light(animations.iter().copied(), 0.0).map(drop).map_err(|error| input.not_posed(error))
        }
        _ => Ok(()),
    }
}
