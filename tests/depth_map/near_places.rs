//! Places on near rectangles: whether they are behind the boundary, against `f64`.

use glam::{DVec2, DVec3};
use rimline::reference::depth_map::{Placing, map_view};
use rimline::reference::layout::DepthMapShape;
use rimline::reference::stages::DEPTH_SURFACE;
use rimline_testkit::device::Gpu;
use rimline_testkit::harness::Test;
use rimline_testkit::is_long;
use rimline_testkit::on_gpu::text;
use rimline_testkit::random::Random;
use wgpu::TextureFormat;

use crate::boundary::sample;
use crate::exact::{Exact, Moves, ROUNDING, steps};
use crate::maps::Map;
use crate::parity::{light, map};
use crate::probe::Probe;
use crate::vertices::{Given, eye};

pub(crate) const TESTS: &[Test] =
    &[("near_places_are_behind_where_f64_says_so", places), ("the_near_cap_covers_the_picture", covers)];

/// How far a place of the near rectangle is behind the boundary, in device depth, and what floats may be off by; `Err` if floats
/// may tell neither, and `None` if nothing is there.
fn behind(exact: &Exact, map: &Map, moves: &Moves, place: DVec2) -> Result<Option<(f64, f64)>, ()> {
    let Some((at, off)) = exact.near(place)? else { return Ok(None) };
    let [width, height] = map.size.map(f64::from);
    let low = at - off;
    let high = at + off;
    if high.x < -1.0 || high.y < -1.0 || low.x > width || low.y > height {
        return Ok(None);
    }
    if low.x < -1.0 || low.y < -1.0 || high.x > width || high.y > height || off.x.max(off.y) > 0.25 {
        return Err(());
    }
    // Depths of the boundary at a place, and how they change over a texel in its triangle.
    let depth = |[x, y]: [i64; 2]| match moves.depth(map, [x, y]) {
        Some(depth) => Some(depth),
        None => exact.infinity(DVec2::new(x as f64, y as f64)).map(|(depth, terms)| (depth, 5.0 * ROUNDING * terms)),
    };
    let rank = |[x, y]: [i64; 2]| {
        let Some(depth) = sample(map, x, y) else { return 0x7fff_ffff };
        let unit = if depth < f64::from(f32::MIN_POSITIVE) { 0 } else { i64::from((depth as f32).to_bits()) };
        if map.is_reversed { 0x3f80_0000 - unit } else { unit }
    };
    let surface = |x: f64, y: f64| -> Option<[f64; 3]> {
        let cell = [x.floor(), y.floor()];
        let (across, down) = (x - cell[0], y - cell[1]);
        let [x, y] = cell.map(|at| at as i64);
        let corners = [[x, y], [x + 1, y], [x, y + 1], [x + 1, y + 1]];
        let is_cut = (rank(corners[0]) - rank(corners[3])).abs() > (rank(corners[1]) - rank(corners[2])).abs();
        // The corner where the triangle's legs meet, and how far the place is from it along both.
        let (corner, beside, below, [along, under]) = match (is_cut, across + down > 1.0, across < down) {
            (true, false, _) => (0, 1, 2, [across, down]),
            (true, true, _) => (3, 2, 1, [1.0 - across, 1.0 - down]),
            (false, _, false) => (1, 0, 3, [1.0 - across, down]),
            (false, _, true) => (2, 3, 0, [across, 1.0 - down]),
        };
        let [corner, beside, below] = [corner, beside, below].map(|number: usize| depth(corners[number]));
        // A corner without a share does not matter to a parallel light.
        let (corner, beside, below) = (corner?, beside?, below?);
        let value = corner.0 + along * (beside.0 - corner.0) + under * (below.0 - corner.0);
        let slope = (beside.0 - corner.0).abs().max((below.0 - corner.0).abs());
        let size = corner.0.abs().max(beside.0.abs()).max(below.0.abs());
        let own = corner.1.max(beside.1).max(below.1);
        // Shares, products and sums.
        Some([value, slope, own + 9.0 * ROUNDING * size])
    };
    // The boundary has no gaps, so within what the place may be off by it changes by no more than its triangles there do.
    let around = [(at.x, at.y), (low.x, low.y), (high.x, low.y), (low.x, high.y), (high.x, high.y)];
    let around = around.map(|(x, y)| surface(x, y));
    let [Some(own), ..] = around else {
        // A parallel light has no boundary there, and none may be near.
        return if around.iter().all(Option::is_none) { Ok(None) } else { Err(()) };
    };
    let Some(slope) = around.into_iter().try_fold(0.0, |most: f64, there| Some(most.max(there?[1]))) else {
        return Err(());
    };
    let ahead = if map.is_reversed { own[0] - at.z } else { at.z - own[0] };
    Ok(Some((ahead, slope * (off.x + off.y) + off.z + own[2] + 1e-36)))
}

