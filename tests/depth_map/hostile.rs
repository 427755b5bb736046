//! Receivers beyond the far plane of a light and before its near plane, planes that the light sees at grazing angles, six maps
//! of a cube against rays to the light.

use glam::{DVec2, DVec3, Mat4};
use rimline::gpu::depth_map::{
    DepthCubeMaps, DepthMap, DepthMapCube, DepthMapMethod, DepthMapOptions, DepthMapPipelines, DepthMapVolumes,
};
use rimline::{DepthDirection, ShadowCamera};
use rimline_testkit::device::Gpu;
use rimline_testkit::harness::Test;
use rimline_testkit::is_long;
use rimline_testkit::on_gpu::text;
use rimline_testkit::random::Random;
use wgpu::TextureFormat;

use crate::boundary::Boundary;
use crate::eye_formats::AROUND;
use crate::maps::Map;
use crate::parity::{SIDE, device_depth, map, middle, seen, vector};
use crate::picture::{pipelines, stencil_of};
use crate::scene::{Eye, Rays};
use crate::textures::{depth_view, texture};
use crate::views::{Near, Sun, face_towards, what_is_near, worlds};

pub(crate) const TESTS: &[Test] = &[
    ("receivers_beyond_far_and_before_near_are_those_of_rays", beyond),
    ("planes_at_grazing_angles_have_no_specks", grazing),
    ("shadows_of_cubes_are_right_but_for_a_texel", of_cubes),
];

/// The stencil of a picture.
fn drawn(
    gpu: &Gpu,
    pipelines: &DepthMapPipelines,
    (map, light): (&wgpu::Texture, ShadowCamera),
    (eye, depths): (&ShadowCamera, &[f32]),
    options: DepthMapOptions,
) -> Result<Vec<u8>, String> {
    let mut volumes = DepthMapVolumes::new(pipelines, [map.width(), map.height()], options).map_err(text)?;
    stencil_of(gpu, pipelines, (SIDE, depths), |encoder| {
        volumes.encode(encoder, &DepthMap { texture: &depth_view(map), light, objects: None }, eye).map_err(text)
    })
}

/// How far away from the light a place is along the direction that its map looks in, and the distances of near and far plane.
fn distance(eye: &Eye, place: DVec3) -> f64 {
    (place - eye.place).dot(eye.forward.normalize())
}

/// Lights with a near plane before the scene's middle and a far plane in it.
fn beyond() -> Result<(), String> {
    const SEED: u64 = 16_401;
    println!("seed {SEED}");
    let gpu = Gpu::shared()?;
    let pipelines = pipelines(&gpu, DepthDirection::Reversed, 0..1)?;
    let mut random = Random::new(SEED);
    // Counts of receivers before the near plane, between, and beyond the far plane: dark, lit, wrong.
    let mut tally = [[0_usize; 3]; 3];
    let mut near_borders = 0;
    for _ in 0..if is_long() { 300 } else { 40 } {
        let away = vector(&mut random);
        let depth = [DepthDirection::Reversed, DepthDirection::Standard][random.below(2)];
        let half_width = [None, Some(4.0)][random.below(2)];
        let (near, far) = (f64::from(random.between(2.0, 4.5)), f64::from(random.between(9.0, 11.0)));
        let light = Eye {
            place: 8.0 * away,
            forward: -away,
            near,
            is_relative: random.below(2) == 0,
            depth,
            far: Some(far),
            half_width,
        };
        let camera = light.camera();
        let at = if half_width.is_some() { away.extend(0.0) } else { light.place.extend(1.0) };
        let map = map(&mut random, &camera);
        let place = f64::from(random.between(1.0, 9.0)) * vector(&mut random);
        let depth = DepthDirection::Reversed;
        let forward = vector(&mut random) * 3.0 - place;
        let near_eye = f64::from(random.between(0.1, 1.0));
        let eye =
            Eye { place, forward, near: near_eye, is_relative: true, depth, far: None, half_width: None }.camera();
        let rays = Rays::new(&eye, SIDE);
        let seen = seen(&mut random, &rays);
        let depths: Vec<_> = (0..SIDE * SIDE).map(|pixel| device_depth(&eye, seen(middle(pixel, SIDE)).1)).collect();
        let texture = texture(&gpu, map.size, TextureFormat::R32Float, &map.depths)?;
        let options = DepthMapOptions { slope_bias: 0.0, ..Default::default() };
        let stencil = drawn(&gpu, &pipelines, (&texture, camera), (&eye, &depths), options)?;
        let boundary = Boundary::new(&map, &camera, at, -1.0);
        for (pixel, &value) in (0..).zip(&stencil).filter(|(pixel, _)| pixel % 3 == 0) {
            let truth = |(x, y, part): (f64, f64, f64)| {
                let (near, place) = seen(middle(pixel, SIDE) + DVec2::new(x, y));
                let place = near + part * (place - near);
                (boundary.parity(near, place), boundary.is_dark(near), boundary.is_dark(place))
            };
            let truths = AROUND.map(truth);
            if truths != [truths[0]; 6] || truths[0].0 != truths[0].2 {
                near_borders += 1;
                continue;
            }
            let away = distance(&light, seen(middle(pixel, SIDE)).1);
            let kind = usize::from(away > near) + usize::from(away > far);
            tally[kind][usize::from(!truths[0].0)] += 1;
            tally[kind][2] += usize::from((value != 0) != truths[0].0);
        }
    }
    println!(
        "dark, lit, wrong: {tally:?} before the near plane, between, and beyond the far plane; {near_borders} near borders"
    );
    let is_right = tally.iter().all(|kind| kind[2] == 0);
    // Nothing is in shadow before the near plane: the map has nothing there.
    if is_right && tally[0][1] > 1000 && tally[0][0] == 0 && tally[1][0].min(tally[2][0]) > 150 && tally[2][1] > 1000 {
        Ok(())
    } else {
        Err(format!("{tally:?}"))
    }
}

