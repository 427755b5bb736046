//! A picture with a large map, against rays to the light.

use glam::{DVec2, DVec3, DVec4, Mat4};
use rimline::DepthDirection;
use rimline::gpu::depth_map::{DepthMap, DepthMapMethod, DepthMapOptions, DepthMapVolumes};
use rimline_testkit::device::Gpu;
use rimline_testkit::harness::Test;
use rimline_testkit::is_long;
use rimline_testkit::on_gpu::text;
use wgpu::TextureFormat;

use crate::maps::Map;
use crate::parity::{device_depth, middle};
use crate::picture::{pipelines, stencil_of};
use crate::scene::{Eye, Rays};
use crate::textures::{depth_view, texture};

pub(crate) const TESTS: &[Test] = &[("a_picture_of_a_large_map_is_right_but_for_a_texel", large)];

/// Plates over a floor, in an irregular pattern: whether one is over a place.
fn plate(x: f64, z: f64) -> bool {
    (x * 1.3).sin() + (z * 1.7 + 0.4 * x).cos() + 0.6 * (2.9 * x - 1.1 * z).sin() > 0.7
}

/// A map of 2,048² texels, with `RIMLINE_LONG=1` of 4,096², also by every cell.
fn large() -> Result<(), String> {
    const HEIGHT: f64 = 1.0;
    const PIXELS: u32 = 256;
    let gpu = Gpu::shared()?;
    let side: u32 = if is_long() { 4096 } else { 2048 };
    let towards = DVec3::new(0.35, 1.0, 0.2).normalize();
    let (depth, half_width) = (DepthDirection::Reversed, Some(6.0));
    let light = Eye {
        place: 12.0 * towards,
        forward: -towards,
        near: 1.0,
        is_relative: true,
        depth,
        far: Some(30.0),
        half_width,
    };
    let camera = light.camera();
    let first = |from: DVec3, ray: DVec3| {
        let on = |height: f64| from + (height - from.y) / ray.y * ray;
        let above = on(HEIGHT);
        let is_above = (HEIGHT - from.y) / ray.y > 0.0 && plate(above.x, above.z);
        (if is_above { above } else { on(0.0) }, is_above)
    };
    // Rays of a parallel light have one direction.
    let rays = Rays::new(&camera, side);
    let corners = [DVec2::ZERO, DVec2::new(1.0, 0.0), DVec2::new(0.0, 1.0)].map(|at| rays.at(at).0);
    let (right, down) = (corners[1] - corners[0], corners[2] - corners[0]);
    let matrix = Mat4::from_cols_array_2d(&camera.view_projection).as_dmat4();
    let row: DVec4 = matrix.row(2);
    let origin = DVec3::from_array(camera.origin.map(f64::from));
    let map = Map::new([side; 2], true, |at| {
        let from = corners[0] + (f64::from(at % side) + 0.5) * right + (f64::from(at / side) + 0.5) * down;
        row.dot((first(from, -towards).0 - origin).extend(1.0)) as f32
    });
    let texture = texture(&gpu, map.size, TextureFormat::Depth32Float, &map.depths)?;
    let (place, near) = (DVec3::new(4.0, 3.0, -3.5), 0.1);
    let eye = Eye { place, forward: -place, near, is_relative: false, depth, far: None, half_width: None }.camera();
    let eye_rays = Rays::new(&eye, PIXELS);
    let seen = |pixel: u32| {
        let (from, ray) = eye_rays.at(middle(pixel, PIXELS));
        (ray.y < -0.02).then(|| first(from, ray))
    };
    let seen: Vec<_> = (0..PIXELS * PIXELS).map(seen).collect();
    let depths: Vec<_> = seen.iter().map(|seen| seen.map_or(0.0, |(place, _)| device_depth(&eye, place))).collect();
    let pipelines = pipelines(&gpu, depth, 0..1)?;
    let detectors = [DepthMapMethod::Automatic { dangling: None }, DepthMapMethod::EveryCell];
    for edges in &detectors[..if is_long() { 2 } else { 1 }] {
        let options = DepthMapOptions { method: *edges, ..Default::default() };
        let mut volumes = DepthMapVolumes::new(&pipelines, map.size, options).map_err(text)?;
        let stencil = stencil_of(&gpu, &pipelines, (PIXELS, &depths), |encoder| {
            let map = DepthMap { texture: &depth_view(&texture), light: camera, objects: None };
            volumes.encode(encoder, &map, &eye).map_err(text)
        })?;
        let listed: Vec<u32> = gpu.read(volumes.cells(), 1)?;
        // Lit, dark, at borders, wrong, and wrong if the picture were upside down.
        let mut tally = [0; 5];
        for (pixel, seen) in seen.iter().enumerate() {
            let Some((place, is_above)) = *seen else { continue };
            // Within the map.
            let clip = matrix * (place - origin).extend(1.0);
            if clip.x.abs().max(clip.y.abs()) > 0.99 {
                continue;
            }
            let is_dark = |x: f64, y: f64| {
                let from = place + x * right + y * down + (if is_above { 0.0 } else { HEIGHT }) * towards / towards.y;
                !is_above && plate(from.x, from.z)
            };
            let truth = is_dark(0.0, 0.0);
            // On plates, a border is where one ends.
            let is_edge = |x: f64, y: f64| {
                let at = place + x * right + y * down;
                if is_above { !plate(at.x, at.z) } else { is_dark(x, y) != truth }
            };
            let is_at_border = (-2..=2).any(|x| (-2..=2).any(|y| is_edge(0.75 * f64::from(x), 0.75 * f64::from(y))));
            tally[usize::from(truth)] += 1;
            let is_wrong = (stencil[pixel] != 0) != truth;
            tally[if is_at_border { 2 } else { 3 }] += usize::from(is_wrong);
            tally[4] += usize::from((stencil[stencil.len() - 1 - pixel] != 0) != truth);
        }
        let [lit, dark, at_borders, wrong, turned] = tally;
        println!("{side}² texels, {edges:?}, {} cells: {lit} lit, {dark} dark", listed[0]);
        println!("{at_borders} wrong at borders, {wrong} elsewhere; upside down {turned}");
        if wrong > 0 || lit.min(dark) < 5000 || at_borders * 100 > lit + dark || turned < 1000 {
            return Err(format!("{edges:?}: {tally:?}"));
        }
    }
    Ok(())
}
