//! Shadows of distance fields and meshes against rays to the light: a wrong pixel is at most a texel of the map away from
//! the border of a shadow.

use rimline::DepthDirection;
use rimline::gpu::{DepthMapMethod, DepthMapOptions, DepthMetric};
use rimline_measure::device::Gpu;
use rimline_measure::harness::Test;
use rimline_measure::random::Random;
use wgpu::TextureFormat;

use crate::maps::Map;
use crate::metric::converted;
use crate::picture::Picture;
use crate::textures::{objects, texture};
use crate::views::{MapOf, Near, SIDE, Seen, View, worlds};
use crate::worlds::World;

pub(crate) const TESTS: &[Test] = &[
    ("shadows_are_right_but_for_a_texel", every_cell),
    ("shadows_of_marked_cells_are_right_but_for_a_texel", marked),
    ("shadows_of_edges_of_objects_are_right_but_for_a_texel", of_objects),
    ("shadows_of_contours_are_right_but_for_a_texel", of_contours),
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
    /// The near and the far plane of the light, if they are others.
    planes: Option<(f64, Option<f64>)>,
    /// Metric of the distances in the map, if the options say that the map holds distances.
    written: DepthMetric,
    /// Whether there are objects.
    has_objects: bool,
    /// Bits of the stencil, less one.
    more_bits: u32,
}

