//! Reach: finds the lights that matter to each caster, for each batch, and those of them whose bits are to be computed.

use super::occluded::{SLACK as SLACK_BEHIND, occluded};
use super::table::SceneTable;
use crate::cpu::common::cone::may_be_in_cone;
use crate::layout::{CasterLights, SceneCaster, SceneDispatch};

/// Rigid, or with a box that the caller states.
const BOXED: u32 = 4 | 256;
/// Positions may have changed, or the masks of excluded faces are copied anew.
const NOT_KEPT: u32 = 32 | 64;
/// Above this size squares may overflow, and nothing is said.
const TOO_LARGE: f32 = f32::from_bits((127 + 60) << 23);
/// 32 units in the last place. Rounding, division and root add fewer to a distance, relative to the largest coordinate.
const SLACK: f32 = f32::from_bits((127 - 18) << 23);
/// A scaled w below this is no divisor.
const TINY_W: f32 = f32::from_bits((127 - 30) << 23);

/// For each batch and caster the bits of the lights that matter. `unneeded` has a word for each figure, 1 if the frame does not
/// need it; with no words all are needed. A GPU may decide pairs at the very end of a range
/// differently, because WGSL leaves it some freedom in rounding; neither leaves out a light that reaches the caster.
pub fn reach(table: SceneTable<'_>, group: &SceneDispatch, unneeded: &[u32]) -> Vec<u32> {
    let is_unneeded = |caster: u32| {
        let SceneCaster { flags, clusters_or_figure, .. } = table.caster(caster);
        let number = if flags & 4 == 0 { clusters_or_figure.checked_sub(1) } else { None };
        number.and_then(|number| unneeded.get(number as usize)).is_some_and(|word| *word != 0)
    };
    let of_pair = |(caster, batch)| {
        let reaching = if is_unneeded(caster) { 0 } else { lights_that_matter(table, group, caster, batch) };
        reaching & !occluded(table, group, caster, batch, reaching, SLACK_BEHIND)
    };
    let pairs = (0..group.batches).flat_map(|batch| (0..group.casters).map(move |caster| (caster, batch)));
    pairs.map(of_pair).collect()
}

/// The active pairs of caster and light, and the versions that the next encode compares.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct Taken {
    /// For each batch and caster the bits of the lights whose bits are computed.
    pub taken: Vec<u32>,
    /// The inputs of the bits: the number of the layout, three zeros, then for each batch the versions of 32 lights. Last
    /// come, for each batch and caster, the caster's version and the lights that culling leaves.
    pub kept: Vec<u32>,
    /// For each group of casters and batch the lights whose lists are made anew.
    pub anew: Vec<u32>,
    /// For each group and batch the lights of which bits are kept.
    pub keeps: Vec<u32>,
}

/// Selects the pairs to compute among those that [`reach`] returns. `kept` is [`Taken::kept`] of the encode before, and empty
/// before the first.
pub fn take(table: SceneTable<'_>, group: &SceneDispatch, lit: &[u32], kept: &[u32]) -> Taken {
    let SceneDispatch { casters, batches, structure, ranges_at, keeps, .. } = *group;
    let word = |at: u32| kept.get(at as usize).copied().unwrap_or(0);
    let versions: Vec<u32> = (0..32 * batches).map(|bit| table.word(ranges_at + 8 * batches, bit)).collect();
    let is_same = keeps != 0 && word(0) == structure;
    let same_lights = |batch: u32| {
        let same = |bit: &u32| word(4 + 32 * batch + bit) == versions[(32 * batch + bit) as usize];
        (0..32).filter(same).fold(0_u32, |bits, bit| bits | 1 << bit)
    };
    let mut found = Taken { kept: vec![structure, 0, 0, 0], ..Taken::default() };
    found.kept.extend(&versions);
    for batch in 0..batches {
        let same_lights = same_lights(batch);
        for index in 0..casters {
            let caster = table.caster(index);
            let pair = batch * casters + index;
            let matter = lit.get(pair as usize).copied().unwrap_or(0);
            let at = 4 + 32 * batches + 2 * pair;
            let before = if is_same { word(at + 1) } else { 0 };
            let is_kept = word(at) == caster.version && caster.flags & NOT_KEPT == 0;
            let keeps = if is_kept { matter & before & same_lights } else { 0 };
            let part = (caster.group * batches + batch) as usize;
            for words in [&mut found.anew, &mut found.keeps] {
                words.resize(words.len().max(part + 1), 0);
            }
            found.anew[part] |= if is_same { matter & !keeps | before & !matter } else { u32::MAX };
            found.keeps[part] |= keeps;
            found.taken.push(matter & !keeps);
            found.kept.extend([caster.version, matter]);
        }
    }
    found
}

fn lights_that_matter(table: SceneTable<'_>, group: &SceneDispatch, caster: u32, batch: u32) -> u32 {
    let CasterLights { allowed, first, .. } = table.lights(group, caster, batch);
    let caster = table.caster(caster);
    if caster.flags & BOXED == 0 {
        return allowed;
    }
    let (placed_low, placed_high, terms) = placed_box(&caster);
    let lights = (0..32).filter(|light| allowed >> light & 1 != 0).zip((first..).step_by(2));
    lights.fold(0, |matter, (light, at)| {
        let range = f32::from_bits(table.word(group.ranges_at + 8 * batch, light));
        let cone = table.cone(group, 32 * batch + light);
        let is_reached = may_reach(table.part(at + 1).map(f32::from_bits), range, &caster)
            && may_be_in_cone(&cone, placed_low, placed_high, terms);
        matter | u32::from(is_reached) << light
    })
}

/// The box of a caster in world space, and a bound on the terms of its ends.
fn placed_box(caster: &SceneCaster) -> ([f32; 3], [f32; 3], f32) {
    let SceneCaster { low, high, .. } = *caster;
    let (mut placed_low, mut placed_high, mut terms) = ([0.0; 3], [0.0; 3], 0.0_f32);
    for (axis, row) in [caster.row_0, caster.row_1, caster.row_2].into_iter().enumerate() {
        let products = [0, 1, 2].map(|c| [row[c] * low[c], row[c] * high[c]]);
        let [begin, end] = [f32::min, f32::max].map(|pick: fn(f32, f32) -> f32| products.map(|[a, b]| pick(a, b)));
        let sizes = [0, 1, 2].map(|c| begin[c].abs().max(end[c].abs()));
        placed_low[axis] = begin[0] + begin[1] + begin[2] + row[3];
        placed_high[axis] = end[0] + end[1] + end[2] + row[3];
        terms = terms.max(sizes[0] + sizes[1] + sizes[2] + row[3].abs());
    }
    (placed_low, placed_high, terms)
}

/// Whether the light may reach the box of the caster. It is never false for a light that does.
fn may_reach([x, y, z, w]: [f32; 4], range: f32, caster: &SceneCaster) -> bool {
    let SceneCaster { low, high, scale, .. } = *caster;
    if range == 0.0 || w.abs() < TINY_W || low[0] > high[0] {
        return true;
    }
    let point = [x / w, y / w, z / w];
    let size = point.iter().chain(&low).chain(&high).fold(0.0_f32, |size, c| size.max(c.abs()));
    if size >= TOO_LARGE {
        return true;
    }
    let apart: [f32; 3] = std::array::from_fn(|axis| point[axis] - point[axis].clamp(low[axis], high[axis]));
    let distance = (apart[0] * apart[0] + apart[1] * apart[1] + apart[2] * apart[2]).sqrt();
    let is_beyond = scale * (distance - SLACK * size) > range * (1.0 + SLACK);
    !is_beyond
}
