//! A film as numbered pictures in a folder.

use std::io::{self, BufRead as _, Write as _};
use std::path::{Path, PathBuf};

use super::Film;
use crate::failure::Failure;
use crate::files::{Inputs, check_folder};
use crate::image::Picture;
use crate::output::{Folder, Line, Output, is_quiet};
use crate::shadow::args::FilmArgs;
use crate::signals::{self, create_unfinished, remove_unfinished};

const PNG: &str = "png";

/// A folder that is claimed for a film. What is in it is dropped before the folder, which is removed if it is empty then.
pub(super) struct Frames<'a> {
    args: &'a FilmArgs,
    /// The first picture's file, until it is written.
    first: Option<Output>,
    _claim: Claim,
    _made: Folder,
    count: u32,
    identity: String,
    kept: u32,
    written: u32,
}

/// The keyword of a picture's text that names its film.
const FILM: &str = "rimline film";

/// A name for the film of these options and inputs: a hash, FNV-1a, of all that decides the pictures.
fn identity(options: &str, files: &[&Path]) -> String {
    let mut hash = 0xcbf2_9ce4_8422_2325_u64;
    let mut take = |bytes: &[u8]| {
        hash = bytes.iter().fold(hash, |hash, &byte| (hash ^ u64::from(byte)).wrapping_mul(0x0100_0000_01b3));
    };
    take(options.as_bytes());
    // A pipe cannot be read again, and a file that is missing, such as a picture that a model names, decides nothing.
    let readable = files.iter().filter(|file| file.is_file());
    for file in readable.filter_map(|file| std::fs::File::open(file).ok()) {
        let mut reader = io::BufReader::with_capacity(1 << 16, file);
        while let Ok(bytes @ [_, ..]) = reader.fill_buf() {
            take(bytes);
            let count = bytes.len();
            reader.consume(count);
        }
    }
    format!("{hash:016x}")
}

impl<'a> Frames<'a> {
    /// Claims the folder before long work: a folder that cannot be had is known at once.
    pub(super) fn begin(args: &'a FilmArgs) -> Result<Self, Failure> {
        check_folder(
            &args.out,
            "--out is the folder for numbered PNG files; give the name of a folder, or one that ends in \
             .gif, .apng or .mp4",
        )?;
        let (made, claim) = (Folder::create(&args.out)?, Claim::take(&args.out)?);
        let (count, identity, kept, written) = (0, String::new(), 0, 0);
        Ok(Self { args, first: None, _claim: claim, _made: made, count, identity, kept, written })
    }

    fn file(&self, frame: u32) -> PathBuf {
        frame_file(&self.args.out, frame, self.count, PNG)
    }

    /// Sets the words that a signal should say.
    fn tell(&self) {
        let (done, folder) = (self.kept + self.written, Line(self.args.out.display()));
        if !is_quiet() {
            signals::say_at_end(format!("{done} of {} pictures are in {folder}; --resume goes on", self.count));
        }
    }
}

