//! Stage `needs`: figures that a frame does not need: they are not deformed, nothing is computed of them, and nothing shows it.

use std::ops::ControlFlow;

use glam::{DVec3, DVec4};
use rimline::cpu::{HiddenCaster, HiddenFaces, HiddenOptions};
use rimline::gpu::{
    Capacities, CasterPositions, DeformError, DeformerOptions, FrameInputs, LightMask, Measuring, PoseInputs, Scene,
    SceneFrame, SceneOptions, SceneStatistics, ShadowError, View,
};
use rimline::model::Box3;
use rimline::{Cone, Displacement, Light, ModelError, ShadowCamera};
use rimline_testkit::device::Gpu;
use rimline_testkit::harness::Test;
use rimline_testkit::on_gpu::{text, views};
use rimline_testkit::random::Random;
use rimline_testkit::{is_long, must_fail, same};

use crate::crowd::{Apart, Crowd, Figure, Stage, camera, lights, place, sees, walk};
use crate::histories::{Volumes, buffers, volumes};

pub(crate) const TESTS: &[Test] = &[
    ("needs_hide_nothing", hide_nothing),
    ("needs_of_as_many_views_as_are_looked_at", most_views),
    ("figures_walk_out_of_need_and_back", histories),
    ("a_deform_that_is_dropped_spoils_one_frame", dropped),
    ("changes_after_a_deform_are_heeded", changed),
    ("needs_are_switched_off", off),
    ("instances_that_are_mirrored_anew", mirrored),
    ("models_that_are_displaced", displaced),
    ("hidden_faces_do_not_hold_for_models", hidden),
    ("models_come_and_go", come_and_go),
    ("models_that_are_refused_change_nothing", refusals),
];

fn options() -> SceneOptions {
    SceneOptions {
        capacities: Capacities { lists: Some(u32::MAX), caps: Some(u32::MAX), ..Default::default() },
        ..SceneOptions::default()
    }
}

/// Boxes that an invocation looks at: views times lights and one more. With more, all figures are needed.
const MOST_BOXES: usize = 2500;

/// Fails where a camera sees a place of a figure that is not needed, or of its shadow within a light's range. Shares no code.
fn check_unneeded(
    [low, high]: Box3,
    mask: u32,
    lights: &[Light],
    cameras: &[ShadowCamera],
    random: &mut Random,
) -> Result<(), String> {
    for _ in 0..20 {
        let p = DVec3::from([0, 1, 2].map(|axis| f64::from(random.between(low[axis], high[axis]))));
        let mut places = vec![p.extend(1.0)];
        for (_, light) in lights.iter().enumerate().filter(|(bit, _)| mask >> bit & 1 != 0) {
            let [x, y, z, w] = light.to_array().map(f64::from);
            let away = p * w - DVec3::new(x, y, z);
            let is_in_cone = light.cone.is_none_or(|Cone { axis, cosine }| {
                let axis = DVec3::from(axis.map(f64::from)).normalize();
                axis.dot(away) >= f64::from(cosine) * away.length()
            });
            if is_in_cone && (w == 0.0 || away.length() / w <= f64::from(light.range)) {
                let steps = (-7..14).map(|step| p.extend(1.0) + 2_f64.powi(step) * away.extend(0.0));
                places.extend(steps.chain([away.extend(0.0)]));
            }
        }
        let seen = |camera: &ShadowCamera| places.iter().find(|place: &&DVec4| sees(camera, **place)).copied();
        if let Some(place) = cameras.iter().find_map(seen) {
            return Err(format!("{place} of the box {low:?} {high:?} or its shadow is seen"));
        }
    }
    Ok(())
}

fn volumes_of(gpu: &Gpu, frame: &SceneFrame, views: usize) -> Result<Volumes, String> {
    let (draws, statistics) = buffers(frame)?;
    let bits: Vec<u32> = frame.lights().iter().map(|(light, _)| light.bit()).collect();
    volumes(gpu, (&draws, &statistics), (views, frame.batches()), &bits)
}

/// For each figure whether it is one point at the origin, as those are that the frame does not need.
fn points(found: &[[u32; 3]], figures: usize) -> Vec<bool> {
    found.chunks(found.len() / figures).map(|own| own.iter().all(|position| *position == [0; 3])).collect()
}

