//! Names of results that say another format than is written.

use std::path::Path;

use crate::failure::UsageError;

/// Endings that stand for a format. One that is none of these is a part of the name.
const FORMATS: &str = "png apng jpg jpeg jpe jfif gif bmp tif tiff webp avif heic jxl svg pdf dxf eps ps exr hdr tga ppm \
    pgm pnm psd ico mp4 m4v mov avi mkv webm mpg mpeg ogv npz npy mat h5 gltf glb bin obj mtl ply stl off fbx dae 3ds \
    usd usda usdc usdz blend zip gz tar csv tsv json txt md html wgsl";

/// A format that is written.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Written {
    Png,
    Npz,
    Json,
    Svg,
    Pdf,
    Dxf,
}

impl Written {
    /// Name of the format, and ending of its files.
    fn words(self) -> (&'static str, &'static str) {
        match self {
            Self::Png => ("a PNG picture", "png"),
            Self::Npz => ("a NumPy archive", "npz"),
            Self::Json => ("JSON", "json"),
            Self::Svg => ("an SVG drawing", "svg"),
            Self::Pdf => ("a PDF", "pdf"),
            Self::Dxf => ("a DXF drawing", "dxf"),
        }
    }
}

/// Refuses a file name that ends as another format's.
pub(crate) fn check(out: &Path, written: Written) -> Result<(), UsageError> {
    let (what, own) = written.words();
    match format_of(out) {
        Some(ending) if ending != own => Err(UsageError::Ending { out: out.to_owned(), what, own }),
        _ => Ok(()),
    }
}

/// Refuses a folder that is not there and is named as a file would be.
pub(crate) fn check_folder(out: &Path) -> Result<(), UsageError> {
    if format_of(out).is_some() && !out.exists() {
        return Err(UsageError::FolderEnding { out: out.to_owned() });
    }
    Ok(())
}

/// The same of a folder for a report.
#[cfg(feature = "bench")]
pub(crate) fn check_report(folder: &Path) -> Result<(), UsageError> {
    if format_of(folder).is_some() && !folder.exists() {
        return Err(UsageError::ReportEnding { folder: folder.to_owned() });
    }
    Ok(())
}

fn format_of(out: &Path) -> Option<String> {
    let ending = out.extension()?.to_str()?.to_lowercase();
    FORMATS.split_whitespace().any(|format| format == ending).then_some(ending)
}

#[cfg(all(test, feature = "bench"))]
mod tests {
    use super::*;

    #[test]
    fn endings_of_other_formats_are_refused() {
        let is_taken = |name: &str, written| check(Path::new(name), written).is_ok();
        for name in ["a.png", "a.PNG", "a", "a.b", "v1.2", "/dev/stdout", ".png"] {
            assert!(is_taken(name, Written::Png), "{name}");
        }
        for name in ["a.jpg", "a.JPEG", "a.npz", "a.glb", "a.png.webp"] {
            assert!(!is_taken(name, Written::Png), "{name}");
        }
        assert!(is_taken("a.npz", Written::Npz) && !is_taken("a.png", Written::Npz));
        assert!(is_taken("a.json", Written::Json) && is_taken("-", Written::Json) && !is_taken("a.glb", Written::Json));
        assert!(check_report(Path::new("none/report.html")).is_err() && check_report(Path::new("none/report")).is_ok());
        assert!(check_folder(Path::new("none/film.mp4")).is_err());
        assert!(check_folder(Path::new("none/film.d")).is_ok());
    }
}
