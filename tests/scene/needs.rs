//! Stage `needs`: deforming casters that a frame does not need are not deformed, nothing is computed of them, and no
//! image shows it.

use std::ops::ControlFlow;
use std::sync::Arc;

use glam::{DVec3, DVec4};
use rimline::cpu::{OccludedFaces, OcclusionCaster, OcclusionOptions};
use rimline::gpu::{
    Capacities, CasterPositions, DeformError, DeformerOptions, FrameInputs, LightMask, Measuring, PoseInputs, Scene,
    SceneFrame, SceneOptions, SceneStatistics, ShadowError, View,
};
use rimline::model::Box3;
use rimline::{Cone, Displacement, Light, ModelError, Pose, ShadowCamera};
use rimline_testkit::device::Gpu;
use rimline_testkit::harness::Test;
use rimline_testkit::on_gpu::{text, views};
use rimline_testkit::random::Random;
use rimline_testkit::{is_long, must_fail, same};

use crate::crowd::{Apart, Crowd, Stage, Walker, camera, lights, position, sees, walk};
use crate::histories::{VolumeBuffers, Volumes, volumes};
use crate::random_scene::encoder;

pub(crate) const TESTS: &[Test] = &[
    ("needs_cull_nothing_visible", nothing_visible),
    ("needs_of_as_many_views_as_are_looked_at", most_views),
    ("figures_walk_out_of_need_and_back", histories),
    ("a_deform_that_is_dropped_spoils_one_frame", dropped),
    ("changes_after_a_deform_are_heeded", changed),
    ("needs_are_switched_off", off),
    ("instances_that_become_mirrored", mirrored),
    ("models_that_are_displaced", displaced),
    ("occluded_faces_do_not_hold_for_models", occluded),
    ("models_come_and_go", come_and_go),
    ("models_that_are_refused_change_nothing", refusals),
];

fn options() -> SceneOptions {
    SceneOptions {
        capacities: Capacities { lists: Some(u32::MAX), caps: Some(u32::MAX), ..Default::default() },
        ..SceneOptions::default()
    }
}

/// Boxes that an invocation tests: views times lights and one more. With more, all casters are needed.
const MOST_BOXES: usize = 2500;

/// The figures, lights and cameras of a frame.
#[derive(Clone)]
struct Moment {
    walkers: Vec<Walker>,
    lights: Vec<Light>,
    cameras: Vec<ShadowCamera>,
}

/// A crowd in a scene, and what is to be drawn next.
struct Play {
    gpu: Arc<Gpu>,
    random: Random,
    crowd: Crowd,
    stage: Stage,
    next: Moment,
}

impl Play {
    fn new(seed: u64, walkers: usize) -> Result<Self, String> {
        let (gpu, mut random) = Gpu::seeded(seed)?;
        let crowd = Crowd::new(walkers)?;
        let (lights, walkers) = (lights(&mut random), crowd.walkers(&mut random));
        let stage = Stage::new(&gpu, &crowd, &crowd.pose(&walkers)?, &lights, options())?;
        let cameras = vec![camera(&mut random)];
        Ok(Self { gpu, random, crowd, stage, next: Moment { walkers, lights, cameras } })
    }

    fn pose(&self) -> Result<Pose, String> {
        self.crowd.pose(&self.next.walkers)
    }

    fn set_pose(&mut self) -> Result<(), String> {
        let pose = self.pose()?;
        self.stage.scene.set_pose(self.stage.model, &pose).map_err(text)
    }

    fn deform(&mut self, encoder: &mut wgpu::CommandEncoder, cameras: &[ShadowCamera]) -> Result<(), String> {
        self.stage.scene.deform(encoder, FrameInputs::new(&views(cameras))).map_err(text)
    }

    /// Records a frame into an encoder, in which the models may be deformed already.
    fn record(&mut self, mut encoder: wgpu::CommandEncoder) -> Result<Recorded, String> {
        let inputs = views(&self.next.cameras);
        let frame = self.stage.scene.encode(&mut encoder, FrameInputs::new(&inputs)).map_err(text)?;
        let volumes = VolumeBuffers::new(&frame, self.next.cameras.len())?;
        Ok(Recorded { encoder, volumes, statistics: frame.statistics().clone(), moment: self.next.clone() })
    }

