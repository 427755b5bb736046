//! `rimline film`: an animation with its shadows, as numbered pictures, or as one file that moves.

mod clip;
mod folder;

use std::path::Path;

use rimline::gpu::ShadowStatistics;
use serde_json::json;

use crate::camera::swept;
use crate::device::{Gpu, On as _, describe};
use crate::failure::Failure;
use crate::image::Picture;
use crate::input::{Input, note_idle_time, settle};
use crate::output::{Progress, note, print, say};
use crate::shadow;
use crate::shadow::args::{FilmArgs, MAX_FRAMES};
use crate::shadow::casters::Casters;
use crate::shadow::casting::PosedModel;
use crate::shadow::pictures::Pictures;
use crate::shadow::shadow_scene::{ShadowInputs, ShadowScene, open_gpu, take_first_animation};
use crate::shadow::shadows::{RenderResources, ShadowMethod, each, warn_of_limits};
use clip::{Clip, Format};
use folder::Frames;
pub(crate) use folder::{Claim, check_earlier, frame_file, remove_earlier};

/// Moments that the camera is chosen by: it must see all of the motion.
const LOOKS: u32 = 12;

/// How long a film lasts in which only the camera moves.
const ORBIT_SECONDS: f32 = 4.0;

pub(crate) fn run(args: &FilmArgs) -> Result<(), Failure> {
    let scene = &args.scene;
    scene.check()?;
    let mut film = begin(args)?;
    let progress = Progress::start();
    progress.step("reading the models");
    let props = read(args)?;
    let frames = frames(args, &props)?;
    film.start(frames, &props.files(scene).collect::<Vec<_>>())?;

    progress.step("opening the device");
    let gpu = open_gpu(scene)?;
    let method = ShadowMethod { counting: scene.method, from_depth: None };
    let _compiling = method.compile(&gpu);
    progress.step("looking at the motion");
    let mut bodies = props.bodies(&gpu, scene)?;
    let points = points_in_motion(args, &gpu, &mut bodies, frames)?;
    let mut set = ShadowScene::new(scene, bodies, &points, args.orbit.is_some(), None)?;
    let (first, axis) = (set.camera, set.orbit_axis());
    let resources = RenderResources::new(&gpu, scene.view.size, set.samples());
    let pictures = Pictures::new(&resources, &method, scene.mode, scene.volumes, set.is_in_parts()).on(&gpu)?;
    drop(progress);

    let progress = Progress::pictures(u64::from(frames));
    let mut casters = Casters::new(&resources, &pictures.pipelines, set.samples(), scene.volumes).on(&gpu)?;
    let mut most: ShadowStatistics = bytemuck::Zeroable::zeroed();
    for frame in 0..frames {
        if film.has(frame) {
            progress.picture_done();
            continue;
        }
        let time = time_of(args, frame);
        let still = set.camera_at(time)?.unwrap_or(first);
        let turn = |degrees| still.turned(axis, f64::from(degrees) * f64::from(frame) / f64::from(frames));
        set.camera = args.orbit.map_or(still, turn);
        set.pose(&gpu, time)?;
        casters.set_bodies(&set.bodies)?;
        set.cast(&mut casters, None).on(&gpu)?;
        set.count_layers(&mut casters)?;
        let picture = shadow::picture(&pictures, &mut set, &mut casters, None).on(&gpu)?;
        let found = casters.shadows.statistics().on(&gpu)?;
        most = each(most, found, u32::max);
        gpu.check()?;
        film.write(frame, &picture)?;
        progress.picture_done();
    }
    drop(progress);
    warn_of_limits(most);
    set.warn_of_depth(&gpu);
    let said = film.finish(frames)?;
    if args.json {
        return print(&report(args, &gpu, frames));
    }
    let [width, height] = scene.view.size;
    say(&format!("{said} ({width}×{height})\n"))
}

fn begin(args: &FilmArgs) -> Result<Box<dyn Film + '_>, Failure> {
    Ok(match Format::of(&args.out) {
        Some(format) => Box::new(Clip::begin(args, format)?),
        None => Box::new(Frames::begin(args)?),
    })
}

