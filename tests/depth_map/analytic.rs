//! Shadows of distance fields and meshes against rays to the light: a wrong pixel is at most a texel of the map away from
//! the border of a shadow.

use std::cell::OnceCell;

use glam::DVec3;
use rimline::DepthDirection;
use rimline::gpu::depth_map::{DanglingEdges, DepthMapMethod, DepthMapOptions, DepthMetric};
use rimline_testkit::device::Gpu;
use rimline_testkit::harness::Test;
use rimline_testkit::is_long;
use rimline_testkit::random::Random;
use wgpu::TextureFormat;

use crate::maps::Map;
use crate::metric::converted;
use crate::picture::Picture;
use crate::textures::{objects, texture};
use crate::views::{MapOf, Near, SIDE, Seen, View, worlds};
use crate::worlds::World;

pub(crate) const TESTS: &[Test] = &[
    ("shadows_are_right_but_for_a_texel", of_methods),
    ("shadows_of_edges_of_objects_are_right_but_for_a_texel", of_objects),
    ("shadows_of_distances_are_right_but_for_a_texel", of_distances),
    ("a_map_that_is_off_by_three_texels_is_noticed", off),
    ("borders_of_more_bits_are_nearer_to_the_truth", of_bits),
];

#[derive(Debug, Default)]
struct Tally {
    dark: usize,
    lit: usize,
    at_borders: usize,
    at_folds: usize,
    wrong: usize,
    /// The sum of the squares of what the shares of dark bits are off by.
    squares: f64,
}

/// How a map is made and taken.
#[derive(Clone, Copy, Default)]
struct Way {
    options: DepthMapOptions,
    /// Texels by which the map is moved.
    off: usize,
    /// Metric of the distances in the map, if the options say that the map holds distances.
    written: DepthMetric,
    /// Whether there are objects.
    has_objects: bool,
    /// Bits of the stencil, less one.
    more_bits: u32,
}

/// A view, and its receivers with the truth of them.
struct Given<'a> {
    view: View<'a>,
    receivers: Vec<Receiver>,
}

struct Receiver {
    pixel: usize,
    seen: (DVec3, DVec3),
    is_lit: bool,
    /// Pixels that are near, for as many bits of the stencil.
    near: [OnceCell<Near>; 8],
}

impl<'a> Given<'a> {
    /// `None` if the near rectangle is in a body.
    fn new(random: &mut Random, world: &'a World, planes: Option<(f64, Option<f64>)>) -> Option<Self> {
        let view = View::lit(random, world, MapOf { planes, ..MapOf::default() })?;
        let receiver =
            |(pixel, seen)| Receiver { pixel, seen, is_lit: view.is_lit(seen), near: [const { OnceCell::new() }; 8] };
        let receivers = view.receivers().map(receiver).collect();
        Some(Self { view, receivers })
    }
}

fn trial(
    gpu: &Gpu,
    Given { view, receivers }: &Given<'_>,
    format: TextureFormat,
    Way { options, off, written, has_objects, more_bits }: Way,
    tally: &mut Tally,
) -> Result<(), String> {
    let [light_depths, eye_depths] = view.depths();
    let is_reversed = view.sun.camera.depth == DepthDirection::Reversed;
    let mut map = Map { size: [SIDE; 2], is_reversed, depths: light_depths };
    map.depths.rotate_right(off);
    let texture = if options.metric == DepthMetric::Device {
        texture(gpu, map.size, format, &map.depths)?
    } else {
        converted(gpu, &view.sun.camera, options.metric, (map.size, &view.distances(written)))?
    };
    // The ground is one object, and what stands on it is another.
    let on_ground = |seen: &Seen| u32::from(seen.is_some_and(|(place, _)| place.y < 1e-7));
    let mut numbers: Vec<_> = view.light_seen.iter().map(on_ground).collect();
    numbers.rotate_right(off);
    let objects = has_objects.then(|| objects(gpu, map.size, &numbers));
    let picture = Picture {
        map: &texture,
        objects: objects.as_ref(),
        light: view.sun.camera,
        eye: view.eye,
        depths: &eye_depths,
        side: SIDE,
        options,
        bits: 7 - more_bits..8,
    };
    let stencil = picture.stencil(gpu)?;
    // A texel, and as much as bits move the boundary.
    let within = 1.5 - 0.5 / f64::from(1 + more_bits);
    for Receiver { pixel, seen, is_lit, near } in receivers {
        *(if *is_lit { &mut tally.lit } else { &mut tally.dark }) += 1;
        let dark = f64::from(stencil[*pixel].count_ones()) / f64::from(1 + more_bits);
        let off = dark - if *is_lit { 0.0 } else { 1.0 };
        tally.squares += off * off;
        if off == 0.0 {
            continue;
        }
        let near = *near[more_bits as usize].get_or_init(|| view.near(*seen, within));
        tally.at_borders += usize::from(near == Near::Border);
        tally.at_folds += usize::from(near == Near::Fold);
        if near == Near::Nothing {
            tally.wrong += 1;
            if tally.wrong < 10 {
                let (point, normal) = seen;
                println!("pixel {pixel}: {point} {normal}, lit {is_lit}, {format:?} {}", view.sun.is_parallel);
            }
        }
    }
    Ok(())
}