/// A place between two that is barely more than its bound away from the boundary, if it passes between them.
fn at_border(behind: &dyn Fn(DVec2) -> Option<(f64, f64)>, from: DVec2, to: DVec2) -> Option<[f32; 4]> {
    let is_behind = behind(from)?.0 > 0.0;
    if (behind(to)?.0 > 0.0) == is_behind {
        return None;
    }
    let (mut low, mut high) = (0.0, 1.0);
    for _ in 0..30 {
        let middle = f64::midpoint(low, high);
        let place = from.lerp(to, middle).as_vec2();
        let (ahead, off) = behind(place.as_dvec2())?;
        if ahead.abs() > off && ahead.abs() < 4.0 * off {
            return Some([place.x, place.y, 0.0, 0.0]);
        }
        *(if (ahead > 0.0) == is_behind { &mut low } else { &mut high }) = middle;
    }
    None
}

#[derive(Debug, Default)]
struct Tally {
    behind: usize,
    before: usize,
    nothing: usize,
    unsure: usize,
    /// Places that are between one and four bounds away from the boundary.
    near: usize,
}

fn places() -> Result<(), String> {
    const SEED: u64 = 16_104;
    println!("seed {SEED}");
    let gpu = Gpu::shared()?;
    let mut random = Random::new(SEED);
    let (mut tally, mut probe, mut wrong) = (Tally::default(), None, 0);
    for round in 0..if is_long() { 3000 } else { 240 } {
        let (camera, _) = light(&mut random);
        let map = map(&mut random, &camera);
        let (eye, format) = eye(&mut random);
        let spread = random.below(3) == 0;
        let jitter = if spread { [0; 2].map(|_: u32| f64::from(random.between(-0.4, 0.4))) } else { [0.0; 2] };
        let slope_bias = [0.0, 0.5, 4.5][random.below(3)];
        let placing = Placing { border: 1.0, jitter, slope_bias };
        let view = map_view((&camera, map.size, TextureFormat::R32Float), (&eye, format), &placing).map_err(text)?;
        let shape = DepthMapShape { spread: u32::from(spread), ..map.shape(0.0, u32::MAX) };
        let exact = Exact::new((&camera, map.size), (&eye, format), jitter);
        let moves = Moves { slope_bias, steps: steps(TextureFormat::R32Float, camera.depth), spread };
        let given = Given::new(&gpu, (&shape, map.size, &map.depths), &[0], &[view])?;
        let bound = given.bound();
        let expression = "vec4<u32>(u32(is_behind(input.xy)))";
        let make = || Probe::new(&gpu, &DEPTH_SURFACE.wgsl(), ("vec4<u32>", expression), &bound);
        let mut places: Vec<_> =
            (0..256).map(|_| [random.between(-1.0, 1.0), random.between(-1.0, 1.0), 0.0, 0.0]).collect();
        let borders = places.windows(2).step_by(4).filter_map(|ends| {
            let [from, to] = [ends[0], ends[1]].map(|[x, y, ..]| DVec2::new(f64::from(x), f64::from(y)));
            at_border(&|place| behind(&exact, &map, &moves, place).ok().flatten(), from, to)
        });
        let borders: Vec<_> = borders.collect();
        tally.near += borders.len();
        places.extend(borders);
        let found = probe.get_or_insert_with(make).run(&gpu, &bound, &places)?;
        for (place, found) in places.iter().zip(found) {
            let told = found[0] == 1;
            let at = DVec2::new(f64::from(place[0]), f64::from(place[1]));
            let expected = match behind(&exact, &map, &moves, at) {
                Err(()) => {
                    tally.unsure += 1;
                    continue;
                }
                Ok(None) => {
                    tally.nothing += 1;
                    false
                }
                Ok(Some((ahead, off))) => {
                    if ahead.abs() <= off {
                        tally.unsure += 1;
                        continue;
                    }
                    *(if ahead > 0.0 { &mut tally.behind } else { &mut tally.before }) += 1;
                    ahead > 0.0
                }
            };
            if told != expected {
                return Err(format!("round {round}, {place:?}: {told}, expected {expected}, {:?}", map.size));
            }
            // Negative control: the next place but one.
            let other = DVec2::new(at.x, -at.y);
            let other = behind(&exact, &map, &moves, other).ok().flatten();
            wrong += usize::from(other.is_some_and(|(ahead, _)| (ahead > 0.0) != told));
        }
    }
    println!("{tally:?}; places that are turned upside down: {wrong} wrong");
    let told = tally.behind + tally.before + tally.nothing;
    if tally.behind.min(tally.before) > 2000 && tally.unsure * 50 < told && wrong > 1000 {
        Ok(())
    } else {
        Err(format!("{tally:?}, {wrong}"))
    }
}