/// A figure that is no point is as where everything is deformed.
fn check_positions(found: &[[u32; 3]], all: &[[u32; 3]], unneeded: &[bool]) -> Result<(), String> {
    let count = all.len() / unneeded.len();
    for (number, _) in unneeded.iter().enumerate().filter(|(_, is_unneeded)| !**is_unneeded) {
        let own = number * count..(number + 1) * count;
        same(&format!("figure {number}"), &found[own.clone()], &all[own])?;
    }
    Ok(())
}

/// A view many times over: what it does not need is known only after the last of them, so that loops have all turns that they may
/// have. llvmpipe ends an invocation's loops after 65,535 turns without a word.
fn most_views() -> Result<(), String> {
    let gpu = &*Gpu::shared()?;
    let mut random = Random::new(4601);
    let crowd = Crowd::new(60)?;
    let lights = lights(&mut random);
    let pose = crowd.pose(&crowd.figures(&mut random))?;
    let mut stage = Stage::new(gpu, &crowd, &pose, &lights, options())?;
    let most = MOST_BOXES / (lights.len() + 1);
    let view = View::new(camera(&mut random));
    let mut of_one = Vec::new();
    for views in [1, most, most + 1] {
        let seen = vec![view; views];
        gpu.submit(|encoder| stage.scene.deform(encoder, FrameInputs::new(&seen)).map_err(text))?;
        let found = points(&stage.positions(gpu)?, 60);
        if views == 1 {
            of_one.clone_from(&found);
        }
        let expected = if views > most { vec![false; of_one.len()] } else { of_one.clone() };
        same(&format!("{views} views"), &found, &expected)?;
        let mut other = found;
        other[views % 60] ^= true;
        must_fail("another figure", &same(&format!("{views} views"), &other, &expected))?;
    }
    let unneeded = of_one.iter().filter(|is_unneeded| **is_unneeded).count();
    println!("{most} views, {unneeded} of {} figures not needed", of_one.len());
    if unneeded > 5 && unneeded < of_one.len() { Ok(()) } else { Err("not as meant".to_owned()) }
}

/// Random sizes, masks, lights and cameras, and figures without a box, since numbers of their pose overflow.
fn hide_nothing() -> Result<(), String> {
    let gpu = &*Gpu::shared()?;
    let (mut unneeded, mut needed, mut noticed, mut boxless) = (0, 0, 0, 0);
    for seed in 4101..if is_long() { 4301 } else { 4111 } {
        println!("seed {seed}");
        let mut random = Random::new(seed);
        let crowd = Crowd::new(60)?;
        let lights = lights(&mut random);
        let mut figures = crowd.figures(&mut random);
        let mut stage = Stage::new(gpu, &crowd, &crowd.pose(&figures)?, &lights, options())?;
        let casters = stage.scene.casters(stage.model).map_err(text)?.to_vec();
        for _ in 0..4 {
            let cameras: Vec<_> = (0..=random.below(2)).map(|_| camera(&mut random)).collect();
            let mut masks = Vec::new();
            for (figure, &caster) in figures.iter_mut().zip(&casters) {
                figure.at = place(&mut random);
                figure.size = if random.below(20) > 0 { random.between(0.0, 1.5) } else { 4e37 };
                let mask = random.below(64) as u32;
                let allowed = stage.lights.iter().filter(|light| mask >> light.bit() & 1 != 0).copied();
                stage.scene.set_lights(caster, LightMask::only(allowed)).map_err(text)?;
                masks.push(mask);
            }
            let pose = crowd.pose(&figures)?;
            let boxes = crowd.boxes(&pose)?;
            boxless += boxes.iter().filter(|own| own.is_none()).count();
            let frame = gpu.submit(|encoder| stage.encode(encoder, &pose, &cameras))?;
            let found = points(&stage.positions(gpu)?, figures.len());
            let statistics = gpu.read::<SceneStatistics>(frame.statistics(), 1)?[0];
            let count = found.iter().filter(|is_unneeded| **is_unneeded).count();
            same("counted", &[statistics.culled_casters], &[count as u32])?;
            for ((own, mask), word) in boxes.iter().zip(&masks).zip(&found) {
                let is_hidden = own.map(|own| check_unneeded(own, *mask, &lights, &cameras, &mut random));
                match (word, is_hidden) {
                    (false, Some(Err(_))) => noticed += 1,
                    (false, _) => needed += 1,
                    (_, None) => return Err("a figure without a box is left out".to_owned()),
                    (_, Some(outcome)) => {
                        outcome?;
                        unneeded += 1;
                    }
                }
            }
        }
    }
    println!("{unneeded} figures not needed, {noticed} seen, {needed} others needed, {boxless} without a box");
    // Few figures are deformed without need: boxes near the frustum's edges, and boxes that samples miss.
    let is_meant = unneeded > 500 && noticed > 300 && needed < noticed && boxless > 50;
    if is_meant { Ok(()) } else { Err("not as meant".to_owned()) }
}

