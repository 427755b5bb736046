//! Table 2 of the paper: how many triangles volumes have, and how many times more where the map's side is doubled.

use glam::{DQuat, DVec3};
use rimline::gpu::DepthMapMethod;
use rimline_testkit::random::Random;

use crate::scenes::{PAPER, RADIUS, scene};
use crate::stage::{Bench, DETECTORS, MAP, camera, map_of};

const SIDES: [u32; 2] = [256, 512];
const DISTANCE: f64 = 8.0;

/// Axes of a camera, turned at random.
pub(crate) fn turned(random: &mut Random) -> [DVec3; 3] {
    // A direction in four dimensions is a rotation.
    let turn = loop {
        let four = [0; 4].map(|_| f64::from(random.between(-1.0, 1.0)));
        let turn = DQuat::from_array(four);
        if (0.1..=1.0).contains(&turn.length()) {
            break turn.normalize();
        }
    };
    [DVec3::X, DVec3::Y, DVec3::NEG_Z].map(|axis| turn * axis)
}

/// The triangles of a list of cells: its number, and entries whose two highest bits tell which triangles are drawn. A list of
/// walls has two for each.
fn triangles(way: DepthMapMethod, list: &[u32]) -> u64 {
    let Some((&count, entries)) = list.split_first() else { return 0 };
    if let DepthMapMethod::Contours { .. } = way {
        return 2 * u64::from(count);
    }
    entries.iter().take(count as usize).map(|entry| u64::from((entry >> 30).count_ones())).sum()
}

pub(crate) fn measure(bench: &Bench, rotations: usize, seed: u64) -> Result<(), String> {
    println!(
        "\nMean triangles of volumes, {rotations} rotations, maps of {SIDES:?} texels a side, 24 bits; seed {seed}"
    );
    println!("| scene | triangles | detector | {}² | {}² | ratio | paper's ratio |", SIDES[0], SIDES[1]);
    println!("|---|---:|---|---:|---:|---:|---:|");
    for (number, (name, faces, ratio)) in PAPER.into_iter().enumerate() {
        let shape = scene(number, seed);
        assert_eq!(shape.faces.len(), faces, "scene {name} has as many triangles as the paper's");
        let drawn = bench.drawn(&shape)?;
        let mut sums = [[0_u64; 2]; DETECTORS.len()];
        for (size, side) in SIDES.into_iter().enumerate() {
            let mut random = Random::new(seed);
            let map = bench.target(side, MAP);
            let mut volumes = Vec::new();
            for (_, way) in DETECTORS {
                volumes.push(bench.volumes(side, way)?);
            }
            for _ in 0..rotations {
                let light = camera(turned(&mut random), DISTANCE, f64::from(RADIUS), true);
                bench.gpu.submit(|encoder| {
                    Bench::draw_map(encoder, &drawn, &map, &light)?;
                    for volumes in &mut volumes {
                        volumes
                            .encode(encoder, &map_of(&map, light), &eye(), None)
                            .map_err(|error| error.to_string())?;
                    }
                    Ok(())
                })?;
                for ((sums, volumes), (_, way)) in sums.iter_mut().zip(&volumes).zip(DETECTORS) {
                    sums[size] += triangles(way, &bench.gpu.read(volumes.cells(), usize::MAX)?);
                }
            }
        }
        for ((detector, _), sums) in DETECTORS.iter().zip(sums) {
            let [small, large] = sums.map(|sum| sum as f64 / rotations as f64);
            println!("| {name} | {faces} | {detector} | {small:.0} | {large:.0} | {:.2} | {ratio} |", large / small);
        }
    }
    Ok(())
}

/// An eye, which lists of cells do not depend on.
pub(crate) fn eye() -> rimline::ShadowCamera {
    camera([DVec3::X, DVec3::Y, DVec3::NEG_Z], DISTANCE, f64::from(RADIUS), false)
}
