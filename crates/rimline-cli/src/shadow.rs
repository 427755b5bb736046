//! `rimline shadow`: models with their shadows.

pub(crate) mod args;
pub(crate) mod casters;
pub(crate) mod casting;
mod depth_shadows;
pub(crate) mod from_depth;
mod layers;
mod light_maps;
pub(crate) mod pictures;
mod report;
mod scene_shadows;
pub(crate) mod shadow_scene;
pub(crate) mod shadows;

use std::time::Instant;

use rimline::gpu::StageTimer;
use rimline::{Light, Origin, ShadowCamera};
use rimline_picture::PARTS;

use crate::device::{Gpu, GpuError, On as _};
use crate::failure::Failure;
use crate::files::Inputs;
use crate::image::Picture;
use crate::input::{Input, note_idle_time, settle};
use crate::output::{Filled, Output, Progress, print, say};
use crate::report::Times;
use args::{ShadowArgs, not_orthographic};
use casters::Casters;
use casting::{CastInputs, Occlusion, PosedModel};
use from_depth::FromDepth;
use pictures::{DrawInputs, Masks, Pictures};
use report::{Report, ResultFiles};
pub(crate) use report::{are_written, files};
use shadow_scene::{ShadowInputs, ShadowScene};
use shadows::{RenderResources, ShadowMethod, VolumePipelines, warn_of_limits};

pub(crate) fn run(args: &ShadowArgs) -> Result<(), Failure> {
    let scene = &args.scene;
    ResultFiles::check(args)?;
    args.check()?;
    let progress = Progress::start();
    let mut times = Times::default();
    progress.step("reading the models");
    let mut props = times.measure("load", || ShadowInputs::read(scene))?;
    let origin = times.measure("load", || settle(&mut props.inputs, scene.posed.pose.time))?;
    note_idle_time(&scene.posed.pose, props.is_moving());
    let from_depth = times.measure("load", || FromDepth::of(args, origin))?;
    let given = from_depth.as_ref().and_then(|from| from.given.as_deref());
    let inputs = Inputs::new(props.files(scene).chain(args.depth.as_deref()));
    let mut files = ResultFiles::begin(args, &inputs)?;

    progress.step("opening the device");
    let gpu = times.measure("device", || shadow_scene::open_gpu(scene))?;
    let method = ShadowMethod { counting: scene.method, from_depth: from_depth.clone() };
    let _compiling = method.compile(&gpu);
    progress.step("placing the models");
    let bodies = times.measure("topology", || props.bodies(&gpu, scene))?;
    let points: Vec<[f32; 3]> = bodies.iter().flat_map(PosedModel::points).collect();
    let mut set = ShadowScene::new(scene, bodies, &points, false, given.map(|map| map.cameras.light()))?;
    check_set(args, from_depth.as_ref(), &set, origin)?;
    files.begin_lights(args, &inputs, set.shaded_lights.len())?;

    progress.step("drawing");
    let begin = Instant::now();
    let resources = RenderResources::new(&gpu, scene.view.size, set.samples());
    let drawing = Drawing::new(args, &resources, &method, &set)?;
    let Some(pipelines) = drawing.pipelines() else { return Ok(()) };
    let shows_volumes = scene.volumes && drawing.pictures.is_some();
    let mut casters = Casters::new(&resources, pipelines, set.samples(), shows_volumes).on(&gpu)?;
    times.add("pipelines", begin.elapsed().as_secs_f64() * 1e3);
    times.measure("topology", || casters.set_bodies(&set.bodies))?;
    let occlusion =
        args.hide_covered.then(|| leave_out_occluded(&set, &mut casters, &mut times, &progress)).transpose()?;
    progress.step("drawing");
    // Times are for those who ask for them; all others would wait for the work twice.
    if args.json {
        times.measure("compile", || {
            warm_up(&gpu, pipelines, &set.camera.shadow_camera(), (&set.bodies, &set.ranged()))
        })?;
    }
    cast(&mut set, &mut casters, &mut times, &progress)?;
    if args.json {
        times.measure("compile", || drawing.trial(&gpu, &set.trial(&casters)))?;
    }
    drawing.write(&mut files, &mut set, &mut casters, &mut times, &progress)?;
    write_maps(&mut files, &casters, origin)?;
    let report = Report::read(&set, &casters, occlusion.as_ref()).on(&gpu)?;
    gpu.check()?;
    Filled::finish_all(std::mem::take(&mut files.filled))?;
    drop(progress);
    warn_of_limits(report.all);
    set.warn_of_depth(&gpu);
    if args.json {
        return print(&report.json(scene, &times));
    }
    say(&report.text(&files.names, scene.view.size, &times))
}