    /// Submits a frame in the next pose.
    fn frame(&mut self) -> Result<SceneFrame, String> {
        let pose = self.pose()?;
        let Self { gpu, stage, next, .. } = self;
        gpu.submit(|encoder| stage.encode(encoder, &pose, &next.cameras))
    }

    fn volumes(&self, frame: &SceneFrame) -> Result<Volumes, String> {
        volumes(&self.gpu, frame, self.next.cameras.len())
    }

    /// A scene of the same whose caller deforms everything.
    fn apart(&self, deforming: DeformerOptions<'_>) -> Result<Apart, String> {
        Apart::new(&self.gpu, &self.crowd, &self.pose()?, &self.next.lights, (options(), deforming))
    }

    /// Inserts the model anew, with a displacement.
    fn displace(&mut self, by: &Displacement, displaced_by: f32) -> Result<(), String> {
        let pose = self.pose()?;
        let stage = &mut self.stage;
        stage.scene.remove_model(stage.model).map_err(text)?;
        let options = DeformerOptions { displacement: Some(by), ..DeformerOptions::default() };
        let pose = PoseInputs { displaced_by, ..PoseInputs::new(&pose) };
        stage.model = stage.scene.insert_model(&self.crowd.model, pose, options).map_err(text)?;
        Ok(())
    }

    /// Submits a recorded frame, and compares it with a new scene whose caller deforms everything.
    fn check(&self, recorded: Recorded) -> Result<Drawn, String> {
        let Recorded { encoder, volumes: recorded, statistics, moment } = recorded;
        let Moment { walkers, lights, cameras } = moment;
        let gpu = &self.gpu;
        gpu.queue.submit([encoder.finish()]);
        let bits: Vec<u32> = (0..lights.len() as u32).collect();
        let found = recorded.read(gpu, &bits)?;
        let statistics = gpu.read::<SceneStatistics>(&statistics, 1)?[0];
        let pose = self.crowd.pose(&walkers)?;
        let mut other = Apart::new(gpu, &self.crowd, &pose, &lights, (options(), DeformerOptions::default()))?;
        let frame = gpu.submit(|encoder| other.encode(encoder, (&pose, 0.0), &cameras))?;
        same("instances", &found.instances, &volumes(gpu, &frame, cameras.len())?.instances)?;
        let (found_positions, all) = (self.stage.positions(gpu)?, other.positions(gpu)?);
        let culled = points(&found_positions, walkers.len());
        let vertices = all.len() / walkers.len();
        for (number, _) in culled.iter().enumerate().filter(|(_, is_culled)| !**is_culled) {
            let range = number * vertices..(number + 1) * vertices;
            same(&format!("figure {number}"), &found_positions[range.clone()], &all[range])?;
        }
        let count = count(&culled);
        same("culled figures", &[statistics.culled_casters], &[count])?;
        Ok(Drawn {
            culled: count,
            cached_pairs: statistics.cached_pairs,
            instances: found.instances.iter().flatten().sum(),
        })
    }
}

/// A recorded frame, and its moment.
struct Recorded {
    encoder: wgpu::CommandEncoder,
    volumes: VolumeBuffers,
    statistics: wgpu::Buffer,
    moment: Moment,
}

/// Counts of a frame.
#[derive(Debug, Default)]
struct Drawn {
    culled: u32,
    cached_pairs: u32,
    instances: u32,
}

/// For each figure whether all its vertices are at the origin, as those of a culled one.
fn points(found: &[[u32; 3]], walkers: usize) -> Vec<bool> {
    found.chunks(found.len() / walkers).map(|walker| walker.iter().all(|position| *position == [0; 3])).collect()
}

fn count(culled: &[bool]) -> u32 {
    culled.iter().filter(|is_culled| **is_culled).count() as u32
}

