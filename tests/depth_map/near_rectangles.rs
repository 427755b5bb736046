//! Near rectangles of any width, at the boundary: from a thousandth of a texel of the map to all of it, edge-on to the
//! light, and across two maps of a cube. The stencil of `depth_surface` against the crossings of rays, with near caps
//! always drawn and skipped where `depth_near` says that they may be.

use glam::{DVec3, DVec4};
use rimline::gpu::depth_map::DepthMapOptions;
use rimline::internals::depth_map::{DepthMapNearCap, near_box};
use rimline::internals::layout::DepthNearBox;
use rimline::{DepthDirection, ShadowCamera};
use rimline_testkit::device::Gpu;
use rimline_testkit::harness::Test;
use rimline_testkit::random::Random;
use rimline_testkit::{is_long, must_fail, same};
use wgpu::TextureFormat;

use crate::boundary::{Boundary, sample};
use crate::contours::distance;
use crate::cube::cube_of;
use crate::maps::Map;
use crate::parity::{self, SIDE, any_eye, clip, either, light, map, seen, seen_depths, truth, unprojected};
use crate::picture::{AUTOMATIC, Encoded, Maps, REVERSED, STANDARD, Target, Volumes, by, contours, look, pipelines};
use crate::rules::{cast, rank};
use rimline_testkit::frames::{Eye, Rays, vector};
use rimline_testkit::textures::read;

pub(crate) const TESTS: &[Test] = &[
    ("near_rectangles_of_all_widths_are_those_of_rays", widths),
    ("near_rectangles_edge_on_to_the_light_are_those_of_rays", edge_on),
    ("near_rectangles_across_two_maps_are_those_of_rays", across),
    ("near_caps_beyond_the_far_plane_are_drawn", beyond),
    ("skipped_near_caps_change_no_picture", of_maps),
    ("skipped_near_caps_of_cubes_change_no_picture", of_cubes),
];

/// A rounding of WGSL: one unit in the last place, of a number anywhere in its binade.
pub(crate) const ROUNDING: f64 = 1.0 / 8_388_608.0;

/// From the light to the farthest positions near the boundary.
const SCENE: f64 = 16.0;

/// The position of a map's sample, at any depth.
pub(crate) fn position(camera: &ShadowCamera, size: [u32; 2], [x, y]: [f64; 2], depth: f64) -> DVec3 {
    let [width, height] = size.map(f64::from);
    unprojected(camera, DVec3::new((2.0 * x + 1.0) / width - 1.0, 1.0 - (2.0 * y + 1.0) / height, depth))
}

/// An eye whose near rectangle has its middle at a position, is `width` wide, and looks along `forward`.
pub(crate) fn eye_at(random: &mut Random, middle: DVec3, forward: DVec3, width: f64) -> ShadowCamera {
    let forward = forward.normalize();
    let is_relative = width < 0.1 || random.below(2) == 0;
    // Parallel rays where the near rectangle is small: the depths of a perspective eye would be too coarse there.
    let half_width = (width < 0.01 || random.below(3) == 0).then_some(width / 2.0);
    let near = if half_width.is_some() { 0.5 } else { width / 2.0 / 30_f64.to_radians().tan() };
    let depth = if half_width.is_some() && random.below(2) == 0 { STANDARD } else { REVERSED };
    let far = half_width.map(|_| 24.0);
    Eye { is_relative, depth, far, half_width, ..look(middle - near * forward, forward, near) }.camera()
}

/// The eye with depths that are moved by four steps of floats.
fn moved(eye: &ShadowCamera) -> ShadowCamera {
    let [share, constant] = match eye.depth {
        DepthDirection::Reversed => [0.5_f64.powi(21), 0.0],
        DepthDirection::Standard => [0.0, 0.5_f64.powi(22)],
    };
    let mut moved = *eye;
    for column in &mut moved.view_projection {
        column[2] = (f64::from(column[2]) * (1.0 - share) + f64::from(column[3]) * constant) as f32;
    }
    moved
}

/// Pixels, and pictures whose near rectangles are in shadow and in light.
#[derive(Clone, Copy, Debug, Default)]
struct Tally {
    pixels: parity::Tally,
    cut: usize,
}

