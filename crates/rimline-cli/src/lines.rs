//! `rimline lines`: hidden-line drawings, as vectors or as a picture.

pub(crate) mod args;
mod dxf;
mod eye;
mod json;
mod motion;
mod pdf;
mod png;
mod sheet;
mod style;
mod svg;

use std::collections::BTreeSet;
use std::io::{self, Write};
use std::path::PathBuf;

use clap::ValueEnum;
use rimline::Origin;
use rimline_lines::{Drawing, Fault, LineClass, Object};

use crate::failure::Failure;
use crate::files::{Inputs, check_ending, check_folder};
use crate::film::{self, Claim};
use crate::info::Seams;
use crate::input::{Input, note_idle_time, play, settle};
use crate::output::{Folder, Line, Output, Progress, note, say};
use args::{DxfUnits, Format, Hidden, LinesArgs};
use eye::Eye;
use motion::Motion;
use sheet::Sheet;
use style::Style;

pub(crate) fn run(args: &LinesArgs) -> Result<(), Failure> {
    let format = Format::of(args)?;
    args.check(format)?;
    let mut style = style(args)?;
    let files = files(args)?;
    let _folder = args.frames.map(|_| Folder::create(&args.out)).transpose()?;
    let _claim = args.frames.map(|_| Claim::take(&args.out)).transpose()?;
    let progress = Progress::start();
    progress.step("reading the models");
    let inputs = read(args)?;
    check_results(args, format, &inputs, &files)?;
    let mut output = Some(Output::create(&files[0])?);

    let motion = Motion::new(args, &inputs)?;
    if motion.eye(0)?.view.is_perspective() {
        args.check_perspective()?;
    }
    let extent = motion.extent()?;
    let mut remarks = Remarks::default();
    let mut said = String::new();
    for (frame, file) in (0..).zip(&files) {
        let (objects, eye) = (motion.objects(frame)?, motion.eye(frame)?);
        let drawing = motion.drawing(frame, &objects, &eye, &progress)?;
        if remarks.of_drawing(&drawing, objects.len()) && frame == 0 {
            return Err(Failure::input(&args.files[0], "nothing of it can be drawn; the warnings say why"));
        }
        if frame == 0 && drawing.spans.iter().any(|span| span.class == LineClass::Boundary) {
            remarks.of_seams(&inputs);
        }
        let origin = inputs[0].origin();
        // Added to coordinates of the page, it makes them those of the files.
        let is_in_units = format == Format::Dxf && args.dxf_units == DxfUnits::Model;
        let units = is_in_units.then(|| eye.view.page(origin.to_array()));
        let sheet_of = |style: &Style| Sheet::new(args, style, &drawing, extent.window(args, &eye), units);
        let mut sheet = sheet_of(&style)?;
        if frame == 0 && sheet.is_crowded() {
            style.is_fine = true;
            sheet = sheet_of(&style)?;
        }
        sheet.remarks.iter().for_each(|remark| remarks.say(remark));
        if files.len() == 1 {
            progress.step("writing");
        }
        let output = output.take().map_or_else(|| Output::create(file), Ok)?;
        let picture = Picture { args, eye: &eye, objects: &objects, drawing: &drawing, sheet: &sheet, origin };
        output.finish(|file| format.write(file, &picture))?;
        if args.frames.is_some() && frame == 0 {
            film::remove_earlier(files.iter().skip(1).cloned())?;
        }
        said = sheet.said(args, eye.view.is_perspective(), [&files[0], file]);
    }
    drop(progress);
    say(&said)
}

/// The style of the lines. Says where it has some for lines that are not drawn.
fn style(args: &LinesArgs) -> Result<Style, Failure> {
    let Some(file) = &args.style else { return Ok(Style::default()) };
    let style = style::read(file)?;
    if args.hidden == Hidden::None && style.has_hidden() {
        note(&format!("warning: {}: hidden lines are not drawn; give --hidden dashed or thin", file.display()));
    }
    Ok(style)
}

/// Refuses results that would replace an input, or stand among the pictures of another film.
fn check_results(args: &LinesArgs, format: Format, inputs: &[Input], files: &[PathBuf]) -> Result<(), Failure> {
    let read = Inputs::new(inputs.iter().flat_map(Input::files).chain(args.style.as_deref()));
    files.iter().try_for_each(|file| read.spare(file))?;
    args.frames.map_or(Ok(()), |frames| film::check_earlier(&args.out, frames, format.names().0))
}

pub(crate) fn files(args: &LinesArgs) -> Result<Vec<PathBuf>, Failure> {
    let format = Format::of(args)?;
    Ok(match args.frames {
        Some(frames) => (0..frames).map(|frame| film::frame_file(&args.out, frame, frames, format.names().0)).collect(),
        None => vec![args.out.clone()],
    })
}