/// Fails if a camera sees a point of a culled figure, or of its shadow within a light's range and cone. Shares no code.
fn check_culled(
    [low, high]: Box3,
    mask: u32,
    lights: &[Light],
    cameras: &[ShadowCamera],
    random: &mut Random,
) -> Result<(), String> {
    for _ in 0..20 {
        let p = DVec3::from([0, 1, 2].map(|axis| f64::from(random.between(low[axis], high[axis]))));
        let mut points = vec![p.extend(1.0)];
        for (_, light) in lights.iter().enumerate().filter(|(bit, _)| mask >> bit & 1 != 0) {
            let [x, y, z, w] = light.to_array().map(f64::from);
            let away = p * w - DVec3::new(x, y, z);
            let is_in_cone = light.cone.is_none_or(|Cone { axis, cosine }| {
                let axis = DVec3::from(axis.map(f64::from)).normalize();
                axis.dot(away) >= f64::from(cosine) * away.length()
            });
            if is_in_cone && (w == 0.0 || away.length() / w <= f64::from(light.range)) {
                let steps = (-7..14).map(|step| p.extend(1.0) + 2_f64.powi(step) * away.extend(0.0));
                points.extend(steps.chain([away.extend(0.0)]));
            }
        }
        let seen = |camera: &ShadowCamera| points.iter().find(|point: &&DVec4| sees(camera, **point)).copied();
        if let Some(point) = cameras.iter().find_map(seen) {
            return Err(format!("{point} of the box {low:?} {high:?} or its shadow is seen"));
        }
    }
    Ok(())
}

/// Random sizes, masks, lights and cameras, and figures without a box, since numbers of their pose overflow.
fn nothing_visible() -> Result<(), String> {
    let (mut culled, mut needed, mut noticed, mut boxless) = (0, 0, 0, 0);
    for seed in 4101..if is_long() { 4301 } else { 4111 } {
        let mut play = Play::new(seed, 60)?;
        let casters = play.stage.scene.casters(play.stage.model).map_err(text)?.to_vec();
        for _ in 0..4 {
            let Play { random, stage, next, .. } = &mut play;
            next.cameras = (0..=random.below(2)).map(|_| camera(random)).collect();
            let mut masks = Vec::new();
            for (walker, &caster) in next.walkers.iter_mut().zip(&casters) {
                walker.at = position(random);
                walker.size = if random.below(20) > 0 { random.between(0.0, 1.5) } else { 4e37 };
                let mask = random.below(64) as u32;
                let allowed = stage.lights.iter().filter(|light| mask >> light.bit() & 1 != 0).copied();
                stage.scene.set_lights(caster, LightMask::only(allowed)).map_err(text)?;
                masks.push(mask);
            }
            let frame = play.frame()?;
            let found = points(&play.stage.positions(&play.gpu)?, casters.len());
            let statistics = play.gpu.read::<SceneStatistics>(frame.statistics(), 1)?[0];
            same("counted", &[statistics.culled_casters], &[count(&found)])?;
            for ((bounds, mask), is_culled) in play.crowd.boxes(&play.pose()?)?.iter().zip(&masks).zip(&found) {
                boxless += usize::from(bounds.is_none());
                let Moment { lights, cameras, .. } = &play.next;
                let outcome = bounds.map(|bounds| check_culled(bounds, *mask, lights, cameras, &mut play.random));
                match (is_culled, outcome) {
                    (false, Some(Err(_))) => noticed += 1,
                    (false, _) => needed += 1,
                    (_, None) => return Err("a figure without a box is culled".to_owned()),
                    (_, Some(outcome)) => {
                        outcome?;
                        culled += 1;
                    }
                }
            }
        }
    }
    println!("{culled} figures culled, {noticed} seen, {needed} others needed, {boxless} without a box");
    // Few figures are deformed without need: boxes near the frustum's edges, and boxes that samples miss.
    let is_meant = culled > 500 && noticed > 300 && needed < noticed && boxless > 50;
    if is_meant { Ok(()) } else { Err("too few of a kind".to_owned()) }
}

