//! Near rectangles of any width, at the boundary: from a thousandth of a texel of the map to all of it, edge-on to the
//! light, and across two maps of a cube. The stencil against the crossings of rays, with near caps always drawn and
//! skipped where they may be.

use glam::{DVec3, DVec4};
use rimline::ShadowCamera;
use rimline::gpu::depth_map::DepthMapOptions;
use rimline_testkit::device::Gpu;
use rimline_testkit::harness::Test;
use rimline_testkit::random::Random;
use rimline_testkit::{is_long, must_fail, same};
use wgpu::TextureFormat;

use crate::boundary::{Boundary, sample};
use crate::cube::{Cube, cube_of};
use crate::exact::{ROUNDING, steps};
use crate::parity::{self, SIDE, clip, either, light, map, middle, seen, seen_depths, truth, unprojected};
use crate::picture::{Maps, REVERSED, STANDARD, Target, look};
use crate::scene::{Eye, Rays, vector};

pub(crate) const TESTS: &[Test] = &[
    ("near_rectangles_of_all_widths_are_those_of_rays", widths),
    ("near_rectangles_edge_on_to_the_light_are_those_of_rays", edge_on),
    ("near_rectangles_across_two_maps_are_those_of_rays", across),
];

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
    let [share, constant] = steps(TextureFormat::Depth32FloatStencil8, eye.depth);
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
    /// Compares a picture with rays, whose near rectangle is `width` wide. A vertex is off by five roundings of the
    /// terms that it adds up from, in numbers of the size of the scene; in pixels the more, the smaller the near
    /// rectangle is. `slip` is what a position of the near rectangle may be off by along the light's ray, because
    /// depths are floats.
    fn add(
        &mut self,
        boundary: &Boundary,
        stencil: &[u8],
        seen: &parity::Seen<'_>,
        (width, slip): (f64, &dyn Fn(DVec3) -> DVec3),
    ) {
        let pixels = 5.0 * ROUNDING * SCENE / width * f64::from(SIDE);
        let (share, wider) = (3, 1.0 + pixels / 0.05);
        let mut behind = [0; 2];
        for pixel in (0..SIDE * SIDE).filter(|pixel| pixel % share == pixel / SIDE % share) {
            let middle = middle(pixel, SIDE);
            let (near, _) = seen(middle);
            let is_dark = boundary.is_dark(near);
            behind[usize::from(is_dark)] += 1;
            let slips = [slip(near), -slip(near)].map(|slip| boundary.is_dark(near + slip));
            let truth = truth(boundary, seen, middle, (wider, true)).filter(|_| slips == [is_dark; 2]);
            self.pixels.add(truth, stencil[pixel as usize] != 0);
        }
        self.cut += usize::from(behind[0] > 0 && behind[1] > 0);
    }

    fn check(&self, what: &str, least: usize) -> Result<(), String> {
        println!("{what}: {self:?}");
        let parity::Tally { dark, lit, near_borders, wrong, .. } = self.pixels;
        let is_tried = dark.min(lit) > 50 && self.cut >= least && near_borders * 2 < dark + lit;
        if wrong == 0 && is_tried { Ok(()) } else { Err(format!("{what}: {self:?}")) }
    }
}

/// The stencil of a picture, which is the same with near caps that are always drawn.
pub(crate) fn both(gpu: &Gpu, target: &Target<'_>, maps: &Maps, options: DepthMapOptions) -> Result<Vec<u8>, String> {
    let [skipped, all] = [true, false].map(|skip_near_caps| {
        let (stencil, encoded) = target.draw(gpu, maps, DepthMapOptions { skip_near_caps, ..options })?;
        if skip_near_caps || encoded.has_cap() { Ok(stencil) } else { Err("a near cap is skipped".to_owned()) }
    });
    let skipped = skipped?;
    same("with near caps that are always drawn", &skipped, &all?)?;
    Ok(skipped)
}