/// Refuses lights, cameras and models that do not go together with depth maps or occluded faces.
fn check_set(
    args: &ShadowArgs,
    from_depth: Option<&FromDepth>,
    set: &ShadowScene<'_>,
    origin: Origin,
) -> Result<(), Failure> {
    let given = from_depth.and_then(|from| from.given.as_deref());
    if from_depth.is_some() && set.camera.far.is_some() {
        return Err(not_orthographic(if given.is_some() { "--depth" } else { "--from-depth" }));
    }
    given.map_or(Ok(()), |map| from_depth::check_lights(map, &set.shaded_lights, &set.stage, origin))?;
    check_occlusion(args, set)?;
    from_depth.map_or(Ok(()), |from| from.check(&set.ranged(), &set.bodies))
}

fn check_occlusion(args: &ShadowArgs, set: &ShadowScene<'_>) -> Result<(), Failure> {
    let Some(body) = set.bodies.iter().find(|body| args.hide_covered && body.has_polygons()) else { return Ok(()) };
    Err(Failure::usage(format!(
        "--hide-covered takes triangles, and {} has polygons; cut its faces into triangles, as those of an .obj are \
         without --polygons, or leave out --hide-covered",
        body.input.file.display()
    )))
}

/// Finds the occluded faces, which then cast no shadows.
fn leave_out_occluded(
    set: &ShadowScene<'_>,
    casters: &mut Casters<'_>,
    times: &mut Times,
    progress: &Progress,
) -> Result<Occlusion, Failure> {
    progress.step("looking for occluded faces");
    let found = times.measure("occluded_faces", || Occlusion::find(&set.bodies, &set.ranged()))?;
    casters.leave_out(&set.bodies, &found)?;
    Ok(found)
}

