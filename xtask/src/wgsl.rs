//! The stages' WGSL through compilers that are not ours. The test suite runs naga's library; this runs Chromium's tint,
//! and naga's command, where they are installed.

use std::path::PathBuf;
use std::process::Command;

use crate::process;
use crate::summary::Summary;

/// A compiler and what makes it check a file without writing anything.
const COMPILERS: [(&str, &[&str]); 2] = [("tint", &["--format", "wgsl"]), ("naga", &[])];

/// Checks what the test `wgsl_composes` has written: every stage with the files it includes.
pub(crate) fn add(summary: &mut Summary) {
    let files = composed();
    for (compiler, arguments) in COMPILERS {
        if !process::on_path(compiler) {
            summary.note(&format!("{compiler} is not on the PATH, so it did not check the WGSL"));
            continue;
        }
        let outcome = files.as_ref().map_err(String::clone).and_then(|files| {
            let complaints: Vec<_> = files
                .iter()
                .filter_map(|file| process::output(Command::new(compiler).args(arguments).arg(file)).err())
                .collect();
            if complaints.is_empty() { Ok(()) } else { Err(complaints.join("\n")) }
        });
        let count = files.as_ref().map_or(0, Vec::len);
        summary.check(&format!("{compiler} accepts the WGSL ({count} files)"), outcome);
    }
}

fn composed() -> Result<Vec<PathBuf>, String> {
    let directory = process::target().join("wgsl");
    let entries = std::fs::read_dir(&directory).into_iter().flatten().flatten().map(|entry| entry.path());
    let mut files: Vec<_> = entries.filter(|path| path.extension().is_some_and(|e| e == "wgsl")).collect();
    files.sort();
    if files.is_empty() {
        return Err(format!("the test `wgsl_composes` has written nothing to {}", directory.display()));
    }
    Ok(files)
}
