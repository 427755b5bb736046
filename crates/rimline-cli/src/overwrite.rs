//! Results that would be written over an input.

use std::collections::HashMap;
use std::path::{Path, PathBuf};

use crate::failure::UsageError;
use crate::source;
use crate::target::{self, Identity, identity};

/// The files that a command reads, whatever names they are given by.
#[derive(Debug)]
pub(crate) struct Inputs(HashMap<Identity, PathBuf>);

impl Inputs {
    pub(crate) fn new<P: AsRef<Path>>(files: impl IntoIterator<Item = P>) -> Self {
        let place = |file: P| {
            let file = file.as_ref();
            // Missing files, pipes and devices have no contents that could be lost.
            let there = source::metadata(file).ok().filter(std::fs::Metadata::is_file)?;
            Some((identity(file, &there)?, file.to_owned()))
        };
        Self(files.into_iter().filter_map(place).collect())
    }

    /// Refuses to write a file that is one of them.
    pub(crate) fn spare(&self, out: &Path) -> Result<(), UsageError> {
        let identity = target::metadata(out).ok().and_then(|there| identity(out, &there));
        match identity.and_then(|identity| self.0.get(&identity)) {
            Some(input) => Err(UsageError::OutputIsInput { out: out.to_owned(), input: input.clone() }),
            None => Ok(()),
        }
    }
}