/// Runs the stages of extraction and shadow volumes with a triangle, so that shaders are compiled before stages are timed.
/// Depth maps of the lights have the cameras that they have for the bodies `seen`: one map or six, so that no other stages
/// run than for these.
fn warm_up(
    gpu: &Gpu,
    pipelines: &VolumePipelines,
    camera: &ShadowCamera,
    (seen, lights): (&[PosedModel<'_>], &[Light]),
) -> Result<(), Failure> {
    let Some(input) = Input::triangle() else { return Ok(()) };
    let body = [PosedModel::new(gpu, &input, 0.0, None, true)?];
    let mut shadows = casters::shadows(gpu, pipelines, lights.len()).on(gpu)?;
    shadows.set_bodies(&body)?;
    let mut encoder = gpu.encoder("warm up");
    shadows.encode(&mut encoder, CastInputs { bodies: &body, seen, camera, lights }, None).on(gpu)?;
    gpu.submit(encoder);
    gpu.wait()
}

/// Casts the shadows, and waits for them. Warns of depth maps that take long to draw.
fn cast(
    set: &mut ShadowScene<'_>,
    casters: &mut Casters<'_>,
    times: &mut Times,
    progress: &Progress,
) -> Result<(), Failure> {
    let gpu = casters.gpu();
    let mut timer = StageTimer::new(&gpu.device, &gpu.queue);
    let begin = Instant::now();
    set.cast(casters, timer.as_mut()).on(gpu)?;
    gpu.wait()?;
    let all_stages = begin.elapsed().as_secs_f64() * 1e3;
    set.count_layers(casters)?;
    if let Some(found) = casters.shadows.depths_found().on(gpu)?
        && let Some(step) = found.warn_if_busy(progress)
    {
        progress.step(step);
    }
    times.add_stages(gpu, timer.as_ref(), all_stages).on(gpu)
}

/// The pipelines and targets of what is drawn: a picture, masks, or both.
struct Drawing {
    pictures: Option<Pictures>,
    masks: Option<Masks>,
}

impl Drawing {
    fn new(
        args: &ShadowArgs,
        resources: &RenderResources<'_>,
        method: &ShadowMethod,
        set: &ShadowScene<'_>,
    ) -> Result<Self, Failure> {
        let scene = &args.scene;
        let pictures = |_| Pictures::new(resources, method, scene.mode, scene.volumes, set.is_in_parts());
        let pictures = args.out.as_ref().map(pictures).transpose().on(resources.gpu)?;
        let masks = args.mask.as_ref().map(|_| Masks::new(resources, method)).transpose().on(resources.gpu)?;
        Ok(Self { pictures, masks })
    }

    /// `None`: nothing is drawn.
    fn pipelines(&self) -> Option<&VolumePipelines> {
        let of_pictures = self.pictures.as_ref().map(|pictures| &pictures.pipelines);
        of_pictures.or(self.masks.as_ref().map(|masks| &masks.pipelines))
    }

    /// Draws once, and shows it to nobody, so that the driver has compiled everything before times are taken.
    fn trial(&self, gpu: &Gpu, subject: &DrawInputs<'_>) -> Result<(), Failure> {
        let Self { pictures, masks } = self;
        let mut encoder = gpu.encoder("trial");
        pictures.as_ref().map_or(Ok(()), |pictures| pictures.record(&mut encoder, subject, 0)).on(gpu)?;
        masks.as_ref().map_or(Ok(()), |masks| masks.record(&mut encoder, subject, 0).map(drop)).on(gpu)?;
        gpu.submit(encoder);
        gpu.wait()
    }

    /// Draws the picture, then the masks, and fills their files.
    fn write(
        &self,
        files: &mut ResultFiles,
        set: &mut ShadowScene<'_>,
        casters: &mut Casters<'_>,
        times: &mut Times,
        progress: &Progress,
    ) -> Result<(), Failure> {
        let gpu = casters.gpu();
        if let (Some(pictures), Some(output)) = (&self.pictures, files.picture.take()) {
            let draw = || picture(pictures, set, casters, Some(progress));
            let picture = times.measure("picture", draw).on(gpu)?;
            gpu.check()?;
            files.filled.push(output.fill(|file| picture.write_png(file, None))?);
        }
        let Some(masks) = &self.masks else { return Ok(()) };
        for (light, file) in files.masks.drain(..).enumerate() {
            let draw = || mask(masks, &set.subject(casters), set.samples_of(light));
            let mask = times.measure("masks", draw).on(gpu)?;
            gpu.check()?;
            files.filled.push(Output::create(&file)?.fill(|to| mask.write_png(to, None))?);
        }
        Ok(())
    }
}

/// Fills the files of the lights' depth maps.
fn write_maps(files: &mut ResultFiles, casters: &Casters<'_>, origin: Origin) -> Result<(), Failure> {
    let gpu = casters.gpu();
    for (light, file) in files.maps.drain(..).enumerate() {
        if let Some(maps) = casters.shadows.saved_maps(light, origin).on(gpu)? {
            gpu.check()?;
            files.filled.push(Output::create(&file)?.fill(|to| maps.write(to))?);
        }
    }
    Ok(())
}

/// Draws and reads a picture of what was encoded and submitted, in parts if it has them; what was encoded is the same
/// afterwards.
pub(crate) fn picture(
    pictures: &Pictures,
    set: &mut ShadowScene<'_>,
    casters: &mut Casters<'_>,
    progress: Option<&Progress>,
) -> Result<Picture, GpuError> {
    let gpu = casters.gpu();
    let mut encoder = gpu.encoder("picture");
    if set.is_in_parts() {
        for part in 0..PARTS {
            set.take_part(Some(part));
            set.encode_lights(&mut encoder, casters, None)?;
            pictures.record(&mut encoder, &set.subject(casters), part)?;
            gpu.submit(std::mem::replace(&mut encoder, gpu.encoder("picture")));
            if let Some(progress) = progress.filter(|progress| progress.is_shown()) {
                // Commands are recorded long before they run.
                let _ = gpu.device.poll(rimline::wgpu::PollType::wait_indefinitely());
                progress.step(format!("drawing, {} %", 100 * (part + 1) / PARTS));
            }
        }
        set.take_part(None);
        set.encode_lights(&mut encoder, casters, None)?;
    } else {
        pictures.record(&mut encoder, &set.subject(casters), 0)?;
    }
    let texture = pictures.develop(&mut encoder, casters.resources);
    gpu.submit(encoder);
    Picture::read(gpu, texture)
}

/// A light's mask: the mean of its samples'.
fn mask(masks: &Masks, subject: &DrawInputs<'_>, samples: std::ops::Range<usize>) -> Result<Picture, GpuError> {
    let gpu = subject.casters.gpu();
    let mut pictures = Vec::with_capacity(samples.len());
    for light in samples {
        let mut encoder = gpu.encoder("mask");
        let texture = masks.record(&mut encoder, subject, light)?;
        gpu.submit(encoder);
        pictures.push(Picture::read(gpu, texture)?);
    }
    Ok(Picture::mean(pictures))
}
