//! Bytes that a model counts against the limit of memory. The count is the peak of the memory in use at one time.

/// Bytes for a vertex and for a face of triangles while the mesh is made of the model. A vertex has its position, its
/// source vertex, and a number in each of several lists. A face has two copies, the mates of its half-edges, and three
/// edge records. The library counts the same for a glTF.
pub(crate) const VERTEX: u64 = 12 + 4 + 8;
pub(crate) const FACE: u64 = 2 * 12 + 12 + 3 * 16;
/// The same while vertices are welded, which is the most where there are many for each face: both copies, the groups of
/// vertices and their new numbers.
const WELDED_VERTEX: u64 = 2 * (12 + 4) + 20;
const WELDED_FACE: u64 = 2 * 12;
/// Bytes for a polygon, for a loop, and for a corner: two copies of the mesh with an edge of the outline, half an edge
/// record and half a triangle for each corner, as quadrilaterals have them, and a third of the triangles.
pub(crate) const POLYGON: u64 = 40;
pub(crate) const LOOP: u64 = 12;
pub(crate) const CORNER: u64 = 64;

/// Bytes for a model of triangles, with the mesh that is made of it.
pub(crate) fn model(vertices: u64, faces: u64) -> u64 {
    let bytes = |vertex: u64, face: u64| vertices.saturating_mul(vertex).saturating_add(faces.saturating_mul(face));
    bytes(VERTEX, FACE).max(bytes(WELDED_VERTEX, WELDED_FACE))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_most_of_both_times_counts() {
        // A closed mesh, and one whose faces share no vertex.
        assert_eq!(model(500, 1000), 500 * VERTEX + 1000 * FACE);
        assert_eq!(model(3000, 1000), 3000 * WELDED_VERTEX + 1000 * WELDED_FACE);
    }
}
