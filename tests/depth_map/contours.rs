//! Probe.
use glam::Vec2;
use rimline::DepthDirection;
use rimline::reference::cpu::{ContourMap, Samples, contour_distance, contour_marks, contour_places, contour_walls};
use rimline::reference::layout::ContourShape;
use rimline_measure::harness::Test;
use rimline_measure::random::Random;

use crate::maps::Map;
use crate::views::{Near, SIDE, View, worlds};

pub(crate) const TESTS: &[Test] = &[("probe_contours", probe)];

fn probe() -> Result<(), String> {
    let get = |name: &str, default: f64| std::env::var(name).ok().and_then(|v| v.parse().ok()).unwrap_or(default);
    let threshold = (get("THRESHOLD", 0.0005) * (1 << 29) as f64) as u32;
    let tolerance = get("TOLERANCE", 0.0005) * (1 << 29) as f64;
    let shift = (tolerance.log2().floor() as i32 - 3).max(0) as u32;
    let dtol = get("DTOL", 0.0) as f32;
    let mut random = Random::new(1635);
    let mut tally = [[0_usize; 5]; 3];
    let (mut walls, mut marked, mut pixels) = (0, 0, 0);
    let (mut rounds, mut codes, mut short, mut flat, mut border) = (0, [0; 5], 0, 0, 0);
    for _ in 0..get("ROUNDS", 8.0) as usize {
        for world in worlds(&mut random) {
            let Some(view) = View::random(&mut random, &world) else { continue };
            let [light_depths, _] = view.depths();
            let is_reversed = view.sun.camera.depth == DepthDirection::Reversed;
            let map = Map { size: [SIDE; 2], is_reversed, depths: light_depths };
            let shape = map.shape(0.0, u32::MAX);
            let samples = Samples { shape: &shape, depths: &map.depths, objects: &[] };
            let tiles = (SIDE + 1).div_ceil(16);
            let contour = ContourShape {
                tiles: [tiles, tiles * tiles],
                words: (SIDE + 2).div_ceil(16),
                capacity: u32::MAX,
                threshold: threshold as i32,
                sure: 16 * threshold as i32,
                sideways: get("SIDEWAYS", 64.0) as i32,
                tolerance: (tolerance as i32) >> shift,
                shift,
                slope_bias: (get("BIAS", 1.0) * 128.0) as i32,
                share: 0,
                constant: 128,
            };
            let own = ContourMap { samples: &samples, shape: &contour };
            let marks = contour_marks(&own);
            let raw = contour_places(&own, &marks);
            let list = contour_walls(&own, &marks, &raw);
            walls += list.count;
            for y in 0..=(SIDE as i32) {
                for x in 0..=(SIDE as i32) {
                    let n = (0..4).filter(|&bit| own_is_marked(&own, [x, y], bit)).count();
                    codes[n] += 1;
                }
            }
            for (_, seen) in view.receivers() {
                pixels += 1;
                let is_lit = view.is_lit(seen);
                let place = view.sun.in_map(seen.0);
                let lattice = glam::DVec2::new(place.x, place.y) * f64::from(SIDE) + 0.5;
                let is_in = |at: f64| at >= 0.0 && at < f64::from(SIDE) + 1.0;
                if !is_in(lattice.x) || !is_in(lattice.y) {
                    continue;
                }
                let cell = lattice.floor();
                let part = (lattice - cell).as_vec2();
                let cell = [cell.x as i32, cell.y as i32];
                let depth = if is_reversed { 1.0 - place.z } else { place.z } as f32;
                let is_marked = (0..4).any(|bit| own_is_marked(&own, cell, bit));
                for (way, tally) in tally.iter_mut().enumerate() {
                    let dark = match way {
                        0 | 1 if is_marked => {
                            contour_distance(&own, &marks, if way == 0 { &list.places } else { &raw }, cell, part)
                                .pipe(|d: i32| d != i32::MAX && depth > d as f32 / (1 << 29) as f32 + dtol)
                        }
                        0 | 1 => {
                            // the plane of the cell
                            let d = |x, y| {
                                let v = own.moved([cell[0] + x, cell[1] + y]);
                                if v == i32::MAX { 9.0 } else { v as f32 / (1 << 29) as f32 }
                            };
                            let Vec2 { x, y } = part;
                            depth
                                > dtol
                                    + d(0, 0) * (1.0 - x) * (1.0 - y)
                                    + d(1, 0) * x * (1.0 - y)
                                    + d(0, 1) * (1.0 - x) * y
                                    + d(1, 1) * x * y
                        }
                        _ => {
                            let at = [(lattice.x + 0.5).floor() as i32, (lattice.y + 0.5).floor() as i32];
                            let v = own.distance(at);
                            v != i32::MAX && depth > v as f32 / (1 << 29) as f32 + 0.003
                        }
                    };
                    if dark != is_lit {
                        continue;
                    }
                    let near = view.near(seen, 1.0);
                    let at = match (near, is_lit) {
                        (Near::Border, true) => 0,
                        (Near::Border, false) => 1,
                        (Near::Fold, _) => 2,
                        (_, true) => 3,
                        (_, false) => 4,
                    };
                    tally[at] += 1;
                }
            }
        }
    }
    println!("{rounds} rounds, {pixels} pixels, {} walls, {marked} marks", walls);
    println!("rounds codes {codes:?} short {short} flat {flat} border ends {border}");
    println!("dark at borders, lit at borders, folds, acne, leaks");
    for (name, tally) in ["fitted", "raw", "lookup"].iter().zip(tally) {
        println!("{name}: {tally:?} {}", tally[0] + tally[1]);
    }
    Err("probe".into())
}

