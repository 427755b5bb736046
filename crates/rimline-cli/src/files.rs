//! Input files, and targets of results: a regular file, which is replaced, or a pipe, device or stream, which gets a copy.

use std::collections::{HashMap, HashSet};
use std::ffi::OsString;
use std::fs::{DirEntry, File, Metadata, OpenOptions};
use std::io::{self, BufReader, Cursor, Read, Seek};
use std::path::{Path, PathBuf};
use std::sync::atomic::{AtomicBool, Ordering};

use rimline_files::{FileError, open_regular};

use crate::failure::{Cause, Failure};

/// Whether a result goes to standard output, so that text cannot.
pub(crate) static HOLDS_RESULT: AtomicBool = AtomicBool::new(false);

pub(crate) enum Target {
    /// A name for a regular file, with what is there already.
    Replace(PathBuf, Option<Metadata>),
    /// The file that the complete result is copied to: a pipe, a device, standard output or standard error. Or a regular file
    /// to which no path leads any more: for it the flag is true, and it is cut to nothing before.
    Through(File, bool),
}

/// Finds the target of a name. A symbolic link stays, and the file that it leads to is the target.
pub(crate) fn find(name: &Path) -> io::Result<Target> {
    if is_standard(name) {
        let no_stream = || io::Error::other("standard output cannot be written through here; give the name of a file");
        HOLDS_RESULT.store(true, Ordering::SeqCst);
        return Ok(Target::Through(standard(&io::stdout()).ok_or_else(no_stream)?, false));
    }
    if name.to_string_lossy().ends_with(std::path::is_separator) {
        return Err(io::Error::other("it is the name of a folder; give the name of a file"));
    }
    match std::fs::metadata(name) {
        Ok(there) if there.is_dir() => Err(io::Error::other("it is a folder; give the name of a file")),
        Ok(there) => existing(name, there),
        Err(error) if error.kind() == io::ErrorKind::NotFound => {
            let path = end_of_links(name)?;
            check_parent(&path)?;
            Ok(Target::Replace(path, None))
        }
        Err(error) => Err(error),
    }
}

fn existing(name: &Path, there: Metadata) -> io::Result<Target> {
    for (is_stdout, stream) in [(true, standard(&io::stdout())), (false, standard(&io::stderr()))] {
        if let Some(file) = stream
            && !is_character_device(&there)
            && file.metadata().is_ok_and(|open| identity(name, &open) == identity(name, &there))
        {
            if is_stdout {
                HOLDS_RESULT.store(true, Ordering::SeqCst);
            }
            return Ok(Target::Through(file, false));
        }
    }
    // Opening fails if the file may not be written. It neither makes the file nor cuts it.
    let file = OpenOptions::new().write(true).open(name)?;
    if there.is_file()
        && let Ok(path) = name.canonicalize()
        && std::fs::metadata(&path).is_ok_and(|found| identity(&path, &found) == identity(name, &there))
    {
        return Ok(Target::Replace(path, Some(there)));
    }
    Ok(Target::Through(file, there.is_file()))
}

/// Whether a name stands for standard input or output.
pub(crate) fn is_standard(name: &Path) -> bool {
    name.as_os_str() == "-"
}

/// Whether a result is there as a file. Standard output never counts, because nothing tells if a result went there.
pub(crate) fn is_written(result: &Path) -> bool {
    !is_standard(result) && result.is_file()
}

/// The files that a command reads, by identity and not by name. Results must not replace them.
#[derive(Debug)]
pub(crate) struct Inputs(HashMap<Identity, PathBuf>);

impl Inputs {
    pub(crate) fn new<P: AsRef<Path>>(files: impl IntoIterator<Item = P>) -> Self {
        let identified = |file: P| {
            let file = file.as_ref();
            // Missing files, pipes and devices have no contents that could be lost.
            let there = metadata(file).ok().filter(std::fs::Metadata::is_file)?;
            Some((identity(file, &there)?, file.to_owned()))
        };
        Self(files.into_iter().filter_map(identified).collect())
    }

