//! A film as one file: GIF, animated PNG, or MP4 by ffmpeg.

use std::fs::File;
use std::io::{self, BufWriter, Seek as _, Write as _};
use std::path::Path;
use std::process::{Child, Command, Stdio};

use tempfile::{NamedTempFile, TempPath};

use super::Film;
use crate::failure::Failure;
use crate::files::Inputs;
use crate::image::{Picture, png_encoder};
use crate::output::{Line, Output, note};
use crate::shadow::args::FilmArgs;
use crate::signals::{make_unfinished, remove_unfinished};

#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Format {
    Gif,
    Apng,
    Mp4,
}

impl Format {
    /// The format that a name ends in, unless it is that of a folder.
    pub(super) fn of(out: &Path) -> Option<Self> {
        let ending = out.extension()?.to_str()?.to_lowercase();
        let found = [("gif", Self::Gif), ("apng", Self::Apng), ("mp4", Self::Mp4)]
            .into_iter()
            .find(|(name, _)| *name == ending);
        found.filter(|_| !out.is_dir()).map(|(_, format)| format)
    }
}

/// Most pictures a second that browsers show of a GIF.
const GIF_FPS: f32 = 50.0;

/// Most pictures a second of an animated PNG.
const APNG_FPS: f32 = 65535.0;

/// The most hundredths of a second that a GIF shows a picture.
const GIF_DELAY: f64 = 65535.0;

pub(super) struct Clip<'a> {
    args: &'a FilmArgs,
    output: Output,
    format: Format,
    encoder: Option<Encoder>,
}

enum Encoder {
    Gif(Box<gif::Encoder<BufWriter<File>>>),
    Apng(Box<png::Writer<BufWriter<File>>>),
    Mp4(Ffmpeg),
}

impl<'a> Clip<'a> {
    /// Refuses before long work what cannot be written.
    pub(super) fn begin(args: &'a FilmArgs, format: Format) -> Result<Self, Failure> {
        if args.resume {
            return Err(Failure::usage(
                "--resume keeps the pictures of a folder; give --out the name of a folder, or leave it out",
            ));
        }
        match format {
            Format::Gif if args.scene.view.size.iter().any(|&side| u16::try_from(side).is_err()) => {
                return Err(Failure::usage(
                    "a GIF has at most 65535 pixels in each direction; give a smaller --size, or .apng",
                ));
            }
            Format::Gif if f64::from(args.fps()) * GIF_DELAY < 100.0 => {
                return Err(Failure::usage(
                    "a GIF shows a picture for at most 655.35 seconds; give a larger --fps, or .apng",
                ));
            }
            Format::Gif if args.fps() > GIF_FPS => {
                note(&format!(
                    "warning: programs show at most {GIF_FPS} pictures of a GIF a second, so it takes longer than it \
                     says"
                ));
            }
            Format::Apng if args.fps() > APNG_FPS => {
                note(&format!(
                    "warning: an animated PNG shows at most {APNG_FPS} pictures a second, so it takes longer than it says"
                ));
            }
            Format::Mp4 => Ffmpeg::check().map_err(|source| {
                Failure::usage(format!(
                    "{} needs ffmpeg, and no program of this name can be started: {source}; install it (on Debian \
                     `sudo apt-get install ffmpeg`), or give a folder, .gif or .apng",
                    args.out.display()
                ))
            })?,
            _ => {}
        }
        Ok(Self { args, output: Output::create(&args.out)?, format, encoder: None })
    }

    fn encoder(&self, file: File, frames: u32) -> io::Result<Encoder> {
        let (size @ [width, height], fps) = (self.args.scene.view.size, self.args.fps());
        let file = BufWriter::with_capacity(1 << 18, file);
        Ok(match self.format {
            Format::Gif => {
                let encoder = gif::Encoder::new(file, width as u16, height as u16, &[]);
                let mut encoder = encoder.map_err(io::Error::other)?;
                encoder.set_repeat(gif::Repeat::Infinite).map_err(io::Error::other)?;
                Encoder::Gif(Box::new(encoder))
            }
            Format::Apng => {
                let mut encoder = png_encoder(file, size, false);
                let (numerator, denominator) = delay(fps);
                encoder.set_animated(frames, 0)?;
                encoder.set_frame_delay(numerator, denominator)?;
                Encoder::Apng(Box::new(encoder.write_header()?))
            }
            Format::Mp4 => Encoder::Mp4(Ffmpeg::start(size, fps)?),
        })
    }
}