impl Tally {
    fn check(&self, what: &str, least: usize) -> Result<(), String> {
        println!("{what}: {self:?}");
        let parity::Tally { dark, lit, near_borders, wrong, .. } = self.pixels;
        let is_tried = dark.min(lit) > 50 && self.cut >= least && near_borders * 2 < dark + lit;
        if wrong == 0 && is_tried { Ok(()) } else { Err(format!("{what}: {self:?}")) }
    }
}

/// Maps, the light (homogeneous), and their boundary.
struct Scene {
    maps: Maps,
    light: DVec4,
    boundary: Boundary,
}

impl Scene {
    /// Most that a position of the near rectangle may be off by along the light's ray, because depths are floats: the move of
    /// the map's depths, and twenty roundings of them. docs/numerics/depth-maps.md, "Rounding of positions".
    fn slip(&self, near: DVec3) -> DVec3 {
        let ahead = |camera: &ShadowCamera| clip(camera, near).w;
        let lights = self.maps.lights.iter();
        let Some(camera) = lights.max_by(|a, b| ahead(a).total_cmp(&ahead(b))) else { return DVec3::NAN };
        let depth = |position: DVec3| {
            let clip = clip(camera, position);
            clip.z / clip.w
        };
        let ray = (self.light.truncate() - self.light.w * near).normalize();
        let slope = (depth(near + 1e-4 * ray) - depth(near)) / 1e-4;
        24.0 * ROUNDING * depth(near).abs() / slope.abs() * ray
    }

    /// Compares a picture with rays, whose near rectangle is `width` wide. A vertex is off by five roundings of the terms
    /// that it adds up from, in numbers of the size of the scene; in pixels the more, the smaller the near rectangle is.
    fn add(&self, tally: &mut Tally, stencil: &[u8], seen: &parity::Seen<'_>, (width, slips): (f64, bool)) {
        let pixels = 5.0 * ROUNDING * SCENE / width * f64::from(SIDE);
        let mut behind = [0; 2];
        for pixel in (0..SIDE * SIDE).filter(|pixel| pixel % 3 == pixel / SIDE % 3) {
            let middle = parity::middle(pixel, SIDE);
            let near = seen(middle).0;
            let is_dark = self.boundary.is_dark(near);
            behind[usize::from(is_dark)] += 1;
            let slip = if slips { self.slip(near) } else { DVec3::ZERO };
            let slips = [slip, -slip].map(|slip| self.boundary.is_dark(near + slip));
            let truth = truth(&self.boundary, seen, middle, (1.0 + pixels / 0.05, true));
            tally.pixels.add(truth.filter(|_| slips == [is_dark; 2]), stencil[pixel as usize] != 0);
        }
        tally.cut += usize::from(behind[0] > 0 && behind[1] > 0);
    }
}

/// The stencil of a picture, which is the same with near caps that are always drawn.
pub(crate) fn both(
    gpu: &Gpu,
    target: &Target<'_>,
    maps: &Maps,
    options: DepthMapOptions,
) -> Result<(Vec<u8>, Encoded), String> {
    let (all, encoded) = target.draw(gpu, maps, DepthMapOptions { skip_near_caps: false, ..options })?;
    same("without the switch", &[encoded.frame.near_cap()], &[&DepthMapNearCap::Drawn])?;
    let (skipped, encoded) = target.draw(gpu, maps, options)?;
    same("with near caps that are always drawn", &skipped, &all)?;
    Ok((skipped, encoded))
}

/// From the light (homogeneous) and a position, the width of a texel there and the map's size, and a number: where the
/// middle of a near rectangle is, where it looks, and how wide it is.
type At<'a> = dyn Fn(&mut Random, (DVec4, DVec3), (f64, [u32; 2]), usize) -> (DVec3, DVec3, f64) + 'a;

