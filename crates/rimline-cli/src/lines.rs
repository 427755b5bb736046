//! `rimline lines`: hidden-line drawings, as vectors or as a picture.

pub(crate) mod args;
mod dxf;
mod eye;
mod json;
mod pdf;
mod png;
mod sheet;
mod style;
mod svg;

use std::borrow::Cow;
use std::collections::BTreeSet;
use std::io::{self, Write};
use std::ops::ControlFlow;
use std::path::{Path, PathBuf};

use clap::ValueEnum;
use rimline::cpu::Threads;
use rimline::{Mesh, Origin};
use rimline_lines::{Drawing, Fault, LineClass, LineOptions, LinesError, Object, draw, objects_of_model};
use rimline_picture::Bounds;

use crate::failure::{Failure, NO_FINITE_FACE};
use crate::files::{Inputs, check_ending, check_folder};
use crate::film::{self, Claim};
use crate::info::Seams;
use crate::input::{Input, Shape, note_idle_time, play, settle};
use crate::output::{Folder, Line, Output, Progress, note, say};
use args::{DxfUnits, Format, Hidden, LinesArgs};
use eye::Eye;
use sheet::Sheet;
use style::Style;

/// Moments that the eye of a film is chosen by.
const LOOKS: u32 = 12;

pub(crate) fn run(args: &LinesArgs) -> Result<(), Failure> {
    let format = Format::of(args)?;
    args.check(format)?;
    let mut style = args.style.as_deref().map_or_else(|| Ok(Style::default()), style::read)?;
    if let (Some(file), Hidden::None, true) = (&args.style, args.hidden, style.has_hidden()) {
        note(&format!("warning: {}: hidden lines are not drawn; give --hidden dashed or thin", file.display()));
    }
    let frames = args.frames.unwrap_or(1);
    let files = files(args)?;
    let file = |frame: u32| files[frame as usize].clone();
    let _folder = args.frames.map(|_| Folder::create(&args.out)).transpose()?;
    let _claim = args.frames.map(|_| Claim::take(&args.out)).transpose()?;
    let progress = Progress::start();
    progress.step("reading the models");
    let inputs = read(args)?;
    let read = inputs.iter().flat_map(Input::files).map(Path::to_owned).chain(args.style.clone());
    let read = Inputs::new(read.collect::<Vec<PathBuf>>());
    (0..frames).try_for_each(|frame| read.spare(&file(frame)))?;
    if args.frames.is_some() {
        film::check_earlier(&args.out, frames, format.names().0)?;
    }
    let mut output = Some(Output::create(&file(0))?);

    let is_moving = frames > 1 && inputs.iter().any(|input| !input.playing.is_empty());
    let time_s = |frame: u32| args.pose.time + (f64::from(frame) / f64::from(args.fps)) as f32;
    let objects_at = |frame: u32| {
        let mut objects = Vec::new();
        for input in &inputs {
            objects.extend(objects_of(input, time_s(frame), inputs.len() > 1)?);
        }
        tell_apart(&mut objects);
        Ok::<_, Failure>(objects)
    };
    let first = objects_at(0)?;
    let objects_of_frame = |frame: u32| {
        if is_moving && frame > 0 { objects_at(frame).map(Cow::Owned) } else { Ok(Cow::Borrowed(&first)) }
    };
    let refused = |error: LinesError| refused(&args.files[0], error);
    let mut corners = eye::corners(&first);
    for look in 1..if is_moving { LOOKS.min(frames) } else { 1 } {
        corners.extend(eye::corners(&objects_at(look * frames / LOOKS.min(frames))?));
    }
    let origin = inputs[0].origin();
    let bounds = Bounds::of(&corners).ok_or_else(|| Failure::input(&args.files[0])(NO_FINITE_FACE.into()))?;
    let still = Eye::new(args, origin, &corners, &bounds)?;
    drop(corners);
    let eye_of = |frame: u32| {
        let camera = inputs[0].camera(&args.camera, time_s(frame))?;
        let eye = camera.map_or(Ok(still), |camera| Eye::of_camera(&camera, &bounds)).map_err(refused)?;
        eye.turned(f64::from(args.turn) * f64::from(frame) / f64::from(frames)).map_err(refused)
    };
    if eye_of(0)?.view.is_perspective() {
        args.check_perspective()?;
    }
    let mut extent = sheet::Extent::default();
    for frame in 0..frames {
        extent.add(args, &eye_of(frame)?, &objects_of_frame(frame)?);
    }
    let mut remarks = Remarks::default();
    let mut said = String::new();
    for frame in 0..frames {
        let (objects, eye) = (objects_of_frame(frame)?, eye_of(frame)?);
        let what = if frames == 1 { "finding lines".to_owned() } else { format!("drawing {} of {frames}", frame + 1) };
        progress.step(what.clone());
        let drawing = draw(&objects, &eye.view, &options(args, &eye), |done, all| {
            progress.step(format!("{what}, {:.0} %", 100.0 * done as f64 / (all as f64).max(1.0)));
            ControlFlow::Continue(())
        });
        let drawing = drawing.map_err(refused)?;
        let is_left_out = remarks.of_drawing(&drawing, objects.len());
        if is_left_out && frame == 0 {
            return Err(Failure::input(&args.files[0])("nothing of it can be drawn; the warnings say why".into()));
        }
        if frame == 0 && drawing.spans.iter().any(|span| span.class == LineClass::Boundary) {
            remarks.of_seams(&inputs);
        }
        // Added to coordinates of the page, it makes them those of the files.
        let is_in_units = format == Format::Dxf && args.dxf_units == DxfUnits::Model;
        let units = is_in_units.then(|| eye.view.page(origin.to_array()));
        let mut sheet = Sheet::new(args, &style, &drawing, extent.window(args, &eye), units)?;
        if frame == 0 && sheet.is_crowded() {
            style.is_fine = true;
            sheet = Sheet::new(args, &style, &drawing, extent.window(args, &eye), units)?;
        }
        sheet.remarks.iter().for_each(|remark| remarks.say(remark));
        if frames == 1 {
            progress.step("writing");
        }
        let output = output.take().map_or_else(|| Output::create(&file(frame)), Ok)?;
        output.finish(|file| {
            format
                .write(file, &Picture { args, eye: &eye, objects: &objects, drawing: &drawing, sheet: &sheet, origin })
        })?;
        if args.frames.is_some() && frame == 0 {
            film::remove_earlier((1..frames).map(file))?;
        }
        said = sheet.said(args, eye.view.is_perspective(), &[file(0), file(frame)]);
    }
    drop(progress);
    say(&said)
}

