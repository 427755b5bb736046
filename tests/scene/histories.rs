//! Frames do not depend on a scene's past. Scenes changed, and their encoders were dropped or submitted in any order; their
//! shadow volumes must equal those of a new scene.

use std::collections::HashMap;

use glam::Vec3;
use rimline::gpu::{
    Capacities, Caster, CasterHandle, CasterPositions, FrameInputs, LightHandle, LightMask, Measuring, Scene,
    SceneFrame, SceneOptions, ShadowStatistics,
};
use rimline::internals::layout::ShadowDraws;
use rimline::{Counting, DepthDirection, ShadowCamera};
use rimline_testkit::device::Gpu;
use rimline_testkit::harness::Test;
use rimline_testkit::on_gpu::{text, views};
use rimline_testkit::random::Random;
use rimline_testkit::{is_long, same};

use crate::random_scene::{Content, Placed, RandomScene, encoder};

pub(crate) const TESTS: &[Test] = &[("volumes_do_not_depend_on_what_a_scene_was_before", histories)];

/// Faces that are excluded for a light.
type Excluded = Vec<(CasterHandle, LightHandle, Vec<u32>)>;

/// A recorded frame, and its expected result: the content, the cameras and the excluded faces of that moment.
struct Recorded {
    encoder: wgpu::CommandEncoder,
    volumes: VolumeBuffers,
    content: Content,
    cameras: Vec<ShadowCamera>,
    excluded: Excluded,
}

/// The instances of each draw over all groups, for each view and light; and the statistics.
#[derive(Debug, PartialEq)]
pub(crate) struct Volumes {
    pub(crate) instances: Vec<[u32; 6]>,
    statistics: Vec<u32>,
    /// Cached lists, which are not compared.
    cached_lists: u32,
}

pub(crate) fn camera(random: &mut Random) -> ShadowCamera {
    let far = [1.5, 8.0, 60.0][random.below(3)];
    let origin = far * Vec3::from(random.direction());
    let forward = (Vec3::from(random.direction()) - origin).normalize();
    looking(origin, forward, forward.any_orthonormal_vector())
}

/// Near 0.1, without a far plane.
pub(crate) fn looking(origin: Vec3, forward: Vec3, right: Vec3) -> ShadowCamera {
    let up = right.cross(forward);
    let [x, y, z] = [0, 1, 2].map(|axis| [2.0 * right[axis], 2.0 * up[axis], 0.0, forward[axis]]);
    let view_projection = [x, y, z, [0.0, 0.0, 0.1, 0.0]];
    ShadowCamera { view_projection, origin: origin.to_array(), depth: DepthDirection::Reversed }
}

/// The buffers of a frame's volumes. They hold the results after its submission, even if the frame is stale then.
pub(crate) struct VolumeBuffers {
    draws: Vec<wgpu::Buffer>,
    statistics: wgpu::Buffer,
    views: usize,
    batches: usize,
}

impl VolumeBuffers {
    pub(crate) fn new(frame: &SceneFrame, views: usize) -> Result<Self, String> {
        Ok(Self {
            draws: frame.results().map_err(text)?.shadow_draws.to_vec(),
            statistics: frame.shadow_statistics().ok_or("no view")?.clone(),
            views,
            batches: frame.batches(),
        })
    }

    /// The volumes of the lights with these bits.
    pub(crate) fn read(&self, gpu: &Gpu, bits: &[u32]) -> Result<Volumes, String> {
        let mut instances = vec![[0; 6]; self.views * bits.len()];
        for buffer in &self.draws {
            let group: Vec<ShadowDraws> = gpu.read(buffer, usize::MAX)?;
            let indices =
                (0..self.views).flat_map(|view| bits.iter().map(move |&bit| view * 32 * self.batches + bit as usize));
            for (sum, index) in instances.iter_mut().zip(indices) {
                let ShadowDraws { plain, clipped, near_front, near_back, far_front, far_back, .. } = group[index];
                let kinds = [plain, clipped, near_front, near_back, far_front, far_back];
                sum.iter_mut().zip(kinds).for_each(|(sum, draw)| *sum += draw.instance_count);
            }
        }
        let mut statistics: Vec<ShadowStatistics> = gpu.read(&self.statistics, 1)?;
        let cached_lists = statistics.iter_mut().map(|statistics| std::mem::take(&mut statistics.cached_lists)).sum();
        Ok(Volumes { instances, statistics: bytemuck::cast_slice(&statistics).to_vec(), cached_lists })
    }
}

