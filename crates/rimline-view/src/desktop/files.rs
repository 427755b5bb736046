//! Files: what is opened, and where screenshots go.

use std::fs::{self, File};
use std::io::{ErrorKind, Write as _};
use std::path::{Path, PathBuf};

/// The name of a file without its folders.
pub(super) fn name(path: &Path) -> String {
    path.file_name().unwrap_or(path.as_os_str()).to_string_lossy().into_owned()
}

/// Writes a picture to the first path of a folder where no file is yet, or says why not.
pub(super) fn save(folder: &Path, picture: &[u8]) -> Result<PathBuf, String> {
    let mut number = 1_u32;
    loop {
        let path = folder.join(format!("rimline-{number}.png"));
        // A part of a picture is none.
        let write = |mut file: File| file.write_all(picture).inspect_err(|_| _ = fs::remove_file(&path));
        match File::create_new(&path).and_then(write) {
            Ok(()) => return Ok(path),
            Err(error) if error.kind() == ErrorKind::AlreadyExists => number += 1,
            Err(error) => return Err(format!("{}: {error}", path.display())),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn pictures_replace_no_file() {
        let folder = tempfile::tempdir().expect("a folder");
        std::fs::write(folder.path().join("rimline-1.png"), "mine").expect("a file");
        let paths = [0, 1].map(|byte| save(folder.path(), &[byte]).expect("it is written"));
        assert_eq!(paths, ["rimline-2.png", "rimline-3.png"].map(|name| folder.path().join(name)));
        assert_eq!(std::fs::read(folder.path().join("rimline-1.png")).expect("it is there"), b"mine");
        assert_eq!(std::fs::read(&paths[1]).expect("it is there"), [1]);
        let missing = folder.path().join("missing");
        assert!(save(&missing, &[]).is_err_and(|why| why.contains("rimline-1.png")));
    }
}
