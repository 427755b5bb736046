//! Needs: finds the figures of a scene that a frame needs, from the boxes that the caller states, before they are deformed.

use glam::Vec3;

use crate::cpu::common::cone::may_be_in_cone;
use crate::cpu::shadow::seen::{Bounds, box_is_unseen, is_unseen, out_of_range};
use crate::layout::{NeedsDispatch, SeenLight};

/// For each figure 0 if it is needed, else 1. `seen` has the lights of each view, and `figures` what
/// `wgsl/scene/needs.wgsl` reads of each figure.
pub fn needs(frame: &NeedsDispatch, seen: &[SeenLight], figures: &[[u32; 4]]) -> Vec<u32> {
    let figures = figures.chunks(frame.parts.max(1) as usize).take(frame.figures as usize);
    figures.map(|figure| u32::from(!is_needed(frame, seen, figure))).collect()
}

fn is_needed(frame: &NeedsDispatch, seen: &[SeenLight], figure: &[[u32; 4]]) -> bool {
    let [[low_x, low_y, low_z, has_box], [high_x, high_y, high_z, _], lights @ ..] = figure else { return true };
    if frame.all != 0 || *has_box == 0 {
        return true;
    }
    let [low, high] = [[low_x, low_y, low_z], [high_x, high_y, high_z]]
        .map(|corner| Vec3::from(corner.map(|&word| f32::from_bits(word))));
    let own = Bounds { low, high };
    let has_light = |number: usize| lights[number / 128][number / 32 % 4] >> (number % 32) & 1 != 0;
    let views = seen.chunks(frame.lights.max(1) as usize).take(frame.views as usize);
    let may_matter = |lights: &[SeenLight]| {
        let may_shade = |(_, SeenLight { view, light, cone, .. }): (usize, &SeenLight)| {
            let is_in_cone = || may_be_in_cone(cone, low.to_array(), high.to_array(), 0.0);
            let is_reached = frame.skip_unreached == 0 || (!out_of_range(light, own) && is_in_cone());
            is_reached && (frame.skip_unseen == 0 || !is_unseen(view, light, own))
        };
        let is_seen = lights.first().is_some_and(|first| !box_is_unseen(&first.view, own));
        is_seen || lights.iter().enumerate().filter(|(number, _)| has_light(*number)).any(may_shade)
    };
    views.into_iter().any(may_matter)
}