pub(crate) fn files(args: &LinesArgs) -> Result<Vec<PathBuf>, Failure> {
    let format = Format::of(args)?;
    Ok(match args.frames {
        Some(frames) => (0..frames).map(|frame| film::frame_file(&args.out, frame, frames, format.names().0)).collect(),
        None => vec![args.out.clone()],
    })
}

fn options(args: &LinesArgs, eye: &Eye) -> LineOptions {
    LineOptions {
        classes: args.classes(),
        crease_degrees: args.crease(),
        near: eye.near,
        window: sheet::taken(args, eye),
        memory_limit: Some(args.load.memory_limit),
        threads: Threads::all(),
    }
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
    let options = args.load.options(args.weld.weld(), args.polygons.taken());
    let mut inputs = args.files.iter().map(|file| Input::read(file, &options)).collect::<Result<Vec<_>, _>>()?;
    play(&mut inputs, &args.pose)?;
    settle(&mut inputs, args.pose.time)?;
    note_idle_time(&args.pose, inputs.iter().any(|input| !input.playing.is_empty()), None);
    Ok(inputs)
}

/// The objects of a file. Where there are several files, their names begin with the file's.
fn objects_of(input: &Input, time_s: f32, is_prefixed: bool) -> Result<Vec<Object<'static>>, Failure> {
    let shape = input.shape(time_s, false)?;
    let mut objects = match &shape {
        Shape::Posed { model, pose } => {
            objects_of_model(model, pose, Threads::all()).map_err(|error| refused(&input.file, error))?
        }
        Shape::World(positions) => {
            let name = input.file.file_stem().unwrap_or_default().to_string_lossy().into_owned();
            let (mesh, positions) = (Cow::Owned(input.mesh(&shape)?), Cow::Owned(positions.to_vec()));
            vec![Object { name, mesh, positions, marked: Vec::new() }]
        }
    };
    objects = objects.into_iter().map(finite).collect::<Result<_, _>>()?;
    if is_prefixed {
        let file = input.file.file_name().unwrap_or_default().to_string_lossy();
        for object in &mut objects {
            object.name = format!("{file}: {}", object.name);
        }
    }
    Ok(objects)
}

/// Numbers names that several objects have.
fn tell_apart(objects: &mut [Object<'_>]) {
    let mut names: BTreeSet<String> = objects.iter().map(|object| object.name.clone()).collect();
    let mut met = BTreeSet::new();
    for object in objects {
        if met.insert(object.name.clone()) {
            continue;
        }
        let mut numbered = (2..).map(|number| format!("{} {number}", object.name));
        object.name = numbered.find(|name| names.insert(name.clone())).unwrap_or_default();
        met.insert(object.name.clone());
    }
}

/// Whether all corners of a face are finite.
fn is_finite(object: &Object<'_>, face: &[u32; 3]) -> bool {
    let mut corners = face.iter().map(|&vertex| object.positions.get(vertex as usize));
    corners.all(|corner| corner.is_some_and(|corner| corner.iter().all(|c| c.is_finite())))
}

/// Without faces that are not finite, as long as there are others: a warning has counted them. Polygons stay as they are.
fn finite(object: Object<'static>) -> Result<Object<'static>, Failure> {
    let faces = object.mesh.faces().iter().copied().filter(|face| is_finite(&object, face));
    let faces: Vec<[u32; 3]> = faces.collect();
    if faces.is_empty() || faces.len() == object.mesh.faces().len() || object.mesh.polygons().is_some() {
        return Ok(object);
    }
    let mesh = Mesh::from_faces(object.positions.len(), faces).map_err(rimline::ModelError::from)?;
    Ok(Object { mesh: Cow::Owned(mesh), ..object })
}

fn refused(file: &Path, error: LinesError) -> Failure {
    Failure::input(file)(error.into())
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
            Failure::usage(format!(
                "{}: no format is known by this name; end it in .svg, .pdf, .dxf, .json or .png, or give --format",
                args.out.display()
            ))
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
