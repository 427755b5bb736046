//! Shadow arguments: the indirect draws of each light's volume.

use bytemuck::Zeroable as _;

use super::casting::{LISTS, list_capacities};
use crate::layout::{DrawArguments, ShadowDraws, ShadowLight, ShadowShape, ShadowStatistics};
use crate::shadow::{CAST_EVERY, CAST_NOTHING, COUNT_Z_PASS, COUNT_ZP_PLUS, COUNT_ZP_PLUS_2005};

/// The draws of each light, and the statistics. `cap_counts` has the counts of a light's three lists: cap faces of both
/// classes, and excluded faces.
pub fn shadow_arguments(
    shape: &ShadowShape,
    silhouette_counts: &[u32],
    cap_counts: &[[u32; LISTS]],
    lights: &[ShadowLight],
) -> (Vec<ShadowDraws>, ShadowStatistics) {
    let mut statistics = ShadowStatistics::zeroed();
    let draws = lights.iter().zip(silhouette_counts).zip(cap_counts).map(|((light, &silhouettes), &counts)| {
        let is_skipped = light.casting == CAST_NOTHING;
        let is_doubled = light.casting == CAST_EVERY;
        let sides = if silhouettes > shape.capacity { shape.edges } else { silhouettes };
        // A side of weight 2 is drawn twice.
        let sides = if is_skipped { 0 } else { sides * (1 + u32::from(is_doubled)) };
        let [front, back, excluded] = if is_skipped { [0; LISTS] } else { counts };
        let [.., excluded_capacity] = list_capacities(shape.cap_capacity);
        let has_overflowed = front.max(back) > shape.cap_capacity || excluded > excluded_capacity;
        let has_caps = front + back > 0;
        let is_clipped = light.counting == COUNT_ZP_PLUS && has_caps;
        statistics.skipped += u32::from(is_skipped);
        statistics.every_face += u32::from(is_doubled);
        statistics.ended += u32::from(!is_skipped && light.end > 0.0);
        statistics.capped += u32::from(is_clipped || (light.counting == COUNT_ZP_PLUS_2005 && has_caps));
        statistics.overflowed_caps += u32::from(has_overflowed);
        let cap = |vertices: u32, count: u32| {
            arguments(vertices, if count > shape.cap_capacity { shape.faces } else { count })
        };
        // Sides of holes and of excluded faces count only where every face casts, as it does then. A face has three edges.
        let hole_faces = if light.holed != 0 || excluded > excluded_capacity { shape.faces } else { excluded };
        let holes = if is_doubled { 3 * hole_faces } else { 0 };
        let [plain_holes, clipped_holes] = if is_clipped { [0, holes] } else { [holes, 0] };
        let none = ShadowDraws {
            holes: arguments(5, plain_holes),
            clipped_holes: arguments(6, clipped_holes),
            ..ShadowDraws::zeroed()
        };
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
