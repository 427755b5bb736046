//! Arguments: the indirect draw of each light's list.

use crate::layout::{DrawArguments, DrawShape};

/// The draw of each light, from its count of silhouette edges, and the number of lists that overflowed.
pub fn arguments(shape: DrawShape, counts: &[u32]) -> (Vec<DrawArguments>, u32) {
    let draws = counts.iter().map(|&count| DrawArguments {
        vertex_count: shape.vertices_per_edge,
        instance_count: if count > shape.capacity { shape.edges } else { count },
        first_vertex: 0,
        first_instance: 0,
    });
    let overflowed = counts.iter().filter(|&&count| count > shape.capacity).count() as u32;
    (draws.collect(), overflowed)
}
