//! Counting methods against each other over paths of cameras: time of the stencil pass and of the whole frame, and wrong
//! pixels.

pub(crate) mod scene;
mod truth;

use rimline::Counting;
use rimline::gpu::{ShadowFormat, ShadowPipelines};
use serde_json::json;
use wgpu::TextureAspect;

use crate::engine::{Contender, Metric, Rounds, times};
use crate::gpu::{Gpu, Stopwatch};
use crate::record::{
    Camera, Casters, DEPTH, Drawn, IDENTITY, STENCIL, SceneRecorder, Setting, Surface, Surfaces, made_anew,
};
use crate::row::{Row, Section, Variant, compare};
use crate::shapes::Shape;
use crate::{Error, Host};
use scene::Path;
use truth::Truth;

pub(crate) const Z_PASS: &str = "z-pass";

/// The counting methods that are compared.
const METHODS: [(&str, &str, Counting, usize, usize); 5] = [
    (Z_PASS, "z-pass", Counting::ZPass, 6, 2),
    ("z-fail", "z-fail", Counting::ZFail, 0, 1),
    ("zp+paper", "ZP+ as published", Counting::ZpPlus2005, 1, 4),
    ("zp+", "ZP+ clipped", Counting::ZpPlus, 2, 3),
    ("auto", "auto", Counting::Auto, 4, 0),
];

/// A caster, and a room that receives.
pub(crate) struct Stage {
    pub(crate) caster: Shape,
    pub(crate) room: Shape,
    pub(crate) size: u32,
}

#[derive(Clone, Copy, Debug)]
pub(crate) struct Frames {
    /// The length of each path; 0 leaves all out.
    pub(crate) count: usize,
    pub(crate) size: u32,
    pub(crate) rounds: Rounds,
}

impl Frames {
    fn camera(self, path: Path, frame: usize) -> Camera {
        path.camera(frame as f32 / self.count.saturating_sub(1).max(1) as f32)
    }
}

/// Times and wrong pixels of every method for a caster on a path.
pub(crate) fn measure(
    plan: Frames,
    gpu: &Gpu,
    (name, caster): (&str, &Shape),
    path: Path,
    host: &dyn Host,
) -> Result<Row, Error> {
    let stage = Stage { caster: caster.clone(), room: scene::room(), size: plan.size };
    let (light, faces) = (path.light(), stage.caster.faces.len());
    let casters = Casters::InBuffers(vec![stage.caster.clone()]);
    let setting = Setting::new(casters, vec![light], plan.camera(path, 0).shadow());
    let format = ShadowFormat { depth_stencil: DEPTH, ..ShadowFormat::default() };
    let pipelines = METHODS.map(|(_, _, counting, ..)| ShadowPipelines::new(&gpu.pipelines, &format, counting));
    let pipelines = pipelines.into_iter().collect::<Result<Vec<_>, _>>()?;
    let drawn = pipelines.iter().map(|pipelines| -> Result<_, Error> {
        let scene = SceneRecorder::new(gpu, &setting, Some(pipelines), made_anew(1, pipelines.counting()))?;
        let surfaces = [&stage.caster, &stage.room].map(|shape| Surface::new(gpu, shape, &[IDENTITY]));
        let surfaces = Some(Surfaces::new(gpu, DEPTH, Some(stage.size), surfaces.into()));
        Ok(Drawn { scene, surfaces, depth: gpu.texture([stage.size; 2], DEPTH), receivers: None })
    });
    let mut drawn = drawn.collect::<Result<Vec<_>, _>>()?;
    let wrong = wrong_pixels(plan, gpu, (path, &Truth::new(&stage, light)), &mut drawn, host)?;
    let mut contenders: Vec<(Variant, Contender<'_>)> = Vec::new();
    for (drawn, (id, name, _, colour, shape)) in drawn.iter_mut().zip(METHODS) {
        let mut stopwatch = Stopwatch::new(gpu);
        let run = move || {
            let mut sums = [0.0; 2];
            for frame in 0..plan.count {
                look(gpu, drawn, &plan.camera(path, frame));
                let timed = stopwatch.frame(&["stages", "depth", STENCIL, "light"], |encoder, part, timer| {
                    drawn.record(encoder, part, timer)
                })?;
                let found = [timed.of(|name| name == STENCIL), timed.whole_ms];
                sums.iter_mut().zip(found).for_each(|(sum, ms)| *sum += ms / plan.count as f64);
            }
            Ok(times([("stencil", sums[0]), ("frame", sums[1])]))
        };
        contenders.push((Variant::new(id, name, colour, shape), Box::new(run)));
    }
    let entries = compare(plan.rounds, contenders, host)?.into_iter().zip(wrong);
    let entries = entries.map(|(entry, wrong)| entry.with(Metric::Count("wrong_pixels"), wrong));
    Ok(Row {
        section: Section::Shadows,
        scene: path.id.to_owned(),
        title: path.name.to_owned(),
        group: name.to_owned(),
        facts: vec![
            ("faces", json!(faces)),
            ("lights", json!(1)),
            ("size", json!(plan.size)),
            ("frames", json!(plan.count)),
        ],
        entries: entries.collect(),
    })
}

fn look(gpu: &Gpu, drawn: &mut Drawn<'_>, camera: &Camera) {
    drawn.scene.camera = camera.shadow();
    drawn.surfaces.iter().for_each(|surfaces| surfaces.look(gpu, &camera.shadow()));
}

/// For each of `drawn` the wrong pixels of some frames: about four of each path are held against rays.
fn wrong_pixels(
    plan: Frames,
    gpu: &Gpu,
    (path, truth): (Path, &Truth),
    drawn: &mut [Drawn<'_>],
    host: &dyn Host,
) -> Result<Vec<Vec<f64>>, Error> {
    let mut wrong = vec![Vec::new(); drawn.len()];
    for frame in (0..plan.count).step_by(plan.count.div_ceil(4).max(1)) {
        if host.is_stopped() {
            return Err(Error::Stopped);
        }
        let camera = plan.camera(path, frame);
        let seen = truth.seen(&camera);
        for (drawn, wrong) in drawn.iter_mut().zip(&mut wrong) {
            look(gpu, drawn, &camera);
            let counts = gpu.pixels(&drawn.depth.clone(), TextureAspect::StencilOnly, |encoder| {
                ["stages", "depth", STENCIL].into_iter().try_for_each(|part| drawn.record(encoder, part, None))
            })?;
            wrong.push(seen.wrong(&counts) as f64);
        }
    }
    Ok(wrong)
}
