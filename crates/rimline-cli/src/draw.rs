//! `rimline draw`: a model with its outline.

mod frame;
mod outline_picture;

use std::thread::{Builder, Scope, ScopedJoinHandle};

use rimline::gpu::{Extractor, ExtractorOptions, ListOptions, Use};
use rimline::{Mesh, MeshError, wgpu};
use rimline_picture::{Bounds, Camera, SceneBounds, corner_normals};
use serde_json::json;

use crate::args::DrawArgs;
use crate::camera::{camera, elevation};
use crate::coincident::{Coincident, corners, is_finite};
use crate::coordinates::add_origin;
use crate::device::{self, Gpu, GpuError, On as _, Wanted};
use crate::failure::{DRAW_ON_CPU, Failure, NO_AREA, NO_FINITE_FACE};
use crate::files::{Inputs, check_ending};
use crate::image::{Picture, check_bounds, check_model, check_size, too_large, wrote};
use crate::input::{PosedInput, Positions, Scene};
use crate::output::{Output, Progress, print, say};
use frame::Frame;
use outline_picture::{Canvas, LinePipelines, ModelPipelines};

/// Degrees that the eye is above the model by default.
const ELEVATION: f64 = 17.0;

/// Bytes of a pixel in the largest arrays: four samples of colour or depth.
const PIXEL_BYTES: u64 = 4 * 4;

pub(crate) fn run(args: &DrawArgs) -> Result<(), Failure> {
    let wanted = &args.posed.device.device;
    if *wanted == Wanted::Cpu {
        return Err(Failure::usage(DRAW_ON_CPU));
    }
    check_ending(&args.out, "png")?;
    let progress = Progress::start();
    progress.step("reading the model");
    let posed = PosedInput::read(&args.posed, &args.model)?;
    if !args.plain {
        posed.input.note_colors();
    }
    let scene = posed.scene()?;
    Inputs::new(posed.files()).spare(&args.out)?;
    let output = Output::create(&args.out)?;

    progress.step("opening the device");
    let gpu = device::open_gpu(wanted)?;
    check_size(&gpu, args.view.size, 4)?;
    check_model(&gpu, scene.mesh.faces().len(), scene.mesh.vertex_count() as usize).on(&gpu)?;
    let picture = draw(args, &gpu, &posed, &scene, &progress)?;
    gpu.check()?;
    progress.step("writing");
    output.finish(|file| picture.write_png(file, None))?;
    drop(progress);
    if !args.json {
        return say(&format!("{}\n", wrote(&args.out, args.view.size)));
    }
    let (vertices, faces) = (scene.mesh.vertex_count(), scene.mesh.face_count());
    let mut report = json!({
        "adapter": device::describe(&gpu.info), "out": args.out.display().to_string(), "size": args.view.size,
        "vertices": vertices, "faces": faces,
    });
    add_origin(&mut report, posed.input.origin());
    print(&format!("{report:#}\n"))
}

/// Draws the picture. Shaders compile on threads of their own, but with OpenGL, and each part of the picture is submitted as
/// soon as those that it needs are there: drivers compile further when shaders first run.
fn draw(
    args: &DrawArgs,
    gpu: &Gpu,
    posed: &PosedInput<'_>,
    scene: &Scene<'_>,
    progress: &Progress,
) -> Result<Picture, Failure> {
    let factory = outline_picture::factory(gpu);
    std::thread::scope(|scope| {
        let model_pipelines = Made::by(scope, gpu, || ModelPipelines::new(&factory));
        let line_pipelines = Made::by(scope, gpu, || {
            if scene.mesh.polygons().is_none() {
                // A refusal of the device is reported where the pipeline is needed.
                let _ = gpu.pipelines.warm_up(&[Use::Extraction(&options())]);
            }
            LinePipelines::new(&factory)
        });
        let positions = Positions::new(gpu, &scene.shape, posed.displacement.as_ref()).on(gpu)?;
        positions.submit(gpu, &scene.shape, posed.time_s()).on(gpu)?;
        // The camera and the normals need positions here; the silhouette stays on the GPU.
        let world = positions.read(gpu, &scene.shape).on(gpu)?;

        progress.step("drawing");
        let mut drawn = DrawnFaces::of(args, posed, scene, &world);
        let (bounds, camera) = bounds_and_camera(args, posed, scene, drawn.points(&world))?;
        let sheet = coincident_faces(&world, &mut drawn, &camera);
        let sheet = sheet.map_err(|error| Failure::input(&posed.input.file, error))?;
        let outlined = sheet.as_ref().filter(|_| scene.mesh.polygons().is_none()).unwrap_or(&scene.mesh);

        let survey_scale = outline_picture::survey_scale(args.view.size, gpu.device.limits().max_texture_dimension_2d);
        let flags = [args.show_boundary, drawn.colors.is_some()];
        let frame = Frame::new(&camera, args.view.size, &bounds, survey_scale, flags);
        let scope = gpu.device.push_error_scope(wgpu::ErrorFilter::OutOfMemory);
        let record = || {
            let canvas = Canvas::new(&factory, (&frame, &bounds), args.view.size);
            let mut encoder = gpu.encoder("model");
            let (normals, buffer) = (corner_normals(&world, &drawn.faces), positions.buffer().buffer);
            let corners = (&*drawn.faces, &*normals, drawn.colors.as_deref());
            let faces = canvas.model(&mut encoder, &model_pipelines.get(), buffer, corners);
            gpu.submit(encoder);

            let mut extractor = Extractor::new(&gpu.pipelines, outlined, options())?;
            let mut encoder = gpu.encoder("silhouette");
            let extraction = extractor.encode(&mut encoder, positions.buffer(), &[camera.eye_light()])?;
            gpu.submit(encoder);

            let mut encoder = gpu.encoder("lines");
            let texture = canvas.lines(&mut encoder, &line_pipelines.get(), &extraction, [buffer, &faces])?;
            gpu.submit(encoder);
            Ok(texture)
        };
        let texture: Result<wgpu::Texture, GpuError> = record();
        if pollster::block_on(scope.pop()).is_some() {
            return Err(too_large(gpu, args.view.size, PIXEL_BYTES));
        }
        Picture::read(gpu, &texture.on(gpu)?).on(gpu)
    })
}

