//! Stage `needs`: deforming casters that a frame does not need are not deformed, nothing is computed of them, and no
//! image shows it.

use std::ops::ControlFlow;
use std::sync::Arc;

use glam::{DVec3, DVec4};
use rimline::cpu::{OccludedFaces, OcclusionCaster, OcclusionOptions};
use rimline::gpu::{
    Capacities, Caster, CasterHandle, CasterPositions, DeformError, DeformerOptions, FrameInputs, LightHandle,
    LightMask, Measuring, ModelHandle, PoseInputs, Scene, SceneFrame, SceneOptions, SceneStatistics, ShadowError, View,
};
use rimline::model::Box3;
use rimline::{Cone, Displacement, Light, ModelError, Pose, ShadowCamera};
use rimline_testkit::cases::case;
use rimline_testkit::device::Gpu;
use rimline_testkit::dispatch::storage_layout;
use rimline_testkit::harness::Test;
use rimline_testkit::on_gpu::{limited, text, views};
use rimline_testkit::random::Random;
use rimline_testkit::refusals::{is, refusal, refused, shows};
use rimline_testkit::{IDENTITY, is_long, must_fail, same, shapes};

use crate::crowd::{Apart, Crowd, Walker, camera, lights, position, sees, walk};
use crate::histories::{VolumeBuffers, Volumes, volumes};
use crate::random_scene::encoder;

pub(crate) const TESTS: &[Test] = &[
    ("needs_cull_nothing_visible", nothing_visible),
    ("needs_of_as_many_views_as_are_looked_at", most_views),
    ("needs_of_lights_that_views_leave_out", left_out),
    ("figures_walk_out_of_need_and_back", histories),
    ("a_deform_that_is_dropped_spoils_one_frame", dropped),
    ("needs_of_more_instances_than_a_row_of_workgroups_takes", several_rows),
    ("lights_of_each_batch_need_figures", batches),
    ("needs_are_switched_off", off),
    ("models_that_are_displaced", displaced),
    ("resources_of_displacements_may_change_and_are_checked", resources),
    ("occluded_faces_do_not_hold_for_models", occluded),
    ("models_come_and_go", come_and_go),
    ("a_deform_is_no_encode_for_regions_of_removed_meshes", removed_mesh),
    ("models_that_are_refused_change_nothing", refusals),
];

/// Lists and caps have room for all. A draw of one that overflowed would have more instances.
fn options() -> SceneOptions {
    SceneOptions {
        capacities: Capacities { lists: Some(u32::MAX), caps: Some(u32::MAX), ..Default::default() },
        ..SceneOptions::default()
    }
}

/// The figures, lights and cameras of a frame.
#[derive(Clone)]
struct Moment {
    walkers: Vec<Walker>,
    lights: Vec<Light>,
    cameras: Vec<ShadowCamera>,
    /// The lights of the two views.
    masks: [LightMask; 2],
}

impl Moment {
    fn views_of(&self, cameras: &[ShadowCamera]) -> Vec<View<'static>> {
        cameras.iter().zip(self.masks).map(|(&camera, lights)| View { lights, ..View::new(camera) }).collect()
    }
}

/// A crowd in a scene that deforms it as far as a frame needs, and what is to be drawn next.
struct Play {
    gpu: Arc<Gpu>,
    random: Random,
    crowd: Crowd,
    scene: Scene,
    model: ModelHandle,
    lights: Vec<LightHandle>,
    /// Whether [`exclude`] was called.
    excludes: bool,
    next: Moment,
}

/// A recorded frame, and its moment.
struct Recorded {
    encoder: wgpu::CommandEncoder,
    volumes: VolumeBuffers,
    statistics: wgpu::Buffer,
    moment: Moment,
}

/// Counts of a frame, or sums over frames.
#[derive(Debug, Default)]
struct Drawn {
    culled: u32,
    cached_pairs: u32,
    instances: u32,
    mirrored: usize,
}

impl Play {
    fn new(seed: u64, walkers: usize) -> Result<Self, String> {
        let (gpu, mut random) = Gpu::seeded(seed)?;
        let crowd = Crowd::new(walkers)?;
        let (lights, walkers) = (lights(&mut random), crowd.walkers(&mut random));
        let next = Moment { walkers, lights, cameras: vec![camera(&mut random)], masks: [LightMask::ALL; 2] };
        let (scene, model, lights) = staged(&gpu, &crowd, &next, options())?;
        Ok(Self { gpu, random, crowd, scene, model, lights, excludes: false, next })
    }

    fn pose(&self) -> Result<Pose, String> {
        self.crowd.pose(&self.next.walkers)
    }

