//! The pyramid of the farthest receivers that `receiver_depth` and `receiver_pyramid` make, against the depths that are drawn and
//! points that are seen.

use glam::{DMat4, DVec3, DVec4};
use rimline::gpu::{Caster, FrameInputs, Receivers, Scene, SceneOptions, View};
use rimline::internals::scene::CHOICE_WORDS;
use rimline::{DepthDirection, Light, ShadowCamera};
use rimline_testkit::device::Gpu;
use rimline_testkit::on_gpu::text;
use rimline_testkit::random::Random;
use rimline_testkit::{must_fail, same, shapes};

use crate::trials::Test;
use rimline_testkit::frames::{Eye, vector};
use rimline_testkit::textures::sampled;

pub(crate) const TESTS: &[Test] =
    &[("receivers_are_those_of_their_depths", pyramid), ("lists_for_known_receivers_are_kept", versions)];

/// Depths of samples at random, of which a share in percent is the sky's, and a texture of them. Where there are several, one
/// is -0 with standard depth.
fn written(
    gpu: &Gpu,
    [width, height]: [u32; 2],
    samples: u32,
    [seed, share_of_sky]: [u32; 2],
    [sky, nearest]: [f32; 2],
) -> Result<(Vec<f32>, wgpu::Texture), String> {
    let mut random = Random::new(u64::from(seed));
    let mut one = |_| if random.below(100) < share_of_sky as usize { sky } else { nearest * random.between(0.0, 0.5) };
    let mut depths: Vec<f32> = (0..width * height * samples).map(&mut one).collect();
    // With standard depth -0 is the nearest depth, as 0 is.
    if let [first, _, ..] = &mut depths[..]
        && sky == 1.0
    {
        *first = -0.0;
    }
    let texture = sampled(gpu, [width, height], (wgpu::TextureFormat::Depth32Float, samples), &depths)?;
    Ok((depths, texture))
}

fn eye(random: &mut Random, number: usize) -> Eye {
    let (forward, position) = (vector(random), 5.0 * vector(random));
    let depth = [DepthDirection::Reversed, DepthDirection::Standard][number % 2];
    let (far, half_width) = [(None, None), (Some(50.0), None), (Some(50.0), Some(8.0))][number / 2 % 3];
    Eye { is_relative: random.below(5) > 0, depth, far, half_width, ..Eye::new(position, forward, 0.1) }
}

/// The farthest of `by` times `by` cells, in rows of so many cells.
fn farthest(cells: &[u32], [width, height]: [u32; 2], by: u32) -> (Vec<u32>, [u32; 2]) {
    let size = [width.div_ceil(by), height.div_ceil(by)];
    let mut keys = vec![0; (size[0] * size[1]) as usize];
    for (at, &key) in (0..).zip(cells) {
        let farthest_key = &mut keys[(at / width / by * size[0] + at % width / by) as usize];
        *farthest_key = key.max(*farthest_key);
    }
    (keys, size)
}

/// Depths of samples that a camera sees.
struct Seen {
    camera: ShadowCamera,
    near_z: f32,
    sky_receives: bool,
    pixels: [u32; 2],
    samples: usize,
    depths: Vec<f32>,
}

impl Seen {
    fn receives(&self, depth: f32) -> bool {
        depth != 1.0 - self.near_z || self.sky_receives
    }

    /// The farthest receiver of each tile of 8 × 8 pixels, then of each four, up to one, and the number of tiles. Keys grow
    /// with the distance, and are 0 for none.
    fn levels(&self) -> (Vec<u32>, [u32; 2]) {
        let key = |depth: &f32| match depth.abs().to_bits() {
            _ if !self.receives(*depth) => 0,
            bits if self.near_z == 0.0 => bits + 1,
            bits => 0x4000_0000 - bits,
        };
        let of_pixels = self.depths.chunks(self.samples).map(|depths| depths.iter().map(key).max().unwrap_or(0));
        let (mut keys, mut size) = farthest(&of_pixels.collect::<Vec<_>>(), self.pixels, 8);
        let (mut all, tiles) = (keys.clone(), size);
        while keys.len() > 1 {
            (keys, size) = farthest(&keys, size, 2);
            all.extend(&keys);
        }
        (all, tiles)
    }

