//! The objects and the eye of a drawing, at one moment or in the course of a film.

use std::borrow::Cow;
use std::collections::{BTreeSet, HashMap};
use std::ops::{ControlFlow, Deref};
use std::path::Path;

use rimline::Mesh;
use rimline::cpu::Threads;
use rimline_lines::{Drawing, LineOptions, LinesError, Object, draw, objects_of_model};
use rimline_picture::Bounds;

use super::args::LinesArgs;
use super::eye::{self, Eye};
use super::sheet::{self, Extent};
use crate::coincident::is_finite;
use crate::failure::{EYE_TOO_FAR, Failure, NO_FINITE_FACE};
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
    first: Objects,
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

    pub(crate) fn objects(&self, frame: u32) -> Result<Cow<'_, Objects>, Failure> {
        if self.is_moving && frame > 0 {
            objects_at(self.args, self.inputs, frame).map(Cow::Owned)
        } else {
            Ok(Cow::Borrowed(&self.first))
        }
    }

    pub(crate) fn eye(&self, frame: u32) -> Result<Eye, Failure> {
        let Self { args, inputs, frames, bounds, still, .. } = self;
        let refused = |error: LinesError| refused(&args.files[0], error);
        let camera = inputs[0].camera(&args.camera, time_s(args, frame))?;
        let eye = camera.map_or(Ok(*still), |camera| Eye::of_camera(&camera, bounds)).map_err(refused)?;
        let degrees = f64::from(args.turn) * f64::from(frame) / f64::from(*frames);
        // An eye that sees a page still does when it is turned, if numbers can say where it is.
        eye.turned(degrees).map_err(|_| Failure::usage(EYE_TOO_FAR))
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
        objects: &Objects,
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
        let mut drawing = drawing.map_err(|error| refused(&args.files[0], error))?;
        objects.number(&mut drawing);
        Ok(drawing)
    }
}

/// The objects of a drawing.
#[derive(Clone)]
pub(crate) struct Objects {
    list: Vec<Object<'static>>,
    /// Only objects that lost faces have some.
    numbers: Vec<Option<Numbers>>,
}

/// The numbers in a whole mesh of what is left of it.
#[derive(Clone)]
struct Numbers {
    faces: Vec<u32>,
    /// For each edge record the first one of its edge.
    edges: Vec<Option<u32>>,
}

impl Deref for Objects {
    type Target = [Object<'static>];

    fn deref(&self) -> &Self::Target {
        &self.list
    }
}

impl Objects {
    /// Gives edges and faces their numbers in the whole meshes.
    fn number(&self, drawing: &mut Drawing) {
        let numbers = |object: u32| self.numbers.get(object as usize).and_then(Option::as_ref);
        for span in &mut drawing.spans {
            if let Some(numbers) = numbers(span.object) {
                span.edge = span.edge.and_then(|edge| numbers.edges.get(edge as usize).copied().flatten());
            }
            for face in span.faces.iter_mut().flatten() {
                let number = numbers(face.object).and_then(|numbers| numbers.faces.get(face.face as usize).copied());
                face.face = number.unwrap_or(face.face);
            }
        }
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
fn objects_at(args: &LinesArgs, inputs: &[Input], frame: u32) -> Result<Objects, Failure> {
    let (mut list, mut numbers) = (Vec::new(), Vec::new());
    for input in inputs {
        for object in objects_of(input, time_s(args, frame), inputs.len() > 1)? {
            let (object, of_object) = finite(object)?;
            list.push(object);
            numbers.push(of_object);
        }
    }
    tell_apart(&mut list);
    Ok(Objects { list, numbers })
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
fn finite(object: Object<'static>) -> Result<(Object<'static>, Option<Numbers>), Failure> {
    let kept = (0..).zip(object.mesh.faces()).filter(|(_, face)| is_finite(&object.positions, face));
    let (numbers, faces): (Vec<u32>, Vec<[u32; 3]>) = kept.map(|(number, &face)| (number, face)).unzip();
    if faces.is_empty() || faces.len() == object.mesh.faces().len() || object.mesh.polygons().is_some() {
        return Ok((object, None));
    }
    let mesh = Mesh::from_faces(object.positions.len(), faces).map_err(rimline::ModelError::from)?;
    let numbers = Numbers { faces: numbers, edges: first_records(&mesh, &object.mesh) };
    Ok((Object { mesh: Cow::Owned(mesh), ..object }, Some(numbers)))
}

/// The first record in the whole mesh of the edge of each record of a part of it.
fn first_records(part: &Mesh, whole: &Mesh) -> Vec<Option<u32>> {
    let sorted = |[a, b]: [u32; 2]| [a.min(b), a.max(b)];
    let mut first = HashMap::new();
    for (record, &edge) in (0_u32..).zip(whole.edges().vertices()) {
        first.entry(sorted(edge)).or_insert(record);
    }
    part.edges().vertices().iter().map(|&edge| first.get(&sorted(edge)).copied()).collect()
}

fn refused(file: &Path, error: LinesError) -> Failure {
    Failure::input(file, error)
}