/// The light sees a plane at an angle near 90° from its normal. Points on the plane are lit, seen from above. Points behind
/// it by more than the bias are dark, seen from below.
fn grazing() -> Result<(), String> {
    const SEED: u64 = 16_402;
    const TEXELS: u32 = 64;
    println!("seed {SEED}");
    let gpu = Gpu::shared()?;
    let pipelines = pipelines(&gpu, DepthDirection::Reversed, 0..1)?;
    let mut random = Random::new(SEED);
    // Lit, and dark; wrong ones of each.
    let (mut seen_of, mut wrong) = ([0; 2], [0; 2]);
    let mut unmoved = 0;
    for round in 0..if is_long() { 300 } else { 15 } {
        let degrees = [85.0, 88.0, 89.5, 89.9, 89.99][round % 5];
        let angle = f64::to_radians(degrees);
        let depth = [DepthDirection::Reversed, DepthDirection::Standard][random.below(2)];
        let forward = vector(&mut random);
        let across = forward.cross(vector(&mut random)).normalize();
        // From the light's direction the normal is turned away by the angle.
        let normal = (-forward * angle.cos() + forward.cross(across) * angle.sin()).normalize();
        // So small a map that the plane passes from near to far within 30 texels of 64.
        let texel = 18.0 / (30.0 * angle.tan());
        let half_width = f64::from(TEXELS) / 2.0 * texel;
        let light = Eye {
            place: -10.0 * forward,
            forward,
            near: 1.0,
            is_relative: random.below(2) == 0,
            depth,
            far: Some(19.0),
            half_width: Some(half_width),
        };
        let camera = light.camera();
        let rays = Rays::new(&camera, TEXELS);
        let is_reversed = depth == DepthDirection::Reversed;
        let map = Map::new([TEXELS; 2], is_reversed, |at| {
            let (from, ray) = rays.at(middle(at, TEXELS));
            let t = -from.dot(normal) / ray.dot(normal);
            if (0.0..18.0).contains(&t) { device_depth(&camera, from + t * ray) } else { f32::from(!is_reversed) }
        });
        let texture = texture(&gpu, map.size, TextureFormat::Depth32Float, &map.depths)?;
        // Along the plane, and away from the light.
        let along = (forward - forward.dot(normal) * normal).normalize();
        let foot = f64::from(random.between(-6.0, 6.0)) * along;
        // The bias is a texel's diagonal at most, which along the light is as much times the tangent, and four steps.
        let behind = 2.5 * texel * angle.tan() + 0.01;
        for (is_below, edges) in [(false, 0), (false, 1), (true, 0), (true, 1)] {
            let edges = [DepthMapMethod::EveryCell, DepthMapMethod::Automatic { dangling: None }][edges];
            let side = if is_below { -1.0 } else { 1.0 };
            let width = half_width * f64::from(random.between(0.3, 1.5));
            // The eye looks at the plane, or from below at what lies behind it.
            let tilt = f64::from(random.between(-0.5, 0.5)) * along;
            let away = (side * normal + tilt).normalize();
            let target = if is_below { foot + behind * forward } else { foot };
            let half_width = Some(width);
            let place = target + 2.0 * away;
            let (near, far, is_relative) = (if is_below { 0.5 } else { 0.1 }, Some(10.0), true);
            let depth = DepthDirection::Reversed;
            let eye = Eye { place, forward: -away, near, is_relative, depth, far, half_width }.camera();
            let eye_rays = Rays::new(&eye, SIDE);
            let seen = |pixel: u32| {
                let (from, ray) = eye_rays.at(middle(pixel, SIDE));
                from - (from - target).dot(normal) / ray.dot(normal) * ray
            };
            let depths: Vec<_> = (0..SIDE * SIDE).map(|pixel| device_depth(&eye, seen(pixel))).collect();
            let draw = |slope_bias| {
                let options = DepthMapOptions { method: edges, slope_bias, ..Default::default() };
                drawn(&gpu, &pipelines, (&texture, camera), (&eye, &depths), options)
            };
            let stencil = draw(1.0)?;
            let other = if is_below { stencil.clone() } else { draw(0.0)? };
            let matrix = Mat4::from_cols_array_2d(&camera.view_projection).as_dmat4();
            for (pixel, &value) in (0..).zip(&stencil) {
                // In the map, with two texels to spare, and the plane there.
                let place = seen(pixel);
                let clip = matrix * (place - DVec3::from_array(camera.origin.map(f64::from))).extend(1.0);
                let at = clip.truncate().truncate() / clip.w;
                let texels = DVec2::new(at.x + 1.0, 1.0 - at.y) / 2.0 * f64::from(TEXELS);
                let is_seen = |(x, y): (i64, i64)| {
                    let [x, y] = [texels.x.floor() as i64 + x, texels.y.floor() as i64 + y];
                    crate::boundary::sample(&map, x, y).is_some()
                };
                if !(-2..=2).all(|x| (-2..=2).all(|y| is_seen((x, y)))) {
                    continue;
                }
                let kind = usize::from(is_below);
                seen_of[kind] += 1;
                wrong[kind] += usize::from((value != 0) != is_below);
                unmoved += usize::from(!is_below && other[pixel as usize] != 0);
            }
        }
    }
    println!(
        "{seen_of:?} on planes and behind them, {wrong:?} wrong; without the slope's move {unmoved} on planes are"
    );
    if wrong == [0; 2] && seen_of[0].min(seen_of[1]) > 10_000 {
        Ok(())
    } else {
        Err(format!("{wrong:?} of {seen_of:?}"))
    }
}

