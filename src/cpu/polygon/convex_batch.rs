//! Convex batch: the cheap way for many polygons and lights at a time, by `f32` with the filter's bound.

use std::ops::Range;

use super::convex::convex_turns;
use crate::cpu::extract::batch::{Batch, LANES};
use crate::layout::LightBatch;
use crate::mesh::Polygons;

/// What is certain of a polygon for 32 lights.
#[derive(Clone, Copy)]
pub(crate) struct Convex {
    /// The lights for which it is convex and faces them.
    pub(crate) facing: u32,
    /// The lights for which it is not convex, and all lights if `f32` leaves a sign undecided.
    pub(crate) undecided: u32,
}

/// The turns of a polygon so far.
#[derive(Clone, Copy)]
struct Turns {
    are_all_positive: u32,
    is_any_positive: u32,
    are_certain: bool,
}

impl Turns {
    fn add(&mut self, positive: u32, is_certain: bool) {
        self.are_all_positive &= positive;
        self.is_any_positive |= positive;
        self.are_certain &= is_certain;
    }
}

/// Decides a run of polygons. `largest` is the largest coordinate there is.
pub(crate) fn convex_batch(
    positions: &[[f32; 3]],
    polygons: &Polygons,
    run: Range<usize>,
    largest: f32,
    light_batch: &LightBatch,
) -> impl Iterator<Item = Convex> {
    let mut turns = vec![Turns { are_all_positive: u32::MAX, is_any_positive: 0, are_certain: false }; run.len()];
    let mut waiting = Waiting { corners: [[0; 3]; LANES], polygons: [0; LANES], count: 0 };
    let decide = |waiting: &mut Waiting, turns: &mut [Turns]| {
        let batch = Batch::new(positions, &waiting.corners[..waiting.count], light_batch);
        let certain = batch.certain(largest, light_batch);
        for (lane, &polygon) in waiting.polygons[..waiting.count].iter().enumerate() {
            turns[polygon].add(batch.masks[lane], certain[lane]);
        }
        waiting.count = 0;
    };
    for (place, polygon) in run.enumerate() {
        let outline = polygons.outline(polygon);
        if !is_loop(outline) {
            continue;
        }
        turns[place].are_certain = true;
        for corners in convex_turns(outline.len()) {
            waiting.corners[waiting.count] = corners.map(|corner| outline[corner][0]);
            waiting.polygons[waiting.count] = place;
            waiting.count += 1;
            if waiting.count == LANES {
                decide(&mut waiting, &mut turns);
            }
        }
    }
    decide(&mut waiting, &mut turns);
    let live = light_batch.live;
    turns.into_iter().map(move |turns| {
        if !turns.are_certain {
            return Convex { facing: 0, undecided: live };
        }
        let facing = live & turns.are_all_positive;
        Convex { facing, undecided: live & turns.is_any_positive & !turns.are_all_positive }
    })
}

/// Turns that are decided together, and the polygons that they belong to.
struct Waiting {
    corners: [[u32; 3]; LANES],
    polygons: [usize; LANES],
    count: usize,
}

/// Whether an outline is one loop, whose edges follow each other.
fn is_loop(outline: &[[u32; 2]]) -> bool {
    let ends = outline.iter().skip(1).chain(outline.first());
    outline.len() >= 3 && outline.iter().zip(ends).all(|([_, end], [start, _])| end == start)
}