/// Pictures at positions of a boundary.
fn trials(random: &mut Random, what: &str, at: &At<'_>) -> Result<(), String> {
    let gpu = Gpu::shared_with_depth_features()?;
    let (mut tally, mut rounds) = (Tally::default(), 0);
    while rounds < if is_long() { 60 } else { 6 } {
        let (camera, light) = light(random);
        let map = map(random, &camera);
        let texel = [0, 1].map(|axis| random.below(map.size[axis] as usize) as i64);
        let Some(depth) = sample(&map, texel[0], texel[1]) else { continue };
        let [x, y] = texel.map(|at| at as f64);
        let middle = position(&camera, map.size, [x, y], depth);
        let width = (position(&camera, map.size, [x + 1.0, y], depth) - middle).length();
        let maps = Maps::of(&gpu, &map, TextureFormat::R32Float, camera)?;
        let boundary = Boundary::edited(&map, &camera, light, -1.0, None);
        let (middle, forward, width) = at(random, (light, middle), (width, map.size), rounds);
        let eye = eye_at(random, middle, forward, width);
        // Its near plane is that of the boundary, which is moved by the steps of the eye's depths.
        let rays = Rays::new(&moved(&eye), SIDE);
        let seen = seen(random, &rays);
        let depths = seen_depths(&eye, SIDE, &seen);
        let target = Target { format: TextureFormat::Depth32FloatStencil8, ..Target::new(eye, &depths) };
        let options = DepthMapOptions { slope_bias: 0.0, ..Default::default() };
        let (stencil, _) = both(&gpu, &target, &maps, options)?;
        let wrong = tally.pixels.wrong;
        Scene { maps, light, boundary }.add(&mut tally, &stencil, &seen, (width, true));
        if tally.pixels.wrong > wrong {
            println!("{} wrong, {what}: {eye:?}, {camera:?}", tally.pixels.wrong - wrong);
        }
        rounds += 1;
    }
    tally.check(what, rounds / 4)
}

fn widths() -> Result<(), String> {
    let mut random = Random::new(16_301);
    for texels in [0.001, 0.03, 0.4, 1.0, 4.0, 0.0] {
        trials(&mut random, &format!("{texels} texels"), &|random, (_, middle), (width, size), _| {
            // 0: the whole map.
            let width = width * if texels == 0.0 { f64::from(size[0].max(size[1])) } else { texels };
            let middle = middle + width * f64::from(random.between(-0.3, 0.3)) * vector(random);
            (middle, vector(random), width)
        })?;
    }
    Ok(())
}

/// The light lies in the plane of the near rectangle, exactly or nearly.
fn edge_on() -> Result<(), String> {
    let mut random = Random::new(16_302);
    for tilt in [0.0, 1e-6, 1e-3, 0.03] {
        trials(&mut random, &format!("tilted by {tilt}"), &|random, (at, middle), (width, _), round| {
            let to_light = if at.w == 0.0 { at.truncate() } else { (at.truncate() - middle).normalize() };
            let forward = to_light.cross(vector(random)).normalize() + tilt * to_light;
            (middle, forward, width * [0.3, 2.0, 8.0][round % 3])
        })?;
    }
    Ok(())
}

/// Near rectangles whose middle is on a ray that two maps of a cube share, or three.
fn across() -> Result<(), String> {
    let (gpu, mut random) = Gpu::seeded(16_303)?;
    let (mut tally, mut other) = (Tally::default(), Tally::default());
    for round in 0..if is_long() { 120 } else { 18 } {
        let cube = cube_of(&mut random, 6);
        let (light, cameras) = (cube.light, &cube.cameras);
        // The middles of the outermost texels lie on the edges of the cube.
        let face = random.below(6);
        let along = f64::from(random.below(6) as u32);
        let corner = [[0.0, along], [5.0, along], [along, 0.0], [along, 5.0]][random.below(4)];
        let ray = (position(&cameras[face], [6; 2], corner, 0.5) - light).normalize();
        let distance = f64::from(random.between(1.0, 8.0));
        let width = distance * [0.001, 0.05, 0.5, 1.5][round % 4];
        let middle = light + distance * ray + width * f64::from(random.between(-0.2, 0.2)) * vector(&mut random);
        // A third of them edge-on.
        let forward = if round % 3 == 0 { ray.cross(vector(&mut random)) } else { vector(&mut random) };
        let (depth, far, half_width) = (either(&mut random), Some(60.0), Some(width / 2.0));
        let forward = forward.normalize();
        let eye = Eye { depth, far, half_width, ..look(middle - 0.5 * forward, forward, 0.5) }.camera();
        let rays = Rays::new(&eye, SIDE);
        let seen = seen(&mut random, &rays);
        let depths = seen_depths(&eye, SIDE, &seen);
        let target = Target::new(eye, &depths);
        let maps = Maps::all(&gpu, (&cube.maps, 6), TextureFormat::R32Float, cameras)?;
        let scene = Scene { maps, light: light.extend(1.0), boundary: Boundary::cube(&cube, -1.0) };
        let options = DepthMapOptions { slope_bias: 0.0, ..Default::default() };
        let (stencil, _) = both(&gpu, &target, &scene.maps, options)?;
        scene.add(&mut tally, &stencil, &seen, (width, false));
        if round < 6 {
            let exchanged = target.stencil(&gpu, &scene.maps.exchanged([1, 0, 3, 2, 5, 4]), options)?;
            scene.add(&mut other, &exchanged, &seen, (width, false));
        }
    }
    must_fail("maps that are exchanged", &other.check("exchanged", 0))?;
    tally.check("across maps", 4)
}