    /// Refuses a result that would be written to one of the inputs.
    pub(crate) fn spare(&self, out: &Path) -> Result<(), Failure> {
        let there = match is_standard(out).then(|| standard(&io::stdout())).flatten() {
            Some(stream) => stream.metadata(),
            None => std::fs::metadata(out),
        };
        let identity = there.ok().and_then(|there| identity(out, &there));
        match identity.and_then(|identity| self.0.get(&identity)) {
            Some(input) => Err(Failure::usage(format!(
                "{} is an input, {}, and the result would replace it; choose another name",
                out.display(),
                input.display()
            ))),
            None => Ok(()),
        }
    }
}

/// The path that a chain of symbolic links ends at, which need not exist.
pub(crate) fn end_of_links(name: &Path) -> io::Result<PathBuf> {
    let mut path = name.to_owned();
    // Chains of more than 40 links count as loops, as on Linux.
    for _ in 0..=40 {
        match path.read_link() {
            Ok(next) => path = path.parent().unwrap_or(Path::new("")).join(next),
            Err(_) => return Ok(path),
        }
    }
    Err(io::Error::other("its links lead to each other"))
}

/// Refuses a target whose folder does not exist.
pub(crate) fn check_parent(target: &Path) -> io::Result<()> {
    if folder_of(target).is_dir() { Ok(()) } else { Err(io::Error::other("its folder does not exist; make it first")) }
}

pub(crate) fn folder_of(path: &Path) -> &Path {
    path.parent().filter(|folder| !folder.as_os_str().is_empty()).unwrap_or(Path::new("."))
}

#[cfg(unix)]
fn standard(stream: &impl std::os::fd::AsFd) -> Option<File> {
    stream.as_fd().try_clone_to_owned().ok().map(File::from)
}

#[cfg(not(unix))]
fn standard<T>(_: &T) -> Option<File> {
    None
}

#[cfg(unix)]
fn is_character_device(there: &Metadata) -> bool {
    std::os::unix::fs::FileTypeExt::is_char_device(&there.file_type())
}

#[cfg(not(unix))]
fn is_character_device(_: &Metadata) -> bool {
    false
}

/// Identity of a file, the same for all its names; but on systems other than Unix each hard link has its own.
#[cfg(unix)]
type Identity = (u64, u64);
#[cfg(not(unix))]
type Identity = PathBuf;

#[cfg(unix)]
#[expect(clippy::unnecessary_wraps, reason = "elsewhere it may not be known")]
fn identity(_: &Path, there: &Metadata) -> Option<Identity> {
    use std::os::unix::fs::MetadataExt;
    Some((there.dev(), there.ino()))
}

#[cfg(not(unix))]
fn identity(file: &Path, _: &Metadata) -> Option<Identity> {
    file.canonicalize().ok()
}

/// Whether both name one file, which need not exist. (The crate `same-file` opens both, and so waits at a pipe.)
pub(crate) fn is_same_file(a: &Path, b: &Path) -> bool {
    if let (Ok(there), Ok(other)) = (std::fs::metadata(a), std::fs::metadata(b)) {
        return identity(a, &there) == identity(b, &other);
    }
    a == b || real_path(a).is_some_and(|a| Some(a) == real_path(b))
}

/// The path of a file without symbolic links. The file need not exist; without its folder the result is `None`.
pub(crate) fn real_path(path: &Path) -> Option<PathBuf> {
    let path = end_of_links(path).ok()?;
    Some(folder_of(&path).canonicalize().ok()?.join(path.file_name()?))
}

/// The folders of many results, each of which is read once.
#[derive(Debug, Default)]
pub(crate) struct Folders(HashMap<PathBuf, Option<Folder>>);

/// The real path of a folder, and the names in it, with ASCII letters in lower case.
#[derive(Debug)]
struct Folder {
    path: PathBuf,
    names: HashSet<OsString>,
}