/// From the light (homogeneous) and a position, the width of a texel there and the map's size, and a number: where the
/// middle of a near rectangle is, where it looks, and how wide it is.
type At<'a> = dyn Fn(&mut Random, (DVec4, DVec3), (f64, [u32; 2]), usize) -> (DVec3, DVec3, f64) + 'a;

/// Pictures at positions of a boundary.
fn trials(random: &mut Random, (what, least): (&str, usize), at: &At<'_>) -> Result<(), String> {
    let gpu = Gpu::shared_with_depth_features()?;
    let (mut tally, mut rounds) = (Tally::default(), 0);
    while rounds < if is_long() { 60 } else { 6 } {
        let (camera, homogeneous) = light(random);
        let map = map(random, &camera);
        let texel = [0, 1].map(|axis| random.below(map.size[axis] as usize) as i64);
        let Some(depth) = sample(&map, texel[0], texel[1]) else { continue };
        let [x, y] = texel.map(|at| at as f64);
        let middle = position(&camera, map.size, [x, y], depth);
        let width = (position(&camera, map.size, [x + 1.0, y], depth) - middle).length();
        let (middle, forward, width) = at(random, (homogeneous, middle), (width, map.size), rounds);
        let eye = eye_at(random, middle, forward, width);
        // Its near plane is that of the boundary, which is moved by the steps of the eye's depths.
        let rays = Rays::new(&moved(&eye), SIDE);
        let seen = seen(random, &rays);
        let depths = seen_depths(&eye, SIDE, &seen);
        let maps = Maps::of(&gpu, &map, TextureFormat::R32Float, camera)?;
        let target = Target { format: TextureFormat::Depth32FloatStencil8, ..Target::new(eye, &depths) };
        let options = DepthMapOptions { slope_bias: 0.0, ..Default::default() };
        let stencil = both(&gpu, &target, &maps, options)?;
        let boundary = Boundary::edited(&map, &camera, homogeneous, -1.0, None);
        // The move of the map's depths, and twenty roundings of them: docs/numerics/depth-maps.md, "Rounding of positions".
        let depth = |position: DVec3| {
            let clip = clip(&camera, position);
            clip.z / clip.w
        };
        let slip = |near: DVec3| {
            let ray = (homogeneous.truncate() - homogeneous.w * near).normalize();
            let slope = (depth(near + 1e-4 * ray) - depth(near)) / 1e-4;
            24.0 * ROUNDING * depth(near).abs() / slope.abs() * ray
        };
        let before = tally.pixels.wrong;
        tally.add(&boundary, &stencil, &seen, (width, &slip));
        if tally.pixels.wrong > before {
            println!("{} wrong, {what}: {eye:?}, {camera:?}", tally.pixels.wrong - before);
        }
        rounds += 1;
    }
    tally.check(what, rounds / least)
}

fn widths() -> Result<(), String> {
    let mut random = Random::new(16_301);
    for texels in [0.001, 0.03, 0.4, 1.0, 4.0, 0.0] {
        trials(&mut random, (&format!("{texels} texels"), 4), &|random, (_, middle), (width, size), _| {
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
        trials(&mut random, (&format!("tilted by {tilt}"), 4), &|random, (at, middle), (width, _), round| {
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
        let Cube { light, cameras, maps, .. } = cube_of(&mut random, 6);
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
        let given = Maps::all(&gpu, (&maps, 6), TextureFormat::R32Float, &cameras)?;
        let options = DepthMapOptions { slope_bias: 0.0, ..Default::default() };
        let stencil = both(&gpu, &target, &given, options)?;
        let boundary = Boundary::cube(&maps, &cameras, light, -1.0);
        let no_slip = |_: DVec3| DVec3::ZERO;
        tally.add(&boundary, &stencil, &seen, (width, &no_slip));
        if round < 6 {
            let exchanged = target.stencil(&gpu, &given.exchanged([1, 0, 3, 2, 5, 4]), options)?;
            other.add(&boundary, &exchanged, &seen, (width, &no_slip));
        }
    }
    must_fail("maps that are exchanged", &other.check("exchanged", 0))?;
    tally.check("across maps", 4)
}
