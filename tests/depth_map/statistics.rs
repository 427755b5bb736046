//! Statistics that the GPU copies for its readers: lists that overflow, and near caps that are left out.

use rimline::gpu::depth_map::{
    DepthMap, DepthMapFrame, DepthMapMethod, DepthMapOptions, DepthMapStatistics, DepthMapVolumes,
};
use rimline::reference::depth_map::DepthMapNearCap;
use rimline::{DepthDirection, ShadowCamera};
use rimline_testkit::device::Gpu;
use rimline_testkit::harness::Test;
use rimline_testkit::on_gpu::text;
use rimline_testkit::random::Random;
use rimline_testkit::same;
use wgpu::TextureFormat;

use crate::cells;
use crate::maps::{Map, maps};
use crate::picture::pipelines;
use crate::stages::{camera, direction};
use crate::textures::{depth_view, texture};

pub(crate) const TESTS: &[Test] =
    &[("statistics_tell_of_lists_that_overflow", lists), ("statistics_tell_of_walls_that_overflow", walls)];

/// The statistics of an encode, and the arguments of its draws.
fn encoded(
    gpu: &Gpu,
    volumes: &mut DepthMapVolumes,
    (map, light): (&Map, ShadowCamera),
    eye: &ShadowCamera,
) -> Result<(DepthMapFrame, DepthMapStatistics, Vec<u32>), String> {
    let texture = depth_view(&texture(gpu, map.size, TextureFormat::R32Float, &map.depths)?);
    let (frame, buffer) = gpu.submit(|encoder| {
        let frame =
            volumes.encode(encoder, &DepthMap { texture: &texture, light, objects: None }, eye).map_err(text)?;
        let buffer = frame.statistics(encoder).map_err(text)?;
        Ok((frame, buffer))
    })?;
    let statistics: Vec<DepthMapStatistics> = gpu.read(&buffer, 1)?;
    let arguments = gpu.read(frame.draw_arguments(), usize::MAX)?;
    Ok((frame, statistics[0], arguments))
}

/// The vertices of a near cap, as they are drawn.
fn vertices(gpu: &Gpu, cap: &DepthMapNearCap) -> Result<u32, String> {
    Ok(match cap {
        DepthMapNearCap::Lit => 0,
        DepthMapNearCap::Told(draw) => gpu.read::<u32>(draw, 1)?[0],
        DepthMapNearCap::Drawn => 3,
    })
}

fn lists() -> Result<(), String> {
    const SEED: u64 = 1701;
    println!("seed {SEED}");
    let gpu = Gpu::shared()?;
    let pipelines = pipelines(&gpu, DepthDirection::Reversed, 7..8)?;
    let mut random = Random::new(SEED);
    let (mut overflowed, mut caps) = ([0; 2], [0; 3]);
    for map in maps(&mut random) {
        for capacity in [None, Some(random.below(30) as u32)] {
            let skip_near_caps = random.below(3) > 0;
            let edges = DepthMapMethod::EveryCell;
            let options = DepthMapOptions { method: edges, capacity, skip_near_caps, ..Default::default() };
            let mut volumes = DepthMapVolumes::new(&pipelines, map.size, options).map_err(text)?;
            let light = camera(direction(&map));
            // An eye beside the light, and one where it looks at.
            let mut eye = camera(DepthDirection::Reversed);
            eye.origin[1] += [8.0, -1.0][random.below(2)];
            let (frame, found, arguments) = encoded(&gpu, &mut volumes, (&map, light), &eye)?;
            let shape = map.shape(-1.0, capacity.unwrap_or(u32::MAX));
            let count = cells::listed(&map, &[], -1.0, false, None)[0];
            let near_cap_vertices = vertices(&gpu, frame.near_cap())?;
            let expected = DepthMapStatistics { found: count, capacity: shape.capacity, near_cap_vertices, unused: 0 };
            same("statistics", &[found], &[expected])?;
            same("capacity", &[volumes.capacity()], &[shape.capacity])?;
            let is_overflowed = count > shape.capacity;
            same("overflow", &[found.is_overflowed()], &[is_overflowed])?;
            let cells = if is_overflowed { shape.cells } else { count };
            same("arguments", &arguments, &[6 * cells, 1, 0, 0])?;
            overflowed[usize::from(is_overflowed)] += 1;
            caps[(near_cap_vertices / 3) as usize + usize::from(*frame.near_cap() == DepthMapNearCap::Drawn)] += 1;
            // Negative control: one more cell.
            let other = DepthMapStatistics { found: count + 1, ..expected };
            if same("statistics", &[found], &[other]).is_ok() {
                return Err("another count is the same".to_owned());
            }
        }
    }
    println!("{overflowed:?} lists with room and without, near caps left out, told and drawn: {caps:?}");
    if overflowed.iter().chain(&caps).any(|&count| count < 5) { Err("too few of a kind".to_owned()) } else { Ok(()) }
}

/// Lone texels: each cell has an end of a contour.
fn walls() -> Result<(), String> {
    let gpu = Gpu::shared()?;
    let pipelines = pipelines(&gpu, DepthDirection::Reversed, 7..8)?;
    let map = Map::new([24, 24], true, |texel| if (texel % 24 + texel / 24) % 2 == 0 { 0.5 } else { 0.0 });
    let light = camera(DepthDirection::Reversed);
    let method = DepthMapMethod::Contours { threshold: 1.0, sideways: 0.25, depth: 0.01 };
    let of = |capacity| {
        let options = DepthMapOptions { method, capacity, ..Default::default() };
        let mut volumes = DepthMapVolumes::new(&pipelines, map.size, options).map_err(text)?;
        let (_, found, arguments) = encoded(&gpu, &mut volumes, (&map, light), &light)?;
        same("capacity", &[found.capacity], &[volumes.capacity()])?;
        Ok::<_, String>((found, arguments))
    };
    let (all, arguments) = of(Some(1 << 16))?;
    same("walls", &arguments, &[6 * all.found, 1, 0, 0, 0, 1, 0, 0])?;
    let (exact, arguments) = of(Some(all.found))?;
    same("just enough", &arguments, &[6 * all.found, 1, 0, 0, 0, 1, 0, 0])?;
    let (few, arguments) = of(Some(all.found - 1))?;
    same("too few", &arguments, &[0, 1, 0, 0, 6 * 25 * 25, 1, 0, 0])?;
    let told = [all, exact, few].map(|found| (found.found, found.is_overflowed()));
    same("told", &told, &[(all.found, false), (all.found, false), (all.found, true)])?;
    if all.found > 1000 { Ok(()) } else { Err(format!("{} walls", all.found)) }
}