    fn casters(&self) -> Result<Vec<CasterHandle>, String> {
        self.scene.casters(self.model).map(<[_]>::to_vec).map_err(text)
    }

    fn set_pose(&mut self) -> Result<(), String> {
        let pose = self.pose()?;
        self.scene.set_pose(self.model, &pose).map_err(text)
    }

    fn set_all(&mut self, mask: LightMask) -> Result<(), String> {
        self.casters()?.into_iter().try_for_each(|caster| self.scene.set_lights(caster, mask)).map_err(text)
    }

    fn deform(&mut self, encoder: &mut wgpu::CommandEncoder, cameras: &[ShadowCamera]) -> Result<(), String> {
        let inputs = self.next.views_of(cameras);
        self.scene.deform(encoder, FrameInputs::new(&inputs)).map_err(text)
    }

    /// Records a frame into an encoder, in which the models may be deformed already. Call [`Self::set_pose`] before, if
    /// figures changed.
    fn record(&mut self, mut encoder: wgpu::CommandEncoder) -> Result<Recorded, String> {
        let inputs = self.next.views_of(&self.next.cameras);
        let frame = self.scene.encode(&mut encoder, FrameInputs::new(&inputs)).map_err(text)?;
        let volumes = VolumeBuffers::new(&frame, self.next.cameras.len())?;
        Ok(Recorded { encoder, volumes, statistics: frame.statistics().clone(), moment: self.next.clone() })
    }

    /// Submits a frame in the next pose.
    fn frame(&mut self) -> Result<SceneFrame, String> {
        self.set_pose()?;
        let inputs = views(&self.next.cameras);
        self.gpu.submit(|encoder| self.scene.encode(encoder, FrameInputs::new(&inputs)).map_err(text))
    }

    fn volumes(&self, frame: &SceneFrame) -> Result<Volumes, String> {
        volumes(&self.gpu, frame, self.next.cameras.len())
    }

    /// For each figure whether all its vertices are at the origin: it is culled, or nothing was deformed so far.
    fn culled(&self) -> Result<Vec<bool>, String> {
        let found = self.positions()?;
        let walkers = found.chunks(found.len() / self.next.walkers.len());
        Ok(walkers.map(|walker| walker.iter().all(|position| *position == [0; 3])).collect())
    }