    /// Each receiver must be in the box, if that has an end.
    fn check_points(&self, words: &[u32]) -> Result<(), String> {
        let columns = self.camera.view_projection.map(|column| column.map(f64::from));
        let inverse = DMat4::from_cols_array_2d(&columns).inverse();
        let [low, high] = [6, 9].map(|at| [0, 1, 2].map(|axis| f64::from(f32::from_bits(words[at + axis]))));
        let ndc = |at: usize, size: u32| (at as f64 + 0.5) / f64::from(size) * 2.0 - 1.0;
        let [width, height] = self.pixels;
        for (number, &depth) in self.depths.iter().enumerate().filter(|(_, depth)| self.receives(**depth)) {
            let pixel = number / self.samples;
            let [x, y] = [pixel % width as usize, pixel / width as usize];
            let point = inverse * DVec4::new(ndc(x, width), -ndc(y, height), f64::from(depth), 1.0);
            let point = point.truncate() / point.w;
            let is_within = point.cmpge(DVec3::from(low)).all() && point.cmple(DVec3::from(high)).all();
            if words[5] != 0 && !is_within {
                return Err(format!("pixel {x} {y} at depth {depth} is at {point}, the box is {low:?} {high:?}"));
            }
        }
        Ok(())
    }
}

/// Words before the levels.
const HEAD: usize = 16;

/// Keys of tiles and levels are those of the depths, and the box has all points that are seen.
fn pyramid() -> Result<(), String> {
    let (gpu, mut random) = Gpu::seeded(6001)?;
    let (mut limited, mut endless) = (0, 0);
    for number in 0..48 {
        let eye = eye(&mut random, number);
        let camera = eye.camera();
        let pixels = [[1, 1], [8, 8], [9, 17], [64, 48], [300, 7], [333, 417]][number / 8];
        let samples = if number % 3 == 2 { 4 } else { 1 };
        let sky_receives = random.below(2) == 0;
        let share = [0, 60, 100, 97][random.below(4)];
        let near_z = if eye.depth == DepthDirection::Reversed { 1.0 } else { 0.0 };
        let ends = [1.0 - near_z, [1.0, 0.01][random.below(2)]];
        let (depths, texture) = written(&gpu, pixels, samples, [number as u32, share], ends)?;
        let depth = texture.create_view(&wgpu::TextureViewDescriptor::default());
        let mut scene = filled(&gpu, 0)?;
        // The second of three views has them.
        let mut views = [View::new(camera); 3];
        views[1].depth = Some(Receivers { depth: &depth, sky_receives, version: None });
        let frame = gpu.submit(|encoder| scene.encode(encoder, FrameInputs::new(&views)).map_err(text))?;
        let (buffer, count) = frame.results().map_err(text)?.receivers.ok_or("no view")?;
        let all: Vec<u32> = gpu.read(buffer, usize::MAX)?;
        let mut found = all[1 + count as usize..][..count as usize].to_vec();
        let seen = Seen { camera, near_z, sky_receives, pixels, samples: samples as usize, depths };
        let (keys, [across, down]) = seen.levels();
        let farthest = *keys.last().ok_or("no level")?;
        same("sizes and the farthest", &found[..5], &[across, down, pixels[0], pixels[1], farthest])?;
        same(&format!("levels of {pixels:?}"), &found[HEAD..][..keys.len()], &keys)?;
        seen.check_points(&found)?;
        if found[5] == 0 {
            endless += 1;
        } else if found[4] != 0 {
            limited += 1;
            // A box without an extent.
            found.copy_within(6..9, 9);
            must_fail("a smaller box", &seen.check_points(&found))?;
        }
        let depths = seen.depths.iter().map(|depth| 0.5 * depth + 0.5 * near_z).collect();
        if farthest > 1 {
            must_fail("nearer depths", &same("levels", &Seen { depths, ..seen }.levels().0, &keys))?;
        }
    }
    println!("{limited} boxes, {endless} without an end");
    if limited.min(endless) < 3 { Err("too few of a kind".to_owned()) } else { Ok(()) }
}

/// Casters and lights in front of an eye.
fn filled(gpu: &Gpu, seed: u64) -> Result<Scene, String> {
    let mut random = Random::new(seed);
    let mut scene = Scene::new(&gpu.pipelines, &gpu.queue, SceneOptions::default()).map_err(text)?;
    let shape = shapes::cube();
    let mesh = scene.add_mesh(&shape.mesh().map_err(text)?, &shape.positions).map_err(text)?;
    for _ in 0..16 {
        let [x, y, z] = [(); 3].map(|()| random.between(-9.0, 9.0));
        let rows = [[0.3, 0.0, 0.0, x], [0.0, 0.3, 0.0, y], [0.0, 0.0, 0.3, z]];
        scene.insert(Caster::rigid(mesh, rows)).map_err(text)?;
    }
    for _ in 0..4 {
        let xyz = [(); 3].map(|()| random.between(-12.0, 12.0));
        scene.add_light(Light::point(xyz)).map_err(text)?;
    }
    Ok(scene)
}