/// A view many times over. Only its last copy decides that a figure is culled, so loops have all their turns. llvmpipe
/// ends an invocation's loops after 65,535 turns without a word.
fn most_views() -> Result<(), String> {
    let mut play = Play::new(4601, 60)?;
    let most = MOST_BOXES / (play.next.lights.len() + 1);
    let view = View::new(play.next.cameras[0]);
    let mut of_one = Vec::new();
    for views in [1, most, most + 1] {
        let Play { gpu, stage, .. } = &mut play;
        gpu.submit(|encoder| stage.scene.deform(encoder, FrameInputs::new(&vec![view; views])).map_err(text))?;
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
    let culled = count(&of_one);
    println!("{most} views, {culled} figures culled");
    if culled > 5 && culled < 60 { Ok(()) } else { Err("too few of a kind".to_owned()) }
}

/// Frames are dropped, swapped, of another pose or the same. Models are deformed before some, for their views or for others.
fn histories() -> Result<(), String> {
    let (mut sum, mut late, mut noticed) = (Drawn::default(), 0, 0);
    for seed in 4201..if is_long() { 4301 } else { 4209 } {
        let mut play = Play::new(seed, 24)?;
        let mut late_frames: Vec<Recorded> = Vec::new();
        for step in 0..16 {
            let what = |error| format!("step {step}: {error}");
            let mut encoder = encoder(&play.gpu);
            play.set_pose()?;
            match play.random.below(4) {
                0 => play.deform(&mut encoder, &play.next.cameras.clone())?,
                1 => {
                    let other = camera(&mut play.random);
                    play.deform(&mut encoder, &[other])?;
                }
                _ => {}
            }
            let recorded = play.record(encoder).map_err(what)?;
            match play.random.below(4) {
                0 => {}
                1 => late_frames.push(recorded),
                _ => {
                    let drawn = play.check(recorded).map_err(what)?;
                    sum.culled += drawn.culled;
                    sum.cached_pairs += drawn.cached_pairs;
                    sum.instances += drawn.instances;
                }
            }
            if play.random.below(3) == 0 && !late_frames.is_empty() {
                let recorded = late_frames.swap_remove(play.random.below(late_frames.len()));
                play.check(recorded).map_err(|error| format!("late, {}", what(error)))?;
                late += 1;
            }
            // Figures move in a quarter of the frames, cameras in half of them.
            let Play { random, stage, next, .. } = &mut play;
            match random.below(4) {
                0 => walk(&mut next.walkers, random),
                1 => {
                    let light = random.below(next.lights.len());
                    next.lights[light] = Light::point(position(random).to_array()).with_range(6.0);
                    stage.scene.set_light(stage.lights[light], next.lights[light]).map_err(text)?;
                }
                _ => next.cameras = (0..=random.below(2)).map(|_| camera(random)).collect(),
            }
        }
        // Negative control: figures that walk on.
        play.set_pose()?;
        let mut recorded = play.record(encoder(&play.gpu))?;
        walk(&mut recorded.moment.walkers, &mut play.random);
        noticed += u32::from(play.check(recorded).is_err());
    }
    println!("{sum:?}, {late} late, {noticed} controls");
    let is_vacuous = sum.culled < 200 || sum.cached_pairs < 200 || sum.instances < 10_000 || late < 5 || noticed < 6;
    if is_vacuous { Err("too few of a kind".to_owned()) } else { Ok(()) }
}

/// A frame before `deform` is stale. A `deform` whose encoder is dropped spoils one frame, and none after it.
fn dropped() -> Result<(), String> {
    let mut play = Play::new(4501, 24)?;
    for number in 0..6 {
        let before = play.frame()?;
        walk(&mut play.next.walkers, &mut play.random);
        play.set_pose()?;
        before.check_current().map_err(text)?;
        let cameras = play.next.cameras.clone();
        play.deform(&mut encoder(&play.gpu), &cameras)?;
        if before.check_current() != Err(ShadowError::StaleFrame) {
            return Err("a frame whose positions are overwritten is not refused".to_owned());
        }
        // The positions of this frame were never computed.
        let spoilt = play.record(encoder(&play.gpu))?;
        play.gpu.queue.submit([spoilt.encoder.finish()]);
        let recorded = play.record(encoder(&play.gpu))?;
        play.check(recorded).map_err(|error| format!("frame {number}: {error}"))?;
    }
    Ok(())
}

/// Between `deform` and the encode a light moves or is added, casters get lights, or camera or pose change: other
/// figures are needed then.
fn changed() -> Result<(), String> {
    for number in 0..25 {
        let mut play = Play::new(4511 + number, 24)?;
        let casters = play.stage.scene.casters(play.stage.model).map_err(text)?.to_vec();
        let set_all = |scene: &mut Scene, mask: LightMask| {
            casters.iter().try_for_each(|&caster| scene.set_lights(caster, mask)).map_err(text)
        };
        if number % 5 == 4 {
            set_all(&mut play.stage.scene, LightMask::NONE)?;
        }
        play.frame()?;
        let (mut encoder, cameras) = (encoder(&play.gpu), play.next.cameras.clone());
        play.deform(&mut encoder, &cameras)?;
        let Play { random, stage, next, .. } = &mut play;
        let light = Light::point(position(random).to_array());
        match number % 5 {
            0 => {
                // The light affected few figures before.
                let last = next.lights.len() - 1;
                stage.scene.set_light(stage.lights[last], light).map_err(text)?;
                next.lights[last] = light;
            }
            1 => {
                stage.scene.add_light(light).map_err(text)?;
                next.lights.push(light);
            }
            2 => next.cameras = vec![camera(random)],
            4 => set_all(&mut stage.scene, LightMask::ALL)?,
            _ => {
                walk(&mut next.walkers, random);
                play.set_pose()?;
            }
        }
        let recorded = play.record(encoder)?;
        play.check(recorded).map_err(|error| format!("frame {number}: {error}"))?;
    }
    Ok(())
}

/// Without the level, a camera or a box all figures are needed. A displacement that may move them anywhere leaves no box.
fn off() -> Result<(), String> {
    let mut play = Play::new(4401, 9)?;
    let source = "fn displace(position: vec3<f32>, vertex: u32, time: f32) -> vec3<f32> { return position; }";
    let displacement = Displacement::new(source).map_err(text)?;
    // Far away and looking farther, and no light.
    let mut away = play.next.cameras[0];
    away.origin = [0, 1, 2].map(|axis| 1e4 * away.view_projection[axis][3]);
    for (culls, cameras, displaced_by, expected) in [
        (true, vec![away], Some(0.0), 9),
        (true, vec![away], None, 9),
        (false, vec![away], Some(0.0), 0),
        (true, Vec::new(), Some(0.0), 0),
        (true, vec![away], Some(f32::INFINITY), 0),
    ] {
        let mut options = options();
        options.measuring.set(Measuring::CULLED_CASTERS, !culls);
        play.stage = Stage::new(&play.gpu, &play.crowd, &play.pose()?, &[], options)?;
        if let Some(displaced_by) = displaced_by {
            play.displace(&displacement, displaced_by)?;
        }
        let Play { gpu, stage, .. } = &mut play;
        gpu.submit(|encoder| stage.scene.encode(encoder, FrameInputs::new(&views(&cameras))).map_err(text))?;
        let found = count(&points(&stage.positions(gpu)?, 9));
        same(&format!("{culls}, {} cameras, {displaced_by:?}", cameras.len()), &[found], &[expected])?;
    }
    Ok(())
}

/// Figures become their mirror images and back: their faces are turned then, also excluded ones.
fn mirrored() -> Result<(), String> {
    let mut play = Play::new(4701, 12)?;
    let (mut turned, mut noticed) = (0, 0);
    for step in 0..12 {
        let Play { random, next, .. } = &mut play;
        for walker in &mut next.walkers {
            walker.is_mirrored ^= random.below(3) == 0;
            turned += u32::from(walker.is_mirrored);
        }
        next.cameras = vec![camera(random)];
        play.set_pose()?;
        let mut recorded = play.record(encoder(&play.gpu))?;
        if step % 4 == 3 {
            recorded.moment.walkers.iter_mut().for_each(|walker| walker.is_mirrored ^= true);
            noticed += u32::from(play.check(recorded).is_err());
        } else {
            play.check(recorded).map_err(|error| format!("step {step}: {error}"))?;
        }
    }
    // Faces stay excluded.
    let exclude = |scene: &mut Scene, casters: &[_], lights: &[_]| {
        let mut pairs = casters.iter().flat_map(|&caster| lights.iter().map(move |&light| (caster, light)));
        pairs.try_for_each(|(caster, light)| scene.set_excluded(caster, light, &[0, 1, 2, 3, 9])).map_err(text)
    };
    let casters = play.stage.scene.casters(play.stage.model).map_err(text)?.to_vec();
    exclude(&mut play.stage.scene, &casters, &play.stage.lights)?;
    play.next.walkers.iter_mut().for_each(|walker| walker.is_mirrored ^= true);
    play.next.cameras = (0..2).map(|_| camera(&mut play.random)).collect();
    let frame = play.frame()?;
    let found = play.volumes(&frame)?;
    let mut other = play.apart(DeformerOptions::default())?;
    let pose = play.pose()?;
    let volumes = |other: &mut Apart| {
        let frame = play.gpu.submit(|encoder| other.encode(encoder, (&pose, 0.0), &play.next.cameras))?;
        play.volumes(&frame)
    };
    let whole = volumes(&mut other)?;
    exclude(&mut other.scene, &other.casters, &other.lights)?;
    let expected = volumes(&mut other)?;
    same("excluded faces", &found.instances, &expected.instances)?;
    must_fail("none excluded", &same("excluded faces", &whole.instances, &expected.instances))?;
    println!("{turned} mirrored, {noticed} controls");
    if turned < 30 || noticed < 2 { Err("too few of a kind".to_owned()) } else { Ok(()) }
}

/// A displacement that depends on time: as in a caller's deformer, and cached while the time is the same.
fn displaced() -> Result<(), String> {
    let mut play = Play::new(4801, 8)?;
    let source = "fn displace(position: vec3<f32>, vertex: u32, time: f32) -> vec3<f32> {
        return position + 0.2 * vec3<f32>(sin(time + f32(vertex)), 0.0, 0.0);
    }";
    let displacement = Displacement::new(source).map_err(text)?;
    play.displace(&displacement, 0.201)?;
    let mut other = play.apart(DeformerOptions { displacement: Some(&displacement), ..DeformerOptions::default() })?;
    let pose = play.pose()?;
    let Play { gpu, stage, .. } = &mut play;
    let mut cached = Vec::new();
    for time_s in [0.0, 1.0, 1.0, 2.0] {
        let inputs = PoseInputs { time_s, displaced_by: 0.201, ..PoseInputs::new(&pose) };
        stage.scene.set_pose(stage.model, inputs).map_err(text)?;
        // Without a view all figures are needed.
        let frame = gpu.submit(|encoder| stage.scene.encode(encoder, FrameInputs::default()).map_err(text))?;
        gpu.submit(|encoder| other.encode(encoder, (&pose, time_s), &[]))?;
        same(&format!("time {time_s}"), &stage.positions(gpu)?, &other.positions(gpu)?)?;
        let statistics = gpu.read::<SceneStatistics>(frame.statistics(), 1)?[0];
        cached.push(statistics.cached_pairs == statistics.pairs);
    }
    same("all cached", &cached, &[false, false, true, false])
}

