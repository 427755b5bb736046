//! A folder that one film is being written into.

use std::io::{self, Write as _};
use std::path::{Path, PathBuf};

use crate::failure::{Failure, UsageError};
use crate::output;

/// A film's claim of its folder, as long as it lives: a hidden file with the number of the process. Two films in one folder
/// would remove and replace each other's pictures.
#[derive(Debug)]
pub(crate) struct Claim {
    file: PathBuf,
}

const NAME: &str = ".rimline-film.part";

impl Claim {
    /// Claims a folder that is there. A claim whose process is gone counts for nothing.
    pub(crate) fn take(folder: &Path) -> Result<Self, Failure> {
        let file = folder.join(NAME);
        let mut taken = claim(&file);
        if taken.as_ref().is_err_and(is_there) && is_stale(&file) {
            let _ = std::fs::remove_file(&file);
            taken = claim(&file);
        }
        match taken {
            Ok(()) => Ok(Self { file }),
            Err(error) if is_there(&error) => {
                Err(UsageError::FilmInProgress { folder: folder.to_owned(), claim: file }.into())
            }
            Err(source) => Err(Failure::Output { file: folder.to_owned(), source }),
        }
    }
}

impl Drop for Claim {
    fn drop(&mut self) {
        output::remove_unfinished(|path| *path == self.file);
    }
}

fn claim(file: &Path) -> io::Result<()> {
    output::create_unfinished(file)?.write_all(std::process::id().to_string().as_bytes())
}

fn is_there(error: &io::Error) -> bool {
    error.kind() == io::ErrorKind::AlreadyExists
}

/// Whether the process that a claim names is gone. Where the system does not list processes as files, none is known to be.
fn is_stale(file: &Path) -> bool {
    let processes = Path::new("/proc");
    let process = std::fs::read_to_string(file).ok().and_then(|text| text.parse::<u32>().ok());
    processes.join("self").exists() && process.is_some_and(|process| !processes.join(process.to_string()).exists())
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_folder_has_one_film_at_a_time() {
        let folder = tempfile::tempdir().expect("there is room");
        let first = Claim::take(folder.path()).expect("nobody claims it");
        let second = Claim::take(folder.path()).expect_err("it is claimed");
        assert!(second.to_string().contains(NAME), "{second}");
        drop(first);
        assert!(!folder.path().join(NAME).exists());
        drop(Claim::take(folder.path()).expect("nobody claims it any more"));
    }

    #[test]
    #[cfg(target_os = "linux")]
    fn a_claim_of_a_process_that_is_gone_counts_for_nothing() {
        let folder = tempfile::tempdir().expect("there is room");
        // Above the largest number of a process.
        std::fs::write(folder.path().join(NAME), "4294967295").expect("there is room");
        let claim = Claim::take(folder.path()).expect("its process is gone");
        drop(claim);
        // A file without a number may be a claim in the making.
        std::fs::write(folder.path().join(NAME), "").expect("there is room");
        Claim::take(folder.path()).expect_err("it may be in the making");
    }
}
