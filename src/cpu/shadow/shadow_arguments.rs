//! Shadow arguments: the indirect draws of each light's volume.

use bytemuck::Zeroable as _;

use super::casting::LISTS;
use crate::layout::{DrawArguments, ShadowDraws, ShadowLight, ShadowShape, ShadowStatistics};
use crate::shadow::{CAST_EVERY, CAST_NOTHING, COUNT_Z_PASS, COUNT_ZP_PLUS, COUNT_ZP_PLUS_2005};

/// The draws of each light, and the statistics. `side_counts` has the numbers of a light's sides of weight 1 and 2.
/// `cap_counts` has the numbers of its cap faces of both classes.
pub fn shadow_arguments(
    shape: &ShadowShape,
    side_counts: &[[u32; 2]],
    cap_counts: &[[u32; LISTS]],
    lights: &[ShadowLight],
) -> (Vec<ShadowDraws>, ShadowStatistics) {
    let mut statistics = ShadowStatistics::zeroed();
    let draws = lights.iter().zip(side_counts).zip(cap_counts).map(|((light, &[singles, doubles]), &counts)| {
        let is_skipped = light.casting == CAST_NOTHING;
        let has_overflowed = singles + doubles > shape.side_capacity;
        // A side of weight 2 is drawn twice. If the list overflowed, every edge is.
        let sides = match (is_skipped, has_overflowed) {
            (true, _) => 0,
            (false, true) => 2 * shape.edges,
            (false, false) => singles + 2 * doubles,
        };
        let [front, back] = if is_skipped { [0; LISTS] } else { counts };
        let has_caps = front + back > 0;
        let is_clipped = light.counting == COUNT_ZP_PLUS && has_caps;
        statistics.skipped += u32::from(is_skipped);
        statistics.every_face += u32::from(light.casting == CAST_EVERY);
        statistics.ended += u32::from(!is_skipped && light.end > 0.0);
        statistics.capped += u32::from(is_clipped || (light.counting == COUNT_ZP_PLUS_2005 && has_caps));
        statistics.overflowed_caps += u32::from(front.max(back) > shape.cap_capacity);
        statistics.overflowed_sides += u32::from(!is_skipped && has_overflowed);
        let cap = |vertices: u32, count: u32| {
            arguments(vertices, if count > shape.cap_capacity { shape.faces } else { count })
        };
        let none = ShadowDraws::zeroed();
        match (shape.counting, light.counting) {
            (COUNT_ZP_PLUS_2005, COUNT_ZP_PLUS_2005) => {
                ShadowDraws { clipped: arguments(4, 3 * sides), front: cap(3, front), back: cap(3, back), ..none }
            }
            (COUNT_ZP_PLUS_2005, _) => {
                ShadowDraws { switched: arguments(4, sides), far_front: cap(3, front), far_back: cap(3, back), ..none }
            }
            (_, COUNT_Z_PASS) => {
                ShadowDraws { plain: arguments(4, sides), far_front: cap(3, front), far_back: cap(3, back), ..none }
            }
            (_, counting) => {
                let vertices = if counting == COUNT_ZP_PLUS { 5 } else { 3 };
                ShadowDraws {
                    plain: arguments(4, if is_clipped { 0 } else { sides }),
                    clipped: arguments(5, if is_clipped { sides } else { 0 }),
                    front: cap(vertices, front),
                    back: cap(vertices, back),
                    ..none
                }
            }
        }
    });
    let draws = draws.collect();
    (draws, statistics)
}

/// A draw. It is all zeros if it has no instances.
fn arguments(vertices: u32, instances: u32) -> DrawArguments {
    let vertex_count = if instances == 0 { 0 } else { vertices };
    DrawArguments { vertex_count, instance_count: instances, first_vertex: 0, first_instance: 0 }
}
