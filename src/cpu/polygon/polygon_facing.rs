//! Polygon facing: for each polygon and light whether it faces the light, and whether it is twisted.

use super::orientation::Orientation;
use super::polygon_masks::{PolygonMasks, polygon_masks};
use super::polygon_pairs::Boundary;
use super::turns_batch::{Decided, turns_batch};
use crate::Light;
use crate::cpu::common::parallel::Threads;
use crate::cpu::extract::facing::{FacingStatistics, largest_magnitude};
use crate::layout::{LightBatch, low_bits};
use crate::light;
use crate::mesh::Polygons;

/// Masks of polygons for `lights`: ⌈N/32⌉ planes with one [`PolygonMasks`] for each polygon. A vertex that `positions`
/// lacks counts as non-finite. `undecided_pairs` counts what turns left to pairs of edges, and `exact_zeros`
/// polygons in a plane with a light.
pub fn polygon_facing(
    positions: &[[f32; 3]],
    polygons: &Polygons,
    lights: &[Light],
    threads: Threads,
) -> (Vec<PolygonMasks>, FacingStatistics) {
    let mut masks = vec![PolygonMasks::default(); polygons.len() * light::batches(lights.len())];
    let mut total = FacingStatistics::default();
    let largest = largest_magnitude(positions, threads);
    for (lights, plane) in lights.chunks(32).zip(masks.chunks_mut(polygons.len().max(1))) {
        let light_batch = LightBatch::new(lights, 0, 3);
        let statistics = threads.share(plane, |first, masks| {
            let mut statistics = FacingStatistics::default();
            // In ranges whose results fit the cache.
            for (number, masks) in masks.chunks_mut(RANGE).enumerate() {
                let range = first + RANGE * number..first + RANGE * number + masks.len();
                let decided = turns_batch(positions, polygons, range.clone(), largest, &light_batch);
                for ((polygon, masks), decided) in range.zip(masks).zip(decided) {
                    let Decided { facing, twisted, undecided } = decided;
                    *masks = PolygonMasks { facing, twisted, excluded: twisted };
                    if undecided != 0 {
                        decide(masks, positions, polygons.boundary(polygon), lights, undecided, &mut statistics);
                    }
                }
            }
            statistics
        });
        let statistics = statistics.into_iter().fold(FacingStatistics::default(), FacingStatistics::plus);
        // Every batch sees the same polygons.
        total = FacingStatistics { non_finite_faces: 0, ..total }.plus(statistics);
    }
    (masks, total)
}

/// The number of polygons at a time.
const RANGE: usize = 1024;

/// Decides lights that `f32` leaves undecided.
fn decide(
    masks: &mut PolygonMasks,
    positions: &[[f32; 3]],
    boundary: &[[u32; 2]],
    lights: &[Light],
    undecided: u32,
    statistics: &mut FacingStatistics,
) {
    if boundary.is_empty() {
        return;
    }
    let Some(boundary) = Boundary::new(boundary, positions) else {
        statistics.non_finite_faces += 1;
        masks.excluded = low_bits(lights.len());
        return;
    };
    let asked = lights.iter().enumerate().filter(|(bit, _)| undecided >> bit & 1 != 0);
    let found = polygon_masks(asked.map(|(bit, light)| {
        let (seen, is_general) = boundary.decide(light.to_array());
        statistics.undecided_pairs = statistics.undecided_pairs.wrapping_add(u32::from(is_general));
        statistics.exact_zeros = statistics.exact_zeros.wrapping_add(u32::from(seen == Orientation::InPlane));
        (bit, seen)
    }));
    *masks = PolygonMasks { facing: masks.facing | found.facing, ..found };
}