/// The volumes of all lights of a submitted frame.
pub(crate) fn volumes(gpu: &Gpu, frame: &SceneFrame, views: usize) -> Result<Volumes, String> {
    let bits: Vec<u32> = frame.lights().iter().map(|(light, _)| light.bit()).collect();
    VolumeBuffers::new(frame, views)?.read(gpu, &bits)
}

impl Recorded {
    fn new(
        mut encoder: wgpu::CommandEncoder,
        scene: &mut RandomScene,
        cameras: Vec<ShadowCamera>,
        excluded: &Excluded,
    ) -> Result<Self, String> {
        let frame = scene.scene.encode(&mut encoder, FrameInputs::new(&views(&cameras))).map_err(text)?;
        let volumes = VolumeBuffers::new(&frame, cameras.len())?;
        let (content, excluded) = (scene.content.clone(), excluded.clone());
        Ok(Self { encoder, volumes, content, cameras, excluded })
    }

    /// Submits it, and compares it with a new scene. Returns the numbers of instances and of cached lists.
    fn check(self, gpu: &Gpu, options: SceneOptions) -> Result<[u32; 2], String> {
        let expected = self.without_past(gpu, options)?;
        gpu.queue.submit([self.encoder.finish()]);
        let bits: Vec<u32> = self.content.lights.iter().map(|(light, _)| light.bit()).collect();
        let mut found = self.volumes.read(gpu, &bits)?;
        let cached_lists = std::mem::replace(&mut found.cached_lists, expected.cached_lists);
        same("volumes", &[&found], &[&expected])?;
        Ok([found.instances.iter().flatten().sum(), cached_lists])
    }

    /// The volumes of the same content in a scene without a past.
    fn without_past(&self, gpu: &Gpu, options: SceneOptions) -> Result<Volumes, String> {
        let Self { content, cameras, excluded, .. } = self;
        let mut scene = Scene::new(&gpu.pipelines, &gpu.queue, options).map_err(text)?;
        let meshes = content.meshes.iter().map(|(case, _)| scene.add_mesh(&case.2, &case.1).map_err(text));
        let meshes = meshes.collect::<Result<Vec<_>, _>>()?;
        let lights = content.lights.iter().map(|(old, light)| Ok((*old, scene.add_light(*light).map_err(text)?)));
        let lights = lights.collect::<Result<HashMap<_, _>, String>>()?;
        for known in &content.casters {
            let positions = match &known.placed {
                Placed::Rigid(rows) => CasterPositions::Rigid((*rows).into()),
                Placed::World(world) => CasterPositions::Buffer { buffer: gpu.storage(world), offset: 0, stride: 12 },
            };
            let allowed = lights.iter().filter(|(old, _)| known.lights.contains(**old)).map(|(_, new)| *new);
            let (mesh, lights_of) = (meshes[known.mesh], LightMask::only(allowed));
            let caster = Caster { mesh, positions, lights: lights_of, in_depth: known.in_depth };
            let caster = scene.insert(caster).map_err(text)?;
            if known.bounds.is_some() {
                scene.set_bounds(caster, known.bounds).map_err(text)?;
            }
            for (_, light, faces) in excluded.iter().filter(|(of, ..)| *of == known.handle) {
                if let Some(light) = lights.get(light) {
                    scene.set_excluded(caster, *light, faces).map_err(text)?;
                }
            }
        }
        let frame = gpu.submit(|encoder| scene.encode(encoder, FrameInputs::new(&views(cameras))).map_err(text))?;
        let bits: Vec<u32> = content.lights.iter().map(|(old, _)| lights[old].bit()).collect();
        VolumeBuffers::new(&frame, cameras.len())?.read(gpu, &bits)
    }
}

