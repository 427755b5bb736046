//! Results that would be written over an input.

use std::path::{Path, PathBuf};

use crate::failure::UsageError;
use crate::source;

/// The files that a command reads, by whatever names.
#[derive(Debug, Default)]
pub(crate) struct Inputs {
    files: Vec<PathBuf>,
    #[cfg(unix)]
    places: std::collections::HashMap<(u64, u64), usize>,
}

impl Inputs {
    pub(crate) fn new<P: AsRef<Path>>(files: impl IntoIterator<Item = P>) -> Self {
        let mut inputs = Self::default();
        for file in files {
            let file = file.as_ref();
            // One that is named and not there cannot be lost.
            let Ok(_there) = source::metadata(file) else { continue };
            #[cfg(unix)]
            {
                use std::os::unix::fs::MetadataExt;
                // What a device or pipe had cannot be lost either.
                if !_there.is_file() {
                    continue;
                }
                inputs.places.insert((_there.dev(), _there.ino()), inputs.files.len());
            }
            inputs.files.push(file.to_owned());
        }
        inputs
    }

    /// Refuses to write a file that is one of them.
    pub(crate) fn spare(&self, out: &Path) -> Result<(), UsageError> {
        match self.input(out) {
            Some(input) => Err(UsageError::OutputIsInput { out: out.to_owned(), input: input.to_owned() }),
            None => Ok(()),
        }
    }

    #[cfg(unix)]
    fn input(&self, out: &Path) -> Option<&Path> {
        use std::os::unix::fs::MetadataExt;
        let there = std::fs::metadata(out).ok()?;
        let index = self.places.get(&(there.dev(), there.ino()))?;
        self.files.get(*index).map(PathBuf::as_path)
    }

    #[cfg(not(unix))]
    fn input(&self, out: &Path) -> Option<&Path> {
        self.files.iter().map(PathBuf::as_path).find(|input| crate::target::is_same_file(out, input))
    }
}
