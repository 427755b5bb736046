//! `rimline film`: an animation with its shadows, as numbered pictures.

use std::io::{self, Write as _};
use std::path::{Path, PathBuf};

use rimline::internals::layout::ShadowStatistics;

use crate::failure::{Failure, UsageError};
use crate::gpu_error::On as _;
use crate::input::Input;
use crate::origin;
use crate::output::{Folder, Output, print};
use crate::progress::Progress;
use crate::shadow;
use crate::shadow::args::{FilmArgs, MAX_FRAMES};
use crate::shadow::casters::Casters;
use crate::shadow::depth::warn_of_limits;
use crate::shadow::pictures::Pictures;
use crate::shadow::posed_model::PosedModel;
use crate::shadow::render_resources::RenderResources;
use crate::shadow::shadow_scene::{ShadowInputs, ShadowScene, open_gpu};
use crate::shadow::shadows::ShadowMethod;
use crate::shown::Line;
use crate::signals::{create_unfinished, remove_unfinished};
use crate::target::{Inputs, check_folder};

/// Moments that the camera is chosen by: it must see all of the motion.
const LOOKS: u32 = 12;
/// The ending of the pictures.
const PNG: &str = "png";

pub(crate) fn run(args: &FilmArgs) -> Result<(), Failure> {
    let scene = &args.scene;
    check_folder(&args.out, |out| UsageError::FolderEnding { out })?;
    // Before long work: a place that cannot be had is known at once.
    let _folder = Folder::create(&args.out)?;
    let _claim = Claim::take(&args.out)?;
    let progress = Progress::start();
    progress.step("reading the models");
    let mut props = ShadowInputs::read(scene)?;
    if scene.posed.pose.animations.is_empty() && props.displacement.is_none() {
        props.take_first_animations();
    }
    origin::settle(&mut props.inputs, &props.animations, scene.posed.pose.time)?;
    let frames = frames(args, &props)?;
    let time = |frame: u32| scene.posed.pose.time + (f64::from(frame) / f64::from(args.fps)) as f32;
    let file = |frame: u32| frame_file(&args.out, frame, frames, PNG);
    let inputs = Inputs::new(props.files(scene));
    for frame in 0..frames {
        inputs.spare(&file(frame))?;
        if file(frame).is_dir() {
            let source = std::io::Error::other("it is a folder; remove it, or choose another place for the film");
            return Err(Failure::Output { file: file(frame), source });
        }
    }
    check_earlier(&args.out, frames, PNG)?;
    let mut output = Some(Output::create(&file(0))?);

    progress.step("opening the device");
    let gpu = open_gpu(scene)?;
    let method = ShadowMethod::new(scene.method.counting(), None);
    let _compiling = method.compile(&gpu);
    progress.step("looking at the motion");
    let mut bodies = props.bodies(&gpu, time(0))?;
    let mut points = Vec::new();
    for look in 0..LOOKS.min(frames) {
        let posed = time((u64::from(look) * u64::from(frames) / u64::from(LOOKS.min(frames))) as u32);
        bodies.iter_mut().try_for_each(|body| body.pose(&gpu, posed))?;
        points.extend(bodies.iter().flat_map(PosedModel::points));
    }
    let mut set = ShadowScene::new(scene, bodies, &points, None)?;
    let resources = RenderResources::new(&gpu, &set.frame(), scene.view.size, set.samples());
    let pictures = Pictures::new(&resources, &method, scene.mode, scene.volumes, set.is_in_parts()).on(&gpu)?;
    drop(progress);

    let progress = Progress::pictures(u64::from(frames));
    let mut casters = Casters::new(&resources, &pictures.pipelines, set.samples(), scene.volumes).on(&gpu)?;
    let mut most: ShadowStatistics = bytemuck::Zeroable::zeroed();
    for frame in 0..frames {
        let output = output.take().map_or_else(|| Output::create(&file(frame)), Ok)?;
        set.pose(&gpu, time(frame))?;
        casters.place(&set.bodies)?;
        set.cast(&mut casters, None).on(&gpu)?;
        set.count_layers(&mut casters)?;
        let picture = shadow::picture(&pictures, &mut set, &mut casters).on(&gpu)?;
        let found = casters.shadows.statistics().on(&gpu)?;
        most.count_bound = most.count_bound.max(found.count_bound);
        most.may_wrap = most.may_wrap.max(found.may_wrap);
        most.lost_pieces = most.lost_pieces.max(found.lost_pieces);
        most.most_pieces = most.most_pieces.max(found.most_pieces);
        gpu.check()?;
        output.finish(|file| picture.write_png(file))?;
        if frame == 0 {
            remove_earlier((1..frames).map(file))?;
        }
        progress.picture_done();
    }
    drop(progress);
    warn_of_limits(most);
    set.warn_of_depth(&gpu);
    let [first, last] = [file(0), file(frames - 1)];
    let [width, height] = scene.view.size;
    let names = match frames {
        1 => Line(first.display()).to_string(),
        _ => format!("{frames} pictures, {} to {}", Line(first.display()), Line(last.display())),
    };
    print(&format!("wrote {names} ({width}×{height})\n"))
}

/// How many pictures are asked for, or make up the longest animation.
fn frames(args: &FilmArgs, props: &ShadowInputs) -> Result<u32, Failure> {
    let duration = |(input, animations): (&Input, &Vec<usize>)| {
        let asset = input.asset()?;
        let lasts = animations.iter().filter_map(|&index| Some(asset.animations().get(index)?.duration_s));
        lasts.reduce(f32::max)
    };
    let lasts = props.inputs.iter().zip(&props.animations).filter_map(duration).reduce(f32::max);
    let seconds = match (args.frames, args.seconds.or(lasts)) {
        (Some(frames), _) => return Ok(frames),
        (None, Some(seconds)) => seconds,
        (None, None) if props.displacement.is_some() => return Err(UsageError::EndlessDisplacement.into()),
        (None, None) => return Err(UsageError::NoAnimation.into()),
    };
    let frames = (f64::from(seconds) * f64::from(args.fps)).round().max(1.0);
    if frames > MAX_FRAMES as f64 {
        return Err(UsageError::TooManyFrames { frames: frames as u64, limit: MAX_FRAMES as u64 }.into());
    }
    Ok(frames as u32)
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
    Err(UsageError::OtherFilm { folder: folder.to_owned(), first: first.clone(), count }.into())
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
        std::fs::remove_file(&file).map_err(|source| Failure::Output { file, source })?;
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
            Err(error) if is_there(&error) => {
                Err(UsageError::FilmInProgress { folder: folder.to_owned(), claim: file }.into())
            }
            Err(source) => Err(Failure::Output { file: folder.to_owned(), source }),
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
    fn a_folder_has_one_film_at_a_time() {
        let folder = tempfile::tempdir().expect("there is room");
        let first = Claim::take(folder.path()).expect("nobody claims it");
        let second = Claim::take(folder.path()).expect_err("it is claimed");
        assert!(second.to_string().contains(CLAIM), "{second}");
        drop(first);
        assert!(!folder.path().join(CLAIM).exists());
        drop(Claim::take(folder.path()).expect("nobody claims it any more"));
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