/// A frame that was recorded, and what it must come to.
struct Recorded {
    encoder: wgpu::CommandEncoder,
    /// The buffers of its draws.
    draws: (Vec<wgpu::Buffer>, wgpu::Buffer),
    statistics: wgpu::Buffer,
    batches: usize,
    figures: Vec<Figure>,
    lights: Vec<Light>,
    cameras: Vec<ShadowCamera>,
}

impl Recorded {
    /// Records a frame of a stage whose lights are `lights`. In some, models are deformed before, for its views or others.
    fn new(
        (crowd, stage): (&Crowd, &mut Stage),
        mut encoder: wgpu::CommandEncoder,
        figures: &[Figure],
        lights: &[Light],
        cameras: Vec<ShadowCamera>,
        before: Option<&[ShadowCamera]>,
    ) -> Result<Self, String> {
        let pose = crowd.pose(figures)?;
        if let Some(before) = before {
            stage.scene.set_pose(stage.model, &pose).map_err(text)?;
            stage.scene.deform(&mut encoder, FrameInputs::new(&views(before))).map_err(text)?;
            // An encode takes them, since the pose is still that.
            let frame = stage.scene.encode(&mut encoder, FrameInputs::new(&views(&cameras))).map_err(text)?;
            return Self::of(encoder, &frame, figures, lights, cameras);
        }
        let frame = stage.encode(&mut encoder, &pose, &cameras)?;
        Self::of(encoder, &frame, figures, lights, cameras)
    }

    fn of(
        encoder: wgpu::CommandEncoder,
        frame: &SceneFrame,
        figures: &[Figure],
        lights: &[Light],
        cameras: Vec<ShadowCamera>,
    ) -> Result<Self, String> {
        let (draws, statistics, batches) = (buffers(frame)?, frame.statistics().clone(), frame.batches());
        let (figures, lights) = (figures.to_vec(), lights.to_vec());
        Ok(Self { encoder, draws, statistics, batches, figures, lights, cameras })
    }

    /// Submits it, and compares with a scene made anew whose caller deforms everything. Returns how many figures were not
    /// needed, and what was kept.
    fn check(self, gpu: &Gpu, crowd: &Crowd, stage: &Stage, options: SceneOptions) -> Result<[u32; 3], String> {
        gpu.queue.submit([self.encoder.finish()]);
        let bits: Vec<u32> = (0..self.lights.len() as u32).collect();
        let sizes = (self.cameras.len(), self.batches);
        let found = volumes(gpu, (&self.draws.0, &self.draws.1), sizes, &bits)?;
        let statistics = gpu.read::<SceneStatistics>(&self.statistics, 1)?[0];
        let pose = crowd.pose(&self.figures)?;
        let mut other = Apart::new(gpu, crowd, &pose, &self.lights, (options, DeformerOptions::default()))?;
        let frame = gpu.submit(|encoder| other.encode(encoder, (&pose, 0.0), &self.cameras))?;
        let expected = volumes_of(gpu, &frame, self.cameras.len())?;
        same("instances", &found.instances, &expected.instances)?;
        let (own, all) = (stage.positions(gpu)?, other.positions(gpu)?);
        let unneeded = points(&own, self.figures.len());
        check_positions(&own, &all, &unneeded)?;
        let count = unneeded.iter().filter(|is_unneeded| **is_unneeded).count() as u32;
        same("figures that were not needed", &[statistics.culled_casters], &[count])?;
        Ok([count, statistics.cached_pairs, found.instances.iter().flatten().sum()])
    }
}

fn encoder(gpu: &Gpu) -> wgpu::CommandEncoder {
    gpu.device.create_command_encoder(&wgpu::CommandEncoderDescriptor::default())
}

