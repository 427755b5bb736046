//! The displacement function of `--displace`.

use std::path::Path;

use rimline::Displacement;

use crate::failure::{Failure, InputError};
use crate::input_args::PoseArgs;
use crate::output::note;
use crate::source;

/// Reads and checks it.
pub(crate) fn read(file: &Path) -> Result<Displacement, Failure> {
    let read = || -> Result<Displacement, InputError> {
        let displacement = Displacement::new(&source::read_text(file)?)?;
        if displacement.uses_resources() {
            return Err(InputError::DisplacementResources);
        }
        Ok(displacement)
    };
    read().map_err(Failure::input(file))
}

/// Tells whoever gives a time that nothing moves with it.
pub(crate) fn note_idle_time(pose: &PoseArgs, animations: &[usize], displacement: Option<&Displacement>) {
    if pose.time != 0.0 && animations.is_empty() && displacement.is_none() {
        note("warning: --time has no effect without --animation or --displace");
    }
}