/// Draws each view in each way, of worlds that are taken.
fn trials<const N: usize>(seed: u64, ways: [Way; N], is_taken: fn(&World) -> bool) -> Result<(), String> {
    println!("seed {seed}");
    let gpu = Gpu::shared()?;
    let mut random = Random::new(seed);
    let formats = [TextureFormat::Depth32Float, TextureFormat::Depth24Plus, TextureFormat::Depth16Unorm];
    let (mut all_wrong, mut pixels) = ([0; N], 0);
    for format in formats {
        let mut tallies = ways.map(|_| Tally::default());
        for _ in 0..if is_long() { 12 } else { 4 } {
            for world in worlds(&mut random).iter().filter(|world| is_taken(world)) {
                let Some(given) = Given::new(&mut random, world, None) else { continue };
                for (tally, way) in tallies.iter_mut().zip(ways) {
                    trial(&gpu, &given, format, way, tally)?;
                }
            }
        }
        for ((wrong, tally), way) in all_wrong.iter_mut().zip(&tallies).zip(ways) {
            println!("{format:?} {:?}: {tally:?}", way.options.method);
            // The move by the slope is for folds.
            let folds = if way.options.slope_bias > 0.0 { 10_000 } else { 2_000 };
            if tally.dark < 1000
                || tally.lit < 1000
                || tally.at_borders * 20 > tally.dark + tally.lit
                || tally.at_folds * folds > tally.dark + tally.lit
            {
                return Err(format!("{format:?} {:?}: {tally:?}", way.options.method));
            }
            *wrong += tally.wrong;
        }
        pixels += tallies[0].dark + tallies[0].lit;
    }
    for (wrong, way) in all_wrong.into_iter().zip(ways) {
        // A detector may miss an edge. Walls miss more, at rims that are steeper than the texels tell.
        let allowed = match way.options.method {
            DepthMapMethod::EveryCell => 0,
            DepthMapMethod::Contours { .. } => pixels / 10_000,
            DepthMapMethod::SecondDifferences { .. } => 1 + pixels / 100_000,
            _ => pixels / 100_000,
        };
        if wrong > allowed {
            return Err(format!("{:?}: {wrong} of {pixels} are wrong away from borders", way.options.method));
        }
    }
    Ok(())
}

/// Each view is drawn with every cell, with cells that detectors mark, and with contours.
fn of_methods() -> Result<(), String> {
    let edges = DepthMapMethod::Differences { threshold: 0.0005, dangling: None };
    let dangling = Some(DanglingEdges::default());
    let automatic = DepthMapMethod::Automatic { dangling };
    let second = DepthMapMethod::SecondDifferences { low: 0.0005, high: 0.05, dangling };
    let methods = [DepthMapMethod::EveryCell, edges, CONTOURS, automatic, second];
    let with = |method| Way { options: DepthMapOptions { method, ..Default::default() }, ..Default::default() };
    trials(1631, methods.map(with), |_| true)
}

/// Objects that cast no shadow onto themselves. Steep sides of the boxes are left out. Moved, they would leave the boxes behind, and
/// rays would miss a crossing there, so they are not moved.
fn of_objects() -> Result<(), String> {
    let method = DepthMapMethod::Differences { threshold: 1.0, dangling: None };
    let options = DepthMapOptions { method, slope_bias: 0.0, ..Default::default() };
    let way = Way { options, has_objects: true, ..Default::default() };
    trials(1634, [way], |world| matches!(world, World::Sphere { .. } | World::Cuboid { .. }))
}

const CONTOURS: DepthMapMethod = DepthMapMethod::Contours { threshold: 0.0005, sideways: 0.25, depth: 0.002 };