trait Pipe: Sized {
    fn pipe<R>(self, f: impl FnOnce(Self) -> R) -> R {
        f(self)
    }
}
impl Pipe for i32 {}
fn own_is_marked(map: &ContourMap<'_>, cell: [i32; 2], bit: usize) -> bool {
    let [x, y] = cell;
    let edge = match bit {
        0 => ([x, y], 0),
        1 => ([x + 1, y], 1),
        2 => ([x, y + 1], 0),
        _ => ([x, y], 1),
    };
    map.is_marked(rimline::reference::cpu::Edge { at: edge.0, axis: edge.1 })
}

pub(crate) fn debug(view: &View<'_>, map: &Map, seen: (glam::DVec3, glam::DVec3), pixel: usize) {
    let shape = map.shape(0.0, u32::MAX);
    let samples = Samples { shape: &shape, depths: &map.depths, objects: &[] };
    let tiles = (SIDE + 1).div_ceil(16);
    let threshold = (0.0005 * (1 << 29) as f64) as i32;
    let tolerance = 0.002 * (1 << 29) as f64;
    let shift = (tolerance.log2().floor() as i32 - 3).max(0) as u32;
    let contour = ContourShape {
        tiles: [tiles, tiles * tiles],
        words: (SIDE + 2).div_ceil(16),
        capacity: u32::MAX,
        threshold,
        sure: 16 * threshold,
        sideways: 64,
        tolerance: (tolerance as i32) >> shift,
        shift,
        slope_bias: 128,
        share: 0,
        constant: 128,
    };
    let own = ContourMap { samples: &samples, shape: &contour };
    let marks = contour_marks(&own);
    let raw = contour_places(&own, &marks);
    let list = contour_walls(&own, &marks, &raw);
    let at = glam::DVec2::new((pixel as u32 % SIDE) as f64 + 0.5, (pixel as u32 / SIDE) as f64 + 0.5);
    let eye = crate::scene::Rays::new(&view.eye, SIDE).at(at).0;
    let mut last = None;
    println!("DEBUG to {} lit {}", seen.0, view.is_lit(seen));
    let steps = 4000;
    let mut last_truth = None;
    for i in 0..steps {
        let t = f64::from(i) / f64::from(steps);
        let point = eye + (seen.0 - eye) * t;
        let place = view.sun.in_map(point);
        let lattice = glam::DVec2::new(place.x, place.y) * f64::from(SIDE) + 0.5;
        let is_in = |at: f64| at >= 0.0 && at < f64::from(SIDE) + 1.0;
        if !is_in(lattice.x) || !is_in(lattice.y) {
            continue;
        }
        let cell = lattice.floor();
        let part = (lattice - cell).as_vec2();
        let cell = [cell.x as i32, cell.y as i32];
        let depth = if map.is_reversed { 1.0 - place.z } else { place.z } as f32;
        let code: u32 = (0..4).map(|bit| u32::from(own_is_marked(&own, cell, bit)) << bit).sum();
        let dark = if code > 0 {
            let d = contour_distance(&own, &marks, &list.places, cell, part);
            d != i32::MAX && depth > d as f32 / (1 << 29) as f32
        } else {
            let d = |x, y| {
                let v = own.moved([cell[0] + x, cell[1] + y]);
                if v == i32::MAX { 9.0 } else { v as f32 / (1 << 29) as f32 }
            };
            let Vec2 { x, y } = part;
            depth
                > d(0, 0) * (1.0 - x) * (1.0 - y) + d(1, 0) * x * (1.0 - y) + d(0, 1) * (1.0 - x) * y + d(1, 1) * x * y
        };
        let truth = !view.sun.is_lit(view.world, point, glam::DVec3::ZERO);
        if last_truth != Some(truth) {
            println!("  {i}: truth {truth} (own {dark}) {cell:?} {part} code {code:04b} depth {depth}");
        }
        last_truth = Some(truth);
        if last.is_none_or(|(was, _, _)| was != dark) {
            let truth = view.sun.is_lit(view.world, point, glam::DVec3::ZERO);
            println!(
                "  {i}: {dark} truly {} cell {cell:?} part {part} code {code:04b} depth {depth} was in {:?}",
                !truth, last
            );
            for y in -2..4 {
                let row: Vec<_> = (-2..4)
                    .map(|x| {
                        let v = own.distance([cell[0] + x, cell[1] + y]);
                        let m = |axis| {
                            if own.is_marked(rimline::reference::cpu::Edge { at: [cell[0] + x, cell[1] + y], axis }) {
                                ["|", "_"][axis]
                            } else {
                                " "
                            }
                        };
                        format!(
                            "{:.4}{}{}",
                            if v == i32::MAX { 9.0 } else { f64::from(v) / (1 << 29) as f64 },
                            m(0),
                            m(1)
                        )
                    })
                    .collect();
                println!("      {}", row.join(" "));
            }
        }
        last = Some((dark, cell, code));
    }
}