/// Eyes farther away than any depth of the map. Far is no surface, but a map may clamp to it what is behind: all is drawn.
fn beyond() -> Result<(), String> {
    let gpu = Gpu::shared()?;
    let map = Map::new([9, 9], false, |_| 0.5);
    let (position, forward) = (DVec3::new(0.5, 1.0, -2.0), DVec3::Z);
    for (depth, half_width) in [(STANDARD, None), (REVERSED, None), (STANDARD, Some(2.0)), (REVERSED, Some(2.0))] {
        let light = Eye { depth, far: Some(2.5), half_width, ..look(position, forward, 0.5) }.camera();
        let maps = Maps::of(&gpu, &map, TextureFormat::R32Float, light)?;
        for along in [0.6, 2.0, 2.6, 8.9, 1e5] {
            let eye = Eye { depth, ..look(position + along * forward, forward, 1e-3) }.camera();
            let encoded = Encoded::new(&gpu, &*pipelines(&gpu, depth, 0..1)?, &maps, &eye, by(AUTOMATIC))?;
            same(&format!("{depth:?}, {half_width:?}, {along} away"), &[encoded.has_cap()], &[along > 1.0])?;
        }
    }
    Ok(())
}

/// The samples of a box.
fn samples(near: &DepthNearBox) -> impl Iterator<Item = [u32; 2]> {
    let ([x, y], [across, down]) = (near.first, near.size);
    (y..y + down).flat_map(move |y| (x..x + across).map(move |x| [x, y]))
}

/// Whether triangles between the samples may be nearer than the near rectangle. Texel 0 comes after a border.
fn may_be_before(map: &Map, border: i64, near: &DepthNearBox) -> bool {
    let depth = |[x, y]: [u32; 2]| cast(map, i64::from(x) - border, i64::from(y) - border);
    samples(near).any(|at| depth(at).is_some_and(|depth| rank(map, Some(depth)) <= i64::from(near.key)))
}

/// Whether surfaces that go on up to contours may be. A sample moves nearer by the largest step to a neighbour, in each
/// direction.
fn may_be_before_walls(map: &Map, near: &DepthNearBox) -> bool {
    let nearest = |at: [i32; 2]| {
        let distance_here = distance(map, at)?;
        let nearing = |[x, y]: [i32; 2]| {
            let beside = [[at[0] - x, at[1] - y], [at[0] + x, at[1] + y]];
            beside.into_iter().filter_map(|there| distance(map, there)).map(|other| (other - distance_here).abs()).max()
        };
        Some(distance_here - nearing([1, 0]).unwrap_or(0) - nearing([0, 1]).unwrap_or(0))
    };
    let mut nearest = samples(near).filter_map(|at| nearest(at.map(|at| at as i32)));
    nearest.any(|distance| distance <= i64::from(near.distance))
}

/// Whether surfaces before the near rectangle are in a box.
type Before<'a> = dyn Fn(&Encoded, &DepthNearBox) -> Result<bool, String> + 'a;

/// Pictures by their near caps, skipped, skipped by the GPU, and drawn; dark pixels; and, the negative control, pictures whose
/// decision differs if surfaces are never nearer.
#[derive(Clone, Copy, Debug, Default)]
struct Caps([usize; 3], usize, usize);