impl Folders {
    /// The [`real_path`] of a file that certainly did not exist when its folder was read, so it is neither a link nor an input.
    /// `None`: it may have existed, its folder cannot be read, or it is `-`.
    pub(crate) fn path_of_new(&mut self, file: &Path) -> Option<PathBuf> {
        let name = file.file_name().filter(|_| !is_standard(file))?;
        let parent = folder_of(file);
        let folder = self.0.entry(parent.to_owned()).or_insert_with(|| Folder::read(parent).ok());
        let Folder { path, names } = folder.as_ref()?;
        // On some systems names are equal if they differ in case only, or in how Unicode encodes a letter.
        let is_new = name.is_ascii() && !names.contains(&name.to_ascii_lowercase());
        is_new.then(|| path.join(name))
    }
}

impl Folder {
    fn read(path: &Path) -> io::Result<Self> {
        let name = |entry: io::Result<DirEntry>| entry.map(|entry| entry.file_name().to_ascii_lowercase());
        Ok(Self { path: path.canonicalize()?, names: path.read_dir()?.map(name).collect::<io::Result<_>>()? })
    }
}

/// Endings that name a format. Any other ending is a part of the name.
const FORMATS: &str = "png apng jpg jpeg jpe jfif gif bmp tif tiff webp avif heic jxl svg pdf dxf eps ps exr hdr tga ppm \
                       pgm pnm psd ico mp4 m4v mov avi mkv webm mpg mpeg ogv npz npy mat h5 gltf glb bin obj mtl ply stl off fbx dae 3ds \
                       usd usda usdc usdz blend zip gz tar csv tsv json txt md html wgsl";

/// Refuses a file name with the ending of another format than `expected`, in which the file is written.
pub(crate) fn check_ending(out: &Path, expected: &'static str) -> Result<(), Failure> {
    let what = match expected {
        "png" => "a PNG picture",
        "gif" => "a GIF",
        "apng" => "an animated PNG",
        "mp4" => "an MP4 video",
        "npz" => "a NumPy archive",
        "svg" => "an SVG drawing",
        "pdf" => "a PDF",
        "dxf" => "a DXF drawing",
        _ => "JSON",
    };
    match format_of(out) {
        Some(ending) if ending != expected => {
            Err(Failure::usage(format!("{} is written as {what}; give a name that ends in .{expected}", out.display())))
        }
        _ => Ok(()),
    }
}

/// Refuses standard output, and a path that does not exist and has the ending of a format of files.
pub(crate) fn check_folder(out: &Path, why: &str) -> Result<(), Failure> {
    let wrong = match format_of(out) {
        _ if is_standard(out) => "is standard output",
        Some(_) if !out.exists() => "looks like a file",
        _ => return Ok(()),
    };
    Err(Failure::usage(format!("{} {wrong}, but {why}", out.display())))
}

fn format_of(out: &Path) -> Option<String> {
    let ending = out.extension()?.to_str()?.to_lowercase();
    FORMATS.split_whitespace().any(|format| format == ending).then_some(ending)
}

/// The most bytes that are read from standard input. A memory limit may be lower.
const MAX_STDIN_BYTES: u64 = 1 << 32;

/// A seekable reader, which archives need.
trait ReadSeek: Read + Seek {}

impl<T: Read + Seek> ReadSeek for T {}

/// An archive of arrays. More than `memory_limit` bytes on standard input are an error.
pub(crate) fn archive(file: &Path, memory_limit: u64) -> Result<impl Read + Seek + use<>, Cause> {
    let reader: Box<dyn ReadSeek> = if is_standard(file) {
        Box::new(Cursor::new(stdin(memory_limit)?))
    } else {
        Box::new(BufReader::with_capacity(1 << 18, open_regular(file).map_err(FileError::from)?))
    };
    Ok(rimline_files::archive(reader).map_err(FileError::from)?)
}

