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
use std::ops::ControlFlow;
use std::path::{Path, PathBuf};

use rimline::cpu::Threads;
use rimline::{Mesh, Origin};
use rimline_lines::{Drawing, Fault, LineOptions, LinesError, Object, draw, objects_of_model};

use crate::failure::{Failure, InputError};
use crate::input::{Input, Shape};
use crate::output::{Output, note, say};
use crate::posed_input::{animations, note_idle_time};
use crate::progress::Progress;
use crate::target::Inputs;
use crate::{origin, shown};
use args::LinesArgs;
use eye::Eye;
use format::Format;
use sheet::Sheet;
use style::Style;

pub(crate) fn run(args: &LinesArgs) -> Result<(), Failure> {
    let format = Format::of(args)?;
    args.check()?;
    let style = args.style.as_deref().map_or_else(|| Ok(Style::default()), style::read)?;
    let progress = Progress::start();
    progress.step("reading the models");
    let (inputs, chosen) = read(args)?;
    let read = inputs.iter().flat_map(Input::files).map(Path::to_owned).chain(args.style.clone());
    Inputs::new(read.collect::<Vec<PathBuf>>()).spare(&args.out)?;
    let output = Output::create(&args.out)?;

    let mut objects = Vec::new();
    for (input, playing) in inputs.iter().zip(&chosen) {
        objects.extend(objects_of(input, playing, args.pose.time, inputs.len() > 1)?);
    }
    let origin = inputs[0].origin();
    let eye = Eye::new(args, origin, &objects).map_err(|error| error.on(&args.files[0]))?;
    progress.step("finding lines");
    let options = LineOptions {
        classes: args.classes(),
        crease_degrees: args.crease,
        window: sheet::taken(args),
        memory_limit: Some(args.load.memory_limit),
        threads: Threads::all(),
        ..LineOptions::default()
    };
    let percent = |done: f64| format!("finding lines, {:.0} %", 100.0 * done);
    let drawing = draw(&objects, &eye.view, &options, |done, all| {
        progress.step(percent(done as f64 / (all as f64).max(1.0)));
        ControlFlow::Continue(())
    });
    let drawing = drawing.map_err(|error| refused(&args.files[0], error))?;
    for left_out in &drawing.left_out {
        note(&format!("warning: `{}`: {}", left_out.name, left_out.fault));
    }
    let is_left_out = |object: usize| {
        drawing
            .left_out
            .iter()
            .any(|left_out| left_out.object == object && !matches!(left_out.fault, Fault::NoSuchEdge { .. }))
    };
    if (0..objects.len()).all(is_left_out) {
        return Err(Failure::input(&args.files[0])(InputError::NothingToDraw));
    }
    if drawing.spans.is_empty() {
        note("warning: no line of these classes is in sight");
    }
    let sheet = Sheet::new(args, &style, &drawing, eye.view.is_perspective())?;
    progress.step("writing");
    output.finish(|file| {
        format.write(file, &Picture { args, eye: &eye, objects: &objects, drawing: &drawing, sheet: &sheet, origin })
    })?;
    drop(progress);
    say(&sheet.said(args))
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
        format!("{}; {}", self.eye.said(self.args), self.sheet.scale_said())
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