/// Occluded faces are of static casters. A version that was searched says nothing about the poses of a scene's own model.
fn occluded() -> Result<(), String> {
    let mut play = Play::new(4851, 3)?;
    let light = play.next.lights[2];
    let mut other = play.apart(DeformerOptions::default())?;
    let pose = play.pose()?;
    play.gpu.submit(|encoder| other.encode(encoder, (&pose, 0.0), &[]))?;
    let positions = other.positions(&play.gpu)?.into_iter().map(|p| p.map(f32::from_bits)).collect::<Vec<_>>();
    let geometry = &play.crowd.model.geometries()[0];
    let mesh = geometry.mesh().map_err(text)?;
    // The first versions that a scene counts, and those of the caller.
    let walkers = positions.chunks(geometry.positions().len());
    let searched: Vec<_> =
        walkers.map(|positions| OcclusionCaster { mesh: &mesh, positions, version: Some(1) }).collect();
    let go_on = |_, _| ControlFlow::Continue(());
    let found = OccludedFaces::find(light, &searched, OcclusionOptions::default(), go_on).map_err(text)?;
    let casters = play.stage.scene.casters(play.stage.model).map_err(text)?.to_vec();
    play.stage.scene.set_occluded_faces(play.stage.lights[2], &casters, Some(&found)).map_err(text)?;
    let frame = play.frame()?;
    for &caster in &other.casters {
        other.scene.set_position_version(caster, Some(1)).map_err(text)?;
    }
    other.scene.set_occluded_faces(other.lights[2], &other.casters, Some(&found)).map_err(text)?;
    let held = play.gpu.submit(|encoder| other.encode(encoder, (&pose, 0.0), &[]))?;
    same("ignored", &[frame.occluded_faces().ignored, held.occluded_faces().ignored], &[1, 0])
}

