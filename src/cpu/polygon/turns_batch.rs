//! Turns batch: the cheap way for many polygons and lights at a time, by `f32` with the filter's bound.

use std::ops::Range;

use super::polygon_turns::convex_turns;
use crate::cpu::extract::batch::{Batch, LANES};
use crate::layout::LightBatch;
use crate::mesh::{Polygons, is_loop};

/// Decision for a polygon in `f32`, for 32 lights.
#[derive(Clone, Copy)]
pub(crate) struct Decided {
    /// The lights that it faces.
    pub(crate) facing: u32,
    /// The lights for which it is twisted.
    pub(crate) twisted: u32,
    /// The lights for which it is not convex, and all lights if `f32` leaves a sign undecided.
    pub(crate) undecided: u32,
}

/// The turns of a polygon so far.
#[derive(Clone, Copy)]
struct Turns {
    are_all_positive: u32,
    /// The lights for which one turn or more are positive, two or more, three or more.
    positive: [u32; 3],
    are_certain: bool,
}

impl Turns {
    fn add(&mut self, positive: u32, is_certain: bool) {
        self.are_all_positive &= positive;
        let [once, twice, _] = self.positive;
        self.positive[0] |= positive;
        self.positive[1] |= once & positive;
        self.positive[2] |= twice & positive;
        self.are_certain &= is_certain;
    }
}

/// Decides a range of polygons. `largest` is the largest absolute coordinate there is.
pub(crate) fn turns_batch(
    positions: &[[f32; 3]],
    polygons: &Polygons,
    range: Range<usize>,
    largest: f32,
    light_batch: &LightBatch,
) -> impl Iterator<Item = Decided> {
    let mut turns = vec![Turns { are_all_positive: u32::MAX, positive: [0; 3], are_certain: false }; range.len()];
    let mut waiting = Waiting { corners: [[0; 3]; LANES], polygons: [0; LANES], count: 0 };
    let decide = |waiting: &mut Waiting, turns: &mut [Turns]| {
        let batch = Batch::new(positions, &waiting.corners[..waiting.count], light_batch);
        let certain = batch.certain(largest, light_batch);
        for (lane, &polygon) in waiting.polygons[..waiting.count].iter().enumerate() {
            turns[polygon].add(batch.masks[lane], certain[lane]);
        }
        waiting.count = 0;
    };
    for (index, polygon) in range.clone().enumerate() {
        let boundary = polygons.boundary(polygon);
        if !is_loop(boundary) {
            continue;
        }
        turns[index].are_certain = true;
        for corners in convex_turns(boundary.len()) {
            waiting.corners[waiting.count] = corners.map(|corner| boundary[corner][0]);
            waiting.polygons[waiting.count] = index;
            waiting.count += 1;
            if waiting.count == LANES {
                decide(&mut waiting, &mut turns);
            }
        }
    }
    decide(&mut waiting, &mut turns);
    let live = light_batch.active_bits;
    turns.into_iter().zip(range).map(move |(turns, polygon)| {
        let [once, twice, thrice] = turns.positive.map(|lights| lights & live);
        if !turns.are_certain {
            return Decided { facing: 0, twisted: 0, undecided: live };
        }
        if polygons.boundary(polygon).len() == 4 {
            return Decided { facing: thrice, twisted: twice & !thrice, undecided: 0 };
        }
        let facing = live & turns.are_all_positive;
        Decided { facing, twisted: 0, undecided: once & !facing }
    })
}

/// Turns that are decided together, and the polygons that they belong to.
struct Waiting {
    corners: [[u32; 3]; LANES],
    polygons: [usize; LANES],
    count: usize,
}