impl Film for Frames<'_> {
    /// Refuses also to stand among pictures of another film.
    fn start(&mut self, count: u32, files: &[&Path]) -> Result<(), Failure> {
        let FilmArgs { scene, orbit, out, .. } = self.args;
        let fps = self.args.fps();
        (self.count, self.identity) = (count, identity(&format!("{scene:?} {fps} {orbit:?} {count}"), files));
        let inputs = Inputs::new(files);
        for frame in 0..count {
            let file = self.file(frame);
            inputs.spare(&file)?;
            if file.is_dir() {
                let why = "it is a folder; remove it, or choose another folder for the film";
                return Err(Failure::output(&file)(io::Error::other(why)));
            }
        }
        check_earlier(out, count, PNG)?;
        let kept: Vec<PathBuf> = (0..count).filter(|&frame| self.has(frame)).map(|frame| self.file(frame)).collect();
        if let Some(file) = kept.iter().find(|file| !is_of(file, &self.identity, scene.view.size)) {
            return Err(Failure::usage(format!(
                "{} is of a film with another --device, other options or models, so --resume would mix two; give those \
                 of that film, or leave --resume out, which draws all pictures anew, or choose another folder",
                file.display()
            )));
        }
        self.kept = kept.len() as u32;
        self.tell();
        self.first = if self.has(0) { None } else { Some(Output::create(&self.file(0))?) };
        Ok(())
    }

    /// All pictures are complete.
    fn has(&self, frame: u32) -> bool {
        self.args.resume && self.file(frame).is_file()
    }

    fn write(&mut self, frame: u32, picture: &Picture) -> Result<(), Failure> {
        let output = self.first.take().map_or_else(|| Output::create(&self.file(frame)), Ok)?;
        output.finish(|file| picture.write_png(file, Some((FILM, &self.identity))))?;
        self.written += 1;
        self.tell();
        if frame == 0 && !self.args.resume {
            remove_earlier((1..self.count).map(|frame| self.file(frame)))?;
        }
        Ok(())
    }

    fn finish(self: Box<Self>, _frames: u32) -> Result<String, Failure> {
        let [first, last] = [0, self.count - 1].map(|frame| Line(self.file(frame).display()).to_string());
        let pictures = |count: u32| if count == 1 { "1 picture".to_owned() } else { format!("{count} pictures") };
        Ok(match (self.kept, self.count) {
            (0, 1) => format!("wrote {first}"),
            (0, count) => format!("wrote {count} pictures, {first} to {last}"),
            (kept, _) => format!("kept {}, wrote {}: {first} to {last}", pictures(kept), self.written),
        })
    }
}

/// Whether a picture may be of a film: it names it, or names none and has its size. What is no picture may be anything.
fn is_of(file: &Path, identity: &str, size: [u32; 2]) -> bool {
    let Ok(file) = std::fs::File::open(file) else { return true };
    let Ok(reader) = png::Decoder::new(io::BufReader::new(file)).read_info() else { return true };
    let info = reader.info();
    let named = info.uncompressed_latin1_text.iter().find(|text| text.keyword == FILM);
    named.map_or([info.width, info.height] == size, |text| text.text == identity)
}

/// Refuses a folder with pictures of a film that this one does not replace: they would stand among its own.
pub(crate) fn check_earlier(folder: &Path, frames: u32, ending: &str) -> Result<(), Failure> {
    let Ok(entries) = std::fs::read_dir(folder) else { return Ok(()) };
    let is_other = |path: &PathBuf| match frame_number(path, ending) {
        Some(frame) => frame >= u64::from(frames) || frame_file(folder, frame as u32, frames, ending) != *path,
        None => false,
    };
    let mut others: Vec<PathBuf> = entries.filter_map(|entry| Some(entry.ok()?.path())).filter(is_other).collect();
    others.sort();
    let Some(first) = others.first() else { return Ok(()) };
    let count = if others.len() == 1 { "a picture".to_owned() } else { format!("{} pictures", others.len()) };
    Err(Failure::usage(format!(
        "{} has {count} of another film, which is longer or has other numbers, first {}; remove these \
         pictures or choose another folder",
        folder.display(),
        first.display()
    )))
}

/// The number of a file that is named as pictures are: four digits or more, and nothing else.
fn frame_number(path: &Path, ending: &str) -> Option<u64> {
    let digits = path.file_name()?.to_str()?.strip_suffix(ending)?.strip_suffix('.')?;
    let is_number = digits.len() >= 4 && digits.bytes().all(|digit| digit.is_ascii_digit());
    is_number.then(|| digits.parse().unwrap_or(u64::MAX))
}

/// Removes the pictures of an earlier film that this one is going to replace, so that one that is stopped leaves only its
/// own.
pub(crate) fn remove_earlier(files: impl Iterator<Item = PathBuf>) -> Result<(), Failure> {
    for file in files.filter(|file| file.symlink_metadata().is_ok_and(|there| there.is_file())) {
        std::fs::remove_file(&file).map_err(Failure::output(&file))?;
    }
    Ok(())
}