/// Two models. One is removed before a frame of both is submitted.
fn come_and_go() -> Result<(), String> {
    let [mut play, mut alone] = [Play::new(4901, 5)?, Play::new(4902, 3)?];
    // Both scenes have the same lights and camera.
    alone.next = Moment { walkers: alone.next.walkers, ..play.next.clone() };
    let pose = alone.pose()?;
    alone.stage = Stage::new(&alone.gpu, &alone.crowd, &pose, &alone.next.lights, options())?;
    let frame = play.frame()?;
    let first = play.volumes(&frame)?;
    let frame = alone.frame()?;
    let expected = alone.volumes(&frame)?;
    let inserted = play.stage.scene.insert_model(&alone.crowd.model, &pose, DeformerOptions::default());
    let recorded = play.record(encoder(&play.gpu))?;
    let model = std::mem::replace(&mut play.stage.model, inserted.map_err(text)?);
    play.stage.scene.remove_model(model).map_err(text)?;
    play.gpu.queue.submit([recorded.encoder.finish()]);
    let bits: Vec<u32> = (0..play.next.lights.len() as u32).collect();
    let both = recorded.volumes.read(&play.gpu, &bits)?;
    let sum = |of: &Volumes| of.instances.iter().flatten().sum::<u32>();
    same("both", &[sum(&both)], &[sum(&first) + sum(&expected)])?;
    let Play { gpu, stage, next, .. } = &mut play;
    let frame = gpu.submit(|encoder| stage.encode(encoder, &pose, &next.cameras))?;
    same("the second alone", &play.volumes(&frame)?.instances, &expected.instances)?;
    same("its positions", &play.stage.positions(&play.gpu)?, &alone.stage.positions(&play.gpu)?)?;
    let removed = ShadowError::Removed { what: "model" };
    same("its handle", &[play.stage.scene.set_pose(model, &pose)], &[Err(removed.clone())])?;
    same("once more", &[play.stage.scene.remove_model(model)], &[Err(removed)])?;
    must_fail("one", &same("both", &[sum(&both)], &[sum(&expected)]))
}

