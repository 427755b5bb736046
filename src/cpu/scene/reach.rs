//! Reach: finds the lights that matter to each caster, for each batch.

use super::table::SceneTable;
use crate::layout::{CasterLights, SceneCaster, SceneDispatch};

const RIGID: u32 = 4;
/// Above this size squares may overflow, and nothing is said.
const TOO_LARGE: f32 = f32::from_bits((127 + 60) << 23);
/// 32 units in the last place. Rounding, division and root add fewer to a distance, relative to the largest coordinate.
const SLACK: f32 = f32::from_bits((127 - 18) << 23);
/// A scaled w below this is no divisor.
const TINY_W: f32 = f32::from_bits((127 - 30) << 23);

/// For each batch and caster the bits of the lights that matter. A GPU may decide pairs at the very end of a range
/// differently, because WGSL leaves it some freedom in rounding; neither leaves out a light that reaches the caster.
pub fn reach(table: SceneTable<'_>, group: &SceneDispatch) -> Vec<u32> {
    let pairs = (0..group.batches).flat_map(|batch| (0..group.casters).map(move |caster| (caster, batch)));
    pairs.map(|(caster, batch)| lights_that_matter(table, group, caster, batch)).collect()
}

fn lights_that_matter(table: SceneTable<'_>, group: &SceneDispatch, caster: u32, batch: u32) -> u32 {
    let CasterLights { allowed, first, .. } = table.lights(group, caster, batch);
    let caster = table.caster(caster);
    if caster.flags & RIGID == 0 {
        return allowed;
    }
    let lights = (0..32).filter(|light| allowed >> light & 1 != 0).zip((first..).step_by(2));
    lights.fold(0, |matter, (light, at)| {
        let range = f32::from_bits(table.word(group.ranges_at + 8 * batch, light));
        matter | u32::from(may_reach(table.part(at + 1).map(f32::from_bits), range, &caster)) << light
    })
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