/// The triangle of the cap has every place of the near rectangle within, and its places are those of clip space.
fn covers() -> Result<(), String> {
    let gpu = Gpu::shared()?;
    let map = Map::new([2, 2], true, |_| 0.5);
    let eye = crate::stages::camera(rimline::DepthDirection::Reversed);
    let placing = Placing { border: 1.0, jitter: [0.0; 2], slope_bias: 0.0 };
    let format = TextureFormat::Depth24PlusStencil8;
    let view = map_view((&eye, map.size, TextureFormat::R32Float), (&eye, format), &placing).map_err(text)?;
    let given = Given::new(&gpu, (&map.shape(0.0, 9), map.size, &map.depths), &[0], &[view])?;
    let bound = given.bound();
    let of = |expression| {
        let probe = Probe::new(&gpu, &DEPTH_SURFACE.wgsl(), ("vec4<f32>", expression), &bound);
        let found = probe.run(&gpu, &bound, &[0.0, 1.0, 2.0].map(|index| [index, 0.0, 0.0, 0.0]));
        found.map(|found| found.into_iter().map(|vertex| vertex.map(f32::from_bits)).collect::<Vec<_>>())
    };
    let positions = of("depth_near_cap(u32(input.x)).position")?;
    let places = of("vec4<f32>(depth_near_cap(u32(input.x)).place, 0.0, 0.0)")?;
    for (&[x, y, z, w], place) in positions.iter().zip(&places) {
        rimline_testkit::same("vertex", &[x, y, w], &[place[0], place[1], 1.0])?;
        if !(0.0..=1.0).contains(&z) {
            return Err(format!("clipped: {z}"));
        }
    }
    let corner = |number: usize| DVec3::new(f64::from(places[number][0]), f64::from(places[number][1]), 0.0);
    for at in [[-1.0, -1.0], [1.0, -1.0], [-1.0, 1.0], [1.0, 1.0]] {
        let at = DVec3::new(at[0], at[1], 0.0);
        let is_in = (0..3).all(|number| {
            let (from, to) = (corner(number), corner((number + 1) % 3));
            (to - from).cross(at - from).z >= 0.0
        });
        if !is_in {
            return Err(format!("{at} is not covered by {places:?}"));
        }
    }
    Ok(())
}