/// The same views with one bit and with more. The error of a pixel is the difference between the share of its bits that are dark
/// and the truth.
fn of_bits() -> Result<(), String> {
    const SEED: u64 = 1635;
    println!("seed {SEED}");
    let marked = DepthMapMethod::Differences { threshold: 0.0005, dangling: None };
    let every = DepthMapMethod::EveryCell;
    let gpu = Gpu::shared()?;
    let mut random = Random::new(SEED);
    let ways = [(1, every), (4, every), (8, every), (4, marked)];
    let mut tallies = ways.map(|_| Tally::default());
    for world in worlds(&mut random).into_iter().chain(worlds(&mut random)) {
        let Some(given) = Given::new(&mut random, &world, None) else { continue };
        for (tally, (bits, method)) in tallies.iter_mut().zip(ways) {
            let options = DepthMapOptions { method, ..Default::default() };
            let way = Way { options, more_bits: bits - 1, ..Default::default() };
            trial(&gpu, &given, TextureFormat::Depth32Float, way, tally)?;
        }
    }
    for ((bits, method), tally) in ways.iter().zip(&tallies) {
        println!("{bits} bits, {method:?}: {tally:?}");
        if tally.wrong > 0 {
            return Err(format!("{bits} bits, {method:?}: {tally:?}"));
        }
    }
    let errors = tallies.map(|tally| tally.squares);
    println!("mean squares are {:.2} and {:.2} of those of one bit", errors[1] / errors[0], errors[2] / errors[0]);
    // Bits that are all alike would have the error of one.
    if errors[1] < 0.8 * errors[0] && errors[2] < errors[1] { Ok(()) } else { Err(format!("{errors:?}")) }
}

/// Negative control: the map's columns are moved.
fn off() -> Result<(), String> {
    let gpu = Gpu::shared()?;
    let mut random = Random::new(1633);
    let mut tally = Tally::default();
    for world in worlds(&mut random) {
        let Some(given) = Given::new(&mut random, &world, None) else { continue };
        let way = Way { off: 3, ..Default::default() };
        trial(&gpu, &given, TextureFormat::Depth32Float, way, &mut tally)?;
    }
    if tally.wrong > 100 { Ok(()) } else { Err(format!("negative control: {tally:?}")) }
}

/// Maps of distances, of lights with far planes behind everything, amid it, and at infinity. Walls are compared with those of
/// device depths of the same views.
fn of_distances() -> Result<(), String> {
    const SEED: u64 = 1637;
    println!("seed {SEED}");
    let gpu = Gpu::shared()?;
    let mut random = Random::new(SEED);
    let [device, axis, ray] = [DepthMetric::Device, DepthMetric::AlongAxis, DepthMetric::AlongRay];
    let with = |method, metric, written| {
        let options = DepthMapOptions { method, metric, ..Default::default() };
        Way { options, written, ..Default::default() }
    };
    let automatic = DepthMapMethod::Automatic { dangling: None };
    let ways = [
        with(CONTOURS, device, device),
        with(DepthMapMethod::EveryCell, axis, axis),
        with(automatic, ray, ray),
        with(CONTOURS, ray, ray),
        // Negative control: distances along the axis are taken for the longer ones along rays, so surfaces stand before themselves.
        with(automatic, ray, axis),
    ];
    let mut tallies = ways.map(|_| Tally::default());
    for planes in [None, Some((0.5, None)), Some((4.0, Some(15.5)))] {
        for world in worlds(&mut random) {
            let Some(given) = Given::new(&mut random, &world, planes) else { continue };
            for (tally, way) in tallies.iter_mut().zip(ways) {
                trial(&gpu, &given, TextureFormat::R32Float, way, tally)?;
            }
        }
    }
    for (tally, Way { options, written, .. }) in tallies.iter().zip(&ways) {
        println!("{:?} {:?}, written {written:?}: {tally:?}", options.metric, options.method);
    }
    let [of_device, right @ .., exchanged] = &tallies;
    for (tally, way) in right.iter().zip(&ways[1..]) {
        // Walls miss some rims, whatever the metric, and so much the more as the threshold is larger in the world.
        let allowed = if way.options.method == CONTOURS { of_device.wrong } else { 0 };
        let pixels = tally.dark + tally.lit;
        let is_wrong = tally.wrong > allowed || tally.at_borders * 20 > pixels || tally.at_folds * 10_000 > pixels;
        if is_wrong || tally.dark < 1000 || tally.lit < 1000 {
            return Err(format!("{:?}: {tally:?}, and {allowed} wrong of device depths", way.options));
        }
    }
    if exchanged.wrong > 1000 { Ok(()) } else { Err(format!("negative control: {exchanged:?}")) }
}
