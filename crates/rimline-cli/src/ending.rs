//! Names of results that say another format than is written.

use std::path::{Path, PathBuf};

use crate::failure::UsageError;

/// Endings that stand for a format. One that is none of these is a part of the name.
const FORMATS: &str = "png apng jpg jpeg jpe jfif gif bmp tif tiff webp avif heic jxl svg pdf eps ps exr hdr tga ppm \
    pgm pnm psd ico mp4 m4v mov avi mkv webm mpg mpeg ogv npz npy mat h5 gltf glb bin obj mtl ply stl off fbx dae 3ds \
    usd usda usdc usdz blend zip gz tar csv tsv json txt md html wgsl";

/// Refuses a file name that ends as another format's: its own is `own`.
pub(crate) fn check(out: &Path, own: &'static str) -> Result<(), UsageError> {
    let what = match own {
        "png" => "a PNG picture",
        "npz" => "a NumPy archive",
        _ => "JSON",
    };
    match format_of(out) {
        Some(ending) if ending != own => Err(UsageError::Ending { out: out.to_owned(), what, own }),
        _ => Ok(()),
    }
}

/// Refuses a folder that is not there and is named as a file would be.
pub(crate) fn check_folder(out: &Path, refused: impl FnOnce(PathBuf) -> UsageError) -> Result<(), UsageError> {
    if format_of(out).is_some() && !out.exists() { Err(refused(out.to_owned())) } else { Ok(()) }
}

fn format_of(out: &Path) -> Option<String> {
    let ending = out.extension()?.to_str()?.to_lowercase();
    FORMATS.split_whitespace().any(|format| format == ending).then_some(ending)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn endings_of_other_formats_are_refused() {
        let is_taken = |name: &str, own| check(Path::new(name), own).is_ok();
        for name in ["a.png", "a.PNG", "a", "a.b", "v1.2", "/dev/stdout", ".png"] {
            assert!(is_taken(name, "png"), "{name}");
        }
        for name in ["a.jpg", "a.JPEG", "a.npz", "a.glb", "a.png.webp"] {
            assert!(!is_taken(name, "png"), "{name}");
        }
        assert!(is_taken("a.npz", "npz") && !is_taken("a.png", "npz"));
        assert!(is_taken("a.json", "json") && is_taken("-", "json") && !is_taken("a.glb", "json"));
        let is_folder = |name| check_folder(Path::new(name), |out| UsageError::FolderEnding { out }).is_ok();
        assert!(!is_folder("none/film.mp4") && is_folder("none/film.d") && is_folder("none/report"));
    }
}