/// Choices for each caster and light, the draws, and the numbers of cached lists, of volumes culled by receivers, and of
/// those that end.
type Chosen = (Vec<u32>, Vec<u32>, [u32; 3]);

fn chosen(gpu: &Gpu, scene: &mut Scene, view: View<'_>) -> Result<Chosen, String> {
    let frame = gpu.submit(|encoder| scene.encode(encoder, FrameInputs::new(&[view])).map_err(text))?;
    let results = frame.results().map_err(text)?;
    let mut words: Vec<u32> = gpu.read(results.choices.ok_or("no view")?, 8 * 16)?;
    // The last word of a caster tells which lists are made anew.
    words.iter_mut().skip(7).step_by(CHOICE_WORDS).for_each(|word| *word = 0);
    let draws: Vec<u32> = gpu.read(&results.shadow_draws[0], usize::MAX)?;
    let statistics = frame.shadow_statistics().ok_or("no view")?;
    let statistics = gpu.read::<rimline::gpu::ShadowStatistics>(statistics, 1)?[0];
    Ok((words, draws, [statistics.cached_lists, statistics.culled_by_receivers, statistics.ended]))
}

/// Lists stay cached while camera and version stay the same. Choices always equal those of a new scene.
fn versions() -> Result<(), String> {
    let gpu = &*Gpu::shared()?;
    let (mut kept, mut made, mut culled, mut noticed) = (0, 0, 0, 0);
    for seed in 6101..6109 {
        println!("seed {seed}");
        let mut random = Random::new(seed);
        let eyes = [eye(&mut random, 0), eye(&mut random, 0)];
        let texture = |(number, (nearest, share)): (u32, (f32, u32))| {
            let (_, texture) = written(gpu, [48, 40], 1, [number, share], [0.0, nearest])?;
            Ok(texture.create_view(&wgpu::TextureViewDescriptor::default()))
        };
        let depths = (0..).zip([(1.0, 40), (0.9, 40), (0.2, 0)]).map(texture).collect::<Result<Vec<_>, String>>()?;
        let mut scene = filled(gpu, seed)?;
        let mut last = None;
        for _ in 0..24 {
            // On average half of the frames change nothing.
            let (mut at, mut picture, mut sky_receives, mut is_known) = last.unwrap_or((0, 0, false, true));
            match random.below(8) {
                0 => at = 1 - at,
                1 => picture = (picture + 1 + random.below(2)) % 3,
                2 => sky_receives = !sky_receives,
                3 => is_known = !is_known,
                _ => {}
            }
            let now = (at, picture, sky_receives, is_known);
            let version = is_known.then_some(picture as u64);
            let without = View::new(eyes[at].camera());
            let depth = Some(Receivers { depth: &depths[picture], sky_receives, version });
            let view = View { depth, ..without };
            let (words, draws, [lists, volumes, ends]) = chosen(gpu, &mut scene, view)?;
            let (expected, of_new, [.., ends_of_new]) = chosen(gpu, &mut filled(gpu, seed)?, view)?;
            let what = format!("{now:?} after {last:?}");
            same(&format!("{what}: choices"), &words, &expected)?;
            same(&format!("{what}: draws"), &draws, &of_new)?;
            let is_kept = is_known && last == Some(now);
            let all_lists = if is_kept { 4 } else { 0 };
            same(&format!("{what}: lists kept, volumes that end"), &[lists, ends], &[all_lists, ends_of_new])?;
            *(if is_kept { &mut kept } else { &mut made }) += 1;
            culled += volumes;
            let (other, ..) = chosen(gpu, &mut filled(gpu, seed)?, without)?;
            noticed += u32::from(same("without receivers", &words, &other).is_err());
            last = Some(now);
        }
    }
    println!("kept {kept} times, made {made} times, {culled} culled, {noticed} differ from those without receivers");
    if kept < 20 || made < 20 || culled == 0 || noticed == 0 { Err("too few of a kind".to_owned()) } else { Ok(()) }
}
