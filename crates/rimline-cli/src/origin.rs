//! The run's origin: one for all files, near the models, where coordinates are too large for `f32`.

use rimline::Origin;

use crate::failure::Failure;
use crate::input::Input;
use crate::output::note;
use crate::shown::Line;

/// Moves the files to one origin, and warns where `f32` still loses much. `animations` has those of each.
pub(crate) fn settle(inputs: &mut [Input], animations: &[Vec<usize>], time_s: f32) -> Result<Origin, Failure> {
    let mut files: Vec<_> =
        inputs.iter_mut().zip(animations).map(|(input, playing)| (&mut input.content, &**playing)).collect();
    let settled = rimline_files::settle(&mut files, time_s).map_err(|(index, error)| inputs[index].failed(error))?;
    for (input, warning) in inputs.iter().zip(settled.warnings) {
        if let Some(warning) = warning {
            note(&format!("warning: {}: {warning}", Line(input.file.display())));
        }
    }
    Ok(settled.origin)
}