impl Film for Clip<'_> {
    fn start(&mut self, frames: u32, files: &[&Path]) -> Result<(), Failure> {
        Inputs::new(files).spare(&self.args.out)?;
        let encoder = self.encoder(self.output.handle()?, frames);
        self.encoder = Some(encoder.map_err(Failure::output(&self.args.out))?);
        Ok(())
    }

    fn write(&mut self, frame: u32, picture: &Picture) -> Result<(), Failure> {
        let (rgb, [width, height]) = (picture.rgb(), picture.size());
        let written = match &mut self.encoder {
            None => Ok(()),
            Some(Encoder::Gif(encoder)) => {
                // Delays are rounded so that the film keeps its length, unless a picture lasts under 2 hundredths of a second.
                let at = |frame: u32| (100.0 * f64::from(frame) / f64::from(self.args.fps())).round() as u64;
                let mut picture = gif::Frame::from_rgb_speed(width as u16, height as u16, &rgb, 10);
                picture.delay = (at(frame + 1) - at(frame)).clamp(2, GIF_DELAY as u64) as u16;
                encoder.write_frame(&picture).map_err(io::Error::other)
            }
            Some(Encoder::Apng(encoder)) => encoder.write_image_data(&rgb).map_err(io::Error::from),
            Some(Encoder::Mp4(ffmpeg)) => ffmpeg.write(&rgb),
        };
        written.map_err(Failure::output(&self.args.out))
    }

    fn finish(self: Box<Self>, frames: u32) -> Result<String, Failure> {
        let Self { args, output, encoder, .. } = *self;
        let finished = match encoder {
            None => Ok(None),
            Some(Encoder::Gif(encoder)) => {
                encoder.into_inner().map_err(io::Error::other).and_then(|mut file| file.flush()).map(|()| None)
            }
            Some(Encoder::Apng(encoder)) => encoder.finish().map_err(io::Error::from).map(|()| None),
            Some(Encoder::Mp4(mut ffmpeg)) => ffmpeg.finish().map(|()| Some(ffmpeg)),
        };
        let made = finished.map_err(Failure::output(&args.out))?;
        output.finish(|to| -> io::Result<()> {
            made.map_or(Ok(()), |ffmpeg| io::copy(&mut File::open(&ffmpeg.made)?, to).map(drop))
        })?;
        Ok(format!("wrote {}, {frames} pictures", Line(args.out.display())))
    }
}

/// Seconds from a picture to the next, as a fraction: the nearest of those with a power of ten on one side.
fn delay(fps: f32) -> (u16, u16) {
    const SIDES: [f64; 4] = [1000.0, 100.0, 10.0, 1.0];
    let fps = f64::from(fps);
    let whole = |number: f64| number.round().clamp(1.0, 65535.0);
    let fast = SIDES.map(|numerator| (numerator, whole(numerator * fps)));
    let slow = SIDES.map(|denominator| (whole(denominator / fps), denominator));
    let error = |&(numerator, denominator): &(f64, f64)| (numerator / denominator * fps - 1.0).abs();
    let nearest = fast.into_iter().chain(slow).min_by(|one, other| error(one).total_cmp(&error(other)));
    nearest.map_or((1, 1), |(numerator, denominator)| (numerator as u16, denominator as u16))
}

/// A running ffmpeg, which reads pictures and writes a file of its own: MP4 is not written from front to back.
struct Ffmpeg {
    child: Child,
    made: TempPath,
    complaints: File,
}

impl Ffmpeg {
    fn check() -> io::Result<()> {
        let silent = || Stdio::null();
        Command::new("ffmpeg").arg("-version").stdin(silent()).stdout(silent()).stderr(silent()).status().map(drop)
    }

    fn start([width, height]: [u32; 2], fps: f32) -> io::Result<Self> {
        let made = make_unfinished(|| {
            let made = NamedTempFile::with_suffix(".mp4")?.into_temp_path();
            let path = made.to_path_buf();
            Ok((made, path))
        })?;
        let complaints = tempfile::tempfile()?;
        let (size, rate) = (format!("{width}x{height}"), fps.to_string());
        let child = Command::new("ffmpeg")
            .args(["-hide_banner", "-loglevel", "error", "-y", "-f", "rawvideo", "-pix_fmt", "rgb24"])
            .args(["-video_size", &size, "-framerate", &rate, "-i", "-"])
            // In yuv420p four pixels share a colour, so sides must be even.
            .args(["-vf", "pad=ceil(iw/2)*2:ceil(ih/2)*2", "-c:v", "libx264", "-crf", "18", "-pix_fmt", "yuv420p"])
            .args(["-movflags", "+faststart", "-f", "mp4"])
            .arg(&made)
            .stdin(Stdio::piped())
            .stdout(Stdio::null())
            .stderr(complaints.try_clone()?)
            .spawn()?;
        Ok(Self { child, made, complaints })
    }

    fn write(&mut self, rgb: &[u8]) -> io::Result<()> {
        let written = self.child.stdin.as_mut().map_or(Ok(()), |stdin| stdin.write_all(rgb));
        // It says more than a broken pipe does.
        if written.is_err() { self.ended().and(written) } else { Ok(()) }
    }

    fn finish(&mut self) -> io::Result<()> {
        drop(self.child.stdin.take());
        self.ended()
    }

    /// Waits, and says what it complained about if it failed.
    fn ended(&mut self) -> io::Result<()> {
        if self.child.wait()?.success() {
            return Ok(());
        }
        self.complaints.rewind()?;
        let said = io::read_to_string(&self.complaints)?;
        let last = said.lines().last().unwrap_or("it says nothing").chars().take(200).collect::<String>();
        Err(io::Error::other(format!("ffmpeg failed: {last}")))
    }
}

impl Drop for Ffmpeg {
    fn drop(&mut self) {
        // It is of no use without the rest of the pictures.
        let _ = self.child.kill();
        let _ = self.child.wait();
        remove_unfinished(&self.made);
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn delays_are_fractions() {
        let of = |fps: f32| delay(fps);
        assert_eq!((of(25.0), of(0.001), of(29.97)), ((1000, 25000), (1000, 1), (1000, 29970)));
        assert_eq!((of(100.0), of(1e5)), ((100, 10000), (1, 65535)));
        // Two thirds of 1000 seconds, not half of them.
        assert_eq!((of(0.0015), of(0.3)), ((6667, 10), (1000, 300)));
    }
}