/// Reads the models, and says which options have no effect on them.
fn read(args: &FilmArgs) -> Result<ShadowInputs, Failure> {
    let pose = &args.scene.posed.pose;
    let mut props = ShadowInputs::read(&args.scene)?;
    if pose.animations.is_empty() && props.displacement.is_none() {
        props.inputs.iter_mut().for_each(take_first_animation);
    }
    settle(&mut props.inputs, pose.time)?;
    let is_moving = props.is_moving();
    note_idle_time(pose, is_moving);
    if !is_moving && args.fps.is_some() && args.frames.is_some() && Format::of(&args.out).is_none() {
        note("warning: --fps has no effect on numbered pictures where only the camera moves, as --frames counts them");
    }
    Ok(props)
}

/// The time of a picture.
fn time_of(args: &FilmArgs, frame: u32) -> f32 {
    args.scene.posed.pose.time + (f64::from(frame) / f64::from(args.fps())) as f32
}

/// Points that the camera must see: those of the bodies at some times of the film, for an orbit at all turns.
fn points_in_motion(
    args: &FilmArgs,
    gpu: &Gpu,
    bodies: &mut [PosedModel<'_>],
    frames: u32,
) -> Result<Vec<[f32; 3]>, Failure> {
    let looks = LOOKS.min(frames);
    let mut points = Vec::new();
    for look in 0..looks {
        let frame = u64::from(look) * u64::from(frames) / u64::from(looks);
        let time = time_of(args, frame as u32);
        bodies.iter_mut().try_for_each(|body| body.pose(gpu, time))?;
        points.extend(bodies.iter().flat_map(PosedModel::points));
    }
    Ok(if args.orbit.is_some() { swept(&points, None) } else { points })
}

fn report(args: &FilmArgs, gpu: &Gpu, frames: u32) -> String {
    let report = json!({
        "adapter": describe(&gpu.info), "out": args.out.display().to_string(), "frames": frames, "fps": args.fps(),
        "size": args.scene.view.size,
    });
    format!("{report:#}\n")
}

trait Film {
    /// Begins before the first of so many pictures of models in these files. Refuses to replace one of them.
    fn start(&mut self, frames: u32, files: &[&Path]) -> Result<(), Failure>;

    /// Whether a picture is there and stays.
    fn has(&self, _frame: u32) -> bool {
        false
    }

    fn write(&mut self, frame: u32, picture: &Picture) -> Result<(), Failure>;

    /// Completes it. Returns what was written, in words.
    fn finish(self: Box<Self>, frames: u32) -> Result<String, Failure>;
}

/// How many pictures are asked for, or make up the longest animation.
fn frames(args: &FilmArgs, props: &ShadowInputs) -> Result<u32, Failure> {
    if let Some(frames) = args.frames {
        return Ok(frames);
    }
    let duration = |input: &Input| {
        let animations = input.asset()?.animations();
        input.playing.iter().filter_map(|&index| Some(animations.get(index)?.duration_s)).reduce(f32::max)
    };
    let lasts = props.inputs.iter().filter_map(duration).reduce(f32::max);
    let seconds = args.seconds.or(lasts).or(args.orbit.map(|_| ORBIT_SECONDS)).ok_or_else(|| {
        Failure::usage(if props.displacement.is_some() {
            "a film with --displace needs a length; give --frames or --seconds, or name an --animation"
        } else {
            "no file has an animation, so nothing moves; give --orbit 360 to lead the camera around, or --displace, or \
             the number of pictures with --frames"
        })
    })?;
    let frames = (f64::from(seconds) * f64::from(args.fps())).round().max(1.0);
    if frames > MAX_FRAMES as f64 {
        return Err(Failure::usage(format!(
            "a film of {} pictures is too long; at most {MAX_FRAMES} are written",
            frames as u64
        )));
    }
    Ok(frames as u32)
}