    /// Deforms for these views. For each figure whether it is culled.
    fn culled_in(&mut self, views: &[View<'_>]) -> Result<Vec<bool>, String> {
        self.gpu.submit(|encoder| self.scene.deform(encoder, FrameInputs::new(views)).map_err(text))?;
        self.culled()
    }

    fn positions(&self) -> Result<Vec<[u32; 3]>, String> {
        self.gpu.read(self.scene.positions(self.model).map_err(text)?.buffer, usize::MAX)
    }

    /// A new scene of a moment. Its caller deforms everything.
    fn apart(&self, moment: &Moment, deforming: DeformerOptions<'_>) -> Result<Apart, String> {
        let pose = self.crowd.pose(&moment.walkers)?;
        Apart::new(&self.gpu, &self.crowd, &pose, &moment.lights, (options(), deforming))
    }

    /// Inserts the model anew, with a displacement.
    fn displace(&mut self, by: &Displacement, displaced_by: f32) -> Result<(), String> {
        let pose = self.pose()?;
        self.scene.remove_model(self.model).map_err(text)?;
        let options = DeformerOptions { displacement: Some(by), ..DeformerOptions::default() };
        let pose = PoseInputs { displaced_by, ..PoseInputs::new(&pose) };
        self.model = self.scene.insert_model(&self.crowd.model, pose, options).map_err(text)?;
        Ok(())
    }

    /// Submits a recorded frame, and compares it with a new scene whose caller deforms everything.
    fn check(&self, recorded: Recorded) -> Result<Drawn, String> {
        let Recorded { encoder, volumes: recorded, statistics, moment } = recorded;
        let (gpu, count) = (&self.gpu, moment.walkers.len());
        gpu.queue.submit([encoder.finish()]);
        let bits: Vec<u32> = (0..moment.lights.len() as u32).collect();
        let found = recorded.read(gpu, &bits)?;
        let statistics = gpu.read::<SceneStatistics>(&statistics, 1)?[0];
        let mut other = self.apart(&moment, DeformerOptions::default())?;
        if self.excludes {
            exclude(&mut other.scene, &other.casters, &other.lights)?;
        }
        let pose = self.crowd.pose(&moment.walkers)?;
        let inputs = moment.views_of(&moment.cameras);
        let frame = gpu.submit(|encoder| other.encode(encoder, (&pose, 0.0), &inputs))?;
        same("instances", &found.instances, &volumes(gpu, &frame, moment.cameras.len())?.instances)?;
        let (positions, all, culled) = (self.positions()?, other.positions(gpu)?, self.culled()?);
        let vertices = all.len() / count;
        for (number, _) in culled.iter().enumerate().filter(|(_, is_culled)| !**is_culled) {
            let range = number * vertices..(number + 1) * vertices;
            same(&format!("figure {number}"), &positions[range.clone()], &all[range])?;
        }
        same("culled figures", &[statistics.culled_casters], &[number_of(&culled)])?;
        Ok(Drawn {
            culled: number_of(&culled),
            cached_pairs: statistics.cached_pairs,
            instances: found.instances.iter().flatten().sum(),
            mirrored: moment.walkers.iter().filter(|walker| walker.is_mirrored).count(),
        })
    }

    /// Figures, a light or cameras change, or a light is added.
    fn change(&mut self) -> Result<(), String> {
        let Self { random, scene, next, lights, .. } = self;
        match random.below(8) {
            0 | 1 => walk(&mut next.walkers, random),
            2 if lights.len() < 8 => {
                let light = Light::point(position(random).to_array()).with_range(6.0);
                lights.push(scene.add_light(light).map_err(text)?);
                next.lights.push(light);
            }
            3 | 4 => {
                let light = random.below(next.lights.len());
                next.lights[light] = Light::point(position(random).to_array()).with_range(6.0);
                scene.set_light(lights[light], next.lights[light]).map_err(text)?;
            }
            _ => next.cameras = (0..=random.below(2)).map(|_| camera(random)).collect(),
        }
        Ok(())
    }
}

fn staged(
    gpu: &Gpu,
    crowd: &Crowd,
    Moment { walkers, lights, .. }: &Moment,
    options: SceneOptions,
) -> Result<(Scene, ModelHandle, Vec<LightHandle>), String> {
    let mut scene = Scene::new(&gpu.pipelines, &gpu.queue, options).map_err(text)?;
    let lights = lights.iter().map(|light| scene.add_light(*light).map_err(text)).collect::<Result<_, _>>()?;
    let pose = crowd.pose(walkers)?;
    let model = scene.insert_model(&crowd.model, &pose, DeformerOptions::default()).map_err(text)?;
    Ok((scene, model, lights))
}

/// Excludes faces of all casters for two lights.
fn exclude(scene: &mut Scene, casters: &[CasterHandle], lights: &[LightHandle]) -> Result<(), String> {
    // All over a figure, so that some are on any silhouette.
    let faces: Vec<u32> = (0..1200).step_by(17).collect();
    let mut pairs = casters.iter().flat_map(|&caster| lights[..2].iter().map(move |&light| (caster, light)));
    pairs.try_for_each(|(caster, light)| scene.set_excluded(caster, light, &faces)).map_err(text)
}

fn number_of(culled: &[bool]) -> u32 {
    culled.iter().filter(|is_culled| **is_culled).count() as u32
}

/// Fails if a camera sees one of some points at random in a culled figure's box, or one of their shadows within a light's
/// range and cone. Shares no code but for the box.
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

/// Random sizes, masks, lights and cameras, and figures without a box, since numbers of their pose may overflow.
fn nothing_visible() -> Result<(), String> {
    let (mut culled, mut needed, mut noticed, mut boxless) = (0, 0, 0, 0);
    for seed in 4101..if is_long() { 4301 } else { 4111 } {
        let mut play = Play::new(seed, 60)?;
        let casters = play.casters()?;
        for _ in 0..4 {
            let Play { random, scene, lights, next, .. } = &mut play;
            next.cameras = (0..=random.below(2)).map(|_| camera(random)).collect();
            let mut masks = Vec::new();
            for (walker, &caster) in next.walkers.iter_mut().zip(&casters) {
                walker.at = position(random);
                walker.size = if random.below(20) > 0 { random.between(0.0, 1.5) } else { 4e37 };
                let mask = random.below(64) as u32;
                let allowed = lights.iter().filter(|light| mask >> light.bit() & 1 != 0).copied();
                scene.set_lights(caster, LightMask::only(allowed)).map_err(text)?;
                masks.push(mask);
            }
            let frame = play.frame()?;
            let found = play.culled()?;
            let statistics = play.gpu.read::<SceneStatistics>(frame.statistics(), 1)?[0];
            same("counted", &[statistics.culled_casters], &[number_of(&found)])?;
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
    // Few figures are deformed without need: those without a box, boxes near the frustum's edges, and boxes that samples
    // miss.
    let is_meant = culled > 500 && noticed > 300 && needed < noticed && boxless > 50;
    if is_meant { Ok(()) } else { Err("too few of a kind".to_owned()) }
}

/// A view many times over. Only its last copy decides that a figure is culled, so loops have all their turns. llvmpipe
/// ends an invocation's loops after 65,535 turns without a word. An invocation tests at most 2,500 boxes (`NEEDS_BOXES`): for
/// each view one, and one for each light. If there are more, all casters are needed.
fn most_views() -> Result<(), String> {
    let mut play = Play::new(4601, 60)?;
    let most = 2500 / (play.next.lights.len() + 1);
    let view = View::new(play.next.cameras[0]);
    let mut found = Vec::new();
    for views in [1, most, most + 1] {
        found.push(play.culled_in(&vec![view; views])?);
    }
    same("as many as are looked at", &found[1], &found[0])?;
    same("one more", &found[2], &[false; 60])?;
    must_fail("one more", &same("one more", &found[1], &found[2]))?;
    let culled = number_of(&found[0]);
    if culled > 5 && culled < 60 { Ok(()) } else { Err(format!("{culled} of 60 figures culled")) }
}

/// A view needs figures for its own lights, as if they had no others; without lights only those that it sees. Figures deformed
/// for fewer lights are deformed anew.
fn left_out() -> Result<(), String> {
    let mut fewer = 0;
    for seed in 4701..4705 {
        let mut play = Play::new(seed, 60)?;
        let cameras = [play.next.cameras[0], camera(&mut play.random), camera(&mut play.random)];
        let light = play.lights[seed as usize % play.lights.len()];
        let masks = [LightMask::only([light]), LightMask::ALL.without(light), LightMask::NONE];
        let mut in_all = vec![true; 60];
        for (camera, mask) in cameras.into_iter().zip(masks) {
            play.set_all(mask)?;
            let of_view = play.culled_in(&[View::new(camera)])?;
            in_all.iter_mut().zip(of_view).for_each(|(in_all, in_view)| *in_all &= in_view);
        }
        play.set_all(LightMask::ALL)?;
        let whole = cameras.map(View::new);
        let parts = [0, 1, 2].map(|number| View { lights: masks[number], ..whole[number] });
        let (culled, found) = (play.culled_in(&whole)?, play.culled_in(&parts)?);
        same(&format!("seed {seed}"), &found, &in_all)?;
        fewer += number_of(&found) - number_of(&culled);
        for (deformed, encoded) in [(parts, whole), (whole, parts)] {
            play.gpu.submit(|encoder| {
                play.scene.deform(encoder, FrameInputs::new(&deformed)).map_err(text)?;
                play.scene.encode(encoder, FrameInputs::new(&encoded)).map(drop).map_err(text)
            })?;
            same(&format!("seed {seed}, encoded"), &play.culled()?, &culled)?;
        }
    }
    if fewer > 0 { Ok(()) } else { Err("no view needs fewer figures for fewer lights".to_owned()) }
}

/// The lights of two views at a step: all, all but one, or one.
fn masks(lights: &[LightHandle], step: usize) -> [LightMask; 2] {
    [step, step + 1].map(|number| match (number % 3, lights[number % lights.len()]) {
        (0, _) => LightMask::ALL,
        (1, light) => LightMask::ALL.without(light),
        (_, light) => LightMask::only([light]),
    })
}

/// Frames are dropped, swapped, of another pose or the same, of mirror images, with excluded faces or without. Views leave
/// out lights that they have in other frames. Models are deformed before some, for their views or for others, and something
/// changes between `deform` and the encode.
fn histories() -> Result<(), String> {
    let (mut sum, mut late, mut between, mut noticed, mut unexcluded) = (Drawn::default(), 0, 0, 0, 0);
    for seed in 4201..if is_long() { 4301 } else { 4213 } {
        let mut play = Play::new(seed, 24)?;
        play.excludes = seed % 4 == 0;
        if play.excludes {
            let casters = play.casters()?;
            exclude(&mut play.scene, &casters, &play.lights)?;
        }
        let mut late_frames: Vec<Recorded> = Vec::new();
        for step in 0..16 {
            let what = |error| format!("step {step}: {error}");
            let mut encoder = encoder(&play.gpu);
            play.set_pose()?;
            play.next.masks = masks(&play.lights, step);
            let gets_lights = play.random.below(8) == 0;
            if gets_lights {
                play.set_all(LightMask::NONE)?;
            }
            let is_deformed = play.random.below(2) == 0;
            if is_deformed {
                let other = camera(&mut play.random);
                let cameras = [play.next.cameras.clone(), vec![other]];
                play.deform(&mut encoder, &cameras[step % 2])?;
            }
            let changes = play.random.below(3) == 0;
            if changes {
                play.change()?;
                play.set_pose()?;
            }
            if gets_lights {
                play.set_all(LightMask::ALL)?;
            }
            between += u32::from(is_deformed && (changes || gets_lights));
            // In half of the steps views get lights or lose some.
            play.next.masks = masks(&play.lights, step + step / 2 % 2);
            let recorded = play.record(encoder).map_err(what)?;
            match play.random.below(4) {
                0 => {}
                1 => late_frames.push(recorded),
                _ => {
                    let drawn = play.check(recorded).map_err(what)?;
                    sum.culled += drawn.culled;
                    sum.cached_pairs += drawn.cached_pairs;
                    sum.instances += drawn.instances;
                    sum.mirrored += drawn.mirrored;
                }
            }
            if play.random.below(3) == 0 && !late_frames.is_empty() {
                let recorded = late_frames.swap_remove(play.random.below(late_frames.len()));
                play.check(recorded).map_err(|error| format!("late, {}", what(error)))?;
                late += 1;
            }
            play.change()?;
        }
        // Negative control: figures that walk on.
        play.set_pose()?;
        let mut recorded = play.record(encoder(&play.gpu))?;
        walk(&mut recorded.moment.walkers, &mut play.random);
        noticed += u32::from(play.check(recorded).is_err());
        // Another one: faces that the other scene does not exclude.
        if play.excludes {
            play.next.cameras = (0..2).map(|_| camera(&mut play.random)).collect();
            let recorded = play.record(encoder(&play.gpu))?;
            play.excludes = false;
            unexcluded += u32::from(play.check(recorded).is_err());
        }
    }
    println!("{sum:?}, {late} late, {between} changes after a deform, {noticed} and {unexcluded} controls");
    let is_vacuous = sum.culled < 200 || sum.cached_pairs < 200 || sum.instances < 10_000 || late < 5 || noticed < 9;
    if is_vacuous || sum.mirrored < 200 || between < 25 || unexcluded == 0 {
        Err("too few of a kind".to_owned())
    } else {
        Ok(())
    }
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
        same("overwritten", &[before.check_current()], &[Err(ShadowError::StaleFrame)])?;
        // The positions of this frame were never computed.
        let spoilt = play.record(encoder(&play.gpu))?;
        must_fail("the spoilt frame", &play.check(spoilt))?;
        let recorded = play.record(encoder(&play.gpu))?;
        play.check(recorded).map_err(|error| format!("frame {number}: {error}"))?;
    }
    Ok(())
}

/// Without the level, a camera or a box all figures are needed. A displacement that may move them anywhere leaves no box.
fn off() -> Result<(), String> {
    let mut play = Play::new(4401, 9)?;
    let source = "fn displace(position: vec3<f32>, vertex: u32, time: f32) -> vec3<f32> { return position; }";
    let displacement = Displacement::new(source).map_err(text)?;
    // Far away and looking farther, or past them, and no light.
    play.next.lights.clear();
    let [mut away, mut beside] = [play.next.cameras[0]; 2];
    away.origin = [0, 1, 2].map(|axis| 1e4 * away.view_projection[axis][3]);
    beside.origin = [0, 1, 2].map(|axis| 1e4 * beside.view_projection[axis][0] - 1e3 * beside.view_projection[axis][3]);
    for (culls, cameras, displaced_by, expected) in [
        (true, &[away][..], Some(0.0), 9),
        (true, &[away], None, 9),
        (true, &[beside], None, 9),
        (false, &[away], Some(0.0), 0),
        (true, &[], Some(0.0), 0),
        (true, &[away], Some(f32::INFINITY), 0),
    ] {
        let mut options = options();
        options.measuring.set(Measuring::CULLED_CASTERS, !culls);
        (play.scene, play.model, play.lights) = staged(&play.gpu, &play.crowd, &play.next, options)?;
        if let Some(displaced_by) = displaced_by {
            play.displace(&displacement, displaced_by)?;
        }
        let inputs = views(cameras);
        play.gpu.submit(|encoder| play.scene.encode(encoder, FrameInputs::new(&inputs)).map_err(text))?;
        let found = number_of(&play.culled()?);
        same(&format!("{culls}, {} cameras, {displaced_by:?}", cameras.len()), &[found], &[expected])?;
    }
    Ok(())
}

/// A displacement that depends on time: as in a caller's deformer, and cached while the time is the same.
fn displaced() -> Result<(), String> {
    let mut play = Play::new(4801, 8)?;
    let source = "fn displace(position: vec3<f32>, vertex: u32, time: f32) -> vec3<f32> {
        return position + 0.2 * vec3<f32>(sin(time + f32(vertex)), 0.0, 0.0);
    }";
    let displacement = Displacement::new(source).map_err(text)?;
    play.displace(&displacement, 0.201)?;
    let deforming = DeformerOptions { displacement: Some(&displacement), ..DeformerOptions::default() };
    let (mut other, pose) = (play.apart(&play.next, deforming)?, play.pose()?);
    for (time_s, is_cached) in [(0.0, false), (1.0, false), (1.0, true), (2.0, false)] {
        let inputs = PoseInputs { time_s, displaced_by: 0.201, ..PoseInputs::new(&pose) };
        play.scene.set_pose(play.model, inputs).map_err(text)?;
        // Without a view all figures are needed.
        let frame = play.gpu.submit(|encoder| play.scene.encode(encoder, FrameInputs::default()).map_err(text))?;
        play.gpu.submit(|encoder| other.encode(encoder, (&pose, time_s), &[]))?;
        same(&format!("time {time_s}"), &play.positions()?, &other.positions(&play.gpu)?)?;
        let SceneStatistics { pairs, cached_pairs, .. } = play.gpu.read::<SceneStatistics>(frame.statistics(), 1)?[0];
        same(&format!("all cached, time {time_s}"), &[cached_pairs == pairs], &[is_cached])?;
    }
    Ok(())
}

/// Occluded faces are of static casters. A version that was searched says nothing about the poses of a scene's own model.
fn occluded() -> Result<(), String> {
    let mut play = Play::new(4851, 3)?;
    let (mut other, pose) = (play.apart(&play.next, DeformerOptions::default())?, play.pose()?);
    play.gpu.submit(|encoder| other.encode(encoder, (&pose, 0.0), &[]))?;
    let positions = other.positions(&play.gpu)?.into_iter().map(|p| p.map(f32::from_bits)).collect::<Vec<_>>();
    let mesh = play.crowd.model.geometries()[0].mesh().map_err(text)?;
    // Version 1 is also the scene's own for the first pose of a model.
    let walkers = positions.chunks(positions.len() / 3);
    let searched: Vec<_> =
        walkers.map(|positions| OcclusionCaster { mesh: &mesh, positions, version: Some(1) }).collect();
    let go_on = |_, _| ControlFlow::Continue(());
    let found =
        OccludedFaces::find(play.next.lights[2], &searched, OcclusionOptions::default(), go_on).map_err(text)?;
    let casters = play.casters()?;
    play.scene.set_occluded_faces(play.lights[2], &casters, Some(&found)).map_err(text)?;
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
    (alone.scene, alone.model, alone.lights) = staged(&alone.gpu, &alone.crowd, &alone.next, options())?;
    let (first, expected) = (play.frame()?, alone.frame()?);
    let (first, expected) = (play.volumes(&first)?.instances, alone.volumes(&expected)?.instances);
    let pose = alone.pose()?;
    let second = play.scene.insert_model(&alone.crowd.model, &pose, DeformerOptions::default()).map_err(text)?;
    let recorded = play.record(encoder(&play.gpu))?;
    let model = std::mem::replace(&mut play.model, second);
    play.scene.remove_model(model).map_err(text)?;
    play.gpu.queue.submit([recorded.encoder.finish()]);
    let bits: Vec<u32> = (0..play.next.lights.len() as u32).collect();
    let both = recorded.volumes.read(&play.gpu, &bits)?.instances;
    let sum = |of: &[[u32; 6]]| of.iter().flatten().sum::<u32>();
    same("both", &[sum(&both)], &[sum(&first) + sum(&expected)])?;
    must_fail("one", &same("both", &[sum(&both)], &[sum(&expected)]))?;
    let inputs = views(&play.next.cameras);
    let frame = play.gpu.submit(|encoder| play.scene.encode(encoder, FrameInputs::new(&inputs)).map_err(text))?;
    same("the second alone", &play.volumes(&frame)?.instances, &expected)?;
    same("its positions", &play.positions()?, &alone.positions()?)?;
    let removed = || is(ShadowError::Removed { what: "model" });
    refused([
        refusal("its handle", play.scene.set_pose(model, &pose), removed()),
        refusal("once more", play.scene.remove_model(model), removed()),
    ])
}

/// A frame finds its mesh though the mesh was removed, models were deformed, and one frame was encoded before it is
/// submitted.
fn removed_mesh() -> Result<(), String> {
    let (_, positions, mesh) = case("cube", shapes::cube());
    let mut counts = Vec::new();
    for is_late in [false, true] {
        let mut play = Play::new(4951, 3)?;
        let cube = play.scene.add_mesh(&mesh, &positions).map_err(text)?;
        let caster = play.scene.insert(Caster::rigid(cube, IDENTITY)).map_err(text)?;
        let mut late = encoder(&play.gpu);
        let frame = play.scene.encode(&mut late, FrameInputs::default()).map_err(text)?;
        let groups = frame.results().map_err(text)?.groups;
        // The cube is the last caster, so its group is the last.
        let lists = groups.last().ok_or("no group")?.lists.clone();
        if is_late {
            play.scene.remove(caster).map_err(text)?;
            play.scene.remove_mesh(cube).map_err(text)?;
            play.deform(&mut encoder(&play.gpu), &[])?;
            play.scene.encode(&mut encoder(&play.gpu), FrameInputs::default()).map_err(text)?;
            // All its corners are one point, which has no silhouette.
            play.scene.add_mesh(&mesh, &vec![[0.0; 3]; positions.len()]).map_err(text)?;
        }
        play.gpu.queue.submit([late.finish()]);
        counts.push(play.gpu.read::<u32>(&lists, play.next.lights.len())?);
    }
    same("edges of the late frame", &counts[1], &counts[0])?;
    must_fail("no edges", &same("no edges", &counts[0], &vec![0; counts[0].len()]))
}

/// A refused pose changes nothing, and the next frame may have other resources.
fn resources() -> Result<(), String> {
    let gpu = &*Gpu::shared()?;
    let source = "@group(1) @binding(0) var<storage, read> by: array<vec4<f32>>;
        fn displace(position: vec3<f32>, vertex: u32, time: f32) -> vec3<f32> { return by[0].xyz; }";
    let displacement = Displacement::new(source).map_err(text)?;
    let layout = storage_layout(gpu, &[(0, true)]);
    let group = |layout: &wgpu::BindGroupLayout, binding, x: f32| {
        gpu.device.create_bind_group(&wgpu::BindGroupDescriptor {
            label: Some("displacement"),
            layout,
            entries: &[wgpu::BindGroupEntry {
                binding,
                resource: gpu.storage(&[[x, 3.0, 4.0, 0.0]]).as_entire_binding(),
            }],
        })
    };
    let [before, after] = [1.0, 2.0].map(|x| group(&layout, 0, x));
    let other = group(&storage_layout(gpu, &[(1, true)]), 1, 9.0);
    let crowd = Crowd::new(1)?;
    let pose = crowd.pose(&crowd.walkers(&mut Random::new(4963)))?;
    let inputs = |resources| PoseInputs { resources, ..PoseInputs::new(&pose) };
    let deforming = DeformerOptions {
        displacement: Some(&displacement),
        displacement_layout: Some(&layout),
        ..DeformerOptions::default()
    };
    let mut scene = Scene::new(&gpu.pipelines, &gpu.queue, options()).map_err(text)?;
    scene.add_light(Light::directional([0.4, 1.0, 0.1])).map_err(text)?;
    let model = scene.insert_model(&crowd.model, inputs(Some(&before)), deforming).map_err(text)?;
    let positions = |scene: &mut Scene| {
        gpu.submit(|encoder| scene.encode(encoder, FrameInputs::default()).map(drop).map_err(text))?;
        gpu.read::<[f32; 3]>(scene.positions(model).map_err(text)?.buffer, crowd.model.vertex_count())
    };
    let expected = |x: f32| vec![[x, 3.0, 4.0]; crowd.model.vertex_count()];
    same("before", &positions(&mut scene)?, &expected(1.0))?;
    refused([
        refusal("of another layout", scene.set_pose(model, inputs(Some(&other))), shows(&["Deform(BindGroup {"])),
        refusal("none", scene.set_pose(model, inputs(None)), is(ShadowError::Deform(DeformError::Resources))),
    ])?;
    same("still", &positions(&mut scene)?, &expected(1.0))?;
    scene.set_pose(model, inputs(Some(&after))).map_err(text)?;
    same("after", &positions(&mut scene)?, &expected(2.0))
}

/// An instance that the second row leaves out would have no state, and so would never be cached.
fn several_rows() -> Result<(), String> {
    let gpu = limited(1 << 27, 1 << 28, 2)?;
    let crowd = Crowd::new(130)?;
    let pose = crowd.pose(&crowd.walkers(&mut Random::new(4961)))?;
    let mut scene = Scene::new(&gpu.pipelines, &gpu.queue, options()).map_err(text)?;
    scene.add_light(Light::directional([0.4, 1.0, 0.1])).map_err(text)?;
    scene.insert_model(&crowd.model, &pose, DeformerOptions::default()).map_err(text)?;
    let mut pairs = Vec::new();
    for _ in 0..2 {
        let frame = gpu.submit(|encoder| scene.encode(encoder, FrameInputs::default()).map_err(text))?;
        let statistics = gpu.read::<SceneStatistics>(frame.statistics(), 1)?[0];
        pairs.push([statistics.pairs, statistics.cached_pairs]);
    }
    same("pairs, and cached ones", &pairs, &[[130, 0], [130, 130]])
}

/// A camera looks away from all figures. Only a light from behind throws their shadows before it.
fn batches() -> Result<(), String> {
    let mut play = Play::new(4701, 3)?;
    let mut camera = play.next.cameras[0];
    let forward = [0, 1, 2].map(|axis| camera.view_projection[axis][3]);
    camera.origin = forward.map(|c| 1e4 * c);
    let [ahead, behind] = [forward, forward.map(|c| -c)].map(Light::directional);
    play.next.lights = vec![ahead; 160];
    let options = SceneOptions { max_lights: 160, ..options() };
    (play.scene, play.model, play.lights) = staged(&play.gpu, &play.crowd, &play.next, options)?;
    let inputs = views(&[camera]);
    for bit in [0, 31, 32, 127, 128, 159] {
        let handle = play.lights[bit];
        for (what, light, mask, expected) in [
            ("behind", behind, LightMask::ALL, 0),
            ("for no caster", behind, LightMask::ALL.without(handle), 3),
            ("ahead", ahead, LightMask::ALL, 3),
        ] {
            play.scene.set_light(handle, light).map_err(text)?;
            play.set_all(mask)?;
            play.gpu.submit(|encoder| play.scene.deform(encoder, FrameInputs::new(&inputs)).map_err(text))?;
            same(&format!("light {bit} {what}"), &[number_of(&play.culled()?)], &[expected])?;
        }
    }
    Ok(())
}

/// Calls that instances refuse, poses that do not fit, a displacement without a layout, and handles of another scene.
fn refusals() -> Result<(), String> {
    let [mut play, fewer] = [Play::new(4501, 4)?, Play::new(4502, 3)?];
    let (pose, other_pose) = (play.pose()?, fewer.pose()?);
    let frame = play.frame()?;
    let (expected, bytes) = (play.volumes(&frame)?, frame.results().map_err(text)?.bytes);
    let (model, caster) = (play.model, play.casters()?[0]);
    let (scene, crowd) = (&mut play.scene, &play.crowd.model);
    let positions = scene.positions(model).map(CasterPositions::from).map_err(text)?;
    let source = "@group(1) @binding(0) var<uniform> by: vec4<f32>;
        fn displace(position: vec3<f32>, vertex: u32, time: f32) -> vec3<f32> { return position + by.xyz; }";
    let displacement = Displacement::new(source).map_err(text)?;
    let no_layout = DeformerOptions { displacement: Some(&displacement), ..DeformerOptions::default() };
    let of_model = || is(ShadowError::OfModel);
    let wrong = || is(ShadowError::Deform(DeformError::Model(ModelError::PoseInstances { given: 3, needed: 4 })));
    let foreign = || is(ShadowError::OtherScene { what: "model" });
    let mut other = fewer.scene;
    refused([
        refusal("remove", scene.remove(caster), of_model()),
        refusal("bounds", scene.set_bounds(caster, None), of_model()),
        refusal("a version", scene.set_position_version(caster, Some(1)), of_model()),
        refusal("a transform", scene.set_transform(caster, [[0.0; 4]; 3]), of_model()),
        refusal("positions", scene.set_positions(caster, positions), of_model()),
        refusal("a pose", scene.set_pose(model, &other_pose), wrong()),
        refusal("a pose at first", scene.insert_model(crowd, &other_pose, DeformerOptions::default()), wrong()),
        refusal(
            "no layout",
            scene.insert_model(crowd, &pose, no_layout),
            is(ShadowError::Deform(DeformError::Resources)),
        ),
        refusal("another scene's pose", other.set_pose(model, &pose), foreign()),
        refusal("its removal", other.remove_model(model), foreign()),
        refusal("its casters", other.casters(model), foreign()),
        refusal("its positions", other.positions(model), foreign()),
    ])?;
    let frame = play.frame()?;
    same("as before", &play.volumes(&frame)?.instances, &expected.instances)?;
    same("memory", &[frame.results().map_err(text)?.bytes], &[bytes])
}
