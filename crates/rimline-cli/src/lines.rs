//! `rimline lines`: hidden-line drawings, as vectors or as a picture.

pub(crate) mod args;
mod dxf;
mod eye;
mod format;
mod json;
mod pdf;
mod png;
mod sheet;
mod style;
mod svg;

use std::borrow::Cow;
use std::collections::BTreeSet;
use std::ops::ControlFlow;
use std::path::{Path, PathBuf};

use rimline::cpu::Threads;
use rimline::{Mesh, Origin};
use rimline_lines::{Drawing, Fault, LineClass, LineOptions, LinesError, Object, draw, objects_of_model};
use rimline_picture::Bounds;

use crate::failure::{Failure, InputError, UsageError};
use crate::film::{self, Claim};
use crate::info::Seams;
use crate::input::{Input, Shape};
use crate::output::{Folder, Output, note, say};
use crate::posed_input::{animations, note_idle_time};
use crate::progress::Progress;
use crate::target::Inputs;
use crate::{origin, shown};
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
    let (inputs, chosen) = read(args)?;
    let read = inputs.iter().flat_map(Input::files).map(Path::to_owned).chain(args.style.clone());
    let read = Inputs::new(read.collect::<Vec<PathBuf>>());
    (0..frames).try_for_each(|frame| read.spare(&file(frame)))?;
    if args.frames.is_some() {
        film::check_earlier(&args.out, frames, format.ending())?;
    }
    let mut output = Some(Output::create(&file(0))?);

    let is_moving = frames > 1 && chosen.iter().any(|playing| !playing.is_empty());
    let time_s = |frame: u32| args.pose.time + (f64::from(frame) / f64::from(args.fps)) as f32;
    let objects_at = |frame: u32| {
        let mut objects = Vec::new();
        for (input, playing) in inputs.iter().zip(&chosen) {
            objects.extend(objects_of(input, playing, time_s(frame), inputs.len() > 1)?);
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
    let bounds = Bounds::of(&corners).ok_or_else(|| Failure::input(&args.files[0])(InputError::NoFiniteFace))?;
    let still = Eye::new(args, origin, &corners, &bounds)?;
    drop(corners);
    let eye_of = |frame: u32| {
        let camera = inputs[0].camera(&args.camera, &chosen[0], time_s(frame))?;
        let eye = camera.map_or(Ok(still), |camera| Eye::of_camera(&camera, &bounds)).map_err(refused)?;
        eye.turned(args.turn * f64::from(frame) / f64::from(frames)).map_err(refused)
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
            return Err(Failure::input(&args.files[0])(InputError::NothingToDraw));
        }
        if frame == 0 && drawing.spans.iter().any(|span| span.class == LineClass::Boundary) {
            remarks.of_seams(&inputs);
        }
        let units = (format == Format::Dxf && args.dxf_units == DxfUnits::Model).then(|| eye.page_of_origin(origin));
        let mut sheet = Sheet::new(args, &style, &drawing, extent.window(args, &eye), units)?;
        if frame == 0 && sheet.is_crowded() {
            style.is_fine = true;
            sheet = Sheet::new(args, &style, &drawing, extent.window(args, &eye), units)?;
        }
        sheet.remarks.iter().for_each(|remark| remarks.say(remark.clone()));
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

/// The files of the drawings.
pub(crate) fn files(args: &LinesArgs) -> Result<Vec<PathBuf>, UsageError> {
    let format = Format::of(args)?;
    Ok(match args.frames {
        Some(frames) => (0..frames).map(|frame| film::frame_file(&args.out, frame, frames, format.ending())).collect(),
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
    fn say(&mut self, remark: String) {
        if !self.0.contains(&remark) {
            note(&remark);
            self.0.insert(remark);
        }
    }

    /// Says which objects are left out. Returns whether all are.
    fn of_drawing(&mut self, drawing: &Drawing, objects: usize) -> bool {
        for left_out in &drawing.left_out {
            self.say(format!("warning: `{}`: {}", left_out.name, left_out.fault));
        }
        let is_left_out = |object: usize| {
            let mut faults = drawing.left_out.iter().filter(|left_out| left_out.object == object);
            faults.any(|left_out| !matches!(left_out.fault, Fault::NoSuchEdge { .. }))
        };
        if (0..objects).all(is_left_out) {
            return true;
        }
        if drawing.spans.is_empty() {
            self.say("warning: no line of these classes is in sight".to_owned());
        }
        false
    }

    /// Says where boundaries are cracks that rounding left.
    fn of_seams(&mut self, inputs: &[Input]) {
        for input in inputs.iter().filter(|input| input.polygons().is_none()) {
            for geometry in input.model().geometries() {
                let seams = geometry.mesh().ok().and_then(|mesh| Seams::of(geometry, &mesh));
                if let Some(seams) = seams.filter(|seams| seams.closes > 0) {
                    self.say(format!("warning: {}: {}", input.file.display(), seams.text()));
                }
            }
        }
    }
}

/// A drawing, and all that the formats say of it.
pub(crate) struct Picture<'a> {
    args: &'a LinesArgs,
    eye: &'a Eye,
    objects: &'a [Object<'a>],
    drawing: &'a Drawing,
    sheet: &'a Sheet,
    origin: Origin,
}

impl Picture<'_> {
    /// The names of the files, without folders.
    fn title(&self) -> String {
        let name = |file: &PathBuf| file.file_name().unwrap_or(file.as_os_str()).to_string_lossy().into_owned();
        shown::Line(self.args.files.iter().map(name).collect::<Vec<_>>().join(", ")).to_string()
    }

    /// The view and the scale in a sentence.
    fn description(&self) -> String {
        format!("{}; {}", self.eye.said(self.args), self.sheet.scale_said(self.eye.view.is_perspective()))
    }
}

/// The files, and the animations of each that play.
fn read(args: &LinesArgs) -> Result<(Vec<Input>, Vec<Vec<usize>>), Failure> {
    let options = args.load.options(args.weld.weld());
    let mut inputs = Vec::with_capacity(args.files.len());
    for file in &args.files {
        inputs.push(Input::read(file, options, args.polygons.taken())?);
    }
    let chosen = animations(&inputs, &args.pose)?;
    origin::settle(&mut inputs, &chosen, args.pose.time)?;
    note_idle_time(&args.pose, &chosen.concat(), None);
    Ok((inputs, chosen))
}

/// The objects of a file. Where there are several files, their names begin with the file's.
fn objects_of(
    input: &Input,
    playing: &[usize],
    time_s: f32,
    is_prefixed: bool,
) -> Result<Vec<Object<'static>>, Failure> {
    let shape = input.shape(playing, time_s, false)?;
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

/// Without faces that are not finite, as long as there are others: a warning has counted them. Polygons stay as they are.
fn finite(object: Object<'static>) -> Result<Object<'static>, Failure> {
    let is_finite = |face: &&[u32; 3]| {
        face.iter()
            .all(|&vertex| object.positions.get(vertex as usize).is_some_and(|at| at.iter().all(|c| c.is_finite())))
    };
    let faces: Vec<[u32; 3]> = object.mesh.faces().iter().filter(is_finite).copied().collect();
    if faces.is_empty() || faces.len() == object.mesh.faces().len() || object.mesh.polygons().is_some() {
        return Ok(object);
    }
    let mesh = Mesh::from_faces(object.positions.len(), faces).map_err(rimline::ModelError::from)?;
    Ok(Object { mesh: Cow::Owned(mesh), ..object })
}

fn refused(file: &Path, error: LinesError) -> Failure {
    Failure::input(file)(InputError::Lines(error))
}
