//! Table 2 of the paper on shadow volumes from depth maps (2000): how many triangles volumes have, and how many times
//! more where the map's side is doubled.

use glam::{DQuat, DVec3, Vec3};
use rimline::gpu::depth_map::DepthMapMethod;
use rimline_bench::Error;
use rimline_bench::random::Random;
use rimline_bench::shapes::{self, Shape};

use crate::stage::{AUTOMATIC, Bench, CONTOURS, MAP, camera, map_of};

const SEED: u64 = 16;
const SIDES: [u32; 2] = [256, 512];
const DISTANCE: f64 = 8.0;
/// The radius of a ball around everything.
const RADIUS: f64 = 2.3;
/// Rings and segments of tori, with as many triangles as the paper's scenes A, C and D, and its ratio.
const SCENES: [(&str, [u32; 2], usize, &str); 3] =
    [("A", [36, 26], 1, "—"), ("C", [121, 93], 10, "1.80"), ("D", [61, 30], 1, "1.67")];
const WAYS: [(&str, DepthMapMethod); 4] = [
    ("every cell", DepthMapMethod::EveryCell),
    ("differences 0.02", DepthMapMethod::Differences { threshold: 0.02, dangling: None }),
    ("automatic", AUTOMATIC),
    ("contours 0.005", CONTOURS),
];

/// Tori above a thin ground, and the same below it.
fn scene([rings, segments]: [u32; 2], count: usize) -> Shape {
    let (mut scene, mut random) = (Shape::default(), Random::new(SEED));
    let mut push = |shape: &Shape, transform: &dyn Fn(Vec3) -> Vec3| {
        let first = scene.positions.len() as u32;
        scene.positions.extend(shape.positions.iter().map(|&position| transform(Vec3::from(position)).to_array()));
        scene.faces.extend(shape.faces.iter().map(|face| face.map(|vertex| first + vertex)));
    };
    let torus =
        if count == 1 { shapes::torus(rings, segments, 0.8, 0.35) } else { shapes::torus(rings, segments, 0.5, 0.06) };
    for number in 0..2 * count {
        let turn = glam::Quat::from_rotation_arc(random.direction().into(), random.direction().into());
        let at = Vec3::new(random.between(-0.5, 0.5), 0.9, random.between(-0.5, 0.5));
        let side = if number % 2 == 0 { 1.0 } else { -1.0 };
        push(&torus, &|p| (at + turn * p) * Vec3::new(1.0, side, 1.0));
    }
    push(&shapes::cube(), &|p| p * Vec3::new(1.6, 0.01, 1.6));
    scene
}

/// Axes of a camera, turned at random.
fn turned(random: &mut Random) -> [DVec3; 3] {
    // A direction in four dimensions is a rotation.
    let turn = loop {
        let turn = DQuat::from_array([0; 4].map(|_| f64::from(random.between(-1.0, 1.0))));
        if (0.1..=1.0).contains(&turn.length()) {
            break turn.normalize();
        }
    };
    [DVec3::X, DVec3::Y, DVec3::NEG_Z].map(|axis| turn * axis)
}

/// The triangles of a list of cells: its number, and entries whose two highest bits tell which triangles are drawn. A
/// list of walls has two for each.
fn triangles(way: DepthMapMethod, list: &[u32]) -> u64 {
    let Some((&count, entries)) = list.split_first() else { return 0 };
    if let DepthMapMethod::Contours { .. } = way {
        return 2 * u64::from(count);
    }
    entries.iter().take(count as usize).map(|entry| u64::from((entry >> 30).count_ones())).sum()
}

pub(crate) fn measure(bench: &Bench, rotations: usize) -> Result<(), Error> {
    println!(
        "\nMean triangles of volumes, {rotations} rotations, maps of {SIDES:?} texels a side, 24 bits; seed {SEED}"
    );
    println!("| scene | triangles | detector | {}² | {}² | ratio | paper's ratio |", SIDES[0], SIDES[1]);
    println!("|---|---:|---|---:|---:|---:|---:|");
    // Lists of cells do not depend on it.
    let eye = camera([DVec3::X, DVec3::Y, DVec3::NEG_Z], DISTANCE, RADIUS, false);
    for (name, rings, count, ratio) in SCENES {
        let shape = scene(rings, count);
        let drawn = bench.drawn(&shape)?;
        let mut sums = [[0_u64; 2]; WAYS.len()];
        for (size, side) in SIDES.into_iter().enumerate() {
            let (mut random, map) = (Random::new(SEED), bench.target(side, MAP));
            let mut volumes = WAYS.iter().map(|(_, way)| bench.volumes(side, *way)).collect::<Result<Vec<_>, _>>()?;
            for _ in 0..rotations {
                let light = camera(turned(&mut random), DISTANCE, RADIUS, true);
                bench.clock(|encoder| {
                    Bench::draw_map(encoder, &drawn, &map, &light)?;
                    volumes
                        .iter_mut()
                        .try_for_each(|volumes| Ok(volumes.encode(encoder, &map_of(&map, light), &eye).map(drop)?))
                })?;
                for ((sums, volumes), (_, way)) in sums.iter_mut().zip(&volumes).zip(WAYS) {
                    sums[size] += triangles(way, &bench.gpu.read::<u32>(volumes.cells())?);
                }
            }
        }
        for ((detector, _), sums) in WAYS.iter().zip(sums) {
            let [small, large] = sums.map(|sum| sum as f64 / rotations as f64);
            let faces = shape.faces.len();
            println!("| {name} | {faces} | {detector} | {small:.0} | {large:.0} | {:.2} | {ratio} |", large / small);
        }
    }
    Ok(())
}