/// Maps without objects.
fn maps_of<'a>(textures: [Option<&'a wgpu::TextureView>; 6], lights: &[ShadowCamera; 6]) -> DepthCubeMaps<'a> {
    DepthCubeMaps { textures, lights: *lights, objects: [None; 6] }
}

/// Bodies on a ground around a light, against rays to the light: every cell, and the default detector.
fn of_cubes() -> Result<(), String> {
    const SEED: u64 = 16_403;
    const TEXELS: u32 = 48;
    println!("seed {SEED}");
    let gpu = Gpu::shared()?;
    let mut random = Random::new(SEED);
    // Lit and dark ones; those wrong at borders and at folds with every cell, wrong ones elsewhere with it and with the default;
    // and wrong ones with maps that are exchanged.
    let ([mut lit, mut dark, mut borders, mut folds, mut exchanged, mut cut], mut wrong) = ([0; 6], [0; 2]);
    for round in 0..if is_long() { 6 } else { 1 } {
        for (number, world) in worlds(&mut random).iter().enumerate() {
            if !is_long() && ![1, 2, 3].contains(&number) {
                continue;
            }
            let mut between = |low: f32, high: f32| f64::from(random.between(low, high));
            let light = DVec3::new(between(-2.5, 2.5), between(2.7, 4.0), between(-2.5, 2.5)).as_vec3();
            let depth = [DepthDirection::Reversed, DepthDirection::Standard][(round + number) % 2];
            let cameras = DepthMapCube::cameras(light.to_array(), 0.1, None, depth, TEXELS).map_err(text)?;
            let light = light.as_dvec3();
            if world.is_inside(light) {
                continue;
            }
            let light_rays = cameras.map(|camera| Rays::new(&camera, TEXELS));
            let mut views = Vec::new();
            for (camera, rays) in cameras.iter().zip(&light_rays) {
                let map = Map::new([TEXELS; 2], depth == DepthDirection::Reversed, |at| {
                    let (from, ray) = rays.at(middle(at, TEXELS));
                    let hit = world.first(from, ray);
                    let far = f32::from(depth == DepthDirection::Standard);
                    hit.map_or(far, |(t, _)| device_depth(camera, from + t * ray))
                });
                views.push(depth_view(&texture(&gpu, map.size, TextureFormat::Depth32Float, &map.depths)?));
            }
            let place = DVec3::new(between(-5.0, 5.0), between(1.0, 5.0), between(-5.0, 5.0));
            if world.is_inside(place) {
                continue;
            }
            let eye_depth = DepthDirection::Reversed;
            let forward = DVec3::new(between(-1.0, 1.0), between(0.0, 1.0), between(-1.0, 1.0)) - place;
            let eye =
                Eye { place, forward, near: 0.05, is_relative: true, depth: eye_depth, far: None, half_width: None };
            let eye = eye.camera();
            let rays = Rays::new(&eye, SIDE);
            // Where the near plane cuts a body, what it cuts off is not in the depth buffer, and the default detector needs it there.
            let mut corners = (0..=SIDE).flat_map(|y| (0..=SIDE).map(move |x| DVec2::new(f64::from(x), f64::from(y))));
            let is_cut = corners.any(|place| world.is_inside(rays.at(place).0));
            cut += usize::from(is_cut);
            let seen: Vec<_> = (0..SIDE * SIDE)
                .map(|pixel| {
                    let (from, ray) = rays.at(middle(pixel, SIDE));
                    world.first(from, ray).map(|(t, normal)| (from + t * ray, normal))
                })
                .collect();
            let depths: Vec<_> =
                seen.iter().map(|seen| seen.map_or(0.0, |(place, _)| device_depth(&eye, place))).collect();
            let pipelines = pipelines(&gpu, eye_depth, 0..1)?;
            let draw = |order: [usize; 6], edges| {
                let options = DepthMapOptions { method: edges, ..Default::default() };
                let mut volumes = DepthMapCube::new(&pipelines, TEXELS, options).map_err(text)?;
                stencil_of(&gpu, &pipelines, (SIDE, &depths), |encoder| {
                    let maps = maps_of(order.map(|face| Some(&views[face])), &cameras);
                    volumes.encode(encoder, &maps, &eye).map_err(text)
                })
            };
            let order = [0, 1, 2, 3, 4, 5];
            let stencils =
                [draw(order, DepthMapMethod::EveryCell)?, draw(order, DepthMapMethod::Automatic { dangling: None })?];
            let other = draw([1, 0, 2, 3, 5, 4], DepthMapMethod::EveryCell)?;
            for (pixel, seen) in seen.iter().enumerate() {
                let Some(seen) = *seen else { continue };
                // The map whose axis is nearest to the way to the place.
                let face = face_towards(seen.0 - light);
                let sun = Sun::new(light, false, cameras[face]);
                if sun.is_averted(seen.0, seen.1) {
                    continue;
                }
                let is_lit = sun.is_lit(world, seen.0, seen.1);
                *(if is_lit { &mut lit } else { &mut dark }) += 1;
                let is_wrong = |stencil: &[u8]| (stencil[pixel] == 0) != is_lit;
                exchanged += usize::from(is_wrong(&other));
                let are_wrong = [is_wrong(&stencils[0]), is_wrong(&stencils[1]) && !is_cut];
                if are_wrong == [false; 2] {
                    continue;
                }
                match what_is_near((world, &sun), (&light_rays[face], TEXELS), 1.0, seen) {
                    Near::Border => borders += usize::from(are_wrong[0]),
                    Near::Fold => folds += usize::from(are_wrong[0]),
                    Near::Nothing => {
                        wrong = [0, 1].map(|at: usize| wrong[at] + usize::from(are_wrong[at]));
                        println!("world {number}, round {round}, pixel {pixel}: {seen:?}, lit {is_lit}, light {light}");
                    }
                }
            }
        }
    }
    println!(
        "{lit} lit, {dark} dark; {borders} wrong at borders, {folds} at folds, {wrong:?} elsewhere; exchanged {exchanged}; \
         {cut} near rectangles in bodies"
    );
    if wrong == [0; 2] && lit > 1500 && dark > 150 && (borders + folds) * 10 < lit + dark && exchanged > 300 {
        Ok(())
    } else {
        Err(format!("{wrong:?} wrong"))
    }
}