/// Frames are dropped, swapped, of another pose or the same. Models are deformed before some, for their views or for others.
fn histories() -> Result<(), String> {
    let gpu = &*Gpu::shared()?;
    let (mut sums, mut late, mut noticed) = ([0_u32; 3], 0, 0);
    for seed in 4201..if is_long() { 4301 } else { 4209 } {
        println!("seed {seed}");
        let mut random = Random::new(seed);
        let crowd = Crowd::new(24)?;
        let mut lights = lights(&mut random);
        let options = options();
        let mut figures = crowd.figures(&mut random);
        let mut stage = Stage::new(gpu, &crowd, &crowd.pose(&figures)?, &lights, options)?;
        let mut cameras = vec![camera(&mut random)];
        let mut kept: Vec<Recorded> = Vec::new();
        for step in 0..16 {
            let what = |error| format!("step {step}: {error}");
            let before = match random.below(4) {
                0 => Some(cameras.clone()),
                1 => Some(vec![camera(&mut random)]),
                _ => None,
            };
            let of = (&crowd, &mut stage);
            let recorded =
                Recorded::new(of, encoder(gpu), &figures, &lights, cameras.clone(), before.as_deref()).map_err(what)?;
            match random.below(4) {
                0 => {}
                1 => kept.push(recorded),
                _ => {
                    let found = recorded.check(gpu, &crowd, &stage, options).map_err(what)?;
                    sums.iter_mut().zip(found).for_each(|(sum, found)| *sum += found);
                }
            }
            if random.below(3) == 0 && !kept.is_empty() {
                let recorded = kept.swap_remove(random.below(kept.len()));
                recorded.check(gpu, &crowd, &stage, options).map_err(|error| format!("late, {}", what(error)))?;
                late += 1;
            }
            // Figures move in a quarter of the frames, cameras in half of them.
            match random.below(4) {
                0 => walk(&mut figures, &mut random),
                1 => {
                    let light = random.below(lights.len());
                    lights[light] = Light::point(place(&mut random).to_array()).with_range(6.0);
                    stage.scene.set_light(stage.lights[light], lights[light]).map_err(text)?;
                }
                _ => cameras = (0..=random.below(2)).map(|_| camera(&mut random)).collect(),
            }
        }
        // Negative control: figures that walk on.
        let of = (&crowd, &mut stage);
        let mut recorded = Recorded::new(of, encoder(gpu), &figures, &lights, cameras, None)?;
        walk(&mut recorded.figures, &mut random);
        noticed += u32::from(recorded.check(gpu, &crowd, &stage, options).is_err());
    }
    let [unneeded, pairs, instances] = sums;
    println!(
        "{unneeded} figures not needed, {pairs} pairs kept, {instances} instances, {late} late, {noticed} controls"
    );
    if unneeded < 200 || pairs < 200 || instances < 10_000 || late < 5 || noticed < 6 {
        return Err("too few of a kind".to_owned());
    }
    Ok(())
}

/// A frame before `deform` is out of date. A `deform` whose encoder is dropped spoils one frame, and none after it.
fn dropped() -> Result<(), String> {
    let gpu = &*Gpu::shared()?;
    let mut random = Random::new(4501);
    let crowd = Crowd::new(24)?;
    let (lights, mut figures) = (lights(&mut random), crowd.figures(&mut random));
    let mut stage = Stage::new(gpu, &crowd, &crowd.pose(&figures)?, &lights, options())?;
    let cameras = vec![camera(&mut random)];
    for number in 0..6 {
        let before = gpu.submit(|encoder| stage.encode(encoder, &crowd.pose(&figures)?, &cameras))?;
        walk(&mut figures, &mut random);
        stage.scene.set_pose(stage.model, &crowd.pose(&figures)?).map_err(text)?;
        let inputs = views(&cameras);
        before.check_current().map_err(text)?;
        stage.scene.deform(&mut encoder(gpu), FrameInputs::new(&inputs)).map_err(text)?;
        if before.check_current() != Err(ShadowError::StaleFrame) {
            return Err("a frame whose positions are overwritten is not refused".to_owned());
        }
        // This one has positions that nobody computed.
        gpu.submit(|encoder| stage.scene.encode(encoder, FrameInputs::new(&inputs)).map_err(text))?;
        let mut encoder = encoder(gpu);
        let frame = stage.scene.encode(&mut encoder, FrameInputs::new(&inputs)).map_err(text)?;
        let recorded = Recorded::of(encoder, &frame, &figures, &lights, cameras.clone())?;
        recorded.check(gpu, &crowd, &stage, options()).map_err(|error| format!("frame {number}: {error}"))?;
    }
    Ok(())
}