/// Remarks for the user, each of which is printed once.
#[derive(Default)]
struct Remarks(BTreeSet<String>);

impl Remarks {
    fn say(&mut self, remark: &str) {
        if self.0.insert(remark.to_owned()) {
            note(remark);
        }
    }

    /// Says which objects are left out. Returns whether all are.
    fn of_drawing(&mut self, drawing: &Drawing, objects: usize) -> bool {
        for left_out in &drawing.left_out {
            self.say(&format!("warning: `{}`: {}", left_out.name, left_out.fault));
        }
        let is_left_out = |object: usize| {
            let mut faults = drawing.left_out.iter().filter(|left_out| left_out.object == object);
            faults.any(|left_out| !matches!(left_out.fault, Fault::NoSuchEdge { .. }))
        };
        if (0..objects).all(is_left_out) {
            return true;
        }
        if drawing.spans.is_empty() {
            self.say("warning: no line of these classes is in sight");
        }
        false
    }

    /// Says where boundaries are cracks that rounding left.
    fn of_seams(&mut self, inputs: &[Input]) {
        for input in inputs.iter().filter(|input| input.polygons().is_none()) {
            for geometry in input.model().geometries() {
                let seams = geometry.mesh().ok().and_then(|mesh| Seams::of(geometry, &mesh));
                if let Some(seams) = seams.filter(|seams| seams.closes > 0) {
                    self.say(&format!("warning: {}: {}", input.file.display(), seams.text()));
                }
            }
        }
    }
}

pub(crate) struct Picture<'a> {
    args: &'a LinesArgs,
    eye: &'a Eye,
    objects: &'a [Object<'a>],
    drawing: &'a Drawing,
    sheet: &'a Sheet,
    origin: Origin,
}

impl Picture<'_> {
    fn title(&self) -> String {
        let name = |file: &PathBuf| file.file_name().unwrap_or(file.as_os_str()).to_string_lossy().into_owned();
        Line(self.args.files.iter().map(name).collect::<Vec<_>>().join(", ")).to_string()
    }

    fn description(&self) -> String {
        format!(
            "{}; {}",
            self.eye.said(self.args, self.origin),
            self.sheet.scale_said(self.args, self.eye.view.is_perspective())
        )
    }
}

fn read(args: &LinesArgs) -> Result<Vec<Input>, Failure> {
    let options = args.read.options();
    let mut inputs = args.files.iter().map(|file| Input::read(file, &options)).collect::<Result<Vec<_>, _>>()?;
    play(&mut inputs, &args.pose)?;
    settle(&mut inputs, args.pose.time)?;
    note_idle_time(&args.pose, inputs.iter().any(|input| !input.playing.is_empty()));
    Ok(inputs)
}

impl Format {
    /// The format that is asked for, or that the name of the result has. Of numbered drawings the name is a folder's.
    pub(crate) fn of(args: &LinesArgs) -> Result<Self, Failure> {
        if args.frames.is_some() {
            check_folder(
                &args.out,
                "with --frames --out is the folder for numbered drawings; give the name of a folder, and the \
                 format by --format",
            )?;
            return Ok(args.format.unwrap_or(Self::Svg));
        }
        let ending = args.out.extension().and_then(|ending| ending.to_str()).map(str::to_lowercase);
        let named = ending.and_then(|ending| Self::from_str(&ending, false).ok());
        let format = args.format.or(named).ok_or_else(|| {
            let advice = if args.out.is_dir() {
                "it is a folder; give the name of a file that ends in .svg, .pdf, .dxf, .json or .png"
            } else {
                "no format is known by this name; end it in .svg, .pdf, .dxf, .json or .png, or give --format"
            };
            Failure::usage(format!("{}: {advice}", args.out.display()))
        })?;
        check_ending(&args.out, format.names().0)?;
        Ok(format)
    }

    /// The ending of its files, and the format in a sentence.
    pub(crate) fn names(self) -> (&'static str, &'static str) {
        match self {
            Self::Svg => ("svg", "an SVG"),
            Self::Pdf => ("pdf", "a PDF"),
            Self::Dxf => ("dxf", "a DXF"),
            Self::Json => ("json", "JSON"),
            Self::Png => ("png", "a PNG"),
        }
    }

    pub(crate) fn write(self, to: &mut impl Write, picture: &Picture<'_>) -> io::Result<()> {
        match self {
            Self::Svg => svg::write(to, picture),
            Self::Pdf => pdf::write(to, picture),
            Self::Dxf => dxf::write(to, picture),
            Self::Json => json::write(to, picture),
            Self::Png => png::write(to, picture),
        }
    }
}