fn trial(
    gpu: &Gpu,
    random: &mut Random,
    world: &World,
    format: TextureFormat,
    Way { options, off, planes, written, has_objects, more_bits }: Way,
    tally: &mut Tally,
) -> Result<(), String> {
    let Some(view) = View::lit(random, world, MapOf { planes, ..MapOf::default() }) else { return Ok(()) };
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
    for (pixel, seen) in view.receivers() {
        let is_lit = view.is_lit(seen);
        *(if is_lit { &mut tally.lit } else { &mut tally.dark }) += 1;
        let off = f64::from(stencil[pixel].count_ones()) / f64::from(1 + more_bits) - if is_lit { 0.0 } else { 1.0 };
        tally.squares += off * off;
        if off == 0.0 {
            continue;
        }
        let near = view.near(seen, within);
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

fn trials(seed: u64, rounds: usize, options: DepthMapOptions, has_objects: bool) -> Result<(), String> {
    println!("seed {seed}");
    let gpu = Gpu::shared()?;
    let mut random = Random::new(seed);
    let formats = [TextureFormat::Depth32Float, TextureFormat::Depth24Plus, TextureFormat::Depth16Unorm];
    let (mut all_wrong, mut pixels) = (0, 0);
    for format in formats {
        let mut tally = Tally::default();
        for round in 0..rounds {
            let worlds = worlds(&mut random);
            // Objects that cast no shadow onto themselves.
            let is_convex = |world: &World| matches!(world, World::Sphere { .. } | World::Cuboid { .. });
            let taken = worlds.iter().enumerate().filter(|(_, world)| !has_objects || is_convex(world));
            for (number, world) in taken {
                let before = tally.wrong;
                let way = Way { options, has_objects, ..Default::default() };
                trial(&gpu, &mut random, world, format, way, &mut tally)?;
                if tally.wrong > before {
                    println!("{format:?}, round {round}, world {number}: {} wrong", tally.wrong - before);
                }
            }
        }
        println!("{format:?}: {tally:?}");
        // The move by the slope is for folds.
        let folds = if options.slope_bias > 0.0 { 10_000 } else { 2_000 };
        if tally.dark < 1000
            || tally.lit < 1000
            || tally.at_borders * 20 > tally.dark + tally.lit
            || tally.at_folds * folds > tally.dark + tally.lit
        {
            return Err(format!("{format:?}: {tally:?}"));
        }
        all_wrong += tally.wrong;
        pixels += tally.dark + tally.lit;
    }
    // A detector may miss an edge. Walls miss more, at rims that are steeper than the texels tell.
    let allowed = match options.method {
        DepthMapMethod::EveryCell => 0,
        DepthMapMethod::Contours { .. } => pixels / 10_000,
        _ => pixels / 100_000,
    };
    if all_wrong > allowed { Err(format!("{all_wrong} of {pixels} are wrong away from borders")) } else { Ok(()) }
}

fn every_cell() -> Result<(), String> {
    trials(1631, 4, DepthMapOptions { method: DepthMapMethod::EveryCell, ..Default::default() }, false)
}

fn marked() -> Result<(), String> {
    let edges = DepthMapMethod::Differences { threshold: 0.0005, dangling: None };
    trials(1632, 4, DepthMapOptions { method: edges, ..Default::default() }, false)
}

/// Steep sides of the boxes are left out. Moved, they would leave the boxes behind, and rays would miss a crossing there, so they
/// are not moved.
fn of_objects() -> Result<(), String> {
    let method = DepthMapMethod::Differences { threshold: 1.0, dangling: None };
    trials(1634, 4, DepthMapOptions { method, slope_bias: 0.0, ..Default::default() }, true)
}

const CONTOURS: DepthMapMethod = DepthMapMethod::Contours { threshold: 0.0005, sideways: 0.25, depth: 0.002 };

fn of_contours() -> Result<(), String> {
    trials(1636, 4, DepthMapOptions { method: CONTOURS, ..Default::default() }, false)
}

/// The same views with one bit and with more. The error of a pixel is the difference between the share of its bits that are dark
/// and the truth.
fn of_bits() -> Result<(), String> {
    let mut errors = Vec::new();
    let marked = DepthMapMethod::Differences { threshold: 0.0005, dangling: None };
    let every = DepthMapMethod::EveryCell;
    for (bits, edges) in [(1, every), (4, every), (8, every), (4, marked)] {
        println!("seed 1635, {bits} bits, {edges:?}");
        let gpu = Gpu::shared()?;
        let mut random = Random::new(1635);
        let mut tally = Tally::default();
        for world in worlds(&mut random).into_iter().chain(worlds(&mut random)) {
            let options = DepthMapOptions { method: edges, ..Default::default() };
            let way = Way { options, more_bits: bits - 1, ..Default::default() };
            trial(&gpu, &mut random, &world, TextureFormat::Depth32Float, way, &mut tally)?;
        }
        println!("{tally:?}");
        if tally.wrong > 0 {
            return Err(format!("{bits} bits, {edges:?}: {tally:?}"));
        }
        errors.push(tally.squares);
    }
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
        let way = Way { off: 3, ..Default::default() };
        trial(&gpu, &mut random, &world, TextureFormat::Depth32Float, way, &mut tally)?;
    }
    if tally.wrong > 100 { Ok(()) } else { Err(format!("negative control: {tally:?}")) }
}

/// Maps of distances, of lights with far planes behind everything, amid it, and at infinity. Walls are compared with those of
/// device depths of the same views.
fn of_distances() -> Result<(), String> {
    const SEED: u64 = 1637;
    println!("seed {SEED}");
    let gpu = Gpu::shared()?;
    let trials = |options: DepthMapOptions, written| {
        let (mut random, mut tally) = (Random::new(SEED), Tally::default());
        for planes in [None, Some((0.5, None)), Some((4.0, Some(15.5)))] {
            for world in worlds(&mut random) {
                let way = Way { options, planes, written, ..Default::default() };
                trial(&gpu, &mut random, &world, TextureFormat::R32Float, way, &mut tally)?;
            }
        }
        println!("{:?} {:?}, written {written:?}: {tally:?}", options.metric, options.method);
        Ok::<_, String>(tally)
    };
    let [axis, ray] = [DepthMetric::AlongAxis, DepthMetric::AlongRay];
    let ways = [
        (DepthMapOptions { method: DepthMapMethod::EveryCell, ..Default::default() }, &[axis][..]),
        (DepthMapOptions { method: DepthMapMethod::Automatic { dangling: None }, ..Default::default() }, &[ray]),
        (DepthMapOptions { method: CONTOURS, ..Default::default() }, &[ray]),
    ];
    for (options, metrics) in ways {
        // Walls miss some rims, whatever the metric, and so much the more as the threshold is larger in the world.
        let is_exact = options.method != CONTOURS;
        let allowed = if is_exact { 0 } else { trials(options, DepthMetric::Device)?.wrong };
        for &metric in metrics {
            let tally = trials(DepthMapOptions { metric, ..options }, metric)?;
            let pixels = tally.dark + tally.lit;
            let is_wrong = tally.wrong > allowed || tally.at_borders * 20 > pixels || tally.at_folds * 10_000 > pixels;
            if is_wrong || tally.dark < 1000 || tally.lit < 1000 {
                return Err(format!("{metric:?} {options:?}: {tally:?}, and {allowed} wrong of device depths"));
            }
        }
    }
    // Negative control: distances along the axis are taken for the longer ones along rays, so surfaces stand before themselves.
    let options = DepthMapOptions { metric: DepthMetric::AlongRay, ..Default::default() };
    let tally = trials(options, DepthMetric::AlongAxis)?;
    if tally.wrong > 1000 { Ok(()) } else { Err(format!("negative control: {tally:?}")) }
}
