//! Near rectangles of any width, at the boundary: from a thousandth of a texel of the map to all of it, edge-on to the light,
//! and across two maps of a cube. The stencil against the crossings of rays, with near caps always drawn and left out where
//! they may be.

use glam::{DMat4, DVec2, DVec3, DVec4, Mat4};
use rimline::gpu::depth_map::{DepthCubeMaps, DepthMap, DepthMapCube, DepthMapOptions};
use rimline::{DepthDirection, ShadowCamera};
use rimline_testkit::device::Gpu;
use rimline_testkit::harness::Test;
use rimline_testkit::on_gpu::text;
use rimline_testkit::random::Random;
use rimline_testkit::{is_long, must_fail, same};
use wgpu::TextureFormat;

use crate::boundary::{Boundary, sample};
use crate::cube::{Cube, cube_of, views};
use crate::exact::{ROUNDING, steps};
use crate::eye_formats::{AROUND, Made, device, drawn};
use crate::maps::Map;
use crate::parity::{SIDE, light, map, middle, seen, seen_depths, vector};
use crate::picture::{pipelines, stencil_of};
use crate::scene::{Eye, Rays};
use crate::textures::{depth_view, texture};

pub(crate) const TESTS: &[Test] = &[
    ("near_rectangles_of_all_widths_are_those_of_rays", widths),
    ("near_rectangles_edge_on_to_the_light_are_those_of_rays", edge_on),
    ("near_rectangles_across_two_maps_are_those_of_rays", across),
];

/// From the light to the farthest places near the boundary.
const SCENE: f64 = 16.0;

/// The place of a map's sample, at any depth.
pub(crate) fn place(camera: &ShadowCamera, size: [u32; 2], [x, y]: [f64; 2], depth: f64) -> DVec3 {
    let matrix: DMat4 = Mat4::from_cols_array_2d(&camera.view_projection).as_dmat4().inverse();
    let [width, height] = size.map(f64::from);
    let point = matrix * DVec4::new((2.0 * x + 1.0) / width - 1.0, 1.0 - (2.0 * y + 1.0) / height, depth, 1.0);
    point.truncate() / point.w + DVec3::from_array(camera.origin.map(f64::from))
}

