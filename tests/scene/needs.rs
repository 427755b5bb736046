//! Stage `needs`: figures that a frame does not need: they are not deformed, nothing is computed of them, and nothing shows it.

use glam::{DVec3, DVec4};
use rimline::gpu::{
    Capacities, DeformError, FrameInputs, LightMask, Measuring, SceneFrame, SceneNeeds, SceneOptions, SceneStatistics,
    ShadowError,
};
use rimline::model::Box3;
use rimline::{Cone, Light, ShadowCamera};
use rimline_testkit::device::Gpu;
use rimline_testkit::harness::Test;
use rimline_testkit::on_gpu::{text, views};
use rimline_testkit::random::Random;
use rimline_testkit::{is_long, must_fail, same};

use crate::crowd::{Crowd, Figure, Stage, camera, lights, place, sees, walk};
use crate::histories::{Volumes, buffers, volumes};

pub(crate) const TESTS: &[Test] = &[
    ("needs_hide_nothing", hide_nothing),
    ("needs_of_as_many_views_as_are_looked_at", most_views),
    ("figures_walk_out_of_need_and_back", histories),
    ("needs_are_switched_off", off),
    ("needs_that_do_not_fit_are_typed_errors", refusals),
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

fn words(gpu: &Gpu, needs: &SceneNeeds) -> Result<Vec<u32>, String> {
    gpu.read(needs.buffer(), needs.len())
}

fn volumes_of(gpu: &Gpu, frame: &SceneFrame, views: usize) -> Result<Volumes, String> {
    let (draws, statistics) = buffers(frame)?;
    let bits: Vec<u32> = frame.lights().iter().map(|(light, _)| light.bit()).collect();
    volumes(gpu, (&draws, &statistics), (views, frame.batches()), &bits)
}

fn positions(gpu: &Gpu, stage: &Stage) -> Result<Vec<[u32; 3]>, String> {
    gpu.read(stage.deformer.positions().buffer, usize::MAX)
}

/// A figure that the frame does not need is a point. All others are as where everything is deformed.
fn check_positions(found: &[[u32; 3]], all: &[[u32; 3]], unneeded: &[u32]) -> Result<(), String> {
    let count = all.len() / unneeded.len();
    for (number, word) in unneeded.iter().enumerate() {
        let own = number * count..(number + 1) * count;
        let expected = if *word != 0 { vec![[0; 3]; count] } else { all[own.clone()].to_vec() };
        same(&format!("figure {number}"), &found[own], &expected)?;
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
    let mut stage = Stage::new(gpu, &crowd, &lights, options())?;
    for &caster in &stage.casters {
        let at = place(&mut random);
        let own = Some([(at - 0.5).to_array(), (at + 0.5).to_array()]);
        stage.scene.set_bounds(caster, own).map_err(text)?;
    }
    let most = MOST_BOXES / (lights.len() + 1);
    let view = camera(&mut random);
    let mut of_one = Vec::new();
    for views in [1, most, most + 1] {
        let cameras = vec![view; views];
        let casters = &stage.casters;
        let needs = gpu.submit(|encoder| stage.scene.encode_needs(encoder, casters, &cameras, None).map_err(text))?;
        let found = words(gpu, &needs)?;
        if views == 1 {
            of_one.clone_from(&found);
        }
        let expected = if views > most { vec![0; of_one.len()] } else { of_one.clone() };
        same(&format!("{views} views"), &found, &expected)?;
        let mut other = found;
        other[views % 60] ^= 1;
        must_fail("another figure", &same(&format!("{views} views"), &other, &expected))?;
    }
    let unneeded = of_one.iter().filter(|&&word| word != 0).count();
    println!("{most} views, {unneeded} of {} figures not needed", of_one.len());
    if unneeded > 5 && unneeded < of_one.len() { Ok(()) } else { Err("not as meant".to_owned()) }
}

/// Random boxes, masks, lights and cameras, and figures without a box.
fn hide_nothing() -> Result<(), String> {
    let gpu = &*Gpu::shared()?;
    let (mut unneeded, mut needed, mut noticed) = (0, 0, 0);
    for seed in 4101..if is_long() { 4301 } else { 4111 } {
        println!("seed {seed}");
        let mut random = Random::new(seed);
        let crowd = Crowd::new(60)?;
        let lights = lights(&mut random);
        let mut stage = Stage::new(gpu, &crowd, &lights, options())?;
        for _ in 0..4 {
            let cameras: Vec<_> = (0..=random.below(2)).map(|_| camera(&mut random)).collect();
            let (mut boxes, mut masks) = (Vec::new(), Vec::new());
            for &caster in &stage.casters {
                let (at, half) = (place(&mut random), random.between(0.0, 2.0));
                let own = (random.below(20) > 0).then(|| [(at - half).to_array(), (at + half).to_array()]);
                stage.scene.set_bounds(caster, own).map_err(text)?;
                let mask = random.below(64) as u32;
                let allowed = stage.lights.iter().filter(|light| mask >> light.bit() & 1 != 0).copied();
                stage.scene.set_lights(caster, LightMask::only(allowed)).map_err(text)?;
                boxes.push(own);
                masks.push(mask);
            }
            let casters = &stage.casters;
            let needs =
                gpu.submit(|encoder| stage.scene.encode_needs(encoder, casters, &cameras, None).map_err(text))?;
            let found = words(gpu, &needs)?;
            for ((own, mask), word) in boxes.iter().zip(&masks).zip(&found) {
                let is_hidden = own.map(|own| check_unneeded(own, *mask, &lights, &cameras, &mut random));
                match (word, is_hidden) {
                    (0, Some(Err(_))) => noticed += 1,
                    (0, _) => needed += 1,
                    (_, None) => return Err("a figure without a box is left out".to_owned()),
                    (_, Some(outcome)) => {
                        outcome?;
                        unneeded += 1;
                    }
                }
            }
        }
    }
    println!("{unneeded} figures not needed, {noticed} seen, {needed} others needed");
    // Few figures are deformed without need: boxes near the frustum's edges, and boxes that samples miss.
    if unneeded < 500 || noticed < 300 || needed > noticed { Err("not as meant".to_owned()) } else { Ok(()) }
}

/// A frame that was recorded, and what it must come to.
struct Recorded {
    encoder: wgpu::CommandEncoder,
    /// The frame, its needs if it heeds any, and the buffers of its draws.
    needs: Option<SceneNeeds>,
    draws: (Vec<wgpu::Buffer>, wgpu::Buffer),
    statistics: wgpu::Buffer,
    batches: usize,
    figures: Vec<Figure>,
    lights: Vec<Light>,
    cameras: Vec<ShadowCamera>,
}

impl Recorded {
    /// Records a frame of a stage whose lights are `lights`. It heeds needs, or deforms everything.
    fn new(
        (crowd, stage): (&Crowd, &mut Stage),
        mut encoder: wgpu::CommandEncoder,
        figures: &[Figure],
        lights: &[Light],
        cameras: Vec<ShadowCamera>,
        heeds: bool,
    ) -> Result<Self, String> {
        let pose = crowd.pose(figures)?;
        stage.state(crowd, &pose, figures)?;
        let (needs, frame) = if heeds {
            let (needs, frame) = stage.encode_needed(&mut encoder, &pose, &cameras)?;
            (Some(needs), frame)
        } else {
            (None, stage.encode(&mut encoder, &pose, &cameras)?)
        };
        let (draws, statistics, batches) = (buffers(&frame)?, frame.statistics().clone(), frame.batches());
        let (figures, lights) = (figures.to_vec(), lights.to_vec());
        Ok(Self { encoder, needs, draws, statistics, batches, figures, lights, cameras })
    }

    /// Submits it, and compares with a scene made anew that deforms everything. Returns how many figures were not needed, and
    /// what was kept.
    fn check(self, gpu: &Gpu, crowd: &Crowd, stage: &Stage, options: SceneOptions) -> Result<[u32; 3], String> {
        gpu.queue.submit([self.encoder.finish()]);
        let bits: Vec<u32> = (0..self.lights.len() as u32).collect();
        let sizes = (self.cameras.len(), self.batches);
        let found = volumes(gpu, (&self.draws.0, &self.draws.1), sizes, &bits)?;
        let statistics = gpu.read::<SceneStatistics>(&self.statistics, 1)?[0];
        let mut other = Stage::new(gpu, crowd, &self.lights, options)?;
        let pose = crowd.pose(&self.figures)?;
        other.state(crowd, &pose, &self.figures)?;
        let frame = gpu.submit(|encoder| other.encode(encoder, &pose, &self.cameras))?;
        let expected = volumes_of(gpu, &frame, self.cameras.len())?;
        same("instances", &found.instances, &expected.instances)?;
        let (own, all) = (positions(gpu, stage)?, positions(gpu, &other)?);
        let unneeded = match &self.needs {
            Some(needs) => words(gpu, needs)?,
            None => vec![0; self.figures.len()],
        };
        check_positions(&own, &all, &unneeded)?;
        let count: u32 = unneeded.iter().sum();
        same("figures that were not needed", &[statistics.unneeded], &[count])?;
        Ok([count, statistics.kept_pairs, found.instances.iter().flatten().sum()])
    }
}

/// Frames are dropped, swapped, of another pose or the same, with and without needs.
fn histories() -> Result<(), String> {
    let gpu = &*Gpu::shared()?;
    let encoder = || gpu.device.create_command_encoder(&wgpu::CommandEncoderDescriptor::default());
    let (mut sums, mut late, mut noticed) = ([0_u32; 3], 0, 0);
    for seed in 4201..if is_long() { 4301 } else { 4209 } {
        println!("seed {seed}");
        let mut random = Random::new(seed);
        let crowd = Crowd::new(24)?;
        let mut lights = lights(&mut random);
        let options = options();
        let mut stage = Stage::new(gpu, &crowd, &lights, options)?;
        let mut figures = crowd.figures(&mut random);
        let mut cameras = vec![camera(&mut random)];
        let mut kept: Vec<Recorded> = Vec::new();
        for step in 0..16 {
            let what = |error| format!("step {step}: {error}");
            let heeds = random.below(5) > 0;
            let recorded = Recorded::new((&crowd, &mut stage), encoder(), &figures, &lights, cameras.clone(), heeds)?;
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
        let mut recorded = Recorded::new((&crowd, &mut stage), encoder(), &figures, &lights, cameras, true)?;
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

/// Without the switch, a camera or a box all figures are needed.
fn off() -> Result<(), String> {
    let gpu = &*Gpu::shared()?;
    let mut random = Random::new(4401);
    let crowd = Crowd::new(9)?;
    let figures = crowd.figures(&mut random);
    let pose = crowd.pose(&figures)?;
    // Far away and looking farther, and no light.
    let mut away = camera(&mut random);
    away.origin = [0, 1, 2].map(|axis| 1e4 * away.view_projection[axis][3]);
    for (skips, cameras, boxed, expected) in [
        (true, vec![away], true, 9),
        (false, vec![away], true, 0),
        (true, Vec::new(), true, 0),
        (true, vec![away], false, 0),
    ] {
        let mut options = options();
        options.measuring.set(Measuring::UNNEEDED, !skips);
        let mut stage = Stage::new(gpu, &crowd, &[], options)?;
        if boxed {
            stage.state(&crowd, &pose, &figures)?;
        }
        let (needs, _) = gpu.submit(|encoder| stage.encode_needed(encoder, &pose, &cameras))?;
        let found: u32 = words(gpu, &needs)?.iter().sum();
        same(&format!("{skips}, {} cameras, {boxed}", cameras.len()), &[found], &[expected])?;
    }
    Ok(())
}

/// A change of a scene after its needs were found.
type Change = fn(&mut Stage) -> Result<(), ShadowError>;

fn refusals() -> Result<(), String> {
    let gpu = &*Gpu::shared()?;
    let mut random = Random::new(4501);
    let crowd = Crowd::new(4)?;
    let (figures, lights) = (crowd.figures(&mut random), lights(&mut random));
    let pose = crowd.pose(&figures)?;
    let mut stage = Stage::new(gpu, &crowd, &lights, options())?;
    stage.state(&crowd, &pose, &figures)?;
    let cameras = [camera(&mut random)];
    let mut encoder = gpu.device.create_command_encoder(&wgpu::CommandEncoderDescriptor::default());
    let [a, b, ..] = stage.casters[..] else { return Err("four figures".to_owned()) };
    let twice = stage.scene.encode_needs(&mut encoder, &[a, b, a], &cameras, None).err();
    same("twice", &[twice], &[Some(ShadowError::ListedTwice { caster: 2 })])?;
    let all = stage.casters.clone();
    let needs = |stage: &mut Stage, encoder: &mut wgpu::CommandEncoder| {
        stage.scene.encode_needs(encoder, &all, &cameras, None).map_err(text)
    };
    let encode = |stage: &mut Stage, needs: &SceneNeeds, cameras: &[ShadowCamera]| {
        let mut encoder = gpu.device.create_command_encoder(&wgpu::CommandEncoderDescriptor::default());
        stage.scene.encode_needed(&mut encoder, FrameInputs::new(&views(cameras)), needs).err()
    };
    let stale = [Some(ShadowError::StaleNeeds)];
    let own = needs(&mut stage, &mut encoder)?;
    same("as it was", &[encode(&mut stage, &own, &cameras)], &[None])?;
    same("other cameras", &[encode(&mut stage, &own, &[camera(&mut random)])], &stale)?;
    same("no camera", &[encode(&mut stage, &own, &[])], &stale)?;
    let part = own.part(1..4).ok_or("no part")?;
    same("a part", &[encode(&mut stage, &part, &cameras)], &stale)?;
    same("too large a part", &[own.part(1..5).map(|part| part.len())], &[None])?;
    let changes: [Change; 4] = [
        |stage| stage.scene.set_light(stage.lights[1], Light::point([1.0; 3])),
        |stage| stage.scene.set_bounds(stage.casters[1], Some([[0.0; 3], [1.0; 3]])),
        |stage| stage.scene.set_lights(stage.casters[1], LightMask::NONE),
        |stage| stage.scene.remove_light(stage.lights[0]),
    ];
    for (number, change) in changes.into_iter().enumerate() {
        let own = needs(&mut stage, &mut encoder)?;
        change(&mut stage).map_err(text)?;
        same(&format!("change {number}"), &[encode(&mut stage, &own, &cameras)], &stale)?;
    }
    let [first, second] = [needs(&mut stage, &mut encoder)?, needs(&mut stage, &mut encoder)?];
    same("not the last", &[encode(&mut stage, &first, &cameras)], &stale)?;
    same("the last", &[encode(&mut stage, &second, &cameras)], &[None])?;
    let mut other = Stage::new(gpu, &crowd, &lights, options())?;
    same(
        "another scene",
        &[encode(&mut other, &second, &cameras)],
        &[Some(ShadowError::OtherScene { what: "needs" })],
    )?;
    let few = stage.deformer.encode_needed(&mut encoder, &pose, 0.0, None, &part, None).err();
    same("three of four", &[few], &[Some(DeformError::Needs { given: 3, instances: 4 })])
}