/// Between `deform` and the encode a light moves or comes, casters get lights, or camera or pose change: other figures are needed then.
fn changed() -> Result<(), String> {
    let gpu = &*Gpu::shared()?;
    let mut random = Random::new(4511);
    let crowd = Crowd::new(24)?;
    for number in 0..25 {
        let (mut lights, mut figures) = (lights(&mut random), crowd.figures(&mut random));
        let mut stage = Stage::new(gpu, &crowd, &crowd.pose(&figures)?, &lights, options())?;
        let mut cameras = vec![camera(&mut random)];
        let casters = stage.scene.casters(stage.model).map_err(text)?.to_vec();
        let set_all = |scene: &mut Scene, mask: LightMask| {
            casters.iter().try_for_each(|&caster| scene.set_lights(caster, mask)).map_err(text)
        };
        if number % 5 == 4 {
            set_all(&mut stage.scene, LightMask::NONE)?;
        }
        gpu.submit(|encoder| stage.encode(encoder, &crowd.pose(&figures)?, &cameras))?;
        let mut encoder = encoder(gpu);
        stage.scene.deform(&mut encoder, FrameInputs::new(&views(&cameras))).map_err(text)?;
        let light = Light::point(place(&mut random).to_array());
        match number % 5 {
            0 => {
                // One that reached few of them.
                let last = lights.len() - 1;
                stage.scene.set_light(stage.lights[last], light).map_err(text)?;
                lights[last] = light;
            }
            1 => {
                stage.scene.add_light(light).map_err(text)?;
                lights.push(light);
            }
            2 => cameras = vec![camera(&mut random)],
            4 => set_all(&mut stage.scene, LightMask::ALL)?,
            _ => {
                walk(&mut figures, &mut random);
                stage.scene.set_pose(stage.model, &crowd.pose(&figures)?).map_err(text)?;
            }
        }
        let frame = stage.scene.encode(&mut encoder, FrameInputs::new(&views(&cameras))).map_err(text)?;
        let recorded = Recorded::of(encoder, &frame, &figures, &lights, cameras)?;
        recorded.check(gpu, &crowd, &stage, options()).map_err(|error| format!("frame {number}: {error}"))?;
    }
    Ok(())
}

/// A displacement that moves nothing.
fn still() -> Result<Displacement, String> {
    let source = "fn displace(position: vec3<f32>, vertex: u32, time: f32) -> vec3<f32> { return position; }";
    Displacement::new(source).map_err(text)
}

/// Without the level, a camera or a box all figures are needed. A displacement that may move them anywhere leaves no box.
fn off() -> Result<(), String> {
    let gpu = &*Gpu::shared()?;
    let mut random = Random::new(4401);
    let crowd = Crowd::new(9)?;
    let pose = crowd.pose(&crowd.figures(&mut random))?;
    let displacement = still()?;
    // Far away and looking farther, and no light.
    let mut away = camera(&mut random);
    away.origin = [0, 1, 2].map(|axis| 1e4 * away.view_projection[axis][3]);
    for (skips, cameras, displaced_by, expected) in [
        (true, vec![away], Some(0.0), 9),
        (true, vec![away], None, 9),
        (false, vec![away], Some(0.0), 0),
        (true, Vec::new(), Some(0.0), 0),
        (true, vec![away], Some(f32::INFINITY), 0),
    ] {
        let mut options = options();
        options.measuring.set(Measuring::CULLED_CASTERS, !skips);
        let mut stage = Stage::new(gpu, &crowd, &pose, &[], options)?;
        if let Some(displaced_by) = displaced_by {
            stage.scene.remove_model(stage.model).map_err(text)?;
            let pose = PoseInputs { displaced_by, ..PoseInputs::new(&pose) };
            let options = DeformerOptions { displacement: Some(&displacement), ..DeformerOptions::default() };
            stage.model = stage.scene.insert_model(&crowd.model, pose, options).map_err(text)?;
        }
        gpu.submit(|encoder| stage.scene.encode(encoder, FrameInputs::new(&views(&cameras))).map_err(text))?;
        let found = points(&stage.positions(gpu)?, 9).into_iter().filter(|is_unneeded| *is_unneeded).count();
        let what = format!("{skips}, {} cameras, {displaced_by:?}", cameras.len());
        same(&what, &[found], &[expected])?;
    }
    Ok(())
}