/// An eye whose near rectangle has its middle at a place, is `width` wide, and looks along `forward`.
pub(crate) fn eye_at(random: &mut Random, middle: DVec3, forward: DVec3, width: f64) -> ShadowCamera {
    let forward = forward.normalize();
    let is_relative = width < 0.1 || random.below(2) == 0;
    // Parallel rays where the near rectangle is small: the depths of a perspective eye would be too coarse there.
    let half_width = (width < 0.01 || random.below(3) == 0).then_some(width / 2.0);
    let near = if half_width.is_some() { 0.5 } else { width / 2.0 / 30_f64.to_radians().tan() };
    let depth =
        if half_width.is_some() && random.below(2) == 0 { DepthDirection::Standard } else { DepthDirection::Reversed };
    let far = half_width.map(|_| 24.0);
    Eye { place: middle - near * forward, forward, near, is_relative, depth, far, half_width }.camera()
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

#[derive(Clone, Copy, Debug, Default)]
struct Tally {
    dark: usize,
    lit: usize,
    near_borders: usize,
    /// Places of the near rectangle that are in shadow, and pictures that have both kinds.
    behind: usize,
    cut: usize,
    wrong: usize,
}

impl Tally {
    /// Compares a picture with rays, whose near rectangle is `width` wide. A vertex is off by five roundings of the terms that
    /// it adds up from, in numbers of the size of the scene; in pixels the more, the smaller the near rectangle is. `slip` is
    /// what a place of the near rectangle may be off by along the light's ray, because depths are floats.
    fn add(
        &mut self,
        boundary: &Boundary,
        stencil: &[bool],
        seen: &dyn Fn(DVec2) -> (DVec3, DVec3),
        (width, slip): (f64, &dyn Fn(DVec3) -> DVec3),
    ) {
        let pixels = 5.0 * ROUNDING * SCENE / width * f64::from(SIDE);
        let (share, wider) = (3, 1.0 + pixels / 0.05);
        let mut behind = [0; 2];
        for pixel in (0..SIDE * SIDE).filter(|pixel| pixel % share == pixel / SIDE % share) {
            let middle = middle(pixel, SIDE);
            let truth = |(x, y, part): (f64, f64, f64)| {
                let (near, place) = seen(middle + wider * DVec2::new(x, y));
                let place = near + part * (place - near);
                (boundary.parity(near, place), boundary.is_dark(near), boundary.is_dark(place))
            };
            let truths = AROUND.map(truth);
            let (near, _) = seen(middle);
            let slips = [slip(near), -slip(near)].map(|slip| boundary.is_dark(near + slip));
            behind[usize::from(truths[0].1)] += 1;
            if truths != [truths[0]; 6] || truths[0].0 != truths[0].2 || slips != [truths[0].1; 2] {
                self.near_borders += 1;
                continue;
            }
            *(if truths[0].0 { &mut self.dark } else { &mut self.lit }) += 1;
            self.behind += usize::from(truths[0].1);
            self.wrong += usize::from(stencil[pixel as usize] != truths[0].0);
        }
        self.cut += usize::from(behind[0] > 0 && behind[1] > 0);
    }

    fn check(&self, what: &str, least: usize) -> Result<(), String> {
        println!("{what}: {self:?}");
        let told = self.dark + self.lit;
        if self.wrong == 0 && self.dark.min(self.lit) > 50 && self.cut >= least && self.near_borders * 2 < told {
            Ok(())
        } else {
            Err(format!("{what}: {self:?}"))
        }
    }
}

/// A light, a map of it, and a place on its boundary with the width of a texel there.
fn scene(random: &mut Random) -> Option<(ShadowCamera, DVec4, Map, DVec3, f64)> {
    let (camera, at) = light(random);
    let map = map(random, &camera);
    let texel = [0, 1].map(|axis| random.below(map.size[axis] as usize) as i64);
    let depth = sample(&map, texel[0], texel[1])?;
    let [x, y] = texel.map(|at| at as f64);
    let middle = place(&camera, map.size, [x, y], depth);
    let width = (place(&camera, map.size, [x + 1.0, y], depth) - middle).length();
    Some((camera, at, map, middle, width))
}

/// The picture of a scene with the switch on and off.
fn pictures(
    (gpu, pipelines): (&Gpu, &mut Made),
    random: &mut Random,
    (camera, at, map): (ShadowCamera, DVec4, &Map),
    (eye, width): (&ShadowCamera, f64),
    tally: &mut Tally,
) -> Result<Vec<bool>, String> {
    // Its near plane is that of the boundary, which is moved by the steps of the eye's depths.
    let rays = Rays::new(&moved(eye), SIDE);
    let seen = seen(random, &rays);
    let depths = seen_depths(eye, SIDE, &seen);
    let texture = texture(gpu, map.size, TextureFormat::R32Float, &map.depths)?;
    let given = DepthMap { texture: &depth_view(&texture), light: camera, objects: None };
    let target = (TextureFormat::Depth32FloatStencil8, 1);
    let mut picture = |skip_near_caps| {
        let options = DepthMapOptions { slope_bias: 0.0, skip_near_caps, ..Default::default() };
        drawn(gpu, pipelines, target, &depths, (&given, eye), options)
    };
    let found = picture(true)?;
    same("with near caps that are always drawn", &picture(false)?, &found)?;
    let boundary = Boundary::new(map, &camera, at, -1.0);
    let stencil: Vec<_> = found.iter().map(|&value| value != 0).collect();
    // The move of the map's depths, and twenty roundings of them: docs/numerics/depth-maps.md, "Rounding of positions".
    let depth = |place: DVec3| {
        let matrix = Mat4::from_cols_array_2d(&camera.view_projection).as_dmat4();
        let clip = matrix * (place - DVec3::from_array(camera.origin.map(f64::from))).extend(1.0);
        clip.z / clip.w
    };
    let slip = |near: DVec3| {
        let ray = (at.truncate() - at.w * near).normalize();
        let slope = (depth(near + 1e-4 * ray) - depth(near)) / 1e-4;
        24.0 * ROUNDING * depth(near).abs() / slope.abs() * ray
    };
    tally.add(&boundary, &stencil, &seen, (width, &slip));
    Ok(stencil)
}

fn widths() -> Result<(), String> {
    const SEED: u64 = 16_301;
    println!("seed {SEED}");
    let gpu = device()?;
    let mut pipelines = Made::default();
    let mut random = Random::new(SEED);
    for texels in [0.001, 0.03, 0.4, 1.0, 4.0, 0.0] {
        let mut tally = Tally::default();
        let mut rounds = 0;
        while rounds < if is_long() { 60 } else { 6 } {
            let Some((camera, at, map, middle, width)) = scene(&mut random) else { continue };
            // 0: the whole map.
            let width = width * if texels == 0.0 { f64::from(map.size[0].max(map.size[1])) } else { texels };
            let middle = middle + width * f64::from(random.between(-0.3, 0.3)) * vector(&mut random);
            let forward = vector(&mut random);
            let eye = eye_at(&mut random, middle, forward, width);
            let before = tally.wrong;
            pictures((&gpu, &mut pipelines), &mut random, (camera, at, &map), (&eye, width), &mut tally)?;
            if tally.wrong > before {
                println!("{} wrong of {texels} texels: {eye:?}, {camera:?}", tally.wrong - before);
            }
            rounds += 1;
        }
        tally.check(&format!("{texels} texels"), rounds / 4)?;
    }
    Ok(())
}

/// The light lies in the plane of the near rectangle, exactly or nearly.
fn edge_on() -> Result<(), String> {
    const SEED: u64 = 16_302;
    println!("seed {SEED}");
    let gpu = device()?;
    let mut pipelines = Made::default();
    let mut random = Random::new(SEED);
    for tilt in [0.0, 1e-6, 1e-3, 0.03] {
        let (mut tally, mut rounds) = (Tally::default(), 0);
        while rounds < if is_long() { 60 } else { 6 } {
            let Some((camera, at, map, middle, width)) = scene(&mut random) else { continue };
            let width = width * [0.3, 2.0, 8.0][rounds % 3];
            let to_light = if at.w == 0.0 { at.truncate() } else { (at.truncate() - middle).normalize() };
            let forward = to_light.cross(vector(&mut random)).normalize() + tilt * to_light;
            let eye = eye_at(&mut random, middle, forward, width);
            pictures((&gpu, &mut pipelines), &mut random, (camera, at, &map), (&eye, width), &mut tally)?;
            rounds += 1;
        }
        tally.check(&format!("tilted by {tilt}"), rounds / 4)?;
    }
    Ok(())
}

/// Near rectangles whose middle is on a ray that two maps of a cube share, or three.
fn across() -> Result<(), String> {
    const SEED: u64 = 16_303;
    println!("seed {SEED}");
    let gpu = Gpu::shared()?;
    let mut random = Random::new(SEED);
    let (mut tally, mut other) = (Tally::default(), Tally::default());
    for round in 0..if is_long() { 120 } else { 18 } {
        let Cube { light, cameras, maps, .. } = cube_of(&mut random, 6);
        // The middles of the outermost texels lie on the edges of the cube.
        let face = random.below(6);
        let along = f64::from(random.below(6) as u32);
        let corner = [[0.0, along], [5.0, along], [along, 0.0], [along, 5.0]][random.below(4)];
        let ray = (place(&cameras[face], [6; 2], corner, 0.5) - light).normalize();
        let distance = f64::from(random.between(1.0, 8.0));
        let width = distance * [0.001, 0.05, 0.5, 1.5][round % 4];
        let middle = light + distance * ray + width * f64::from(random.between(-0.2, 0.2)) * vector(&mut random);
        // A third of them edge-on.
        let forward = if round % 3 == 0 { ray.cross(vector(&mut random)) } else { vector(&mut random) };
        let half_width = Some(width / 2.0);
        let depth = [DepthDirection::Reversed, DepthDirection::Standard][random.below(2)];
        let forward = forward.normalize();
        let place = middle - 0.5 * forward;
        let eye = Eye { place, forward, near: 0.5, is_relative: true, depth, far: Some(60.0), half_width }.camera();
        let rays = Rays::new(&eye, SIDE);
        let seen = seen(&mut random, &rays);
        let depths = seen_depths(&eye, SIDE, &seen);
        let pipelines = pipelines(&gpu, depth, 0..1)?;
        let views = views(&gpu, &maps)?;
        let picture = |skip_near_caps, order: [usize; 6]| {
            let options = DepthMapOptions { slope_bias: 0.0, skip_near_caps, ..Default::default() };
            let mut volumes = DepthMapCube::new(&pipelines, 6, options).map_err(text)?;
            stencil_of(&gpu, &pipelines, (SIDE, &depths), |encoder| {
                let textures = order.map(|face| views[face].as_ref());
                let maps = DepthCubeMaps { textures, lights: cameras, objects: [None; 6] };
                volumes.encode(encoder, &maps, &eye).map_err(text)
            })
        };
        let plain = [0, 1, 2, 3, 4, 5];
        let found = picture(true, plain)?;
        same("with near caps that are always drawn", &picture(false, plain)?, &found)?;
        let no_slip = |_: DVec3| DVec3::ZERO;
        let boundary = Boundary::cube(&maps, &cameras, light, -1.0);
        let is_set = |stencil: Vec<u8>| stencil.into_iter().map(|value| value != 0).collect::<Vec<_>>();
        tally.add(&boundary, &is_set(found), &seen, (width, &no_slip));
        if round < 6 {
            other.add(&boundary, &is_set(picture(true, [1, 0, 3, 2, 5, 4])?), &seen, (width, &no_slip));
        }
    }
    must_fail("maps that are exchanged", &other.check("exchanged", 0))?;
    tally.check("across maps", 4)
}