/// Excludes faces of a caster for a light.
fn exclude(scene: &mut RandomScene, excluded: &mut Excluded) -> Result<(), String> {
    let Content { casters, lights, meshes } = &scene.content;
    if casters.is_empty() || lights.is_empty() {
        return Ok(());
    }
    let known = &casters[scene.random.below(casters.len())];
    let (light, _) = lights[scene.random.below(lights.len())];
    let faces = meshes[known.mesh].0.2.faces().len() as u32;
    let faces: Vec<u32> = (0..faces).filter(|_| scene.random.below(4) == 0).collect();
    scene.scene.set_excluded(known.handle, light, &faces).map_err(text)?;
    excluded.retain(|(of, by, _)| (*of, *by) != (known.handle, light));
    excluded.push((known.handle, light, faces));
    Ok(())
}

fn histories() -> Result<(), String> {
    let gpu = &*Gpu::shared()?;
    let (mut instances, mut cached_lists, mut late, mut noticed) = (0_u64, 0, 0, 0);
    for seed in 3001..if is_long() { 3301 } else { 3021 } {
        let mut random = Random::new(seed);
        let mut options = SceneOptions {
            max_lights: 40,
            capacities: Capacities { lists: Some(u32::MAX), caps: Some(u32::MAX), ..Capacities::default() },
            counting: [Counting::Auto, Counting::ZpPlus, Counting::ZFail, Counting::ZPass][random.below(4)],
            end_at_range: random.below(2) == 0,
            ..SceneOptions::default()
        };
        options.measuring.set(Measuring::CULLED_BY_VIEW, random.below(2) == 0);
        // In every other scene no caster is added or removed, and all are rigid.
        let is_calm = seed % 2 == 0;
        let fill = if is_calm { RandomScene::filled_rigid } else { RandomScene::filled };
        let mut scene = fill(gpu, seed, options, [[3, 36][random.below(2)], 8])?;
        let mut excluded = Excluded::new();
        let mut late_frames: Vec<Recorded> = Vec::new();
        let mut cameras = [0; 3].map(|_| camera(&mut random));
        for step in 0..8 {
            let what = |error| format!("step {step}: {error}");
            // Many cameras do not move, and some are not there for a while.
            for camera_now in &mut cameras {
                if random.below(4) == 0 {
                    *camera_now = camera(&mut random);
                }
            }
            let cameras = cameras[..=random.below(3)].to_vec();
            let recorded = Recorded::new(encoder(gpu), &mut scene, cameras, &excluded)?;
            match random.below(4) {
                // Dropped.
                0 => {}
                1 => late_frames.push(recorded),
                _ => {
                    let [drawn, lists] = recorded.check(gpu, options).map_err(what)?;
                    instances += u64::from(drawn);
                    cached_lists += lists;
                }
            }
            if random.below(3) == 0 && !late_frames.is_empty() {
                let recorded = late_frames.swap_remove(random.below(late_frames.len()));
                recorded.check(gpu, options).map_err(|error| format!("late, {}", what(error)))?;
                late += 1;
            }
            match (is_calm, random.below(3)) {
                (true, 0) => drop(scene.move_casters()?),
                (true, 1) => drop(scene.move_lights()?),
                (true, _) => {}
                (false, which) => {
                    if which == 0 {
                        exclude(&mut scene, &mut excluded)?;
                    }
                    if random.below(3) > 0 {
                        scene.change(gpu)?;
                    }
                }
            }
            // A batch of lights becomes empty.
            if step == 4 && scene.content.lights.len() > 33 {
                for (light, _) in scene.content.lights.extract_if(.., |(light, _)| light.bit() < 32) {
                    scene.scene.remove_light(light).map_err(text)?;
                }
            }
        }
        // The negative control: other cameras.
        let mut recorded = Recorded::new(encoder(gpu), &mut scene, vec![camera(&mut random)], &excluded)?;
        recorded.cameras = vec![camera(&mut random)];
        noticed += u32::from(recorded.check(gpu, options).is_err());
    }
    println!("{instances} instances, {cached_lists} lists cached, {late} late frames, {noticed} other cameras noticed");
    if cached_lists < 100 {
        return Err("too few lists were cached".to_owned());
    }
    if instances < 100_000 || late < 10 || noticed < 10 { Err("too few of a kind".to_owned()) } else { Ok(()) }
}