/// The bytes of a file. More than `memory_limit` bytes on standard input are an error.
pub(crate) fn read(file: &Path, memory_limit: u64) -> Result<Vec<u8>, FileError> {
    if is_standard(file) {
        return stdin(memory_limit);
    }
    let mut bytes = Vec::new();
    open_regular(file)?.read_to_end(&mut bytes)?;
    Ok(bytes)
}

pub(crate) fn read_text(file: &Path) -> Result<String, Failure> {
    let text = |bytes| String::from_utf8(bytes).map_err(|_| io::Error::other("it is not UTF-8 text").into());
    let mut text = read(file, MAX_STDIN_BYTES).and_then(text).map_err(|error| Failure::input(file, error))?;
    // Editors on Windows begin files with a byte order mark.
    if text.starts_with('\u{feff}') {
        text.replace_range(..'\u{feff}'.len_utf8(), "");
    }
    Ok(text)
}

/// The input's metadata. On Unix `-` has the metadata of standard input: a file, a pipe or a terminal.
pub(crate) fn metadata(file: &Path) -> io::Result<Metadata> {
    #[cfg(unix)]
    if is_standard(file) {
        use std::os::fd::AsFd;
        return File::from(io::stdin().as_fd().try_clone_to_owned()?).metadata();
    }
    std::fs::metadata(file)
}

fn stdin(memory_limit: u64) -> Result<Vec<u8>, FileError> {
    static IS_TAKEN: AtomicBool = AtomicBool::new(false);
    if IS_TAKEN.swap(true, Ordering::SeqCst) {
        return Err(io::Error::other("standard input is already another input; `-` can be given once").into());
    }
    let mut bytes = Vec::new();
    let most = memory_limit.min(MAX_STDIN_BYTES);
    io::stdin().lock().take(most + 1).read_to_end(&mut bytes)?;
    let needed = bytes.len() as u64;
    if needed > MAX_STDIN_BYTES {
        return Err(io::Error::other("standard input holds more than 4 GiB; write it to a file").into());
    }
    if needed > most {
        return Err(FileError::TooLarge { what: "standard input".into(), needed, limit: memory_limit });
    }
    if bytes.is_empty() {
        return Err(io::Error::other("it is empty").into());
    }
    Ok(bytes)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn only_a_file_that_is_certainly_not_there_is_new() {
        let folder = tempfile::tempdir().expect("a folder");
        std::fs::write(folder.path().join("There.png"), "").expect("a file");
        let mut folders = Folders::default();
        let new = folder.path().join("new.png");
        for _ in 0..2 {
            assert!(folders.path_of_new(&new).is_some_and(|path| Some(path) == real_path(&new)));
            for name in ["There.png", "there.PNG", "\u{e9}.png", "none/new.png", "none/.."] {
                assert_eq!(folders.path_of_new(&folder.path().join(name)), None, "{name}");
            }
        }
        assert_eq!(folders.path_of_new(Path::new("-")), None);
    }

    #[test]
    fn endings_of_other_formats_are_refused() {
        let is_taken = |name: &str, expected| check_ending(Path::new(name), expected).is_ok();
        for name in ["a.png", "a.PNG", "a", "a.b", "v1.2", "/dev/stdout", ".png"] {
            assert!(is_taken(name, "png"), "{name}");
        }
        for name in ["a.jpg", "a.JPEG", "a.npz", "a.glb", "a.png.webp"] {
            assert!(!is_taken(name, "png"), "{name}");
        }
        assert!(is_taken("a.npz", "npz") && !is_taken("a.png", "npz"));
        assert!(is_taken("a.json", "json") && is_taken("-", "json") && !is_taken("a.glb", "json"));
        let is_folder = |name| check_folder(Path::new(name), "").is_ok();
        assert!(!is_folder("none/film.mp4") && !is_folder("-") && is_folder("none/film.d") && is_folder("none/report"));
    }
}