/// Calls that instances refuse, and poses that do not fit.
fn refusals() -> Result<(), String> {
    let [mut play, fewer] = [Play::new(4501, 4)?, Play::new(4502, 3)?];
    let (pose, other_pose) = (play.pose()?, fewer.pose()?);
    let frame = play.frame()?;
    let (expected, bytes) = (play.volumes(&frame)?, frame.results().map_err(text)?.bytes);
    let model = play.stage.model;
    let scene = &mut play.stage.scene;
    let caster = scene.casters(model).map_err(text)?[0];
    let positions = scene.positions(model).map(CasterPositions::from).map_err(text)?;
    let of_model = [
        scene.remove(caster),
        scene.set_bounds(caster, None),
        scene.set_position_version(caster, Some(1)),
        scene.set_transform(caster, [[0.0; 4]; 3]),
        scene.set_positions(caster, positions),
    ];
    same("instances", &of_model, &[const { Err(ShadowError::OfModel) }; 5])?;
    let wrong = DeformError::Model(ModelError::PoseInstances { given: 3, needed: 4 });
    let wrong = Err(ShadowError::Deform(wrong));
    same("a pose", &[scene.set_pose(model, &other_pose)], std::slice::from_ref(&wrong))?;
    let inserted = scene.insert_model(&play.crowd.model, &other_pose, DeformerOptions::default());
    same("a pose at first", &[inserted.map(drop)], &[wrong])?;
    let source = "@group(1) @binding(0) var<uniform> by: vec4<f32>;
        fn displace(position: vec3<f32>, vertex: u32, time: f32) -> vec3<f32> { return position + by.xyz; }";
    let displacement = Displacement::new(source).map_err(text)?;
    let options = DeformerOptions { displacement: Some(&displacement), ..DeformerOptions::default() };
    let resources = Err(ShadowError::Deform(DeformError::Resources));
    same("no layout", &[scene.insert_model(&play.crowd.model, &pose, options).map(drop)], &[resources])?;
    let mut other = fewer.stage.scene;
    let found = [
        other.set_pose(model, &pose),
        other.remove_model(model),
        other.casters(model).map(drop),
        other.positions(model).map(drop),
    ];
    let foreign = [const { Err(ShadowError::OtherScene { what: "model" }) }; 4];
    same("another scene", &found, &foreign)?;
    must_fail("none", &same("another scene", &[Ok(())], &foreign[..1]))?;
    let frame = play.frame()?;
    same("as before", &play.volumes(&frame)?.instances, &expected.instances)?;
    same("memory", &[frame.results().map_err(text)?.bytes], &[bytes])
}