/// Lines are blended in the order of the list, so that order makes each run draw the same bytes.
fn options() -> ExtractorOptions {
    ExtractorOptions {
        lists: Some(ListOptions { ordered: true, ..ListOptions::default() }),
        ..ExtractorOptions::default()
    }
}

/// A value that another thread makes. Where none starts, this one has made it. With OpenGL, too: a thread that waits long for the
/// context panics in wgpu.
enum Made<'scope, T> {
    Here(T),
    There(ScopedJoinHandle<'scope, T>),
}

impl<'scope, T: Send + 'scope> Made<'scope, T> {
    fn by(scope: &'scope Scope<'scope, '_>, gpu: &Gpu, make: impl Fn() -> T + Copy + Send + 'scope) -> Self {
        let is_shared = gpu.info.backend != wgpu::Backend::Gl;
        let thread = is_shared.then(|| Builder::new().spawn_scoped(scope, make).ok()).flatten();
        thread.map_or_else(|| Self::Here(make()), Self::There)
    }

    fn get(self) -> T {
        match self {
            Self::Here(made) => made,
            Self::There(thread) => thread.join().unwrap_or_else(|panic| std::panic::resume_unwind(panic)),
        }
    }
}

/// The faces that are drawn, and a base colour for each of their corners.
struct DrawnFaces {
    faces: Vec<[u32; 3]>,
    colors: Option<Vec<[u32; 3]>>,
}

impl DrawnFaces {
    /// The faces with finite positions.
    fn of(args: &DrawArgs, posed: &PosedInput<'_>, scene: &Scene<'_>, world: &[[f32; 3]]) -> Self {
        let is_drawn = |face: &[u32; 3]| is_finite(world, face);
        let faces = scene.mesh.faces();
        let colors = if args.plain { None } else { posed.input.corner_colors(&scene.shape) };
        let colors = colors.map(|colors| {
            let drawn = colors.into_iter().zip(faces).filter(|(_, face)| is_drawn(face));
            drawn.map(|(colors, _)| colors).collect()
        });
        Self { faces: faces.iter().copied().filter(is_drawn).collect(), colors }
    }

    /// The positions of their corners.
    fn points<'a>(&'a self, world: &'a [[f32; 3]]) -> impl Iterator<Item = [f32; 3]> + Clone + 'a {
        corners(world, &self.faces).flatten()
    }
}

/// The box around `points`, and a camera that sees them.
fn bounds_and_camera(
    args: &DrawArgs,
    posed: &PosedInput<'_>,
    scene: &Scene<'_>,
    points: impl Iterator<Item = [f32; 3]> + Clone,
) -> Result<(Bounds, Camera), Failure> {
    let file = &posed.input.file;
    let none = if scene.mesh.faces().is_empty() { NO_AREA } else { NO_FINITE_FACE };
    let bounds = Bounds::of(points.clone()).ok_or_else(|| Failure::input(file, none))?;
    check_bounds(&bounds).map_err(|error| Failure::input(file, error))?;
    let view = posed.input.view(&args.view, posed.time_s())?;
    let mut camera = camera(&view, elevation(ELEVATION, &bounds), &bounds, points)?;
    if view.camera.is_some() {
        // The ground has less than an extent around the model.
        let stage = SceneBounds { models: bounds, ground: bounds.min.y };
        camera = camera.with_nearer_far_plane(&stage, 1.0);
    }
    Ok((bounds, camera))
}

/// Where faces coincide with turned ones, leaves those that are turned away from the eye out of the faces to draw, and
/// returns a mesh of the surface without its second side. Else an edge between the sides of one face would be on the
/// outline.
fn coincident_faces(world: &[[f32; 3]], drawn: &mut DrawnFaces, camera: &Camera) -> Result<Option<Mesh>, MeshError> {
    let DrawnFaces { faces, colors } = drawn;
    let Some(found) = Coincident::of(corners(world, faces)) else { return Ok(None) };
    let numbered = || faces.iter().copied().enumerate();
    let one_sided = numbered().filter(|&(number, _)| found.is_first(number)).map(|(_, face)| face).collect();
    let sheet = Mesh::from_faces(world.len(), one_sided)?;
    let is_seen = |(number, corners)| found.seen_instead(number, corners, camera.distant_eye()).is_none();
    let are_seen: Vec<bool> = corners(world, faces).enumerate().map(is_seen).collect();
    for list in [Some(faces), colors.as_mut()].into_iter().flatten() {
        let mut are_seen = are_seen.iter();
        list.retain(|_| are_seen.next() != Some(&false));
    }
    Ok(Some(sheet))
}