/// Four digits or as many as it takes.
pub(crate) fn frame_file(folder: &Path, frame: u32, frames: u32, ending: &str) -> PathBuf {
    let digits = (frames - 1).to_string().len().max(4);
    folder.join(format!("{frame:0digits$}.{ending}"))
}

/// A film's claim of its folder, as long as it lives: a hidden file with the number of the process. Two films in one folder
/// would remove and replace each other's pictures.
#[derive(Debug)]
pub(crate) struct Claim {
    file: PathBuf,
}

const CLAIM: &str = ".rimline-film.part";

impl Claim {
    /// Claims a folder that is there. A claim whose process is gone counts for nothing.
    pub(crate) fn take(folder: &Path) -> Result<Self, Failure> {
        let file = folder.join(CLAIM);
        let mut taken = claim(&file);
        if taken.as_ref().is_err_and(is_there) && is_stale(&file) {
            let _ = std::fs::remove_file(&file);
            taken = claim(&file);
        }
        match taken {
            Ok(()) => Ok(Self { file }),
            Err(error) if is_there(&error) => Err(Failure::usage(format!(
                "another film is being written into {}; wait until it is done, or choose another folder (if \
                 there is no other film, remove {})",
                folder.display(),
                file.display()
            ))),
            Err(error) => Err(Failure::output(folder)(error)),
        }
    }
}

impl Drop for Claim {
    fn drop(&mut self) {
        remove_unfinished(&self.file);
    }
}

fn claim(file: &Path) -> io::Result<()> {
    create_unfinished(file)?.write_all(std::process::id().to_string().as_bytes())
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
    fn pictures_of_other_films() {
        assert_eq!(frame_number(Path::new("a/0007.png"), PNG), Some(7));
        for other in ["a/007.png", "a/0007.PNG", "a/0007.jpg", "a/x0007.png", "a/+007.png", "0007"] {
            assert_eq!(frame_number(Path::new(other), PNG), None, "{other}");
        }
        assert_eq!(frame_number(Path::new("99999999999999999999999.png"), PNG), Some(u64::MAX));
    }

    #[test]
    fn an_earlier_film_makes_room() {
        let folder = tempfile::tempdir().expect("there is room");
        let at = |name: &str| folder.path().join(name);
        for name in ["0000.png", "0001.png", "0003.png", "notes.txt"] {
            std::fs::write(at(name), "earlier").expect("there is room");
        }
        std::fs::create_dir(at("0002.png")).expect("there is room");
        remove_earlier((1..3).map(|frame| frame_file(folder.path(), frame, 3, PNG))).expect("they can be removed");
        for (name, is_left) in
            [("0000.png", true), ("0001.png", false), ("0002.png", true), ("0003.png", true), ("notes.txt", true)]
        {
            assert_eq!(at(name).exists(), is_left, "{name}");
        }
    }

    #[test]
    fn frames_are_numbered_in_their_folder() {
        for folder in ["a/frames", "a/frames/"] {
            assert_eq!(frame_file(Path::new(folder), 7, 10, PNG), Path::new("a/frames/0007.png"));
        }
        assert_eq!(frame_file(Path::new("walk"), 12_345, 20_000, PNG), Path::new("walk/12345.png"));
    }

    #[test]
    #[cfg(target_os = "linux")]
    fn a_claim_of_a_process_that_is_gone_counts_for_nothing() {
        let folder = tempfile::tempdir().expect("there is room");
        // Above the largest number of a process.
        std::fs::write(folder.path().join(CLAIM), "4294967295").expect("there is room");
        let claim = Claim::take(folder.path()).expect("its process is gone");
        drop(claim);
        // A file without a number may be a claim in the making.
        std::fs::write(folder.path().join(CLAIM), "").expect("there is room");
        Claim::take(folder.path()).expect_err("it may be in the making");
    }
}