impl Caps {
    /// An eye near the scene. Its near plane is near or far away from it.
    fn add(
        &mut self,
        (gpu, random): (&Gpu, &mut Random),
        distance: f64,
        (maps, options, bits): (&Maps, DepthMapOptions, u32),
        may_be_before: &Before<'_>,
    ) -> Result<(), String> {
        let position = distance * f64::from(random.between(0.1, 1.0)) * vector(random);
        let near = [[0.01, 0.3], [0.3, 3.0]][random.below(2)];
        let eye = any_eye(random, position, near);
        let rays = Rays::new(&eye, SIDE);
        let depths = seen_depths(&eye, SIDE, &seen(random, &rays));
        let target = Target { bits: 0..bits, ..Target::new(eye, &depths) };
        let (stencil, encoded) = both(gpu, &target, maps, options)?;
        let near = near_box(&maps.lights, maps.size, (&eye, target.format), options.method != AUTOMATIC);
        let may_be_dark = near.map_or(Ok(false), |near| may_be_before(&encoded, &near))?;
        let other = near.map(|near| DepthNearBox { key: 0, distance: i32::MIN, ..near });
        self.2 += usize::from(may_be_dark != other.map_or(Ok(false), |near| may_be_before(&encoded, &near))?);
        if let DepthMapNearCap::Indirect(draw) = encoded.frame.near_cap() {
            same("the draw", &gpu.read::<u32>(draw, 4)?, &[if may_be_dark { 3 } else { 0 }, 1, 0, 0])?;
        }
        self.0[encoded.cap_kind()] += 1;
        self.1 += stencil.iter().filter(|&&value| value != 0).count();
        Ok(())
    }

    fn check(self, what: &str, least: [usize; 3]) -> Result<(), String> {
        println!("{what}: {self:?}");
        let is_tried = self.1 > 1000 && self.2 > 4 && self.0.iter().zip(least).all(|(&known, least)| known >= least);
        if is_tried { Ok(()) } else { Err(format!("{what}: {self:?}")) }
    }
}

/// Maps with five texels each way for each of others, into one bit and into two, and with walls.
fn of_maps() -> Result<(), String> {
    let (gpu, mut random) = Gpu::seeded(1695)?;
    let mut all = [Caps::default(); 3];
    for round in 0..if is_long() { 3000 } else { 300 } {
        let (camera, _) = light(&mut random);
        let small = map(&mut random, &camera);
        let [across, down] = small.size.map(|texels| 5 * texels);
        let texel = |at: u32| small.depths[(at / across / 5 * small.size[0] + at % across / 5) as usize];
        let map = Map::new([across, down], small.is_reversed, texel);
        let maps = Maps::of(&gpu, &map, TextureFormat::R32Float, camera)?;
        let (method, bits) = [(AUTOMATIC, 1), (AUTOMATIC, 2), (contours([0.005, 0.25, 0.02]), 1)][round % 3];
        let distance = [8.0, 24.0][round % 2];
        all[round % 3].add((&gpu, &mut random), distance, (&maps, by(method), bits), &|_, near| {
            Ok(if round % 3 == 2 { may_be_before_walls(&map, near) } else { may_be_before(&map, 1, near) })
        })?;
    }
    all.into_iter().zip(["maps", "bits", "walls"]).try_for_each(|(caps, what)| caps.check(what, [10, 4, 10]))
}

fn of_cubes() -> Result<(), String> {
    const SIDE: u32 = 24;
    let (gpu, mut random) = Gpu::seeded(1696)?;
    let [mut caps, mut without] = [Caps::default(); 2];
    let none: [Option<Map>; 6] = [const { None }; 6];
    let rounds = if is_long() { 1000 } else { 60 };
    for round in 0..rounds + 6 {
        let cube = cube_of(&mut random, SIDE);
        let given = if round < rounds { &cube.maps[..] } else { &none[..] };
        let maps = Maps::all(&gpu, (given, SIDE), TextureFormat::R32Float, &cube.cameras)?;
        let of_round = if round < rounds { &mut caps } else { &mut without };
        let distance = 5.0 + cube.light.length();
        of_round.add((&gpu, &mut random), distance, (&maps, by(AUTOMATIC), 1), &|encoded, near| {
            let Volumes::Cube(volumes) = &encoded.volumes else { return Err("no cube".to_owned()) };
            let depths = read(&gpu, volumes.texture().texture())?;
            // Six maps in one, without a border.
            let is_reversed = cube.cameras[0].depth == REVERSED;
            Ok(may_be_before(&Map { size: [3 * SIDE, 2 * SIDE], is_reversed, depths }, 0, near))
        })?;
    }
    same("dark pixels of cubes without maps", &[without.1], &[0])?;
    caps.check("cubes", [0, 5, 10])
}
