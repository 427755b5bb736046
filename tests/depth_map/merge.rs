//! Two maps in one by `depth_merge`: each texel against the nearer depth, as the documents tell it.

use rimline::DepthDirection;
use rimline::gpu::depth_map::{
    DepthMap, DepthMapError, DepthMapMerge, DepthMapMethod, DepthMapOptions, DepthMapVolumes,
};
use rimline_testkit::device::Gpu;
use rimline_testkit::harness::Test;
use rimline_testkit::on_gpu::text;
use rimline_testkit::random::Random;
use rimline_testkit::{must_fail, same};
use wgpu::TextureFormat;

use crate::cells::listed;
use crate::maps::{Map, maps};
use crate::picture::pipelines;
use crate::stages::{camera, direction};
use crate::textures::{depth_view, read, texture};

pub(crate) const TESTS: &[Test] = &[
    ("merged_maps_have_the_nearer_depth", nearer),
    ("merged_maps_are_taken_as_maps", taken),
    ("merges_that_cannot_be_made_or_recorded", refused),
];

const FORMATS: [[TextureFormat; 2]; 4] = [
    [TextureFormat::R32Float; 2],
    [TextureFormat::Depth32Float, TextureFormat::R32Float],
    [TextureFormat::Depth16Unorm, TextureFormat::Depth24PlusStencil8],
    [TextureFormat::R32Float, TextureFormat::Depth16Unorm],
];

/// The nearer of two depths: NaN is far, numbers are clamped, and what is smaller than every normal number is 0.
fn expected(is_reversed: bool, a: f32, b: f32) -> f32 {
    let far = if is_reversed { 0.0 } else { 1.0 };
    let [a, b] = [a, b].map(|depth| match f64::from(depth) {
        depth if depth.is_nan() => far,
        depth if depth < 2.0_f64.powi(-126) => 0.0,
        depth => depth.min(1.0),
    });
    (if is_reversed { a.max(b) } else { a.min(b) }) as f32
}

fn bits(depths: &[f32]) -> Vec<u32> {
    depths.iter().map(|depth| depth.to_bits()).collect()
}

/// Pairs of maps of one size and direction.
fn pairs(random: &mut Random) -> Vec<[Map; 2]> {
    let mut other = maps(random);
    // Hostile maps meet others of their size.
    for chunk in other.chunks_mut(5) {
        chunk.rotate_left(1);
    }
    maps(random).into_iter().zip(other).map(|(a, b)| [a, b]).collect()
}

/// A depth attachment takes finite depths from 0 to 1 alone.
fn given(map: &Map, format: TextureFormat) -> Vec<f32> {
    let clamp = |depth: &f32| if depth.is_nan() { 0.5 } else { depth.clamp(0.0, 1.0) };
    if format == TextureFormat::R32Float { map.depths.clone() } else { map.depths.iter().map(clamp).collect() }
}

fn nearer() -> Result<(), String> {
    const SEED: u64 = 1641;
    println!("seed {SEED}");
    let gpu = Gpu::shared()?;
    let mut random = Random::new(SEED);
    let (mut texels, mut taken) = (0, [0; 2]);
    for formats in FORMATS {
        for pair in pairs(&mut random) {
            let textures = [0, 1].map(|at| texture(&gpu, pair[at].size, formats[at], &given(&pair[at], formats[at])));
            let [first, second] = textures;
            let textures = [first?, second?];
            let depths = [read(&gpu, &textures[0])?, read(&gpu, &textures[1])?];
            let merge = DepthMapMerge::new(&gpu.pipelines, pair[0].size).map_err(text)?;
            let views = textures.each_ref().map(depth_view);
            let found = |depth| {
                gpu.submit(|encoder| merge.encode(encoder, views.each_ref(), depth).map_err(text))?;
                read(&gpu, merge.texture().texture())
            };
            let merged = found(direction(&pair[0]))?;
            let is_reversed = pair[0].is_reversed;
            let both = || depths[0].iter().zip(&depths[1]);
            let truth: Vec<_> = both().map(|(&a, &b)| expected(is_reversed, a, b)).collect();
            let what = format!("{formats:?} {:?}, reversed {is_reversed}", pair[0].size);
            same(&what, &bits(&merged), &bits(&truth))?;
            texels += truth.len();
            for (at, depths) in depths.iter().enumerate() {
                taken[at] += depths.iter().zip(&truth).filter(|(own, truth)| own == truth).count();
            }
            if both().any(|(a, b)| a != b && (0.1..0.9).contains(a) && (0.1..0.9).contains(b)) {
                // Negative control: the other direction takes the farther depth.
                let other = if is_reversed { DepthDirection::Standard } else { DepthDirection::Reversed };
                must_fail("the other direction", &same(&what, &bits(&found(other)?), &bits(&truth)))?;
            }
        }
    }
    println!("{texels} texels, {taken:?} taken from the first and the second");
    if taken.iter().any(|&taken| taken * 4 < texels) { Err(format!("{taken:?} of {texels}")) } else { Ok(()) }
}

