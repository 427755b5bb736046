//! The objects and the eye of a drawing, at one moment or in the course of a film.

use std::borrow::Cow;
use std::collections::BTreeSet;
use std::ops::ControlFlow;
use std::path::Path;

use rimline::Mesh;
use rimline::cpu::Threads;
use rimline_lines::{Drawing, LineOptions, LinesError, Object, draw, objects_of_model};
use rimline_picture::Bounds;

use super::args::LinesArgs;
use super::eye::{self, Eye};
use super::sheet::{self, Extent};
use crate::coincident::is_finite;
use crate::failure::{Failure, NO_FINITE_FACE};
use crate::input::{Input, Shape};
use crate::output::Progress;

/// Moments that the eye of a film is chosen by.
const LOOKS: u32 = 12;

/// The models and the eye over all drawings.
pub(crate) struct Motion<'a> {
    args: &'a LinesArgs,
    inputs: &'a [Input],
    frames: u32,
    /// Whether objects move between drawings.
    is_moving: bool,
    /// The objects of the first drawing.
    first: Vec<Object<'static>>,
    /// The box around the objects at some moments.
    bounds: Bounds,
    /// The eye before it turns, unless a camera of the file is taken.
    still: Eye,
}

impl<'a> Motion<'a> {
    pub(crate) fn new(args: &'a LinesArgs, inputs: &'a [Input]) -> Result<Self, Failure> {
        let frames = args.frames.unwrap_or(1);
        let is_moving = frames > 1 && inputs.iter().any(|input| !input.playing.is_empty());
        let first = objects_at(args, inputs, 0)?;
        let mut corners = eye::corners(&first);
        let looks = if is_moving { LOOKS.min(frames) } else { 1 };
        for look in 1..looks {
            corners.extend(eye::corners(&objects_at(args, inputs, look * frames / looks)?));
        }
        let bounds = Bounds::of(&corners).ok_or_else(|| Failure::input(&args.files[0], NO_FINITE_FACE))?;
        let still = Eye::new(args, inputs[0].origin(), &corners, &bounds)?;
        inputs[0].warn_of_mirror(inputs[0].camera(&args.camera, time_s(args, 0))?.as_ref());
        Ok(Self { args, inputs, frames, is_moving, first, bounds, still })
    }

    pub(crate) fn objects(&self, frame: u32) -> Result<Cow<'_, [Object<'static>]>, Failure> {
        if self.is_moving && frame > 0 {
            objects_at(self.args, self.inputs, frame).map(Cow::Owned)
        } else {
            Ok(Cow::Borrowed(self.first.as_slice()))
        }
    }

    pub(crate) fn eye(&self, frame: u32) -> Result<Eye, Failure> {
        let Self { args, inputs, frames, bounds, still, .. } = self;
        let refused = |error: LinesError| refused(&args.files[0], error);
        let camera = inputs[0].camera(&args.camera, time_s(args, frame))?;
        let eye = camera.map_or(Ok(*still), |camera| Eye::of_camera(&camera, bounds)).map_err(refused)?;
        eye.turned(f64::from(args.turn) * f64::from(frame) / f64::from(*frames)).map_err(refused)
    }

    /// The part of the page that all drawings take.
    pub(crate) fn extent(&self) -> Result<Extent, Failure> {
        let mut extent = Extent::default();
        for frame in 0..self.frames {
            extent.add(self.args, &self.eye(frame)?, &self.objects(frame)?);
        }
        Ok(extent)
    }

    /// Finds the lines of objects. Says how far it is.
    pub(crate) fn drawing(
        &self,
        frame: u32,
        objects: &[Object<'_>],
        eye: &Eye,
        progress: &Progress,
    ) -> Result<Drawing, Failure> {
        let Self { args, frames, .. } = self;
        let what = if *frames == 1 { "finding lines".to_owned() } else { format!("drawing {} of {frames}", frame + 1) };
        progress.step(what.clone());
        let drawing = draw(objects, &eye.view, &options(args, eye), |done, all| {
            progress.step(format!("{what}, {:.0} %", 100.0 * done as f64 / (all as f64).max(1.0)));
            ControlFlow::Continue(())
        });
        drawing.map_err(|error| refused(&args.files[0], error))
    }
}

fn time_s(args: &LinesArgs, frame: u32) -> f32 {
    args.pose.time + (f64::from(frame) / f64::from(args.fps())) as f32
}

fn options(args: &LinesArgs, eye: &Eye) -> LineOptions {
    LineOptions {
        classes: args.classes(),
        crease_degrees: args.crease(),
        near: eye.near,
        window: sheet::taken(args, eye),
        memory_limit: Some(args.read.load.memory_limit),
        threads: Threads::all(),
    }
}

/// The objects of all files in a drawing.
fn objects_at(args: &LinesArgs, inputs: &[Input], frame: u32) -> Result<Vec<Object<'static>>, Failure> {
    let mut objects = Vec::new();
    for input in inputs {
        objects.extend(objects_of(input, time_s(args, frame), inputs.len() > 1)?);
    }
    tell_apart(&mut objects);
    Ok(objects)
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

/// Without faces that are not finite, as long as there are others: a warning has counted them. The others are numbered anew,
/// and so are edges. Polygons stay as they are.
fn finite(object: Object<'static>) -> Result<Object<'static>, Failure> {
    let faces = object.mesh.faces().iter().copied().filter(|face| is_finite(&object.positions, face));
    let faces: Vec<[u32; 3]> = faces.collect();
    if faces.is_empty() || faces.len() == object.mesh.faces().len() || object.mesh.polygons().is_some() {
        return Ok(object);
    }
    let mesh = Mesh::from_faces(object.positions.len(), faces).map_err(rimline::ModelError::from)?;
    Ok(Object { mesh: Cow::Owned(mesh), ..object })
}

fn refused(file: &Path, error: LinesError) -> Failure {
    Failure::input(file, error)
}