/// Figures become their mirror images and back: their faces are turned then, also those that are excluded.
fn mirrored() -> Result<(), String> {
    let gpu = &*Gpu::shared()?;
    let mut random = Random::new(4701);
    let crowd = Crowd::new(12)?;
    let lights = lights(&mut random);
    let mut figures = crowd.figures(&mut random);
    let mut stage = Stage::new(gpu, &crowd, &crowd.pose(&figures)?, &lights, options())?;
    let (mut turned, mut noticed) = (0, 0);
    for step in 0..12 {
        let what = |error| format!("step {step}: {error}");
        for figure in &mut figures {
            figure.is_mirrored ^= random.below(3) == 0;
            turned += u32::from(figure.is_mirrored);
        }
        let cameras = vec![camera(&mut random)];
        let of = (&crowd, &mut stage);
        let mut recorded = Recorded::new(of, encoder(gpu), &figures, &lights, cameras.clone(), None)?;
        if step % 4 == 3 {
            for figure in &mut recorded.figures {
                figure.is_mirrored ^= true;
            }
            noticed += u32::from(recorded.check(gpu, &crowd, &stage, options()).is_err());
        } else {
            recorded.check(gpu, &crowd, &stage, options()).map_err(what)?;
        }
    }
    // Faces stay excluded.
    let casters = stage.scene.casters(stage.model).map_err(text)?.to_vec();
    for (&caster, &light) in casters.iter().flat_map(|caster| stage.lights.iter().map(move |light| (caster, light))) {
        stage.scene.set_excluded(caster, light, &[0, 1, 2, 3, 9]).map_err(text)?;
    }
    for figure in &mut figures {
        figure.is_mirrored ^= true;
    }
    let (pose, cameras) = (crowd.pose(&figures)?, (0..2).map(|_| camera(&mut random)).collect::<Vec<_>>());
    let frame = gpu.submit(|encoder| stage.encode(encoder, &pose, &cameras))?;
    let found = volumes_of(gpu, &frame, 2)?;
    let mut other = Apart::new(gpu, &crowd, &pose, &lights, (options(), DeformerOptions::default()))?;
    let frame = gpu.submit(|encoder| other.encode(encoder, (&pose, 0.0), &cameras))?;
    let whole = volumes_of(gpu, &frame, 2)?;
    for (&caster, &light) in
        other.casters.iter().flat_map(|caster| other.lights.iter().map(move |light| (caster, light)))
    {
        other.scene.set_excluded(caster, light, &[0, 1, 2, 3, 9]).map_err(text)?;
    }
    let frame = gpu.submit(|encoder| other.encode(encoder, (&pose, 0.0), &cameras))?;
    let expected = volumes_of(gpu, &frame, 2)?;
    same("excluded faces", &found.instances, &expected.instances)?;
    must_fail("none excluded", &same("excluded faces", &whole.instances, &expected.instances))?;
    println!("{turned} mirrored, {noticed} controls");
    if turned < 30 || noticed < 2 { Err("not as meant".to_owned()) } else { Ok(()) }
}

/// A displacement that depends on time: as a caller's deformer has it, and kept while the time is the same.
fn displaced() -> Result<(), String> {
    let gpu = &*Gpu::shared()?;
    let mut random = Random::new(4801);
    let crowd = Crowd::new(8)?;
    let lights = lights(&mut random);
    let pose = crowd.pose(&crowd.figures(&mut random))?;
    let source = "fn displace(position: vec3<f32>, vertex: u32, time: f32) -> vec3<f32> {
        return position + 0.2 * vec3<f32>(sin(time + f32(vertex)), 0.0, 0.0);
    }";
    let displacement = Displacement::new(source).map_err(text)?;
    let deforming = DeformerOptions { displacement: Some(&displacement), ..DeformerOptions::default() };
    let mut stage = Stage::new(gpu, &crowd, &pose, &lights, options())?;
    stage.scene.remove_model(stage.model).map_err(text)?;
    let at = |time_s| PoseInputs { time_s, displaced_by: 0.201, ..PoseInputs::new(&pose) };
    stage.model = stage.scene.insert_model(&crowd.model, at(0.0), deforming).map_err(text)?;
    let mut other = Apart::new(gpu, &crowd, &pose, &lights, (options(), deforming))?;
    let mut kept = Vec::new();
    for time_s in [0.0, 1.0, 1.0, 2.0] {
        stage.scene.set_pose(stage.model, at(time_s)).map_err(text)?;
        // No view, so all are needed.
        let frame = gpu.submit(|encoder| stage.scene.encode(encoder, FrameInputs::default()).map_err(text))?;
        gpu.submit(|encoder| other.encode(encoder, (&pose, time_s), &[]))?;
        same(&format!("time {time_s}"), &stage.positions(gpu)?, &other.positions(gpu)?)?;
        let statistics = gpu.read::<SceneStatistics>(frame.statistics(), 1)?[0];
        kept.push(statistics.cached_pairs == statistics.pairs);
    }
    same("all kept", &kept, &[false, false, true, false])
}