/// Three maps, merged in two steps, have the cells of the nearest depths.
fn taken() -> Result<(), String> {
    let gpu = Gpu::shared()?;
    let size = [20, 13];
    let far = 1.0;
    let maps = [0, 1, 2]
        .map(|band| Map::new(size, false, |texel| if texel % 20 / 5 == band { 0.3 + 0.1 * band as f32 } else { far }));
    let pipelines = pipelines(&gpu, DepthDirection::Reversed, 7..8)?;
    let options = DepthMapOptions { method: DepthMapMethod::EveryCell, ..Default::default() };
    let mut volumes = DepthMapVolumes::new(&pipelines, size, options).map_err(text)?;
    let merges = [DepthMapMerge::new(&gpu.pipelines, size), DepthMapMerge::new(&gpu.pipelines, size)];
    let [first, second] = merges;
    let (first, second) = (first.map_err(text)?, second.map_err(text)?);
    let textures = [0, 1, 2].map(|at| texture(&gpu, size, TextureFormat::R32Float, &maps[at].depths));
    let views = textures.into_iter().map(|texture| texture.map(|texture| depth_view(&texture)));
    let views = views.collect::<Result<Vec<_>, _>>()?;
    gpu.submit(|encoder| {
        let depth = DepthDirection::Standard;
        first.encode(encoder, [&views[0], &views[1]], depth).map_err(text)?;
        second.encode(encoder, [&views[2], first.texture()], depth).map_err(text)?;
        let map = DepthMap { texture: second.texture(), light: camera(depth), objects: None };
        volumes.encode(encoder, &map, &camera(DepthDirection::Reversed)).map(drop).map_err(text)
    })?;
    let all = Map::new(size, false, |texel| [0.3, 0.3 + 0.1, 0.3 + 0.1 * 2.0, far][(texel % 20 / 5) as usize]);
    let expected = listed(&all, &[], -1.0, false, None);
    let found: Vec<u32> = gpu.read(volumes.cells(), expected.len())?;
    same("cells", &found, &expected)?;
    let one = listed(&maps[0], &[], -1.0, false, None);
    must_fail("one map alone", &same("cells", &[found[0]], &[one[0]]))
}

fn refused() -> Result<(), String> {
    let gpu = Gpu::shared()?;
    let most = gpu.device.limits().max_texture_dimension_2d;
    for size in [[0, 4], [4, 0]] {
        let found = DepthMapMerge::new(&gpu.pipelines, size).err();
        same("size", &[found], &[Some(DepthMapError::Size(size[0], size[1]))])?;
    }
    let size = [most + 1, 1];
    let found = DepthMapMerge::new(&gpu.pipelines, size).err();
    same("size", &[found], &[Some(DepthMapError::Texture { size, most })])?;
    let merge = DepthMapMerge::new(&gpu.pipelines, [4, 4]).map_err(text)?;
    let right = depth_view(&texture(&gpu, [4, 4], TextureFormat::Depth16Unorm, &[0.5; 16])?);
    let large = depth_view(&texture(&gpu, [4, 5], TextureFormat::R32Float, &[0.5; 20])?);
    let found = gpu.submit(|encoder| {
        let mut encode = |maps| merge.encode(encoder, maps, DepthDirection::Standard);
        Ok([encode([&right, &large]), encode([&large, &right]), encode([merge.texture(), &right]), encode([&right; 2])])
    })?;
    let size = |number: u32| {
        Err(DepthMapError::MapSize { map: format!("map {number} of the merge"), given: [4, 5], made: [4, 4] })
    };
    same("maps", &found, &[size(1), size(0), Err(DepthMapError::OwnResult), Ok(())])?;
    let pipelines = pipelines(&gpu, DepthDirection::Reversed, 7..8)?;
    let options = DepthMapOptions { rounded_to: Some(TextureFormat::Rgba8Unorm), ..Default::default() };
    let found = DepthMapVolumes::new(&pipelines, [4, 4], options).err();
    same("format", &[found], &[Some(DepthMapError::RoundedTo(TextureFormat::Rgba8Unorm))])
}
