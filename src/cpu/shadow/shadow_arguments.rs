//! Shadow arguments: the indirect draws of each light's volumes.

use bytemuck::Zeroable as _;

use super::casting::LISTS;
use crate::layout::{DrawArguments, ShadowDraws, ShadowShape, ShadowStatistics};
use crate::shadow::COUNT_ZP_PLUS_2005;

/// The draws of each light, and of the statistics what this stage counts. `sides` has the numbers of a light's plain and
/// clipped sides. `caps` has the numbers of its cap faces of each kind.
pub fn shadow_arguments(
    shape: &ShadowShape,
    sides: &[[u32; 2]],
    caps: &[[u32; LISTS]],
) -> (Vec<ShadowDraws>, ShadowStatistics) {
    let mut statistics = ShadowStatistics::zeroed();
    let draws = sides.iter().zip(caps).map(|(&sides, &[near_front, near_back, far_front, far_back])| {
        let (near, far) = ([near_front, near_back], [far_front, far_back]);
        let overflows = |lists: [u32; 2], capacity: u32| lists[0] + lists[1] > capacity;
        statistics.overflowed_sides += u32::from(overflows(sides, shape.side_capacity));
        let caps_overflow = overflows(near, shape.near_capacity) || overflows(far, shape.far_capacity);
        statistics.overflowed_caps += u32::from(caps_overflow);
        statistics.capped += u32::from(near != [0, 0]);
        // The draw of a list that overflowed goes over everything.
        let instances = |lists: [u32; 2], capacity: u32, all: u32| {
            lists.map(|count| if overflows(lists, capacity) && count > 0 { all } else { count })
        };
        let [plain, clipped] = instances(sides, shape.side_capacity, 2 * shape.edges);
        let [near_front, near_back] = instances(near, shape.near_capacity, shape.faces);
        let [far_front, far_back] = instances(far, shape.far_capacity, shape.faces);
        let (side_vertices, quads, cap_vertices) =
            if shape.counting == COUNT_ZP_PLUS_2005 { (4, 3, 3) } else { (5, 1, 5) };
        ShadowDraws {
            plain: arguments(4, plain),
            clipped: arguments(side_vertices, quads * clipped),
            near_front: arguments(cap_vertices, near_front),
            near_back: arguments(cap_vertices, near_back),
            far_front: arguments(3, far_front),
            far_back: arguments(3, far_back),
            light_front: arguments(4, if shape.proxies == 0 { 0 } else { far_front }),
            light_back: arguments(4, if shape.proxies == 0 { 0 } else { far_back }),
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