/// Hidden faces are of static casters. A version that was searched says nothing about the poses of a scene's own model.
fn hidden() -> Result<(), String> {
    let gpu = &*Gpu::shared()?;
    let mut random = Random::new(4851);
    let crowd = Crowd::new(3)?;
    let lights = [Light::point([0.0, 40.0, 0.0])];
    let pose = crowd.pose(&crowd.figures(&mut random))?;
    let mut stage = Stage::new(gpu, &crowd, &pose, &lights, options())?;
    let mut other = Apart::new(gpu, &crowd, &pose, &lights, (options(), DeformerOptions::default()))?;
    gpu.submit(|encoder| other.encode(encoder, (&pose, 0.0), &[]))?;
    let positions = other.positions(gpu)?.into_iter().map(|p| p.map(f32::from_bits)).collect::<Vec<_>>();
    let geometry = &crowd.model.geometries()[0];
    let mesh = geometry.mesh().map_err(text)?;
    // The first versions that a scene counts, and those of the caller.
    let figures = positions.chunks(geometry.positions().len());
    let searched: Vec<_> = figures.map(|positions| HiddenCaster { mesh: &mesh, positions, version: Some(1) }).collect();
    let go_on = |_, _| ControlFlow::Continue(());
    let found = HiddenFaces::find(lights[0], &searched, HiddenOptions::default(), go_on).map_err(text)?;
    let casters = stage.scene.casters(stage.model).map_err(text)?.to_vec();
    stage.scene.set_hidden_faces(stage.lights[0], &casters, Some(&found)).map_err(text)?;
    let frame = gpu.submit(|encoder| stage.encode(encoder, &pose, &[]))?;
    for &caster in &other.casters {
        other.scene.set_position_version(caster, Some(1)).map_err(text)?;
    }
    other.scene.set_hidden_faces(other.lights[0], &other.casters, Some(&found)).map_err(text)?;
    let held = gpu.submit(|encoder| other.encode(encoder, (&pose, 0.0), &[]))?;
    same("ignored", &[frame.hidden().ignored, held.hidden().ignored], &[1, 0])
}

/// Two models, of which one goes while a frame of both is not submitted yet, and comes back.
fn come_and_go() -> Result<(), String> {
    let gpu = &*Gpu::shared()?;
    let mut random = Random::new(4901);
    let [crowd, second] = [Crowd::new(5)?, Crowd::new(3)?];
    let lights = lights(&mut random);
    let [pose, other_pose] = [&crowd, &second].map(|crowd| crowd.pose(&crowd.figures(&mut random)));
    let (pose, other_pose) = (pose?, other_pose?);
    let cameras = [camera(&mut random)];
    let mut stage = Stage::new(gpu, &crowd, &pose, &lights, options())?;
    let mut alone = Stage::new(gpu, &second, &other_pose, &lights, options())?;
    let frame = gpu.submit(|encoder| stage.encode(encoder, &pose, &cameras))?;
    let first = volumes_of(gpu, &frame, 1)?;
    let frame = gpu.submit(|encoder| alone.encode(encoder, &other_pose, &cameras))?;
    let expected = volumes_of(gpu, &frame, 1)?;
    let insert = |stage: &mut Stage| {
        stage.scene.insert_model(&second.model, &other_pose, DeformerOptions::default()).map_err(text)
    };
    let handle = insert(&mut stage)?;
    let mut late = encoder(gpu);
    let both = stage.encode(&mut late, &pose, &cameras)?;
    let (draws, statistics) = buffers(&both)?;
    let model = std::mem::replace(&mut stage.model, handle);
    stage.scene.remove_model(model).map_err(text)?;
    gpu.queue.submit([late.finish()]);
    let bits: Vec<u32> = (0..lights.len() as u32).collect();
    let both = volumes(gpu, (&draws, &statistics), (1, both.batches()), &bits)?;
    let sum = |of: &Volumes| of.instances.iter().flatten().sum::<u32>();
    same("both", &[sum(&both)], &[sum(&first) + sum(&expected)])?;
    let frame = gpu.submit(|encoder| stage.encode(encoder, &other_pose, &cameras))?;
    same("the second alone", &volumes_of(gpu, &frame, 1)?.instances, &expected.instances)?;
    same("its positions", &stage.positions(gpu)?, &alone.positions(gpu)?)?;
    let removed = ShadowError::Removed { what: "model" };
    same("its handle", &[stage.scene.set_pose(model, &pose)], &[Err(removed.clone())])?;
    same("once more", &[stage.scene.remove_model(model)], &[Err(removed)])?;
    must_fail("one", &same("both", &[sum(&both)], &[sum(&expected)]))
}

/// Calls that instances do not take, and poses that do not fit.
fn refusals() -> Result<(), String> {
    let gpu = &*Gpu::shared()?;
    let mut random = Random::new(4501);
    let [crowd, fewer] = [Crowd::new(4)?, Crowd::new(3)?];
    let lights = lights(&mut random);
    let [pose, of_fewer] = [&crowd, &fewer].map(|crowd| crowd.pose(&crowd.figures(&mut random)));
    let (pose, of_fewer) = (pose?, of_fewer?);
    let cameras = [camera(&mut random)];
    let mut stage = Stage::new(gpu, &crowd, &pose, &lights, options())?;
    let frame = gpu.submit(|encoder| stage.encode(encoder, &pose, &cameras))?;
    let (expected, bytes) = (volumes_of(gpu, &frame, 1)?, frame.results().map_err(text)?.bytes);
    let scene = &mut stage.scene;
    let caster = scene.casters(stage.model).map_err(text)?[0];
    let positions = scene.positions(stage.model).map(CasterPositions::from).map_err(text)?;
    let of_model = [
        scene.remove(caster),
        scene.set_bounds(caster, None),
        scene.set_position_version(caster, Some(1)),
        scene.set_transform(caster, [[0.0; 4]; 3]),
        scene.set_positions(caster, positions),
    ];
    same("instances", &of_model, &[const { Err(ShadowError::OfModel) }; 5])?;
    let wrong = |error: ModelError| Err(ShadowError::Deform(DeformError::Model(error)));
    let wrong = wrong(ModelError::PoseInstances { given: 3, needed: 4 });
    same("a pose", &[scene.set_pose(stage.model, &of_fewer)], std::slice::from_ref(&wrong))?;
    let inserted = scene.insert_model(&crowd.model, &of_fewer, DeformerOptions::default());
    same("a pose at first", &[inserted.map(drop)], &[wrong])?;
    let source = "@group(1) @binding(0) var<uniform> by: vec4<f32>;
        fn displace(position: vec3<f32>, vertex: u32, time: f32) -> vec3<f32> { return position + by.xyz; }";
    let displacement = Displacement::new(source).map_err(text)?;
    let options_of = DeformerOptions { displacement: Some(&displacement), ..DeformerOptions::default() };
    let resources = Err(ShadowError::Deform(DeformError::Resources));
    same("no layout", &[scene.insert_model(&crowd.model, &pose, options_of).map(drop)], &[resources])?;
    let mut other = Stage::new(gpu, &crowd, &pose, &lights, options())?;
    let foreign = Err(ShadowError::OtherScene { what: "model" });
    let found = [
        other.scene.set_pose(stage.model, &pose),
        other.scene.remove_model(stage.model),
        other.scene.casters(stage.model).map(drop),
        other.scene.positions(stage.model).map(drop),
    ];
    same("another scene", &found, &[const { Err(ShadowError::OtherScene { what: "model" }) }; 4])?;
    must_fail("none", &same("another scene", &[Ok(())], &[foreign]))?;
    let frame = gpu.submit(|encoder| stage.encode(encoder, &pose, &cameras))?;
    same("as before", &volumes_of(gpu, &frame, 1)?.instances, &expected.instances)?;
    same("memory", &[frame.results().map_err(text)?.bytes], &[bytes])
}
